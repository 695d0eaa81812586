//! Stance: where in a clip the feet stand, where they step, and where a standing foot is to be planted.
//!
//! In: a clip and the soles of its feet. Out: [`Stance`]: the clip cut into [`StanceSpan`]s that stand and spans in
//! which some foot steps; [`place`]: the flat place of a sole over a span. Geometry only: who can stand there
//! is judged by dynamics.
//!
//! *A foot steps* while the middle of its sole is faster than [`Settings::speed_m_s`] (the step begins and ends
//! where it falls below half of that), or higher than [`Settings::lift_m`] above the usual height of the lower
//! foot. A heel that
//! rises while the toes stay, a foot that turns under the body, a creeping sole do not step.
//!
//! *A span stands* if no foot steps in it, no sole strays further than [`Settings::stray_m`], and it lasts
//! [`Settings::least_s`]. All other frames belong to stepping spans. The spans cover the clip.
//!
//! Units: m, s; world frame, y up. Heights are of the middle of a sole.

use std::ops::Range;

use crate::rotation::{between, exp, log};
use crate::{Clip, Kinematics, Sole, Transform, Vec3};

/// What counts as standing. See the module header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Speed of a sole's middle that is a step, m/s; lower finds more steps.
    pub speed_m_s: f64,
    /// Height above the usual one of the lower foot at which a sole has left the ground, m; lower finds more steps.
    pub lift_m: f64,
    /// Furthest apart that one sole's places in a standing span are, along x or z, m; lower cuts sooner.
    pub stray_m: f64,
    /// Shortest span that counts as standing, s.
    pub least_s: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { speed_m_s: 0.2, lift_m: 0.04, stray_m: 0.1, least_s: 1.5 }
    }
}

/// A part of a clip in which its feet all stand, or one steps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StanceSpan {
    /// Frames.
    pub frames: Range<usize>,
    /// Whether all feet stand throughout.
    pub stands: bool,
    /// Soles (by their index) that step in it; empty when it stands, or is too short to count.
    pub stepping: Vec<usize>,
}

/// A clip cut into spans.
#[derive(Clone, Debug, PartialEq)]
pub struct Stance {
    /// Spans, in order, covering the clip.
    pub spans: Vec<StanceSpan>,
    /// Height of the ground: median height of the soles' middles in the standing spans; of the slow soles
    /// where nothing stands, m.
    pub ground_m: f64,
}

impl Stance {
    /// Spans that stand.
    pub fn standing(&self) -> impl Iterator<Item = &StanceSpan> {
        self.spans.iter().filter(|s| s.stands)
    }
}

/// Half the time over which a sole's speed is taken, s: a quiet foot's noise of 1 mm is 0.03 m/s then.
const HALF_WINDOW: f64 = 1.0 / 30.0;

