//! Laws of warping paths, and every path of small series tried one by one.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::{DtwError, LONGEST_WAIT, Limits, Path, Series, align};

fn noise(frames: usize, channels: usize, seed: u64) -> Vec<f64> {
    let mut rng = Pcg64::seed_from_u64(seed);
    (0..frames * channels).map(|_| rng.random_range(-1.0..1.0)).collect()
}

fn two<'a>(a: &'a [f64], b: &'a [f64], channels: usize) -> (Series<'a>, Series<'a>) {
    (Series { values: a, channels }, Series { values: b, channels })
}

fn cost(a: &[f64], b: &[f64], channels: usize, path: &[(usize, usize)]) -> f64 {
    let square = |(i, j): (usize, usize)| -> f64 {
        (0..channels).map(|c| (a[i * channels + c] - b[j * channels + c]).powi(2)).sum()
    };
    path.iter().map(|p| square(*p)).sum()
}

/// The path is one, and its cost is the sum along it.
fn check(a: &[f64], b: &[f64], channels: usize, path: &Path, limits: Limits) {
    let (m, n) = (a.len() / channels, b.len() / channels);
    let pairs = path.pairs();
    let (first, last) = (pairs[0], *pairs.last().unwrap());
    assert!(first.0.min(first.1) == 0 && first.0.max(first.1) <= limits.loose, "{first:?}");
    assert!((m - 1 - last.0).min(n - 1 - last.1) == 0, "{last:?}");
    assert!((m - 1 - last.0).max(n - 1 - last.1) <= limits.loose, "{last:?}");
    for w in pairs.windows(2) {
        let (di, dj) = (w[1].0 - w[0].0, w[1].1 - w[0].1);
        assert!(di <= 1 && dj <= 1 && di + dj > 0, "{w:?}");
    }
    if let Some(wait) = limits.wait {
        let (of_a, of_b) = path.longest_waits();
        assert!(of_a <= wait && of_b <= wait, "{of_a} {of_b}");
    }
    if let Some(band) = limits.band {
        let (x, y) = (1.0 / (m - 1).max(1) as f64, 1.0 / (n - 1).max(1) as f64);
        for (i, j) in pairs {
            let off = (*i as f64 * x - *j as f64 * y).abs();
            assert!(off <= band as f64 * x.min(y) + 0.5 * x.max(y) + 1e-6, "{i} {j}: {off}");
        }
    }
    let sum = cost(a, b, channels, pairs);
    assert!((path.cost() - sum).abs() <= 1e-12 * sum.max(1.0), "{} {sum}", path.cost()); // 1e-15 seen
}

/// The cheapest of all paths from (i, j) on, tried one by one.
fn brute(a: &[f64], b: &[f64], limits: Limits) -> Option<f64> {
    let (m, n) = (a.len(), b.len());
    let (x, y) = (1.0 / (m - 1).max(1) as f64, 1.0 / (n - 1).max(1) as f64);
    let inside = |i: usize, j: usize| {
        limits.band.is_none_or(|w| {
            (i as f64 * x - j as f64 * y).abs() <= w as f64 * x.min(y) + 0.5 * x.max(y) + 1e-9
        })
    };
    // (i, j, steps a waited, steps b waited): a wait of one after a wait of the other needs a diagonal between
    fn walk(
        at: (usize, usize, usize, usize),
        sum: f64,
        a: &[f64],
        b: &[f64],
        limits: Limits,
        inside: &dyn Fn(usize, usize) -> bool,
        best: &mut Option<f64>,
    ) {
        let (i, j, wa, wb) = at;
        if i >= a.len() || j >= b.len() || !inside(i, j) {
            return;
        }
        let sum = sum + (a[i] - b[j]).powi(2);
        let left = (a.len() - 1 - i, b.len() - 1 - j);
        if left.0.min(left.1) == 0 && left.0.max(left.1) <= limits.loose && best.is_none_or(|b| sum < b) {
            *best = Some(sum);
        }
        walk((i + 1, j + 1, 0, 0), sum, a, b, limits, inside, best);
        let most = limits.wait.unwrap_or(usize::MAX);
        if wa < most && (wb == 0 || limits.wait.is_none()) {
            walk((i, j + 1, wa + 1, 0), sum, a, b, limits, inside, best);
        }
        if wb < most && (wa == 0 || limits.wait.is_none()) {
            walk((i + 1, j, 0, wb + 1), sum, a, b, limits, inside, best);
        }
    }
    let mut best = None;
    for s in 0..=limits.loose {
        walk((s, 0, 0, 0), 0.0, a, b, limits, &inside, &mut best);
        walk((0, s, 0, 0), 0.0, a, b, limits, &inside, &mut best);
    }
    best
}

