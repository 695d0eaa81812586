//! The part of a required wrench that a plane floor can give, and how the soles share it.
//!
//! In: corners of the soles, their heights and speeds, a required wrench. Out: an admissible wrench per
//! foot. Every frame is computed by itself. The floor is the plane y = `h`; that of a treadmill moves.
//!
//! *Soles.* Points no farther apart than [`SPACING_M`] along the edges, corners included. Toes are welded: in a foot that rolls
//! over its ball the tips are under the ground, and the sole reaches from them back to where it leaves the ground.
//!
//! *Contact.* A point of a sole at height z above the ground and with speed u touches by
//! `α = s(z/height) · s(u/speed)`, where s falls from 1 at ½ to 0 at 1 (cubic); of these the foot's
//! contact is made. The fall is gradual, so that forces begin and end without jumps.
//!
//! *Force.* Only pressing, the tangential part at most μ f_n.
//!
//! *Centre of pressure.* Where the horizontal moment of the required wrench vanishes on the ground, or the
//! nearest point of the hull of the touching corners.
//!
//! *Shares.* Pressures w of the corners x with `Σ w = 1`, `Σ w x = c`, `w ≥ 0` that minimise `Σ w²/α`: those of
//! rigid soles on an elastic floor of stiffness α under each corner. Between two equal feet this splits the
//! force by distance. Every foot's own centre of pressure lies inside its sole.
//!
//! *Moment about the vertical.* At most `ρ √((μ f_n)² − f_t²)`, ρ = Σ w |x − c| \[HC96\]; shared like the force.
//!
//! \[HC96\] Howe, Cutkosky. Practical force-motion models for sliding manipulation, IJRR 1996 (elliptic limit
//! surface).

use bodies::Character;
use motion::support::ground as plane;
use motion::{Clip, Derivatives, Floor, Sole, Support, Vec3, smoothstep};
use nalgebra::Matrix3;

use super::AnalysisOptions;
use crate::{Model, State, Wrench};

/// Distance outside the support polygon that counts as a violation, m; more where noise moves the centre of pressure by more
/// ([`super::NoiseFloor::pressure`]).
pub const COP_SLACK: f64 = 1e-3;
/// Least vertical force that has a centre of pressure, as a share of body weight: below, the noise of the
/// moment moves it by decimetres.
pub const LEAST_LOAD: f64 = 0.1;
/// Least force that is judged, per mass, m/s²: what is left of a body in free fall by rounding and the ends of a clip.
const LEAST_PULL: f64 = 0.01;
/// Distance of the points along the edges of a sole, m: half a ball's length.
pub const SPACING_M: f64 = 0.04;
/// Least touch α of a corner.
const LEAST_TOUCH: f64 = 1e-3;

/// How the floor of an analysis is chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum FloorChoice {
    /// There is none: the whole required wrench is residual.
    None,
    /// A horizontal plane at this height, m.
    At(f64),
    /// A horizontal plane at the median height of the lowest corner of the soles, over the frames in
    /// which it is slower than [`Contact::speed_m_s`].
    #[default]
    Detect,
}

/// When a corner of a sole touches the ground. See the module header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Height at which contact is lost, m.
    pub height_m: f64,
    /// Speed against the ground at which contact is lost, m/s.
    pub speed_m_s: f64,
    /// Velocity of the ground, world, m/s: of the belt of a treadmill.
    pub ground_velocity: Vec3,
}

impl Default for Contact {
    fn default() -> Self {
        Self { height_m: 0.05, speed_m_s: 1.2, ground_velocity: Vec3::zeros() }
    }
}

/// Frames that break a rule.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Violations {
    /// Frames, ascending.
    pub frames: Vec<usize>,
    /// Worst value; zero when there is no violation.
    pub worst: f64,
    /// Frame of the worst value.
    pub worst_frame: usize,
}

impl Violations {
    /// Adds a frame whose value is beyond the limit.
    pub(super) fn record(&mut self, frame: usize, value: f64, limit: f64) {
        if value > limit {
            self.frames.push(frame);
            if value > self.worst {
                (self.worst, self.worst_frame) = (value, frame);
            }
        }
    }
}

