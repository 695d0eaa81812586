//! Self-collision: which shapes of a body may touch each other, and where two capsules are nearest.
//!
//! In: a [`Character`]. Out: pairs of its capsules and balls (a ball is a capsule whose ends are one), the same for every engine. Left out are
//! shapes of one rigid body, shapes of bodies that a joint connects, and shapes that touch in the rest pose: they were made to overlap.
//! Boxes and cones do not take part.

use motion::{Kinematics, Shape, Vec3};
use nalgebra::Point3;

use crate::Character;

/// A capsule of a link; a ball where `a` is `b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkCapsule {
    /// The link.
    pub link: usize,
    /// Which of its shapes.
    pub shape: usize,
    /// One end of the segment, link frame, m.
    pub a: Vec3,
    /// The other end, m.
    pub b: Vec3,
    /// Radius, m.
    pub radius: f64,
}

impl Character {
    /// Its capsules and balls, by link and shape.
    pub fn capsules(&self) -> Vec<LinkCapsule> {
        let mut out = Vec::new();
        for (link, body) in self.bodies.iter().enumerate() {
            for (shape, s) in body.shapes.iter().enumerate() {
                match *s {
                    Shape::Capsule { a, b, radius } => out.push(LinkCapsule { link, shape, a, b, radius }),
                    Shape::Sphere { center, radius } => {
                        out.push(LinkCapsule { link, shape, a: center, b: center, radius });
                    }
                    Shape::Box { .. } | Shape::Cone { .. } => {}
                }
            }
        }
        out
    }

    /// Pairs of [`capsules`](Self::capsules), as indices into them, that may touch each other. See the module header.
    ///
    /// # Examples
    /// ```
    /// let (human, _) = bodies::anthropometry::human::human();
    /// let (all, name) = (human.capsules(), |l: usize| human.skeleton.links()[l].name.as_str());
    /// let touch = |a: &str, b: &str| {
    ///     human.self_pairs().iter().any(|&[i, j]| (name(all[i].link), name(all[j].link)) == (a, b))
    /// };
    /// assert!(touch("wrist_l", "wrist_r") || touch("wrist_r", "wrist_l"));
    /// assert!(!touch("hip_l", "knee_l"));
    /// ```
    pub fn self_pairs(&self) -> Vec<[usize; 2]> {
        let all = self.capsules();
        let k = Kinematics::new(&self.skeleton, &self.rest);
        let at = |c: &LinkCapsule, p: &Vec3| (k.world[c.link] * Point3::from(*p)).coords;
        let mut out = Vec::new();
        for (i, one) in all.iter().enumerate() {
            for (j, other) in all.iter().enumerate().skip(i + 1) {
                let (first, second) = (self.solid(one.link), self.solid(other.link));
                if first == second
                    || self.inboard(first) == Some(second)
                    || self.inboard(second) == Some(first)
                {
                    continue;
                }
                let (p, q) =
                    nearest([at(one, &one.a), at(one, &one.b)], [at(other, &other.a), at(other, &other.b)]);
                if (p - q).norm() > one.radius + other.radius {
                    out.push([i, j]);
                }
            }
        }
        out
    }

    /// The first link of the rigid body that a link belongs to.
    fn solid(&self, mut link: usize) -> usize {
        let links = self.skeleton.links();
        while let (0, Some(parent)) = (links[link].joint.nv(), links[link].parent) {
            link = parent;
        }
        link
    }

    /// The rigid body on which another hangs; links that only chain joints are passed over.
    fn inboard(&self, solid: usize) -> Option<usize> {
        let links = self.skeleton.links();
        let mut at = self.solid(links[solid].parent?);
        let chains = |link: usize| self.bodies[link].mass == 0.0 && self.bodies[link].shapes.is_empty();
        while let (true, Some(parent)) = (chains(at), links[at].parent) {
            at = self.solid(parent);
        }
        Some(at)
    }
}

/// The nearest points of two segments (Ericson, Real-Time Collision Detection, 2005, §5.1.9): one on each.
pub fn nearest([a, b]: [Vec3; 2], [c, d]: [Vec3; 2]) -> (Vec3, Vec3) {
    let (u, w, r) = (b - a, d - c, a - c);
    let (uu, ww, wr) = (u.norm_squared(), w.norm_squared(), w.dot(&r));
    let part = |x: f64, of: f64| if of > 0.0 { (x / of).clamp(0.0, 1.0) } else { 0.0 };
    let (ur, uw) = (u.dot(&r), u.dot(&w));
    let cross = uu * ww - uw * uw;
    // of parallel segments any point will do: the first end
    let mut s = if cross > 1e-12 * uu * ww { ((uw * wr - ur * ww) / cross).clamp(0.0, 1.0) } else { 0.0 };
    let t = if ww > 0.0 { (uw * s + wr) / ww } else { 0.0 };
    let kept = t.clamp(0.0, 1.0);
    if kept != t || ww == 0.0 {
        s = part(uw * kept - ur, uu);
    }
    (a + u * s, c + w * kept)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::anthropometry::human::human;

    /// Nearest points are no farther apart than those of a fine grid.
    #[test]
    fn nearest_points_are_nearest() {
        let x = |i: usize| ((i as f64 * 12.9898).sin() * 43758.5453).fract();
        let mut worst: f64 = 0.0;
        for n in 0..200 {
            let p: Vec<Vec3> = (0..4)
                .map(|k| Vec3::new(x(12 * n + 3 * k), x(12 * n + 3 * k + 1), x(12 * n + 3 * k + 2)))
                .collect();
            // some are points, some parallel
            let (a, b) = if n % 7 == 0 { (p[0], p[0]) } else { (p[0], p[1]) };
            let (c, d) = if n % 5 == 0 { (p[2], p[2] + (b - a)) } else { (p[2], p[3]) };
            let (f, g) = nearest([a, b], [c, d]);
            let on = |p: &Vec3, a: &Vec3, b: &Vec3| {
                ((p - a).norm() + (p - b).norm() - (b - a).norm()).abs() < 1e-9
            };
            assert!(on(&f, &a, &b) && on(&g, &c, &d), "{n}");
            let grid = (0..=60).flat_map(|i| (0..=60).map(move |j| (i as f64 / 60.0, j as f64 / 60.0)));
            let least =
                grid.map(|(s, t)| (a.lerp(&b, s) - c.lerp(&d, t)).norm()).fold(f64::INFINITY, f64::min);
            worst = worst.max((f - g).norm() - least);
        }
        assert!(worst < 1e-9, "{worst}"); // none is farther
    }

    /// Nothing touches in the rest pose, and what a joint connects never does.
    #[test]
    fn pairs_are_apart_at_rest() {
        let c = human().0;
        let (all, pairs) = (c.capsules(), c.self_pairs());
        assert!(pairs.len() > 100, "{}", pairs.len());
        let links = c.skeleton.links();
        for [i, j] in pairs {
            let (a, b) = (all[i].link, all[j].link);
            assert!(links[a].parent != Some(b) && links[b].parent != Some(a), "{a} {b}");
        }
    }
}
