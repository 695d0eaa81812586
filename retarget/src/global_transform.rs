//! Global transform: where a body in place has to go so that its momentum is the performer's, scaled.
//!
//! In: the human clip in the world, the character's clip in its local frame (no place, no heading). Out: the
//! character's clip in the world, and both momenta. Height, roll and pitch are in the poses and stay.
//!
//! # Equations
//!
//! The printed (6)–(8) of \[YAH10\] drop the mass in ω × p and the coupling of the two; about the local origin,
//! `[ΔP; ΔL_o] = [[m E, −m [p×]], [m [p×], I_o]] [v; ω]` is exact. Solved about a body's *own centre of mass* G
//! it falls apart in two: with the horizontal place and the yaw free,
//!
//! ```text
//! ω_y = (s_i L_h − L_c)_G,y / I_G,yy        v = ΔP/m − ω × p
//! ```
//!
//! (About the projection of the root a straight walk would turn a rigid character by tens of degrees.) The
//! second says that the centre of mass moves at the scaled velocity of the human one, so the path of the
//! centre of mass is integrated and the local frame put where it belongs: the linear momentum of the sampled clip is
//! matched to rounding, whatever the yaw is, and nothing accumulates.
//!
//! *Yaw drift.* ω_y is a quotient of small numbers; integrated, its error grows. Below
//! [`GlobalOptions::drift_hz`] the heading follows the human's, above it the momentum:
//! `ψ = ∫ω − S(∫ω − ψ_h)` with the zero-phase smoother S of [`motion::smooth::whittaker`].
//!
//! *Pace.* A slender body has little inertia about the vertical, and where its momentum is to be a whole human's it would spin. Against the
//! same clip with the human's heading its speeds are held to [`Bounds::GLOBAL`](crate::Bounds::GLOBAL): where they would be beyond,
//! the heading goes over to the human's and the linear momentum stays what it is ([`GlobalPath`]).
//!
//! *Path.* Scaling by one ratio gives the human's path, smaller; with a ratio for each axis, those are the
//! axes of the human's low-frequency heading, and the path is the integral of the scaled velocity.
//!
//! *Ratios* as in the paper: of masses; of the diagonal inertias, about the centre of mass in the rest
//! poses; of the mean speed of the feature points when every rotation turns at unit rate, one by one, along
//! each axis of the local frame in the rest poses.
//!
//! Symbols: h human, c character; momenta between frames i and i + 1, at the pose halfway, rates by quaternion
//! logarithm.
//!
//! \[YAH10\] Yamane, Ariki, Hodgins. Animating Non-Humanoid Characters with Human Motion Data, SCA 2010, §5.1.

use bodies::Character;
use dynamics::{Model, State};
use motion::smooth::whittaker::{Whittaker, lambda};
use motion::{Clip, Joint, Kinematics, Quat, Transform, Vec3};
use nalgebra::Matrix3;

use crate::features::{Features, RootFrame};
use crate::fit::place_root;
use crate::options::{GlobalOptions, SizeRatio};
use crate::result::MomentumReport;
use crate::{Performer, Puppet};
use motion::ik::JointAxes;

/// Ratios by which a human momentum becomes the character's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Of the masses.
    pub mass: f64,
    /// Of lengths along X (width), Y (height), Z (depth) of the local frame.
    pub size: Vec3,
    /// Of the moments of inertia about X, Y, Z.
    pub inertia: Vec3,
}

impl Scale {
    /// The ratios of two bodies. See the module header.
    pub fn new(performer: &Performer, puppet: &Puppet, size: SizeRatio) -> Self {
        let (human, own) = (&performer.character, &*puppet.character);
        let speed = |c: &Character, f: &Features| mean_speed(c, f);
        let ratio = |a: Vec3, b: Vec3| a.component_div(&b.map(|x| x.max(1e-9)));
        let per_axis = ratio(speed(own, &puppet.features), speed(human, &performer.features));
        let size = match size {
            SizeRatio::Stride => {
                let most = stride(own, human);
                Vec3::new(per_axis.x.min(most), per_axis.y, per_axis.z.min(most))
            }
            SizeRatio::PerAxis => per_axis,
            SizeRatio::Uniform => {
                let both = 0.5 * (per_axis.x + per_axis.z);
                Vec3::new(both, per_axis.y, both)
            }
            SizeRatio::Fixed(s) => Vec3::repeat(s),
        };
        let inertia = ratio(rest_inertia(own, &puppet.features), rest_inertia(human, &performer.features));
        Self { mass: own.mass() / human.mass(), size, inertia }
    }

