//! Penalty contact: the force the ground gives to a point at a height and a velocity \[YAH10, §5.3\].
//!
//! In: height and slip of a point and their rates. Out: force on the point, and its gradients. A
//! function of the kinematics alone: no engine, no solver, no memory but the anchors given.
//!
//! Normal force, (13), up positive, `z < 0` inside the ground:
//!
//! ```text
//! f_n = ½ k_P (√(z² + 4 f_0²/k_P²) − z) − k_D g(z) ż,   g(z) = 1 − ½ e^{kz} (z < 0), ½ e^{−kz} (z ≥ 0)
//! ```
//!
//! At rest `f_n → −k_P z` deep inside, `→ 0` far above, and `f_0` at `z = 0`. `g` and its slope are
//! continuous at 0. Friction, (14), with `r̂` the nominal position (the anchor):
//!
//! ```text
//! f_t = μ f_n h(|F|) F,   F = −k_tP (r − r̂) − k_tD ṙ,   h(x) = (1 − e^{−k_t x})/x → k_t as x → 0
//! ```
//!
//! so `|f_t| = μ |f_n| (1 − e^{−k_t |F|}) ≤ μ |f_n|`.
//!
//! # Adhesion
//!
//! As printed, `f_n` is negative when a point leaves fast enough, `k_D g ż > ` spring: the ground pulls,
//! and friction then drives the slip instead of braking it. The paper does not say so.
//! [`Pull::AsPrinted`] keeps that; [`Pull::Never`] passes `f_n` through a smooth `max(·, 0)`, in force,
//! gradient and friction alike. With `t = f/w` (`w` its width):
//!
//! ```text
//! 0 (t ≤ 0);   w t³ (6 − 8t + 3t²) (0 < t < 1);   f (t ≥ 1)
//! ```
//!
//! twice continuously differentiable, monotone, and exactly `f` above the width.
//!
//! # What it can supply
//!
//! Of the six components of a wrench, contacts that do not slip (`ṙ = 0`) with `k_tP = 0` give three:
//! the vertical force and the moments about the two horizontal axes (pitch about X, roll about Z).
//! Friction is then identically zero, so no horizontal force and no moment about the vertical
//! can be matched by moving the root's height. With anchors and `k_tP > 0` all six are there, the
//! horizontal ones within the friction cone.
//!
//! Frames and symbols: world axes, Y up; tangential pairs are `[x, z]`. `z` (m) height above the ground,
//! `ż` (m/s), slip `r − r̂` (m), `ṙ` (m/s). Forces in N.
//!
//! \[YAH10\] Yamane, Ariki, Hodgins. Animating Non-Humanoid Characters with Human Motion Data, SCA 2010.

use motion::Vec3;
use nalgebra::{Matrix2, Matrix3x2, Vector2};
use thiserror::Error;

use crate::{Model, State, Wrench};

/// What becomes of a normal force below zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pull {
    /// The ground pulls, as (13) is printed.
    AsPrinted,
    /// The ground only pushes: smooth `max(f, 0)`.
    Never {
        /// Force above which nothing is altered, N, > 0.
        width_n: f64,
    },
}

/// Parameters of (13) and (14). See the module header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penalty {
    /// Normal stiffness, N/m, > 0.
    pub k_p: f64,
    /// Normal damping deep inside the ground, N·s/m.
    pub k_d: f64,
    /// Force left at zero height, N, > 0.
    pub f_0: f64,
    /// Steepness of the damper's onset, 1/m.
    pub k: f64,
    /// Coefficient of friction.
    pub mu: f64,
    /// Stiffness towards the anchor, N/m.
    pub k_tp: f64,
    /// Damping of slip, N·s/m.
    pub k_td: f64,
    /// Steepness of friction, 1/N.
    pub k_t: f64,
    /// Below this `|F|`, N, `h` is its series: the quotient is 0/0 at 0.
    pub epsilon: f64,
    /// Whether the ground may pull.
    pub pull: Pull,
}

