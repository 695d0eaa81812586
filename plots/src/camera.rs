//! A camera without perspective: world points to a picture, with depth.
//!
//! Picture coordinates in metres: `right` and `up` on the picture, `near` towards the viewer. The same
//! length anywhere in the world is as long in the picture, so that figures can be compared.

use motion::{Clip, Kinematics, LimbKind, Skeleton, Vec3};

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

    /// A viewer at `yaw_deg` around a body that faces `facing` (rad, yaw): 0 sees it from the front, 90
    /// from its left, 180 from behind; looking down a little.
    pub fn around(facing: f64, yaw_deg: f64) -> Self {
        Self::new(facing + yaw_deg.to_radians(), PITCH)
    }

    /// A three-quarter or side view in which `clips` show their motion best, for a body that faces
    /// `forward` (rad, yaw).
    ///
    /// Of views from the front half, the one in which the links' positions (against the root's horizontal
    /// position) vary most on the picture; a view that shows the face wins against one that shows a
    /// little more motion from the side.
    pub fn most_motion(clips: &[&Clip], forward: f64) -> Self {
        let candidates = [(38.0, 1.0), (-38.0, 1.0), (62.0, 0.95), (-62.0, 0.95), (90.0, 0.8), (-90.0, 0.8)];
        let score = |(deg, weight): (f64, f64)| {
            let camera = Self::around(forward, deg);
            weight * clips.iter().map(|c| camera.motion(c)).sum::<f64>()
        };
        // the first candidate has 2 % in hand and later ones must exceed the best by 1e-6, so that rounding never decides a tie
        let mut best = (candidates[0], score(candidates[0]) * 1.02);
        for c in &candidates[1..] {
            let s = score(*c);
            if s > best.1 * (1.0 + 1e-6) {
                best = (*c, s);
            }
        }
        Self::around(forward, best.0.0)
    }

    /// `(right, up, near)` of a world point, m.
    pub fn project(&self, p: &Vec3) -> Vec3 {
        Vec3::new(self.right.dot(p), self.up.dot(p), self.near.dot(p))
    }

    /// Direction towards the viewer, world.
    pub fn near(&self) -> Vec3 {
        self.near
    }

    /// Sum over links of the spread of their pictured positions over time, m.
    fn motion(&self, clip: &Clip) -> f64 {
        let samples = 24;
        let links = clip.skeleton.links().len();
        let mut pose = vec![0.0; clip.skeleton.nq()];
        let mut kinematics = Kinematics::new(&clip.skeleton, clip.pose(0));
        let (mut sum, mut square) = (vec![Vec3::zeros(); links], vec![0.0; links]);
        for i in 0..samples {
            clip.sample(clip.duration_s() * f64::from(i) / f64::from(samples - 1), &mut pose);
            kinematics.update(&clip.skeleton, &pose);
            let root = kinematics.origin(0);
            for link in 0..links {
                let mut at = self.project(&(kinematics.origin(link) - Vec3::new(root.x, 0.0, root.z)));
                at.z = 0.0;
                sum[link] += at;
                square[link] += at.norm_squared();
            }
        }
        let n = f64::from(samples);
        (0..links).map(|l| (square[l] / n - (sum[l] / n).norm_squared()).max(0.0).sqrt()).sum()
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
        let front = Camera::around(facing, 0.0).project(&Vec3::x());
        assert!(front.z > 0.98 && front.x.abs() < 1e-15, "{front}");
        // facing +x, the left is −z
        let left = Camera::around(facing, 90.0);
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
