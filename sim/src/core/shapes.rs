//! Shapes as points: what of a body may touch a plane.
//!
//! In: the shapes of a character. Out: points with a radius, grouped by body, each in the frame of its body: the ends of a
//! capsule, the centre of a ball, the corners of a box, the corners of the polyhedron that stands for a cone. Against a plane
//! these are exact: a convex solid touches it with the hull of such points.

use bodies::Character;
use dynamics::Model;
use motion::{Shape, Vec3};
use nalgebra::Point3;

/// A ball that may touch.
#[derive(Clone, Debug)]
pub(super) struct Point {
    /// Centre in the frame of its body, m.
    pub at: Vec3,
    /// Radius, m; zero for corners.
    pub radius: f64,
}

/// The points of one body.
#[derive(Clone, Debug)]
pub(super) struct Group {
    /// The body.
    pub body: usize,
    /// Its first point.
    pub from: usize,
    /// Past its last point.
    pub to: usize,
    /// No point is farther from the body's origin, radius included, m.
    pub reach: f64,
}

/// All points of a character, and which body they belong to.
pub(super) fn points(character: &Character, model: &Model) -> (Vec<Point>, Vec<Group>) {
    let mut points: Vec<Point> = Vec::new();
    let mut groups = Vec::new();
    for body in 0..model.bodies.len() {
        let from = points.len();
        for (link, source) in character.bodies.iter().enumerate() {
            let (owner, frame) = model.body_of[link];
            if owner != body {
                continue;
            }
            for shape in &source.shapes {
                let mut add = |at: &Vec3, radius: f64| {
                    points.push(Point { at: (frame * Point3::from(*at)).coords, radius });
                };
                match shape {
                    Shape::Capsule { a, b, radius } => {
                        add(a, *radius);
                        add(b, *radius);
                    }
                    Shape::Sphere { center, radius } => add(center, *radius),
                    Shape::Box { center, half, rotation } => {
                        for corner in 0..8 {
                            let side = |axis: usize| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 };
                            let way = Vec3::new(side(0), side(1), side(2));
                            add(&(center + rotation * half.component_mul(&way)), 0.0);
                        }
                    }
                    Shape::Cone { .. } => shape.rims().iter().for_each(|p| add(p, 0.0)),
                }
            }
        }
        if points.len() > from {
            let reach = points[from..].iter().map(|p| p.at.norm() + p.radius).fold(0.0, f64::max);
            groups.push(Group { body, from, to: points.len(), reach });
        }
    }
    (points, groups)
}
