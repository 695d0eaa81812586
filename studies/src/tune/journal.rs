//! Samples as a table: the state of a search on disk, and the result of a sweep.
//!
//! In: samples and what identifies the run. Out: CSV text with one line per sample, and back, equal to the bit (numbers are
//! written with as many digits as they need). The first line is a comment, `# ` and the run's identity; the second
//! names the columns: `index`, `cost`, the terms, `survived`, the parameters in their units, `check`.
//!
//! `check` is a digest of the first two lines and of the row before it: a row that somebody changed, or that belongs to
//! another table, is an error, for a search would go on from a cost that nobody computed. It finds changes; it is no protection
//! against somebody who forges a row.

use std::fmt::Write as _;

use controllers::Parameter;
use dynamics::digest::Digest;

use super::search::Sample;
use scenes::tune_spec::TERMS;

/// Columns before the parameters.
const BEFORE: usize = 3 + TERMS.len();
/// The last column.
const CHECK: &str = "check";
/// Its hexadecimal digits.
const CHECK_DIGITS: usize = 16;

/// What a table is of: its first two lines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Head {
    /// The run.
    pub identity: String,
    /// Names of the columns.
    columns: String,
}

impl Head {
    /// Of a run over some parameters.
    pub fn new(identity: &str, parameters: &[&Parameter]) -> Self {
        let mut names = vec!["index", "cost"];
        names.extend(TERMS);
        names.push("survived");
        names.extend(parameters.iter().map(|p| p.name));
        names.push(CHECK);
        Self { identity: identity.into(), columns: names.join(",") }
    }

    /// Names of the parameters.
    pub fn parameters(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.columns.split(',').skip(BEFORE).collect();
        names.pop();
        names
    }

    /// One line, without its end.
    pub fn line(&self, index: usize, s: &Sample) -> String {
        let mut text = format!("{index},{}", s.cost);
        for x in &s.terms {
            let _ = write!(text, ",{x}");
        }
        let _ = write!(text, ",{}", s.survived);
        for x in &s.values {
            let _ = write!(text, ",{x}");
        }
        let check = self.check(&text);
        text + "," + &check
    }

    /// A whole table, of samples with their indices.
    pub fn table<'a>(&self, samples: impl IntoIterator<Item = (usize, &'a Sample)>) -> String {
        let mut text = format!("# {}\n{}\n", self.identity, self.columns);
        for (i, s) in samples {
            text += &self.line(i, s);
            text.push('\n');
        }
        text
    }

    /// The last cell of a row that has this text before it.
    fn check(&self, row: &str) -> String {
        let mut digest = Digest::default();
        [&self.identity, &self.columns, row].into_iter().for_each(|text| digest.text(text));
        digest.hex()
    }
}

/// A table read back.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Its first two lines.
    pub head: Head,
    /// Index and sample of every whole line, in the order of the file.
    pub samples: Vec<(usize, Sample)>,
    /// Lines that are not whole, such as the last one of a job that was killed: their numbers, from 1.
    pub torn: Vec<usize>,
}

/// Reads a table. A line that is not whole is listed in `torn`, not an error: a job may have been killed while it wrote.
///
/// # Errors
/// What the first two lines should be; a line that is whole but not as it was written.
pub fn read(text: &str) -> Result<Table, String> {
    let mut lines = text.split_inclusive('\n');
    let mut next = || lines.next().and_then(|l| l.strip_suffix('\n'));
    let identity =
        next().and_then(|l| l.strip_prefix("# ")).ok_or("line 1 is no `# …` that says which run it is")?;
    let columns =
        next().filter(|l| l.starts_with("index,cost,")).ok_or("line 2 does not name the columns")?;
    if !columns.ends_with(&format!(",{CHECK}")) {
        return Err(format!(
            "line 2 does not end with the column `{CHECK}`, by which rows are known to be whole"
        ));
    }
    let head = Head { identity: identity.into(), columns: columns.into() };
    let mut table = Table { head, samples: vec![], torn: vec![] };
    for (i, raw) in text.split_inclusive('\n').enumerate().skip(2) {
        match raw.strip_suffix('\n').and_then(|l| sample(l, &table.head)) {
            Some(Ok(found)) => table.samples.push(found),
            Some(Err(Changed)) => {
                return Err(format!(
                    "line {} was changed after it was written, or is of another table: its check does not fit",
                    i + 1
                ));
            }
            // another job's copy of the first two lines
            None if raw.starts_with("# ") || raw.trim_end() == columns => {}
            None => table.torn.push(i + 1),
        }
    }
    Ok(table)
}

