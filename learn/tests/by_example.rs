//! Models of examples by their names: the same verbs, laws of moving least squares and of nearest examples, bad data.

mod common {
    pub mod examples;
}

use common::examples::{examples, mirror, mirrored, noisy, rule, uniform};
use learn::{
    ExampleMethod, ExampleModel, ExampleOptions, Examples, FitError, InputError, Mirror, MlsOptions, Moment,
    MovingLeastSquares, NearestExamples, Prediction, Scratch,
};
use nalgebra::DMatrix;

fn fit(method: ExampleMethod, e: &Examples) -> ExampleModel {
    ExampleModel::fit(method, e, &ExampleOptions::default()).unwrap()
}

#[test]
fn names_are_read_back() {
    for method in ExampleMethod::ALL {
        assert_eq!(method.name().parse(), Ok(method));
        assert_eq!(fit(method, &examples(9, 1, true)).method(), method);
    }
    let error = "knn".parse::<ExampleMethod>().unwrap_err().to_string();
    assert_eq!(error, "unknown model of examples `knn`; known are gp, mls, nearest");
}

/// f(M x) = M' f(x), of every model.
#[test]
fn a_mirrored_input_has_the_mirrored_answer() {
    for method in ExampleMethod::ALL {
        let model = fit(method, &examples(60, 5, true));
        let frames = noisy(30, 9).0;
        let (a, b) = (
            model.predict_batch(&frames).unwrap(),
            model.predict_batch(&mirrored(&mirror().input, &frames)).unwrap(),
        );
        let worst = (mirrored(&mirror().output, &a.mean) - b.mean).amax(); // 1e-14 seen
        assert!(worst < 1e-12, "{method}: {worst:e}");
        for (a, b) in a.variance.iter().zip(&b.variance) {
            assert!((a - b).abs() < 1e-12, "{method}");
        }
    }
}

/// Images are examples of their own: appending them by hand is the same.
#[test]
fn a_mirror_is_twice_the_examples() {
    for method in ExampleMethod::ALL {
        let e = examples(40, 5, true);
        let (x, y) = common::examples::doubled(&e);
        // By hand an example and its image are different events too; one kernel and one width for both.
        let options = ExampleOptions {
            gp: learn::RbfOptions {
                kernel: Some(learn::RbfKernel::isotropic(0.9, 1.7, 0.003)),
                ..Default::default()
            },
            mls: MlsOptions { width: Some(0.8), ..MlsOptions::default() },
            neighbours: 3,
        };
        let a = ExampleModel::fit(method, &e, &options).unwrap();
        let b = ExampleModel::fit(method, &Examples::new(x, y, None).unwrap(), &options).unwrap();
        let frames = uniform(20, 8, 12);
        let (a, b) = (a.predict_batch(&frames).unwrap(), b.predict_batch(&frames).unwrap());
        let worst = (a.mean - b.mean).amax(); // 1e-13 seen
        assert!(worst < 1e-10, "{method}: {worst:e}");
    }
}

/// Every model predicts a smooth rule better than its targets' spread, Gaussian processes best.
#[test]
fn all_learn_the_rule() {
    let frames = uniform(200, 8, 50);
    let wanted = rule(&frames);
    let errors = ExampleMethod::ALL.map(|method| {
        let batch = fit(method, &examples(400, 1, true)).predict_batch(&frames).unwrap();
        (batch.mean - &wanted).norm() / wanted.norm()
    });
    println!("{errors:?}");
    assert!(errors[0] < 0.06 && errors[1] < 0.35 && errors[2] < 0.8, "{errors:?}");
    assert!(errors[0] < errors[1] && errors[1] < errors[2], "{errors:?}");
}

/// A linear rule is the linear map, anywhere among the examples: what is fitted is not a constant.
#[test]
fn moving_least_squares_fit_a_linear_rule() {
    let x = uniform(200, 3, 3);
    let y = DMatrix::from_fn(200, 2, |i, k| 0.3 + x[(i, 0)] * (k as f64 + 1.0) - 0.5 * x[(i, 2)]);
    let options = MlsOptions { ridge: 1e-9, width: Some(0.5), ..MlsOptions::default() };
    let model = MovingLeastSquares::fit(&Examples::new(x, y, None).unwrap(), &options).unwrap();
    let frames = uniform(20, 3, 9);
    let batch = model.predict_batch(&frames).unwrap();
    for i in 0..20 {
        for k in 0..2 {
            let wanted = 0.3 + frames[(i, 0)] * (k as f64 + 1.0) - 0.5 * frames[(i, 2)];
            assert!((batch.mean[(i, k)] - wanted).abs() < 1e-6); // 1e-8 seen: the ridge
        }
    }
}

