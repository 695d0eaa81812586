//! Clips as they come: roots above the pelvis, joints that slide, glitches, ends; what is performed, what is refused, what is said.
//!
//! Inputs: `../shared/cases/clips` and `../shared/mocap`.

use std::path::{Path, PathBuf};

use formats::bvh::{self, ImportOptions, OffsetRule};
use motion::Kinematics;
use support::shared;
use takes::{
    AnalysisInput, AnalysisReport, Ask, Engines, PerformError, Progress, Report, RootMode, Take, analysis,
};

fn case(name: &str) -> PathBuf {
    shared(&format!("cases/clips/{name}.bvh"))
}

fn open(path: &Path, import: ImportOptions) -> Take {
    takes::open(path, &Ask { import, ..Ask::default() }).unwrap_or_else(|e| panic!("{e}"))
}

fn analysed(path: &Path, import: &ImportOptions) -> (AnalysisInput, AnalysisReport) {
    let input = analysis::open(path, None, import).unwrap_or_else(|e| panic!("{e}"));
    let analysis = input.analyze(&Default::default()).unwrap_or_else(|e| panic!("{e}"));
    let report = AnalysisReport::new(&input, &analysis);
    (input, report)
}

fn engines() -> Engines {
    Engines::default()
}

/// A reference above the pelvis: the body starts at the pelvis and is where the clip has it; what is written has all joints of
/// the file, and the body's points where they were.
#[test]
fn a_root_above_the_pelvis_is_folded_and_given_back() {
    let take = open(&case("extra_root"), ImportOptions::default());
    let skeleton = &take.body.character.skeleton;
    assert_eq!(skeleton.links()[0].name, "Hips");
    let source = take.clip_source().unwrap();
    let notes = source.body.as_ref().unwrap().notes.join("\n");
    assert!(notes.contains("the root `Reference` is above the pelvis `Hips`"), "{notes}");
    let files = take.for_files(&take.asked.clip);
    assert_eq!(files.skeleton.links()[0].name, "Reference");
    let mut moved = 0.0f64;
    for frame in 0..files.frames() {
        let body = Kinematics::new(skeleton, take.asked.clip.pose(frame));
        let written = Kinematics::new(&files.skeleton, files.pose(frame));
        let read = Kinematics::new(&source.clip.skeleton, source.clip.pose(frame));
        for (i, link) in skeleton.links().iter().enumerate() {
            let j = files.skeleton.link(&link.name).unwrap();
            let apart =
                (body.origin(i) - written.origin(j)).norm() + (body.origin(i) - read.origin(j)).norm();
            assert!(apart < 1e-9, "{frame} {}: {apart}", link.name); // 1e-15 seen
        }
        moved =
            moved.max((body.origin(0) - Kinematics::new(skeleton, take.asked.clip.pose(0)).origin(0)).norm());
    }
    println!("the pelvis moves by {moved} m");
    let (_, report) = analysed(&case("extra_root"), &ImportOptions::default());
    let mean = report.required.vertical_mean_percent_bw.unwrap();
    assert!((mean - 100.0).abs() < 3.0, "{mean} %");
}

/// Joints that slide: written, but neither performed nor analysed; held, they are both.
#[test]
fn joints_that_slide_are_refused_by_name() {
    let text = std::fs::read_to_string(case("six_jitter_001cm")).unwrap();
    let (head, rows) = text.split_once("Frame Time: 0.033333\n").unwrap();
    // the left hand, 5 cm to and fro along the forearm
    let parsed = bvh::Bvh::parse(text.as_bytes()).unwrap();
    let hand = parsed.joints.iter().find(|j| j.name == "LeftHand").unwrap().channels_at;
    let slid = rows.lines().enumerate().map(|(frame, row)| {
        let mut values: Vec<f64> = row.split_whitespace().map(|x| x.parse().unwrap()).collect();
        values[hand] += 5.0 * (0.4 * frame as f64).sin();
        values.iter().map(|x| format!("{x} ")).collect::<String>() + "\n"
    });
    let slid: String = format!("{head}Frame Time: 0.033333\n{}", slid.collect::<String>());
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("slides.bvh");
    std::fs::write(&path, slid).unwrap();
    let take = open(&path, ImportOptions::default());
    let Err(PerformError::Slides(slides)) = take.clone().perform(&engines(), &Progress::silent()) else {
        panic!("performed");
    };
    let said = slides.to_string();
    assert!(said.contains("`LeftHand` slides by up to 52 mm against `LeftForeArm`"), "{said}");
    assert!(PerformError::Slides(slides).is_input());
    let refused = analysis::open(&path, None, &ImportOptions::default()).unwrap_err().to_string();
    assert!(refused.contains("`LeftHand` slides"), "{refused}");
    // as a motion it is kept: the hand is where the file has it
    let written = take.preview().take;
    let files = written.for_files(&written.asked.clip);
    let hand = files.skeleton.link("LeftHand").unwrap();
    let far = (0..files.frames()).map(|f| files.skeleton.position(files.pose(f), hand).x).fold(0.0, f64::max);
    assert!((far - 0.05).abs() < 0.001, "{far}");
    let hold = ImportOptions { offsets: Some(OffsetRule::Hold), ..Default::default() };
    assert!(open(&path, hold).check_performable().is_ok());
}

