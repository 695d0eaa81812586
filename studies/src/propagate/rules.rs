//! Known edits, to measure what is learned of them.
//!
//! In: a clip of a person and a [`Rule`]. Out: the clip as the rule has it, with its times: the truth that a learned edit is held against.
//! Rules act in the joint's parent frame, not in the form in which differences are learned.
//!
//! Units: rad, s, m/s; directions in the axes of the zero pose, lateral = left to right.

use bodies::anthropometry::{Anatomy, AnatomyError};
use edits::by_example::{ExampleError, Pair, Rig};
use motion::rotation::{Vec3, exp, log};
use motion::{Clip, Kinematics, smoothstep};
use thiserror::Error;

/// A known edit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// The lowest joint of the spine leans forward by 15° more.
    Lean,
    /// It leans by half the mean flexion of the knees.
    SpineByKnee,
    /// It leans by 15° for each m/s of speed.
    LeanBySpeed,
    /// Steps below 1 m/s are up to a fifth slower, above it up to a fifth faster.
    Timing,
    /// The lowest joint of the neck leans by the product of the mean flexions of knees and elbows (1 rad for 1 rad²).
    Product,
    /// Each arm is raised sideways by 20° times the positive part of the sine of its own phase of the gait.
    Phase,
    /// Both arms are raised sideways by 60° while the body walks.
    ArmsWhileWalking,
}

impl Rule {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Lean,
        Self::SpineByKnee,
        Self::LeanBySpeed,
        Self::Timing,
        Self::Product,
        Self::Phase,
        Self::ArmsWhileWalking,
    ];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lean => "spine + 15°",
            Self::SpineByKnee => "spine + 0.5 knee",
            Self::LeanBySpeed => "lean 15° per m/s",
            Self::Timing => "timing by speed",
            Self::Product => "neck + knee × elbow",
            Self::Phase => "arms by phase",
            Self::ArmsWhileWalking => "arms while walking",
        }
    }
}

