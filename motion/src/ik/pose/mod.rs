//! Posing by dragging: any joints or points to where they are dragged, others pinned, the rest as near as it can stay (IAF09, §5).
//!
//! In: a pose, [`Rules`] (what resists how much, what moves as one piece, whether limits hold) and [`Handle`]s: points of links
//! that are dragged or pinned. Out: the pose `q` that minimises
//!
//! ```text
//! E(q) = ½ Σ_d w_d |x_d(q) − g_d|² + ½ ρ Σ_i w_i |x_i(q) − a_i|²     with pins  x_p(q) = g_p
//! ```
//!
//! Symbols: `x_d` dragged points, `g_d` where to (world, m), `w_d` their weights; `x_i` all joints, and of links without children
//! the ends of their bones and their sites, such as the corners of soles (which share a weight); `a_i` where each was when the
//! drag began, `w_i` the weight of its link, ρ = [`RESISTANCE`]. What hangs on a handle goes with it: its `a_i` are shifted by what the nearest handle above was moved.
//!
//! *Positions or angles.* The paper's unknowns are joint positions, with a constraint for the length of every bone. Here they are
//! the joint values, and the cost stays the paper's, in positions. Bones then have their lengths by construction (to
//! rounding; Newton on lengths stops at some residue), a pelvis with three children cannot turn inside out, hinges and slides
//! are kept (no positions of a lamp's or a knee's bones say that they turn about one axis), and limits are those of the
//! joints. The matrix is as sparse: [`system`] assembles the points as the mass matrix of a tree and factors it
//! without fill-in. What positions leave open, the twist of a bone between balls, is decided as in the paper: [`turn`] turns each bone
//! by the least rotation from the pose before the drag. Balls have it so; balls with limits that are kept stay as solved.
//!
//! *Newton.* Full second derivatives, forces included: with Gauss–Newton alone a limb that is pulled at from afar swings
//! past its target. Where they are not positive definite, Gauss–Newton's part is taken. Pins are constraints with multipliers (a step
//! along them, and one back onto them); constraints that contradict each other or cannot be reached meet in the sense of
//! least squares ([`system::COMPLIANCE`]).
//!
//! *Continuity.* A drag starts from the pose of the last one, so the answer follows a valley of E; and no joint turns by more
//! than [`MOST_TURN`] in one call. A valley may end (a hand is dragged straight through its shoulder): then the body
//! goes over to the next one in steps of that size, in the calls that follow. [`Poser::walk`] drags along a straight line.
//!
//! It is not [`whole_body`](super::whole_body): there all goals are soft terms beside a departure in joint values, for every
//! frame of a clip by fixed steps whose sums are part of written results; here pins are exact, every joint is an anchor, and a
//! call goes on from the last.
//!
//! IAF09: Ikemoto, Arikan, Forsyth. Generalizing motion edits with Gaussian processes. ACM TOG 28(1), 2009.

mod check;
mod limits;
mod solve;
pub mod system;
pub mod turn;

pub use check::PoseError;

use std::sync::Arc;

use self::system::System;
use self::turn::Seen;
use super::axes::JointAxes;
use crate::rotation::Quat;
use crate::skeleton::Limits;
use crate::symmetry::size_m;
use crate::{Joint, Kinematics, Range, Skeleton, Transform, Vec3};

/// ρ: what a joint of weight 1 resists its displacement with, against a drag of weight 1.
///
/// So small that a drag that can be met is met within some thousandths of its way.
pub const RESISTANCE: f64 = 1e-4;

/// Most that a joint turns in one call, rad, or a root or slide moves, m.
pub const MOST_TURN: f64 = 0.25;

/// What every joint resists a step with, 1/rad², in parts of ρ times the square of the body's size: it settles what no point sees, and
/// makes a body that has to go over to another valley go there in calls, not in one.
const VISCOSITY: f64 = 0.07;

/// Most strides of a walk, and most calls until the body rests after it.
const MOST_STRIDES: usize = 100_000;
const MOST_CALLS: usize = 200;

