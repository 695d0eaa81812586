//! Which moment of a donor belongs to which moment of a base (SCF06 §4.5).
//!
//! In: postures of the base, activations of the donor in a [`StyleSet`], what to align on. Out: an [`Alignment`]: for
//! every frame of the base a time of the donor, never falling, and the donor's activations there.
//!
//! *Series.* One number a frame: how far a bone points ahead (its hip swing, for a thigh), or a component's activation; with its
//! rate of change as a second channel, so that a leg going forward is not taken for one going back. Both are brought to
//! mean 0 and variance 1 in each clip: styles differ in how far a leg swings, not in that it does.
//!
//! *Cyclic clips* (both repeat themselves in the series): the donor is stretched so that periods agree, its cycles are
//! repeated where it is shorter than the base, and the base is found as a piece of it. *Other clips*: from beginning to
//! beginning and end to end. Local slopes stay between ½ and 2 of the stretch. The path is smoothed at 1.5 Hz: a warp
//! that jerks makes motion that jerks.

use learn::dtw::{Limits, Series, align};
use motion::smooth::whittaker::{Whittaker, lambda};
use motion::{Quat, TimeMap};
use nalgebra::DMatrix;

use super::cycle::{Period, period};
use super::error::StyleError;
use super::figure::Postures;
use super::set::StyleSet;

/// Rate at which series are compared, Hz.
const RATE_HZ: f64 = 30.0;
/// The path is smoothed at this frequency, Hz.
const PATH_HZ: f64 = 1.5;
/// Half the time over which repeated cycles are blended, s.
const BLEND_S: f64 = 0.15;
/// Activations this near are those of one clip: each frame is its own partner, where a clip of equal cycles has many.
const SAME: f64 = 1e-9;
/// A bone that points ahead and back by less has no swing worth aligning on.
const LEAST_SWING: f64 = 0.05;
/// What a swing without a period counts beside the correlation of one with it.
const NO_PERIOD: f64 = 0.4;
/// A donor that has to run so many times as fast as it did is said to.
const FAST: f64 = 1.6;

/// What is aligned on.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum On {
    /// The thigh whose swing repeats itself best in both clips; where no thigh swings, the bone that does.
    #[default]
    Automatic,
    /// How far this bone points ahead.
    Bone(String),
    /// These components (indices of groups) of the set.
    Components(Vec<usize>),
    /// Times that belong together, `(base, donor)`, s: for gestures.
    Anchors(Vec<(f64, f64)>),
}

/// A donor in the time of a base. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Alignment {
    /// What was aligned on, in words.
    pub on: String,
    /// For every frame of the base, the time of the donor (its cycles repeated), s.
    pub donor_s: Vec<f64>,
    /// The donor's activations there, frames of the base × k.
    pub activations: DMatrix<f64>,
    /// Least, mean and largest rate of the donor: its seconds for each second of the base.
    pub rates: [f64; 3],
    /// What to beware of, one line each.
    pub notes: Vec<String>,
}

/// What the number of a frame is.
#[derive(Clone, Debug, PartialEq)]
enum Signal {
    /// How far a bone points ahead, −1 to 1.
    Bone(usize),
    /// The sum of these components' activations.
    Components(Vec<usize>),
}

impl Signal {
    /// Of postures with their activations, frame by frame.
    fn of(&self, set: &StyleSet, turns: &[Vec<Quat>], u: &DMatrix<f64>) -> Vec<f64> {
        match self {
            Signal::Bone(bone) => {
                let direction = set.figure.direction(*bone).unwrap_or_default();
                turns.iter().map(|t| (t[*bone] * direction).z).collect()
            }
            Signal::Components(members) => {
                (0..u.nrows()).map(|r| members.iter().map(|c| u[(r, *c)]).sum()).collect()
            }
        }
    }

    /// Of activations alone.
    fn of_activations(&self, set: &StyleSet, u: &DMatrix<f64>) -> Vec<f64> {
        match self {
            Signal::Bone(_) => self.of(set, &set.postures(u).turns, u),
            Signal::Components(_) => self.of(set, &[], u),
        }
    }
}

/// Every so many frames are compared.
fn step(rate_hz: f64) -> usize {
    ((rate_hz / RATE_HZ).round() as usize).max(1)
}

