//! Ground truth: a nonlinear rule from human to lamp, thirty key poses, a thousand frames never seen; and what
//! happens when the key poses keep to the rule only roughly.

mod rule {
    pub mod performance;
}

use learn::{GplvmOptions, Locate, Method, Model, Pairs, Start, rms_error, suggest};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rule::performance::{farthest, performance};

fn pick(y: &DMatrix<f64>, z: &DMatrix<f64>, keep: &[usize]) -> Pairs {
    Pairs::new(&y.select_rows(keep), &z.select_rows(keep)).unwrap()
}

/// R² of the best affine map from human to lamp: 1 − residual/variance over all hinges.
fn linear_r2(y: &DMatrix<f64>, z: &DMatrix<f64>) -> f64 {
    let design = y.clone().insert_column(y.ncols(), 1.0);
    let fitted = &design * design.clone().svd(true, true).solve(z, 1e-10).unwrap();
    let centred = z - DMatrix::from_element(z.nrows(), 1, 1.0) * z.row_mean();
    1.0 - (z - fitted).norm_squared() / centred.norm_squared()
}

/// 5° RMS is asked for over 1,000 frames of another take; no affine map explains more than 80 % of either.
#[test]
fn thirty_key_poses_reproduce_a_thousand_unseen_frames() {
    let (y, z) = performance(2000, 0);
    let (unseen, truth) = performance(1000, 5);
    for (y, z) in [(&y, &z), (&unseen, &truth)] {
        let r2 = linear_r2(y, z);
        assert!(r2 <= 0.8, "{r2}"); // 0.781, 0.756
    }
    let pairs = pick(&y, &z, &farthest(&y, 30));
    let error = |method, options: &GplvmOptions| {
        let model = Model::fit(method, &pairs, options).unwrap();
        rms_error(&model, &unseen, &truth).unwrap().to_degrees()
    };
    let all = Method::ALL.map(|m| error(m, &GplvmOptions::default()));
    println!("gplvm, gp, pca, nn3, nn10: {all:.2?} deg RMS");
    let [gplvm, gp, pca, nn3, nn10] = all; // 2.4, 2.0, 13.0, 8.7, 12.1 seen
    assert!(gplvm < 5.0 && gp < 5.0, "{all:?}");
    assert!(pca.min(nn3).min(nn10) > 2.0 * gplvm, "{all:?}");
    // The way back forgives a worse start: 2.1° seen from principal components.
    let from_pca = error(Method::Gplvm, &GplvmOptions { start: Start::Pca, ..GplvmOptions::default() });
    println!("from PCA start: {from_pca:.2}");
    assert!(from_pca < 5.0, "{from_pca}");
}

/// Feature points of planar chains whose joints are these columns of `angles`: three markers on each link of 0.4 m, m.
fn markers(angles: &DMatrix<f64>, chains: &[&[usize]]) -> DMatrix<f64> {
    let mut all = Vec::new();
    for i in 0..angles.nrows() {
        for chain in chains {
            let (mut at, mut turn) = ([0.0, 0.0], 0.0_f64);
            for &joint in *chain {
                turn += angles[(i, joint)];
                for (along, across) in [(0.15, 0.05), (0.3, -0.05), (0.4, 0.0)] {
                    all.push(at[0] + along * turn.sin() + across * turn.cos());
                    all.push(at[1] + along * turn.cos() - across * turn.sin());
                }
                at = [at[0] + 0.4 * turn.sin(), at[1] + 0.4 * turn.cos()];
            }
        }
    }
    DMatrix::from_row_slice(angles.nrows(), all.len() / angles.nrows(), &all)
}

