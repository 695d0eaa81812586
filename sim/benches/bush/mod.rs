//! Bodies of any number of links, whose branches are as long as each other.

use bodies::{Body, Character, JointClass};
use motion::{Joint, Link, Quat, Shape, Skeleton, Vec3};
use nalgebra::Matrix3;

/// A bush: a root of two feet, and from it branches of balls and hinges, five links long.
pub fn bush(links: usize) -> Character {
    let mut all = vec![Link::new("root", None, Vec3::zeros(), Joint::Free)];
    let half = Vec3::new(0.06, 0.02, 0.12);
    let foot = |x: f64| Shape::Box { center: Vec3::new(x, 0.02, 0.0), half, rotation: Quat::identity() };
    let body = |mass: f64, shapes: Vec<Shape>| Body {
        mass,
        com: Vec3::new(0.0, 0.1, 0.0),
        inertia: Matrix3::from_diagonal(&Vec3::new(0.01, 0.01, 0.008)) * mass,
        shapes,
    };
    let mut bodies = vec![body(40.0, vec![foot(-0.15), foot(0.15)])];
    for i in 1..links {
        let (branch, at) = ((i - 1) / 5, (i - 1) % 5);
        let parent = if at == 0 { 0 } else { i - 1 };
        let angle = branch as f64 * 0.7;
        let offset =
            if at == 0 { Vec3::new(0.1 * angle.sin(), 0.3, 0.1 * angle.cos()) } else { Vec3::y() * 0.12 };
        let joint = if at % 2 == 0 { Joint::Spherical } else { Joint::Revolute(Vec3::x()) };
        all.push(Link::new(format!("link{i}"), Some(parent), offset, joint));
        bodies.push(body(1.0, vec![Shape::Sphere { center: Vec3::zeros(), radius: 0.04 }]));
    }
    let skeleton = std::sync::Arc::new(Skeleton::new(all).unwrap());
    Character {
        name: "bush".into(),
        classes: vec![JointClass::Other; links],
        rest: skeleton.zero_pose(),
        skeleton,
        bodies,
        contacts: vec![],
    }
    .check()
    .unwrap()
}