fn thinned(u: &DMatrix<f64>, step: usize) -> DMatrix<f64> {
    DMatrix::from_fn(u.nrows().div_ceil(step), u.ncols(), |r, c| u[(r * step, c)])
}

fn spread(x: &[f64]) -> f64 {
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    (x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / x.len() as f64).sqrt()
}

/// A signal of base and donor.
struct Pair {
    on: String,
    signal: Signal,
    base: Vec<f64>,
    donor: Vec<f64>,
}

impl Pair {
    fn periods(&self, base_hz: f64, donor_hz: f64) -> Option<(Period, Period)> {
        Some((period(&self.base, base_hz)?, period(&self.donor, donor_hz)?))
    }
}

/// Aligns one of the set's clips, the donor, to a base.
///
/// * `own`: activations of the base, frames × k
///
/// # Errors
/// A bone that the set does not have, anchors that are no time map, series that stand still.
pub fn aligned(
    set: &StyleSet,
    base: &Postures,
    own: &DMatrix<f64>,
    donor: usize,
    on: &On,
) -> Result<Alignment, StyleError> {
    let u = set.of_clip(donor);
    if let On::Anchors(anchors) = on {
        return by_anchors(set, base, &u, donor, anchors);
    }
    if own.shape() == u.shape() && (own - &u).amax() < SAME {
        let donor_s = (0..base.frames()).map(|f| f as f64 / base.rate_hz).collect();
        let on = "nothing: the base is the donor".to_owned();
        return Ok(finished(set, base, &u, donor_s, on, Vec::new(), donor));
    }
    let (base_step, donor_step) = (step(base.rate_hz), step(set.rate_hz));
    let (base_hz, donor_hz) = (base.rate_hz / base_step as f64, set.rate_hz / donor_step as f64);
    let (thin_own, thin_u) = (thinned(own, base_step), thinned(&u, donor_step));
    // both as the components have them, so that what these leave out does not look like a shift in time
    let (base_turns, donor_turns) = (set.postures(&thin_own).turns, set.postures(&thin_u).turns);
    let pair_of = |on: String, signal: Signal| Pair {
        base: signal.of(set, &base_turns, &thin_own),
        donor: signal.of(set, &donor_turns, &thin_u),
        on,
        signal,
    };
    let of_bone =
        |b: usize| pair_of(format!("how far {} points ahead", set.figure.bones[b].name), Signal::Bone(b));
    let pair = match on {
        On::Bone(name) => {
            let bone = set.figure.bone(name).filter(|b| set.figure.direction(*b).is_some());
            of_bone(bone.ok_or_else(|| StyleError::Bone {
                name: name.clone(),
                hint: motion::names::hint(name, set.figure.bones.iter().map(|b| b.name.as_str())),
            })?)
        }
        On::Components(groups) => {
            let members = groups.iter().flat_map(|g| set.groups[*g].iter().copied()).collect();
            let numbers: Vec<String> = groups.iter().map(|g| (g + 1).to_string()).collect();
            pair_of(format!("component {}", numbers.join(" + ")), Signal::Components(members))
        }
        On::Automatic | On::Anchors(_) => {
            let worth = |p: &Pair| {
                let least = spread(&p.base).min(spread(&p.donor));
                let repeats = p.periods(base_hz, donor_hz).map(|(a, b)| a.correlation.min(b.correlation));
                (least > LEAST_SWING, least * repeats.unwrap_or(NO_PERIOD))
            };
            let thighs = set.figure.thighs();
            let all = (0..set.figure.bones.len()).filter(|b| set.figure.direction(*b).is_some());
            let mut best: Option<((bool, bool, f64), Pair)> = None;
            for bone in all {
                let pair = of_bone(bone);
                let (swings, w) = worth(&pair);
                // steps are what feet have to keep
                let w = (swings, thighs.contains(&bone), w);
                if best.as_ref().is_none_or(|b| w > b.0) {
                    best = Some((w, pair));
                }
            }
            best.ok_or(StyleError::Still { on: "every bone".into() })?.1
        }
    };
    if spread(&pair.base) < 1e-9 || spread(&pair.donor) < 1e-9 {
        return Err(StyleError::Still { on: pair.on });
    }
    let periods = pair.periods(base_hz, donor_hz);
    let base_s = (pair.base.len() - 1) as f64 / base_hz;
    let mut notes = Vec::new();
    // the donor with its cycles repeated, and donor seconds for each base second
    let (u, series, stretch) = match periods {
        Some((b, d)) => {
            let stretch = d.seconds / b.seconds;
            let needed_s = (base_s + b.seconds) * stretch;
            let own_s = (u.nrows() - 1) as f64 / set.rate_hz;
            if own_s >= needed_s {
                (u, pair.donor.clone(), stretch)
            } else {
                let cycle = (d.seconds * set.rate_hz).round() as usize;
                let longer = repeated(&u, cycle, (needed_s * set.rate_hz).ceil() as usize, set.rate_hz);
                notes.push(format!(
                    "{} is {own_s:.1} s long and its cycles of {:.2} s are repeated to {needed_s:.1} s",
                    set.names[donor], d.seconds
                ));
                let series = pair.signal.of_activations(set, &thinned(&longer, donor_step));
                (longer, series, stretch)
            }
        }
        None => {
            let donor_s = (u.nrows() - 1) as f64 / set.rate_hz;
            (u, pair.donor.clone(), if base_s > 0.0 { donor_s / base_s } else { 1.0 })
        }
    };
    // the donor at the base's rate, its periods those of the base
    let stretched = series_at(&series, base_hz, donor_hz, stretch);
    let limits = Limits { wait: Some(1), piece: periods.is_some(), ..Limits::default() };
    // scaled by what the donor does before its cycles are repeated: a clip is then its own best partner
    let alone = series_at(&pair.donor, base_hz, donor_hz, stretch);
    let (a, b) = (two_channels(&pair.base, &pair.base), two_channels(&stretched, &alone));
    let (sa, sb) = (Series { values: &a, channels: 2 }, Series { values: &b, channels: 2 });
    let path = align(sa, sb, limits).or_else(|_| align(sa, sb, Limits { wait: None, ..limits }))?;
    let rough = path.partners_of_a();
    let smooth = Whittaker::new(rough.len(), lambda(PATH_HZ.min(0.45 * base_hz), base_hz)).smooth(&rough, 1);
    let mut rising = smooth;
    for i in 1..rising.len() {
        rising[i] = rising[i].max(rising[i - 1]);
    }
    let donor_s: Vec<f64> = (0..base.frames())
        .map(|f| beyond(&rising, f as f64 / base_step as f64) / base_hz * stretch)
        .collect();
    Ok(finished(set, base, &u, donor_s, pair.on, notes, donor))
}

