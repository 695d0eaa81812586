//! Physics refinement \[YAH10, §5.3\]: a small smooth displacement that makes a motion explainable by its contacts.
//!
//! In: a clip whose contacts hold, its phases, the variance of the mapping in every frame. Out: the clip moved by
//! Gaussian radial basis functions of the chosen degrees of freedom, whose weights minimise
//!
//! ```text
//! Z = ½ wᵀw + k₁ (Z_p + κ Z_c) + k₂ Z_m + slip + limits + collisions                                (11)
//! Z_p = ½ Σ_frames |F − F̂|² + |N − N̂|²/ℓ²                                                          (12)
//! Z_c = ½ Σ_frames in contact max(0, |F_xz| − μ' F_y)²
//! Z_m = ½ Σ_frames dt/τ · mean_points |p − p₀|²/σ²                                                 (15)
//! ```
//!
//! - *Z_p*: see [`physics`]. Forces count as those of a body of [`REFERENCE_KG`], so that k₁ means the same for a lamp
//!   and a man; ℓ is the radius of gyration about X in the rest pose. Where only the root's height moves, what is not the
//!   vertical force counts 0.6 of a newton each: of a body whose weight is not over its feet the moment can then only be
//!   lowered by carrying half of its weight, which is what the least sum of squares does.
//! - *Z_c*: the required force outside the cone of μ' = [`CONE_SHARE`] μ. Z_p alone says little about the cone: the
//!   mismatch of a force that is far outside is nearly the same with and without its vertical part, and where a flight is made
//!   steeper the vertical force beside it falls before the horizontal force does.
//! - *Z_m*: the mapping's variance σ² (never below [`LEAST_DEVIATION_M`]²) about the pose that is refined, not about
//!   the mapping's mean, which would pull the feet away from where contact adjustment has put them. \[YAH10\] sums over
//!   frames and points as if they erred independently. A body that is mapped too low has all its points too low, for
//!   as long as the pose lasts: the points count as one here, and so do the frames of τ = [`INDEPENDENT_S`], whatever
//!   the frame rate. (Summed as printed, Z_m holds a jump at the height it was mapped to; the flight cannot become one.)
//!   Unsure frames move more, also to get out of a collision.
//! - *Slip* of points in a phase from their place, half a cost at [`SLIP_M`]; *limits* of joints; *collisions* of
//!   the body with itself, the ground and the scene ([`solids`]); in *flights* the root's way up or down, half a cost at
//!   [`FLIGHT_SHARE`] of their height: a hop that no key pose made ballistic has least mismatch on the ground.
//!
//! All sums over frames count as those of [`REFERENCE_HZ`]: the motion that costs least is the same at any rate.
//!
//! *Solution.* Levenberg–Marquardt (`descent`). Two functions act together only within 16 spacings, and hardly beyond 12: with
//! the unknowns in the order of time the normal equations are banded; long clips are solved a stretch at a time (`windows`), so
//! that cost grows linearly with length. Rates and accelerations of the displaced clip are central differences, as anyone who
//! reads the clip will take them.
//!
//! *Collisions first.* Where bodies penetrate, the joints between the two are moved by a pass of its own ([`apart`]), without
//! forces. The refinement itself moves what it is asked to move and nothing else.
//!
//! \[YAH10\] Yamane, Ariki, Hodgins. Animating Non-Humanoid Characters with Human Motion Data, SCA 2010.

pub mod band;
pub mod basis;
mod descent;
mod local;
pub mod physics;
mod problem;
pub mod solids;
mod windows;

use std::ops::Range;

use bodies::Character;
use dynamics::{Model, Penalty, State};
use motion::names::hint;
use motion::{Clip, Joint, Kinematics, Vec3};

use crate::contacts::{phases, point_paths, report as contact_report};
use crate::options::{RefineDofs, RefineOptions, WorldOptions};
use crate::phase::{Phase, PhaseFrames};
use crate::result::RefinementReport;
use crate::{Puppet, RetargetError};
use physics::{Forces, Physics};
use problem::Setting;
use solids::Solids;

