//! Contacts in the blend: derivatives, a dense solution, and what becomes of a walker's feet.

use std::f64::consts::TAU;
use std::sync::Arc;

use motion::plant::{Knee, Plant, plant};
use motion::rotation::exp;
use motion::{Joint, Limb, LimbKind, Link, Site};
use nalgebra::DVector;

use super::*;
use crate::by_example::block_band::BlockBand;
use crate::by_example::contact_chain::Chain;
use crate::by_example::outputs;
use crate::by_example::solve::{Evidence, blend};
use crate::by_example::{ExampleEdit, ExampleOptions, Pair};
use crate::{ByExample, ClipEdit, EditLog, Where};

const RATE_HZ: f64 = 60.0;
const STEP_S: f64 = 0.5;

/// A trunk on two legs: hips and ankles are balls, knees hinges; a toe on each foot.
fn body() -> Arc<Skeleton> {
    let (ball, knee) = (Joint::Spherical, Joint::Revolute(Vec3::x()));
    let mut links = vec![Link::new("pelvis", None, Vec3::zeros(), Joint::Free)];
    let mut trunk = Link::new("trunk", Some(0), Vec3::y() * 0.1, ball);
    trunk.end = Some(Vec3::y() * 0.5);
    links.push(trunk);
    let (mut limbs, mut sites) = (Vec::new(), Vec::new());
    for (side, x) in [("l", 0.1), ("r", -0.1)] {
        let upper = links.len();
        links.push(Link::new(format!("hip_{side}"), Some(0), Vec3::new(x, -0.05, 0.0), ball));
        links.push(Link::new(format!("knee_{side}"), Some(upper), Vec3::y() * -0.42, knee));
        let mut foot = Link::new(format!("ankle_{side}"), Some(upper + 1), Vec3::y() * -0.42, ball);
        foot.end = Some(Vec3::new(0.0, -0.08, 0.15));
        links.push(foot);
        let (name, kind) = (format!("leg_{side}"), LimbKind::Leg);
        limbs.push(Limb { name, kind, upper, lower: upper + 1, end: upper + 2 });
        sites.push(Site { name: format!("toe_{side}"), link: upper + 2, at: Vec3::new(0.0, -0.08, 0.15) });
    }
    let s = Skeleton::new(links).unwrap().with_limbs(limbs).unwrap().with_sites(sites).unwrap();
    Arc::new(s)
}

/// It walks along a wide curve, feet planted in turn; the plan has when.
fn walk(seconds: f64) -> Motion {
    let s = body();
    let frames = (seconds * RATE_HZ) as usize + 1;
    let path = |t: f64| {
        let yaw = 0.3 * t;
        (Quat::from_axis_angle(&Vec3::y_axis(), yaw), Vec3::new(1.0 - yaw.cos(), 0.0, yaw.sin()) * 2.0)
    };
    // where a foot stands that came down at step k, and where it is between
    let stands = |x: f64, k: f64| {
        let (turn, at) = path((k + 0.5) * STEP_S);
        Transform::from_parts((at + turn * Vec3::x() * x + Vec3::y() * 0.08).into(), turn)
    };
    let foot = |x: f64, phase: f64, t: f64| {
        // a foot swings in even steps of its own, stands in odd ones
        let steps = t / STEP_S + phase;
        let k = 2.0 * (0.5 * steps).floor();
        let u = (steps - k).min(1.0);
        let (a, b) = (stands(x, k - 1.0 - phase), stands(x, k + 1.0 - phase));
        let s = smoothstep(u);
        let lift = Vec3::y() * (0.1 * (std::f64::consts::PI * u).sin().powi(2));
        let at = a.translation.vector.lerp(&b.translation.vector, s) + lift;
        Transform::from_parts(at.into(), a.rotation.slerp(&b.rotation, s))
    };
    let mut q = Vec::new();
    for f in 0..frames {
        let t = f as f64 / RATE_HZ;
        let mut pose = s.zero_pose();
        let (turn, at) = path(t);
        let sway = Vec3::new(0.02 * (TAU * t / 1.0).sin(), 0.86 + 0.01 * (TAU * t / 0.5).sin(), 0.0);
        s.set_position(&mut pose, 0, &(at + turn * sway));
        s.set_rotation(&mut pose, 0, &(turn * exp(&Vec3::new(0.05, 0.0, 0.02 * (TAU * t).sin()))));
        for limb in s.limbs() {
            pose[s.q_at(limb.lower)] = 0.4;
        }
        let plants: Vec<Plant> = [(0.1, 0.0), (-0.1, 1.0)]
            .into_iter()
            .zip(s.limbs())
            .map(|((x, phase), limb)| Plant {
                limb: limb.clone(),
                world_from_end: foot(x, phase, t),
                knee: Knee::Kept,
            })
            .collect();
        assert!(plant(&s, &mut pose, &plants).unwrap() < 1e-9);
        q.extend(pose);
    }
    let mut contacts = Vec::new();
    for (limb, phase) in s.limbs().iter().zip([0.0, 1.0]) {
        let mut from_s = (1.0 - phase) * STEP_S;
        while from_s + STEP_S <= seconds {
            let world_from_point = Some(foot(if phase == 0.0 { 0.1 } else { -0.1 }, phase, from_s));
            let to_s = from_s + STEP_S;
            contacts.push(Contact { point: limb.name.clone(), from_s, to_s, world_from_point });
            from_s += 2.0 * STEP_S;
        }
    }
    let contacts = ContactPlan::new(contacts).unwrap();
    Motion { contacts, ..Motion::of(Clip::new(s, RATE_HZ, q)) }
}

