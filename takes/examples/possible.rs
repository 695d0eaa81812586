//! How far clips that step are from being possible: the table of `docs/WALKING.md`.
//!
//! `cargo run --release -p takes --example possible [-- FOLDER [CLIP…]]`: every clip of the folder (by default the mocap beside the
//! repository) that steps, or those named, with what is said of them.

use std::path::{Path, PathBuf};

use controllers::likeness::Likeness;
use takes::{Ask, Possible, RootMode};

/// Clips that stand.
const STANDS: [&str; 8] = ["02_05", "05_06", "104_41", "127_01", "135_04", "135_08", "14_24", "14_37"];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let folder = args.next().unwrap_or_else(|| "../shared/mocap/bvh".into());
    let named: Vec<String> = args.collect();
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(Path::new(&folder))?.map(|e| Ok(e?.path())).collect::<std::io::Result<_>>()?;
    files.retain(|f| {
        let stem = f.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        let asked = named.contains(&stem);
        let bvh = f.extension().is_some_and(|e| e == "bvh");
        bvh && if named.is_empty() { !STANDS.iter().any(|s| stem.starts_with(s)) } else { asked }
    });
    files.sort();
    println!(
        "| clip | s | pressure inside before | after | links RMS mm | worst frame | upper body ° | out of reach mm | shift mm | flights, frames | not possible | links from raw mm | upper RMS °, smoothed (raw) | contacts s (in one only) | rises off | strides off | |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    let (mut names, mut all): (Vec<String>, Vec<Possible>) = Default::default();
    for file in files {
        let mut take = takes::open(file.as_path(), &Ask::default())?;
        take.conditions.physics.root = RootMode::Free;
        let Some(p) = take.possible()? else { continue };
        let m = p.measures;
        let percent = |x: Option<f64>| x.map_or("–".into(), |x| format!("{:.0} %", 100.0 * x));
        let shift = p.shift.iter().map(|s| s.norm()).fold(0.0, f64::max);
        println!(
            "| {} | {:.1} | {} | {} | {:.0} | {:.0} | {:.1} | {:.0} | {:.0} | {} | {} | {} |",
            take.name,
            p.clip.duration_s(),
            percent(m.inside_before),
            percent(m.inside_after),
            1e3 * m.links_rms_m,
            1e3 * m.links_worst_m,
            m.upper_deg,
            1e3 * m.out_of_reach_m,
            1e3 * shift,
            m.flights,
            p.unmet.len(),
            p.likeness.as_ref().map_or("– | – | – | – | – |".into(), likeness),
        );
        if !named.is_empty() {
            p.shifts.iter().for_each(|s| println!("  {s}"));
            p.unmet.iter().for_each(|u| println!("  {u}"));
            for c in p.plan.contacts() {
                println!("  {} {:.2}–{:.2}", c.point, c.from_s, c.to_s);
            }
            for (what, pairs) in [
                ("rise", p.likeness.as_ref().map(|l| &l.rises)),
                ("stride", p.likeness.as_ref().map(|l| &l.strides)),
            ] {
                for pair in pairs.into_iter().flatten() {
                    println!(
                        "  {what} at {:.2} s: {:.0} mm, captured {:.0}",
                        pair.at_s,
                        1e3 * pair.made_m,
                        1e3 * pair.captured_m
                    );
                }
            }
            println!("  flights fall to within {:.1e} m/s²", m.flight_error_m_s2);
        }
        names.push(take.name.clone());
        all.push(p);
    }
    let count = |of: &dyn Fn(&Possible) -> bool| all.iter().filter(|p| of(p)).count();
    println!(
        "{} clips; links within 80 mm in every frame: {}; pressure inside in 95 % of the frames: {}, before {}; nothing named: {}",
        all.len(),
        count(&|p| p.measures.links_worst_m <= 0.08),
        count(&|p| p.measures.inside_after.is_some_and(|x| x >= 0.95)),
        count(&|p| p.measures.inside_before.is_some_and(|x| x >= 0.95)),
        count(&|p| p.unmet.is_empty()),
    );
    let unlike = |p: &Possible| p.likeness.as_ref().is_none_or(|l| !l.unlike().is_empty());
    println!("as captured in every measure, so that they count: {} of {}", count(&|p| !unlike(p)), all.len());
    for (name, p) in names.iter().zip(&all).filter(|(_, p)| unlike(p)) {
        let said: Vec<String> = p.likeness.iter().flat_map(|l| l.unlike()).map(|u| u.to_string()).collect();
        println!("  {name} does not count: {}", said.join("; "));
    }
    Ok(())
}

/// The columns of what a motion made possible has of its capture.
fn likeness(l: &Likeness) -> String {
    let signed = |x: f64| format!("{:+.0} %", 100.0 * x);
    format!(
        "{:.0} | {:.1} ({:.1}) | {:+.3} ({}) | {} | {} | {}",
        1e3 * l.links_m,
        l.upper_deg,
        l.upper_raw_deg,
        l.times.as_ref().map_or(0.0, |t| t.by_s),
        l.strange,
        if l.rises.is_empty() { "–".into() } else { signed(l.rise_off()) },
        if l.strides.is_empty() { "–".into() } else { signed(l.stride_off()) },
        if l.unlike().is_empty() { "counts" } else { "does not count" },
    )
}
