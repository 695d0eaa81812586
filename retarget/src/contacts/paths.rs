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
//! *One link, one correction.* A heel that flies while its ball rests is carried by the ball's correction: with one of
//! its own it would disagree with the ball by centimetres, and the foot would jump when the ball leaves. So c
//! above is the path of the point with its link carried along, c + D, D the mean correction of the link's resting points.
//!
//! *Floor.* A height below 0 in flight is compressed to y/√(1 + (y/δ)²): never deeper than δ = 4 mm, and equal
//! to y to second order at 0, where phases begin and end.
//!
//! \[YAH10\] Yamane, Ariki, Hodgins. Animating Non-Humanoid Characters with Human Motion Data, SCA 2010.

use motion::{Vec3, smoothstep};

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
/// Time in which a resting point comes to count for its link, s.
const FADE_S: f64 = 0.1;
/// Depth that a flying point approaches but never reaches, m.
pub const FLOOR_M: f64 = 0.004;

/// The paths that hold every point in its phases. A point without phases keeps its path (above the floor).
pub fn held_paths(puppet: &Puppet, paths: &[Path], spans: &[Vec<Span>], rate_hz: f64) -> Vec<Path> {
    let places = places(puppet, paths, spans);
    let carried = carried(puppet, paths, spans, &places, rate_hz);
    let mut out = paths.to_vec();
    for (c, path) in out.iter_mut().enumerate() {
        let source: Path = paths[c].iter().zip(&carried[c]).map(|(p, d)| p + d).collect();
        hold(path, &source, &spans[c], &places[c], rate_hz);
    }
    out
}

/// For each point the correction that its link has, D: the mean of the corrections of the link's resting points, each
/// fading in and out within its phase; bridged where none rests.
fn carried(
    puppet: &Puppet,
    paths: &[Path],
    spans: &[Vec<Span>],
    places: &[Vec<Vec3>],
    rate_hz: f64,
) -> Vec<Path> {
    let sites = puppet.character.skeleton.sites();
    let link = |c: usize| sites[puppet.contacts[c].site].link;
    let fade = (FADE_S * rate_hz).round().max(1.0);
    let of_link = |l: usize| {
        let mut sum = vec![(Vec3::zeros(), 0.0); paths[0].len()];
        for c in (0..paths.len()).filter(|&c| link(c) == l) {
            for (s, place) in spans[c].iter().zip(&places[c]) {
                for i in s.first..=s.last {
                    let inside = (i - s.first).min(s.last - i) as f64 + 0.5;
                    let weight = smoothstep(inside / fade);
                    sum[i].0 += (place - paths[c][i]) * weight;
                    sum[i].1 += weight;
                }
            }
        }
        let known: Vec<Option<Vec3>> = sum.iter().map(|(d, w)| (*w > 0.0).then(|| d / *w)).collect();
        bridge(&known, rate_hz)
    };
    (0..paths.len()).map(|c| of_link(link(c))).collect()
}

/// A path known in some frames, led on through the others without a jump in place or rate.
fn bridge(known: &[Option<Vec3>], rate_hz: f64) -> Path {
    let n = known.len();
    let rate = |i: usize, j: usize| match (known.get(i).copied().flatten(), known.get(j).copied().flatten()) {
        (Some(a), Some(b)) => (b - a) * rate_hz,
        _ => Vec3::zeros(),
    };
    let mut out = vec![Vec3::zeros(); n];
    let mut i = 0;
    while i < n {
        if let Some(d) = known[i] {
            out[i] = d;
            i += 1;
            continue;
        }
        let run = known[i..].iter().take_while(|k| k.is_none()).count();
        let (a, b) = (i.checked_sub(1), (i + run < n).then_some(i + run));
        let end = |at: usize, rate: Vec3| End { shift: known[at].unwrap_or_default(), rate };
        let from = a.map(|a| (a, end(a, rate(a.wrapping_sub(1), a))));
        let to = b.map(|b| (b, end(b, rate(b, b + 1))));
        for (j, x) in out.iter_mut().enumerate().take(i + run).skip(i) {
            *x = between(j, from, to, rate_hz);
        }
        i += run;
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
    let mut fly = |frames: std::ops::Range<usize>, from: Option<(usize, End)>, to: Option<(usize, End)>| {
        for i in frames {
            path[i] = source[i] + between(i, from, to, rate_hz);
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

/// Δ at frame `i` of a flight between two ends, of which one may be missing. See the module header.
fn between(i: usize, from: Option<(usize, End)>, to: Option<(usize, End)>, rate_hz: f64) -> Vec3 {
    let (mut shift, length_s) = match (&from, &to) {
        (Some((a, x)), Some((b, y))) => {
            let s = (i - a) as f64 / (b - a) as f64;
            let way = (y.shift - x.shift) * (s * s * s * (10.0 - 15.0 * s + 6.0 * s * s));
            (x.shift + way, (b - a) as f64 / rate_hz)
        }
        (Some((_, x)), None) | (None, Some((_, x))) => (x.shift, f64::INFINITY),
        (None, None) => return Vec3::zeros(),
    };
    let t = length_s.min(BRAKE_S);
    // mirrored in time at the far end: the rate changes sign
    for (side, sign) in [(&from, 1.0), (&to, -1.0)] {
        let Some((at, e)) = side else { continue };
        let s = i.abs_diff(*at) as f64 / rate_hz / t;
        if s < 1.0 {
            shift += e.rate * (sign * t * s * (1.0 - s).powi(3) * (1.0 + 3.0 * s));
        }
    }
    shift
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
