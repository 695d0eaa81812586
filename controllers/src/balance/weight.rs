//! Weight shift between two feet: the line between them, how pressure and weight go along it, and what wakes it.
//!
//! In: feet on the ground, an error of the capture point. Out: parts along the line, shares, a level. The ground
//! plane, (x, z), m.

use dynamics::{Model, State};
use motion::support::{Vec2, ground};
use motion::{Vec3, smoothstep};

use super::BalanceSettings;
use crate::support::Foot;

/// The line between two feet, on the ground.
pub(super) struct Line {
    middle: Vec2,
    /// Unit vector from the first to the second.
    pub along: Vec2,
    /// Fraction of a shift of pressure that happens under each sole; the rest is weight that changes feet.
    rolling: f64,
}

impl Line {
    /// `None` unless there are two feet apart.
    pub fn between(feet: &[Foot], centers: &[Vec3], model: &Model, state: &State) -> Option<Self> {
        let [a, b] = centers else { return None };
        let (a, b) = (ground(a), ground(b));
        let half = 0.5 * (b - a).norm();
        let along = (b - a).try_normalize(1e-6)?;
        let reach = |foot: &Foot, center: Vec2| {
            let beyond = foot
                .corners
                .iter()
                .map(|(link, at)| (ground(&state.point(model, *link, at)) - center).dot(&along).abs());
            beyond.fold(0.0, f64::max)
        };
        let sole = 0.5 * (reach(&feet[0], a) + reach(&feet[1], b));
        Some(Self { middle: (a + b) * 0.5, along, rolling: sole / (sole + half) })
    }

    /// Part of `x` along the line.
    pub fn part(&self, x: Vec2) -> Vec2 {
        self.along * self.along.dot(&x)
    }

    /// The point whose distances share the weight for a centre of pressure `p`: both soles and the shares
    /// reach their ends together, so the foot that is left keeps weight as long as it can.
    pub fn sharing(&self, p: Vec2) -> Vec2 {
        p - self.part(p - self.middle) * self.rolling
    }
}

/// How much of a strategy for pushes acts: a push tells itself from the motion asked for by how fast the capture
/// point runs off, ξ̇ = F/(m ω₀), long before by how far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wake {
    /// Error of the capture point, m, followed with the time constant [`SUDDEN`]; `None` before the first step.
    followed: Option<Vec2>,
    level: f64,
}

/// Time over which the speed of the capture point is taken, s.
const SUDDEN: f64 = 0.02;
/// Time constant with which it falls asleep, s.
const CALM: f64 = 0.3;

impl Wake {
    /// Level in 0 to 1 after a step of `dt` with the error `x` of the capture point, m.
    pub fn update(&mut self, s: &BalanceSettings, x: Vec2, dt: f64) -> f64 {
        let followed = self.followed.get_or_insert(x);
        // in the steady state of a ramp this is its slope, at any step
        let gain = 1.0 - (-dt / SUDDEN).exp();
        let speed = (x - *followed) * (gain / dt);
        *followed += (x - *followed) * gain;
        if x.norm() < s.weight_rest_m {
            self.level *= (-dt / CALM).exp();
            if self.level < 1e-3 {
                self.level = 0.0;
            }
        }
        let woken = (speed.norm() - s.weight_from_m_s) / (s.weight_full_m_s - s.weight_from_m_s);
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

    /// What runs off slowly never wakes it, however far; what runs off fast does within 50 ms, at any rate; and it
    /// sleeps again once the error is gone.
    #[test]
    fn the_weight_shift_wakes_for_what_is_sudden() {
        let s = BalanceSettings::default();
        for rate_hz in [120.0, 240.0, 480.0] {
            assert_eq!(after(0.99 * s.weight_from_m_s, 1.0, rate_hz).1, 0.0);
            let (mut wake, level) = after(1.2 * s.weight_full_m_s, 0.05, rate_hz);
            assert_eq!(level, 1.0, "{rate_hz} Hz");
            for _ in 0..(10.0 * rate_hz) as usize {
                wake.update(&s, Vec2::y() * (2.0 * s.weight_rest_m), 1.0 / rate_hz);
            }
            assert_eq!(wake.level, 1.0, "awake while there is an error");
            for _ in 0..(3.0 * rate_hz) as usize {
                wake.update(&s, Vec2::zeros(), 1.0 / rate_hz);
            }
            assert_eq!(wake.level, 0.0);
        }
    }
}