/// Corners of all soles.
fn corners(soles: &[Sole]) -> impl Iterator<Item = &(usize, Vec3)> {
    soles.iter().flat_map(|s| &s.corners)
}

/// One foot in one frame; fields as in [`super::FootForces`].
#[derive(Clone, Debug)]
pub(super) struct FootNow {
    pub link: usize,
    pub contact: bool,
    pub height: f64,
    pub share: f64,
    pub force: Vec3,
    pub cop: Vec3,
    pub free_moment: f64,
}

/// Memory of [`FloorReaction::admissible`], and the feet it has loaded.
pub(super) struct Scratch {
    pub feet: Vec<FootNow>,
    touch: Vec<f64>,
    at: Vec<Vec3>,
    share: Vec<f64>,
}

impl Scratch {
    pub fn new(soles: &[Sole]) -> Self {
        let corners = corners(soles).count();
        let foot = |sole: &Sole| FootNow {
            link: sole.link,
            contact: false,
            height: f64::NAN,
            share: 0.0,
            force: Vec3::zeros(),
            cop: Vec3::repeat(f64::NAN),
            free_moment: 0.0,
        };
        Self {
            feet: soles.iter().map(foot).collect(),
            touch: vec![0.0; corners],
            at: vec![Vec3::zeros(); corners],
            share: vec![0.0; corners],
        }
    }

    /// The wrenches on the loaded feet.
    pub fn wrenches(&self) -> impl Iterator<Item = Wrench> + '_ {
        self.feet.iter().filter(|f| f.share > 0.0).map(|f| Wrench {
            link: f.link,
            point: f.cop,
            force: f.force,
            moment: Vec3::y() * f.free_moment,
        })
    }
}

/// The admissible reaction of the floor in one frame.
pub(super) struct Admissible {
    pub force: Vec3,
    pub moment_com: Vec3,
    /// Required centre of pressure, NaN without one.
    pub cop: Vec3,
    /// Whether nothing touches.
    pub flight: bool,
    /// |f_t|/(μ f_n) of the required force; infinite where it pulls, zero in flight.
    pub cone: f64,
    /// Distance of the required centre of pressure from the support, m.
    pub outside: f64,
}

/// What the floor under a clip can give. See the module header.
pub(super) struct FloorReaction {
    /// Level; `None` without one.
    pub floor: Option<Floor>,
    contact: Contact,
    /// Least vertical force that has a centre of pressure, N.
    least_load: f64,
}

impl FloorReaction {
    /// Finds the floor; `v` is `frames × nv`.
    pub fn new(
        model: &Model,
        state: &mut State,
        soles: &[Sole],
        clip: &Clip,
        v: &[f64],
        options: &AnalysisOptions,
    ) -> Self {
        let height = match options.ground {
            FloorChoice::None => None,
            FloorChoice::At(height) => Some(height),
            FloorChoice::Detect => detect(model, state, soles, clip, v, &options.contact),
        };
        let least_load = LEAST_LOAD * model.mass * options.gravity.norm();
        let floor = height.map(|height_m| Floor::level(height_m, options.friction));
        Self { floor, contact: options.contact, least_load }
    }