/// What may change, and smooth differences: knees bend, hips and tilt turn, the root sinks and goes other ways.
fn edit(rig: &Rig, frames: usize, amount: f64) -> (Allowed, DMatrix<f64>) {
    let wave = |f: usize, c: usize| (0.05 * f as f64 + 1.7 * c as f64).sin();
    let d = DMatrix::from_fn(frames, outputs::width(rig), |f, c| amount * (0.6 + 0.4 * wave(f, c)));
    let allowed = Allowed {
        joints: vec![true; rig.joints().len()],
        tilt: true,
        height: true,
        steps: true,
        time: false,
    };
    (allowed, d)
}

fn form(frames: usize) -> Form {
    let wave = |f: usize, a: f64| 1.0 + 0.5 * (a * f as f64).sin();
    Form {
        configuration: (0..frames).map(|f| 100.0 * wave(f, 0.2)).collect(),
        acceleration: (0..frames).map(|f| 0.02 * wave(f, 0.13)).collect(),
        step_s: 1.0 / RATE_HZ,
        root: 1.0,
    }
}

/// A walk, its blend without contacts, and all that belongs to it.
struct Case {
    motion: Motion,
    rig: Rig,
    allowed: Allowed,
    differences: DMatrix<f64>,
    free: Clip,
    form: Form,
}

impl Case {
    fn new(seconds: f64, amount: f64) -> Self {
        let motion = walk(seconds);
        let rig = Rig::of(&motion.clip.skeleton).unwrap();
        let (allowed, differences) = edit(&rig, motion.clip.frames(), amount);
        let form = form(motion.clip.frames());
        Self::of(motion, rig, allowed, differences, form)
    }

    fn of(motion: Motion, rig: Rig, allowed: Allowed, differences: DMatrix<f64>, form: Form) -> Self {
        let clip = &motion.clip;
        let free = outputs::add(&rig, clip, &differences, &allowed, &clip.skeleton, rig.size_m);
        Self { motion, rig, allowed, differences, free, form }
    }

    fn blended(&self) -> Blended<'_> {
        Blended { rig: &self.rig, clip: &self.free, differences: &self.differences, allowed: &self.allowed }
    }

    fn keep(&self) -> (Clip, Kept) {
        keep(&self.motion, &self.blended(), &self.form, (0.0, self.motion.clip.duration_s()))
    }
}

