use learn::*;
use nalgebra::DMatrix;
fn load(path:&str)->DMatrix<f64>{ let s=std::fs::read_to_string(path).unwrap(); let r:Vec<Vec<f64>>=s.lines().map(|l| l.split(' ').map(|v| v.parse().unwrap()).collect()).collect(); DMatrix::from_fn(r.len(), r[0].len(), |i,j| r[i][j]) }
fn main(){
    let d=std::env::args().nth(1).unwrap();
    let (y,z,yt,zt)=(load(&format!("{d}/Y.txt")),load(&format!("{d}/Z.txt")),load(&format!("{d}/Yt.txt")),load(&format!("{d}/Zt.txt")));
    let pairs=Pairs::new(&y,&z).unwrap();
    let m=SharedGplvm::fit(&pairs,&Default::default()).unwrap();
    let mut mp=Mapper::new(&m); let mut steps=0; 
    let cpu=||{ let s=std::fs::read_to_string("/proc/self/schedstat").unwrap(); s.split(' ').next().unwrap().parse::<f64>().unwrap()*1e-3 }; let c0=cpu(); let t=std::time::Instant::now(); for i in 0..yt.nrows(){ let v:Vec<f64>=yt.row(i).iter().copied().collect(); mp.map(&v).unwrap(); steps+=mp.scratch().steps(); }
    let c1=(cpu()-c0)/yt.nrows() as f64; let t1=t.elapsed().as_secs_f64()/yt.nrows() as f64;
    let mapped=map_frames(&m,&yt).unwrap();
    let e=(&mapped.means-&zt).norm_squared()/zt.len() as f64;
    println!("REACH {:?} EVERY {:?} {:.0}us cpu {:.0} steps {:.1} err {:.4} cold {:.4} jumps {} ", std::env::var("REACH"), std::env::var("EVERY"), t1*1e6, c1, steps as f64/yt.nrows() as f64, e.sqrt(), rms_error(&m,&yt,&zt).unwrap(), mapped.jumps.len());
}