/// RMS errors (mm) over 200 unseen frames, mean of six sets of thirty key poses whose lamp angles are wrong by
/// `rough` (rad RMS).
fn marker_errors(rough: f64, models: &[(Method, Locate)]) -> Vec<f64> {
    let human: [&[usize]; 5] = [&[4, 5, 0, 3, 10], &[4, 6, 7], &[4, 5, 8, 9, 11], &[4, 1, 7], &[4, 5, 2, 9]];
    let lamp: [&[usize]; 1] = [&[0, 1, 2, 3, 4]];
    let (y, z) = performance(2000, 0);
    let (unseen, truth) = performance(200, 5);
    let (y, unseen, truth) = (markers(&y, &human), markers(&unseen, &human), markers(&truth, &lamp));
    assert_eq!((y.ncols(), truth.ncols()), (120, 30));
    let mut sums = vec![0.0; models.len()];
    for seed in 0..6 {
        let mut rng = Pcg64::seed_from_u64(seed);
        let mut keep = farthest(&y, if seed == 0 { 30 } else { 0 });
        while keep.len() < 30 {
            let i = rng.random_range(0..y.nrows());
            if keep.iter().all(|&j| i.abs_diff(j) > 3) {
                keep.push(i);
            }
        }
        let mut normal = || (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
        let z = markers(&z.select_rows(&keep).map(|v| v + rough * normal()), &lamp);
        let pairs = Pairs::new(&y.select_rows(&keep), &z).unwrap();
        for (sum, &(method, locate)) in sums.iter_mut().zip(models) {
            let options = GplvmOptions { locate, ..GplvmOptions::default() };
            let model = Model::fit(method, &pairs, &options).unwrap();
            *sum += 1e3 * rms_error(&model, &unseen, &truth).unwrap() / 6.0;
        }
    }
    sums
}

/// With feature points, as the paper uses them, the shared model generalises better than the GP it is compared with
/// there, and clearly better than PCA and neighbours. With twelve bare angles the GP wins (2.0° to 2.4° above): the
/// likelihood of a few coordinates does not outweigh the prior of as many latent ones.
#[test]
fn slow_with_markers_the_shared_model_generalises_best() {
    let mut models: Vec<(Method, Locate)> = Method::ALL.map(|m| (m, Locate::Back)).to_vec();
    models.push((Method::Gplvm, Locate::Posterior));
    let errors = marker_errors(0.0, &models);
    println!("gplvm, gp, pca, nn3, nn10, gplvm by posterior: {errors:.0?} mm RMS");
    // 213, 220, 587, 243, 240, 218 seen.
    let [gplvm, gp, pca, nn3, nn10, searched] = errors[..] else { unreachable!("six models") };
    assert!(gplvm < gp, "{errors:?}");
    assert!(gplvm < 0.9 * pca.min(nn3).min(nn10), "{errors:?}");
    assert!(gplvm < searched, "{errors:?}");
}

/// Key poses made by hand keep to no rule exactly. As they get rougher, latent points found by search explain the
/// roughness; the way back leaves it to noise, and stays ahead of GP regression.
#[test]
fn slow_rough_key_poses_need_the_way_back() {
    let models =
        [(Method::Gplvm, Locate::Back), (Method::Gplvm, Locate::Posterior), (Method::Gp, Locate::Back)];
    for rough in [5.0, 10.0, 20.0, 30.0, 40.0] {
        let errors = marker_errors(f64::to_radians(rough), &models);
        println!("{rough}° rough: way back, search, gp: {errors:.0?} mm RMS");
        let [back, search, gp] = errors[..] else { unreachable!("three models") };
        // Seen: 246 256 249, 273 297 277, 323 394 358, 403 504 429, 488 600 502.
        assert!(back < gp && back < 0.97 * search, "{rough}°: {errors:?}");
    }
}

/// Five poses suggested lower the held-out error more than five drawn at random: median over 20 seeds.
#[test]
fn suggested_poses_teach_more_than_random_ones() {
    let (y, z) = performance(600, 0);
    let (unseen, truth) = performance(1000, 5);
    let some: Vec<usize> = (0..1000).step_by(7).collect();
    let (unseen, truth) = (unseen.select_rows(&some), truth.select_rows(&some));
    let options = GplvmOptions::default();
    let mut gains: [Vec<f64>; 2] = Default::default();
    for seed in 0..20 {
        let mut rng = Pcg64::seed_from_u64(seed);
        let mut drawn = Vec::new();
        while drawn.len() < 20 {
            let i = rng.random_range(0..y.nrows());
            if drawn.iter().all(|&j: &usize| i.abs_diff(j) > 3) {
                drawn.push(i);
            }
        }
        let (start, random) = drawn.split_at(15);
        let fit = |more: &[usize]| {
            let keep = [start, more].concat();
            Model::fit(Method::Gplvm, &pick(&y, &z, &keep), &options).unwrap()
        };
        let error = |m: &Model| rms_error(m, &unseen, &truth).unwrap().to_degrees();
        let model = fit(&[]);
        let before = error(&model);
        let named: Vec<usize> = suggest(&model, &y, 5).unwrap().iter().map(|s| s.frame).collect();
        for (gains, more) in gains.iter_mut().zip([random, &named]) {
            gains.push(before - error(&fit(more)));
        }
    }
    let median = |v: &mut Vec<f64>| {
        v.sort_by(f64::total_cmp);
        0.5 * (v[9] + v[10])
    };
    let [random, suggested] = gains.each_mut().map(median);
    println!("gain: random {random:.2} deg, suggested {suggested:.2} deg"); // 3.1, 4.5 seen
    assert!(suggested > random, "{random} {suggested}");
}