/// Derivatives of E are its differences, at corrections that are not small.
#[test]
fn the_gradient_is_that_of_the_cost() {
    let mut case = Case::new(1.2, 0.15);
    // a point of a link and a site beside the limbs; a hinge among the joints
    let mut contacts = case.motion.contacts.contacts().to_vec();
    let contact =
        |point: &str, from_s, to_s| Contact { point: point.into(), from_s, to_s, world_from_point: None };
    contacts.push(contact("toe_l", 0.3, 0.9));
    contacts.push(contact("knee_r", 0.1, 0.4));
    case.motion.contacts = ContactPlan::new(contacts).unwrap();
    let frames = 0..case.motion.clip.frames();
    let (found, unknown) = standing(&case.motion, &case.blended(), &frames);
    assert!(unknown.is_empty());
    let blended = case.blended();
    let mut problem = Problem::new(&case.motion.clip, &blended, &case.form, frames.clone(), found);
    let n = problem.chain.width;
    assert_eq!(n, 3 + 1 + 1 + 2 + 2 * (3 + 1 + 3));
    let c: Vec<f64> = (0..n * frames.len()).map(|i| 0.1 * (0.37 * i as f64).sin()).collect();
    let mut matrix = BlockBand::zeros(n, frames.len());
    let mut gradient = vec![0.0; c.len()];
    problem.derivatives(&c, &mut matrix, &mut gradient);
    let scale = gradient.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
    let mut worst = 0.0_f64;
    for i in (0..c.len()).step_by(7) {
        let at = |by: f64| {
            let mut c = c.clone();
            c[i] += by;
            c
        };
        let h = 1e-4;
        let (a, b) = (problem.cost(&at(-h)), problem.cost(&at(h)));
        let (a2, b2) = (problem.cost(&at(-2.0 * h)), problem.cost(&at(2.0 * h)));
        let found = (8.0 * (b - a) - (b2 - a2)) / (12.0 * h);
        worst = worst.max((found - gradient[i]).abs() / scale);
    }
    println!("gradient {worst:e}");
    assert!(worst < 1e-8, "{worst:e}"); // 7e-12 seen
}

/// The banded solution is that of a full least-squares problem written down from the module header, with Jacobians by differences.
#[test]
fn the_solution_is_that_of_a_dense_one() {
    let case = Case::new(0.8, 0.08);
    let (clip, kept) = case.keep();
    assert!(kept.settled && !kept.standing.is_empty());
    let frames = clip.frames();
    let h = case.form.step_s;
    let ends: Vec<usize> = kept.standing.iter().map(|s| s.link).collect();
    let chain = Chain::new(&case.rig, &case.motion.clip, &case.free, &case.differences, &case.allowed, &ends);
    let n = chain.width;
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let w = STIFFNESS
        * (mean(&case.form.configuration) + (TAU * SLOW_HZ).powi(4) * mean(&case.form.acceleration));
    let size = case.rig.size_m;
    let s = case.motion.clip.skeleton.clone();
    let owners = chain.owners();
    let residual = |c: &DVector<f64>| -> Vec<f64> {
        let at = |f: usize, i: usize| c[f * n + i];
        let mut r = Vec::new();
        for i in 0..n {
            for f in 0..frames {
                let k = case.form.configuration[f].sqrt();
                if owners[i] as usize != 2 {
                    r.push(k * at(f, i));
                } else if f + 1 < frames {
                    r.push(k * (at(f + 1, i) - at(f, i)) / h);
                }
                if f > 0 && f + 1 < frames {
                    let bend = (at(f - 1, i) - 2.0 * at(f, i) + at(f + 1, i)) / (h * h);
                    r.push(case.form.acceleration[f].sqrt() * bend);
                }
            }
        }
        let mut q = vec![0.0; s.nq()];
        for f in 0..frames {
            chain.pose(f, &c.as_slice()[f * n..(f + 1) * n], &mut q);
            let k = Kinematics::new(&s, &q);
            for one in kept.standing.iter().filter(|o| o.frames().contains(&f)) {
                let weight = (w * one.weights[f - one.first]).sqrt() / size;
                let (x, turned) = one.goal(f);
                r.extend(((k.point(one.link, &one.at) - x) * weight).iter());
                let turn = log(&(k.world[one.link].rotation * turned.inverse()));
                r.extend((turn * (weight * LEVER_M)).iter());
            }
        }
        r
    };
    let mut c = DVector::zeros(n * frames);
    for _ in 0..5 {
        let r = DVector::from_vec(residual(&c));
        let mut j = DMatrix::zeros(r.len(), c.len());
        for i in 0..c.len() {
            let mut near = c.clone();
            near[i] += 1e-5;
            let plus = DVector::from_vec(residual(&near));
            near[i] -= 2e-5;
            j.set_column(i, &((plus - DVector::from_vec(residual(&near))) / 2e-5));
        }
        let step = j.clone().qr();
        let right = step.q().transpose() * r;
        c -= step.r().solve_upper_triangular(&right).unwrap();
    }
    let (mut worst, mut most) = (0.0_f64, 0.0_f64);
    let mut q = vec![0.0; s.nq()];
    let mut v = vec![0.0; s.nv()];
    for f in 0..frames {
        chain.pose(f, &c.as_slice()[f * n..(f + 1) * n], &mut q);
        s.difference(clip.pose(f), &q, 1.0, &mut v);
        worst = v.iter().fold(worst, |m, x| m.max(x.abs()));
        s.difference(case.free.pose(f), &q, 1.0, &mut v);
        most = v.iter().fold(most, |m, x| m.max(x.abs()));
    }
    println!("apart {worst:e} of corrections up to {most}");
    assert!(most > 0.02 && worst < 1e-4 * most, "{worst:e} of {most}"); // 3e-6 seen
}

