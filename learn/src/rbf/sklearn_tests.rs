//! Against scikit-learn 1.9.1: the numbers come from `tests/rbf_by_sklearn.py`, which makes the same data.

use nalgebra::DMatrix;

use super::evidence::{Evidence, Range, Ranges};
use super::targets::Targets;
use super::{RbfKernel, RbfOptions, RbfRegression};
use crate::cloud::Cloud;
use crate::examples::{Examples, Mirror};

const KERNEL: RbfKernel = RbfKernel::isotropic(0.8, 1.3, 0.01);

const WIDE: Ranges = {
    let all = Range::new(-20.0, 10.0);
    Ranges { signal: all, length: all, noise: all }
};

fn inputs(first: usize, count: usize) -> DMatrix<f64> {
    DMatrix::from_fn(count, 5, |r, k| {
        let i = (first + r) as f64;
        (0.7 * i + 1.9 * k as f64 + 0.013 * i * i).sin()
    })
}

fn targets(x: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(x.nrows(), 3, |r, k| {
        let (i, x) = (r as f64, x.row(r));
        let clean = [(2.0 * x[0]).sin() + x[1] * x[2], 0.5 * x[3] - x[0], (x[4] + x[1]).cos()];
        clean[k] + 0.03 * (37.7 * i * i + k as f64).sin()
    })
}

fn mirror() -> Mirror {
    Mirror {
        input: vec![(1, 1.0), (0, 1.0), (2, -1.0), (4, -1.0), (3, -1.0)],
        output: vec![(0, -1.0), (2, 1.0), (1, 1.0)],
    }
}

struct Theirs {
    likelihood: f64,
    gradient: [f64; 3],
    mean: [[f64; 3]; 3],
    variance: [f64; 3],
    fitted: [f64; 3],
    best: f64,
}

const AS_THEY_ARE: Theirs = Theirs {
    likelihood: 108.96214976374395,
    gradient: [-8.360039253395406, 35.459137031123326, -51.3968396035021],
    mean: [
        [-0.6895576151917667, 0.39963644484784194, 0.5654283282594637],
        [1.2050930228566574, -0.25475618917111637, 0.3270176428438105],
        [-0.908476652064698, 0.18548067777020696, 0.06721025586817543],
    ],
    variance: [0.013383672781920432, 0.013380062510877977, 0.01214598118303889],
    fitted: [1.019354742072529, 1.8857287895736203, 0.0001269291188427376],
    best: 291.9851499045118,
};

const WITH_IMAGES: Theirs = Theirs {
    likelihood: 219.47966256233428,
    gradient: [-16.20351135075775, 72.09731154490748, -102.79435922775792],
    mean: [
        [-0.6899705904351007, 0.39990321098463355, 0.5638886161065628],
        [1.2065292271102024, -0.25484437030037316, 0.32712641926010105],
        [-0.9085825698242472, 0.18533628293130278, 0.06675754008612723],
    ],
    variance: [0.013382114496560684, 0.013379197292941347, 0.01214567934697397],
    fitted: [1.3106229295952168, 1.9716491976643895, 0.00012717122295786076],
    best: 586.3430306124349,
};

/// Largest difference in units of the other number, or of one if that is smaller.
fn apart(own: &[f64], theirs: &[f64]) -> f64 {
    own.iter().zip(theirs).map(|(a, b)| (a - b).abs() / b.abs().max(1.0)).fold(0.0, f64::max)
}

