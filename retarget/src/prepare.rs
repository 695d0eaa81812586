//! The human clip as the stages want it: on the performer's skeleton, at one rate, smooth, on ground at 0.
//!
//! In: a clip as it was captured. Out: the clip everything else works on. Smoothing comes before resampling, so that
//! noise does not fold into what is kept. The ground is where the lowest contact points stand: in every
//! frame the lowest one is taken, and of its heights while it is slow the median; where it hardly ever is, the
//! lower [`STANDING`] quantile of all.

use motion::{Clip, Kinematics, Smoothing, Vec3, smooth};

use crate::{Performer, RetargetError};

/// Share of the frames whose lowest contact point lies below the ground that is found.
pub const STANDING: f64 = 0.2;
/// A point slower than this stands, m/s, for a performer of standard size.
pub const SLOW_M_S: f64 = 0.35;
/// Fewest frames that can be differentiated twice.
pub const FEWEST_FRAMES: usize = 5;

/// Prepares a human clip. See the module header.
///
/// # Errors
/// A clip of another skeleton, a rate that is not positive, fewer than five frames.
pub fn prepare(
    clip: &Clip,
    performer: &Performer,
    rate_hz: Option<f64>,
    smoothing: Smoothing,
    ground_m: Option<f64>,
) -> Result<Clip, RetargetError> {
    let c = &performer.character;
    let map = bodies::PoseMap::of_clip(clip, &c.skeleton)?;
    let mut human = map.clip_to_character(clip, &c.skeleton);
    if human.frames() > 3 {
        human = smooth(&human, smoothing).clip;
    }
    if let Some(rate) = rate_hz {
        if !(rate > 0.0 && rate.is_finite()) {
            let (name, allowed) = ("the frame rate (Hz)", "positive numbers");
            return Err(RetargetError::Option { name, value: rate, allowed });
        }
        let own = human.rate_hz;
        human = human.resample(rate);
        // between the frames of a slower clip it goes straight on: the corners are above what it can tell
        if rate > 1.01 * own && human.frames() > 3 {
            human = smooth(&human, Smoothing::CutoffHz(own / 3.0)).clip;
        }
    }
    if human.frames() < FEWEST_FRAMES {
        let (frames, rate_hz) = (human.frames(), human.rate_hz);
        return Err(RetargetError::TooShort { frames, rate_hz, least: FEWEST_FRAMES });
    }
    let ground = ground_m.unwrap_or_else(|| ground_of(performer, &human));
    for i in 0..human.frames() {
        crate::fit::place_root(&c.skeleton, human.pose_mut(i), |w| {
            let mut w = *w;
            w.translation.vector.y -= ground;
            w
        });
    }
    Ok(human)
}

/// Height of the ground under a clip, m; 0 for a performer without contact points.
pub fn ground_of(performer: &Performer, human: &Clip) -> f64 {
    let c = &performer.character;
    let mut k = Kinematics::new(&c.skeleton, &c.skeleton.zero_pose());
    let place = |k: &Kinematics, site: usize| {
        let site = &c.skeleton.sites()[site];
        k.point(site.link, &site.at)
    };
    let (mut lowest, mut slow) = (Vec::new(), Vec::new());
    let mut before: Vec<Vec3> = Vec::new();
    for i in 0..human.frames() {
        k.update(&c.skeleton, human.pose(i));
        let now: Vec<Vec3> = c.contacts.iter().map(|&s| place(&k, s)).collect();
        let Some(low) = (0..now.len()).min_by(|&a, &b| now[a].y.total_cmp(&now[b].y)) else { return 0.0 };
        lowest.push(now[low].y);
        let step = before.get(low).map_or(f64::INFINITY, |p| (now[low] - p).norm());
        if step * human.rate_hz < SLOW_M_S * performer.features.unit_m {
            slow.push(now[low].y);
        }
        before = now;
    }
    let quantile = |heights: &mut Vec<f64>, at: f64| {
        heights.sort_by(f64::total_cmp);
        heights[((heights.len() - 1) as f64 * at).round() as usize]
    };
    let enough = slow.len() as f64 >= STANDING * lowest.len() as f64;
    if enough { quantile(&mut slow, 0.5) } else { quantile(&mut lowest, STANDING) }
}
