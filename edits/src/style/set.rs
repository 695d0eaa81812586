//! A set of style components: what two clips do, taken apart (SCF06 §4.1–4.4).
//!
//! In: two clips. Out: a [`StyleSet`]: the mean E{x} of the joined clip, and components with what one unit of each does
//! to every channel (P A) and how strong it is in every frame of both clips (u). It is all that is needed to put a
//! component into any clip.
//!
//! Components come in the order in which they tell the two clips apart, best first; number 1 is the first. Each is a
//! motion ([`StyleSet::component`]), `x^i = E{x} + P A (u^i e_i)`, and several merged are one
//! ([`StyleSet::merged`], equation 4): a group of components that is chosen, seen and weighted together.

use std::collections::BTreeMap;

use learn::ica::{Contrast, Ica, IcaOptions, Method, fit, whiten};
use motion::Clip;
use nalgebra::{DMatrix, DVector};

use super::error::StyleError;
use super::figure::{Figure, Match, Postures};
use super::representation::{Channels, Coding, Representation};
use super::separate::{Separation, separate};

/// A clip to be decomposed.
#[derive(Clone, Copy, Debug)]
pub struct Example<'a> {
    /// What it is called in words and files.
    pub name: &'a str,
    /// The clip.
    pub clip: &'a Clip,
    /// Height of its floor, m.
    pub floor_m: f64,
    /// Bones of the first clip and what this one calls them, where the names differ.
    pub names: &'a BTreeMap<String, String>,
}

/// How two clips are decomposed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StyleOptions {
    /// What is decomposed.
    pub representation: Representation,
    /// Independent components: how many, how, from which starts.
    pub ica: IcaOptions,
    /// Principal components instead, for comparison.
    pub principal: bool,
}

/// How far a decomposition can be trusted.
#[derive(Clone, Debug, PartialEq)]
pub struct Trust {
    /// Whether the start that was kept came to rest.
    pub converged: bool,
    /// Its steps.
    pub steps: usize,
    /// Starts that came to rest, of how many.
    pub converged_starts: (usize, usize),
    /// For each component the mean |correlation| with which the other starts find it again.
    pub agreement: Vec<f64>,
}

/// Style components of two clips. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct StyleSet {
    /// The bones that positions are of: those of the first clip.
    pub figure: Figure,
    /// How postures become numbers.
    pub coding: Coding,
    /// Rate of the activations, Hz.
    pub rate_hz: f64,
    /// Names of the two clips.
    pub names: [String; 2],
    /// Frames of each in [`StyleSet::activations`].
    pub frames: [usize; 2],
    /// E{x}.
    pub mean: DVector<f64>,
    /// What one unit of a component does to the channels: P A, channels × k.
    pub mixing: DMatrix<f64>,
    /// From a frame less its mean to activations, channels × k.
    pub unmixing: DMatrix<f64>,
    /// Mean of the channels that ride along.
    pub carried_mean: DVector<f64>,
    /// What one unit of a component does to them.
    pub carried_mixing: DMatrix<f64>,
    /// W, from whitened data to components, k × k: `u W` is the whitened data.
    pub rotation: DMatrix<f64>,
    /// W₀, the start of the fixed point, k × k.
    pub start: DMatrix<f64>,
    /// The nonlinearity and the method that were used.
    pub found_by: (Contrast, Method),
    /// u, frames of the first clip and then of the second × k.
    pub activations: DMatrix<f64>,
    /// Components that are one: every component is in one group. Indices from 0.
    pub groups: Vec<Vec<usize>>,
    /// Share of the variance that the components explain together, 0 to 1.
    pub explained: f64,
    /// How far it can be trusted.
    pub trust: Trust,
    /// What had to be done to the clips, and what to beware of, one line each.
    pub notes: Vec<String>,
}

