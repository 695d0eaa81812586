//! Shared Gaussian process latent variable model (YAH10 §4): two spaces, one hidden cause.
//!
//! Key poses of a human (Y, N × D_Y) and of a character (Z, N × D_Z) are both explained by latent points X
//! (N × q) through a Gaussian process each, with kernels of their own (`kernel`, (1)). Learning maximises
//! the joint likelihood (2) over X and both kernels; mapping a new pose y finds the x that best explains it
//! (5) and reads mean (3) and variance (4) of the character there.
//!
//! Observations are centred and divided by one number a space, so that kernels of both have comparable
//! variances; means and variances come back in the units of the pairs. The start is the mean of both sides
//! of a regularised kernel CCA (`kcca`); q is at most N − 1.
//!
//! | file | holds |
//! |---|---|
//! | `objective` | the joint likelihood and its gradient |
//! | `search` | the latent point of a new pose |
//!
//! YAH10: Yamane, Ariki, Hodgins. Animating non-humanoid characters with human motion data. SCA 2010.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

pub(crate) mod objective;
pub(crate) mod search;

use crate::dense::{distance_squared, dot, matvec};
use crate::descend::descend;
use crate::error::{FitError, InputError};
use crate::kcca::{self, KernelCca, check_directions, eigen};
use crate::kernel::Kernel;
use crate::likelihood::{View, median_squared, squared_distances};
use crate::pairs::{Coverage, Pairs, Space};
use crate::posterior::Posterior;
use crate::regressor::{Doubt, Jump, Prediction, Regressor, Scratch};
use objective::Joint;
use search::Search;

/// Latent dimensions of the paper.
const DIMENSION: usize = 30;

/// Where learning starts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Start {
    /// Directions that move together in both spaces.
    #[default]
    KernelCca,
    /// Principal components of both spaces side by side.
    Pca,
}

/// How a shared GPLVM is learned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GplvmOptions {
    /// Latent dimension q, 1 to N − 1; `None`: min(30, N − 1). Few dimensions give jerky paths full of
    /// jumps, even where they reconstruct the key poses.
    pub dimension: Option<usize>,
    /// L-BFGS iterations, at most. The likelihood goes on rising for hundreds; errors on unseen poses stop
    /// falling after 35 to 70.
    pub iterations: usize,
    /// Regularisation κ of the kernel CCA start, above 0. Higher starts smoother.
    pub kappa: f64,
    /// Where learning starts.
    pub start: Start,
    /// Whether mapping a pose keeps the prior x ~ N(0, I). Without it, as (5) is printed, directions that
    /// explain nothing drift: on the rule of `examples/criteria.rs` the latent path is a hundred times as
    /// jerky and the error a fifth larger.
    pub prior_in_mapping: bool,
}

impl Default for GplvmOptions {
    fn default() -> Self {
        GplvmOptions {
            dimension: None,
            iterations: 70,
            kappa: kcca::KAPPA,
            start: Start::KernelCca,
            prior_in_mapping: true,
        }
    }
}

/// How learning went. Objectives are −ln of the joint likelihood (2), nats; lower is better.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Learning {
    /// L-BFGS iterations taken.
    pub iterations: usize,
    /// Evaluations of likelihood and gradient.
    pub evaluations: usize,
    /// Objective at the start.
    pub start: f64,
    /// Objective reached.
    pub end: f64,
    /// Why it stopped, in the optimiser's words.
    pub stopped: String,
}

/// A learned map from one space to another through a shared latent space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Stored", into = "Stored")]
pub struct SharedGplvm {
    pairs: Pairs,
    options: GplvmOptions,
    learning: Learning,
    /// N × q, row-major.
    latents: Vec<f64>,
    q: usize,
    input: Posterior,
    output: Posterior,
    input_space: Space,
    output_space: Space,
    /// D_Y × r, row-major transposed (r × D_Y): orthonormal basis of the span of the inputs.
    basis: Vec<f64>,
    coverage: Coverage,
    latent_coverage: Coverage,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "SharedGplvm", deny_unknown_fields)]
struct Stored {
    pairs: Pairs,
    options: GplvmOptions,
    learning: Learning,
    input_kernel: Kernel,
    output_kernel: Kernel,
    dimension: usize,
    latents: Vec<f64>,
}

impl From<SharedGplvm> for Stored {
    fn from(m: SharedGplvm) -> Self {
        Stored {
            pairs: m.pairs,
            options: m.options,
            learning: m.learning,
            input_kernel: m.input.kernel,
            output_kernel: m.output.kernel,
            dimension: m.q,
            latents: m.latents,
        }
    }
}

impl TryFrom<Stored> for SharedGplvm {
    type Error = FitError;

    fn try_from(s: Stored) -> Result<Self, FitError> {
        check_directions(s.dimension, s.pairs.len())?;
        let expected = s.dimension * s.pairs.len();
        if s.latents.len() != expected {
            return Err(FitError::Stored { what: "latent coordinates", found: s.latents.len(), expected });
        }
        let unsound = s.latents.iter().filter(|v| !v.is_finite()).count()
            + [s.input_kernel, s.output_kernel].iter().filter(|k| !k.is_sound()).count();
        if unsound > 0 {
            return Err(FitError::Stored {
                what: "numbers that are not finite or positive",
                found: unsound,
                expected: 0,
            });
        }
        SharedGplvm::assemble(
            s.pairs,
            s.options,
            s.learning,
            s.latents,
            s.dimension,
            [s.input_kernel, s.output_kernel],
        )
    }
}

