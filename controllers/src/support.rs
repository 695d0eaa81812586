//! Support: where the feet stand and how they share the load.
//!
//! RNEA on a floating tree knows no ground. Stance legs get the ground reaction by a stated rule: a
//! total force at a centre of pressure, split between the feet by the distance of that point along
//! the line between them, each share acting at its foot's centre moved by the same offset. DESIGN §4.
//!
//! In: foot poses, a centre of pressure, a force. Out: wrenches on the feet. World frame.

use bodies::Character;
use dynamics::{Model, State, Wrench};
use motion::support::{Support, Vec2, ground};
use motion::{Limb, Sole, Vec3};

/// A foot that may stand: its leg and its sole.
#[derive(Clone, Debug, PartialEq)]
pub struct Foot {
    /// The leg.
    pub limb: Limb,
    /// Body of the foot in the model.
    pub body: usize,
    /// Its sole.
    pub sole: Sole,
}

impl Foot {
    /// The feet of a character: legs whose foot carries contact points.
    pub fn of(character: &Character, model: &Model) -> Vec<Foot> {
        let of =
            |(limb, sole): (&Limb, Sole)| Foot { limb: limb.clone(), body: model.body_of[limb.end].0, sole };
        character.leg_soles().into_iter().map(of).collect()
    }

    /// Corners of the sole in the world, m.
    pub fn corners_in_world(&self, model: &Model, state: &State) -> Vec<Vec3> {
        self.sole.corners.iter().map(|(link, at)| state.point(model, *link, at)).collect()
    }

    /// Speed of the middle of the sole, m/s.
    pub fn speed(&self, model: &Model, state: &State) -> f64 {
        let velocity: Vec3 =
            self.sole.corners.iter().map(|(link, at)| state.point_velocity(model, *link, at)).sum();
        velocity.norm() / self.sole.corners.len() as f64
    }

    /// Mean of the corners in the world, m.
    pub fn center(&self, model: &Model, state: &State) -> Vec3 {
        let sum: Vec3 = self.sole.corners.iter().map(|(link, at)| state.point(model, *link, at)).sum();
        sum / self.sole.corners.len() as f64
    }
}

/// Hull of the soles of `feet`.
pub fn polygon(feet: &[Foot], model: &Model, state: &State) -> Support {
    let corners: Vec<Vec3> = feet.iter().flat_map(|f| f.corners_in_world(model, state)).collect();
    Support::of(corners.iter())
}

/// `p` moved towards the centroid of the support until it is `margin` (m) inside; the centroid where the
/// support is narrower than that, `p` itself where it is already inside.
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

/// `shares` (which sum to 1) of which none is more than its part of the largest of `most`: what is too much for one goes to those with room.
pub fn within_allowance(shares: &[f64], most: &[f64]) -> Vec<f64> {
    let largest = most.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let within: Vec<f64> = shares.iter().zip(most).map(|(s, m)| s.min(m / largest)).collect();
    let room: Vec<f64> = within.iter().zip(most).map(|(s, m)| m / largest - s).collect();
    let left = 1.0 - within.iter().sum::<f64>();
    let all: f64 = room.iter().sum();
    if left <= 0.0 || all <= 0.0 {
        return within;
    }
    within.iter().zip(&room).map(|(s, r)| s + left * r / all).collect()
}

/// Wrenches on the feet that sum to `force` (N) with its centre of pressure at `cop`.
pub fn wrenches(feet: &[Foot], model: &Model, state: &State, cop: Vec2, force: Vec3) -> Vec<Wrench> {
    let centers: Vec<Vec3> = feet.iter().map(|f| f.center(model, state)).collect();
    let shares = shares(&centers, cop);
    shared_wrenches(feet, &centers, &shares, cop, force)
}

/// [`wrenches`] with the share of each foot given (they sum to 1) and the `centers` of the soles, m.
pub fn shared_wrenches(
    feet: &[Foot],
    centers: &[Vec3],
    shares: &[f64],
    cop: Vec2,
    force: Vec3,
) -> Vec<Wrench> {
    let mean: Vec2 = centers.iter().zip(shares).map(|(c, w)| ground(c) * *w).sum();
    let offset = cop - mean;
    feet.iter()
        .zip(centers.iter().zip(shares))
        .map(|(foot, (center, share))| Wrench {
            link: foot.limb.end,
            point: center + Vec3::new(offset.x, 0.0, offset.y),
            force: force * *share,
            moment: Vec3::zeros(),
        })
        .collect()
}

