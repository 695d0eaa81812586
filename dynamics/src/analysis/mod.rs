//! Inverse dynamics of a clip: the forces it needs, what the ground can give of them, and the rest.
//!
//! In: a [`Character`], a [`Clip`], [`AnalysisOptions`]. Out: an [`Analysis`], one row per frame. No
//! engine and no optimisation: the motion is taken as it is, after the smoother of [`mod@motion::smooth`].
//!
//! Per frame, all in world axes:
//!
//! 1. *Required*: `F = ṗ − m g` and `M = L̇` about the centre of mass, from RNEA. The *centre of
//!    pressure* `c` is the point of the ground where the horizontal moment of this wrench vanishes.
//! 2. *Given* by the ground ([`ground`]): nothing without contact or where F pulls; else `F` with its
//!    tangential part cut to the friction cone, at `c` moved to the nearest point of the support polygon,
//!    with a moment about the vertical as far as friction allows. It is shared by the soles as an elastic
//!    floor would: least squares of the pressures of the corners, none of which pulls.
//! 3. *Residual*: required − given, force and moment about the root's origin (as OpenSim's pelvis
//!    residuals): what neither joints nor an admissible ground explain. Graded by [`Grade`].
//! 4. *Torques*: RNEA with the given wrenches on the feet; a free root's entries are the residual.
//!
//! Units: m, rad, s, N, N·m. Flat tables are `frames × columns`.

mod ends;
pub mod grade;
pub mod ground;
pub mod noise;
mod trace;

use motion::floor::FRICTION;
use motion::rotation::{Vec3, log};
use motion::skeleton::vec_at;
use motion::smooth::strength::LEAST_FRAMES;
use motion::smooth::{SmoothReport, Smoothed, Smoothing, Strength, smooth_at};
use motion::{Clip, Joint};
use thiserror::Error;

use crate::conditions::GRAVITY;
use crate::{Model, State, Wrench};
use bodies::{Character, PoseMap, PoseMapError};

pub use ends::{END_S, Ends};
pub use grade::{Grade, Residual};
pub use ground::{Contact, FloorChoice, Violations, pressures};
pub use noise::NoiseFloor;
pub use trace::trace_of;

use ground::FloorReaction;

/// Default of [`AnalysisOptions::soft_tissue`], m/√Hz: 1 mm RMS in the 50 Hz of a 100 Hz recording.
///
/// What is left of the centre of mass of two measured walks after the double integral of the force plates
/// has been taken away lies between 0.2 (6 Hz) and 0.04 mm/√Hz (10 Hz); markers on the thigh alone
/// move by 10 mm and more over the bone (Leardini et al., Gait & Posture 21, 2005).
pub const SOFT_TISSUE: f64 = 1.414e-4;

/// Lowest cut-off that [`Smoothing::Auto`] takes for forces, Hz: the arms of a man who stands still move
/// faster than his centre of mass.
pub const LEAST_CUTOFF_HZ: f64 = 4.0;

/// Cut-off of clips too short for their noise to be read, Hz: usual for gait (Winter, Biomechanics and motor control of human
/// movement, 4th ed., 2009, section 3.4).
pub const SHORT_CUTOFF_HZ: f64 = 6.0;

/// Settings of [`analyze`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnalysisOptions {
    /// How the clip is smoothed before it is differentiated. [`Smoothing::Auto`] takes the cut-off that
    /// minimises the expected error of the acceleration of the *centre of mass*, which is the force the
    /// ground must give, with noise of at least [`AnalysisOptions::soft_tissue`].
    pub smoothing: Smoothing,
    /// Least density of noise assumed on the path of a recorded centre of mass, m/√Hz; 0 for none. Skin
    /// moves over bone with the body's own frequencies, which no spectrum tells from motion. It is not
    /// assumed where no noise is measured at all (simulated or fitted motion).
    pub soft_tissue: f64,
    /// Gravity, world, m/s².
    pub gravity: Vec3,
    /// How the floor is chosen.
    pub ground: FloorChoice,
    /// Coefficient of friction, ≥ 0.
    pub friction: f64,
    /// When a point of a sole touches the ground.
    pub contact: Contact,
}