impl SharedGplvm {
    /// Learns latent points and kernels from at least three pairs.
    ///
    /// # Errors
    /// Too few pairs, a setting out of range, a likelihood that cannot be evaluated at the start.
    pub fn fit(pairs: &Pairs, options: &GplvmOptions) -> Result<Self, FitError> {
        pairs.at_least(3)?;
        let n = pairs.len();
        let q = options.dimension.unwrap_or(DIMENSION.min(n - 1));
        check_directions(q, n)?;
        let (y, z) = (Space::of(pairs.inputs()), Space::of(pairs.outputs()));
        let x = match options.start {
            Start::KernelCca => rows(&KernelCca::fit(pairs, q, options.kappa)?.shared()),
            Start::Pca => principal(&y, &z, q),
        };
        let mut r2 = vec![0.0; n * n];
        squared_distances(&x, q, &mut r2);
        let kernel = Kernel::start(median_squared(&r2, n).max(1e-6));
        let mut joint = Joint::new([View::new(&y.points), View::new(&z.points)], n, q);
        let start = joint.pack(&x, &[kernel; 2]);
        let d = descend(&mut joint, start, options.iterations)?;
        let learning = Learning {
            iterations: d.iterations,
            evaluations: d.evaluations,
            start: d.start_value,
            end: d.value,
            stopped: d.stopped,
        };
        let kernels = [joint.kernel(&d.point, 0), joint.kernel(&d.point, 1)];
        let latents = d.point[..n * q].to_vec();
        SharedGplvm::assemble(pairs.clone(), options.clone(), learning, latents, q, kernels)
    }

    fn assemble(
        pairs: Pairs,
        options: GplvmOptions,
        learning: Learning,
        latents: Vec<f64>,
        q: usize,
        kernels: [Kernel; 2],
    ) -> Result<Self, FitError> {
        let n = pairs.len();
        let (input_space, output_space) = (Space::of(pairs.inputs()), Space::of(pairs.outputs()));
        let mut r2 = vec![0.0; n * n];
        squared_distances(&latents, q, &mut r2);
        let qr = input_space.points.clone().qr();
        let (basis, coordinates) = (qr.q(), qr.r());
        // Columns of the matrices are rows here: coordinates of pose i are column i of R.
        let y = coordinates.as_slice();
        let input = Posterior::new(kernels[0], &r2, n, y)?;
        let output = Posterior::new(kernels[1], &r2, n, output_space.points.as_slice())?;
        let coverage = Coverage::of(&input_space.points);
        let latent_coverage = Coverage::of(&DMatrix::from_column_slice(q, n, &latents));
        let basis = basis.as_slice().to_vec();
        Ok(SharedGplvm {
            pairs,
            options,
            learning,
            latents,
            q,
            input,
            output,
            input_space,
            output_space,
            basis,
            coverage,
            latent_coverage,
        })
    }

    /// Latent dimension q.
    pub fn dimension(&self) -> usize {
        self.q
    }

    /// Latent points of the key poses, N × q.
    pub fn latents(&self) -> DMatrix<f64> {
        DMatrix::from_row_slice(self.pairs.len(), self.q, &self.latents)
    }

    /// Kernels of the input and the output space, in units of the variance of each space.
    pub fn kernels(&self) -> [Kernel; 2] {
        [self.input.kernel, self.output.kernel]
    }

    /// How learning went.
    pub fn learning(&self) -> &Learning {
        &self.learning
    }

    /// Settings it was learned with.
    pub fn options(&self) -> &GplvmOptions {
        &self.options
    }

    fn rank(&self) -> usize {
        self.basis.len() / self.pairs.input_dim()
    }

    /// Finds the latent point of `input`; leaves it in the search of `scratch`. Returns novelty.
    fn locate(&self, input: &[f64], scratch: &mut Scratch) -> Result<f64, InputError> {
        let (n, rank) = (self.pairs.len(), self.rank());
        scratch.fit(self.pairs.input_dim(), n);
        if !scratch.search.as_deref().is_some_and(|s| s.fits(n, self.q, rank)) {
            scratch.search = Some(Box::new(Search::new(n, self.q, rank, self.pairs.input_dim())));
        }
        self.input_space.enter(input, &mut scratch.input)?;
        let (nearest, novelty) =
            self.coverage.novelty(&self.input_space.points, &scratch.input, &mut scratch.squared);
        let Some(search) = scratch.search.as_deref_mut() else { unreachable!("made above") };
        matvec(&self.basis, &scratch.input, &mut search.pose);
        search.beyond = (dot(&scratch.input, &scratch.input) - dot(&search.pose, &search.pose)).max(0.0);
        let lambda = if self.options.prior_in_mapping { 1.0 } else { 0.0 };
        let leap = search.run(&self.input, &self.latents, nearest, lambda);
        scratch.jump = leap.map(|l| Jump { lengths: l.lengths, gain: l.gain, key: nearest });
        Ok(novelty)
    }

