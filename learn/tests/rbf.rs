//! Gaussian process regression of examples against the formulas with an explicit inverse, and its laws.

mod common {
    pub mod examples;
}

use common::examples::{doubled, examples, mirror, mirrored, noisy, rule, uniform};
use learn::{Examples, Moment, Prediction, RbfKernel, RbfOptions, RbfRegression, Scratch};
use nalgebra::DMatrix;

const KERNEL: RbfKernel = RbfKernel::isotropic(0.9, 1.7, 0.003);

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

/// One input at a time is the same to rounding, and a row of a batch does not depend on the others, to the bit.
#[test]
fn rows_stand_for_themselves() {
    for with_mirror in [false, true] {
        let model = RbfRegression::fit(&examples(60, 5, with_mirror), &RbfOptions::default()).unwrap();
        let frames = noisy(90, 9).0;
        let all = model.predict_batch(&frames).unwrap();
        let part = model.predict_batch(&frames.rows(71, 3).into_owned()).unwrap();
        let (mut scratch, mut out) = (Scratch::new(), Prediction::default());
        for i in 71..74 {
            assert_eq!(all.mean.row(i), part.mean.row(i - 71));
            assert_eq!(all.variance[i], part.variance[i - 71]);
            let row: Vec<f64> = frames.row(i).iter().copied().collect();
            model.predict(&row, &mut scratch, &mut out).unwrap();
            for (a, b) in out.mean.iter().zip(all.mean.row(i).iter()) {
                assert!((a - b).abs() < 1e-10, "{a} {b}"); // 1e-13 seen
            }
            assert!((out.variance - all.variance[i]).abs() < 1e-10);
            assert!((out.novelty - all.novelty[i]).abs() < 1e-9);
            assert!((out.confidence - all.confidence[i]).abs() < 1e-9);
        }
    }
}

/// Two fits of the same examples are the same, to the bit.
#[test]
fn fitting_is_deterministic() {
    let e = examples(80, 2, true);
    let fit = || RbfRegression::fit(&e, &RbfOptions::default()).unwrap();
    assert_eq!(fit(), fit());
}

/// The fit finds the noise, and predicts new inputs within it.
#[test]
fn the_rule_is_learned() {
    let model = RbfRegression::fit(&examples(300, 1, true), &RbfOptions::default()).unwrap();
    let frames = uniform(200, 8, 50);
    let batch = model.predict_batch(&frames).unwrap();
    let error = (&batch.mean - rule(&frames)).norm() / (200.0 * 5.0_f64).sqrt();
    let noise = model.noise().sqrt(); // uniform of half width 0.02 has 0.0115
    println!("{error} {noise} {:?} {:?}", model.kernel(), model.learning());
    assert!(error < 0.04, "{error}");
    assert!((0.005..0.02).contains(&noise), "{noise}");
    // Variances are those of the errors, in the mean.
    let told = (batch.variance.iter().sum::<f64>() / 200.0).sqrt();
    assert!((0.5..2.0).contains(&(told / error)), "{told} {error}");
}

fn split(e: &Examples, at: usize) -> (Examples, Examples) {
    let numbers: Vec<usize> = (0..e.len()).collect();
    (e.subset(&numbers[..at]).unwrap(), e.subset(&numbers[at..]).unwrap())
}

/// Growing is fitting all examples at the same kernel, in one step and in many.
#[test]
fn growing_is_fitting_at_the_same_kernel() {
    for with_mirror in [false, true] {
        let e = examples(150, 6, with_mirror);
        let whole = RbfRegression::fit(&e, &at(KERNEL)).unwrap();
        let frames = uniform(10, 8, 3);
        let wanted = whole.predict_batch(&frames).unwrap();
        for first in [1, 64, 100, 149] {
            let (few, more) = split(&e, first);
            let mut grown = RbfRegression::fit(&few, &at(KERNEL)).unwrap();
            if first == 100 {
                for i in 0..more.len() {
                    grown.grow(&more.subset(&[i]).unwrap()).unwrap();
                }
            } else {
                grown.grow(&more).unwrap();
            }
            let batch = grown.predict_batch(&frames).unwrap();
            let worst = (&batch.mean - &wanted.mean).amax(); // ~1e-12 seen
            assert!(worst < 1e-10, "{with_mirror} {first}: {worst:e}");
            for (a, b) in batch.variance.iter().zip(&wanted.variance) {
                assert!((a - b).abs() < 1e-11);
            }
            for (a, b) in batch.novelty.iter().zip(&wanted.novelty) {
                assert!((a - b).abs() < 1e-9 * b);
            }
            assert!((grown.log_likelihood() / whole.log_likelihood() - 1.0).abs() < 1e-10);
            assert_eq!(grown.examples(), whole.examples());
        }
    }
}

