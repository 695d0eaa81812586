//! Shapes: what of a body may touch the ground, props and itself.
//!
//! In: the shapes of a character. Out: points with a radius, grouped by body, each in the frame of its body: the ends of a
//! capsule, the centre of a ball, the corners of a box, the corners of the polyhedron that stands for a cone. Against a plane
//! these are exact: a convex solid touches it with the hull of such points. Where there are props, the solids themselves; where links
//! touch each other, capsules and their pairs.
//!
//! Every place where a contact may be has a number, under which its force is kept: points first, then [`MANIFOLD`] of each solid on each
//! prop, then [`ENDS`] of each pair.

use std::ops::Range;

use bodies::{Character, Prop};
use dynamics::Model;
use motion::{Shape, Transform, Vec3};
use nalgebra::Point3;
use parry3d::math::{Pose, Rotation, Vector};
use parry3d::shape::{Cuboid, SharedShape};

use crate::EngineSettings;

/// Points of a manifold that count.
pub(super) const MANIFOLD: usize = 8;
/// Points of a pair of capsules.
pub(super) const ENDS: usize = 2;

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
    /// Its solids.
    pub solids: Range<usize>,
}

/// A solid that may touch props.
#[derive(Clone)]
pub(super) struct Solid {
    pub body: usize,
    pub solid: SharedShape,
    /// `body_from_solid`.
    pub place: Transform,
    /// Centre of a ball that holds it, body frame, m, and the radius of that.
    pub center: Vec3,
    pub reach: f64,
}

impl std::fmt::Debug for Solid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Solid").field("body", &self.body).field("place", &self.place).finish_non_exhaustive()
    }
}

/// A prop as contacts meet it.
#[derive(Clone, Debug)]
pub(super) struct Obstacle {
    pub prop: Prop,
    pub solid: Cuboid,
    pub place: Pose,
}

/// A capsule in the frame of its body, and the ball that holds it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Capsule {
    pub body: usize,
    pub a: Vec3,
    pub b: Vec3,
    pub radius: f64,
}

/// Two capsules that may touch each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    pub bodies: [usize; 2],
    pub links: [usize; 2],
    pub capsules: [usize; 2],
}

/// All that may touch.
#[derive(Clone, Debug, Default)]
pub(super) struct Shapes {
    pub points: Vec<Point>,
    pub groups: Vec<Group>,
    pub solids: Vec<Solid>,
    pub props: Vec<Obstacle>,
    pub capsules: Vec<Capsule>,
    pub pairs: Vec<Pair>,
}

impl Shapes {
    pub fn new(character: &Character, model: &Model, settings: &EngineSettings) -> Self {
        let mut all = Self::default();
        if settings.ground.is_some() {
            (all.points, all.groups) = points(character, model);
        }
        if !settings.props.is_empty() {
            all.props = settings.props.iter().map(Obstacle::new).collect();
            all.add_solids(character, model);
        }
        if settings.self_collision {
            all.add_pairs(character, model);
        }
        all
    }

    /// How many places there are where a contact may be.
    pub fn places(&self) -> usize {
        self.of_pair(self.pairs.len())
    }

    /// First place of a solid on a prop.
    pub fn on_prop(&self, solid: usize, prop: usize) -> usize {
        self.points.len() + MANIFOLD * (solid * self.props.len() + prop)
    }

    /// First place of a pair.
    pub fn of_pair(&self, pair: usize) -> usize {
        self.on_prop(self.solids.len(), 0) + ENDS * pair
    }

    fn add_solids(&mut self, character: &Character, model: &Model) {
        for body in 0..model.bodies.len() {
            let first = self.solids.len();
            for (link, source) in character.bodies.iter().enumerate() {
                let (owner, frame) = model.body_of[link];
                if owner == body {
                    self.solids.extend(source.shapes.iter().map(|shape| Solid::new(body, shape, &frame)));
                }
            }
            let solids = first..self.solids.len();
            match self.groups.iter_mut().find(|g| g.body == body) {
                Some(group) => group.solids = solids,
                None if solids.is_empty() => {}
                None => self.groups.push(Group { body, from: 0, to: 0, reach: 0.0, solids }),
            }
        }
    }

    fn add_pairs(&mut self, character: &Character, model: &Model) {
        let capsules = character.capsules();
        self.capsules = capsules
            .iter()
            .map(|c| {
                let (body, frame) = &model.body_of[c.link];
                let [a, b] = [c.a, c.b].map(|p| (frame * Point3::from(p)).coords);
                Capsule { body: *body, a, b, radius: c.radius }
            })
            .collect();
        let pair = |[i, j]: [usize; 2]| {
            let links = [capsules[i].link, capsules[j].link];
            Pair { bodies: links.map(|l| model.body_of[l].0), links, capsules: [i, j] }
        };
        self.pairs = character.self_pairs().into_iter().map(pair).collect();
        // pairs of the same two bodies share a slot
        self.pairs.sort_by_key(|p| (p.bodies, p.capsules));
    }
}

impl Obstacle {
    pub fn new(prop: &Prop) -> Self {
        Self { prop: prop.clone(), solid: Cuboid::new(to_vector(prop.half)), place: pose(&prop.place) }
    }
}

impl Solid {
    pub fn new(body: usize, shape: &Shape, frame: &Transform) -> Self {
        let (solid, local) = match shape {
            Shape::Capsule { a, b, radius } => {
                (SharedShape::capsule(to_vector(*a), to_vector(*b), *radius), Transform::identity())
            }
            Shape::Sphere { center, radius } => {
                (SharedShape::ball(*radius), Transform::from_parts((*center).into(), Default::default()))
            }
            Shape::Box { center, half, rotation } => (
                SharedShape::cuboid(half.x, half.y, half.z),
                Transform::from_parts((*center).into(), *rotation),
            ),
            Shape::Cone { a, b, radius_a, .. } => {
                let corners: Vec<_> = shape.rims().iter().map(|p| to_vector(*p)).collect();
                // two rims of positive radius have a hull; where rounding leaves none, a capsule replaces it
                let solid = SharedShape::convex_hull(&corners)
                    .unwrap_or_else(|| SharedShape::capsule(to_vector(*a), to_vector(*b), *radius_a));
                (solid, Transform::identity())
            }
        };
        let place = frame * local;
        let ball = solid.compute_local_bounding_sphere();
        let at = ball.center();
        let center = (place * Point3::new(at.x, at.y, at.z)).coords;
        Self { body, solid, place, center, reach: ball.radius() }
    }
}

/// All points of a character, and which body they belong to.
fn points(character: &Character, model: &Model) -> (Vec<Point>, Vec<Group>) {
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
            groups.push(Group { body, from, to: points.len(), reach, solids: 0..0 });
        }
    }
    (points, groups)
}

pub(super) fn pose(t: &Transform) -> Pose {
    let (p, r) = (t.translation.vector, t.rotation);
    Pose::from_parts(to_vector(p), Rotation::from_xyzw(r.i, r.j, r.k, r.w))
}

fn to_vector(v: Vec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}
