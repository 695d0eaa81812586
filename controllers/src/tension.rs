//! Tension: from the dimensionless T an animator sets to stiffness and damping.
//!
//! K = T · K₁ with K₁ = max(2 · K_least over the poses of the scene, I_eff (2π f)²): T = 1 is relaxed and
//! natural, T = 0.5 still stands where it matters. In: a model, poses, who stands. Out: per joint
//! the scale K₁, and per pose the least tension and the effective inertia. DESIGN §4.
//!
//! Natural frequencies f of a relaxed, lightly tensed limb, Hz (orders of magnitude of passive and
//! lightly activated limbs, Winter 2009 ch. 9; chosen so that T = 1 looks unforced):
//!
//! | joint | f | joint | f | joint | f |
//! |---|---|---|---|---|---|
//! | spine | 1.6 | shoulder | 1.1 | hip | 1.1 |
//! | neck | 2.2 | elbow | 1.6 | knee | 1.4 |
//! | clavicle | 1.8 | wrist | 3.0 | ankle | 2.5 |
//! | other | 1.5 | stance leg | 0.8 | | |
//!
//! A stance leg moves the body above it, not the limb below: it sways below 1 Hz, as standing people do.

use bodies::JointClass;
use dynamics::{Model, State, Wrench};
use motion::{Joint, Limb, Vec3};
use nalgebra::{DMatrix, DVector};

use crate::antagonist::SetPoints;
use crate::rest_of;

/// Damping ratio ζ of every joint: k_d = 2 ζ √(K I_eff).
///
/// Below 1, so that a relaxed limb swings past its goal; high enough that it does so once and does not ring.
pub const DAMPING_RATIO: f64 = 0.7;

/// Natural frequency of the joints of a stance leg at T = 1, Hz.
pub const STANCE_HZ: f64 = 0.8;

/// Natural frequency of a joint at T = 1, Hz. See the table in the module header.
pub fn natural_frequency_hz(class: JointClass) -> f64 {
    match class {
        JointClass::Root => 0.0,
        JointClass::Spine => 1.6,
        JointClass::Neck => 2.2,
        JointClass::Clavicle => 1.8,
        JointClass::Shoulder | JointClass::Hip => 1.1,
        JointClass::Elbow => 1.6,
        JointClass::Wrist => 3.0,
        JointClass::Knee => 1.4,
        JointClass::Ankle => 2.5,
        JointClass::Other => 1.5,
    }
}

/// A leg that stands: which limb, and its share of the weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StanceLeg {
    /// Body of the thigh, shin and foot in the model.
    pub bodies: [usize; 3],
    /// Share of the weight it carries, in [0, 1]; shares of all legs sum to 1.
    pub share: f64,
}

impl StanceLeg {
    /// The leg `limb` of a model, carrying `share` of the weight.
    pub fn new(model: &Model, limb: &Limb, share: f64) -> Self {
        Self { bodies: limb.links().map(|l| model.body_of[l].0), share }
    }
}

/// What holding one pose needs of one joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Need {
    /// Outside load on the joint at the pose (gravity, support), zero frame, N·m.
    pub load: Vec3,
    /// Least stiffness for the load alone, N·m/rad.
    pub least_load: f64,
    /// Least stiffness for stability, N·m/rad.
    pub least_stability: f64,
    /// Effective inertia: outboard of the axis, or the body above for a stance leg, kg·m².
    pub inertia: f64,
}

impl Need {
    /// Least stiffness, N·m/rad: the larger of load and stability.
    pub fn least(&self) -> f64 {
        self.least_load.max(self.least_stability)
    }
}

