//! Pins of one motion, held frame by frame.
//!
//! In: a clip as it is now. Out: the same with every pin held. A frame, with pose `q`:
//!
//! 1. *Whole.* Pins that come and go together are a layer, with one weight w. The pose P in which they are held is that of least
//!    departure in joint values ([`motion::ik::whole_body`]), each weighed by how far it carries the body ([`departure`]): an arm
//!    reaches before a trunk bends. What layers before hold stays there, what stands stays.
//! 2. *Blended.* `B = q ⊕ w (P ⊖ q)`, joint by joint: no path through space is faster in the joints. The next layer begins at B.
//! 3. *Exact.* [`motion::ik::pose`] takes B onto the pins that are whole and the limbs that stand, within the limits of joints.
//!
//! A frame starts where the frame before ended (against its own pose), so solutions follow one valley. Held again, every frame begins
//! at the pose it had before any pin, its root moved by what others moved it since: blends do not add up. A line of sight is the
//! point of it that is as far ahead as what it looks at. Its goal, and that of a point on another link, depend on the pose: they are set anew
//! until they rest.
//!
//! Limbs in the air, of bodies of which it is known when they stand, are dragged along their own way, far more weakly than pins.
//! Where pins cannot be met feet have precedence.

use std::fmt;
use std::sync::Arc;

use motion::ik::pose::{Handle, Hold, PoseError, Poser, Rules};
use motion::ik::{Goal, JointAxes, Method, Problem, Unknowns, WholeBody, whole_body};
use motion::rotation::{between, log};
use motion::{Clip, ContactPlan, Joint, Kinematics, Skeleton, Vec3};

use super::{EYES, GAZE, Pin, PinAt, unedited};
use crate::pose_request::point;
use crate::{ClipPlace, EditError, Motion};

/// Weight of a pin when it is made exact, against 1 of a limb in the air and 1e-4 of joints that would stay.
const PIN: f64 = 1e3;
/// Weights of pins, of limbs that stand and of limbs in the air in the whole pose, 1/m², and of ways beyond limits, 1/rad².
const WHOLE: [f64; 3] = [1e4, 1e6, 1e2];
const LIMITS: f64 = 1e3;
/// Added to the weight of every departure: what carries nothing is not free, 1/rad².
const STAYS: f64 = 0.3;
/// Most rounds of a frame, and the way of goals that rest, m.
const MOST_ROUNDS: usize = 30;
const RESTS_M: f64 = 1e-7;
/// The same of a whole pose, which is made exact afterwards.
const NEARLY_M: f64 = 1e-4;
/// Strides in which the first frame goes to its goals.
const STRIDES: usize = 20;
/// Points that hold a limb's end in place and turn are this far apart, m.
const APART_M: f64 = 0.1;
/// A limb that stands has come off if it is farther from its place, m.
const SLIPS_M: f64 = 1e-5;
/// Held within this: m, rad.
const HELD_M: f64 = 1e-3;
const HELD_RAD: f64 = 0.5 * std::f64::consts::PI / 180.0;

/// What is held of a link.
#[derive(Clone, Debug)]
enum Point {
    Place {
        link: usize,
        at: Vec3,
    },
    /// Eyes and the direction of their sight, in the link's frame.
    Sight {
        link: usize,
        at: Vec3,
        forward: Vec3,
    },
}

#[derive(Clone, Debug)]
enum Target {
    World(Vec3),
    Link(usize, Vec3),
    /// A place or a direction for each frame.
    Path(Vec<Vec3>),
}

#[derive(Clone, Debug)]
struct Held {
    point: Point,
    target: Target,
    weights: Vec<f64>,
    name: String,
}

