//! Sets of style components as `.style`: a zip of numpy arrays and one text.
//!
//! In: a [`StyleSet`]. Out: an uncompressed zip; and back, equal to the bit. Same set, same bytes. `numpy.load` reads the
//! arrays; `words.ron` is for people and holds what is no number. Reading trusts nothing: see [`StyleFileError`].
//!
//! Layout (`k` components, `n` frames of both clips, `c` channels, `r` channels that ride along, `b` bones, in [`edits::style`]):
//!
//! | array | shape | holds |
//! |---|---|---|
//! | `mean`, `mixing`, `unmixing` | c, c × k, c × k | E{x}; P A; from x − E{x} to u |
//! | `carried_mean`, `carried_mixing` | r, r × k | the same of what rides along |
//! | `activations` | n × k | u; the first clip's frames, then the second's |
//! | `rotation`, `start` | k × k | W and W₀: the whitened data are `activations @ rotation` |
//! | `agreement` | k | how well other starts find each component again |
//! | `frames` | 2 | frames of each clip |
//! | `rate_hz`, `explained`, `leg_m` | scalar | Hz; share of the variance; height of the root in the zero pose, m |
//! | `bone_name`, `bone_parent`, `bone_offset`, `bone_end` | b, b, b × 3, b × 3 | text; −1 of the root; m, zero pose that faces +Z; NaN without an end |
//! | `center` | b × 4 | mean rotation of each joint, quaternion `w x y z` |
//!
//! `words.ron`: names of the clips, representation, method, contrast, groups of merged components (from 1), whether and how
//! the decomposition came to rest, notes; each component in words, as comments.

use std::io::{self, Cursor, Read, Seek, Write};
use std::path::Path;

use edits::style::figure::{Bone, Figure};
use edits::style::representation::Coding;
use edits::style::set::Trust;
use edits::style::{Representation, StyleSet};
use learn::ica::{Contrast, Method};
use motion::file::read_within;
use motion::names::Word;
use motion::skeleton::quat_at;
use motion::{Joint, Link, Skeleton, SkeletonError, Vec3};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::limits::STYLE_BYTES;
use crate::trace_npz::{Arrays, ArraysIn, TraceFileError};

