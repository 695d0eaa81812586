//! What a clip edit changed: when, which joints, and by how much.
//!
//! In: a motion before and after. Out: a [`ClipChange`]. Poses are compared at the times that belong to each other:
//! the clip before, retimed as the edit says, with the clip after, frame by frame. So a retiming changes time and no
//! joint, and an edit cannot forget to report.
//!
//! Units: s, degrees and mm, as people read them; slopes are retimed seconds for each second before (2 is
//! twice as slow).

use std::fmt;

use motion::{Dof, Joint, Skeleton};

use crate::{EditError, Edited, Motion};

/// A pose or slope that differs by less (rad, m, 1) has not changed.
const NOISE: f64 = 1e-9;

/// The largest change of its kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Largest {
    /// The link whose joint it is.
    pub link: String,
    /// How much: degrees or mm.
    pub amount: f64,
    /// When, s.
    pub at_s: f64,
}

/// What one clip edit changed of one joint.
#[derive(Clone, Debug, PartialEq)]
pub struct JointChange {
    /// The link.
    pub link: String,
    /// First frame that changed, s.
    pub from_s: f64,
    /// Last such frame, s.
    pub to_s: f64,
    /// The largest turn, degrees.
    pub turned_deg: f64,
    /// The furthest way of the root or of a slide, mm.
    pub moved_mm: f64,
}

impl JointChange {
    /// The largest change, as people read it: `12.00°`, `3.1 mm`, or both.
    pub fn by(&self) -> String {
        match (self.turned_deg > NOISE, self.moved_mm > NOISE) {
            (true, true) => format!("{:.2}° and {:.1} mm", self.turned_deg, self.moved_mm),
            (false, true) => format!("{:.1} mm", self.moved_mm),
            _ => format!("{:.2}°", self.turned_deg),
        }
    }
}

/// What one clip edit changed. Times are those of the clip after it.
#[derive(Clone, Debug, PartialEq)]
pub struct ClipChange {
    /// Index of the edit in the log.
    pub edit: usize,
    /// First frame that changed, or runs at another speed, s.
    pub from_s: f64,
    /// Last such frame, s.
    pub to_s: f64,
    /// Links whose joints were moved, in the skeleton's order.
    pub joints: Vec<String>,
    /// The same, each with when and by how much.
    pub of_joints: Vec<JointChange>,
    /// The largest turn of a joint, degrees.
    pub turned: Option<Largest>,
    /// The furthest way of the root (or of a slide), mm.
    pub moved: Option<Largest>,
    /// Least and largest slope at the frames, where time was changed.
    pub slopes: Option<(f64, f64)>,
    /// Lengths of the clip before and after, s.
    pub lengths_s: (f64, f64),
}