impl StyleSet {
    /// Decomposes two clips; the second is brought onto the first one's bones and rate.
    ///
    /// # Errors
    /// Clips of fewer than two frames, skeletons that cannot be matched, data that cannot be decomposed.
    pub fn of(a: Example, b: Example, options: &StyleOptions) -> Result<Self, StyleError> {
        for e in [a, b] {
            if e.clip.frames() < 2 {
                return Err(StyleError::Short { name: e.name.into(), frames: e.clip.frames() });
            }
        }
        let figure = Figure::of(&a.clip.skeleton);
        let mut notes = Vec::new();
        let mut postures = Vec::new();
        for e in [a, b] {
            let resampled;
            let mut clip = e.clip;
            if clip.rate_hz != a.clip.rate_hz {
                notes.push(format!(
                    "{} is resampled from {} Hz to {} Hz",
                    e.name, clip.rate_hz, a.clip.rate_hz
                ));
                resampled = clip.resample(a.clip.rate_hz);
                clip = &resampled;
                if clip.frames() < 2 {
                    return Err(StyleError::Short { name: e.name.into(), frames: clip.frames() });
                }
            }
            let matched = Match::of(&figure, &clip.skeleton, e.names)?;
            notes.extend(said(e.name, a.name, &matched));
            postures.push(Postures::of(clip, &figure, &matched, e.floor_m));
        }
        notes.push(headings(a.name, &postures[0], b.name, &postures[1]));
        let coding = Coding::of(options.representation, &figure, &[&postures[0], &postures[1]]);
        let [one, two] = [&postures[0], &postures[1]].map(|p| coding.encode(&figure, p));
        let own = joined(&one.own, &two.own);
        let carried = joined(&one.carried, &two.carried);
        let ica = if options.principal { principal(&own, options)? } else { fit(&own, &options.ica)? };
        let frames = [one.own.nrows(), two.own.nrows()];
        let found_by = (options.ica.contrast, options.ica.method);
        Ok(Self::ordered(
            figure,
            coding,
            a.clip.rate_hz,
            [a.name, b.name],
            frames,
            &ica,
            &carried,
            found_by,
            notes,
        ))
    }

    #[expect(clippy::too_many_arguments, reason = "the parts of the value that is built")]
    fn ordered(
        figure: Figure,
        coding: Coding,
        rate_hz: f64,
        names: [&str; 2],
        frames: [usize; 2],
        ica: &Ica,
        carried: &DMatrix<f64>,
        found_by: (Contrast, Method),
        mut notes: Vec<String>,
    ) -> Self {
        let k = ica.components();
        let separations: Vec<f64> =
            (0..k).map(|i| separate(ica.activations.column(i).as_slice(), frames[0]).best()).collect();
        let mut order: Vec<usize> = (0..k).collect();
        order.sort_by(|x, y| separations[*y].total_cmp(&separations[*x]));
        let sorted = |m: &DMatrix<f64>| DMatrix::from_fn(m.nrows(), k, |r, c| m[(r, order[c])]);
        // W Λ^−½ Vᵀ, as columns
        let mut unmixing = ica.whitening.directions.clone();
        for (c, mut column) in unmixing.column_iter_mut().enumerate() {
            column /= ica.whitening.variances[c].sqrt();
        }
        let unmixing = unmixing * ica.rotation.transpose();
        let activations = sorted(&ica.activations);
        let rotation = DMatrix::from_fn(k, k, |r, c| ica.rotation[(order[r], c)]);
        // activations have unit variance and no correlation: the regression on them is a mean of products
        let n = activations.nrows() as f64;
        let carried_mean = DVector::from_iterator(carried.ncols(), carried.column_iter().map(|c| c.mean()));
        let carried_mixing = carried.tr_mul(&activations) / n;
        let trust = Trust {
            converged: ica.converged,
            steps: ica.steps,
            converged_starts: ica.converged_starts,
            agreement: order.iter().map(|i| ica.agreement[*i]).collect(),
        };
        if !trust.converged {
            notes.push(format!(
                "the decomposition did not come to rest in {} steps: do not trust it",
                trust.steps
            ));
        }
        for (i, agreement) in trust.agreement.iter().enumerate().filter(|(_, a)| **a < learn::ica::STABLE) {
            notes.push(format!(
                "component {} is not stable: other starts find it again with a correlation of {agreement:.2} only",
                i + 1
            ));
        }
        StyleSet {
            figure,
            coding,
            rate_hz,
            names: names.map(str::to_owned),
            frames,
            mean: ica.whitening.mean.clone(),
            mixing: sorted(&ica.mixing),
            unmixing: sorted(&unmixing),
            carried_mean,
            carried_mixing,
            rotation,
            start: ica.start.clone(),
            found_by,
            activations,
            groups: (0..k).map(|i| vec![i]).collect(),
            explained: ica.whitening.explained(),
            trust,
            notes,
        }
    }

