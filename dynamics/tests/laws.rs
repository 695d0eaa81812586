//! Laws of inverse dynamics on a tree that has every joint type, turned zero frames and a weld.

use std::sync::Arc;

use bodies::{Body, Character, JointClass};
use dynamics::{ForwardDynamics, InverseDerivatives, Model, State, Wrench};
use motion::rotation::exp;
use motion::{Joint, Link, Skeleton, Vec3};
use nalgebra::{DMatrix, DVector, Matrix3, Translation3};

/// Repeatable numbers in (−1, 1) without a random-number crate: a Weyl sequence.
struct Numbers(f64);
impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = (self.0 + 0.618_033_988_749_894_9) % 1.0;
        (self.0 * 977.0).sin()
    }
    fn vec(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
}

fn tree() -> Character {
    tree_on(Joint::Free)
}

/// The tree with a root that moves as `root` does.
fn tree_on(root: Joint) -> Character {
    let mut r = Numbers(0.3);
    let joints = [
        (None, root),
        (Some(0), Joint::Spherical),
        (Some(1), Joint::Revolute(Vec3::new(0.6, 0.0, 0.8))),
        (Some(0), Joint::Prismatic(Vec3::new(0.0, 0.8, -0.6))),
        (Some(3), Joint::Fixed),
        (Some(4), Joint::Spherical),
        (Some(2), Joint::Revolute(Vec3::x())),
        (Some(5), Joint::Free),
    ];
    let mut links = Vec::new();
    let mut bodies = Vec::new();
    for (i, (parent, joint)) in joints.into_iter().enumerate() {
        let mut link = Link::new(format!("link{i}"), parent, r.vec() * 0.4, joint);
        link.parent_from_zero.rotation = exp(&r.vec());
        link.parent_from_zero.translation = Translation3::from(r.vec() * 0.4);
        links.push(link);
        let turn = exp(&r.vec()).to_rotation_matrix();
        let diagonal = Matrix3::from_diagonal(&Vec3::new(0.02, 0.03, 0.04));
        bodies.push(Body {
            mass: 1.5 + r.next(),
            com: r.vec() * 0.2,
            inertia: turn.matrix() * diagonal * turn.matrix().transpose(),
            shapes: vec![],
        });
    }
    let skeleton = Arc::new(Skeleton::new(links).unwrap());
    Character {
        name: "tree".into(),
        classes: vec![JointClass::Other; bodies.len()],
        rest: skeleton.zero_pose(),
        skeleton,
        bodies,
        contacts: vec![],
    }
    .check()
    .unwrap()
}

struct Case {
    model: Model,
    q: Vec<f64>,
    v: Vec<f64>,
    vd: Vec<f64>,
}

fn cases() -> Vec<Case> {
    cases_of(&tree(), 20)
}

/// The tree on roots of every kind, and the human, whose root's zero frame is the world's.
fn all_cases() -> Vec<Case> {
    let slide = Joint::Prismatic(Vec3::new(0.0, 0.6, 0.8));
    let mut cases = cases();
    for root in [Joint::Fixed, slide, Joint::Revolute(Vec3::z()), Joint::Spherical] {
        cases.extend(cases_of(&tree_on(root), 4));
    }
    cases.extend(cases_of(&bodies::anthropometry::human::human().0, 4));
    cases
}

fn cases_of(character: &Character, count: usize) -> Vec<Case> {
    let model = Model::new(character, Vec3::new(0.3, -9.81, 0.2));
    let mut r = Numbers(0.7);
    (0..count)
        .map(|_| {
            let mut q = character.skeleton.zero_pose();
            let turn: Vec<f64> = (0..model.nv()).map(|_| 2.0 * r.next()).collect();
            character.skeleton.integrate(&mut q, &turn, 1.0);
            let v = (0..model.nv()).map(|_| 5.0 * r.next()).collect();
            let vd = (0..model.nv()).map(|_| 50.0 * r.next()).collect();
            Case { model: model.clone(), q, v, vd }
        })
        .collect()
}