/// Likelihood, gradient, mean and variance at one kernel to 1e-6 (~1e-12 seen), and the same optimum.
#[test]
fn the_regression_is_that_of_scikit_learn() {
    for (mirror, theirs) in [(None, AS_THEY_ARE), (Some(mirror()), WITH_IMAGES)] {
        let x = inputs(0, 45);
        let y = targets(&x);
        let examples = Examples::new(x, y, mirror).unwrap();
        let (cloud, targets) = (Cloud::of(&examples), Targets::of(&examples, false));
        let mut evidence = Evidence::new(&cloud, &examples, &targets, WIDE);
        let (value, by) = evidence.at(&KERNEL, true).unwrap();
        let mut seen = vec![apart(&[-value], &[theirs.likelihood])];
        let down: Vec<f64> = by.iter().map(|v| -v).collect();
        seen.push(apart(&down, &theirs.gradient));

        let options = RbfOptions { kernel: Some(KERNEL), ..RbfOptions::default() };
        let model = RbfRegression::fit(&examples, &options).unwrap();
        seen.push(apart(&[model.log_likelihood()], &[theirs.likelihood]));
        let batch = model.predict_batch(&inputs(100, 3)).unwrap();
        for (i, mean) in theirs.mean.iter().enumerate() {
            seen.push(apart(batch.mean.row(i).transpose().as_slice(), mean));
        }
        seen.push(apart(&batch.variance, &theirs.variance));
        println!("{seen:?}");
        assert!(seen.iter().all(|v| *v < 1e-9), "{seen:?}");

        let fitted = RbfRegression::fit(&examples, &RbfOptions::default()).unwrap();
        assert!((fitted.log_likelihood() / theirs.best - 1.0).abs() < 1e-6, "{}", fitted.log_likelihood());
        let k = fitted.kernel();
        for (own, theirs) in [k.signal_variance, k.length, k.noise_variance].iter().zip(theirs.fitted) {
            assert!((own / theirs - 1.0).abs() < 1e-2, "{own} {theirs}");
        }
    }
}

/// The gradient is that of differences, with images and without, with groups and without, at kernels far apart.
#[test]
fn the_gradient_is_the_slope() {
    use crate::descend::Objective;
    for (mirror, groups) in [(None, 1), (Some(mirror()), 1), (None, 3), (Some(mirror()), 3)] {
        let examples = in_groups(mirror, groups);
        let (cloud, targets) = (Cloud::of(&examples), Targets::of(&examples, true));
        let ranges = Ranges {
            signal: Range::new(-6.0, 4.0),
            length: Range::new(-3.0, 1.5),
            noise: Range::new(-9.0, 2.0),
        };
        let mut evidence = Evidence::new(&cloud, &examples, &targets, ranges);
        for [signal, length, noise] in [[0.0, 0.0, 0.0], [1.0, -0.5, -3.0], [-2.0, 1.0, 2.0]] {
            let lengths = (0..groups).map(|g| length + 0.2 * g as f64);
            let p: Vec<f64> = [signal].into_iter().chain(lengths).chain([noise]).collect();
            let mut gradient = vec![0.0; p.len()];
            evidence.evaluate(&p, &mut gradient).unwrap();
            for k in 0..p.len() {
                let mut at = |h: f64| {
                    let mut p = p.clone();
                    p[k] += h;
                    evidence.evaluate(&p, &mut vec![0.0; p.len()]).unwrap()
                };
                let h = 1e-4;
                let slope = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
                let error = (gradient[k] - slope).abs() / slope.abs().max(1.0); // ~1e-9 seen
                assert!(error < 1e-6, "{p:?} {k}: {} {slope}", gradient[k]);
            }
        }
    }
}

/// Ninety examples, coordinates in so many groups that the mirror keeps.
fn in_groups(mirror: Option<Mirror>, groups: usize) -> Examples {
    let x = inputs(0, 90);
    let y = targets(&x);
    let of = if groups == 1 { vec![0; 5] } else { vec![0, 0, 1, 2, 2] };
    Examples::new(x, y, mirror).and_then(|e| e.with_groups(of)).unwrap()
}

/// Two halves have the likelihood and the gradient of examples with their images appended, to rounding.
#[test]
fn two_halves_are_the_whole() {
    let x = inputs(0, 70);
    let y = targets(&x);
    let m = mirror();
    let twice =
        |map: &[(usize, f64)], a: &DMatrix<f64>| {
            let n = a.nrows();
            DMatrix::from_fn(2 * n, a.ncols(), |i, k| {
                if i < n { a[(i, k)] } else { map[k].1 * a[(i - n, map[k].0)] }
            })
        };
    let whole = Examples::new(twice(&m.input, &x), twice(&m.output, &y), None).unwrap();
    let halves = Examples::new(x, y, Some(m)).unwrap();
    let at = |e: &Examples| {
        let (cloud, targets) = (Cloud::of(e), Targets::of(e, false));
        Evidence::new(&cloud, e, &targets, WIDE).at(&KERNEL, true).unwrap()
    };
    let (a, b) = (at(&halves), at(&whole));
    assert!((a.0 / b.0 - 1.0).abs() < 1e-12, "{} {}", a.0, b.0);
    assert!(apart(&a.1, &b.1) < 1e-11, "{:?} {:?}", a.1, b.1);
}
