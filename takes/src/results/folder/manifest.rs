//! The manifest of an output folder: which files a run wrote, and what was in them.
//!
//! `.contrapposto.json` lists the name, length and digest of every file. A file is *ours* while it is listed and
//! unchanged; only such files are replaced or removed. The digest is FNV-1a, 64 bits, which finds changes made by
//! people and programs; it is no protection against somebody who forges a file.
//!
//! Source: Fowler, Noll, Vo, Eastlake. The FNV Non-Cryptographic Hash Algorithm, RFC 9923.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use motion::Fnv;
use serde::{Deserialize, Serialize};

use super::error::FolderError;
use super::names;

/// The file's name.
pub const MANIFEST: &str = ".contrapposto.json";
/// Version of the format.
const VERSION: u32 = 1;
/// For somebody who opens the file.
const ABOUT: &str = "files that contrapposto wrote here; it replaces and removes only these, and only while they are unchanged";

/// Length and digest of a file's content.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stamp {
    /// Length, bytes.
    pub bytes: u64,
    /// FNV-1a of all bytes, 64 bits, as 16 hexadecimal digits.
    #[serde(with = "hexadecimal")]
    pub fnv1a64: u64,
}

impl Stamp {
    /// Of bytes in memory.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Self {
        let mut hash = Fnv::default();
        hash.bytes(bytes);
        Self { bytes: bytes.len() as u64, fnv1a64: hash.value() }
    }

    /// Of an open file, from where it stands to its end.
    ///
    /// # Errors
    /// Of reading.
    pub fn of_file(file: &mut File) -> io::Result<Self> {
        let mut buffer = vec![0; 1 << 18];
        let (mut hash, mut bytes) = (Fnv::default(), 0);
        loop {
            match file.read(&mut buffer) {
                Ok(0) => return Ok(Self { bytes, fnv1a64: hash.value() }),
                Ok(n) => {
                    hash.bytes(&buffer[..n]);
                    bytes += n as u64;
                }
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(e),
            }
        }
    }

    /// Whether a file has this content; its length is looked at first.
    ///
    /// # Errors
    /// Of reading.
    pub fn is_of(&self, path: &Path) -> io::Result<bool> {
        let mut file = File::open(path)?;
        Ok(file.metadata()?.len() == self.bytes && Self::of_file(&mut file)? == *self)
    }
}

mod hexadecimal {
    use serde::{Deserialize, Deserializer, Serializer, de};

    pub fn serialize<S: Serializer>(value: &u64, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&format!("{value:016x}"))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u64, D::Error> {
        let text = String::deserialize(deserializer)?;
        u64::from_str_radix(&text, 16).map_err(de::Error::custom)
    }
}

/// Which files runs wrote into a folder. The same run writes the same bytes: it holds no time and no random number.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    about: String,
    version: u32,
    /// The command that wrote them.
    pub command: String,
    /// Names relative to the folder, with `/`, and what was written.
    pub files: BTreeMap<String, Stamp>,
    /// Folders in it that runs made; they are removed when nothing is left in them.
    pub folders: BTreeSet<String>,
}

impl Manifest {
    /// One without files.
    #[must_use]
    pub fn new(command: &str) -> Self {
        Self {
            about: ABOUT.into(),
            version: VERSION,
            command: command.into(),
            files: BTreeMap::new(),
            folders: BTreeSet::new(),
        }
    }

    /// As text.
    #[must_use]
    pub fn to_json(&self) -> String {
        // maps with text as keys and numbers: serialising cannot fail
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    /// The manifest of a folder and the stamp of its own bytes; none where there is none.
    ///
    /// # Errors
    /// One that is no manifest of this version, or that names files outside the folder.
    pub fn read(dir: &Path) -> Result<Option<(Self, Stamp)>, FolderError> {
        let path = dir.join(MANIFEST);
        let damaged = |path: &PathBuf, why: String| FolderError::Manifest { path: path.clone(), why };
        match fs::symlink_metadata(&path) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            Ok(meta) if !meta.is_file() => return Err(damaged(&path, "it is not a regular file".into())),
            _ => {}
        }
        let bytes = fs::read(&path).map_err(FolderError::io("read", &path))?;
        let manifest: Self = serde_json::from_slice(&bytes).map_err(|e| damaged(&path, e.to_string()))?;
        if manifest.version != VERSION {
            let why = format!("its version is {}, allowed: {VERSION}", manifest.version);
            return Err(damaged(&path, why));
        }
        for name in manifest.files.keys().chain(&manifest.folders) {
            names::check(name).map_err(|e| damaged(&path, e.to_string()))?;
        }
        Ok(Some((manifest, Stamp::of(&bytes))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Test vectors of RFC 9923.
    #[test]
    fn digests_are_those_of_the_standard() {
        let vectors: [(&[u8], u64); 3] =
            [(b"", 0xcbf2_9ce4_8422_2325), (b"a", 0xaf63_dc4c_8601_ec8c), (b"foobar", 0x8594_4171_f739_67e8)];
        for (bytes, digest) in vectors {
            assert_eq!(Stamp::of(bytes), Stamp { bytes: bytes.len() as u64, fnv1a64: digest });
        }
    }

    #[test]
    fn a_manifest_is_read_back_and_one_that_leaves_the_folder_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        assert!(Manifest::read(dir.path()).unwrap().is_none());
        let mut manifest = Manifest::new("render");
        manifest.files.insert("plots/a.svg".into(), Stamp::of(b"a"));
        manifest.folders.insert("plots".into());
        fs::write(dir.path().join(MANIFEST), manifest.to_json()).unwrap();
        assert_eq!(Manifest::read(dir.path()).unwrap().unwrap().0, manifest);
        manifest.files.insert("../elsewhere".into(), Stamp::of(b"a"));
        for text in [manifest.to_json(), "{}".into(), Manifest::new("x").to_json().replace(": 1,", ": 2,")] {
            fs::write(dir.path().join(MANIFEST), text).unwrap();
            let e = Manifest::read(dir.path()).unwrap_err();
            assert!(matches!(&e, FolderError::Manifest { .. }) && e.is_input(), "{e}");
        }
    }
}
