//! GP regression against scikit-learn 1.9.1: the numbers come from `gp_by_sklearn.py`, which makes the same
//! data.

use learn::{GpRegression, Pairs, Prediction, Regressor, Scratch};
use nalgebra::DMatrix;

fn data(first: usize, count: usize) -> (DMatrix<f64>, DMatrix<f64>) {
    let at = |i: usize| (first + i) as f64;
    let y = DMatrix::from_fn(count, 3, |i, k| {
        let i = at(i);
        [(0.7 * i).sin(), (1.3 * i + 0.2).cos(), (0.31 * i * i).sin()][k]
    });
    let z = DMatrix::from_fn(count, 2, |r, k| {
        let i = at(r);
        let clean = [(2.0 * y[(r, 0)]).sin() + y[(r, 1)] * y[(r, 2)], (-y[(r, 1)]).exp() + 0.5 * y[(r, 0)]];
        clean[k] + 0.03 * [(37.7 * i * i).sin(), (91.3 * i * i).cos()][k]
    });
    (y, z)
}

const LIKELIHOOD: f64 = 26.222552212006264;
const KERNEL: [f64; 3] = [2.60 * 2.60, 2.56, 0.000219]; // theta1, length, noise, as printed
const MEAN: [[f64; 2]; 3] = [
    [0.8889850463868881, 1.5863998831690047],
    [1.7843652182076715, 0.8522345073986217],
    [1.615659778247296, 0.8470007786076799],
];
const VARIANCE: [f64; 3] = [0.00038520541700636635, 0.000787204663647619, 0.000904123768800177];

/// Another optimiser from twenty starts finds no better likelihood, and predicts the same.
#[test]
fn the_fit_is_that_of_scikit_learn() {
    let (y, z) = data(0, 40);
    let model = GpRegression::fit(&Pairs::new(&y, &z).unwrap()).unwrap();
    let likelihood = -model.learning().end;
    println!("{likelihood} {:?} {:?}", model.kernel(), model.learning());
    assert!((likelihood - LIKELIHOOD).abs() < 1e-3, "{likelihood}");
    let kernel = model.kernel();
    for (own, theirs) in [kernel.theta1, kernel.length(), kernel.noise()].iter().zip(KERNEL) {
        assert!((own / theirs - 1.0).abs() < 0.01, "{own} {theirs}"); // printed with three digits
    }
    let (mut scratch, mut out) = (Scratch::new(), Prediction::default());
    for (i, (mean, variance)) in MEAN.iter().zip(VARIANCE).enumerate() {
        let probe: Vec<f64> = data(100 + i, 1).0.iter().copied().collect();
        model.predict(&probe, &mut scratch, &mut out).unwrap();
        for (own, theirs) in out.mean.iter().zip(mean) {
            assert!((own - theirs).abs() < 1e-4, "{own} {theirs}");
        }
        assert!((out.variance / variance - 1.0).abs() < 1e-2, "{} {variance}", out.variance);
    }
}
