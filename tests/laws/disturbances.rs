//! Disturbances of a scene, by the laws they must keep: slopes, carried masses, pushes; and falls as outcomes.

use controllers::LegTension;
use dynamics::fall::Margin;
use dynamics::{RootMode, Trace};
use motion::Vec3;
use motion::skeleton::vec_at;
use takes::{Ask, Engines, Input, Outcome, Take};

const G: f64 = 9.81;

/// A standing human with these fields in its scene.
fn scene(fields: &str) -> Take {
    let ron = format!("Scene(character: \"characters/human.ron\", rate_hz: 60, {fields})");
    takes::open(Input::Text { ron, base: support::root().join("scenes") }, &Ask::default())
        .unwrap_or_else(|e| panic!("{e}"))
}

fn perform(take: &Take) -> Outcome {
    let out = take.outcome(&Engines::default(), &mut |_| {}).unwrap();
    assert!(out.diverged.is_none(), "{:?}", out.diverged);
    assert_eq!(out.trace.root, RootMode::Free);
    out
}

/// Mean of a quantity over the last half second.
fn at_the_end(t: &Trace, of: impl Fn(usize) -> Vec3) -> Vec3 {
    let n = (0.5 * t.rate_hz) as usize;
    (t.rows() - n..t.rows()).map(of).sum::<Vec3>() / n as f64
}

/// A person on a slope stands on m g: the tangential part is m g sin α, the normal one m g cos α.
#[test]
fn slow_a_person_stands_on_a_slope() {
    for towards in [0.0, 90.0, 180.0] {
        let world = format!("world: (ground: Plane(friction: 0.8, tilt_deg: 5, towards_deg: {towards}))");
        let take = scene(&format!("settle_s: 3, {world}"));
        let out = perform(&take);
        assert!(out.fall.is_none(), "{towards}°: {:?}", out.fall);
        let t = &out.trace;
        let (weight, up) = (take.body.character.mass() * G, t.ground_up(0));
        let sums = t.contact_sums();
        let force = at_the_end(t, |row| sums[row]);
        let normal = force.dot(&up);
        let tangential = (force - up * normal).norm();
        let tilt = 5f64.to_radians();
        let errors = [
            (force - Vec3::y() * weight).norm() / weight,
            (normal / (weight * tilt.cos()) - 1.0).abs(),
            (tangential / (weight * tilt.sin()) - 1.0).abs(),
        ];
        println!("{towards}°: {errors:?}");
        // 2e-7, 3e-8, 2e-6 seen
        assert!(errors[0] < 1e-3 && errors[1] < 1e-3 && errors[2] < 1e-2, "{towards}°: {errors:?}");
        // flat on the slope, and no corner of a sole leaves its place
        let sites = take.body.character.contacts.iter().map(|&i| &take.body.character.skeleton.sites()[i]);
        for s in sites {
            let k = motion::Kinematics::new(&take.body.character.skeleton, t.pose(t.rows() - 1));
            assert!(t.height(0, &k.point(s.link, &s.at)).abs() < 1e-3, "{towards}° {}", s.name);
        }
    }
}

