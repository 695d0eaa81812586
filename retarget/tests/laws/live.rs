//! The pipeline as a whole, on a clip and frame by frame.

use motion::{Kinematics, Smoothing, Vec3};
use retarget::contacts::phases::own_floors;
use retarget::live::LAND_S;
use retarget::{
    Live, Mapping, MappingModel, Options, Performer, PipelineStage, RetargetError, SizeRatio, run,
};

use crate::bodies::{key_poses, mocap, puppet, raise_left_sole, scaled};

fn options() -> Options {
    let mut o = Options { smoothing: Smoothing::Off, ground_m: Some(0.0), ..Options::default() };
    o.global.size = SizeRatio::Fixed(0.5);
    o
}

/// All stages of a walk learned from every fifth of its frames; any model; stops where it is told to.
#[test]
fn the_pipeline_runs_to_the_stage_it_is_told() {
    let (performer, human) = mocap("16_21");
    let puppet = puppet(scaled(&performer.character, 0.5, 1.0));
    let keys = key_poses(&performer, &human, &puppet, 0.5, 5);
    let stages = [PipelineStage::Map, PipelineStage::Global, PipelineStage::Contact, PipelineStage::Refine];
    for (n, stop_after) in stages.into_iter().enumerate() {
        let o = Options { stop_after, ..options() };
        let r = run(&human, &performer, &puppet, &keys, &o).unwrap();
        assert_eq!(r.stages.iter().map(|s| s.0).collect::<Vec<_>>(), stages[..=n]);
        assert_eq!(r.clip, r.stages[n].1);
        assert_eq!(r.momentum.is_some(), n > 0);
        if let Some(m) = r.momentum {
            assert!(m.relative_rms < 0.01, "{}", m.relative_rms); // 1e-14 seen
        }
        if let Some(f) = r.refinement {
            println!("vertical {} → {}, {:?}", f.before[1], f.after[1], r.contact);
            assert!(f.after[1] < 0.2 * f.before[1]);
        }
    }
    for model in MappingModel::ALL {
        let o = Options { model, stop_after: PipelineStage::Map, ..options() };
        let r = run(&human, &performer, &puppet, &keys, &o).unwrap();
        let fit = r.mapping.fit_rms_m.iter().sum::<f64>() / human.frames() as f64;
        println!("{model:?}: points fit within {:.1} mm, {} jumps", 1e3 * fit, r.mapping.jumps.len());
        assert!(r.clip.data().iter().all(|x| x.is_finite()));
    }
}

/// Same input, same bytes.
#[test]
fn the_pipeline_is_deterministic() {
    let (performer, human) = mocap("16_21");
    let puppet = puppet(scaled(&performer.character, 0.5, 1.0));
    let keys = key_poses(&performer, &human, &puppet, 0.5, 5);
    let once = || run(&human, &performer, &puppet, &keys, &options()).unwrap();
    assert_eq!(once(), once());
}

/// Frame by frame: points that are down stay, the path is the scaled human one, nothing jumps.
#[test]
fn live_points_stay_where_they_land() {
    let (performer, human) = mocap("16_21");
    let puppet = puppet(scaled(&performer.character, 0.5, 1.0));
    let keys = key_poses(&performer, &human, &puppet, 0.5, 5);
    let o = options();
    let mapping = Mapping::learn(&puppet, &keys, o.model, &o.gplvm).unwrap();
    let mut live = Live::new(&mapping, &performer, &puppet, human.rate_hz, &o).unwrap();
    let s = puppet.character.skeleton.clone();
    let mut k = Kinematics::new(&s, &puppet.character.rest);
    let n = puppet.contacts.len();
    let (mut since, mut place) = (vec![0.0; n], vec![Vec3::zeros(); n]);
    let (mut slip, mut deep, mut before, mut step) = (0.0f64, 0.0f64, None, 0.0f64);
    for i in 0..human.frames() {
        let frame = live.step(human.pose(i)).unwrap();
        k.update(&s, frame.pose);
        for c in 0..n {
            let site = &s.sites()[puppet.contacts[c].site];
            let p = k.point(site.link, &site.at);
            deep = deep.max(-p.y);
            since[c] = if frame.down[c] { since[c] + 1.0 / human.rate_hz } else { 0.0 };
            if since[c] <= LAND_S + 2.0 / human.rate_hz {
                place[c] = p;
            } else {
                slip = slip.max((p.x - place[c].x).hypot(p.z - place[c].z));
            }
        }
        let root = k.origin(0);
        step = before.map_or(step, |b: Vec3| step.max((root - b).norm() * human.rate_hz));
        before = Some(root);
    }
    println!("slip {:.2} mm, depth {:.2} mm, root at most {step:.2} m/s", 1e3 * slip, 1e3 * deep);
    assert!(slip <= 1e-3 && deep <= 5e-3 && step < 1.5); // 0.1 mm, 2.5 mm, 0.9 m/s seen
    let faulty = vec![f64::NAN; human.skeleton.nq()];
    assert!(matches!(live.step(&faulty), Err(RetargetError::Learn(_))));
}

/// Soles that were guessed centimetres too high touch as well, once their floors are told.
#[test]
fn live_points_stand_on_their_own_floors() {
    let (mut performer, human) = mocap("16_21");
    let puppet = puppet(scaled(&performer.character, 0.5, 1.0));
    let keys = key_poses(&performer, &human, &puppet, 0.5, 5);
    let o = options();
    let mapping = Mapping::learn(&puppet, &keys, o.model, &o.gplvm).unwrap();
    let down = |performer: &Performer| -> Vec<bool> {
        let live = Live::new(&mapping, performer, &puppet, human.rate_hz, &o).unwrap();
        let mut live = live.on_floors(&own_floors(performer, &human, &o.contact));
        (0..human.frames()).flat_map(|i| live.step(human.pose(i)).unwrap().down.to_vec()).collect()
    };
    let truth = down(&performer);
    raise_left_sole(&mut performer.character, 0.03);
    let found = down(&performer);
    let rests = truth.iter().filter(|x| **x).count() as f64;
    let other = truth.iter().zip(&found).filter(|(a, b)| a != b).count() as f64;
    println!("at rest {:.2} of the time, {:.3} of it differs", rests / truth.len() as f64, other / rests);
    assert!(rests > 0.2 * truth.len() as f64);
    assert!(other < 0.1 * rests, "{other} of {rests}");
}