/// Without contacts, and with an edit that changes nothing, the result is the blend to the bit.
#[test]
fn nothing_to_keep_is_nothing_done() {
    let mut case = Case::new(2.0, 0.1);
    case.motion.contacts = ContactPlan::default();
    assert_eq!(case.keep().0, case.free);
    let same = Case::new(2.0, 0.0);
    let (clip, kept) = same.keep();
    assert_eq!((clip, kept.steps), (same.motion.clip.clone(), 0));
    // nothing may move: the contacts are missed, and it is said
    let mut bound = Case::new(2.0, 0.1);
    bound.allowed.joints.fill(false);
    (bound.allowed.tilt, bound.allowed.height, bound.allowed.steps) = (false, false, false);
    let (clip, kept) = bound.keep();
    assert_eq!(clip, bound.free);
    assert!(!kept.notes(&kept.misses(&clip)).is_empty());
}

/// Largest third difference of the links' origins, m/s³.
fn peak_jerk(clip: &Clip) -> f64 {
    let at: Vec<Vec<Vec3>> = (0..clip.frames())
        .map(|f| {
            let k = Kinematics::new(&clip.skeleton, clip.pose(f));
            (0..k.world.len()).map(|l| k.origin(l)).collect()
        })
        .collect();
    let mut peak = 0.0_f64;
    for w in at.windows(4) {
        for l in 0..w[0].len() {
            let third = w[3][l] - w[2][l] * 3.0 + w[1][l] * 3.0 - w[0][l];
            peak = peak.max(third.norm() * clip.rate_hz.powi(3));
        }
    }
    peak
}

/// Furthest way of a standing point from its mean place, m.
fn slip(clip: &Clip, plan: &ContactPlan) -> f64 {
    let mut worst = 0.0_f64;
    for c in plan.contacts() {
        let (link, at, _) = point(&clip.skeleton, &c.point).unwrap();
        let places: Vec<Vec3> =
            trace(clip, link, &at, frames_of((c.from_s, c.to_s), clip)).into_iter().map(|p| p.0).collect();
        let mean = places.iter().sum::<Vec3>() / places.len() as f64;
        worst = places.iter().fold(worst, |m, p| m.max((p - mean).norm()));
    }
    worst
}

/// Feet that slide and float in the blend stand where the plan then says, turned as it says, and nothing jumps.
#[test]
fn feet_stand() {
    let case = Case::new(4.0, 0.1);
    let (clip, kept) = case.keep();
    let misses = kept.misses(&clip);
    let worst = misses.iter().map(|m| m.rms_m).fold(0.0, f64::max);
    let slips = [&case.motion.clip, &case.free, &clip].map(|c| slip(c, &case.motion.contacts));
    let jerks = [&case.motion.clip, &case.free, &clip].map(peak_jerk);
    println!("{} steps; miss {worst:e}; slip {slips:?}; jerk {jerks:?}", kept.steps);
    assert!(kept.settled && worst < 1e-3, "{worst}"); // 2e-6 seen
    assert!(slips[1] > 0.01 && slips[2] < slips[0] + 0.002, "{slips:?}");
    assert!(jerks[2] < 1.2 * jerks[1], "{jerks:?}");
    assert!(kept.notes(&misses).is_empty());
    // the plan has the new places
    for c in kept.plan.contacts() {
        let limb = clip.skeleton.limb(&c.point).unwrap();
        let f = frames_of((c.from_s, c.to_s), &clip).start + 5;
        let apart = Kinematics::new(&clip.skeleton, clip.pose(f)).world[limb.end].inverse()
            * c.world_from_point.unwrap();
        assert!(apart.translation.vector.norm() < 1e-3 && apart.rotation.angle() < 0.01, "{apart}");
    }
}

