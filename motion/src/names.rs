//! Names: tables of the names of values ([`Word`]), and the nearest known name, for error messages.
//!
//! In: a name and the known ones. Out: the value it names, or the known name at the least edit distance, if it is near
//! enough to be a slip. Distance counts insertions, deletions, substitutions and swaps of neighbours.

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
    for candidate in candidates {
        let d = distance(name, candidate);
        let longest = name.chars().count().max(candidate.chars().count());
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
