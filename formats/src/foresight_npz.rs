//! Offsets of targets that foresight chose, as numpy arrays, written and read.
//!
//! | array | shape | holds |
//! |---|---|---|
//! | `input` | 1 | number of what they were found for, sixteen hexadecimal digits |
//! | `rate_hz` | 1 | rows per second |
//! | `joint` | channels | link of each joint |
//! | `axis` | channels | axis of its zero frame; 0 for hinges |
//! | `offset` | rows × channels | rad (m for slides), from the first step on |

use std::io::{self, BufWriter, Cursor};
use std::path::Path;

use motion::file::read_within;

use crate::TraceFileError;
use crate::limits::TRACE_BYTES;
use crate::trace_npz::{Arrays, ArraysIn};

/// Offsets on file. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Offsets {
    /// Number of what they were found for.
    pub input: u64,
    /// Rows per second, Hz.
    pub rate_hz: f64,
    /// Link of each joint that was moved.
    pub joints: Vec<String>,
    /// Its axis.
    pub axes: Vec<usize>,
    /// Offsets, `rows × channels`.
    pub offsets: Vec<f64>,
}

/// Writes offsets to a file.
///
/// # Errors
/// Of the file system.
pub fn save(offsets: &Offsets, path: &Path) -> io::Result<()> {
    let mut npz = Arrays::new(BufWriter::new(std::fs::File::create(path)?));
    let joints: Vec<&str> = offsets.joints.iter().map(String::as_str).collect();
    npz.text("input", &[1], &[&format!("{:016x}", offsets.input)])?;
    npz.numbers("rate_hz", &[1], &[offsets.rate_hz])?;
    npz.text("joint", &[joints.len() as u64], &joints)?;
    npz.indices("axis", offsets.axes.iter().copied())?;
    npz.table("offset", joints.len(), &offsets.offsets)?;
    npz.finish()
}

/// Reads offsets of a file.
///
/// # Errors
/// [`TraceFileError`]: arrays that are missing or of another shape, numbers that are not finite.
pub fn open(path: &Path) -> Result<Offsets, TraceFileError> {
    let mut npz = ArraysIn::new(Cursor::new(read_within(path, TRACE_BYTES)?))?;
    let fault = |array: &'static str, fault: &str| TraceFileError::Array { array, fault: fault.into() };
    let input = npz.texts("input", &[1])?.swap_remove(0);
    let input = u64::from_str_radix(&input, 16)
        .map_err(|_| fault("input", "no number; allowed: sixteen hexadecimal digits"))?;
    let rate_hz = npz.reals("rate_hz", &[1])?[0];
    let joints = npz.list("joint")?;
    let axes = npz.integers("axis", &[joints.len()])?;
    let axes =
        axes.into_iter().map(|a| usize::try_from(a).ok().filter(|a| *a < 3)).collect::<Option<Vec<_>>>();
    let axes = axes.ok_or_else(|| fault("axis", "no axis; allowed: 0, 1, 2"))?;
    let (shape, array) = npz.array("offset")?;
    if shape.len() != 2 || shape[1] != joints.len() {
        let allowed = vec![shape.first().copied().unwrap_or(0), joints.len()];
        return Err(TraceFileError::Shape { array: "offset", found: shape, allowed });
    }
    let offsets = array.into_reals().map_err(|why| fault("offset", &why))?;
    if !offsets.iter().all(|x| x.is_finite()) {
        return Err(fault("offset", "a number that is not finite"));
    }
    Ok(Offsets { input, rate_hz, joints, axes, offsets })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is written is read back to the bit; a table of another width is refused.
    #[test]
    fn offsets_are_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("foresight.npz");
        let offsets = Offsets {
            input: 0x0123_4567_89AB_CDEF,
            rate_hz: 240.0,
            joints: vec!["hip".into(), "hip".into(), "knee".into()],
            axes: vec![0, 2, 0],
            offsets: vec![0.1, -0.2, 1.0 / 3.0, 0.0, 1e-9, -2.5],
        };
        save(&offsets, &path).unwrap();
        assert_eq!(open(&path).unwrap(), offsets);
        let narrow = Offsets { joints: vec!["hip".into()], axes: vec![0], ..offsets.clone() };
        save(&narrow, &path).unwrap();
        assert_eq!(open(&path).unwrap().offsets, offsets.offsets);
        save(&Offsets { offsets: vec![f64::NAN; 3], ..offsets }, &path).unwrap();
        assert!(open(&path).unwrap_err().to_string().contains("not finite"));
    }
}
