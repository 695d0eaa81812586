//! Where the values of a RON text stand.
//!
//! In: a text that RON has already accepted. Out: the position of any value by its path, such as
//! `links[3].mass_kg`, `parts{"arm_l"}[0]` or `rest.joints{"elbow_l"}`. RON forgets positions once a
//! value is built; errors that are found later (an unknown name, an impossible mass) get theirs here.
//!
//! Paths: `.field` of a struct, `[index]` of a list or tuple, `{"key"}` of a map (its place is that of the key); names of structs and
//! variants take no part.

use std::collections::HashMap;

/// Positions of the values of one text; see the module header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SourceMap {
    at: HashMap<String, usize>,
}

impl SourceMap {
    /// Scans a text.
    pub fn new(text: &str) -> Self {
        let mut scan = Scan { text: text.as_bytes(), i: 0, map: Self::default() };
        scan.value(&mut String::new(), 0);
        scan.map
    }

    /// Byte offset of the value at a path, or of the nearest enclosing value that is written down.
    pub fn offset(&self, path: &str) -> usize {
        let mut path = path;
        loop {
            if let Some(&at) = self.at.get(path) {
                return at;
            }
            match path.rfind(['.', '[', '{']) {
                Some(i) => path = &path[..i],
                None => return self.at.get("").copied().unwrap_or(0),
            }
        }
    }
}

/// Line and column (1-based, in characters) of a byte offset.
pub fn line_column(text: &str, offset: usize) -> (usize, usize) {
    let mut end = offset.min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    let before = &text[..end];
    let line = before.matches('\n').count() + 1;
    let start = before.rfind('\n').map_or(0, |i| i + 1);
    (line, before[start..].chars().count() + 1)
}

struct Scan<'a> {
    text: &'a [u8],
    i: usize,
    map: SourceMap,
}

/// Deeper nesting than this is not descended into: the positions of enclosing values serve.
const DEEPEST: usize = 64;

