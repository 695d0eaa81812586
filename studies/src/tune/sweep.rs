//! Sweeps: a grid of parameters, costed sample by sample, split over jobs.
//!
//! In: axes `NAME=FROM..TO:N`, a shard `i/n`. Out: one line of CSV per sample, keyed by its index in the whole grid.
//!
//! The last axis runs fastest. Shard i of n (from 1) has every n-th sample, from the i-th on, so that dear corners of the grid
//! are spread over the jobs. Lines are appended whole, by one write each to a file opened for appending: jobs on one
//! machine may share a file. A job that is run again skips what the file has; a line torn by a kill is costed anew.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::str::FromStr;

use controllers::{PARAMETERS, Parameter, parameter};
use rayon::prelude::*;
use takes::results::folder::{FolderError, Overwrite, write_file};

use super::cost::Cost;
use super::journal::{self, Head, Table};
use super::search::Sample;

/// Why there is no sweep.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SweepError {
    /// A text that is no axis.
    #[error("`{0}` is no axis; allowed: NAME=FROM..TO:N, such as shift=0.2..0.8:7")]
    Axis(String),
    /// A parameter that does not exist.
    #[error("unknown parameter `{name}`{hint}")]
    Name {
        /// What was asked for.
        name: String,
        /// What exists.
        hint: String,
    },
    /// A range that is empty or leaves the parameter's.
    #[error("{name}={from}..{to}:{n}: {why}")]
    Range {
        /// The parameter.
        name: String,
        /// From.
        from: String,
        /// To.
        to: String,
        /// Points.
        n: usize,
        /// What is wrong, and what is allowed.
        why: String,
    },
    /// A text that is no shard.
    #[error("`{0}` is no shard; allowed: i/n with i from 1 to n, such as 3/8")]
    Shard(String),
    /// A file of another sweep.
    #[error(
        "{path} is of another sweep\n  found:  {found}\n  needed: {needed}\n  help: --fresh begins anew, --out takes another folder"
    )]
    Other {
        /// The file.
        path: String,
        /// What its first line says.
        found: String,
        /// What it should say.
        needed: String,
    },
    /// One sample with two results.
    #[error(
        "sample {index} has two costs, {a} and {b}, in {path}: the files are of different programs or scenes"
    )]
    Contradiction {
        /// The sample.
        index: usize,
        /// One.
        a: String,
        /// The other.
        b: String,
        /// Where the second was found.
        path: String,
    },
    /// A file that is no table of a sweep, or not as it was written.
    #[error("{path}: {why}\n  help: --fresh begins anew, --out takes another folder")]
    Table {
        /// The file.
        path: String,
        /// What is wrong.
        why: String,
    },
    /// A file that a table would replace.
    #[error(
        "{path} is no table of a sweep and would be replaced; give another folder with --out, or move it away"
    )]
    Foreign {
        /// The file.
        path: String,
    },
    /// Files.
    #[error("{path}: {why}")]
    File {
        /// The file.
        path: String,
        /// What is wrong.
        why: String,
    },
}

impl SweepError {
    /// Whether the fault lies in the input rather than in the run.
    pub fn is_input(&self) -> bool {
        !matches!(self, Self::File { .. })
    }
}

/// The most samples of a grid.
pub const MOST_SAMPLES: usize = 1_000_000;

/// One axis of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// What varies.
    pub parameter: &'static Parameter,
    /// First value.
    pub from: f64,
    /// Last value.
    pub to: f64,
    /// Values, evenly spaced (by ratio for a parameter of ratios).
    pub points: usize,
}

impl FromStr for Axis {
    type Err = SweepError;

    fn from_str(text: &str) -> Result<Self, SweepError> {
        let bad = || SweepError::Axis(text.into());
        let (name, range) = text.split_once('=').ok_or_else(bad)?;
        let (range, n) = range.rsplit_once(':').ok_or_else(bad)?;
        let (from, to) = range.split_once("..").ok_or_else(bad)?;
        let n: usize = n.trim().parse().map_err(|_| bad())?;
        let (a, b): (f64, f64) = match (from.trim().parse(), to.trim().parse()) {
            (Ok(a), Ok(b)) => (a, b),
            _ => return Err(bad()),
        };
        let name = name.trim();
        let Some(p) = parameter(name) else {
            let hint = motion::names::hint(name, PARAMETERS.iter().map(|p| p.name));
            return Err(SweepError::Name { name: name.into(), hint });
        };
        let fault = |why: String| SweepError::Range {
            name: name.into(),
            from: from.trim().into(),
            to: to.trim().into(),
            n,
            why,
        };
        if !p.allows(a) || !p.allows(b) {
            return Err(fault(format!("allowed: values from {} to {}", p.lo, p.hi)));
        }
        match n {
            0 => Err(fault("the range is empty; allowed: at least 1 point".into())),
            1 if a != b => Err(fault("one point needs FROM equal to TO; allowed: 2 or more points".into())),
            n if n > 1 && a >= b => Err(fault("the range is empty; allowed: FROM below TO".into())),
            points => Ok(Self { parameter: p, from: a, to: b, points }),
        }
    }
}

