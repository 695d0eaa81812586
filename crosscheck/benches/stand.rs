//! A step of the standing human in the core, in MuJoCo and in rapier, in one interleaved run.
//!
//! In: the same body, the same springs and dampers, the same ground, self-collision off in all, then on in all, MuJoCo's own threads off (it
//! has none unless asked). Out: least times per step of many short blocks of all three, taken in turn; of MuJoCo those that `mj_step(m, d, 24)`
//! takes inside its process, so that neither Python nor the pipe counts. The core and rapier are given their drives every step, as in a
//! pass; MuJoCo's springs are part of its model.
//!
//! ```sh
//! cargo bench -p crosscheck --bench stand
//! ```

use std::hint::black_box;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use bodies::Character;
use bodies::anthropometry::human::human;
use controllers::{Drive, rest_of};
use formats::mjcf::{self, MjcfOptions};
use motion::{Floor, Vec3};
use sim::{Core, Engine, EngineSettings, Rapier};

const RATE_HZ: f64 = 240.0;
const STIFFNESS: f64 = 5000.0;
const DAMPING: f64 = 200.0;
const GRAVITY: Vec3 = Vec3::new(0.0, -9.81, 0.0);
const GROUND: Floor = Floor::level(0.0, 0.8);
/// Steps per block.
const BLOCK: usize = 24;
const BLOCKS: usize = 400;

/// MuJoCo's side: loads a model, then for every line it reads takes a block of steps and says how long they took, s.
const SIDE: &str = r#"
import sys, time
import numpy as np, mujoco
m = mujoco.MjModel.from_xml_path(sys.argv[1])
rate, stiffness, damping, block = (float(x) for x in sys.argv[2:6])
m.opt.timestep = 1.0 / rate
m.opt.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
d = mujoco.MjData(m)
if m.nkey:
    mujoco.mj_resetDataKeyframe(m, d, 0)
m.qpos_spring[:] = d.qpos
m.jnt_stiffness[:] = np.where(m.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE), 0.0, stiffness)
m.dof_damping[6:] = damping
m.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_LIMIT)
for _ in sys.stdin:
    start = time.perf_counter()
    mujoco.mj_step(m, d, int(block))
    took = time.perf_counter() - start
    cones = {0: "pyramidal", 1: "elliptic"}
    print(took, d.ncon, d.nefc, int(d.solver_niter[0]), float(d.qpos[1]), mujoco.__version__,
          cones[int(m.opt.cone)], m.opt.tolerance, m.opt.iterations, flush=True)
"#;

fn settings(substeps: usize, self_collision: bool) -> EngineSettings {
    EngineSettings {
        rate_hz: RATE_HZ,
        substeps,
        gravity: GRAVITY,
        ground: Some(GROUND),
        pinned: false,
        contact: Default::default(),
        props: Default::default(),
        self_collision,
    }
}

fn drives(engine: &dyn Engine, c: &Character) -> Vec<Drive> {
    let drive = |i: usize| Drive {
        stiffness: STIFFNESS,
        damping: DAMPING,
        rest: rest_of(engine.model(), i, &c.rest),
    };
    (0..engine.model().bodies.len()).map(drive).collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let python = crosscheck::environment::prepare(&mut |note| eprintln!("{note}"))?;
    compare(&python, false)?;
    compare(&python, true)
}

fn compare(python: &Path, self_collision: bool) -> Result<(), Box<dyn std::error::Error>> {
    let c = human().0;
    let options = MjcfOptions {
        self_collision,
        gravity: GRAVITY,
        ground: Some(GROUND),
        pose: Some(c.rest.clone()),
        ..MjcfOptions::default()
    };
    let folder = tempfile::tempdir()?;
    let model = folder.path().join("human.xml");
    std::fs::write(&model, mjcf::write(&c, &options)?.text)?;
    let mut mujoco = Command::new(python)
        .args(["-c", SIDE, &model.to_string_lossy()])
        .args([RATE_HZ, STIFFNESS, DAMPING, BLOCK as f64].map(|x| x.to_string()))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()?;
    let mut ask = mujoco.stdin.take().ok_or("no pipe")?;
    let mut answers = BufReader::new(mujoco.stdout.take().ok_or("no pipe")?);

    let still = vec![0.0; c.skeleton.nv()];
    let mut ours: Vec<(&str, Box<dyn Engine>, Vec<Drive>)> = Vec::new();
    for (name, engine) in [
        (
            "core, 1 substep",
            Box::new(Core::new(&c, settings(1, self_collision), &c.rest, &still)?) as Box<dyn Engine>,
        ),
        ("core, 2 substeps", Box::new(Core::new(&c, settings(2, self_collision), &c.rest, &still)?)),
        ("rapier, 1 substep", Box::new(Rapier::new(&c, settings(1, self_collision), &c.rest, &still)?)),
    ] {
        let drives = drives(engine.as_ref(), &c);
        ours.push((name, engine, drives));
    }
    let mut best = vec![f64::INFINITY; ours.len() + 1];
    let mut said = String::new();
    for block in 0..BLOCKS + 10 {
        writeln!(ask, "step")?;
        ask.flush()?;
        said.clear();
        answers.read_line(&mut said)?;
        let took: f64 = said.split_whitespace().next().ok_or("MuJoCo ended")?.parse()?;
        let mut times = vec![took];
        for (_, engine, drives) in &mut ours {
            let start = Instant::now();
            for _ in 0..BLOCK {
                engine.set_drives(black_box(drives));
                engine.step()?;
            }
            times.push(start.elapsed().as_secs_f64());
        }
        if block >= 10 {
            for (best, t) in best.iter_mut().zip(times) {
                *best = best.min(t / BLOCK as f64);
            }
        }
    }
    drop(ask);
    mujoco.wait()?;
    let words: Vec<&str> = said.split_whitespace().collect();
    println!(
        "standing human, {} degrees of freedom, {RATE_HZ} Hz, self-collision {}; {BLOCKS} blocks of {BLOCK} steps taken in turn; least times",
        c.skeleton.nv(),
        if self_collision { "on" } else { "off" }
    );
    println!(
        "MuJoCo {} discrete: {:6.2} µs; {} contacts, {} rows, {} iterations, {} cone, tolerance {}, at most {} iterations; root at {} m",
        words[5],
        best[0] * 1e6,
        words[1],
        words[2],
        words[3],
        words[6],
        words[7],
        words[8],
        words[4]
    );
    assert!(words[4].parse::<f64>()? > 0.8, "MuJoCo's body has fallen");
    for ((name, engine, _), t) in ours.iter().zip(&best[1..]) {
        let mut contacts = Vec::new();
        engine.contacts(&mut contacts);
        println!(
            "{name}: {:6.2} µs = {:.3} × MuJoCo; {} contacts; root at {:.4} m",
            t * 1e6,
            t / best[0],
            contacts.len(),
            engine.q()[1]
        );
        if let Some(l) = engine.ledger() {
            println!(
                "  worst residual {:.1e} m g dt over all steps, {} of {} above 1e-6; {:.2} sweeps and {:.2} Newton steps a solution",
                l.worst_residual,
                l.above_tight,
                l.touching,
                l.sweeps as f64 / l.touching as f64,
                l.newton_steps as f64 / l.touching as f64
            );
        }
    }
    Ok(())
}