/// A parameter no body has.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("penalty contact: {name} is {value}; it must be positive and finite")]
pub struct PenaltyError {
    /// Which one, with its unit.
    pub name: &'static str,
    /// Value found.
    pub value: f64,
}

/// Damping ratio of a body that bobs on all its points, for [`Penalty::for_body`].
pub const DAMPING_RATIO: f64 = 0.5;
/// `f_0` of [`Penalty::for_body`] as a share of a point's standing load; the paper's corner has the
/// same width, 0.2 mm, at a sink of 1 mm.
pub const RESIDUAL_SHARE: f64 = 0.1;

/// A force with its gradients; components `[x, up, z]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointForce {
    /// Force on the point, world, N.
    pub force: Vec3,
    /// ∂f/∂z, N/m.
    pub d_z: Vec3,
    /// ∂f/∂ż, N·s/m.
    pub d_zd: Vec3,
    /// ∂f/∂(slip), one column each for x and z, N/m.
    pub d_slip: Matrix3x2<f64>,
    /// ∂f/∂(slip rate), one column each for x and z, N·s/m.
    pub d_rate: Matrix3x2<f64>,
}

impl Penalty {
    /// The values printed in \[YAH10, §6\], adhesion included.
    ///
    /// They suit bodies of a few kilograms: 75 kg on 8 points sinks 9 mm, and `k_D = 1` hardly damps.
    pub fn paper() -> Self {
        Self {
            k_p: 1e4,
            k_d: 1.0,
            f_0: 1.0,
            k: 20.0,
            mu: 1.0,
            k_tp: 0.0,
            k_td: 100.0,
            k_t: 20.0,
            epsilon: 1e-6,
            pull: Pull::AsPrinted,
        }
    }