/// Mass as whose forces a mismatch counts, kg.
pub const REFERENCE_KG: f64 = 75.0;
/// Least standard deviation of a feature point, m.
pub const LEAST_DEVIATION_M: f64 = 0.01;
/// Time over which the mapping errs in the same way, τ, s.
pub const INDEPENDENT_S: f64 = 0.5;
/// Frame rate as whose frames all count, Hz: the paper's.
pub const REFERENCE_HZ: f64 = 30.0;
/// Way up or down in a flight that costs one half, over the flight's height.
pub const FLIGHT_SHARE: f64 = 0.1;
/// Slip that costs one half, m.
pub const SLIP_M: f64 = 0.001;
/// Share of the friction cone that is aimed at.
pub const CONE_SHARE: f64 = 0.9;
/// Stiffness of an anchor over that of [`Penalty::for_body`], whose friction is used up only after 3 mm of slip.
const GRIP: f64 = 4.0;
/// Share of the damping of [`Penalty::for_body`] that is kept. Nothing is simulated here, so that damping is not needed for
/// stability, and the force of the damper on a heel that lands at 0.1 m/s is none that the motion requires.
const DAMPING: f64 = 0.1;
/// Spacing of the basis functions of the pass against collisions, s: an arm goes round a hip, it does not jump.
const COLLISION_SPACING_S: f64 = 0.25;
/// Most steps of that pass.
const COLLISION_STEPS: usize = 6;
/// Penetrations below this are none, m.
const TOUCH_M: f64 = 0.001;

/// Refines a clip. See the module header.
///
/// * `variance`: of a coordinate of a feature point in every frame, m²
/// * `world`: gravity, friction of the ground, solids
///
/// # Errors
/// Phases that do not fit, links that do not exist, options outside their range.
pub fn refine(
    puppet: &Puppet,
    clip: &Clip,
    found: &[Phase],
    variance: &[f64],
    world: &WorldOptions,
    options: &RefineOptions,
) -> Result<(Clip, RefinementReport), RetargetError> {
    refine_with(puppet, clip, found, variance, world, options, &|_| {})
}

/// As [`refine`], with something done to the clip before it is judged.
pub(crate) fn refine_with(
    puppet: &Puppet,
    clip: &Clip,
    found: &[Phase],
    variance: &[f64],
    world: &WorldOptions,
    options: &RefineOptions,
    finish: &dyn Fn(&mut Clip),
) -> Result<(Clip, RefinementReport), RetargetError> {
    world.check()?;
    check(options)?;
    let prepared = Prepared::new(puppet, clip, found, world, options)?;
    let Prepared { spans, source, anchors, penalty, length_m, solids, .. } = &prepared;
    let (penalty, length_m) = (*penalty, *length_m);
    let setting = Setting { variance, ..prepared.setting(puppet, world, options) };
    let c = &puppet.character;
    let mut out = clip.clone();
    let before_m = collisions(solids, clip).0;
    // the root moves all links alike: it cannot end a penetration of one link by another
    let alone = matches!(options.dofs, RefineDofs::RootHeight | RefineDofs::Root);
    let setting = Setting { solids: setting.solids.filter(|_| !alone), ..setting };
    let dofs = refined_dofs(puppet, &options.dofs, spans)?;
    let iterations = windows::solve(setting, &mut out, &dofs, true, &|_| dofs.clone())?;
    finish(&mut out);

    let mut physics = Physics::new(puppet, penalty, Vec3::y() * -world.gravity_m_s2);
    let (before, after) = (forces(&mut physics, clip, anchors), forces(&mut physics, &out, anchors));
    let moved: Vec<f64> =
        (0..clip.frames()).map(|i| root_displacement(puppet, clip.pose(i), out.pose(i))).collect();
    let mut sorted = moved.clone();
    sorted.sort_by(f64::total_cmp);
    let held = contact_report(source, &point_paths(puppet, &out), spans, clip.rate_hz);
    let weight_n = c.mass() * world.gravity_m_s2;
    let cone = |f: &[Forces]| outside_cone(f, anchors, world.friction, weight_n);
    let report = RefinementReport {
        before: mismatch(&before, length_m),
        after: mismatch(&after, length_m),
        length_m,
        weight_n,
        root_median_m: sorted[sorted.len() / 2],
        root_largest_m: sorted[sorted.len() - 1],
        slip_m: held.slip_m,
        cone_before: cone(&before),
        cone_after: cone(&after),
        collision_m: [before_m, collisions(solids, &out).0],
        iterations,
        required_before: before.iter().map(|f| f.required).collect(),
        contact_before: before.iter().map(|f| f.given).collect(),
        required_after: after.iter().map(|f| f.required).collect(),
        contact_after: after.iter().map(|f| f.given).collect(),
    };
    Ok((out, report))
}

