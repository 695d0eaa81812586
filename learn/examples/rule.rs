#[path="../tests/rule/performance.rs"] mod rule;
use learn::*; use rule::*;
use rand::{RngExt,SeedableRng}; use rand_pcg::Pcg64;
fn main(){
    let (y,z)=performance(2000,0); let (yt,zt)=performance(1000,5);
    println!("R2 {:.3} {:.3} std {:.1} deg", linear_r2(&y,&z), linear_r2(&yt,&zt), { let c=&zt - nalgebra::DMatrix::from_element(zt.nrows(),1,1.0)*zt.row_mean(); (c.norm_squared()/zt.len() as f64).sqrt().to_degrees()});
    let mut sets=vec![("farthest".to_string(),farthest(&y,30))];
    for seed in 0..3 { let mut r=Pcg64::seed_from_u64(seed); let mut v=Vec::new(); while v.len()<30 { let i=r.random_range(0..2000); if !v.contains(&i){v.push(i)} } sets.push((format!("random{seed}"),v)); }
    for (n,keep) in &sets {
        let p=Pairs::new(&y.select_rows(keep),&z.select_rows(keep)).unwrap();
        print!("{n:20}");
        for m in Method::ALL { let m=Model::fit(m,&p,&Default::default()).unwrap(); print!(" {:.2}", rms_error(&m,&yt,&zt).unwrap().to_degrees()); }
        for (q,k,st,it) in [(29,0.05,Start::KernelCca,70),(29,0.1,Start::KernelCca,70),(29,0.2,Start::KernelCca,70),(29,0.5,Start::KernelCca,70),(29,1.,Start::KernelCca,70),(29,0.1,Start::KernelCca,35),(29,0.1,Start::KernelCca,150),(15,0.1,Start::KernelCca,70),(8,0.1,Start::KernelCca,70),(29,0.01,Start::Pca,70)] {
            let o=GplvmOptions{dimension:Some(q),kappa:k,start:st,iterations:it,..Default::default()}; let m=SharedGplvm::fit(&p,&o).unwrap();
            print!(" | {q} {k} {st:?} {it}: {:.2} {:.0}", rms_error(&m,&yt,&zt).unwrap().to_degrees(), m.learning().end); }
        println!();
    }
}
