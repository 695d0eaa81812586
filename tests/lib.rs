//! Helpers shared by the promises: where things are.

use std::path::{Path, PathBuf};

/// The repository's root.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("tests lies in the repository").into()
}

/// A scene of the library.
pub fn scene(name: &str) -> PathBuf {
    root().join("scenes").join(name)
}

/// Real data beside the repository.
pub fn shared(path: &str) -> PathBuf {
    root().join("../shared").join(path)
}

/// All scenes of the library, by name.
pub fn scenes() -> Vec<PathBuf> {
    let mut all: Vec<PathBuf> = std::fs::read_dir(root().join("scenes"))
        .expect("the scenes folder")
        .map(|e| e.expect("an entry").path())
        .filter(|p| p.extension().is_some_and(|e| e == "ron"))
        .collect();
    all.sort();
    all
}
