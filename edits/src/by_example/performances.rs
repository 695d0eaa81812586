//! Pairs from two performances: the same content played twice, frame by frame on each other.
//!
//! In: two clips of one rig, such as a walk and the same walk crouched. Out: for every frame of the first the moment of the second
//! that belongs to it, and a [`Pair`] of equally many frames. Pairs of IAF09's comparison with Hsu et al. (Style translation for human
//! motion, 2005) are made so: by motion warping instead of by hand.
//!
//! Frames are compared by their [`Features`]: points of the body now, 0.125 s before and after, in the heading frame; so
//! velocities count, and a leg that passes forward is not one that passes back. A style is a change of posture and of extent, so
//! from every channel the mean of its own clip is taken, and it is divided by its spread (a spread below [`LEAST_SPREAD`] counts as that).
//! The correspondence is the cheapest path of dynamic time warping ([`learn::dtw`]) from the first frames to the last, with
//! bounded waits. A path of whole frames has steps; it is smoothed over 0.125 s, its ends stay, and a share of [`STRAIGHT`] of the
//! straight line makes it increase everywhere.
//!
//! Units: s; frames count from 0.

use learn::dtw::{self, Limits, Series};
use motion::Clip;

use super::features::{Features, Recognised};
use super::{ExampleError, Pair, Rig};

/// Least spread that a channel is divided by, in parts of the body's size.
pub const LEAST_SPREAD: f64 = 0.02;

/// Share of the straight line in the correspondence.
pub const STRAIGHT: f64 = 0.02;

/// Half the width of the smoothing, s.
const SMOOTH_S: f64 = 0.0625;

/// Most frames that one performance may wait for the other, after which both go on.
pub const WAIT: usize = 3;

/// Which frame of the second performance belongs to each of the first.
#[derive(Clone, Debug, PartialEq)]
pub struct Correspondence {
    /// For every frame of the first, when the second is there, s; increasing.
    pub times_s: Vec<f64>,
    /// Root of the mean squared difference of the frames on each other, in spreads of their channels: two performances of one
    /// content have well below 1, two that have nothing in common about 1.4.
    pub apart: f64,
    /// Longest waits of the first and of the second, frames: at [`WAIT`] the limit may have held the path back.
    pub longest_waits: (usize, usize),
}

