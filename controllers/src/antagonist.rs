//! Antagonistic actuators: two opposed springs and a damper per joint axis.
//!
//! Unloaded, the ratio of the gains sets where the joint rests; their sum, the tension K, how hard it
//! holds \[NF02\]. In: angle, rate, load. Out: gains, torque. No engine, no state.
//!
//! Symbols: `q` angle (rad), `lo < hi` set points (rad), beyond the joint's limits, `k_lo k_hi` gains
//! (N·m/rad), never negative because springs only pull, `kd` damping (N·m·s/rad); about the joint axis,
//! zero frame. For slides read m and N.
//!
//! Both gains non-negative is the same as: the unloaded rest lies between the set points. That is how
//! every joint is bounded here. A ball has a pair for each of its anatomical coordinates φ: with ω = A φ̇
//! its load along coordinate i is (Aᵀ load)ᵢ, at the target.
//!
//! \[NF02\] Neff, Fiume. Modeling tension and relaxation for computer animation, SCA 2002.

use motion::rotation::{exp, exp_rate};
use motion::{BallLimits, Joint, Limits, Link, Quat, Range, Skeleton, Vec3};
use nalgebra::Matrix3;
use thiserror::Error;

use crate::Rest;

/// How far the set points lie beyond the limits, rad.
pub const MARGIN: f64 = 20.0 * std::f64::consts::PI / 180.0;

/// Why a pose cannot be held.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum HoldError {
    /// The angle is not between the set points.
    #[error("{q} rad is outside the set points ({lo}, {hi})")]
    OutOfRange {
        /// Angle asked for, rad.
        q: f64,
        /// Lower set point, rad.
        lo: f64,
        /// Upper set point, rad.
        hi: f64,
    },
    /// A spring would have to push.
    #[error("tension {tension} N·m/rad is too little: {least} N·m/rad needed")]
    TooRelaxed {
        /// Tension given, N·m/rad.
        tension: f64,
        /// Least tension that holds the load, N·m/rad.
        least: f64,
    },
}

/// A pair of springs and a damper about one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Antagonist {
    /// Lower set point, rad.
    pub lo: f64,
    /// Upper set point, rad.
    pub hi: f64,
    /// Gain towards `lo`, N·m/rad, ≥ 0.
    pub k_lo: f64,
    /// Gain towards `hi`, N·m/rad, ≥ 0.
    pub k_hi: f64,
    /// Damping, N·m·s/rad.
    pub kd: f64,
}

impl Antagonist {
    /// Returns gains that hold `q` against `load` with the given tension, undamped.
    ///
    /// Solves `k_lo (lo − q) + k_hi (hi − q) + load = 0`, `k_lo + k_hi = tension`: one point of the
    /// iso-angle line of \[NF02\].
    ///
    /// * `q`: rad, strictly inside `(lo, hi)`
    /// * `load`: outside torque on the same axis, N·m
    /// * `tension`: N·m/rad, > 0
    ///
    /// # Errors
    /// `OutOfRange` outside the set points; `TooRelaxed { least }` if a spring would have to push.
    ///
    /// # Examples
    /// ```
    /// # use controllers::Antagonist;
    /// let elbow = Antagonist::hold(-0.3, 2.8, 1.2, -3.0, 40.0).unwrap();
    /// assert!((elbow.torque(1.2, 0.0) - 3.0).abs() < 1e-12); // balances
    /// ```
    pub fn hold(lo: f64, hi: f64, q: f64, load: f64, tension: f64) -> Result<Self, HoldError> {
        if !(lo < q && q < hi) {
            return Err(HoldError::OutOfRange { q, lo, hi });
        }
        let least = least_for_load(Range::new(lo, hi), q, load);
        if tension < least {
            return Err(HoldError::TooRelaxed { tension, least });
        }
        Ok(Self::at_rest(Range::new(lo, hi), tension, q - load / tension))
    }

    /// Gains of the pair with tension `tension` whose unloaded rest is `rest`, moved between the set
    /// points: where one gain would be negative it is zero and the other takes all.
    pub fn at_rest(set: Range, tension: f64, rest: f64) -> Self {
        let share = ((rest - set.lo) / (set.hi - set.lo)).clamp(0.0, 1.0);
        let (k_hi, k_lo) = (tension * share, tension * (1.0 - share));
        Self { lo: set.lo, hi: set.hi, k_lo, k_hi, kd: 0.0 }
    }

