use learn::*;
use nalgebra::DMatrix;
use std::time::Instant;
fn load(path: &str) -> DMatrix<f64> {
    let s = std::fs::read_to_string(path).unwrap();
    let r: Vec<Vec<f64>> = s.lines().map(|l| l.split(' ').map(|v| v.parse().unwrap()).collect()).collect();
    DMatrix::from_fn(r.len(), r[0].len(), |i, j| r[i][j])
}
fn main() {
    let d = std::env::args().nth(1).unwrap();
    let (y, z, yt, zt) = (
        load(&format!("{d}/Y.txt")),
        load(&format!("{d}/Z.txt")),
        load(&format!("{d}/Yt.txt")),
        load(&format!("{d}/Zt.txt")),
    );
    let pairs = Pairs::new(&y, &z).unwrap();
    let sz = {
        let m = z.row_mean();
        let mut s = 0.0;
        for i in 0..z.nrows() {
            s += (z.row(i) - &m).norm_squared();
        }
        (s / z.len() as f64).sqrt()
    };
    for start in [Start::KernelCca, Start::Pca] {
        for kappa in [0.1, 0.01, 0.001, 0.0001] {
            for prior in [true, false] {
                if start == Start::Pca && kappa < 0.1 {
                    continue;
                }
                let o = GplvmOptions { start, kappa, prior_in_mapping: prior, ..Default::default() };
                let t = Instant::now();
                let m = SharedGplvm::fit(&pairs, &o).unwrap();
                let t1 = t.elapsed().as_secs_f64();
                let t = Instant::now();
                let mapped = map_frames(&m, &yt).unwrap();
                let t2 = t.elapsed().as_secs_f64() / yt.nrows() as f64;
                let e = ((&mapped.means - &zt).norm_squared() / zt.len() as f64).sqrt() / sz;
                let mut mp = Mapper::new(&m);
                let mut steps = 0;
                for i in 0..yt.nrows() {
                    let v: Vec<f64> = yt.row(i).iter().copied().collect();
                    mp.map(&v).unwrap();
                    steps += mp.scratch().steps();
                }
                let l = m.learning();
                let ps = path_shape(mapped.latents.as_ref().unwrap(), 60.0);
                println!(
                    "{start:?} k{kappa} prior {prior} q{} learn {:.1}ms it {} ev {} start {:.0} end {:.0} map {:.0}us steps {:.1} err {e:.4} key {:.4} jumps {} reljerk {:.0} worst {:.1}  stop {}",
                    m.dimension(),
                    t1 * 1e3,
                    l.iterations,
                    l.evaluations,
                    l.start,
                    l.end,
                    t2 * 1e6,
                    steps as f64 / yt.nrows() as f64,
                    key_pose_error(&m).unwrap() / sz,
                    mapped.jumps.len(),
                    ps.map_or(0.0, |p| p.relative_jerk),
                    ps.map_or(0.0, |p| p.worst_step),
                    l.stopped
                );
            }
        }
    }
    for me in Method::ALL {
        let m = Model::fit(me, &pairs, &Default::default()).unwrap();
        println!("{me} err {:.4}", rms_error(&m, &yt, &zt).unwrap() / sz);
        if let Model::Gplvm(g) = &m {
            println!("{:?}", g.kernels());
        }
        if let Model::Gp(g) = &m {
            println!("{:?} {:?}", g.kernel(), g.learning());
        }
    }
}