    /// Number of components, merged ones counted once.
    pub fn components(&self) -> usize {
        self.groups.len()
    }

    /// Activations of one of the clips (0 or 1), frames × k.
    pub fn of_clip(&self, clip: usize) -> DMatrix<f64> {
        let first = if clip == 0 { 0 } else { self.frames[0] };
        self.activations.rows(first, self.frames[clip]).into_owned()
    }

    /// Which of the two clips is called so.
    ///
    /// # Errors
    /// A name that neither has.
    pub fn clip_named(&self, name: &str) -> Result<usize, StyleError> {
        self.names
            .iter()
            .position(|n| n == name)
            .ok_or_else(|| StyleError::Name { name: name.into(), known: self.names.join(" or ") })
    }

    /// Components by their numbers, counted from 1.
    ///
    /// # Errors
    /// Numbers there are none of.
    pub fn numbered(&self, numbers: &[usize]) -> Result<Vec<usize>, StyleError> {
        let most = self.components();
        numbers
            .iter()
            .map(|n| {
                if (1..=most).contains(n) {
                    Ok(n - 1)
                } else {
                    Err(StyleError::Component { found: *n, most })
                }
            })
            .collect()
    }

    /// The set with some components (indices of groups) merged into one, which takes the place of the first of them.
    pub fn merged(&self, components: &[usize]) -> Self {
        let Some(first) = components.iter().min() else { return self.clone() };
        let one: Vec<usize> = components.iter().flat_map(|c| self.groups[*c].iter().copied()).collect();
        let groups = self.groups.iter().enumerate().filter_map(|(i, g)| match i {
            i if i == *first => Some(one.clone()),
            i if components.contains(&i) => None,
            _ => Some(g.clone()),
        });
        StyleSet { groups: groups.collect(), ..self.clone() }
    }

    /// How well a component tells the two clips apart; of a merged one, the best of its parts.
    pub fn separation(&self, component: usize) -> Separation {
        let of = |i: &usize| separate(self.activations.column(*i).as_slice(), self.frames[0]);
        let all = self.groups[component].iter().map(of);
        all.max_by(|a, b| a.best().total_cmp(&b.best())).expect("groups are not empty")
    }

    /// Components (indices of groups) that tell the clips apart well enough to be what their styles differ in: at least
    /// [`CLEAR`], or the best.
    pub fn clear(&self) -> Vec<usize> {
        let clear: Vec<usize> =
            (0..self.components()).filter(|c| self.separation(*c).best() >= CLEAR).collect();
        if clear.is_empty() { vec![0] } else { clear }
    }

    /// Share of the variance of all channels that a component explains, 0 to 1.
    pub fn share(&self, component: usize) -> f64 {
        let all: f64 = self.mixing.norm_squared() / self.explained;
        self.groups[component].iter().map(|i| self.mixing.column(*i).norm_squared()).sum::<f64>() / all
    }

    /// Activations of any posture numbers, frames × k.
    pub fn project(&self, own: &DMatrix<f64>) -> DMatrix<f64> {
        let mut u = own * &self.unmixing;
        let shift = self.unmixing.tr_mul(&self.mean);
        for (k, mut column) in u.column_iter_mut().enumerate() {
            column.add_scalar_mut(-shift[k]);
        }
        u
    }

    /// The channels of the mean and of these activations, frames × k.
    pub fn channels(&self, u: &DMatrix<f64>) -> Channels {
        let with = |mean: &DVector<f64>, change: DMatrix<f64>| {
            let mut change = change;
            for (c, mut column) in change.column_iter_mut().enumerate() {
                column.add_scalar_mut(mean[c]);
            }
            change
        };
        Channels {
            own: with(&self.mean, u * self.mixing.transpose()),
            carried: with(&self.carried_mean, u * self.carried_mixing.transpose()),
        }
    }

