//! Tails, ears, antennas: parts that follow by dynamics.
//!
//! In: a clip of the puppet, and which of its links sway. Out: the clip with those joints moved by springs towards the
//! poses they had, carried by a body that moves as it did. They lag where the body starts, swing on where it stops, and
//! rest where the key poses put them.
//!
//! *Equation.* With t the swaying degrees of freedom, all others prescribed,
//!
//! ```text
//! M_tt v̇_t + h_t = K log(R* R⁻¹) − D (v_t − v*_t) + g_t(q*)        h = ID(q, v, v̇ with v̇_t = 0)
//! ```
//!
//! by implicit steps of the linear part: `(M + dt D + dt² K) v̇ = …`, stable at any step. The load of gravity in the keyed
//! pose is carried, so that nothing sags. K and D of a joint come from a frequency f and a damping ratio ζ: with I the
//! largest inertia of what it carries about its axes in the rest pose, `K = I (2πf)²`, `D = 2ζ √(K I)`: a joint alone, its
//! neighbours locked, swings at f; a chain of them is slower. A ball has one K in all directions. Beyond a joint's
//! limits the spring is `STOP` times as stiff.
//!
//! Nothing here changes what carries the parts: a tail's pull on its body is in the forces that are refined afterwards.

use dynamics::{Model, State};
use motion::{Clip, Derivatives, Vec3, linear, rotation};
use nalgebra::DMatrix;

use crate::result::SwayReport;
use crate::{Puppet, Sway};
use motion::limits::tangent_correction;

/// Longest step, s.
const STEP_S: f64 = 1.0 / 240.0;
/// Stiffness beyond a limit over that within.
const STOP: f64 = 4.0;

/// A swaying joint.
struct Spring {
    link: usize,
    /// Its first degree of freedom, in the body and among those that sway; how many.
    at: usize,
    own: usize,
    count: usize,
    stiffness: f64,
    damping: f64,
}

/// Moves the swaying parts of a clip. See the module header.
///
/// * `gravity_m_s2`: along −Y
pub fn sway(puppet: &Puppet, clip: &Clip, gravity_m_s2: f64) -> (Clip, SwayReport) {
    let c = &puppet.character;
    let s = &c.skeleton;
    let model = Model::new(c, Vec3::y() * -gravity_m_s2);
    let mut state = State::new(&model);
    let springs = springs(puppet, &model, &mut state);
    let n: usize = springs.iter().map(|j| j.count).sum();
    let mut out = clip.clone();
    let mut report = SwayReport::default();
    if n == 0 || clip.frames() < 2 {
        return (out, report);
    }
    let nv = s.nv();
    let d = Derivatives::central(clip);
    let steps = (1.0 / (clip.rate_hz * STEP_S)).ceil().max(1.0) as usize;
    let dt = 1.0 / (clip.rate_hz * steps as f64);
    let (mut q, mut goal) = (clip.pose(0).to_vec(), clip.pose(0).to_vec());
    let (mut v, mut vd, mut tau, mut load) =
        (d.v[..nv].to_vec(), vec![0.0; nv], vec![0.0; nv], vec![0.0; nv]);
    let mut rate = vec![0.0; nv];
    let (mut mass, mut a, mut b) = (DMatrix::zeros(nv, nv), vec![0.0; n * n], vec![0.0; n]);
    for i in 0..clip.frames() - 1 {
        for step in 0..steps {
            let x = step as f64 / steps as f64;
            s.interpolate(clip.pose(i), clip.pose(i + 1), x, &mut goal);
            let between = |of: &[f64], k: usize| of[i * nv + k] * (1.0 - x) + of[(i + 1) * nv + k] * x;
            (0..nv).for_each(|k| (rate[k], vd[k]) = (between(&d.v, k), between(&d.vd, k)));
            state.update_pose(&model, &goal);
            state.gravity_load(&model, &mut load);
            // all joints are prescribed by the clip but those that sway
            prescribe_all_but(s, &springs, &goal, &rate, &mut q, &mut v, &mut vd);
            state.update(&model, &q, &v);
            state.inverse_dynamics(&model, &v, &vd, &[], &mut tau);
            state.mass_matrix(&model, &mut mass);
            for j in &springs {
                let mut pull = displacement_to(s, j.link, &q, &goal) * j.stiffness;
                if let Some(e) = tangent_correction(s, &q, j.link) {
                    pull += e * (STOP * j.stiffness);
                }
                for k in 0..j.count {
                    let at = j.at + k;
                    let off = v[at] - rate[at];
                    b[j.own + k] = pull[k] - (j.damping + dt * j.stiffness) * off + load[at] - tau[at];
                    for other in &springs {
                        for l in 0..other.count {
                            a[(j.own + k) * n + other.own + l] = mass[(at, other.at + l)];
                        }
                    }
                    a[(j.own + k) * (n + 1)] += dt * j.damping + dt * dt * j.stiffness;
                }
            }
            if !linear::solve_cholesky(&mut a, n, &mut b) {
                // only parts without mass make it singular: they do not sway
                return (clip.clone(), SwayReport::default());
            }
            for j in &springs {
                (0..j.count).for_each(|k| v[j.at + k] += dt * b[j.own + k]);
            }
            vd.fill(0.0);
            springs.iter().for_each(|j| vd[j.at..j.at + j.count].copy_from_slice(&v[j.at..j.at + j.count]));
            s.integrate(&mut q, &vd, dt);
        }
        let pose = out.pose_mut(i + 1);
        // only the swaying joints are clamped: contact adjustment may have taken legs a little beyond their limits
        goal.copy_from_slice(&q);
        s.clamp_to_limits(&mut goal);
        for j in &springs {
            let r = s.q_at(j.link)..s.q_at(j.link) + s.links()[j.link].joint.nq();
            pose[r.clone()].copy_from_slice(&goal[r]);
        }
        for j in &springs {
            report.most_rad = report.most_rad.max(displacement_to(s, j.link, pose, clip.pose(i + 1)).norm());
        }
    }
    report.links = springs.len();
    (out, report)
}

