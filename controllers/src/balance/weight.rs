//! Weight shift between two feet: the line between them, and how pressure and weight go along it.

use dynamics::{Model, State};
use motion::Vec3;
use motion::support::{Vec2, ground};

use crate::support::Foot;

/// The line between two feet, on the ground.
pub(super) struct Line {
    middle: Vec2,
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