impl Default for AnalysisOptions {
    fn default() -> Self {
        Self {
            smoothing: Smoothing::Auto,
            soft_tissue: SOFT_TISSUE,
            gravity: GRAVITY,
            ground: FloorChoice::Detect,
            friction: FRICTION,
            contact: Contact::default(),
        }
    }
}

/// Why a clip cannot be analysed.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum AnalysisError {
    /// Too few frames for an acceleration.
    #[error("the clip has {frames} frames; an acceleration needs at least {least}")]
    Short {
        /// Frames of the clip.
        frames: usize,
        /// Frames needed.
        least: usize,
    },
    /// A clip of another skeleton.
    #[error(transparent)]
    Skeleton(#[from] PoseMapError),
    /// A pose that holds NaN or infinity.
    #[error("frame {frame} of the clip holds a number that is not finite")]
    NotFinite {
        /// The frame.
        frame: usize,
    },
    /// A setting out of range.
    #[error("{name} is {value}; it must be {allowed}")]
    Option {
        /// The setting.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
}

/// One foot through the clip.
#[derive(Clone, Debug, PartialEq)]
pub struct FootForces {
    /// Name of its leg.
    pub name: String,
    /// The link the force acts on.
    pub link: usize,
    /// Frames in which at least one corner of the sole touches.
    pub contact: Vec<bool>,
    /// Height of the lowest corner above the ground, m.
    pub height: Vec<f64>,
    /// Share of the vertical force, 0 to 1.
    pub share: Vec<f64>,
    /// Force on the foot, `frames × 3`, N.
    pub force: Vec<f64>,
    /// Where it acts, on the ground, `frames × 3`, m; NaN without load.
    pub cop: Vec<f64>,
    /// Moment about the vertical through that point, N·m.
    pub free_moment: Vec<f64>,
}

/// A joint that turns further between two frames than a joint can: a flipped or mislabelled recording.
///
/// No smoother mends it, and the forces around it mean nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// The frame after the jump.
    pub frame: usize,
    /// The link.
    pub link: usize,
    /// Angle, rad.
    pub angle: f64,
}

/// What a clip needs and what the ground gives. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Analysis {
    /// The motion that was analysed: smoothed, on the character's skeleton.
    pub clip: Clip,
    /// What the smoother chose and found.
    pub smoothing: SmoothReport,
    /// Jumps of the given clip, before smoothing, in order of frame: turns beyond 45° and 25 rad/s.
    pub jumps: Vec<Jump>,
    /// Gravity, m/s².
    pub gravity: Vec3,
    /// Mass, kg.
    pub mass: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Height of the ground, m; `None` without ground.
    pub ground_m: Option<f64>,
    /// Velocities, `frames × nv`.
    pub v: Vec<f64>,
    /// Accelerations, `frames × nv`.
    pub vd: Vec<f64>,
    /// Joint forces with the ground's wrenches on the feet, `frames × nv`, N or N·m. The entries of a
    /// free root are the residual along its zero frame's axes.
    pub tau: Vec<f64>,
    /// Force the motion needs from outside, `ṗ − m g`, `frames × 3`, N.
    pub required_force: Vec<f64>,
    /// Moment it needs about the centre of mass, `L̇`, `frames × 3`, N·m.
    pub required_moment_com: Vec<f64>,
    /// Force the ground gives, `frames × 3`, N.
    pub ground_force: Vec<f64>,
    /// Its moment about the centre of mass, `frames × 3`, N·m.
    pub ground_moment_com: Vec<f64>,
    /// Required less given: force (N), moment about the root's origin (N·m), `frames × 6`.
    pub residual: Vec<f64>,
    /// The same without any ground: the whole required wrench about the root's origin, `frames × 6`.
    pub root_wrench: Vec<f64>,
    /// Centre of mass, `frames × 3`, m.
    pub com: Vec<f64>,
    /// Its velocity, `frames × 3`, m/s.
    pub com_velocity: Vec<f64>,
    /// Angular momentum about it, `frames × 3`, N·m·s.
    pub angular_momentum: Vec<f64>,
    /// Centre of pressure the motion needs on the ground, `frames × 3`, m; NaN where the required force
    /// presses with less than a tenth of body weight, or without ground.
    pub cop: Vec<f64>,
    /// The feet, in the order of the character's legs.
    pub feet: Vec<FootForces>,
    /// Which frames are graded, and how uncertain the ends are.
    pub ends: Ends,
    /// Frames without contact.
    pub flight: Vec<bool>,
    /// Graded frames whose required force leaves the friction cone; `worst` is |f_t|/(μ f_n), infinite where
    /// the force pulls.
    pub friction_violations: Violations,
    /// Graded frames whose required centre of pressure leaves the support polygon; `worst` is the distance, m.
    pub support_violations: Violations,
    /// What noise of the poses makes of the torques and the root's wrench.
    pub noise: NoiseFloor,
    /// Peak, RMS and grade of the residual over the graded frames.
    pub graded: Residual,
}