impl Axis {
    /// The value of a point.
    fn at(&self, i: usize) -> f64 {
        if i + 1 == self.points && i > 0 {
            return self.to;
        }
        let (a, b) = (self.parameter.part(self.from), self.parameter.part(self.to));
        if i == 0 { self.from } else { self.parameter.at(a + (b - a) * i as f64 / (self.points - 1) as f64) }
    }
}

/// A grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Its axes; the last runs fastest.
    pub axes: Vec<Axis>,
}

impl Grid {
    /// A grid; of two axes of one parameter the second is at fault.
    ///
    /// # Errors
    /// A parameter twice, or more than [`MOST_SAMPLES`].
    pub fn new(axes: Vec<Axis>) -> Result<Self, SweepError> {
        for (i, axis) in axes.iter().enumerate() {
            let fault = |why: String| SweepError::Range {
                name: axis.parameter.name.into(),
                from: axis.from.to_string(),
                to: axis.to.to_string(),
                n: axis.points,
                why,
            };
            if axes[..i].iter().any(|a| a.parameter == axis.parameter) {
                return Err(fault("the parameter is swept twice".into()));
            }
            let samples = axes[..=i].iter().try_fold(1_usize, |n, a| n.checked_mul(a.points));
            if samples.is_none_or(|n| n > MOST_SAMPLES) {
                return Err(fault(format!("the grid is too large; allowed: up to {MOST_SAMPLES} samples")));
            }
        }
        Ok(Self { axes })
    }

    /// Parameters of the axes.
    pub fn parameters(&self) -> Vec<&'static Parameter> {
        self.axes.iter().map(|a| a.parameter).collect()
    }

    /// Samples.
    pub fn len(&self) -> usize {
        self.axes.iter().map(|a| a.points).product()
    }

    /// Whether it has no axis: one sample, the scene's own.
    pub fn is_empty(&self) -> bool {
        self.axes.is_empty()
    }

    /// Values of a sample.
    pub fn values(&self, index: usize) -> Vec<f64> {
        let mut rest = index;
        let mut values: Vec<f64> = self
            .axes
            .iter()
            .rev()
            .map(|axis| {
                let value = axis.at(rest % axis.points);
                rest /= axis.points;
                value
            })
            .collect();
        values.reverse();
        values
    }

    /// The first line of its table.
    pub fn identity(&self, scene: &str, digest: &str) -> String {
        let axes: Vec<String> = self
            .axes
            .iter()
            .map(|a| format!("{}={}..{}:{}", a.parameter.name, a.from, a.to, a.points))
            .collect();
        let samples = self.len();
        format!("{IDENTITY} {scene}: {} samples={samples} input={digest}", axes.join(" "))
    }
}

/// How what a table is of begins.
const IDENTITY: &str = "contrapposto sweep of";
/// How a table begins.
const OPENING: &str = "# contrapposto sweep of ";

/// Samples of the whole grid, by the first line of its table; `None` if that is none of a sweep.
pub fn samples_of(identity: &str) -> Option<usize> {
    let identity = identity.strip_prefix(IDENTITY)?;
    identity.split(' ').find_map(|word| word.strip_prefix("samples="))?.parse().ok()
}

/// A part of a grid: the `i`-th of `n`, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which.
    pub i: usize,
    /// Of how many.
    pub n: usize,
}

impl Shard {
    /// All of it.
    pub const WHOLE: Self = Self { i: 1, n: 1 };

    /// Its samples of a grid of `len`.
    pub fn samples(self, len: usize) -> impl Iterator<Item = usize> {
        (self.i - 1..len).step_by(self.n)
    }
}

impl FromStr for Shard {
    type Err = SweepError;

    fn from_str(text: &str) -> Result<Self, SweepError> {
        let read = || {
            let (i, n) = text.split_once('/')?;
            Some(Self { i: i.trim().parse().ok()?, n: n.trim().parse().ok()? })
        };
        read().filter(|s| s.i >= 1 && s.i <= s.n).ok_or_else(|| SweepError::Shard(text.into()))
    }
}

