//! Examples added at the same kernel.

use super::half::{Half, join};
use super::targets::Targets;
use super::{RbfRegression, Weighted, not_definite};
use crate::cloud::{Cloud, Squared};
use crate::error::FitError;
use crate::examples::Examples;

impl RbfRegression {
    /// Adds examples at the same kernel, by more rows of the factors: O(N²) for each, nothing is learned again. The centre
    /// of targets ([`crate::RbfOptions::centre`]) stays. With inducing points, examples farther from them than any was before
    /// make them be chosen again.
    ///
    /// # Errors
    /// As [`Examples::and`]; a kernel matrix that does not factor. The model is then what it was.
    pub fn grow(&mut self, more: &Examples) -> Result<(), FitError> {
        let examples = self.examples.and(more)?;
        let was = self.cloud.len();
        if self.inducing.is_none() && examples.effective() > self.options.exact_up_to {
            return self.again(examples);
        }
        let cloud = self.cloud.and(more);
        let weighted = self
            .weighted
            .as_ref()
            .map(|w| Weighted { cloud: cloud.scaled(&w.scales), scales: w.scales.clone() });
        let seen = weighted.as_ref().map_or(&cloud, |w| &w.cloud);
        let added = seen.subset(&(was..cloud.len()).collect::<Vec<_>>());
        let new = Targets::about(more, self.targets.parity.clone(), self.targets.centre.clone());
        let mut targets = self.targets.clone();
        for (t, n) in targets.parts.iter_mut().zip(&new.parts) {
            t.values.extend_from_slice(&n.values);
        }
        let halves = match &self.inducing {
            None => self.more_rows(seen, &added, &new)?,
            Some(inducing) => {
                let mut squared = Squared::default();
                inducing.cloud.squared(added.points(), added.len(), &mut squared);
                let far = (0..added.len()).any(|i| {
                    let p = added.point(i);
                    inducing.cloud.nearest(&squared, i, added.len(), p)
                        > inducing.reach.max(1e-9 * self.extent.diameter)
                });
                if far {
                    return self.again(examples);
                }
                self.more_sums(&squared, &new)?
            }
        };
        self.extent = cloud.extent_grown(&examples, &self.extent, was);
        (self.examples, self.cloud, self.weighted) = (examples, cloud, weighted);
        (self.targets, self.halves) = (targets, halves);
        self.log_likelihood = self.likelihood();
        Ok(())
    }

    /// The same kernel with these examples, from nothing.
    fn again(&mut self, examples: Examples) -> Result<(), FitError> {
        let (options, learning) = (self.options.clone(), self.learning.clone());
        *self = RbfRegression::with_kernel(examples, options, self.kernel, learning)?;
        Ok(())
    }

    fn more_rows(&self, cloud: &Cloud, added: &Cloud, new: &Targets) -> Result<Vec<Half>, FitError> {
        let (n, more) = (cloud.len(), added.len());
        let mut squared = Squared::default();
        // rows are the points added, columns all
        added.squared(cloud.points(), n, &mut squared);
        let was = n - more;
        for i in 0..more {
            squared.own[i * n + was + i] = 0.0;
        }
        self.kernel.of(&mut squared.own);
        self.kernel.of(&mut squared.image);
        let mut rows = Vec::new();
        let mut halves = Vec::new();
        for (half, part) in self.halves.iter().zip(&new.parts) {
            join(half.sign, &squared, &mut rows);
            for i in 0..more {
                rows[i * n + was + i] += self.kernel.noise_variance;
            }
            let factor = half.factor.extended(&rows, more).ok_or_else(|| not_definite(&self.kernel))?;
            let mut whitened = half.whitened.clone();
            whitened.extend_from_slice(&part.values);
            factor.solve_lower_from(&mut whitened, half.columns, was);
            halves.push(Half { factor, whitened, sparse: None, ..*half });
        }
        Ok(halves)
    }

    fn more_sums(&self, squared: &Squared, new: &Targets) -> Result<Vec<Half>, FitError> {
        let mut k = squared.clone();
        self.kernel.of(&mut k.own);
        self.kernel.of(&mut k.image);
        let mut halves = self.halves.clone();
        let mut v = Vec::new();
        for (half, part) in halves.iter_mut().zip(&new.parts) {
            let m = half.factor.len();
            join(half.sign, &k, &mut v);
            let count = v.len() / m;
            half.factor.solve_lower(&mut v, count);
            if let Some(sparse) = &mut half.sparse {
                if !sparse.add(&v, m, &part.values, half.columns, &self.kernel) {
                    return Err(not_definite(&self.kernel));
                }
                half.whitened = sparse.whitened(half.columns, &self.kernel);
            }
        }
        Ok(halves)
    }
}
