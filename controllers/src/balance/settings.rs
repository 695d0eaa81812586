//! Parameters of the balance property, and their defaults.

/// Parameters of the balance property.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BalanceSettings {
    /// Pelvis shift per centre-of-mass error, m/m; higher pulls back harder, too high sways.
    pub shift: f64,
    /// Pelvis shift per centre-of-mass velocity over ω₀, m/m; higher damps sway.
    pub shift_damping: f64,
    /// Rate at which a lasting error is removed, 1/s; higher removes it sooner, too high sways.
    pub shift_rate: f64,
    /// Largest pelvis shift, m.
    pub shift_limit_m: f64,
    /// Centre-of-pressure shift per centre-of-mass error, m/m; above 0 pushes the body back.
    pub pressure: f64,
    /// Centre-of-pressure shift per velocity over ω₀, m/m; 1 follows the capture point.
    pub pressure_damping: f64,
    /// The centre of pressure stays this far inside the soles, m.
    pub margin_m: f64,
    /// Weight shift between two feet against errors along the line between them. Off, the legs answer them
    /// like any other, and pushes to the side drag the foot that lost its load.
    pub weight_shift: bool,
    /// Error of the capture point along the line between the feet at which the weight shift begins, m;
    /// lower reaches into quiet motion.
    pub weight_from_m: f64,
    /// Error at which it acts whole, m; nearer to [`Self::weight_from_m`] is more abrupt.
    pub weight_full_m: f64,
    /// Centre-of-pressure shift per centre-of-mass error along the line between the feet, m/m, with
    /// [`Self::weight_shift`]; higher returns sooner, too high lifts the foot that is left.
    pub weight: f64,
    /// The same per velocity over ω₀, m/m; 1 holds the capture point where it is, more brings it back.
    pub weight_damping: f64,
    /// How far the legs let the pelvis go along the line between the feet instead of pulling it back with
    /// their springs, in [0, 1], with [`Self::weight_shift`]; lower drags the unloaded foot sooner.
    pub weight_yield: f64,
    /// Least part of its evenly shared stiffness and damping a leg keeps when its foot is unloaded, in
    /// [0, 1], with [`Self::weight_shift`]; lower leaves it limp, 1 does not shift them.
    pub least_share: f64,
    /// Ankle strategy: the centre of pressure answers the body's sway.
    pub ankle: bool,
    /// Hip strategy: the trunk leans where the body falls when the centre of pressure is at its edge.
    pub hip: bool,
    /// How far the pressure wanted lies beyond the capture point, per error of that, m/m.
    pub hip_gain: f64,
    /// Largest moment of the trunk, N·m.
    pub hip_torque_nm: f64,
    /// Largest lean, rad.
    pub hip_stroke_rad: f64,
    /// Frequency of the return, rad/s.
    pub hip_return: f64,
    /// Part of the lean that the pelvis takes, to the side and fore and aft.
    pub hip_pelvis: [f64; 2],
    /// mgh
    pub ankle_mgh: Option<f64>,
    /// side
    pub hip_side_nm: f64,
    /// b
    pub hip_brake: f64,
    /// d
    pub hip_delay: f64,
    /// x
    pub x1: f64,
    /// x
    pub x2: f64,
    /// x
    pub x3: f64,
    /// x
    pub x4: f64,
    /// x
    pub x5: f64,
    /// x
    pub x6: f64,
}

impl Default for BalanceSettings {
    fn default() -> Self {
        Self {
            shift: 0.4,
            shift_damping: 0.3,
            shift_rate: 0.5,
            shift_limit_m: 0.08,
            pressure: 0.3,
            pressure_damping: 0.8,
            margin_m: 0.01,
            weight_shift: true,
            weight_from_m: 0.015,
            weight_full_m: 0.025,
            weight: 1.5,
            weight_damping: 2.5,
            weight_yield: 1.0,
            least_share: 0.25,
            ankle: true,
            hip: true,
            hip_gain: 2.0,
            hip_torque_nm: 150.0,
            hip_stroke_rad: 0.7,
            hip_return: 2.0,
            hip_pelvis: [0.0, 0.5],
            ankle_mgh: None,
            hip_side_nm: 50.0,
            hip_brake: 0.4,
            hip_delay: 0.02,
            x1: 1.0,
            x2: 1.0,
            x3: 1.0,
            x4: 0.0,
            x5: 0.0,
            x6: 0.0,
        }
    }
}

impl BalanceSettings {
    /// How much of the weight shift acts at a capture-point error of `x` metres: 0 to 1, smooth.
    pub(super) fn fade(&self, x: f64) -> f64 {
        let t = ((x.abs() - self.weight_from_m) / (self.weight_full_m - self.weight_from_m)).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    }
}
