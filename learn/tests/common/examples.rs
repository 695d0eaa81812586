//! Examples of a curved rule with a mirror: eight input coordinates (two swapped pairs, one pair swapped with a sign, one kept,
//! one negated), five target coordinates.

use learn::{Examples, Mirror};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Uniform in −1 … 1.
pub fn uniform(rows: usize, columns: usize, seed: u64) -> DMatrix<f64> {
    let mut rng = Pcg64::seed_from_u64(seed);
    DMatrix::from_fn(rows, columns, |_, _| rng.random_range(-1.0..1.0))
}

/// The mirror.
pub fn mirror() -> Mirror {
    Mirror {
        input: vec![(1, 1.0), (0, 1.0), (2, 1.0), (3, -1.0), (5, -1.0), (4, -1.0), (7, 1.0), (6, 1.0)],
        output: vec![(0, 1.0), (2, -1.0), (1, -1.0), (3, -1.0), (4, 1.0)],
    }
}

/// `matrix` with every row mirrored by one side.
pub fn mirrored(map: &[(usize, f64)], matrix: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, k| map[k].1 * matrix[(i, map[k].0)])
}

/// A smooth rule that obeys the mirror.
pub fn rule(x: &DMatrix<f64>) -> DMatrix<f64> {
    let half = |x: &DMatrix<f64>| {
        DMatrix::from_fn(x.nrows(), 5, |i, k| {
            let x = x.row(i);
            [
                (1.3 * x[0]).sin() + 0.4 * x[2] * x[7],
                0.5 * x[4] * x[1] + x[3],
                (x[0] - x[6]).cos(),
                x[3] * x[2] - 0.7 * x[5],
                0.3 * x[2] - 0.2,
            ][k]
        })
    };
    let m = mirror();
    (half(x) + mirrored(&m.output, &half(&mirrored(&m.input, x)))) * 0.5
}

/// `n` inputs, and targets with some noise.
pub fn noisy(n: usize, seed: u64) -> (DMatrix<f64>, DMatrix<f64>) {
    let x = uniform(n, 8, seed);
    let y = rule(&x) + 0.02 * uniform(n, 5, seed + 1000);
    (x, y)
}

/// The same as examples.
pub fn examples(n: usize, seed: u64, with_mirror: bool) -> Examples {
    let (x, y) = noisy(n, seed);
    Examples::new(x, y, with_mirror.then(mirror)).unwrap()
}

/// Inputs and targets followed by their mirror images, if there is a mirror.
pub fn doubled(e: &Examples) -> (DMatrix<f64>, DMatrix<f64>) {
    let Some(m) = e.mirror() else { return (e.inputs().clone(), e.targets().clone()) };
    let below = |a: &DMatrix<f64>, b: DMatrix<f64>| {
        let n = a.nrows();
        DMatrix::from_fn(2 * n, a.ncols(), |i, k| if i < n { a[(i, k)] } else { b[(i - n, k)] })
    };
    (below(e.inputs(), mirrored(&m.input, e.inputs())), below(e.targets(), mirrored(&m.output, e.targets())))
}
