//! XML with places: elements and attributes that know where they stand, for messages a person can act on.
//!
//! In: a file. Out: an owned tree of [`Element`]s. Text between elements is refused: no format read here
//! has any. Elements nested deeper than [`MAX_DEPTH`] are refused, so that readers may recurse.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::model_file::{ModelFault, ModelFileError};

/// Deepest nesting read; model files of hundreds of bodies in a row stay below it.
pub const MAX_DEPTH: usize = 400;

/// A place in a text file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub file: Arc<PathBuf>,
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1, in characters.
    pub column: usize,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.file.display(), self.line, self.column)
    }
}

/// An attribute as written.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// Name, without name space.
    pub name: String,
    /// Value, entities resolved.
    pub value: String,
    /// Where its name begins.
    pub place: Place,
}

/// An element with its attributes and child elements, in the order of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Element {
    /// Name; a name space prefix is written before it as in the file.
    pub name: String,
    /// Attributes.
    pub attributes: Vec<Attribute>,
    /// Child elements.
    pub children: Vec<Element>,
    /// Where its `<` stands.
    pub place: Place,
}

impl Element {
    /// The attribute of this name.
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|a| a.name == name)
    }

    /// The value of the attribute of this name.
    pub fn value(&self, name: &str) -> Option<&str> {
        self.attribute(name).map(|a| a.value.as_str())
    }

    /// Child elements of this name.
    pub fn children_named<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Element> {
        self.children.iter().filter(move |c| c.name == name)
    }

    /// How a message calls the element: its tag, and its `name` where it has one.
    pub fn title(&self) -> String {
        match self.value("name") {
            Some(name) => format!("{} `{name}`", self.name),
            None => self.name.clone(),
        }
    }
}

/// Reads the root element of an XML file.
///
/// # Errors
/// A file that cannot be read, is not UTF-8, is not well-formed, nests too deeply or has text between
/// elements; with line and column.
pub fn read(path: &Path) -> Result<Element, ModelFileError> {
    let bytes = super::read(path).map_err(ModelFileError::File)?;
    let file = Arc::new(path.to_path_buf());
    let text = match std::str::from_utf8(&bytes) {
        Ok(text) => text.strip_prefix('\u{feff}').unwrap_or(text),
        Err(e) => {
            let good = String::from_utf8_lossy(&bytes[..e.valid_up_to()]).into_owned();
            return Err(Lines::new(&good, file).fault(good.len(), ModelFault::NotUtf8));
        }
    };
    parse(text, file)
}

/// Parses XML text; `file` names it in places.
///
/// # Errors
/// See [`read`].
pub fn parse(text: &str, file: Arc<PathBuf>) -> Result<Element, ModelFileError> {
    let lines = Lines::new(text, file);
    // entities expand: the number of nodes is bounded by what a model can use, not by the text
    let options =
        roxmltree::ParsingOptions { allow_dtd: false, nodes_limit: 4_000_000, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(text, options).map_err(|e| {
        let at = e.pos();
        let mut message = e.to_string();
        if let Some(cut) = message.rfind(" at ") {
            message.truncate(cut); // the place follows in our own form
        }
        ModelFileError::Model {
            fault: ModelFault::Syntax { message },
            place: Place { file: lines.file.clone(), line: at.row as usize, column: at.col as usize },
        }
    })?;
    lines.element(document.root_element(), 0)
}

/// Line starts of a text, to turn byte offsets into places.
struct Lines<'a> {
    text: &'a str,
    starts: Vec<usize>,
    file: Arc<PathBuf>,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str, file: Arc<PathBuf>) -> Self {
        let starts = std::iter::once(0).chain(text.match_indices('\n').map(|(i, _)| i + 1)).collect();
        Self { text, starts, file }
    }

    fn place(&self, byte: usize) -> Place {
        let line = self.starts.partition_point(|&s| s <= byte);
        let column = self.text[self.starts[line - 1]..byte].chars().count() + 1;
        Place { file: self.file.clone(), line, column }
    }

    fn fault(&self, byte: usize, fault: ModelFault) -> ModelFileError {
        ModelFileError::Model { fault, place: self.place(byte) }
    }

    fn element(&self, node: roxmltree::Node<'_, '_>, depth: usize) -> Result<Element, ModelFileError> {
        let at = node.range().start;
        if depth > MAX_DEPTH {
            return Err(self.fault(at, ModelFault::TooDeep { limit: MAX_DEPTH }));
        }
        // the prefix as written: everything between `<` and the local name
        let local = node.tag_name().name();
        let tag = &self.text[at + 1..];
        let prefix = tag.find(':').filter(|&i| tag[i + 1..].starts_with(local) && !tag.starts_with(local));
        let name = prefix.map_or_else(|| local.to_owned(), |i| format!("{}:{local}", &tag[..i]));
        let attributes = node
            .attributes()
            .map(|a| Attribute {
                name: a.name().to_owned(),
                value: a.value().to_owned(),
                place: self.place(a.range().start),
            })
            .collect();
        let mut children = Vec::new();
        for child in node.children() {
            if child.is_element() {
                children.push(self.element(child, depth + 1)?);
            } else if child.is_text() {
                let text = child.text().unwrap_or_default();
                if let Some(skipped) = text.find(|c: char| !c.is_whitespace()) {
                    let found: String = text.trim().chars().take(20).collect();
                    let byte = (child.range().start + skipped).min(child.range().end);
                    let byte = (0..=byte).rev().find(|&b| self.text.is_char_boundary(b)).unwrap_or(0);
                    return Err(self.fault(byte, ModelFault::Text { element: name, found }));
                }
            }
        }
        Ok(Element { name, attributes, children, place: self.place(at) })
    }
}