impl Analysis {
    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.clip.frames()
    }

    /// Frames per second, Hz.
    pub fn rate_hz(&self) -> f64 {
        self.clip.rate_hz
    }

    /// Body weight, N.
    pub fn weight(&self) -> f64 {
        self.mass * self.gravity.norm()
    }

    /// Names of the columns of `v`, `vd` and `tau`: the link's name, with `.tx`, `.rx` and the like where
    /// a joint has several degrees of freedom.
    pub fn dof_names(&self) -> Vec<String> {
        self.clip.skeleton.dof_names()
    }
}

/// Path of the centre of mass, `frames × 3`, m.
fn com_path(model: &Model, state: &mut State, clip: &Clip) -> Vec<f64> {
    let mut com = Vec::with_capacity(3 * clip.frames());
    for k in 0..clip.frames() {
        state.update_pose(model, clip.pose(k));
        com.extend(&state.com(model));
    }
    com
}

/// The clip as inverse dynamics smooths it, by the noise on the path of its centre of mass and the usual options.
pub fn smoothed(model: &Model, clip: &Clip) -> Clip {
    smooth_at(clip, strength(model, &mut State::new(model), clip, &AnalysisOptions::default())).clip
}

/// Strength of smoothing for the forces of a clip, by the noise on the path of its centre of mass. See
/// [`AnalysisOptions::smoothing`]; of fewer than 16 frames no noise is read, and [`SHORT_CUTOFF_HZ`] is taken.
pub fn strength(model: &Model, state: &mut State, clip: &Clip, options: &AnalysisOptions) -> Strength {
    strength_of_com(&com_path(model, state, clip), clip, options)
}

fn strength_of_com(com: &[f64], clip: &Clip, options: &AnalysisOptions) -> Strength {
    let chosen = Strength::of(com, 3, clip.rate_hz, options.soft_tissue);
    match options.smoothing {
        Smoothing::Auto if clip.frames() < LEAST_FRAMES => Strength::at(SHORT_CUTOFF_HZ),
        Smoothing::Auto => Strength { cutoff_hz: chosen.cutoff_hz.max(LEAST_CUTOFF_HZ), ..chosen },
        Smoothing::CutoffHz(cutoff_hz) => Strength { cutoff_hz, ..chosen },
        Smoothing::Off => Strength { cutoff_hz: f64::INFINITY, assumed: 0.0, ..chosen },
    }
}

