//! Pins: points of a body held where they are told while every other edit applies (NF03, its future work).
//!
//! In: a [`Motion`] as the edits before left it, and [`Pin`]s: points of links, or the line of sight, with where and from when to
//! when. Out: the motion in which they are held, all at once, by whole-body IK ([`motion::ik::pose`]): joints keep their limits,
//! what stands stays where it stands, and the rest of the body stays as near as it can to where it was.
//!
//! | held at | a point | the line of sight, [`GAZE`] |
//! |---|---|---|
//! | [`PinAt::World`] | at this place | on this place |
//! | [`PinAt::Link`] | at this point of another link, wherever that goes | on this point |
//! | [`PinAt::Asked`] | where it was before any edit ([`Motion::unedited`]) | as it was |
//!
//! A pin is whole from `from_s` to `to_s`. Within `blend_s` before and after, its goal goes over from where the point would be to
//! where it is held along the least-jerk curve ([`Curve::EaseInOut`]): the hand travels, so feet stand in the blends too. What
//! cannot be reached is approached, feet stay, and the log says how far it misses, and when ([`Missed`]).
//!
//! [`Pins`] is the edit; [`Holds`] is the same in two steps, for a caller that has a say between them (a body whose balance moves
//! the root): hold, let it move, hold again.
//!
//! The line of sight begins at the site [`EYES`] and looks along +Z as the zero pose has it. Units: m, s, world Y up.

mod hold;

use std::sync::Arc;

use motion::{Clip, Curve};

pub use hold::{Holds, Missed};

use crate::{ClipEdit, ClipPlace, EditError, EditLog, Edited, Motion};

/// The point that is the line of sight.
pub const GAZE: &str = "gaze";
/// The site that the line of sight begins at.
pub const EYES: &str = "eyes";
/// Times that differ by less are one time, s.
const SAME_S: f64 = 1e-9;
/// How long a pin takes to come, and to go, if nothing is said, s.
pub const BLEND_S: f64 = 0.4;

/// Where a point is held. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub enum PinAt {
    /// A place of the world, m.
    World([f64; 3]),
    /// A point of a link (in its frame, m).
    Link(String, [f64; 3]),
    /// Where it was before any edit.
    Asked,
}

/// One point held. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Pin {
    /// A link, a site, or [`GAZE`].
    pub point: String,
    /// A point of the link, in its frame, m; zero is its joint. Of sites and of the line of sight it must be zero.
    pub point_m: [f64; 3],
    /// Where it is held.
    pub at: PinAt,
    /// From when, s.
    pub from_s: f64,
    /// To when, s.
    pub to_s: f64,
    /// How long it comes and goes, s, ≥ 0.
    pub blend_s: f64,
}

impl Pin {
    /// Whether the line of sight is held.
    pub fn is_gaze(&self) -> bool {
        self.point == GAZE
    }

    /// How much of it acts at `t_s`, 0 to 1; a blend that would leave the place is made shorter.
    ///
    /// * `near`: half a frame, s: written times have few digits
    fn weight(&self, at: &ClipPlace, near: f64, t_s: f64) -> f64 {
        let ramp = |gone: f64, room: f64| {
            let whole = self.blend_s.min(room);
            if gone < near {
                1.0
            } else if gone >= whole - SAME_S {
                0.0
            } else {
                1.0 - Curve::EaseInOut.at(gone / whole)
            }
        };
        if t_s < self.from_s {
            ramp(self.from_s - t_s, self.from_s - at.from_s)
        } else {
            ramp(t_s - self.to_s, at.to_s - self.to_s)
        }
    }
}

/// Points held, all at once. See the module header.
///
/// ```
/// use std::sync::Arc;
/// use edits::pin::{BLEND_S, Pin, PinAt, Pins};
/// use edits::{ClipEdit, EditLog, Motion, Where};
/// use motion::{Clip, Joint, Kinematics, Link, Skeleton, Vec3};
///
/// let ball = Joint::Spherical;
/// let arm = vec![
///     Link::new("shoulder", None, Vec3::zeros(), ball),
///     Link::new("elbow", Some(0), Vec3::new(0.3, -0.05, 0.0), ball),
///     Link::new("wrist", Some(1), Vec3::new(0.25, 0.05, 0.0), ball),
/// ];
/// let s = Arc::new(Skeleton::new(arm).unwrap());
/// let still = Clip::new(s.clone(), 30.0, (0..61).flat_map(|_| s.zero_pose()).collect());
/// let at = PinAt::World([0.4, 0.1, 0.0]);
/// let wrist = Pin { point: "wrist".into(), point_m: [0.0; 3], at, from_s: 0.8, to_s: 1.2, blend_s: BLEND_S };
/// let mut log = EditLog::default();
/// let held = Pins { pins: vec![wrist] }.apply(&Motion::of(still), &Where::default(), &mut log).unwrap();
/// let k = Kinematics::new(&s, held.clip.pose(30));
/// assert!((k.origin(2) - Vec3::new(0.4, 0.1, 0.0)).norm() < 1e-5);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pins {
    /// The pins.
    pub pins: Vec<Pin>,
}

