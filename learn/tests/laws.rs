//! What must hold for every model, whatever the data.

mod common {
    pub mod data;
}

use common::data::{curved, curved_pairs, path, uniform};
use learn::{
    GplvmOptions, Locate, Mapper, Method, Model, Pairs, PcaLinear, Prediction, Regressor, Scratch,
    SharedGplvm, key_pose_error, leave_out, map_frames, path_shape, rms_error, suggest,
};
use nalgebra::DMatrix;

fn fit(method: Method, pairs: &Pairs) -> Model {
    Model::fit(method, pairs, &GplvmOptions::default()).unwrap()
}

fn predict(model: &impl Regressor, input: &[f64]) -> Prediction {
    let mut out = Prediction::default();
    model.predict(input, &mut Scratch::new(), &mut out).unwrap();
    out
}

/// Root of the mean variance of the columns.
fn spread(m: &DMatrix<f64>) -> f64 {
    let centred = m - DMatrix::from_element(m.nrows(), 1, 1.0) * m.row_mean();
    (centred.norm_squared() / m.len() as f64).sqrt()
}

/// Same pairs, same bits: the model, and every number it gives.
#[test]
fn learning_is_deterministic() {
    let frames = curved(&path(40)).0;
    for method in Method::ALL {
        let (a, b) = (fit(method, &curved_pairs()), fit(method, &curved_pairs()));
        assert_eq!(a, b, "{method}");
        assert_eq!(map_frames(&a, &frames).unwrap(), map_frames(&b, &frames).unwrap(), "{method}");
    }
}

/// Output = input: every model that can be exact is, the others are near.
#[test]
fn the_identity_is_recovered() {
    let y = curved(&uniform(25, 3, 4)).0;
    let pairs = Pairs::new(&y, &y).unwrap();
    let unseen = curved(&path(60)).0;
    // Share of the spread. Seen: gplvm 1e-3, gp 2e-4, pca 2e-13.
    for (method, allowed) in [(Method::Gplvm, 0.02), (Method::Gp, 1e-3), (Method::Pca, 1e-10)] {
        let error = rms_error(&fit(method, &pairs), &unseen, &unseen).unwrap() / spread(&y);
        println!("identity, {method}: {error:.1e}");
        assert!(error < allowed, "{method}: {error}");
    }
}

/// z = B y + c.
#[test]
fn a_linear_map_is_recovered() {
    let b = uniform(9, 4, 8);
    let answer = |y: &DMatrix<f64>| (y * &b).add_scalar(3.0);
    let y = curved(&uniform(25, 3, 4)).0;
    let pairs = Pairs::new(&y, &answer(&y)).unwrap();
    let unseen = curved(&path(60)).0;
    // Seen: gplvm 5e-3, gp 1e-4, pca 6e-14.
    for (method, allowed) in [(Method::Gplvm, 0.02), (Method::Gp, 1e-3), (Method::Pca, 1e-10)] {
        let error = rms_error(&fit(method, &pairs), &unseen, &answer(&unseen)).unwrap() / spread(&answer(&y));
        println!("linear, {method}: {error:.1e}");
        assert!(error < allowed, "{method}: {error}");
    }
}

/// Key poses come back: exactly from what passes through them, within the noise it learned from what does not.
#[test]
fn key_poses_come_back() {
    let (y, z) = curved(&uniform(25, 3, 4));
    let pairs = Pairs::new(&y, &z).unwrap();
    // Seen: gplvm 5e-3, gp 6e-3, nn3 and nn10 0; pca has nine coordinates for 25 pairs.
    for (method, allowed) in
        [(Method::Gplvm, 0.02), (Method::Gp, 0.02), (Method::Nn3, 1e-12), (Method::Nn10, 1e-12)]
    {
        let error = key_pose_error(&fit(method, &pairs)).unwrap() / spread(&z);
        println!("key poses, {method}: {error:.1e}");
        assert!(error < allowed, "{method}: {error}");
    }
}

/// Other units, other origins: the same answer in those units.
#[test]
fn units_do_not_matter() {
    let (y, z) = curved(&uniform(25, 3, 4));
    let scaled = Pairs::new(&(&y * 1024.0), &(&z * 0.125).add_scalar(2.0)).unwrap();
    let pairs = Pairs::new(&y, &z).unwrap();
    let input: Vec<f64> = curved(&path(1)).0.iter().copied().collect();
    let far: Vec<f64> = input.iter().map(|v| 1024.0 * v).collect();
    for method in Method::ALL {
        let (a, b) = (predict(&fit(method, &pairs), &input), predict(&fit(method, &scaled), &far));
        for (a, b) in a.mean.iter().zip(&b.mean) {
            assert!((0.125 * a + 2.0 - b).abs() < 1e-6, "{method}: {a} {b}"); // 1e-9 seen
        }
        assert!((a.variance / 64.0 - b.variance).abs() < 1e-6 * b.variance, "{method}");
        assert!(
            (a.confidence - b.confidence).abs() < 1e-6 && (a.novelty - b.novelty).abs() < 1e-9,
            "{method}"
        );
    }
}