    /// Activations of one component, all others at zero: u^i e_i.
    pub fn alone(&self, component: usize) -> DMatrix<f64> {
        let members = &self.groups[component];
        DMatrix::from_fn(self.activations.nrows(), self.activations.ncols(), |r, c| {
            if members.contains(&c) { self.activations[(r, c)] } else { 0.0 }
        })
    }

    /// Postures of activations.
    pub fn postures(&self, u: &DMatrix<f64>) -> Postures {
        let channels = self.channels(u);
        let frames = u.nrows();
        let start = self.coding.center.iter().enumerate().fold(Vec::new(), |mut turns, (i, joint)| {
            let above = self.figure.bones[i].parent.map_or(motion::Quat::identity(), |p: usize| turns[p]);
            turns.push(above * joint);
            turns
        });
        let mut postures = Postures {
            rate_hz: self.rate_hz,
            turns: vec![start; frames],
            height: vec![0.0; frames],
            heading: vec![0.0; frames],
        };
        self.coding.decode(&self.figure, &channels, &mut postures.turns, &mut postures.height);
        postures
    }

    /// A component as a motion of the joined clip, in place (equation 3).
    pub fn component(&self, component: usize) -> Clip {
        self.postures(&self.alone(component)).in_place(&self.figure)
    }

    /// All components together: the approximation of the joined clip.
    pub fn together(&self) -> Clip {
        self.postures(&self.activations).in_place(&self.figure)
    }
}

/// Components that tell clips apart at least so well are taken when none are named.
pub const CLEAR: f64 = 0.6;

fn joined(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(a.nrows() + b.nrows(), a.ncols(), |r, c| {
        if r < a.nrows() { a[(r, c)] } else { b[(r - a.nrows(), c)] }
    })
}

/// Principal components in the form of independent ones: the rotation is none.
fn principal(x: &DMatrix<f64>, options: &StyleOptions) -> Result<Ica, StyleError> {
    let whitening = whiten(x, options.ica.count)?;
    let k = whitening.variances.len();
    Ok(Ica {
        mixing: whitening.dewhitening(),
        activations: whitening.apply(x),
        rotation: DMatrix::identity(k, k),
        start: DMatrix::identity(k, k),
        whitening,
        agreement: vec![1.0; k],
        converged: true,
        steps: 0,
        last_turn: 0.0,
        converged_starts: (0, 0),
    })
}

/// What bringing a clip onto the figure of another took.
pub(super) fn said(name: &str, onto: &str, matched: &Match) -> Option<String> {
    if matched.is_same() {
        return None;
    }
    let mut parts = Vec::new();
    if (matched.size - 1.0).abs() > 1e-9 {
        parts.push(format!("legs {:.3} times as long", matched.size));
    }
    if matched.largest_turn > 1e-9 {
        let deg = matched.largest_turn.to_degrees();
        parts.push(format!("bones of the zero pose up to {deg:.1}° apart"));
    }
    if !matched.renamed.is_empty() {
        let pairs: Vec<String> = matched.renamed.iter().take(6).map(|(a, b)| format!("{a} = {b}")).collect();
        let more = if matched.renamed.len() > 6 { ", …" } else { "" };
        parts.push(format!("{} matched by name: {}{more}", matched.renamed.len(), pairs.join(", ")));
    }
    if !matched.missing.is_empty() {
        parts.push(format!("without {}, which stay with their parents", matched.missing.join(", ")));
    }
    Some(format!("{name} is brought onto the bones of {onto}: {}", parts.join("; ")))
}

/// Says how the headings were aligned.
fn headings(a: &str, one: &Postures, b: &str, two: &Postures) -> String {
    let mean = |p: &Postures| (p.heading.iter().sum::<f64>() / p.frames() as f64).to_degrees();
    let wrapped = |deg: f64| deg - 360.0 * (deg / 360.0).round();
    format!(
        "headings are taken away: {a} faces {:.0}°, {b} {:.0}° from +Z on average",
        wrapped(mean(one)),
        wrapped(mean(two))
    )
}
