//! Support: the convex hull of ground contacts seen from above, and how far inside it a point lies.
//!
//! In: contact points (m, world). Out: hull, area, centroid, signed margin and nearest point, all in
//! the horizontal x–z plane; heights are ignored. No forces and no judgement of balance.
//!
//! Plane points are [`Vec2`] `(x, z)`. Corners run counter-clockwise when x is drawn to the right and
//! z upwards, starting at the least x; no three lie on a line.
//!
//! Hull: A. M. Andrew. Another efficient algorithm for convex hulls in two dimensions, 1979.

use nalgebra::Vector2;

use crate::rotation::Vec3;

/// A point of the ground plane: `(x, z)`, m.
pub type Vec2 = Vector2<f64>;

/// Drops the height of a world point.
pub fn ground(p: &Vec3) -> Vec2 {
    Vec2::new(p.x, p.z)
}

/// Convex hull of contact points in the ground plane.
///
/// It may be empty, a point or a segment: a body in flight, on a toe, on an edge.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Support {
    corners: Vec<Vec2>,
}

impl Support {
    /// Hull of world points, seen from above.
    pub fn of<'a>(points: impl IntoIterator<Item = &'a Vec3>) -> Self {
        Self::of_plane(points.into_iter().map(ground).collect())
    }

    /// Hull of points of the ground plane; points that are not finite are left out.
    pub fn of_plane(mut points: Vec<Vec2>) -> Self {
        points.retain(|p| p.iter().all(|x| x.is_finite()));
        points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        points.dedup();
        if points.len() < 3 {
            return Self { corners: points };
        }
        let mut corners = chain(points.iter());
        corners.pop();
        let upper = chain(points.iter().rev());
        corners.extend(&upper[..upper.len() - 1]);
        Self { corners }
    }

    /// Corners, counter-clockwise in `(x, z)`.
    pub fn corners(&self) -> &[Vec2] {
        &self.corners
    }

    /// Whether no point touches the ground.
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// Area, m²; zero for a segment or a point.
    pub fn area(&self) -> f64 {
        // shoelace about the first corner: small numbers also far from the origin
        let c = &self.corners;
        (2..c.len()).map(|i| 0.5 * (c[i - 1] - c[0]).perp(&(c[i] - c[0]))).sum()
    }

    /// Centre of the area; of the length for a segment; `None` when empty.
    pub fn centroid(&self) -> Option<Vec2> {
        let c = &self.corners;
        match c.len() {
            0 => None,
            1 => Some(c[0]),
            2 => Some((c[0] + c[1]) * 0.5),
            n => {
                let mut sum = Vec2::zeros();
                for i in 2..n {
                    let (a, b) = (c[i - 1] - c[0], c[i] - c[0]);
                    sum += (a + b) * (a.perp(&b) / 6.0);
                }
                Some(c[0] + sum / self.area())
            }
        }
    }

    /// Distance from `p` to the hull's boundary, m: positive inside, negative outside.
    ///
    /// Exact also outside a corner. Minus the distance for a segment or a point; −∞ when empty.
    pub fn margin(&self, p: &Vec2) -> f64 {
        let Some(near) = self.boundary(p) else { return f64::NEG_INFINITY };
        let distance = (p - near).norm();
        if self.contains(p) { distance } else { -distance }
    }

    /// Point of the hull (inside counts) nearest to `p`; `None` when empty.
    pub fn nearest(&self, p: &Vec2) -> Option<Vec2> {
        if self.contains(p) { Some(*p) } else { self.boundary(p) }
    }

    /// Whether `p` lies in the hull, boundary included; never for a segment or a point.
    pub fn contains(&self, p: &Vec2) -> bool {
        self.corners.len() > 2 && self.edges().all(|(a, b)| (b - a).perp(&(p - a)) >= 0.0)
    }

    /// Boundary point nearest to `p`.
    fn boundary(&self, p: &Vec2) -> Option<Vec2> {
        self.edges()
            .map(|(a, b)| {
                let along = b - a;
                let length2 = along.norm_squared();
                let s = if length2 > 0.0 { ((p - a).dot(&along) / length2).clamp(0.0, 1.0) } else { 0.0 };
                a + along * s
            })
            .min_by(|u, v| (p - u).norm_squared().total_cmp(&(p - v).norm_squared()))
    }

    fn edges(&self) -> impl Iterator<Item = (Vec2, Vec2)> + '_ {
        let c = &self.corners;
        (0..c.len()).map(move |i| (c[i], c[(i + 1) % c.len()]))
    }
}

