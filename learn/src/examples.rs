//! Examples of an edit: inputs, the targets there, and what is known of both.
//!
//! Unlike [`crate::Pairs`] they are many, neighbours in time, and may repeat or contradict each other: that is what edits
//! are, and finding it is the work of what learns from them. In: one example a row. A [`Mirror`] counts every example a
//! second time, mirrored. A [`Moment`] says of each example where it is from, so that neighbours in time do not count as
//! evidence of how dense the examples lie. Groups of input coordinates may each have a length of their own in a kernel
//! ([`Examples::with_groups`]).

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::error::{FitError, Side};

/// Most groups of input coordinates.
pub const GROUPS: usize = 8;

/// What left and right exchanged does to inputs and targets: signed permutations that undo themselves,
/// `mirrored[i] = sign · vector[index]` with `(index, sign)` of coordinate `i`; signs are 1 or −1.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mirror {
    /// Of inputs, D_x long.
    pub input: Vec<(usize, f64)>,
    /// Of targets, D_y long.
    pub output: Vec<(usize, f64)>,
}

impl Mirror {
    /// Checks one side against its number of coordinates.
    fn check(map: &[(usize, f64)], side: Side, dimension: usize) -> Result<(), FitError> {
        if map.len() != dimension {
            return Err(FitError::MirrorLength { side, found: map.len(), expected: dimension });
        }
        for (coordinate, &(index, sign)) in map.iter().enumerate() {
            let back = map.get(index).copied();
            if back != Some((coordinate, sign)) || sign.abs() != 1.0 {
                return Err(FitError::Mirror { side, coordinate, index, sign });
            }
        }
        Ok(())
    }

    /// Writes the mirror image of `vector` by one side of a mirror.
    ///
    /// # Panics
    /// Lengths that differ.
    pub fn apply(map: &[(usize, f64)], vector: &[f64], out: &mut [f64]) {
        for (o, &(index, sign)) in out.iter_mut().zip(map) {
            *o = sign * vector[index];
        }
    }
}

/// Where an example is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Moment {
    /// Which clip, any numbering.
    pub clip: u32,
    /// Which frame of it.
    pub frame: u32,
}