/// The pins of one motion. See the module header.
#[derive(Clone, Debug)]
pub struct Holds {
    held: Vec<Held>,
    /// Pins that come and go together, in the order of the first.
    layers: Vec<Vec<usize>>,
    /// The ends of limbs, links and sites that stand at times.
    standing: Vec<Standing>,
    skeleton: Arc<Skeleton>,
    poser: Poser,
    whole: WholeBody,
    /// Weight of the departure of each degree of freedom.
    departure: Vec<f64>,
    limits: bool,
    /// The motion before any pin; how far its roots were moved since, and where roots were when the pins were held last.
    before: Clip,
    shifts: Vec<Vec3>,
    roots: Vec<Vec3>,
    /// For each layer and frame, what moves it to the whole pose.
    moved: Vec<Vec<Option<Vec<f64>>>>,
}

#[derive(Clone, Debug)]
struct Standing {
    link: usize,
    at: Vec<Vec3>,
    /// Whether it stands, for each frame.
    stands: Vec<bool>,
}

/// How well a pin is held over its span. Displayed as the log says it.
#[derive(Clone, Debug, PartialEq)]
pub struct Missed {
    /// The point.
    pub point: String,
    /// Whether it is the line of sight.
    pub gaze: bool,
    /// From when to when it is held, s.
    pub span_s: (f64, f64),
    /// The worst miss: mm, or degrees of the line of sight.
    pub most: f64,
    /// When that is, s.
    pub at_s: f64,
    /// When it misses by more than 1 mm, or 0.5°, s: first and last such frame; `None` where it is held.
    pub beyond_s: Option<(f64, f64)>,
}

impl fmt::Display for Missed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (unit, digits) = if self.gaze { ("°", 2) } else { (" mm", 3) };
        let Self { point, span_s: (from_s, to_s), most, at_s, .. } = self;
        match self.beyond_s {
            None => write!(f, "{point} held from {from_s:.3} s to {to_s:.3} s within {most:.digits$}{unit}"),
            Some((first, last)) => write!(
                f,
                "{point} cannot be held: it misses by up to {most:.1}{unit}, at {at_s:.3} s, and is beyond {} from \
                 {first:.3} s to {last:.3} s",
                if self.gaze { "0.5°" } else { "1 mm" }
            ),
        }
    }
}

impl Point {
    fn of(s: &Skeleton, pin: &Pin) -> Result<Self, EditError> {
        if pin.is_gaze() {
            let sites = s.sites().iter().map(|site| site.name.as_str());
            let eyes = s.site(EYES).ok_or_else(|| EditError::unknown("site", EYES, sites))?;
            let zero = Kinematics::new(s, &s.zero_pose());
            let forward = zero.world[eyes.link].rotation.inverse() * Vec3::z();
            moved_point(pin)?;
            return Ok(Self::Sight { link: eyes.link, at: eyes.at, forward });
        }
        let (link, at) = point(s, &pin.point)?;
        if s.link(&pin.point).is_none() {
            moved_point(pin)?;
        }
        Ok(Self::Place { link, at: at + Vec3::from(pin.point_m) })
    }

    fn link(&self) -> usize {
        match self {
            Self::Place { link, .. } | Self::Sight { link, .. } => *link,
        }
    }

    /// Its place, or its direction.
    fn read(&self, k: &Kinematics) -> Vec3 {
        match self {
            Self::Place { link, at } => k.point(*link, at),
            Self::Sight { link, forward, .. } => k.world[*link].rotation * forward,
        }
    }
}

/// A site has its place already.
fn moved_point(pin: &Pin) -> Result<(), EditError> {
    match pin.point_m.iter().find(|x| **x != 0.0) {
        None => Ok(()),
        Some(&value) => Err(EditError::Parameter {
            edit: "pin",
            what: "`point_m`",
            value,
            at: format!(" for `{}`", pin.point),
            allowed: "zeros: only points of links are moved by it",
        }),
    }
}