    /// Tension K = k_lo + k_hi, N·m/rad.
    pub fn tension(&self) -> f64 {
        self.k_lo + self.k_hi
    }

    /// Angle at which the pair rests without load, rad.
    pub fn rest(&self) -> f64 {
        (self.k_lo * self.lo + self.k_hi * self.hi) / self.tension()
    }

    /// Torque on the joint at angle `q` (rad) and rate `qd` (rad/s), N·m.
    pub fn torque(&self, q: f64, qd: f64) -> f64 {
        self.k_lo * (self.lo - q) + self.k_hi * (self.hi - q) - self.kd * qd
    }
}

/// Least tension that holds `q` between the set points against `load` with pulling springs only,
/// N·m/rad: max(load/(q − lo), −load/(hi − q)), DESIGN §4.
pub fn least_for_load(set: Range, q: f64, load: f64) -> f64 {
    (load / (q - set.lo)).max(-load / (set.hi - q))
}

/// Set points of a joint's axes: its limits widened by [`MARGIN`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SetPoints {
    /// A hinge or slide.
    Axis(Range),
    /// A ball, in anatomical coordinates.
    Ball(BallLimits),
    /// Not actuated.
    None,
}

/// Half range of a joint without limits, rad.
const UNLIMITED: f64 = std::f64::consts::PI;

impl SetPoints {
    /// Set points of a joint with the given limits; an unlimited joint gets ±180° plus the margin.
    pub fn of(joint: &Joint, limits: Option<&Limits>) -> Self {
        let widen = |r: &Range| Range::new(r.lo - MARGIN, r.hi + MARGIN);
        let free = widen(&Range::new(-UNLIMITED, UNLIMITED));
        match (joint, limits) {
            (Joint::Revolute(_) | Joint::Prismatic(_), Some(Limits::Axis(r))) => Self::Axis(widen(r)),
            (Joint::Revolute(_) | Joint::Prismatic(_), _) => Self::Axis(free),
            (Joint::Spherical, Some(Limits::Ball(b))) => {
                Self::Ball(BallLimits { axes: b.axes, ranges: b.ranges.map(|r| widen(&r)) })
            }
            (Joint::Spherical, _) => {
                Self::Ball(BallLimits { axes: [Vec3::x(), Vec3::y(), Vec3::z()], ranges: [free; 3] })
            }
            _ => Self::None,
        }
    }

    /// Unloaded rest that balances `load` at `target` with stiffness `k`, within the set points.
    ///
    /// Hinge: θ* − load/K; ball: shift −load/K, each of its anatomical axes bounded on its own. `load` is
    /// along the zero frame (in `.x` for hinges and slides), N·m.
    pub fn rest(&self, target: &Rest, load: Vec3, k: f64) -> Rest {
        match (self, target) {
            (Self::Axis(set), Rest::Scalar(q)) => Rest::Scalar(set.clamp(q - load.x / k)),
            (Self::Ball(set), Rest::Ball { target, .. }) => {
                let (phi, axes) = anatomical(set, target);
                let wanted = axes.tr_mul(&(-load / k));
                let bounded = Vec3::from_fn(|i, _| set.ranges[i].clamp(phi[i] + wanted[i]) - phi[i]);
                let shift = if (bounded - wanted).amax() < 1e-12 {
                    -load / k
                } else {
                    // Regular for swings below half a turn, which limits keep.
                    axes.transpose().try_inverse().map_or(-load / k, |inverse| inverse * bounded)
                };
                Rest::Ball { target: *target, shift }
            }
            _ => Rest::None,
        }
    }

    /// Least stiffness that holds `target` against `load` with pulling springs only, N·m/rad.
    ///
    /// For a ball: the worst of its three anatomical axes.
    pub fn least(&self, target: &Rest, load: Vec3) -> f64 {
        match (self, target) {
            (Self::Axis(set), Rest::Scalar(q)) => least_for_load(*set, *q, load.x),
            (Self::Ball(set), Rest::Ball { target, .. }) => {
                let (phi, axes) = anatomical(set, target);
                let load = axes.tr_mul(&load);
                (0..3).map(|i| least_for_load(set.ranges[i], phi[i], load[i])).fold(0.0, f64::max)
            }
            _ => 0.0,
        }
    }