fn file_error(path: &Path) -> impl Fn(io::Error) -> SweepError + '_ {
    move |e| SweepError::File { path: path.display().to_string(), why: e.to_string() }
}

/// Reads a table of a sweep; with `identity`, only of that one.
///
/// # Errors
/// Files that cannot be read, that are no table or another sweep's.
pub fn read(path: &Path, identity: Option<&str>) -> Result<Table, SweepError> {
    let mut text = String::new();
    File::open(path).and_then(|mut f| f.read_to_string(&mut text)).map_err(file_error(path))?;
    let shown = path.display().to_string();
    let table = journal::read(&text).map_err(|why| SweepError::Table { path: shown.clone(), why })?;
    let found = table.head.identity.clone();
    if let Some(needed) = identity.filter(|needed| **needed != *found) {
        return Err(SweepError::Other { path: shown, found, needed: needed.into() });
    }
    let Some(samples) = samples_of(&found) else {
        let why = format!("no table of a sweep: line 1 is `{found}`");
        return Err(SweepError::Table { path: shown, why });
    };
    match table.samples.iter().find(|(index, _)| *index >= samples) {
        None => Ok(table),
        Some((index, _)) => {
            let why = format!("sample {index} of a sweep of {samples} samples, which count from 0");
            Err(SweepError::Table { path: shown, why })
        }
    }
}

/// Removes the table of an earlier sweep, if there is one.
///
/// # Errors
/// A file that is no table of a sweep: nobody's work is removed by its name. Of the file system.
pub fn forget(path: &Path) -> Result<(), SweepError> {
    if !path.exists() {
        return Ok(());
    }
    check_replaceable(path)?;
    std::fs::remove_file(path).map_err(file_error(path))
}

/// Tells whether what is at a path may be replaced by a table of a sweep: nothing, or one.
///
/// # Errors
/// As [`forget`].
pub fn check_replaceable(path: &Path) -> Result<(), SweepError> {
    if !path.exists() {
        return Ok(());
    }
    let mut text = Vec::new();
    File::open(path)
        .and_then(|f| f.take(OPENING.len() as u64).read_to_end(&mut text))
        .map_err(file_error(path))?;
    match text == OPENING.as_bytes() {
        true => Ok(()),
        false => Err(SweepError::Foreign { path: path.display().to_string() }),
    }
}

/// Samples costed together before their lines are written: no thread waits long, and little is lost by a kill.
const TOGETHER: usize = 16;

/// Costs the samples of a shard that the file does not have yet and appends them. Returns how many those were.
///
/// # Errors
/// Files that cannot be read or written, or another sweep's.
pub fn run(
    cost: &Cost,
    grid: &Grid,
    shard: Shard,
    identity: &str,
    path: &Path,
    progress: &mut dyn FnMut(f64),
) -> Result<usize, SweepError> {
    let head = Head::new(identity, &grid.parameters());
    begin(path, &head)?;
    let table = read(path, Some(identity))?;
    let have: BTreeMap<usize, &Sample> = table.samples.iter().map(|(i, s)| (*i, s)).collect();
    let missing: Vec<usize> = shard.samples(grid.len()).filter(|i| !have.contains_key(i)).collect();
    let mut file = OpenOptions::new().append(true).read(true).open(path).map_err(file_error(path))?;
    close_torn_line(&mut file).map_err(file_error(path))?;
    for (k, together) in missing.chunks(TOGETHER).enumerate() {
        let found: Vec<Sample> = together
            .par_iter()
            .with_max_len(1)
            .map(|&i| {
                let names = grid.axes.iter().map(|a| a.parameter.name);
                let mut sample = cost.evaluate(&cost.with_named(names.zip(grid.values(i))));
                sample.values = grid.values(i);
                sample
            })
            .collect();
        for (i, sample) in together.iter().zip(&found) {
            // one write call per line, so that lines of several jobs do not mix
            file.write_all((head.line(*i, sample) + "\n").as_bytes()).map_err(file_error(path))?;
        }
        file.sync_data().map_err(file_error(path))?;
        progress((((k + 1) * TOGETHER) as f64 / missing.len() as f64).min(1.0));
    }
    Ok(missing.len())
}

/// Makes the file with its first two lines, unless it is there: whole, and by one of several jobs only.
fn begin(path: &Path, head: &Head) -> Result<(), SweepError> {
    if path.exists() {
        return Ok(());
    }
    match write_file(path, head.table([]).as_bytes(), Overwrite::Refuse, &[]) {
        // another job has begun it meanwhile
        Ok(()) | Err(FolderError::Exists { .. }) => Ok(()),
        Err(e) => Err(SweepError::File { path: path.display().to_string(), why: e.to_string() }),
    }
}

