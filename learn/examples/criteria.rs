//! The two criteria of YAH10 §6.2 on a known rule: which latent dimension, how many iterations, which start?
//!
//! `cargo run --release -p learn --example criteria`. Thirty key poses of the human-to-lamp rule of
//! `tests/rule/performance.rs`; errors in degrees RMS at the key poses and over 500 unseen frames, jerk of
//! the latent path over its extent (1/s³), largest over median latent step, jumps between basins.

#[path = "../tests/rule/performance.rs"]
mod performance;

use learn::{
    GplvmOptions, Locate, Method, Model, Pairs, SharedGplvm, Start, key_pose_error, map_frames, path_shape,
    rms_error,
};
use performance::{farthest, performance};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (y, z) = performance(2000, 0);
    let (unseen, truth) = performance(500, 5);
    let keep = farthest(&y, 30);
    let pairs = Pairs::new(&y.select_rows(&keep), &z.select_rows(&keep))?;
    println!(
        "| dimension | iterations | start | −ln L start | −ln L end | key poses ° | unseen ° | jerk/extent 1/s³ | worst step | jumps |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    let row = |options: GplvmOptions| -> Result<(), Box<dyn std::error::Error>> {
        let model = SharedGplvm::fit(&pairs, &options)?;
        let mapped = map_frames(&model, &unseen)?;
        let path =
            mapped.latents.as_ref().and_then(|l| path_shape(l, 30.0)).ok_or("the path does not move")?;
        let learning = model.learning();
        println!(
            "| {} | {} | {:?} κ {} | {:.0} | {:.0} | {:.2} | {:.2} | {:.0} | {:.1} | {} |",
            model.dimension(),
            learning.iterations,
            options.start,
            options.kappa,
            learning.start,
            learning.end,
            key_pose_error(&model)?.to_degrees(),
            rms_error(&model, &unseen, &truth)?.to_degrees(),
            path.relative_jerk,
            path.worst_step,
            mapped.jumps.len()
        );
        Ok(())
    };
    for dimension in [2, 5, 10, 15, 20, 29] {
        row(GplvmOptions { dimension: Some(dimension), ..GplvmOptions::default() })?;
    }
    for iterations in [0, 10, 20, 35, 150, 300] {
        row(GplvmOptions { iterations, ..GplvmOptions::default() })?;
    }
    for kappa in [0.001, 0.01, 0.03, 0.3] {
        row(GplvmOptions { kappa, ..GplvmOptions::default() })?;
    }
    for iterations in [35, 70, 150, 300] {
        row(GplvmOptions { iterations, start: Start::Pca, ..GplvmOptions::default() })?;
    }
    println!("Latent points by posterior, by likelihood:");
    for locate in [Locate::Posterior, Locate::Likelihood] {
        row(GplvmOptions { locate, ..GplvmOptions::default() })?;
    }
    for method in Method::ALL {
        let model = Model::fit(method, &pairs, &GplvmOptions::default())?;
        println!("{method}: {:.2}° unseen", rms_error(&model, &unseen, &truth)?.to_degrees());
    }
    Ok(())
}