fn by_anchors(
    set: &StyleSet,
    base: &Postures,
    u: &DMatrix<f64>,
    donor: usize,
    anchors: &[(f64, f64)],
) -> Result<Alignment, StyleError> {
    let times = TimeMap::with_ends(anchors, [motion::time_map::End::Free; 2])
        .map_err(|source| StyleError::Anchors { source })?;
    let donor_s = (0..base.frames()).map(|f| times.at(f as f64 / base.rate_hz)).collect();
    let on = format!("{} anchors", anchors.len());
    Ok(finished(set, base, u, donor_s, on, Vec::new(), donor))
}

fn finished(
    set: &StyleSet,
    base: &Postures,
    u: &DMatrix<f64>,
    donor_s: Vec<f64>,
    on: String,
    mut notes: Vec<String>,
    donor: usize,
) -> Alignment {
    let last = (u.nrows() - 1) as f64;
    let columns: Vec<Vec<f64>> = (0..u.ncols()).map(|c| u.column(c).iter().copied().collect()).collect();
    let activations = DMatrix::from_fn(base.frames(), u.ncols(), |r, c| {
        at(&columns[c], (donor_s[r] * set.rate_hz).clamp(0.0, last))
    });
    let rates: Vec<f64> = donor_s.windows(2).map(|w| (w[1] - w[0]) * base.rate_hz).collect();
    let mean = rates.iter().sum::<f64>() / rates.len().max(1) as f64;
    let least = rates.iter().copied().fold(f64::INFINITY, f64::min);
    let most = rates.iter().copied().fold(0.0, f64::max);
    if mean > FAST {
        notes.push(format!(
            "{} is slower than the base and runs {mean:.1} times as fast: what was easy becomes stiff",
            set.names[donor]
        ));
    }
    if most > 2.5 * mean || least < mean / 2.5 {
        notes
            .push(format!("the warp is extreme: rates of {least:.2} to {most:.2} about a mean of {mean:.2}"));
    }
    Alignment { on, donor_s, activations, rates: [least, mean, most], notes }
}

