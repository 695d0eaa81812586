use std::sync::Arc;

use super::*;
use crate::rotation::{exp, log};
use crate::{Link, Vec3};

fn skeleton() -> Arc<Skeleton> {
    let ball = Link::new("ball", Some(0), Vec3::y(), Joint::Spherical);
    let hinge = Link::new("hinge", Some(1), Vec3::y(), Joint::Revolute(Vec3::x()));
    let root = Link::new("root", None, Vec3::zeros(), Joint::Free);
    Arc::new(Skeleton::new(vec![root, ball, hinge]).unwrap())
}

/// Uniform numbers in (−1, 1) from a seed (SplitMix64).
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Standard normal, by twelve uniforms.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() * 0.5
    }
}

/// A wandering root, a ball and a hinge: coordinates of the motion at a time.
fn wander(t: f64) -> [Vec3; 4] {
    let s = |a: f64, f: f64, p: f64| a * (std::f64::consts::TAU * f * t + p).sin();
    [
        Vec3::new(1.2 * t, 0.9 + s(0.03, 1.8, 0.4), s(0.04, 0.9, 1.0)),
        Vec3::new(s(0.1, 0.9, 0.0), s(0.15, 0.9, 2.0) + 0.3 * t, s(0.05, 1.8, 0.5)),
        Vec3::new(s(0.5, 0.9, 0.3) + s(0.08, 2.7, 1.0), s(0.2, 1.8, 1.1), s(0.3, 0.9, 2.2)),
        Vec3::new(0.6 + s(0.5, 0.9, 1.5) + s(0.2, 1.8, 0.1) + s(0.06, 3.6, 0.7), 0.0, 0.0),
    ]
}

fn clip(rate: f64, frames: usize, mut noise: impl FnMut() -> f64) -> Clip {
    let s = skeleton();
    let mut q = Vec::new();
    for k in 0..frames {
        let [p, r, ball, hinge] = wander(k as f64 / rate);
        let mut shaken = |v: Vec3, scale: f64| v + Vec3::from_fn(|_, _| scale * noise());
        let mut pose = s.zero_pose();
        s.set_position(&mut pose, 0, &shaken(p, 0.25));
        s.set_rotation(&mut pose, 0, &exp(&shaken(r, 1.0)));
        s.set_rotation(&mut pose, 1, &exp(&shaken(ball, 1.0)));
        pose[s.q_at(2)] = shaken(hinge, 1.0).x;
        q.extend(pose);
    }
    Clip::new(s, rate, q)
}

fn rms(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
}

/// A fall and an ever faster spin are not touched, at the ends neither, however strong the smoothing.
#[test]
fn constant_acceleration_is_exact() {
    let s = skeleton();
    let rate = 100.0;
    let axis = Vec3::new(1.0, 2.0, -1.0).normalize();
    let mut q = Vec::new();
    for k in 0..60 {
        let t = k as f64 / rate;
        let mut pose = s.zero_pose();
        s.set_position(&mut pose, 0, &Vec3::new(t, 2.0 - 4.9 * t * t, 0.0));
        s.set_rotation(&mut pose, 1, &exp(&(axis * (0.5 * t + 3.0 * t * t))));
        pose[s.q_at(2)] = 1.0 - t * t;
        q.extend(pose);
    }
    let given = Clip::new(s, rate, q);
    for hz in [0.5, 5.0, 20.0] {
        let out = smooth(&given, Smoothing::CutoffHz(hz));
        assert!(rms(out.clip.data(), given.data()) < 1e-12, "{hz}"); // 2e-15 seen
        for k in [0, 1, 2, 30, 57, 58, 59] {
            let t = k as f64 / rate;
            let (v, vd) = (&out.derivatives.v[k * 10..], &out.derivatives.vd[k * 10..]);
            assert!((v[1] + 9.8 * t).abs() < 1e-10 && (vd[1] + 9.8).abs() < 1e-8);
            for i in 0..3 {
                assert!((v[6 + i] - axis[i] * (0.5 + 6.0 * t)).abs() < 1e-10);
                assert!((vd[6 + i] - axis[i] * 6.0).abs() < 1e-8);
            }
        }
    }
}

/// Displacements of slides and of the root add up.
#[test]
fn smoothing_is_linear() {
    let mut random = Random(7);
    let y: Vec<f64> = (0..200).map(|_| random.normal()).collect();
    let z: Vec<f64> = (0..200).map(|k| (k as f64 * 0.1).sin()).collect();
    let w = Whittaker::new(100, lambda(4.0, 60.0));
    let sum: Vec<f64> = y.iter().zip(&z).map(|(a, b)| 2.0 * a - 3.0 * b).collect();
    let (fy, fz, fs) = (w.smooth(&y, 2), w.smooth(&z, 2), w.smooth(&sum, 2));
    for i in 0..200 {
        let error = fs[i] - (2.0 * fy[i] - 3.0 * fz[i]);
        assert!(error.abs() < 1e-11, "{i}: {error}"); // 2e-12 seen
    }
}