/// Inverse dynamics of a clip. See the module header.
///
/// The clip may be of the character's skeleton or of the one it was guessed from (with welded joints
/// free; see [`PoseMap`]).
///
/// # Errors
/// See [`AnalysisError`].
pub fn analyze(
    character: &Character,
    clip: &Clip,
    options: &AnalysisOptions,
) -> Result<Analysis, AnalysisError> {
    check(clip, options)?;
    let map = PoseMap::of_clip(clip, &character.skeleton)?;
    let clip = map.clip_to_character(clip, &character.skeleton);
    let model = Model::new(character, options.gravity);
    let mut state = State::new(&model);
    let jumps = jumps(&clip);
    let com = com_path(&model, &mut state, &clip);
    let strength = strength_of_com(&com, &clip, options);
    let smoothed = smooth_at(&clip, strength);
    let noise = NoiseFloor::of(&model, &mut state, &smoothed);
    let Smoothed { clip, derivatives, report, .. } = smoothed;
    let ends = Ends::of(&com, clip.rate_hz, report.cutoff_hz, model.mass);
    let soles = character.edged_soles(ground::SPACING_M);
    let (v, vd) = (derivatives.v, derivatives.vd);
    let reaction = FloorReaction::new(&model, &mut state, &soles, &clip, &v, options);
    let (frames, nv) = (clip.frames(), model.nv());

    let table = |columns: usize| Vec::with_capacity(frames * columns);
    let mut a = Analysis {
        smoothing: report,
        jumps,
        gravity: options.gravity,
        mass: model.mass,
        friction: options.friction,
        ground_m: reaction.floor.map(|f| f.height_m),
        tau: vec![0.0; frames * nv],
        required_force: table(3),
        required_moment_com: table(3),
        ground_force: table(3),
        ground_moment_com: table(3),
        residual: table(6),
        root_wrench: table(6),
        com: table(3),
        com_velocity: table(3),
        angular_momentum: table(3),
        cop: table(3),
        feet: soles.iter().map(|f| FootForces::new(&f.name, f.link, frames)).collect(),
        ends,
        flight: Vec::with_capacity(frames),
        friction_violations: Violations::default(),
        support_violations: Violations::default(),
        noise,
        graded: Residual::default(),
        clip,
        v,
        vd,
    };
    let mut wrenches: Vec<Wrench> = Vec::with_capacity(soles.len());
    let mut scratch = ground::Scratch::new(&soles);
    for k in 0..frames {
        let row = k * nv..(k + 1) * nv;
        let (v, vd) = (&a.v[row.clone()], &a.vd[row.clone()]);
        state.update(&model, a.clip.pose(k), v);
        let momentum = state.momentum(&model);
        let rate = state.momentum_rate(&model, v, vd);
        let (force, moment_com) = (rate.linear - model.gravity * model.mass, rate.angular);
        let to_com = momentum.com - state.bodies[0].origin();
        let moment_root = moment_com + to_com.cross(&force);

        let given =
            reaction.admissible(&model, &state, &soles, &mut scratch, momentum.com, force, moment_com);
        wrenches.clear();
        wrenches.extend(scratch.wrenches());
        state.inverse_dynamics(&model, v, vd, &wrenches, &mut a.tau[row]);
        let moment_given_root = given.moment_com + to_com.cross(&given.force);

        a.required_force.extend(&force);
        a.required_moment_com.extend(&moment_com);
        a.ground_force.extend(&given.force);
        a.ground_moment_com.extend(&given.moment_com);
        a.residual.extend(&(force - given.force));
        a.residual.extend(&(moment_root - moment_given_root));
        a.root_wrench.extend(&force);
        a.root_wrench.extend(&moment_root);
        a.com.extend(&momentum.com);
        a.com_velocity.extend(&(momentum.linear / model.mass));
        a.angular_momentum.extend(&momentum.angular);
        a.cop.extend(&given.cop);
        a.flight.push(given.flight);
        for (foot, now) in a.feet.iter_mut().zip(&scratch.feet) {
            foot.push(now);
        }
        if a.ends.graded.contains(&k) {
            let height = momentum.com.y - reaction.floor.map_or(0.0, |f| f.height_m);
            let slack = a.noise.pressure(height) / force.y.max(f64::MIN_POSITIVE);
            a.friction_violations.record(k, given.cone, 1.0);
            a.support_violations.record(k, given.outside, slack.max(ground::COP_SLACK));
        }
    }
    a.graded = Residual::over(&a.residual, a.ends.graded.clone());
    Ok(a)
}