/// At a key pose every model is sure; farther away none is, and all say that they extrapolate.
#[test]
fn models_say_when_they_extrapolate() {
    let pairs = curved_pairs();
    for method in Method::ALL {
        let model = fit(method, &pairs);
        let at_home = predict(&model, pairs.input(3));
        assert!(at_home.novelty < 1e-12 && !at_home.extrapolates(), "{method}");
        let mut last = at_home.confidence;
        assert!(last > 0.9, "{method}: {last}");
        for distance in [3.0, 10.0, 100.0] {
            let far: Vec<f64> = pairs.input(3).iter().map(|v| v + distance).collect();
            let out = predict(&model, &far);
            assert!(out.extrapolates(), "{method} at {distance}: {}", out.novelty);
            assert!(out.confidence <= last + 1e-9, "{method} at {distance}: {} after {last}", out.confidence);
            assert!(out.mean.iter().all(|v| v.is_finite()) && out.variance.is_finite(), "{method}");
            last = out.confidence;
        }
        assert!(last < 0.05, "{method}: {last}");
    }
}

/// The variance is the size of the error: over unseen frames |error|² is within a factor of ten of the
/// variance.
#[test]
fn variance_is_the_size_of_the_error() {
    let pairs = curved_pairs();
    let (y, z) = curved(&uniform(200, 3, 77));
    for method in Method::ALL {
        let model = fit(method, &pairs);
        let (mut error, mut variance) = (0.0, 0.0);
        for i in 0..y.nrows() {
            let out = predict(&model, &y.row(i).iter().copied().collect::<Vec<_>>());
            let e: f64 = out.mean.iter().zip(z.row(i).iter()).map(|(a, b)| (a - b).powi(2)).sum();
            error += e / z.ncols() as f64;
            variance += out.variance;
        }
        println!("error²/variance, {method}: {:.2}", error / variance); // 2.3, 2.7, 1.1, 0.8, 0.4 seen
        assert!(error / variance > 0.1 && error / variance < 10.0, "{method}: {}", error / variance);
    }
}

/// PCA passes through every pair; its variance is that of leave-one-out residuals all the same (two roads).
#[test]
fn pca_variance_is_that_of_pairs_left_out() {
    // 20 coordinates for 12 pairs: interpolation. 3 for 12: regression.
    for coordinates in [20, 3] {
        let (y, z) = (uniform(12, coordinates, 1), uniform(12, 5, 2));
        let pairs = Pairs::new(&y, &z).unwrap();
        let one_by_one: Vec<_> = (0..12).map(|i| vec![i]).collect();
        let left = leave_out(&pairs, Method::Pca, &GplvmOptions::default(), &one_by_one).unwrap();
        let residual = left.iter().map(|l| l.rms * l.rms).sum::<f64>() / 12.0;
        let centre: Vec<f64> = y.row_mean().iter().copied().collect();
        let variance = predict(&PcaLinear::fit(&pairs, None).unwrap(), &centre).variance;
        assert!((variance / residual - 1.0).abs() < 1e-8, "{coordinates}: {variance} {residual}"); // 1e-13 seen
    }
}

/// Nearest neighbours stay between the outputs they interpolate.
#[test]
fn neighbours_do_not_overshoot() {
    let pairs = curved_pairs();
    let model = fit(Method::Nn3, &pairs);
    for i in 0..50 {
        let input: Vec<f64> = curved(&uniform(1, 3, i)).0.iter().map(|v| 2.0 * v).collect();
        let out = predict(&model, &input);
        for (k, v) in out.mean.iter().enumerate() {
            let all = (0..pairs.len()).map(|i| pairs.output(i)[k]);
            let (low, high) = all.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
            assert!(*v >= low - 1e-12 && *v <= high + 1e-12);
        }
    }
}

/// Along a smooth path the warm start changes nothing but the time: frame by frame, the answer is as good as
/// a fresh one's.
#[test]
fn a_sequence_gives_what_single_frames_give() {
    let options = GplvmOptions { locate: Locate::Posterior, ..GplvmOptions::default() };
    let model = SharedGplvm::fit(&curved_pairs(), &options).unwrap();
    let frames = curved(&path(200)).0;
    let mapped = map_frames(&model, &frames).unwrap();
    let shape = path_shape(mapped.latents.as_ref().unwrap(), 30.0).unwrap();
    println!("{shape:?}, jumps {:?}", mapped.jumps);
    assert!(mapped.jumps.is_empty(), "{:?}", mapped.jumps);
    assert!(shape.worst_step < 4.0, "{shape:?}"); // 1.5 seen
    let mut worst: f64 = 0.0;
    for i in 0..frames.nrows() {
        let one = predict(&model, &frames.row(i).iter().copied().collect::<Vec<_>>());
        for (a, b) in one.mean.iter().zip(mapped.means.row(i).iter()) {
            worst = worst.max((a - b).abs());
        }
    }
    assert!(worst < 1e-4, "{worst}"); // 2e-6 seen
}

