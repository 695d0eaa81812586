//! One `.npy` array from bytes nobody vouches for.
//!
//! In: the bytes of a zip entry. Out: shape and numbers or texts. What is read: numpy `lib.format` 1.0 to
//! 3.0, row-major, little-endian `f8`, `f4`, `i8`, `i4` and `U` (UTF-32). Nothing is allocated before the
//! declared size is known to fit the bytes at hand, and the header is parsed without recursion: a
//! damaged file costs an error, never a crash.

/// An array as stored.
#[derive(Clone, Debug)]
pub struct Npy {
    /// Length along each axis; empty for a scalar.
    pub shape: Vec<usize>,
    values: Values,
}

#[derive(Clone, Debug)]
enum Values {
    Reals(Vec<f64>),
    Integers(Vec<i64>),
    Texts(Vec<String>),
}

/// Why bytes are no array, without the name of the array.
pub type Fault = String;

impl Npy {
    /// Parses an array.
    pub fn parse(bytes: &[u8]) -> Result<Self, Fault> {
        let (header, body) = split(bytes)?;
        let order = value(header, "fortran_order")?;
        let shape = shape(value(header, "shape")?)?;
        if order.starts_with("True") && shape.len() > 1 {
            return Err("column-major order; allowed: row-major (C order)".into());
        }
        let kind = value(header, "descr")?;
        let kind = match kind.strip_prefix('\'').and_then(|k| k.split_once('\'')) {
            Some((kind, _)) => kind,
            None => return Err("records or objects; allowed: numbers and text".into()),
        };
        let count = shape.iter().try_fold(1usize, |n, &s| n.checked_mul(s));
        let size = match kind {
            "<f8" | "<i8" => 8,
            "<f4" | "<i4" => 4,
            text if text.starts_with("<U") => {
                let width: Option<usize> = text[2..].parse().ok();
                width.and_then(|w| w.checked_mul(4)).ok_or_else(|| format!("type `{text}`"))?
            }
            other => return Err(format!("type `{}`; allowed: <f8, <f4, <i8, <i4, <U", short(other))),
        };
        let needed = count.and_then(|n| n.checked_mul(size));
        if needed != Some(body.len()) {
            let needed =
                needed.map_or_else(|| "more bytes than there can be".into(), |n| format!("{n} bytes"));
            return Err(format!("shape {shape:?} of `{kind}` needs {needed}; there are {}", body.len()));
        }
        let count = count.unwrap_or(0);
        let values = match kind {
            "<f8" => Values::Reals(cells(body, f64::from_le_bytes).collect()),
            "<f4" => Values::Reals(cells(body, f32::from_le_bytes).map(f64::from).collect()),
            "<i8" => Values::Integers(cells(body, i64::from_le_bytes).collect()),
            "<i4" => Values::Integers(cells(body, i32::from_le_bytes).map(i64::from).collect()),
            // a text type of width 0 has no bytes, so its number of texts cannot be checked against the length of the data
            _ if size == 0 => return Err(format!("{count} texts of no length")),
            _ => Values::Texts(body.chunks_exact(size).map(text).collect::<Result<_, _>>()?),
        };
        Ok(Self { shape, values })
    }

    /// The numbers, row by row; integers are turned into reals.
    pub fn into_reals(self) -> Result<Vec<f64>, Fault> {
        match self.values {
            Values::Reals(v) => Ok(v),
            Values::Integers(v) => Ok(v.into_iter().map(|x| x as f64).collect()),
            Values::Texts(_) => Err("text; allowed: numbers".into()),
        }
    }

    /// The integers, row by row.
    pub fn into_integers(self) -> Result<Vec<i64>, Fault> {
        match self.values {
            Values::Integers(v) => Ok(v),
            Values::Reals(_) => Err("real numbers; allowed: integers".into()),
            Values::Texts(_) => Err("text; allowed: integers".into()),
        }
    }

    /// The texts, row by row.
    pub fn into_texts(self) -> Result<Vec<String>, Fault> {
        match self.values {
            Values::Texts(v) => Ok(v),
            _ => Err("numbers; allowed: text (<U)".into()),
        }
    }
}

/// Header text and data.
fn split(bytes: &[u8]) -> Result<(&str, &[u8]), Fault> {
    let cut = || Fault::from("the array ends inside its header");
    if !bytes.starts_with(b"\x93NUMPY") {
        return Err("not a .npy array: it does not begin with \\x93NUMPY".into());
    }
    let (size, start) = match *bytes.get(6).ok_or_else(cut)? {
        1 => {
            let b = bytes.get(8..10).ok_or_else(cut)?;
            (usize::from(u16::from_le_bytes([b[0], b[1]])), 10)
        }
        2 | 3 => {
            let b = bytes.get(8..12).ok_or_else(cut)?;
            (u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize, 12)
        }
        v => return Err(format!("format version {v}; allowed: 1, 2, 3")),
    };
    let header = bytes.get(start..).and_then(|rest| rest.get(..size)).ok_or_else(cut)?;
    let header = std::str::from_utf8(header).map_err(|_| "a header that is no text".to_owned())?;
    Ok((header, &bytes[start + size..]))
}

/// What follows `'key':` in the header.
fn value<'a>(header: &'a str, key: &str) -> Result<&'a str, Fault> {
    let at = header.find(&format!("'{key}'"));
    let after = at.and_then(|at| header[at + key.len() + 2..].trim_start().strip_prefix(':'));
    after.map(str::trim_start).ok_or_else(|| format!("a header without '{key}'"))
}

fn shape(text: &str) -> Result<Vec<usize>, Fault> {
    let inside = text.strip_prefix('(').and_then(|t| t.split_once(')'));
    let (inside, _) = inside.ok_or_else(|| "a shape that is no tuple".to_owned())?;
    let lengths = inside.split(',').map(str::trim).filter(|l| !l.is_empty());
    let parse = |l: &str| l.parse().map_err(|_| format!("length `{}` in its shape", short(l)));
    lengths.map(parse).collect()
}

/// The numbers of a body, `N` bytes each.
fn cells<const N: usize, T>(body: &[u8], of: fn([u8; N]) -> T) -> impl Iterator<Item = T> {
    body.chunks_exact(N).map(move |chunk| of(std::array::from_fn(|i| chunk[i])))
}

/// A UTF-32 text up to its padding.
fn text(bytes: &[u8]) -> Result<String, Fault> {
    let end = bytes.chunks_exact(4).rposition(|c| c != [0; 4]).map_or(0, |last| last + 1);
    let char =
        |code: u32| char::from_u32(code).ok_or_else(|| format!("text with the invalid code {code:#x}"));
    cells(&bytes[..4 * end], u32::from_le_bytes).map(char).collect()
}

/// As much of a text as a message bears.
fn short(text: &str) -> String {
    text.chars().take(20).collect()
}
