//! Figures that cannot be drawn cost nothing else.

use std::collections::BTreeMap;

use plots::Figure;
use takes::Progress;
use takes::results::figures::Draw;
use takes::results::folder::{Folder, Plan};
use takes::results::write::write_report;

/// One figure is drawn, one is too large for any page, one makes the drawing library panic, one cannot be made: the numbers are
/// on disk before the first of them, the first is there, and each of the others is named with its reason.
#[test]
fn a_failed_figure_costs_nothing_else() {
    let home = tempfile::tempdir().unwrap();
    let dir = home.path().join("out");
    let there = || dir.join("numbers.csv").is_file() && dir.join("report.json").is_file();
    let figures: Vec<Draw<'_>> = vec![
        ("good", Box::new(|| Ok(Figure::new(100.0, 80.0)))),
        ("large", Box::new(|| Ok(Figure::new(1600.0, 1e7)))),
        (
            "panics",
            Box::new(|| panic!("{}", if there() { "a curve without points" } else { "no numbers yet" })),
        ),
        ("missing", Box::new(|| Err("no rows".into()))),
    ];
    let mut data = |folder: &mut Folder| {
        folder.add("numbers_csv", "numbers.csv")?;
        Ok(folder.write("numbers.csv", b"1,2,3")?)
    };
    let mut report = |files: BTreeMap<String, String>| files.into_values().collect::<Vec<_>>().join(" ");
    let plan = Plan { command: "test", planned: &["numbers.csv", "report.json"], ..Plan::default() };
    let undrawn = write_report(&dir, &plan, &mut data, &figures, &mut report, &Progress::silent()).unwrap();
    let why: Vec<(&str, &str)> = undrawn.iter().map(|u| (u.stem.as_str(), u.why.as_str())).collect();
    assert_eq!(why[1..], [("panics", "a curve without points"), ("missing", "no rows")]);
    assert!(why[0].0 == "large" && why[0].1.contains("allowed: up to 16384 px a side"), "{why:?}");
    let said = std::fs::read_to_string(dir.join("report.json")).unwrap();
    assert_eq!(said, "plots/good.png plots/good.svg numbers.csv report.json");
    assert!(there() && dir.join("plots/good.png").is_file() && !dir.join("plots/large.svg").exists());
}
