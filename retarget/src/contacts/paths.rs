//! Where each contact point has to be, in every frame.
//!
//! In: the paths of the points as the motion has them, and their phases. Out: the paths to follow.
//!
//! *In a phase* a point stays at the floor projection of its mean there. Points of one link whose phases
//! overlap keep their distances: the places of a heel and a ball that rest one after the other are moved
//! together or apart, by the least squares, until the sole fits.
//!
//! *In flight* the correction Δ goes from that of the phase before to that of the phase after. \[YAH10\] (9)
//! blends it with h²(3 − 2h), which matches positions only: the point still has the speed of the source at
//! touchdown (0.1 to 0.4 m/s were measured) and stops dead. Here c + Δ starts and ends at rest: with
//! s = (t − t₀)/T over the flight and s' over T' = min(T, 0.2 s) from either end,
//!
//! ```text
//! Δ = Δ₀ + (Δ₁ − Δ₀) s³(10 − 15s + 6s²) + Δ̇₀ T' H(s') + the same mirrored at the other end
//! H = s(1 − s)³(1 + 3s)
//! ```
//!
//! Both quintics match position and rate at both ends and add no acceleration there. To take the source's acceleration
//! away too (a further quintic, ½ s²(1 − s)³) was tried: 40 m/s² at a heel's touchdown then have to be made up
//! for in flight, and the jerk near the ends of a walk's phases rose from 1.1 to 1.3 times the source's; so it did with
//! longer T'. Before the first phase and after the last Δ is that of the phase, but for its rate.
//!
//! *Floor.* A height below 0 in flight is compressed to y/√(1 + (y/δ)²): never deeper than δ = 4 mm, and equal
//! to y to second order at 0, where phases begin and end.
//!
//! \[YAH10\] Yamane, Ariki, Hodgins. Animating Non-Humanoid Characters with Human Motion Data, SCA 2010.

use motion::Vec3;

use crate::Puppet;

/// World positions of a point, one per frame, m.
pub type Path = Vec<Vec3>;

/// Frames of a phase, ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// First frame in contact.
    pub first: usize,
    /// Last frame in contact.
    pub last: usize,
}

/// Longest time in which speed is brought to rest, s.
pub const BRAKE_S: f64 = 0.2;
/// Depth that a flying point approaches but never reaches, m.
pub const FLOOR_M: f64 = 0.004;

/// The paths that hold every point in its phases. A point without phases keeps its path (above the floor).
pub fn held_paths(puppet: &Puppet, paths: &[Path], spans: &[Vec<Span>], rate_hz: f64) -> Vec<Path> {
    let places = places(puppet, paths, spans);
    let mut out = paths.to_vec();
    for (((path, source), spans), places) in out.iter_mut().zip(paths).zip(spans).zip(&places) {
        hold(path, source, spans, places, rate_hz);
    }
    out
}

/// Where each point rests in each of its phases, on the floor.
fn places(puppet: &Puppet, paths: &[Path], spans: &[Vec<Span>]) -> Vec<Vec<Vec3>> {
    let mean = |p: &[Vec3]| p.iter().sum::<Vec3>() / p.len() as f64;
    let mut places: Vec<Vec<Vec3>> = paths
        .iter()
        .zip(spans)
        .map(|(path, spans)| {
            let on_floor = |s: &Span| mean(&path[s.first..=s.last]).component_mul(&Vec3::new(1.0, 0.0, 1.0));
            spans.iter().map(on_floor).collect()
        })
        .collect();
    // pairs of phases of one link that overlap, and the distance of their points
    let sites = puppet.character.skeleton.sites();
    let mut ties = Vec::new();
    for a in 0..spans.len() {
        for b in 0..a {
            let (p, q) = (&sites[puppet.contacts[a].site], &sites[puppet.contacts[b].site]);
            if p.link != q.link {
                continue;
            }
            for (i, s) in spans[a].iter().enumerate() {
                for (j, t) in spans[b].iter().enumerate() {
                    if s.first <= t.last && t.first <= s.last {
                        ties.push(((a, i), (b, j), (p.at - q.at).norm()));
                    }
                }
            }
        }
    }
    // Each pass moves both ends of every tie half way; they meet within a few passes.
    for _ in 0..2000 {
        let mut worst: f64 = 0.0;
        for &((a, i), (b, j), length) in &ties {
            let apart = places[a][i] - places[b][j];
            let distance = apart.norm();
            if distance < 1e-9 {
                continue;
            }
            let shift = apart * (0.5 * (length - distance) / distance);
            places[a][i] += shift;
            places[b][j] -= shift;
            worst = worst.max((length - distance).abs());
        }
        if worst < 1e-10 {
            break;
        }
    }
    places
}