/// Ground that tilts under a person who is not told: soles ride on it, shins stay upright, and the verdict is to stand.
#[test]
fn slow_a_person_stands_on_a_seesaw() {
    for (towards, tilt) in [(0.0, 5.0), (180.0, 5.0), (90.0, 4.0), (-40.0, 5.0)] {
        let take = scene(&format!(
            "settle_s: 5, world: (ground: Plane(friction: 0.8, tilts: [
                Tilt(start_s: 0.5, duration_s: 1.2, tilt_deg: {tilt}, towards_deg: {towards}),
                Tilt(start_s: 2.2, duration_s: 1.2)]))"
        ));
        let out = perform(&take);
        assert!(out.fall.is_none(), "{towards}°: {:?}", out.fall);
        let t = &out.trace;
        assert!(t.ground_turns());
        let steep = t.disturbed.ground_up.iter().map(|up| up.y.acos().to_degrees()).fold(0.0, f64::max);
        assert!((steep - tilt).abs() < 1e-6, "{steep}");
        let c = &take.body.character;
        let sites: Vec<_> = c.contacts.iter().map(|&i| &c.skeleton.sites()[i]).collect();
        let at = |row: usize| motion::Kinematics::new(&c.skeleton, t.pose(row));
        let home = at(0);
        let (mut off, mut over, mut leaning): (f64, f64, f64) = (0.0, 0.0, 0.0);
        for row in (0..t.rows()).step_by(8) {
            let k = at(row);
            for s in &sites {
                let p = k.point(s.link, &s.at);
                off = off.max((t.unturned(row, &p) - home.point(s.link, &s.at)).norm());
                over = over.max(t.height(row, &p).abs());
            }
            let chest = c.skeleton.link("chest").unwrap();
            let turned = k.world[chest].rotation * home.world[chest].rotation.inverse();
            leaning = leaning.max(turned.angle().to_degrees());
        }
        println!("{towards}°: {:.2} mm, {:.3} mm, {leaning:.2}°", 1e3 * off, 1e3 * over);
        assert!(off < 2e-3 && over < 1e-3, "{towards}°: {off} {over}");
        assert!(leaning < 3.0, "{towards}°: {leaning}°");
        assert!(unexplained(t) < 1e-3);
    }
}

/// Statics of a load that the controller does not know of: the centre of pressure is under the common centre of
/// mass, away from the body's own by m (x − c)/(M + m).
#[test]
fn slow_a_carried_mass_moves_the_pressure() {
    let take = scene(
        "settle_s: 5, carried: [Carried(link: \"chest\", mass_kg: 6, at_m: (0.1, 0.1, 0.2), from_s: 0.5, known: false)]",
    );
    let out = perform(&take);
    assert!(out.fall.is_none(), "{:?}", out.fall);
    let t = &out.trace;
    let (mass, load) = (take.body.character.mass(), 6.0);
    let links = take.body.character.bodies.len();
    let body = at_the_end(t, |row| {
        let part = |l: usize| vec_at(&t.link_com, 3 * (row * links + l)) * take.body.character.bodies[l].mass;
        (0..links).map(part).sum::<Vec3>() / mass
    });
    let crate_at = at_the_end(t, |row| vec_at(&t.disturbed.carried_com, 3 * row));
    let pressure = at_the_end(t, |row| t.cop(row).unwrap());
    let expected = (crate_at - body) * (load / (mass + load));
    let shift = pressure - body;
    println!("{:?} mm, statics {:?} mm", shift * 1e3, expected * 1e3);
    assert!(expected.z > 0.005 && expected.x > 0.003, "{expected:?}");
    assert!((shift - expected).xz().norm() < 1e-3, "{shift:?} {expected:?}"); // 0.05 mm seen
    let sums = t.contact_sums();
    let weight = at_the_end(t, |row| sums[row]).y / ((mass + load) * G);
    assert!((weight - 1.0).abs() < 1e-3, "{weight}");
}

/// RMS and peak of what neither gravity, contacts, pushes nor hands explain, over body weight.
fn unexplained(t: &Trace) -> f64 {
    let residual = t.residual();
    let square: f64 = residual.chunks_exact(6).map(|w| w[0] * w[0] + w[1] * w[1] + w[2] * w[2]).sum();
    (square / t.rows() as f64).sqrt() / (t.character.mass() * G)
}