/// What cannot be added is refused, and the model is what it was.
#[test]
fn what_does_not_fit_is_not_added() {
    let mut model = RbfRegression::fit(&examples(20, 1, true), &at(KERNEL)).unwrap();
    let before = model.clone();
    let told = |e: Examples, model: &mut RbfRegression| model.grow(&e).unwrap_err().to_string();
    assert_eq!(told(examples(5, 2, false), &mut model), "examples to be added have other mirrors");
    let narrow = Examples::new(DMatrix::zeros(1, 7), DMatrix::zeros(1, 5), None).unwrap();
    assert_eq!(told(narrow, &mut model), "input vectors to be added have 7 coordinates, the examples have 8");
    assert_eq!(model, before);
}

/// Residuals in closed form are those of models without the example, or without its event.
#[test]
fn residuals_are_those_of_models_without_the_example() {
    for (with_mirror, sets) in [(false, false), (true, false), (false, true), (true, true)] {
        let mut e = examples(70, 8, with_mirror);
        if sets {
            let moments = (0..70).map(|i| Moment { clip: i / 35, frame: i % 35 }).collect();
            e = e.with_moments(moments, 2).unwrap();
        }
        let model = RbfRegression::fit(&e, &at(KERNEL)).unwrap();
        let told = if sets { model.leave_event_out() } else { model.leave_one_out() }.unwrap();
        for i in [0, 17, 34, 69_usize] {
            let out = |j: usize| if sets { i / 35 == j / 35 && i.abs_diff(j) <= 2 } else { i == j };
            let keep: Vec<usize> = (0..70).filter(|&j| !out(j)).collect();
            let without = RbfRegression::fit(&e.subset(&keep).unwrap(), &at(KERNEL)).unwrap();
            let batch = without.predict_batch(&e.inputs().rows(i, 1).into_owned()).unwrap();
            let residual = e.targets().row(i) - batch.mean.row(0);
            let worst = (told.residual.row(i) - residual).amax(); // ~1e-12 seen
            assert!(worst < 1e-9, "{with_mirror} {sets} {i}: {worst:e}");
            assert!((told.variance[i] - batch.variance[0]).abs() < 1e-9, "{with_mirror} {sets} {i}");
        }
    }
}

/// With every example an inducing point the approximation is the whole; with fewer it is worse and says so.
#[test]
fn more_inducing_points_come_to_the_whole() {
    for with_mirror in [false, true] {
        let e = examples(200, 4, with_mirror);
        let whole = RbfRegression::fit(&e, &at(KERNEL)).unwrap();
        let frames = uniform(50, 8, 31);
        let wanted = whole.predict_batch(&frames).unwrap();
        let through = |inducing| {
            let options = RbfOptions { exact_up_to: 0, inducing, ..at(KERNEL) };
            RbfRegression::fit(&e, &options).unwrap()
        };
        let mut last = f64::INFINITY;
        for inducing in [25, 100, 200] {
            let model = through(inducing);
            assert_eq!(model.inducing(), Some(inducing));
            let batch = model.predict_batch(&frames).unwrap();
            let worst = (&batch.mean - &wanted.mean).amax();
            println!("{with_mirror} {inducing}: {worst:e} {}", model.log_likelihood());
            assert!(worst < 0.7 * last, "{inducing}: {worst} {last}");
            assert_eq!(batch.novelty, wanted.novelty);
            last = worst;
        }
        assert!(last < 1e-5, "{last:e}"); // the diagonal between inducing points has 1e-10 more
        let all = through(200);
        let (a, b) = (all.leave_one_out().unwrap(), whole.leave_one_out().unwrap());
        assert!((a.residual - b.residual).amax() < 1e-5);
        let row: Vec<f64> = frames.row(3).iter().copied().collect();
        let (mut scratch, mut out) = (Scratch::new(), Prediction::default());
        let few = through(25);
        few.predict(&row, &mut scratch, &mut out).unwrap();
        let batch = few.predict_batch(&frames).unwrap();
        assert!((out.variance - batch.variance[3]).abs() < 1e-9);
        assert!((out.mean[2] - batch.mean[(3, 2)]).abs() < 1e-9);
    }
}

