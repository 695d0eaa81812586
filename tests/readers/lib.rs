//! Every reader of files behind one function, so that each can be given anything.
//!
//! In: bytes, whole or broken. Out: `true` if they were taken for a file, `false` if they were refused; a reader that panics, or takes
//! what is not finite, has a fault, and the panic is let through. [`READERS`] is the table: a reader that is added to the
//! project is a row here, a target in `tests/fuzz`, and then both the mutations of this crate's test and the fuzzer find it.
//!
//! Readers that open what a file names look for it where the file lies: texts of scenes are read as if they lay in the
//! repository's `scenes` folder.

mod mutate;

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use formats::bvh::ImportOptions;
use motion::Clip;
use scenes::character_file::parse_file;
use scenes::{Patch, Source, contact_file};
use studies::tune::journal;
use takes::retargeting::{Actor, KeyPoseFile};

pub use mutate::Mutator;

/// A reader.
pub struct Reader {
    /// What it is called here and in `tests/fuzz`.
    pub name: &'static str,
    /// Reads; whether it took the bytes for a file.
    pub read: fn(&[u8]) -> bool,
    /// Whole files for it.
    pub seeds: fn() -> Vec<Vec<u8>>,
}

/// All readers.
pub const READERS: &[Reader] = &[
    Reader { name: "bvh", read: bvh, seeds: || bytes(&clip_files()) },
    Reader { name: "mjcf", read: |b| model(b, "xml"), seeds: || bytes(&model_files("xml")) },
    Reader { name: "urdf", read: |b| model(b, "urdf"), seeds: || bytes(&model_files("urdf")) },
    Reader { name: "npz", read: npz, seeds: || vec![trace()] },
    Reader { name: "scene", read: scene, seeds: || bytes(&scene_files()) },
    Reader { name: "character", read: character, seeds: || bytes(&library("characters")) },
    Reader { name: "key_poses", read: key_poses, seeds: || bytes(&library("keyposes")) },
    Reader { name: "contacts", read: contacts, seeds: || vec![contacts_seed()] },
    Reader { name: "patch", read: patch, seeds: || vec![patch_seed()] },
    Reader { name: "samples", read: samples, seeds: || vec![table()] },
];

/// The reader of this name.
///
/// # Panics
/// If there is none.
pub fn reader(name: &str) -> &'static Reader {
    READERS.iter().find(|r| r.name == name).unwrap_or_else(|| panic!("no reader `{name}`"))
}

/// Two contacts of one point of the lamp.
fn contacts_seed() -> Vec<u8> {
    let point = contact_file::points(&LAMP.puppet).next().expect("a contact point");
    format!("(points: {{\"{point}\": [(0.0, 1.25), (1.5, 2.0)]}})").into_bytes()
}

/// A patch of one parameter.
fn patch_seed() -> Vec<u8> {
    let p = &controllers::PARAMETERS[0];
    format!("(set: {{\"{}\": (was: {}, is: {})}})", p.name, p.lo, p.hi).into_bytes()
}

/// The lamp of the library, for what is read for a puppet.
static LAMP: LazyLock<Actor> = LazyLock::new(|| Actor::open(&support::scene("characters/lamp.ron")).unwrap());

/// A clip is finite, and what we write of it is read again, as many frames of it.
fn bvh(file: &[u8]) -> bool {
    in_file(file, "bvh", |path| {
        let Ok((clip, _)) = formats::open_clip(path, &ImportOptions::default()) else { return false };
        assert!(finite(&clip), "a clip with numbers that are not finite");
        let Ok(text) = formats::bvh::write(&clip, &formats::bvh::WriteOptions::default()) else {
            return true;
        };
        let again = formats::bvh::Bvh::parse(text.as_bytes()).expect("what we wrote");
        assert_eq!(again.frames, clip.frames(), "frames written");
        true
    })
}

/// A body has positive masses that are finite, and the file that we write of it is read again.
///
/// What the models of dm_control include is found.
fn model(file: &[u8], ending: &str) -> bool {
    with_links(&format!("fuzzed.{ending}"), file, &[support::shared("models/dm_control/common")], |path| {
        let options = formats::model::ImportOptions { dynamics_only: true };
        let strict = formats::open_model(path, &Default::default()).is_ok();
        let Ok(read) = formats::open_model(path, &options) else {
            assert!(!strict, "read strictly, but not with parts left out");
            return false;
        };
        let c = &read.character;
        assert!(c.bodies.iter().all(|b| b.mass.is_finite() && b.mass >= 0.0), "masses");
        assert!(c.rest.iter().all(|x| x.is_finite()), "a rest pose that is not finite");
        let Ok(written) = formats::mjcf::write(c, &Default::default()) else { return true };
        in_file(written.text.as_bytes(), "xml", |path| {
            formats::open_model(path, &options).expect("what we wrote");
            true
        })
    })
}

fn npz(file: &[u8]) -> bool {
    formats::trace_npz::read(std::io::Cursor::new(file)).is_ok()
}

/// A text as if it lay in the library's folder; `None` if it is none, which reading from disk must refuse.
fn source(file: &[u8], beside: &str) -> Option<Source> {
    let Ok(text) = std::str::from_utf8(file) else {
        let read = in_file(file, "ron", |path| Source::read(path).is_ok());
        assert!(!read, "bytes that are no text were read");
        return None;
    };
    Some(Source::new(support::scene(beside), text))
}

