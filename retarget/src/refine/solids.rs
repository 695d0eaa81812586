//! Body and scene as balls: what touches what, how deep, and in which direction.
//!
//! In: the shapes of a character's links, solids of the scene. Out: penetrations of a pose. Every shape is filled
//! with balls along its longest directions, half a radius of overlap between neighbours, so that a capsule's
//! surface is at most 14 % of its radius above theirs; distances are then between centres, with a direction
//! wherever two centres are apart. Two links that touch in the rest pose or hang on one another are no
//! collision; other pairs are one from the depth on that they have in an accepted pose. Links with contact points, and those
//! they hang on, may touch the ground: a shin is thicker than its ankle is high.

use motion::{Kinematics, Shape, Vec3};

use crate::Puppet;

/// A ball on a link, or in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ball {
    center: Vec3,
    radius: f64,
}

/// Two points that should be apart: how deep they are in one another and which way out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penetration {
    /// Link and world position of the first point.
    pub first: (usize, Vec3),
    /// The second, on a link of the body; `None` where it belongs to the scene.
    pub second: Option<(usize, Vec3)>,
    /// Unit direction in which the first should go.
    pub out: Vec3,
    /// Depth, m, > 0.
    pub depth_m: f64,
}

/// What of a body may collide. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Solids {
    links: Vec<Part>,
    /// Pairs into `links`, and how deep they may be in one another, m.
    pairs: Vec<(usize, usize, f64)>,
    /// Entries of `links` that should stay above the ground.
    aloft: Vec<usize>,
    scene: Vec<Shape>,
}

/// A link's balls, and one around them all.
#[derive(Clone, Debug, PartialEq)]
struct Part {
    link: usize,
    balls: Vec<Ball>,
    bound: Ball,
}

/// Where the balls of all parts are in a pose, world.
struct Placed {
    /// Per part, the middle of its bound.
    bounds: Vec<Vec3>,
    /// Per part, the middles of its balls.
    balls: Vec<Vec<Vec3>>,
}

/// Balls per shape and direction, at most.
const MOST: usize = 8;

impl Solids {
    /// For a puppet, the solids of a scene (world), and poses (`nq` each) whose touches are meant.
    pub fn new(puppet: &Puppet, scene: &[Shape], accepted: &[Vec<f64>]) -> Self {
        let c = &puppet.character;
        let links: Vec<Part> = c
            .bodies
            .iter()
            .enumerate()
            .filter_map(|(link, b)| Part::new(link, b.shapes.iter().flat_map(balls).collect()))
            .collect();
        let k = Kinematics::new(&c.skeleton, &c.rest);
        let mut out = Self { links, pairs: Vec::new(), aloft: Vec::new(), scene: scene.to_vec() };
        let at_rest = out.place(&k);
        for a in 0..out.links.len() {
            for b in 0..a {
                let (i, j) = (out.links[a].link, out.links[b].link);
                let parent = |l: usize| c.skeleton.links()[l].parent;
                if parent(i) == Some(j) || parent(j) == Some(i) {
                    continue;
                }
                let mut touching = Vec::new();
                out.between(&at_rest, (a, b, 0.0), &mut touching);
                if touching.is_empty() {
                    out.pairs.push((a, b, 0.0));
                }
            }
        }
        let mut pairs = std::mem::take(&mut out.pairs);
        let mut posed = k.clone();
        let mut touching = Vec::new();
        for q in accepted {
            posed.update(&c.skeleton, q);
            let placed = out.place(&posed);
            for pair in &mut pairs {
                touching.clear();
                out.between(&placed, (pair.0, pair.1, 0.0), &mut touching);
                pair.2 = touching.iter().map(|t: &Penetration| t.depth_m).fold(pair.2, f64::max);
            }
        }
        out.pairs = pairs;
        let stands = |link: usize| {
            puppet.contacts.iter().any(|p| {
                let foot = c.skeleton.sites()[p.site].link;
                foot == link || c.skeleton.links()[foot].parent == Some(link)
            })
        };
        out.aloft = (0..out.links.len()).filter(|&i| !stands(out.links[i].link)).collect();
        out
    }

    fn place(&self, k: &Kinematics) -> Placed {
        Placed {
            bounds: self.links.iter().map(|p| k.point(p.link, &p.bound.center)).collect(),
            balls: self
                .links
                .iter()
                .map(|p| p.balls.iter().map(|b| k.point(p.link, &b.center)).collect())
                .collect(),
        }
    }

    /// All penetrations of a pose, appended to `out`.
    pub fn penetrations(&self, k: &Kinematics, out: &mut Vec<Penetration>) {
        let placed = self.place(k);
        for &pair in &self.pairs {
            self.between(&placed, pair, out);
        }
        for &i in &self.aloft {
            let part = &self.links[i];
            for (ball, p) in part.balls.iter().zip(&placed.balls[i]) {
                let depth_m = ball.radius - p.y;
                if depth_m > 0.0 {
                    out.push(Penetration { first: (part.link, *p), second: None, out: Vec3::y(), depth_m });
                }
            }
        }
        for (i, part) in self.links.iter().enumerate().filter(|_| !self.scene.is_empty()) {
            for (ball, p) in part.balls.iter().zip(&placed.balls[i]) {
                for solid in &self.scene {
                    let (distance, out_of) = distance(solid, p);
                    let depth_m = ball.radius - distance;
                    if depth_m > 0.0 {
                        out.push(Penetration { first: (part.link, *p), second: None, out: out_of, depth_m });
                    }
                }
            }
        }
    }