fn inverse(c: &Case, q: &[f64], v: &[f64], vd: &[f64], w: &[Wrench]) -> DVector<f64> {
    let mut state = State::new(&c.model);
    state.update(&c.model, q, v);
    let mut tau = vec![0.0; c.model.nv()];
    state.inverse_dynamics(&c.model, v, vd, w, &mut tau);
    DVector::from_vec(tau)
}

fn mass(c: &Case) -> DMatrix<f64> {
    let mut state = State::new(&c.model);
    state.update(&c.model, &c.q, &c.v);
    let mut m = DMatrix::zeros(c.model.nv(), c.model.nv());
    state.mass_matrix(&c.model, &mut m);
    m
}

/// A weld is one body: eight links, seven bodies, the same total mass.
#[test]
fn welds_are_fused() {
    let character = tree();
    let model = Model::new(&character, Vec3::zeros());
    assert_eq!(model.bodies.len(), 7);
    assert!((model.mass - character.mass()).abs() < 1e-12);
}

/// Columns of M are inverse dynamics of unit accelerations: two algorithms, one matrix.
#[test]
fn mass_matrix_is_inverse_dynamics_of_unit_accelerations() {
    for c in all_cases() {
        let m = mass(&c);
        let n = c.model.nv();
        let zero = vec![0.0; n];
        let bias = inverse(&c, &c.q, &zero, &zero, &[]);
        for k in 0..n {
            let mut unit = zero.clone();
            unit[k] = 1.0;
            let column = inverse(&c, &c.q, &zero, &unit, &[]) - &bias;
            assert!((column - m.column(k)).norm() <= 1e-12 * m.norm()); // 1e-15 seen
        }
        assert!(m.cholesky().is_some(), "positive definite");
    }
}

/// The state `h` seconds along the motion of a case.
fn along(c: &Case, h: f64) -> State {
    let mut q = c.q.clone();
    // second-order step: q(h) = q ⊕ (v + v̇ h/2) h; a ball's frame is fixed, so this is exact to h²
    let mid: Vec<f64> = c.v.iter().zip(&c.vd).map(|(v, a)| v + 0.5 * a * h).collect();
    c.model.skeleton.integrate(&mut q, &mid, h);
    let v: Vec<f64> = c.v.iter().zip(&c.vd).map(|(v, a)| v + a * h).collect();
    let mut state = State::new(&c.model);
    state.update(&c.model, &q, &v);
    state
}

/// Power balance: v·τ = d/dt (kinetic + potential), by central differences along the motion.
#[test]
fn work_is_the_change_of_energy() {
    let dt = 1e-5;
    for c in all_cases() {
        let tau = inverse(&c, &c.q, &c.v, &c.vd, &[]);
        let power: f64 = tau.iter().zip(&c.v).map(|(t, v)| t * v).sum();
        let energy = |h: f64| {
            let (kinetic, potential) = along(&c, h).energy(&c.model);
            kinetic + potential
        };
        let rate = (energy(dt) - energy(-dt)) / (2.0 * dt);
        assert!((rate - power).abs() < 1e-6 * power.abs().max(1e3), "{rate} {power}"); // 5e-8 seen
    }
}

/// The root wrench of inverse dynamics is the rate of momentum less gravity.
#[test]
fn root_force_is_the_rate_of_momentum() {
    let dt = 1e-5;
    for c in cases() {
        let tau = inverse(&c, &c.q, &c.v, &c.vd, &[]);
        let [a, b] = [-dt, dt].map(|h| along(&c, h).momentum(&c.model));
        let root = &c.model.bodies[0];
        let zero = root.parent_from_zero.rotation;
        let force = zero * Vec3::new(tau[0], tau[1], tau[2]);
        let rate = (b.linear - a.linear) / (2.0 * dt) - c.model.gravity * c.model.mass;
        assert!((rate - force).norm() < 1e-5 * force.norm().max(1e3), "{rate} {force}");
        let mut state = State::new(&c.model);
        state.update(&c.model, &c.q, &c.v);
        let arm = state.bodies[0].world.translation.vector - state.com(&c.model);
        let moment = zero * Vec3::new(tau[3], tau[4], tau[5]) + arm.cross(&force);
        let rate = (b.angular - a.angular) / (2.0 * dt);
        assert!((rate - moment).norm() < 1e-5 * moment.norm().max(1e3), "{rate} {moment}");
    }
}