    /// Gains `(k_lo, k_hi)` of each axis for stiffness `k` resting at `rest`; for display and export.
    pub fn gains(&self, k: f64, rest: &Rest) -> [(f64, f64); 3] {
        let pair = |set: Range, rest: f64| {
            let a = Antagonist::at_rest(set, k, rest);
            (a.k_lo, a.k_hi)
        };
        match (self, rest) {
            (Self::Axis(set), Rest::Scalar(q)) => [pair(*set, *q), (0.0, 0.0), (0.0, 0.0)],
            (Self::Ball(set), Rest::Ball { target, shift }) => {
                let (phi, axes) = anatomical(set, target);
                let rest = phi + axes.tr_mul(shift);
                std::array::from_fn(|i| pair(set.ranges[i], rest[i]))
            }
            _ => [(0.0, 0.0); 3],
        }
    }
}

/// Set points (θ_L, θ_H) of every hinge (rad) and slide (m) of a skeleton, per link.
pub fn axis_set_points(skeleton: &Skeleton) -> Vec<(usize, [f64; 2])> {
    let links = skeleton.links().iter().enumerate();
    let axis = |(i, l): (usize, &Link)| match SetPoints::of(&l.joint, l.limits.as_ref()) {
        SetPoints::Axis(set) => Some((i, [set.lo, set.hi])),
        _ => None,
    };
    links.filter_map(axis).collect()
}

