//! The way back: the latent point of a new pose by regression instead of search [LQ06].
//!
//! A Gaussian process from the inputs Y to the latent points X, one kernel for all latent coordinates, its
//! parameters those of greatest evidence P(X | Y). Its noise β⁻¹ is what latent points have of their own: where
//! pairs disagree, learning moves their latent points apart to explain both. Taken for white noise it would
//! forget the key poses; here it is a part that fades within a fraction of the gap between key poses,
//!
//! c(y, y') = θ1 exp(−θ2/2 |y − y'|²) + θ3 + β⁻¹ exp(−|y − y'|²/(2 ℓ²)),
//!
//! so that the map passes through every key pose and is smooth between them. Inputs are in scaled units.
//!
//! \[LQ06\] Lawrence, Quiñonero-Candela. Local distance preservation in the GP-LVM through back constraints. ICML 2006.

use crate::dense::dot;
use crate::descend::descend;
use crate::error::FitError;
use crate::gp::Evidence;
use crate::kernel::Kernel;
use crate::likelihood::{median_squared, squared_distances};
use crate::pairs::Space;
use crate::posterior::Posterior;

/// L-BFGS iterations, at most.
const ITERATIONS: usize = 100;
/// ℓ over the median distance of an input from its nearest neighbour. With 0 key poses come back as badly as from
/// GP regression (30 to 64 mm on the characters that ship), with 0.3 within 4 to 12 mm, and poses left out are
/// predicted the same; from 0.6 on these get worse.
const OWN: f64 = 0.3;

/// The regression from inputs to latent points.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Back {
    posterior: Posterior,
    /// Latent points: mean and scale.
    latent: Space,
    /// 1/ℓ².
    pub own: f64,
}

impl Back {
    /// Learns the kernel; `latent` has a latent point a column.
    pub fn kernel(input: &Space, latent: &Space) -> Result<Kernel, FitError> {
        let mut evidence = Evidence::new(input, latent);
        let n = input.points.ncols();
        let start = Kernel::start(median_squared(evidence.squared_distances(), n));
        let d = descend(&mut evidence, start.parameters().to_vec(), ITERATIONS)?;
        Ok(Kernel::from_parameters(&d.point))
    }

    /// With a kernel that was learned.
    pub fn new(input: &Space, latent: Space, kernel: Kernel) -> Result<Self, FitError> {
        let (d, n) = input.points.shape();
        let mut c = vec![0.0; n * n];
        squared_distances(input.points.as_slice(), d, &mut c);
        let nearest = |i: usize| {
            let r2 = |j: usize| c[i.max(j) * n + i.min(j)];
            (0..n).filter(|&j| j != i).map(r2).fold(f64::INFINITY, f64::min)
        };
        let mut gaps: Vec<f64> = (0..n).map(nearest).collect();
        gaps.sort_by(f64::total_cmp);
        let own = 1.0 / (OWN * OWN * gaps[n / 2]);
        for i in 0..n {
            for v in &mut c[i * n..i * n + i] {
                *v = covariance(&kernel, own, *v);
            }
            c[i * n + i] = kernel.at_zero();
        }
        let posterior = Posterior::of_covariance(kernel, c, n, latent.points.as_slice())?;
        Ok(Back { posterior, latent, own })
    }

    /// The learned kernel; its noise is the part of every key pose's own.
    pub fn parameters(&self) -> Kernel {
        self.posterior.kernel
    }

    /// Latent point (q) for the squared distances of an input to the inputs of the pairs; `k` and `w` (N) are
    /// written, `w` = L⁻¹c. Returns the variance of every latent coordinate.
    pub fn locate(&self, squared: &[f64], k: &mut [f64], w: &mut [f64], point: &mut [f64]) -> f64 {
        for (k, r2) in k.iter_mut().zip(squared) {
            *k = covariance(&self.posterior.kernel, self.own, *r2);
        }
        self.posterior.whiten(k, w);
        self.posterior.mean(w, point);
        for (x, m) in point.iter_mut().zip(&self.latent.mean) {
            *x = m + self.latent.scale * *x;
        }
        (self.posterior.kernel.at_zero() - dot(w, w)).max(0.0) * self.variance()
    }

    /// Variance of the latent points, the unit of the kernel.
    pub fn variance(&self) -> f64 {
        self.latent.scale * self.latent.scale
    }
}

/// c at a squared distance; `own` is 1/ℓ².
pub(crate) fn covariance(kernel: &Kernel, own: f64, r2: f64) -> f64 {
    kernel.theta1 * (-0.5 * kernel.theta2 * r2).exp()
        + kernel.theta3
        + kernel.noise() * (-0.5 * own * r2).exp()
}
