//! Lists the files of the library, so that a new scene is one new file and nothing else.
//!
//! In: every `*.ron`, program (`*.rhai`) and learned edit (`*.edit`) in this folder and in the folders directly below it. Out: `library.rs`
//! in `OUT_DIR`, the tables `ENTRIES` and `DATA` of `src/library.rs`: files of this folder first (as `scenes/NAME.ron`), then folder by folder, sorted.
//!
//! Cargo runs it again when anything in the folder changes, a file added or removed included.

use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// Folders of the crate that are none of the library.
const CODE: [&str; 4] = ["src", "tests", "examples", "target"];

fn main() -> io::Result<()> {
    let variable = |name| env::var_os(name).map(PathBuf::from).ok_or_else(|| io::Error::other(name));
    let (home, out) = (variable("CARGO_MANIFEST_DIR")?, variable("OUT_DIR")?);
    let mut folders = vec![("scenes".to_owned(), home.clone())];
    for path in children(&home)? {
        let name = name_of(&path);
        if path.is_dir() && !CODE.contains(&name.as_str()) {
            folders.push((name, path));
        }
    }
    let mut table = String::from("static ENTRIES: &[Entry] = &[\n");
    let mut data = String::from("static DATA: &[Data] = &[\n");
    for (folder, path) in folders {
        for file in children(&path)? {
            let name = format!("{folder}/{}", name_of(&file));
            let is = |ending: &str| file.is_file() && file.extension().is_some_and(|e| e == ending);
            if is("ron") || is("rhai") {
                table += &format!("    Entry {{ path: {name:?}, text: include_str!({file:?}) }},\n");
            }
            if is("edit") {
                data += &format!("    Data {{ path: {name:?}, bytes: include_bytes!({file:?}) }},\n");
            }
        }
    }
    fs::write(out.join("library.rs"), format!("{table}];\n{data}];\n"))?;
    println!("cargo::rerun-if-changed={}", home.display());
    Ok(())
}

/// What a folder holds, sorted.
fn children(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut all = fs::read_dir(folder)?.map(|e| Ok(e?.path())).collect::<io::Result<Vec<_>>>()?;
    // `reach` before `reach-slack`
    all.sort_by_key(|path| path.with_extension(""));
    Ok(all)
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
