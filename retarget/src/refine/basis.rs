//! Gaussian radial basis functions in time, (10) of \[YAH10\].
//!
//! `Δ(t) = Σ w_i φ_i(t)`, `φ_i = exp(−(t − T_i)²/σ²)`, `T_i` at a constant spacing h, σ = 2h. Beyond 8h a function
//! is below 1.2e-7 and is taken as zero: at any time 17 are not, and two that are farther apart than 16h never
//! meet, which makes the normal equations banded.
//!
//! \[YAH10\] Yamane, Ariki, Hodgins. Animating Non-Humanoid Characters with Human Motion Data, SCA 2010, §5.3.

/// Reach of a function in spacings.
pub const REACH: usize = 8;
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

    /// Those that act at `t_s`.
    pub fn at(&self, t_s: f64, out: &mut Active) {
        let h = self.spacing_s;
        let x = t_s / h + OUTSIDE as f64;
        let first = (x - REACH as f64).ceil().max(0.0) as usize;
        let last = ((x + REACH as f64).floor() as usize).min(self.count - 1);
        out.first = first;
        out.phi.clear();
        let sigma2 = 4.0 * h * h;
        for i in first..=last {
            let s = (x - i as f64) * h;
            let phi = (-s * s / sigma2).exp();
            out.phi.push([phi, -2.0 * s / sigma2 * phi, (4.0 * s * s / sigma2 - 2.0) / sigma2 * phi]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 17 functions act inside, and the derivatives are those of the values.
    #[test]
    fn derivatives_are_differences() {
        let b = Basis::new(3.0, 0.1);
        let [mut lo, mut mid, mut hi] = [Active::default(), Active::default(), Active::default()];
        let e = 1e-4;
        b.at(1.501, &mut mid);
        b.at(1.501 - e, &mut lo);
        b.at(1.501 + e, &mut hi);
        assert!((16..=17).contains(&mid.phi.len()) && lo.first == mid.first && hi.first == mid.first);
        for ((l, m), h) in lo.phi.iter().zip(&mid.phi).zip(&hi.phi) {
            assert!(((h[0] - l[0]) / (2.0 * e) - m[1]).abs() < 1e-5);
            assert!(((h[0] - 2.0 * m[0] + l[0]) / (e * e) - m[2]).abs() < 1e-3);
        }
        b.at(1.5, &mut mid);
        assert_eq!(mid.phi.len(), 17);
    }
}
