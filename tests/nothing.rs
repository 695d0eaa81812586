//! Numbers of nothing: every function whose name says that it sums up measured numbers has a test that gives it none of them, or only
//! zeros.

use std::path::{Path, PathBuf};

/// Parts of names of functions that divide by how many or how much there is.
const WORDS: [&str; 8] = ["rms", "ratio", "ratios", "worst", "share", "shares", "percent", "relative"];

/// File, function, and the test that gives it nothing: a file and the test's name, or why nothing cannot come.
const KNOWN: &[(&str, &str, &str)] = &[
    ("bodies/src/anthropometry/limits.rs", "rig_share", "a number of joints, never zero"),
    ("cli/src/style_args.rs", "percent", "reads a word"),
    ("cli/src/summary.rs", "percent", "writes a number that may be none"),
    ("cli/src/analysis_text.rs", "percent", "writes a number that may be none"),
    (
        "controllers/src/support.rs",
        "shares",
        "controllers/src/support.rs: shares_of_nothing_and_of_one_place",
    ),
    ("crosscheck/src/check.rs", "ratio", "crosscheck/src/check.rs: zeros_on_both_sides_agree"),
    ("crosscheck/src/check.rs", "relative", "crosscheck/src/check.rs: zeros_on_both_sides_agree"),
    (
        "dynamics/src/verdict/judge.rs",
        "worst_span",
        "dynamics/src/verdict/judge.rs: spans_are_judged_by_their_largest_value",
    ),
    (
        "dynamics/src/ground_forces.rs",
        "rms_difference",
        "dynamics/src/ground_forces.rs: differences_of_nothing_and_of_zeros",
    ),
    ("edits/src/by_example/onto.rs", "ratio", "of bodies with a size; others are refused"),
    ("edits/src/on_fit/support.rs", "share", "a table with a number for each frame"),
    ("edits/src/style/set.rs", "share", "channels that all stand still are refused"),
    ("learn/src/ica/mod.rs", "share", "channels that all stand still are refused"),
    ("learn/src/validate.rs", "rms_error", "learn/src/validate.rs: the_error_of_nothing_is_zero"),
    ("learn/src/validate.rs", "rms", "learn/src/validate.rs: the_error_of_nothing_is_zero"),
    ("learn/src/parity.rs", "share", "one of two constants"),
    ("motion/src/metrics.rs", "joint_rms_deg", "motion/src/metrics.rs: numbers_of_nothing_are_zero"),
    ("motion/src/metrics.rs", "position_rms_mm", "motion/src/metrics.rs: numbers_of_nothing_are_zero"),
    ("motion/src/metrics.rs", "jerk_rms", "motion/src/metrics.rs: numbers_of_nothing_are_zero"),
    ("plots/src/trade.rs", "worst", "plots/src/trade.rs: the_worst_of_nothing_has_a_length"),
    ("plots/src/columns.rs", "rms", "plots/src/columns.rs: the_mean_of_nothing_is_zero"),
    ("sim/src/foresight/mod.rs", "offset_rms", "sim/src/foresight/mod.rs: offsets_of_nothing_and_of_zeros"),
    ("sim/src/ledger.rs", "correction_rms_n", "sim/src/ledger.rs: a_ledger_without_steps_is_zero"),
    ("studies/src/style/mod.rs", "share", "studies/src/style/mod.rs: no_share_of_no_gap_is_closed"),
    ("takes/src/keyed.rs", "share", "a key, clamped to 0 to 1"),
    (
        "takes/src/results/dynamic_report.rs",
        "percent",
        "takes/src/results/dynamic_report.rs: numbers_of_a_run_in_which_nothing_happened",
    ),
];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") && !path.ends_with("tests.rs") {
            found.push(path);
        }
    }
}

/// Functions of a source with one of [`WORDS`] in their name, but for those of its tests.
fn summing(source: &str) -> Vec<&str> {
    let code = source.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let names = code.lines().filter_map(|line| {
        let line = line.trim_start();
        let before = ["", "pub ", "pub(crate) ", "pub(super) ", "const ", "pub const "];
        let rest = before.iter().find_map(|b| line.strip_prefix(b)?.strip_prefix("fn "))?;
        rest.split(['(', '<']).next()
    });
    names.filter(|name| name.split('_').any(|part| WORDS.contains(&part))).collect()
}

#[test]
fn numbers_of_nothing_have_tests() {
    let root = support::root();
    let mut files = Vec::new();
    for entry in std::fs::read_dir(&root).unwrap() {
        let src = entry.unwrap().path().join("src");
        if src.is_dir() {
            sources(&src, &mut files);
        }
    }
    let mut seen = Vec::new();
    for file in files {
        let source = std::fs::read_to_string(&file).unwrap();
        let at = file.strip_prefix(&root).unwrap().to_str().unwrap().to_owned();
        for name in summing(&source) {
            let known = KNOWN.iter().find(|(file, function, _)| *file == at && *function == name);
            let Some((_, _, why)) = known else {
                panic!("{at}: `{name}` sums up numbers; what does it make of none, and which test says so?")
            };
            seen.push((at.clone(), name.to_owned()));
            if let Some((file, test)) = why.split_once(".rs: ") {
                let text = std::fs::read_to_string(root.join(format!("{file}.rs"))).unwrap();
                assert!(text.contains(&format!("    fn {test}()")), "{at}: no test `{test}` in {file}.rs");
            }
        }
    }
    for (file, function, _) in KNOWN {
        assert!(seen.iter().any(|(f, n)| f == file && n == function), "{file}: no `{function}` any more");
    }
}

/// What is to be found is found, and tests are not.
#[test]
fn functions_that_sum_up_are_found() {
    let source = "pub fn rms_error<T>(x: T) {}\n    fn worst(a: u8) {}\nfn firms() {}\n#[cfg(test)]\nmod tests {\n    fn a_ratio() {}\n}\n";
    assert_eq!(summing(source), ["rms_error", "worst"]);
}