impl Held {
    fn new(pin: &Pin, motion: &Motion, at: &ClipPlace) -> Result<Self, EditError> {
        let (clip, s) = (&motion.clip, &motion.clip.skeleton);
        let point = Point::of(s, pin)?;
        let read = |clip: &Clip, f: usize| point.read(&Kinematics::new(s, clip.pose(f)));
        let target = match &pin.at {
            PinAt::World(place) => Target::World(Vec3::from(*place)),
            PinAt::Link(name, place) => {
                let known = s.links().iter().map(|l| l.name.as_str());
                let link = s.link(name).ok_or_else(|| EditError::unknown("link", name, known))?;
                // what the point carries, or is part of, goes where it goes
                if s.ancestors(link).any(|above| above == point.link()) {
                    let (point, link) = (pin.point.clone(), name.clone());
                    return Err(EditError::PinnedToItself { point, link });
                }
                Target::Link(link, Vec3::from(*place))
            }
            PinAt::Asked => {
                let before = unedited(motion);
                Target::Path((0..clip.frames()).map(|f| read(&before, f)).collect())
            }
        };
        let near = 0.5 / clip.rate_hz;
        let weights = (0..clip.frames()).map(|f| pin.weight(at, near, f as f64 / clip.rate_hz));
        Ok(Self {
            weights: weights.collect(),
            target,
            name: if pin.is_gaze() { GAZE.into() } else { pin.point.clone() },
            point,
        })
    }

    /// The place that a point is held at, or that eyes look at; `None` of eyes that look in a direction.
    fn looked_at(&self, f: usize, k: &Kinematics) -> Option<Vec3> {
        match (&self.target, &self.point) {
            (Target::World(place), _) => Some(*place),
            (Target::Link(link, at), _) => Some(k.point(*link, at)),
            (Target::Path(path), Point::Place { .. }) => Some(path[f]),
            (Target::Path(_), Point::Sight { .. }) => None,
        }
    }

    /// Where it should be: a place, or a unit direction.
    fn wanted(&self, f: usize, k: &Kinematics) -> Vec3 {
        match (&self.point, &self.target, self.looked_at(f, k)) {
            (Point::Place { .. }, _, Some(place)) => place,
            (Point::Sight { link, at, .. }, _, Some(place)) => {
                (place - k.point(*link, at)).try_normalize(1e-6).unwrap_or_else(|| self.point.read(k))
            }
            (_, Target::Path(path), None) => path[f],
            _ => self.point.read(k),
        }
    }

    /// The point that is moved, and where to, in the pose that `k` is of; of the line of sight the point that is as far ahead as what
    /// it looks at, and the line.
    fn goal(&self, f: usize, k: &Kinematics) -> (Vec3, Vec3, Option<Vec3>) {
        let wanted = self.wanted(f, k);
        match &self.point {
            Point::Place { at, .. } => (*at, wanted, None),
            Point::Sight { link, at, forward } => {
                let eyes = k.point(*link, at);
                let ahead = self.looked_at(f, k).map_or(1.0, |place| (place - eyes).norm().max(0.1));
                (at + forward * ahead, eyes + wanted * ahead, Some(wanted))
            }
        }
    }

    /// How far it is from where it should be: m or rad.
    fn miss(&self, f: usize, k: &Kinematics) -> f64 {
        let (is, wanted) = (self.point.read(k), self.wanted(f, k));
        match self.point {
            Point::Place { .. } => (is - wanted).norm(),
            Point::Sight { .. } => log(&between(&is, &wanted)).norm(),
        }
    }
}

