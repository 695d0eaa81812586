//! Pins of one motion, held frame by frame.
//!
//! In: a clip as it is now. Out: the same with every pin held. Goals of a frame: a pin whole at its target; in a blend
//! `g = x + w (target − x)`, x where the point would be without pins. x is remembered from the motion before the pins, against its root:
//! a root that was moved since takes it along, so a clip held, moved and held again is continuous at the ends of the blends.
//!
//! Where a frame starts: from its own pose, moved by what the frame before was moved, less a little ([`FORGET_S`]): solutions follow
//! one valley from frame to frame, and what no point sees (the twist of a collar bone) goes back to where it was.
//!
//! A line of sight is a point 1 m ahead of the eyes. Its goal, and that of a point on another link, depend on the pose: they are
//! set anew until they rest.
//!
//! Limbs that stand are pinned exactly; limbs in the air, of bodies of which it is known when they stand, are dragged along their
//! own way, far more weakly than pins. Pins are dragged so strongly that they are met to [`motion::ik::pose`]'s micrometres
//! where they can be met; where not, feet have precedence.

use std::fmt;
use std::sync::Arc;

use motion::ik::pose::{Handle, Hold, PoseError, Poser, Rules};
use motion::rotation::{between, exp, log};
use motion::{Clip, ContactPlan, Kinematics, Skeleton, Vec3};

use super::{EYES, GAZE, Pin, PinAt, unedited};
use crate::pose_request::point;
use crate::{ClipPlace, EditError, Motion};

/// Weight of a pin, against 1 of a limb in the air and 1e-4 of joints that would stay.
const PIN: f64 = 1e3;
/// Time in which what a frame took over from the one before fades by e, s.
const FORGET_S: f64 = 0.1;
/// Most rounds of one frame, and the way of goals that rest, m.
const MOST_ROUNDS: usize = 60;
const RESTS_M: f64 = 1e-8;
/// Stride of the first frame, m.
const STRIDE_M: f64 = 0.02;
/// Points that hold a limb's end in place and turn are this far apart, m.
const APART_M: f64 = 0.1;
/// Held within this: m, rad.
const HELD_M: f64 = 1e-3;
const HELD_RAD: f64 = 0.5 * std::f64::consts::PI / 180.0;

/// What is held of a link.
#[derive(Clone, Debug)]
enum Point {
    Place { link: usize, at: Vec3 },
    /// Eyes and the direction of their sight, in the link's frame.
    Sight { link: usize, at: Vec3, forward: Vec3 },
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
    /// Where it would be without pins, against the root; or its direction.
    free: Vec<Vec3>,
    weights: Vec<f64>,
    name: String,
}