/// Turning the whole motion turns the answer; playing it backwards plays the answer backwards, with the
/// velocities reversed.
#[test]
fn smoothing_turns_and_reverses_with_the_motion() {
    let mut random = Random(11);
    let given = clip(60.0, 120, || 0.01 * random.normal());
    let out = smooth(&given, Smoothing::Auto);
    let s = given.skeleton.clone();
    let turn = exp(&Vec3::new(0.7, -1.1, 2.0));
    let mut turned = given.clone();
    let mut reversed = given.clone();
    for k in 0..120 {
        let p = given.pose(k);
        let (at, r) = (s.position(p, 0), s.rotation(p, 0));
        s.set_position(turned.pose_mut(k), 0, &(turn * at));
        s.set_rotation(turned.pose_mut(k), 0, &(turn * r));
        // from the right, too: what the ball carries
        let ball = s.rotation(p, 1) * turn;
        s.set_rotation(turned.pose_mut(k), 1, &ball);
        reversed.pose_mut(k).copy_from_slice(given.pose(119 - k));
    }
    let (a, b) = (smooth(&turned, Smoothing::Auto), smooth(&reversed, Smoothing::Auto));
    assert!((a.report.cutoff_hz - out.report.cutoff_hz).abs() < 1e-9);
    let mut reverse = 0.0;
    for k in 0..120 {
        let (p, q) = (out.clip.pose(k), a.clip.pose(k));
        let error = log(&(s.rotation(q, 0) * (turn * s.rotation(p, 0)).inverse())).norm()
            + log(&(s.rotation(q, 1) * (s.rotation(p, 1) * turn).inverse())).norm()
            + (s.position(q, 0) - turn * s.position(p, 0)).norm();
        assert!(error < 1e-12, "{k}: {error}"); // 1e-15 seen
        for i in 0..10 {
            let (v, w) = (out.derivatives.v[k * 10 + i], b.derivatives.v[(119 - k) * 10 + i]);
            reverse = f64::max(reverse, (v + w).abs());
        }
    }
    assert!(reverse < 1e-11, "{reverse}"); // 1e-14 seen
}

/// Two Gauss–Newton steps are enough: more change nothing that could be seen, at noise of a degree and a
/// cut-off that costs the motion its swing.
#[test]
fn two_steps_are_enough() {
    let mut random = Random(3);
    let given = clip(60.0, 200, || 0.02 * random.normal());
    for hz in [1.0, 3.0, 6.0] {
        let path = |steps| smoothed_path(&given, lambda(hz, 60.0), steps);
        let (first, second, many) = (path(1), path(STEPS), path(8));
        let [a, b] = [&first, &second].map(|c| rms(c.data(), many.data()));
        // 2.2e-3 and 2.8e-4 seen at 1 Hz, 9.5e-5 and 3.6e-6 at 6 Hz, in quaternions and radians
        assert!(b < 1e-3 && b < 0.2 * a, "{hz}: {a} {b}");
    }
}

/// What smoothing takes off noise in the accelerations is within 1.3 of the best cut-off there is, for
/// white and for coloured noise, at any rate, without being told any of them.
#[test]
fn slow_the_chosen_strength_is_nearly_the_best() {
    let mut worst = (0.0, String::new());
    for rate in [30.0, 60.0, 100.0, 120.0, 240.0] {
        let frames = (5.0 * rate) as usize;
        let clean = Derivatives::central(&clip(8.0 * rate, 8 * frames, || 0.0));
        let truth: Vec<f64> = clean.vd.chunks_exact(10).step_by(8).take(frames).flatten().copied().collect();
        for size in [3e-4, 1e-3, 3e-3, 1e-2] {
            for colour in [0.0_f64, 0.5, 0.8] {
                let mut random = Random(rate as u64 * 1000 + (size * 1e5) as u64 + (colour * 10.0) as u64);
                // ten numbers per frame: each remembers its own last value
                let mut last = [0.0; 12];
                let mut at = 0;
                let given = clip(rate, frames, || {
                    at = (at + 1) % 12;
                    last[at] = colour * last[at] + (1.0 - colour * colour).sqrt() * random.normal();
                    size * last[at]
                });
                // a quarter of a second at each end has data on one side only: measured apart
                let edge = (0.25 * rate) as usize * 10;
                let error = |hz: f64| {
                    let vd = smooth(&given, Smoothing::CutoffHz(hz)).derivatives.vd;
                    rms(&vd[edge..vd.len() - edge], &truth[edge..truth.len() - edge])
                };
                let auto = smooth(&given, Smoothing::Auto);
                let hz = auto.report.cutoff_hz;
                let found = error(hz);
                let oracle = (0..40).map(|i| 1.0 * (0.45 * rate).powf(f64::from(i) / 39.0));
                let (best, at) = oracle
                    .map(|hz| (error(hz), hz))
                    .fold((f64::INFINITY, 0.0), |a, b| if b.0 < a.0 { b } else { a });
                let ratio = found / best;
                let what = format!(
                    "{rate} Hz, noise {size} rad, colour {colour}: {hz:.1} Hz (best {at:.1}), ratio {ratio:.3}, left {:.2}/{found:.2}",
                    rms(&auto.report.acceleration_noise, &[0.0; 10])
                );
                if ratio > worst.0 {
                    worst = (ratio, what);
                }
            }
        }
    }
    assert!(worst.0 < 1.3, "{}", worst.1); // 1.05 seen
}

