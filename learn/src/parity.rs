//! A signed permutation M that undoes itself, in the coordinates where it is diagonal: those it keeps (even), then those
//! it negates (odd).
//!
//! With a mirror, the kernel matrix of examples and images is [[A, B], [B, A]], and Y of both is [Y; Y M']. In
//! (u₁ ± u₂)/√2 it falls into A + B, which sees the even targets only, and A − B, which sees the odd ones only:
//! two Gaussian processes of half the size with kernels k(x, x') ± k(x, M x').

use std::f64::consts::FRAC_1_SQRT_2;

/// The change of coordinates; orthonormal.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Parity {
    /// Of every new coordinate: `a`, and `(b, sign)` for (x_a ± x_b)/√2.
    rows: Vec<(usize, Option<(usize, f64)>)>,
    /// Number of even coordinates, which come first.
    pub even: usize,
}

impl Parity {
    /// Of a checked side of a mirror; without one, all coordinates are even and stay as they are.
    pub fn of(map: Option<&[(usize, f64)]>, dimension: usize) -> Self {
        let Some(map) = map else {
            return Parity { rows: (0..dimension).map(|i| (i, None)).collect(), even: dimension };
        };
        let (mut even, mut odd) = (Vec::new(), Vec::new());
        for (i, &(j, sign)) in map.iter().enumerate() {
            if i == j {
                if sign > 0.0 { even.push((i, None)) } else { odd.push((i, None)) }
            } else if i < j {
                even.push((i, Some((j, sign))));
                odd.push((i, Some((j, -sign))));
            }
        }
        let count = even.len();
        even.extend(odd);
        Parity { rows: even, even: count }
    }

    /// What is known of every coordinate, for the new ones: the same for both of those that are joined.
    pub fn carry<T>(&self, of: impl Fn(usize) -> T) -> Vec<T> {
        self.rows.iter().map(|(a, _)| of(*a)).collect()
    }

    /// Of some of the new coordinates; only [`Parity::len`] and `even` mean something then.
    pub fn subset(&self, keep: &[bool]) -> Self {
        let kept = |range: std::ops::Range<usize>| range.filter(|&i| keep[i]).map(|i| self.rows[i]);
        let even: Vec<_> = kept(0..self.even).collect();
        let count = even.len();
        Parity { rows: even.into_iter().chain(kept(self.even..self.rows.len())).collect(), even: count }
    }

    /// Number of coordinates.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Into even and odd coordinates.
    pub fn enter(&self, x: impl Fn(usize) -> f64, out: &mut [f64]) {
        for (o, &(a, b)) in out.iter_mut().zip(&self.rows) {
            *o = match b {
                None => x(a),
                Some((b, sign)) => (x(a) + sign * x(b)) * FRAC_1_SQRT_2,
            };
        }
    }

    /// Back.
    pub fn leave(&self, parts: &[f64], out: &mut [f64]) {
        // Every pair of coordinates has one even and one odd row: each gives half of both.
        out.fill(0.0);
        for (v, &(a, b)) in parts.iter().zip(&self.rows) {
            match b {
                None => out[a] = *v,
                Some((b, sign)) => {
                    out[a] += v * FRAC_1_SQRT_2;
                    out[b] += sign * v * FRAC_1_SQRT_2;
                }
            }
        }
    }
}

/// Which images count how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Sign {
    /// There are none.
    Only,
    /// k(x, x') + k(x, M x'): even targets.
    Even,
    /// k(x, x') − k(x, M x'): odd targets.
    Odd,
}

impl Sign {
    /// Of kernels to points and to their images.
    pub fn join(self, own: f64, image: f64) -> f64 {
        match self {
            Sign::Only => own,
            Sign::Even => own + image,
            Sign::Odd => own - image,
        }
    }

    /// How much of the whole variance this half counts.
    pub fn share(self) -> f64 {
        if self == Sign::Only { 1.0 } else { 0.5 }
    }
}