/// Ends a line that a killed job left open, so that the next one begins anew.
fn close_torn_line(file: &mut File) -> io::Result<()> {
    let length = file.seek(SeekFrom::End(0))?;
    if length == 0 {
        return Ok(());
    }
    file.seek(SeekFrom::Start(length - 1))?;
    let mut last = [0];
    file.read_exact(&mut last)?;
    if last[0] == b'\n' { Ok(()) } else { file.write_all(b"\n") }
}

/// Samples of several tables of one sweep, by index. A sample may be in several, if they agree.
///
/// # Errors
/// Tables of different sweeps, samples with two results, files that cannot be read.
pub fn merge(paths: &[impl AsRef<Path>]) -> Result<(Table, BTreeMap<usize, Sample>), SweepError> {
    let mut first: Option<Table> = None;
    let mut all: BTreeMap<usize, Sample> = BTreeMap::new();
    for path in paths {
        let path = path.as_ref();
        let table = read(path, first.as_ref().map(|t| t.head.identity.as_str()))?;
        for (index, sample) in &table.samples {
            let have = all.entry(*index).or_insert_with(|| sample.clone());
            if have != sample {
                return Err(SweepError::Contradiction {
                    index: *index,
                    a: have.cost.to_string(),
                    b: sample.cost.to_string(),
                    path: path.display().to_string(),
                });
            }
        }
        first.get_or_insert(table);
    }
    let table = first.ok_or_else(|| SweepError::File { path: "--merge".into(), why: "no file".into() })?;
    Ok((table, all))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(text: &str) -> Axis {
        text.parse().unwrap()
    }

    /// Shards have every sample once, whatever their number.
    #[test]
    fn shards_are_a_partition() {
        for (len, n) in [(12, 1), (12, 5), (3, 7), (1, 1)] {
            let mut all: Vec<usize> = (1..=n).flat_map(|i| Shard { i, n }.samples(len)).collect();
            all.sort_unstable();
            assert_eq!(all, (0..len).collect::<Vec<_>>());
        }
    }

    #[test]
    fn grids_run_through_all_values() {
        let grid = Grid::new(vec![axis("shift=0.2..0.8:3"), axis("tension=0.5..2:3")]).unwrap();
        assert_eq!(grid.len(), 9);
        let ends = [grid.values(0), grid.values(8)];
        assert_eq!(ends, [vec![0.2, 0.5], vec![0.8, 2.0]]);
        let middle = grid.values(4);
        // the range of tension is spaced by ratios
        assert!((middle[0] - 0.5).abs() < 1e-12 && (middle[1] - 1.0).abs() < 1e-12, "{middle:?}");
        assert_eq!(grid.values(1)[0], 0.2);
        assert_eq!(axis("shift=0.4..0.4:1").at(0), 0.4);
    }

    #[test]
    fn bad_axes_and_shards_are_told() {
        for (text, words) in [
            ("shift", "is no axis"),
            ("shift=0..1", "is no axis"),
            ("shift=a..1:3", "is no axis"),
            ("shft=0..1:3", "did you mean `shift`?"),
            ("nonsense=0..1:3", "there are: tension, shift,"),
            ("shift=0..1:0", "empty"),
            ("shift=0..1:1", "one point"),
            ("shift=0.8..0.2:4", "FROM below TO"),
            ("shift=0.2..7:4", "allowed: values from 0 to 1.2"),
            ("shift=NaN..1:4", "allowed: values from 0 to 1.2"),
        ] {
            let e = text.parse::<Axis>().unwrap_err().to_string();
            assert!(e.contains(words), "{text}: {e}");
        }
        let twice = Grid::new(vec![axis("shift=0..1:3"), axis("shift=0..1:2")]).unwrap_err();
        assert!(twice.to_string().contains("swept twice"), "{twice}");
        let large = Grid::new(vec![axis("shift=0..1:3000"), axis("pressure=0..1:3000")]).unwrap_err();
        assert!(large.to_string().contains("up to 1000000 samples"), "{large}");
        for text in ["", "0/3", "4/3", "1", "-1/3", "1/0", "a/b"] {
            let e = text.parse::<Shard>().unwrap_err().to_string();
            assert!(e.contains("i from 1 to n"), "{e}");
        }
        assert_eq!("3/3".parse(), Ok(Shard { i: 3, n: 3 }));
    }
}