/// Turns joints between links that are in one another, and between the body and solids of the scene, until they are apart or as far as
/// it goes in a few steps; contact points stay. Nothing else moves.
///
/// # Errors
/// As [`refine`].
pub fn apart(
    puppet: &Puppet,
    clip: &Clip,
    found: &[Phase],
    variance: &[f64],
    world: &WorldOptions,
    options: &RefineOptions,
) -> Result<Clip, RetargetError> {
    world.check()?;
    check(options)?;
    let mut out = clip.clone();
    let wide = RefineOptions {
        spacing_s: COLLISION_SPACING_S,
        iterations: options.iterations.min(COLLISION_STEPS),
        ..options.clone()
    };
    let prepared = Prepared::new(puppet, clip, found, world, &wide)?;
    let (deepest, touching) = collisions(&prepared.solids, clip);
    if !options.collisions || deepest <= TOUCH_M {
        return Ok(out);
    }
    let between = |s: Range<usize>| joints_between(puppet, s.flat_map(|i| &touching[i]));
    let dofs = between(0..clip.frames());
    if !dofs.is_empty() {
        let setting = Setting { variance, ..prepared.setting(puppet, world, &wide) };
        // only what moves in the whole clip: a stretch in which only legs touch moves no leg if arms touch elsewhere
        let moving = |s: Range<usize>| between(s).into_iter().filter(|d| dofs.contains(d)).collect();
        windows::solve(setting, &mut out, &dofs, false, &|s| moving(s.counted.clone()))?;
    }
    Ok(out)
}

/// What a clip brings to a problem.
struct Prepared {
    spans: Vec<Vec<PhaseFrames>>,
    source: Vec<Vec<Vec3>>,
    anchors: Vec<Vec<Option<[f64; 2]>>>,
    /// Weight of the root's squared way up or down in every frame, 1/m²; 0 outside flights.
    aloft: Vec<f64>,
    penalty: Penalty,
    length_m: f64,
    solids: Solids,
}

impl Prepared {
    fn new(
        puppet: &Puppet,
        clip: &Clip,
        found: &[Phase],
        world: &WorldOptions,
        options: &RefineOptions,
    ) -> Result<Self, RetargetError> {
        let spans = phases::frames_of_phases(puppet, found, clip)?;
        let source = point_paths(puppet, clip);
        let anchors = anchors(&source, &spans, clip.frames());
        let mass = puppet.character.mass();
        let mut penalty =
            Penalty::for_body(mass, world.gravity_m_s2, mean_contacts(&anchors), options.sink_m)?;
        penalty.mu = world.friction;
        penalty.k_d *= DAMPING;
        penalty.k_tp *= GRIP;
        let mut aloft = vec![0.0; clip.frames()];
        for f in options.flights.iter().filter(|f| f.height_m > 0.0) {
            let frame = |t: f64| (t * clip.rate_hz).round().max(0.0) as usize;
            let weight = (FLIGHT_SHARE * f.height_m).powi(-2);
            let inside = aloft.iter_mut().take(frame(f.to_s) + 1).skip(frame(f.from_s));
            inside.for_each(|w| *w = weight);
        }
        let solids = Solids::new(puppet, &world.obstacles, &options.accepted);
        Ok(Self { spans, source, anchors, aloft, penalty, length_m: gyration(puppet), solids })
    }

    /// The setting, without the mapping's variance.
    fn setting<'a>(
        &'a self,
        puppet: &'a Puppet,
        world: &'a WorldOptions,
        options: &'a RefineOptions,
    ) -> Setting<'a> {
        Setting {
            puppet,
            anchors: &self.anchors,
            variance: &[],
            aloft: &self.aloft,
            world,
            options,
            solids: options.collisions.then_some(&self.solids),
            length_m: self.length_m,
            penalty: self.penalty,
        }
    }
}

