//! The library: scenes, performances, characters, key poses and programs that are inside the program.
//!
//! In: a name or a path as a person gives it, and what kind of file is expected. Out: a path that [`crate::Source`] reads.
//! `build.rs` embeds every `*.ron` and `*.rhai` of this crate's folder, and the learned edits (`*.edit`) that scenes name; a new scene is one new file.
//!
//! A file of the library has a *location*: a path that begins with `library:`, such as `library:scenes/bow.ron` or
//! `library:characters/human.ron`. A location stands wherever a path may: on the command line, in a scene file, in an
//! error. Files of the library name each other by relative paths, as they do on disk: [`beside`] keeps them inside.
//! A bare *name* (`bow`) stands for a location where a person says which file to open: [`resolve`] is the one place that
//! knows names. In files names are always paths, so that what a file means does not depend on what lies beside it.

use std::path::{Path, PathBuf};

use motion::names::distance;

// the tables `ENTRIES` and `DATA`, see build.rs
include!(concat!(env!("OUT_DIR"), "/library.rs"));

/// How a location in the library begins.
pub const PREFIX: &str = "library:";

/// What a file of the library holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A scene, also a performance.
    Scene,
    /// A character.
    Character,
    /// Key poses of a character.
    KeyPoses,
    /// A program of an edit or a reactive property.
    Program,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Scene, Self::Character, Self::KeyPoses, Self::Program];

    /// What a file of this kind is called.
    pub fn word(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Character => "character",
            Self::KeyPoses => "file of key poses",
            Self::Program => "program",
        }
    }
}

/// A file of the library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    path: &'static str,
    text: &'static str,
}

impl Entry {
    /// Its name, as a person gives it: `bow`.
    pub fn name(&self) -> &'static str {
        let file = self.path.rsplit('/').next().unwrap_or(self.path);
        file.rsplit_once('.').map_or(file, |(name, _)| name)
    }

    /// The folder it is in: `scenes`, `performances`, `characters`, …
    pub fn folder(&self) -> &'static str {
        self.path.split('/').next().unwrap_or_default()
    }

    /// What it holds, which its folder says.
    pub fn kind(&self) -> Kind {
        match self.folder() {
            "characters" => Kind::Character,
            "keyposes" => Kind::KeyPoses,
            "programs" => Kind::Program,
            _ => Kind::Scene,
        }
    }

    /// Its location: `library:scenes/bow.ron`.
    pub fn location(&self) -> PathBuf {
        PathBuf::from(format!("{PREFIX}{}", self.path))
    }

    /// Its text.
    pub fn text(&self) -> &'static str {
        self.text
    }

    /// One line about it: the first sentence of the comment that it begins with.
    pub fn about(&self) -> String {
        let comment = self.text.lines().map_while(|line| line.strip_prefix("//"));
        let words: Vec<&str> = comment.flat_map(str::split_whitespace).collect();
        let end = words.iter().position(|w| w.ends_with('.')).map_or(words.len(), |i| i + 1);
        words[..end].join(" ")
    }
}

/// A file of the library that is no text, and that texts name: a learned edit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Data {
    path: &'static str,
    bytes: &'static [u8],
}

/// The bytes of a learned edit at a location, such as `library:propagate/lean-back.edit`; `None` where there is none.
pub fn bytes(location: &Path) -> Option<&'static [u8]> {
    let path = path_of(location)?;
    DATA.iter().find(|d| d.path == path).map(|d| d.bytes)
}

/// All files: scenes, performances and what else holds scenes, then characters, then key poses; sorted within a folder.
pub fn entries() -> impl Iterator<Item = &'static Entry> {
    Kind::ALL.into_iter().flat_map(of_kind)
}

fn of_kind(kind: Kind) -> impl Iterator<Item = &'static Entry> {
    ENTRIES.iter().filter(move |e| e.kind() == kind)
}

/// Whether a path is a location in the library, of a file that is there or not.
pub fn is_location(path: &Path) -> bool {
    path.to_str().is_some_and(|text| text.starts_with(PREFIX))
}

