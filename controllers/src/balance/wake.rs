//! When the answer to pushes acts.
//!
//! A push shows in the speed of the capture point's error at once, ξ̇ = F/(m ω₀), and in the error itself only later. The
//! level rises with that speed at once and decays when the error is gone.
//!
//! In: an error of the capture point. Out: a level, the speed of the error. The ground plane, (x, z), m.

use motion::smoothstep;
use motion::support::Vec2;

use super::BalanceSettings;

/// How much of the answer to pushes acts. See the module header.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wake {
    /// Error of the capture point, m, low-pass filtered with the time constant [`SPEED_S`]; `None` before the first step.
    followed: Option<Vec2>,
    level: f64,
    /// Speed of the error, m/s.
    pub speed: Vec2,
}

/// Time constant of the filter from which the speed of the error is taken, s.
const SPEED_S: f64 = 0.02;
/// Time constant with which the level decays, s.
const DECAY_S: f64 = 0.3;

impl Wake {
    /// Level in 0 to 1 after a step of `dt` with the error `x` of the capture point, m.
    pub fn update(&mut self, s: &BalanceSettings, x: Vec2, dt: f64) -> f64 {
        let followed = self.followed.get_or_insert(x);
        // for a ramp in the steady state this is its slope, whatever the step
        let gain = 1.0 - (-dt / SPEED_S).exp();
        let speed = (x - *followed) * (gain / dt);
        self.speed = speed;
        *followed += (x - *followed) * gain;
        if x.norm() < s.wake_rest_m {
            self.level *= (-dt / DECAY_S).exp();
            if self.level < 1e-3 {
                self.level = 0.0;
            }
        }
        let woken = (speed.norm() - s.wake_from_m_s) / (s.wake_full_m_s - s.wake_from_m_s);
        self.level = self.level.max(smoothstep(woken));
        self.level
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Level after `seconds` of an error that grows by `speed` metres a second.
    fn after(speed: f64, seconds: f64, rate_hz: f64) -> (Wake, f64) {
        let mut wake = Wake::default();
        let mut level = 0.0;
        for k in 0..(seconds * rate_hz) as usize {
            level = wake.update(
                &BalanceSettings::default(),
                Vec2::x() * (speed * k as f64 / rate_hz),
                1.0 / rate_hz,
            );
        }
        (wake, level)
    }

    /// A slow error leaves the level at 0, however large it gets; a fast one raises it to 1 within 50 ms, at any control
    /// rate; the level decays once the error is gone.
    #[test]
    fn it_wakes_for_what_is_sudden() {
        let s = BalanceSettings::default();
        for rate_hz in [120.0, 240.0, 480.0] {
            assert_eq!(after(0.99 * s.wake_from_m_s, 1.0, rate_hz).1, 0.0);
            let (mut wake, level) = after(1.2 * s.wake_full_m_s, 0.05, rate_hz);
            assert_eq!(level, 1.0, "{rate_hz} Hz");
            for _ in 0..(10.0 * rate_hz) as usize {
                wake.update(&s, Vec2::y() * (2.0 * s.wake_rest_m), 1.0 / rate_hz);
            }
            assert_eq!(wake.level, 1.0, "awake while there is an error");
            for _ in 0..(3.0 * rate_hz) as usize {
                wake.update(&s, Vec2::zeros(), 1.0 / rate_hz);
            }
            assert_eq!(wake.level, 0.0);
        }
    }
}
