//! Ground forces of one motion from several sources: in total and per foot.
//!
//! In: an [`Analysis`] (what the motion requires), a [`Penalty`] evaluated on the motion (what that
//! contact model gives), a [`Trace`] (what an engine measured). Out: [`GroundForces`], one row per
//! sample, ready to be laid over each other. World axes, N; feet in the order of the character's legs.
//!
//! *Required*, total: `ṗ − m g` of the motion. Per foot only the sum is determined while both feet stand;
//! it is divided as an elastic floor under the soles would divide it ([`crate::analysis::ground`]).
//!
//! *Given*: (13), (14) at every contact point of the character. A penalty model stands a little inside the ground, and
//! its force changes by the body's weight within a millimetre or two of height, more exactly than a captured ground is known.
//! So the whole motion is lowered by the one shift at which the mean vertical force is the required one; only the course
//! of the vertical force over time is then the model's. There are no anchors r̂: recorded feet that stand creep by tenths of
//! a millimetre, and anchors would pull them back with hundreds of newtons. The horizontal force is that of slip
//! alone, almost zero under a foot that stands.
//!
//! *Measured*: contact forces on a foot and all links it carries; of other links in the total only.

use motion::Vec3;
use motion::skeleton::vec_at;

use crate::penalty::PenaltyError;
use crate::{Analysis, Model, Penalty, State, Trace};
use bodies::Character;

/// Force on one foot.
#[derive(Clone, Debug, PartialEq)]
pub struct FootForce {
    /// Name of its leg.
    pub name: String,
    /// The foot's link.
    pub link: usize,
    /// Force, world, N; one per row.
    pub force: Vec<Vec3>,
}

/// Ground forces over time. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundForces {
    /// Rows per second, Hz.
    pub rate_hz: f64,
    /// Time of the first row, s.
    pub start_s: f64,
    /// Sum of all forces, world, N; one per row.
    pub total: Vec<Vec3>,
    /// The feet.
    pub feet: Vec<FootForce>,
}

/// What [`GroundForces::given`] was evaluated with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GivenBy {
    /// The model's parameters.
    pub penalty: Penalty,
    /// Depth at which a standing body would rest, m: δ of [`Penalty::for_body`].
    pub sink_m: f64,
    /// How much the motion was lowered, m.
    pub lowered_m: f64,
}

/// Largest shift of the ground that is tried, m.
const FARTHEST: f64 = 0.1;

impl GroundForces {
    /// What the motion needs.
    pub fn required(a: &Analysis) -> Self {
        let total: Vec<Vec3> = (0..a.frames()).map(|k| vec_at(&a.required_force, 3 * k)).collect();
        let feet = a.feet.iter().map(|f| FootForce {
            name: f.name.clone(),
            link: f.link,
            force: f.share.iter().zip(&total).map(|(share, force)| force * *share).collect(),
        });
        Self { rate_hz: a.rate_hz(), start_s: 0.0, feet: feet.collect(), total }
    }

    /// What penalty contact gives to the motion, for a body that would rest `sink_m` deep; `None`
    /// without ground, weight or contact points, or where no shift up to 0.1 m gives the required mean.
    ///
    /// # Errors
    /// A sink, mass or gravity that is not positive.
    pub fn given(
        character: &Character,
        a: &Analysis,
        sink_m: f64,
    ) -> Result<Option<(Self, GivenBy)>, PenaltyError> {
        let (Some(ground), false) = (a.ground_m, character.contacts.is_empty()) else { return Ok(None) };
        if a.weight() <= 0.0 {
            return Ok(None); // no weight would rest on it
        }
        let points = character.contacts.len();
        let penalty = Penalty::for_body(a.mass, a.gravity.norm(), points, sink_m)?;
        let soles = SolePoints::of(character, a, ground);
        let wanted: f64 = (0..a.frames()).map(|k| a.required_force[3 * k + 1]).sum();
        let sum = |shift: f64| -> f64 {
            soles.points.iter().map(|p| penalty.normal(p.height - shift, p.velocity.y)).sum()
        };
        let (mut lo, mut hi) = (-FARTHEST, FARTHEST);
        if !(sum(lo) < wanted && wanted < sum(hi)) {
            return Ok(None);
        }
        for _ in 0..60 {
            let middle = 0.5 * (lo + hi);
            if sum(middle) < wanted { lo = middle } else { hi = middle }
        }
        let lowered_m = 0.5 * (lo + hi);
        let owner = owners(character);
        let mut out = Self::zeros(character, a.frames(), a.rate_hz());
        for (i, p) in soles.points.iter().enumerate() {
            let (row, c) = (i / points, i % points);
            let rate = [p.velocity.x, p.velocity.z];
            let force = penalty.force(p.height - lowered_m, p.velocity.y, [0.0; 2], rate);
            out.add(row, owner[character.skeleton.sites()[character.contacts[c]].link], force);
        }
        Ok(Some((out, GivenBy { penalty, sink_m, lowered_m })))
    }

    /// What an engine measured.
    pub fn measured(trace: &Trace) -> Self {
        let owner = owners(&trace.character);
        let mut out = Self::zeros(&trace.character, trace.rows(), trace.rate_hz);
        for c in trace.contacts.iter().filter(|c| c.against.is_world()) {
            out.add(c.row, owner[c.link], c.force);
        }
        // row 0 is the state at the start: no step has been made, so there is no force
        for forces in std::iter::once(&mut out.total).chain(out.feet.iter_mut().map(|f| &mut f.force)) {
            if let Some(first) = forces.first_mut() {
                *first = Vec3::repeat(f64::NAN);
            }
        }
        out
    }

