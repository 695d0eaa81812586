//! Figures of a sample body: nothing clipped, nothing overlapping, the same bytes twice.

mod sample;

use std::path::{Path, PathBuf};

use plots::{Figure, StripRow, film_strip};

fn directory(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("plots").join(name);
    std::fs::create_dir_all(&path).unwrap();
    path
}

fn figures() -> Vec<(&'static str, Figure)> {
    let character = sample::human();
    let (plain, edited) = (sample::bow(&character, 0.0), sample::bow(&character, 0.2));
    let rows = [StripRow { label: "unedited", clip: &plain }, StripRow { label: "edited", clip: &edited }];
    let walk = sample::walk(&character);
    let walking = [StripRow { label: "walk", clip: &walk }];
    vec![
        ("strip", film_strip(&rows, &character, 8, "bow: succession 0.2 s, then 0.3 s; 120 Hz")),
        ("strip-walk", film_strip(&walking, &character, 6, "a motion that travels")),
    ]
}

#[test]
fn figures_are_written() {
    let dir = directory("written");
    for (name, figure) in figures() {
        let s = std::time::Instant::now();
        figure.save(&dir, name).unwrap();
        eprintln!("{name} {:?}", s.elapsed());
    }
}
