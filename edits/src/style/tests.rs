//! Laws of style on a small walker whose two ways to walk are known.

use std::collections::BTreeMap;
use std::sync::Arc;

use learn::ica::{Count, IcaOptions};
use motion::rotation::exp;
use motion::{
    BallLimits, Clip, Contact, ContactPlan, Joint, Kinematics, Limb, LimbKind, Limits, Link, Range, Skeleton,
    Vec3,
};

use super::figure::{Figure, Match, Postures};
use super::representation::Coding;
use super::*;
use crate::{Motion, Parameter};

const RATE_HZ: f64 = 60.0;

/// Pelvis, trunk, two arms of two bones, two legs of three.
fn walker(size: f64, prefix: &str) -> Arc<Skeleton> {
    let mut links = Vec::new();
    let mut add = |name: &str, parent: Option<usize>, x: f64, y: f64, z: f64, end: Option<Vec3>| {
        let joint = if parent.is_none() { Joint::Free } else { Joint::Spherical };
        let mut link = Link::new(format!("{prefix}{name}"), parent, Vec3::new(x, y, z) * size, joint);
        link.end = end.map(|e| e * size);
        links.push(link);
        links.len() - 1
    };
    let pelvis = add("pelvis", None, 0.0, 0.0, 0.0, None);
    let trunk = add("trunk", Some(pelvis), 0.0, 0.1, 0.0, None);
    add("head", Some(trunk), 0.0, 0.5, 0.0, Some(Vec3::new(0.0, 0.2, 0.02)));
    let mut limbs = Vec::new();
    for (side, s) in [("l", 1.0), ("r", -1.0)] {
        let upper = add(&format!("arm_{side}"), Some(trunk), 0.2 * s, 0.45, 0.0, None);
        add(&format!("forearm_{side}"), Some(upper), 0.0, -0.3, 0.0, Some(Vec3::new(0.0, -0.28, 0.0)));
        let upper = add(&format!("thigh_{side}"), Some(pelvis), 0.1 * s, 0.0, 0.0, None);
        let lower = add(&format!("shin_{side}"), Some(upper), 0.0, -0.42, 0.0, None);
        let end =
            add(&format!("foot_{side}"), Some(lower), 0.0, -0.4, 0.0, Some(Vec3::new(0.0, -0.06, 0.15)));
        limbs.push(Limb { name: format!("leg_{side}"), kind: LimbKind::Leg, upper, lower, end });
    }
    Arc::new(Skeleton::new(links).unwrap().with_limbs(limbs).unwrap())
}

/// How somebody walks.
#[derive(Clone, Copy)]
struct Gait {
    seconds: f64,
    stride_s: f64,
    lean: f64,
    elbow: f64,
    crouch: f64,
    swing: f64,
    heading: f64,
}

const WALK: Gait =
    Gait { seconds: 6.0, stride_s: 1.1, lean: 0.05, elbow: 0.3, crouch: 0.15, swing: 0.45, heading: 0.4 };
const SNEAK: Gait =
    Gait { seconds: 9.0, stride_s: 1.8, lean: 0.5, elbow: 1.3, crouch: 0.7, swing: 0.35, heading: -1.1 };