/// Cuts `clip` into standing and stepping spans. Without soles nothing stands.
pub fn stance(clip: &Clip, soles: &[Sole], settings: &Settings) -> Stance {
    let frames = clip.frames();
    let centers = centers(clip, soles);
    let speeds: Vec<Vec<f64>> = centers.iter().map(|c| speeds(c, clip.rate_hz)).collect();
    let slow = |s: usize, f: usize| speeds[s][f] < 0.5 * settings.speed_m_s;
    let usual: Vec<f64> = (0..soles.len())
        .map(|s| median((0..frames).filter(|&f| slow(s, f)).map(|f| centers[s][f].y).collect()))
        .collect();
    let down = usual.iter().copied().fold(f64::INFINITY, f64::min);
    let steps: Vec<Vec<bool>> = (0..soles.len())
        .map(|s| {
            let up = |f: usize| centers[s][f].y > down + settings.lift_m;
            let seed: Vec<bool> = (0..frames).map(|f| speeds[s][f] > settings.speed_m_s || up(f)).collect();
            grown(&seed, |f| !slow(s, f))
        })
        .collect();

    let mut spans: Vec<StanceSpan> = Vec::new();
    let mut f = 0;
    while f < frames {
        let end = standing_until(f, &centers, &steps, settings.stray_m);
        let stands = !soles.is_empty() && (end.max(f + 1) - 1 - f) as f64 >= settings.least_s * clip.rate_hz;
        let end = if stands { end } else { (f + 1).max(end) };
        let stepping: Vec<usize> = if stands {
            Vec::new()
        } else {
            (0..soles.len()).filter(|&s| steps[s][f..end].contains(&true)).collect()
        };
        match spans.last_mut() {
            Some(last) if !last.stands && !stands => {
                last.frames.end = end;
                last.stepping.extend(stepping);
            }
            _ => spans.push(StanceSpan { frames: f..end, stands, stepping }),
        }
        f = end;
    }
    for span in &mut spans {
        span.stepping.sort_unstable();
        span.stepping.dedup();
    }
    let heights = |only_standing: bool| -> Vec<f64> {
        let inside = |f: usize| !only_standing || spans.iter().any(|s| s.stands && s.frames.contains(&f));
        (0..soles.len())
            .flat_map(|s| (0..frames).map(move |f| (s, f)))
            .filter(|&(s, f)| inside(f) && slow(s, f))
            .map(|(s, f)| centers[s][f].y)
            .collect()
    };
    let standing = heights(true);
    let ground_m = median(if standing.is_empty() { heights(false) } else { standing });
    Stance { spans, ground_m }
}

/// First frame after `from` at which a foot steps or has strayed.
fn standing_until(from: usize, centers: &[Vec<Vec3>], steps: &[Vec<bool>], stray: f64) -> usize {
    let frames = steps.first().map_or(0, Vec::len);
    let mut boxes: Vec<[f64; 4]> = centers
        .iter()
        .map(|_| [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY])
        .collect();
    for f in from..frames {
        for (s, b) in boxes.iter_mut().enumerate() {
            let c = &centers[s][f];
            *b = [b[0].min(c.x), b[1].max(c.x), b[2].min(c.z), b[3].max(c.z)];
            if steps[s][f] || b[1] - b[0] > stray || b[3] - b[2] > stray {
                return f;
            }
        }
    }
    frames
}

/// The flat place of a sole over `frames`: its mean position and heading, level, its corners at `ground_m`.
/// `world_from_link` of the planted link.
pub fn place(clip: &Clip, sole: &Sole, frames: Range<usize>, ground_m: f64) -> Transform {
    let skeleton = &clip.skeleton;
    let n = frames.len().max(1) as f64;
    let mut k = Kinematics::new(skeleton, clip.pose(frames.start));
    let reference = k.world[sole.link].rotation;
    let (mut middle, mut turn) = (Vec3::zeros(), Vec3::zeros());
    for f in frames {
        k.update(skeleton, clip.pose(f));
        middle += sole.center(&k) / n;
        turn += log(&(k.world[sole.link].rotation * reference.inverse())) / n;
    }
    let mean = exp(&turn) * reference;
    // corners in the frame of the planted link: links of one sole do not move against each other
    let from_world = k.world[sole.link].inverse();
    let corners: Vec<Vec3> = sole
        .corners
        .iter()
        .map(|(l, at)| (from_world * k.world[*l]).transform_point(&(*at).into()).coords)
        .collect();
    let rotation = match normal(&corners) {
        Some(normal) => {
            let up = mean * normal;
            let up = if up.y < 0.0 { -up } else { up };
            between(&up, &Vec3::y()) * mean
        }
        None => mean,
    };
    let center: Vec3 = corners.iter().sum::<Vec3>() / corners.len().max(1) as f64;
    let lowest = corners.iter().map(|c| (rotation * (c - center)).y).fold(f64::INFINITY, f64::min);
    let mut at = middle - rotation * center;
    at.y = ground_m - lowest - (rotation * center).y;
    Transform::from_parts(at.into(), rotation)
}

