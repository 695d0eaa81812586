//! What stages are held to: bounds, speeds, contacts that give way, flights.

use motion::{Clip, Vec3, smoothstep};
use retarget::contacts::{keep, phases};
use retarget::{Bounds, ContactOptions, Guard, Phase, Step, flights};

use crate::bodies::{Held, held, mocap, puppet, same_angles, scaled};

const G: f64 = 9.81;

/// One degree of freedom moved along a curve of the frame.
fn moved(clip: &Clip, dof: usize, by: impl Fn(usize) -> f64) -> Clip {
    let (mut out, mut v) = (clip.clone(), vec![0.0; clip.skeleton.nv()]);
    for i in 0..clip.frames() {
        v[dof] = by(i);
        clip.skeleton.integrate(out.pose_mut(i), &v, 1.0);
    }
    out
}

/// How far each frame of two clips is apart, in the tangent.
fn apart(a: &Clip, b: &Clip) -> Vec<f64> {
    let mut v = vec![0.0; a.skeleton.nv()];
    let of_frame = |i: usize| {
        a.skeleton.difference(a.pose(i), b.pose(i), 1.0, &mut v);
        v.iter().map(|x| x * x).sum::<f64>().sqrt()
    };
    (0..a.frames()).map(of_frame).collect()
}

/// A stage that pops is held back around the pop, is within its factors afterwards, and is left as it is elsewhere.
#[test]
fn a_pop_is_held_back_and_the_rest_stays() {
    let Held { puppet, clip, .. } = held("14_37", 0.7, 1.0);
    let elbow = clip.skeleton.v_at(clip.skeleton.link("RightForeArm").unwrap());
    let middle = clip.frames() / 2;
    // half a radian within two frames, in the middle of a slow turn
    let pop = |i: usize| if i.abs_diff(middle) < 2 { 0.5 } else { 0.0 };
    let slow = |i: usize| 0.1 * (i as f64 / clip.frames() as f64 * 6.0).sin();
    let after = moved(&clip, elbow, |i| slow(i) + pop(i));
    let guard = Guard::new(&puppet, &[clip.pose(0).to_vec()], G);
    let before = guard.before(&clip);
    let (factors, _) = guard.exceeded(&before, &after, &Bounds::CONTACT);
    let out = guard.hold(Step::Contact, (&clip, &before), after.clone(), &Bounds::CONTACT);
    println!(
        "{factors:?} → {:.1}, {:.1}; {:?}",
        out.report.speed, out.report.acceleration, out.report.held_back_s
    );
    assert!(factors[1] > 2.0 * Bounds::CONTACT.acceleration, "{factors:?}");
    assert!(
        out.report.speed <= Bounds::CONTACT.speed && out.report.acceleration <= Bounds::CONTACT.acceleration
    );
    assert_eq!(out.report.held_back_s.len(), 1);
    let [from, to] = out.report.held_back_s[0];
    let at_s = middle as f64 / clip.rate_hz;
    assert!(from < at_s && at_s < to && to - from < 2.0, "{from} {to}");
    for (i, off) in apart(&after, &out.clip).iter().enumerate() {
        let inside = (from..=to).contains(&(i as f64 / clip.rate_hz));
        assert!(inside || *off < 1e-12, "{i}: {off}");
    }
}

/// No displacement leaves its bound, however far the stage goes; what is small stays as it is.
#[test]
fn displacements_stay_within_their_bounds() {
    let Held { puppet, clip, .. } = held("14_37", 0.7, 1.0);
    let s = clip.skeleton.clone();
    let guard = Guard::new(&puppet, &[], G);
    let before = guard.before(&clip);
    let all = Bounds { speed: 1e9, acceleration: 1e9, ..Bounds::REFINE };
    let grow = |i: usize| smoothstep(i as f64 / clip.frames() as f64);
    let knee = s.v_at(s.link("LeftLeg").unwrap());
    let after = moved(&moved(&clip, knee, |i| 2.5 * grow(i)), 0, grow);
    let held = guard.hold(Step::Refine, (&clip, &before), after, &all);
    let (bound, root) = (all.joint_rad, all.root_share * guard.stature_m());
    let turned = held.report.joint.as_ref().unwrap();
    println!("{turned:?}, root {} of {root}", held.report.root_m);
    assert!(turned.rad < bound + 1e-9 && turned.rad > 0.98 * bound && turned.link == "LeftLeg", "{turned:?}");
    assert!(held.report.root_m < root + 1e-9 && held.report.root_m > 0.98 * root && held.report.at_bound());
    let little = moved(&clip, knee, |i| 0.5 * bound * grow(i));
    let kept = guard.hold(Step::Refine, (&clip, &before), little.clone(), &all);
    assert!(kept.clip == little && !kept.report.at_bound());
}