/// Why a rule has no clip to act on.
#[derive(Debug, Error)]
pub enum RuleError {
    /// Names that are not a person's.
    #[error(transparent)]
    Anatomy(#[from] AnatomyError),
    /// A body that edits by example do not know.
    #[error(transparent)]
    Rig(#[from] ExampleError),
}

/// The clip and what the rule makes of it.
///
/// # Errors
/// A clip that is not of a person.
pub fn pair(rule: Rule, name: &str, clip: &Clip) -> Result<Pair, RuleError> {
    let body = Person::of(clip)?;
    let mut target = clip.clone();
    let speeds = body.speeds(clip);
    let frames = clip.frames();
    let times_s = (rule == Rule::Timing).then(|| {
        let mut at = 0.0;
        (0..frames)
            .map(|f| {
                let now = at;
                at += (1.0 - 0.2 * ((speeds[f] - 1.0) / 0.5).clamp(-1.0, 1.0)) / clip.rate_hz;
                now
            })
            .collect()
    });
    let phases = body.phases(clip);
    for f in 0..frames {
        let pose = clip.pose(f).to_vec();
        let out = target.pose_mut(f);
        let anatomy = &body.anatomy;
        let bend = |link: usize| log(&clip.skeleton.rotation(&pose, link)).norm();
        let knee = 0.5 * (bend(anatomy.legs[0][1]) + bend(anatomy.legs[1][1]));
        let elbow = 0.5 * (bend(anatomy.arms[0][1]) + bend(anatomy.arms[1][1]));
        let spine = anatomy.spine[0];
        let fifteen = 15_f64.to_radians();
        match rule {
            Rule::Lean => body.turn(out, spine, Vec3::x() * fifteen),
            Rule::SpineByKnee => body.turn(out, spine, Vec3::x() * (0.5 * knee)),
            Rule::LeanBySpeed => body.turn(out, spine, Vec3::x() * (fifteen * speeds[f])),
            Rule::Timing => {}
            Rule::Product => {
                let neck = anatomy.neck.first().copied().unwrap_or(anatomy.head);
                body.turn(out, neck, Vec3::x() * (knee * elbow));
            }
            Rule::Phase => {
                for side in 0..2 {
                    let up = 20_f64.to_radians() * phases[f][side].sin().max(0.0);
                    body.raise(out, side, up);
                }
            }
            Rule::ArmsWhileWalking => {
                let up = 60_f64.to_radians() * smoothstep((speeds[f] - 0.3) / 0.4);
                for side in 0..2 {
                    body.raise(out, side, up);
                }
            }
        }
    }
    Ok(Pair { times_s, ..Pair::new(name, clip.clone(), target) })
}

/// A person's clip as rules see it.
struct Person {
    anatomy: Anatomy,
    rig: Rig,
    /// On which side each arm hangs: 1 where the lateral axis points, −1 on the other.
    sides: [f64; 2],
}

impl Person {
    fn of(clip: &Clip) -> Result<Self, RuleError> {
        let s = &clip.skeleton;
        let anatomy = Anatomy::of(s)?;
        let rig = Rig::of(s)?;
        let k = Kinematics::new(s, &s.zero_pose());
        let axes_from_world = rig.axes_from_link(0) * k.world[0].rotation.inverse();
        let sides = anatomy.arms.map(|arm| (axes_from_world * (k.origin(arm[0]) - k.origin(0))).x.signum());
        Ok(Self { anatomy, rig, sides })
    }

    /// Turns a joint in its parent's frame by a rotation vector in body axes (x lateral, y up).
    fn turn(&self, q: &mut [f64], link: usize, by: Vec3) {
        let s = self.rig.skeleton();
        let r = exp(&(self.rig.axes_from_link(link).inverse() * by)) * s.rotation(q, link);
        s.set_rotation(q, link, &r);
    }

    /// Raises an arm sideways: about the front of the body.
    fn raise(&self, q: &mut [f64], side: usize, by: f64) {
        self.turn(q, self.anatomy.arms[side][0], Vec3::z() * (by * self.sides[side]));
    }

    /// Speed of the root over the ground, mean of half a second, m/s.
    fn speeds(&self, clip: &Clip) -> Vec<f64> {
        let root = |f: usize| {
            let p = clip.skeleton.position(clip.pose(f), 0);
            Vec3::new(p.x, 0.0, p.z)
        };
        let (last, half) = (clip.frames() - 1, (0.25 * clip.rate_hz).round() as usize);
        (0..=last)
            .map(|f| {
                let (a, b) = (f.saturating_sub(half), (f + half).min(last));
                (root(b) - root(a)).norm() * clip.rate_hz / (b - a).max(1) as f64
            })
            .collect()
    }

    /// Phase of the gait of each side, rad: the angle of (how far the side's foot is in front of the other, how fast it comes
    /// forward at 2π a second).
    fn phases(&self, clip: &Clip) -> Vec<[f64; 2]> {
        let mut k = Kinematics::new(&clip.skeleton, clip.pose(0));
        let ahead: Vec<f64> = (0..clip.frames())
            .map(|f| {
                k.update(&clip.skeleton, clip.pose(f));
                let between = k.origin(self.anatomy.legs[0][2]) - k.origin(self.anatomy.legs[1][2]);
                (self.rig.heading(&k.world[0].rotation).inverse() * between).z
            })
            .collect();
        let (last, half) = (ahead.len() - 1, (0.05 * clip.rate_hz).round().max(1.0) as usize);
        (0..=last)
            .map(|f| {
                let (a, b) = (f.saturating_sub(half), (f + half).min(last));
                let rate = (ahead[b] - ahead[a]) * clip.rate_hz / (b - a).max(1) as f64;
                let (x, y) = (rate / std::f64::consts::TAU, ahead[f]);
                [y.atan2(x), (-y).atan2(-x)]
            })
            .collect()
    }
}
