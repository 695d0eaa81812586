//! Props: boxes and ramps that are fixed in the world, beside the floor.
//!
//! In: a place and a size, as a person says them. Out: a [`Prop`]: a named solid box in the world with friction of its own. A ramp is one
//! too: a plank whose upper face is the slope, so that every engine, drawing and file has the very same solid.
//!
//! Units: m, rad; world frame, y up. Directions are angles about +Y: 0 is +Z, π/2 is +X, as those of a [`motion::Floor`].

use motion::{Quat, Transform, Vec3};
use nalgebra::Point3;

/// Height of a ramp's plank, m, where nothing else is said.
pub const PLANK_M: f64 = 0.1;

/// A box fixed in the world. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Prop {
    /// Its name, for contacts and verdicts.
    pub name: String,
    /// Half edge lengths, m.
    pub half: Vec3,
    /// Where its centre lies and how it is turned: `world_from_prop`.
    pub place: Transform,
    /// Coulomb friction coefficient of whatever touches it.
    pub friction: f64,
}

impl Prop {
    /// An upright box that stands on a point.
    ///
    /// * `at`: middle of its lower face, world, m
    /// * `size`: along its x, y (up) and z, m
    /// * `turn`: about +Y, rad
    pub fn upright(name: &str, at: Vec3, size: Vec3, turn: f64, friction: f64) -> Self {
        let place = Transform::from_parts((at + Vec3::y() * (0.5 * size.y)).into(), about_y(turn));
        Self { name: name.into(), half: size * 0.5, place, friction }
    }

    /// A plank that rises.
    ///
    /// * `at`: middle of the lower edge of its upper face, world, m
    /// * `length`: of its upper face along the slope, m
    /// * `rise`: angle of the slope, rad
    /// * `towards`: where it rises to, rad
    pub fn ramp(
        name: &str,
        at: Vec3,
        (length, width, height): (f64, f64, f64),
        (rise, towards): (f64, f64),
        friction: f64,
    ) -> Self {
        let turn = about_y(towards) * Quat::from_axis_angle(&Vec3::x_axis(), -rise);
        let center = at + turn * Vec3::new(0.0, -0.5 * height, 0.5 * length);
        let half = Vec3::new(width, height, length) * 0.5;
        Self { name: name.into(), half, place: Transform::from_parts(center.into(), turn), friction }
    }

    /// Direction in which its upper face looks, unit length.
    pub fn up(&self) -> Vec3 {
        self.place.rotation * Vec3::y()
    }

    /// Its corners, world, m; bit k of the index says on which side along axis k.
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|corner| {
            let side = |axis: usize| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 };
            let at = self.half.component_mul(&Vec3::new(side(0), side(1), side(2)));
            (self.place * Point3::from(at)).coords
        })
    }

    /// How far a point is from the solid, m: negative inside, there the way to the nearest face.
    pub fn distance(&self, point: &Vec3) -> f64 {
        let local = self.place.inverse_transform_point(&Point3::from(*point)).coords;
        let beyond = local.abs() - self.half;
        let outside = beyond.map(|x| x.max(0.0)).norm();
        if outside > 0.0 { outside } else { beyond.max() }
    }
}

fn about_y(turn: f64) -> Quat {
    Quat::from_axis_angle(&Vec3::y_axis(), turn)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    /// A ramp towards +X begins at its edge, rises by its angle and looks up its slope.
    #[test]
    fn a_ramp_rises_where_it_says() {
        let rise: f64 = 0.3;
        let ramp = Prop::ramp("r", Vec3::new(1.0, 0.2, 0.5), (2.0, 1.0, 0.1), (rise, FRAC_PI_2), 0.8);
        assert!((ramp.up() - Vec3::new(-rise.sin(), rise.cos(), 0.0)).norm() < 1e-12);
        // half a metre up the slope the face is there; above it the distance is the height over the face
        let on = Vec3::new(1.0 + 0.5 * rise.cos(), 0.2 + 0.5 * rise.sin(), 0.5);
        assert!(ramp.distance(&on).abs() < 1e-12);
        assert!((ramp.distance(&(on + ramp.up() * 0.3)) - 0.3).abs() < 1e-12);
        assert!((ramp.distance(&(on - ramp.up() * 0.02)) + 0.02).abs() < 1e-12);
    }

    /// A box stands on its point, and its corners are where its distance ends.
    #[test]
    fn a_box_stands_on_its_point() {
        let step = Prop::upright("s", Vec3::new(0.0, 0.1, 2.0), Vec3::new(0.4, 0.2, 0.6), 0.7, 0.8);
        let corners = step.corners();
        let low = corners.iter().map(|c| c.y).fold(f64::INFINITY, f64::min);
        assert!((low - 0.1).abs() < 1e-12);
        assert!(corners.iter().all(|c| step.distance(c).abs() < 1e-12));
        assert!((step.distance(&Vec3::new(0.0, 0.5, 2.0)) - 0.2).abs() < 1e-12);
    }
}