/// Forward dynamics of inverse dynamics gives the acceleration back, and the other way round.
#[test]
fn forward_undoes_inverse() {
    for c in all_cases() {
        let mut state = State::new(&c.model);
        state.update(&c.model, &c.q, &c.v);
        let w = Wrench {
            link: 5,
            point: Vec3::new(0.3, 0.1, -0.2),
            force: Vec3::new(30.0, -20.0, 10.0),
            moment: Vec3::new(-1.0, 3.0, 2.0),
        };
        let tau = inverse(&c, &c.q, &c.v, &c.vd, &[w]);
        let mut forward = ForwardDynamics::new(&c.model);
        let mut vd = vec![0.0; c.model.nv()];
        forward.accelerations(&c.model, &mut state, &c.v, tau.as_slice(), &[w], &mut vd).unwrap();
        let given = DVector::from_vec(c.vd.clone());
        let error = (DVector::from_vec(vd) - &given).norm();
        assert!(error < 1e-11 * given.norm(), "{error}"); // 8e-13 seen
        let mut x = vec![0.0; c.model.nv()];
        forward.accelerations(&c.model, &mut state, &c.v, &c.vd, &[w], &mut x).unwrap();
        let back = inverse(&c, &c.q, &c.v, &x, &[w]);
        assert!((&back - &given).norm() < 1e-11 * tau.norm()); // 4e-14 seen
        // the sparse factor solves as a dense one does
        let mut y = c.vd.clone();
        forward.solve(&mut y);
        let dense = mass(&c).cholesky().unwrap().solve(&given);
        assert!((DVector::from_vec(y) - &dense).norm() < 1e-11 * dense.norm()); // 3e-13 seen
    }
}

/// An axis that moves nothing is named, not divided by.
#[test]
fn no_inertia_is_refused() {
    let mut model = cases().remove(0).model;
    let last = model.bodies.last_mut().unwrap();
    (last.mass, last.inertia) = (0.0, Matrix3::zeros());
    let first = last.v_at;
    let mut state = State::new(&model);
    let error = ForwardDynamics::new(&model).factor(&model, &mut state).unwrap_err();
    assert!(error.dof >= first && error.pivot == 0.0, "{error}");
}

/// The bias is Coriolis terms and gravity load, and each is what its name says.
#[test]
fn the_bias_is_coriolis_and_gravity() {
    for c in all_cases() {
        let n = c.model.nv();
        let zero = vec![0.0; n];
        let mut state = State::new(&c.model);
        state.update(&c.model, &c.q, &c.v);
        let (mut bias, mut coriolis, mut gravity) = (zero.clone(), zero.clone(), zero.clone());
        state.bias(&c.model, &c.v, &mut bias);
        state.coriolis(&c.model, &c.v, &mut coriolis);
        state.gravity_load(&c.model, &mut gravity);
        let [bias, coriolis, gravity] = [bias, coriolis, gravity].map(DVector::from_vec);
        assert_eq!(bias, inverse(&c, &c.q, &c.v, &zero, &[]));
        assert!((&bias - &coriolis - &gravity).norm() < 1e-12 * bias.norm()); // 4e-16 seen
        let still = inverse(&c, &c.q, &zero, &zero, &[]);
        assert!((&gravity - still).norm() < 1e-12 * gravity.norm());
        // twice the speed, four times the force
        let twice: Vec<f64> = c.v.iter().map(|v| 2.0 * v).collect();
        state.update(&c.model, &c.q, &twice);
        let mut four = zero.clone();
        state.coriolis(&c.model, &twice, &mut four);
        assert!((DVector::from_vec(four) - &coriolis * 4.0).norm() < 1e-12 * coriolis.norm());
        // the load is the slope of the potential, axis by axis
        let h = 1e-5;
        for k in 0..n {
            let potential = |s: f64| {
                let mut step = zero.clone();
                step[k] = s;
                let mut q = c.q.clone();
                c.model.skeleton.integrate(&mut q, &step, 1.0);
                {
                    let mut moved = State::new(&c.model);
                    moved.update_pose(&c.model, &q);
                    moved.energy(&c.model).1
                }
            };
            let slope = (potential(h) - potential(-h)) / (2.0 * h);
            assert!((slope - gravity[k]).abs() < 1e-7 * gravity.norm(), "{k}: {slope} {}", gravity[k]); // 4e-11 seen
        }
    }
}

