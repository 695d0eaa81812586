//! Seeded noise: numbers that look random and are a function of what is asked.
//!
//! In: a seed and a moment or a number. Out: the same value whenever it is asked, on every machine: whole-number arithmetic and
//! a polynomial, no state. So a look-ahead that repeats a step repeats its noise.

/// A whole number mixed so that neighbours share nothing (the finaliser of SplitMix64).
///
/// Steele, Lea, Flood. Fast splittable pseudorandom number generators. OOPSLA 2014.
fn mixed(x: u64) -> u64 {
    let x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

/// The `n`-th number of the stream `seed`, evenly spread in [0, 1).
pub fn random(seed: i64, n: i64) -> f64 {
    let bits = mixed(mixed(seed as u64) ^ (n as u64));
    // 53 bits fill the fraction of a double
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

/// Smooth noise of the moment `t`: within [-1, 1], zero on average, with one new value every unit of `t`.
///
/// Between the values of neighbouring whole numbers it eases with zero slope and curvature at both.
pub fn noise(seed: i64, t: f64) -> f64 {
    if !t.is_finite() {
        return f64::NAN;
    }
    let whole = t.floor();
    let u = t - whole;
    let s = u * u * u * (10.0 + u * (6.0 * u - 15.0));
    let at = |n: f64| 2.0 * random(seed, n as i64) - 1.0;
    let (a, b) = (at(whole), at(whole + 1.0));
    a + (b - a) * s
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_spread_and_smooth() {
        let n = 100_000;
        let mean = (0..n).map(|i| random(7, i)).sum::<f64>() / n as f64;
        let square = (0..n).map(|i| (random(7, i) - 0.5).powi(2)).sum::<f64>() / n as f64;
        // standard errors 0.0009 and 0.0002
        assert!((mean - 0.5).abs() < 0.004 && (square - 1.0 / 12.0).abs() < 0.001, "{mean} {square}");
        let step = 1e-3;
        let largest = (0..n).map(|i| (noise(7, (i + 1) as f64 * step) - noise(7, i as f64 * step)).abs());
        // the steepest slope of the easing is 15/8, over a range of 2
        assert!(largest.fold(0.0, f64::max) <= 3.75 * step + 1e-12);
        assert!((noise(1, 0.3) - noise(2, 0.3)).abs() > 1e-6);
        assert_eq!(noise(3, 2.0), 2.0 * random(3, 2) - 1.0);
    }
}
