//! Pose delta: one pose corrected, and the frames around it with it: y(t) = x(t) ⊕ w(t) δ (IAF09, §5).
//!
//! In: a time and what is asked of the pose there ([`PoseRequest`]), or the difference δ itself; how long it is blended in
//! and out; a block over which it is whole. Out: the clip with a layer on it: w is 1 at the time, or over the block, and goes to 0
//! within `blend_s` before and after along the least-jerk curve ([`Curve::EaseInOut`]; the paper's is a straight line, whose
//! corners show as jerks). Times and contacts stay.
//!
//! δ is a rotation vector in the axes of each joint's zero frame, and a way for slides and the root: over a block every frame is
//! changed by the same δ. Layers add up: a second edit works on what the first left. δ = 0 is the identity, to the bit, and so
//! is every frame where w is 0. `parts` keep only their joints of δ. `span_s` bounds the frames that change: a blend that would
//! leave it is made shorter. With `limits` a joint goes no further beyond them than it was in its frame.
//!
//! Symbols: x ⊕ δ is [`motion::Skeleton::integrate`]; rad, m, s.

use motion::{Curve, Dof, Joint, Value, rotation};

use crate::pose_request::PoseRequest;
use crate::poses::within_limits;
use crate::{ClipEdit, ClipPlace, EditError, EditLog, Edited, Motion};

/// Times that differ by less are one time, s.
const SAME_S: f64 = 1e-9;

/// How long a pose is blended in, and out, if nothing is said, s.
pub const BLEND_S: f64 = 0.3;

/// A dragged point that is nearer to its place than this was reached, m.
const REACHED_M: f64 = 0.01;

/// One pose corrected. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseDelta {
    /// When, s.
    pub at_s: f64,
    /// What is different there.
    pub change: PoseChange,
    /// How long it comes in before the time or block, and goes out after it, s, ≥ 0.
    pub blend_s: f64,
    /// From when to when it is whole, s; without it at `at_s` only.
    pub block_s: Option<(f64, f64)>,
}

/// What is different.
#[derive(Clone, Debug, PartialEq)]
pub enum PoseChange {
    /// What comes of dragging.
    Asked(PoseRequest),
    /// δ (`nv`) itself.
    Delta {
        /// δ.
        delta: Vec<f64>,
        /// Whether joints keep their limits.
        limits: bool,
    },
}

impl PoseDelta {
    fn weight(&self, (from_s, to_s): (f64, f64), at: &ClipPlace, t_s: f64) -> f64 {
        let ramp = |gone: f64, room: f64| {
            let whole = self.blend_s.min(room);
            if gone <= 0.0 {
                1.0
            } else if gone >= whole - SAME_S {
                0.0
            } else {
                1.0 - Curve::EaseInOut.at(gone / whole)
            }
        };
        if t_s < from_s { ramp(from_s - t_s, from_s - at.from_s) } else { ramp(t_s - to_s, at.to_s - to_s) }
    }

    fn check(&self, motion: &Motion, at: &ClipPlace) -> Result<(f64, f64), EditError> {
        let edit = self.name();
        let fault = |what, value, allowed| {
            Err(EditError::Parameter { edit, what, value, at: String::new(), allowed })
        };
        if !(self.blend_s >= 0.0 && self.blend_s.is_finite()) {
            return fault("`blend_s`", self.blend_s, "finite, 0 or more");
        }
        let grace = 0.5 / motion.clip.rate_hz;
        let (from_s, to_s) = self.block_s.unwrap_or((self.at_s, self.at_s));
        for (what, t_s) in [("at_s", self.at_s), ("block_s", from_s), ("block_s", to_s)] {
            if !(t_s >= at.from_s - grace && t_s <= at.to_s + grace) {
                let (span_from_s, span_to_s) = (at.from_s, at.to_s);
                return Err(EditError::TimeOutside { edit, what, t_s, from_s: span_from_s, to_s: span_to_s });
            }
        }
        if from_s > to_s {
            return fault("the end of `block_s`", to_s, "no earlier than its beginning");
        }
        Ok((from_s, to_s))
    }
}

impl ClipEdit for PoseDelta {
    fn name(&self) -> &'static str {
        "pose-delta"
    }

    fn change(&self, motion: &Motion, at: &ClipPlace, log: &mut EditLog) -> Result<Edited, EditError> {
        let block = self.check(motion, at)?;
        let s = motion.clip.skeleton.clone();
        let (delta, limits) = match &self.change {
            PoseChange::Delta { delta, limits } => {
                let (found, needed) = (delta.iter().filter(|x| x.is_finite()).count(), s.nv());
                if delta.len() != needed || found != needed {
                    return Err(EditError::Delta { edit: self.name(), found, needed });
                }
                (delta.clone(), *limits)
            }
            PoseChange::Asked(request) => {
                let mut q = vec![0.0; s.nq()];
                motion.clip.sample(self.at_s, &mut q);
                let answer = request.solve(self.name(), &s, &q)?;
                for met in answer.met.iter().filter(|m| m.miss_m > REACHED_M || (m.pinned && m.miss_m > 1e-6))
                {
                    let verb = if met.pinned { "pinned" } else { "dragged" };
                    log.note(format!(
                        "{} is {:.1} mm from where it was {verb} to",
                        met.name,
                        1e3 * met.miss_m
                    ));
                }
                (answer.delta, request.limits)
            }
        };
        let mut edited = Edited::unchanged(motion);
        let mut cut = 0usize;
        for frame in 0..edited.clip.frames() {
            let t_s = frame as f64 / edited.clip.rate_hz;
            // times are written with few digits: within half a frame of the block is in it
            let near = 0.5 / edited.clip.rate_hz;
            let inside = t_s > block.0 - near && t_s < block.1 + near;
            let w = if inside { 1.0 } else { self.weight(block, at, t_s) };
            if w == 0.0 {
                continue;
            }
            let q = edited.clip.pose_mut(frame);
            for &dof in &at.dofs {
                let before = dof.read(&s, q);
                let Some(after) = moved(&s, dof, &before, &delta, w) else { continue };
                let (after, clamped) =
                    if limits { within_limits(&s, dof, &before, &after) } else { (after, false) };
                cut += usize::from(clamped);
                dof.write(&s, q, &after);
            }
        }
        if cut > 0 {
            log.note(format!("limits held back {cut} joints of frames beside the pose"));
        }
        Ok(edited)
    }
}

/// The value of a DOF moved by the share w of δ; `None` where δ is zero.
fn moved(s: &motion::Skeleton, dof: Dof, value: &Value, delta: &[f64], w: f64) -> Option<Value> {
    let at = s.v_at(dof.link());
    match (dof, value) {
        (Dof::Rotation(link), Value::Rotation(r)) => {
            let at = if matches!(s.links()[link].joint, Joint::Free) { at + 3 } else { at };
            let turn = motion::skeleton::vec_at(delta, at);
            (turn != motion::Vec3::zeros()).then(|| Value::Rotation(rotation::exp(&(turn * w)) * r))
        }
        (Dof::Coordinate(_, i), Value::Scalar(x)) => {
            (delta[at + i] != 0.0).then(|| Value::Scalar(x + w * delta[at + i]))
        }
        (_, Value::Scalar(x)) => (delta[at] != 0.0).then(|| Value::Scalar(x + w * delta[at])),
        _ => None,
    }
}