/// What holds of a pose while it is dragged.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rules<'a> {
    /// Weight of each link (one for each, ≥ 0): how firmly its joint stays where it was. Empty: 1 everywhere.
    pub weights: &'a [f64],
    /// Links that move as one rigid piece, for each piece; they need not touch each other.
    pub groups: &'a [Vec<usize>],
    /// Whether joints keep their limits. One that is beyond them from the start may stay there, and goes no further.
    pub limits: bool,
}

/// A point that is dragged or pinned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Handle {
    /// Its link.
    pub link: usize,
    /// Where it is in the link's frame, m; zero is the joint.
    pub at: Vec3,
    /// Where it should be, world, m.
    pub place: Vec3,
    /// How firmly.
    pub hold: Hold,
}

/// How firmly a handle is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hold {
    /// Exactly, where it can be reached.
    Pinned,
    /// As well as the rest allows; the weight w_d > 0, 1 if nothing else is known.
    Dragged(f64),
}

impl Handle {
    /// The joint of a link, dragged to a place (world, m).
    pub fn drag(link: usize, place: Vec3) -> Self {
        Self { link, at: Vec3::zeros(), place, hold: Hold::Dragged(1.0) }
    }

    /// The joint of a link, pinned to a place (world, m).
    pub fn pin(link: usize, place: Vec3) -> Self {
        Self { link, at: Vec3::zeros(), place, hold: Hold::Pinned }
    }
}

/// How a call ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Posed {
    /// Newton steps taken.
    pub steps: usize,
    /// Whether the body rests; if not, another call with the same handles goes on.
    pub still: bool,
}

/// A joint that resists.
#[derive(Clone, Copy, Debug)]
struct Anchor {
    link: usize,
    at: Vec3,
    /// Where it was, and is pulled to.
    was: Vec3,
    to: Vec3,
    /// Its part of the weight of the link.
    share: f64,
    /// Whether it is a site.
    site: bool,
    weight: f64,
}

/// Two separate parts of one rigid piece: `second` keeps its place in the frame of `first`.
#[derive(Clone, Copy, Debug)]
struct Weld {
    first: usize,
    second: usize,
    first_from_second: Transform,
}

/// The solver for one skeleton, and its memory. [`Poser::drag`] does not allocate once it has seen as many handles.
///
/// # Examples
/// ```
/// use std::sync::Arc;
/// use motion::ik::pose::{Handle, Poser, Rules};
/// use motion::{Joint, Kinematics, Link, Skeleton, Vec3};
///
/// let ball = Joint::Spherical;
/// let links = vec![
///     Link::new("shoulder", None, Vec3::zeros(), ball),
///     Link::new("elbow", Some(0), Vec3::new(0.3, -0.05, 0.0), ball),
///     Link::new("wrist", Some(1), Vec3::new(0.25, 0.05, 0.0), ball),
/// ];
/// let s = Arc::new(Skeleton::new(links).unwrap());
/// let mut q = s.zero_pose();
/// let mut poser = Poser::new(&s);
/// poser.begin(&q, Rules::default()).unwrap();
/// let to = Vec3::new(0.4, 0.1, 0.0);
/// poser.walk(&[Handle::drag(2, to)], 0.02, &mut q).unwrap();
/// assert!((Kinematics::new(&s, &q).origin(2) - to).norm() < 1e-3);
/// ```
#[derive(Clone, Debug)]
pub struct Poser {
    skeleton: Arc<Skeleton>,
    k: Kinematics,
    axes: JointAxes,
    system: System,
    /// Resistance to a step, 1/rad².
    viscosity: f64,
    begun: bool,
    anchors: Vec<Anchor>,
    welds: Vec<Weld>,
    /// Ranges that joints keep, where they have limits.
    ranges: Vec<Option<[Range; 3]>>,
    /// Which links move with their parent; what positions say of each, and where a handle says more.
    joined: Vec<bool>,
    seen: Vec<Seen>,
    kept: Vec<bool>,
    turned: Vec<Quat>,
    /// Shift of what hangs on each link's handles, and how many handles the link has.
    shifts: Vec<(Vec3, usize)>,
    /// Kinematics of the pose that the drag began with.
    first: Kinematics,
    before: Vec<f64>,
    trial: Vec<f64>,
    /// Multipliers before a trial.
    multipliers: Vec<f64>,
    handles: Vec<Handle>,
    /// The handles of the last call.
    last: Vec<Handle>,
    misses: Vec<f64>,
}