/// The springs of a puppet's swaying joints.
fn springs(puppet: &Puppet, model: &Model, state: &mut State) -> Vec<Spring> {
    let c = &puppet.character;
    let nv = c.skeleton.nv();
    let mut mass = DMatrix::zeros(nv, nv);
    state.update_pose(model, &c.rest);
    state.mass_matrix(model, &mut mass);
    let mut links: Vec<(usize, &Sway)> =
        puppet.sways.iter().flat_map(|sway| sway.links.iter().map(move |&l| (l, sway))).collect();
    links.sort_by_key(|l| l.0);
    links.dedup_by_key(|l| l.0);
    let mut out: Vec<Spring> = Vec::new();
    for (link, sway) in links {
        let (at, count) = (c.skeleton.v_at(link), c.skeleton.links()[link].joint.nv());
        if count == 0 || link == 0 {
            continue;
        }
        let inertia = (at..at + count).map(|k| mass[(k, k)]).fold(0.0, f64::max);
        let stiffness = inertia * (std::f64::consts::TAU * sway.frequency_hz).powi(2);
        let damping = 2.0 * sway.damping_ratio * (stiffness * inertia).sqrt();
        let own = out.last().map_or(0, |j| j.own + j.count);
        out.push(Spring { link, at, own, count, stiffness, damping });
    }
    out
}

/// Puts everything but the springs where the goal is; `vd` of the springs is zero.
fn prescribe_all_but(
    s: &motion::Skeleton,
    springs: &[Spring],
    goal: &[f64],
    rate: &[f64],
    q: &mut [f64],
    v: &mut [f64],
    vd: &mut [f64],
) {
    let own = |j: &Spring| s.q_at(j.link)..s.q_at(j.link) + s.links()[j.link].joint.nq();
    let kept: Vec<(Vec<f64>, Vec<f64>)> =
        springs.iter().map(|j| (q[own(j)].to_vec(), v[j.at..j.at + j.count].to_vec())).collect();
    q.copy_from_slice(goal);
    v.copy_from_slice(rate);
    for (j, (pose, speed)) in springs.iter().zip(&kept) {
        q[own(j)].copy_from_slice(pose);
        v[j.at..j.at + j.count].copy_from_slice(speed);
        vd[j.at..j.at + j.count].fill(0.0);
    }
}

/// The turn (or the way, in x) that takes a joint of `q` to that of `goal`, zero frame.
fn displacement_to(s: &motion::Skeleton, link: usize, q: &[f64], goal: &[f64]) -> Vec3 {
    match s.links()[link].joint {
        motion::Joint::Spherical => rotation::log(&(s.rotation(goal, link) * s.rotation(q, link).inverse())),
        _ => Vec3::x() * (goal[s.q_at(link)] - q[s.q_at(link)]),
    }
}
