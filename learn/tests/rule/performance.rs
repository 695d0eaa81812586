//! A known nonlinear map from human angles to the angles of a lamp: ground truth for what is learned.
//!
//! The human has twelve joint angles; four of them move freely (trunk bend a, knee bend k, arm raise s, head
//! nod h), the others follow as in a synergy. With a, k, s, h in rad the lamp's five hinges are
//!
//! base = 0.6 sin 2a + 1.5 k s,  lower = −0.5 k + 1.6 s h,  upper = 1.6 a h + 0.6 sin 2k,
//! neck = 0.9 sin(a + 1.5 s),  shade = 1.4 h k + 0.5 sin 2h.
//!
//! A performance is a sum of two sines per free angle, all frequencies incommensurate, within ±0.75 rad.

use nalgebra::DMatrix;

/// Frequencies (Hz) and phases of the free angles in a performance.
fn free(angle: usize, t: f64, take: u64) -> f64 {
    let slow = [0.31, 0.23, 0.37, 0.29][angle];
    let phase = 1.7 * angle as f64 + 0.9 * take as f64;
    let wave = |f: f64, p: f64| (std::f64::consts::TAU * f * t + p).sin();
    0.45 * wave(slow, phase) + 0.3 * wave(2.0_f64.sqrt() * slow + 0.11, 2.3 * phase + 0.4)
}

/// Human angles (12) of the free ones.
fn human([a, k, s, h]: [f64; 4]) -> [f64; 12] {
    [
        a,
        k,
        s,
        h,
        0.5 * a,
        0.5 * a + 0.2 * k,
        -0.6 * k,
        0.4 * k,
        0.8 * s,
        -0.3 * s + 0.1 * a,
        0.4 * h,
        0.3 * s.sin(),
    ]
}

/// The rule.
fn lamp([a, k, s, h]: [f64; 4]) -> [f64; 5] {
    [
        0.6 * (2.0 * a).sin() + 1.5 * k * s,
        -0.5 * k + 1.6 * s * h,
        1.6 * a * h + 0.6 * (2.0 * k).sin(),
        0.9 * (a + 1.5 * s).sin(),
        1.4 * h * k + 0.5 * (2.0 * h).sin(),
    ]
}

/// `frames` frames at 30 Hz of a take: human (F × 12) and lamp (F × 5), rad.
pub fn performance(frames: usize, take: u64) -> (DMatrix<f64>, DMatrix<f64>) {
    let at = |i: usize| std::array::from_fn(|angle| free(angle, i as f64 / 30.0, take));
    let (mut y, mut z) = (DMatrix::zeros(frames, 12), DMatrix::zeros(frames, 5));
    for i in 0..frames {
        y.row_mut(i).copy_from_slice(&human(at(i)));
        z.row_mut(i).copy_from_slice(&lamp(at(i)));
    }
    (y, z)
}

/// `count` rows, each the farthest from those before; the first is the farthest from the mean.
pub fn farthest(y: &DMatrix<f64>, count: usize) -> Vec<usize> {
    let mean = y.row_mean();
    let mut distance: Vec<f64> = (0..y.nrows()).map(|i| (y.row(i) - &mean).norm()).collect();
    let mut chosen = Vec::new();
    for round in 0..count {
        let far = (0..y.nrows()).max_by(|&a, &b| distance[a].total_cmp(&distance[b])).unwrap();
        chosen.push(far);
        for i in 0..y.nrows() {
            let d = (y.row(i) - y.row(far)).norm();
            distance[i] = if round == 0 { d } else { distance[i].min(d) };
        }
    }
    chosen
}
