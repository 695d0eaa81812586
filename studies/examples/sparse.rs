//! What inducing points cost an edit of real motion: thousands of frames as they are and through fewer points; prints the table of
//! `docs/BY_EXAMPLE.md`.
//!
//! `cargo run --release -p studies --example sparse -- [FRAMES]`: frames taught (3000; images with left and right exchanged come on top). The
//! edit is *spine + 0.5 knee*, clips are of `../shared/mocap`; RMS error of the configuration model on 16_13 and 16_18, degrees. All
//! models have the kernel that is learned by default.

use std::error::Error;

use edits::by_example::features::Features;
use edits::by_example::{ExampleEdit, ExampleOptions, Pair, Rig, outputs};
use formats::bvh::ImportOptions;
use learn::{RbfOptions, RbfRegression};
use nalgebra::DMatrix;
use studies::propagate::compare::{spread, taught};
use studies::propagate::rules::{Rule, pair};

const TRAINING: [&str; 10] =
    ["16_16", "16_20", "16_21", "16_30", "16_33", "49_01", "17_03", "02_01", "14_24", "135_04"];
const UNSEEN: [&str; 2] = ["16_13", "16_18"];

fn main() -> Result<(), Box<dyn Error>> {
    let frames = std::env::args().nth(1).map_or(Ok(3000), |a| a.parse())?;
    let ruled = |names: &[&str]| -> Result<Vec<Pair>, Box<dyn Error>> {
        let one = |name: &&str| -> Result<Pair, Box<dyn Error>> {
            let path = support::shared(&format!("mocap/bvh/{name}.bvh"));
            Ok(pair(Rule::SpineByKnee, name, &formats::open_clip(&path, &ImportOptions::default())?.0)?)
        };
        names.iter().map(one).collect()
    };
    let training = ruled(&TRAINING)?;
    let chosen = spread(&training, frames, 1e9);
    let options = ExampleOptions::default();
    let edit = ExampleEdit::learn(&taught(&training, &chosen), &options)?;
    let examples = edit.configuration.examples();
    let kernel = edit.configuration.as_gp().ok_or("no Gaussian process")?.kernel();
    let asked: Vec<(DMatrix<f64>, DMatrix<f64>)> = ruled(&UNSEEN)?
        .iter()
        .map(|p| {
            let rig = Rig::find(&edit.rig, &p.source.skeleton)?;
            let all: Vec<usize> = (0..p.source.frames()).collect();
            let x = Features::of(&rig, &p.source, &all, options.recognised()).configuration;
            Ok((x, outputs::differences((&rig, &p.source), (&rig, &p.target), None)))
        })
        .collect::<Result<_, Box<dyn Error>>>()?;
    println!("{} examples, {} with images; {kernel:?}", examples.len(), examples.effective());
    println!("{:>20} {:>10} {:>22} {:>10}", "", "error °", "from as they are °", "variance");
    let mut whole: Option<Vec<learn::Batch>> = None;
    for inducing in [None, Some(1500), Some(750), Some(400), Some(100)] {
        let exact_up_to = if inducing.is_none() { usize::MAX } else { 0 };
        let settings = RbfOptions {
            exact_up_to,
            inducing: inducing.unwrap_or(1),
            kernel: Some(kernel),
            ..RbfOptions::default()
        };
        let model = RbfRegression::fit(examples, &settings)?;
        let found = asked.iter().map(|(x, _)| model.predict_batch(x)).collect::<Result<Vec<_>, _>>()?;
        let all: usize = asked.iter().map(|(x, _)| x.nrows()).sum();
        let rms = |sum: f64| (sum / all as f64).sqrt().to_degrees();
        let error = rms(found.iter().zip(&asked).map(|(b, (_, y))| (&b.mean - y).norm_squared()).sum());
        let whole = whole.get_or_insert_with(|| found.clone());
        let apart =
            rms(found.iter().zip(whole.iter()).map(|(a, b)| (&a.mean - &b.mean).norm_squared()).sum());
        let variance = |of: &[learn::Batch]| of.iter().flat_map(|b| &b.variance).sum::<f64>();
        let name = inducing.map_or("as they are".into(), |i| format!("{i} points"));
        println!("{name:>20} {error:>10.3} {apart:>22.3} {:>10.2}", variance(&found) / variance(whole));
    }
    Ok(())
}