impl Poser {
    /// A solver for a skeleton.
    pub fn new(skeleton: &Arc<Skeleton>) -> Self {
        let count = skeleton.links().len();
        let zero = skeleton.zero_pose();
        let (k, axes) = (Kinematics::new(skeleton, &zero), JointAxes::new(skeleton));
        let mut anchors = Vec::new();
        for (link, l) in skeleton.links().iter().enumerate() {
            let anchor = |at, share, site| Anchor {
                link,
                at,
                share,
                site,
                was: Vec3::zeros(),
                to: Vec3::zeros(),
                weight: 0.0,
            };
            anchors.push(anchor(Vec3::zeros(), 1.0, false));
            if skeleton.links().iter().any(|other| other.parent == Some(link)) {
                continue;
            }
            anchors.extend(l.end.map(|end| anchor(end, 1.0, false)));
            let sites = || skeleton.sites().iter().filter(|site| site.link == link);
            let count = sites().count() as f64;
            anchors.extend(sites().map(|site| anchor(site.at, 1.0 / count, true)));
        }
        Self {
            system: System::new(skeleton, &axes),
            first: k.clone(),
            before: zero.clone(),
            trial: zero,
            multipliers: Vec::new(),
            viscosity: VISCOSITY * RESISTANCE * size_m(skeleton).max(1e-3).powi(2),
            begun: false,
            anchors,
            welds: Vec::new(),
            ranges: vec![None; count],
            joined: vec![false; count],
            seen: Vec::new(),
            kept: vec![false; count],
            turned: vec![Quat::identity(); count],
            shifts: vec![(Vec3::zeros(), 0); count],
            handles: Vec::new(),
            last: Vec::new(),
            misses: Vec::new(),
            skeleton: skeleton.clone(),
            k,
            axes,
        }
    }

    /// Starts from a pose (`nq`): joints are pulled back to where they are in it, under these rules.
    ///
    /// # Errors
    /// Lengths, numbers that are not finite, weights below 0, links that do not exist, pieces of one link, links in two pieces.
    pub fn begin(&mut self, q: &[f64], rules: Rules) -> Result<(), PoseError> {
        let s = self.skeleton.clone();
        let links = s.links();
        self.check_pose(q)?;
        if !rules.weights.is_empty() && rules.weights.len() != links.len() {
            let (found, needed) = (rules.weights.len(), links.len());
            return Err(PoseError::Length { what: "the weights", found, needed });
        }
        for (link, &weight) in links.iter().zip(rules.weights) {
            if !(weight >= 0.0 && weight.is_finite()) {
                let link = link.name.clone();
                return Err(PoseError::Weight { link, weight, allowed: "finite, 0 or more" });
            }
        }
        self.check_groups(rules.groups)?;
        self.first.update(&s, q);
        for a in &mut self.anchors {
            a.was = self.first.point(a.link, &a.at);
            a.weight = RESISTANCE * a.share * rules.weights.get(a.link).copied().unwrap_or(1.0);
        }
        for (i, link) in links.iter().enumerate() {
            let wider = |r: &Range, x: f64| Range::new(r.lo.min(x), r.hi.max(x));
            self.ranges[i] = match (&link.limits, link.joint) {
                _ if !rules.limits => None,
                (Some(Limits::Axis(r)), Joint::Revolute(_) | Joint::Prismatic(_)) => {
                    Some([wider(r, q[s.q_at(i)]); 3])
                }
                (Some(Limits::Ball(b)), Joint::Spherical) => {
                    let phi = b.coords(&s.rotation(q, i));
                    Some(std::array::from_fn(|j| wider(&b.ranges[j], phi[j])))
                }
                _ => None,
            };
        }
        self.join(rules.groups);
        self.system.multipliers.clear();
        self.begun = true;
        Ok(())
    }