impl FootForces {
    fn new(name: &str, link: usize, frames: usize) -> Self {
        Self {
            name: name.to_owned(),
            link,
            contact: Vec::with_capacity(frames),
            height: Vec::with_capacity(frames),
            share: Vec::with_capacity(frames),
            force: Vec::with_capacity(3 * frames),
            cop: Vec::with_capacity(3 * frames),
            free_moment: Vec::with_capacity(frames),
        }
    }

    fn push(&mut self, now: &ground::FootNow) {
        self.contact.push(now.contact);
        self.height.push(now.height);
        self.share.push(now.share);
        self.force.extend(&now.force);
        self.cop.extend(&now.cop);
        self.free_moment.push(now.free_moment);
    }

    /// Force on the foot in a frame, N.
    pub fn force_at(&self, frame: usize) -> Vec3 {
        vec_at(&self.force, 3 * frame)
    }
}

/// Turns beyond 45° and 25 rad/s from one frame to the next.
fn jumps(clip: &Clip) -> Vec<Jump> {
    let most = std::f64::consts::FRAC_PI_4.max(25.0 / clip.rate_hz);
    let skeleton = &clip.skeleton;
    let mut out = Vec::new();
    for frame in 1..clip.frames() {
        let (a, b) = (clip.pose(frame - 1), clip.pose(frame));
        for (link, l) in skeleton.links().iter().enumerate() {
            let angle = match l.joint {
                Joint::Free | Joint::Spherical => {
                    log(&(skeleton.rotation(b, link) * skeleton.rotation(a, link).inverse())).norm()
                }
                Joint::Revolute(_) => (b[skeleton.q_at(link)] - a[skeleton.q_at(link)]).abs(),
                Joint::Prismatic(_) | Joint::Fixed => 0.0,
            };
            if angle > most {
                out.push(Jump { frame, link, angle });
            }
        }
    }
    out
}

fn check(clip: &Clip, options: &AnalysisOptions) -> Result<(), AnalysisError> {
    const LEAST: usize = 3;
    let frames = clip.frames();
    if frames < LEAST {
        return Err(AnalysisError::Short { frames, least: LEAST });
    }
    let bad = (0..frames).find(|&k| !clip.pose(k).iter().all(|x| x.is_finite()));
    if let Some(frame) = bad {
        return Err(AnalysisError::NotFinite { frame });
    }
    let finite = |name, value: f64| {
        let allowed = "a finite number";
        if value.is_finite() { Ok(()) } else { Err(AnalysisError::Option { name, value, allowed }) }
    };
    let positive = |name, value: f64, ok: bool| {
        let allowed = "positive";
        if ok { Ok(()) } else { Err(AnalysisError::Option { name, value, allowed }) }
    };
    options.gravity.iter().try_for_each(|g| finite("gravity", *g))?;
    if let FloorChoice::At(height) = options.ground {
        finite("the height of the ground", height)?;
    }
    if let Smoothing::CutoffHz(hz) = options.smoothing {
        positive("the cut-off frequency", hz, hz > 0.0)?;
    }
    let soft = options.soft_tissue;
    if !(soft >= 0.0 && soft.is_finite()) {
        let allowed = "zero or more";
        return Err(AnalysisError::Option { name: "the soft tissue's noise", value: soft, allowed });
    }
    let Contact { height_m, speed_m_s, ground_velocity } = options.contact;
    ground_velocity.iter().try_for_each(|v| finite("the velocity of the ground", *v))?;
    positive("the height of contact", height_m, height_m > 0.0)?;
    positive("the speed of contact", speed_m_s, speed_m_s > 0.0)?;
    let mu = options.friction;
    let allowed = "zero or more";
    if mu >= 0.0 && mu.is_finite() {
        Ok(())
    } else {
        Err(AnalysisError::Option { name: "friction", value: mu, allowed })
    }
}

/// Whether a joint's forces are torques (N·m); a slide's are forces (N).
pub fn is_torque(joint: &Joint) -> bool {
    !matches!(joint, Joint::Prismatic(_))
}