/// Unit normal of the plane through points; `None` if they lie on a line.
pub(crate) fn normal(points: &[Vec3]) -> Option<Vec3> {
    let center: Vec3 = points.iter().sum::<Vec3>() / points.len().max(1) as f64;
    let mut scatter = nalgebra::Matrix3::zeros();
    for p in points {
        scatter += (p - center) * (p - center).transpose();
    }
    let eigen = scatter.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let wide = eigen.eigenvalues[order[1]] > 1e-6 * eigen.eigenvalues[order[2]].max(1e-12);
    wide.then(|| eigen.eigenvectors.column(order[0]).into_owned())
}

/// Middle of every sole in every frame.
fn centers(clip: &Clip, soles: &[Sole]) -> Vec<Vec<Vec3>> {
    let mut out = vec![Vec::with_capacity(clip.frames()); soles.len()];
    let mut k = Kinematics::new(&clip.skeleton, clip.pose(0));
    for f in 0..clip.frames() {
        k.update(&clip.skeleton, clip.pose(f));
        for (s, sole) in soles.iter().enumerate() {
            out[s].push(sole.center(&k));
        }
    }
    out
}

/// Speed of a point over ± [`HALF_WINDOW`], m/s.
fn speeds(at: &[Vec3], rate_hz: f64) -> Vec<f64> {
    let w = ((rate_hz * HALF_WINDOW).round() as usize).max(1);
    (0..at.len())
        .map(|f| {
            let (a, b) = (f.saturating_sub(w), (f + w).min(at.len() - 1));
            (at[b] - at[a]).norm() * rate_hz / (b - a).max(1) as f64
        })
        .collect()
}

/// `seed`, grown both ways while `on` holds.
fn grown(seed: &[bool], on: impl Fn(usize) -> bool) -> Vec<bool> {
    let mut out = seed.to_vec();
    for f in 1..out.len() {
        out[f] |= out[f - 1] && on(f);
    }
    for f in (1..out.len()).rev() {
        out[f - 1] |= out[f] && on(f - 1);
    }
    out
}