/// Motion without noise keeps its accelerations: nothing within its band is taken.
#[test]
fn noiseless_motion_is_left_alone() {
    for rate in [30.0, 60.0, 120.0, 240.0] {
        let given = clip(rate, (4.0 * rate) as usize, || 0.0);
        let out = smooth(&given, Smoothing::Auto);
        let kept = Derivatives::central(&given);
        let size = rms(&kept.vd, &vec![0.0; kept.vd.len()]);
        let edge = (0.25 * rate) as usize * 10;
        let inner = edge..kept.vd.len() - edge;
        let error = rms(&out.derivatives.vd, &kept.vd) / size;
        let inside = rms(&out.derivatives.vd[inner.clone()], &kept.vd[inner]) / size;
        // 3e-5 and 3e-3 seen: at the ends third differences are held down
        assert!(inside < 1e-4 && error < 1e-2, "{rate}: {inside} {error}");
    }
}

/// Short clips are differentiated, not smoothed; no cut-off breaks anything.
#[test]
fn short_clips_are_not_smoothed() {
    for frames in 1..20 {
        let out = smooth(&clip(60.0, frames, || 0.0), Smoothing::Auto);
        assert!(out.derivatives.vd.iter().chain(&out.report.noise).all(|x| x.is_finite()));
        if frames < strength::LEAST_FRAMES {
            assert!(out.report.cutoff_hz.is_infinite());
        }
        for hz in [-1.0, 0.0, 1e-9, 1.0, 29.9, 30.0, f64::INFINITY] {
            let out = smooth(&clip(60.0, frames, || 0.0), Smoothing::CutoffHz(hz));
            assert!(out.clip.data().iter().chain(&out.noise_sample).all(|x| x.is_finite()), "{frames} {hz}");
            assert!(out.report.cutoff_hz >= 0.1);
        }
    }
}

/// The ends are noisier than the middle, because data lie on one side only, but nothing rings: within one
/// period of the cut-off the noise of the acceleration has come down to that of the middle.
#[test]
fn ends_settle_within_a_period() {
    let (frames, hz, rate) = (400, 6.0, 120.0);
    let filter = Whittaker::new(frames, lambda(hz, rate));
    // variance of Δ²z at frame k for unit white noise: the row of the operator, by symmetry of A
    let spread = |k: usize| {
        let mut row = vec![0.0; frames];
        (row[k - 1], row[k], row[k + 1]) = (1.0, -2.0, 1.0);
        let row = filter.smooth(&row, 1);
        row.iter().map(|x| x * x).sum::<f64>().sqrt()
    };
    let middle = spread(200);
    let period = (rate / hz) as usize;
    let worst = (1..period).map(|k| spread(k) / middle).fold(0.0, f64::max);
    assert!(worst < 3.0, "{worst}"); // 2.4 seen, in the first frame
    assert!((period..100).all(|k| (spread(k) / middle - 1.0).abs() < 0.02)); // 0.009 seen
}

/// The strongest smoothing there is leaves a parabola, and to many digits the one of least squares.
#[test]
fn the_strongest_smoothing_is_a_parabola() {
    let (frames, rate) = (60, 60.0);
    let mut random = Random(1);
    let y: Vec<f64> = (0..frames).map(|k| 0.01 * f64::from(k * k) + random.normal()).collect();
    let z = Whittaker::new(60, lambda(rate / 600.0, rate)).smooth(&y, 1);
    let basis = nalgebra::DMatrix::from_fn(60, 3, |k, i| (k as f64 / 60.0 - 0.5).powi(i as i32));
    let y = nalgebra::DVector::from_vec(y);
    let fit = &basis * (basis.transpose() * &basis).try_inverse().unwrap() * basis.transpose() * y;
    let error = (0..60).map(|k| (z[k] - fit[k]).abs()).fold(0.0, f64::max);
    assert!(error < 2e-3, "{error}"); // 3e-4 seen
}