    /// Mean (3) and variance (4) of the output space at latent point `x` (q), in the units of the outputs;
    /// novelty is measured between latent points.
    ///
    /// # Errors
    /// `x` is not q finite numbers.
    pub fn output_at(
        &self,
        x: &[f64],
        scratch: &mut Scratch,
        out: &mut Prediction,
    ) -> Result<(), InputError> {
        if x.len() != self.q {
            return Err(InputError::Dimension { found: x.len(), expected: self.q });
        }
        if let Some(coordinate) = x.iter().position(|v| !v.is_finite()) {
            return Err(InputError::NotFinite { coordinate, value: x[coordinate] });
        }
        scratch.fit(self.pairs.input_dim(), self.pairs.len());
        let unknown = self.read(x, &mut scratch.k, &mut scratch.w, out);
        out.confidence = (1.0 - unknown).clamp(0.0, 1.0);
        let nearest =
            self.latents.chunks_exact(self.q).map(|l| distance_squared(x, l)).fold(f64::INFINITY, f64::min);
        out.novelty = nearest.sqrt() / self.latent_coverage.gap;
        Ok(())
    }

    /// Mean and variance at `x`; returns the variance without noise, in units of the outputs' variance.
    fn read(&self, x: &[f64], k: &mut [f64], w: &mut [f64], out: &mut Prediction) -> f64 {
        let space = &self.output_space;
        self.kernel_at(x, k);
        self.output.whiten(k, w);
        out.mean.resize(self.pairs.output_dim(), 0.0);
        self.output.mean(w, &mut out.mean);
        for (v, m) in out.mean.iter_mut().zip(&space.mean) {
            *v = m + space.scale * *v;
        }
        let left = self.output.left(w);
        out.variance = space.scale.powi(2) * (left + self.output.kernel.noise());
        left
    }

    /// k_Z(x).
    fn kernel_at(&self, x: &[f64], k: &mut [f64]) {
        for (k, xi) in k.iter_mut().zip(self.latents.chunks_exact(self.q)) {
            *k = distance_squared(x, xi);
        }
        self.output.kernel_in_place(k);
    }
}

impl Regressor for SharedGplvm {
    fn pairs(&self) -> &Pairs {
        &self.pairs
    }

    fn predict(&self, input: &[f64], scratch: &mut Scratch, out: &mut Prediction) -> Result<(), InputError> {
        let novelty = self.locate(input, scratch)?;
        let Scratch { k, w, search, .. } = scratch;
        let Some(search) = search.as_deref() else { unreachable!("located above") };
        let unknown = self.read(&search.answer, k, w, out);
        out.confidence = (1.0 - unknown - self.unseen(search)).clamp(0.0, 1.0);
        out.novelty = novelty;
        Ok(())
    }

    fn doubt(&self, frames: &DMatrix<f64>) -> Result<Doubt, InputError> {
        let (n, f) = (self.pairs.len(), frames.nrows());
        let mut scratch = Scratch::new();
        let mut input = vec![0.0; frames.ncols()];
        let root = (self.pairs.input_dim() as f64).sqrt();
        let (mut points, mut known, mut unseen) = (Vec::new(), vec![0.0; f * n], Vec::new());
        for (i, known) in known.chunks_exact_mut(n).enumerate() {
            input.iter_mut().zip(frames.row(i).iter()).for_each(|(a, b)| *a = *b);
            self.locate(&input, &mut scratch)?;
            let Some(search) = scratch.search.as_deref() else { unreachable!("located above") };
            points.extend_from_slice(&search.answer);
            self.kernel_at(&search.answer, &mut scratch.k);
            self.output.whiten(&scratch.k, known);
            unseen.extend(search.residual.iter().map(|r| r / root));
            unseen.push((search.beyond / self.pairs.input_dim() as f64).sqrt());
        }
        Ok(Doubt { kernel: self.output.kernel, points, known, unseen, frames: f })
    }
}

impl SharedGplvm {
    /// The part of the last input that no latent point explains, in units of the variance of the inputs.
    fn unseen(&self, search: &Search) -> f64 {
        (dot(&search.residual, &search.residual) + search.beyond) / self.pairs.input_dim() as f64
    }
}

/// Rows of a matrix one after the other.
fn rows(m: &DMatrix<f64>) -> Vec<f64> {
    m.transpose().as_slice().to_vec()
}

/// Scores on the first `q` principal components of both spaces side by side, the first of unit variance.
fn principal(y: &Space, z: &Space, q: usize) -> Vec<f64> {
    let gram =
        y.points.tr_mul(&y.points) / y.mean.len() as f64 + z.points.tr_mul(&z.points) / z.mean.len() as f64;
    let (values, basis) = eigen(gram);
    let n = basis.nrows();
    let unit = (n as f64 / values[0]).sqrt();
    rows(&DMatrix::from_fn(n, q, |i, k| basis[(i, k)] * values[k].max(0.0).sqrt() * unit))
}