/// Growing through inducing points: near examples add to the sums, a far one makes the points be chosen again.
#[test]
fn growing_through_inducing_points_is_fitting_through_them() {
    let e = examples(120, 4, true);
    let options = RbfOptions { exact_up_to: 100, inducing: 60, ..at(KERNEL) };
    let mut model = RbfRegression::fit(&e, &options).unwrap();
    let near = e.inputs().rows(3, 2) + DMatrix::from_element(2, 8, 1e-3);
    let near = Examples::new(near, e.targets().rows(3, 2).into_owned(), Some(mirror())).unwrap();
    model.grow(&near).unwrap();
    // The same sums from the start: the points chosen do not change, since the near ones are never the farthest.
    let whole = RbfRegression::fit(&e.and(&near).unwrap(), &options).unwrap();
    let frames = uniform(20, 8, 31);
    let (a, b) = (model.predict_batch(&frames).unwrap(), whole.predict_batch(&frames).unwrap());
    assert!((&a.mean - &b.mean).amax() < 1e-8);
    let far =
        Examples::new(DMatrix::from_element(1, 8, 9.0), DMatrix::from_element(1, 5, 0.5), Some(mirror()));
    model.grow(&far.unwrap()).unwrap();
    let there = model.predict_batch(&DMatrix::from_element(1, 8, 9.0)).unwrap();
    assert!(there.confidence[0] > 0.9, "{}", there.confidence[0]);
    // Past the bound an exact model turns into one with inducing points.
    let (few, more) = split(&e, 40);
    let mut exact = RbfRegression::fit(&few, &options).unwrap();
    assert_eq!(exact.inducing(), None);
    exact.grow(&more).unwrap();
    assert_eq!(exact.inducing(), Some(60));
}

/// A rule that is the same everywhere: the length ends at the diameter, not beyond, and far away nothing is left.
#[test]
fn a_constant_rule_does_not_reach_everywhere() {
    let x = uniform(150, 8, 5);
    let y = DMatrix::from_element(150, 5, 0.26) + 1e-3 * uniform(150, 5, 6);
    let model = RbfRegression::fit(&Examples::new(x, y, None).unwrap(), &RbfOptions::default()).unwrap();
    let k = model.kernel();
    println!("{k:?} {} {:?}", model.diameter(), model.learning());
    assert!(k.length <= model.diameter() && k.length > 0.97 * model.diameter());
    let far = DMatrix::from_element(1, 8, 5.0 * model.diameter());
    let (near, far) = (model.predict_batch(&uniform(9, 8, 1)).unwrap(), model.predict_batch(&far).unwrap());
    let worst = near.mean.add_scalar(-0.26).amax(); // 2.5e-3 seen, at the rim of the examples
    assert!(worst < 5e-3, "{worst}");
    assert!(far.mean.amax() < 1e-6 && far.novelty[0] > 10.0 && far.confidence[0] < 1e-6);
}

/// With the mean of the targets taken away first, that is what is left far away.
#[test]
fn centred_targets_return_to_their_mean() {
    let (x, y) = noisy(60, 4);
    let options = RbfOptions { centre: true, ..RbfOptions::default() };
    let e = Examples::new(x, y.clone(), Some(mirror())).unwrap();
    let mut model = RbfRegression::fit(&e, &options).unwrap();
    let far = model.predict_batch(&DMatrix::from_element(1, 8, 1e3)).unwrap();
    let mean = (y.row_mean() + mirrored(&mirror().output, &y).row_mean()) * 0.5;
    assert!((far.mean.row(0) - mean).amax() < 1e-12);
    model.grow(&examples(5, 90, true)).unwrap();
    let again = model.predict_batch(&DMatrix::from_element(1, 8, 1e3)).unwrap();
    assert!((again.mean - far.mean).amax() < 1e-12, "the centre stays");
}

