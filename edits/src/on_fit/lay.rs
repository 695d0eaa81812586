//! The difference that an edit makes to a fit, laid over the clip that was fitted.
//!
//! Where the edit moved keys in time, what is at `t` was at another time `t'` of the fit; elsewhere `t' = t`. The clip's value at `t'`
//! is taken, with its detail, and turned by what the edit changed: `E(t) F(t')⁻¹ R(t')`. So detail travels with the movement that it
//! is a detail of, and an edit that only moves keys in time gives poses of the clip.

use motion::smooth::whittaker::{Whittaker, lambda};
use motion::time_map::End;
use motion::{Clip, Dof, Quat, TimeMap, Track, Tracks, Value, smoothstep};

use nalgebra::{Quaternion, Vector4};

use super::support::Support;
use crate::fit_place::FitPlace;

/// At an end of the span that is no end of the clip the difference is blended over this time, s; over half a span that is shorter.
const BLEND_S: f64 = 0.25;
/// Differences pass up to this frequency, by half; what is faster is corners of elements.
const SMOOTH_HZ: f64 = 12.0;
/// Times nearer than this are one, s.
const SAME_S: f64 = 1e-9;

/// Lays the difference between `before` and `after` over the clip, which `before` fits.
pub(super) fn over(clip: &mut Clip, before: &Tracks, after: &Tracks, place: &FitPlace, support: &Support) {
    let s = clip.skeleton.clone();
    let source = clip.clone();
    let strength = lambda(SMOOTH_HZ.min(0.45 * clip.rate_hz), clip.rate_hz);
    let smoother = Whittaker::new(clip.frames(), strength);
    let mut from = vec![0.0; s.nq()];
    for dof in Dof::all(&s).into_iter().filter(|d| place.selection.allows(*d)) {
        let (fit, edit) = (before.track(dof), after.track(dof));
        let Some(edit) = edit.filter(|edit| fit != Some(*edit)) else { continue };
        let base = dof.read(&s, &before.base);
        let retimed = fit.and_then(|fit| Retimed::of(fit, edit));
        let time = |frame: usize| frame as f64 / clip.rate_hz;
        let times: Vec<f64> =
            (0..clip.frames()).map(|f| retimed.as_ref().map_or(time(f), |r| r.in_fit(time(f)))).collect();
        let edited = retimed.as_ref().map_or(edit, |r| &r.track);
        let fitted = |t: f64| fit.map_or(base, |fit| fit.value_at(t, &base));
        let changes = changes(times.iter().map(|t| (fitted(*t), edited.value_at(*t, &base))), &smoother);
        for frame in 0..clip.frames() {
            let (t_s, from_s) = (frame as f64 / clip.rate_hz, times[frame]);
            let share = support.share(dof, frame) * blend(place, t_s);
            if share == 0.0 || (changes.is_none() && from_s == t_s) {
                continue;
            }
            source.sample(from_s, &mut from);
            let (own, there) = (dof.read(&s, clip.pose(frame)), dof.read(&s, &from));
            let value = match (there, changes.as_ref().map(|c| c[frame])) {
                (Value::Scalar(x), Some(Value::Scalar(d))) => Value::Scalar(x + d),
                (Value::Rotation(r), Some(Value::Rotation(d))) => Value::Rotation(d * r),
                (there, _) => there,
            };
            dof.write(&s, clip.pose_mut(frame), &Value::between(&own, &value, share));
        }
    }
}

/// What is between pairs of a fitted and an edited value, frame by frame, smoothed; `None` where every pair is equal to the bit.
///
/// Elements meet at their keys with corners, which the clip does not have and must not get.
fn changes(pairs: impl Iterator<Item = (Value, Value)>, smoother: &Whittaker) -> Option<Vec<Value>> {
    let pairs: Vec<(Value, Value)> = pairs.collect();
    if pairs.iter().all(|(f, e)| f == e) {
        return None;
    }
    if let Value::Scalar(_) = pairs[0].0 {
        let apart = |(f, e): &(Value, Value)| Some(e.scalar()? - f.scalar()?);
        let raw: Vec<f64> = pairs.iter().map(|p| apart(p).unwrap_or(0.0)).collect();
        return Some(smoother.smooth(&raw, 1).into_iter().map(Value::Scalar).collect());
    }
    // the coordinates of quaternions on one side of the sphere
    let mut raw: Vec<f64> = Vec::with_capacity(4 * pairs.len());
    for (f, e) in &pairs {
        let turn = e.rotation().zip(f.rotation()).map_or(Quat::identity(), |(e, f)| e * f.inverse());
        let q = turn.coords;
        let last = raw.len().checked_sub(4).map(|at| Vector4::from_column_slice(&raw[at..]));
        let q = if last.is_some_and(|last| last.dot(&q) < 0.0) { -q } else { q };
        raw.extend(q.iter());
    }
    let rotation = |q: &[f64]| Value::Rotation(Quat::new_normalize(Quaternion::new(q[3], q[0], q[1], q[2])));
    Some(smoother.smooth(&raw, 4).chunks_exact(4).map(rotation).collect())
}

/// A track whose keys an edit moved in time, in order: when each time of it was in the fit, and what it says then.
///
/// Between keys time is bent smoothly ([`TimeMap`]), where each element alone would bend it at its ends.
struct Retimed {
    to_fit: TimeMap,
    /// The edited values at the times of the fit.
    track: Track,
}

impl Retimed {
    /// `None` where elements are not those of the fit, one after another: what such an edit says has no time in the fit.
    fn of(fit: &Track, edit: &Track) -> Option<Self> {
        let pairs = || fit.elements.iter().zip(&edit.elements);
        let serial = edit.elements.windows(2).all(|p| (p[1].start_s - p[0].arrives_s()).abs() < SAME_S);
        let same = fit.elements.len() == edit.elements.len() && pairs().all(|(a, b)| a.label == b.label);
        if !(serial && same) {
            return None;
        }
        let anchors: Vec<(f64, f64)> = pairs().map(|(a, b)| (a.arrives_s(), b.arrives_s())).collect();
        let times = TimeMap::with_ends(&anchors, [End::Free, End::Joined]).ok()?;
        let mut track = edit.clone();
        for (e, was) in track.elements.iter_mut().zip(&fit.elements) {
            (e.start_s, e.duration_s) = (was.start_s, was.duration_s);
        }
        Some(Self { to_fit: times.inverse(), track })
    }

    fn in_fit(&self, t_s: f64) -> f64 {
        let from_s = self.to_fit.at(t_s);
        if (from_s - t_s).abs() < SAME_S { t_s } else { from_s }
    }
}

/// How much of the difference holds at a time, s.
fn blend(place: &FitPlace, t_s: f64) -> f64 {
    let length = BLEND_S.min(0.5 * (place.to_s - place.from_s));
    let within = |away: f64| smoothstep(away / length);
    let begins = if place.from_s > 0.0 { within(t_s - place.from_s) } else { 1.0 };
    let ends = if place.to_s < place.end_s { within(place.to_s - t_s) } else { 1.0 };
    begins * ends
}
