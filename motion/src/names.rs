//! Names: what may be one, tables of the names of values ([`Word`]), and the nearest known name, for error messages.
//!
//! In: a name and the known ones. Out: the value it names, or the known name at the least edit distance, if it is near
//! enough to be a slip. Distance counts insertions, deletions, substitutions and swaps of neighbours.

/// The most characters of a text of somebody else's that an error repeats.
pub const MOST_ECHOED: usize = 200;

/// A word of a file as a message repeats it: at most [`MOST_ECHOED`] characters, control characters escaped.
///
/// # Examples
/// ```
/// use motion::names::echo;
/// assert_eq!(echo("elbow"), "elbow");
/// assert_eq!(echo("a\u{0}b"), "a\\u{0}b");
/// assert_eq!(echo(&"x".repeat(1_000_000)).chars().count(), 200);
/// ```
pub fn echo(text: &str) -> String {
    let mut out = String::new();
    let mut left = MOST_ECHOED;
    for (at, c) in text.char_indices() {
        let piece: String = if c.is_control() { c.escape_default().collect() } else { c.into() };
        let length = piece.chars().count();
        let last = at + c.len_utf8() == text.len();
        if length + usize::from(!last) > left {
            out.push('…');
            break;
        }
        left -= length;
        out.push_str(&piece);
    }
    out
}

/// The candidate nearest to `name`, or `None` if none is within half the length of the longer name.
///
/// Upper and lower case count as the same letter; the first of several equally near candidates wins.
///
/// # Examples
/// ```
/// use motion::names::nearest;
/// assert_eq!(nearest("elbw_r", ["elbow_l", "elbow_r"]), Some("elbow_r"));
/// assert_eq!(nearest("Wirst_R", ["elbow_r", "wrist_r"]), Some("wrist_r"));
/// assert_eq!(nearest("tail", ["elbow_l", "elbow_r"]), None);
/// ```
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let mut best: Option<(usize, &str)> = None;
    let length = name.chars().count();
    for candidate in candidates {
        let other = candidate.chars().count();
        let longest = length.max(other);
        // names that differ more in length are not near
        if 2 * length.abs_diff(other) > longest {
            continue;
        }
        let d = distance(name, candidate);
        if 2 * d <= longest && best.is_none_or(|(least, _)| d < least) {
            best = Some((d, candidate));
        }
    }
    best.map(|(_, c)| c)
}

/// The end of an error message: `; did you mean …?`, and what exists where nothing is near.
///
/// At most 40 names are listed.
pub fn hint<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    let all: Vec<&str> = candidates.into_iter().collect();
    if let Some(near) = nearest(name, all.iter().copied()) {
        return format!("; did you mean `{near}`?");
    }
    match all.len() {
        0 => "; there are none".into(),
        n if n > 40 => format!("; there are {n}: {}, …", all[..40].join(", ")),
        _ => format!("; there are: {}", all.join(", ")),
    }
}

/// A message in which every text between back quotes is as [`echo`] has it. Control characters elsewhere, but for ends of lines, are
/// written as escapes too, so that a file cannot steer the terminal.
///
/// # Examples
/// ```
/// use motion::names::brief;
/// assert_eq!(brief("unknown joint `elbw_r`"), "unknown joint `elbw_r`");
/// let long = brief(&format!("unknown joint `{}`; known are `a`", "x".repeat(5000)));
/// assert!(long.chars().count() < 250 && long.ends_with("…`; known are `a`"));
/// assert_eq!(brief("`a\u{1b}[2J`"), "`a\\u{1b}[2J`");
/// ```
pub fn brief(message: &str) -> String {
    let mut out = String::with_capacity(message.len().min(1 << 12));
    for (i, part) in message.split('`').enumerate() {
        if i > 0 {
            out.push('`');
        }
        if i % 2 == 1 {
            out += &echo(part);
            continue;
        }
        for c in part.chars() {
            match c {
                '\n' => out.push(c),
                c if c.is_control() => out.extend(c.escape_default()),
                c => out.push(c),
            }
        }
    }
    out
}

/// The most characters of a name.
pub const MOST_OF_A_NAME: usize = 128;

/// Checks a name of a link, site, part or action: every format that is written must be able to hold it.
///
/// # Errors
/// What is wrong and what is allowed.
///
/// # Examples
/// ```
/// use motion::names::check;
/// assert!(check("elbow_l").is_ok() && check("Unterarm rechts").is_ok());
/// assert_eq!(check("").unwrap_err(), "a name is empty; allowed: 1 to 128 characters");
/// assert!(check("a\0b").is_err() && check("two\nlines").is_err() && check(" blank ").is_err());
/// assert!(check(&"x".repeat(129)).is_err());
/// ```
pub fn check(name: &str) -> Result<(), String> {
    let length = name.chars().count();
    if length == 0 {
        return Err(format!("a name is empty; allowed: 1 to {MOST_OF_A_NAME} characters"));
    }
    if length > MOST_OF_A_NAME {
        let start: String = name.chars().take(40).collect();
        return Err(format!("the name `{start}…` has {length} characters; allowed: 1 to {MOST_OF_A_NAME}"));
    }
    if name.chars().any(char::is_control) {
        return Err(format!(
            "the name `{name}` has a control character; allowed: letters, digits, signs and blanks"
        ));
    }
    if name.trim() != name {
        return Err(format!("the name `{name}` begins or ends with a blank; allowed: blanks inside only"));
    }
    Ok(())
}