    fn zeros(character: &Character, rows: usize, rate_hz: f64) -> Self {
        let links = character.skeleton.links();
        let limbs = character.legs();
        let feet = limbs.map(|leg| FootForce {
            name: if leg.name.is_empty() { links[leg.end].name.clone() } else { leg.name.clone() },
            link: leg.end,
            force: vec![Vec3::zeros(); rows],
        });
        Self { rate_hz, start_s: 0.0, feet: feet.collect(), total: vec![Vec3::zeros(); rows] }
    }

    fn add(&mut self, row: usize, owner: usize, force: Vec3) {
        self.total[row] += force;
        if let Some(foot) = self.feet.iter_mut().find(|f| f.link == owner) {
            foot.force[row] += force;
        }
    }

    /// The rows from `from_s` to `to_s`, ends included.
    pub fn between(&self, from_s: f64, to_s: f64) -> Self {
        let last = self.total.len();
        let row = |t: f64| (t - self.start_s) * self.rate_hz;
        let first = (row(from_s) - 1e-6).ceil().clamp(0.0, last as f64) as usize;
        let end = ((row(to_s) + 1e-6).floor() + 1.0).clamp(first as f64, last as f64) as usize;
        let cut = |f: &[Vec3]| f[first..end].to_vec();
        let feet = self.feet.iter();
        Self {
            rate_hz: self.rate_hz,
            start_s: self.start_s + first as f64 / self.rate_hz,
            total: cut(&self.total),
            feet: feet.map(|f| FootForce { force: cut(&f.force), ..f.clone() }).collect(),
        }
    }

    /// RMS difference of two courses of force, on the rows of `a`, linear between those of `b`: vertical,
    /// and length of the horizontal difference, N. `None` without common times.
    pub fn rms_difference(clocks: [&Self; 2], a: &[Vec3], b: &[Vec3]) -> Option<[f64; 2]> {
        let [ca, cb] = clocks;
        let (mut up, mut across, mut n) = (0.0, 0.0, 0.0);
        for (row, force) in a.iter().enumerate() {
            let x = (ca.start_s + row as f64 / ca.rate_hz - cb.start_s) * cb.rate_hz;
            let i = (x + 1e-6).floor();
            if i < 0.0 || x > b.len() as f64 - 1.0 + 1e-6 {
                continue;
            }
            let i = i as usize;
            let s = (x - i as f64).clamp(0.0, 1.0);
            let other = if s < 1e-6 { b[i] } else { b[i] * (1.0 - s) + b[(i + 1).min(b.len() - 1)] * s };
            let d = force - other;
            if d.iter().all(|x| x.is_finite()) {
                up += d.y * d.y;
                across += d.x * d.x + d.z * d.z;
                n += 1.0;
            }
        }
        (n > 0.0).then(|| [f64::sqrt(up / n), f64::sqrt(across / n)])
    }
}

/// For each link the foot that carries it, or the link itself.
fn owners(character: &Character) -> Vec<usize> {
    let links = character.skeleton.links();
    let foot = |link: usize| character.legs().any(|leg| leg.end == link);
    let of = |link: usize| std::iter::successors(Some(link), |&u| links[u].parent).find(|&u| foot(u));
    (0..links.len()).map(|link| of(link).unwrap_or(link)).collect()
}

/// A contact point in one frame.
struct SolePoint {
    /// Above the ground, m.
    height: f64,
    /// World, m/s.
    velocity: Vec3,
}

/// The contact points of all frames, `frames × points`.
struct SolePoints {
    points: Vec<SolePoint>,
}

impl SolePoints {
    fn of(character: &Character, a: &Analysis, ground: f64) -> Self {
        let model = Model::new(character, a.gravity);
        let mut state = State::new(&model);
        let sites = model.skeleton.sites();
        let mut points = Vec::with_capacity(a.frames() * character.contacts.len());
        for k in 0..a.frames() {
            state.update(&model, a.clip.pose(k), &a.v[k * model.nv()..(k + 1) * model.nv()]);
            points.extend(character.contacts.iter().map(|&c| {
                let site = &sites[c];
                let at = state.point(&model, site.link, &site.at);
                let velocity = state.point_velocity(&model, site.link, &site.at);
                SolePoint { height: at.y - ground, velocity }
            }));
        }
        Self { points }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Without common times there is no difference to state; of zeros it is zero.
    #[test]
    fn differences_of_nothing_and_of_zeros() {
        let forces = |rows: usize, start_s: f64| GroundForces {
            rate_hz: 10.0,
            start_s,
            total: vec![Vec3::zeros(); rows],
            feet: Vec::new(),
        };
        let between =
            |a: &GroundForces, b: &GroundForces| GroundForces::rms_difference([a, b], &a.total, &b.total);
        assert_eq!(between(&forces(0, 0.0), &forces(0, 0.0)), None);
        assert_eq!(between(&forces(3, 0.0), &forces(0, 0.0)), None);
        assert_eq!(between(&forces(3, 0.0), &forces(3, 5.0)), None);
        assert_eq!(between(&forces(3, 0.0), &forces(3, 0.0)), Some([0.0; 2]));
        assert!(forces(0, 0.0).between(0.0, 1.0).total.is_empty());
    }
}