/// Lagrange's equations with M alone give the Coriolis terms: no Newton, no Euler.
///
/// For velocities that are no rates of coordinates (Hamel), p = M v, T = vᵀ M v / 2:
/// C v = Ṁ v − ∂T/∂q + p × ω, the last within each ball or free joint's own rotation. Also
/// v·(Ṁ v) = 2 v·(C v): Coriolis forces do no work beyond the change of M.
#[test]
fn coriolis_terms_follow_from_the_mass_matrix() {
    let h = 1e-5;
    for c in all_cases() {
        let n = c.model.nv();
        let v = DVector::from_vec(c.v.clone());
        let m_at = |direction: &[f64], s: f64| {
            let mut q = c.q.clone();
            c.model.skeleton.integrate(&mut q, direction, s);
            let mut state = State::new(&c.model);
            state.update_pose(&c.model, &q);
            let mut m = DMatrix::zeros(n, n);
            state.mass_matrix(&c.model, &mut m);
            m
        };
        let mut state = State::new(&c.model);
        state.update(&c.model, &c.q, &c.v);
        let mut coriolis = vec![0.0; n];
        state.coriolis(&c.model, &c.v, &mut coriolis);
        let coriolis = DVector::from_vec(coriolis);

        let rate = (m_at(&c.v, h) - m_at(&c.v, -h)) / (2.0 * h);
        let work = v.dot(&(&rate * &v));
        assert!((work - 2.0 * v.dot(&coriolis)).abs() < 1e-7 * coriolis.norm() * v.norm()); // 2e-9 seen

        let p = m_at(&c.v, 0.0) * &v;
        let mut expected = &rate * &v;
        for k in 0..n {
            let mut unit = vec![0.0; n];
            unit[k] = 1.0;
            let slope = (m_at(&unit, h) - m_at(&unit, -h)) / (2.0 * h);
            expected[k] -= 0.5 * v.dot(&(slope * &v));
        }
        for b in &c.model.bodies {
            let at = match b.joint {
                Joint::Free => b.v_at + 3,
                Joint::Spherical => b.v_at,
                _ => continue,
            };
            let [p, w] = [&p, &v].map(|x| Vec3::new(x[at], x[at + 1], x[at + 2]));
            let turned = p.cross(&w);
            (0..3).for_each(|k| expected[at + k] += turned[k]);
        }
        let error = (&expected - &coriolis).norm() / coriolis.norm();
        assert!(error < 1e-7, "{error}"); // 8e-9 seen
    }
}

/// Rate of momentum from accelerations against differences of the momentum; about any fixed point.
#[test]
fn momentum_rate_is_the_slope_of_the_momentum() {
    let dt = 1e-5;
    for c in all_cases() {
        let mut state = State::new(&c.model);
        state.update(&c.model, &c.q, &c.v);
        let rate = state.momentum_rate(&c.model, &c.v, &c.vd);
        let [a, b] = [-dt, dt].map(|h| along(&c, h).momentum(&c.model));
        let linear = (b.linear - a.linear) / (2.0 * dt);
        let angular = (b.angular - a.angular) / (2.0 * dt);
        assert!((linear - rate.linear).norm() < 1e-6 * linear.norm(), "{linear} {}", rate.linear); // 2e-8 seen
        assert!((angular - rate.angular).norm() < 1e-6 * angular.norm().max(1e2)); // 1e-8 seen
        let point = Vec3::new(3.0, -2.0, 1.0);
        let about = (b.about(&point) - a.about(&point)) / (2.0 * dt);
        assert!((about - rate.about(&point)).norm() < 1e-6 * about.norm()); // 4e-8 seen
        let speed = state.momentum(&c.model).linear / c.model.mass;
        let moved = (b.com - a.com) / (2.0 * dt);
        assert!((speed - moved).norm() < 1e-6 * speed.norm().max(1.0));
    }
}

