//! Gaussian radial basis functions in time, (10) of \[YAH10\].
//!
//! `Δ(t) = Σ w_i φ_i(t)`, `φ_i = exp(−(t − T_i)²/σ²)`, `T_i` at a constant spacing h, σ = 2h. Beyond 8h a function
//! is below 1.2e-7 and is taken as zero: at any time 17 are not, and two that are farther apart than 16h never
//! meet, which makes the normal equations banded.
//!
//! *Sampled.* A clip is differentiated by differences of its frames, and what it needs in forces is what those say:
//! the rates of a function are taken in the same way ([`Stencils`]), so that the slopes of the refinement's cost are
//! those of the cost itself. (σ is two frames where h is one: φ̈ and its differences are 4 % of its peak apart.)
//!
//! \[YAH10\] Yamane, Ariki, Hodgins. Animating Non-Humanoid Characters with Human Motion Data, SCA 2010, §5.3.

use std::ops::Range;
use std::sync::Arc;

use motion::{Clip, Derivatives, Joint, Link, Skeleton, Vec3};

/// Reach of a function in spacings.
pub const REACH: usize = 8;
/// Spacings within which a function counts in the normal equations of a frame. Beyond, it is below exp(−9) = 1.2e-4; the equations
/// guide steps, of which cost and gradient are complete.
pub const NEAR: usize = 6;
/// Functions beyond each end of the motion, so that its ends can be moved as freely as its middle.
const OUTSIDE: usize = 2;

/// Functions at a constant spacing over a time. See the module header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    spacing_s: f64,
    count: usize,
}

/// The functions that are not zero at one time: value, first and second derivative of each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Active {
    /// Index of the first function.
    pub first: usize,
    /// φ, φ̇ (1/s), φ̈ (1/s²).
    pub phi: Vec<[f64; 3]>,
}

impl Active {
    /// Those of [`NEAR`], as indices into `phi`.
    pub fn near(&self) -> Range<usize> {
        let least = (-0.25 * (NEAR * NEAR) as f64).exp();
        let is = |phi: &[f64; 3]| phi[0] >= least;
        let first = self.phi.iter().position(is).unwrap_or(self.phi.len());
        first..first + self.phi[first..].iter().take_while(|p| is(p)).count()
    }
}

impl Basis {
    /// Functions `spacing_s` apart over a motion of `duration_s`.
    pub fn new(duration_s: f64, spacing_s: f64) -> Self {
        let count = (duration_s / spacing_s).ceil() as usize + 1 + 2 * OUTSIDE;
        Self { spacing_s, count }
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Time of the middle of function `i`, s.
    pub fn middle_s(&self, i: usize) -> f64 {
        (i as f64 - OUTSIDE as f64) * self.spacing_s
    }

    /// Values of those that act at `t_s`, of the functions `among`; rates are left at zero.
    pub fn at(&self, t_s: f64, among: &Range<usize>, out: &mut Active) {
        let x = t_s / self.spacing_s + OUTSIDE as f64;
        let first = ((x - REACH as f64).ceil().max(0.0) as usize).max(among.start);
        let last = ((x + REACH as f64).floor().max(0.0) as usize + 1).min(among.end);
        out.first = first;
        out.phi.clear();
        out.phi.extend((first..last).map(|i| [self.value(t_s, i), 0.0, 0.0]));
    }

    /// Those that act in frame `k` of `stencils`, whose frame 0 is at `from_s`, with their rates as differences of
    /// frames give them.
    pub fn sampled(
        &self,
        stencils: &Stencils,
        k: usize,
        from_s: f64,
        among: &Range<usize>,
        out: &mut Active,
    ) {
        let time = |k: usize| from_s + k as f64 * stencils.dt;
        self.at(time(k), among, out);
        for (l, phi) in out.phi.iter_mut().enumerate() {
            for &(neighbour, slope, bend) in &stencils.of[k] {
                let value = self.value(time(neighbour), out.first + l);
                phi[1] += slope * value;
                phi[2] += bend * value;
            }
        }
    }

    fn value(&self, t_s: f64, i: usize) -> f64 {
        let s = (t_s - self.middle_s(i)) / (2.0 * self.spacing_s);
        (-s * s).exp()
    }
}

/// How [`Derivatives::central`] makes rates of the frames of a clip. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Stencils {
    dt: f64,
    /// Per frame: neighbour (itself among them), weight of its value in the rate (1/s), in the acceleration (1/s²).
    of: Vec<Vec<(usize, f64, f64)>>,
}