    /// A human velocity (world, horizontal part) scaled along the axes of a heading.
    pub fn velocity(&self, heading: f64, v: &Vec3) -> Vec3 {
        let turn = Quat::from_axis_angle(&Vec3::y_axis(), heading);
        turn * (turn.inverse() * v).component_mul(&self.size)
    }
}

/// How much farther one body steps than another: legs, or heights at rest.
fn stride(own: &Character, human: &Character) -> f64 {
    match (leg(own), leg(human)) {
        (Some(a), Some(b)) => a / b,
        _ => stature(own) / stature(human).max(1e-9),
    }
}

/// Mean length of the legs, hip to ankle, m.
fn leg(c: &Character) -> Option<f64> {
    let length = |link: usize| c.skeleton.links()[link].parent_from_zero.translation.vector.norm();
    let legs: Vec<f64> = c.legs().map(|l| length(l.lower) + length(l.end)).collect();
    (!legs.is_empty()).then(|| legs.iter().sum::<f64>() / legs.len() as f64)
}

/// Height of the highest joint, site or end of a link above the lowest contact point at rest, m.
pub(crate) fn stature(c: &Character) -> f64 {
    let (s, k) = (&c.skeleton, Kinematics::new(&c.skeleton, &c.rest));
    let sites = c.contacts.iter().map(|&i| &s.sites()[i]);
    let lowest = sites.map(|s| k.point(s.link, &s.at).y).reduce(f64::min);
    let links = s.links().iter().enumerate();
    let ends = links.flat_map(|(i, l)| [Some(k.origin(i)), l.end.map(|e| k.point(i, &e))]);
    let points = ends.flatten().chain(s.sites().iter().map(|s| k.point(s.link, &s.at)));
    points.map(|p| p.y).fold(f64::NEG_INFINITY, f64::max) - lowest.unwrap_or(0.0)
}

/// The rest pose in the local frame.
fn local_rest(c: &Character, features: &Features) -> Vec<f64> {
    let mut q = c.rest.clone();
    place_root(&c.skeleton, &mut q, |w| features.root.local(w, 0.0).inverse() * w);
    q
}

/// Mean speed of the feature points along each axis at unit rate of every rotation, m/s.
fn mean_speed(c: &Character, features: &Features) -> Vec3 {
    let k = Kinematics::new(&c.skeleton, &local_rest(c, features));
    let mut axes = JointAxes::new(&c.skeleton);
    axes.update(&c.skeleton, &k);
    let mut sum = Vec3::zeros();
    let turning = axes.all.iter().filter(|a| a.angular != Vec3::zeros()).count();
    for p in &features.points {
        let at = k.point(p.link, &p.at);
        for &d in axes.chain[p.link].iter().filter(|&&d| axes.all[d].angular != Vec3::zeros()) {
            sum += axes.all[d].column(&at).abs();
        }
    }
    sum / (features.points.len() * turning).max(1) as f64
}

/// Diagonal of the inertia about the centre of mass in the rest pose, local axes, kg·m².
fn rest_inertia(c: &Character, features: &Features) -> Vec3 {
    let model = Model::new(c, Vec3::zeros());
    let mut state = State::new(&model);
    state.update_pose(&model, &local_rest(c, features));
    state.composites(&model)[0].2.diagonal()
}

/// Momentum of a clip between its frames.
#[derive(Clone, Debug, PartialEq)]
pub struct MomentumPath {
    /// Centre of mass in every frame, world, m.
    pub com: Vec<Vec3>,
    /// Angular momentum about the centre of mass between frames, N·m·s; one fewer than frames.
    pub spin: Vec<Vec3>,
    /// Inertia about it between frames, world axes, kg·m².
    pub inertia: Vec<Matrix3<f64>>,
}

