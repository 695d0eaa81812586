//! Inverse dynamics of recorded motion: would a biomechanist believe it?
//!
//! `cargo test --release -p dynamics --test analysis_clips -- --nocapture` prints the table.

use std::path::Path;

use dynamics::{Analysis, AnalysisOptions, BodyOptions, analyze, guess_body_of_clip};
use motion::Clip;
use motion::format::bvh::{ImportOptions, read_file};

fn clip(name: &str) -> Clip {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../shared/mocap/bvh/{name}.bvh"));
    read_file(&path, &ImportOptions::default()).unwrap_or_else(|e| panic!("{}: {e}", path.display())).0
}

fn analysed(name: &str) -> Analysis {
    let clip = clip(name);
    let (character, _) = guess_body_of_clip(&clip, &BodyOptions::default()).unwrap();
    analyze(&character, &clip, &AnalysisOptions::default()).unwrap()
}

fn column(table: &[f64], columns: usize, at: usize) -> Vec<f64> {
    table.iter().skip(at).step_by(columns).copied().collect()
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

#[test]
fn table() {
    for name in ["14_37", "127_01", "05_06", "02_01", "16_35", "16_21", "16_03", "09_01", "49_05"] {
        let a = analysed(name);
        let fy = column(&a.required_force, 3, 1);
        let n = a.frames();
        let max = |x: &[f64]| x.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        println!(
            "{name:8} n {n} rate {:.0} m {:.1} ground {:+.3} Fy/W mean {:.3} max {:.2} min {:.2} flight {} \
             cone {} ({:.2}) cop {} ({:.3}) residual F {:.0}/{:.0} M {:.0}/{:.0} {} noise F {:.0} tau {:.1} cutoff {:.1} ({:.1e} {:.2}) tau max {:.0}",
            a.rate_hz(),
            a.mass,
            a.ground_m.unwrap(),
            mean(&fy) / a.weight(),
            max(&fy) / a.weight(),
            fy.iter().copied().fold(f64::INFINITY, f64::min) / a.weight(),
            a.flight.iter().filter(|f| **f).count(),
            a.friction_violations.frames.len(),
            a.friction_violations.worst,
            a.support_violations.frames.len(),
            a.support_violations.worst,
            a.graded.force_peak,
            a.graded.force_rms,
            a.graded.moment_peak,
            a.graded.moment_rms,
            a.graded.grade(),
            a.noise.force,
            a.noise.tau[6..].iter().copied().fold(0.0, f64::max),
            a.smoothing.cutoff_hz,
            a.smoothing.strength.density,
            a.smoothing.strength.colour,
            max(&a.tau),
        );
    }
}

#[test]
#[ignore]
fn dump() {
    for name in ["16_35", "16_03", "02_01"] {
        let a = analysed(name);
        println!("{name}");
        for k in (0..a.frames()).step_by(3) {
            print!("{k:4} Fy {:5.2}", a.required_force[3 * k + 1] / a.weight());
            for f in &a.feet {
                print!(
                    " | {} h {:6.3} s {:5.2} cop {:6.2}",
                    if f.contact[k] { "C" } else { "-" },
                    f.height[k],
                    f.share[k],
                    f.cop[3 * k + 2]
                );
            }
            println!(" want {:5.2} {:5.2}", a.cop[3 * k], a.cop[3 * k + 2]);
        }
    }
}