/// A value between frames, held at the ends.
fn at(x: &[f64], frame: f64) -> f64 {
    let last = (x.len() - 1) as f64;
    let frame = frame.clamp(0.0, last);
    let i = (frame.floor() as usize).min(x.len().saturating_sub(2));
    if x.len() < 2 {
        return x[0];
    }
    let s = frame - i as f64;
    x[i] * (1.0 - s) + x[i + 1] * s
}

/// A value between frames, going on with its slope beyond the last.
fn beyond(x: &[f64], frame: f64) -> f64 {
    let last = x.len() - 1;
    if frame <= last as f64 || x.len() < 2 {
        return at(x, frame);
    }
    x[last] + (x[last] - x[last - 1]) * (frame - last as f64)
}

/// A series of the donor at the base's rate, its periods those of the base.
fn series_at(x: &[f64], base_hz: f64, donor_hz: f64, stretch: f64) -> Vec<f64> {
    let count = ((x.len() - 1) as f64 / donor_hz / stretch * base_hz + 1e-9).floor() as usize + 1;
    (0..count.max(2)).map(|i| at(x, i as f64 / base_hz * stretch * donor_hz)).collect()
}

/// The series and its rate of change, as many standard deviations from the mean of `like`.
fn two_channels(x: &[f64], like: &[f64]) -> Vec<f64> {
    let slope = |x: &[f64]| -> Vec<f64> {
        let n = x.len();
        (0..n).map(|i| x[(i + 1).min(n - 1)] - x[i.saturating_sub(1)]).collect()
    };
    let scaled = |x: Vec<f64>, like: &[f64]| -> Vec<f64> {
        let mean = like.iter().sum::<f64>() / like.len() as f64;
        let by = spread(like).max(1e-12);
        x.into_iter().map(|v| (v - mean) / by).collect()
    };
    let values = scaled(x.to_vec(), like);
    let slopes = scaled(slope(x), &slope(like));
    values.into_iter().zip(slopes).flat_map(|(a, b)| [a, b]).collect()
}

/// Frames whose whole cycles are repeated until there are `needed`, blended where they meet.
fn repeated(u: &DMatrix<f64>, cycle: usize, needed: usize, rate_hz: f64) -> DMatrix<f64> {
    let n = u.nrows();
    let blend = ((BLEND_S * rate_hz).round() as usize).min(n / 8).max(1);
    let cycle = cycle.clamp(1, n - 1);
    let away = |i: usize, j: usize| (u.row(i) - u.row(j)).norm();
    // from j on, it goes on as from i on: j as late as can be, i whole cycles before, within a sixth of one
    let j = n - 1 - blend;
    let whole = (j.saturating_sub(blend) / cycle).max(1) * cycle;
    let ideal = j.saturating_sub(whole).max(blend);
    let reach = cycle / 6;
    let i = (ideal.saturating_sub(reach).max(blend)..=(ideal + reach).min(j - 1).max(blend))
        .min_by(|a, b| away(*a, j).total_cmp(&away(*b, j)))
        .unwrap_or(ideal);
    let length = (j - i).max(1);
    let mut rows: Vec<nalgebra::RowDVector<f64>> = (0..j - blend).map(|r| u.row(r).into_owned()).collect();
    while rows.len() < needed {
        for b in 0..2 * blend {
            let s = (b as f64 + 0.5) / (2 * blend) as f64;
            let s = s * s * (3.0 - 2.0 * s);
            let (old, new) = (j - blend + b, i - blend + b);
            rows.push(u.row(old.min(n - 1)) * (1.0 - s) + u.row(new) * s);
        }
        let from = i + blend;
        let to = (i + length).saturating_sub(blend).max(from + 1);
        rows.extend((from..to.min(n)).map(|r| u.row(r).into_owned()));
    }
    DMatrix::from_rows(&rows)
}
