//! What the docs say of the models on the key poses that ship: `docs/RETARGET.md`, "Models".

use formats::bvh::ImportOptions;
use retarget::{Options, PipelineStage};
use studies::retarget::compare::compare;
use studies::retarget::study::study;
use takes::retargeting::{Performance, Session};

const CHARACTERS: [&str; 3] = ["lamp", "penguin", "squirrel"];

fn session(performance: &str, character: &str) -> Session {
    let character = support::scene(&format!("characters/{character}.ron"));
    let performance = support::scene(&format!("performances/{performance}.ron"));
    Session::open(&performance, &character, None, &ImportOptions::default()).unwrap()
}

fn mapped_only() -> Options {
    Options { stop_after: PipelineStage::Map, rate_hz: Some(30.0), ..Options::default() }
}

/// The shared GPLVM predicts key poses left out no worse than GP regression, and better than PCA, nearest
/// neighbours and latent points searched as in the paper; and it gives the key poses back, which GP regression does not.
#[test]
fn slow_the_shared_model_is_as_good_as_regression_and_keeps_the_key_poses() {
    for name in CHARACTERS {
        let rows = compare(&session("happiness", name), &mapped_only()).unwrap();
        let of = |model: &str| rows.iter().find(|r| r.model == model).unwrap();
        let (gplvm, gp) = (of("gplvm"), of("gp"));
        for r in &rows {
            println!(
                "{name}, {}: {:.1} {:.1} {:.1} deg",
                r.model, r.learned_deg, r.left_out_deg, r.performance_left_out_deg
            );
        }
        // Degrees at poses learned, left out, left out by performance; gplvm: lamp 0.1 28.5 29.7, penguin 0.3 21.8 23.6,
        // squirrel 0.6 24.5 26.9; gp: 9.1 28.4 29.5, 11.4 21.8 23.6, 17.0 25.0 27.0.
        assert!(gplvm.left_out_deg < 1.02 * gp.left_out_deg, "{name}");
        assert!(gplvm.performance_left_out_deg < 1.02 * gp.performance_left_out_deg, "{name}");
        assert!(gplvm.learned_deg < 1.0 && gp.learned_deg > 5.0, "{name}");
        for other in ["pca", "nn3", "nn10", "search"] {
            // Shares of the others' errors seen: poses 0.78 to 0.95 (`search` 0.88 to 1.004: as good on the penguin, not
            // better), performances 0.68 to 0.98.
            let most = if other == "search" { 1.02 } else { 0.97 };
            assert!(gplvm.left_out_deg < most * of(other).left_out_deg, "{name}, {other}");
            let by_performance = of(other).performance_left_out_deg;
            assert!(gplvm.performance_left_out_deg < by_performance, "{name}, {other}");
        }
    }
}

/// Five suggested poses lower the error at the poses not known more than five random ones (median over 20 draws); and
/// the criteria for the latent dimension say 30: more reconstruct no better from 15 on, and searched paths go on
/// getting smoother.
#[test]
fn slow_studies_say_what_the_docs_say() {
    for name in CHARACTERS {
        let session = session("happiness", name);
        let done = session.run(&session.learn(&mapped_only()).unwrap(), &mapped_only()).unwrap();
        let study = study(&session, &done.human).unwrap();
        let s = study.suggestions.unwrap();
        println!("{name}: random {:.1}, suggested {:.1} deg", s.random_gain_deg, s.suggested_gain_deg);
        // 3.6 5.8, 2.9 4.4, 2.0 3.8 seen
        assert!(s.suggested_gain_deg > 1.2 * s.random_gain_deg, "{name}: {s:?}");
        let at = |d: usize| study.dimensions.iter().find(|r| r.dimensions == d).unwrap();
        assert!(at(2).learned_deg > 5.0 && at(15).learned_deg < 1.5 && at(30).learned_deg < 1.0, "{name}");
        assert!(at(2).search_jerk_s3 > 5.0 * at(30).search_jerk_s3, "{name}");
        assert_eq!(at(30).search_jumps, 0, "{name}");
        assert!(at(2).jerk_s3 < 1e4 && at(30).jerk_s3 < 1e4, "{name}"); // 2500 to 5600 seen
        let dropped = study.dropped.unwrap();
        assert!(dropped.key_poses >= 6 && dropped.from_full_deg < dropped.extent_deg, "{name}");
    }
}

/// Walks captured from others are within what the key poses cover.
#[test]
fn slow_captured_walks_are_not_extrapolated() {
    for name in CHARACTERS {
        let mut session = session("walk", name);
        let mapping = session.learn(&mapped_only()).unwrap();
        for clip in ["16_21", "02_01"] {
            let path = support::shared(&format!("mocap/bvh/{clip}.bvh"));
            let import = ImportOptions { metres_per_unit: Some(0.0564444), ..ImportOptions::default() };
            session.performance = Performance::open(&path, &import).unwrap();
            let done = session.run(&mapping, &mapped_only()).unwrap();
            let beyond = done.mapping.extrapolates.iter().filter(|&&e| e).count() as f64;
            let share = beyond / done.mapping.extrapolates.len() as f64;
            assert!(share < 0.02, "{name}, {clip}: {share}"); // 0 seen
        }
    }
}

/// No joint turns over between two frames (30 Hz): the squirrel's tail did, by 148° in 1/60 s.
#[test]
fn slow_no_joint_turns_over_within_a_frame() {
    for name in CHARACTERS {
        let session = session("happiness", name);
        let done = session.run(&session.learn(&mapped_only()).unwrap(), &mapped_only()).unwrap();
        let (clip, skeleton) = (&done.stages[0].1, &session.actor.puppet.character.skeleton);
        for f in 1..clip.frames() {
            for link in 1..skeleton.links().len() {
                let turn = skeleton
                    .rotation(clip.pose(f - 1), link)
                    .angle_to(&skeleton.rotation(clip.pose(f), link))
                    .to_degrees();
                assert!(turn < 60.0, "{name}, {}, frame {f}: {turn}°", skeleton.links()[link].name);
            }
        }
    }
}
