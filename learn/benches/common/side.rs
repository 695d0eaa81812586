//! A mirror for vectors of any even length.

/// Left and right halves of the coordinates are exchanged, every third of them negated.
pub fn side(dimension: usize) -> Vec<(usize, f64)> {
    let half = dimension / 2;
    let sign = |i: usize| if (i % half).is_multiple_of(3) { -1.0 } else { 1.0 };
    (0..dimension).map(|i| ((i + half) % dimension, sign(i))).collect()
}