/// A sequence that leaps to another pose ends where a fresh start does, and not less likely: it left the old
/// basin.
#[test]
fn a_leap_does_not_stay_behind() {
    let options = GplvmOptions { dimension: Some(3), locate: Locate::Posterior, ..GplvmOptions::default() };
    let model = SharedGplvm::fit(&curved_pairs(), &options).unwrap();
    let frames = curved(&uniform(150, 3, 21)).0;
    let mapped = map_frames(&model, &frames).unwrap();
    let (mut same, jumps) = (0, mapped.jumps.len());
    for i in 0..frames.nrows() {
        let one = predict(&model, &frames.row(i).iter().copied().collect::<Vec<_>>());
        let apart =
            one.mean.iter().zip(mapped.means.row(i).iter()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        same += usize::from(apart < 1e-3);
    }
    println!("{jumps} jumps, {same} of 150 as from a fresh start"); // 115, 146 seen
    assert!(jumps > 5, "{jumps}");
    assert!(same > 120, "{same}");
    assert!(mapped.jumps.iter().all(|(_, j)| j.gain > 0.0 && j.lengths > 0.0 && j.key < 25));
}

/// The way back knows no basins: near inputs have near latent points, whatever came before, and a key pose has its
/// own.
#[test]
fn the_way_back_is_a_function_through_the_key_poses() {
    let pairs = curved_pairs();
    let model = SharedGplvm::fit(&pairs, &GplvmOptions::default()).unwrap();
    let (latents, mut scratch, mut out) = (model.latents(), Scratch::new(), Prediction::default());
    let mut worst: f64 = 0.0;
    for i in 0..pairs.len() {
        model.predict(pairs.input(i), &mut scratch, &mut out).unwrap();
        let found = scratch.latent().unwrap();
        worst = worst
            .max(found.iter().zip(latents.row(i).iter()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max));
    }
    assert!(worst < 1e-8, "{worst}"); // 4e-12 seen
    let frames = curved(&uniform(150, 3, 21)).0;
    let mapped = map_frames(&model, &frames).unwrap();
    for i in 0..frames.nrows() {
        let one = predict(&model, &frames.row(i).iter().copied().collect::<Vec<_>>());
        assert!(one.mean.iter().eq(mapped.means.row(i).iter()), "{i}");
    }
    assert!(mapped.jumps.is_empty());
}

/// A refused frame leaves the mapper where it was.
#[test]
fn a_bad_frame_is_not_remembered() {
    let model = fit(Method::Gplvm, &curved_pairs());
    let frames = curved(&path(3)).0;
    let row = |i: usize| frames.row(i).iter().copied().collect::<Vec<f64>>();
    let (mut a, mut b) = (Mapper::new(&model), Mapper::new(&model));
    for mapper in [&mut a, &mut b] {
        mapper.map(&row(0)).unwrap();
    }
    assert!(a.map(&[f64::NAN; 9]).is_err() && a.map(&[0.0; 4]).is_err());
    assert_eq!(a.map(&row(1)).unwrap(), b.map(&row(1)).unwrap());
}

/// Suggestions are different frames, the least sure first; each lowers what is left.
#[test]
fn suggestions_spread() {
    let frames = curved(&uniform(300, 3, 5)).0;
    for method in Method::ALL {
        let named = suggest(&fit(method, &curved_pairs()), &frames, 6).unwrap();
        assert_eq!(named.len(), 6);
        for (i, s) in named.iter().enumerate() {
            assert!(
                named[..i].iter().all(|t| t.frame != s.frame && t.left >= s.left && t.variance >= s.variance),
                "{method}: {named:?}"
            );
            for t in &named[..i] {
                let apart = (frames.row(s.frame) - frames.row(t.frame)).norm();
                assert!(apart > 0.3, "{method}: {} and {} are {apart} apart", s.frame, t.frame);
            }
        }
    }
    // More wanted than there are.
    assert_eq!(
        suggest(&fit(Method::Gp, &curved_pairs()), &frames.rows(0, 2).into_owned(), 6).unwrap().len(),
        2
    );
}

/// Third derivative of r sin ωt is r ω³ cos ωt; a parabola has none.
#[test]
fn jerk_is_the_third_derivative() {
    let rate = 1000.0;
    let omega = 3.0;
    let wave = DMatrix::from_fn(4000, 1, |i, _| 2.0 * (omega * i as f64 / rate).sin());
    let shape = path_shape(&wave, rate).unwrap();
    // RMS over 1.91 periods: (2 ω³/√2)·(1 ± 0.03).
    assert!((shape.jerk / (2.0 * omega.powi(3) / 2.0_f64.sqrt()) - 1.0).abs() < 0.05, "{shape:?}");
    let parabola = DMatrix::from_fn(50, 2, |i, k| (i as f64).powi(2) * (k as f64 + 1.0));
    assert!(path_shape(&parabola, 30.0).unwrap().jerk < 1e-6);
    assert_eq!(path_shape(&DMatrix::zeros(3, 2), 30.0), None);
    assert_eq!(path_shape(&DMatrix::zeros(9, 2), 30.0), None);
}
