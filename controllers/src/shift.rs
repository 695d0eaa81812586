//! Weight shifts: the path of the centre of mass that a plan of contacts can carry, nearest to the one asked for.
//!
//! A path `c(t)` with the rate `L̇` of its angular momentum asks the ground for the force `F = m(c̈ − g)` at the pressure `p`
//! (`L̇ + (c − p) × F` has no horizontal part). A path moved by `x` asks for
//!
//! ```text
//! ρ (p' − p) = ρ x − (h/g) ẍ,      ρ = F_y / m g,  h = height of c over the ground
//! ```
//!
//! so what is wanted of the pressure, `b = ρ(p' − p)`, gives the path by the rows of [`crate::admissible`]. Of all paths with a
//! pressure inside the soles that stand (by [`MARGIN_M`]) this is the one whose pressure is moved least: the sets are
//! separate in time and the rows invertible, so the KKT conditions are that `p'` is the nearest point of its set.
//! Friction is `|c̈ + ẍ| ≤ μ F_y/m`: a disc for `b` about `ρ x + (h/g) c̈` with radius `μ ρ h`, found by repetition. In flight
//! ρ is zero, the disc is its centre, and the body is ballistic. Where soles and friction have no point in common, friction counts.
//!
//! *A foot takes load over [`LOADS_S`]* and gives it off before it leaves: the support is the convex hull of what soles with
//! shares up to their allowance can reach, so it changes without a jump where another foot stands.
//!
//! *Heights* come first: in flight `ÿ = −g − c̈_y`; on the ground the path goes back to the one asked for in [`SPRING_S`], and never
//! pulls. What legs cannot reach lowers it besides, within [`REACH_S`].
//!
//! In: a path, `L̇`, a [`Ground`]. Out: how far each frame moves. Linear in the number of frames. World frame, y up; m, s.

use std::ops::Range;

use dynamics::{Model, State};
use motion::support::{Support, Vec2, ground};
use motion::{Clip, ContactPlan, Derivatives, Kinematics, Sole, Vec3, smoothstep};

use crate::admissible::{Row, solve};

/// The centre of pressure wanted stays this far inside the soles, m; in narrower soles it is at the centroid.
pub const MARGIN_M: f64 = 0.01;
/// A foot that stands has its full share after this time, s, and gives it off in as much.
pub const LOADS_S: f64 = 0.1;
/// Time constant with which a height that gave way comes back, s.
pub const SPRING_S: f64 = 0.25;
/// Changes of the angular momentum faster than this are rounded off by muscles and soles, s.
pub const ROUNDED_S: f64 = 0.1;
/// Time constant of a height that gives way to legs, s.
pub const REACH_S: f64 = 0.08;
/// Repetitions of the disc of friction and of pulling heights.
const ROUNDS: usize = 12;

/// What the ground is in every frame: where soles stand, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Ground {
    /// What the soles that stand support, loads as they come and go; empty in flight.
    pub support: Vec<Support>,
    /// Hull of all soles that stand; empty in flight.
    pub hull: Vec<Support>,
    /// Frames without soles on the ground that are no flight all the same: something else bears the body.
    pub held: Vec<bool>,
    /// Its height, m.
    pub height_m: Vec<f64>,
    /// Coulomb friction coefficient.
    pub friction: f64,
}

impl Ground {
    /// The ground under `soles` that stand as `plan` says, each at its place, in a clip of so many `frames`. Contacts without
    /// a place, and of other points, bear nothing. `height_m`: where nothing stands.
    pub fn of(plan: &ContactPlan, soles: &[Sole], clip: &Clip, height_m: f64, friction: f64) -> Self {
        let (frames, rate_hz) = (clip.frames(), clip.rate_hz);
        let k = Kinematics::new(&clip.skeleton, clip.pose(0));
        let mut stands: Vec<Vec<Standing>> = vec![Vec::new(); frames];
        for contact in plan.contacts() {
            let Some(sole) = soles.iter().find(|s| s.name == contact.point) else { continue };
            let Some(place) = contact.world_from_point else { continue };
            let corners: Vec<Vec3> =
                sole.in_link(&k).iter().map(|c| place.transform_point(&(*c).into()).coords).collect();
            let span = contact.frames(rate_hz, frames);
            for f in span.clone() {
                let share = allowance(&span, f, rate_hz, frames);
                stands[f].push(Standing { share, corners: corners.clone() });
            }
        }
        let mut last = height_m;
        let mut out = Self {
            support: Vec::with_capacity(frames),
            hull: Vec::with_capacity(frames),
            held: vec![false; frames],
            height_m: Vec::with_capacity(frames),
            friction,
        };
        for frame in &mut stands {
            let all: Vec<Vec3> = frame.iter().flat_map(|s| s.corners.iter().copied()).collect();
            if !all.is_empty() {
                last = all.iter().map(|c| c.y).sum::<f64>() / all.len() as f64;
            }
            out.height_m.push(last);
            out.hull.push(Support::of(&all));
            out.support.push(reachable(frame));
        }
        out
    }