fn gait(skeleton: &Arc<Skeleton>, g: Gait, speed: f64) -> Clip {
    let frames = (g.seconds * RATE_HZ) as usize;
    let s = skeleton;
    let of = |part: &str| s.links().iter().position(|l| l.name.ends_with(part)).unwrap();
    let mut q = Vec::new();
    for f in 0..frames {
        let t = f as f64 / RATE_HZ;
        let phase = std::f64::consts::TAU * t / g.stride_s;
        let mut pose = s.zero_pose();
        let facing = exp(&(Vec3::y() * g.heading));
        s.set_rotation(&mut pose, 0, &(facing * exp(&(Vec3::x() * (0.3 * g.lean)))));
        s.set_rotation(&mut pose, of("trunk"), &exp(&Vec3::new(0.7 * g.lean, 0.1 * phase.sin(), 0.0)));
        for (side, shift) in [("l", 0.0), ("r", std::f64::consts::PI)] {
            let p = phase + shift;
            let lift = p.cos().max(0.0).powi(2);
            let pitch = -g.crouch - g.swing * p.sin() - 0.3 * lift;
            let bend = 2.0 * g.crouch + 0.7 * lift + 0.1 * (2.0 * p).sin();
            s.set_rotation(&mut pose, of(&format!("thigh_{side}")), &exp(&(Vec3::x() * pitch)));
            s.set_rotation(&mut pose, of(&format!("shin_{side}")), &exp(&(Vec3::x() * bend)));
            s.set_rotation(&mut pose, of(&format!("foot_{side}")), &exp(&(Vec3::x() * (-pitch - bend))));
            let arm = Vec3::new(0.6 * g.swing * p.sin() + 0.2, 0.0, 0.05);
            s.set_rotation(&mut pose, of(&format!("arm_{side}")), &exp(&arm));
            s.set_rotation(
                &mut pose,
                of(&format!("forearm_{side}")),
                &exp(&Vec3::new(-g.elbow - 0.1 * p.sin(), 0.0, 0.0)),
            );
        }
        let way = facing * Vec3::z() * (speed * t);
        s.set_position(&mut pose, 0, &Vec3::new(way.x, 1.0, way.z));
        // the lower foot is on the floor
        let k = Kinematics::new(s, &pose);
        let low = k.origin(of("foot_l")).y.min(k.origin(of("foot_r")).y);
        s.set_position(&mut pose, 0, &Vec3::new(way.x, 1.0 - low + 0.06, way.z));
        q.extend(pose);
    }
    Clip::new(s.clone(), RATE_HZ, q)
}

fn clips() -> (Clip, Clip) {
    let s = walker(1.0, "");
    (gait(&s, WALK, 1.2), gait(&s, SNEAK, 0.5))
}

fn set_of(a: &Clip, b: &Clip, options: &StyleOptions) -> StyleSet {
    let none = BTreeMap::new();
    let example = |name, clip| Example { name, clip, floor_m: 0.0, names: &none };
    StyleSet::of(example("walk", a), example("sneak", b), options).unwrap()
}

fn motion(clip: &Clip) -> Motion {
    Motion { floor_m: Some(0.0), ..Motion::of(clip.clone()) }
}

fn furthest(a: &Clip, b: &Clip) -> f64 {
    assert_eq!(a.frames(), b.frames());
    let mut worst: f64 = 0.0;
    for f in 0..a.frames() {
        let (x, y) = (Kinematics::new(&a.skeleton, a.pose(f)), Kinematics::new(&b.skeleton, b.pose(f)));
        for (p, r) in x.world.iter().zip(&y.world) {
            worst = worst.max((p.translation.vector - r.translation.vector).norm());
            worst = worst.max(p.rotation.angle_to(&r.rotation));
        }
    }
    worst
}

fn apply(set: &StyleSet, base: &Motion, how: &Transfer) -> Styled {
    transfer(set, base, how, (0.0, base.clip.duration_s()), &BTreeMap::new()).unwrap()
}

/// E + Σ (xⁱ − E) over all components is the data, when every direction is kept (SCF06, 2 and 3).
#[test]
fn all_components_together_are_the_clips() {
    let (a, b) = clips();
    for representation in [Representation::Positions, Representation::Tangent, Representation::Euler] {
        let ica = IcaOptions { count: Count::Share(1.0), starts: 1, ..IcaOptions::default() };
        let set = set_of(&a, &b, &StyleOptions { representation, ica, ..StyleOptions::default() });
        let figure = Figure::of(&a.skeleton);
        let matched = Match::of(&figure, &a.skeleton, &BTreeMap::new()).unwrap();
        let mut row = 0;
        let mut worst: f64 = 0.0;
        let whole = {
            let mut sum = set.channels(&set.alone(0)).own;
            for i in 1..set.components() {
                sum += set.channels(&set.alone(i)).own;
                for (c, mut column) in sum.column_iter_mut().enumerate() {
                    column.add_scalar_mut(-set.mean[c]);
                }
            }
            sum
        };
        for clip in [&a, &b] {
            let x = set.coding.encode(&figure, &Postures::of(clip, &figure, &matched, 0.0));
            worst = worst.max((whole.rows(row, x.own.nrows()) - &x.own).amax());
            row += x.own.nrows();
        }
        assert!(worst < 1e-9, "{representation:?}: {worst}"); // 4e-13 seen
    }
}

