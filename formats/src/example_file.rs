//! Learned edits as `.edit`: a zip of numpy arrays and one text.
//!
//! In: an [`ExampleEdit`]. Out: an uncompressed zip; and back: the same examples and kernels to the bit, from which the same model is
//! made. Same edit, same bytes. `numpy.load` reads the arrays; `words.ron` holds what is no array. Reading trusts nothing.
//!
//! Layout (`n` examples, `i` inputs, `o` outputs; [`edits::by_example`] says what they are):
//!
//! | array | shape | holds |
//! |---|---|---|
//! | `configuration_inputs`, `acceleration_inputs` | n × i | features |
//! | `configuration_targets`, `acceleration_targets` | n × o | differences; their second derivatives |
//! | `configuration_mirror`, `acceleration_mirror` | i × 2 | index and sign of each coordinate of a mirrored input; absent if not mirrored |
//! | `outputs_mirror` | o × 2 | the same of outputs |
//! | `moments` | n × 2 | pair, time (ms): examples of one pair that are close in time do not count as neighbours |
//! | `frames` | n × 2 | pair, frame |
//!
//! `words.ron`: the rig by names, options, names of the pairs, kernels.

use std::io::{self, Cursor, Read, Seek, Write};
use std::path::Path;

use edits::ExampleEdit;
use edits::by_example::rig::RigFile;
use edits::by_example::{ExampleError, ExampleFrame, ExampleOptions, Taught};
use learn::{Examples, FitError, Mirror, Moment, RbfKernel};
use motion::file::read_within;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::limits::EDIT_BYTES;
use crate::trace_npz::{Arrays, ArraysIn, TraceFileError};

