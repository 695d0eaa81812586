//! The shipped scenes in the core and in rapier, at the same settings.
//!
//! In: scenes (all of the library that are scripts, unless named), tensions, rates, substeps. Out: a line per run: what each engine says of
//! it, how far the links are apart, the force that neither explains, and what the core counted.
//!
//! ```sh
//! cargo run --release -p studies --example engines -- --rates 240 --substeps 2 --tensions 1 bow twist
//! ```

use std::time::Instant;

use motion::skeleton::vec_at;
use sim::{Engines, Outcome};
use takes::{Ask, Overrides};

const SCENES: [&str; 14] = [
    "bow",
    "chest",
    "crate",
    "greet",
    "greet-late",
    "reach",
    "reach-slack",
    "seesaw",
    "slope",
    "stand",
    "twist",
    "twist-shy",
    "twitch",
    "wave",
];

/// RMS and largest distance of the links' centres of mass, m, over the rows both performed, and the time of the largest, s.
fn apart(a: &Outcome, b: &Outcome) -> (f64, f64, f64) {
    let n = a.trace.link_com.len().min(b.trace.link_com.len());
    let per_row = a.trace.link_com.len() / a.trace.rows();
    let (mut sum, mut most, mut when) = (0.0, 0.0_f64, 0.0);
    for i in (0..n).step_by(3) {
        let d = (vec_at(&a.trace.link_com, i) - vec_at(&b.trace.link_com, i)).norm();
        sum += d * d;
        if d > most {
            (most, when) = (d, (i / per_row) as f64 / a.trace.rate_hz);
        }
    }
    ((sum / (n / 3).max(1) as f64).sqrt(), most, when)
}

/// RMS of the force that nothing explains, % of body weight.
fn unexplained(o: &Outcome) -> f64 {
    let all: Vec<f64> = o.trace.residual().chunks_exact(6).map(|w| vec_at(w, 0).norm_squared()).collect();
    let rms = (all.iter().sum::<f64>() / all.len() as f64).sqrt();
    100.0 * rms / (o.trace.character.mass() * 9.81)
}

fn end(o: &Outcome) -> String {
    match (o.fell_s, &o.diverged) {
        (_, Some(_)) => "diverged".into(),
        (Some(t), None) => format!("falls {t:.2} s"),
        (None, None) => o.verdict.grade().name().to_string(),
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut rates, mut substeps, mut tensions, mut names) = (vec![240.0], vec![2], vec![1.0], Vec::new());
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut numbers = || -> Result<Vec<f64>, Box<dyn std::error::Error>> {
            let list = words.next().ok_or("a list of numbers is missing")?;
            Ok(list.split(',').map(str::parse).collect::<Result<_, _>>()?)
        };
        match word.as_str() {
            "--rates" => rates = numbers()?,
            "--substeps" => substeps = numbers()?.iter().map(|x| *x as usize).collect(),
            "--tensions" => tensions = numbers()?,
            _ => names.push(word),
        }
    }
    if names.is_empty() {
        names = SCENES.map(String::from).to_vec();
    }
    let engines = Engines::default();
    println!(
        "scene, Hz × substeps, tension | core | rapier | links mm: RMS, most (at s) | unexplained % of weight: core, rapier | core corrected %, unsolved, worst residual, contact left m/s | × real time: core, rapier"
    );
    for name in &names {
        for &rate_hz in &rates {
            for &substeps in &substeps {
                for &tension in &tensions {
                    let overrides = Overrides {
                        rate_hz: Some(rate_hz),
                        substeps: Some(substeps),
                        tension: (tension != 1.0).then_some(tension),
                        ..Overrides::default()
                    };
                    let ask = Ask { overrides, ..Ask::default() };
                    let run = |engine: &str| -> Result<(Outcome, f64), Box<dyn std::error::Error>> {
                        let mut take = takes::open(support::scene(&format!("{name}.ron")), &ask)?;
                        take.conditions.engine = Some(engine.into());
                        let start = Instant::now();
                        let outcome = take.outcome(&engines, &mut |_| {})?;
                        let seconds = outcome.trace.rows() as f64 / outcome.trace.rate_hz;
                        Ok((outcome, seconds / start.elapsed().as_secs_f64()))
                    };
                    let ((core, fast), (rapier, slow)) = (run("core")?, run("rapier")?);
                    let (rms, most, when) = apart(&core, &rapier);
                    let l = core.ledger.unwrap_or_default();
                    let corrected =
                        100.0 * l.correction_rms_n(rate_hz) / (core.trace.character.mass() * 9.81);
                    println!(
                        "{name}, {rate_hz} × {substeps}, {tension} | {} | {} | {:.2}, {:.1} ({when:.2}) | {:.4}, {:.4} | {corrected:.4}, {} of {} ({} loose; {:.1} sweeps, {:.1} steps, {} resolved, {} halved of {} substeps), {:.1e}, {:.1e} | {fast:.0}, {slow:.1}",
                        end(&core),
                        end(&rapier),
                        1e3 * rms,
                        1e3 * most,
                        unexplained(&core),
                        unexplained(&rapier),
                        l.above_tight,
                        l.touching,
                        l.above_loose,
                        l.sweeps as f64 / l.touching.max(1) as f64,
                        l.newton_steps as f64 / l.touching.max(1) as f64,
                        l.resolved,
                        l.halved,
                        l.substeps,
                        l.worst_residual,
                        l.worst_slip,
                    );
                }
            }
        }
    }
    Ok(())
}
