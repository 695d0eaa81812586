//! Laws of edits by example, on a small body.

use std::sync::Arc;

use edits::by_example::{Axes, ByExample, ExampleEdit, ExampleOptions, Outputs, Pair, Rig, outputs, poses};
use edits::{ClipEdit, EditLog, Motion, Where};
use motion::rotation::{Quat, Vec3, exp, log};
use motion::symmetry::Symmetry;
use motion::{Clip, Joint, Link, Skeleton};

/// A trunk with two arms, each of an upper and a lower part.
fn body(left: &str) -> Arc<Skeleton> {
    let link = |name: &str, parent, at: [f64; 3], joint| Link::new(name, parent, Vec3::from(at), joint);
    let mut links = vec![
        link("pelvis", None, [0.0, 0.0, 0.0], Joint::Free),
        link("chest", Some(0), [0.0, 0.4, 0.0], Joint::Spherical),
        link(left, Some(1), [0.2, 0.1, 0.0], Joint::Spherical),
        link("fore_l", Some(2), [0.3, 0.0, 0.0], Joint::Spherical),
        link("arm_r", Some(1), [-0.2, 0.1, 0.0], Joint::Spherical),
        link("fore_r", Some(4), [-0.3, 0.0, 0.0], Joint::Spherical),
    ];
    links[3].end = Some(Vec3::new(0.25, 0.0, 0.0));
    links[5].end = Some(Vec3::new(-0.25, 0.0, 0.0));
    Arc::new(Skeleton::new(links).unwrap())
}

/// It walks a curve and swings its arms; `seed` moves phase and pace.
fn walk(rate_hz: f64, seconds: f64, seed: f64) -> Clip {
    let s = body("arm_l");
    let mut q = Vec::new();
    for f in 0..=(seconds * rate_hz).round() as usize {
        let t = f as f64 / rate_hz + seed;
        let mut pose = s.zero_pose();
        let turn = 0.3 * (0.4 * t).sin();
        s.set_position(
            &mut pose,
            0,
            &Vec3::new(0.3 * (0.4 * t).cos(), 1.0 + 0.02 * (8.0 * t).sin(), 1.1 * t),
        );
        s.set_rotation(&mut pose, 0, &exp(&Vec3::new(0.05 * (4.0 * t).sin(), turn, 0.0)));
        for (link, sign) in [(2, 1.0), (4, -1.0)] {
            let swing = (4.0 * t + 0.3 * seed).sin();
            s.set_rotation(&mut pose, link, &exp(&Vec3::new(0.1, 0.5 * swing, -sign)));
            s.set_rotation(
                &mut pose,
                link + 1,
                &exp(&Vec3::new(0.0, -sign * (0.4 + 0.3 * sign * swing), 0.0)),
            );
        }
        q.extend(pose);
    }
    Clip::new(s, rate_hz, q)
}

/// The left arm goes up by half the bend of its elbow, the chest leans by 0.2 rad, the walk is a tenth longer.
fn edited(clip: &Clip) -> Clip {
    let s = clip.skeleton.clone();
    let mut out = clip.clone();
    for f in 0..clip.frames() {
        let from = clip.pose(f).to_vec();
        let to = out.pose_mut(f);
        let mut turn = |link: usize, by: Vec3| {
            let r = s.rotation(&from, link) * exp(&by);
            s.set_rotation(to, link, &r);
        };
        turn(2, Vec3::z() * (0.5 * log(&s.rotation(&from, 3)).norm()));
        turn(1, Vec3::x() * 0.2);
        let p = s.position(&from, 0);
        s.set_position(to, 0, &Vec3::new(p.x, p.y, 1.1 * p.z));
    }
    out
}

fn pair(clip: &Clip) -> Pair {
    Pair::new("walk", clip.clone(), edited(clip))
}

fn learned(options: &ExampleOptions) -> Arc<ExampleEdit> {
    Arc::new(ExampleEdit::learn(&[pair(&walk(60.0, 3.0, 0.0))], options).unwrap())
}

/// Examples as the rule has them: the left arm only.
fn one_sided() -> ExampleOptions {
    ExampleOptions { mirror: false, ..ExampleOptions::default() }
}

fn applied(edit: &ByExample, clip: &Clip, at: &Where) -> Clip {
    let motion = Motion::of(clip.clone());
    let place = at.in_clip(&motion).unwrap();
    edit.run(&motion, &place).unwrap().untimed
}