    /// Parameters scaled to a body that stands on `contact_points` points, `sink_m` deep.
    ///
    /// With the share of the weight on a point, `s = m g/n`, and `ρ = ` [`RESIDUAL_SHARE`]:
    /// `f_0 = ρ s`, `k_P = (1 − ρ²) s/δ` (the factor makes the sink exactly δ, see
    /// [`Penalty::rest_height`]), `k = 3/δ`, so that the damper is gone a few δ above the ground; `k_D`
    /// gives small vertical motion of the standing body the ratio [`DAMPING_RATIO`] (`k_D` is
    /// proportional to it). Tangential: `k_tP = k_P`, `k_tD = k_D`, `k_t = 1/s`, `μ = ` [`motion::floor::FRICTION`].
    /// The ground never pulls.
    ///
    /// * `mass_kg`: of the whole body
    /// * `gravity_m_s2`: magnitude
    /// * `contact_points`: that share its weight, `n`
    /// * `sink_m`: depth at rest, δ; 0.001 to 0.002 is out of sight
    ///
    /// # Errors
    /// A value that is not positive and finite.
    ///
    /// # Examples
    /// ```
    /// # use dynamics::penalty::Penalty;
    /// let p = Penalty::for_body(75.0, 9.81, 8, 0.0015).unwrap();
    /// let share = 75.0 * 9.81 / 8.0;
    /// assert!((p.normal(-0.0015, 0.0) - share).abs() < 1e-9 * share);
    /// ```
    pub fn for_body(
        mass_kg: f64,
        gravity_m_s2: f64,
        contact_points: usize,
        sink_m: f64,
    ) -> Result<Self, PenaltyError> {
        let n = contact_points as f64;
        for (name, value) in [
            ("the mass (kg)", mass_kg),
            ("gravity (m/s²)", gravity_m_s2),
            ("the number of contact points", n),
            ("the depth at rest (m)", sink_m),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(PenaltyError { name, value });
            }
        }
        let share = mass_kg * gravity_m_s2 / n;
        let f_0 = RESIDUAL_SHARE * share;
        let k_p = (1.0 - RESIDUAL_SHARE * RESIDUAL_SHARE) * share / sink_m;
        let mut p = Self {
            k_p,
            k_d: 0.0,
            f_0,
            k: 3.0 / sink_m,
            mu: motion::floor::FRICTION,
            k_tp: k_p,
            k_td: 0.0,
            k_t: 1.0 / share,
            epsilon: 1e-6 * share,
            pull: Pull::Never { width_n: f_0 },
        };
        // m z̈ = −n (slope z + k_D g ż): ζ = n k_D g / (2 √(m n slope))
        let (_, slope, _) = p.normal_gradient(-sink_m, 0.0);
        p.k_d = 2.0 * DAMPING_RATIO * (mass_kg * -slope / n).sqrt() / p.onset(-sink_m);
        p.k_td = p.k_d;
        Ok(p)
    }

    /// Normal force at height `z` (m) and climb `zd` (m/s), N: (13), clamped as [`Pull`] says.
    pub fn normal(&self, z: f64, zd: f64) -> f64 {
        self.normal_gradient(z, zd).0
    }

    /// Normal force with ∂f/∂z and ∂f/∂ż.
    pub fn normal_gradient(&self, z: f64, zd: f64) -> (f64, f64, f64) {
        let corner = 2.0 * self.f_0 / self.k_p;
        let root = z.hypot(corner);
        // √(z² + c²) − z = c²/(√(z² + c²) + z): no difference of near numbers above the ground
        let gap = if z > 0.0 { corner * corner / (root + z) } else { root - z };
        let spring = 0.5 * self.k_p * gap;
        let slope = if root > 0.0 { -spring / root } else { -0.5 * self.k_p };
        let (g, dg) = (self.onset(z), -0.5 * self.k * (-self.k * z.abs()).exp());
        let (f, f_z, f_zd) = (spring - self.k_d * g * zd, slope - self.k_d * dg * zd, -self.k_d * g);
        let (clamped, rate) = self.clamp(f);
        (clamped, rate * f_z, rate * f_zd)
    }

    /// Force of a point, [x, up, z], N: (13) and (14).
    ///
    /// * `z`, `zd`: height above the ground and its rate
    /// * `slip`: `r − r̂`, `[x, z]`, m
    /// * `rate`: `ṙ`, `[x, z]`, m/s
    pub fn force(&self, z: f64, zd: f64, slip: [f64; 2], rate: [f64; 2]) -> Vec3 {
        let normal = self.normal(z, zd);
        let pull = self.tangential(slip, rate);
        let t = pull * (self.mu * self.h(pull.norm())) * normal;
        Vec3::new(t.x, normal, t.y)
    }

    /// [`Penalty::force`] with its gradients.
    pub fn force_gradient(&self, z: f64, zd: f64, slip: [f64; 2], rate: [f64; 2]) -> PointForce {
        let (normal, n_z, n_zd) = self.normal_gradient(z, zd);
        let pull = self.tangential(slip, rate);
        let x = pull.norm();
        let h = self.h(x);
        let direction = pull * (self.mu * h); // f_t = f_n × this
        // ∂(h F)/∂F = h 1 + x h′ u uᵀ with u = F/x and x h′ = k_t e^{−k_t x} − h
        let u = if x > 0.0 { pull / x } else { Vector2::zeros() };
        let turn = Matrix2::identity() * h + u * u.transpose() * (self.k_t * (-self.k_t * x).exp() - h);
        let d_pull = turn * (self.mu * normal);
        let lift = |t: Vector2<f64>, n: f64| Vec3::new(t.x, n, t.y);
        let rows = |m: Matrix2<f64>| {
            Matrix3x2::from_columns(&[
                lift(m.column(0).into_owned(), 0.0),
                lift(m.column(1).into_owned(), 0.0),
            ])
        };
        PointForce {
            force: lift(direction * normal, normal),
            d_z: lift(direction * n_z, n_z),
            d_zd: lift(direction * n_zd, n_zd),
            d_slip: rows(d_pull * -self.k_tp),
            d_rate: rows(d_pull * -self.k_td),
        }
    }

    /// Height at which a still point carries `load_n` > 0, m: `(f_0² − f²)/(k_P f)`, negative for
    /// loads above `f_0`.
    pub fn rest_height(&self, load_n: f64) -> f64 {
        let f = match self.pull {
            Pull::Never { width_n } if load_n < width_n => {
                let (mut lo, mut hi) = (0.0, width_n);
                for _ in 0..100 {
                    let middle = 0.5 * (lo + hi);
                    if self.clamp(middle).0 < load_n { lo = middle } else { hi = middle }
                }
                0.5 * (lo + hi)
            }
            _ => load_n,
        };
        // 2f/k_P + z = √(z² + 4 f_0²/k_P²), squared
        (self.f_0 * self.f_0 - f * f) / (self.k_p * f)
    }

    /// The damper's onset `g(z)`, between 0 (far above) and 1 (deep inside).
    pub fn onset(&self, z: f64) -> f64 {
        let half = 0.5 * (-self.k * z.abs()).exp();
        if z < 0.0 { 1.0 - half } else { half }
    }

    /// `h(x)` of (14), 1/N; `x` ≥ 0 in N.
    pub fn h(&self, x: f64) -> f64 {
        let y = self.k_t * x;
        // series to y²: what is left out is y³/24, below rounding for the ε of both presets
        if x < self.epsilon { self.k_t * (1.0 - y / 2.0 + y * y / 6.0) } else { -(-y).exp_m1() / x }
    }

    fn tangential(&self, slip: [f64; 2], rate: [f64; 2]) -> Vector2<f64> {
        -Vector2::from(slip) * self.k_tp - Vector2::from(rate) * self.k_td
    }

    /// Smooth `max(f, 0)` and its slope.
    fn clamp(&self, f: f64) -> (f64, f64) {
        match self.pull {
            Pull::AsPrinted => (f, 1.0),
            Pull::Never { width_n } => {
                let t = f / width_n;
                if t <= 0.0 {
                    (0.0, 0.0)
                } else if t < 1.0 {
                    let t2 = t * t;
                    (width_n * t * t2 * (6.0 - 8.0 * t + 3.0 * t2), t2 * (18.0 - 32.0 * t + 15.0 * t2))
                } else {
                    (f, 1.0)
                }
            }
        }
    }
}

