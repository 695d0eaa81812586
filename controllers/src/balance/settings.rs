//! Parameters of the balance property: units, defaults, directions, consequences.

use dynamics::digest::Digest;
use motion::names::Word;

/// One of the strategies that can be switched off by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strategy {
    /// The centre of pressure moves under the feet: [`BalanceSettings::ankle`].
    Ankle,
    /// The trunk leans under a push: [`BalanceSettings::hip`].
    Hip,
    /// Weight moves between the feet under a push: [`BalanceSettings::weight_shift`].
    Weight,
}

impl Word for Strategy {
    const KIND: &'static str = "strategy of balance";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Ankle, "ankle", "Pressure moves under the feet"),
        (Self::Hip, "hip", "The trunk leans"),
        (Self::Weight, "weight", "Weight moves between the feet"),
    ];
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
    /// Weight shift: under a push the pressure may travel from foot to foot. Off, each foot keeps its part of the load, and the
    /// pressure only goes where it can under both soles alike.
    pub weight_shift: bool,
    /// Hip strategy: under a push the trunk leans where the body falls once the support cannot catch it alone. Off, the trunk
    /// leans no farther than the push threw it.
    pub hip: bool,
    /// Arms may swing against a push. Off, they hang (or move) as asked.
    pub arms: bool,
    /// Speed of the capture point's error at which the answer to pushes wakes, m/s; lower answers to what the motion itself
    /// stirs up (a wild twist: 0.3), higher to hard pushes only.
    pub wake_from_m_s: f64,
    /// Speed at which it acts whole, m/s; nearer to [`Self::wake_from_m_s`] is more abrupt.
    pub wake_full_m_s: f64,
    /// Awake it stays until the capture point's error is below this, m; higher leaves the rest of the way to the springs.
    pub wake_rest_m: f64,
    /// How far beyond the capture point the pressure is wanted under a push, per error of that, m/m, ≥ 0; 0 holds the capture
    /// point where it is, higher brings it back sooner.
    pub catch_gain: f64,
    /// How far ahead the capture point is foreseen by its speed, s, ≥ 0; higher answers sooner, too high leans for nothing.
    pub catch_ahead_s: f64,
    /// [`Self::margin_m`] under a push, m; lower uses more of the sole, too low turns it about its corner.
    pub catch_margin_m: f64,
    /// How far inside the edge of the support a capture point is that the trunk already leans for, m, ≥ 0; higher leans sooner.
    pub hip_reserve_m: f64,
    /// Moment of the lean over the weight, per way of the capture point beyond that, m/m, ≥ 0; higher leans harder.
    pub hip_gain: f64,
    /// Part of the pressure's room that brings the trunk back, in \[0, 1\]; the rest brings the body back.
    pub hip_share: f64,
    /// Largest change of angular momentum fore and aft, N·m, > 0; higher catches harder pushes, too high tips the feet.
    pub hip_moment_nm: f64,
    /// Largest change of angular momentum to the side, N·m, > 0.
    pub hip_side_moment_nm: f64,
    /// Lean of the chest at which it is stopped, rad, > 0, overshot by up to a quarter where it was driven with its whole moment
    /// all the way; higher catches harder pushes, and looks it.
    pub hip_stroke_rad: f64,
    /// Part of the moment with which the lean begins to be stopped, in (0, 1]; lower brakes sooner and softer.
    pub hip_brake: f64,
    /// Natural frequency of the way back, rad/s, > 0; higher returns sooner and asks more of the ground meanwhile.
    pub hip_return_rad_s: f64,
    /// Time constant of the moment, s, > 0; lower is more sudden.
    pub hip_lag_s: f64,
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
            hip: true,
            arms: false,
            wake_from_m_s: 0.4,
            wake_full_m_s: 0.5,
            wake_rest_m: 0.01,
            catch_gain: 1.5,
            catch_ahead_s: 0.08,
            catch_margin_m: 0.004,
            hip_reserve_m: 0.03,
            hip_gain: 6.0,
            hip_share: 0.25,
            hip_moment_nm: 200.0,
            hip_side_moment_nm: 200.0,
            hip_stroke_rad: 0.87,
            hip_brake: 0.8,
            hip_return_rad_s: 2.0,
            hip_lag_s: 0.02,
        }
    }
}

impl BalanceSettings {
    /// Adds all of them to a digest.
    pub fn identify(&self, d: &mut Digest) {
        let BalanceSettings {
            ankle,
            shift,
            shift_damping,
            shift_rate,
            shift_limit_m,
            pressure,
            pressure_damping,
            margin_m,
            ankle_stiffness,
            weight_shift,
            hip,
            arms,
            wake_from_m_s,
            wake_full_m_s,
            wake_rest_m,
            catch_gain,
            catch_ahead_s,
            catch_margin_m,
            hip_reserve_m,
            hip_gain,
            hip_share,
            hip_moment_nm,
            hip_side_moment_nm,
            hip_stroke_rad,
            hip_brake,
            hip_return_rad_s,
            hip_lag_s,
        } = self;
        d.counts([ankle, weight_shift, hip, arms].map(|on| usize::from(*on)));
        d.option(ankle_stiffness.as_ref(), |d, x| d.number(*x));
        d.numbers([shift, shift_damping, shift_rate, shift_limit_m, pressure, pressure_damping, margin_m]);
        d.numbers([wake_from_m_s, wake_full_m_s, wake_rest_m, catch_gain, catch_ahead_s, catch_margin_m]);
        d.numbers([hip_reserve_m, hip_gain, hip_share, hip_moment_nm, hip_side_moment_nm, hip_stroke_rad]);
        d.numbers([hip_brake, hip_return_rad_s, hip_lag_s]);
    }

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