    /// The part of a required wrench that the floor can give, with `state` at the frame's pose and velocity; loads the feet
    /// of the scratch.
    ///
    /// * `com`: centre of mass, world, m
    /// * `force`: required of the ground, N
    /// * `moment_com`: required about the centre of mass, N·m
    #[allow(clippy::too_many_arguments)]
    pub fn admissible(
        &self,
        model: &Model,
        state: &State,
        soles: &[Sole],
        s: &mut Scratch,
        com: Vec3,
        force: Vec3,
        moment_com: Vec3,
    ) -> Admissible {
        let none = Vec3::zeros();
        let nowhere = Vec3::repeat(f64::NAN);
        let mut out =
            Admissible { force: none, moment_com: none, cop: nowhere, flight: true, cone: 0.0, outside: 0.0 };
        for foot in &mut s.feet {
            (foot.share, foot.force, foot.cop, foot.free_moment) = (0.0, none, nowhere, 0.0);
        }
        let Some(Floor { height_m: height, friction, .. }) = self.floor else { return out };
        self.touch(model, state, soles, s, height);
        out.flight = !s.feet.iter().any(|f| f.contact);
        if force.norm() <= LEAST_PULL * model.mass {
            return out; // the motion needs no force: neither pushed nor pulled
        }

        let normal = force.y;
        let wanted =
            if normal > self.least_load { pressure_center(com, force, moment_com, height) } else { nowhere };
        out.cop = wanted;
        if out.flight {
            return out;
        }
        let tangential = Vec3::new(force.x, 0.0, force.z);
        if normal <= 0.0 {
            out.cone = f64::INFINITY;
            return out;
        }
        out.cone = tangential.norm() / (friction * normal);
        let touching = s.touch.iter().zip(&s.at).filter(|(a, _)| **a > 0.0).map(|(_, p)| p);
        let support = Support::of(touching);
        // a force too small for a centre of pressure acts in the middle
        let aim = if wanted.x.is_nan() { support.centroid() } else { support.nearest(&plane(&wanted)) };
        let Some(aim) = aim else { return out };
        if !wanted.x.is_nan() {
            out.outside = (aim - plane(&wanted)).norm();
        }
        let center = pressures(&s.at, &s.touch, Vec3::new(aim.x, height, aim.y), &mut s.share);

        out.force = Vec3::y() * normal + tangential / out.cone.max(1.0);
        let spread: f64 = s.share.iter().zip(&s.at).map(|(w, p)| w * (p - center).norm()).sum();
        let slip = (friction * normal).powi(2) - out.force.x.powi(2) - out.force.z.powi(2);
        let most = spread * slip.max(0.0).sqrt();
        let arm = center - com;
        let about = moment_com - arm.cross(&out.force);
        let twist = about.y.clamp(-most, most);
        out.moment_com = arm.cross(&out.force) + Vec3::y() * twist;

        let mut first = 0;
        for (sole, foot) in soles.iter().zip(&mut s.feet) {
            let corners = first..first + sole.corners.len();
            first = corners.end;
            let share: f64 = s.share[corners.clone()].iter().sum();
            if share > 0.0 {
                let at: Vec3 = corners.map(|j| s.at[j] * s.share[j]).sum();
                foot.share = share;
                foot.force = out.force * share;
                foot.cop = at / share;
                foot.free_moment = twist * share;
            }
        }
        out
    }

    /// Places of the corners on the ground and their touch α.
    fn touch(&self, model: &Model, state: &State, soles: &[Sole], s: &mut Scratch, height: f64) {
        let mut j = 0;
        for (sole, foot) in soles.iter().zip(&mut s.feet) {
            foot.contact = false;
            foot.height = f64::INFINITY;
            for (link, at) in &sole.corners {
                let p = state.point(model, *link, at);
                let speed = (state.point_velocity(model, *link, at) - self.contact.ground_velocity).norm();
                let above = p.y - height;
                let touch = fade(above / self.contact.height_m) * fade(speed / self.contact.speed_m_s);
                s.touch[j] = if touch > LEAST_TOUCH { touch } else { 0.0 };
                s.at[j] = Vec3::new(p.x, height, p.z);
                foot.contact |= s.touch[j] > 0.0;
                foot.height = foot.height.min(above);
                j += 1;
            }
        }
    }
}

/// 1 up to ½, 0 from 1, a cubic between.
fn fade(x: f64) -> f64 {
    1.0 - smoothstep(2.0 * x - 1.0)
}