impl ClipChange {
    /// Compares; `None` where nothing changed.
    ///
    /// # Errors
    /// [`EditError::ClipResult`]: another skeleton or rate, a length that the times do not give, numbers that are not
    /// finite.
    pub(crate) fn measure(
        name: &'static str,
        edit: usize,
        motion: &Motion,
        edited: &Edited,
    ) -> Result<Option<Self>, EditError> {
        let (before, after) = (edited.times.retime(&motion.clip), &edited.clip);
        let fault = |what: String| Err(EditError::ClipResult { edit: name, what });
        if after.skeleton != before.skeleton {
            return fault("has another skeleton".into());
        }
        if after.rate_hz != before.rate_hz {
            return fault(format!("has {} Hz; allowed: {} Hz, as before", after.rate_hz, before.rate_hz));
        }
        if after.frames() != before.frames() {
            let (found, needed) = (after.frames(), before.frames());
            return fault(format!("has {found} frames; its times give {needed}"));
        }
        let s = &after.skeleton;
        let dofs = Dof::all(s);
        let back = edited.times.inverse();
        let mut moved = vec![false; s.links().len()];
        let mut change = Self {
            edit,
            from_s: f64::INFINITY,
            to_s: f64::NEG_INFINITY,
            joints: Vec::new(),
            of_joints: Vec::new(),
            turned: None,
            moved: None,
            slopes: None,
            lengths_s: (motion.clip.duration_s(), after.duration_s()),
        };
        for frame in 0..after.frames() {
            let at_s = frame as f64 / after.rate_hz;
            let (old, new) = (before.pose(frame), after.pose(frame));
            let mut differs = false;
            let mut ways = vec![(0.0_f64, 0.0_f64); s.links().len()];
            for &dof in &dofs {
                let (a, b) = (dof.read(s, old), dof.read(s, new));
                if !b.is_valid() {
                    let link = &s.links()[dof.link()].name;
                    return fault(format!("is not finite, or no rotation, at {at_s:.3} s: {link}"));
                }
                if a.distance(&b) > NOISE {
                    (differs, moved[dof.link()]) = (true, true);
                    let slides = matches!(s.links()[dof.link()].joint, Joint::Prismatic(_));
                    let (turn, way) = &mut ways[dof.link()];
                    match dof {
                        Dof::Coordinate(..) => *way = way.hypot(a.distance(&b)),
                        Dof::Axis(_) if slides => *way = a.distance(&b),
                        Dof::Axis(_) | Dof::Rotation(_) => *turn = a.distance(&b),
                    }
                }
            }
            if differs {
                change.compare(s, &ways, at_s);
            }
            let slope = edited.times.rate(back.at(at_s));
            if (slope - 1.0).abs() > NOISE {
                let (least, most) = change.slopes.unwrap_or((slope, slope));
                change.slopes = Some((least.min(slope), most.max(slope)));
                differs = true;
            }
            if differs {
                (change.from_s, change.to_s) = (change.from_s.min(at_s), at_s);
            }
        }
        change.joints =
            s.links().iter().zip(moved).filter(|(_, m)| *m).map(|(l, _)| l.name.clone()).collect();
        let place = |j: &JointChange| s.link(&j.link);
        change.of_joints.sort_by_key(place);
        Ok((change.from_s <= change.to_s).then_some(change))
    }

    /// Takes in one frame that differs: the turn (rad) and way (m) of each link.
    fn compare(&mut self, s: &Skeleton, ways: &[(f64, f64)], at_s: f64) {
        for (link, &(turn, way)) in s.links().iter().zip(ways) {
            if (turn, way) == (0.0, 0.0) {
                continue;
            }
            let (turn, way) = (turn.to_degrees(), 1e3 * way);
            larger(&mut self.turned, &link.name, turn, at_s);
            larger(&mut self.moved, &link.name, way, at_s);
            match self.of_joints.iter_mut().find(|j| j.link == link.name) {
                Some(j) => {
                    j.to_s = at_s;
                    (j.turned_deg, j.moved_mm) = (j.turned_deg.max(turn), j.moved_mm.max(way));
                }
                None => self.of_joints.push(JointChange {
                    link: link.name.clone(),
                    from_s: at_s,
                    to_s: at_s,
                    turned_deg: turn,
                    moved_mm: way,
                }),
            }
        }
    }
}

fn larger(largest: &mut Option<Largest>, link: &str, amount: f64, at_s: f64) {
    if amount > NOISE && largest.as_ref().is_none_or(|l| amount > l.amount) {
        *largest = Some(Largest { link: link.into(), amount, at_s });
    }
}

/// `1 s to 2 s: elbow_r, spine; at most 12.30° at elbow_r; slope 0.50 to 1.80, 4.000 s became 5.500 s`.
impl fmt::Display for ClipChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.3} s to {:.3} s: ", self.from_s, self.to_s)?;
        let joints = if self.joints.is_empty() { "no joint".into() } else { self.joints.join(", ") };
        write!(f, "{joints}")?;
        if let Some(l) = &self.turned {
            write!(f, "; at most {:.2}° at {}", l.amount, l.link)?;
        }
        if let Some(l) = &self.moved {
            write!(f, "; {} moved by at most {:.1} mm", l.link, l.amount)?;
        }
        if let Some((least, most)) = self.slopes {
            let (before, after) = self.lengths_s;
            write!(f, "; time has slopes {least:.3} to {most:.3}, {before:.3} s became {after:.3} s")?;
        }
        Ok(())
    }
}
