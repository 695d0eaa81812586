//! Limits of joints as bounds of single coordinates, for the active set of [`pose`](super).
//!
//! A hinge or slide has one coordinate, a ball the three of [`BallLimits`]: two swings and a twist. In a corner of a ball's limits
//! each bound is one of its own, along which the joint may slide ([`crate::limits`] has one way back for a whole ball, which says
//! nothing of that).
//!
//! Units: rad, m.

use crate::rotation::exp;
use crate::skeleton::Limits;
use crate::{BallLimits, Joint, Range, Skeleton, Vec3};

/// How far beyond its limit a joint is left that is at it: it has to be seen there by the next step.
pub const AT_LIMIT: f64 = 1e-8;

/// Less is rounding.
const ROUNDING: f64 = 1e-9;

/// Step of differences, rad.
const STEP: f64 = 1e-6;

/// Whether a coordinate is beyond its limit.
pub fn is_beyond(excess: f64) -> bool {
    excess.abs() > ROUNDING
}

fn ball(s: &Skeleton, link: usize) -> Option<&BallLimits> {
    match (&s.links()[link].limits, s.links()[link].joint) {
        (Some(Limits::Ball(b)), Joint::Spherical) => Some(b),
        _ => None,
    }
}

/// A coordinate of a joint.
pub fn coordinate(s: &Skeleton, q: &[f64], link: usize, which: usize) -> f64 {
    match ball(s, link) {
        Some(b) => b.coords(&s.rotation(q, link))[which],
        None => q[s.q_at(link)],
    }
}

/// How far each coordinate is beyond its range, above it or (negative) below; 0 within.
pub fn excess(s: &Skeleton, q: &[f64], link: usize, ranges: &[Range; 3]) -> Vec3 {
    let beyond = |x: f64, range: &Range| x - range.clamp(x);
    match ball(s, link) {
        Some(b) => {
            let phi = b.coords(&s.rotation(q, link));
            Vec3::from_fn(|i, _| beyond(phi[i], &ranges[i]))
        }
        None => Vec3::x() * beyond(q[s.q_at(link)], &ranges[0]),
    }
}

/// Slope of a coordinate by the degrees of freedom of its joint; only the first counts of a hinge or slide.
pub fn slope(s: &Skeleton, q: &[f64], link: usize, which: usize) -> Vec3 {
    let Some(b) = ball(s, link) else { return Vec3::x() };
    let r = s.rotation(q, link);
    let at = |axis: usize, by: f64| b.coords(&(exp(&(Vec3::ith(axis, by))) * r))[which];
    Vec3::from_fn(|axis, _| (at(axis, STEP) - at(axis, -STEP)) / (2.0 * STEP))
}

/// Moves a joint to at most [`AT_LIMIT`] beyond its ranges; returns whether it moved.
pub fn clamp(s: &Skeleton, q: &mut [f64], link: usize, ranges: &[Range; 3]) -> bool {
    let wider = ranges.map(|r| Range::new(r.lo - AT_LIMIT, r.hi + AT_LIMIT));
    if excess(s, q, link, &wider) == Vec3::zeros() {
        return false;
    }
    match ball(s, link) {
        Some(b) => {
            let r = BallLimits { axes: b.axes, ranges: wider }.clamp(&s.rotation(q, link));
            s.set_rotation(q, link, &r);
        }
        None => {
            let x = &mut q[s.q_at(link)];
            *x = wider[0].clamp(*x);
        }
    }
    true
}
