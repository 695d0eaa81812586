//! Joints of a script that are performed as a dense clip.
//!
//! An edit of the sampled motion (a warp, a pin) leaves no elements that say where a joint goes next, so the muscles of that
//! joint follow the sampled goal with feed-forward, as they follow a captured clip. So do those of elements whose timing is
//! [`motion::Timing::Led`], and the limbs of planted ends that no balance drives. All other joints, and these at other times,
//! keep their transitions, which start from the simulated state (NF03). What the elements said of tension still holds: it is a
//! function of time here.

use motion::smoothstep;

/// Joints performed as a dense clip although they come from a script. See the module header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dense {
    /// Each joint.
    pub joints: Vec<DenseJoint>,
}

/// A joint performed as a dense clip.
#[derive(Clone, Debug, PartialEq)]
pub struct DenseJoint {
    /// Its link.
    pub link: usize,
    /// Tension from a time on: s (ascending), 1 is natural. Before the first it is that of the first.
    pub tension: Vec<(f64, f64)>,
    /// When it follows the clip: from and to, s, in order and apart. Its transitions fade out and in within [`BLEND_S`].
    pub spans: Vec<(f64, f64)>,
    /// Whether its muscles tense as much as the motion needs where that is more than the tension says; otherwise they sag.
    pub tenses: bool,
}

/// How long a joint takes from its transitions to the clip, and back, s.
pub const BLEND_S: f64 = 0.05;

impl DenseJoint {
    /// A joint that follows the clip from beginning to end.
    pub fn throughout(link: usize, tension: Vec<(f64, f64)>) -> Self {
        Self { link, tension, spans: vec![(f64::NEG_INFINITY, f64::INFINITY)], tenses: false }
    }

    /// A joint that follows the clip in `spans` (from and to, s), in any order; those that overlap become one.
    pub fn during(link: usize, tension: Vec<(f64, f64)>, mut spans: Vec<(f64, f64)>) -> Self {
        spans.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut apart: Vec<(f64, f64)> = Vec::new();
        for (from_s, to_s) in spans {
            match apart.last_mut() {
                Some(last) if from_s <= last.1 + BLEND_S => last.1 = last.1.max(to_s),
                _ => apart.push((from_s, to_s)),
            }
        }
        Self { spans: apart, ..Self::throughout(link, tension) }
    }

    /// Tension at a time, s.
    pub fn tension_at(&self, t_s: f64) -> f64 {
        let at = self.tension.partition_point(|(from_s, _)| *from_s <= t_s);
        self.tension.get(at.saturating_sub(1)).map_or(1.0, |(_, tension)| *tension)
    }

    /// How much of the clip it follows at a time (s): 0 its transitions, 1 the clip.
    pub fn level_at(&self, t_s: f64) -> f64 {
        let of = |&(from_s, to_s): &(f64, f64)| {
            let inside = if from_s.is_finite() { smoothstep((t_s - from_s) / BLEND_S) } else { 1.0 };
            let after = if to_s.is_finite() { smoothstep((t_s - to_s) / BLEND_S) } else { 0.0 };
            inside * (1.0 - after)
        };
        self.spans.iter().map(of).fold(0.0, f64::max)
    }

    /// Whether it follows the clip from beginning to end.
    pub fn is_throughout(&self) -> bool {
        self.spans.iter().any(|(from_s, to_s)| *from_s <= 0.0 && *to_s == f64::INFINITY)
    }
}

impl Dense {
    /// Adds a joint; to one that is there, its spans.
    pub fn add(&mut self, joint: DenseJoint) {
        match self.joints.iter_mut().find(|j| j.link == joint.link) {
            Some(there) => {
                let spans = [there.spans.as_slice(), &joint.spans].concat();
                let tenses = there.tenses || joint.tenses;
                *there = DenseJoint { tenses, ..DenseJoint::during(joint.link, joint.tension, spans) };
            }
            None => self.joints.push(joint),
        }
    }

    /// The joint of a link, if it is one of these.
    pub fn joint(&self, link: usize) -> Option<&DenseJoint> {
        self.joints.iter().find(|j| j.link == link)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tension holds from its time on; without any it is natural.
    #[test]
    fn tension_is_that_of_the_last_step() {
        let joint = DenseJoint::throughout(3, vec![(0.0, 1.0), (1.0, 4.0), (2.5, 0.5)]);
        for (t_s, tension) in [(-1.0, 1.0), (0.0, 1.0), (0.999, 1.0), (1.0, 4.0), (2.4, 4.0), (9.0, 0.5)] {
            assert_eq!(joint.tension_at(t_s), tension, "{t_s}");
        }
        assert_eq!(DenseJoint::throughout(0, Vec::new()).tension_at(1.0), 1.0);
    }

    /// A joint follows the clip within its spans, its transitions elsewhere, and goes smoothly between them.
    #[test]
    fn the_clip_holds_within_its_spans() {
        let mut dense = Dense::default();
        dense.add(DenseJoint::during(3, Vec::new(), vec![(3.0, 4.0), (1.0, 2.0)]));
        dense.add(DenseJoint {
            tenses: true,
            ..DenseJoint::during(3, Vec::new(), vec![(3.5, f64::INFINITY)])
        });
        let joint = dense.joint(3).unwrap();
        assert!(dense.joints.len() == 1 && joint.tenses);
        assert_eq!(joint.spans, [(1.0, 2.0), (3.0, f64::INFINITY)]);
        for (t_s, level) in
            [(0.0, 0.0), (1.0, 0.0), (1.06, 1.0), (2.0, 1.0), (2.06, 0.0), (3.1, 1.0), (1e6, 1.0)]
        {
            assert_eq!(joint.level_at(t_s), level, "{t_s}");
        }
        assert!((joint.level_at(1.0 + 0.5 * BLEND_S) - 0.5).abs() < 1e-12);
        assert!(!joint.is_throughout() && DenseJoint::throughout(0, Vec::new()).is_throughout());
        assert_eq!(DenseJoint::throughout(0, Vec::new()).level_at(0.0), 1.0);
    }
}