/// A contact that the body cannot keep gives way and is named; the others hold, and nothing pops. (Held all the same, the legs
/// reach for the ground from half a metre above.)
#[test]
fn a_contact_out_of_reach_gives_way_and_is_named() {
    let (performer, human) = mocap("14_37");
    let puppet = puppet(scaled(&performer.character, 0.7, 1.0));
    let own = same_angles(&human, &puppet.character, 0.7);
    let stands = (0..own.frames()).flat_map(|_| own.pose(0).to_vec()).collect();
    let stands = Clip::new(own.skeleton.clone(), own.rate_hz, stands);
    let middle = 0.5 * stands.duration_s();
    let up = |i: usize| {
        let t = i as f64 / own.rate_hz - middle;
        0.5 * smoothstep(((0.35 - t.abs()) / 0.3).clamp(0.0, 1.0))
    };
    let clip = moved(&stands, 1, up);
    let sites = puppet.character.skeleton.sites();
    let whole = |c: &retarget::ContactPoint| Phase {
        point: sites[c.site].name.clone(),
        from_s: 0.0,
        to_s: clip.duration_s(),
    };
    let given: Vec<Phase> = puppet.contacts.iter().map(whole).collect();
    let options = ContactOptions { phases: Some(given.clone()), ..ContactOptions::default() };
    let guard = Guard::new(&puppet, &[own.pose(0).to_vec()], G);
    let before = guard.before(&clip);
    let kept = keep(&puppet, (&clip, &before), &given, &options, &guard, &|_, _| Ok(())).unwrap();
    let bounds = Bounds::CONTACT;
    println!("{:?}\n{:?}", kept.step, kept.gave_way);
    assert!(kept.step.speed <= bounds.speed && kept.step.acceleration <= bounds.acceleration);
    assert!(kept.gave_way.iter().any(|p| p.from_s < middle && middle < p.to_s), "{:?}", kept.gave_way);
    assert!(kept.phases.iter().all(|p| p.to_s < middle || p.from_s > middle), "{:?}", kept.phases);
    // before and after it the feet stand
    for c in &puppet.contacts {
        let name = &sites[c.site].name;
        let stood: f64 = kept.phases.iter().filter(|p| p.point == *name).map(|p| p.to_s - p.from_s).sum();
        assert!(stood > clip.duration_s() - 2.5, "{name} stood for {stood} s");
    }
    assert!(kept.report.slip_m < 0.02, "{:?}", kept.report);
    let spans = phases::frames_of_phases(&puppet, &kept.phases, &kept.clip).unwrap();
    assert_eq!(spans.len(), puppet.contacts.len());
}

/// A standing jump is a flight; a walk and a cartwheel have none, and standing half a metre above the ground is none either.
#[test]
fn flights_are_what_falls() {
    let found = |name: &str, above_m: f64| {
        let (performer, mut human) = mocap(name);
        let s = human.skeleton.clone();
        for i in 0..human.frames() {
            let p = s.position(human.pose(i), 0) + Vec3::y() * above_m;
            s.set_position(human.pose_mut(i), 0, &p);
        }
        let puppet = puppet(scaled(&performer.character, 0.5, 1.0));
        flights::find(&performer, &human, &puppet, &ContactOptions::default(), G)
    };
    let jump = found("16_02", 0.0);
    assert_eq!(jump.len(), 1, "{jump:?}");
    // 0.25 m at half size; 0.43 s
    assert!((0.08..0.2).contains(&jump[0].scaled_m), "{jump:?}");
    let frames = jump[0].frames.last - jump[0].frames.first;
    assert!((10..20).contains(&frames), "{jump:?}");
    for (name, above_m) in [("16_21", 0.0), ("49_07", 0.0), ("14_37", 0.5), ("16_21", 0.5)] {
        let none = found(name, above_m);
        assert!(none.is_empty(), "{name}: {none:?}");
    }
}

/// A flight that a stage has flattened, or blown up, gets its height back; nothing else moves.
#[test]
fn flights_get_their_heights_back() {
    let (performer, human) = mocap("16_02");
    let puppet = puppet(scaled(&performer.character, 0.7, 1.0));
    let own = same_angles(&human, &puppet.character, 0.7);
    let found = flights::find(&performer, &human, &puppet, &ContactOptions::default(), G);
    let was = flights::heights(&puppet, &own, &found);
    let (first, last) = (found[0].frames.first, found[0].frames.last);
    for share in [-0.9, -0.5, 0.8] {
        let bump = |i: usize| {
            let s = (i as f64 - first as f64) / (last - first) as f64;
            if (0.0..=1.0).contains(&s) { share * was[0] * (4.0 * s * (1.0 - s)).powi(2) } else { 0.0 }
        };
        let mut clip = moved(&own, 1, bump);
        let changed = clip.clone();
        flights::keep(&puppet, &mut clip, &found, &was, &[]);
        let height = flights::heights(&puppet, &clip, &found)[0] / was[0];
        println!("{share}: {height:.2}");
        assert!((flights::KEPT..=2.0 - flights::KEPT).contains(&height), "{share}: {height}");
        for (i, off) in apart(&changed, &clip).iter().enumerate() {
            assert!((first..=last).contains(&i) || *off < 1e-12, "{i}");
        }
    }
}