/// Largest angle between joints, rad, and distance of roots, m.
fn apart(a: &Clip, b: &Clip) -> (f64, f64) {
    let s = &a.skeleton;
    let (mut turn, mut way) = (0.0_f64, 0.0_f64);
    for f in 0..a.frames().min(b.frames()) {
        for link in 0..s.links().len() {
            let r: Quat = s.rotation(a.pose(f), link).inverse() * s.rotation(b.pose(f), link);
            turn = turn.max(log(&r).norm());
        }
        way = way.max((s.position(a.pose(f), 0) - s.position(b.pose(f), 0)).norm());
    }
    (turn, way)
}

/// Nothing of an edit is nothing, to the bit, times included.
#[test]
fn amount_zero_is_the_source() {
    let clip = walk(60.0, 2.0, 0.7);
    let motion = Motion::of(clip.clone());
    let edit = ByExample { amount: 0.0, ..ByExample::new(learned(&one_sided())) };
    let (result, _) = super::clip_body::edited(&edit, &motion, &Where::default());
    assert_eq!(result.clip, clip);
    let whole = applied(&ByExample { amount: 1.0, ..edit.clone() }, &clip, &Where::default());
    assert!(apart(&whole, &clip).0 > 0.15);
    let words = super::clip_body::refused(&ByExample { amount: 2.0, ..edit }, &motion, &Where::default());
    assert!(words.contains("`amount` is 2; allowed: 0 to 1.5"), "{words}");
}

/// What is learned is the edit.
#[test]
fn the_edit_is_learned() {
    let clip = walk(60.0, 2.5, 0.5);
    let (turn, way) =
        apart(&applied(&ByExample::new(learned(&one_sided())), &clip, &Where::default()), &edited(&clip));
    assert!(turn < 0.02, "{turn} rad");
    assert!(way < 0.1, "{way} m");
}

/// Body parts limit it to their joints; everything else is the source, to the bit.
#[test]
fn parts_limit_it() {
    let clip = walk(60.0, 2.0, 0.7);
    let edit = ByExample::new(learned(&one_sided()));
    let arm = applied(&edit, &clip, &Where::default().of(["arm_l"]));
    let whole = applied(&edit, &clip, &Where::default());
    let s = &clip.skeleton;
    for f in 0..clip.frames() {
        assert_eq!(s.rotation(arm.pose(f), 2), s.rotation(whole.pose(f), 2));
        let mut back = arm.pose(f).to_vec();
        s.set_rotation(&mut back, 2, &s.rotation(clip.pose(f), 2));
        let moved: Vec<usize> = (0..s.nq()).filter(|&i| arm.pose(f)[i] != clip.pose(f)[i]).collect();
        assert!(moved.iter().all(|i| (s.q_at(2)..s.q_at(3)).contains(i)), "{moved:?}");
    }
}

/// Outside its span nothing changes, to the bit; inside it is whole beyond the blend, and comes without a jump.
#[test]
fn a_span_comes_and_goes() {
    let clip = walk(60.0, 3.0, 0.2);
    let edit = ByExample::new(learned(&one_sided()));
    let joints = ["chest", "arm_l"];
    let (part, whole) = (
        applied(&edit, &clip, &Where::span(1.0, 2.0).of(joints)),
        applied(&edit, &clip, &Where::default().of(joints)),
    );
    let s = &clip.skeleton;
    let lean =
        |c: &Clip, f: usize| log(&(s.rotation(clip.pose(f), 1).inverse() * s.rotation(c.pose(f), 1))).norm();
    for f in 0..clip.frames() {
        let t = f as f64 / 60.0;
        if !(1.0..=2.0).contains(&t) {
            assert_eq!(part.pose(f), clip.pose(f), "{t} s");
        } else if (1.25..=1.75).contains(&t) {
            assert_eq!(part.pose(f), whole.pose(f), "{t} s");
        }
        if f > 0 {
            // 0.2 rad in 0.25 s, at most 1.5 times the mean speed
            assert!((lean(&part, f) - lean(&part, f - 1)).abs() < 1.6 * 0.2 / 15.0, "{t} s");
        }
    }
}

/// Taught both sides alike, the edit of the mirrored clip is the mirrored edit.
#[test]
fn mirrored_clips_are_edited_alike() {
    let edit = ByExample::new(learned(&ExampleOptions::default()));
    let clip = walk(60.0, 2.0, 0.9);
    let symmetry = Symmetry::of(&clip.skeleton).unwrap();
    let one = applied(&edit, &symmetry.mirrored(&clip), &Where::default());
    let other = symmetry.mirrored(&applied(&edit, &clip, &Where::default()));
    let (turn, way) = apart(&one, &other);
    assert!(turn < 1e-9 && way < 1e-9, "{turn} rad, {way} m");
    // a model that was taught one side only is not alike
    let edit = ByExample::new(learned(&one_sided()));
    let one = applied(&edit, &symmetry.mirrored(&clip), &Where::default());
    let other = symmetry.mirrored(&applied(&edit, &clip, &Where::default()));
    assert!(apart(&one, &other).0 > 0.1);
}