/// Why a file is no set of style components.
#[derive(Debug, Error)]
pub enum StyleFileError {
    /// The file system said no.
    #[error("cannot read it: {0}")]
    Io(#[from] io::Error),
    /// An array that is not there, or the text.
    #[error(
        "no set of style components: `{0}` is missing; allowed: a file of `contrapposto style decompose`"
    )]
    Missing(&'static str),
    /// An array that is not as it must be.
    #[error("no set of style components: {0}")]
    Array(#[from] TraceFileError),
    /// Words that make no sense.
    #[error("words.ron in it: {0}")]
    Words(String),
    /// Parts that do not fit each other.
    #[error("the set in it has {what} {found}; allowed: {allowed}")]
    Value {
        /// Which part.
        what: &'static str,
        /// What was found.
        found: String,
        /// What is allowed.
        allowed: String,
    },
    /// Bones that cannot be.
    #[error("the bones in it: {0}")]
    Bones(#[from] SkeletonError),
}

/// What is no number.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "Style")]
struct Words {
    clips: (String, String),
    representation: String,
    method: String,
    contrast: String,
    groups: Vec<Vec<usize>>,
    converged: bool,
    steps: usize,
    converged_starts: (usize, usize),
    notes: Vec<String>,
}

const WORDS: &str = "words.ron";
const ARRAYS: [&str; 17] = [
    "mean",
    "mixing",
    "unmixing",
    "carried_mean",
    "carried_mixing",
    "activations",
    "rotation",
    "start",
    "agreement",
    "frames",
    "rate_hz",
    "explained",
    "leg_m",
    "bone_name",
    "bone_parent",
    "bone_offset",
    "bone_end",
];

/// Writes a set.
///
/// # Errors
/// Of the writer.
pub fn write<W: Write + Seek>(set: &StyleSet, out: W) -> io::Result<()> {
    pack(set, &words(set), out)
}

fn pack<W: Write + Seek>(set: &StyleSet, words: &str, out: W) -> io::Result<()> {
    let mut npz = Arrays::new(out);
    let matrix = |npz: &mut Arrays<W>, name: &str, m: &DMatrix<f64>| {
        // stored row by row
        npz.table(name, m.ncols(), m.transpose().as_slice())
    };
    let vector = |npz: &mut Arrays<W>, name: &str, v: &[f64]| npz.numbers(name, &[v.len() as u64], v);
    npz.file(WORDS, words.as_bytes())?;
    vector(&mut npz, "mean", set.mean.as_slice())?;
    matrix(&mut npz, "mixing", &set.mixing)?;
    matrix(&mut npz, "unmixing", &set.unmixing)?;
    vector(&mut npz, "carried_mean", set.carried_mean.as_slice())?;
    matrix(&mut npz, "carried_mixing", &set.carried_mixing)?;
    matrix(&mut npz, "activations", &set.activations)?;
    matrix(&mut npz, "rotation", &set.rotation)?;
    matrix(&mut npz, "start", &set.start)?;
    vector(&mut npz, "agreement", &set.trust.agreement)?;
    npz.indices("frames", set.frames.into_iter())?;
    npz.numbers("rate_hz", &[], &[set.rate_hz])?;
    npz.numbers("explained", &[], &[set.explained])?;
    npz.numbers("leg_m", &[], &[set.figure.leg_m])?;
    let bones = &set.figure.bones;
    let names: Vec<&str> = bones.iter().map(|b| b.name.as_str()).collect();
    npz.text("bone_name", &[bones.len() as u64], &names)?;
    let parents: Vec<i64> = bones.iter().map(|b| b.parent.map_or(-1, |p| p as i64)).collect();
    npz.numbers("bone_parent", &[bones.len() as u64], &parents)?;
    let offsets: Vec<f64> = bones.iter().flat_map(|b| b.offset.iter().copied().collect::<Vec<_>>()).collect();
    npz.table("bone_offset", 3, &offsets)?;
    let none = Vec3::repeat(f64::NAN);
    let ends: Vec<f64> =
        bones.iter().flat_map(|b| b.end.unwrap_or(none).iter().copied().collect::<Vec<_>>()).collect();
    npz.table("bone_end", 3, &ends)?;
    let center: Vec<f64> = set.coding.center.iter().flat_map(|q| [q.w, q.i, q.j, q.k]).collect();
    npz.table("center", 4, &center)?;
    npz.finish()
}

/// The bytes of a set.
pub fn bytes(set: &StyleSet) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    write(set, &mut out).expect("memory can be written to");
    out.into_inner()
}

fn words(set: &StyleSet) -> String {
    let name =
        |all: &[(Contrast, &'static str)]| all.iter().find(|x| x.0 == set.found_by.0).map_or("", |x| x.1);
    let words = Words {
        clips: (set.names[0].clone(), set.names[1].clone()),
        representation: set.coding.representation.word().into(),
        method: Method::NAMES.iter().find(|x| x.0 == set.found_by.1).map_or("", |x| x.1).into(),
        contrast: name(&Contrast::NAMES).into(),
        groups: set.groups.iter().map(|g| g.iter().map(|i| i + 1).collect()).collect(),
        converged: set.trust.converged,
        steps: set.trust.steps,
        converged_starts: set.trust.converged_starts,
        notes: set.notes.clone(),
    };
    let mut text =
        String::from("// Style components of two clips. The arrays beside this text are for numpy.load.\n");
    for c in 0..set.components() {
        text += &format!("// {}: {}\n", c + 1, set.words(c));
    }
    let pretty = ron::ser::PrettyConfig::new().struct_names(true);
    text + &ron::ser::to_string_pretty(&words, pretty).expect("words are plain values") + "\n"
}

/// Reads a set.
///
/// # Errors
/// [`StyleFileError`]: what was found, what is allowed.
pub fn read<R: Read + Seek>(input: R) -> Result<StyleSet, StyleFileError> {
    let mut npz = ArraysIn::new(input)?;
    if let Some(missing) = ARRAYS.iter().chain(&["center"]).find(|name| !npz.has(name)) {
        return Err(StyleFileError::Missing(missing));
    }
    let text = npz.file(WORDS).ok_or(StyleFileError::Missing(WORDS))?;
    let text = String::from_utf8(text).map_err(|e| StyleFileError::Words(e.to_string()))?;
    let words: Words = ron::from_str(&text).map_err(|e| StyleFileError::Words(e.to_string()))?;
    let representation =
        Representation::find(&words.representation).map_err(|e| StyleFileError::Words(e.to_string()))?;
    let figure = figure(&mut npz)?;
    let bones = figure.bones.len();
    let center = npz.reals("center", &[bones, 4])?;
    for (bone, q) in center.chunks_exact(4).enumerate() {
        let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length.is_nan() || (length - 1.0).abs() >= 1e-9 {
            return Err(value("center of bone", bone, format!("of length {length}"), "a unit quaternion"));
        }
    }
    let center = center.chunks_exact(4).map(|q| quat_at(q, 0)).collect();
    let coding = Coding { representation, center };
    let (c, r) = coding.widths(&figure);
    let frames = npz.integers("frames", &[2])?;
    let frames: Vec<usize> = frames.iter().filter_map(|f| usize::try_from(*f).ok()).collect();
    let [first, second] = frames[..] else {
        return Err(value("frames", 0, "below 0".into(), "two counts"));
    };
    let (shape, _) = npz.array("activations")?;
    let k = shape.get(1).copied().unwrap_or(0);
    let n = first.checked_add(second).filter(|n| *n >= 2 && first > 0 && second > 0 && k > 0);
    let n = n.ok_or_else(|| {
        value("frames", 0, format!("{first} and {second}, {k} components"), "at least one each")
    })?;
    let mut matrix = |name, rows, columns| -> Result<DMatrix<f64>, StyleFileError> {
        let all = npz.reals(name, &[rows, columns])?;
        finite(name, &all)?;
        Ok(DMatrix::from_row_slice(rows, columns, &all))
    };
    let mixing = matrix("mixing", c, k)?;
    let unmixing = matrix("unmixing", c, k)?;
    let carried_mixing = matrix("carried_mixing", r, k)?;
    let activations = matrix("activations", n, k)?;
    let rotation = matrix("rotation", k, k)?;
    let start = matrix("start", k, k)?;
    let mut vector = |name, count: usize| -> Result<Vec<f64>, StyleFileError> {
        let all = npz.reals(name, &[count])?;
        finite(name, &all)?;
        Ok(all)
    };
    let mean = DVector::from_vec(vector("mean", c)?);
    let carried_mean = DVector::from_vec(vector("carried_mean", r)?);
    let agreement = vector("agreement", k)?;
    let (rate_hz, explained) = (npz.reals("rate_hz", &[])?[0], npz.reals("explained", &[])?[0]);
    if !(rate_hz > 1e-3 && rate_hz < 1e6) {
        return Err(value("rate", 0, format!("{rate_hz} Hz"), "0.001 to 1e6 Hz"));
    }
    if !(explained > 0.0 && explained <= 1.0 + 1e-9) {
        return Err(value("share of the variance", 0, explained.to_string(), "above 0 and at most 1"));
    }
    let mut members: Vec<usize> = words.groups.iter().flatten().copied().collect();
    members.sort_unstable();
    if members != (1..=k).collect::<Vec<_>>() || words.groups.iter().any(Vec::is_empty) {
        let allowed = format!("each of 1 to {k} once");
        return Err(StyleFileError::Value { what: "groups", found: format!("{:?}", words.groups), allowed });
    }
    let contrast = Contrast::NAMES.iter().find(|x| x.1 == words.contrast);
    let contrast = contrast.ok_or_else(|| StyleFileError::Words(format!("contrast `{}`", words.contrast)))?.0;
    let method = Method::NAMES.iter().find(|x| x.1 == words.method);
    let method = method.ok_or_else(|| StyleFileError::Words(format!("method `{}`", words.method)))?.0;
    Ok(StyleSet {
        figure,
        coding,
        rate_hz,
        names: [words.clips.0, words.clips.1],
        frames: [first, second],
        mean,
        mixing,
        unmixing,
        carried_mean,
        carried_mixing,
        rotation,
        start,
        found_by: (contrast, method),
        activations,
        groups: words.groups.iter().map(|g| g.iter().map(|i| i - 1).collect()).collect(),
        explained,
        trust: Trust {
            converged: words.converged,
            steps: words.steps,
            converged_starts: words.converged_starts,
            agreement,
        },
        notes: words.notes,
    })
}

/// [`read`] of a file.
///
/// # Errors
/// As [`read`], and of the file system.
pub fn open(path: &Path) -> Result<StyleSet, StyleFileError> {
    read(Cursor::new(read_within(path, STYLE_BYTES)?))
}

fn figure<R: Read + Seek>(npz: &mut ArraysIn<R>) -> Result<Figure, StyleFileError> {
    let names = npz.list("bone_name")?;
    let n = names.len();
    let parents = npz.integers("bone_parent", &[n])?;
    let offsets = npz.vectors("bone_offset", &[n, 3])?;
    let ends = npz.vectors("bone_end", &[n, 3])?;
    let leg_m = npz.reals("leg_m", &[])?[0];
    if !(leg_m > 0.0 && leg_m.is_finite()) {
        return Err(value("height of the root", 0, format!("{leg_m} m"), "above 0"));
    }
    let mut bones = Vec::with_capacity(n);
    for (i, name) in names.into_iter().enumerate() {
        let parent = match parents[i] {
            -1 => None,
            p => Some(
                usize::try_from(p).map_err(|_| value("parent of bone", i, p.to_string(), "-1 or a bone"))?,
            ),
        };
        let end = Some(ends[i]).filter(|e| e.iter().all(|x| x.is_finite()));
        bones.push(Bone { name, parent, offset: offsets[i], end });
    }
    // the checks that every skeleton passes
    let links = bones.iter().map(|b| {
        let joint = if b.parent.is_none() { Joint::Free } else { Joint::Spherical };
        Link { end: b.end, ..Link::new(b.name.clone(), b.parent, b.offset, joint) }
    });
    Skeleton::new(links.collect())?;
    Ok(Figure { bones, leg_m })
}

fn value(what: &'static str, index: usize, found: String, allowed: &str) -> StyleFileError {
    let found = if index > 0 { format!("{index}: {found}") } else { found };
    StyleFileError::Value { what, found, allowed: allowed.into() }
}

fn finite(name: &'static str, all: &[f64]) -> Result<(), StyleFileError> {
    match all.iter().position(|x| !x.is_finite()) {
        Some(i) => Err(StyleFileError::Value {
            what: name,
            found: format!("{} as number {i}", all[i]),
            allowed: "finite numbers".into(),
        }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use edits::style::{Example, StyleOptions};
    use learn::ica::{Count, IcaOptions};
    use motion::Clip;
    use motion::rotation::exp;

    use super::*;

    fn set(representation: Representation) -> StyleSet {
        let human = bodies::anthropometry::human::human().0;
        let s = human.skeleton.clone();
        let clip = |lean: f64, hz: f64| {
            let q = (0..90).flat_map(|f| {
                let mut q = human.rest.clone();
                let t = f as f64 / 30.0 * std::f64::consts::TAU * hz;
                s.set_rotation(
                    &mut q,
                    0,
                    &exp(&Vec3::new(lean + 0.1 * t.sin(), 0.2 * (2.0 * t).cos().powi(3), 0.0)),
                );
                q
            });
            Clip::new(s.clone(), 30.0, q.collect())
        };
        let (a, b, none) = (clip(0.0, 0.7), clip(0.4, 1.1), BTreeMap::new());
        let example = |name, clip| Example { name, clip, floor_m: 0.0, names: &none };
        let ica = IcaOptions { count: Count::Number(2), ..IcaOptions::default() };
        let options = StyleOptions { representation, ica, principal: false };
        StyleSet::of(example("up\"right", &a), example("leaning", &b), &options).expect("two clips")
    }

    /// What is read is what was written, to the bit, and so are its bytes.
    #[test]
    fn a_set_comes_back_to_the_bit() {
        for representation in [Representation::Positions, Representation::Tangent, Representation::Euler] {
            let set = set(representation).merged(&[0, 1]);
            let bytes = bytes(&set);
            let back = read(Cursor::new(&bytes)).expect("a set");
            assert_eq!(back, set);
            assert_eq!(super::bytes(&back), bytes);
        }
    }

    /// Damaged files are errors that say what is wrong, wherever they are cut.
    #[test]
    fn damaged_files_are_refused() {
        let set = set(Representation::Positions);
        let whole = bytes(&set);
        for at in (0..whole.len()).step_by(whole.len() / 60) {
            assert!(read(Cursor::new(&whole[..at])).is_err(), "cut at {at}");
        }
        let said = |set: &StyleSet, words: &str| {
            let mut out = Cursor::new(Vec::new());
            pack(set, words, &mut out).expect("memory");
            read(out).expect_err("broken").to_string()
        };
        let broken = |change: fn(&mut StyleSet)| {
            let mut other = set.clone();
            change(&mut other);
            said(&other, &words(&set))
        };
        assert_eq!(
            broken(|s| s.mixing[(3, 0)] = f64::NAN),
            format!(
                "the set in it has mixing NaN as number {}; allowed: finite numbers",
                3 * set.mixing.ncols()
            )
        );
        assert!(broken(|s| s.mean = DVector::zeros(5)).contains("array `mean` has shape [5]"));
        assert!(
            broken(|s| s.figure.bones[2].parent = Some(9)).contains("parents come before their children")
        );
        assert!(
            broken(
                |s| s.coding.center[1] = motion::Quat::new_unchecked(nalgebra::Quaternion::identity() * 2.0)
            )
            .contains("unit quaternion")
        );
        let groups = set.merged(&[0, 1]);
        assert!(
            said(&set, &words(&set).replace("[\n            2,", "[\n            7,"))
                .contains("allowed: each of 1 to 2 once")
        );
        assert!(said(&groups, &words(&groups).replace("tanh", "tan")).contains("contrast `tan`"));
        let trace = read(Cursor::new(b"PK\x05\x06\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0")).expect_err("empty");
        assert!(trace.to_string().contains("`mean` is missing"), "{trace}");
    }
}