/// Point of the ground at which the wrench (`force`, `moment_com` about `com`) has no horizontal moment.
pub(crate) fn pressure_center(com: Vec3, force: Vec3, moment_com: Vec3, height: f64) -> Vec3 {
    // with d = com − c: moment + d × force has no x and no z
    let up = com.y - height;
    let dz = (moment_com.x + up * force.z) / force.y;
    let dx = (up * force.x - moment_com.z) / force.y;
    Vec3::new(com.x - dx, height, com.z - dz)
}

/// Pressures of touching corners with their centre at `aim` (in the hull of them): see the module header.
///
/// `at`: corners, m. `touch`: their α, at least one above zero. `share`: the pressures found, they sum to 1.
/// Returns the centre reached, equal to `aim` within about 1e-8 m.
///
/// The dual problem is solved by Newton's method: `w = α max(0, a·λ)` with `a = (1, x, z)`; it minimises
/// `½ Σ α max(0, a·λ)² − b·λ + ½ ε |λ|²`, whose gradient is the condition on Σ w and Σ w x.
pub fn pressures(at: &[Vec3], touch: &[f64], aim: Vec3, share: &mut [f64]) -> Vec3 {
    const SIZE: f64 = 0.1; // m: makes the three unknowns alike
    const EPSILON: f64 = 1e-9;
    let row = |p: &Vec3| Vec3::new(1.0, (p.x - aim.x) / SIZE, (p.z - aim.z) / SIZE);
    let target = Vec3::x();
    let value = |l: &Vec3| {
        let springs = at.iter().zip(touch).map(|(p, a)| a * row(p).dot(l).max(0.0).powi(2));
        0.5 * springs.sum::<f64>() - target.dot(l) + 0.5 * EPSILON * l.norm_squared()
    };
    let mut l = target / touch.iter().sum::<f64>();
    for _ in 0..60 {
        let mut gradient = l * EPSILON - target;
        let mut hessian = Matrix3::identity() * EPSILON;
        for (p, a) in at.iter().zip(touch) {
            let r = row(p);
            let x = r.dot(&l);
            if x > 0.0 {
                gradient += r * (a * x);
                hessian += r * r.transpose() * *a;
            }
        }
        if gradient.norm() < 1e-11 {
            break;
        }
        let Some(inverse) = hessian.cholesky() else { break };
        let step = inverse.solve(&gradient);
        let (now, slope) = (value(&l), gradient.dot(&step));
        let mut size = 1.0;
        while value(&(l - step * size)) > now - 1e-4 * size * slope && size > 1e-6 {
            size *= 0.5;
        }
        l -= step * size;
    }
    let mut sum = 0.0;
    for ((w, p), a) in share.iter_mut().zip(at).zip(touch) {
        *w = a * row(p).dot(&l).max(0.0);
        sum += *w;
    }
    let mut center = Vec3::zeros();
    for (w, p) in share.iter_mut().zip(at) {
        *w /= sum;
        center += p * *w;
    }
    center
}

/// Height of the ground on which a clip was captured, m, as [`super::analyze`] finds it; `None` without soles. Its speeds are
/// those of parabolas over a fifteenth of a second instead of a smoothed clip's.
pub fn height_under(character: &Character, clip: &Clip, contact: &Contact) -> Option<f64> {
    let model = Model::new(character, Vec3::zeros());
    let mut state = State::new(&model);
    let v = Derivatives::new(clip, 1.0 / 15.0).v;
    detect(&model, &mut state, &character.soles(), clip, &v, contact)
}