/// Numbers of postures are those postures, to rounding, from a guess that is far off.
#[test]
fn what_is_encoded_is_decoded() {
    let (a, _) = clips();
    let figure = Figure::of(&a.skeleton);
    let matched = Match::of(&figure, &a.skeleton, &BTreeMap::new()).unwrap();
    let p = Postures::of(&a, &figure, &matched, 0.0);
    for representation in [Representation::Positions, Representation::Tangent, Representation::Euler] {
        let coding = Coding::of(representation, &figure, &[&p]);
        let channels = coding.encode(&figure, &p);
        let mut back = Postures {
            turns: vec![p.turns[17].clone(); p.frames()],
            height: vec![0.0; p.frames()],
            ..p.clone()
        };
        coding.decode(&figure, &channels, &mut back.turns, &mut back.height);
        let mut clip = a.clone();
        back.write(&mut clip, &matched, 0.0);
        let off = furthest(&a, &clip);
        assert!(off < 1e-9, "{representation:?}: {off}"); // 3e-14 seen
    }
}

/// Amount 0 is the base, and so is the base's own style at any amount.
#[test]
fn nothing_changes_nothing() {
    let (a, b) = clips();
    for representation in [Representation::Positions, Representation::Tangent] {
        let set = set_of(&a, &b, &StyleOptions { representation, ..StyleOptions::default() });
        let all: Vec<usize> = (0..set.components()).collect();
        let with = |donor, amount| Transfer {
            components: all.iter().map(|c| (*c, Parameter::Constant(amount))).collect(),
            ..Transfer::of(&set, donor, amount)
        };
        let off = furthest(&a, &apply(&set, &motion(&a), &with(1, 0.0)).edited.clip);
        assert!(off < 1e-9, "{representation:?}: {off}"); // 1e-14 seen
        let off = furthest(&a, &apply(&set, &motion(&a), &with(0, 1.0)).edited.clip);
        assert!(off < 1e-9, "own style, {representation:?}: {off}"); // 1e-12 seen
    }
}

fn pitch(clip: &Clip, part: &str) -> f64 {
    let link = clip.skeleton.links().iter().position(|l| l.name.ends_with(part)).unwrap();
    let mean: f64 = (0..clip.frames())
        .map(|f| {
            let k = Kinematics::new(&clip.skeleton, clip.pose(f));
            let up = k.world[link].rotation * Vec3::y();
            up.y.clamp(-1.0, 1.0).acos()
        })
        .sum();
    mean / clip.frames() as f64
}

/// The lean of the sneak comes into the walk in proportion to its amount, the way and the heading stay, and bones keep
/// their lengths; the other way round the sneak stands up.
#[test]
fn style_moves_between_the_clips_in_both_directions() {
    let (a, b) = clips();
    let set = set_of(&a, &b, &StyleOptions::default());
    println!("{:?}", (0..set.components()).map(|c| set.words(c)).collect::<Vec<_>>());
    for (base, donor_clip, donor) in [(&a, &b, 1), (&b, &a, 0)] {
        let gap = pitch(donor_clip, "trunk") - pitch(base, "trunk");
        let mut last = 0.0;
        for amount in [0.25, 0.5, 0.75, 1.0] {
            let styled = apply(&set, &motion(base), &Transfer::of(&set, donor, amount)).edited.clip;
            let moved = (pitch(&styled, "trunk") - pitch(base, "trunk")) / gap;
            assert!(moved > last, "{donor} at {amount}: {moved} after {last}");
            last = moved;
            let (x, y) = (base.pose(200), styled.pose(200));
            assert!((x[0] - y[0]).hypot(x[2] - y[2]) < 1e-12); // the way over the ground
        }
        assert!(last > 0.8 && last < 1.2, "{donor}: {last} of the gap"); // 0.97 and 1.02 seen
    }
}

/// A curve of amounts acts when it says.
#[test]
fn amounts_may_change_over_time() {
    let (a, b) = clips();
    let set = set_of(&a, &b, &StyleOptions::default());
    let mut how = Transfer::of(&set, 1, 1.0);
    for (_, amount) in &mut how.components {
        *amount = Parameter::OverTime(vec![(2.5, 0.0), (3.5, 1.0)]);
    }
    let styled = apply(&set, &motion(&a), &how).edited.clip;
    let cut = |clip: &Clip, from: usize, to: usize| {
        Clip::new(
            clip.skeleton.clone(),
            clip.rate_hz,
            clip.data()[from * clip.skeleton.nq()..to * clip.skeleton.nq()].to_vec(),
        )
    };
    // the low-pass of the change spreads over a tenth of a second
    let off = furthest(&cut(&a, 0, 120), &cut(&styled, 0, 120));
    assert!(off < 0.01, "{off}"); // 2e-4 seen
    assert!(pitch(&cut(&styled, 240, 360), "trunk") > pitch(&a, "trunk") + 0.3);
}