impl Standing {
    /// What stands at times in a clip; names that the body does not have are of no point of it.
    fn all(clip: &Clip, contacts: &ContactPlan) -> Vec<Self> {
        let s = &clip.skeleton;
        let mut names: Vec<&str> = contacts.contacts().iter().map(|c| c.point.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        let standing = names.into_iter().filter_map(|name| {
            let (link, at) = match s.limbs().iter().find(|limb| limb.name == name) {
                // three points hold place and turn
                Some(limb) => {
                    let corners = [Vec3::zeros(), Vec3::x() * APART_M, Vec3::z() * APART_M];
                    (limb.end, corners.to_vec())
                }
                None => point(s, name).ok().map(|(link, at)| (link, vec![at]))?,
            };
            let stands = |f: usize| {
                let t_s = f as f64 / clip.rate_hz;
                contacts.of(name).any(|c| c.from_s <= t_s && t_s <= c.to_s)
            };
            Some(Self { link, at, stands: (0..clip.frames()).map(stands).collect() })
        });
        standing.collect()
    }
}

impl Holds {
    pub(super) fn new(pins: &[Pin], motion: &Motion, at: &ClipPlace) -> Result<Self, EditError> {
        let s = &motion.clip.skeleton;
        let when = |pin: &Pin| (pin.from_s, pin.to_s, pin.blend_s);
        let mut layers: Vec<Vec<usize>> = Vec::new();
        for (i, pin) in pins.iter().enumerate() {
            match layers.iter_mut().find(|layer| when(&pins[layer[0]]) == when(pin)) {
                Some(layer) => layer.push(i),
                None => layers.push(vec![i]),
            }
        }
        let frames = motion.clip.frames();
        Ok(Self {
            held: pins.iter().map(|pin| Held::new(pin, motion, at)).collect::<Result<_, _>>()?,
            moved: vec![vec![None; frames]; layers.len()],
            shifts: vec![Vec3::zeros(); frames],
            roots: (0..frames).map(|f| root(s, motion.clip.pose(f))).collect(),
            before: motion.clip.clone(),
            layers,
            standing: Standing::all(&motion.clip, &motion.contacts),
            skeleton: s.clone(),
            poser: Poser::new(s),
            whole: WholeBody::new(s, Unknowns::All),
            departure: departure(s),
            limits: s.links().iter().any(|l| l.limits.is_some()),
        })
    }

    /// Moves every frame of `clip` onto the pins. It is the motion the pins were planned for, or what came of holding that, its root
    /// moved since and its limbs planted again.
    ///
    /// # Errors
    /// Poses that are not finite.
    ///
    /// # Panics
    /// If the clip has other frames.
    pub fn hold(&mut self, clip: &mut Clip) -> Result<(), EditError> {
        let s = self.skeleton.clone();
        for f in 0..clip.frames() {
            if self.held.iter().all(|h| h.weights[f] == 0.0) {
                continue;
            }
            let feet = self.feet(f, clip.pose(f));
            self.shifts[f] += root(&s, clip.pose(f)) - self.roots[f];
            let mut q = self.before.pose(f).to_vec();
            if self.shifts[f] != Vec3::zeros() {
                let place = s.position(&q, 0) + self.shifts[f];
                s.set_position(&mut q, 0, &place);
            }
            for layer in 0..self.layers.len() {
                let w = self.held[self.layers[layer][0]].weights[f];
                if w > 0.0 {
                    self.blend(layer, f, w, &feet, &mut q);
                }
            }
            self.exact(f, &feet, &mut q).map_err(|source| EditError::Pose { edit: "pin", source })?;
            self.roots[f] = root(&s, &q);
            clip.pose_mut(f).copy_from_slice(&q);
        }
        Ok(())
    }

    /// What stands, or goes its own way, in the pose `q` of a frame; what is pinned at the time is left out.
    fn feet(&self, f: usize, q: &[f64]) -> Vec<Handle> {
        let k = Kinematics::new(&self.skeleton, q);
        let pinned = |link: usize| self.held.iter().any(|h| h.weights[f] > 0.0 && h.point.link() == link);
        let mut feet = Vec::new();
        for standing in self.standing.iter().filter(|standing| !pinned(standing.link)) {
            let hold = if standing.stands[f] { Hold::Pinned } else { Hold::Dragged(1.0) };
            let link = standing.link;
            feet.extend(standing.at.iter().map(|at| Handle {
                link,
                at: *at,
                place: k.point(link, at),
                hold,
            }));
        }
        feet
    }

