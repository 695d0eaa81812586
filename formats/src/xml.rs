//! XML with places: elements and attributes that know where they stand, for messages a person can act on.
//!
//! In: a file. Out: an owned tree of [`Element`]s. No format read here has text between elements: each element keeps the
//! first of it, and who reads the element refuses it. Elements nested deeper than [`MAX_DEPTH`] are refused, so that
//! readers may recurse; their number and that of their attributes are limited ([`crate::limits`]).

use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use motion::names::echo;

use super::limits::{self, ATTRIBUTES, ELEMENTS, MODEL_BYTES};
use super::model_file::{ModelFault, ModelFileError};
use super::place::Place;

/// Deepest nesting read; model files of hundreds of bodies in a row stay below it.
pub const MAX_DEPTH: usize = 400;

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

/// Text between elements.
#[derive(Clone, Debug, PartialEq)]
pub struct Text {
    /// Its first characters.
    pub found: String,
    /// Whether it is nothing but a `>` too many.
    pub stray: bool,
    /// Where it begins.
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
    /// The first text between its children; one that is not stray if there is any.
    pub text: Option<Text>,
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
            Some(name) => format!("{} `{}`", echo(&self.name), echo(name)),
            None => echo(&self.name),
        }
    }
}

/// Reads the root element of an XML file.
///
/// # Errors
/// A file that cannot be read, is not UTF-8, is not well-formed, nests too deeply or holds too much; with line and column.
pub fn read(path: &Path) -> Result<Element, ModelFileError> {
    let bytes = limits::read(path, MODEL_BYTES).map_err(ModelFileError::File)?;
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
    let blanked = without_late_declaration(text);
    let text = blanked.as_deref().unwrap_or(text);
    let lines = Lines::new(text, file);
    if let Some((at, fault)) = too_much(text) {
        return Err(lines.fault(at, fault));
    }
    // entities expand: the number of nodes is bounded by what a model can use, not by the text
    let options = roxmltree::ParsingOptions {
        allow_dtd: false,
        nodes_limit: 4 * ELEMENTS as u32,
        ..Default::default()
    };
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

/// The text with spaces for an XML declaration that stands behind blank lines: nothing may precede it, but other programs
/// read such files, and all places stay where they are. `None` where there is none.
fn without_late_declaration(text: &str) -> Option<String> {
    let start = text.len() - text.trim_start().len();
    let declared = text[start..].starts_with("<?xml ");
    let end = start + text[start..].find("?>")? + 2;
    (declared && start > 0).then(|| {
        let blank: String = text[start..end].chars().map(|c| if c == '\n' { c } else { ' ' }).collect();
        format!("{}{blank}{}", &text[..start], &text[end..])
    })
}

/// The first tag of a text with too many attributes or after too many others; the parser's work grows with the square of
/// the attributes of an element.
fn too_much(text: &str) -> Option<(usize, ModelFault)> {
    let bytes = text.as_bytes();
    let (mut at, mut elements) = (0, 0);
    let after = |at: usize, end: &str| text[at..].find(end).map_or(bytes.len(), |k| at + k + end.len());
    while let Some(open) = text[at..].find('<').map(|k| at + k) {
        let rest = &text[open..];
        at = match rest {
            _ if rest.starts_with("<!--") => after(open + 4, "-->"),
            _ if rest.starts_with("<![CDATA[") => after(open + 9, "]]>"),
            _ if rest.starts_with("<?") => after(open + 2, "?>"),
            _ if rest.starts_with("</") || rest.starts_with("<!") => open + 2,
            _ => {
                elements += 1;
                let (end, attributes) = tag(bytes, open + 1);
                if attributes > ATTRIBUTES {
                    return Some((
                        open,
                        ModelFault::TooMany { what: "attributes of an element", limit: ATTRIBUTES },
                    ));
                }
                if elements > ELEMENTS {
                    return Some((open, ModelFault::TooMany { what: "elements", limit: ELEMENTS }));
                }
                end
            }
        };
    }
    None
}

/// The end of a tag whose name begins at `at`, and how many values it has.
fn tag(bytes: &[u8], mut at: usize) -> (usize, usize) {
    let (mut quote, mut values) = (None, 0);
    while at < bytes.len() {
        match (bytes[at], quote) {
            (b, Some(q)) if b == q => quote = None,
            (_, Some(_)) => {}
            (b'>', None) => return (at + 1, values),
            (b @ (b'"' | b'\''), None) => {
                quote = Some(b);
                values += 1;
            }
            _ => {}
        }
        at += 1;
    }
    (at, values)
}

/// Turns byte offsets of a text into places. Offsets that ascend cost a walk through the text in all.
struct Lines<'a> {
    text: &'a str,
    file: Arc<PathBuf>,
    /// Where the last place was: byte, line, column.
    last: Cell<(usize, usize, usize)>,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str, file: Arc<PathBuf>) -> Self {
        Self { text, file, last: Cell::new((0, 1, 1)) }
    }

    fn place(&self, byte: usize) -> Place {
        let (from, mut line, mut column) = match self.last.get() {
            last if last.0 <= byte => last,
            _ => (0, 1, 1),
        };
        for c in self.text[from..byte].chars() {
            if c == '\n' {
                (line, column) = (line + 1, 1);
            } else {
                column += 1;
            }
        }
        self.last.set((byte, line, column));
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
        let place = self.place(at);
        // the prefix as written: between `<` and the local name
        let local = node.tag_name().name();
        let written = self.text[at + 1..].split(|c: char| c.is_whitespace() || matches!(c, '/' | '>')).next();
        let name = written.filter(|w| w.ends_with(local)).unwrap_or(local).to_owned();
        let attributes = node
            .attributes()
            .map(|a| Attribute {
                name: a.name().to_owned(),
                value: a.value().to_owned(),
                place: self.place(a.range().start),
            })
            .collect();
        let mut children = Vec::new();
        let mut text: Option<Text> = None;
        for child in node.children() {
            if child.is_element() {
                children.push(self.element(child, depth + 1)?);
            } else if child.is_text()
                && text.as_ref().is_none_or(|t| t.stray)
                && let Some(new) = self.text(child).filter(|new| text.is_none() || !new.stray)
            {
                text = Some(new);
            }
        }
        Ok(Element { name, attributes, children, text, place })
    }

    /// The text of a node, if it is more than white space.
    fn text(&self, node: roxmltree::Node<'_, '_>) -> Option<Text> {
        let text = node.text().unwrap_or_default();
        text.find(|c: char| !c.is_whitespace())?;
        // as written: the parser shortens line ends
        let written = &self.text[node.range()];
        let byte = node.range().start + (written.len() - written.trim_start().len());
        let stray = text.chars().all(|c| c.is_whitespace() || c == '>');
        Some(Text { found: text.trim().chars().take(20).collect(), stray, place: self.place(byte) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Element, ModelFileError> {
        parse(text, Arc::new("m.xml".into()))
    }

    #[test]
    fn places_are_lines_and_characters() {
        let root = read("<a>\r\n é<b c='1'\n d='2'/><x:e xmlns:x='y'/>\n</a>").expect("XML");
        let at = |p: &Place| (p.line, p.column);
        let b = &root.children[0];
        assert_eq!([at(&root.place), at(&b.place)], [(1, 1), (2, 3)]);
        assert_eq!([at(&b.attributes[0].place), at(&b.attributes[1].place)], [(2, 6), (3, 2)]);
        assert_eq!(root.children[1].name, "x:e");
        assert_eq!(at(&root.text.expect("a letter").place), (2, 2));
    }

    #[test]
    fn the_first_text_that_is_no_stray_bracket_is_kept() {
        let text = |t: &str| read(t).expect("XML").text.map(|t| (t.found, t.stray));
        assert_eq!(text("<a> \n</a>"), None);
        assert_eq!(text("<a><b/>></a>"), Some((">".into(), true)));
        assert_eq!(text("<a><b/>><b/> -->.<b/>word</a>"), Some(("-->.".into(), false)));
    }

    #[test]
    fn tags_are_counted_as_the_parser_sees_them() {
        let many = "q=\"\" ".repeat(2 * ATTRIBUTES);
        let hidden =
            format!("<a><?p <x {many}> ?><!-- <x {many}> --><![CDATA[<x {many}>]]><b c='{many}'/></a>");
        assert!(too_much(&hidden).is_none());
        assert!(too_much("<a b='>' c=\"'>'\"/>").is_none());
        assert!(too_much(&format!("<a>{}</a>", "<b/>".repeat(ELEMENTS - 1))).is_none());
        assert_eq!(
            too_much(&format!("<a>{}</a>", "<b/>".repeat(ELEMENTS))).map(|(at, _)| at),
            Some(3 + 4 * (ELEMENTS - 1))
        );
        let wide = format!("<a {}/>", "b='' ".repeat(ATTRIBUTES + 1));
        assert!(matches!(too_much(&wide), Some((0, ModelFault::TooMany { .. }))));
    }
}
