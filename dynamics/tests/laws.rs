//! Laws of inverse dynamics on a tree that has every joint type, turned zero frames and a weld.

use std::sync::Arc;

use dynamics::{Body, Character, JointClass, Model, State, Wrench};
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
    let mut r = Numbers(0.3);
    let joints = [
        (None, Joint::Free),
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
    let character = tree();
    let model = Model::new(&character, Vec3::new(0.3, -9.81, 0.2));
    let mut r = Numbers(0.7);
    (0..20)
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
    for c in cases() {
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

/// Power balance: v·τ = d/dt (kinetic + potential), by central differences along the motion.
#[test]
fn work_is_the_change_of_energy() {
    let dt = 1e-5;
    for c in cases() {
        let tau = inverse(&c, &c.q, &c.v, &c.vd, &[]);
        let power: f64 = tau.iter().zip(&c.v).map(|(t, v)| t * v).sum();
        let energy = |h: f64| {
            let mut q = c.q.clone();
            // second-order step: q(h) = q ⊕ (v + v̇ h/2) h; a ball's frame is fixed, so this is exact to h²
            let mid: Vec<f64> = c.v.iter().zip(&c.vd).map(|(v, a)| v + 0.5 * a * h).collect();
            c.model.skeleton.integrate(&mut q, &mid, h);
            let v: Vec<f64> = c.v.iter().zip(&c.vd).map(|(v, a)| v + a * h).collect();
            let mut state = State::new(&c.model);
            state.update(&c.model, &q, &v);
            let (kinetic, potential) = state.energy(&c.model);
            kinetic + potential
        };
        let rate = (energy(dt) - energy(-dt)) / (2.0 * dt);
        assert!((rate - power).abs() < 1e-6 * power.abs().max(1e3), "{rate} {power}"); // 1e-8 seen
    }
}

/// The root wrench of inverse dynamics is the rate of momentum less gravity.
#[test]
fn root_force_is_the_rate_of_momentum() {
    let dt = 1e-5;
    for c in cases() {
        let tau = inverse(&c, &c.q, &c.v, &c.vd, &[]);
        let momentum = |h: f64| {
            let mut q = c.q.clone();
            let mid: Vec<f64> = c.v.iter().zip(&c.vd).map(|(v, a)| v + 0.5 * a * h).collect();
            c.model.skeleton.integrate(&mut q, &mid, h);
            let v: Vec<f64> = c.v.iter().zip(&c.vd).map(|(v, a)| v + a * h).collect();
            let mut state = State::new(&c.model);
            state.update(&c.model, &q, &v);
            state.momentum(&c.model)
        };
        let (a, b) = (momentum(-dt), momentum(dt));
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

/// Forward dynamics (M⁻¹) of inverse dynamics gives the acceleration back.
#[test]
fn forward_undoes_inverse() {
    for c in cases() {
        let zero = vec![0.0; c.model.nv()];
        let tau = inverse(&c, &c.q, &c.v, &c.vd, &[]);
        let bias = inverse(&c, &c.q, &c.v, &zero, &[]);
        let vd = mass(&c).cholesky().unwrap().solve(&(tau - bias));
        let error = (vd - DVector::from_vec(c.vd.clone())).norm();
        assert!(error < 1e-9 * DVector::from_vec(c.vd.clone()).norm(), "{error}");
    }
}

/// An outside wrench enters as −Jᵀ w, and Jᵀ w does the wrench's work on any velocity.
#[test]
fn wrenches_enter_through_the_jacobian() {
    for c in cases() {
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