/// Outside the span nothing changes; a foot that stands across its ends stays where it stands outside. A correction that must go
/// within 0.2 s of the end of a contact costs some jerk; one that has 0.35 s does not.
#[test]
fn a_span_ends_where_it_ends() {
    for (from_s, to_s, jerkier) in [(1.2, 2.85, 1.2), (1.2, 2.7, 1.35)] {
        let whole = Case::new(4.0, 0.0);
        let frames = whole.motion.clip.frames();
        let (allowed, mut d) = edit(&whole.rig, frames, 0.1);
        for f in 0..frames {
            let t = f as f64 / RATE_HZ;
            d.row_mut(f).scale_mut(smoothstep((t - from_s) / 0.25).min(smoothstep((to_s - t) / 0.25)));
        }
        let case = Case::of(whole.motion, whole.rig, allowed, d, whole.form);
        let (clip, kept) = keep(&case.motion, &case.blended(), &case.form, (from_s, to_s));
        let edited = frames_of((from_s, to_s), &clip);
        for f in (0..frames).filter(|f| !edited.contains(f)) {
            assert_eq!(clip.pose(f), case.free.pose(f), "{f}");
        }
        assert!(edited.clone().any(|f| clip.pose(f) != case.free.pose(f)));
        let worst = kept.misses(&clip).iter().map(|m| m.most_m).fold(0.0, f64::max);
        let jerks = [&case.free, &clip].map(peak_jerk);
        println!("miss {worst:e}, jerk {jerks:?}");
        assert!(kept.standing.iter().any(|s| s.fixed) && worst < 1e-3, "{worst}"); // 2e-5 seen
        assert!(jerks[1] < jerkier * jerks[0], "{jerks:?}"); // 0.95 and 1.26 seen
    }
}

/// A root 0.3 m too high for its legs that corrections may not move: the log says by how much the feet miss, and which names it does
/// not know. One that they may move gives way, however firm it is.
#[test]
fn what_cannot_be_reached_is_said() {
    let mut case = Case::new(2.0, 0.0);
    case.differences.column_mut(outputs::root_columns(&case.rig).height).fill(0.3 / case.rig.size_m);
    case.form.root = 1e9;
    let mut contacts = case.motion.contacts.contacts().to_vec();
    contacts.push(Contact { point: "tail".into(), from_s: 0.0, to_s: 1.0, world_from_point: None });
    case.motion.contacts = ContactPlan::new(contacts).unwrap();
    let mut case = Case::of(case.motion, case.rig, case.allowed, case.differences, case.form);
    let (clip, kept) = case.keep();
    let worst = kept.misses(&clip).iter().map(|m| m.most_m).fold(0.0, f64::max);
    assert!(worst < 1e-3, "{worst}"); // 2e-6 seen
    (case.allowed.tilt, case.allowed.height, case.allowed.steps) = (false, false, false);
    let (clip, kept) = case.keep();
    let misses = kept.misses(&clip);
    let notes = kept.notes(&misses).join("\n");
    println!("{notes}");
    // legs of 0.84 m from 1.11 m: at least 0.2 m are missing
    assert!(misses.iter().all(|m| m.most_m > 0.15 && m.most_m < 0.4), "{misses:?}");
    assert!(notes.contains("`tail`") && notes.contains("cannot be kept") && notes.contains("mm at most"));
}

