//! Errors with a place: what was found, what is allowed, where.
//!
//! In: a RON file. Out: its value, or a [`SceneError`] with file, line and column. Faults of syntax and
//! type get their place from RON; faults found afterwards, from [`SourceMap`] by the path of the
//! value. All RON files are read through [`Source`], those of the [`library`] too.

use std::fmt;
use std::path::{Path, PathBuf};

use motion::file::read_within;
use motion::names::{brief, nearest};
use serde::de::DeserializeOwned;

use crate::library::{self, Entry};
use crate::source_map::{SourceMap, line_column};

/// Largest file that a person writes: a scene with thousands of poses has less than a megabyte.
const FILE_BYTES: u64 = 16 << 20;

/// What is wrong with a file a person wrote, and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct SceneError {
    /// The file.
    pub path: PathBuf,
    /// Line and column, 1-based, in characters; `None` if the file could not be read at all.
    pub place: Option<(usize, usize)>,
    /// What was found and what is allowed.
    pub message: String,
    /// What to do, if that is not plain.
    pub help: Option<String>,
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}\n  --> {}", self.message, self.path.display())?;
        if let Some((line, column)) = self.place {
            write!(f, ":{line}:{column}")?;
        }
        match &self.help {
            Some(help) => write!(f, "\n  help: {help}"),
            None => Ok(()),
        }
    }
}

impl SceneError {
    /// The same error with advice.
    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// A file's text with the positions of its values.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    path: PathBuf,
    text: String,
    map: SourceMap,
}

/// The text of a file, or of that at a location of the [`library`].
///
/// # Errors
/// If it cannot be read or is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, SceneError> {
    let fail = |message: String| SceneError { path: path.into(), place: None, message, help: None };
    if library::is_location(path) {
        let entry = library::find(path);
        return entry.map(|e| e.text().to_owned()).ok_or_else(|| {
            fail("no such file of the library".into()).with_help("`contrapposto library` lists them")
        });
    }
    let bytes = read_within(path, FILE_BYTES).map_err(|e| {
        let fault = fail(format!("cannot read the file: {e}"));
        match library::namesake(path).filter(|_| e.kind() == std::io::ErrorKind::NotFound) {
            Some(entry) => fault.with_help(in_library(entry)),
            None => fault,
        }
    })?;
    String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        fail(format!("the file is not UTF-8 text (byte {at})"))
    })
}

impl Source {
    /// A text as if read from `path`.
    pub fn new(path: impl Into<PathBuf>, text: impl Into<String>) -> Self {
        let (path, mut text) = (path.into(), text.into());
        // the mark that some editors put before UTF-8
        if text.starts_with('\u{feff}') {
            text.remove(0);
        }
        let map = SourceMap::new(&text);
        Self { path, text, map }
    }

    /// Reads a file, or that at a location of the [`library`].
    ///
    /// # Errors
    /// If it cannot be read or is not UTF-8.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let entry = library::find(path).filter(|_| library::is_location(path));
        let path = entry.map_or_else(|| path.to_owned(), Entry::location);
        let text = read_text(&path)?;
        Ok(Self::new(path, text))
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The first word that is no comment or attribute, such as `Scene`.
    pub fn first_word(&self) -> Option<&str> {
        let mut lines = self.text.lines().map(str::trim_start);
        let line = lines.find(|l| !l.is_empty() && !l.starts_with("//") && !l.starts_with('#'))?;
        line.split(|c: char| !c.is_alphanumeric() && c != '_').next()
    }

    /// Parses the text; `Some(…)` may be left out around optional values.
    ///
    /// # Errors
    /// Syntax, types, unknown fields and variants, with their place.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, SceneError> {
        let options =
            ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
        options.from_str(&self.text).map_err(|e| {
            let (line, column) = (e.span.start.line, e.span.start.col);
            let text = self.text.lines().nth(line.saturating_sub(1)).unwrap_or_default();
            let rest: String = text.chars().skip(column.saturating_sub(1)).collect();
            // RON points before the blanks of the value
            let blanks = rest.chars().take_while(|c| c.is_whitespace()).count();
            let found = rest.trim_start();
            let column = if found.is_empty() { column } else { column + blanks };
            let message = brief(&with_found(message_of(&e.code), found));
            SceneError { path: self.path.clone(), place: Some((line, column)), message, help: None }
        })
    }

    /// The path of a file named at `at`: relative to this one, or a location of the [`library`].
    ///
    /// # Errors
    /// If there is no such file; `what` says what it should be.
    pub fn beside(&self, at: &str, what: &str, name: &str) -> Result<PathBuf, SceneError> {
        let beside = library::beside(&self.path, name);
        if library::is_file(&beside) {
            return Ok(beside);
        }
        let fault = self.error(at, format!("the {what} `{}` does not exist", beside.display()));
        Err(match library::namesake(&beside) {
            _ if library::is_location(&beside) => {
                fault.with_help("`contrapposto library` lists what there is")
            }
            None => fault.with_help("the path is relative to this file"),
            Some(entry) => fault.with_help(format!(
                "the path is relative to this file; the one of the library is `{}`",
                entry.location().display()
            )),
        })
    }

    /// An error at the value with this path, see [`SourceMap`].
    pub fn error(&self, at: &str, message: impl Into<String>) -> SceneError {
        // a field of a text that is one value alone has no path before it
        let place = line_column(&self.text, self.map.offset(at.trim_start_matches('.')));
        SceneError {
            path: self.path.clone(),
            place: Some(place),
            message: brief(&message.into()),
            help: None,
        }
    }

    /// An error for a name that does not exist, with the nearest one that does.
    ///
    /// * `kind`: what the name should be, such as `joint`
    /// * `within`: where it was met, such as ` in Pose "reach"`; may be empty
    pub fn unknown<'a>(
        &self,
        at: &str,
        kind: &str,
        name: &str,
        within: &str,
        known: impl IntoIterator<Item = &'a str>,
    ) -> SceneError {
        self.error(at, format!("unknown {kind} `{name}`{within}; {}", nearest_or_all(name, known)))
    }
}