/// Checked examples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Stored", into = "Stored")]
pub struct Examples {
    inputs: DMatrix<f64>,
    targets: DMatrix<f64>,
    mirror: Option<Mirror>,
    moments: Option<Moments>,
    groups: Option<Vec<usize>>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Moments {
    of: Vec<Moment>,
    apart: u32,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Examples", deny_unknown_fields)]
struct Stored {
    inputs: DMatrix<f64>,
    targets: DMatrix<f64>,
    mirror: Option<Mirror>,
    moments: Option<Moments>,
    #[serde(default)]
    groups: Option<Vec<usize>>,
}

impl From<Examples> for Stored {
    fn from(e: Examples) -> Self {
        Stored {
            inputs: e.inputs,
            targets: e.targets,
            mirror: e.mirror,
            moments: e.moments,
            groups: e.groups,
        }
    }
}

impl TryFrom<Stored> for Examples {
    type Error = FitError;

    fn try_from(s: Stored) -> Result<Self, FitError> {
        let examples = Examples::new(s.inputs, s.targets, s.mirror)?;
        let examples = match s.moments {
            Some(m) => examples.with_moments(m.of, m.apart)?,
            None => examples,
        };
        match s.groups {
            Some(groups) => examples.with_groups(groups),
            None => Ok(examples),
        }
    }
}

impl Examples {
    /// Of `inputs` (N × D_x) and `targets` (N × D_y), one example a row, in any units; every example a second time
    /// mirrored if there is a `mirror`. One example is enough: what models make of it is in their own words.
    ///
    /// # Errors
    /// No example, no coordinates, numbers of rows that differ, a value that is not finite, a mirror of another size or
    /// that does not undo itself.
    pub fn new(
        inputs: DMatrix<f64>,
        targets: DMatrix<f64>,
        mirror: Option<Mirror>,
    ) -> Result<Self, FitError> {
        if inputs.nrows() != targets.nrows() {
            return Err(FitError::Unpaired { inputs: inputs.nrows(), outputs: targets.nrows() });
        }
        if inputs.nrows() == 0 {
            return Err(FitError::TooFew { found: 0, least: 1 });
        }
        for (side, m) in [(Side::Input, &inputs), (Side::Output, &targets)] {
            if m.ncols() == 0 {
                return Err(FitError::Empty { side });
            }
            if let Some(i) = m.as_slice().iter().position(|v| !v.is_finite()) {
                let (pair, coordinate) = (i % m.nrows(), i / m.nrows());
                return Err(FitError::NotFinite { side, pair, coordinate, value: m[i] });
            }
        }
        if let Some(mirror) = &mirror {
            Mirror::check(&mirror.input, Side::Input, inputs.ncols())?;
            Mirror::check(&mirror.output, Side::Output, targets.ncols())?;
        }
        Ok(Examples { inputs, targets, mirror, moments: None, groups: None })
    }

    /// With where each example is from. Examples of one clip that are at most `apart` frames from each other, and their
    /// mirror images, are the same event: they do not count as neighbours when it is measured how dense the examples lie.
    ///
    /// # Errors
    /// Another number of moments than of examples.
    pub fn with_moments(mut self, moments: Vec<Moment>, apart: u32) -> Result<Self, FitError> {
        if moments.len() != self.len() {
            return Err(FitError::Moments { found: moments.len(), expected: self.len() });
        }
        self.moments = Some(Moments { of: moments, apart });
        Ok(self)
    }

    /// With the group of each input coordinate, from 0 on: how much each group counts in a distance is learned
    /// ([`crate::RbfKernel::weights`]). Coordinates that a mirror exchanges are of one group.
    ///
    /// # Errors
    /// Another number of them than of coordinates, [`GROUPS`] or above, a mirror that exchanges groups.
    pub fn with_groups(mut self, groups: Vec<usize>) -> Result<Self, FitError> {
        let setting = |value: usize, allowed: String| {
            Err(FitError::Setting { name: "groups", value: value as f64, allowed })
        };
        if groups.len() != self.inputs.ncols() {
            return setting(groups.len(), format!("one a coordinate: {}", self.inputs.ncols()));
        }
        if let Some(&g) = groups.iter().find(|&&g| g >= GROUPS) {
            return setting(g, format!("below {GROUPS}"));
        }
        if let Some(mirror) = &self.mirror
            && let Some(i) = (0..groups.len()).find(|&i| groups[i] != groups[mirror.input[i].0])
        {
            return setting(groups[i], format!("that of coordinate {}, its mirror image", mirror.input[i].0));
        }
        self.groups = Some(groups);
        Ok(self)
    }

    /// These and then `more`.
    ///
    /// # Errors
    /// Other numbers of coordinates, another mirror, other groups, moments on one side only or with another distance.
    pub fn and(&self, more: &Examples) -> Result<Self, FitError> {
        for (side, here, there) in
            [(Side::Input, &self.inputs, &more.inputs), (Side::Output, &self.targets, &more.targets)]
        {
            if here.ncols() != there.ncols() {
                return Err(FitError::Coordinates { side, found: there.ncols(), expected: here.ncols() });
            }
        }
        if self.mirror != more.mirror {
            return Err(FitError::Unlike { what: "mirrors" });
        }
        if self.groups != more.groups {
            return Err(FitError::Unlike { what: "groups" });
        }
        let moments = match (&self.moments, &more.moments) {
            (None, None) => None,
            (Some(a), Some(b)) if a.apart == b.apart => {
                Some(Moments { of: [a.of.as_slice(), b.of.as_slice()].concat(), apart: a.apart })
            }
            _ => return Err(FitError::Unlike { what: "moments" }),
        };
        let below = |a: &DMatrix<f64>, b: &DMatrix<f64>| {
            DMatrix::from_fn(a.nrows() + b.nrows(), a.ncols(), |i, k| {
                if i < a.nrows() { a[(i, k)] } else { b[(i - a.nrows(), k)] }
            })
        };
        Ok(Examples {
            inputs: below(&self.inputs, &more.inputs),
            targets: below(&self.targets, &more.targets),
            mirror: self.mirror.clone(),
            moments,
            groups: self.groups.clone(),
        })
    }

    /// The examples with these numbers, in this order.
    ///
    /// # Errors
    /// None of them, or a number beyond the examples.
    pub fn subset(&self, keep: &[usize]) -> Result<Self, FitError> {
        if let Some(&i) = keep.iter().find(|&&i| i >= self.len()) {
            let allowed = format!("below {}", self.len());
            return Err(FitError::Setting { name: "example", value: i as f64, allowed });
        }
        if keep.is_empty() {
            return Err(FitError::TooFew { found: 0, least: 1 });
        }
        Ok(Examples {
            inputs: self.inputs.select_rows(keep),
            targets: self.targets.select_rows(keep),
            mirror: self.mirror.clone(),
            moments: self
                .moments
                .as_ref()
                .map(|m| Moments { of: keep.iter().map(|&i| m.of[i]).collect(), apart: m.apart }),
            groups: self.groups.clone(),
        })
    }

    /// Number of examples N, without mirror images.
    pub fn len(&self) -> usize {
        self.inputs.nrows()
    }

    /// Never: there is at least one.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of examples with mirror images.
    pub fn effective(&self) -> usize {
        self.len() * if self.mirror.is_some() { 2 } else { 1 }
    }

    /// N × D_x.
    pub fn inputs(&self) -> &DMatrix<f64> {
        &self.inputs
    }

    /// N × D_y.
    pub fn targets(&self) -> &DMatrix<f64> {
        &self.targets
    }

    /// The mirror.
    pub fn mirror(&self) -> Option<&Mirror> {
        self.mirror.as_ref()
    }

    /// Where each example is from.
    pub fn moments(&self) -> Option<&[Moment]> {
        self.moments.as_ref().map(|m| m.of.as_slice())
    }

    /// Group of each input coordinate.
    pub fn groups(&self) -> Option<&[usize]> {
        self.groups.as_deref()
    }

    /// Number of groups; 1 where there are none.
    pub fn group_count(&self) -> usize {
        self.groups.as_ref().and_then(|g| g.iter().max()).map_or(1, |g| g + 1)
    }

    /// The numbers of examples of which no two of one clip are nearer in time than `share` of what is one event, in order; all of them
    /// without moments.
    pub(crate) fn apart(&self, share: f64) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.len()).collect();
        let Some(Moments { of: moments, apart }) = &self.moments else { return order };
        let least = share * f64::from(*apart);
        order.sort_by_key(|&i| (moments[i].clip, moments[i].frame));
        let mut keep: Vec<usize> = Vec::new();
        for i in order {
            let near = keep.last().is_some_and(|&k| {
                moments[k].clip == moments[i].clip && f64::from(moments[i].frame - moments[k].frame) < least
            });
            if !near {
                keep.push(i);
            }
        }
        keep.sort_unstable();
        keep
    }

    /// Whether two examples are the same event.
    pub(crate) fn same_event(&self, i: usize, j: usize) -> bool {
        i == j
            || self.moments.as_ref().is_some_and(|m| {
                let (a, b) = (m.of[i], m.of[j]);
                a.clip == b.clip && a.frame.abs_diff(b.frame) <= m.apart
            })
    }
}