impl Stencils {
    /// Of a clip of so many frames: read from the differences themselves, by paths that are 1 in every fifth frame
    /// and 0 elsewhere. No stencil reaches farther than two frames.
    pub fn new(frames: usize, rate_hz: f64) -> Self {
        const SPAN: usize = 5;
        let slide = |i: usize| {
            let parent = i.checked_sub(1);
            Link::new(format!("{i}"), parent, Vec3::zeros(), Joint::Prismatic(Vec3::x()))
        };
        let skeleton = Skeleton::new((0..SPAN).map(slide).collect()).expect("five slides are a skeleton");
        let pulse = |k: usize| (0..SPAN).map(move |j| f64::from(u8::from(k % SPAN == j)));
        let clip = Clip::new(Arc::new(skeleton), rate_hz, (0..frames).flat_map(pulse).collect());
        let d = Derivatives::central(&clip);
        let of = |k: usize| {
            let near = k.saturating_sub(2)..(k + 3).min(frames);
            near.map(|n| (n, d.v[k * SPAN + n % SPAN], d.vd[k * SPAN + n % SPAN])).collect()
        };
        Self { dt: 1.0 / rate_hz, of: (0..frames).map(of).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 17 functions act inside; their rates are those of a clip that follows them, at its ends too.
    #[test]
    fn rates_are_those_of_a_clip() {
        let (b, rate, frames) = (Basis::new(3.0, 0.05), 30.0, 91);
        let slide = Link::new("slide", None, Vec3::zeros(), Joint::Prismatic(Vec3::y()));
        let skeleton = Arc::new(Skeleton::new(vec![slide]).unwrap());
        let w: Vec<f64> = (0..b.len()).map(|i| (1.7 * i as f64).sin()).collect();
        let (all, mut active) = (0..b.len(), Active::default());
        let sum = |a: &Active, order: usize| {
            a.phi.iter().enumerate().map(|(l, p)| p[order] * w[a.first + l]).sum::<f64>()
        };
        let mut q = Vec::new();
        for k in 0..frames {
            b.at(k as f64 / rate, &all, &mut active);
            q.push(sum(&active, 0));
        }
        let clip = Clip::new(skeleton, rate, q);
        let (d, stencils) = (Derivatives::central(&clip), Stencils::new(frames, rate));
        for k in 0..frames {
            b.sampled(&stencils, k, 0.0, &all, &mut active);
            // what a function that is cut off two frames away would have added: 1e-5 and 1e-3 seen
            assert!((sum(&active, 1) - d.v[k]).abs() < 1e-4, "{k}");
            assert!((sum(&active, 2) - d.vd[k]).abs() < 1e-2, "{k}");
        }
        b.at(1.52, &all, &mut active);
        assert_eq!((active.phi.len(), active.near()), (16, 2..14));
        b.at(1.5, &all, &mut active);
        assert_eq!(active.phi.len(), 17);
    }

    /// Only those asked for act.
    #[test]
    fn a_part_of_the_functions_acts_alone() {
        let (b, mut active) = (Basis::new(3.0, 0.1), Active::default());
        b.at(1.5, &(15..20), &mut active);
        assert_eq!((active.first, active.phi.len()), (15, 5));
        b.at(1.5, &(0..3), &mut active);
        assert!(active.phi.is_empty());
    }
}
