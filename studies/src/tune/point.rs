//! Points of a search: vectors with the three operations that Nelder and Mead need.
//!
//! argmin's own for `Vec<f64>` bring a second random-number crate and complex numbers with them.

use argmin_math::{ArgminAdd, ArgminMul, ArgminSub};

/// A point; every number is a part of its parameter's range, 0 to 1, mirrored beyond.
#[derive(Clone, Debug, PartialEq)]
pub struct Point(pub Vec<f64>);

impl Point {
    /// The point inside the ranges: what leaves at an end comes back from it.
    pub fn folded(&self) -> Vec<f64> {
        self.0.iter().map(|x| fold(*x)).collect()
    }
}

/// Mirrors the line into [0, 1].
fn fold(x: f64) -> f64 {
    let y = x.rem_euclid(2.0);
    if y > 1.0 { 2.0 - y } else { y }
}

impl ArgminAdd<Self, Self> for Point {
    fn add(&self, other: &Self) -> Self {
        Self(self.0.iter().zip(&other.0).map(|(a, b)| a + b).collect())
    }
}

impl ArgminSub<Self, Self> for Point {
    fn sub(&self, other: &Self) -> Self {
        Self(self.0.iter().zip(&other.0).map(|(a, b)| a - b).collect())
    }
}

impl ArgminMul<f64, Self> for Point {
    fn mul(&self, factor: &f64) -> Self {
        Self(self.0.iter().map(|a| a * factor).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_come_back_from_the_ends() {
        for (x, y) in
            [(0.3, 0.3), (0.0, 0.0), (1.0, 1.0), (1.25, 0.75), (-0.25, 0.25), (2.5, 0.5), (-1.5, 0.5)]
        {
            assert!((fold(x) - y).abs() < 1e-15, "{x}");
        }
    }
}
