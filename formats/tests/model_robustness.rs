//! Broken models never panic: every file cut short, and files with one small piece changed, are read or refused.
//!
//! The changes come from a counter, not from a clock: every run sees the same files.

use std::path::{Path, PathBuf};

use formats::model::{ImportOptions, open};

fn files() -> Vec<PathBuf> {
    let own = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/models"));
    let mut all: Vec<PathBuf> = [
        (support::shared("models/dm_control"), "xml"),
        (support::shared("models/pinocchio"), "urdf"),
        (own.into(), "xml"),
        (own.into(), "urdf"),
    ]
    .iter()
    .flat_map(|(folder, extension)| support::files(folder, extension))
    .collect();
    all.sort();
    assert_eq!(all.len(), 12);
    all
}

/// Next number of a fixed sequence (Knuth's MMIX generator).
fn next(seed: &mut u64) -> usize {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 33) as usize
}

/// Reads the text as a file in a folder of its own; an error must have words.
fn survives(folder: &Path, text: &[u8]) -> bool {
    let path = folder.join("model.xml");
    std::fs::write(&path, text).unwrap();
    match open(&path, &ImportOptions { dynamics_only: true }) {
        Ok(imported) => {
            assert!(imported.character.rest.iter().all(|x| x.is_finite()));
            true
        }
        Err(e) => {
            assert!(!e.to_string().is_empty());
            false
        }
    }
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("common")).unwrap();
    for name in ["skybox", "visual", "materials"] {
        let file = format!("common/{name}.xml");
        std::fs::write(folder.path().join(file), "<mujoco/>").unwrap();
    }
    folder
}

#[test]
fn files_cut_short_are_refused() {
    let folder = folder();
    for file in files() {
        let text = std::fs::read(&file).unwrap();
        let end = text.iter().rposition(|&b| b == b'>').unwrap();
        for k in 0..40 {
            let cut = end * k / 40;
            assert!(!survives(folder.path(), &text[..cut]), "{} cut at {cut}", file.display());
        }
        assert!(survives(folder.path(), &text), "{}", file.display());
    }
}

#[test]
fn slow_changed_files_are_read_or_refused() {
    const PIECES: [&str; 24] = [
        "0",
        "-1",
        "1e308",
        "-1e308",
        "1e-308",
        "nan",
        "inf",
        "",
        " ",
        "\"",
        "<",
        ">",
        "/>",
        "&",
        "&#0;",
        "é",
        "\u{feff}",
        "9 9 9 9 9 9 9",
        "free",
        "<body>",
        "</body>",
        "<geom size=\"1e200\"/>",
        "<joint/>",
        "\0",
    ];
    let folder = folder();
    let mut seed = 7;
    let (mut read, mut refused) = (0, 0);
    for file in files() {
        let text = std::fs::read(&file).unwrap();
        for _ in 0..80 {
            let mut changed = text.clone();
            for _ in 0..=next(&mut seed) % 3 {
                let at = next(&mut seed) % changed.len();
                let gone = (next(&mut seed) % 6).min(changed.len() - at);
                let piece = PIECES[next(&mut seed) % PIECES.len()];
                changed.splice(at..at + gone, piece.bytes());
            }
            if survives(folder.path(), &changed) { read += 1 } else { refused += 1 }
        }
        // numbers and words of attributes alone: changes that are still XML
        let text = String::from_utf8(text).unwrap();
        let values: Vec<(usize, usize)> = text
            .match_indices("=\"")
            .filter_map(|(i, _)| Some((i + 2, i + 2 + text[i + 2..].find('"')?)))
            .collect();
        for _ in 0..80 {
            let (from, to) = values[next(&mut seed) % values.len()];
            let piece = PIECES[next(&mut seed) % 9];
            let changed = format!("{}{piece}{}", &text[..from], &text[to..]);
            if survives(folder.path(), changed.as_bytes()) { read += 1 } else { refused += 1 }
        }
    }
    assert!(read > 200 && refused > 200, "{read} read, {refused} refused"); // both roads are walked
}
