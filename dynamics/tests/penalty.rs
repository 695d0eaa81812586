//! Laws of the penalty contact: gradients, limits, friction cone, adhesion, what it can supply.

use std::f64::consts::TAU;

use dynamics::penalty::{DAMPING_RATIO, Penalty, Pull, contact_forces};
use dynamics::{Model, State, total_wrench};
use motion::Vec3;

/// Repeatable numbers in (−1, 1) without a random-number crate: a Weyl sequence.
struct Numbers(f64);
impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = (self.0 + 0.618_033_988_749_894_9) % 1.0;
        (self.0 * 977.0).sin()
    }
    fn pair(&mut self, scale: f64) -> [f64; 2] {
        [scale * self.next(), scale * self.next()]
    }
}

fn presets() -> [(&'static str, Penalty); 2] {
    [("paper", Penalty::paper()), ("ours", Penalty::for_body(75.0, 9.81, 8, 0.0015).unwrap())]
}

/// Analytic gradients against central differences, with Richardson's extrapolation; relative to the column
/// or, where it vanishes, to the stiffness or damping of its kind. 1e-8 seen.
#[test]
fn gradients_are_the_slopes() {
    for (name, p) in presets() {
        let mut r = Numbers(0.2);
        for i in 0..2000 {
            // heights on both sides of 0, from 0.1 mm to 30 mm
            let z = 0.0301f64.powf(1.0 + 0.6 * (1.0 + r.next()) / 2.0) * r.next().signum();
            let zd = r.next();
            // slips at every scale: from sticking to sliding
            let scale = 10f64.powi(-(i % 7));
            let (slip, rate) = (r.pair(0.01 * scale), r.pair(scale));
            let g = p.force_gradient(z, zd, slip, rate);
            assert_eq!(g.force, p.force(z, zd, slip, rate));
            let at = |x: [f64; 6]| p.force(x[0], x[1], [x[2], x[3]], [x[4], x[5]]);
            let x = [z, zd, slip[0], slip[1], rate[0], rate[1]];
            let columns = [
                g.d_z,
                g.d_zd,
                g.d_slip.column(0).into_owned(),
                g.d_slip.column(1).into_owned(),
                g.d_rate.column(0).into_owned(),
                g.d_rate.column(1).into_owned(),
            ];
            let steps =
                [1e-7, 1e-4, 2e-4 * scale.max(1e-4), 2e-4 * scale.max(1e-4), 2e-5 * scale, 2e-5 * scale];
            // the size a derivative of this kind takes: stiffness or damping
            let sizes =
                [p.k_p, p.k_d, p.k_p.max(p.k_tp), p.k_p.max(p.k_tp), p.k_d.max(p.k_td), p.k_d.max(p.k_td)];
            for k in 0..6 {
                let slope = |h: f64| {
                    let (mut a, mut b) = (x, x);
                    a[k] -= h;
                    b[k] += h;
                    (at(b) - at(a)) / (2.0 * h)
                };
                let h = steps[k] * 1e-1;
                let refined = (slope(0.5 * h) * 4.0 - slope(h)) / 3.0;
                let error = (refined - columns[k]).norm() / columns[k].norm().max(sizes[k]);
                assert!(error < 1e-6, "{name}, component {k} at {x:?}: {refined} {}", columns[k]);
            }
        }
    }
}

/// Still: nothing far above, −k_P z deep inside, `f_0` at the ground, and the residue falls as f_0²/(k_P z).
#[test]
fn limits_of_the_spring() {
    for (name, p) in presets() {
        for z in [1.0, 1e3, 1e6] {
            let up = p.normal(z, 0.0);
            let residue = p.f_0 * p.f_0 / (p.k_p * z);
            assert!(up >= 0.0 && up <= residue * (1.0 + 1e-6), "{name} {up}");
            if p.pull == Pull::AsPrinted {
                assert!((up - residue).abs() < 1e-6 * residue, "{name}: {up} {residue}"); // 1e-8 seen
            }
            let down = p.normal(-z, 0.0) / (p.k_p * z) - 1.0;
            assert!((0.0..1e-6).contains(&down), "{name}: {down}");
        }
        assert!((p.normal(0.0, 0.0) - p.f_0).abs() < 1e-12 * p.f_0);
    }
}

/// A standing body sinks as stated, on every number of points; small bobbing has the stated damping.
#[test]
fn a_standing_body_sinks_as_stated() {
    for (mass, points, sink) in [(75.0, 8, 0.0015), (0.4, 3, 0.001), (2000.0, 64, 0.002)] {
        let p = Penalty::for_body(mass, 9.81, points, sink).unwrap();
        let share = mass * 9.81 / points as f64;
        assert!((p.normal(-sink, 0.0) - share).abs() < 1e-12 * share);
        assert!((p.rest_height(share) + sink).abs() < 1e-12 * sink);
        let (_, slope, damping) = p.normal_gradient(-sink, 0.0);
        let n = points as f64;
        let ratio = -n * damping / (2.0 * (mass * n * -slope).sqrt());
        assert!((ratio - DAMPING_RATIO).abs() < 1e-12);
    }
    // the paper's values under 75 kg on 8 points: 9 mm
    let sink = -Penalty::paper().rest_height(75.0 * 9.81 / 8.0);
    assert!((sink - 0.0092).abs() < 1e-4, "{sink}");
    // loads inside the clamp are inverted as well
    for (name, p) in presets() {
        for load in [0.01, 0.3, 0.999, 1.001, 20.0].map(|x| x * p.f_0) {
            let back = p.normal(p.rest_height(load), 0.0);
            assert!((back - load).abs() < 1e-12 * p.k_p.max(load), "{name}: {load} {back}");
        }
    }
}

/// Dropped from rest height plus a little, a body comes back to it: energy only leaves.
#[test]
fn a_bobbing_body_comes_to_rest() {
    let (mass, n, sink) = (75.0, 8, 0.0015);
    let p = Penalty::for_body(mass, 9.81, n, sink).unwrap();
    let (mut z, mut zd, dt) = (0.01, 0.0, 1e-5);
    for _ in 0..100_000 {
        zd += dt * (n as f64 * p.normal(z, zd) / mass - 9.81);
        z += dt * zd;
    }
    assert!((z + sink).abs() < 1e-9 && zd.abs() < 1e-9, "{z} {zd}");
}

/// Friction never exceeds μ f_n, opposes slip, and saturates at it.
#[test]
fn friction_stays_in_the_cone() {
    for (name, p) in presets() {
        let mut r = Numbers(0.6);
        for i in 0..5000 {
            let scale = 10f64.powi(i % 9 - 6);
            let (z, zd) = (0.02 * r.next(), 3.0 * r.next());
            let (slip, rate) = (r.pair(scale), r.pair(scale));
            let f = p.force(z, zd, slip, rate);
            let tangential = f.x.hypot(f.z);
            assert!(tangential <= p.mu * f.y.abs() * (1.0 + 1e-15), "{name}: {f}");
            if p.pull != Pull::AsPrinted {
                assert!(f.y >= 0.0);
                let drive = -(p.k_tp * slip[0] + p.k_td * rate[0]) * f.x
                    - (p.k_tp * slip[1] + p.k_td * rate[1]) * f.z;
                assert!(drive >= 0.0, "{name}: friction along its own pull, {drive}");
            }
        }
        let f = p.force(-0.002, 0.0, [0.0; 2], [30.0, 40.0]);
        assert!((f.xz().norm() - p.mu * f.y).abs() < 1e-9 * f.y, "{name}: {f}");
        assert!((f.x / f.z - 0.75).abs() < 1e-12);
    }
}

/// As printed the ground pulls on a point that leaves fast; ours never does, and has no slope there.
#[test]
fn only_the_paper_adheres() {
    let (paper, ours) = (Penalty::paper(), presets()[1].1);
    assert!(paper.normal(0.0, 10.0) < 0.0);
    let mut r = Numbers(0.1);
    for _ in 0..5000 {
        let (z, zd) = (0.05 * r.next(), 20.0 * r.next());
        assert!(ours.normal(z, zd) >= 0.0, "{z} {zd}");
    }
    let g = ours.force_gradient(-0.001, 20.0, [1e-3, 0.0], [0.1, 0.2]);
    assert_eq!(g.force, Vec3::zeros());
    assert_eq!((g.d_z, g.d_zd), (Vec3::zeros(), Vec3::zeros()));
    assert_eq!(g.d_rate.norm() + g.d_slip.norm(), 0.0);
}

/// The clamp joins without a step in value, slope or curvature at both of its ends.
#[test]
fn the_clamp_is_smooth() {
    let p = presets()[1].1;
    let Pull::Never { width_n } = p.pull else { unreachable!() };
    // at a depth, the climb that makes the raw force `f`
    let z = -0.0005;
    let rest = p.normal(z, 0.0);
    let slope_zd = p.normal_gradient(z, 0.0).2;
    let at = |f: f64| p.normal_gradient(z, (f - rest) / slope_zd);
    for end in [0.0, width_n] {
        let e = 1e-5 * width_n;
        let (a, b) = (at(end - e), at(end + e));
        assert!((b.0 - a.0).abs() < 3.0 * e);
        assert!((b.2 - a.2).abs() < 1e-6 * slope_zd.abs(), "{end}: {} {}", a.2, b.2);
    }
    assert_eq!(at(2.0 * width_n).2, slope_zd);
}

/// h is k_t (1 − k_t x/2 + …) down to zero, without a step at ε and without loss of digits.
#[test]
fn friction_is_steep_but_whole_near_zero() {
    for (name, p) in presets() {
        assert_eq!(p.h(0.0), p.k_t);
        for (x, y) in
            [1e-12, 1e-9, 0.999_999, 1.000_001, 1e2, 1e3].map(|x| (x * p.epsilon, x * p.epsilon * p.k_t))
        {
            let series = p.k_t * (1.0 - y / 2.0 + y * y / 6.0 - y * y * y / 24.0 + y.powi(4) / 120.0);
            let tolerance = 4e-16 + y.powi(5) / 700.0;
            assert!((p.h(x) / series - 1.0).abs() < tolerance, "{name} {x}: {} {series}", p.h(x));
        }
        assert!((p.h(1e9) * 1e9 - 1.0).abs() < 1e-12);
    }
}

/// The damper's onset is ½ at the ground from both sides, with one slope.
#[test]
fn the_onset_is_continuous() {
    for (name, p) in presets() {
        let e = 1e-9 / p.k;
        assert_eq!(p.onset(0.0), 0.5);
        assert!((p.onset(-e) - p.onset(e) - p.k * e).abs() < 1e-15, "{name}");
        assert!((p.onset(-100.0 / p.k) - 1.0).abs() < 1e-15 && p.onset(100.0 / p.k) < 1e-40);
        let (below, above) = (p.normal_gradient(-e, -0.3), p.normal_gradient(e, -0.3));
        assert!((below.1 - above.1).abs() < 1e-6 * p.k_p);
    }
}

/// Nonsense is refused by name.
#[test]
fn impossible_bodies_are_refused() {
    for (mass, gravity, n, sink, word) in [
        (0.0, 9.81, 4, 0.001, "mass"),
        (f64::NAN, 9.81, 4, 0.001, "mass"),
        (75.0, -9.81, 4, 0.001, "gravity"),
        (75.0, 9.81, 0, 0.001, "contact points"),
        (75.0, 9.81, 4, 0.0, "depth"),
    ] {
        let error = Penalty::for_body(mass, gravity, n, sink).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
}

/// Of six components, contacts that do not slip give three when `k_tP = 0`, and six with anchors.
#[test]
fn pinned_contacts_give_vertical_force_pitch_and_roll() {
    let (character, _) = bodies::anthropometry::human::human();
    let model = Model::new(&character, Vec3::new(0.0, -9.81, 0.0));
    let mut state = State::new(&model);
    let mut q = character.rest.clone();
    q[0] += 0.3; // off the origin: moments about it are not zero by symmetry
    let skeleton = &model.skeleton;
    let mut v = vec![0.0; model.nv()];
    v[1] = -0.05; // the whole body sinks: feet move, but do not slip
    state.update(&model, &q, &v);
    let site = |c: &usize| &skeleton.sites()[*c];
    let height = |c: &usize| state.point(&model, site(c).link, &site(c).at).y;
    let lowest = character.contacts.iter().map(height).fold(f64::INFINITY, f64::min);
    let ground = lowest + 0.001;
    let n = character.contacts.len();
    let own = Penalty::for_body(model.mass, 9.81, n, 0.0015).unwrap();
    let about = Vec3::new(0.1, 0.9, -0.2);
    for penalty in [Penalty::paper(), Penalty { k_tp: 0.0, ..own }] {
        let anchors = vec![[0.0, 0.0]; n]; // metres away: without k_tP they do nothing
        let mut wrenches = Vec::new();
        contact_forces(&penalty, &model, &state, &character.contacts, ground, &anchors, &mut wrenches);
        assert_eq!(wrenches.len(), n);
        let (f, m) = total_wrench(&wrenches, &about);
        assert!(f.y > 1.0 && m.x.abs() > 1e-3 && m.z.abs() > 1.0, "{f} {m}");
        assert_eq!((f.x, f.z), (0.0, 0.0));
        assert_eq!(m.y, 0.0);
    }
    // anchors a millimetre off, turned about the vertical: horizontal force and yaw appear
    let anchors: Vec<_> = (character.contacts.iter())
        .enumerate()
        .map(|(i, c)| {
            let p = state.point(&model, site(c).link, &site(c).at);
            let turn = TAU * i as f64 / (3.0 * n as f64);
            [p.x + 0.001 * turn.cos(), p.z + 0.001 * turn.sin()]
        })
        .collect();
    let mut wrenches = Vec::new();
    contact_forces(&own, &model, &state, &character.contacts, ground, &anchors, &mut wrenches);
    let (f, m) = total_wrench(&wrenches, &about);
    assert!(f.x.abs() > 1.0 && f.z.abs() > 1.0 && m.y.abs() > 0.1, "{f} {m}");
}