    /// Whether nothing bears the body in a frame.
    pub fn flies(&self, frame: usize) -> bool {
        self.hull[frame].is_empty() && !self.held[frame]
    }
}

/// The most of the load that a foot takes which stands in the frames `span` of so many, in one of them, 0 to 1: it takes it over
/// [`LOADS_S`], and gives it off before it leaves. One that the motion begins or ends in is loaded already.
pub fn allowance(span: &Range<usize>, frame: usize, rate_hz: f64, frames: usize) -> f64 {
    let ramp = LOADS_S * rate_hz;
    let since = if span.start == 0 { ramp } else { (frame - span.start) as f64 };
    let until = if span.end == frames { ramp } else { (span.end - 1 - frame) as f64 };
    smoothstep((since.min(until) + 0.5) / ramp.max(1.0))
}

#[derive(Clone)]
struct Standing {
    /// The most of the load that it takes, 0 to 1.
    share: f64,
    corners: Vec<Vec3>,
}

/// What soles can reach whose shares are bounded: of one, its hull; of more, of every two those with shares that sum to one. The
/// largest share counts as all.
fn reachable(stands: &mut [Standing]) -> Support {
    let most = stands.iter().map(|s| s.share).fold(0.0, f64::max);
    if most <= 0.0 {
        return Support::default();
    }
    stands.iter_mut().for_each(|s| s.share /= most);
    let mut points: Vec<Vec2> = Vec::new();
    for (i, a) in stands.iter().enumerate() {
        if a.share == 1.0 {
            points.extend(a.corners.iter().map(ground));
        }
        for b in stands[i + 1..].iter().filter(|b| a.share + b.share >= 1.0) {
            for (of_a, of_b) in [(a.share, 1.0 - a.share), (1.0 - b.share, b.share)] {
                let pairs = a.corners.iter().flat_map(|p| b.corners.iter().map(move |q| (p, q)));
                points.extend(pairs.map(|(p, q)| ground(p) * of_a + ground(q) * of_b));
            }
        }
    }
    Support::of_plane(points)
}

/// What a path asks of the ground in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// Force over mass, m/s²: `c̈ − g`.
    pub force: Vec3,
    /// Moment over mass about the point of the ground under the centre of mass, m²/s².
    pub moment: Vec3,
    /// Height of the centre of mass over the ground, m.
    pub height_m: f64,
    /// The point of the ground under the centre of mass.
    pub under: Vec2,
}

impl Asked {
    /// Centre of pressure; `None` where the ground would have to pull or bears less than 5 % of `g` (m/s²): its place is not known there.
    pub fn pressure(&self, g: f64) -> Option<Vec2> {
        let up = self.force.y;
        (up > 0.05 * g).then(|| self.under + Vec2::new(self.moment.z, -self.moment.x) / up)
    }
}

/// What the path `com` with the rates `spin` of its angular momentum (N·m) asks of the ground. Accelerations are second
/// differences; at the ends those beside.
pub fn asked(model: &Model, com: &[Vec3], spin: &[Vec3], rate_hz: f64, ground: &Ground) -> Vec<Asked> {
    let n = com.len();
    let bend = |f: usize| {
        let f = f.clamp(1, n.max(3) - 2);
        if n < 3 { Vec3::zeros() } else { (com[f - 1] + com[f + 1] - com[f] * 2.0) * rate_hz * rate_hz }
    };
    (0..n)
        .map(|f| {
            let force = bend(f) - model.gravity;
            let height_m = com[f].y - ground.height_m[f];
            let moment = spin[f] / model.mass + (Vec3::y() * height_m).cross(&force);
            Asked { force, moment, height_m, under: motion::support::ground(&com[f]) }
        })
        .collect()
}

