//! Shared Gaussian process latent variable model (YAH10 §4): two spaces, one hidden cause.
//!
//! Key poses of a human (Y, N × D_Y) and of a character (Z, N × D_Z) are both explained by latent points X
//! (N × q) through a Gaussian process each, with kernels of their own (`kernel`, (1)). Learning maximises
//! the joint likelihood (2) over X and both kernels; mapping a new pose y finds its x and reads mean (3) and
//! variance (4) of the character there.
//!
//! Two spaces of equal voice. Outputs of fewer coordinates than inputs count as if they had as many: a lamp has 45,
//! its human 81, and a latent space shaped by the human's alone generalises worse (`tests/rule.rs`: by 2 % with key
//! poses that are 5° rough, by 10 % with 20°; exact ones lose 9 %).
//!
//! Finding x. The paper takes the x that best explains y (5). The likelihood counts every coordinate of a pose as
//! an observation of its own, some 80 of them where a body has some ten independent ones, and latent points
//! absorb what pairs disagree in, so that no noise is left: a pose never seen is then explained to the last
//! millimetre by latent directions that mean nothing for the character. [`Locate::Back`] asks what the key poses
//! say instead: x by regression from Y (`back`, \[LQ06\]), whose noise the disagreement of the pairs is.
//!
//! Observations are centred and divided by one number a space, so that kernels of both have comparable
//! variances; means and variances come back in the units of the pairs. The start is the mean of both sides
//! of a regularised kernel CCA (`kcca`); q is at most N − 1.
//!
//! | file | holds |
//! |---|---|
//! | `objective` | the joint likelihood and its gradient |
//! | `back` | the latent point of a new pose by regression |
//! | `search` | the latent point of a new pose by its likelihood |
//!
//! YAH10: Yamane, Ariki, Hodgins. Animating non-humanoid characters with human motion data. SCA 2010.
//! \[LQ06\] Lawrence, Quiñonero-Candela. Local distance preservation in the GP-LVM through back constraints. ICML 2006.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

pub(crate) mod back;
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
use crate::regressor::{Jump, Part, PosteriorCovariance, Prediction, Regressor, Scratch};
use back::Back;
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

/// How the latent point of a new pose is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Locate {
    /// By regression from poses to latent points. A sequence has no basins to jump between.
    #[default]
    Back,
    /// Where P(y | x) P(x) is greatest, x ~ N(0, I): the prior that learning has.
    Posterior,
    /// Where P(y | x) is greatest: (5) as printed. Directions that explain nothing drift: on the rule of
    /// `examples/criteria.rs` the latent path is a hundred times as jerky and the error a fifth larger.
    Likelihood,
}

/// How a shared GPLVM is learned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GplvmOptions {
    /// Latent dimension q, 1 to N − 1; `None`: min(30, N − 1). Few dimensions give jerky paths full of
    /// jumps where latent points are searched, even where they reconstruct the key poses.
    pub dimension: Option<usize>,
    /// L-BFGS iterations, at most. The likelihood goes on rising for hundreds; errors on unseen poses stop
    /// falling after 35 to 70.
    pub iterations: usize,
    /// Regularisation κ of the kernel CCA start, above 0. Higher starts smoother.
    pub kappa: f64,
    /// Where learning starts.
    pub start: Start,
    /// How mapping finds the latent point of a pose.
    pub locate: Locate,
}

