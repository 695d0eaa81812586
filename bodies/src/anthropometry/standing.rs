//! A standing pose for rigs whose zero pose is none.
//!
//! Some exporters (Rokoko) lay every bone along one axis, so that the zero pose is no figure at all. Then
//! the frame of the clip that stands straightest serves as the reference pose. In: a clip. Out: a
//! frame, and a body guessed from it.

use motion::{Clip, Kinematics};

use super::aliases::Anatomy;
use super::frame::UP;
use super::guess::{BodyOptions, BodyReport, GuessError, guess_body};
use crate::Character;

/// The frame in which trunk, thighs and shins are nearest to vertical; the first of equals.
///
/// Measured by the worst of the five; of long clips about a thousand frames are looked at.
pub fn standing_frame(clip: &Clip, anatomy: &Anatomy) -> usize {
    let step = clip.frames().div_ceil(1000).max(1);
    let mut k = Kinematics::new(&clip.skeleton, &clip.skeleton.zero_pose());
    let mut best = (f64::INFINITY, 0);
    for frame in (0..clip.frames()).step_by(step) {
        k.update(&clip.skeleton, clip.pose(frame));
        let down = |from: usize, to: usize| (k.origin(to) - k.origin(from)).angle(&-UP);
        let middle = |row: [usize; 2]| (k.origin(row[0]) + k.origin(row[1])) * 0.5;
        let hips = middle([anatomy.legs[0][0], anatomy.legs[1][0]]);
        let shoulders = middle([anatomy.arms[0][0], anatomy.arms[1][0]]);
        let legs = anatomy.legs.iter().flat_map(|l| [down(l[0], l[1]), down(l[1], l[2])]);
        let worst = legs.fold((shoulders - hips).angle(&UP), f64::max);
        if worst < best.0 {
            best = (worst, frame);
        }
    }
    best.1
}

/// As [`guess_body`] for the skeleton of a clip; where its zero pose does not stand and no reference is
/// given, the straightest frame of the clip is the reference, and the report says so.
///
/// # Errors
/// As [`guess_body`].
pub fn guess_body_of_clip(clip: &Clip, options: &BodyOptions) -> Result<(Character, BodyReport), GuessError> {
    match guess_body(&clip.skeleton, options) {
        Err(GuessError::NotStanding { .. }) if options.reference.is_none() && clip.frames() > 0 => {
            let frame = standing_frame(clip, &Anatomy::of(&clip.skeleton)?);
            let reference = Some(clip.pose(frame).to_vec());
            let (character, mut report) =
                guess_body(&clip.skeleton, &BodyOptions { reference, ..options.clone() })?;
            report.notes.push(format!("the zero pose does not stand: frame {frame} is the reference"));
            Ok((character, report))
        }
        other => other,
    }
}
