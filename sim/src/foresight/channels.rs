//! Channels: which joints a search moves, and how far.
//!
//! In: a character, its plan. Out: one [`Channel`] per degree of freedom that may be offset: the joints of the chains from the root to what
//! stands, the first two joints of a trunk, shoulders. A body that stands on its root, as a lamp on its plate, moves what it has.
//!
//! A muscle of stiffness K answers an offset δ of its target with the torque K δ. Deviations are those of tension 1, over the tension, so that
//! the torques are of the same size at any. A lower tension means larger offsets, not weaker ones.

use bodies::{Character, JointClass};
use controllers::{Drive, Plan, Rest};
use dynamics::Model;
use motion::rotation::exp;
use motion::{LimbKind, Vec3};

/// Deviation of the joints of a chain at tension 1, rad: next to the root, ...
const FIRST: f64 = 0.24;
/// ... in between, ...
const MIDDLE: f64 = 0.2;
/// ... and at what stands.
const LAST: f64 = 0.3;
/// Deviation of the first and the second joint of a trunk, rad.
const TRUNK: [f64; 2] = [0.16, 0.12];
/// Deviation of a shoulder, rad.
const SHOULDER: f64 = 0.3;
/// Below this tension offsets grow no more: targets are not to leave the joint's range.
const LEAST_TENSION: f64 = 0.5;

/// A degree of freedom that is offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// Moving body of the joint.
    pub body: usize,
    /// Axis of the joint's zero frame; 0 for a hinge.
    pub axis: usize,
    /// Standard deviation of offsets, rad (m for slides).
    pub deviation: f64,
}

/// Moving bodies of what stands: feet, else every body with contact points.
pub(super) fn supports(character: &Character, model: &Model) -> Vec<usize> {
    let body = |link: usize| model.body_of[link].0;
    let mut feet: Vec<usize> = character.leg_soles().iter().map(|(leg, _)| body(leg.end)).collect();
    if feet.is_empty() {
        feet = character.soles().iter().map(|s| body(s.link)).collect();
    }
    feet.sort_unstable();
    feet.dedup();
    feet
}

/// The channels of a body. See the module header.
pub(super) fn of(character: &Character, model: &Model, plan: &Plan) -> Vec<Channel> {
    let body = |link: usize| model.body_of[link].0;
    // per body, the deviation at tension 1
    let mut deviations = vec![0.0; model.bodies.len()];
    let supports = supports(character, model);
    for &support in &supports {
        let chain: Vec<usize> =
            std::iter::successors(Some(support), |&b| model.bodies[b].parent).filter(|&b| b != 0).collect();
        for (k, &b) in chain.iter().enumerate() {
            deviations[b] = if k == 0 {
                LAST
            } else if k + 1 == chain.len() {
                FIRST
            } else {
                MIDDLE
            };
        }
    }
    if supports.contains(&0) {
        deviations.iter_mut().skip(1).filter(|d| **d == 0.0).for_each(|d| *d = MIDDLE);
    }
    for limb in character.skeleton.limbs().iter().filter(|l| l.kind != LimbKind::Leg) {
        let b = body(limb.upper);
        if deviations[b] == 0.0 {
            deviations[b] = SHOULDER;
        }
    }
    for (b, of) in model.bodies.iter().enumerate().skip(1) {
        let spine = |b: usize| character.classes[model.bodies[b].link] == JointClass::Spine;
        let above = of.parent.filter(|&p| p != 0 && spine(p));
        let third = above.and_then(|p| model.bodies[p].parent).is_some_and(|p| p != 0 && spine(p));
        if deviations[b] == 0.0 && spine(b) && !third {
            deviations[b] = TRUNK[usize::from(above.is_some())];
        }
    }
    let mut channels = Vec::new();
    for (b, deviation) in deviations.into_iter().enumerate().filter(|(_, d)| *d > 0.0) {
        let natural = plan.scale.k1[b];
        if natural <= 0.0 {
            continue;
        }
        let tension = (plan.impedances[b].stiffness / natural).max(LEAST_TENSION);
        let axes = model.bodies[b].joint.nv().min(3);
        channels.extend((0..axes).map(|axis| Channel { body: b, axis, deviation: deviation / tension }));
    }
    channels
}

/// Moves the targets of drives by `offsets`, one per channel: the target of a ball turns along the axes of its zero frame.
pub(super) fn shift(channels: &[Channel], offsets: &[f64], drives: &mut [Drive]) {
    let mut i = 0;
    while i < channels.len() {
        let body = channels[i].body;
        let mut by = Vec3::zeros();
        while i < channels.len() && channels[i].body == body {
            by[channels[i].axis] = offsets[i];
            i += 1;
        }
        match &mut drives[body].rest {
            Rest::Scalar(at) => *at += by.x,
            Rest::Ball { target, .. } => *target = exp(&by) * *target,
            Rest::None => {}
        }
    }
}