impl Scan<'_> {
    fn peek(&self) -> u8 {
        self.text.get(self.i).copied().unwrap_or(0)
    }

    /// Skips blanks, comments and `#![enable(…)]`.
    fn blanks(&mut self) {
        while self.i < self.text.len() {
            let rest = &self.text[self.i..];
            let until = |end: &[u8]| {
                rest.windows(end.len()).position(|w| w == end).map_or(rest.len(), |n| n + end.len())
            };
            self.i += match rest {
                [c, ..] if c.is_ascii_whitespace() => 1,
                [0xEF, 0xBB, 0xBF, ..] => 3,
                [b'/', b'/', ..] => until(b"\n"),
                [b'/', b'*', ..] => self.block_comment(),
                [b'#', b'!', ..] => until(b"]"),
                _ => return,
            };
        }
    }

    /// Length of a block comment; they nest.
    fn block_comment(&self) -> usize {
        let rest = &self.text[self.i..];
        let (mut depth, mut n) = (0, 0);
        while n < rest.len() {
            match &rest[n..] {
                [b'/', b'*', ..] => (depth, n) = (depth + 1, n + 2),
                [b'*', b'/', ..] => (depth, n) = (depth - 1, n + 2),
                _ => n += 1,
            }
            if depth == 0 {
                break;
            }
        }
        n
    }

    /// Scans one value, whose path is `path`.
    fn value(&mut self, path: &mut String, depth: usize) {
        self.blanks();
        self.map.at.entry(path.clone()).or_insert(self.i);
        if !matches!(self.peek(), b'(' | b'[' | b'{') {
            self.word();
            self.blanks();
        }
        match self.peek() {
            b'(' => self.inside(path, b')', depth),
            b'[' => self.inside(path, b']', depth),
            b'{' => self.inside(path, b'}', depth),
            _ => {}
        }
    }

    fn inside(&mut self, path: &mut String, close: u8, depth: usize) {
        self.i += 1;
        let length = path.len();
        let mut index = 0;
        loop {
            self.blanks();
            if self.i >= self.text.len() || depth > DEEPEST {
                self.i = self.text.len();
                return;
            }
            if self.peek() == close {
                self.i += 1;
                return;
            }
            let start = self.i;
            // a field or key is a word followed by a colon
            let word = self.word();
            self.blanks();
            if close != b']' && self.peek() == b':' && !word.is_empty() {
                self.i += 1;
                match close {
                    b')' if path.is_empty() => path.push_str(&word),
                    b')' => *path += &format!(".{word}"),
                    _ => {
                        *path += &format!("{{{word}}}");
                        self.map.at.entry(path.clone()).or_insert(start); // the place of the key, for errors about its name
                    }
                }
            } else {
                self.i = start;
                *path += &format!("[{index}]");
            }
            self.value(path, depth + 1);
            path.truncate(length);
            index += 1;
            self.blanks();
            if self.peek() == b',' {
                self.i += 1;
            } else if self.i == start {
                self.i += 1; // skip a byte that begins nothing, so that the scan always ends
            }
        }
    }

    /// Reads a string with its quotes, a number or a name.
    fn word(&mut self) -> String {
        let start = self.i;
        let rest = &self.text[start..];
        if let [b'r', b'"' | b'#', ..] = rest {
            let hashes = rest[1..].iter().take_while(|&&c| c == b'#').count();
            if rest.get(1 + hashes) == Some(&b'"') {
                let mut end = vec![b'"'];
                end.extend(vec![b'#'; hashes]);
                let body = &rest[2 + hashes..];
                let n = body.windows(end.len()).position(|w| w == end).unwrap_or(body.len());
                self.i = (start + 2 + hashes + n + end.len()).min(self.text.len());
                return format!("\"{}\"", String::from_utf8_lossy(&body[..n]));
            }
        }
        if let Some(&quote @ (b'"' | b'\'')) = rest.first() {
            self.i += 1;
            while self.i < self.text.len() && self.peek() != quote {
                self.i += if self.peek() == b'\\' { 2 } else { 1 };
            }
            self.i = (self.i + 1).min(self.text.len());
        } else {
            while self.i < self.text.len() && !b"()[]{},: \t\r\n".contains(&self.peek()) {
                self.i += 1;
            }
        }
        String::from_utf8_lossy(&self.text[start..self.i]).into_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_found_by_path() {
        let text = "#![enable(implicit_some)]\n// a (comment\nBody(\n  name: \"é[\", /* { /* nested */ ( */\n  list: [A(x: 1), B(2, 3.5)],\n  parts: {\"arm_l\": [\"a\", \"b\"]},\n)\n";
        let map = SourceMap::new(text);
        let at = |path: &str| {
            let o = map.offset(path);
            (text[o..].chars().take(3).collect::<String>(), line_column(text, o))
        };
        assert_eq!(at("name"), ("\"é[".into(), (4, 9)));
        assert_eq!(at("list[0].x"), ("1),".into(), (5, 15)));
        assert_eq!(at("list[1]"), ("B(2".into(), (5, 19)));
        assert_eq!(at("list[1][1]"), ("3.5".into(), (5, 24)));
        assert_eq!(at("parts{\"arm_l\"}[1]"), ("\"b\"".into(), (6, 26)));
        assert_eq!(at("list[0].missing"), ("A(x".into(), (5, 10)));
        assert_eq!(at("nothing[4].at"), ("Bod".into(), (3, 1)));
    }

    /// Whatever the text, the scan ends.
    #[test]
    fn nonsense_ends() {
        for text in
            ["", "(", "((((((", "[}", "\"abc", "r#\"abc", "/*", "{:}", "a:b:c", "(a:", ")", "(,,,)", "\\"]
        {
            SourceMap::new(text);
        }
        SourceMap::new(&"(".repeat(100_000));
    }
}