/// The known name that was meant, or all there are.
fn nearest_or_all<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    match nearest(name, known.iter().copied()) {
        Some(n) => format!("did you mean `{n}`?"),
        None if known.is_empty() => "there is none".into(),
        None => {
            let list: Vec<_> = known.iter().map(|n| format!("`{n}`")).collect();
            format!("known are {}", list.join(", "))
        }
    }
}

/// Where a file is that was looked for on disk.
fn in_library(entry: &Entry) -> String {
    format!("the library has it: `{}`, or `{}` in a file", entry.name(), entry.location().display())
}

/// What RON says, but of a field or variant that does not exist: that, with the nearest that does.
fn message_of(e: &ron::Error) -> String {
    let known = |expected: &[&'static str], found: &str, what: &str, of: &Option<String>| {
        let of = of.as_ref().map_or(String::new(), |name| format!(" of `{name}`"));
        format!("unknown {what} `{found}`{of}; {}", nearest_or_all(found, expected.iter().copied()))
    };
    match e {
        ron::Error::NoSuchStructField { expected, found, outer } => known(expected, found, "field", outer),
        ron::Error::NoSuchEnumVariant { expected, found, outer } => known(expected, found, "word", outer),
        e => e.to_string(),
    }
}

/// RON says what it expected; this adds what stands there.
fn with_found(message: String, rest_of_line: &str) -> String {
    if !message.starts_with("Expected") && message != "Integer is out of bounds" {
        return message;
    }
    let end = rest_of_line.find([',', ')', ']', '}']).filter(|&i| i > 0).unwrap_or(rest_of_line.len());
    match rest_of_line[..end].trim_end() {
        "" => format!("{message}; found the end of the line or file"),
        found => format!("{message}; found `{}`", found.chars().take(40).collect::<String>()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mark that some editors put before a text is no part of it; places count as if it were not there.
    #[test]
    fn a_byte_order_mark_is_read_over() {
        let marked = Source::new("a.ron", "\u{feff}(1, x)").parse::<(u8, u8)>().unwrap_err();
        let plain = Source::new("a.ron", "(1, x)").parse::<(u8, u8)>().unwrap_err();
        assert_eq!(marked, plain);
        assert_eq!(Source::new("a.ron", "\u{feff}(1, 2)").parse::<(u8, u8)>().unwrap(), (1, 2));
        assert_eq!(Source::new("a.ron", "\u{feff}Scene()").first_word(), Some("Scene"));
    }

    /// However long a name is, an error is short, and its last words are there.
    #[test]
    fn errors_repeat_at_most_200_characters() {
        let long = "x".repeat(1_000_000);
        let text = format!("Scene({long}: 1)");
        #[derive(Debug, serde::Deserialize)]
        #[serde(deny_unknown_fields, rename = "Scene")]
        struct Small {
            #[serde(default)]
            _rate_hz: f64,
        }
        let source = Source::new("a.ron", text);
        let e = source.parse::<Small>().unwrap_err().to_string();
        assert!(e.chars().count() < 400 && e.contains("_rate_hz") && e.contains("a.ron:1:7"), "{e}");
        let e = source.unknown("", "joint", &long, " in a pose", ["elbow_l"]).to_string();
        assert!(e.chars().count() < 400 && e.contains("known are `elbow_l`"), "{e}");
        let e = Source::new("a.ron", format!("\"{long}\"")).parse::<f64>().unwrap_err().to_string();
        assert!(e.chars().count() < 400, "{e}");
    }

    #[test]
    fn an_error_reads_well() {
        let text = "Scene(\n  poses: [Pose(set_deg: {\"elbw_r\": 20})],\n)";
        let source = Source::new("scenes/reach.ron", text);
        let e = source.unknown(
            "poses[0].set_deg{\"elbw_r\"}",
            "joint",
            "elbw_r",
            " in Pose \"reach\"",
            ["elbow_r"],
        );
        assert_eq!(
            e.to_string(),
            "unknown joint `elbw_r` in Pose \"reach\"; did you mean `elbow_r`?\n  --> scenes/reach.ron:2:26"
        );
    }
}
