//! Inverse kinematics of a whole body: points of any links to goals, the rest of the pose kept, limits respected.
//!
//! In: a [`Problem`] and a pose to start from. Out: the pose that minimises
//!
//! ```text
//! Z(q) = Σ_p w_p |x_p(q) − g_p|² + Σ_d W_d (q ⊖ q₀)_d² + w_l Σ_j |e_j(q)|² + w_f Σ_p max(0, h − x_p,y(q))²
//! ```
//!
//! Symbols: `x_p` points of links (world, m), `g_p` their goals (of a point that may be anywhere along a line, only what is across
//! it counts); `q ⊖ q₀` the tangent of [`Skeleton::difference`] from the
//! reference q₀, rad and m; `e_j` the way of a joint back to its limits ([`tangent_correction`]); `h` the height of a
//! floor. All limits, goals and the floor are terms of the sum: how firmly each is kept is a matter of its weight.
//!
//! *Linear equations.* With the Jacobian columns of [`JointAxes`], `∂(q ⊖ q₀) ≈ 1` and `∂e ≈ −ê êᵀ` (a joint gets nearer
//! to its limits only by moving along its way back), a step δ solves `A δ = b`, A = ½ ∂²Z without second derivatives of
//! points, b = −½ ∂Z, by [`linear::solve_cholesky`]; it is taken on the manifold, `q ← q ⊕ δ`.
//!
//! *Methods* ([`Method`]). Gauss–Newton takes the steps as they are, only not too far, and never looks at Z: for goals that
//! can be reached, with weights that make A well conditioned, frame after frame in bounded time. Levenberg–Marquardt damps
//! steps until Z falls: for goals that no pose meets.
//!
//! It is not [`pose`](super::pose): there a user drags, pins are constraints that hold exactly, and every joint is an anchor in
//! space; here a stage of a pipeline weighs goals, limits, a floor and a departure in joint values against each other.

use std::sync::Arc;

use super::axes::{Axis, JointAxes};
use crate::limits::tangent_correction;
use crate::{Kinematics, Skeleton, Vec3, linear};

/// What is asked of a pose. See the module header.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    /// The points.
    pub points: &'a [Point],
    /// The pose q₀ that is departed from (`nq`).
    pub reference: &'a [f64],
    /// Weight W of the departure of each degree of freedom (`nv`), 1/rad² or 1/m², ≥ 0.
    pub weights: &'a [f64],
    /// Weight w_l of the way beyond a limit, 1/rad² or 1/m², ≥ 0.
    pub limit_weight: f64,
    /// A floor that points are pushed out of.
    pub floor: Option<Floor>,
}

/// A point of a link, and where it should be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Its link.
    pub link: usize,
    /// Where it is in the link's frame, m.
    pub at: Vec3,
    /// Where it should be; `None` if only the floor counts.
    pub goal: Option<Goal>,
    /// Whether the floor pushes it.
    pub on_floor: bool,
}

/// Where a point should be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// The place, world, m.
    pub place: Vec3,
    /// Its weight w_p, 1/m², > 0.
    pub weight: f64,
    /// A direction (world, unit) in which the point may be anywhere: only what is across it counts.
    pub along: Option<Vec3>,
}

impl Goal {
    /// The part of a way that counts.
    fn counts(&self, way: Vec3) -> Vec3 {
        match &self.along {
            None => way,
            Some(along) => way - along * along.dot(&way),
        }
    }
}

/// A floor that points should not be below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floor {
    /// Its height h along Y, world, m.
    pub height_m: f64,
    /// Weight w_f of the depth below it, 1/m².
    pub weight: f64,
}

/// Which degrees of freedom are unknown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unknowns {
    /// All of the skeleton.
    #[default]
    All,
    /// Of a free root its height along Y and its turns about X and Z (world axes, about its origin), and all other joints:
    /// for bodies whose horizontal place and heading have another owner. The root's `weights` do not count.
    HeightRollPitch,
}

/// How the problem is solved. See the module header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Undamped steps.
    ///
    /// The floor is looked at from the step after `settle` on, when points are near their goals, and keeps pushing a point
    /// that it has pushed once: released as soon as it is above, a point would swing about the floor's height.
    GaussNewton {
        /// Most steps.
        most_steps: usize,
        /// Steps that are taken in full; the later ones by half, so that joints at their limits come to rest.
        full_steps: usize,
        /// Steps without the floor.
        settle: usize,
        /// A step whose largest entry is below this, rad or m, is the last.
        still: f64,
    },
    /// Damped steps, of which each lowers Z.
    LevenbergMarquardt {
        /// Most steps.
        most_steps: usize,
        /// A step that lowers Z by less than this share is the last.
        enough: f64,
    },
}