/// The same motion at 60 Hz and at 120 Hz is edited alike: joints within 0.2°, the way within 5 mm in 2.5 s.
#[test]
fn the_frame_rate_does_not_matter() {
    let edit = ByExample::new(learned(&one_sided()));
    let (slow, fast) = (walk(60.0, 2.5, 0.4), walk(120.0, 2.5, 0.4));
    let (a, b) = (applied(&edit, &slow, &Where::default()), applied(&edit, &fast, &Where::default()));
    let every_other: Vec<f64> = (0..b.frames()).step_by(2).flat_map(|f| b.pose(f).to_vec()).collect();
    let (turn, way) = apart(&a, &Clip::new(a.skeleton.clone(), 60.0, every_other));
    assert!(turn < 0.2_f64.to_radians() && way < 0.005, "{turn} rad, {way} m");
}

/// Differences go through a half turn without a jump, and give the target back.
#[test]
fn a_half_turn_is_no_jump() {
    let clip = walk(60.0, 2.0, 0.0);
    let s = clip.skeleton.clone();
    let mut target = clip.clone();
    let last = (clip.frames() - 1) as f64;
    let angle = |f: usize| 2.6 + 1.1 * f as f64 / last; // 149° to 212°
    for f in 0..clip.frames() {
        let r = s.rotation(clip.pose(f), 2) * exp(&(Vec3::x() * angle(f)));
        s.set_rotation(target.pose_mut(f), 2, &r);
    }
    let rig = Rig::of(&s).unwrap();
    let d = outputs::differences((&rig, &clip), (&rig, &target), None);
    for f in 1..d.nrows() {
        let step = (d.row(f) - d.row(f - 1)).amax();
        // the axes of the edit turn a little against those of the differences, which are smoothed
        assert!((step - 1.1 / last).abs() < 0.02, "frame {f}: {step}");
    }
    let edit = Arc::new(
        ExampleEdit::learn(&[Pair::new("round", clip.clone(), target.clone())], &one_sided()).unwrap(),
    );
    let (turn, _) = apart(&applied(&ByExample::new(edit), &clip, &Where::default()), &target);
    assert!(turn < 0.05, "{turn} rad");
}

/// The numbers of two clips are as far apart as the clips: two roads to the differences.
#[test]
fn poses_differ_as_their_clips() {
    let (source, times) = (walk(60.0, 2.0, 0.3), (0..121).map(|f| f as f64 / 50.0).collect::<Vec<_>>());
    let target = edited(&source);
    let rig = Rig::of(&source.skeleton).unwrap();
    let (a, b) = (poses::of(&rig, &source, None), poses::of(&rig, &target, Some(&times)));
    let direct = outputs::differences((&rig, &source), (&rig, &target), Some(&times));
    let error = (poses::differences(&rig, &source, &a, &b) - &direct).amax();
    assert!(direct.amax() > 0.1 && error < 1e-12, "{error}"); // 2e-14 seen
    assert!(poses::differences(&rig, &source, &a, &a).amax() < 1e-15); // 1e-16 seen
}

/// Poses are learned as well, with the paper's weights: taught clips come out edited, other motion does not stay as it is where
/// nothing is taught, as it does with differences.
#[test]
fn poses_are_learned_as_printed() {
    let options = |outputs| ExampleOptions { outputs, gate: false, ..one_sided() };
    let taught = walk(60.0, 3.0, 0.0);
    let edit = ByExample::new(learned(&options(Outputs::Poses)));
    let (turn, _) = apart(&applied(&edit, &taught, &Where::default()), &edited(&taught));
    assert!(turn < 0.02, "{turn} rad"); // 0.008 seen
    let other = walk(60.0, 2.0, 3.1);
    let same = |outputs| {
        let pair = Pair::new("same", taught.clone(), taught.clone());
        let edit = ExampleEdit::learn(&[pair], &options(outputs)).unwrap();
        apart(&applied(&ByExample::new(Arc::new(edit)), &other, &Where::default()), &other).0
    };
    let (differences, poses) = (same(Outputs::Differences), same(Outputs::Poses));
    assert!(differences < 1e-12 && poses > 1e-3, "{differences} and {poses} rad");
    // amount and span act on what the pose changes
    let none = ByExample { amount: 0.0, ..edit };
    assert_eq!(applied(&none, &other, &Where::default()), other);
}