/// A learned edit, with contacts free and kept: the same to the bit without a plan; with one, and retimed, feet stand.
#[test]
fn a_learned_edit_keeps_contacts() {
    let taught = walk(3.0);
    let source = taught.clip.clone();
    let s = source.skeleton.clone();
    let mut target = source.clone();
    for f in 0..target.frames() {
        let q = target.pose_mut(f);
        for limb in s.limbs() {
            q[s.q_at(limb.lower)] += 0.2;
        }
    }
    let times_s = (0..source.frames()).map(|f| 1.2 * f as f64 / RATE_HZ).collect();
    let pair = Pair { times_s: Some(times_s), ..Pair::new("knees", source, target) };
    let options = ExampleOptions { examples_hz: 10.0, contacts: Contacts::Keep, ..ExampleOptions::default() };
    let keeps = ByExample::new(Arc::new(ExampleEdit::learn(&[pair], &options).unwrap()));
    let frees = ByExample { contacts: Contacts::Free, ..keeps.clone() };
    let applied = |edit: &ByExample, motion: &Motion| {
        edit.apply(motion, &Where::default(), &mut EditLog::default()).unwrap()
    };
    let bare = Motion::of(taught.clip.clone());
    assert_eq!(applied(&keeps, &bare), applied(&frees, &bare));
    let [kept, free] = [&keeps, &frees].map(|e| applied(e, &taught));
    assert!(kept.clip.duration_s() > 1.15 * taught.clip.duration_s());
    let slips =
        [(&taught.clip, &taught.contacts), (&free.clip, &free.contacts), (&kept.clip, &kept.contacts)]
            .map(|(clip, plan)| slip(clip, plan));
    println!("slip {slips:?}");
    assert!(slips[1] > 0.003 && slips[2] < slips[0] + 0.002, "{slips:?}");
}

/// The form that contacts are weighed against is that of the blend: its answer is where the form's gradient vanishes.
#[test]
fn the_form_is_that_of_the_blend() {
    let frames = 12;
    let mean = DMatrix::from_fn(frames, 1, |f, _| (0.4 * f as f64).sin());
    let variance: Vec<f64> = (0..frames).map(|f| 0.1 + 0.05 * (f as f64).cos()).collect();
    let k = Evidence::new(mean, &variance, 1.0, 1.0, 0.5);
    let a = Evidence::new(DMatrix::zeros(frames, 1), &variance, 1.0, 1.0, 0.5);
    let answer = blend(&k, &a, 0.5);
    let band = Form::of(&k, &a, 0.5).band();
    for f in 0..frames {
        let right = k.learned[f] * k.mean[(f, 0)];
        assert!((band.times(f, |i| answer[(i, 0)]) - right).abs() < 1e-10);
    }
}

/// An edit of the root's height alone.
fn lowered(by_m: f64, root: f64) -> Case {
    let motion = walk(4.0);
    let rig = Rig::of(&motion.clip.skeleton).unwrap();
    let frames = motion.clip.frames();
    let (allowed, mut d) = edit(&rig, frames, 0.0);
    let column = outputs::root_columns(&rig).height;
    d.column_mut(column).fill(-by_m / rig.size_m);
    let form = Form { root, ..form(frames) };
    Case::of(motion, rig, allowed, d, form)
}

/// A root that is taught to be 5 cm (15 cm) lower is, with the default weight: the feet stand, the legs bend. With the weights of the blend it
/// would come up again.
#[test]
fn a_lowered_root_stays_low() {
    let default = ExampleOptions::default().root_weight;
    for by_m in [0.05, 0.15] {
        let share = |root: f64| {
            let case = lowered(by_m, root);
            let (clip, kept) = case.keep();
            let s = &clip.skeleton;
            let height = |c: &Clip| (0..c.frames()).map(|f| s.position(c.pose(f), 0).y).sum::<f64>();
            let lower_m = (height(&case.motion.clip) - height(&clip)) / clip.frames() as f64;
            let worst = kept.misses(&clip).iter().map(|m| m.most_m).fold(0.0, f64::max);
            assert!(kept.settled && kept.steps <= 6 && worst < 1e-3, "{} steps, {worst} m", kept.steps);
            lower_m / by_m
        };
        let (firm, plain) = (share(default), share(1.0));
        assert!(firm > 0.9 && plain < 0.1, "{by_m} m: {firm}, {plain}"); // 0.94 and 0.02 seen
    }
}