/// A line is whole, but not as it was written.
struct Changed;

/// The sample of a line; `None` if the line is not whole.
fn sample(line: &str, head: &Head) -> Option<Result<(usize, Sample), Changed>> {
    let columns = head.columns.split(',').count();
    let cells: Vec<&str> = line.split(',').collect();
    let (row, check) = line.rsplit_once(',')?;
    if cells.len() != columns || columns <= BEFORE || check.len() != CHECK_DIGITS {
        return None;
    }
    if check != head.check(row) {
        return Some(Err(Changed));
    }
    let numbers = |cells: &[&str]| cells.iter().map(|c| c.parse::<f64>().ok()).collect::<Option<Vec<f64>>>();
    let sample = Sample {
        cost: cells[1].parse().ok()?,
        terms: numbers(&cells[2..2 + TERMS.len()])?,
        survived: cells[BEFORE - 1].parse().ok()?,
        values: numbers(&cells[BEFORE..columns - 1])?,
    };
    Some(Ok((cells[0].parse().ok()?, sample)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use controllers::PARAMETERS;

    /// Equal to the bit, also numbers that have no short decimal.
    #[test]
    fn a_table_comes_back() {
        let parameters: Vec<&Parameter> = PARAMETERS.iter().take(2).collect();
        let samples: Vec<Sample> = (0..5)
            .map(|i| Sample {
                values: vec![f64::from(i).sqrt() / 3.0, 1e-7 / 7.0 * f64::from(i)],
                cost: (f64::from(i) * 0.1).exp(),
                terms: vec![0.1 + 0.2, 1.0 / 3.0, 0.0, 1.0, f64::MIN_POSITIVE],
                survived: 3,
            })
            .collect();
        let head = Head::new("tune of x", &parameters);
        let text = head.table(samples.iter().enumerate());
        let back = read(&text).unwrap();
        assert_eq!(back.head, head);
        assert_eq!(back.head.parameters(), parameters.iter().map(|p| p.name).collect::<Vec<_>>());
        assert_eq!(back.samples, samples.iter().cloned().enumerate().collect::<Vec<_>>());
        assert!(back.torn.is_empty());
        // a job killed while it wrote
        let torn = read(&text[..text.len() - 3]).unwrap();
        assert_eq!((torn.samples.len(), torn.torn), (4, vec![7]));
        assert!(read("x\n").is_err() && read("# a\nx\n").is_err() && read("").is_err());
    }

    /// No digit of a row, and nothing of the first two lines, can be changed without being noticed; a row cut anywhere is torn.
    #[test]
    fn a_row_that_was_changed_is_refused() {
        let parameters: Vec<&Parameter> = PARAMETERS.iter().take(2).collect();
        let terms = vec![0.25, 1.0 / 3.0, 0.0, 1.0, 2.0];
        let sample = Sample { values: vec![0.5, 0.75], cost: 1.25, terms, survived: 3 };
        let text = Head::new("tune of x", &parameters).table([(0, &sample), (1, &sample)]);
        let rows = text.match_indices('\n').nth(1).unwrap().0 + 1;
        for (i, c) in text.char_indices().filter(|(_, c)| c.is_ascii_digit()) {
            let other = if c == '7' { '8' } else { '7' };
            let edited = format!("{}{other}{}", &text[..i], &text[i + 1..]);
            let e = read(&edited).unwrap_err();
            assert!(e.contains("was changed after it was written"), "{i}: {e}");
        }
        let e = read(&text.replace("tune of x", "tune of y")).unwrap_err();
        assert!(e.starts_with("line 3 "), "{e}");
        let second = rows + text[rows..].find('\n').unwrap() + 1;
        for cut in second + 1..text.len() {
            // as the next job finds it: the open line is ended
            let cut = read(&format!("{}\n", &text[..cut])).unwrap();
            assert!(cut.samples.len() == 1 && cut.torn == [4] || cut.samples.len() == 2, "{cut:?}");
        }
        assert!(read("# a\nindex,cost,survived\n").unwrap_err().contains("`check`"));
    }
}
