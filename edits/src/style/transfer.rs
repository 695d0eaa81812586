//! Style from one motion in another (SCF06 §4.5, 4.6).
//!
//! In: a [`StyleSet`], a base [`Motion`], a [`Transfer`]: whose style, which components, how much of each. Out: the
//! base with
//!
//! ```text
//! x′ = x + Σ_i a_i P A e_i (u_donor,i(s(t)) − u_base,i(t))
//! ```
//!
//! `s` the alignment, `a_i` the amounts, 0 (the base) to 1.5. What the components do not explain stays the base's, so that
//! amount 0 is the base and the base's own components change nothing. Activations of a base that was not decomposed are its
//! projection.
//!
//! *Afterwards*: the change is low-passed (warped activations have corners; of a donor that has to run n times as fast as it did, at an
//! n-th of the frequency), bone lengths are restored ([`super::representation`]), the way over the ground and the heading are the base's,
//! the pelvis turns about the vertical as in the base, for it turns with the steps, and feet go the base's way by two-bone IK
//! (`steps`), the root lowered where a leg would be too short.

use std::collections::BTreeMap;

use motion::names::Word;
use motion::smooth::whittaker::{Whittaker, lambda};
use motion::time_map::End;
use motion::{Quat, TimeMap, Vec3};
use nalgebra::DMatrix;

use super::align::{On, aligned};
use super::error::StyleError;
use super::figure::{Match, Postures};
use super::set::{StyleSet, said};
use super::steps;
use crate::feet;
use crate::param::Instant;
use crate::{Edited, Motion, Parameter};

/// Whose timing the result has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Timing {
    /// The base's: the donor is warped.
    #[default]
    Base,
    /// The donor's: the base is warped, with its way over the ground.
    Donor,
}

impl Word for Timing {
    const KIND: &'static str = "timing";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Base, "base", "Of the motion that is changed"),
        (Self::Donor, "donor", "Of the motion that the style is taken from"),
    ];
}

/// Most that is transferred: one and a half times the donor's style.
pub const MOST: f64 = 1.5;

/// An amount at a time of the base, s: a constant, or a curve over time.
fn amount_at(amount: &Parameter, time_s: f64) -> f64 {
    amount.at(&Instant { time_s, repetition: 0, pose: 0 })
}

/// # Errors
/// Amounts outside 0 to 1.5, knots out of order, amounts that are not of time.
fn check_amount(amount: &Parameter) -> Result<(), StyleError> {
    let all: Vec<f64> = match amount {
        Parameter::Constant(x) => vec![*x],
        Parameter::OverTime(knots) => {
            let rising = knots.windows(2).all(|w| w[0].0 < w[1].0);
            if knots.is_empty() || !rising || knots.iter().any(|k| !k.0.is_finite()) {
                return Err(StyleError::Knots);
            }
            knots.iter().map(|k| k.1).collect()
        }
        Parameter::OverRepetition(_) | Parameter::PerPose(_) => return Err(StyleError::Knots),
    };
    match all.into_iter().find(|x| !(0.0..=MOST).contains(x)) {
        Some(value) => Err(StyleError::Amount { value }),
        None => Ok(()),
    }
}

/// What is transferred. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Transfer {
    /// Whose style: which clip of the set, 0 or 1.
    pub donor: usize,
    /// Components (indices of groups) with their amounts.
    pub components: Vec<(usize, Parameter)>,
    /// What is aligned on.
    pub on: On,
    /// Whose timing.
    pub timing: Timing,
    /// The change is low-passed here, Hz; of a donor that runs n times as fast as it did, at an n-th of it.
    pub cutoff_hz: f64,
}

/// Cut-off of the change where none is said, Hz.
pub const CUTOFF_HZ: f64 = 6.0;
/// At the ends of a span inside a clip the change comes and goes over this time, s.
const FADE_S: f64 = 0.4;

impl Transfer {
    /// The components that tell the clips apart, all with one amount, aligned automatically in the base's timing.
    pub fn of(set: &StyleSet, donor: usize, amount: f64) -> Self {
        let components = set.clear().into_iter().map(|c| (c, Parameter::Constant(amount))).collect();
        Transfer { donor, components, on: On::Automatic, timing: Timing::Base, cutoff_hz: CUTOFF_HZ }
    }

    /// The same with these components (indices of groups), all with one amount.
    pub fn only(self, components: &[usize], amount: f64) -> Self {
        Transfer {
            components: components.iter().map(|c| (*c, Parameter::Constant(amount))).collect(),
            ..self
        }
    }
}

/// A motion with style, and what there is to say of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Styled {
    /// The motion.
    pub edited: Edited,
    /// What was done and what to beware of, one line each.
    pub notes: Vec<String>,
}

