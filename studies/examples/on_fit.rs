//! Track edits on clips, as the table of `docs/ON_FIT.md`: what the fit takes, and what comes of succession, amplitude and reach.
//!
//! `cargo run --release -p studies --example on_fit -- CLIPS`: CLIPS is a folder of clips.

use std::path::PathBuf;

use studies::on_fit::{HEADING, Halved, measure};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let dir = std::env::args().nth(1).ok_or("the folder of clips is missing")?;
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(dir)?.map(|e| e.map(|e| e.path())).collect::<Result<_, _>>()?;
    files.retain(|path| path.extension().is_some_and(|ending| ending == "bvh"));
    files.sort();
    print!("{HEADING}");
    let mut all = Vec::new();
    for file in &files {
        let measured = measure(file)?;
        println!("{measured}");
        all.push(measured);
    }
    let mut keys: Vec<f64> = all.iter().map(|m| m.fit.keys_per_s).collect();
    keys.sort_by(f64::total_cmp);
    let median = keys.get(keys.len() / 2).ok_or("no clip")?;
    let lags: Vec<_> = all.iter().flat_map(|m| &m.lags).collect();
    let halved: Vec<_> = all.iter().flat_map(|m| &m.halved).collect();
    let reach: Vec<_> = all.iter().flat_map(|m| &m.reach).collect();
    println!(
        "\nclips: {}; keys per second and joint: median {median:.1}, most {:.1}",
        all.len(),
        keys[keys.len() - 1]
    );
    println!(
        "lags within a frame: {} of {}; ranges halved within max(5 %, 2°): {} of {}; reach within 1 %: {} of {}; slip within 2 mm: {} of {}",
        lags.iter().filter(|l| (l.found - l.asked).abs() <= 1.0).count(),
        lags.len(),
        halved.iter().filter(|h| Halved::holds(h)).count(),
        halved.len(),
        reach.iter().filter(|r| (**r / studies::on_fit::REACH - 1.0).abs() <= 0.01).count(),
        reach.len(),
        all.iter().filter(|m| m.slip_mm[1..].iter().all(|x| *x <= m.slip_mm[0] + 2.0)).count(),
        all.len(),
    );
    Ok(())
}