/// Feet that stand in the base stand where they stood, while the body crouches.
#[test]
fn standing_feet_stay() {
    let (a, b) = clips();
    let set = set_of(&a, &b, &StyleOptions::default());
    let contact =
        |point: &str, from_s, to_s| Contact { point: point.into(), from_s, to_s, world_from_point: None };
    let contacts = ContactPlan::new(vec![
        contact("leg_l", 0.9, 1.4),
        contact("leg_r", 1.5, 1.9),
        contact("leg_l", 2.0, 2.4),
    ])
    .unwrap();
    let base = Motion { contacts, ..motion(&a) };
    let styled = apply(&set, &base, &Transfer::of(&set, 1, 1.0));
    let mut worst: f64 = 0.0;
    for c in base.contacts.contacts() {
        let foot = a.skeleton.limb(&c.point).unwrap().end;
        for f in (c.from_s * RATE_HZ).ceil() as usize..=(c.to_s * RATE_HZ) as usize {
            let at = |clip: &Clip| Kinematics::new(&clip.skeleton, clip.pose(f)).origin(foot);
            worst = worst.max((at(&a) - at(&styled.edited.clip)).norm());
        }
    }
    assert!(worst < 1e-6, "{worst} m; {:?}", styled.notes); // 4e-13 seen
    let loose = apply(&set, &motion(&a), &Transfer::of(&set, 1, 1.0)).edited.clip;
    let foot = a.skeleton.limb("leg_l").unwrap().end;
    let moved = (Kinematics::new(&a.skeleton, loose.pose(70)).origin(foot)
        - Kinematics::new(&a.skeleton, a.pose(70)).origin(foot))
    .norm();
    assert!(moved > 0.02, "{moved}"); // without contacts it would have moved by 0.07 m
}

/// Frames 60 to 79, in which the left leg stands, with a knee stretched by 3° too far: captured motion has such knees.
fn with_a_backward_knee(clip: &Clip) -> Clip {
    let s = clip.skeleton.clone();
    let shin = s.limb("leg_l").unwrap().lower;
    let mut out = clip.clone();
    for f in 60..80 {
        s.set_rotation(out.pose_mut(f), shin, &exp(&(Vec3::x() * -0.05)));
    }
    out
}

/// A knee that the base stretches too far is bent as knees bend, not backwards, and its thigh is not turned round.
#[test]
fn a_knee_stretched_too_far_bends_as_knees_do() {
    let (a, b) = clips();
    let a = with_a_backward_knee(&a);
    let set = set_of(&a, &b, &StyleOptions::default());
    let stands = Contact { point: "leg_l".into(), from_s: 1.0, to_s: 1.3, world_from_point: None };
    let base = Motion { contacts: ContactPlan::new(vec![stands]).unwrap(), ..motion(&a) };
    let styled = apply(&set, &base, &Transfer::of(&set, 1, 1.0)).edited.clip;
    let leg = a.skeleton.limb("leg_l").unwrap();
    let (mut turned, mut least, mut moved): (f64, f64, f64) = (0.0, f64::INFINITY, 0.0);
    for f in 60..=78 {
        let rotation = |clip: &Clip, link| clip.skeleton.rotation(clip.pose(f), link);
        turned = turned.max(rotation(&a, leg.upper).angle_to(&rotation(&styled, leg.upper)));
        least = least.min(motion::rotation::log(&rotation(&styled, leg.lower)).x);
        let at = |clip: &Clip| Kinematics::new(&clip.skeleton, clip.pose(f)).origin(leg.end);
        moved = moved.max((at(&a) - at(&styled)).norm());
    }
    println!("{turned} {least} {moved}");
    assert!(turned < 1.2 && least > 0.2 && moved < 1e-6, "{turned} rad, {least} rad, {moved} m");
}