/// Confidence is the mean of the three highest weights.
#[test]
fn confidence_is_the_mean_of_three_weights() {
    let x = DMatrix::from_row_slice(5, 1, &[0.0, 1.0, 2.0, 3.0, 4.0]);
    let options = MlsOptions { width: Some(0.7), ..MlsOptions::default() };
    let model = MovingLeastSquares::fit(&Examples::new(x.clone(), x, None).unwrap(), &options).unwrap();
    let batch = model.predict_batch(&DMatrix::from_element(1, 1, 2.2)).unwrap();
    let weight = |r: f64| (-0.5 * (r / 0.7_f64).powi(2)).exp();
    let wanted = (weight(0.2) + weight(0.8) + weight(1.2)) / 3.0;
    assert!((batch.confidence[0] - wanted).abs() < 1e-14);
    let far = model.predict_batch(&DMatrix::from_element(1, 1, 500.0)).unwrap();
    assert!(far.confidence[0] == 0.0 && far.mean.amax().is_finite() && far.variance[0] > 5.9);
}

/// An example has its own target, and between two examples the nearer one counts more.
#[test]
fn nearest_examples_interpolate() {
    let x = DMatrix::from_row_slice(3, 1, &[0.0, 1.0, 5.0]);
    let y = DMatrix::from_row_slice(3, 1, &[10.0, 20.0, 50.0]);
    let e = Examples::new(x.clone(), y.clone(), None).unwrap();
    let two = NearestExamples::fit(&e, 2).unwrap();
    assert_eq!(two.predict_batch(&x).unwrap().mean, y);
    let between = two.predict_batch(&DMatrix::from_element(1, 1, 0.25)).unwrap();
    assert!((between.mean[0] - 12.5).abs() < 1e-12);
    assert!(NearestExamples::fit(&e, 4).unwrap_err().to_string().contains("from 1 to 3"));
}

/// Growing is fitting all of them, where nothing is learned.
#[test]
fn growing_is_fitting_all() {
    let e = examples(40, 3, true);
    let numbers: Vec<usize> = (0..40).collect();
    let (few, more) = (e.subset(&numbers[..25]).unwrap(), e.subset(&numbers[25..]).unwrap());
    let options = ExampleOptions {
        mls: MlsOptions { width: Some(0.9), ..MlsOptions::default() },
        ..ExampleOptions::default()
    };
    for method in [ExampleMethod::Mls, ExampleMethod::Nearest] {
        let mut model = ExampleModel::fit(method, &few, &options).unwrap();
        model.grow(&more).unwrap();
        assert_eq!(model, ExampleModel::fit(method, &e, &options).unwrap());
    }
}

/// A model written and read is the same model, to the bit.
#[test]
fn a_stored_model_is_the_model() {
    for method in ExampleMethod::ALL {
        let model = fit(method, &examples(30, 3, true));
        let text = ron::to_string(&model).unwrap();
        let back: ExampleModel = ron::from_str(&text).unwrap();
        assert_eq!(model, back, "{method}");
        assert_eq!(text, ron::to_string(&back).unwrap(), "{method}");
    }
}

/// A frame costs no allocation, with any model.
#[test]
fn predicting_does_not_allocate() {
    for method in ExampleMethod::ALL {
        for options in [
            ExampleOptions::default(),
            ExampleOptions {
                gp: learn::RbfOptions { exact_up_to: 10, inducing: 12, ..Default::default() },
                ..ExampleOptions::default()
            },
        ] {
            let model = ExampleModel::fit(method, &examples(30, 3, true), &options).unwrap();
            let frames = uniform(20, 8, 4).transpose();
            let (mut scratch, mut out) = (Scratch::new(), Prediction::default());
            model.predict(&frames.as_slice()[..8], &mut scratch, &mut out).unwrap();
            let counted = allocation_counter::measure(|| {
                for frame in frames.as_slice().chunks_exact(8) {
                    model.predict(frame, &mut scratch, &mut out).unwrap();
                }
            });
            assert_eq!(counted.count_total, 0, "{method}");
        }
    }
}