/// Anatomical coordinates φ of a ball and the matrix A of ω = A φ̇, zero frame.
///
/// R = exp(s) exp(φ₂ a₂) with s = φ₀ a₀ + φ₁ a₁: the swings turn by J(s) a₀ and J(s) a₁, the twist about
/// the swung bone.
pub(crate) fn anatomical(set: &BallLimits, r: &Quat) -> (Vec3, Matrix3<f64>) {
    let phi = set.coords(r);
    let s = set.axes[0] * phi[0] + set.axes[1] * phi[1];
    let twist = exp(&s) * set.axes[2];
    (phi, Matrix3::from_columns(&[exp_rate(&s, &set.axes[0]), exp_rate(&s, &set.axes[1]), twist]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// More tension stiffens the joint; it must not move the pose.
    #[test]
    fn tension_leaves_the_pose_alone() {
        for tension in [20.0, 80.0, 320.0] {
            let a = Antagonist::hold(-0.5, 2.5, 1.2, -4.0, tension).unwrap();
            let error = a.torque(1.2, 0.0) - 4.0; // N·m; ~1e-14 seen
            assert!(error.abs() < 1e-9, "tension {tension}: {error}");
            assert!((a.tension() - tension).abs() < 1e-12);
            assert!(a.k_lo >= 0.0 && a.k_hi >= 0.0);
        }
    }

    /// Just below the least tension a spring would have to push.
    #[test]
    fn least_tension_is_where_one_spring_lets_go() {
        for load in [-4.0, 4.0] {
            let least = least_for_load(Range::new(-0.5, 2.5), 1.2, load);
            let a = Antagonist::hold(-0.5, 2.5, 1.2, load, least * (1.0 + 1e-12)).unwrap();
            assert!(a.k_lo.min(a.k_hi) < 1e-9);
            let error = Antagonist::hold(-0.5, 2.5, 1.2, load, least * 0.999).unwrap_err();
            assert!(matches!(error, HoldError::TooRelaxed { .. }));
        }
    }

    fn shoulder() -> SetPoints {
        let ranges = [Range::new(-1.0, 2.0), Range::new(-1.2, 0.9), Range::new(-0.8, 1.1)];
        let limits = BallLimits { axes: [Vec3::x(), Vec3::z(), -Vec3::y()], ranges };
        SetPoints::of(&Joint::Spherical, Some(&Limits::Ball(limits)))
    }

    /// A ball rests at its set pose, under load, and is equally stiff in all directions there, for any
    /// stiffness that can hold: the curvature of its potential is K.
    #[test]
    fn a_loaded_ball_balances_at_its_target() {
        let load = Vec3::new(3.0, -1.0, 2.0);
        for set in [SetPoints::of(&Joint::Spherical, None), shoulder()] {
            let target = exp(&Vec3::new(0.3, -0.5, 0.2));
            let least = set.least(&Rest::ball(target), load);
            for k in [1.001 * least, 4.0 * least] {
                let rest = set.rest(&Rest::ball(target), load, k);
                let drive = crate::Drive { stiffness: k, damping: 0.0, rest };
                let torque = |delta: Vec3| drive.pull(&(exp(&delta) * target)) * k;
                assert!((torque(Vec3::zeros()) + load).norm() < 1e-12);
                for e in [Vec3::x(), Vec3::y(), Vec3::new(0.0, 0.6, 0.8)] {
                    let h = 1e-5;
                    let stiffness = -(torque(e * h) - torque(-e * h)).dot(&e) / (2.0 * h);
                    assert!((stiffness / k - 1.0).abs() < 1e-8, "{stiffness} {k}"); // 4e-11 seen
                }
                let all = set.gains(k, &rest);
                assert!(all.iter().all(|g| g.0 >= 0.0 && g.1 >= 0.0 && (g.0 + g.1 - k).abs() < 1e-12));
            }
        }
    }

    /// Below its least tension exactly one spring of a ball has let go, and less torque is left.
    #[test]
    fn a_slack_ball_sags() {
        let (set, target) = (shoulder(), exp(&Vec3::new(0.3, -0.5, 0.2)));
        let load = Vec3::new(3.0, -1.0, 2.0);
        let k = 0.9 * set.least(&Rest::ball(target), load);
        let rest = set.rest(&Rest::ball(target), load, k);
        let slack = set.gains(k, &rest).iter().flat_map(|g| [g.0, g.1]).filter(|g| g.abs() < 1e-12).count();
        assert_eq!(slack, 1);
        let drive = crate::Drive { stiffness: k, damping: 0.0, rest };
        assert!((drive.pull(&target) * k + load).norm() > 0.01 * load.norm());
    }

    /// The torque of a ball's springs has a potential: no work on any closed loop.
    #[test]
    fn a_ball_pumps_no_energy() {
        let (set, target) = (shoulder(), exp(&Vec3::new(0.3, -0.5, 0.2)));
        let rest = set.rest(&Rest::ball(target), Vec3::new(9.0, -4.0, 6.0), 20.0);
        let drive = crate::Drive { stiffness: 20.0, damping: 0.0, rest };
        let n = 20_000;
        let at = |i: usize| {
            let t = i as f64 / n as f64 * std::f64::consts::TAU;
            exp(&(Vec3::new(t.cos() - 1.0, (2.0 * t).sin(), t.sin()) * 0.8))
        };
        let (mut work, mut moved) = (0.0, 0.0);
        for i in 0..n {
            let turn = motion::rotation::log(&(at(i + 1) * at(i).inverse()));
            let mean = (drive.pull(&at(i)) + drive.pull(&at(i + 1))) * 0.5;
            work += 20.0 * mean.dot(&turn);
            moved += 20.0 * (mean.dot(&turn)).abs();
        }
        assert!(work.abs() < 1e-6 * moved, "{work} of {moved} J"); // 1e-9 seen
    }

    /// The folded form and the pair are one law.
    #[test]
    fn the_pair_is_one_spring_at_its_rest() {
        let a = Antagonist { lo: -0.4, hi: 2.0, k_lo: 7.0, k_hi: 12.0, kd: 0.5 };
        for q in [-0.2, 0.7, 1.9] {
            let folded = a.tension() * (a.rest() - q) - a.kd * 0.3;
            assert!((folded - a.torque(q, 0.3)).abs() < 1e-12);
        }
        let again = Antagonist::at_rest(Range::new(-0.4, 2.0), a.tension(), a.rest());
        assert!((again.k_lo - 7.0).abs() < 1e-12 && (again.k_hi - 12.0).abs() < 1e-12);
    }
}