/// A leg within limits that are narrow is turned no farther than they allow; its foot keeps its place and its turn, and what is
/// allowed is not touched.
#[test]
fn legs_are_turned_within_their_limits() {
    let (a, _) = clips();
    let mut links = a.skeleton.links().to_vec();
    let leg = a.skeleton.limb("leg_l").unwrap().clone();
    let ranges = [Range::new(-2.0, 2.0), Range::new(-0.3, 0.3), Range::new(-0.2, 0.2)];
    links[leg.upper].limits =
        Some(Limits::Ball(BallLimits { axes: [Vec3::x(), Vec3::z(), Vec3::y()], ranges }));
    let limited = Skeleton::new(links).unwrap();
    let mut held = 0;
    for f in (0..a.frames()).step_by(7) {
        for wanted in [-0.8, -0.05, 0.0, 0.05, 0.8] {
            let angle = super::knees::allowed(&limited, &leg, a.pose(f), a.pose(f), wanted);
            let mut q = a.pose(f).to_vec();
            motion::ik::swivel::turn(&limited, &mut q, &leg, angle);
            let is = limited.rotation(&q, leg.upper);
            let Some(Limits::Ball(ball)) = &limited.links()[leg.upper].limits else { panic!("a ball") };
            assert!(ball.clamp(&is).angle_to(&is) < 1e-6, "{f}, {wanted}: {angle}");
            let [was, is] = [a.pose(f), &q[..]].map(|q| Kinematics::new(&limited, q).world[leg.end]);
            let moved = (was.translation.vector - is.translation.vector).norm();
            assert!(moved < 1e-9 && was.rotation.angle_to(&is.rotation) < 1e-7, "{f}: {moved} m");
            let less = angle.abs() < wanted.abs() && angle * wanted >= 0.0;
            assert!(angle == wanted || less, "{f}: {angle} for {wanted}");
            held += usize::from(angle != wanted);
            assert!(angle == wanted || wanted.abs() > 0.5, "{f}: {angle} for {wanted}");
        }
    }
    assert!(held > 50, "{held}");
}

/// The donor's timing makes the base as slow as the donor, and its way with it.
#[test]
fn the_donors_timing_retimes_the_base() {
    let (a, b) = clips();
    let set = set_of(&a, &b, &StyleOptions::default());
    let how = Transfer { timing: Timing::Donor, ..Transfer::of(&set, 1, 1.0) };
    let styled = apply(&set, &motion(&a), &how).edited;
    let slower = styled.clip.duration_s() / a.duration_s();
    assert!((slower - SNEAK.stride_s / WALK.stride_s).abs() < 0.15, "{slower}"); // 1.63 seen, strides say 1.64
    let way = |clip: &Clip| {
        let (x, y) = (clip.pose(0), clip.pose(clip.frames() - 1));
        (x[0] - y[0]).hypot(x[2] - y[2])
    };
    assert!((way(&styled.clip) - way(&a)).abs() < 0.05, "{} {}", way(&styled.clip), way(&a));
}

/// Components of two clips go into a third of another size, other names and a zero pose of its own.
#[test]
fn a_third_clip_of_another_body_takes_the_style() {
    let (a, b) = clips();
    let set = set_of(&a, &b, &StyleOptions::default());
    let other = walker(1.3, "Subject7:");
    let third = gait(&other, Gait { stride_s: 1.25, heading: 2.0, seconds: 5.0, ..WALK }, 1.4);
    let base = motion(&third);
    let off = furthest(&third, &apply(&set, &base, &Transfer::of(&set, 1, 0.0)).edited.clip);
    assert!(off < 1e-9, "{off}"); // 2e-14 seen
    let styled = apply(&set, &base, &Transfer::of(&set, 1, 1.0));
    let gap = (
        pitch(&b, "trunk") - pitch(&third, "trunk"),
        pitch(&styled.edited.clip, "trunk") - pitch(&third, "trunk"),
    );
    assert!((gap.1 / gap.0 - 1.0).abs() < 0.2, "{gap:?}"); // 0.97 seen
    let note = &styled.notes[0];
    assert!(note.contains("legs 1.300 times as long") && note.contains("matched by name"), "{note}");
}