/// Why a file is no learned edit.
#[derive(Debug, Error)]
pub enum ExampleFileError {
    /// The file system said no.
    #[error("cannot read it: {0}")]
    Io(#[from] io::Error),
    /// Something that is not there.
    #[error("no learned edit: `{0}` is missing; allowed: a file of `contrapposto propagate train`")]
    Missing(&'static str),
    /// An array that is not as it must be.
    #[error("no learned edit: {0}")]
    Array(#[from] TraceFileError),
    /// Words that make no sense.
    #[error("words.ron in it: {0}")]
    Words(String),
    /// A number that is none of those allowed.
    #[error("`{array}` in it has {found}; allowed: {allowed}")]
    Value {
        /// Which array.
        array: &'static str,
        /// What was found.
        found: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Examples that are none.
    #[error("the examples in it: {0}")]
    Examples(#[from] FitError),
    /// Parts that do not fit each other.
    #[error(transparent)]
    Edit(#[from] ExampleError),
}

/// What is no array.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "Edit")]
struct Words {
    rig: RigFile,
    options: ExampleOptions,
    pairs: Vec<String>,
    apart_ms: u32,
    kernels: Option<(RbfKernel, RbfKernel)>,
}

const WORDS: &str = "words.ron";
/// Of configurations and of accelerations.
const INPUTS: [&str; 2] = ["configuration_inputs", "acceleration_inputs"];
const TARGETS: [&str; 2] = ["configuration_targets", "acceleration_targets"];
const MIRRORS: [&str; 2] = ["configuration_mirror", "acceleration_mirror"];
const OUTPUTS: &str = "outputs_mirror";

/// Writes an edit.
///
/// # Errors
/// Of the writer.
pub fn write<W: Write + Seek>(edit: &ExampleEdit, out: W) -> io::Result<()> {
    let mut npz = Arrays::new(out);
    let taught = edit.taught();
    npz.file(WORDS, words(edit, &taught).as_bytes())?;
    for (k, of) in taught.iter().enumerate() {
        // stored row by row
        let mut matrix = |name, m: &DMatrix<f64>| npz.table(name, m.ncols(), m.transpose().as_slice());
        matrix(INPUTS[k], of.examples.inputs())?;
        matrix(TARGETS[k], of.examples.targets())?;
        let Some(mirror) = of.examples.mirror() else { continue };
        let signed = |map: &[(usize, f64)]| -> Vec<f64> {
            map.iter().flat_map(|(index, sign)| [*index as f64, *sign]).collect()
        };
        npz.table(MIRRORS[k], 2, &signed(&mirror.input))?;
        if k == 0 {
            npz.table(OUTPUTS, 2, &signed(&mirror.output))?;
        }
    }
    let moments = taught[0].examples.moments().unwrap_or_default();
    let moments: Vec<f64> = moments.iter().flat_map(|m| [f64::from(m.clip), f64::from(m.frame)]).collect();
    npz.table("moments", 2, &moments)?;
    let frames: Vec<f64> = edit.frames.iter().flat_map(|f| [f.pair as f64, f.frame as f64]).collect();
    npz.table("frames", 2, &frames)?;
    npz.finish()
}

/// The bytes of an edit.
pub fn bytes(edit: &ExampleEdit) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    write(edit, &mut out).expect("memory can be written to");
    out.into_inner()
}

fn words(edit: &ExampleEdit, taught: &[Taught; 2]) -> String {
    let words = Words {
        rig: edit.rig.clone(),
        options: edit.options.clone(),
        pairs: edit.pairs.clone(),
        apart_ms: edits::by_example::rows::APART_MS,
        kernels: taught[0].kernel.zip(taught[1].kernel),
    };
    let pretty = ron::ser::PrettyConfig::new().struct_names(true);
    let text = ron::ser::to_string_pretty(&words, pretty).expect("words are plain values");
    format!("// An edit learned from examples. The arrays beside this text are for numpy.load.\n{text}\n")
}

/// Reads an edit.
///
/// # Errors
/// [`ExampleFileError`]: what was found, what is allowed.
pub fn read<R: Read + Seek>(input: R) -> Result<ExampleEdit, ExampleFileError> {
    let mut npz = ArraysIn::new(input)?;
    let text = npz.file(WORDS).ok_or(ExampleFileError::Missing(WORDS))?;
    let text = String::from_utf8(text).map_err(|e| ExampleFileError::Words(e.to_string()))?;
    let words: Words = ron::from_str(&text).map_err(|e| ExampleFileError::Words(e.to_string()))?;
    if let Some(missing) =
        INPUTS.iter().chain(&TARGETS).chain(&["moments", "frames"]).find(|name| !npz.has(name))
    {
        return Err(ExampleFileError::Missing(missing));
    }
    let counts = |npz: &mut ArraysIn<R>, name| -> Result<Vec<[u32; 2]>, ExampleFileError> {
        let m = table(npz, name)?;
        let whole = |x: f64| (x >= 0.0 && x <= f64::from(u32::MAX) && x.fract() == 0.0).then_some(x as u32);
        let allowed = "two whole numbers from 0 on a row";
        let fault = |found| ExampleFileError::Value { array: name, found, allowed };
        if m.ncols() != 2 {
            return Err(fault(format!("{} numbers a row", m.ncols())));
        }
        (0..m.nrows())
            .map(|r| match (whole(m[(r, 0)]), whole(m[(r, 1)])) {
                (Some(a), Some(b)) => Ok([a, b]),
                _ => Err(fault(format!("({}, {}) in row {r}", m[(r, 0)], m[(r, 1)]))),
            })
            .collect()
    };
    let moments: Vec<Moment> =
        counts(&mut npz, "moments")?.iter().map(|m| Moment { clip: m[0], frame: m[1] }).collect();
    let frames: Vec<ExampleFrame> = counts(&mut npz, "frames")?
        .iter()
        .map(|f| ExampleFrame { pair: f[0] as usize, frame: f[1] as usize })
        .collect();
    let mirrored = npz.has(OUTPUTS);
    let mut taught = |k: usize| -> Result<Taught, ExampleFileError> {
        let (inputs, targets) = (table(&mut npz, INPUTS[k])?, table(&mut npz, TARGETS[k])?);
        let mirror = match mirrored {
            true => Some(Mirror { input: signed(&mut npz, MIRRORS[k])?, output: signed(&mut npz, OUTPUTS)? }),
            false => None,
        };
        let examples =
            Examples::new(inputs, targets, mirror)?.with_moments(moments.clone(), words.apart_ms)?;
        let kernel = words.kernels.map(|(a, b)| if k == 0 { a } else { b });
        Ok(Taught { examples, kernel })
    };
    let taught = [taught(0)?, taught(1)?];
    Ok(ExampleEdit::stored(words.rig, words.options, words.pairs, frames, taught)?)
}

/// [`read`] of a file.
///
/// # Errors
/// As [`read`], and of the file system.
pub fn open(path: &Path) -> Result<ExampleEdit, ExampleFileError> {
    read(Cursor::new(read_within(path, EDIT_BYTES)?))
}

/// A matrix of any shape.
fn table<R: Read + Seek>(
    npz: &mut ArraysIn<R>,
    name: &'static str,
) -> Result<DMatrix<f64>, ExampleFileError> {
    let (shape, array) = npz.array(name)?;
    let [rows, columns] = shape[..] else {
        let found = format!("shape {shape:?}");
        return Err(ExampleFileError::Value { array: name, found, allowed: "rows and columns" });
    };
    let all = array.into_reals().map_err(|_| ExampleFileError::Value {
        array: name,
        found: "other numbers".into(),
        allowed: "64-bit reals",
    })?;
    Ok(DMatrix::from_row_slice(rows, columns, &all))
}

/// A signed permutation; that it is one is checked by [`Examples::new`].
fn signed<R: Read + Seek>(
    npz: &mut ArraysIn<R>,
    name: &'static str,
) -> Result<Vec<(usize, f64)>, ExampleFileError> {
    if !npz.has(name) {
        return Err(ExampleFileError::Missing(name));
    }
    let m = table(npz, name)?;
    let good = m.ncols() == 2 && (0..m.nrows()).all(|r| m[(r, 0)] >= 0.0 && m[(r, 0)].fract() == 0.0);
    if !good {
        let found = format!("shape {:?}, or an index that is none", m.shape());
        return Err(ExampleFileError::Value { array: name, found, allowed: "an index and a sign a row" });
    }
    Ok((0..m.nrows()).map(|r| (m[(r, 0)] as usize, m[(r, 1)])).collect())
}

#[cfg(test)]
mod tests {
    use edits::by_example::{Outputs, Pair};
    use motion::Clip;
    use motion::rotation::{Vec3, exp};

    use super::*;

    fn edit(estimator: learn::ExampleMethod, outputs: Outputs) -> (ExampleEdit, Clip) {
        let human = bodies::anthropometry::human::human().0;
        let s = human.skeleton.clone();
        let clip = |bend: f64| {
            let q = (0..60).flat_map(|f| {
                let mut q = human.rest.clone();
                let swing = (f as f64 * 0.3).sin();
                for link in 1..s.links().len() {
                    if matches!(s.links()[link].joint, motion::Joint::Spherical) {
                        let turn = Vec3::new(bend + 0.2 * swing, 0.1 * swing * link as f64, 0.0);
                        s.set_rotation(&mut q, link, &exp(&turn));
                    }
                }
                q
            });
            Clip::new(s.clone(), 30.0, q.collect())
        };
        let options = ExampleOptions { estimator, outputs, ..ExampleOptions::default() };
        let pair = Pair::new("bend", clip(0.0), clip(0.2));
        (ExampleEdit::learn(&[pair], &options).expect("a pair"), clip(0.05))
    }

    /// What is read answers as what was written, to the bit, and its bytes are the same.
    #[test]
    fn an_edit_comes_back_to_the_bit() {
        let differences = learn::ExampleMethod::ALL.map(|m| (m, Outputs::Differences));
        for (estimator, outputs) in
            differences.into_iter().chain([(learn::ExampleMethod::Gp, Outputs::Poses)])
        {
            let (edit, clip) = edit(estimator, outputs);
            let bytes = bytes(&edit);
            let back = read(Cursor::new(&bytes)).expect("an edit");
            assert_eq!(super::bytes(&back), bytes, "{estimator}");
            assert_eq!(back.options.outputs, outputs);
            assert_eq!(back.answer(&clip).expect("the rig"), edit.answer(&clip).expect("the rig"));
        }
    }

    /// Damaged files are errors, wherever they are cut; parts of another edit are named.
    #[test]
    fn damaged_files_are_refused() {
        let (edit, _) = edit(learn::ExampleMethod::Gp, Outputs::Differences);
        let whole = bytes(&edit);
        for at in (0..whole.len()).step_by(whole.len() / 40) {
            assert!(read(Cursor::new(&whole[..at])).is_err(), "cut at {at}");
        }
        let empty = read(Cursor::new(b"PK\x05\x06\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0")).expect_err("empty");
        assert!(empty.to_string().contains("`words.ron` is missing"), "{empty}");
        let mut fewer = edit.clone();
        fewer.frames.pop();
        let said = read(Cursor::new(bytes(&fewer))).expect_err("an example less").to_string();
        assert!(said.contains("examples × inputs × outputs are"), "{said}");
    }
}
