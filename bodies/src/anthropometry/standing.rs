//! A body for a clip: its pelvis found below other roots, its rest pose in the motion where the zero pose is none.
//!
//! In: a clip. Out: a folded skeleton, a frame, a body guessed from them.
//!
//! *Roots.* Game engines put a reference or a mover above the pelvis. The body then starts at the pelvis, and the motion
//! of what is above is folded into it ([`PoseMap`]).
//!
//! *Rest pose.* Some exporters (Rokoko) lay every bone along one axis, so that the zero pose is no figure at all.
//! Then the frame of the clip that stands best serves as the reference pose: trunk and legs upright, feet low and
//! level, and nothing in motion.

use std::sync::Arc;

use motion::{Clip, Joint, Kinematics, Link, Skeleton, Transform};

use super::aliases::{Anatomy, pelvis_below_root};
use super::error::GuessError;
use super::frame::{Posed, UP, feet_with_toes};
use super::guess::{BodyOptions, BodyReport, guess_body};
use crate::{Character, PoseMap};

/// Of long clips about as many frames are looked at.
const FRAMES: usize = 1000;
/// What a lift of ankles and toes by one leg's length costs, rad of leaning.
const LIFT_COST: f64 = 4.0;
/// What a metre per second of ankles, hips and shoulders costs, rad of leaning.
const SPEED_COST: f64 = 0.3;

/// The clip as a body sees it that starts at its pelvis; `None` where it does already.
///
/// # Errors
/// Never for a skeleton that is one; a [`GuessError`] of its parts.
pub fn folded_to_pelvis(clip: &Clip) -> Result<Option<Clip>, GuessError> {
    let skeleton = &clip.skeleton;
    let Some(pelvis) = pelvis_below_root(skeleton) else { return Ok(None) };
    let below: Vec<usize> =
        (0..skeleton.links().len()).filter(|&i| skeleton.ancestors(i).any(|up| up == pelvis)).collect();
    let folded = |&i: &usize| {
        let link = &skeleton.links()[i];
        let parent = link.parent.and_then(|p| below.binary_search(&p).ok());
        match parent {
            Some(_) => Link { parent, ..link.clone() },
            None => Link {
                parent: None,
                joint: Joint::Free,
                parent_from_zero: Transform::identity(),
                ..link.clone()
            },
        }
    };
    let body = Arc::new(Skeleton::new(below.iter().map(folded).collect())?);
    let map = PoseMap::new(skeleton, &body).map_err(|e| GuessError::Fold(e.to_string()))?;
    Ok(Some(map.clip_to_character(clip, &body)))
}

/// The frame that stands best; the first of equals. See the module header.
///
/// Its worst lean of trunk, thighs and shins, and what lifted feet and speed add.
pub fn standing_frame(clip: &Clip, anatomy: &Anatomy) -> usize {
    let step = clip.frames().div_ceil(FRAMES).max(1);
    let frames: Vec<usize> = (0..clip.frames()).step_by(step).collect();
    let mut k = Kinematics::new(&clip.skeleton, &clip.skeleton.zero_pose());
    let low = feet_with_toes(&clip.skeleton, anatomy).concat();
    let quick = [
        anatomy.legs[0][2],
        anatomy.legs[1][2],
        anatomy.legs[0][0],
        anatomy.legs[1][0],
        anatomy.arms[0][0],
        anatomy.arms[1][0],
    ];
    let (mut leans, mut heights, mut speeds) = (Vec::new(), Vec::new(), Vec::new());
    let mut leg = 0.0f64;
    for &frame in &frames {
        k.update(&clip.skeleton, clip.pose(frame));
        let down = |from: usize, to: usize| (k.origin(to) - k.origin(from)).angle(&-UP);
        let middle = |row: [usize; 2]| (k.origin(row[0]) + k.origin(row[1])) * 0.5;
        let hips = middle([anatomy.legs[0][0], anatomy.legs[1][0]]);
        let shoulders = middle([anatomy.arms[0][0], anatomy.arms[1][0]]);
        let legs = anatomy.legs.iter().flat_map(|l| [down(l[0], l[1]), down(l[1], l[2])]);
        leans.push(legs.fold((shoulders - hips).angle(&UP), f64::max));
        heights.push(low.iter().map(|&i| k.origin(i).y).collect::<Vec<f64>>());
        let [a, b, c] = anatomy.legs[0];
        leg = leg.max((k.origin(b) - k.origin(a)).norm() + (k.origin(c) - k.origin(b)).norm());
        let at = quick.map(|i| k.origin(i));
        k.update(&clip.skeleton, clip.pose((frame + 1).min(clip.frames() - 1)));
        let moved = quick.iter().zip(at).map(|(&i, at)| (k.origin(i) - at).norm()).fold(0.0, f64::max);
        speeds.push(moved * clip.rate_hz);
    }
    let floor = |point: usize| {
        let mut of: Vec<f64> = heights.iter().map(|h| h[point]).collect();
        of.sort_by(f64::total_cmp);
        of[of.len() / 20]
    };
    let floors: Vec<f64> = (0..low.len()).map(floor).collect();
    let cost = |i: usize| {
        let lift = heights[i].iter().zip(&floors).map(|(h, floor)| (h - floor).max(0.0)).fold(0.0, f64::max);
        leans[i] + LIFT_COST * lift / leg.max(1e-9) + SPEED_COST * speeds[i]
    };
    (0..frames.len()).min_by(|&a, &b| cost(a).total_cmp(&cost(b))).map_or(0, |i| frames[i])
}

/// As [`guess_body`] for the skeleton of a clip: from its pelvis on, and where its zero pose does not stand and no
/// reference is given, from the frame that stands best. The report says so.
///
/// # Errors
/// As [`guess_body`]; `NotStanding` of the best frame where none stands.
pub fn guess_body_of_clip(clip: &Clip, options: &BodyOptions) -> Result<(Character, BodyReport), GuessError> {
    let folded = folded_to_pelvis(clip)?;
    let body = folded.as_ref().unwrap_or(clip);
    let (character, mut report) = match guess_body(&body.skeleton, options) {
        Err(GuessError::NotStanding { what, angle_deg, .. })
            if options.reference.is_none() && body.frames() > 0 =>
        {
            let anatomy = Anatomy::of(&body.skeleton)?;
            let frame = standing_frame(body, &anatomy);
            let (reference, posed) = (Some(body.pose(frame).to_vec()), Posed::of(body, &anatomy));
            let (character, mut report) =
                guess_body(&body.skeleton, &BodyOptions { reference, posed, ..options.clone() })?;
            let at = frame as f64 / clip.rate_hz;
            report.notes.push(format!(
                "the zero pose does not stand (its {what} leans {angle_deg:.0}°): the rest pose is that of {at:.2} s \
                 (frame {frame}), the most upright and quiet one"
            ));
            (character, report)
        }
        other => other?,
    };
    if folded.is_some() {
        let links = clip.skeleton.links();
        report.notes.push(format!(
            "the root `{}` is above the pelvis `{}`: what moves there moves the pelvis",
            links[0].name,
            body.skeleton.links()[0].name
        ));
    }
    Ok((character, report))
}
