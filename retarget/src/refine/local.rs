//! The quadratic of one frame, and how it reaches the unknowns.
//!
//! In: residuals of a frame with their slopes by `x = (δ, δ̇, δ̈)` of the D degrees of freedom that move. Out: normal
//! matrix and gradient of the weights, basis function i and degree of freedom d at `i·D + d`: with Q (3D × 3D) and g
//! those of x, `A_{il} += Σ_ab φᵃ_i φᵇ_l Q_ab`.

use motion::Vec3;

use super::band::Band;
use super::basis::Active;

/// The quadratic of one frame in `x`. See the module header.
pub(super) struct FrameQuadratic {
    pub d: usize,
    /// Q, lower triangle, row-major, `3d × 3d`.
    pub q: Vec<f64>,
    pub gradient: Vec<f64>,
    /// One residual's slope.
    pub row: Vec<f64>,
    pub chain: Vec<(usize, Vec3)>,
    half: Vec<f64>,
}

impl FrameQuadratic {
    pub fn new(d: usize) -> Self {
        Self {
            d,
            q: vec![0.0; 9 * d * d],
            gradient: vec![0.0; 3 * d],
            row: vec![0.0; 3 * d],
            chain: Vec::new(),
            half: vec![0.0; 3 * d * d],
        }
    }

    pub fn clear(&mut self) {
        self.q.fill(0.0);
        self.gradient.fill(0.0);
    }

    pub fn clear_row(&mut self) {
        self.row.fill(0.0);
    }

    /// Adds ½ r², of which `row[..count]` is the slope.
    pub fn add_row(&mut self, r: f64, count: usize) {
        let n = 3 * self.d;
        for i in 0..count {
            let x = self.row[i];
            if x == 0.0 {
                continue;
            }
            self.gradient[i] += x * r;
            let to = &mut self.q[i * n..i * n + i + 1];
            to.iter_mut().zip(&self.row).for_each(|(q, y)| *q += x * y);
        }
    }

    /// Adds the frame to the normal equations of the weights, of which function `active.first` is number `first`.
    pub fn add_to(
        &mut self,
        active: &Active,
        first: usize,
        normal: &mut Band,
        gradient: &mut [f64],
        rates: bool,
    ) {
        let (d, n) = (self.d, 3 * self.d);
        let orders = if rates { 3 } else { 1 };
        for i in 0..n {
            (0..i).for_each(|j| self.q[j * n + i] = self.q[i * n + j]);
        }
        let (q, g) = (&self.q, &self.gradient);
        let half = &mut self.half;
        for (l, phi) in active.phi.iter().enumerate() {
            let to = &mut gradient[(first + l) * d..(first + l + 1) * d];
            for (j, to) in to.iter_mut().enumerate() {
                *to += (0..orders).map(|a| phi[a] * g[a * d + j]).sum::<f64>();
            }
        }
        let near = active.near();
        for l in near.clone() {
            let phi = &active.phi[l];
            // this function's columns of Q Φ, one after the other: Q is symmetric
            for j in 0..d {
                let column = &mut half[j * n..j * n + orders * d];
                column.fill(0.0);
                for (b, x) in phi.iter().enumerate().take(orders) {
                    let row = &q[(b * d + j) * n..];
                    column.iter_mut().zip(row).for_each(|(h, q)| *h += x * q);
                }
            }
            for i in l..near.end {
                let other = &active.phi[i];
                for (to, h) in normal.block_mut(first + i, first + l).zip(half.chunks_exact(n)) {
                    if rates {
                        let (pose, rest) = h.split_at(d);
                        let (rate, bend) = rest.split_at(d);
                        for (((r, p), v), a) in to.iter_mut().zip(pose).zip(rate).zip(bend) {
                            *r += other[0] * p + other[1] * v + other[2] * a;
                        }
                    } else {
                        to.iter_mut().zip(h).for_each(|(r, p)| *r += other[0] * p);
                    }
                }
            }
        }
    }
}