/// Targets that are zero: nothing is learned, everything predicted is zero, and sure near the examples.
#[test]
fn zero_targets_are_an_edit_that_does_nothing() {
    for scale in [0.0, 1e-13] {
        let x = uniform(40, 8, 5);
        let y = scale * uniform(40, 5, 2);
        let e = Examples::new(x.clone(), y, Some(mirror())).unwrap();
        let model = RbfRegression::fit(&e, &RbfOptions::default()).unwrap();
        assert_eq!(model.learning().stopped, "all targets are zero");
        assert!(model.log_likelihood().is_finite());
        let batch = model.predict_batch(&x).unwrap();
        assert!(batch.mean.amax() <= scale);
        assert!(batch.confidence.iter().all(|c| *c > 0.95));
    }
}

/// One example, or many at one place: their mean there, nothing far away; a mirror image is another place.
#[test]
fn one_place_is_answered_there_only() {
    let x = uniform(1, 8, 5);
    let many = DMatrix::from_fn(6, 8, |_, k| x[k]);
    let y = uniform(6, 5, 2);
    for (inputs, targets, m) in [
        (x.clone(), y.rows(0, 1).into_owned(), None),
        (x.clone(), y.rows(0, 1).into_owned(), Some(mirror())),
        (many, y.clone(), None),
    ] {
        let mean = targets.row_mean();
        let model =
            RbfRegression::fit(&Examples::new(inputs, targets, m).unwrap(), &RbfOptions::default()).unwrap();
        let (here, far) = (model.predict_batch(&x).unwrap(), model.predict_batch(&(3.0 * &x)).unwrap());
        println!("{:?} {:?} {}", model.kernel(), model.learning().stopped, model.spacing());
        assert!((here.mean.row(0) - &mean).amax() < 0.05 * mean.amax());
        assert!(far.mean.amax() < 0.05 * mean.amax() || model.diameter() > 0.0);
        assert!(here.novelty[0] < 1e-6 && far.novelty[0] > 1.0);
    }
    let zero = Examples::new(DMatrix::zeros(2, 3), DMatrix::from_element(2, 1, 1.0), None).unwrap();
    assert_eq!(RbfRegression::fit(&zero, &RbfOptions::default()).unwrap().kernel().length, 1.0);
}

/// The same example many times over is one example that is surer; nothing breaks.
#[test]
fn repetitions_are_no_neighbours() {
    let (x, y) = noisy(50, 3);
    let once = Examples::new(x, y, Some(mirror())).unwrap();
    let thrice = once.and(&once).unwrap().and(&once).unwrap();
    let a = RbfRegression::fit(&once, &RbfOptions::default()).unwrap();
    let b = RbfRegression::fit(&thrice, &RbfOptions::default()).unwrap();
    assert!((a.spacing() / b.spacing() - 1.0).abs() < 1e-6, "{} {}", a.spacing(), b.spacing());
    let frames = uniform(9, 8, 3);
    let (a, b) = (a.predict_batch(&frames).unwrap(), b.predict_batch(&frames).unwrap());
    for (a, b) in a.novelty.iter().zip(&b.novelty) {
        assert!((a / b - 1.0).abs() < 1e-6);
    }
    assert!(b.mean.iter().chain(&b.variance).all(|v| v.is_finite()));
}

/// A circle walked twice, 200 frames a round: without moments the spacing is a frame's step, with them the distance between
/// the rounds. Novelty counts in it.
#[test]
fn neighbours_in_time_are_not_the_spacing() {
    let angle = |i: usize| 0.01 * std::f64::consts::PI * i as f64;
    let x = DMatrix::from_fn(400, 3, |i, k| [angle(i).cos(), angle(i).sin(), 0.1 * (i / 200) as f64][k]);
    let y = x.columns(0, 2) * 0.5;
    let plain = Examples::new(x, y, None).unwrap();
    let moments = (0..400).map(|i| Moment { clip: 7, frame: i }).collect();
    let told = plain.clone().with_moments(moments, 20).unwrap();
    let spacing = |e: &Examples| RbfRegression::fit(e, &at(KERNEL)).unwrap().spacing();
    assert!((spacing(&plain) - 0.0314).abs() < 1e-3, "{}", spacing(&plain));
    assert!((spacing(&told) - 0.1).abs() < 2e-3, "{}", spacing(&told));
    let model = RbfRegression::fit(&told, &at(KERNEL)).unwrap();
    let batch = model.predict_batch(&DMatrix::from_row_slice(1, 3, &[1.0, 0.0, 0.3])).unwrap();
    assert!((batch.novelty[0] - 2.0).abs() < 0.05, "{}", batch.novelty[0]);
    // All of one event: no neighbour counts, the spacing is half of the whole.
    let moments = (0..400).map(|i| Moment { clip: 7, frame: i }).collect();
    let one = plain.with_moments(moments, 400).unwrap();
    let model = RbfRegression::fit(&one, &at(KERNEL)).unwrap();
    assert!((model.spacing() / model.diameter() - 0.5).abs() < 1e-9);
}

