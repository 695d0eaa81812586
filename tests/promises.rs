//! Every test that `docs/PROMISES.md` names exists and is run.

use std::collections::BTreeMap;

/// Files and tests named under each heading: lines such as ``- `cli/tests/cli/output.rs`: `one_test`, `another` ``.
fn named(text: &str) -> BTreeMap<String, Vec<(String, String)>> {
    let mut all: BTreeMap<String, Vec<(String, String)>> = BTreeMap::new();
    let mut promise = String::new();
    for line in text.lines() {
        if let Some(heading) = line.strip_prefix("## ") {
            promise = heading.to_owned();
            all.entry(promise.clone()).or_default();
        }
        let quoted: Vec<&str> = line.split('`').skip(1).step_by(2).collect();
        if let (true, [file, tests @ ..]) = (line.starts_with("- `"), quoted.as_slice())
            && file.ends_with(".rs")
        {
            let of_promise = all.entry(promise.clone()).or_default();
            of_promise.extend(tests.iter().map(|test| ((*file).to_owned(), (*test).to_owned())));
        }
    }
    all
}

/// Whether a source has a test of this name that is not ignored.
fn has_test(source: &str, test: &str) -> bool {
    let Some(at) = source.find(&format!("fn {test}(")) else { return false };
    let above = source[..at].trim_end().rsplit("\n\n").next().unwrap_or_default();
    above.contains("#[test]") && !above.contains("#[ignore")
}

#[test]
fn every_promise_is_held_by_tests_that_exist() {
    let text = std::fs::read_to_string(support::root().join("docs/PROMISES.md")).unwrap();
    let promises = named(&text);
    let numbers: Vec<String> =
        promises.keys().filter_map(|p| Some(p.split_once('.')?.0.to_owned())).collect();
    assert_eq!(numbers.len(), 10, "{:?}", promises.keys());
    for (promise, tests) in &promises {
        assert!(!tests.is_empty(), "no test holds `{promise}`");
        for (file, test) in tests {
            let path = support::root().join(file);
            let source = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{promise}: {file}: {e}"));
            assert!(has_test(&source, test), "{promise}: no test `{test}` in {file}");
        }
    }
}

/// A test that was renamed, ignored or never written is found.
#[test]
fn a_test_that_is_missing_is_found() {
    let source = "/// A law.\n#[test]\nfn holds() {}\n\n#[test]\n#[ignore = \"slow\"]\nfn sleeps() {}\n\nfn helper() {}\n";
    assert!(has_test(source, "holds"));
    assert!(!has_test(source, "sleeps") && !has_test(source, "helper") && !has_test(source, "hold"));
    let text = "## 1. It lasts\n\nWords with `code`.\n\n- `a/b.rs`: `one`, `two`\n\n## 2. Other\n";
    let found = named(text);
    assert_eq!(found["1. It lasts"], [("a/b.rs".into(), "one".into()), ("a/b.rs".into(), "two".into())]);
    assert!(found["2. Other"].is_empty());
}