/// Δ and Δ̇ at an end of a flight.
#[derive(Clone, Copy)]
struct End {
    shift: Vec3,
    rate: Vec3,
}

fn hold(path: &mut Path, source: &Path, spans: &[Span], places: &[Vec3], rate_hz: f64) {
    let (Some(first), Some(last)) = (spans.first(), spans.last()) else {
        path.iter_mut().for_each(|p| p.y = floored(p.y));
        return;
    };
    for (s, place) in spans.iter().zip(places) {
        path[s.first..=s.last].fill(*place);
    }
    // at rest in the phase: the speed that the source has there is taken away
    let end = |frame: usize, place: &Vec3| End {
        shift: place - source[frame],
        rate: -rate_at(source, frame, rate_hz),
    };
    let brake = |seconds: f64| seconds.min(BRAKE_S);
    let mut fly = |frames: std::ops::Range<usize>, from: Option<(usize, End)>, to: Option<(usize, End)>| {
        for i in frames {
            let mut shift = Vec3::zeros();
            let length = match (&from, &to) {
                (Some((a, x)), Some((b, y))) => {
                    let s = (i - a) as f64 / (b - a) as f64;
                    shift += x.shift + (y.shift - x.shift) * (s * s * s * (10.0 - 15.0 * s + 6.0 * s * s));
                    (b - a) as f64 / rate_hz
                }
                (Some((_, x)), None) | (None, Some((_, x))) => {
                    shift += x.shift;
                    f64::INFINITY
                }
                (None, None) => 0.0,
            };
            let t = brake(length);
            // mirrored in time at the far end: rates change sign
            for (side, sign) in [(&from, 1.0), (&to, -1.0)] {
                let Some((at, e)) = side else { continue };
                let s = i.abs_diff(*at) as f64 / rate_hz / t;
                if s < 1.0 {
                    shift += e.rate * (sign * t * s * (1.0 - s).powi(3) * (1.0 + 3.0 * s));
                }
            }
            path[i] = source[i] + shift;
            path[i].y = floored(path[i].y);
        }
    };
    fly(0..first.first, None, Some((first.first, end(first.first, &places[0]))));
    for (i, w) in spans.windows(2).enumerate() {
        let (from, to) = (w[0].last, w[1].first);
        fly(from + 1..to, Some((from, end(from, &places[i]))), Some((to, end(to, &places[i + 1]))));
    }
    let from = last.last;
    fly(from + 1..source.len(), Some((from, end(from, &places[places.len() - 1]))), None);
}

/// Height kept above −[`FLOOR_M`].
pub(crate) fn floored(y: f64) -> f64 {
    if y < 0.0 { y / (1.0 + (y / FLOOR_M).powi(2)).sqrt() } else { y }
}

/// Velocity of a sampled path by central differences, of second order at the ends too.
fn rate_at(p: &Path, i: usize, rate_hz: f64) -> Vec3 {
    let n = p.len();
    if n < 3 {
        return Vec3::zeros();
    }
    let m = i.clamp(1, n - 2);
    let bend = p[m + 1] - p[m] * 2.0 + p[m - 1];
    ((p[m + 1] - p[m - 1]) * 0.5 + bend * (i as f64 - m as f64)) * rate_hz
}