/// Two roads to one number: dynamic programming, and every path there is.
#[test]
fn no_path_is_cheaper() {
    let mut without = 0;
    for (m, n) in [(1, 1), (1, 5), (6, 1), (6, 6), (5, 7), (7, 4), (3, 8)] {
        for seed in 0..4 {
            let (a, b) = (noise(m, 1, seed), noise(n, 1, 100 + seed));
            for band in [None, Some(0), Some(1), Some(3)] {
                for wait in [None, Some(0), Some(1), Some(2)] {
                    for loose in [0, 1, 2] {
                        let limits = Limits { band, wait, loose, piece: false };
                        let all = brute(&a, &b, limits);
                        match align(Series::one(&a), Series::one(&b), limits) {
                            Ok(path) => {
                                check(&a, &b, 1, &path, limits);
                                let least = all.expect("a path that was found");
                                let off = path.cost() - least; // 4e-16 seen
                                assert!(off.abs() < 1e-12, "{m} × {n}, {limits:?}: {off}");
                            }
                            Err(DtwError::NoPath { .. }) => {
                                assert_eq!(all, None, "{m} × {n}, {limits:?}");
                                without += 1;
                            }
                            Err(e) => panic!("{e}"),
                        }
                    }
                }
            }
        }
    }
    assert!(without > 50, "{without}"); // narrow limits leave no path for 4 × 7 frames
}

/// The cost of a pair of the exchanged series is the same.
#[test]
fn exchanged_series_cost_the_same() {
    for (seed, limits) in [
        Limits::default(),
        Limits { band: Some(7), ..Limits::default() },
        Limits { wait: Some(2), loose: 4, ..Limits::default() },
    ]
    .into_iter()
    .enumerate()
    {
        let (a, b) = (noise(60, 3, seed as u64), noise(47, 3, 9 + seed as u64));
        let (sa, sb) = two(&a, &b, 3);
        let (there, back) = (align(sa, sb, limits).unwrap(), align(sb, sa, limits).unwrap());
        check(&a, &b, 3, &there, limits);
        check(&b, &a, 3, &back, limits);
        assert!((there.cost() - back.cost()).abs() < 1e-12 * there.cost()); // 1e-15 seen
        check(&b, &a, 3, &there.exchanged(), limits);
    }
}

/// A series and itself: the diagonal, at no cost.
#[test]
fn a_series_is_its_own_partner() {
    let a = noise(80, 2, 3);
    let (s, _) = two(&a, &a, 2);
    for wait in [None, Some(3)] {
        let path = align(s, s, Limits { wait, ..Limits::default() }).unwrap();
        assert_eq!(path.cost(), 0.0);
        assert!(path.pairs().iter().all(|(i, j)| i == j));
        assert!(path.partners_of_a().iter().enumerate().all(|(i, p)| *p == i as f64));
    }
}

/// Wider limits never cost more, and the widest are none.
#[test]
fn wider_limits_cost_less() {
    let (a, b) = (noise(90, 1, 5), noise(70, 1, 6));
    let cost = |limits| align(Series::one(&a), Series::one(&b), limits).unwrap().cost();
    let free = cost(Limits::default());
    for axis in 0..3 {
        let mut last = f64::INFINITY;
        for size in [1, 2, 5, 20, 63] {
            let now = cost(match axis {
                0 => Limits { band: Some(size), ..Limits::default() },
                1 => Limits { wait: Some(size), ..Limits::default() },
                _ => Limits { wait: Some(2), loose: size, ..Limits::default() },
            });
            assert!(now <= last, "{axis} {size}: {now} {last}");
            last = now;
        }
        assert!(axis == 2 || (last - free).abs() < 1e-12 * free, "{axis}: {last} {free}"); // 0 seen
    }
}

