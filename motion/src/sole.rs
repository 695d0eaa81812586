//! A sole: the points of a foot that a floor can press on.
//!
//! In: the link of a foot, the corners of its sole in link frames, a pose. Out: the corners in the world, their middle,
//! the polygon they support. Which points of a body are soles is the body's to say (`bodies::Character::soles`).
//!
//! Units: m; world frame, y up.

use crate::{Kinematics, Support, Vec3};

/// A sole. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Sole {
    /// Name of the leg that ends in it; of its link, where no leg does.
    pub name: String,
    /// Link that it belongs to: the end of the leg.
    pub link: usize,
    /// Corners: link (that one, or one welded to it) and point in that link's frame, m.
    pub corners: Vec<(usize, Vec3)>,
}

impl Sole {
    /// The corners, world, m.
    pub fn points<'a>(&'a self, k: &'a Kinematics) -> impl Iterator<Item = Vec3> + 'a {
        self.corners.iter().map(|(link, at)| k.point(*link, at))
    }

    /// The corners in the frame of [`Sole::link`], m, whatever the pose: links of one sole do not move against each other.
    pub fn in_link(&self, k: &Kinematics) -> Vec<Vec3> {
        let back = k.world[self.link].inverse();
        self.points(k).map(|p| back.transform_point(&p.into()).coords).collect()
    }

    /// Middle of the corners, world, m; the origin without corners.
    pub fn center(&self, k: &Kinematics) -> Vec3 {
        self.points(k).sum::<Vec3>() / self.corners.len().max(1) as f64
    }

    /// The polygon that several soles support together.
    pub fn support<'a>(soles: impl IntoIterator<Item = &'a Self>, k: &Kinematics) -> Support {
        let points: Vec<Vec3> = soles.into_iter().flat_map(|s| s.points(k)).collect();
        Support::of(&points)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Joint, Link, Skeleton};

    /// A foot that turned a quarter about +Y with its toes welded on, and a second one beside it: middle and polygon are
    /// those of the corners where they then are.
    #[test]
    fn corners_turn_with_the_foot() {
        let mut links = vec![Link::new("root", None, Vec3::zeros(), Joint::Free)];
        links.push(Link::new("foot", Some(0), Vec3::new(0.5, 0.0, 0.0), Joint::Revolute(Vec3::y())));
        links.push(Link::new("toes", Some(1), Vec3::new(0.0, 0.0, 0.2), Joint::Fixed));
        let s = Skeleton::new(links).unwrap();
        let mut q = s.zero_pose();
        q[s.q_at(1)] = std::f64::consts::FRAC_PI_2;
        let k = Kinematics::new(&s, &q);
        let at = |link, x, z| (link, Vec3::new(x, -0.1, z));
        let turned = Sole {
            name: "leg".into(),
            link: 1,
            corners: vec![at(1, -0.05, 0.0), at(1, 0.05, 0.0), at(2, -0.05, 0.1), at(2, 0.05, 0.1)],
        };
        // forward (+Z) has become left (+X): x from 0.5 to 0.8, z ± 0.05
        assert!((turned.center(&k) - Vec3::new(0.65, -0.1, 0.0)).norm() < 1e-12);
        assert!((Sole::support([&turned], &k).area() - 0.03).abs() < 1e-12);
        let other =
            Sole { name: "other".into(), link: 0, corners: vec![at(0, 0.0, -0.05), at(0, 0.0, 0.05)] };
        let both = Sole::support([&turned, &other], &k);
        assert!((both.area() - 0.08).abs() < 1e-12, "{}", both.area());
    }
}