/// Median; zero of nothing.
fn median(mut x: Vec<f64>) -> f64 {
    x.sort_by(f64::total_cmp);
    x.get(x.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::{Joint, Link, Skeleton};

    const RATE: f64 = 60.0;

    /// A root with two feet that slide along z and up, and their soles: 0.1 × 0.25 m, 0.08 m below their links.
    fn feet() -> (Arc<Skeleton>, Vec<Sole>) {
        let mut links = vec![Link::new("root", None, Vec3::zeros(), Joint::Free)];
        let mut soles = Vec::new();
        for x in [0.1, -0.1] {
            let along = links.len();
            links.push(Link::new(format!("along{x}"), Some(0), Vec3::x() * x, Joint::Prismatic(Vec3::z())));
            links.push(Link::new(format!("up{x}"), Some(along), Vec3::zeros(), Joint::Prismatic(Vec3::y())));
            let corner = |dx: f64, dz: f64| (along + 1, Vec3::new(dx, -0.08, dz));
            let corners =
                vec![corner(-0.05, -0.07), corner(0.05, -0.07), corner(-0.05, 0.18), corner(0.05, 0.18)];
            soles.push(Sole { name: format!("foot{x}"), link: along + 1, corners });
        }
        (Arc::new(Skeleton::new(links).unwrap()), soles)
    }

    /// A clip whose feet are `(z, height)` at a time; left first.
    fn clip(seconds: f64, at: impl Fn(f64) -> [(f64, f64); 2]) -> (Clip, Vec<Sole>) {
        let (s, soles) = feet();
        let mut q = Vec::new();
        for f in 0..=(seconds * RATE) as usize {
            let mut pose = s.zero_pose();
            for (side, (z, up)) in at(f as f64 / RATE).into_iter().enumerate() {
                pose[s.q_at(2 * side + 1)] = z;
                pose[s.q_at(2 * side + 2)] = up + 0.08;
            }
            q.extend(pose);
        }
        (Clip::new(s, RATE, q), soles)
    }

    /// A step of 0.3 m and 0.1 m high from `t` = 0 to 0.5 s.
    fn step(t: f64) -> (f64, f64) {
        let u = (t / 0.5).clamp(0.0, 1.0);
        (0.3 * u * u * (3.0 - 2.0 * u), 0.1 * (std::f64::consts::PI * u).sin())
    }

    /// Two seconds of standing, a step of the left foot, 2.5 s of standing: found to a tenth of a second, and the
    /// spans cover the clip.
    #[test]
    fn a_step_cuts_a_clip_in_three() {
        let (clip, soles) = clip(5.0, |t| [step(t - 2.0), (0.0, 0.0)]);
        let found = stance(&clip, &soles, &Settings::default());
        let spans = &found.spans;
        assert_eq!(spans.iter().map(|s| s.stands).collect::<Vec<_>>(), [true, false, true], "{spans:?}");
        assert_eq!(spans[1].stepping, [0]);
        assert!(
            spans[1].frames.start.abs_diff(120) <= 6 && spans[1].frames.end.abs_diff(150) <= 6,
            "{spans:?}"
        );
        assert!(spans.windows(2).all(|w| w[0].frames.end == w[1].frames.start));
        assert_eq!((spans[0].frames.start, spans[2].frames.end), (0, clip.frames()));
        assert!(found.ground_m.abs() < 1e-12, "{}", found.ground_m);
    }

    /// Standing that is shorter than asked belongs to the steps around it.
    #[test]
    fn a_short_stop_is_no_stand() {
        let (clip, soles) = clip(3.0, |t| [step(t - 0.5), step(t - 2.0)]);
        let found = stance(&clip, &soles, &Settings::default());
        assert_eq!(found.spans.len(), 1);
        assert_eq!((found.spans[0].stands, &found.spans[0].stepping[..]), (false, &[0, 1][..]));
    }

    /// A foot held in the air does not stand, however still; a slow creep is cut where it has gone too far.
    #[test]
    fn a_raised_foot_and_a_creeping_one() {
        let (raised, soles) = clip(4.0, |_| [(0.0, 0.2), (0.0, 0.0)]);
        assert_eq!(stance(&raised, &soles, &Settings::default()).standing().count(), 0);
        let (creeping, soles) = clip(6.0, |t| [(0.03 * t, 0.0), (0.0, 0.0)]);
        let found = stance(&creeping, &soles, &Settings::default());
        assert_eq!(found.standing().count(), 2, "{:?}", found.spans);
        assert_eq!(stance(&creeping, &[], &Settings::default()).standing().count(), 0);
    }

    /// A sole that leans is planted level, at the mean of its places, with its heading; all corners on the ground.
    #[test]
    fn a_leaning_sole_is_planted_flat() {
        let (mut clip, soles) = clip(1.0, |t| [(0.02 * t, 0.0), (0.0, 0.0)]);
        let skeleton = clip.skeleton.clone();
        let lean = exp(&(Vec3::y() * 0.4)) * exp(&Vec3::new(0.1, 0.0, -0.15));
        for f in 0..clip.frames() {
            skeleton.set_rotation(clip.pose_mut(f), 0, &lean);
        }
        let place = place(&clip, &soles[0], 0..clip.frames(), 0.3);
        for (_, at) in &soles[0].corners {
            let y = place.transform_point(&(*at).into()).y;
            assert!((y - 0.3).abs() < 1e-9, "{y}"); // 1e-16 seen
        }
        let front = place.rotation * Vec3::z();
        assert!((front.x.atan2(front.z) - 0.4).abs() < 0.03, "{front}");
        let mean: Vec3 = (0..clip.frames())
            .map(|f| soles[0].center(&Kinematics::new(&skeleton, clip.pose(f))))
            .sum::<Vec3>()
            / clip.frames() as f64;
        let middle =
            soles[0].corners.iter().map(|(_, at)| place.transform_point(&(*at).into()).coords).sum::<Vec3>()
                / 4.0;
        assert!((middle - mean).xz().norm() < 1e-9, "{middle} {mean}");
    }
}
