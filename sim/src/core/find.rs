//! Finding: what touches what in a substep.
//!
//! In: poses, the ground and how it turns, props, the forces of the last substep. Out: the [`Contact`]s and the [`Slot`]s that they move,
//! contacts in the order of their slots.
//!
//! Points meet the ground ([`super::shapes`]); solids meet props by manifolds of parry, made anew each time so that nothing but the pose
//! decides them; capsules meet capsules at their nearest points, near parallel ones at both ends of what they share.

use bodies::self_collision::nearest;
use dynamics::State;
use motion::Vec3;
use motion::floor::FRICTION;
use parry3d::math::Vector;
use parry3d::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};

use super::contact::{Contact, Ground, Yield, axes};
use super::shapes::{ENDS, MANIFOLD, Obstacle, Pair, Shapes, pose};

/// Points nearer than this to what is fixed take part, m.
const MARGIN: f64 = 0.02;
/// The same of links that may touch each other.
const SELF_MARGIN: f64 = 0.01;
/// Most points that parry finds of two faces: their corners and where edges cross.
const MOST_POINTS: usize = 64;
/// Points of a manifold that are nearer to each other are one, m.
const SAME: f64 = 1e-6;
/// Sine of the angle at which two capsules count as parallel.
const PARALLEL: f64 = 0.1;

/// What contacts move: a body against the world, or a body against another. Its twist is that of the first body, less that of the second
/// at the origin of the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Slot {
    pub body: usize,
    pub other: Option<usize>,
}

/// Memory of a search.
#[derive(Clone, Debug)]
pub(super) struct Finder {
    manifolds: Vec<ContactManifold<(), ()>>,
    /// Where the ends of the capsules of the body are, and the least and greatest corners of the boxes along the axes that hold them.
    ends: Vec<[Vec3; 2]>,
    boxes: Vec<[Vec3; 2]>,
}

impl Finder {
    /// All the memory that searches among these shapes take.
    pub fn new(shapes: &Shapes) -> Self {
        let mut manifold = ContactManifold::default();
        manifold.points.reserve(MOST_POINTS);
        Self {
            manifolds: if shapes.props.is_empty() { Vec::new() } else { vec![manifold] },
            ends: Vec::with_capacity(shapes.capsules.len()),
            boxes: Vec::with_capacity(shapes.capsules.len()),
        }
    }

    /// Finds the contacts of a substep; forces of points that are not among them are forgotten.
    pub fn find(
        &mut self,
        shapes: &Shapes,
        state: &State,
        ground: Option<&Ground>,
        law: (f64, Yield),
        forces: &mut [[f64; 3]],
        (contacts, slots): (&mut Vec<Contact>, &mut Vec<Slot>),
    ) {
        contacts.clear();
        slots.clear();
        // a spring acts where it is pressed, not before
        let (margin, inner) = if law.1 == Yield::Stiff { (MARGIN, SELF_MARGIN) } else { (0.0, 0.0) };
        for group in &shapes.groups {
            let found = contacts.len();
            let s = &state.bodies[group.body];
            let slot = slots.len();
            if let Some(ground) = ground {
                let (up, pivot) = (ground.floor.up, ground.floor.pivot());
                let height = (s.origin() - pivot).dot(&up);
                if height > group.reach + margin {
                    forces[group.from..group.to].fill([0.0; 3]);
                } else {
                    let up_here = s.rotation.tr_mul(&up);
                    for point in group.from..group.to {
                        let p = &shapes.points[point];
                        let depth = p.radius - (height + p.at.dot(&up_here));
                        if depth < -margin {
                            forces[point] = [0.0; 3];
                            continue;
                        }
                        let arm = s.rotation * p.at - up * p.radius;
                        let at = s.origin() + arm;
                        let moving = ground.rate.cross(&(at - pivot));
                        let friction = ground.floor.friction;
                        contacts.push(Contact::new(
                            (point, slot),
                            (at, arm, depth),
                            &ground.axes,
                            &moving,
                            friction,
                            law,
                        ));
                    }
                }
            }
            for solid in group.solids.clone() {
                for (number, prop) in shapes.props.iter().enumerate() {
                    let first = shapes.on_prop(solid, number);
                    self.on_prop(
                        (shapes, solid, prop),
                        (state, slot, first),
                        (margin, law),
                        forces,
                        contacts,
                    );
                }
            }
            if contacts.len() > found {
                slots.push(Slot { body: group.body, other: None });
            }
        }
        if !shapes.pairs.is_empty() {
            self.place_capsules(shapes, state, inner);
        }
        let mut last: Option<Slot> = None;
        for (number, pair) in shapes.pairs.iter().enumerate() {
            let found = contacts.len();
            let of = Slot { body: pair.bodies[0], other: Some(pair.bodies[1]) };
            let slot = slots.len() - usize::from(last == Some(of));
            let first = shapes.of_pair(number);
            let [[low, high], [other_low, other_high]] =
                [&self.boxes[pair.capsules[0]], &self.boxes[pair.capsules[1]]];
            let apart = |k: usize| (low[k] > other_high[k]) | (other_low[k] > high[k]);
            if apart(0) | apart(1) | apart(2) {
                for force in &mut forces[first..first + ENDS] {
                    *force = [0.0; 3];
                }
                continue;
            }
            self.capsules((shapes, pair), (state, slot, first), (inner, law), forces, contacts);
            if contacts.len() > found && last != Some(of) {
                slots.push(of);
                last = Some(of);
            }
        }
    }