    /// Moves `q` by the share `w` to the pose in which a layer is whole.
    fn blend(&mut self, layer: usize, f: usize, w: f64, feet: &[Handle], q: &mut [f64]) {
        let s = self.skeleton.clone();
        let base = q.to_vec();
        let mut k = Kinematics::new(&s, &base);
        let known = &self.moved[layer];
        let moved = known[f].as_ref().or(f.checked_sub(1).and_then(|before| known[before].as_ref()));
        let strides = if moved.is_some() { 1 } else { STRIDES };
        if let Some(moved) = moved {
            s.integrate(q, moved, 1.0);
        }
        let along = |link: usize, at: Vec3, place: Vec3, weight: f64, along| {
            let goal = Some(Goal { place, weight, along });
            whole_body::Point { link, at, goal, on_floor: false }
        };
        let point = |link, at, place, weight| along(link, at, place, weight, None);
        let [pins, stands, goes] = WHOLE;
        let mut points: Vec<whole_body::Point> = feet
            .iter()
            .map(|h| point(h.link, h.at, h.place, if h.hold == Hold::Pinned { stands } else { goes }))
            .collect();
        for held in self.layers[..layer].iter().flatten().map(|&i| &self.held[i]) {
            if held.weights[f] > 0.0 {
                let (at, ..) = held.goal(f, &k);
                let link = held.point.link();
                points.push(point(link, at, k.point(link, &at), pins));
            }
        }
        let fixed = points.len();
        let method = Method::LevenbergMarquardt { most_steps: 12, enough: 1e-6 };
        for round in 1..strides + MOST_ROUNDS {
            k.update(&s, q);
            let left = strides.saturating_sub(round) as f64 / (strides.saturating_sub(round) + 1) as f64;
            let goals: Vec<whole_body::Point> = self.layers[layer]
                .iter()
                .map(|&i| &self.held[i])
                .map(|held| {
                    let ((at, to, line), link) = (held.goal(f, &k), held.point.link());
                    let from = k.point(link, &at);
                    along(link, at, to + (from - to) * left, pins, line)
                })
                .collect();
            let place = |p: &whole_body::Point| p.goal.map_or(Vec3::zeros(), |g| g.place);
            let went = points[fixed..].iter().zip(&goals).map(|(a, b)| (place(a) - place(b)).norm());
            if points.len() > fixed && round > strides && went.fold(0.0, f64::max) < NEARLY_M {
                break;
            }
            points.truncate(fixed);
            points.extend(goals);
            let problem = Problem {
                points: &points,
                reference: &base,
                weights: &self.departure,
                limit_weight: LIMITS,
                floor: None,
            };
            self.whole.solve(&problem, method, q, &|_, _| {});
        }
        let mut delta = vec![0.0; s.nv()];
        s.difference(&base, q, 1.0, &mut delta);
        if w < 1.0 {
            q.copy_from_slice(&base);
            s.integrate(q, &delta, w);
        }
        self.moved[layer][f] = Some(delta);
    }

