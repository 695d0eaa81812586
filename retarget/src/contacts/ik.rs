//! The pose that puts contact points where they have to be and keeps the rest.
//!
//! In: a pose and a goal for each point. Out: the pose that [`motion::ik::whole_body`] finds near it by Gauss–Newton. One
//! smooth problem with the same weights in every frame: where the goals move smoothly, so does the pose. The weight of a
//! goal is so large that a goal that can be reached is missed by micrometres. Joints between the root and a contact point
//! weigh least, so that they move first; the root and all that it carries move where those cannot reach.
//!
//! The goals of one link fit it, but the legs need not reach them, and live they need not fit. So a point in a phase outweighs
//! one in flight a thousandfold, and beside its phases the weight goes over from one to the other. A point without any phase
//! has no goal. Every point is pushed out of the ground below −[`DEPTH_M`], unless it is held in a phase.

use motion::ik::{Floor, Goal, Method, Point, Problem, Unknowns, WholeBody};
use motion::{Joint, Kinematics, Vec3};

use crate::Puppet;
use crate::phase::PhaseFrames;

/// Weight of a goal in a phase against a radian of a leg, 1/m².
const GOAL: f64 = 1e7;
/// Weight of a goal in flight, 1/m².
const FLIGHT: f64 = 1e4;
/// Weight of the depth below −[`DEPTH_M`], 1/m².
const FLOOR: f64 = 1e6;
/// Depth from which points are pushed out of the ground, m.
pub const DEPTH_M: f64 = 0.002;
/// Weight of a radian beyond a limit.
const LIMIT: f64 = 1e5;
/// Weight of a radian of a joint that carries no contact point.
const OTHER: f64 = 100.0;
/// Weight of a radian of the root.
const ROOT_TURN: f64 = 20.0;
/// Weight of the root's way, over the square of the size of the body.
const ROOT_WAY: f64 = 10.0;
/// How much more a held root weighs.
const HELD_ROOT: f64 = 10.0;
/// After two steps the goals are nearly reached: only then is it known which points are below the ground.
const METHOD: Method = Method::GaussNewton { most_steps: 30, full_steps: 10, settle: 2, still: 1e-8 };

/// The solver of one puppet, and its memory. See the module header.
#[derive(Clone, Debug)]
pub struct ContactIk {
    solver: WholeBody,
    /// The puppet's contact points, in its order.
    points: Vec<Point>,
    /// Whether each has a phase, and so a goal.
    has_phase: Vec<bool>,
    /// Of each degree of freedom.
    weights: Vec<f64>,
}

impl ContactIk {
    /// A solver for the contact points of a puppet, of which those with phases have goals.
    pub fn new(puppet: &Puppet, phases: &[Vec<PhaseFrames>]) -> Self {
        let skeleton = &puppet.character.skeleton;
        let solver = WholeBody::new(skeleton, Unknowns::All);
        let sites = puppet.contacts.iter().map(|c| &skeleton.sites()[c.site]);
        let points: Vec<Point> =
            sites.map(|s| Point { link: s.link, at: s.at, goal: None, on_floor: true }).collect();
        let has_phase: Vec<bool> = phases.iter().map(|p| !p.is_empty()).collect();
        let rest = Kinematics::new(skeleton, &puppet.character.rest);
        let size =
            points.iter().map(|p| (rest.point(p.link, &p.at) - rest.origin(0)).norm()).fold(0.05, f64::max);
        let mut weights = vec![OTHER; skeleton.nv()];
        for (p, _) in points.iter().zip(&has_phase).filter(|(_, has)| **has) {
            solver.carriers()[p.link].iter().for_each(|&d| weights[d] = 1.0);
        }
        for (d, w) in weights.iter_mut().enumerate().take(6) {
            *w = if d < 3 { ROOT_WAY / (size * size) } else { ROOT_TURN };
        }
        for (i, link) in skeleton.links().iter().enumerate().skip(1) {
            if let Joint::Prismatic(_) = link.joint {
                weights[skeleton.v_at(i)] /= size * size;
            }
        }
        Self { solver, points, has_phase, weights }
    }

    /// From now on the root stays where `from` has it, as long as the legs can reach.
    pub fn hold_root(&mut self) {
        self.weights[..6].iter_mut().for_each(|w| *w *= HELD_ROOT);
    }

    /// Writes the pose near `from` whose points are at their goals into `q`.
    ///
    /// * `goal`: of each contact point its place (world, m), and how firmly it is held there: 1 in a phase, 0 in flight
    pub fn solve(&mut self, from: &[f64], goal: &dyn Fn(usize) -> (Vec3, f64), q: &mut [f64]) {
        for (contact, (point, has_phase)) in self.points.iter_mut().zip(&self.has_phase).enumerate() {
            let (place, firmness) = goal(contact);
            let weight = FLIGHT * (GOAL / FLIGHT).powf(firmness);
            point.goal = has_phase.then_some(Goal { place, weight, along: None });
            point.on_floor = firmness < 1.0;
        }
        let problem = Problem {
            points: &self.points,
            reference: from,
            weights: &self.weights,
            limit_weight: LIMIT,
            floor: Some(Floor { height_m: -DEPTH_M, weight: FLOOR }),
        };
        q.copy_from_slice(from);
        self.solver.solve(&problem, METHOD, q, &|_, _| {});
    }
}
