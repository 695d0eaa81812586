//! Learning two models of 550 examples and their images (1,100 together; 180 to 62 coordinates), and predicting with
//! them: at most 0.7 of the time of the same by LAPACK, and 1 ms for one frame.
//!
//! `cargo bench -p learn --bench examples` times with criterion. With a folder, `cargo bench -p learn --bench examples -- DIR`, it
//! writes the data there (`X0.f64 Y0.f64 F0.f64`, the same with 1: examples with images, 1,000 frames; row by row, little-endian) and prints
//! one JSON line of CPU seconds; `lapack/run.sh` runs that and the script in turns. Compare only numbers of one such run.

mod common {
    #[cfg(unix)]
    pub mod clock;
    pub mod data;
    pub mod side;
}

use std::hint::black_box;
use std::path::Path;

#[cfg(unix)]
use common::clock::least;
use common::data::motion;
use common::side::side;
use criterion::Criterion;
use learn::{Examples, Mirror, Prediction, RbfOptions, RbfRegression, Scratch};
use nalgebra::DMatrix;

const EXAMPLES: usize = 550;
const FRAMES: usize = 1000;
const INPUTS: usize = 180;
const TARGETS: usize = 62;

struct Data {
    examples: Examples,
    frames: DMatrix<f64>,
}

fn data(examples: usize, seed: u64) -> Data {
    let mut m = motion(examples + FRAMES, INPUTS + TARGETS, seed);
    for mut column in m.column_iter_mut() {
        let known = column.rows(0, examples);
        let (mean, scale) = (known.mean(), known.variance().sqrt());
        column.apply(|v| *v = (*v - mean) / scale);
    }
    let inputs = m.view((0, 0), (examples, INPUTS)).into_owned();
    let targets = m.view((0, INPUTS), (examples, TARGETS)).into_owned();
    let mirror = Mirror { input: side(INPUTS), output: side(TARGETS) };
    let examples_ = Examples::new(inputs, targets, Some(mirror)).expect("finite numbers");
    Data { examples: examples_, frames: m.view((examples, 0), (FRAMES, INPUTS)).into_owned() }
}

fn fit(data: &Data) -> RbfRegression {
    RbfRegression::fit(&data.examples, &RbfOptions::default()).expect("it fits")
}

fn one_by_one(model: &RbfRegression, frames: &DMatrix<f64>, count: usize) {
    let (mut scratch, mut out) = (Scratch::new(), Prediction::default());
    let transposed = frames.transpose();
    for frame in transposed.as_slice().chunks_exact(INPUTS).take(count) {
        model.predict(black_box(frame), &mut scratch, &mut out).expect("it predicts");
        black_box(&out);
    }
}

fn criterion_benches(c: &mut Criterion) {
    let both = [data(EXAMPLES, 17), data(EXAMPLES, 18)];
    c.bench_function("learn two models of 1,100 mirrored examples", |b| {
        b.iter(|| both.iter().map(|d| fit(black_box(d))).collect::<Vec<_>>())
    });
    let model = fit(&both[0]);
    c.bench_function("predict 1,000 frames with variance", |b| {
        b.iter(|| model.predict_batch(black_box(&both[0].frames)).expect("it predicts"))
    });
    c.bench_function("predict 20 frames one by one", |b| b.iter(|| one_by_one(&model, &both[0].frames, 20)));
    let few = both[0].examples.subset(&(0..520).collect::<Vec<_>>()).expect("examples");
    let more = both[0].examples.subset(&(520..550).collect::<Vec<_>>()).expect("examples");
    let options = RbfOptions { kernel: Some(model.kernel()), ..RbfOptions::default() };
    let known = RbfRegression::fit(&few, &options).expect("it fits");
    c.bench_function("add 30 examples to 520", |b| {
        b.iter(|| {
            let mut model = known.clone();
            model.grow(black_box(&more)).expect("it grows");
            model
        })
    });
    let many = data(3000, 19);
    let options = RbfOptions { kernel: Some(model.kernel()), ..RbfOptions::default() };
    c.bench_function("6,000 mirrored examples through inducing points, kernel given", |b| {
        b.iter(|| RbfRegression::fit(black_box(&many.examples), &options).expect("it fits"))
    });
}

#[cfg(unix)]
fn beside_lapack(dir: &Path) {
    let write = |name: String, m: &DMatrix<f64>| {
        let bytes: Vec<u8> = m.transpose().iter().flat_map(|v| v.to_le_bytes()).collect();
        std::fs::write(dir.join(name), bytes).expect("the folder can be written");
    };
    let mirrored =
        |map: &[(usize, f64)], m: &DMatrix<f64>| {
            let n = m.nrows();
            DMatrix::from_fn(2 * n, m.ncols(), |i, k| {
                if i < n { m[(i, k)] } else { map[k].1 * m[(i - n, map[k].0)] }
            })
        };
    let mut lines = Vec::new();
    for (i, seed) in [17, 18].into_iter().enumerate() {
        let data = data(EXAMPLES, seed);
        write(format!("X{i}.f64"), &mirrored(&side(INPUTS), data.examples.inputs()));
        write(format!("Y{i}.f64"), &mirrored(&side(TARGETS), data.examples.targets()));
        write(format!("F{i}.f64"), &data.frames);
        let model = fit(&data);
        let fit_s = least(3, || {
            black_box(fit(&data));
        });
        let batch_s = least(5, || {
            black_box(model.predict_batch(&data.frames).expect("it predicts"));
        });
        one_by_one(&model, &data.frames, 2);
        let one_s = least(5, || one_by_one(&model, &data.frames, 20)) / 20.0;
        let (k, learning) = (model.kernel(), model.learning());
        lines.push(format!(
            "{{\"fit_s\":{fit_s:.5},\"batch_s\":{batch_s:.5},\"one_s\":{one_s:.6},\"lml\":{:.9e},\"theta\":[{:.9e},{:.9e},{:.9e}],\
             \"iterations\":{},\"evaluations\":{},\"diameter\":{:.3}}}",
            model.log_likelihood(),
            k.signal_variance,
            k.length,
            k.noise_variance,
            learning.iterations,
            learning.evaluations,
            model.diameter(),
        ));
    }
    println!("{{\"engine\":\"contrapposto\",\"models\":[{}]}}", lines.join(","));
}

fn main() {
    #[cfg(unix)]
    if let Some(dir) = std::env::args().skip(1).find(|a| !a.starts_with('-') && Path::new(a).is_dir()) {
        return beside_lapack(Path::new(&dir));
    }
    let mut c = Criterion::default().configure_from_args().sample_size(10);
    criterion_benches(&mut c);
    c.final_summary();
}
