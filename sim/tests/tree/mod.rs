//! A small tree with every kind of joint, and a law that every engine keeps on it.

use bodies::{Body, Character};
use dynamics::{Model, State};
use motion::rotation::exp;
use motion::{Joint, Link, Shape, Vec3};
use nalgebra::{DMatrix, DVector, Matrix3};
use sim::Engine;

use crate::solids::character;

/// A body of this mass, with a rotational inertia that grows with it.
pub fn body(mass: f64, com: Vec3, shapes: Vec<Shape>) -> Body {
    let inertia = Matrix3::from_diagonal(&Vec3::new(0.02, 0.03, 0.025)) * mass;
    Body { mass, com, inertia, shapes }
}

/// A free root with its centre of mass off its origin, a ball, a skew hinge and a slide.
pub fn tree() -> Character {
    let mut links = vec![
        Link::new("root", None, Vec3::zeros(), Joint::Free),
        Link::new("ball", Some(0), Vec3::new(0.1, 0.2, 0.0), Joint::Spherical),
        Link::new("hinge", Some(1), Vec3::new(0.0, 0.3, 0.1), Joint::Revolute(Vec3::new(0.6, 0.0, 0.8))),
        Link::new("slide", Some(0), Vec3::new(-0.1, 0.0, 0.2), Joint::Prismatic(Vec3::new(0.0, 0.8, 0.6))),
        Link::new("weld", Some(3), Vec3::new(0.0, 0.1, 0.0), Joint::Fixed),
    ];
    links[2].parent_from_zero.rotation = exp(&Vec3::new(0.3, -0.4, 0.2));
    let bodies = vec![
        body(3.0, Vec3::new(0.05, -0.02, 0.03), vec![]),
        body(2.0, Vec3::new(0.0, 0.1, 0.0), vec![]),
        body(1.0, Vec3::new(0.02, 0.1, -0.05), vec![]),
        body(1.5, Vec3::new(0.0, 0.05, 0.0), vec![]),
        body(0.5, Vec3::new(0.0, 0.1, 0.0), vec![]),
    ];
    character(links, bodies)
}

/// A pose and a velocity in which everything moves.
pub fn start(c: &Character) -> (Vec<f64>, Vec<f64>) {
    let mut q = c.skeleton.zero_pose();
    let turn: Vec<f64> = (0..c.skeleton.nv()).map(|i| 0.4 * (i as f64 * 1.7).sin()).collect();
    c.skeleton.integrate(&mut q, &turn, 1.0);
    let v = (0..c.skeleton.nv()).map(|i| 1.5 * (i as f64 * 2.3).cos()).collect();
    (q, v)
}

/// A pinned root lands on its path, and the limbs feel its acceleration: the joint accelerations are those of our forward
/// dynamics with the root's acceleration prescribed. Gravity is 9.81 m/s² down; `dt` is the length of a step, s.
pub fn carries_its_limbs(engine: &mut dyn Engine, c: &Character, (q, v): (&[f64], &[f64]), dt: f64) {
    let model = Model::new(c, Vec3::new(0.0, -9.81, 0.0));
    let mut state = State::new(&model);
    state.update(&model, q, v);
    let root_accel = [3.0, -2.0, 4.0, 5.0, -6.0, 2.0];
    // Two steps: path velocities are means over a step, so the first difference that is an
    // acceleration is the one between the first and the second step.
    let (mut path_q, mut path_v) = (q.to_vec(), v.to_vec());
    let mut before = Vec::new();
    for _ in 0..2 {
        for k in 0..6 {
            path_v[k] += root_accel[k] * dt;
        }
        c.skeleton.integrate(&mut path_q, &path_v, dt);
        before = engine.v().to_vec();
        engine.move_root(&state, &path_q);
        engine.step().unwrap();
        for k in 0..7 {
            assert!((engine.q()[k] - path_q[k]).abs() < 1e-12);
        }
    }
    let n = model.nv();
    let (mut m, mut bias) = (DMatrix::zeros(n, n), vec![0.0; n]);
    state.mass_matrix(&model, &mut m);
    let mut prescribed = vec![0.0; n];
    prescribed[..6].copy_from_slice(&root_accel);
    state.inverse_dynamics(&model, v, &prescribed, &[], &mut bias);
    let limbs = m.view((6, 6), (n - 6, n - 6)).into_owned();
    let expected = -limbs.cholesky().unwrap().solve(&DVector::from_column_slice(&bias[6..]));
    for k in 6..n {
        let found = (engine.v()[k] - before[k]) / dt;
        assert!((found - expected[k - 6]).abs() < 2e-2, "dof {k}: {found} {}", expected[k - 6]);
    }
}