    fn on_prop(
        &mut self,
        (shapes, solid, prop): (&Shapes, usize, &Obstacle),
        (state, slot, first): (&State, usize, usize),
        (margin, law): (f64, (f64, Yield)),
        forces: &mut [[f64; 3]],
        contacts: &mut Vec<Contact>,
    ) {
        let solid = &shapes.solids[solid];
        let s = &state.bodies[solid.body];
        let center = s.origin() + s.rotation * solid.center;
        let mut found = 0;
        if prop.prop.distance(&center) <= solid.reach + margin {
            let world = pose(&(s.world * solid.place));
            let between = prop.place.inverse() * world;
            for manifold in &mut self.manifolds {
                manifold.points.clear();
                manifold.local_n1 = Vector::ZERO;
            }
            // every pair of a box and a convex solid is supported
            let supported = DefaultQueryDispatcher.contact_manifolds(
                &between,
                &prop.solid,
                solid.solid.as_ref(),
                margin,
                &mut self.manifolds,
                &mut None,
            );
            debug_assert!(supported.is_ok());
            for manifold in &self.manifolds {
                let axes = axes(vector(prop.place.rotation * manifold.local_n1));
                // where edges and ends meet, a point may be there twice
                let again = |i: usize| {
                    let p = &manifold.points[i].local_p2;
                    manifold.points[..i].iter().any(|q| (q.local_p2 - *p).length_squared() < SAME * SAME)
                };
                for (i, p) in manifold.points.iter().enumerate() {
                    if p.dist > margin || again(i) {
                        continue;
                    }
                    if found == MANIFOLD {
                        break;
                    }
                    let at = vector(world * p.local_p2);
                    contacts.push(Contact::new(
                        (first + found, slot),
                        (at, at - s.origin(), -p.dist),
                        &axes,
                        &Vec3::zeros(),
                        prop.prop.friction,
                        law,
                    ));
                    found += 1;
                }
            }
        }
        forces[first + found..first + MANIFOLD].fill([0.0; 3]);
    }

    /// Ends and boxes of all capsules; boxes of two that are nearer than `margin` overlap.
    fn place_capsules(&mut self, shapes: &Shapes, state: &State, margin: f64) {
        self.ends.clear();
        self.boxes.clear();
        for c in &shapes.capsules {
            let s = &state.bodies[c.body];
            let [a, b] = [c.a, c.b].map(|p| s.origin() + s.rotation * p);
            let around = Vec3::repeat(c.radius + 0.5 * margin);
            self.ends.push([a, b]);
            self.boxes.push([a.inf(&b) - around, a.sup(&b) + around]);
        }
    }

    /// Contacts of two capsules of the body.
    fn capsules(
        &self,
        (shapes, pair): (&Shapes, &Pair),
        (state, slot, first): (&State, usize, usize),
        (margin, law): (f64, (f64, Yield)),
        forces: &mut [[f64; 3]],
        contacts: &mut Vec<Contact>,
    ) {
        let [one, other] = pair.capsules.map(|c| &shapes.capsules[c]);
        let s = &state.bodies[pair.bodies[0]];
        let [[a, b], [c, d]] = pair.capsules.map(|c| self.ends[c]);
        let mut found = 0;
        let mut touch = |(p, q): (Vec3, Vec3)| {
            let away = p - q;
            let far = away.norm();
            let depth = one.radius + other.radius - far;
            if depth < -margin || far == 0.0 {
                return;
            }
            let axes = axes(away / far);
            // between the two surfaces
            let at = 0.5 * ((p - axes[0] * one.radius) + (q + axes[0] * other.radius));
            let place = (at, at - s.origin(), depth);
            let mut contact =
                Contact::new((first + found, slot), place, &axes, &Vec3::zeros(), FRICTION, law);
            contact.inner = true;
            contacts.push(contact);
            found += 1;
        };
        let (u, w) = (b - a, d - c);
        let (long, wide) = (u.norm_squared(), w.norm_squared());
        if long * wide > 0.0 && u.cross(&w).norm_squared() < PARALLEL * PARALLEL * long * wide {
            // the ends of what the second spans along the first
            let along = |x: &Vec3| ((x - a).dot(&u) / long).clamp(0.0, 1.0);
            let (from, to) = (along(&c), along(&d));
            if from == to {
                touch(nearest([a, b], [c, d]));
            } else {
                for part in [from, to] {
                    let p = a + u * part;
                    touch((p, nearest([p, p], [c, d]).1));
                }
            }
        } else {
            touch(nearest([a, b], [c, d]));
        }
        forces[first + found..first + ENDS].fill([0.0; 3]);
    }
}

fn vector(v: Vector) -> Vec3 {
    Vec3::new(v.x, v.y, v.z)
}