/// Links that carry at least half of the mass that is not the root's: what moves the body of one that stands on its root.
fn links_of_most_mass(c: &Character) -> Vec<usize> {
    let s = &c.skeleton;
    let mut carried: Vec<f64> = c.bodies.iter().map(|b| b.mass).collect();
    for i in (1..carried.len()).rev() {
        if let Some(p) = s.links()[i].parent {
            carried[p] += carried[i];
        }
    }
    let whole = carried[0] - c.bodies[0].mass;
    (1..carried.len()).filter(|&l| carried[l] >= 0.5 * whole && s.links()[l].joint.nv() > 0).collect()
}

fn check(o: &RefineOptions) -> Result<(), RetargetError> {
    let positive = |name: &'static str, value: f64| {
        let allowed = "positive numbers";
        if value > 0.0 && value.is_finite() {
            Ok(())
        } else {
            Err(RetargetError::Option { name, value, allowed })
        }
    };
    positive("the spacing of the basis functions (s)", o.spacing_s)?;
    positive("k1", o.k1)?;
    positive("k2", o.k2)?;
    if let Some(value) = o.cone.filter(|c| !(*c >= 0.0 && c.is_finite())) {
        let (name, allowed) = ("the weight of the friction cone", "0 and positive numbers");
        return Err(RetargetError::Option { name, value, allowed });
    }
    Ok(())
}

/// Where the points are anchored, per frame: their own place at the middle of the phase.
fn anchors(paths: &[Vec<Vec3>], spans: &[Vec<PhaseFrames>], frames: usize) -> Vec<Vec<Option<[f64; 2]>>> {
    let mut out = vec![vec![None; paths.len()]; frames];
    for (c, (path, spans)) in paths.iter().zip(spans).enumerate() {
        for s in spans {
            let mean = path[s.first..=s.last].iter().sum::<Vec3>() / (s.last - s.first + 1) as f64;
            (s.first..=s.last).for_each(|i| out[i][c] = Some([mean.x, mean.z]));
        }
    }
    out
}

/// Points that share the weight: the mean number of those in contact, over the frames that have any.
fn mean_contacts(anchors: &[Vec<Option<[f64; 2]>>]) -> usize {
    let counts: Vec<usize> = anchors.iter().map(|a| a.iter().flatten().count()).filter(|&n| n > 0).collect();
    ((counts.iter().sum::<usize>() as f64 / counts.len().max(1) as f64).round() as usize).max(1)
}

/// Radius of gyration about X in the rest pose, m.
fn gyration(puppet: &Puppet) -> f64 {
    let c = &puppet.character;
    let model = Model::new(c, Vec3::zeros());
    let mut state = State::new(&model);
    state.update_pose(&model, &c.rest);
    let (mass, _, inertia) = state.composites(&model)[0];
    (inertia[(0, 0)] / mass).sqrt()
}

/// Forces of every frame by central differences.
fn forces(physics: &mut Physics, clip: &Clip, anchors: &[Vec<Option<[f64; 2]>>]) -> Vec<Forces> {
    let d = motion::Derivatives::central(clip);
    let nv = clip.skeleton.nv();
    (0..clip.frames())
        .map(|i| {
            let at = i * nv..(i + 1) * nv;
            physics.forces(clip.pose(i), &d.v[at.clone()], &d.vd[at], &anchors[i])
        })
        .collect()
}

/// Z_p by component, N².
fn mismatch(forces: &[Forces], length_m: f64) -> [f64; 6] {
    let mut out = [0.0; 6];
    for f in forces {
        for i in 0..6 {
            let r = if i < 3 { f.residual[i] } else { f.residual[i] / length_m };
            out[i] += 0.5 * r * r;
        }
    }
    out
}

/// Share of the weight by which a force may miss the cone before it counts.
const CONE_SLACK: f64 = 0.01;

/// Frames with a point in contact whose required force is outside the friction cone.
fn outside_cone(f: &[Forces], anchors: &[Vec<Option<[f64; 2]>>], mu: f64, weight: f64) -> Vec<usize> {
    let outside =
        |f: &Forces| f.required.x.hypot(f.required.z) > mu * f.required.y.max(0.0) + CONE_SLACK * weight;
    let touching = |i: &usize| anchors[*i].iter().any(Option::is_some);
    (0..f.len()).filter(touching).filter(|&i| outside(&f[i])).collect()
}

fn root_displacement(puppet: &Puppet, a: &[f64], b: &[f64]) -> f64 {
    let s = &puppet.character.skeleton;
    (s.position(a, 0) - s.position(b, 0)).norm()
}

