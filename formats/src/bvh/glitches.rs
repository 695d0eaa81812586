//! Glitches of a capture as the reader names them, and mends them on request.
//!
//! In: the clip read. Out: [`Glitches`]. [`mod@motion::glitch`] says what a glitch is. Fingers and toes of a human-like
//! skeleton are left out: no body moves them.

use std::fmt;

use bodies::anthropometry::Anatomy;
use motion::Clip;
use motion::glitch::{Glitch, Part, glitches, mended};

/// Glitches named in words.
const NAMED: usize = 6;

/// A glitch with names.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedGlitch {
    /// The joint.
    pub joint: String,
    /// What of it jumps.
    pub part: Part,
    /// First and last frame that are wrong, from 0; of a jump that does not come back, the frame after it twice.
    pub frames: [usize; 2],
    /// Time of the first, s.
    pub at_s: f64,
    /// Largest acceleration, rad/s² or m/s².
    pub acceleration: f64,
    /// Whether its frames were interpolated.
    pub repaired: bool,
}

/// All glitches, the worst first. `Display` prints the worst, a line each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Glitches {
    /// The worst first.
    pub all: Vec<NamedGlitch>,
    /// Whether the caller asked for repair.
    pub repair: bool,
}

impl fmt::Display for NamedGlitch {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [a, b] = self.frames;
        let frames = if a == b { format!("frame {a}") } else { format!("frames {a} to {b}") };
        let (what, unit) = match self.part {
            Part::Turn => ("turns with", "rad/s²"),
            Part::Place => ("moves with", "m/s²"),
        };
        let done = if self.repaired { ", interpolated" } else { "" };
        write!(
            f,
            "`{}` {what} {:.0} {unit}, {frames} ({:.2} s){done}",
            self.joint, self.acceleration, self.at_s
        )
    }
}

impl fmt::Display for Glitches {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if self.all.is_empty() {
            return Ok(());
        }
        let count = self.all.len();
        write!(f, "GLITCHES: {count} times a joint accelerates as no muscle could make it")?;
        if !self.repair {
            write!(f, "; ask for repair to interpolate these frames")?;
        }
        for glitch in self.all.iter().take(NAMED) {
            write!(f, "\n  {glitch}")?;
        }
        if count > NAMED {
            write!(f, "\n  … and {} more", count - NAMED)?;
        }
        Ok(())
    }
}

/// Finds the glitches of a clip, and mends them if asked.
pub(super) fn find(clip: Clip, repair: bool) -> (Clip, Glitches) {
    let skeleton = clip.skeleton.clone();
    let roles = Anatomy::of(&skeleton).map(|a| a.roles).ok();
    let moves = |g: &Glitch| roles.as_ref().is_none_or(|roles| !roles[g.link].is_welded());
    let (clip, found) = if repair {
        mended(&clip)
    } else {
        let found = glitches(&clip);
        (clip, found)
    };
    let found: Vec<Glitch> = found.into_iter().filter(moves).collect();
    let named = |g: &Glitch| NamedGlitch {
        joint: skeleton.links()[g.link].name.clone(),
        part: g.part,
        frames: [g.frames.start, g.frames.end.saturating_sub(1).max(g.frames.start)],
        at_s: g.frames.start as f64 / clip.rate_hz,
        acceleration: g.acceleration,
        repaired: repair && !g.frames.is_empty(),
    };
    let mut all: Vec<NamedGlitch> = found.iter().map(named).collect();
    all.sort_by(|a, b| b.acceleration.total_cmp(&a.acceleration));
    (clip, Glitches { all, repair })
}