impl MomentumPath {
    /// Of a clip of this character.
    pub fn of(character: &Character, clip: &Clip) -> Self {
        let model = Model::new(character, Vec3::zeros());
        let mut state = State::new(&model);
        let (mut q, mut v) = (vec![0.0; clip.skeleton.nq()], vec![0.0; clip.skeleton.nv()]);
        let mut out = Self { com: Vec::new(), spin: Vec::new(), inertia: Vec::new() };
        for i in 0..clip.frames() {
            state.update_pose(&model, clip.pose(i));
            out.com.push(state.com(&model));
            if i + 1 < clip.frames() {
                let (a, b) = (clip.pose(i), clip.pose(i + 1));
                clip.skeleton.interpolate(a, b, 0.5, &mut q);
                clip.skeleton.difference(a, b, 1.0 / clip.rate_hz, &mut v);
                state.update(&model, &q, &v);
                out.spin.push(state.momentum(&model).angular);
                out.inertia.push(state.composites(&model)[0].2);
            }
        }
        out
    }
}

/// Headings of a clip's root in every frame, unwrapped, rad.
pub fn headings(clip: &Clip, root: &RootFrame) -> Vec<f64> {
    let zero = clip.skeleton.links()[0].parent_from_zero;
    let mut out: Vec<f64> = Vec::new();
    for i in 0..clip.frames() {
        let world = zero * clip.skeleton.joint_transform(clip.pose(i), 0);
        let h = root.heading(&world.rotation);
        let turns = out.last().map_or(0.0, |before| ((before - h) / std::f64::consts::TAU).round());
        out.push(h + turns * std::f64::consts::TAU);
    }
    out
}

/// What of a sampled curve is below a frequency.
pub(crate) fn low_pass(x: &[f64], cutoff_hz: f64, rate_hz: f64) -> Vec<f64> {
    let mut out = x.to_vec();
    if x.len() > 3 {
        let third = vec![0.0; x.len() - 3];
        let hz = cutoff_hz.clamp(rate_hz / 600.0, 0.49 * rate_hz);
        Whittaker::new(x.len(), lambda(hz, rate_hz)).correct(&third, &mut out, 1);
    }
    out
}

/// Where a clip in its local frame goes, and the two headings between which it may be: the human's, and that of the momentum.
#[derive(Clone, Debug)]
pub struct GlobalPath<'a> {
    puppet: &'a Puppet,
    local: &'a Clip,
    scale: Scale,
    theirs: MomentumPath,
    /// Of the local clip.
    own_com: Vec<Vec3>,
    /// The path of the centre of mass, world, m; of its height nothing is used.
    com: Vec<Vec3>,
    /// The human's heading in every frame, rad, and what of it is slow.
    headings: Vec<f64>,
    course: Vec<f64>,
    /// The heading whose momentum is the human's, scaled, in every frame, rad.
    turned: Vec<f64>,
}

impl<'a> GlobalPath<'a> {
    /// * `human`: the human clip, world, ground at height 0
    /// * `local`: as many frames of the puppet at the same rate, each in its local frame
    pub fn new(
        performer: &Performer,
        human: &Clip,
        puppet: &'a Puppet,
        local: &'a Clip,
        options: &GlobalOptions,
    ) -> Self {
        let scale = Scale::new(performer, puppet, options.size);
        let dt = 1.0 / human.rate_hz;
        let (theirs, own) =
            (MomentumPath::of(&performer.character, human), MomentumPath::of(&puppet.character, local));
        let headings = headings(human, &performer.features.root);
        let course = low_pass(&headings, options.drift_hz, human.rate_hz);

        let mut turned = vec![headings[0]];
        for i in 0..theirs.spin.len() {
            let missing = scale.inertia.y * theirs.spin[i].y - own.spin[i].y;
            turned.push(turned[i] + dt * missing / own.inertia[i][(1, 1)]);
        }
        let drift: Vec<f64> = turned.iter().zip(&headings).map(|(a, b)| a - b).collect();
        let drift = low_pass(&drift, options.drift_hz, human.rate_hz);
        turned.iter_mut().zip(drift).for_each(|(turned, drift)| *turned -= drift);

        let mut com = vec![scale.velocity(course[0], &theirs.com[0])];
        for i in 1..local.frames() {
            let course = 0.5 * (course[i - 1] + course[i]);
            com.push(com[i - 1] + scale.velocity(course, &(theirs.com[i] - theirs.com[i - 1])));
        }
        Self { puppet, local, scale, theirs, own_com: own.com, com, headings, course, turned }
    }