/// A clip that stands still, and one of a single frame, teach what they show.
#[test]
fn still_and_single_frames_are_examples() {
    let one = walk(60.0, 0.0, 0.0);
    let still = Clip::new(one.skeleton.clone(), 60.0, (0..60).flat_map(|_| one.pose(0).to_vec()).collect());
    for clip in [one, still] {
        let mut target = clip.clone();
        for f in 0..clip.frames() {
            let s = clip.skeleton.clone();
            let r = s.rotation(clip.pose(f), 1) * exp(&(Vec3::x() * 0.2));
            s.set_rotation(target.pose_mut(f), 1, &r);
        }
        let edit =
            ExampleEdit::learn(&[Pair::new("still", clip.clone(), target.clone())], &one_sided()).unwrap();
        let done = applied(&ByExample::new(Arc::new(edit)), &clip, &Where::default());
        let (turn, way) = apart(&done, &target);
        assert!(turn < 0.02 && way < 1e-6, "{} frames: {turn} rad, {way} m", clip.frames());
    }
}

#[track_caller]
fn has(found: String, expected: &str) {
    assert!(found.contains(expected), "{found}");
}

/// Bad examples are refused in words.
#[test]
fn bad_examples_are_named() {
    let clip = walk(60.0, 1.0, 0.0);
    let good = pair(&clip);
    let words = |pairs: &[Pair]| match ExampleEdit::learn(pairs, &ExampleOptions::default()) {
        Ok(_) => String::from("learned"),
        Err(e) => e.to_string(),
    };
    has(words(&[]), "there is no pair to learn from");
    let longer = Pair { target: walk(60.0, 1.5, 0.0), ..good.clone() };
    has(words(&[longer]), "pair `walk`: the source has 61 frames at 60 Hz and the target 91 at 60 Hz");
    let slower = Pair { target: walk(30.0, 2.0, 0.0), ..good.clone() };
    has(words(&[slower]), "the target 61 at 30 Hz");
    let mut broken = good.clone();
    broken.target.pose_mut(7)[3] = f64::NAN;
    has(words(&[broken]), "pair `walk`: frame 7 of the target has a number that is not finite");
    let early = Pair {
        times_s: Some((0..61).map(|f| if f == 9 { 0.0 } else { f as f64 }).collect()),
        ..good.clone()
    };
    has(words(&[early]), "time 9 is 0 s, after 8 s; times must increase");
    has(words(&[Pair { times_s: Some(vec![0.0]), ..good.clone() }]), "1 times for 61 frames");
    has(
        words(&[Pair { spans_s: vec![(2.0, 3.0)], ..good.clone() }]),
        "the span 2 s to 3 s has no frames; the clip lasts 1.000 s",
    );
    let other = body("wing");
    let source = Clip::new(other, 60.0, clip.data().to_vec());
    let stranger =
        Pair { name: "bird".into(), target: source.clone(), source: source.clone(), ..good.clone() };
    has(words(&[good.clone(), stranger]), "pair `bird`: it has no `arm_l`");
    let edit = ByExample::new(learned(&one_sided()));
    let mut log = EditLog::default();
    let refused = edit.apply(&Motion::of(source), &Where::default(), &mut log).unwrap_err().to_string();
    has(refused, "the skeleton is not one that this edit was taught on: it has no `arm_l`");
    let options = ExampleOptions { examples_hz: 0.0, ..ExampleOptions::default() };
    has(
        ExampleEdit::learn(&[good], &options).unwrap_err().to_string(),
        "`examples_hz` is 0; allowed: above 0",
    );
}

/// Differences are in the axes in which the examples agree: those of the joint for what turns with it, those of its parent for what does not. What is
/// learned of both comes back on another walk.
#[test]
fn the_axes_are_those_of_the_edit() {
    let (clip, unseen) = (walk(60.0, 3.0, 0.0), walk(60.0, 2.0, 0.7));
    let raised = |clip: &Clip, axes: Axes| {
        let s = clip.skeleton.clone();
        let mut out = clip.clone();
        for f in 0..clip.frames() {
            for (link, sign) in [(2, 1.0), (4, -1.0)] {
                let r = s.rotation(clip.pose(f), link);
                let by = exp(&(Vec3::z() * (0.8 * sign)));
                s.set_rotation(out.pose_mut(f), link, &if axes == Axes::Joint { r * by } else { by * r });
            }
        }
        out
    };
    for axes in [Axes::Joint, Axes::Parent] {
        let pair = Pair::new("walk", clip.clone(), raised(&clip, axes));
        let edit = ExampleEdit::learn(&[pair], &ExampleOptions::default()).unwrap();
        assert_eq!(edit.rig.axes, axes);
        let result = applied(&ByExample::new(Arc::new(edit)), &unseen, &Where::default());
        let (turn, _) = apart(&result, &raised(&unseen, axes));
        assert!(turn < 0.03, "{axes:?}: {turn} rad");
    }
}