/// J v is the velocity of a point and J v̇ + J̇ v its acceleration, the slope of that velocity.
#[test]
fn points_move_by_their_jacobian() {
    let dt = 1e-5;
    for c in all_cases() {
        let body = c.model.bodies.len() - 1;
        let link = c.model.bodies[body].link;
        let at = |h: f64| {
            let state = along(&c, h);
            (state.point_velocity(&c.model, link, &Vec3::zeros()), state.bodies[body].omega)
        };
        let mut state = State::new(&c.model);
        state.update(&c.model, &c.q, &c.v);
        let point = state.bodies[body].origin();
        let moved = |x: &[f64]| {
            let (mut linear, mut angular) = (Vec3::zeros(), Vec3::zeros());
            state.jacobian(&c.model, body, &point, |dof, l, a| {
                linear += l * x[dof];
                angular += a * x[dof];
            });
            (linear, angular)
        };
        let (velocity, omega) = moved(&c.v);
        let now = at(0.0);
        assert!((velocity - now.0).norm() < 1e-12 * now.0.norm().max(1.0)); // 1e-14 seen
        assert!((omega - now.1).norm() < 1e-12 * now.1.norm().max(1.0));
        let (mut accel, mut alpha) = moved(&c.vd);
        state.drifts(&c.model, &c.v, |b, linear, angular| {
            if b == body {
                accel += linear;
                alpha += angular;
            }
        });
        let (a, b) = (at(-dt), at(dt));
        let slope = ((b.0 - a.0) / (2.0 * dt), (b.1 - a.1) / (2.0 * dt));
        assert!((accel - slope.0).norm() < 1e-6 * slope.0.norm().max(10.0), "{accel} {}", slope.0);
        assert!((alpha - slope.1).norm() < 1e-6 * slope.1.norm().max(10.0), "{alpha} {}", slope.1);
    }
}

/// An outside wrench enters as −Jᵀ w, and Jᵀ w does the wrench's work on any velocity.
#[test]
fn wrenches_enter_through_the_jacobian() {
    for c in all_cases() {
        let mut state = State::new(&c.model);
        state.update(&c.model, &c.q, &c.v);
        let at = Vec3::new(0.1, -0.2, 0.3);
        for link in 0..8 {
            let w = Wrench {
                link,
                point: state.point(&c.model, link, &at),
                force: Vec3::new(10.0, -20.0, 5.0),
                moment: Vec3::new(1.0, 2.0, -3.0),
            };
            let with = inverse(&c, &c.q, &c.v, &c.vd, &[w]);
            let without = inverse(&c, &c.q, &c.v, &c.vd, &[]);
            let mut jtw = vec![0.0; c.model.nv()];
            state.add_wrench(&c.model, &w, &mut jtw);
            let jtw = DVector::from_vec(jtw);
            assert!((&without - &with - &jtw).norm() < 1e-9);
            let power: f64 = jtw.iter().zip(&c.v).map(|(t, v)| t * v).sum();
            let omega = state.bodies[c.model.body_of[link].0].omega;
            let expected = w.force.dot(&state.point_velocity(&c.model, link, &at)) + w.moment.dot(&omega);
            assert!((power - expected).abs() < 1e-9);
        }
    }
}

