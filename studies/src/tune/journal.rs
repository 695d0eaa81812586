//! Samples as a table: the state of a search on disk, and the result of a sweep.
//!
//! In: samples and what identifies the run. Out: CSV text with one line per sample, and back, equal to the bit (numbers are
//! written with as many digits as they need). The first line is a comment, `# ` and the run's identity; the second
//! names the columns: `index`, `cost`, the terms, `survived`, then the parameters in their units.

use std::fmt::Write as _;

use controllers::Parameter;

use super::search::Sample;
use scenes::tune_spec::TERMS;

/// Columns before the parameters.
const BEFORE: usize = 3 + TERMS.len();

/// The line of column names.
pub fn head(parameters: &[&Parameter]) -> String {
    let mut names = vec!["index", "cost"];
    names.extend(TERMS);
    names.push("survived");
    names.extend(parameters.iter().map(|p| p.name));
    names.join(",")
}

/// Names of the parameters in a line of column names.
pub fn parameters_of(head: &str) -> Vec<&str> {
    head.split(',').skip(BEFORE).collect()
}

/// One line, without its end.
pub fn line(index: usize, s: &Sample) -> String {
    let mut text = format!("{index},{}", s.cost);
    for x in &s.terms {
        let _ = write!(text, ",{x}");
    }
    let _ = write!(text, ",{}", s.survived);
    for x in &s.values {
        let _ = write!(text, ",{x}");
    }
    text
}

/// A whole table.
pub fn table(identity: &str, parameters: &[&Parameter], samples: &[Sample]) -> String {
    let mut text = format!("# {identity}\n{}\n", head(parameters));
    for (i, s) in samples.iter().enumerate() {
        text += &line(i, s);
        text.push('\n');
    }
    text
}

/// A table read back.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// What the first line says.
    pub identity: String,
    /// The second line.
    pub head: String,
    /// Index and sample of every whole line, in the order of the file.
    pub samples: Vec<(usize, Sample)>,
    /// Lines that are not whole, such as the last one of a job that was killed: their numbers, from 1.
    pub torn: Vec<usize>,
}

/// Reads a table. A line that is not whole is listed in `torn`, not an error: a job may have been killed while it wrote.
///
/// # Errors
/// What the first two lines should be.
pub fn read(text: &str) -> Result<Table, String> {
    let mut lines = text.split_inclusive('\n');
    let mut next = || lines.next().and_then(|l| l.strip_suffix('\n'));
    let identity =
        next().and_then(|l| l.strip_prefix("# ")).ok_or("line 1 is no `# …` that says which run it is")?;
    let head = next().filter(|l| l.starts_with("index,cost,")).ok_or("line 2 does not name the columns")?;
    let mut table = Table { identity: identity.into(), head: head.into(), samples: vec![], torn: vec![] };
    let columns = head.split(',').count();
    for (i, raw) in text.split_inclusive('\n').enumerate().skip(2) {
        match raw.strip_suffix('\n').and_then(|l| sample(l, columns)) {
            Some(found) => table.samples.push(found),
            // another job's copy of the first two lines
            None if raw.starts_with("# ") || raw.trim_end() == head => {}
            None => table.torn.push(i + 1),
        }
    }
    Ok(table)
}

fn sample(line: &str, columns: usize) -> Option<(usize, Sample)> {
    let cells: Vec<&str> = line.split(',').collect();
    if cells.len() != columns || columns < BEFORE {
        return None;
    }
    let numbers = |cells: &[&str]| cells.iter().map(|c| c.parse::<f64>().ok()).collect::<Option<Vec<f64>>>();
    let sample = Sample {
        cost: cells[1].parse().ok()?,
        terms: numbers(&cells[2..2 + TERMS.len()])?,
        survived: cells[BEFORE - 1].parse().ok()?,
        values: numbers(&cells[BEFORE..])?,
    };
    Some((cells[0].parse().ok()?, sample))
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
        let text = table("tune of x", &parameters, &samples);
        let back = read(&text).unwrap();
        assert_eq!(back.identity, "tune of x");
        assert_eq!(back.samples, samples.iter().cloned().enumerate().collect::<Vec<_>>());
        assert!(back.torn.is_empty());
        // a job killed while it wrote
        let torn = read(&text[..text.len() - 3]).unwrap();
        assert_eq!((torn.samples.len(), torn.torn), (4, vec![7]));
        assert!(read("x\n").is_err() && read("# a\nx\n").is_err() && read("").is_err());
    }
}