/// Share of each foot (sums to 1) and wrenches on the feet that sum to `force` (N) with its centre of pressure at
/// `cop`, as rigid soles on an even floor take it: the pressures of all corners that have this centre and the
/// least sum of squares. Each foot's own centre lies inside its sole as long as `cop` lies inside all of them.
pub fn pressed_wrenches(
    feet: &[Foot],
    model: &Model,
    state: &State,
    cop: Vec2,
    force: Vec3,
) -> (Vec<f64>, Vec<Wrench>) {
    let corners: Vec<Vec<Vec3>> = feet.iter().map(|f| f.corners_in_world(model, state)).collect();
    let at: Vec<Vec3> = corners.concat();
    let mut pressures = vec![0.0; at.len()];
    let height = at.iter().map(|p| p.y).sum::<f64>() / at.len().max(1) as f64;
    let aim = Vec3::new(cop.x, height, cop.y);
    dynamics::analysis::pressures(&at, &vec![1.0; at.len()], aim, &mut pressures);
    let mut first = 0;
    feet.iter()
        .zip(&corners)
        .map(|(foot, corners)| {
            let own = &pressures[first..first + corners.len()];
            first += corners.len();
            let share: f64 = own.iter().sum();
            let sum: Vec3 = corners.iter().zip(own).map(|(p, w)| p * *w).sum();
            let point = if share > 0.0 { sum / share } else { foot.center(model, state) };
            let wrench = Wrench { link: foot.limb.end, point, force: force * share, moment: Vec3::zeros() };
            (share, wrench)
        })
        .unzip()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shares keep their sum, and none is more than allowed.
    #[test]
    fn shares_are_allowed() {
        for (shares, most) in [
            ([0.8, 0.2], [0.3, 1.0]),
            ([0.8, 0.2], [1.0, 1.0]),
            ([0.5, 0.5], [0.02, 0.01]),
            ([0.0, 1.0], [1.0, 0.25]),
        ] {
            let all = within_allowance(&shares, &most);
            let largest = most[0].max(most[1]);
            assert!((all.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{all:?}");
            assert!(all.iter().zip(most).all(|(s, m)| *s <= m / largest + 1e-12 && *s >= 0.0), "{all:?}");
        }
        assert_eq!(within_allowance(&[0.8, 0.2], &[1.0, 1.0]), [0.8, 0.2]);
        assert!(within_allowance(&[], &[]).is_empty());
        assert_eq!(within_allowance(&[0.0, 0.0], &[0.0, 0.0]), [0.0, 0.0]);
    }

    fn sole() -> Support {
        let corners = [(0.0, 0.0), (0.1, 0.0), (0.12, 0.25), (-0.01, 0.25)];
        Support::of_plane(corners.map(|(x, z)| Vec2::new(x, z)).to_vec())
    }

    /// What is inside stays to the bit; what is outside ends on the margin, on its line to the centroid.
    #[test]
    fn clamping_ends_on_the_margin() {
        let sole = sole();
        let (margin, center) = (0.02, sole.centroid().unwrap());
        for i in 0..200 {
            let f = f64::from(i);
            let p = center + Vec2::new((f * 0.7).sin(), (f * 1.3).cos()) * (0.002 * f);
            let c = clamp_inside(&sole, p, margin);
            if sole.margin(&p) >= margin {
                assert_eq!(c, p);
            } else {
                assert!((sole.margin(&c) - margin).abs() < 1e-9, "{p} {}", sole.margin(&c));
                let (a, b) = (c - center, p - center);
                assert!(a.perp(&b).abs() < 1e-12 && a.dot(&b) > 0.0);
                assert!((clamp_inside(&sole, c, margin) - c).norm() < 1e-9);
            }
        }
    }

    /// Without feet nothing is shared; feet at one place carry it all between them, wherever the pressure is.
    #[test]
    fn shares_of_nothing_and_of_one_place() {
        assert!(shares(&[], Vec2::zeros()).is_empty());
        for feet in 1..4 {
            for cop in [Vec2::zeros(), Vec2::new(1.0, -2.0)] {
                let shares = shares(&vec![Vec3::zeros(); feet], cop);
                let sum: f64 = shares.iter().sum();
                assert!(shares.len() == feet && (sum - 1.0).abs() < 1e-15, "{shares:?}");
            }
        }
    }

    /// A support narrower than its margin, an edge or nothing: the best there is.
    #[test]
    fn a_narrow_support_gives_its_centroid() {
        let sole = sole();
        let far = Vec2::new(1.0, 1.0);
        assert_eq!(clamp_inside(&sole, far, 0.2), sole.centroid().unwrap());
        let edge = Support::of_plane(vec![Vec2::zeros(), Vec2::new(0.2, 0.0)]);
        assert_eq!(clamp_inside(&edge, far, 0.01), Vec2::new(0.1, 0.0));
        assert_eq!(clamp_inside(&Support::default(), far, 0.01), far);
    }
}
