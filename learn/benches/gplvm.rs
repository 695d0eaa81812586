//! Learning a shared GPLVM and mapping frames with it: at most 0.1 s for 52 key poses in 30 dimensions and
//! at least 1,000 frames/s are asked for, and half of GPy's time.
//!
//! `cargo bench -p learn --bench gplvm` times with criterion. With a folder, `cargo bench -p learn --bench
//! gplvm -- DIR`, it writes the data there (`Y.f64`, `Z.f64`: 52 × 120 and 52 × 60, row by row,
//! little-endian) and prints one JSON line of CPU seconds; `gpy/run.sh` runs that and GPy in turns. Compare
//! only numbers of one such run.

mod common {
    #[cfg(unix)]
    pub mod clock;
    pub mod data;
}

use std::hint::black_box;
use std::path::Path;

#[cfg(unix)]
use common::clock::least;
use common::data::motion;
use criterion::Criterion;
use learn::{GplvmOptions, Mapper, Method, Model, Pairs, SharedGplvm};
use nalgebra::DMatrix;

struct Data {
    pairs: Pairs,
    y: DMatrix<f64>,
    z: DMatrix<f64>,
    /// 120 × 300: one frame a column.
    frames: DMatrix<f64>,
}

fn data(n: usize, outputs: usize) -> Data {
    let m = motion(2000, 120 + outputs, 17);
    let keys: Vec<usize> = (0..n).map(|i| i * 1600 / n + 13 * i % 7).collect();
    let y = m.columns(0, 120).select_rows(&keys);
    let z = m.columns(120, outputs).select_rows(&keys);
    let pairs = Pairs::new(&y, &z).expect("distinct frames");
    let frames = m.view((1650, 0), (300, 120)).transpose();
    Data { pairs, y, z, frames }
}

fn fit(data: &Data) -> SharedGplvm {
    SharedGplvm::fit(&data.pairs, &GplvmOptions::default()).expect("it fits")
}

fn criterion_benches(c: &mut Criterion) {
    for (n, outputs) in [(30, 60), (52, 60), (52, 150), (115, 60)] {
        let data = data(n, outputs);
        c.bench_function(&format!("learn, {n} key poses, 120 to {outputs}"), |b| {
            b.iter(|| fit(black_box(&data)))
        });
    }
    let data = data(52, 60);
    for method in Method::ALL {
        let model = Model::fit(method, &data.pairs, &GplvmOptions::default()).expect("it fits");
        let mut mapper = Mapper::new(&model);
        let mut next = (0..300).chain((0..299).rev()).cycle();
        c.bench_function(&format!("map a frame, {method}, 52 key poses"), |b| {
            b.iter(|| {
                let frame = next.next().unwrap_or(0);
                black_box(mapper.map(&data.frames.as_slice()[frame * 120..(frame + 1) * 120]).is_ok())
            });
        });
    }
}

#[cfg(unix)]
fn beside_gpy(dir: &Path) {
    let data = data(52, 60);
    for (name, m) in [("Y", &data.y), ("Z", &data.z)] {
        let bytes: Vec<u8> = m.transpose().iter().flat_map(|v| v.to_le_bytes()).collect();
        std::fs::write(dir.join(format!("{name}.f64")), bytes).expect("the folder can be written");
    }
    let model = fit(&data);
    let learn_s = least(5, || {
        black_box(fit(&data));
    });
    let mut mapper = Mapper::new(&model);
    let map_s = least(3, || {
        mapper.forget();
        for frame in data.frames.as_slice().chunks_exact(120) {
            mapper.map(frame).expect("it maps");
        }
    }) / 300.0;
    println!(
        "{{\"engine\":\"contrapposto\",\"learn_s\":{learn_s:.5},\"map_s\":{map_s:.6},\"iterations\":{}}}",
        model.learning().iterations
    );
}

fn main() {
    #[cfg(unix)]
    if let Some(dir) = std::env::args().skip(1).find(|a| !a.starts_with('-') && Path::new(a).is_dir()) {
        return beside_gpy(Path::new(&dir));
    }
    let mut c = Criterion::default().configure_from_args().sample_size(20);
    criterion_benches(&mut c);
    c.final_summary();
}