/// A link, and the other one; `None` is the scene.
type Pair = (usize, Option<usize>);

/// Deepest penetration of a clip, m, and in every frame the pairs of links that penetrate at all.
fn collisions(solids: &Solids, clip: &Clip) -> (f64, Vec<Vec<Pair>>) {
    let (mut deepest, mut all) = (0.0f64, Vec::new());
    let mut k = Kinematics::new(&clip.skeleton, &clip.skeleton.zero_pose());
    let mut found = Vec::new();
    for i in 0..clip.frames() {
        k.update(&clip.skeleton, clip.pose(i));
        found.clear();
        solids.penetrations(&k, &mut found);
        let mut pairs = Vec::new();
        for t in found.iter().filter(|t| t.depth_m > TOUCH_M) {
            deepest = deepest.max(t.depth_m);
            let pair = (t.first.0, t.second.map(|s| s.0));
            if !pairs.contains(&pair) {
                pairs.push(pair);
            }
        }
        all.push(pairs);
    }
    (deepest, all)
}

/// Degrees of freedom between two links of each pair, or between a link and the root.
fn joints_between<'p>(puppet: &Puppet, pairs: impl Iterator<Item = &'p Pair>) -> Vec<usize> {
    let s = &puppet.character.skeleton;
    let chain = |link: usize| -> Vec<usize> { s.ancestors(link).collect() };
    let mut links: Vec<usize> = Vec::new();
    let mut seen = Vec::new();
    for &(a, b) in pairs {
        if seen.contains(&(a, b)) {
            continue;
        }
        seen.push((a, b));
        let (a, b) = (chain(a), b.map(chain).unwrap_or_default());
        links.extend(a.iter().filter(|l| !b.contains(l)));
        links.extend(b.iter().filter(|l| !a.contains(l)));
    }
    links.retain(|&l| l != 0);
    links.sort_unstable();
    links.dedup();
    // where joints of the arms can end the penetration, those that carry contact points do not move
    let stands =
        |l: &usize| puppet.contacts.iter().any(|c| s.ancestors(s.sites()[c.site].link).any(|u| u == *l));
    if links.iter().any(|l| !stands(l)) {
        links.retain(|l| !stands(l));
    }
    links.iter().flat_map(|&l| s.v_at(l)..s.v_at(l) + s.links()[l].joint.nv()).collect()
}

/// Degrees of freedom that the physics may move.
///
/// * `spans`: contact phases of each point
fn refined_dofs(
    puppet: &Puppet,
    dofs: &RefineDofs,
    spans: &[Vec<PhaseFrames>],
) -> Result<Vec<usize>, RetargetError> {
    let c = &puppet.character;
    let s = &c.skeleton;
    if s.links()[0].joint != Joint::Free {
        let (character, link) = (c.name.clone(), s.links()[0].name.clone());
        return Err(RetargetError::Root { character, link });
    }
    // along Y of the root's zero frame: up, unless a file turned that frame
    let up = s.links()[0].parent_from_zero.rotation.inverse() * Vec3::y();
    let height = up.iamax();
    let of_link = |l: usize| s.v_at(l)..s.v_at(l) + s.links()[l].joint.nv();
    let mut out: Vec<usize> = match dofs {
        RefineDofs::RootHeight => vec![height],
        RefineDofs::Root => (0..6).collect(),
        RefineDofs::RootAndLegs => {
            let standing = puppet.contacts.iter().zip(spans).filter(|(_, spans)| !spans.is_empty());
            let mut links: Vec<usize> =
                standing.flat_map(|(p, _)| s.ancestors(s.sites()[p.site].link)).filter(|&l| l != 0).collect();
            if links.is_empty() {
                links = links_of_most_mass(c);
            }
            (0..6).chain(links.into_iter().flat_map(of_link)).collect()
        }
        RefineDofs::Links(names) => {
            let mut all = vec![height];
            for name in names {
                let known = s.links().iter().map(|l| l.name.as_str());
                let fault = || RetargetError::RefineLink { name: name.clone(), hint: hint(name, known) };
                all.extend(of_link(s.link(name).ok_or_else(fault)?));
            }
            all
        }
    };
    out.sort_unstable();
    out.dedup();
    Ok(out)
}
