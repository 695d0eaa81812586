//! No circle of files: what a file imports does not import it back, but for a module and its own child modules.
//!
//! `cargo test --release -p promises circles -- --nocapture` prints the circles of every crate; with `CIRCLES_OF=FOLDER` those
//! of another checkout.

mod graph;
mod source;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use source::ModulePath;

/// Crates in which there are some.
const KNOTTED: [&str; 1] = ["learn"];

/// Folders of the crates of a checkout, by name.
fn crates(root: &Path) -> Vec<(String, PathBuf)> {
    let folders = std::fs::read_dir(root).unwrap().map(|e| e.unwrap().path());
    let sources = folders.map(|f| (f.file_name().unwrap().to_string_lossy().into_owned(), f.join("src")));
    let mut all: Vec<_> = sources.filter(|(_, src)| src.is_dir()).collect();
    all.sort();
    all
}

fn shown(module: &ModulePath) -> String {
    if module.is_empty() { "crate".into() } else { module.join("::") }
}

#[test]
fn files_do_not_import_one_another_in_circles() {
    let other = std::env::var_os("CIRCLES_OF").map(PathBuf::from);
    let crates = crates(&other.clone().unwrap_or_else(support::root));
    assert!(other.is_some() || crates.len() > 10, "crates are not found: {crates:?}");
    let mut wrong = Vec::new();
    for (name, src) in &crates {
        let imports = source::imports(src);
        let circles = graph::circles(&imports);
        let arrows: usize = imports.values().map(BTreeSet::len).sum();
        let within: usize = circles.iter().map(Vec::len).sum();
        println!(
            "{name}: {} files, {arrows} arrows; {} circles with {within} files",
            imports.len(),
            circles.len()
        );
        for circle in &circles {
            let files: Vec<String> = circle.iter().map(shown).collect();
            println!("    {}", files.join(", "));
            for (from, to) in circle.iter().flat_map(|f| imports[f].iter().map(move |t| (f, t))) {
                if circle.contains(to) {
                    println!("        {} → {}", shown(from), shown(to));
                }
            }
            if other.is_none() && !KNOTTED.contains(&name.as_str()) {
                wrong.push(format!("{name}: {}", files.join(", ")));
            }
        }
        assert!(imports.len() < 5 || arrows >= imports.len() / 2, "{name}: imports are not read");
    }
    assert!(wrong.is_empty(), "circles of files:\n{}", wrong.join("\n"));
}

/// A crate of these files.
fn circles_of(files: &[(&str, &str)]) -> Vec<Vec<String>> {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    let imports: BTreeMap<_, _> = source::imports(folder.path());
    graph::circles(&imports).iter().map(|c| c.iter().map(shown).collect()).collect()
}

/// The check finds circles: of two, through a name handed on, through a path in code, through a child and its parent's other user.
#[test]
fn circles_are_found() {
    let two =
        [("lib.rs", "mod a; mod b;"), ("a.rs", "use crate::b::B;"), ("b.rs", "use super::a::{self, A};")];
    assert_eq!(circles_of(&two), [["a", "b"]]);
    let handed_on = [
        ("lib.rs", "mod a; mod b; pub use a::A; pub use b::*;"),
        ("a.rs", "use crate::{X, B};"),
        ("b.rs", "pub struct B; fn f() { let _ = crate::A; }"),
    ];
    assert_eq!(circles_of(&handed_on), [["a", "b"]]);
    let through_a_child = [
        ("lib.rs", "mod a; mod b;"),
        ("a/mod.rs", "mod c; pub struct A; use c::C;"),
        ("a/c.rs", "use crate::b::B; pub struct C;"),
        ("b.rs", "use crate::a::A; pub struct B;"),
    ];
    assert_eq!(circles_of(&through_a_child), [["a", "a::c", "b"]]);
}

/// And nothing else: a parent and its children, tests, comments, texts, other crates.
#[test]
fn what_is_no_circle_is_not_found() {
    let fine = [
        (
            "lib.rs",
            "//! use of `crate::b`\nmod a; mod b; #[cfg(test)] mod tests; pub use a::A; pub struct Root;",
        ),
        ("a/mod.rs", "mod c; use c::C; pub struct A; mod inner { use super::A; }"),
        ("a/c.rs", "use super::A; pub struct C; use crate::Root; use other::b::B;"),
        ("b.rs", "use crate::a::A; const T: &str = \"crate::b\"; /* crate::b::B */ pub struct B;"),
        ("tests.rs", "use crate::a::A;"),
        ("a/d.rs", "#[cfg(test)] mod tests { use crate::e::E; } pub struct D;"),
        ("e.rs", "use crate::a::d::D;"),
    ];
    assert_eq!(circles_of(&fine), [[""; 0]; 0]);
}