/// What holding the pose `q` statically needs of every body's joint.
///
/// `wrenches` are those of the ground. Allocates; meant for poses, not for every step.
pub fn needs(
    model: &Model,
    set_points: &[SetPoints],
    q: &[f64],
    stance: &[StanceLeg],
    wrenches: &[Wrench],
) -> Vec<Need> {
    let n = model.nv();
    let mut state = State::new(model);
    let zero = vec![0.0; n];
    state.update(model, q, &zero);
    let mut tau = vec![0.0; n];
    state.inverse_dynamics(model, &zero, &zero, wrenches, &mut tau);
    let mut mass = DMatrix::zeros(n, n);
    state.mass_matrix(model, &mut mass);
    let mut inboard = vec![0.0; n];
    state.inboard_inertia(model, &mut inboard);

    let stability = least_for_stability(model, &mut state, stance);
    let leg_share = |body: usize| stance.iter().find(|l| l.bodies.contains(&body)).map(|l| l.share);
    model
        .bodies
        .iter()
        .enumerate()
        .map(|(i, b)| {
            let load = -dynamics::rnea::joint_force(&b.joint, &tau, b.v_at);
            let target = rest_of(model, i, q);
            let dofs = b.v_at..b.v_at + b.joint.nv();
            let inertia = match leg_share(i) {
                Some(share) => dofs.map(|k| share * inboard[k]).fold(0.0, f64::max),
                None => dofs.map(|k| mass[(k, k)]).fold(0.0, f64::max),
            };
            Need {
                load,
                least_load: set_points[i].least(&target, load),
                least_stability: stability[i],
                inertia,
            }
        })
        .collect()
}

/// Least stiffness per body so that λ_min(diag K + ∂²V/∂q²) ≥ 0 with the root held, and, for stance
/// legs, with the foot as base.
///
/// Each joint alone needs d = λ_max(−H_jj)⁺; in series they need more, by the common factor
/// λ_max(D^−½ (−H) D^−½). A floor of 2 % of the largest d keeps joints that need nothing of their own
/// from becoming the weak link of the others.
fn least_for_stability(model: &Model, state: &mut State, stance: &[StanceLeg]) -> Vec<f64> {
    let n = model.nv();
    let mut h = DMatrix::zeros(n, n);
    state.gravity_stiffness(model, &mut h);
    let in_leg = |b: usize| stance.iter().any(|l| l.bodies.contains(&b));
    let mut out = vec![0.0; model.bodies.len()];
    let upper: Vec<usize> =
        (0..model.bodies.len()).filter(|&i| actuated(&model.bodies[i].joint) && !in_leg(i)).collect();
    scale_up(model, &h, &upper, &mut out);
    for leg in stance {
        h.fill(0.0);
        stance_stiffness(model, state, leg, &mut h);
        scale_up(model, &h, &leg.bodies, &mut out);
    }
    out
}

fn actuated(joint: &Joint) -> bool {
    !matches!(joint, Joint::Free | Joint::Fixed)
}

fn scale_up(model: &Model, h: &DMatrix<f64>, bodies: &[usize], out: &mut [f64]) {
    let own: Vec<f64> = bodies
        .iter()
        .map(|&i| {
            let b = &model.bodies[i];
            let block = -h.view((b.v_at, b.v_at), (b.joint.nv(), b.joint.nv())).into_owned();
            block.symmetric_eigenvalues().max().max(0.0)
        })
        .collect();
    let largest = own.iter().copied().fold(0.0, f64::max);
    if largest == 0.0 {
        return;
    }
    let floored: Vec<f64> = own.iter().map(|d| d.max(0.02 * largest)).collect();
    let mut dofs = Vec::new();
    for (&i, d) in bodies.iter().zip(&floored) {
        let b = &model.bodies[i];
        dofs.extend((b.v_at..b.v_at + b.joint.nv()).map(|k| (k, d.sqrt())));
    }
    let scaled =
        DMatrix::from_fn(dofs.len(), dofs.len(), |r, c| -h[(dofs[r].0, dofs[c].0)] / (dofs[r].1 * dofs[c].1));
    let series = scaled.symmetric_eigenvalues().max();
    for (&i, d) in bodies.iter().zip(&floored) {
        // a lone inverted rod needs exactly its own d
        out[i] = if bodies.len() == 1 { own[0] } else { d * series };
    }
}

