//! `THIRD-PARTY.md` names every package that the program is built from, and none that it is not, in the versions of `Cargo.lock`.
//!
//! cargo-about made the file from the resolved graph; cargo itself (`cargo tree`) says here what is built, fetching packages of other systems where they are not there yet.

use std::collections::BTreeSet;
use std::process::Command;

/// Where the program is built: the targets of `about.toml` and `deny.toml`.
const TARGETS: [&str; 3] = ["x86_64-unknown-linux-gnu", "aarch64-apple-darwin", "x86_64-pc-windows-msvc"];

/// `name version` of every line `- name version…`.
fn listed(page: &str) -> BTreeSet<String> {
    let pair = |line: &str| {
        let mut words = line.strip_prefix("- ")?.split([' ', ',']);
        let (name, version) = (words.next()?, words.next()?);
        version.starts_with(|c: char| c.is_ascii_digit()).then(|| format!("{name} {version}"))
    };
    page.lines().filter_map(pair).collect()
}

/// `name version` of every package in the program on one of the targets; procedural macros run while it is compiled, and so do theirs.
fn built() -> BTreeSet<String> {
    let mut all = BTreeSet::new();
    for target in TARGETS {
        let out = Command::new(env!("CARGO"))
            .args(["tree", "--locked", "-p", "cli", "-e", "normal,no-proc-macro", "--prefix", "none"])
            .args(["--target", target])
            .current_dir(support::root())
            .output()
            .expect("cargo");
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        for line in String::from_utf8(out.stdout).expect("text").lines() {
            let mut words = line.split(' ');
            if let (Some(name), Some(version)) = (words.next(), words.next()) {
                all.insert(format!("{name} {}", version.trim_start_matches('v')));
            }
        }
    }
    all
}

/// `name version` of every package of the lock file.
fn locked() -> BTreeSet<String> {
    let text = std::fs::read_to_string(support::root().join("Cargo.lock")).expect("Cargo.lock");
    let value = |line: &str, key: &str| Some(line.strip_prefix(key)?.trim_matches('"').to_owned());
    let lines: Vec<&str> = text.lines().collect();
    let package = |w: &[&str]| Some(format!("{} {}", value(w[0], "name = ")?, value(w[1], "version = ")?));
    lines.windows(2).filter_map(package).collect()
}

/// What a page lacks of what is built, and what it has that is not in the lock file.
fn wrong(page: &str) -> (Vec<String>, Vec<String>) {
    let (listed, built) = (listed(page), built());
    assert!(built.len() > 100, "{} packages: the tree is not read", built.len());
    (built.difference(&listed).cloned().collect(), listed.difference(&locked()).cloned().collect())
}

#[test]
fn third_party_names_what_is_built() {
    let page = std::fs::read_to_string(support::root().join("THIRD-PARTY.md")).expect("THIRD-PARTY.md");
    let (missing, stale) = wrong(&page);
    assert!(missing.is_empty(), "not in THIRD-PARTY.md: {missing:?}; CONTRIBUTING.md says how it is made");
    assert!(
        stale.is_empty(),
        "not in Cargo.lock: {stale:?}; CONTRIBUTING.md says how THIRD-PARTY.md is made"
    );

    // the controls: a package taken out, and one of another version
    let line = page.lines().find(|l| l.starts_with("- rapier3d-f64 ")).expect("the engine");
    let (missing, stale) = wrong(&page.replace(line, "- rapier3d-f64 0.0.1"));
    assert_eq!((missing.len(), stale), (1, vec!["rapier3d-f64 0.0.1".to_owned()]), "{missing:?}");
}

/// Every text of a licence is there: a section without one would keep none.
#[test]
fn third_party_has_the_texts() {
    let page = std::fs::read_to_string(support::root().join("THIRD-PARTY.md")).expect("THIRD-PARTY.md");
    let sections: Vec<&str> = page.split("\n## ").skip(1).collect();
    assert!(sections.len() > 10, "{} licences", sections.len());
    for section in sections {
        let text = section.split("```").nth(1).unwrap_or_default();
        assert!(text.len() > 400 && section.contains("\n- "), "{}", &section[..section.len().min(200)]);
    }
}

/// Archives and pictures are those of today: one `zip` of the ninth release or later, pictures written with `png` itself and not with
/// the `image` that plotters would bring; one linear algebra.
#[test]
fn archives_and_pictures_are_of_today() {
    let locked = locked();
    let of = |name: &str| -> Vec<u32> {
        let versions =
            locked.iter().filter_map(|p| p.strip_prefix(name)?.strip_prefix(' ').map(str::to_owned));
        versions.map(|v| v.split('.').next().unwrap().parse().expect("a version")).collect()
    };
    assert!(matches!(of("zip")[..], [major] if major >= 9), "zip {:?}", of("zip"));
    assert!(of("image").is_empty(), "image {:?}", of("image"));
    assert_eq!((of("nalgebra").len(), of("png").len()), (1, 1));
}