/// Merged components are seen and weighted as one, and together they are what they were.
#[test]
fn merged_components_are_one() {
    let (a, b) = clips();
    let ica = IcaOptions { count: Count::Number(4), ..IcaOptions::default() };
    let set = set_of(&a, &b, &StyleOptions { ica, ..StyleOptions::default() });
    let merged = set.merged(&[0, 2]);
    assert_eq!((merged.components(), merged.groups[0].clone()), (3, vec![0, 2]));
    let sum = set.alone(0) + set.alone(2);
    assert_eq!(merged.alone(0), sum);
    let how = |s: &StyleSet, c: &[usize]| Transfer {
        components: c.iter().map(|c| (*c, Parameter::Constant(0.7))).collect(),
        ..Transfer::of(s, 1, 0.7)
    };
    let (one, two) =
        (apply(&merged, &motion(&a), &how(&merged, &[0])), apply(&set, &motion(&a), &how(&set, &[0, 2])));
    assert!(furthest(&one.edited.clip, &two.edited.clip) < 1e-12);
    assert!((merged.share(0) - set.share(0) - set.share(2)).abs() < 1e-12);
}

/// Gestures are aligned by anchors, and an extreme warp is said to be one.
#[test]
fn anchors_align_and_extremes_are_said() {
    let (a, b) = clips();
    let set = set_of(&a, &b, &StyleOptions::default());
    let how =
        Transfer { on: On::Anchors(vec![(0.0, 0.0), (1.0, 0.2), (5.9, 8.9)]), ..Transfer::of(&set, 1, 1.0) };
    let styled = apply(&set, &motion(&a), &how);
    assert!(styled.notes.iter().any(|n| n.contains("the warp is extreme")), "{:?}", styled.notes);
    let fast = Transfer { on: On::Anchors(vec![(0.0, 0.0), (4.0, 8.0)]), ..Transfer::of(&set, 1, 1.0) };
    let styled = apply(&set, &motion(&a), &fast);
    assert!(styled.notes.iter().any(|n| n.contains("becomes stiff")), "{:?}", styled.notes);
}

/// What cannot be done says why.
#[test]
fn what_cannot_be_done_is_refused() {
    let (a, b) = clips();
    let set = set_of(&a, &b, &StyleOptions::default());
    let none = BTreeMap::new();
    let refused =
        |how: Transfer| transfer(&set, &motion(&a), &how, (0.0, 6.0), &none).unwrap_err().to_string();
    let of = Transfer::of(&set, 1, 1.0);
    assert_eq!(refused(Transfer::of(&set, 1, 1.6)), "an amount of 1.6; allowed: 0 to 1.5");
    let missing = Transfer { components: vec![(8, Parameter::Constant(1.0))], ..of.clone() };
    assert!(refused(missing).starts_with("there is no component 9; allowed: 1 to "));
    let bone = Transfer { on: On::Bone("thig_l".into()), ..of.clone() };
    assert!(refused(bone).contains("did you mean `thigh_l`"));
    let knots = vec![(1.0, 0.5), (0.5, 0.2)];
    let knots = Transfer { components: vec![(0, Parameter::OverTime(knots))], ..of.clone() };
    assert!(refused(knots).contains("in ascending order"));
    let lamp = Skeleton::new(vec![Link::new("lamp", None, Vec3::zeros(), Joint::Free)]).unwrap();
    let lamp = Clip::new(Arc::new(lamp.clone()), RATE_HZ, lamp.zero_pose().repeat(10));
    let said = transfer(&set, &motion(&lamp), &of, (0.0, 0.1), &none).unwrap_err().to_string();
    assert!(said.starts_with("only 1 of the 13 bones are found"), "{said}");
    let still = Clip::new(a.skeleton.clone(), RATE_HZ, a.pose(0).repeat(40));
    let example = |name, clip| Example { name, clip, floor_m: 0.0, names: &none };
    let said = StyleSet::of(example("a", &still), example("b", &still), &StyleOptions::default());
    assert!(said.unwrap_err().to_string().contains("stand still"));
    let one = Clip::new(a.skeleton.clone(), RATE_HZ, a.pose(0).to_vec());
    let said = StyleSet::of(example("a", &a), example("b", &one), &StyleOptions::default());
    assert_eq!(said.unwrap_err().to_string(), "b has 1 frames; a motion has at least 2");
    let half = Clip::new(b.skeleton.clone(), 30.0, b.resample(30.0).data().to_vec());
    let set = StyleSet::of(example("a", &a), example("b", &half), &StyleOptions::default()).unwrap();
    assert_eq!(set.notes[0], "b is resampled from 30 Hz to 60 Hz");
}