    /// Where two links are deeper in one another than they may be.
    fn between(&self, placed: &Placed, (a, b, free_m): (usize, usize, f64), out: &mut Vec<Penetration>) {
        let (first, second) = (&self.links[a], &self.links[b]);
        let reach = first.bound.radius + second.bound.radius - free_m;
        if apart(&placed.bounds[a], &placed.bounds[b], reach) {
            return;
        }
        for (p, at) in first.balls.iter().zip(&placed.balls[a]) {
            if apart(at, &placed.bounds[b], p.radius + second.bound.radius - free_m) {
                continue;
            }
            for (q, other) in second.balls.iter().zip(&placed.balls[b]) {
                let reach = p.radius + q.radius - free_m;
                if apart(at, other, reach) {
                    continue;
                }
                let way = at - other;
                let depth_m = reach - way.norm();
                if depth_m > 0.0 && way.norm() > 1e-9 {
                    let second = Some((second.link, *other));
                    out.push(Penetration { first: (first.link, *at), second, out: way.normalize(), depth_m });
                }
            }
        }
    }
}

/// Whether two points are at least `reach` from one another.
fn apart(a: &Vec3, b: &Vec3, reach: f64) -> bool {
    reach <= 0.0 || (a - b).norm_squared() >= reach * reach
}

impl Part {
    /// `None` without balls.
    fn new(link: usize, balls: Vec<Ball>) -> Option<Self> {
        let middle = balls.iter().map(|b| b.center).sum::<Vec3>() / balls.len() as f64;
        let reach = balls.iter().map(|b| (b.center - middle).norm() + b.radius).reduce(f64::max)?;
        // slightly larger, so that rounding excludes no ball
        let bound = Ball { center: middle, radius: reach * (1.0 + 1e-9) };
        Some(Self { link, balls, bound })
    }
}

/// Balls that fill a shape.
fn balls(shape: &Shape) -> Vec<Ball> {
    let line = |a: Vec3, b: Vec3, ra: f64, rb: f64| -> Vec<Ball> {
        let gaps = (((b - a).norm() / ra.min(rb).max(1e-3)).ceil() as usize).clamp(1, MOST);
        (0..=gaps)
            .map(|i| {
                let s = i as f64 / gaps as f64;
                Ball { center: a + (b - a) * s, radius: ra + (rb - ra) * s }
            })
            .collect()
    };
    match *shape {
        Shape::Sphere { center, radius } => vec![Ball { center, radius }],
        Shape::Capsule { a, b, radius } => line(a, b, radius, radius),
        // the ends are flat: the outermost balls stay inside
        Shape::Cone { a, b, radius_a, radius_b } => {
            let axis = (b - a).normalize();
            let least = radius_a.min(radius_b).min(0.5 * (b - a).norm());
            line(a + axis * least, b - axis * least, radius_a, radius_b)
        }
        Shape::Box { center, half, rotation } => {
            let radius = half.min();
            let steps = |h: f64| (((h - radius) / (0.5 * radius)).ceil() as usize).min(MOST);
            let n = half.map(steps);
            let place = |i: usize, axis: usize| {
                if n[axis] == 0 {
                    0.0
                } else {
                    (2.0 * i as f64 / n[axis] as f64 - 1.0) * (half[axis] - radius)
                }
            };
            let mut out = Vec::new();
            for x in 0..=n.x {
                for y in 0..=n.y {
                    for z in 0..=n.z {
                        let at = Vec3::new(place(x, 0), place(y, 1), place(z, 2));
                        out.push(Ball { center: center + rotation * at, radius });
                    }
                }
            }
            out
        }
    }
}

/// Signed distance of a point from a solid of the scene, and the direction away from it.
fn distance(solid: &Shape, p: &Vec3) -> (f64, Vec3) {
    let from = |c: Vec3, radius: f64| {
        let d = p - c;
        let n = d.norm();
        (n - radius, if n > 1e-9 { d / n } else { Vec3::y() })
    };
    match *solid {
        Shape::Sphere { center, radius } => from(center, radius),
        Shape::Capsule { a, b, radius } => {
            let along = b - a;
            let s = (p - a).dot(&along) / along.norm_squared().max(1e-18);
            from(a + along * s.clamp(0.0, 1.0), radius)
        }
        Shape::Cone { a, b, radius_a, radius_b } => {
            let axis = (b - a).normalize();
            let (along, length) = ((p - a).dot(&axis), (b - a).norm());
            let s = (along / length).clamp(0.0, 1.0);
            let side = p - a - axis * along;
            let out = if side.norm() > 1e-9 { side.normalize() } else { axis };
            let flank = side.norm() - (radius_a + (radius_b - radius_a) * s);
            let (lid, cap) = if along < 0.5 * length { (-along, -axis) } else { (along - length, axis) };
            if flank > 0.0 && lid > 0.0 {
                let away = out * flank + cap * lid;
                (away.norm(), away.normalize())
            } else if flank > lid {
                (flank, out)
            } else {
                (lid, cap)
            }
        }
        Shape::Box { center, half, rotation } => {
            let local = rotation.inverse() * (p - center);
            let beyond = local.abs() - half;
            if beyond.max() > 0.0 {
                let nearest = Vec3::from_fn(|i, _| local[i].clamp(-half[i], half[i]));
                let d = local - nearest;
                (d.norm(), rotation * d.normalize())
            } else {
                let axis = beyond.imax();
                let mut n = Vec3::zeros();
                n[axis] = if local[axis] < 0.0 { -1.0 } else { 1.0 };
                (beyond[axis], rotation * n)
            }
        }
    }
}