/// Largest entry of a Gauss–Newton step, rad or m: farther away the linear equations say little.
const FARTHEST: f64 = 0.5;

/// Damping to begin with; it grows tenfold after a step that fails, and falls as much after one that succeeds.
const FIRST_DAMPING: f64 = 1e-8;
/// Least damping.
const LEAST_DAMPING: f64 = 1e-12;
/// Damping beyond which no step is worth trying.
const MOST_DAMPING: f64 = 1e4;
/// Added to the damped diagonal, so that an unknown that nothing depends on stays where it is.
const REGULAR: f64 = 1e-12;

/// Unknowns of the root under [`Unknowns::HeightRollPitch`].
const ROOT: usize = 3;
/// Degrees of freedom of a free root.
const FREE: usize = 6;

/// Where sums begin: −0.0 is the neutral element of floating-point addition (0.0 + −0.0 is 0.0).
const NOTHING: f64 = -0.0;

/// The solver for one skeleton, and its memory. See the module header.
#[derive(Clone, Debug)]
pub struct WholeBody {
    skeleton: Arc<Skeleton>,
    unknowns: Unknowns,
    k: Kinematics,
    axes: JointAxes,
    /// The axis of each unknown.
    moving: Vec<Axis>,
    /// For each link, the unknowns that move it.
    chain: Vec<Vec<usize>>,
    /// A, lower triangle, row-major; its factor; b, and the step that comes of it.
    normal: Vec<f64>,
    factor: Vec<f64>,
    right: Vec<f64>,
    step: Vec<f64>,
    /// Jacobian columns of one point.
    columns: Vec<Vec3>,
    /// A tangent (`nv`): departure from the reference, or a step.
    tangent: Vec<f64>,
    trial: Vec<f64>,
    /// Whether the floor pushes each point.
    pushed: Vec<bool>,
}

impl WholeBody {
    /// A solver for a skeleton; for [`Unknowns::HeightRollPitch`] its root must be free.
    pub fn new(skeleton: &Arc<Skeleton>, unknowns: Unknowns) -> Self {
        let axes = JointAxes::new(skeleton);
        let (n, chain) = match unknowns {
            Unknowns::All => (skeleton.nv(), axes.chain.clone()),
            Unknowns::HeightRollPitch => {
                let of_link = |c: &Vec<usize>| {
                    (0..ROOT).chain(c.iter().filter(|&&d| d >= FREE).map(|d| d - FREE + ROOT)).collect()
                };
                (skeleton.nv() - FREE + ROOT, axes.chain.iter().map(of_link).collect())
            }
        };
        let zero = skeleton.zero_pose();
        Self {
            k: Kinematics::new(skeleton, &zero),
            moving: vec![Axis::default(); n],
            normal: vec![0.0; n * n],
            factor: vec![0.0; n * n],
            right: vec![0.0; n],
            step: vec![0.0; n],
            columns: vec![Vec3::zeros(); n],
            tangent: vec![0.0; skeleton.nv()],
            trial: zero,
            pushed: Vec::new(),
            skeleton: skeleton.clone(),
            unknowns,
            axes,
            chain,
        }
    }

    /// Degrees of freedom that move each link, in ascending order.
    pub fn carriers(&self) -> &[Vec<usize>] {
        &self.axes.chain
    }

    /// Moves `q` (`nq`) to the pose that the problem asks for; returns the steps taken.
    ///
    /// Limits are kept as far as their weight says; [`Skeleton::clamp_to_limits`] removes what is left.
    ///
    /// * `q`: where the search starts
    /// * `retract`: what every step is followed by, such as taking out a heading that is not looked for
    pub fn solve(
        &mut self,
        problem: &Problem,
        method: Method,
        q: &mut [f64],
        retract: &dyn Fn(&Skeleton, &mut [f64]),
    ) -> usize {
        self.pushed.clear();
        self.pushed.resize(problem.points.len(), false);
        match method {
            Method::GaussNewton { most_steps, full_steps, settle, still } => {
                self.gauss_newton(problem, [most_steps, full_steps, settle], still, q, retract)
            }
            Method::LevenbergMarquardt { most_steps, enough } => {
                self.levenberg_marquardt(problem, most_steps, enough, q, retract)
            }
        }
    }

