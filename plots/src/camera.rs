//! A camera without perspective: world points to a picture, with depth.
//!
//! Picture coordinates in metres: `right` and `up` on the picture, `near` towards the viewer. The same
//! length anywhere in the world is as long in the picture, so that figures can be compared.

use std::str::FromStr;

use motion::names::Word;
use motion::{Kinematics, LimbKind, Skeleton, Vec3};

/// From where a body is looked at: an angle around it, 0 in front of it, 90 on its left, 180 behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    yaw_deg: f64,
}

/// Views with a name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ViewName {
    /// From the front.
    Front,
    /// From its left.
    Side,
    /// Between both: where a walk, a bow and a wave are all seen.
    #[default]
    ThreeQuarter,
}

impl Word for ViewName {
    const KIND: &'static str = "view";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Front, "front", "From the front"),
        (Self::Side, "side", "From its left"),
        (Self::ThreeQuarter, "three-quarter", "Between front and left"),
    ];
}

/// A text that is no [`View`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{text}` is no view; allowed: {}, or degrees from -360 to 360 (0 is the front, 90 its left)", ViewName::WORDS.iter().map(|w| w.1).collect::<Vec<_>>().join(", "))]
pub struct ViewError {
    text: String,
}

impl View {
    /// From this angle, degrees; `None` for one that is not finite.
    pub fn degrees(yaw_deg: f64) -> Option<Self> {
        yaw_deg.is_finite().then_some(Self { yaw_deg })
    }

    /// The angle, degrees.
    pub fn yaw_deg(self) -> f64 {
        self.yaw_deg
    }
}

impl From<ViewName> for View {
    fn from(name: ViewName) -> Self {
        let yaw_deg = match name {
            ViewName::Front => 0.0,
            ViewName::Side => 90.0,
            ViewName::ThreeQuarter => 38.0,
        };
        Self { yaw_deg }
    }
}

impl Default for View {
    fn default() -> Self {
        ViewName::default().into()
    }
}

impl FromStr for View {
    type Err = ViewError;

    fn from_str(text: &str) -> Result<Self, ViewError> {
        if let Ok(name) = ViewName::find(text) {
            return Ok(name.into());
        }
        let degrees = text.parse().ok().filter(|x: &f64| x.abs() <= 360.0).and_then(Self::degrees);
        degrees.ok_or_else(|| ViewError { text: text.chars().take(40).collect() })
    }
}

/// Where the viewer stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    right: Vec3,
    up: Vec3,
    near: Vec3,
}

/// How far a viewer looks down, rad (9°): enough to see where feet stand.
const PITCH: f64 = 0.157_079_632_679_489_66;

impl Camera {
    /// A viewer in the direction of `yaw` (rad, about the vertical; 0 on +Z, π/2 on +X), looking down
    /// by `pitch` (rad).
    pub fn new(yaw: f64, pitch: f64) -> Self {
        let (sy, cy) = yaw.sin_cos();
        let (sp, cp) = pitch.sin_cos();
        let near = Vec3::new(sy * cp, sp, cy * cp);
        let right = Vec3::new(cy, 0.0, -sy);
        Self { right, up: near.cross(&right), near }
    }

    /// A viewer around a body that faces `facing` (rad, yaw), looking down a little.
    pub fn around(facing: f64, view: View) -> Self {
        Self::new(facing + view.yaw_deg().to_radians(), PITCH)
    }

    /// `(right, up, near)` of a world point, m.
    pub fn project(&self, p: &Vec3) -> Vec3 {
        Vec3::new(self.right.dot(p), self.up.dot(p), self.near.dot(p))
    }

    /// Direction towards the viewer, world.
    pub fn near(&self) -> Vec3 {
        self.near
    }
}

/// Yaw that a body faces in the pose `q`, rad: forward is left × up, left from right leg (or arm) to
/// left leg. Without limbs, the +Z of the world.
pub fn facing(skeleton: &Skeleton, q: &[f64]) -> f64 {
    let kinematics = Kinematics::new(skeleton, q);
    let zero = Kinematics::new(skeleton, &skeleton.zero_pose());
    for kind in [LimbKind::Leg, LimbKind::Arm] {
        let mut left = Vec3::zeros();
        for limb in skeleton.limbs().iter().filter(|l| l.kind == kind) {
            // in the zero pose the left is +X
            let side = (zero.origin(limb.upper) - zero.origin(0)).x.signum();
            left += kinematics.origin(limb.upper) * side;
        }
        let limbs = skeleton.limbs().iter().filter(|l| l.kind == kind).count();
        if limbs >= 2 && left.x.hypot(left.z) > 1e-6 && left.norm() < 2.0 {
            // left × up = (−left.z, 0, left.x)
            return (-left.z).atan2(left.x);
        }
    }
    0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn picture_is_a_rotation_of_the_world() {
        let camera = Camera::new(0.6, 0.2);
        let p = Vec3::new(0.3, -1.2, 2.0);
        assert!((camera.project(&p).norm() - p.norm()).abs() < 1e-14);
        let basis = camera.right.cross(&camera.up);
        assert!((basis - camera.near).norm() < 1e-15);
        assert!(camera.project(&Vec3::y()).y > 0.9);
    }

    /// From its left, a body that faces +x (a quarter turn) faces away from the viewer's left: what is in
    /// front of it is on the viewer's left.
    #[test]
    fn around_counts_from_the_front_to_the_left() {
        let facing = 0.5 * std::f64::consts::PI;
        let front = Camera::around(facing, ViewName::Front.into()).project(&Vec3::x());
        assert!(front.z > 0.98 && front.x.abs() < 1e-15, "{front}");
        // facing +x, the left is −z
        let left = Camera::around(facing, ViewName::Side.into());
        assert!(left.project(&-Vec3::z()).z > 0.98);
        assert!(left.project(&Vec3::x()).x < -0.99);
    }

    /// Seen from the front, the character's left is on the viewer's right.
    #[test]
    fn front_view_mirrors_sides() {
        let camera = Camera::new(0.0, 0.0);
        assert!((camera.project(&Vec3::x()) - Vec3::x()).norm() < 1e-15);
        assert!((camera.near() - Vec3::z()).norm() < 1e-15);
    }
}