/// Any model answers one example, identical examples, and targets of zero with finite numbers.
#[test]
fn poor_examples_have_finite_answers() {
    let x = uniform(1, 8, 1);
    let same = DMatrix::from_fn(5, 8, |_, k| x[k]);
    for method in ExampleMethod::ALL {
        for (inputs, targets) in [
            (x.clone(), uniform(1, 5, 2)),
            (same.clone(), uniform(5, 5, 2)),
            (uniform(9, 8, 3), DMatrix::zeros(9, 5)),
            (DMatrix::zeros(2, 8), DMatrix::zeros(2, 5)),
        ] {
            for m in [None, Some(mirror())] {
                let model = fit(method, &Examples::new(inputs.clone(), targets.clone(), m).unwrap());
                let mut frames = uniform(6, 8, 4);
                frames.set_row(0, &x.row(0));
                frames *= 3.0;
                let batch = model.predict_batch(&frames).unwrap();
                let all =
                    batch.mean.iter().chain(&batch.variance).chain(&batch.novelty).chain(&batch.confidence);
                assert!(all.into_iter().all(|v| v.is_finite()), "{method}: {batch:?}");
                assert!(batch.variance.iter().all(|v| *v >= 0.0), "{method}");
            }
        }
    }
}

#[test]
fn inputs_that_do_not_fit_are_refused() {
    for method in ExampleMethod::ALL {
        let model = fit(method, &examples(12, 1, true));
        let told = model.predict_batch(&uniform(3, 7, 1)).unwrap_err();
        assert_eq!(told, InputError::Dimension { found: 7, expected: 8 });
        let mut frames = uniform(3, 8, 1);
        frames[(2, 5)] = f64::INFINITY;
        let told = model.predict_batch(&frames).unwrap_err();
        assert_eq!(told, InputError::NotFinite { coordinate: 5, value: f64::INFINITY });
        assert_eq!(model.predict_batch(&uniform(0, 8, 1)).unwrap().mean.shape(), (0, 5));
    }
}

#[test]
fn bad_examples_are_told_with_their_numbers() {
    let refused = |x: DMatrix<f64>, y: DMatrix<f64>, m| Examples::new(x, y, m).unwrap_err().to_string();
    let (x, y) = noisy(6, 1);
    assert_eq!(
        refused(x.rows(0, 5).into_owned(), y.clone(), None),
        "5 inputs but 6 outputs: they come in pairs"
    );
    assert_eq!(refused(DMatrix::zeros(0, 3), DMatrix::zeros(0, 2), None), "0 pairs, at least 1 are needed");
    assert_eq!(refused(x.clone(), DMatrix::zeros(6, 0), None), "output vectors have no coordinates");
    let mut bad = y.clone();
    bad[(4, 2)] = f64::NAN;
    assert_eq!(refused(x.clone(), bad, None), "output 4, coordinate 2 is NaN");
    let with = |change: fn(&mut Mirror)| {
        let mut m = mirror();
        change(&mut m);
        Some(m)
    };
    let told = refused(x.clone(), y.clone(), with(|m| m.input.truncate(7)));
    assert_eq!(told, "mirror of input vectors has 7 coordinates, the vectors have 8");
    let told = refused(x.clone(), y.clone(), with(|m| m.output[1] = (2, 1.0)));
    assert!(told.starts_with("mirror of output vectors: coordinate 1 comes from 2 with sign 1;"), "{told}");
    for change in [
        (|m: &mut Mirror| m.input[2] = (99, 1.0)) as fn(&mut Mirror),
        |m| m.input[2] = (2, 0.5),
        |m| m.input[0] = (0, 1.0),
        |m| m.input[3] = (3, f64::NAN),
    ] {
        assert!(matches!(Examples::new(x.clone(), y.clone(), with(change)), Err(FitError::Mirror { .. })));
    }
    let e = Examples::new(x, y, None).unwrap();
    let told = e.clone().with_moments(vec![Moment { clip: 0, frame: 0 }], 3).unwrap_err().to_string();
    assert_eq!(told, "1 moments for 6 examples");
    assert!(e.subset(&[6]).unwrap_err().to_string().contains("below 6"));
    assert!(e.subset(&[]).is_err());
    let options = |width: f64, neighbours, ridge| MlsOptions { width: Some(width), neighbours, ridge };
    for bad in
        [options(0.0, 9, 1e-3), options(f64::NAN, 9, 1e-3), options(1.0, 0, 1e-3), options(1.0, 9, 0.0)]
    {
        assert!(matches!(MovingLeastSquares::fit(&e, &bad), Err(FitError::Setting { .. })));
    }
}