/// ∂²V/∂q² of a stance leg with its foot as base: axis j carries everything *inboard* of it.
fn stance_stiffness(model: &Model, state: &mut State, leg: &StanceLeg, h: &mut DMatrix<f64>) {
    let composites = state.composites(model).to_vec();
    let whole = composites[0];
    // from the foot up: ankle, knee, hip
    let chain = [leg.bodies[2], leg.bodies[1], leg.bodies[0]];
    for (jj, &j) in chain.iter().enumerate() {
        let mass = whole.0 - composites[j].0;
        let com = (whole.1 * whole.0 - composites[j].1 * composites[j].0) / mass;
        let arm = com - state.bodies[j].world.translation.vector;
        for (l, a_j) in axes(model, state, j) {
            for &i in &chain[..=jj] {
                for (k, a_i) in axes(model, state, i) {
                    let moved = a_i.cross(&a_j.cross(&arm));
                    let other = if i == j { a_j.cross(&a_i.cross(&arm)) } else { moved };
                    let value = -0.5 * leg.share * mass * model.gravity.dot(&(moved + other));
                    h[(k, l)] = value;
                    h[(l, k)] = value;
                }
            }
        }
    }
}

/// Axes about which the joint of a body turns, world, with their degrees of freedom; none for slides and a free root.
fn axes(model: &Model, state: &State, body: usize) -> Vec<(usize, Vec3)> {
    let mut out = Vec::new();
    if matches!(model.bodies[body].joint, Joint::Spherical | Joint::Revolute(_)) {
        state.joint_axes(model, body, |dof, _, angular| out.push((dof, angular)));
    }
    out
}

/// Stiffness scale and typical inertia of every joint of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct TensionScale {
    /// K₁ per body: stiffness at T = 1, N·m/rad.
    pub k1: Vec<f64>,
    /// Largest effective inertia over the poses, kg·m².
    pub inertia: Vec<f64>,
    /// Largest K_least over the poses, N·m/rad.
    pub least: Vec<f64>,
}

impl TensionScale {
    /// Scale over the needs of all poses of a scene; `classes` per link.
    pub fn new(model: &Model, classes: &[JointClass], stance: &[StanceLeg], poses: &[Vec<Need>]) -> Self {
        let n = model.bodies.len();
        let largest = |f: &dyn Fn(&Need) -> f64, i: usize| poses.iter().map(|p| f(&p[i])).fold(0.0, f64::max);
        let least: Vec<f64> = (0..n).map(|i| largest(&|p| p.least(), i)).collect();
        let inertia: Vec<f64> = (0..n).map(|i| largest(&|p| p.inertia, i)).collect();
        let k1 = (0..n)
            .map(|i| {
                let stands = stance.iter().any(|l| l.bodies.contains(&i));
                let class = classes[model.bodies[i].link];
                let f = if stands { STANCE_HZ } else { natural_frequency_hz(class) };
                (2.0 * least[i]).max(inertia[i] * (std::f64::consts::TAU * f).powi(2))
            })
            .collect();
        Self { k1, inertia, least }
    }

    /// Damping for stiffness `k` of a joint with effective inertia `inertia`: 2 ζ √(K I), N·m·s/rad.
    pub fn damping(k: f64, inertia: f64) -> f64 {
        2.0 * DAMPING_RATIO * (k * inertia).sqrt()
    }
}

/// Smallest eigenvalue of diag K + ∂²V/∂q² with the root held: positive when the pose is stable.
pub fn stability_margin(model: &Model, q: &[f64], stiffness: &[f64]) -> f64 {
    let n = model.nv();
    let mut state = State::new(model);
    state.update(model, q, &vec![0.0; n]);
    let mut h = DMatrix::zeros(n, n);
    state.gravity_stiffness(model, &mut h);
    let mut k = DVector::zeros(n);
    for (b, &value) in model.bodies.iter().zip(stiffness) {
        k.rows_mut(b.v_at, b.joint.nv()).fill(value);
    }
    let dofs: Vec<usize> = model
        .bodies
        .iter()
        .filter(|b| actuated(&b.joint))
        .flat_map(|b| b.v_at..b.v_at + b.joint.nv())
        .collect();
    let m = DMatrix::from_fn(dofs.len(), dofs.len(), |r, c| {
        h[(dofs[r], dofs[c])] + if r == c { k[dofs[r]] } else { 0.0 }
    });
    m.symmetric_eigenvalues().min()
}