fn scene(file: &[u8]) -> bool {
    source(file, "bow.ron").is_some_and(|s| scenes::scene::parse(s, "fuzzed".into()).is_ok())
}

fn character(file: &[u8]) -> bool {
    source(file, "characters/human.ron").is_some_and(|s| match parse_file(&s) {
        Ok(read) => {
            let c = &read.character;
            assert!(c.bodies.iter().all(|b| b.mass.is_finite() && b.mass >= 0.0), "masses");
            true
        }
        Err(_) => false,
    })
}

/// Performances are found where the library has them: beside the folder of the file.
fn key_poses(file: &[u8]) -> bool {
    let beside = ["performances", "characters"].map(support::scene);
    with_links("keyposes/fuzzed.ron", file, &beside, |path| KeyPoseFile::open(path, &LAMP.puppet).is_ok())
}

fn contacts(file: &[u8]) -> bool {
    in_file(file, "ron", |path| contact_file::read(path, &LAMP.puppet, 2.0).is_ok())
}

fn patch(file: &[u8]) -> bool {
    source(file, "bow.ron").is_some_and(|s| Patch::parse(&s).is_ok())
}

fn samples(file: &[u8]) -> bool {
    std::str::from_utf8(file).is_ok_and(|text| journal::read(text).is_ok())
}

fn finite(clip: &Clip) -> bool {
    (0..clip.frames()).all(|k| clip.pose(k).iter().all(|x| x.is_finite())) && clip.rate_hz.is_finite()
}

/// Calls `with` with a file of these bytes, which is removed after it.
fn in_file<T>(bytes: &[u8], ending: &str, with: impl FnOnce(&Path) -> T) -> T {
    let mut file =
        tempfile::Builder::new().suffix(&format!(".{ending}")).tempfile().expect("a temporary file");
    std::io::Write::write_all(&mut file, bytes).expect("a temporary file that can be written");
    with(file.path())
}

/// Calls `with` with a file of this name and these bytes in a folder with links to `others`; all is removed after it.
fn with_links<T>(name: &str, bytes: &[u8], others: &[PathBuf], with: impl FnOnce(&Path) -> T) -> T {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    std::fs::create_dir_all(path.parent().expect("a folder")).expect("a temporary folder");
    for other in others {
        let link = folder.path().join(other.file_name().expect("a name"));
        std::os::unix::fs::symlink(other, link).expect("a link");
    }
    std::fs::write(&path, bytes).expect("a temporary file");
    with(&path)
}

fn bytes(files: &[PathBuf]) -> Vec<Vec<u8>> {
    files.iter().map(|f| std::fs::read(f).unwrap_or_else(|e| panic!("{}: {e}", f.display()))).collect()
}

/// Clips of the zoo and of the cases that are small enough to be mutated by the thousand.
fn clip_files() -> Vec<PathBuf> {
    let folders = ["bvh-zoo/synthetic", "bvh-zoo", "cases/clips"];
    small(folders.iter().flat_map(|f| support::files(&support::shared(f), "bvh")))
}

fn model_files(ending: &str) -> Vec<PathBuf> {
    let folders = match ending {
        "xml" => ["models/dm_control", "cases/models"],
        _ => ["models/pinocchio", "cases/models"],
    };
    small(folders.iter().flat_map(|f| support::files(&support::shared(f), ending)))
}

fn scene_files() -> Vec<PathBuf> {
    let mut files = support::files(&support::root().join("scenes"), "ron");
    files.extend(support::files(&support::shared("cases/scenes"), "ron"));
    small(files.into_iter())
}

fn library(folder: &str) -> Vec<PathBuf> {
    support::files(&support::scene(folder), "ron")
}

/// Files up to 64 kB: mutations of larger ones hit numbers, seldom structure.
fn small(files: impl Iterator<Item = PathBuf>) -> Vec<PathBuf> {
    files.filter(|f| std::fs::metadata(f).is_ok_and(|m| m.len() < 65_536)).collect()
}

/// The trace that an analysis makes of a quarter of a second.
fn trace() -> Vec<u8> {
    let clip = support::shared("cases/clips/still_15_frames.bvh");
    let input = takes::analysis::open(&clip, None, &ImportOptions::default()).expect("a clip");
    let analysis = input.analyze(&Default::default()).expect("an analysis");
    let mut bytes = std::io::Cursor::new(Vec::new());
    formats::trace_npz::write(&input.trace(&analysis), &mut bytes).expect("a trace in memory");
    bytes.into_inner()
}

/// A table of two samples.
fn table() -> Vec<u8> {
    use studies::tune::Sample;
    let parameters: Vec<_> = controllers::PARAMETERS.iter().take(2).collect();
    let terms = || vec![0.25; studies::tune::TERMS.len()];
    let sample = |x: f64| Sample { values: vec![x, 2.0 * x], cost: x, terms: terms(), survived: 1 };
    let samples = [sample(0.5), sample(1.5)];
    journal::Head::new("a run", &parameters).table(samples.iter().enumerate()).into_bytes()
}
