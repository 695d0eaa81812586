//! The library for programs: names where files are opened; only files on disk are inputs that results must not replace.

use std::path::{Path, PathBuf};

use takes::{Ask, Input, TakeError, open, retargeting::Session};

#[test]
fn a_name_opens_a_scene_of_the_library() {
    let take = open(Path::new("bow"), &Ask::default()).unwrap();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/bow.ron");
    let other = open(&file, &Ask::default()).unwrap();
    assert_eq!(take.name, "bow");
    assert!(take.asked.clip == other.asked.clip && take.body.character == other.body.character);
    assert_eq!(take.files, Vec::<PathBuf>::new());
    assert_eq!(other.files.len(), 2);
    assert!(matches!(open(Path::new("bwo"), &Ask::default()), Err(TakeError::Name(e)) if e.name == "bwo"));
}

/// A text has no file beside it, but it may name those of the library.
#[test]
fn a_text_names_the_library() {
    let home = tempfile::tempdir().unwrap();
    let ron = "Scene(character: \"library:characters/penguin.ron\")".to_owned();
    let take = open(Input::Text { ron, base: home.path().into() }, &Ask::default()).unwrap();
    assert_eq!(take.body.character.name, "penguin");
}

/// A character of the library brings its key poses, and they their performances.
#[test]
fn a_character_of_the_library_brings_its_key_poses() {
    let import = Ask::default().import;
    let session = Session::open(Path::new("fear"), Path::new("lamp"), None, &import).unwrap();
    assert_eq!(session.name(), "fear-lamp");
    assert_eq!(session.key_poses.path, Path::new("library:keyposes/lamp.ron"));
    assert!(session.key_poses.performances.len() > 3);
}
