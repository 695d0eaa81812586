//! The two edits that ship, made again: scenes, learned edits, numbers and figures of `docs/BY_EXAMPLE.md`.
//!
//! `cargo run --release -p studies --example shipped_edits -- --out DIR`: learns both from their training performances, applies them to an errand of two
//! minutes, prints how far they are from the script, and writes figures into DIR. With `--write`, the scenes and learned edits
//! in `scenes/` are written again. Everything is a script: nothing is read.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use plots::predicted::{Predicted, prediction};
use plots::{StripOptions, StripRow, View, film_strip_with};
use studies::propagate::apply::{Use, apply};
use studies::propagate::shipped::{Shipped, errand, pair};
use takes::results::folder::{Overwrite, write_file};

fn main() -> Result<(), Box<dyn Error>> {
    let (mut out, mut write) = (None, false);
    let mut arguments = std::env::args().skip(1);
    while let Some(a) = arguments.next() {
        match a.as_str() {
            "--out" => out = Some(arguments.next().ok_or("--out needs a folder")?),
            "--write" => write = true,
            other => return Err(format!("`{other}`: allowed are --out DIR and --write").into()),
        }
    }
    if let Some(out) = &out {
        std::fs::create_dir_all(out)?;
    }
    for shipped in Shipped::ALL {
        if write {
            scenes(shipped)?;
        }
        report(shipped, out.as_deref().map(Path::new))?;
    }
    Ok(())
}

/// Learns the edit, applies it to the errand, and says how well it holds.
fn report(shipped: Shipped, out: Option<&Path>) -> Result<(), Box<dyn Error>> {
    let edit = Arc::new(shipped.learn()?);
    let unseen = pair("errand", &errand(), shipped.change())?;
    let done = apply(&edit, &unseen.source, &Use::default())?;
    let held = shipped.held(&unseen.source, &unseen.target, &done.untimed);
    println!(
        "{}: taught by {} frames; errand of {:.0} s\n  walking ({} frames, asked {:.1}°): {:.2}° RMS, {:.2}° at most\n  \
         standing and turning on the spot ({}): {:.2}° RMS, {:.2}° at most\n  between ({}): {:.2}° RMS, {:.2}° at most",
        shipped.name(),
        edit.frames.len(),
        unseen.source.duration_s(),
        held.frames.0,
        held.asked_deg,
        held.walking_deg.0,
        held.walking_deg.1,
        held.frames.1,
        held.standing_deg.0,
        held.standing_deg.1,
        held.frames.2,
        held.between_deg.0,
        held.between_deg.1,
    );
    let Some(out) = out else { return Ok(()) };
    let [mean, deviation, blended] = shipped.predicted(&edit, &done);
    let truth = shipped.truth(&edit, &unseen)?;
    let label = shipped.joint_label();
    let none = vec![0.0; mean.len()];
    let of = Predicted {
        rate_hz: unseen.source.rate_hz,
        source: &none,
        mean: &mean,
        deviation: &deviation,
        blended: &blended,
        truth: Some(&truth),
        label,
        row_s: 31.5,
    };
    let note = format!(
        "an errand of {:.0} s, unseen; taught by {} frames at 30 Hz and their mirror images; walking {:.1}° RMS from the script, standing {:.1}°",
        unseen.source.duration_s(),
        edit.frames.len(),
        held.walking_deg.0,
        held.standing_deg.0
    );
    let figure = prediction(&of, shipped.title(), &note);
    for path in figure.save(out, &format!("{}_prediction", shipped.name()))? {
        println!("{}", path.display());
    }
    let (character, _) = bodies::anthropometry::human::human();
    let rows = [StripRow::new("before", &unseen.source), StripRow::new("after", &done.untimed)];
    let options = StripOptions {
        count: 13,
        from_s: 0.0,
        to_s: Some(24.0),
        view: View::degrees(if shipped == Shipped::LeanBack { 80.0 } else { 40.0 }).unwrap_or_default(),
        title: Some(shipped.title().into()),
        ..StripOptions::default()
    };
    let figure = film_strip_with(&rows, &character, "the first 24 s of the errand", &options);
    for path in figure.save(out, &format!("{}_strip", shipped.name()))? {
        println!("{}", path.display());
    }
    Ok(())
}

/// Writes the training performances, the scene that uses the edit, and the edit.
fn scenes(shipped: Shipped) -> Result<(), Box<dyn Error>> {
    let root = support::root().join("scenes");
    std::fs::create_dir_all(root.join("propagate"))?;
    let edit = (shipped.model(), formats::example_file::bytes(&shipped.learn_small()?));
    let texts = shipped.scenes().map(|(file, text)| (file, text.into_bytes()));
    for (file, bytes) in texts.into_iter().chain([edit]) {
        let path = root.join(&file);
        // what is the same is not touched, so that nothing is built again
        if std::fs::read(&path).is_ok_and(|old| old == bytes) {
            continue;
        }
        write_file(&path, &bytes, Overwrite::Allow, &[])?;
        println!("scenes/{file}: {} bytes", bytes.len());
    }
    Ok(())
}
