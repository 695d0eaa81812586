//! What inducing points cost: 1,500 examples and their images, as they are and through fewer points; unseen frames between
//! them.
//!
//! `cargo run --release -p learn --example inducing` prints, in units of the targets' standard deviation, the RMS error of
//! 1,000 unseen frames, the RMS difference from the whole, and the mean ratio of variances: at the kernel of the whole by the number of
//! points, and with the kernel learned from fewer examples.

#[path = "../benches/common/data.rs"]
mod data;
#[path = "../benches/common/side.rs"]
mod side;

use learn::{Batch, Examples, Mirror, RbfOptions, RbfRegression};
use nalgebra::DMatrix;
use side::side;

const EXAMPLES: usize = 1500;
const INPUTS: usize = 180;
const TARGETS: usize = 62;

fn rms(difference: &DMatrix<f64>) -> f64 {
    difference.norm() / (difference.len() as f64).sqrt()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut frames = data::motion(2 * EXAMPLES, INPUTS + TARGETS, 17);
    for mut column in frames.column_iter_mut() {
        let (mean, scale) = (column.mean(), column.variance().sqrt());
        column.apply(|v| *v = (*v - mean) / scale);
    }
    let every_second = |first: usize, count: usize| {
        let rows: Vec<usize> = (0..count).map(|i| 2 * i + first).collect();
        let rows = frames.select_rows(&rows);
        (rows.columns(0, INPUTS).into_owned(), rows.columns(INPUTS, TARGETS).into_owned())
    };
    let (inputs, targets) = every_second(0, EXAMPLES);
    let (unseen, wanted) = every_second(1, 1000);
    let mirror = Mirror { input: side(INPUTS), output: side(TARGETS) };
    let examples = Examples::new(inputs, targets, Some(mirror))?;
    let whole = RbfRegression::fit(&examples, &RbfOptions::default())?;
    let all = whole.predict_batch(&unseen)?;
    println!("as they are: RMS error {:.4}, kernel {:?}", rms(&(&all.mean - &wanted)), whole.kernel());
    let line = |what: String, batch: &Batch| {
        let ratios = batch.variance.iter().zip(&all.variance).map(|(a, b)| a / b);
        println!(
            "{what}: RMS error {:.4}, from the whole {:.4}, variance over the whole's {:.2}",
            rms(&(&batch.mean - &wanted)),
            rms(&(&batch.mean - &all.mean)),
            ratios.sum::<f64>() / batch.variance.len() as f64
        );
    };
    for inducing in [100, 200, 400, 750, 1000, 1500] {
        let options =
            RbfOptions { exact_up_to: 0, inducing, kernel: Some(whole.kernel()), ..RbfOptions::default() };
        let model = RbfRegression::fit(&examples, &options)?;
        line(format!("{inducing} points"), &model.predict_batch(&unseen)?);
    }
    for exact_up_to in [500, 1000, 2000] {
        let model = RbfRegression::fit(&examples, &RbfOptions { exact_up_to, ..RbfOptions::default() })?;
        line(format!("750 points, kernel of {exact_up_to} examples"), &model.predict_batch(&unseen)?);
    }
    Ok(())
}
