//! Whether a series repeats itself, and after how long.

/// A period, and how well it repeats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Period {
    /// s.
    pub seconds: f64,
    /// Correlation of the series with itself one period later, 0 to 1.
    pub correlation: f64,
}

/// Shortest period that is looked for, s.
const SHORTEST_S: f64 = 0.3;
/// Less correlation is no period.
const LEAST: f64 = 0.5;

/// The period of a series: the lag of the highest peak of its autocorrelation (of overlapping parts), from 0.3 s to seven
/// tenths of its length; of peaks within 90 % of the highest the first, so that two periods are not taken for one. Peaks count
/// by the root of the share that overlaps: little that overlaps correlates by chance.
pub fn period(x: &[f64], rate_hz: f64) -> Option<Period> {
    let n = x.len();
    let correlation = |lag: usize| {
        let (a, b) = (&x[..n - lag], &x[lag..]);
        let mean = |s: &[f64]| s.iter().sum::<f64>() / s.len() as f64;
        let (ma, mb) = (mean(a), mean(b));
        let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
        for (p, q) in a.iter().zip(b) {
            ab += (p - ma) * (q - mb);
            aa += (p - ma).powi(2);
            bb += (q - mb).powi(2);
        }
        if aa > 0.0 && bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 }
    };
    let first = (SHORTEST_S * rate_hz).ceil() as usize;
    let last = 7 * n / 10;
    if first < 1 || last < first + 2 {
        return None;
    }
    let all: Vec<f64> =
        (first - 1..=last + 1).map(|lag| if lag < n - 1 { correlation(lag) } else { 0.0 }).collect();
    let peaks: Vec<(usize, f64)> = (1..all.len() - 1)
        .filter(|i| all[*i] >= all[i - 1] && all[*i] > all[i + 1] && all[*i] > LEAST)
        .map(|i| (first - 1 + i, all[i]))
        .collect();
    let worth = |p: &(usize, f64)| p.1 * ((n - p.0) as f64 / n as f64).sqrt();
    let highest = peaks.iter().map(worth).fold(0.0, f64::max);
    let (lag, correlation) = *peaks.iter().find(|p| worth(p) >= 0.9 * highest)?;
    Some(Period { seconds: lag as f64 / rate_hz, correlation })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sine has its period; a ramp and a pulse have none.
    #[test]
    fn what_repeats_has_a_period() {
        let wave: Vec<f64> = (0..600).map(|i| (std::f64::consts::TAU * i as f64 / 72.0).sin()).collect();
        let p = period(&wave, 60.0).unwrap();
        assert!((p.seconds - 1.2).abs() < 1e-9 && p.correlation > 0.999, "{p:?}");
        let pulse: Vec<f64> = (0..600).map(|i| (-((i as f64 - 200.0) / 20.0).powi(2)).exp()).collect();
        assert_eq!(period(&pulse, 60.0), None);
        assert_eq!(period(&[1.0, 2.0], 60.0), None);
    }
}
