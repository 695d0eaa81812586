//! Gaussian process regression of examples against the formulas with an explicit inverse, and its laws.

mod common {
    pub mod examples;
}

use common::examples::{doubled, examples, mirror, mirrored, noisy, uniform};
use learn::{Examples, RbfKernel, RbfOptions, RbfRegression};
use nalgebra::DMatrix;

const KERNEL: RbfKernel = RbfKernel { signal_variance: 0.9, length: 1.7, noise_variance: 0.003 };

fn at(kernel: RbfKernel) -> RbfOptions {
    RbfOptions { kernel: Some(kernel), ..RbfOptions::default() }
}

fn kernel_matrix(k: &RbfKernel, a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(a.nrows(), b.nrows(), |i, j| {
        let r2 = (a.row(i) - b.row(j)).norm_squared();
        k.signal_variance * (-0.5 * r2 / k.length.powi(2)).exp()
    })
}

/// Mean, variance and log likelihood by K⁻¹ of examples and images.
fn plain(e: &Examples, k: &RbfKernel, frames: &DMatrix<f64>) -> (DMatrix<f64>, Vec<f64>, f64) {
    let (x, y) = doubled(e);
    let n = x.nrows();
    let kxx = kernel_matrix(k, &x, &x) + DMatrix::identity(n, n) * k.noise_variance;
    let inverse = kxx.clone().try_inverse().unwrap();
    let ln_det = 2.0 * kxx.cholesky().unwrap().l().diagonal().map(f64::ln).sum();
    let star = kernel_matrix(k, frames, &x);
    let variance = (0..frames.nrows())
        .map(|i| {
            let s = star.row(i);
            k.signal_variance + k.noise_variance - (s * &inverse * s.transpose())[(0, 0)]
        })
        .collect();
    let d = y.ncols() as f64;
    let likelihood = -0.5 * (y.transpose() * &inverse * &y).trace()
        - 0.5 * d * (ln_det + n as f64 * (2.0 * std::f64::consts::PI).ln());
    (star * inverse * y, variance, likelihood)
}

/// Both ways to predict are the formulas, with a mirror and without, above and below the size of a block.
#[test]
fn predictions_are_those_of_the_explicit_inverse() {
    for (n, with_mirror) in [(1, false), (1, true), (7, true), (64, false), (130, true), (150, false)] {
        let e = examples(n, 3, with_mirror);
        let model = RbfRegression::fit(&e, &at(KERNEL)).unwrap();
        let frames = uniform(70, 8, 77);
        let (mean, variance, likelihood) = plain(&e, &KERNEL, &frames);
        let batch = model.predict_batch(&frames).unwrap();
        let worst = (&batch.mean - &mean).amax(); // ~1e-12 seen
        assert!(worst < 1e-10, "{n} {with_mirror}: {worst:e}");
        for (own, theirs) in batch.variance.iter().zip(&variance) {
            assert!((own - theirs).abs() < 1e-10, "{n} {with_mirror}: {own} {theirs}");
        }
        let own = model.log_likelihood();
        assert!((own - likelihood).abs() < 1e-9 * likelihood.abs().max(1.0), "{own} {likelihood}");
    }
}

/// f(M x) = M' f(x), to the bit.
#[test]
fn a_mirrored_input_has_the_mirrored_answer() {
    let e = examples(40, 5, true);
    let model = RbfRegression::fit(&e, &RbfOptions::default()).unwrap();
    let frames = noisy(20, 9).0;
    let (a, b) = (
        model.predict_batch(&frames).unwrap(),
        model.predict_batch(&mirrored(&mirror().input, &frames)).unwrap(),
    );
    assert_eq!(mirrored(&mirror().output, &a.mean), b.mean);
    assert_eq!((a.variance, a.novelty), (b.variance, b.novelty));
}