impl Pins {
    /// What holds them in a motion.
    ///
    /// # Errors
    /// Names that do not exist, numbers that are not finite, times out of order or outside the place, a point held on what it
    /// carries, one point held twice at a time, body parts (a pin moves the whole body).
    pub fn holds(&self, motion: &Motion, at: &ClipPlace) -> Result<Holds, EditError> {
        self.check(motion, at)?;
        Holds::new(&self.pins, motion, at)
    }

    fn check(&self, motion: &Motion, at: &ClipPlace) -> Result<(), EditError> {
        let edit = self.name();
        if !at.parts.is_empty() {
            return Err(EditError::PinParts { parts: at.parts.join(", ") });
        }
        let grace = 0.5 / motion.clip.rate_hz;
        for (i, pin) in self.pins.iter().enumerate() {
            let fault = |what, value, allowed| {
                let at = format!(" for `{}`", pin.point);
                Err(EditError::Parameter { edit, what, value, at, allowed })
            };
            if !(pin.blend_s >= 0.0 && pin.blend_s.is_finite()) {
                return fault("`blend_s`", pin.blend_s, "finite, 0 or more");
            }
            for (what, t_s) in [("from_s", pin.from_s), ("to_s", pin.to_s)] {
                if !(t_s >= at.from_s - grace && t_s <= at.to_s + grace) {
                    let (from_s, to_s) = (at.from_s, at.to_s);
                    return Err(EditError::TimeOutside { edit, what, t_s, from_s, to_s });
                }
            }
            if pin.from_s > pin.to_s {
                return fault("`to_s`", pin.to_s, "no earlier than `from_s`");
            }
            let place = match &pin.at {
                PinAt::World(place) | PinAt::Link(_, place) => *place,
                PinAt::Asked => [0.0; 3],
            };
            if let Some(&value) = place.iter().chain(&pin.point_m).find(|x| !x.is_finite()) {
                return fault("a coordinate", value, "finite, m");
            }
            let same = |other: &&Pin| {
                (&other.point, other.point_m) == (&pin.point, pin.point_m)
                    && other.from_s <= pin.to_s
                    && pin.from_s <= other.to_s
            };
            if let Some(other) = self.pins[..i].iter().find(same) {
                let (point, at_s) = (pin.point.clone(), pin.from_s.max(other.from_s));
                return Err(EditError::PinnedTwice { point, at_s });
            }
        }
        Ok(())
    }
}

impl ClipEdit for Pins {
    fn name(&self) -> &'static str {
        "pin"
    }

    fn change(&self, motion: &Motion, at: &ClipPlace, log: &mut EditLog) -> Result<Edited, EditError> {
        let mut holds = self.holds(motion, at)?;
        let mut edited = Edited::unchanged(motion);
        holds.hold(&mut edited.clip)?;
        for missed in holds.missed(&edited.clip) {
            log.note(missed.to_string());
        }
        Ok(edited)
    }
}

/// The motion before any edit, frame by frame in the time of `motion`.
fn unedited(motion: &Motion) -> Arc<Clip> {
    let Some(clip) = &motion.unedited else { return Arc::new(motion.clip.clone()) };
    if motion.times.is_identity() && clip.frames() >= motion.clip.frames() {
        return clip.clone();
    }
    let back = motion.times.inverse();
    let mut q = vec![0.0; motion.clip.skeleton.nq()];
    let mut data = Vec::with_capacity(motion.clip.data().len());
    for f in 0..motion.clip.frames() {
        clip.sample(back.at(f as f64 / motion.clip.rate_hz), &mut q);
        data.extend_from_slice(&q);
    }
    Arc::new(Clip::new(motion.clip.skeleton.clone(), motion.clip.rate_hz, data))
}