/// A motion retimed by a known map is found again, whatever channels it has.
#[test]
fn a_known_time_map_is_found() {
    let motion = |t: f64| [(2.0 * t).sin(), (3.1 * t + 0.4).cos(), 0.3 * t];
    let map = |t: f64| t + 0.35 * t.sin();
    let a: Vec<f64> = (0..300).flat_map(|i| motion(map(0.02 * i as f64))).collect();
    let last = map(0.02 * 299.0);
    let b: Vec<f64> = (0..=(last / 0.02) as usize).flat_map(|i| motion(0.02 * i as f64)).collect();
    let (sa, sb) = two(&a, &b, 3);
    let path = align(sa, sb, Limits { wait: Some(2), ..Limits::default() }).unwrap();
    let worst = path
        .partners_of_a()
        .iter()
        .enumerate()
        .map(|(i, p)| (p - map(0.02 * i as f64) / 0.02).abs())
        .fold(0.0, f64::max);
    assert!(worst <= 1.0, "{worst} frames"); // 0.5 seen: partners are whole frames
}

/// A piece of a series is found in it when ends may be loose.
#[test]
fn loose_ends_find_a_piece() {
    let whole = noise(50, 1, 8);
    let path =
        align(Series::one(&whole[12..40]), Series::one(&whole), Limits { loose: 15, ..Limits::default() })
            .unwrap();
    assert_eq!(path.cost(), 0.0);
    assert_eq!(path.pairs()[0], (0, 12));
    let partners = path.partners_of_b();
    assert_eq!((partners[12], partners[20], partners[0], partners[49]), (0.0, 8.0, 0.0, 27.0));
}

/// A piece is found wherever it is, however long the whole; its own ends stay bound.
#[test]
fn a_piece_is_found_in_the_whole() {
    let whole = noise(400, 2, 21);
    let piece: Vec<f64> = whole[2 * 230..2 * 290].to_vec();
    let (a, b) = two(&piece, &whole, 2);
    for wait in [None, Some(1)] {
        let limits = Limits { wait, piece: true, ..Limits::default() };
        let path = align(a, b, limits).unwrap();
        assert_eq!((path.cost(), path.pairs()[0], *path.pairs().last().unwrap()), (0.0, (0, 230), (59, 289)));
        // the other way round the whole has to be matched, and is not
        assert!(align(b, a, Limits { piece: true, ..Limits::default() }).unwrap().cost() > 1.0);
    }
}

/// What cannot be aligned says why.
#[test]
fn bad_series_are_refused() {
    let one = Series::one;
    let free = Limits::default();
    let said = |a: Series, b: Series, limits| align(a, b, limits).unwrap_err().to_string();
    assert_eq!(said(one(&[]), one(&[1.0]), free), "series a has no frames");
    let nan = [0.0, f64::NAN];
    assert_eq!(said(one(&[1.0]), one(&nan), free), "series b, frame 1, channel 0 is NaN");
    let three = [0.0, 1.0, 2.0];
    assert_eq!(
        said(Series { values: &three, channels: 2 }, one(&three), free),
        "series a has 3 values, which do not fill frames of 2 channels"
    );
    assert_eq!(
        said(Series { values: &three, channels: 3 }, one(&three), free),
        "series a has 3 channels, series b 1: they are compared channel by channel"
    );
    let long = noise(200, 1, 1);
    assert_eq!(
        said(one(&three), one(&long), Limits { wait: Some(2), ..free }),
        "3 and 200 frames cannot be matched with a wait of at most 2 steps, 0 loose frames at each end"
    );
    assert_eq!(
        said(one(&three), one(&long), Limits { wait: Some(LONGEST_WAIT + 1), ..free }),
        "a wait of at most 64 steps: a limit is 0 to 63, or none (200 frames cannot wait longer)"
    );
}