/// The pins of one motion. See the module header.
#[derive(Clone, Debug)]
pub struct Holds {
    held: Vec<Held>,
    /// The ends of limbs, links and sites that stand at times.
    standing: Vec<Standing>,
    skeleton: Arc<Skeleton>,
    poser: Poser,
    limits: bool,
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
        let free = (0..clip.frames()).map(|f| match point {
            Point::Place { .. } => {
                let k = Kinematics::new(s, clip.pose(f));
                point.read(&k) - k.origin(0)
            }
            Point::Sight { .. } => read(clip, f),
        });
        let near = 0.5 / clip.rate_hz;
        let weights = (0..clip.frames()).map(|f| pin.weight(at, near, f as f64 / clip.rate_hz));
        Ok(Self {
            free: free.collect(),
            weights: weights.collect(),
            target,
            name: if pin.is_gaze() { GAZE.into() } else { pin.point.clone() },
            point,
        })
    }

    /// Where it should be: a place, or a unit direction.
    fn wanted(&self, f: usize, k: &Kinematics) -> Vec3 {
        let place = match &self.target {
            Target::World(place) => *place,
            Target::Link(link, at) => k.point(*link, at),
            Target::Path(path) => path[f],
        };
        match (&self.point, &self.target) {
            (Point::Sight { link, at, .. }, Target::World(_) | Target::Link(..)) => {
                (place - k.point(*link, at)).try_normalize(1e-6).unwrap_or_else(|| self.point.read(k))
            }
            _ => place,
        }
    }

    /// The handle of a frame in the pose that `k` is of.
    fn handle(&self, f: usize, k: &Kinematics) -> Handle {
        let (w, wanted) = (self.weights[f], self.wanted(f, k));
        let hold = Hold::Dragged(PIN);
        match &self.point {
            Point::Place { link, at } => {
                let free = k.origin(0) + self.free[f];
                let place = if w < 1.0 { free + (wanted - free) * w } else { wanted };
                Handle { link: *link, at: *at, place, hold }
            }
            Point::Sight { link, at, forward } => {
                let turn = log(&between(&self.free[f], &wanted)) * w;
                let looks = if w < 1.0 { exp(&turn) * self.free[f] } else { wanted };
                Handle { link: *link, at: at + forward, place: k.point(*link, at) + looks, hold }
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
        Ok(Self {
            held: pins.iter().map(|pin| Held::new(pin, motion, at)).collect::<Result<_, _>>()?,
            standing: Standing::all(&motion.clip, &motion.contacts),
            skeleton: s.clone(),
            poser: Poser::new(s),
            limits: s.links().iter().any(|l| l.limits.is_some()),
        })
    }

    /// Moves every frame of `clip`, which is the motion the pins were planned for or that motion moved since, onto the pins.
    ///
    /// # Errors
    /// Poses that are not finite.
    ///
    /// # Panics
    /// If the clip has other frames.
    pub fn hold(&mut self, clip: &mut Clip) -> Result<(), EditError> {
        let s = clip.skeleton.clone();
        let keep = (-1.0 / (clip.rate_hz * FORGET_S)).exp();
        let mut moved: Option<Vec<f64>> = None;
        for f in 0..clip.frames() {
            if self.held.iter().all(|h| h.weights[f] == 0.0) {
                moved = None;
                continue;
            }
            let base = clip.pose(f).to_vec();
            let mut q = base.clone();
            if let Some(moved) = &moved {
                s.integrate(&mut q, moved, keep);
            }
            self.frame(f, &base, &mut q, moved.is_none())
                .map_err(|source| EditError::Pose { edit: "pin", source })?;
            let mut delta = vec![0.0; s.nv()];
            s.difference(&base, &q, 1.0, &mut delta);
            moved = Some(delta);
            clip.pose_mut(f).copy_from_slice(&q);
        }
        Ok(())
    }

    /// Holds one frame: from `base`, starting at `q`.
    fn frame(
        &mut self,
        f: usize,
        base: &[f64],
        q: &mut [f64],
        first: bool,
    ) -> Result<(), PoseError> {
        let s = &self.skeleton;
        let mut weights = vec![1.0; s.links().len()];
        let acting: Vec<&Held> = self.held.iter().filter(|h| h.weights[f] > 0.0).collect();
        for held in acting.iter().filter(|h| matches!(h.point, Point::Sight { .. })) {
            // a head that looks elsewhere has to turn: where its own points were says nothing
            weights[held.point.link()] = 0.0;
        }
        let rules = Rules { weights: &weights, groups: &[], limits: self.limits };
        self.poser.begin(base, rules)?;
        let mut k = Kinematics::new(s, base);
        let mut handles: Vec<Handle> = Vec::new();
        for standing in &self.standing {
            if acting.iter().any(|h| h.point.link() == standing.link) {
                continue;
            }
            let hold = if standing.stands[f] { Hold::Pinned } else { Hold::Dragged(1.0) };
            let handle =
                |at: &Vec3| Handle { link: standing.link, at: *at, place: k.point(standing.link, at), hold };
            handles.extend(standing.at.iter().map(handle));
        }
        let feet = handles.len();
        if first {
            k.update(s, q);
            handles.extend(acting.iter().map(|h| h.handle(f, &k)));
            self.poser.walk(&handles, STRIDE_M, q)?;
        }
        for _ in 0..MOST_ROUNDS {
            k.update(s, q);
            let goals: Vec<Handle> = acting.iter().map(|h| h.handle(f, &k)).collect();
            let went = handles[feet..].iter().zip(&goals).map(|(a, b)| (a.place - b.place).norm());
            let rests = handles.len() > feet && went.fold(0.0, f64::max) < RESTS_M;
            handles.truncate(feet);
            handles.extend(goals);
            let posed = self.poser.drag(&handles, q)?;
            if posed.still && rests {
                break;
            }
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