impl Default for GplvmOptions {
    fn default() -> Self {
        GplvmOptions {
            dimension: None,
            iterations: 70,
            kappa: kcca::KAPPA,
            start: Start::KernelCca,
            locate: Locate::Back,
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
    back: Back,
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
    back_kernel: Kernel,
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
            back_kernel: m.back.parameters(),
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
            + [s.input_kernel, s.output_kernel, s.back_kernel].iter().filter(|k| !k.is_positive()).count();
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
            s.back_kernel,
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
        // outputs of fewer coordinates than inputs count as many: see the module header
        let weight = (pairs.input_dim() as f64 / pairs.output_dim() as f64).max(1.0);
        let views = [View::new(&y.points), View::weighted(&z.points, weight)];
        let mut joint = Joint::new(views, n, q);
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
        let back = Back::kernel(&y, &Space::of(&DMatrix::from_column_slice(q, n, &latents)))?;
        SharedGplvm::assemble(pairs.clone(), options.clone(), learning, latents, q, kernels, back)
    }

    fn assemble(
        pairs: Pairs,
        options: GplvmOptions,
        learning: Learning,
        latents: Vec<f64>,
        q: usize,
        kernels: [Kernel; 2],
        back: Kernel,
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
        let points = DMatrix::from_column_slice(q, n, &latents);
        let latent_coverage = Coverage::of(&points);
        let back = Back::new(&input_space, Space::of(&points), back)?;
        let basis = basis.as_slice().to_vec();
        Ok(SharedGplvm {
            pairs,
            options,
            learning,
            latents,
            q,
            input,
            output,
            back,
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

    /// Kernel of the regression from inputs to latent points, in units of the variance of these.
    pub fn back_kernel(&self) -> Kernel {
        self.back.parameters()
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

    /// Finds the latent point of `input`; leaves it in the search of `scratch`. Returns novelty, and what is
    /// not known of the output because the latent point is not, in units of the outputs' variance.
    fn locate(&self, input: &[f64], scratch: &mut Scratch) -> Result<(f64, f64), InputError> {
        let (n, rank) = (self.pairs.len(), self.rank());
        scratch.fit(self.pairs.input_dim(), n);
        if !scratch.search.as_deref().is_some_and(|s| s.fits(n, self.q, rank)) {
            scratch.search = Some(Box::new(Search::new(n, self.q, rank, self.pairs.input_dim())));
        }
        self.input_space.enter(input, &mut scratch.input)?;
        let (nearest, novelty) =
            self.coverage.novelty(&self.input_space.points, &scratch.input, &mut scratch.squared);
        let Some(search) = scratch.search.as_deref_mut() else { unreachable!("made above") };
        let lambda = match self.options.locate {
            Locate::Back => {
                let (k, w) = (&mut scratch.k, &mut scratch.w);
                let variance = self.back.locate(&scratch.squared, k, w, &mut search.answer);
                search.warm = true;
                search.steps = 0;
                scratch.jump = None;
                return Ok((novelty, self.drift(variance)));
            }
            Locate::Posterior => 1.0,
            Locate::Likelihood => 0.0,
        };
        matvec(&self.basis, &scratch.input, &mut search.pose);
        search.beyond = (dot(&scratch.input, &scratch.input) - dot(&search.pose, &search.pose)).max(0.0);
        let change = search.run(&self.input, &self.latents, nearest, lambda);
        scratch.jump = change.map(|l| Jump { lengths: l.lengths, gain: l.gain, key: nearest });
        // The part of the input that no latent point explains, in units of the variance of the inputs.
        let unseen = dot(&search.residual, &search.residual) + search.beyond;
        Ok((novelty, unseen / self.pairs.input_dim() as f64))
    }

    /// Expected squared change of the output when every latent coordinate has this variance: of z ~ GP(0, k),
    /// E|z(x) − z(x + e)|² = 2 θ1 (1 − (1 + θ2 c)^{−q/2}) for e ~ N(0, c I).
    fn drift(&self, variance: f64) -> f64 {
        let kernel = &self.output.kernel;
        2.0 * kernel.theta1 * (1.0 - (1.0 + kernel.theta2 * variance).powf(-0.5 * self.q as f64))
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
        let (novelty, unseen) = self.locate(input, scratch)?;
        let Scratch { k, w, search, .. } = scratch;
        let Some(search) = search.as_deref() else { unreachable!("located above") };
        let unknown = self.read(&search.answer, k, w, out);
        if self.options.locate == Locate::Back {
            out.variance += self.output_space.scale.powi(2) * unseen;
        }
        out.confidence = (1.0 - unknown - unseen).clamp(0.0, 1.0);
        out.novelty = novelty;
        Ok(())
    }

    fn posterior_covariance(&self, frames: &DMatrix<f64>) -> Result<PosteriorCovariance, InputError> {
        let (n, f) = (self.pairs.len(), frames.nrows());
        let mut scratch = Scratch::new();
        let mut input = vec![0.0; frames.ncols()];
        let root = (self.pairs.input_dim() as f64).sqrt();
        let by_search = self.options.locate != Locate::Back;
        let (mut points, mut known, mut unseen) = (Vec::new(), vec![0.0; f * n], Vec::new());
        let (mut inputs, mut told) = (Vec::new(), Vec::new());
        for (i, known) in known.chunks_exact_mut(n).enumerate() {
            input.iter_mut().zip(frames.row(i).iter()).for_each(|(a, b)| *a = *b);
            self.locate(&input, &mut scratch)?;
            let Some(search) = scratch.search.as_deref() else { unreachable!("located above") };
            points.extend_from_slice(&search.answer);
            if by_search {
                unseen.extend(search.residual.iter().map(|r| r / root));
                unseen.push((search.beyond / self.pairs.input_dim() as f64).sqrt());
            } else {
                inputs.extend_from_slice(&scratch.input);
                told.extend_from_slice(&scratch.w);
            }
            self.kernel_at(&search.answer, &mut scratch.k);
            self.output.whiten(&scratch.k, known);
        }
        let kernel = self.output.kernel;
        let mut parts = vec![Part { weight: 1.0, kernel, own: None, points, known }];
        if !by_search {
            // To first order in the variance of a latent coordinate, see `drift`.
            let weight = self.q as f64 * kernel.theta1 * kernel.theta2 * self.back.variance();
            let own = Some(self.back.own);
            parts.push(Part { weight, kernel: self.back.parameters(), own, points: inputs, known: told });
        }
        Ok(PosteriorCovariance { noise: kernel.noise(), parts, unseen, frames: f })
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