/// The correspondence of two performances; a second one at another rate is resampled.
///
/// # Errors
/// Skeletons that are not one rig, numbers that are not finite, lengths so different that the waits leave no path.
pub fn correspond(name: &str, first: &Clip, second: &Clip) -> Result<Correspondence, ExampleError> {
    for (side, clip) in [("source", first), ("target", second)] {
        if let Some(at) = clip.data().iter().position(|x| !x.is_finite()) {
            let frame = at / clip.skeleton.nq();
            return Err(ExampleError::NotFinite { pair: name.into(), side, frame });
        }
    }
    let rig = Rig::of(&first.skeleton)?;
    let other = Rig::find(rig.file(), &second.skeleton)?;
    let resampled = (second.rate_hz != first.rate_hz).then(|| second.resample(first.rate_hz));
    let second = resampled.as_ref().unwrap_or(second);
    let channels = |rig: &Rig, clip: &Clip| -> (Vec<f64>, usize) {
        let frames: Vec<usize> = (0..clip.frames()).collect();
        let x = Features::of(rig, clip, &frames, Recognised { path_weight: 0.0, ..Recognised::default() })
            .configuration;
        let n = x.nrows() as f64;
        let (mut out, width) = (vec![0.0; x.len()], x.ncols());
        for c in 0..width {
            let column = x.column(c);
            let mean = column.sum() / n;
            let spread =
                (column.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt().max(LEAST_SPREAD);
            column.iter().enumerate().for_each(|(r, v)| out[r * width + c] = (v - mean) / spread);
        }
        (out, width)
    };
    let ((a, width), (b, _)) = (channels(&rig, first), channels(&other, second));
    let limits = Limits { wait: Some(WAIT), ..Limits::default() };
    let path =
        dtw::align(Series { values: &a, channels: width }, Series { values: &b, channels: width }, limits)
            .map_err(|source| ExampleError::Matching { pair: name.into(), source })?;
    let cells = (path.pairs().len() * width) as f64;
    Ok(Correspondence {
        times_s: increasing(&path.partners_of_a(), first.rate_hz),
        apart: (path.cost() / cells).sqrt(),
        longest_waits: path.longest_waits(),
    })
}

/// Frames to times: smoothed, ends kept, increasing.
fn increasing(partners: &[f64], rate_hz: f64) -> Vec<f64> {
    let last = partners.len() - 1;
    let half = (SMOOTH_S * rate_hz).round() as usize;
    (0..=last)
        .map(|i| {
            // a window that shrinks at the ends keeps them, and what does not fall does not fall in its means
            let h = half.min(i).min(last - i);
            let mean = partners[i - h..=i + h].iter().sum::<f64>() / (2 * h + 1) as f64;
            let share = if last == 0 { 0.0 } else { i as f64 / last as f64 };
            let line = partners[0] + (partners[last] - partners[0]) * share;
            (mean + STRAIGHT * (line - mean)) / rate_hz
        })
        .collect()
}

impl Pair {
    /// A pair from two performances: the second at the moments that belong to the frames of the first, and what they are.
    ///
    /// # Errors
    /// Those of [`correspond`] and of [`Pair::check`].
    pub fn of_performances(
        name: impl Into<String>,
        source: Clip,
        performed: &Clip,
    ) -> Result<(Self, Correspondence), ExampleError> {
        let name = name.into();
        let found = correspond(&name, &source, performed)?;
        let nq = performed.skeleton.nq();
        let mut q = vec![0.0; source.frames() * nq];
        for (pose, t_s) in q.chunks_exact_mut(nq).zip(&found.times_s) {
            performed.sample(*t_s, pose);
        }
        let target = Clip::new(performed.skeleton.clone(), source.rate_hz, q);
        let pair = Pair { times_s: Some(found.times_s.clone()), ..Pair::new(name, source, target) };
        pair.check()?;
        Ok((pair, found))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use motion::rotation::exp;
    use motion::{Joint, Link, Skeleton, TimeMap, Vec3};

    use super::*;

    /// A body that walks and swings its arms at a pace that changes; `lean` rad forward, arms `extent` times as far.
    fn performance(lean: f64, extent: f64) -> Clip {
        let ball = Joint::Spherical;
        let mut links = vec![Link::new("pelvis", None, Vec3::zeros(), Joint::Free)];
        links.push(Link::new("chest", Some(0), Vec3::new(0.0, 0.3, 0.0), ball));
        for (side, x) in [("l", 1.0), ("r", -1.0)] {
            let at = links.len();
            links.push(Link::new(format!("shoulder_{side}"), Some(1), Vec3::new(0.2 * x, 0.2, 0.0), ball));
            links.push(Link::new(format!("wrist_{side}"), Some(at), Vec3::new(0.0, -0.5, 0.0), ball));
            links.push(Link::new(format!("hip_{side}"), Some(0), Vec3::new(0.1 * x, -0.05, 0.0), ball));
            links.push(Link::new(format!("ankle_{side}"), Some(at + 2), Vec3::new(0.0, -0.8, 0.0), ball));
        }
        let s = Arc::new(Skeleton::new(links).unwrap());
        let mut q = Vec::new();
        for i in 0..=360 {
            let t = f64::from(i) / 60.0;
            let phase = 5.0 * t + 1.5 * (0.7 * t).sin();
            let mut pose = s.zero_pose();
            s.set_position(&mut pose, 0, &Vec3::new(0.2 * t, 0.9 + 0.02 * (2.0 * phase).cos(), 1.2 * t));
            s.set_rotation(&mut pose, 0, &exp(&(Vec3::y() * 0.3 * t)));
            s.set_rotation(&mut pose, 1, &exp(&(Vec3::x() * lean)));
            for (k, link) in [2, 4, 6, 8].into_iter().enumerate() {
                let swing = 0.5
                    * (phase + [0.0, std::f64::consts::PI, std::f64::consts::PI, 0.0][k]).sin()
                    * if k % 2 == 0 { extent } else { 1.0 };
                s.set_rotation(&mut pose, link, &exp(&(Vec3::x() * swing)));
            }
            q.extend(pose);
        }
        Clip::new(s, 60.0, q)
    }

    /// A performance retimed and played in another posture is matched to within a frame; the pair has the frames and times of a pair.
    #[test]
    fn a_retimed_performance_is_found_again() {
        let (source, styled) = (performance(0.0, 1.0), performance(0.35, 1.4));
        let times = TimeMap::new(&[(0.0, 0.0), (2.0, 2.5), (4.0, 4.1), (6.0, 6.6)]).unwrap();
        let performed = times.retime(&styled);
        for performed in [performed.clone(), performed.resample(90.0)] {
            let (pair, found) = Pair::of_performances("lean", source.clone(), &performed).unwrap();
            let off = |i: usize| found.times_s[i] - times.at(i as f64 / 60.0);
            let rms = ((0..=360).map(|i| off(i).powi(2)).sum::<f64>() / 361.0).sqrt();
            let worst = (0..=360).map(|i| off(i).abs()).fold(0.0, f64::max);
            println!(
                "{:.1} ms RMS, {:.1} ms at most, apart {:.3}, waits {:?}",
                1e3 * rms,
                1e3 * worst,
                found.apart,
                found.longest_waits
            );
            assert!(rms < 1.0 / 60.0 && worst < 3.0 / 60.0, "{rms} {worst}");
            assert!(found.apart < 0.5, "{}", found.apart);
            assert_eq!(pair.target.frames(), pair.source.frames());
            // against the frames that were matched by truth, not by search
            let (mut truth, mut a) = (vec![0.0; source.skeleton.nq()], 0.0_f64);
            for i in 0..=360 {
                styled.sample(i as f64 / 60.0, &mut truth);
                let d = pair.target.pose(i)[7..].iter().zip(&truth[7..]).map(|(x, y)| (x - y).abs());
                a = d.fold(a, f64::max);
            }
            assert!(a < 0.15, "{a}");
        }
        // the same performance is itself; another content is not the same
        let same = correspond("same", &source, &source).unwrap();
        let off = (0..=360).map(|i| (same.times_s[i] - i as f64 / 60.0).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9 && same.apart < 1e-9, "{off} {}", same.apart);
    }

    /// What cannot be matched is refused.
    #[test]
    fn what_cannot_be_matched_is_refused() {
        let source = performance(0.0, 1.0);
        let short =
            Clip::new(source.skeleton.clone(), 60.0, source.data()[..20 * source.skeleton.nq()].to_vec());
        let words = correspond("short", &source, &short).unwrap_err().to_string();
        assert!(words.contains("pair `short`") && words.contains("361 and 20 frames"), "{words}");
        let mut broken = source.clone();
        broken.pose_mut(7)[2] = f64::NAN;
        assert!(matches!(correspond("nan", &source, &broken), Err(ExampleError::NotFinite { frame: 7, .. })));
    }
}
