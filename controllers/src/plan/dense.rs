//! Joints of a script that are performed as a dense clip.
//!
//! An edit of the sampled motion (a warp, a pin) leaves no elements that say where a joint goes next, so the muscles of that
//! joint follow the sampled goal with feed-forward, as they follow a captured clip. All other joints keep their transitions,
//! which start from the simulated state (NF03). What the elements said of tension still holds: it is a function of time here.

/// Joints performed as a dense clip although they come from a script. See the module header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dense {
    /// Link of each joint, with its tension over time.
    pub joints: Vec<DenseJoint>,
}

/// A joint performed as a dense clip.
#[derive(Clone, Debug, PartialEq)]
pub struct DenseJoint {
    /// Its link.
    pub link: usize,
    /// Tension from a time on: s (ascending), 1 is natural. Before the first it is that of the first.
    pub tension: Vec<(f64, f64)>,
}

impl DenseJoint {
    /// Tension at a time, s.
    pub fn tension_at(&self, t_s: f64) -> f64 {
        let at = self.tension.partition_point(|(from_s, _)| *from_s <= t_s);
        self.tension.get(at.saturating_sub(1)).map_or(1.0, |(_, tension)| *tension)
    }
}

impl Dense {
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
        let joint = DenseJoint { link: 3, tension: vec![(0.0, 1.0), (1.0, 4.0), (2.5, 0.5)] };
        for (t_s, tension) in [(-1.0, 1.0), (0.0, 1.0), (0.999, 1.0), (1.0, 4.0), (2.4, 4.0), (9.0, 0.5)] {
            assert_eq!(joint.tension_at(t_s), tension, "{t_s}");
        }
        assert_eq!(DenseJoint { link: 0, tension: Vec::new() }.tension_at(1.0), 1.0);
    }
}
