//! Joints that their limits changed: which, from what, to what, when.
//!
//! In: a clip before limits were applied. Out: a [`Limited`] for every axis of a joint that was beyond, the furthest first.
//! Units: rad (m for slides), s; people read degrees.

use std::fmt;

use motion::skeleton::quat_at;
use motion::{Clip, Joint, Limits, Range};

/// Beyond a limit by less counts as within, rad or m.
const WITHIN: f64 = 0.5 * std::f64::consts::PI / 180.0;
/// Spans nearer to one another are one, s.
const APART_S: f64 = 0.1;

/// An axis of a joint that was asked beyond its limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Limited {
    /// The joint.
    pub joint: String,
    /// Which axis of a ball: `swing 1`, `swing 2` or `twist`; `None` for hinges and slides.
    pub axis: Option<&'static str>,
    /// Whether it is a way, m, not an angle.
    pub slides: bool,
    /// The furthest that was asked.
    pub asked: f64,
    /// The limit there.
    pub limit: f64,
    /// When: first and last moment of each span, s.
    pub spans_s: Vec<(f64, f64)>,
}

impl Limited {
    /// How far beyond the limit.
    pub fn beyond(&self) -> f64 {
        (self.asked - self.limit).abs()
    }
}

impl fmt::Display for Limited {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.joint)?;
        if let Some(axis) = self.axis {
            write!(f, " ({axis})")?;
        }
        let value = |x: f64| {
            if self.slides { format!("{:.0} mm", 1e3 * x) } else { format!("{:.0}°", x.to_degrees()) }
        };
        write!(f, " asked {}, limit {}", value(self.asked), value(self.limit))?;
        match &self.spans_s[..] {
            [] => Ok(()),
            [(from_s, to_s)] => write!(f, ", {from_s:.1}–{to_s:.1} s"),
            [(from_s, _), .., (_, to_s)] => {
                write!(f, ", {} times in {from_s:.1}–{to_s:.1} s", self.spans_s.len())
            }
        }
    }
}

/// Axes of a joint: its names, its values in a pose and their ranges.
fn axes(joint: &Joint, limits: &Limits, q: &[f64], at: usize) -> Vec<(Option<&'static str>, f64, Range)> {
    match (joint, limits) {
        (Joint::Revolute(_) | Joint::Prismatic(_), Limits::Axis(range)) => vec![(None, q[at], *range)],
        (Joint::Spherical, Limits::Ball(ball)) => {
            let phi = ball.coords(&quat_at(q, at));
            let names = ["swing 1", "swing 2", "twist"];
            (0..3).map(|i| (Some(names[i]), phi[i], ball.ranges[i])).collect()
        }
        _ => Vec::new(),
    }
}

/// Every axis that is beyond its limit somewhere in `clip`, the furthest first.
pub fn limited(clip: &Clip) -> Vec<Limited> {
    let skeleton = &clip.skeleton;
    let mut all: Vec<Limited> = Vec::new();
    for (link, l) in skeleton.links().iter().enumerate() {
        let Some(limits) = &l.limits else { continue };
        let mut own: [Option<Limited>; 3] = [None, None, None];
        for frame in 0..clip.frames() {
            let t_s = frame as f64 / clip.rate_hz;
            let axes = axes(&l.joint, limits, clip.pose(frame), skeleton.q_at(link));
            for (slot, (axis, asked, range)) in own.iter_mut().zip(axes) {
                let limit = range.clamp(asked);
                if (asked - limit).abs() <= WITHIN {
                    continue;
                }
                let one = slot.get_or_insert_with(|| Limited {
                    joint: l.name.clone(),
                    axis,
                    slides: matches!(l.joint, Joint::Prismatic(_)),
                    asked,
                    limit,
                    spans_s: Vec::new(),
                });
                if (asked - limit).abs() > one.beyond() {
                    (one.asked, one.limit) = (asked, limit);
                }
                match one.spans_s.last_mut() {
                    Some((_, to_s)) if t_s - *to_s <= APART_S => *to_s = t_s,
                    _ => one.spans_s.push((t_s, t_s)),
                }
            }
        }
        all.extend(own.into_iter().flatten());
    }
    all.sort_by(|a, b| b.beyond().total_cmp(&a.beyond()));
    all
}

/// Keeps joint limits; also the fraction of the frames that they changed, and which joints.
pub(crate) fn within_limits(mut clip: Clip) -> (Clip, f64, Vec<Limited>) {
    let changed = limited(&clip);
    let skeleton = clip.skeleton.clone();
    let mut clamped = 0;
    for f in 0..clip.frames() {
        clamped += usize::from(skeleton.clamp_to_limits(clip.pose_mut(f)));
    }
    let share = clamped as f64 / clip.frames() as f64;
    (clip, share, changed)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use motion::{Link, Skeleton, Vec3};

    use super::*;

    /// A hinge is named with the furthest that was asked, its limit and when; one within its limits is not.
    #[test]
    fn a_joint_is_named_with_how_far_and_when() {
        let mut elbow = Link::new("elbow_r", None, Vec3::zeros(), Joint::Revolute(Vec3::y()));
        elbow.limits = Some(Limits::Axis(Range::new(0.0, 150f64.to_radians())));
        let skeleton = Arc::new(Skeleton::new(vec![elbow]).unwrap());
        let asked = |t: f64| if (0.8..=1.4).contains(&t) { 170f64.to_radians() } else { 1.0 };
        let clip = |asked: &dyn Fn(f64) -> f64| {
            Clip::new(skeleton.clone(), 100.0, (0..200).map(|f| asked(f64::from(f) / 100.0)).collect())
        };
        let found = limited(&clip(&asked));
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].to_string(), "elbow_r asked 170°, limit 150°, 0.8–1.4 s");
        let twice = |t: f64| if ((t * 2.0) as usize).is_multiple_of(2) { -0.5 } else { 1.0 };
        let found = limited(&clip(&twice));
        assert_eq!(found[0].to_string(), "elbow_r asked -29°, limit 0°, 2 times in 0.0–1.5 s");
        assert!(limited(&clip(&|_| 1.0)).is_empty());
    }
}