/// Centre of mass of every frame, m, and the rate of the angular momentum about it, N·m, over [`ROUNDED_S`].
pub fn com_and_spin(model: &Model, clip: &Clip) -> (Vec<Vec3>, Vec<Vec3>) {
    let d = Derivatives::new(clip, ROUNDED_S);
    let nv = model.nv();
    let mut state = State::new(model);
    (0..clip.frames())
        .map(|f| {
            let (v, vd) = (&d.v[f * nv..(f + 1) * nv], &d.vd[f * nv..(f + 1) * nv]);
            state.update(model, clip.pose(f), v);
            let rate = state.momentum_rate(model, v, vd);
            (rate.com, rate.angular)
        })
        .unzip()
}

/// The nearest point to `p` that is [`MARGIN_M`] inside, by a support shrunk to its centroid.
pub fn inside(support: &Support, p: Vec2) -> Vec2 {
    let Some(center) = support.centroid() else { return p };
    let room = support.margin(&center);
    if room <= MARGIN_M {
        // an edge: its nearest point but for the ends
        return if room > 0.0 { center } else { support.nearest(&p).unwrap_or(p) };
    }
    let scale = 1.0 - MARGIN_M / room;
    let shrunk: Vec<Vec2> = support.corners().iter().map(|c| center + (c - center) * scale).collect();
    Support::of_plane(shrunk).nearest(&p).unwrap_or(p)
}

/// How far heights move: `reach[f]` (m, ≤ 0) is what legs want. See the module header.
pub fn heights(com: &[Vec3], reach: &[f64], gravity: f64, rate_hz: f64, ground: &Ground) -> Vec<f64> {
    let n = com.len();
    let a = (SPRING_S * rate_hz).powi(2);
    let rise = |f: usize| {
        if f == 0 || f + 1 >= n { 0.0 } else { (com[f - 1].y + com[f + 1].y - 2.0 * com[f].y) * a }
    };
    let fall = gravity * SPRING_S * SPRING_S;
    let mut y = vec![Vec2::zeros(); n];
    for _ in 0..ROUNDS {
        let row = |f: usize| {
            let free = rise(f) + fall;
            let (hold, b) = if ground.flies(f) { (0.0, free) } else { (1.0, (y[f].x + free).min(0.0)) };
            Row { hold, a, b: Vec2::new(b, 0.0) }
        };
        let rows: Vec<Row> = (0..n).map(row).collect();
        y = solve(&rows);
    }
    // what legs want comes and goes by itself
    let row = |f: usize| {
        let (hold, b) = if ground.flies(f) { (0.0, 0.0) } else { (1.0, reach[f]) };
        Row { hold, a: (REACH_S * rate_hz).powi(2), b: Vec2::new(b, 0.0) }
    };
    let rows: Vec<Row> = (0..n).map(row).collect();
    y.iter().zip(solve(&rows)).map(|(y, r)| y.x + r.x).collect()
}

/// How far the path moves over the ground in every frame, m. See the module header.
pub fn path(asked: &[Asked], gravity: f64, rate_hz: f64, ground: &Ground) -> Vec<Vec2> {
    let n = asked.len();
    let mut x = vec![Vec2::zeros(); n];
    let wanted: Vec<(f64, f64, Vec2, Vec2)> = asked
        .iter()
        .enumerate()
        .map(|(f, of)| {
            let hold = if ground.flies(f) { 0.0 } else { (of.force.y / gravity).max(0.0) };
            let arm = of.height_m.max(0.2) / gravity;
            let moved = match of.pressure(gravity) {
                Some(p) if hold > 0.0 => (inside(&ground.support[f], p) - p) * hold,
                _ => Vec2::zeros(),
            };
            let thrown = Vec2::new(of.force.x, of.force.z) * arm;
            (hold, arm, moved, thrown)
        })
        .collect();
    for _ in 0..ROUNDS {
        let mut bound = false;
        let rows: Vec<Row> = wanted
            .iter()
            .zip(&x)
            .enumerate()
            .map(|(f, (&(hold, arm, moved, thrown), x))| {
                let center = x * hold + thrown;
                let radius = ground.friction * hold * arm * gravity;
                let off = moved - center;
                let free = ground.held[f];
                let b =
                    if off.norm() > radius && !free { center + off * (radius / off.norm()) } else { moved };
                bound |= hold > 0.0 && b != moved;
                Row { hold, a: arm * rate_hz * rate_hz, b }
            })
            .collect();
        x = solve(&rows);
        if !bound {
            break;
        }
    }
    x
}
