//! A box to lie, slide and tip.

use bodies::{Body, Carried, Character};
use motion::{Joint, Link, Quat, Shape, Vec3};

use crate::solids::character;

/// kg.
pub const MASS: f64 = 12.0;
/// Half its edges, m.
pub const HALF: [f64; 3] = [0.15, 0.05, 0.2];

/// A free box of even density.
pub fn solid_box() -> Character {
    let half = Vec3::from(HALF);
    let c = Carried::solid_box(0, MASS, Vec3::zeros(), half * 2.0);
    let shapes = vec![Shape::Box { center: Vec3::zeros(), half, rotation: Quat::identity() }];
    let body = Body { mass: c.mass, com: c.at, inertia: c.inertia, shapes };
    character(vec![Link::new("box", None, Vec3::zeros(), Joint::Free)], vec![body])
}
