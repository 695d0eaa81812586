//! FastICA against scikit-learn 1.9.1: the numbers come from `ica_by_sklearn.py`, which makes the same data.

use learn::ica::{Contrast, Count, IcaOptions, Method, fixed_point, whiten};
use nalgebra::DMatrix;

const FRAMES: usize = 700;
const CHANNELS: usize = 7;
const K: usize = 4;

fn data() -> DMatrix<f64> {
    let sources = DMatrix::from_fn(FRAMES, 4, |i, k| {
        let t = i as f64 / 60.0;
        match k {
            0 => 2.0 * (0.83 * t).fract() - 1.0,
            1 => (1.9 * t).sin().powi(9),
            2 => (2.9 * t + 0.4).sin() + 0.3 * (8.1 * t).sin(),
            _ => (0.31 * t * t).fract().powi(3),
        }
    });
    let mix = DMatrix::from_fn(4, CHANNELS, |k, c| {
        let (k, c) = (k as f64, c as f64);
        (1.0 + k + 1.7 * c * (k + 1.0)).sin()
    });
    sources * mix + DMatrix::from_fn(FRAMES, CHANNELS, |_, c| c as f64)
}

/// Rows of the rotation, in the order of scikit-learn.
#[rustfmt::skip]
fn theirs() -> [[[f64; K]; K]; 6] {
    [
        // parallel, logcosh: 32 steps
        [
            [0.5637445822542236, 0.7987512857858255, -0.1452685828894112, -0.15193902809943977],
            [0.15480353814235262, 0.005473669167696715, 0.9420562785855334, -0.29754977987225656],
            [-0.8100900311481746, 0.5678276855245817, 0.09470972909671237, -0.11115722288980358],
            [-0.04452024249674597, -0.19884200248718792, -0.28715339805974877, -0.9359608603126709],
        ],
        // parallel, cube: 182 steps
        [
            [0.526803007467155, 0.7854486068512772, -0.290829451022883, -0.14480092450215096],
            [0.29716763642446975, 0.12261389982289125, 0.9371115872703172, -0.13593785505083533],
            [-0.004741424219519058, -0.21667124982703953, -0.11084372194284953, -0.969919974895154],
            [-0.7963337906191252, 0.5666479392568178, 0.15796763189745627, -0.14074385999710737],
        ],
        // parallel, exp: 32 steps
        [
            [0.564904872930955, 0.7982898313601676, -0.13794650954709872, -0.15680111667200675],
            [0.14631332353351673, -0.0017900753818999697, 0.9398067095071347, -0.3087920914662075],
            [-0.8107898232811466, 0.5672904657835539, 0.09037731189371231, -0.1123980933542507],
            [0.045768530227259824, 0.20226632989241666, 0.2992758773505902, 0.9313578918269368],
        ],
        // deflation, logcosh: 114 steps
        [
            [0.5627946571535424, 0.802322681191999, -0.1596342929201998, -0.1185638294260794],
            [0.8205391564889489, -0.5551511738424516, 0.001562558629907691, 0.13608903431313052],
            [-0.09899917505623075, -0.06819981209446678, -0.936487745790532, 0.3294520465145622],
            [0.01329773988378059, -0.20840891309276924, -0.3122581510842655, -0.9267598082237435],
        ],
        // deflation, cube: 80 steps
        [
            [0.56501889367036, 0.7957094959673862, -0.16604774240281894, -0.14152100574041143],
            [-0.8210146952854105, 0.5572198201329471, -0.018791834398777137, -0.12283244333782252],
            [-0.08175297156987915, -0.10240943499093223, -0.9644668576636412, 0.229417609901146],
            [-0.0022296996258349923, 0.21416063527915688, 0.20464284661643525, 0.9551186083754879],
        ],
        // deflation, exp: 133 steps
        [
            [0.5624462658694823, 0.8029891602654857, -0.15876382416835183, -0.11686169021987669],
            [0.8209422232395361, -0.5549648426258809, 0.002517640955451338, 0.13439327005389204],
            [0.0977079476193394, 0.06733560260122447, 0.9342508714302311, -0.33629508296464905],
            [0.012697286482541658, -0.20661158865777918, -0.31931648697070736, -0.9247634354238792],
        ],
    ]
}

/// From the same whitened data, start and nonlinearity: the same components, up to sign.
#[test]
fn components_are_those_of_scikit_learn() {
    let z = whiten(&data(), Count::Number(K)).unwrap().apply(&data()).transpose();
    let start = DMatrix::from_fn(K, K, |r, c| {
        let (r, c) = (r as f64, c as f64);
        (1.3 * r * c + r + 0.5 * c * c).cos()
    });
    let all = [Method::Symmetric, Method::Deflation].into_iter().flat_map(|method| {
        [Contrast::Tanh, Contrast::Cube, Contrast::Exp].map(|contrast| (method, contrast))
    });
    let mut worst: f64 = 0.0;
    for ((method, contrast), theirs) in all.zip(theirs()) {
        let options =
            IcaOptions { method, contrast, most_steps: 1000, tolerance: 1e-12, ..IcaOptions::default() };
        let fixed = fixed_point(&z, &start, &options).unwrap();
        assert!(fixed.converged, "{method:?} {contrast:?}: {}", fixed.last_turn);
        for (i, row) in theirs.iter().enumerate() {
            // components have unit variance: the correlation is the cosine of the rows
            let cosine: f64 = (0..K).map(|c| fixed.rotation[(i, c)] * row[c]).sum();
            assert!(cosine.abs() > 0.999_999, "{method:?} {contrast:?}, component {i}: {cosine}");
            worst = worst.max(1.0 - cosine.abs());
        }
    }
    println!("1 − |correlation| at most {worst:.1e}"); // 1.9e-13 seen
}