/// Forces of the ground on contact points of a posed character: one wrench per point, in their order.
///
/// * `state`: updated for the pose and velocity
/// * `contacts`: indices into the skeleton's sites, as [`bodies::Character::contacts`]
/// * `ground_m`: height of the ground plane
/// * `anchors`: nominal positions r̂, `[x, z]`, world, m, one per contact, or empty: then slip is zero
///   and only `k_tD` resists. Compute them as the contacts' positions when they first touched.
///
/// Appends to `out`; allocates only when its capacity is short. The sum is [`crate::total_wrench`].
///
/// # Panics
/// If there are anchors, but not one for each contact, or a contact is not a site.
pub fn contact_forces(
    penalty: &Penalty,
    model: &Model,
    state: &State,
    contacts: &[usize],
    ground_m: f64,
    anchors: &[[f64; 2]],
    out: &mut Vec<Wrench>,
) {
    assert!(anchors.is_empty() || anchors.len() == contacts.len(), "one anchor per contact, or none");
    for (i, &contact) in contacts.iter().enumerate() {
        let site = &model.skeleton.sites()[contact];
        let p = state.point(model, site.link, &site.at);
        let v = state.point_velocity(model, site.link, &site.at);
        let slip = anchors.get(i).map_or([0.0; 2], |a| [p.x - a[0], p.z - a[1]]);
        let force = penalty.force(p.y - ground_m, v.y, slip, [v.x, v.z]);
        out.push(Wrench { link: site.link, point: p, force, moment: Vec3::zeros() });
    }
}