/// Four performances of a line whose remainder wanders slowly, as that of a motion does: 20 frames share it. Whose frames are known to be neighbours,
/// the rule is found among them; taken for examples of their own, the remainder is learned as well.
#[test]
fn what_neighbours_share_is_not_learned() {
    let wander = |t: f64, seed: f64| (t / 6.0 + seed).sin() * (t / 9.0 + 2.0 * seed).cos();
    let input = |i: usize, shift: f64| {
        let (clip, t) = ((i / 100) as f64, (i % 100) as f64);
        [
            (0.02 * t + clip + shift).sin(),
            (0.013 * t + 2.0 * clip + shift).cos(),
            0.3 * wander(t, clip + shift),
        ]
    };
    let rule = |x: [f64; 3]| 0.8 * x[0] - 0.3 * x[1];
    let [x, unseen] = [0.0, 0.37].map(|shift| DMatrix::from_fn(400, 3, |i, k| input(i, shift)[k]));
    let y = DMatrix::from_fn(400, 1, |i, _| {
        rule(input(i, 0.0)) + 0.1 * wander((i % 100) as f64 * 1.3, 5.0 + (i / 100) as f64)
    });
    let plain = Examples::new(x, y, None).unwrap();
    let moments = (0..400).map(|i| Moment { clip: i / 100, frame: i % 100 }).collect();
    let told = plain.clone().with_moments(moments, 50).unwrap();
    let [blind, knowing] = [&plain, &told].map(|e| {
        let mean =
            RbfRegression::fit(e, &RbfOptions::default()).unwrap().predict_batch(&unseen).unwrap().mean;
        ((0..400).map(|i| (mean[(i, 0)] - rule(input(i, 0.37))).powi(2)).sum::<f64>() / 400.0).sqrt()
    });
    assert!(knowing < 0.5 * blind, "{knowing} and {blind}"); // 0.036 and 0.153 seen
}

/// A model written and read is the same model, to the bit.
#[test]
fn a_stored_model_is_the_model() {
    for (exact_up_to, with_mirror) in [(3000, true), (50, false)] {
        let e = examples(60, 3, with_mirror);
        let moments = (0..60).map(|frame| Moment { clip: 1, frame }).collect();
        let e = e.with_moments(moments, 3).unwrap();
        let options = RbfOptions { exact_up_to, inducing: 30, ..RbfOptions::default() };
        let model = RbfRegression::fit(&e, &options).unwrap();
        let text = ron::to_string(&model).unwrap();
        let back: RbfRegression = ron::from_str(&text).unwrap();
        assert_eq!(model, back);
        let damaged = text.replacen("length:", "length:-", 1);
        let error = ron::from_str::<RbfRegression>(&damaged).unwrap_err().to_string();
        assert!(error.contains("must be positive"), "{error}");
    }
}

/// In three groups that the mirror keeps.
fn grouped(e: Examples) -> Examples {
    e.with_groups(vec![0, 0, 1, 1, 2, 2, 0, 0]).unwrap()
}

const WEIGHED: RbfKernel =
    RbfKernel { weights: [0.6, 1.0, 0.25, 1.0, 1.0, 1.0, 1.0, 1.0], ..RbfKernel::isotropic(0.9, 1.7, 0.003) };