    /// Takes `q` onto the pins that are whole and the limbs that stand.
    fn exact(&mut self, f: usize, feet: &[Handle], q: &mut [f64]) -> Result<(), PoseError> {
        let s = &self.skeleton;
        let mut weights = vec![1.0; s.links().len()];
        let whole: Vec<&Held> = self.held.iter().filter(|h| h.weights[f] >= 1.0).collect();
        for held in whole.iter().filter(|h| matches!(h.point, Point::Sight { .. })) {
            // a head that looks elsewhere has to turn: where its own points were says nothing
            weights[held.point.link()] = 0.0;
        }
        if self.limits {
            s.clamp_to_limits(q);
        }
        let rules = Rules { weights: &weights, groups: &[], limits: self.limits };
        self.poser.begin(q, rules)?;
        let mut handles = feet.to_vec();
        let mut k = Kinematics::new(s, q);
        for _ in 0..MOST_ROUNDS {
            k.update(s, q);
            let goal = |held: &&Held| {
                let (at, place, _) = held.goal(f, &k);
                Handle { link: held.point.link(), at, place, hold: Hold::Dragged(PIN) }
            };
            let goals: Vec<Handle> = whole.iter().map(goal).collect();
            let went = handles[feet.len()..].iter().zip(&goals).map(|(a, b)| (a.place - b.place).norm());
            let rests = handles.len() == feet.len() + goals.len() && went.fold(0.0, f64::max) < RESTS_M;
            handles.truncate(feet.len());
            handles.extend(goals);
            if handles.is_empty() {
                break;
            }
            let posed = self.poser.drag(&handles, q)?;
            if posed.still && rests {
                break;
            }
        }
        // pulled from far beyond their reach limbs that stand come off by millimetres: they have precedence
        let off = self.poser.misses().iter().zip(feet).filter(|(_, h)| h.hold == Hold::Pinned);
        if off.fold(0.0_f64, |m, (miss, _)| m.max(*miss)) > SLIPS_M {
            for _ in 0..MOST_ROUNDS {
                if self.poser.drag(feet, q)?.still {
                    break;
                }
            }
        }
        if self.limits {
            s.clamp_to_limits(q);
        }
        Ok(())
    }

    /// How well each pin is held in `clip`, over the frames in which it is whole; in the order of the pins.
    pub fn missed(&self, clip: &Clip) -> Vec<Missed> {
        let s = &clip.skeleton;
        let time = |f: usize| f as f64 / clip.rate_hz;
        let one = |held: &Held| {
            let gaze = matches!(held.point, Point::Sight { .. });
            let (limit, unit) = if gaze { (HELD_RAD, 1f64.to_degrees()) } else { (HELD_M, 1e3) };
            let frames: Vec<usize> = (0..clip.frames()).filter(|&f| held.weights[f] >= 1.0).collect();
            let (mut most, mut at_s, mut beyond_s) = (0.0, 0.0, None::<(f64, f64)>);
            for &f in &frames {
                let miss = held.miss(f, &Kinematics::new(s, clip.pose(f)));
                if miss > most {
                    (most, at_s) = (miss, time(f));
                }
                if miss > limit {
                    beyond_s = Some((beyond_s.map_or(time(f), |b| b.0), time(f)));
                }
            }
            let ends = frames.first().zip(frames.last());
            Missed {
                point: held.name.clone(),
                gaze,
                span_s: ends.map_or((0.0, 0.0), |(a, b)| (time(*a), time(*b))),
                most: most * unit,
                at_s,
                beyond_s,
            }
        };
        self.held.iter().map(one).collect()
    }
}

/// Weight of the departure of each degree of freedom, 1/rad² or 1/m²: the square of how far a unit of it moves the joints and ends it
/// carries, in the zero pose, summed. An arm is lighter than a trunk.
fn departure(s: &Skeleton) -> Vec<f64> {
    let k = Kinematics::new(s, &s.zero_pose());
    let mut axes = JointAxes::new(s);
    axes.update(s, &k);
    let mut weights = vec![STAYS; s.nv()];
    for (link, l) in s.links().iter().enumerate() {
        for at in [Some(Vec3::zeros()), l.end].into_iter().flatten() {
            let x = k.point(link, &at);
            for &d in &axes.chain[link] {
                weights[d] += axes.all[d].column(&x).norm_squared();
            }
        }
    }
    weights
}

/// Where a root that may go is, m.
fn root(s: &Skeleton, q: &[f64]) -> Vec3 {
    if matches!(s.links()[0].joint, Joint::Free) { s.position(q, 0) } else { Vec3::zeros() }
}
