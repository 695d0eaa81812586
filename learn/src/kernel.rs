//! The kernel of YAH10 (1) and the numbers an optimiser turns.
//!
//! k(x, x') = θ1 exp(−θ2/2 |x − x'|²) + θ3 + β⁻¹ δ
//!
//! θ1, θ3, β⁻¹ are variances in units of the outputs' own mean variance, θ2 an inverse squared length in the
//! space of x. The optimiser sees p = (ln θ1, ln θ2, ln(θ3 − 10⁻⁹), ln(β⁻¹ − 10⁻⁶)): the prior p(Φ) ∝ Π 1/φ
//! grows without bound as θ3 → 0, so a floor must be under it; and noise below 10⁻³ of the outputs' standard
//! deviation cannot be told from rounding once K is factored.
//!
//! YAH10: Yamane, Ariki, Hodgins. Animating non-humanoid characters with human motion data. SCA 2010.

use serde::{Deserialize, Serialize};

/// Least θ3.
const BIAS_FLOOR: f64 = 1e-9;
/// Least β⁻¹.
pub(crate) const NOISE_FLOOR: f64 = 1e-6;
/// Parameters of one kernel as the optimiser sees them.
pub(crate) const PARAMETERS: usize = 4;
/// Range of each p. Beyond, the likelihood no longer changes or K no longer factors.
const BOX: [(f64, f64); PARAMETERS] = [(-16.0, 9.0), (-23.0, 14.0), (-30.0, 9.0), (-30.0, 5.0)];

/// Parameters of the kernel; all positive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Kernel {
    /// Variance of what changes with x.
    pub theta1: f64,
    /// Inverse squared length.
    pub theta2: f64,
    /// Variance of what does not.
    pub theta3: f64,
    /// Precision of the observations, 1/noise variance.
    pub beta: f64,
}

impl Kernel {
    /// Noise variance β⁻¹.
    pub fn noise(&self) -> f64 {
        1.0 / self.beta
    }

    /// The distance at which the changing part has fallen to e^−½.
    pub fn length(&self) -> f64 {
        self.theta2.powf(-0.5)
    }

    /// k(x, x), noise included.
    pub fn at_zero(&self) -> f64 {
        self.theta1 + self.theta3 + self.noise()
    }

    /// Whether all parameters are finite and positive.
    pub(crate) fn is_positive(&self) -> bool {
        [self.theta1, self.theta2, self.theta3, self.beta].iter().all(|v| v.is_finite() && *v > 0.0)
    }

    /// Where optimisation starts: outputs of unit variance, a hundredth of it noise, lengths as wide as the
    /// data.
    pub(crate) fn start(median_squared_distance: f64) -> Self {
        Kernel { theta1: 1.0, theta2: 1.0 / median_squared_distance, theta3: 1e-2, beta: 1e2 }
    }

    /// From the optimiser's numbers.
    pub(crate) fn from_parameters(p: &[f64]) -> Self {
        let e = |k: usize| p[k].clamp(BOX[k].0, BOX[k].1).exp();
        Kernel { theta1: e(0), theta2: e(1), theta3: BIAS_FLOOR + e(2), beta: 1.0 / (NOISE_FLOOR + e(3)) }
    }

    /// To the optimiser's numbers.
    pub(crate) fn parameters(&self) -> [f64; PARAMETERS] {
        let above = |v: f64, floor: f64| (v - floor).max(f64::MIN_POSITIVE).ln();
        let p = [
            self.theta1.ln(),
            self.theta2.ln(),
            above(self.theta3, BIAS_FLOOR),
            above(self.noise(), NOISE_FLOOR),
        ];
        std::array::from_fn(|k| p[k].clamp(BOX[k].0, BOX[k].1))
    }

    /// Turns derivatives by (θ1, θ2, θ3, β⁻¹) into derivatives by p.
    pub(crate) fn chain(&self, by_theta: &[f64; PARAMETERS]) -> [f64; PARAMETERS] {
        let scale =
            [self.theta1, self.theta2, self.theta3 - BIAS_FLOOR, (self.noise() - NOISE_FLOOR).max(0.0)];
        std::array::from_fn(|k| by_theta[k] * scale[k])
    }

    /// −ln p(Φ) = Σ ln φ over φ ∈ {θ1, θ2, θ3, β}, and its derivatives by (θ1, θ2, θ3, β⁻¹).
    pub(crate) fn minus_ln_prior(&self) -> (f64, [f64; PARAMETERS]) {
        let value = self.theta1.ln() + self.theta2.ln() + self.theta3.ln() + self.beta.ln();
        (value, [1.0 / self.theta1, 1.0 / self.theta2, 1.0 / self.theta3, -self.beta])
    }
}

/// Quadratic penalty outside [`BOX`], with its gradient. Far outside the likelihood is flat, and without the penalty the
/// optimiser would go on there without an end.
pub(crate) fn box_penalty(p: &[f64], gradient: &mut [f64]) -> f64 {
    let mut value = 0.0;
    for k in 0..PARAMETERS {
        let beyond = p[k] - p[k].clamp(BOX[k].0, BOX[k].1);
        if beyond != 0.0 {
            value += 50.0 * beyond * beyond;
            gradient[k] = 100.0 * beyond;
        }
    }
    value
}
