//! The transitions of a script: where every joint starts, and every redirection it will get \[NF02\].
//!
//! Gains for the end pose of an element are known when it becomes active. Joints that hold still are balanced anew for
//! the pose the others are going to.

use dynamics::Model;
use motion::{Curve, Dof, Limits, Tracks, Value};

use super::dense::{Dense, DenseJoint};
use super::needs::PoseNeeds;
use super::{JointControl, ModelFrom, Sagging};
use crate::antagonist::SetPoints;
use crate::tension::{Need, TensionScale};
use crate::transition::Transition;
use crate::{Drive, Goal, Rest, rest_of};

/// Joints that get a new end at a time.
#[derive(Clone, Debug)]
pub(crate) struct Redirection {
    pub(crate) at_s: f64,
    pub(crate) changes: Vec<Change>,
}

/// The new end of one joint.
#[derive(Clone, Debug)]
pub(crate) struct Change {
    pub(crate) body: usize,
    pub(crate) to: Drive,
    pub(crate) end_s: f64,
    pub(crate) curve: Curve,
}

/// What the transitions of a script are planned from.
pub(super) struct ScriptPlanner<'a> {
    pub(super) tracks: &'a Tracks,
    /// Factor on every tension.
    pub(super) factor: f64,
    /// Joints that stay tracked.
    pub(super) dense: &'a Dense,
    pub(super) goal: &'a Goal,
    pub(super) models: &'a [ModelFrom],
    pub(super) set_points: &'a [SetPoints],
    pub(super) scale: &'a TensionScale,
    pub(super) needs: PoseNeeds<'a>,
    /// Where transitions end too slack.
    pub(super) sagging: Vec<Sagging>,
}

impl ScriptPlanner<'_> {
    /// Makes every tracked joint of `joints` that is not dense a transition that holds the first pose; returns the redirections and where
    /// they sag, in order of time.
    pub(super) fn plan(mut self, joints: &mut [JointControl]) -> (Vec<Redirection>, Vec<Sagging>) {
        let start = self.needs.at(0.0);
        for (i, joint) in joints.iter_mut().enumerate() {
            let dense = self.dense.joint(self.model().bodies[i].link).is_some_and(DenseJoint::is_throughout);
            if matches!(joint, JointControl::Tracked) && !dense {
                let target = rest_of(self.model(), i, self.goal.pose(0));
                let tension = self.factor * self.tracks.base_tension[self.model().bodies[i].link];
                *joint = JointControl::Transition(Transition::still(
                    self.hold(i, target, tension, &start[i], 0.0),
                ));
            }
        }
        let mut times: Vec<f64> = self.tracks.elements().map(|(_, e)| e.start_s).collect();
        times.extend(self.models.iter().skip(1).map(|m| m.from_s));
        times.sort_by(f64::total_cmp);
        times.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        let redirections = times.into_iter().map(|at_s| self.redirection(joints, at_s)).collect();
        self.sagging.sort_by(|a, b| a.time_s.total_cmp(&b.time_s).then(a.link.cmp(&b.link)));
        (redirections, self.sagging)
    }

    /// The body without what it will carry: joints are those of all models.
    fn model(&self) -> &Model {
        &self.models[0].model
    }

    /// What changes when the elements that start at `at_s` become active.
    fn redirection(&mut self, joints: &[JointControl], at_s: f64) -> Redirection {
        let tracks = self.tracks;
        let starting: Vec<_> = tracks.elements().filter(|(_, e)| (e.start_s - at_s).abs() < 1e-9).collect();
        let horizon = starting.iter().map(|(_, e)| e.arrives_s()).fold(at_s, f64::max);
        // joints that hold still brace along the curve of the element that arrives last
        let brace = starting
            .iter()
            .max_by(|a, b| a.1.arrives_s().total_cmp(&b.1.arrives_s()))
            .map_or(Curve::EaseInOut, |(_, e)| e.curve);
        // where the mass carried changes, joints are balanced anew at once, even if nothing moves
        let load_changes = self.models.iter().skip(1).any(|m| (m.from_s - at_s).abs() < 1e-9);
        let mut changes = Vec::new();
        for (body, joint) in joints.iter().enumerate() {
            if !matches!(joint, JointControl::Transition(_)) {
                continue;
            }
            let link = self.model().bodies[body].link;
            let Some(dof) = Dof::of_link(&tracks.skeleton, link) else { continue };
            let own = starting.iter().rev().find(|(d, _)| *d == dof).map(|(_, e)| *e);
            if let Some(e) = own {
                let target = self.clamped(link, &e.end);
                let need = self.needs.at(e.arrives_s())[body];
                let to = self.hold(body, target, self.factor * e.tension, &need, e.arrives_s());
                changes.push(Change { body, to, end_s: e.arrives_s(), curve: e.curve });
                continue;
            }
            let track = tracks.track(dof);
            let moving = track
                .and_then(|t| t.active(at_s).map(|i| &t.elements[i]))
                .is_some_and(|e| e.arrives_s() > at_s);
            if moving || (horizon <= at_s && !load_changes) {
                continue;
            }
            let target = self.clamped(link, &tracks.value_at(dof, at_s));
            let tension = self.factor * tracks.tension_at(link, at_s);
            let need = self.needs.at(horizon)[body];
            let to = self.hold(body, target, tension, &need, horizon);
            changes.push(Change { body, to, end_s: horizon, curve: brace });
        }
        Redirection { at_s, changes }
    }

    /// Drive that holds `target` under a need at dimensionless `tension`; notes where it sags.
    fn hold(&mut self, body: usize, target: Rest, tension: f64, need: &Need, at_s: f64) -> Drive {
        let stiffness = tension * self.scale.k1[body];
        let least = need.least();
        let link = self.model().bodies[body].link;
        // where it follows the clip, that is judged step by step
        let follows = self.dense.joint(link).is_some_and(|joint| joint.level_at(at_s) > 0.0);
        if stiffness < least * (1.0 - 1e-9) && !follows {
            self.sagging.push(Sagging { link, time_s: at_s, lasts_s: 0.0, tension: stiffness, least });
        }
        Drive {
            stiffness,
            damping: TensionScale::damping(stiffness, need.inertia),
            rest: self.set_points[body].rest(&target, need.load, stiffness),
        }
    }

    /// A value of a joint as rest, within the joint's limits.
    fn clamped(&self, link: usize, value: &Value) -> Rest {
        match (value, &self.model().skeleton.links()[link].limits) {
            (Value::Scalar(x), Some(Limits::Axis(r))) => Rest::Scalar(r.clamp(*x)),
            (Value::Scalar(x), _) => Rest::Scalar(*x),
            (Value::Rotation(r), Some(Limits::Ball(b))) => Rest::ball(b.clamp(r)),
            (Value::Rotation(r), _) => Rest::ball(*r),
        }
    }
}