/// Transfers style. `span_s`: where in the base, s. `names`: bones of the set and what the base calls them.
///
/// # Errors
/// Amounts out of range, components or bones the set does not have, skeletons that cannot be matched, legs that IK cannot
/// solve.
pub fn transfer(
    set: &StyleSet,
    motion: &Motion,
    how: &Transfer,
    span_s: (f64, f64),
    names: &BTreeMap<String, String>,
) -> Result<Styled, StyleError> {
    for (component, amount) in &how.components {
        check_amount(amount)?;
        if *component >= set.components() {
            return Err(StyleError::Component { found: component + 1, most: set.components() });
        }
    }
    if !(how.cutoff_hz > 0.0 && how.cutoff_hz.is_finite()) {
        return Err(StyleError::Cutoff { value: how.cutoff_hz });
    }
    if motion.clip.frames() < 2 {
        return Err(StyleError::Short { name: "the base".into(), frames: motion.clip.frames() });
    }
    let floor_m = motion.floor_m.unwrap_or_else(|| feet::lowest(&motion.clip));
    let matched = Match::of(&set.figure, &motion.clip.skeleton, names)?;
    let mut notes: Vec<String> = said("the base", &set.names[0], &matched).into_iter().collect();
    let mut base = Postures::of(&motion.clip, &set.figure, &matched, floor_m);
    let mut channels = set.coding.encode(&set.figure, &base);
    let mut own = set.project(&channels.own);
    let mut alignment = aligned(set, &base, &own, how.donor, &how.on)?;
    let mut edited = Edited::unchanged(motion);
    let mut span_s = span_s;
    if how.timing == Timing::Donor {
        let times = donors_time(&alignment.donor_s, base.rate_hz)?;
        edited = Edited::retimed(motion, times.clone());
        span_s = (times.at(span_s.0), times.at(span_s.1));
        base = Postures::of(&edited.clip, &set.figure, &matched, floor_m);
        channels = set.coding.encode(&set.figure, &base);
        own = set.project(&channels.own);
        alignment = aligned(set, &base, &own, how.donor, &how.on)?;
    }
    let [least, mean, most] = alignment.rates;
    notes.push(format!(
        "aligned on {}; {} runs {mean:.2} times as fast as it was ({least:.2} to {most:.2})",
        alignment.on, set.names[how.donor]
    ));
    notes.append(&mut alignment.notes);

    let clip = &edited.clip;
    let (frames, rate_hz) = (clip.frames(), clip.rate_hz);
    let end_s = clip.duration_s();
    let back = edited.times.inverse();
    let mut change = DMatrix::zeros(frames, own.ncols());
    for (component, amount) in &how.components {
        for f in 0..frames {
            let t = f as f64 / rate_hz;
            let a = amount_at(amount, back.at(t)) * within(t, span_s, end_s);
            for &i in &set.groups[*component] {
                change[(f, i)] += a * (alignment.activations[(f, i)] - own[(f, i)]);
            }
        }
    }
    smoothed(&mut change, how.cutoff_hz / mean.max(1.0), rate_hz);
    channels.own += &change * set.mixing.transpose();
    channels.carried += &change * set.carried_mixing.transpose();
    let mut styled = base.clone();
    set.coding.decode(&set.figure, &channels, &mut styled.turns, &mut styled.height);
    if !edited.contacts.contacts().is_empty() && !set.figure.thighs().is_empty() {
        for (styled, base) in styled.turns.iter_mut().zip(&base.turns) {
            let by = yaw(&base[0]) - yaw(&styled[0]);
            styled[0] = motion::rotation::exp(&(Vec3::y() * by)) * styled[0];
        }
    }
    let before = edited.clip.clone();
    styled.write(&mut edited.clip, &matched, floor_m);
    notes.extend(steps::keep(&before, &edited.contacts, &mut edited.clip)?);
    Ok(Styled { edited, notes })
}

/// How far a turn turns what points to the left about the vertical, rad.
fn yaw(turn: &Quat) -> f64 {
    let left = turn * Vec3::x();
    (-left.z).atan2(left.x)
}

/// How much of a change acts at a time: all inside the span, coming and going at ends that are not the clip's.
fn within(t: f64, (from, to): (f64, f64), end_s: f64) -> f64 {
    let rise = |x: f64| motion::smoothstep(x.clamp(0.0, 1.0));
    let begins = if from <= 1e-9 { 1.0 } else { rise((t - from) / FADE_S) };
    let ends = if to >= end_s - 1e-9 { 1.0 } else { rise((to - t) / FADE_S) };
    begins.min(ends)
}

/// Low-passes every column; columns of zeros stay zeros to the bit.
fn smoothed(m: &mut DMatrix<f64>, cutoff_hz: f64, rate_hz: f64) {
    if m.nrows() < 4 || cutoff_hz >= 0.45 * rate_hz {
        return;
    }
    let smoother = Whittaker::new(m.nrows(), lambda(cutoff_hz, rate_hz));
    for mut column in m.column_iter_mut() {
        let path: Vec<f64> = column.iter().copied().collect();
        if path.iter().all(|x| *x == 0.0) {
            continue;
        }
        column.copy_from_slice(&smoother.smooth(&path, 1));
    }
}

/// The map from the base's time to the donor's, an anchor every quarter of a second.
fn donors_time(donor_s: &[f64], rate_hz: f64) -> Result<TimeMap, StyleError> {
    let every = ((0.25 * rate_hz).round() as usize).max(1);
    let last = donor_s.len() - 1;
    let mut frames: Vec<usize> = (0..last).step_by(every).collect();
    if frames.len() > 1 && last - frames[frames.len() - 1] < every / 2 {
        frames.pop();
    }
    frames.push(last);
    let anchors: Vec<(f64, f64)> =
        frames.iter().map(|f| (*f as f64 / rate_hz, donor_s[*f] - donor_s[0])).collect();
    TimeMap::with_ends(&anchors, [End::Free; 2]).map_err(|source| StyleError::Anchors { source })
}
