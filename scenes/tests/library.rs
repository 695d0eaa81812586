//! The library inside the program: all of what lies in the folder, opened as from the folder.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use scenes::library::{self, Kind};
use scenes::{Source, character_file, scene};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

/// Every `*.ron` and `*.rhai` below a folder, with its text.
fn on_disk(dir: &Path, found: &mut BTreeMap<PathBuf, String>) {
    for entry in std::fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            on_disk(&path, found);
        } else if path.extension().is_some_and(|e| e == "ron" || e == "rhai") {
            let text = std::fs::read_to_string(&path).unwrap();
            found.insert(path.strip_prefix(folder()).unwrap().into(), text);
        }
    }
}

/// Where an entry lies, relative to the folder.
fn file_of(entry: &library::Entry) -> PathBuf {
    let location = entry.location().display().to_string();
    let path = location.strip_prefix("library:").unwrap();
    path.strip_prefix("scenes/").unwrap_or(path).into()
}

#[test]
fn every_file_that_ships_is_inside_as_it_is_on_disk() {
    let mut files = BTreeMap::new();
    on_disk(&folder(), &mut files);
    let inside: BTreeMap<PathBuf, String> =
        library::entries().map(|e| (file_of(e), e.text().to_owned())).collect();
    assert_eq!(inside.keys().collect::<Vec<_>>(), files.keys().collect::<Vec<_>>());
    assert!(inside == files, "a text differs");
    assert!(files.len() >= 28, "{}", files.len());
}

/// Learned edits that scenes name are inside too, byte for byte, and are named as texts are.
#[test]
fn learned_edits_are_inside_as_they_are_on_disk() {
    for name in ["lean-back", "arms-out"] {
        let location = PathBuf::from(format!("library:propagate/{name}.edit"));
        let disk = std::fs::read(folder().join(format!("propagate/{name}.edit"))).unwrap();
        assert!(library::bytes(&location).is_some_and(|inside| inside == disk), "{name}");
        assert!(library::is_file(&location));
        let beside = library::beside(Path::new("library:scenes/bow.ron"), format!("propagate/{name}.edit"));
        assert_eq!(beside, location);
    }
    assert_eq!(library::bytes(Path::new("library:propagate/none.edit")), None);
    assert_eq!(library::bytes(Path::new("scenes/propagate/lean-back.edit")), None);
}

/// A name means one file where a kind is expected, and the list says something about it.
#[test]
fn names_are_unambiguous_and_described() {
    for kind in Kind::ALL {
        let mut names: Vec<&str> =
            library::entries().filter(|e| e.kind() == kind).map(library::Entry::name).collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count, "{kind:?}: {names:?}");
    }
    for entry in library::entries() {
        let about = entry.about();
        assert!(about.len() > 10 && about.ends_with('.'), "{}: `{about}`", entry.location().display());
        assert!(!entry.name().contains(['.', '/', ':']), "{} could not be given as a name", entry.name());
    }
}

/// Each file opens inside the library as it does on disk, with all that it names; none of it is a file on disk.
#[test]
fn files_open_inside_the_library() {
    for entry in library::entries() {
        let (inside, outside) = (entry.location(), folder().join(file_of(entry)));
        match entry.kind() {
            Kind::Character => {
                let read = |path: &Path| character_file::read(path).unwrap();
                assert_eq!(read(&inside), read(&outside));
            }
            Kind::Scene => {
                let a = scene::read(&inside).unwrap_or_else(|e| panic!("{e}"));
                let b = scene::read(&outside).unwrap();
                assert_eq!((&a.name, &a.character), (&b.name, &b.character));
                assert_eq!(a.files, Vec::<PathBuf>::new());
                assert_eq!(b.files[0], outside);
            }
            // `programs` reads it; its text is compared above
            Kind::Program => assert!(entry.text().contains("fn params()")),
            // takes opens them; its text is compared above
            Kind::KeyPoses => assert_eq!(Source::read(&inside).unwrap().first_word(), Some("KeyPoses")),
        }
    }
}

#[test]
fn errors_in_the_library_name_their_place() {
    let source = Source::read(Path::new("library:scenes/bow.ron")).unwrap();
    let line = source_line("edits: [");
    assert_eq!(
        source.error("edits", "wrong").to_string(),
        format!("wrong\n  --> library:scenes/bow.ron:{line}:12")
    );
    let e = Source::read(Path::new("library:scenes/bwo.ron")).unwrap_err().to_string();
    assert!(e.contains("no such file of the library") && e.contains("library:scenes/bwo.ron"), "{e}");
}

fn source_line(what: &str) -> usize {
    let text = std::fs::read_to_string(folder().join("bow.ron")).unwrap();
    1 + text.lines().position(|line| line.contains(what)).unwrap()
}

/// A scene on disk names a file of the library by its location, and nothing is looked for there otherwise.
#[test]
fn a_scene_on_disk_may_name_the_library() {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("mine.ron");
    let write = |text: &str| std::fs::write(&path, text).unwrap();
    write("Scene(character: \"library:characters/human.ron\")");
    let mine = scene::read(&path).unwrap();
    assert_eq!((mine.character.name.as_str(), &mine.files), ("human", &vec![path.clone()]));
    for (text, words) in [
        (
            "Scene(character: \"characters/human.ron\")",
            "the one of the library is `library:characters/human.ron`",
        ),
        ("Scene(character: \"human\")", "does not exist"),
        ("Scene(character: \"library:human\")", "`library:human` does not exist"),
        (
            "Scene(character: \"library:characters/human.ron\", motion: Clip(\"library:scenes/bow.ron\"))",
            "`library:scenes/bow.ron` is no clip",
        ),
    ] {
        write(text);
        let e = scene::read(&path).err().unwrap().to_string();
        assert!(e.contains(words) && e.contains("mine.ron:1:"), "{e}");
    }
}