/// Weights of groups are inputs in another scale: the same answers, one by one and together, grown, with examples left out and through inducing
/// points. Novelty does not see them.
#[test]
fn weights_of_groups_are_scales_of_inputs() {
    let columns = [0.6, 0.6, 1.0, 1.0, 0.25, 0.25, 0.6, 0.6];
    let scaled = |x: &DMatrix<f64>| DMatrix::from_fn(x.nrows(), x.ncols(), |i, k| x[(i, k)] * columns[k]);
    let frames = uniform(70, 8, 77);
    for (exact_up_to, with_mirror) in [(3000, true), (3000, false), (40, true)] {
        let e = examples(90, 3, with_mirror);
        let plain = Examples::new(scaled(e.inputs()), e.targets().clone(), e.mirror().cloned()).unwrap();
        let options = RbfOptions { exact_up_to, inducing: 30, ..at(KERNEL) };
        let weighed = RbfOptions { kernel: Some(WEIGHED), ..options.clone() };
        let e = grouped(e);
        let mut model = RbfRegression::fit(&e, &weighed).unwrap();
        let other = RbfRegression::fit(&plain, &options).unwrap();
        let (a, b) = (model.predict_batch(&frames).unwrap(), other.predict_batch(&scaled(&frames)).unwrap());
        assert!((&a.mean - &b.mean).amax() < 1e-9, "{}", (&a.mean - &b.mean).amax());
        assert!(a.variance.iter().zip(&b.variance).all(|(a, b)| (a - b).abs() < 1e-9));
        assert_eq!(
            a.novelty,
            RbfRegression::fit(&e, &options).unwrap().predict_batch(&frames).unwrap().novelty
        );
        let (mut scratch, mut out) = (Scratch::new(), Prediction::default());
        for i in 0..frames.nrows() {
            let row: Vec<f64> = frames.row(i).iter().copied().collect();
            model.predict(&row, &mut scratch, &mut out).unwrap();
            assert!(out.mean.iter().enumerate().all(|(k, v)| (v - a.mean[(i, k)]).abs() < 1e-9));
            assert!((out.novelty - a.novelty[i]).abs() < 1e-9);
        }
        let (mine, theirs) = (model.leave_one_out().unwrap(), other.leave_one_out().unwrap());
        assert!((&mine.residual - &theirs.residual).amax() < 1e-7);
        let (head, tail) = split(&e, 60);
        let whole = model.clone();
        model = RbfRegression::fit(&head, &weighed).unwrap();
        model.grow(&tail).unwrap();
        if exact_up_to == 3000 {
            let grown = model.predict_batch(&frames).unwrap();
            assert!((&grown.mean - whole.predict_batch(&frames).unwrap().mean).amax() < 1e-9);
        }
    }
}

/// An edit of one group alone is learned as such: the other groups get long lengths, and what they do elsewhere does not matter.
#[test]
fn a_rule_of_one_group_does_not_look_at_the_others() {
    let x = uniform(120, 8, 5);
    let y = DMatrix::from_fn(120, 1, |i, _| (2.5 * x[(i, 2)]).sin());
    let e = Examples::new(x, y, None).unwrap();
    let frames = uniform(200, 8, 6);
    let rms = |model: &RbfRegression| {
        let mean = model.predict_batch(&frames).unwrap().mean;
        let sum: f64 = (0..200).map(|i| (mean[(i, 0)] - (2.5 * frames[(i, 2)]).sin()).powi(2)).sum();
        (sum / 200.0).sqrt()
    };
    let plain = rms(&RbfRegression::fit(&e, &RbfOptions::default()).unwrap());
    let e = e.with_groups(vec![0, 0, 1, 2, 2, 2, 0, 0]).unwrap();
    let model = RbfRegression::fit(&e, &RbfOptions::default()).unwrap();
    let [a, b, c, ..] = model.kernel().weights;
    println!("{plain} without groups, {} with, weights {a} {b} {c}", rms(&model));
    assert!(rms(&model) < 0.02 && plain > 0.2, "{plain}, {}", rms(&model));
    assert!(b == 1.0 && a < 0.2 && c < 0.2, "{a} {b} {c}");
}

/// Groups that are not one a coordinate, too many, or exchanged by the mirror are refused.
#[test]
fn groups_that_do_not_fit_are_refused() {
    let e = || examples(5, 1, true);
    for groups in [vec![0; 7], vec![8; 8], vec![0, 1, 0, 0, 0, 0, 0, 0]] {
        assert!(e().with_groups(groups.clone()).is_err(), "{groups:?}");
    }
    assert!(grouped(e()).and(&e()).is_err());
}