/// Momentum changes by what is on record and nothing else, through a push, a crate that comes and goes, and a slope.
#[test]
fn momentum_is_explained_through_every_disturbance() {
    let take = scene(
        "settle_s: 3, world: (ground: Plane(friction: 0.8, tilt_deg: 3, towards_deg: 30)),
        pushes: [Push(link: \"chest\", impulse_ns: 12, towards_deg: 200, start_s: 0.8)],
        carried: [Carried(link: \"wrist_r\", mass_kg: 5, at_m: (0, -0.2, 0), from_s: 1, to_s: 2, known: false),
                  Carried(link: \"pelvis\", mass_kg: 2, at_m: (0, 0, 0.1), from_s: 1.2)]",
    );
    let out = perform(&take);
    assert!(out.fall.is_none(), "{:?}", out.fall);
    let explained = unexplained(&out.trace);
    println!("{explained:.1e} of body weight");
    assert!(explained < 1e-3, "{explained}"); // 3e-4 seen
    // without the record of the push it is not; nor without the weight of the crate
    let mut bare = out.trace.clone();
    bare.disturbed.wrench.clear();
    assert!(unexplained(&bare) > 0.01, "{}", unexplained(&bare));
    let mut light = out.trace.clone();
    light.disturbed.carried.clear();
    assert!(unexplained(&light) > 0.01, "{}", unexplained(&light));
}

/// A load that is known of is held where a surprise sags: shoulder and elbow hardly move (0.00° seen against 51°).
#[test]
fn slow_a_known_load_is_held() {
    let moved = |known: bool| {
        let take = scene(&format!(
            "settle_s: 2, carried: [Carried(link: \"wrist_r\", mass_kg: 5, at_m: (0, -0.2, 0.05), from_s: 0.5, known: {known})]"
        ));
        let out = perform(&take);
        let errors = motion::metrics::joint_errors(&out.trace.clip(), &out.trace.target_clip());
        errors.iter().map(|e| e.peak_deg).fold(0.0, f64::max)
    };
    let (known, surprise) = (moved(true), moved(false));
    println!("{known:.2}° known, {surprise:.2}° not");
    assert!(known < 1.0, "{known}");
    assert!(surprise > 5.0 * known.max(0.1), "{surprise} {known}");
}

/// Falls are told with their story: what was lost, in order of time, before the fall.
#[test]
fn slow_a_fall_has_a_cause() {
    let pushed = |ns: f64, towards: f64| {
        perform(&scene(&format!(
            "settle_s: 3, pushes: [Push(link: \"pelvis\", impulse_ns: {ns}, towards_deg: {towards}, start_s: 0.5)]"
        )))
    };
    for towards in [0.0, 90.0, 180.0] {
        let out = pushed(70.0, towards);
        let fall = out.fall.unwrap_or_else(|| panic!("{towards}° stands"));
        println!("{towards}°: {fall}; {:?}", fall.losses);
        assert_eq!(Some(fall.time_s), out.fell_s);
        let cause = fall.cause().unwrap();
        assert_eq!(cause.margin, Margin::CapturePoint, "{towards}°");
        // the push lasts from 0.5 to 0.6 s
        assert!(cause.time_s > 0.5 && cause.time_s < 0.7, "{towards}°: {cause}");
        assert!(fall.losses.windows(2).all(|w| w[0].time_s <= w[1].time_s));
        assert!(fall.losses.iter().all(|l| l.time_s <= fall.time_s));
        assert!(fall.losses.iter().any(|l| l.margin == Margin::CenterOfMass), "{:?}", fall.losses);
        assert_eq!(dynamics::fall::of(&out.trace), Some(fall));
    }
    let stands = pushed(15.0, 45.0);
    assert_eq!((stands.fall, dynamics::fall::of(&stands.trace)), (None, None));
}

/// Tension of stance legs is kept where legs stand; what was asked and what is used are told.
#[test]
fn the_legs_say_what_tension_they_use() {
    let of = |tension: f64| {
        let take = scene(&format!("settle_s: 0.2, physics: (tension: {tension})"));
        (perform(&take).leg_tension, take)
    };
    for (asked, used) in [(0.25, 0.6), (4.0, 2.0)] {
        let (told, take) = of(asked);
        let legs: Vec<usize> = take.body.character.legs().flat_map(|l| [l.upper, l.lower, l.end]).collect();
        assert_eq!(told.len(), legs.len());
        for LegTension { link, asked: a, used: u, natural } in told {
            assert!(legs.contains(&link) && natural > 0.0);
            assert_eq!((a, u), (asked, used));
        }
    }
    assert_eq!(of(1.0).0, []);
}