/// Edit distance (optimal string alignment) without regard to case.
pub fn distance(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.chars().flat_map(char::to_lowercase).collect();
    let b: Vec<char> = b.chars().flat_map(char::to_lowercase).collect();
    let width = b.len() + 1;
    let mut d = vec![0; (a.len() + 1) * width];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            d[i * width + j] = if i == 0 || j == 0 {
                i + j
            } else {
                let change = usize::from(a[i - 1] != b[j - 1]);
                let mut least = (d[(i - 1) * width + j] + 1)
                    .min(d[i * width + j - 1] + 1)
                    .min(d[(i - 1) * width + j - 1] + change);
                if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                    least = least.min(d[(i - 2) * width + j - 2] + 1);
                }
                least
            };
        }
    }
    d[a.len() * width + b.len()]
}

/// An enumeration that people write: in a scene, on a command line, in a report. Each value has one name and one line about
/// it, and all three take them from here.
///
/// An enumeration whose values carry data has a second one beside it, of their names alone: `Curve` has `CurveName`.
///
/// # Examples
/// ```
/// use motion::names::Word;
///
/// #[derive(Clone, Copy, Debug, PartialEq)]
/// enum Side { Left, Right }
///
/// impl Word for Side {
///     const KIND: &'static str = "side";
///     const WORDS: &'static [(Self, &'static str, &'static str)] =
///         &[(Side::Left, "left", "where the heart is"), (Side::Right, "right", "the other one")];
/// }
///
/// assert_eq!(Side::find("Left"), Ok(Side::Left)); // scenes write names with a capital
/// assert_eq!(Side::Right.word(), "right");
/// assert_eq!(Side::Right.identifier(), "Right");
/// let e = Side::find("lft").unwrap_err();
/// assert_eq!(e.to_string(), "unknown side `lft`; did you mean `left`?");
/// ```
pub trait Word: Copy + PartialEq + 'static {
    /// What a value is called in messages, such as `model`.
    const KIND: &'static str;
    /// All values: value, name in lower case with hyphens, one line about it.
    const WORDS: &'static [(Self, &'static str, &'static str)];
    /// Other names that are understood, such as a shorter one on a command line; nothing writes them.
    const ALIASES: &'static [(Self, &'static str)] = &[];

    /// The name of this value.
    fn word(self) -> &'static str {
        Self::WORDS.iter().find(|w| w.0 == self).map_or("", |w| w.1)
    }

    /// The name as a scene writes it: `root-height` is `RootHeight`.
    fn identifier(self) -> String {
        let capital = |part: &str| part[..1].to_uppercase() + &part[1..];
        self.word().split('-').filter(|part| !part.is_empty()).map(capital).collect()
    }

    /// The value of a name. Capitals, hyphens and underscores make no difference: `RootHeight` is `root-height`.
    ///
    /// # Errors
    /// [`UnknownWord`] with the nearest name, or all names.
    fn find(text: &str) -> Result<Self, UnknownWord> {
        let plain = |s: &str| s.replace(['-', '_'], "").to_lowercase();
        let names = Self::WORDS.iter().map(|w| (w.0, w.1)).chain(Self::ALIASES.iter().copied());
        let found = names.into_iter().find(|(_, name)| plain(name) == plain(text));
        found.map(|(value, _)| value).ok_or_else(|| {
            let hint = hint(text, Self::WORDS.iter().map(|w| w.1));
            UnknownWord { kind: Self::KIND, found: text.chars().take(80).collect(), hint }
        })
    }
}

/// A name that is none of an enumeration's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown {kind} `{found}`{hint}")]
pub struct UnknownWord {
    /// What it should name.
    pub kind: &'static str,
    /// What was written.
    pub found: String,
    /// The nearest name, or all of them.
    pub hint: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_slip_is_one_step() {
        for (a, b) in [("elbow", "elbw"), ("elbow", "elbwo"), ("elbow", "elbox"), ("elbow", "elboww")] {
            assert_eq!(distance(a, b), 1, "{a} {b}");
            assert_eq!(distance(b, a), 1, "{a} {b}");
        }
        assert_eq!(distance("Elbow_R", "elbow_r"), 0);
        assert_eq!(distance("", "abc"), 3);
    }

    #[test]
    fn hints_name_the_nearest_or_list_all() {
        assert_eq!(hint("wvae", ["wave", "bow"]), "; did you mean `wave`?");
        assert_eq!(hint("zzzz", ["wave", "bow"]), "; there are: wave, bow");
        assert_eq!(hint("zzzz", []), "; there are none");
    }
}