/// Trembling offsets are held: the body is performed, and is where it was asked to be.
#[test]
fn trembling_offsets_are_performed() {
    let take = open(&case("six_jitter_001cm"), ImportOptions::default());
    assert_eq!(take.body.character.skeleton.nv(), 54);
    let done = take.perform(&engines(), &Progress::silent()).unwrap();
    let report = Report::of(&done.take, done.outcome(), &[]);
    let apart = report.dynamic.unwrap().position_rms_mm;
    assert!(apart < 10.0, "links {apart} mm off"); // 8162 mm before
}

/// Fifteen frames of standing weigh what the body weighs, and are said to be too short.
#[test]
fn a_short_still_pose_weighs_what_it_weighs() {
    let (_, report) = analysed(&case("still_15_frames"), &ImportOptions::default());
    let percent = report.required.vertical_peak_percent_bw.unwrap();
    assert!((90.0..115.0).contains(&percent), "{percent} %"); // 389 % without smoothing
    assert!(report.ends.too_short);
    assert_eq!(report.smoothing.cutoff_hz, Some(6.0));
}

/// Where a walk is cut, it is not graded; the error of the cut is measured and is what cutting really does.
#[test]
fn the_ends_of_a_cropped_walk_are_left_out() {
    let (input, report) = analysed(&shared("mocap/bvh/16_21.bvh"), &ImportOptions::default());
    let (first, inside) = (report.ends.first_frame_error_n.unwrap(), report.ends.inside_error_n.unwrap());
    println!("cut: {first:.0} N, inside {inside:.0} N");
    assert!(inside < first && first < 300.0, "{first} {inside}");
    assert_eq!(report.ends.left_out_s, 0.05);
    assert!(report.residual.force_peak_at_s >= 0.05 && !report.ends.too_short);
    // the truth at a cut: the same frames out of the whole
    let whole = input.analyze(&Default::default()).unwrap();
    let n = whole.clip.skeleton.nq();
    let (from, to) = (100, 220);
    let data = input.given.data()[from * n..to * n].to_vec();
    let mut cut = input.clone();
    cut.given = motion::Clip::new(input.given.skeleton.clone(), 120.0, data);
    let cut = cut.analyze(&Default::default()).unwrap();
    let off = |k: usize| {
        let at = |a: &takes::Analysis, k: usize| motion::skeleton::vec_at(&a.required_force, 3 * k);
        (at(&cut, k) - at(&whole, from + k)).norm()
    };
    let (first, inside) = (off(0).max(off(119)), off(6).max(off(113)));
    println!("off by {first:.0} N at the cut, {inside:.0} N inside");
    assert!(inside < first);
}

/// A pin that follows a walk takes what `analyze` says the walk needs, not the noise of the capture.
#[test]
fn a_pinned_walk_weighs_as_much_as_it_is_analysed() {
    let path = shared("mocap/bvh/16_21.bvh");
    let take = open(&path, ImportOptions::default());
    assert_eq!(take.conditions.physics.root, RootMode::Pinned);
    let done = take.perform(&engines(), &Progress::silent()).unwrap();
    let root = Report::of(&done.take, done.outcome(), &[]).dynamic.unwrap().root;
    let (_, analysed) = analysed(&path, &ImportOptions::default());
    let (pinned, free) =
        (root.residual_force_peak_percent_bw.unwrap(), analysed.required.vertical_peak_percent_bw.unwrap());
    assert!(root.smoothed_at_hz.is_some());
    assert!((pinned / free - 1.0).abs() < 0.15, "{pinned} % pinned, {free} % analysed"); // 573 % before
}

/// Hip flips are named with joint and frames, and repaired they no longer weigh tons.
#[test]
fn flips_are_named_and_repaired() {
    let path = shared("mocap/bvh/05_06.bvh");
    let (_, flipped) = analysed(&path, &ImportOptions::default());
    let (input, mended) = analysed(&path, &ImportOptions { repair: true, ..Default::default() });
    let takes::AnalysisSource::Clip(source) = &input.source else { panic!("a clip") };
    let text = source.import.as_ref().unwrap().to_string();
    println!("{text}\n{} N, then {} N", flipped.required.vertical_peak_n, mended.required.vertical_peak_n);
    assert!(text.contains("`RightUpLeg` turns with") && text.contains("interpolated"), "{text}");
    assert!(mended.required.vertical_peak_n < 0.5 * flipped.required.vertical_peak_n);
    // a clean walk has none
    let (input, _) = analysed(&shared("mocap/bvh/16_21.bvh"), &ImportOptions::default());
    let takes::AnalysisSource::Clip(source) = &input.source else { panic!("a clip") };
    assert!(source.import.as_ref().unwrap().glitches.all.is_empty());
}