    /// The clip in the world: its centre of mass on the path, and its heading the momentum's by a share of every frame, the human's
    /// by the rest.
    pub fn clip(&self, share: impl Fn(usize) -> f64) -> Clip {
        let mut clip = self.local.clone();
        for i in 0..clip.frames() {
            let share = share(i);
            // to the bit what it is where all of it counts
            let heading = if share == 1.0 {
                self.turned[i]
            } else {
                self.headings[i] + share * (self.turned[i] - self.headings[i])
            };
            let turn = Quat::from_axis_angle(&Vec3::y_axis(), heading);
            let place = self.com[i] - turn * self.own_com[i];
            let world_from_local = Transform::from_parts(Vec3::new(place.x, 0.0, place.z).into(), turn);
            place_root(&self.local.skeleton, clip.pose_mut(i), |root| world_from_local * root);
        }
        clip
    }

    /// The momenta of the human, scaled, and of a clip that [`GlobalPath::clip`] gave.
    pub fn report(&self, clip: &Clip) -> MomentumReport {
        let (scale, dt, mass) = (self.scale, 1.0 / clip.rate_hz, self.puppet.character.mass());
        let after = MomentumPath::of(&self.puppet.character, clip);
        let steps = |p: &[Vec3]| -> Vec<Vec3> { p.windows(2).map(|w| (w[1] - w[0]) / dt).collect() };
        let scaled: Vec<Vec3> = steps(&self.theirs.com)
            .iter()
            .zip(self.course.windows(2))
            .map(|(v, course)| scale.velocity(0.5 * (course[0] + course[1]), v) * mass)
            .collect();
        let character: Vec<Vec3> = steps(&after.com).iter().map(|v| v * mass).collect();
        let flat = |v: Vec3| v.x * v.x + v.z * v.z;
        let missed: f64 = scaled.iter().zip(&character).map(|(a, b)| flat(a - b)).sum();
        let whole: f64 = scaled.iter().map(|a| flat(*a)).sum();
        MomentumReport {
            mass_ratio: scale.mass,
            size_ratio: scale.size,
            inertia_ratio: scale.inertia,
            relative_rms: if whole > 0.0 { (missed / whole).sqrt() } else { 0.0 },
            human_spin: self.theirs.spin.iter().map(|l| l.y * scale.inertia.y).collect(),
            character_spin: after.spin.iter().map(|l| l.y).collect(),
            human: scaled,
            character,
        }
    }
}

/// Moves a clip in its local frame so that its momentum is the human's, scaled. Its speeds are held to nothing: the
/// pipeline does that with [`GlobalPath`].
///
/// * `human`, `local`: as for [`GlobalPath::new`]
pub fn global_transform(
    performer: &Performer,
    human: &Clip,
    puppet: &Puppet,
    local: &Clip,
    options: &GlobalOptions,
) -> (Clip, MomentumReport) {
    let path = GlobalPath::new(performer, human, puppet, local, options);
    let clip = path.clip(|_| 1.0);
    let report = path.report(&clip);
    (clip, report)
}

/// A clip with place and heading taken out of every frame.
pub fn in_local_frame(clip: &Clip, root: &RootFrame) -> Clip {
    let mut out = clip.clone();
    for i in 0..clip.frames() {
        place_root(&clip.skeleton, out.pose_mut(i), |w| root.local(w, 0.0).inverse() * w);
    }
    out
}

/// Whether a skeleton's root can go anywhere.
pub(crate) fn has_free_root(character: &Character) -> bool {
    character.skeleton.links()[0].joint == Joint::Free
}
