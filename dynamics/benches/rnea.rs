//! Times inverse and forward dynamics, mass matrix and derivatives of the standing human, and dumps
//! what they were fed.
//!
//! `cargo bench -p dynamics --bench rnea -- [DUMP_DIR]`. One JSON line: microseconds per call, each the
//! least of 30 passes over the same 1,000 states, in CPU time of the thread. With a folder, writes
//! `model.txt` and `states.bin`, which `pinocchio/pinocchio.cc` reads; `pinocchio/run.sh` runs both in
//! turns. Compare only numbers of one such run.
//!
//! `model.txt`: bodies, nq, nv, states, gravity; then per body: parent (−1: none), joint (`free`, `ball`,
//! `hinge`, `slide`), axis, rotation (rows) and translation of the zero frame in the parent, mass,
//! centre of mass, inertia (rows). `states.bin`: per state q, v, v̇, τ, M (columns), f64 little-endian.

use std::fmt::Write as _;
use std::hint::black_box;
use std::path::Path;

use bodies::anthropometry::human::human;
use dynamics::{ForwardDynamics, InverseDerivatives, Model, State};
use motion::{Joint, Vec3};
use nalgebra::DMatrix;

const STATES: usize = 1000;
const PASSES: usize = 30;

struct Sample {
    q: Vec<f64>,
    v: Vec<f64>,
    vd: Vec<f64>,
}

fn main() {
    let dump = std::env::args().skip(1).find(|a| !a.starts_with("--"));
    let (character, _) = human();
    let model = Model::new(&character, Vec3::new(0.0, -9.81, 0.0));
    let samples = samples(&model);
    let mut state = State::new(&model);
    let n = model.nv();
    let (mut tau, mut m) = (vec![0.0; n], DMatrix::zeros(n, n));
    if let Some(dir) = dump {
        write_dump(Path::new(&dir), &model, &samples).expect("the folder can be written");
    }

    let rnea = least(&samples, |s| {
        state.update(&model, &s.q, &s.v);
        state.inverse_dynamics(&model, &s.v, &s.vd, &[], &mut tau);
        black_box(&tau);
    });
    let pose = least(&samples, |s| {
        state.update_pose(&model, &s.q);
        black_box(&state);
    });
    let crba = least(&samples, |s| {
        state.update_pose(&model, &s.q);
        state.mass_matrix(&model, &mut m);
        black_box(&m);
    });
    let mut forward = ForwardDynamics::new(&model);
    let mut vd = vec![0.0; n];
    let accelerations = least(&samples, |s| {
        state.update(&model, &s.q, &s.v);
        // any forces do: the samples' accelerations are at hand
        forward.accelerations(&model, &mut state, &s.v, &s.vd, &[], &mut vd).expect("the human has mass");
        black_box(&vd);
    });
    let mut slopes = InverseDerivatives::new(&model);
    let derivatives = least(&samples, |s| {
        state.update(&model, &s.q, &s.v);
        slopes.update(&model, &state, &s.v, &s.vd, &[]);
        black_box(&slopes);
    });
    println!(
        "{{\"engine\":\"contrapposto\",\"rnea_us\":{rnea:.3},\"crba_us\":{crba:.3},\"pose_us\":{pose:.3},\"forward_us\":{accelerations:.3},\"derivatives_us\":{derivatives:.3},\"nv\":{n}}}"
    );
}

/// Poses all over, |q̇| to 10 rad/s, |q̈| to 100 rad/s²; the same every time (a Weyl sequence).
fn samples(model: &Model) -> Vec<Sample> {
    let mut x = 0.5;
    let mut next = || {
        x = (x + 0.618_033_988_749_894_9) % 1.0;
        (x * 977.0_f64).sin()
    };
    (0..STATES)
        .map(|_| {
            let mut q = model.skeleton.zero_pose();
            let turn: Vec<f64> = (0..model.nv()).map(|_| 2.0 * next()).collect();
            model.skeleton.integrate(&mut q, &turn, 1.0);
            let v = (0..model.nv()).map(|_| 10.0 * next()).collect();
            let vd = (0..model.nv()).map(|_| 100.0 * next()).collect();
            Sample { q, v, vd }
        })
        .collect()
}

/// Least time per call over the passes, µs.
fn least(samples: &[Sample], mut call: impl FnMut(&Sample)) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..PASSES {
        let start = cpu_s();
        samples.iter().for_each(&mut call);
        best = best.min((cpu_s() - start) / samples.len() as f64);
    }
    best * 1e6
}

#[cfg(unix)]
fn cpu_s() -> f64 {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    t.tv_sec as f64 + 1e-9 * t.tv_nsec as f64
}

#[cfg(not(unix))]
fn cpu_s() -> f64 {
    use std::sync::LazyLock;
    use std::time::Instant;
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed().as_secs_f64()
}

fn write_dump(dir: &Path, model: &Model, samples: &[Sample]) -> std::io::Result<()> {
    let n = model.nv();
    let g = model.gravity;
    let mut text = format!("{} {} {n} {}\n", model.bodies.len(), model.skeleton.nq(), samples.len());
    let row = |text: &mut String, numbers: &mut dyn Iterator<Item = f64>| {
        let words: Vec<String> = numbers.map(|x| format!("{x:e}")).collect();
        writeln!(text, "{}", words.join(" ")).expect("strings take text");
    };
    row(&mut text, &mut g.iter().copied());
    for b in &model.bodies {
        let (kind, axis) = match b.joint {
            Joint::Free => ("free", Vec3::zeros()),
            Joint::Spherical => ("ball", Vec3::zeros()),
            Joint::Revolute(axis) => ("hinge", axis),
            Joint::Prismatic(axis) => ("slide", axis),
            Joint::Fixed => panic!("the human's root is free"),
        };
        let r = b.parent_from_zero.rotation.to_rotation_matrix();
        let parent = b.parent.map_or(-1, |p| p as i64);
        writeln!(text, "{parent} {kind}").expect("strings take text");
        row(&mut text, &mut axis.iter().copied());
        row(&mut text, &mut r.matrix().transpose().iter().copied());
        row(&mut text, &mut b.parent_from_zero.translation.vector.iter().copied());
        row(&mut text, &mut std::iter::once(b.mass));
        row(&mut text, &mut b.com.iter().copied());
        row(&mut text, &mut b.inertia.transpose().iter().copied());
    }
    let mut bytes = Vec::new();
    let mut state = State::new(model);
    let (mut tau, mut m) = (vec![0.0; n], DMatrix::zeros(n, n));
    for s in samples {
        state.update(model, &s.q, &s.v);
        state.inverse_dynamics(model, &s.v, &s.vd, &[], &mut tau);
        state.mass_matrix(model, &mut m);
        for x in s.q.iter().chain(&s.v).chain(&s.vd).chain(&tau).chain(m.iter()) {
            bytes.extend_from_slice(&x.to_le_bytes());
        }
    }
    std::fs::create_dir_all(dir)?;
    std::fs::write(dir.join("model.txt"), text)?;
    std::fs::write(dir.join("states.bin"), bytes)
}
