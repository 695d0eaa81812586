use learn::*;
use nalgebra::DMatrix;
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
    let m = SharedGplvm::fit(&pairs, &Default::default()).unwrap();
    let (mut s, mut p) = (Scratch::new(), Prediction::default());
    let (mut s2, mut p2) = (Scratch::new(), Prediction::default());
    for i in (0..yt.nrows()).step_by(20) {
        let v: Vec<f64> = yt.row(i).iter().copied().collect();
        for j in 0..20 {
            let v: Vec<f64> = yt.row(i.saturating_sub(19) + j.min(i)).iter().copied().collect();
            if i.saturating_sub(19) + j <= i {
                m.predict(&v, &mut s, &mut p).unwrap();
            }
        }
        s2.forget();
        m.predict(&v, &mut s2, &mut p2).unwrap();
        let e = |p: &Prediction| {
            (p.mean.iter().zip(zt.row(i).iter()).map(|(a, b)| (a - b).powi(2)).sum::<f64>()
                / zt.ncols() as f64)
                .sqrt()
        };
        println!(
            "{i} warm err {:.3} conf {:.3} steps {} | cold err {:.3} conf {:.3} steps {} nov {:.2} {:?}",
            e(&p),
            p.confidence,
            s.steps(),
            e(&p2),
            p2.confidence,
            s2.steps(),
            p.novelty,
            s.jump()
        );
    }
}
