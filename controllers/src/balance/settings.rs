//! Parameters of the balance property: units, defaults, directions, consequences.

/// One of the strategies that can be switched off by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strategy {
    /// The centre of pressure moves under the feet: [`BalanceSettings::ankle`].
    Ankle,
    /// The trunk leans: [`BalanceSettings::hip`].
    Hip,
    /// Weight moves between two feet: [`BalanceSettings::weight_shift`].
    Weight,
}

/// A text that names no [`Strategy`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no strategy of balance; allowed: ankle, hip, weight")]
pub struct StrategyError(String);

impl std::str::FromStr for Strategy {
    type Err = StrategyError;

    fn from_str(text: &str) -> Result<Self, StrategyError> {
        match text {
            "ankle" => Ok(Self::Ankle),
            "hip" => Ok(Self::Hip),
            "weight" => Ok(Self::Weight),
            _ => Err(StrategyError(text.into())),
        }
    }
}

/// Parameters of the balance property.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BalanceSettings {
    /// Ankle strategy: the ankles and the pressure under the feet answer the sway of the centre of mass. Off, the ankles carry
    /// the body wherever it is and neither pull it back nor let it fall faster; it does not stand for long.
    pub ankle: bool,
    /// Pelvis shift per centre-of-mass error, m/m, ≥ 0; higher pulls back harder, too high sways.
    pub shift: f64,
    /// Pelvis shift per centre-of-mass velocity over ω₀, m/m, ≥ 0; higher damps sway.
    pub shift_damping: f64,
    /// Rate at which a lasting error is removed, 1/s, ≥ 0; higher removes it sooner, too high sways.
    pub shift_rate: f64,
    /// Largest pelvis shift, m, ≥ 0.
    pub shift_limit_m: f64,
    /// Centre-of-pressure shift per centre-of-mass error, m/m, ≥ 0; above 0 pushes the body back.
    pub pressure: f64,
    /// Centre-of-pressure shift per velocity over ω₀, m/m, ≥ 0; 1 follows the capture point.
    pub pressure_damping: f64,
    /// The centre of pressure stays this far inside the soles, m; lower uses more of the sole, too low tips it.
    pub margin_m: f64,
    /// Stiffness of all stance ankles together over m g h, > 0; `None` leaves it to the tension. Below 1 the springs
    /// alone would let the body fall, and only the pressure that follows its centre of mass holds it.
    pub ankle_stiffness: Option<f64>,
    /// Weight shift between two feet against errors along the line between them. Off, the legs answer them
    /// like any other, and pushes to the side drag the foot that lost its load.
    pub weight_shift: bool,
    /// Speed of the capture point's error along the line between the feet at which the weight shift wakes (and, in any
    /// direction, the hip strategy), m/s;
    /// lower answers to what the motion itself stirs up (a wild twist: 0.3), higher to hard pushes only.
    pub weight_from_m_s: f64,
    /// Speed at which it acts whole, m/s; nearer to [`Self::weight_from_m_s`] is more abrupt.
    pub weight_full_m_s: f64,
    /// Awake it stays until the capture point's error along the line is below this, m; higher leaves the rest
    /// of the way to the springs.
    pub weight_rest_m: f64,
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
    /// Hip strategy: the trunk leans where the body falls when its pressure is at the edge of the support. Off, the trunk
    /// does what the motion asks for and nothing else.
    pub hip: bool,
    /// How far beyond the capture point the pressure is wanted, per error of that, m/m, ≥ 0, once it runs off as fast as wakes
    /// the weight shift; higher starts the lean sooner and harder, with 0 only when the capture point has left the support.
    pub hip_gain: f64,
    /// Largest change of angular momentum fore and aft, N·m, > 0; higher catches harder pushes, too high lifts the heels.
    pub hip_moment_nm: f64,
    /// Largest change of angular momentum to the side, N·m, > 0; a narrow stance takes less of it: too high throws the
    /// load from foot to foot.
    pub hip_side_moment_nm: f64,
    /// Lean of the chest at which it is stopped, rad, > 0, overshot by up to a quarter where nothing else is left; higher catches harder pushes, and looks it.
    pub hip_stroke_rad: f64,
    /// Part of the moment the lean is stopped with before its stroke ends, in (0, 1]; lower brakes sooner and softer.
    pub hip_brake: f64,
    /// Natural frequency of the way back, rad/s, > 0; higher returns sooner and asks more of the ankles meanwhile.
    pub hip_return_rad_s: f64,
    /// Time constant of the moment, s, > 0; lower is more sudden.
    pub hip_lag_s: f64,
    /// Part of a lean fore and aft that the pelvis takes, in [0, 1]; the spine takes the rest, and all of it to the side.
    pub hip_pelvis: f64,
}

impl Default for BalanceSettings {
    fn default() -> Self {
        Self {
            ankle: true,
            shift: 0.4,
            shift_damping: 0.3,
            shift_rate: 0.5,
            shift_limit_m: 0.08,
            pressure: 0.3,
            pressure_damping: 0.8,
            margin_m: 0.01,
            ankle_stiffness: None,
            weight_shift: true,
            weight_from_m_s: 0.4,
            weight_full_m_s: 0.5,
            weight_rest_m: 0.01,
            weight: 1.5,
            weight_damping: 2.5,
            weight_yield: 1.0,
            least_share: 0.25,
            hip: true,
            hip_gain: 1.5,
            hip_moment_nm: 150.0,
            hip_side_moment_nm: 50.0,
            hip_stroke_rad: 0.7,
            hip_brake: 0.4,
            hip_return_rad_s: 2.0,
            hip_lag_s: 0.02,
            hip_pelvis: 0.5,
        }
    }
}

impl BalanceSettings {
    /// The same with a strategy switched off.
    pub fn without(mut self, strategy: Strategy) -> Self {
        match strategy {
            Strategy::Ankle => self.ankle = false,
            Strategy::Hip => self.hip = false,
            Strategy::Weight => self.weight_shift = false,
        }
        self
    }
}