/// ∂²V/∂q² against central differences of the gravity torque.
#[test]
fn gravity_stiffness_is_the_slope_of_the_gravity_load() {
    let h = 1e-6;
    for c in cases() {
        let n = c.model.nv();
        let mut state = State::new(&c.model);
        state.update(&c.model, &c.q, &c.v);
        let mut k = DMatrix::zeros(n, n);
        state.gravity_stiffness(&c.model, &mut k);
        let zero = vec![0.0; n];
        for l in 0..n {
            let load = |s: f64| {
                let mut step = zero.clone();
                step[l] = s;
                let mut q = c.q.clone();
                c.model.skeleton.integrate(&mut q, &step, 1.0);
                inverse(&c, &q, &zero, &zero, &[])
            };
            let slope = (load(h) - load(-h)) / (2.0 * h);
            for b in &c.model.bodies {
                for i in b.v_at..b.v_at + b.joint.nv() {
                    // a ball's own block is the symmetric part; other entries match one by one
                    let own = (b.v_at..b.v_at + b.joint.nv()).contains(&l);
                    if !own {
                        // outboard rows feel inboard turns through their turned axes as well: only
                        // the row of the inboard axis is the plain second derivative
                        if i < l {
                            assert!((slope[i] - k[(i, l)]).abs() < 1e-4, "{i} {l}");
                        }
                    } else if i == l {
                        assert!((slope[i] - k[(i, l)]).abs() < 1e-4, "{i} {l}: {} {}", slope[i], k[(i, l)]);
                    }
                }
            }
        }
    }
}

/// ∂τ/∂q, ∂τ/∂v, ∂τ/∂v̇ against central differences, with wrenches that stay in the world.
#[test]
fn derivatives_of_inverse_dynamics_are_its_slopes() {
    for (i, c) in all_cases().iter().enumerate() {
        let n = c.model.nv();
        let mut state = State::new(&c.model);
        state.update(&c.model, &c.q, &c.v);
        let w = |link: usize| Wrench {
            link,
            point: Vec3::new(0.5, -0.3, 0.8) * link as f64,
            force: Vec3::new(40.0, -200.0, 70.0),
            moment: Vec3::new(5.0, 20.0, -30.0),
        };
        let wrenches = if i % 2 == 0 { vec![w(0), w(2), w(4), w(7), w(7)] } else { vec![] };
        let mut slopes = InverseDerivatives::new(&c.model);
        slopes.update(&c.model, &state, &c.v, &c.vd, &wrenches);
        let shifted = |k: usize, which: usize, s: f64| {
            let (mut q, mut v, mut vd) = (c.q.clone(), c.v.clone(), c.vd.clone());
            match which {
                0 => {
                    let mut step = vec![0.0; n];
                    step[k] = s;
                    c.model.skeleton.integrate(&mut q, &step, 1.0);
                }
                1 => v[k] += s,
                _ => vd[k] += s,
            }
            inverse(c, &q, &v, &vd, &wrenches)
        };
        for (which, (analytic, h)) in
            [(&slopes.q, 2e-4), (&slopes.v, 1e-2), (&slopes.vd, 1.0)].iter().enumerate()
        {
            let scale = analytic.amax();
            for k in 0..n {
                let slope = |h: f64| (shifted(k, which, h) - shifted(k, which, -h)) / (2.0 * h);
                let refined = (slope(0.5 * h) * 4.0 - slope(*h)) / 3.0; // Richardson: error of order h⁴
                let error = (refined - analytic.column(k)).amax() / scale;
                assert!(error < 1e-9, "variable {which}, axis {k}: {error:e}"); // 1e-11 seen for q
            }
        }
        // τ is quadratic in v: 2 C(q, v) v = (∂τ/∂v) v
        let v = DVector::from_vec(c.v.clone());
        let mut coriolis = vec![0.0; n];
        state.coriolis(&c.model, &c.v, &mut coriolis);
        let twice = DVector::from_vec(coriolis) * 2.0;
        assert!((&slopes.v * v - &twice).norm() < 1e-12 * twice.norm()); // 3e-15 seen
        assert!((&slopes.vd - mass(c)).norm() < 1e-13 * slopes.vd.norm()); // 7e-16 seen
    }
}