/// One chain of Andrew's hull: turns left at every corner.
fn chain<'a>(points: impl Iterator<Item = &'a Vec2>) -> Vec<Vec2> {
    let mut out: Vec<Vec2> = Vec::new();
    for p in points {
        while let [.., a, b] = out[..] {
            if (b - a).perp(&(p - b)) > 0.0 {
                break;
            }
            out.pop();
        }
        out.push(*p);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn plane(points: &[[f64; 2]]) -> Support {
        Support::of_plane(points.iter().map(|p| Vec2::new(p[0], p[1])).collect())
    }

    /// 0.3 m wide, 0.2 m long, far from the origin, with points inside, on edges and repeated.
    fn feet() -> Support {
        plane(&[[7.0, 5.0], [7.3, 5.2], [7.3, 5.0], [7.0, 5.2], [7.1, 5.1], [7.15, 5.0], [7.0, 5.0]])
    }

    #[test]
    fn a_rectangle_is_its_four_corners() {
        let hull = feet();
        assert_eq!(hull.corners().len(), 4);
        assert!((hull.area() - 0.06).abs() < 1e-14); // 4e-17 seen
        assert!((hull.centroid().unwrap() - Vec2::new(7.15, 5.1)).norm() < 1e-12);
    }

    #[test]
    fn margin_is_the_signed_distance() {
        let hull = feet();
        for (p, expected) in [
            ([7.15, 5.1], 0.1),    // centre: the near edges are 0.1 m away
            ([7.02, 5.1], 0.02),   // inside
            ([6.97, 5.1], -0.03),  // outside an edge
            ([7.33, 5.24], -0.05), // outside a corner: 3-4-5
        ] {
            let error = hull.margin(&Vec2::new(p[0], p[1])) - expected;
            assert!(error.abs() < 1e-12, "{p:?}: {error}"); // 4e-16 seen
        }
    }

    #[test]
    fn thin_supports_have_no_inside() {
        assert_eq!(plane(&[]).margin(&Vec2::zeros()), f64::NEG_INFINITY);
        assert_eq!(plane(&[]).centroid(), None);
        assert_eq!(plane(&[[1.0, 1.0]]).margin(&Vec2::new(1.0, 3.0)), -2.0);
        let edge = plane(&[[0.0, 0.0], [1.0, 0.0], [0.5, 0.0]]);
        assert_eq!(edge.corners().len(), 2);
        assert_eq!(edge.area(), 0.0);
        assert_eq!(edge.margin(&Vec2::new(0.5, 0.25)), -0.25);
        assert_eq!(edge.margin(&Vec2::new(0.5, 0.0)), 0.0);
        assert_eq!(edge.centroid(), Some(Vec2::new(0.5, 0.0)));
        assert_eq!(plane(&[[f64::NAN, 0.0]]), Support::default());
    }

    proptest! {
        /// Two roads to one number: the margin inside is the least distance to the edges' lines, and
        /// outside no hull point is nearer than `nearest`. No given point is outside.
        #[test]
        fn hull_holds_its_points(
            raw in prop::collection::vec((-1.0..1.0f64, -1.0..1.0f64), 3..20),
            probe in (-2.0..2.0f64, -2.0..2.0f64),
        ) {
            let points: Vec<Vec2> = raw.iter().map(|p| Vec2::new(p.0, p.1)).collect();
            let hull = Support::of_plane(points.clone());
            for p in &points {
                prop_assert!(hull.margin(p) > -1e-12);
            }
            let p = Vec2::new(probe.0, probe.1);
            let near = hull.nearest(&p).unwrap();
            prop_assert!(hull.margin(&near) > -1e-12);
            if hull.contains(&p) {
                let lines = hull.edges().map(|(a, b)| (b - a).normalize().perp(&(p - a)));
                let least = lines.fold(f64::INFINITY, f64::min);
                prop_assert!((hull.margin(&p) - least).abs() < 1e-12);
            } else {
                // separating line: all points lie behind the normal at the nearest point
                let normal = p - near;
                for q in &points {
                    prop_assert!(normal.dot(&(q - near)) < 1e-9);
                }
            }
        }

        /// Any order of the points gives the same hull, to the bit.
        #[test]
        fn order_does_not_matter(raw in prop::collection::vec((-1.0..1.0f64, -1.0..1.0f64), 0..12)) {
            let points: Vec<Vec2> = raw.iter().map(|p| Vec2::new(p.0, p.1)).collect();
            let reversed = points.iter().rev().copied().collect();
            prop_assert_eq!(Support::of_plane(points), Support::of_plane(reversed));
        }
    }
}