    /// Moves `q` (`nq`) to the pose that the handles ask for, from where it is. See the module header.
    ///
    /// The handles may differ from call to call; what is no longer held goes back to where it was.
    ///
    /// # Errors
    /// A pose that is not finite, handles that are not (or of no link, or at two places), none, and no [`Poser::begin`].
    pub fn drag(&mut self, handles: &[Handle], q: &mut [f64]) -> Result<Posed, PoseError> {
        self.check_pose(q)?;
        self.check_handles(handles)?;
        Ok(self.solve(handles, q))
    }

    /// Drags along straight lines from where the handles are now, and on until the body rests.
    ///
    /// * `stride_m`: most that a handle moves from one call to the next, m, > 0; 0.02 follows every way that was tried
    ///
    /// # Errors
    /// Those of [`Poser::drag`].
    pub fn walk(&mut self, handles: &[Handle], stride_m: f64, q: &mut [f64]) -> Result<Posed, PoseError> {
        self.check_pose(q)?;
        self.check_handles(handles)?;
        let s = self.skeleton.clone();
        self.k.update(&s, q);
        let mut moving = std::mem::take(&mut self.handles);
        moving.clear();
        moving.extend(handles.iter().map(|h| Handle { place: self.k.point(h.link, &h.at), ..*h }));
        let far = moving.iter().zip(handles).map(|(a, b)| (b.place - a.place).norm()).fold(0.0, f64::max);
        let strides = ((far / stride_m).ceil() as usize).clamp(1, MOST_STRIDES);
        let mut taken = 0;
        for i in 1..=strides {
            let left = (strides - i) as f64 / (strides - i + 1) as f64;
            for (m, h) in moving.iter_mut().zip(handles) {
                m.place = h.place + (m.place - h.place) * left;
            }
            taken += self.solve(&moving, q).steps;
        }
        self.handles = moving;
        let mut last = Posed { steps: taken, still: false };
        for _ in 0..MOST_CALLS {
            let posed = self.solve(handles, q);
            last = Posed { steps: last.steps + posed.steps, still: posed.still };
            if posed.still {
                break;
            }
        }
        Ok(last)
    }

    /// How far each handle of the last call is from its place, m.
    pub fn misses(&self) -> &[f64] {
        &self.misses
    }

    /// Where a point of a link is at the end of the last call, world, m.
    pub fn place(&self, link: usize, at: &Vec3) -> Vec3 {
        self.k.point(link, at)
    }

    /// Locks the joints inside rigid pieces, and finds what holds their separate parts together.
    fn join(&mut self, groups: &[Vec<usize>]) {
        let s = self.skeleton.clone();
        self.joined.fill(false);
        self.system.locked.fill(false);
        self.welds.clear();
        let mut whole: Vec<bool> = self.ranges.iter().map(Option::is_some).collect();
        for a in self.anchors.iter().filter(|a| a.site) {
            whole[a.link] = true;
        }
        for group in groups {
            let mut sorted = group.clone();
            sorted.sort_unstable();
            let mut first: Option<usize> = None;
            for &link in &sorted {
                if s.links()[link].parent.is_some_and(|p| sorted.contains(&p)) {
                    self.joined[link] = true;
                    let at = s.v_at(link);
                    self.system.locked[at..at + s.links()[link].joint.nv()].fill(true);
                } else if let Some(first) = first {
                    let first_from_second = self.first.world[first].inverse() * self.first.world[link];
                    self.welds.push(Weld { first, second: link, first_from_second });
                    (whole[first], whole[link]) = (true, true);
                } else {
                    first = Some(link);
                }
            }
        }
        self.seen = turn::seen(&s, &whole, &self.joined);
    }
}