/// The file at a location. Folders are those below `scenes/` of the repository, whose name may stand in front:
/// `library:scenes/characters/human.ron` is `library:characters/human.ron`.
pub fn find(location: &Path) -> Option<&'static Entry> {
    let path = path_of(location)?;
    ENTRIES.iter().find(|e| e.path == path)
}

/// What a location says, from the folder on.
fn path_of(location: &Path) -> Option<String> {
    let mut parts: Vec<&str> = Vec::new();
    for part in location.to_str()?.strip_prefix(PREFIX)?.split(['/', '\\']) {
        match part {
            "" | "." => {}
            ".." => drop(parts.pop()?),
            name => parts.push(name),
        }
    }
    if parts.len() > 2 && parts[0] == "scenes" {
        parts.remove(0);
    }
    Some(parts.join("/"))
}

/// Whether a path leads to a file, on disk or in the library.
pub fn is_file(path: &Path) -> bool {
    if is_location(path) { find(path).is_some() || bytes(path).is_some() } else { path.is_file() }
}

/// The path of a file that the file `of` names: relative to it, or a location.
pub fn beside(of: &Path, name: impl AsRef<Path>) -> PathBuf {
    let name = name.as_ref();
    let path = if is_location(name) { name.into() } else { of.parent().unwrap_or(Path::new("")).join(name) };
    if bytes(&path).is_some() {
        return PathBuf::from(format!("{PREFIX}{}", path_of(&path).unwrap_or_default()));
    }
    find(&path).map_or(path, Entry::location)
}

/// The file of the library that has the same name as a file on disk that does not exist.
pub fn namesake(path: &Path) -> Option<&'static Entry> {
    let name = path.file_name()?.to_str()?;
    // of several, the one whose folder has the same name too
    let folder = path.parent().and_then(Path::file_name);
    let same = || entries().filter(|e| e.path.rsplit('/').next() == Some(name));
    same().find(|e| folder.is_some_and(|f| f == e.folder())).or_else(|| same().next())
}

/// A name that is neither a file nor in the library.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{name}`: no such file, and no {expected} of the library{hint}")]
pub struct UnknownName {
    /// What was given.
    pub name: String,
    /// What should be there.
    pub expected: String,
    /// The nearest names, and where all of them are listed.
    pub hint: String,
}

/// The path of a file that a person names where a file of one of these kinds is expected.
///
/// A file that exists is always meant itself, whatever its name. Else a bare name (no folder, no dot) is that of a file
/// of the library. Everything else is left as it is, for whoever opens it to say what is wrong.
///
/// # Errors
/// [`UnknownName`]: a bare name or a location that is not there.
///
/// # Examples
/// ```
/// use std::path::Path;
/// use scenes::library::{Kind, resolve};
/// let bow = resolve(Path::new("bow"), &[Kind::Scene]).unwrap();
/// assert_eq!(bow, Path::new("library:scenes/bow.ron"));
/// let e = resolve(Path::new("bwo"), &[Kind::Scene]).unwrap_err();
/// assert_eq!(
///     e.to_string(),
///     "`bwo`: no such file, and no scene of the library; did you mean `bow`? `contrapposto library` lists them"
/// );
/// ```
pub fn resolve(path: &Path, kinds: &[Kind]) -> Result<PathBuf, UnknownName> {
    if is_location(path) {
        return match find(path) {
            Some(entry) => Ok(entry.location()),
            None => Err(unknown(&path.to_string_lossy(), kinds)),
        };
    }
    match bare(path).filter(|_| path.is_dir() || !path.exists()) {
        None => Ok(path.into()),
        Some(name) => {
            let found = kinds.iter().flat_map(|&k| of_kind(k)).find(|e| e.name() == name);
            found.map(Entry::location).ok_or_else(|| unknown(name, kinds))
        }
    }
}

/// The text of a path that may be a name.
fn bare(path: &Path) -> Option<&str> {
    let name = path.to_str()?;
    let is_name = !name.is_empty() && !name.contains(['/', '\\', '.', ':']);
    is_name.then_some(name)
}

/// At most this many names are offered for one that is unknown.
const OFFERED: usize = 3;