    fn gauss_newton(
        &mut self,
        problem: &Problem,
        [most_steps, full_steps, settle]: [usize; 3],
        still: f64,
        q: &mut [f64],
        retract: &dyn Fn(&Skeleton, &mut [f64]),
    ) -> usize {
        let n = self.moving.len();
        for taken in 0..most_steps {
            self.place(q);
            self.clear();
            self.departure(problem, q);
            self.points(problem, taken >= settle);
            self.limits(problem, q, Vec3::norm_squared);
            self.step.copy_from_slice(&self.right);
            if !linear::solve_cholesky(&mut self.normal, n, &mut self.step) {
                return taken;
            }
            let largest = self.step.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let share = (FARTHEST / largest.max(1e-12)).min(if taken < full_steps { 1.0 } else { 0.5 });
            self.walk(share, q);
            retract(&self.skeleton, q);
            if largest < still && taken > settle {
                return taken + 1;
            }
        }
        most_steps
    }

    fn levenberg_marquardt(
        &mut self,
        problem: &Problem,
        most_steps: usize,
        enough: f64,
        q: &mut [f64],
        retract: &dyn Fn(&Skeleton, &mut [f64]),
    ) -> usize {
        let n = self.moving.len();
        let (mut damping, mut cost) = (FIRST_DAMPING, self.cost(problem, q));
        let mut trial = std::mem::take(&mut self.trial);
        let mut taken = 0;
        'steps: while taken < most_steps {
            self.place(q);
            self.clear();
            self.pushed.fill(false);
            self.points(problem, true);
            self.limits(problem, q, |e| e.norm() * e.norm());
            self.departure(problem, q);
            loop {
                self.factor.copy_from_slice(&self.normal);
                for i in 0..n {
                    self.factor[i * n + i] += damping * self.normal[i * n + i] + REGULAR;
                }
                self.step.copy_from_slice(&self.right);
                let mut lower = f64::INFINITY;
                if linear::solve_cholesky(&mut self.factor, n, &mut self.step) {
                    trial.copy_from_slice(q);
                    self.walk(1.0, &mut trial);
                    retract(&self.skeleton, &mut trial);
                    lower = self.cost(problem, &trial);
                }
                if lower < cost {
                    q.copy_from_slice(&trial);
                    taken += 1;
                    let last = cost - lower < enough * cost;
                    (cost, damping) = (lower, (damping * 0.1).max(LEAST_DAMPING));
                    if last {
                        break 'steps;
                    }
                    break;
                }
                damping *= 10.0;
                if damping > MOST_DAMPING {
                    break 'steps;
                }
            }
        }
        self.trial = trial;
        taken
    }

    /// Z at a pose.
    pub fn cost(&mut self, problem: &Problem, q: &[f64]) -> f64 {
        self.k.update(&self.skeleton, q);
        let place = |p: &Point| self.k.point(p.link, &p.at);
        let goals = problem.points.iter().filter_map(|p| Some((place(p), p.goal?)));
        let missed: f64 = goals.map(|(at, g)| g.weight * g.counts(at - g.place).norm_squared()).sum();
        let links = 0..self.skeleton.links().len();
        let ways = links.filter_map(|i| tangent_correction(&self.skeleton, q, i));
        let beyond: f64 = ways.map(|e| e.norm_squared()).sum();
        let below: f64 = problem.floor.map_or(0.0, |floor| {
            let pushed = problem.points.iter().filter(|p| p.on_floor);
            floor.weight * pushed.map(|p| (floor.height_m - place(p).y).max(0.0).powi(2)).sum::<f64>()
        });
        self.skeleton.difference(problem.reference, q, 1.0, &mut self.tangent);
        let away = self.tangent.iter().zip(problem.weights).skip(self.skipped());
        let departed: f64 = away.map(|(x, w)| w * x * x).sum();
        missed + problem.limit_weight * beyond + departed + below
    }

    /// Degrees of freedom before the first that is an unknown of its own.
    fn skipped(&self) -> usize {
        match self.unknowns {
            Unknowns::All => 0,
            Unknowns::HeightRollPitch => FREE,
        }
    }

    /// The unknown that a degree of freedom is; it must be one.
    fn unknown(&self, dof: usize) -> usize {
        match self.unknowns {
            Unknowns::All => dof,
            Unknowns::HeightRollPitch => dof - FREE + ROOT,
        }
    }

    /// Kinematics and axes at `q`.
    fn place(&mut self, q: &[f64]) {
        self.k.update(&self.skeleton, q);
        self.axes.update(&self.skeleton, &self.k);
        match self.unknowns {
            Unknowns::All => self.moving.copy_from_slice(&self.axes.all),
            Unknowns::HeightRollPitch => {
                let (none, origin) = (Vec3::zeros(), self.k.origin(0));
                self.moving[0] = Axis { linear: Vec3::y(), angular: none, origin };
                self.moving[1] = Axis { linear: none, angular: Vec3::x(), origin };
                self.moving[2] = Axis { linear: none, angular: Vec3::z(), origin };
                self.moving[ROOT..].copy_from_slice(&self.axes.all[FREE..]);
            }
        }
    }

    fn clear(&mut self) {
        self.normal.fill(0.0);
        self.right.fill(NOTHING);
    }

    /// Adds the departure from the reference.
    fn departure(&mut self, problem: &Problem, q: &[f64]) {
        let n = self.moving.len();
        self.skeleton.difference(problem.reference, q, 1.0, &mut self.tangent);
        for dof in self.skipped()..self.tangent.len() {
            let (u, weight) = (self.unknown(dof), problem.weights[dof]);
            self.right[u] -= weight * self.tangent[dof];
            self.normal[u * n + u] += weight;
        }
    }

    /// Adds the points: their goals, and the heights of those that the floor pushes.
    fn points(&mut self, problem: &Problem, look_at_floor: bool) {
        let n = self.moving.len();
        for (i, p) in problem.points.iter().enumerate() {
            let at = self.k.point(p.link, &p.at);
            let chain = &self.chain[p.link];
            for (column, &u) in self.columns.iter_mut().zip(chain) {
                *column = self.moving[u].column(&at);
            }
            if let Some(goal) = p.goal {
                let missing = goal.place - at;
                for (a, &u) in chain.iter().enumerate() {
                    let c = goal.counts(self.columns[a]) * goal.weight;
                    self.right[u] += c.dot(&missing);
                    for (&v, other) in chain[..=a].iter().zip(&self.columns) {
                        self.normal[u * n + v] += c.dot(other);
                    }
                }
            }
            let Some(floor) = problem.floor.filter(|_| p.on_floor) else { continue };
            self.pushed[i] |= look_at_floor && at.y < floor.height_m;
            if self.pushed[i] {
                let missing = floor.height_m - at.y;
                for (a, &u) in chain.iter().enumerate() {
                    let c = self.columns[a].y * floor.weight;
                    self.right[u] += c * missing;
                    for (&v, other) in chain[..=a].iter().zip(&self.columns) {
                        self.normal[u * n + v] += c * other.y;
                    }
                }
            }
        }
    }

    /// Adds the joints beyond their limits, each along its way back.
    ///
    /// * `square`: `|e|²`; the two methods round it in different ways, and captured motion on a body with ball limits shows
    ///   the last bit in the written digits, so that one way for both would change results
    fn limits(&mut self, problem: &Problem, q: &[f64], square: fn(&Vec3) -> f64) {
        let (n, weight) = (self.moving.len(), problem.limit_weight);
        for (link, l) in self.skeleton.links().iter().enumerate() {
            let Some(e) = tangent_correction(&self.skeleton, q, link) else { continue };
            let at = self.unknown(self.skeleton.v_at(link));
            let square = square(&e);
            for a in 0..l.joint.nv() {
                self.right[at + a] += weight * e[a];
                for b in 0..=a {
                    self.normal[(at + a) * n + at + b] += weight * e[a] * e[b] / square;
                }
            }
        }
    }

    /// Moves `q` by a share of the step.
    fn walk(&mut self, share: f64, q: &mut [f64]) {
        match self.unknowns {
            Unknowns::All => self.tangent.copy_from_slice(&self.step),
            Unknowns::HeightRollPitch => {
                let zero_from_world = self.skeleton.links()[0].parent_from_zero.rotation.inverse();
                let (rise, turn) = (Vec3::y() * self.step[0], Vec3::new(self.step[1], 0.0, self.step[2]));
                self.tangent[..3].copy_from_slice((zero_from_world * rise).as_slice());
                self.tangent[3..FREE].copy_from_slice((zero_from_world * turn).as_slice());
                self.tangent[FREE..].copy_from_slice(&self.step[ROOT..]);
            }
        }
        self.skeleton.integrate(q, &self.tangent, share);
    }
}
