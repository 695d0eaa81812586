//! The floor: a plane, and how it turns while a body stands on it.
//!
//! In: height, friction, tilt; turns over time. Out: the plane at any time, and the motion of its points. It turns
//! about horizontal axes through one point, that under the world's origin. Its tilt is a vector `(x, z)` in the
//! horizontal plane: its length is the angle of the slope (rad), its direction that in which the slope falls. A turn
//! takes the tilt from where it is to another one along a straight line, timed by a curve.
//!
//! Units: m, rad, s; world frame, y up.

use nalgebra::Vector2;

use crate::rotation::between;
use crate::{Curve, Quat, Transform, Vec3};

/// Coulomb friction coefficient of a floor about which nothing is said: a shoe on a dry floor.
pub const FRICTION: f64 = 0.8;

/// A plane that bodies stand on. See the module header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floor {
    /// Height under the world's origin, m.
    pub height_m: f64,
    /// Coulomb friction coefficient.
    pub friction: f64,
    /// Direction in which it faces, unit length; +Y when level.
    pub up: Vec3,
    /// Whether it may turn while a body is on it.
    pub turns: bool,
}

impl Floor {
    /// A level plane.
    pub const fn level(height_m: f64, friction: f64) -> Self {
        Self { height_m, friction, up: Vec3::new(0.0, 1.0, 0.0), turns: false }
    }

    /// Whether it is level, and stays so.
    pub fn stays_level(&self) -> bool {
        self.up == Vec3::y() && !self.turns
    }

    /// The same, tilted: it falls by `tilt` rad towards the horizontal direction `towards` rad about +Y
    /// (0: +Z, π/2: +X).
    pub fn tilted(self, tilt: f64, towards: f64) -> Self {
        let (s, c) = tilt.sin_cos();
        Self { up: Vec3::new(s * towards.sin(), c, s * towards.cos()), ..self }
    }

    /// The same, free to turn.
    pub fn turning(self) -> Self {
        Self { turns: true, ..self }
    }

    /// The rotation that takes a level floor to this one.
    pub fn turn(&self) -> Quat {
        between(&Vec3::y(), &self.up)
    }

    /// The point about which it turns, world, m.
    pub fn pivot(&self) -> Vec3 {
        Vec3::y() * self.height_m
    }

    /// Where a turn takes what lay on a level floor at height 0: `world_from_level`.
    pub fn place(&self) -> Transform {
        Transform::from_parts(self.pivot().into(), self.turn())
    }

    /// The point of the plane above or below `p`, m; the plane must not be upright.
    pub fn under(&self, p: &Vec3) -> Vec3 {
        let up = &self.up;
        Vec3::new(p.x, self.height_m - (p.x * up.x + p.z * up.z) / up.y.max(1e-3), p.z)
    }

    /// Tilt, rad, towards where it falls: (x, z).
    fn tilt(&self) -> Vector2<f64> {
        let across = Vector2::new(self.up.x, self.up.z);
        let way = across.try_normalize(0.0).unwrap_or_default();
        way * across.norm().atan2(self.up.y)
    }

    /// This floor `t_s` seconds after the run began, turned by `tilts` in order of time.
    ///
    /// # Examples
    /// ```
    /// # use motion::{Curve, floor::{Floor, Tilt}};
    /// let up = Tilt { start_s: 1.0, duration_s: 2.0, tilt: 0.1, towards: 0.0, curve: Curve::Linear };
    /// let half = Floor::level(0.0, 0.8).at(&[up], 2.0);
    /// assert!((half.up.z - 0.05f64.sin()).abs() < 1e-12);
    /// ```
    pub fn at(&self, tilts: &[Tilt], t_s: f64) -> Self {
        let mut now = self.tilt();
        for tilt in tilts.iter().filter(|x| x.start_s < t_s) {
            let u = ((t_s - tilt.start_s) / tilt.duration_s).min(1.0);
            let to = Vector2::new(tilt.towards.sin(), tilt.towards.cos()) * tilt.tilt;
            now += (to - now) * tilt.curve.at(u);
        }
        if tilts.is_empty() { *self } else { self.tilted(now.norm(), now.x.atan2(now.y)) }
    }
}

/// A turn of the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tilt {
    /// When it begins, s.
    pub start_s: f64,
    /// How long it takes, s.
    pub duration_s: f64,
    /// How steep the floor is afterwards, rad.
    pub tilt: f64,
    /// Where it then falls to, rad about +Y (0: +Z, π/2: +X).
    pub towards: f64,
    /// How it gets there.
    pub curve: Curve,
}