/// Height of the ground under a clip; see [`FloorChoice::Detect`]. `None` without corners.
fn detect(
    model: &Model,
    state: &mut State,
    soles: &[Sole],
    clip: &Clip,
    v: &[f64],
    contact: &Contact,
) -> Option<f64> {
    const FRAMES: usize = 1000;
    let step = clip.frames().div_ceil(FRAMES).max(1);
    let (mut slow, mut all) = (Vec::new(), f64::INFINITY);
    for k in (0..clip.frames()).step_by(step) {
        state.update(model, clip.pose(k), &v[k * model.nv()..(k + 1) * model.nv()]);
        let lowest = corners(soles)
            .map(|(link, at)| (state.point(model, *link, at).y, *link, *at))
            .min_by(|a, b| a.0.total_cmp(&b.0))?;
        all = all.min(lowest.0);
        let velocity = state.point_velocity(model, lowest.1, &lowest.2) - contact.ground_velocity;
        if velocity.norm() < contact.speed_m_s {
            slow.push(lowest.0);
        }
    }
    if slow.is_empty() {
        return Some(all);
    }
    let middle = slow.len() / 2;
    Some(*slow.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two soles 0.1 × 0.25 m, 0.3 m apart, at height 0.2.
    fn corners() -> Vec<Vec3> {
        let sole = [(0.0, 0.0), (0.1, 0.0), (0.1, 0.25), (0.0, 0.25)];
        let at = |x: f64| sole.map(|(dx, z)| Vec3::new(x + dx, 0.2, z));
        [at(-0.25), at(0.15)].concat()
    }

    /// Between equal feet side by side the load is shared nearly by distance: with all corners pressed, the
    /// right foot's share is ½ + c·x̄/(2σ²), x̄ = 0.2 m its middle, σ² = 0.0425 m² the corners' mean square.
    #[test]
    fn equal_feet_share_by_distance() {
        let at = corners();
        for c in [-0.16, -0.1, -0.03, 0.0, 0.05, 0.12, 0.16] {
            let aim = Vec3::new(c, 0.2, 0.125);
            let mut share = [0.0; 8];
            let center = pressures(&at, &[1.0; 8], aim, &mut share);
            let right: f64 = share[4..].iter().sum();
            assert!((center - aim).norm() < 1e-9, "{c}: {center}"); // 5e-12 seen
            let error = right - (0.5 + c * 0.1 / 0.0425);
            assert!(error.abs() < 1e-9, "{c}: {error}"); // 1e-11 seen
            assert!((right - (0.5 + c / 0.4)).abs() < 0.03, "{c}: {right}");
        }
        let mut share = [0.0; 8];
        pressures(&at, &[1.0; 8], Vec3::new(0.25, 0.2, 0.1), &mut share);
        assert!(share[..4].iter().sum::<f64>() < 1e-3); // all on the outer edge
    }

    /// Corners, edges and the inside of the hull: no corner pulls, the centre is reached, and each foot's own
    /// centre is in its sole.
    #[test]
    fn pressures_push_and_balance_everywhere() {
        let at = corners();
        let touch = [1.0, 0.7, 1.0, 0.02, 1.0, 1.0, 0.3, 1.0];
        let hull = Support::of(at.iter());
        for i in 0..400 {
            let f = f64::from(i);
            let wild = motion::support::Vec2::new((f * 0.7).sin() * 0.4, 0.125 + (f * 1.3).cos() * 0.3);
            let aim = hull.nearest(&wild).unwrap();
            let mut share = [0.0; 8];
            let center = pressures(&at, &touch, Vec3::new(aim.x, 0.2, aim.y), &mut share);
            assert!(share.iter().all(|w| *w >= 0.0));
            assert!((share.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let error = (plane(&center) - aim).norm();
            assert!(error < 1e-7, "{aim}: {error}"); // 5e-9 seen
        }
    }

    #[test]
    fn touch_fades_between_half_and_one() {
        assert_eq!((fade(-3.0), fade(0.5), fade(0.75), fade(1.0), fade(9.0)), (1.0, 1.0, 0.5, 0.0, 0.0));
    }

    /// Through the centre of pressure the wrench has a vertical moment only.
    #[test]
    fn no_horizontal_moment_at_the_center_of_pressure() {
        let (com, f, m) =
            (Vec3::new(0.1, 0.9, -0.2), Vec3::new(30.0, 700.0, -80.0), Vec3::new(12.0, -3.0, 25.0));
        let c = pressure_center(com, f, m, 0.05);
        let at_c = m + (com - c).cross(&f);
        assert!(at_c.x.abs() < 1e-12 && at_c.z.abs() < 1e-12, "{at_c}");
        assert_eq!(c.y, 0.05);
    }
}
