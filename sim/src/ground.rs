//! Ground: a plane, and how it turns while a body stands on it.
//!
//! In: height, friction, tilt; turns over time. Out: the plane at any time, and the motion of its points. It turns
//! about horizontal axes through one point, that under the world's origin: its tilt is a vector in the horizontal plane,
//! as long as it is steep (rad) and pointing to where it falls, and goes from one turn's to the next one's along a curve.

use dynamics::mjcf::MjcfGround;
use motion::{Curve, Quat, Transform, Vec3};
use nalgebra::Vector2;

/// The ground: a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Height under the world's origin, m.
    pub height_m: f64,
    /// Coulomb friction coefficient.
    pub friction: f64,
    /// Direction in which it faces, unit length; +Y when level.
    pub up: Vec3,
    /// Whether it may turn while a body is on it.
    pub turns: bool,
}

impl Ground {
    /// A level plane.
    pub const fn level(height_m: f64, friction: f64) -> Self {
        Self { height_m, friction, up: Vec3::new(0.0, 1.0, 0.0), turns: false }
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

    /// The rotation that takes level ground to this one.
    pub fn turn(&self) -> Quat {
        motion::rotation::between(&Vec3::y(), &self.up)
    }

    /// The point about which it turns, world, m.
    pub fn pivot(&self) -> Vec3 {
        Vec3::y() * self.height_m
    }

    /// Where it takes what lay on level ground at height 0.
    pub fn place(&self) -> Transform {
        Transform::from_parts(self.pivot().into(), self.turn())
    }

    /// Tilt, rad, towards where it falls: (x, z).
    fn tilt(&self) -> Vector2<f64> {
        let across = Vector2::new(self.up.x, self.up.z);
        let way = across.try_normalize(0.0).unwrap_or_default();
        way * across.norm().atan2(self.up.y)
    }

    /// This ground `t_s` seconds after it began, turned by `tilts` in order of time.
    ///
    /// # Examples
    /// ```
    /// # use sim::{Ground, ground::Tilt};
    /// # use motion::Curve;
    /// let up = Tilt { start_s: 1.0, duration_s: 2.0, tilt: 0.1, towards: 0.0, curve: Curve::Linear };
    /// let half = Ground::level(0.0, 0.8).at(&[up], 2.0);
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

impl From<Ground> for MjcfGround {
    fn from(g: Ground) -> Self {
        Self { height_m: g.height_m, friction: g.friction, up: g.up, turns: g.turns }
    }
}

/// A turn of the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tilt {
    /// When it begins, s.
    pub start_s: f64,
    /// How long it takes, s.
    pub duration_s: f64,
    /// How steep the ground is afterwards, rad.
    pub tilt: f64,
    /// Where it then falls to, rad about +Y (0: +Z, π/2: +X).
    pub towards: f64,
    /// How it gets there.
    pub curve: Curve,
}
