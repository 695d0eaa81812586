//! Support: where the feet stand and how they share the load.
//!
//! RNEA on a floating tree knows no ground. Stance legs get the ground reaction by a stated rule: a
//! total force at a centre of pressure, split between the feet by the distance of that point along
//! the line between them, each share acting at its foot's centre moved by the same offset. DESIGN §4.
//!
//! In: foot poses, a centre of pressure, a force. Out: wrenches on the feet. World frame.

use dynamics::{Character, Model, State, Wrench};
use motion::support::{Support, Vec2, ground};
use motion::{Limb, LimbKind, Vec3};

/// A foot that may stand: its leg and the corners of its sole.
#[derive(Clone, Debug, PartialEq)]
pub struct Foot {
    /// The leg.
    pub limb: Limb,
    /// Body of the foot in the model.
    pub body: usize,
    /// Corners of the sole: link and point in that link's frame, m.
    pub corners: Vec<(usize, Vec3)>,
}

impl Foot {
    /// The feet of a character: legs whose foot carries contact points.
    pub fn of(character: &Character, model: &Model) -> Vec<Foot> {
        let sites = character.skeleton.sites();
        let legs = character.skeleton.limbs().iter().filter(|l| l.kind == LimbKind::Leg);
        legs.filter_map(|limb| {
            let body = model.body_of[limb.end].0;
            let corners: Vec<_> = character
                .contacts
                .iter()
                .map(|&c| &sites[c])
                .filter(|s| model.body_of[s.link].0 == body)
                .map(|s| (s.link, s.at))
                .collect();
            (!corners.is_empty()).then(|| Foot { limb: limb.clone(), body, corners })
        })
        .collect()
    }

    /// Corners of the sole in the world, m.
    pub fn corners_in_world(&self, model: &Model, state: &State) -> Vec<Vec3> {
        self.corners.iter().map(|(link, at)| state.point(model, *link, at)).collect()
    }

    /// Mean of the corners in the world, m.
    pub fn center(&self, model: &Model, state: &State) -> Vec3 {
        let sum: Vec3 = self.corners.iter().map(|(link, at)| state.point(model, *link, at)).sum();
        sum / self.corners.len() as f64
    }
}

/// Hull of the soles of `feet`.
pub fn polygon(feet: &[Foot], model: &Model, state: &State) -> Support {
    let corners: Vec<Vec3> = feet.iter().flat_map(|f| f.corners_in_world(model, state)).collect();
    Support::of(corners.iter())
}

/// Nearest point to `p` that is at least `margin` (m) inside the support; its centroid where the
/// support is narrower than that.
pub fn clamp_inside(support: &Support, p: Vec2, margin: f64) -> Vec2 {
    let Some(center) = support.centroid() else { return p };
    if support.margin(&p) >= margin {
        return p;
    }
    if support.margin(&center) <= margin {
        return center;
    }
    // bisection along the line to the centroid: the margin of a convex polygon is concave on it
    let (mut out, mut inside) = (p, center);
    for _ in 0..40 {
        let mid = (out + inside) * 0.5;
        if support.margin(&mid) >= margin { inside = mid } else { out = mid }
    }
    inside
}

/// Share of the weight of each foot (sums to 1) for a centre of pressure `cop`.
pub fn shares(centers: &[Vec3], cop: Vec2) -> Vec<f64> {
    match centers {
        [] => Vec::new(),
        [_] => vec![1.0],
        [a, b] => {
            let (a, b) = (ground(a), ground(b));
            let line = b - a;
            let s = ((cop - a).dot(&line) / line.norm_squared().max(1e-12)).clamp(0.0, 1.0);
            vec![1.0 - s, s]
        }
        many => {
            let w: Vec<f64> = many.iter().map(|c| 1.0 / ((ground(c) - cop).norm() + 0.02)).collect();
            let sum: f64 = w.iter().sum();
            w.iter().map(|x| x / sum).collect()
        }
    }
}

/// Wrenches on the feet that sum to `force` (N) with its centre of pressure at `cop`.
pub fn wrenches(feet: &[Foot], model: &Model, state: &State, cop: Vec2, force: Vec3) -> Vec<Wrench> {
    let centers: Vec<Vec3> = feet.iter().map(|f| f.center(model, state)).collect();
    let shares = shares(&centers, cop);
    let mean: Vec2 = centers.iter().zip(&shares).map(|(c, w)| ground(c) * *w).sum();
    let offset = cop - mean;
    feet.iter()
        .zip(centers.iter().zip(&shares))
        .map(|(foot, (center, share))| Wrench {
            link: foot.limb.end,
            point: center + Vec3::new(offset.x, 0.0, offset.y),
            force: force * *share,
            moment: Vec3::zeros(),
        })
        .collect()
}
