//! Contacts and forces of the characters that ship, after adjustment and after refinement: the tables of
//! `docs/RETARGET.md`.
//!
//! In: lamp, penguin, squirrel; the performances of `scenes/performances` and three clips of `../shared/mocap` that no
//! key pose was made from. Out: a row for each pair of them, at 30 Hz.
//!
//! ```sh
//! cargo run --release -p studies --example retargeting                      # the root's height moves
//! cargo run --release -p studies --example retargeting -- legs              # root and legs
//! cargo run --release -p studies --example retargeting -- contact           # contacts alone, in seconds
//! cargo run --release -p studies --example retargeting -- height lamp dance # one pair
//! ```

use std::path::PathBuf;

use formats::bvh::ImportOptions;
use retarget::{Options, PipelineStage, RefineDofs};
use takes::retargeting::{RetargetReport, Session};

const CHARACTERS: [&str; 3] = ["lamp", "penguin", "squirrel"];
const PERFORMANCES: [&str; 7] = ["anger", "dance", "disgust", "fear", "happiness", "sadness", "surprise"];
/// A walk, gestures, a ballet's turns.
const CLIPS: [&str; 3] = ["16_21", "14_24", "05_03"];
/// Rate at which all is measured, Hz: the paper's.
const RATE_HZ: f64 = 30.0;

fn path(name: &str) -> PathBuf {
    if CLIPS.contains(&name) || name.contains('_') {
        support::shared(&format!("mocap/bvh/{name}.bvh"))
    } else {
        support::scene(&format!("performances/{name}.ron"))
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let asked: Vec<String> = std::env::args().skip(1).collect();
    let dofs = match asked.first().map(String::as_str) {
        None | Some("height") => RefineDofs::RootHeight,
        Some("root") => RefineDofs::Root,
        Some("legs") => RefineDofs::RootAndLegs,
        Some("contact") => RefineDofs::default(),
        Some(other) => return Err(format!("`{other}` is none of height, root, legs, contact").into()),
    };
    let of = |at: usize, all: &[&str]| match asked.get(at) {
        Some(x) if x != "all" => x.split(',').map(str::to_owned).collect(),
        _ => all.iter().map(|&x| x.to_owned()).collect::<Vec<String>>(),
    };
    let every: Vec<&str> = PERFORMANCES.into_iter().chain(CLIPS).collect();
    println!("lengths in mm; jerk over that of the mapped motion; Z_p fell by %; frames outside the cone;");
    println!(
        "left: RMS mismatch of each component that is left, % of body weight (moments over the radius of gyration)"
    );
    println!(
        "                                 | slip depth jerk |   Fx   Fy   Fz   Nx   Ny   Nz |   all | left                    | root: median, most; slip | cone | steps | s"
    );
    for character in of(1, &CHARACTERS) {
        for performance in of(2, &every) {
            let to = support::scene(&format!("characters/{character}.ron"));
            let import = ImportOptions::default();
            let session = Session::open(&path(&performance), &to, None, &import)?;
            let mut options = Options { rate_hz: Some(RATE_HZ), ..Options::default() };
            options.refine.dofs = dofs.clone();
            if asked.first().is_some_and(|x| x == "contact") {
                options.stop_after = PipelineStage::Contact;
            }
            let mapping = session.learn(&options)?;
            let start = std::time::Instant::now();
            let done = session.run(&mapping, &options)?;
            let seconds = start.elapsed().as_secs_f64();
            let warnings = RetargetReport::new(&session, options.model, &done, Vec::new()).warnings;
            let Some(c) = &done.contact else { continue };
            print!(
                "{character:8} {performance:14} {:5.1} s | {:.2} {:.2} {:.2} | ",
                done.clip.duration_s(),
                1e3 * c.slip_m,
                1e3 * c.penetration_m,
                c.jerk_ratio,
            );
            let Some(r) = &done.refinement else {
                println!("{seconds:.1}");
                warnings.iter().for_each(|w| println!("         {w}"));
                continue;
            };
            let share = |i: usize| 100.0 * (1.0 - r.after[i] / r.before[i].max(1e-12));
            let sum = |x: &[f64; 6]| x.iter().sum::<f64>();
            let each: Vec<String> = (0..6).map(|i| format!("{:4.0}", share(i))).collect();
            let weight = r.weight_n;
            let frames = done.clip.frames() as f64;
            let left = r.after.map(|z| format!("{:3.1}", 100.0 * (2.0 * z / frames).sqrt() / weight));
            println!(
                "{} | {:5.1} | {} | {:5.1} {:5.1} {:.2} | {:2} → {:2} | {:2} | {seconds:.1}",
                each.join(" "),
                100.0 * (1.0 - sum(&r.after) / sum(&r.before)),
                left.join(" "),
                1e3 * r.root_median_m,
                1e3 * r.root_largest_m,
                1e3 * r.slip_m,
                r.cone_before.len(),
                r.cone_after.len(),
                r.iterations,
            );
            warnings.iter().for_each(|w| println!("         {w}"));
        }
    }
    Ok(())
}