fn unknown(given: &str, kinds: &[Kind]) -> UnknownName {
    let words: Vec<&str> = kinds.iter().map(|k| k.word()).collect();
    let location = given.starts_with(PREFIX);
    let candidates = kinds.iter().flat_map(|&k| of_kind(k));
    let shown = |e: &Entry| if location { e.location().display().to_string() } else { e.name().to_owned() };
    let other = entries().find(|e| e.name() == given);
    let hint = match (near(given, candidates.map(shown)), other) {
        (_, Some(entry)) => format!("; `{given}` is a {} there", entry.kind().word()),
        (near, None) if near.is_empty() => String::new(),
        (near, None) => format!("; did you mean {}?", near.join(" or ")),
    };
    let them = if hint.ends_with('?') {
        " `contrapposto library` lists them"
    } else {
        "; `contrapposto library` lists them"
    };
    UnknownName { name: given.into(), expected: words.join(" or "), hint: hint + them }
}

/// Names within half the length of the longer one and one step of the nearest, the nearest first.
fn near(given: &str, candidates: impl Iterator<Item = String>) -> Vec<String> {
    let mut near: Vec<(usize, String)> = candidates
        .map(|name| (distance(given, &name), name))
        .filter(|(d, name)| 2 * d <= name.chars().count().max(given.chars().count()))
        .collect();
    near.sort();
    near.dedup();
    let most = near.first().map_or(0, |(d, _)| d + 1);
    let names = near.into_iter().filter(|(d, _)| *d <= most).map(|(_, name)| format!("`{name}`"));
    names.take(OFFERED).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn locations_are_found_however_they_are_written() {
        for (given, path) in [
            ("library:scenes/bow.ron", "scenes/bow.ron"),
            ("library:characters/human.ron", "characters/human.ron"),
            ("library:scenes/characters/human.ron", "characters/human.ron"),
            ("library:performances/../characters/./human.ron", "characters/human.ron"),
        ] {
            assert_eq!(find(Path::new(given)).map(|e| e.path), Some(path), "{given}");
        }
        for given in ["scenes/bow.ron", "library:bow", "library:../scenes/bow.ron", "library:", "library:/"] {
            assert_eq!(find(Path::new(given)), None, "{given}");
        }
    }

    #[test]
    fn files_of_the_library_name_each_other() {
        let beside = |of: &str, name: &str| beside(Path::new(of), name).display().to_string();
        let human = "library:characters/human.ron";
        assert_eq!(beside("library:scenes/bow.ron", "characters/human.ron"), human);
        assert_eq!(beside("library:performances/fear.ron", "../characters/human.ron"), human);
        assert_eq!(beside("mine/scene.ron", human), human);
        assert_eq!(beside("mine/scene.ron", "characters/human.ron"), "mine/characters/human.ron");
        assert_eq!(beside("library:scenes/bow.ron", "/tmp/human.ron"), "/tmp/human.ron");
    }

    #[test]
    fn unknown_names_are_met_with_the_nearest() {
        let said = |given: &str, kinds: &[Kind]| resolve(Path::new(given), kinds).unwrap_err().to_string();
        assert_eq!(
            said("penguin", &[Kind::Scene]),
            "`penguin`: no such file, and no scene of the library; `penguin` is a character there; \
             `contrapposto library` lists them"
        );
        assert_eq!(
            said("zzzzzz", &[Kind::Scene, Kind::Character]),
            "`zzzzzz`: no such file, and no scene or character of the library; `contrapposto library` lists them"
        );
        assert!(said("twis", &[Kind::Scene]).contains("did you mean `twist`?"));
        assert!(
            said("library:characters/humn.ron", &[Kind::Character])
                .contains("`library:characters/human.ron`")
        );
    }

    /// Paths that are no bare names are left to whoever opens them.
    #[test]
    fn paths_stay_what_they_are() {
        for path in ["missing.ron", "missing.bvh", "out/bow", "./bow", ".", "..", ""] {
            assert_eq!(resolve(Path::new(path), &[Kind::Scene]), Ok(path.into()), "{path}");
        }
    }
}
