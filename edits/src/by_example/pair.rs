//! Training pairs: a source clip and its edited version.
//!
//! In: two clips of one rig with the same frames. Out: checked, with the frames that are examples. A pair may be two whole clips,
//! or a clip of which only some spans were corrected.

use motion::Clip;

use super::ExampleError;

/// A source and its edited version. Frame n of one belongs to frame n of the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// What messages call it.
    pub name: String,
    /// The motion before.
    pub source: Clip,
    /// The motion as it should be.
    pub target: Clip,
    /// When the frames of the target come, s, one for each, increasing; `None` where timing was not edited.
    pub times_s: Option<Vec<f64>>,
    /// Parts of the source that are examples, s; none is all of it.
    pub spans_s: Vec<(f64, f64)>,
    /// Keeps examples apart that contradict each other on purpose: a model is taught the pairs of one context, and those of none.
    pub context: Option<String>,
}

impl Pair {
    /// A pair of two whole clips with the same timing.
    pub fn new(name: impl Into<String>, source: Clip, target: Clip) -> Self {
        Self { name: name.into(), source, target, times_s: None, spans_s: Vec::new(), context: None }
    }

    /// Checks that the two clips go together.
    ///
    /// # Errors
    /// Numbers of frames or rates that differ, numbers that are not finite, times out of order.
    pub fn check(&self) -> Result<(), ExampleError> {
        let (a, b) = (&self.source, &self.target);
        if a.frames() != b.frames() || a.rate_hz != b.rate_hz || a.frames() == 0 {
            return Err(ExampleError::Unequal {
                pair: self.name.clone(),
                source_frames: a.frames(),
                source_hz: a.rate_hz,
                target_frames: b.frames(),
                target_hz: b.rate_hz,
            });
        }
        for (side, clip) in [("source", a), ("target", b)] {
            if let Some(at) = clip.data().iter().position(|x| !x.is_finite()) {
                let frame = at / clip.skeleton.nq();
                return Err(ExampleError::NotFinite { pair: self.name.clone(), side, frame });
            }
        }
        let Some(times) = &self.times_s else { return Ok(()) };
        let fault = |what: String| Err(ExampleError::Times { pair: self.name.clone(), what });
        if times.len() != a.frames() {
            return fault(format!("{} times for {} frames", times.len(), a.frames()));
        }
        if let Some(i) = (1..times.len()).find(|&i| !(times[i] > times[i - 1] && times[i].is_finite())) {
            return fault(format!(
                "time {} is {} s, after {} s; times must increase",
                i,
                times[i],
                times[i - 1]
            ));
        }
        Ok(())
    }

    /// The frames that are examples, at most `rate_hz` of them a second.
    ///
    /// # Errors
    /// A span without frames.
    pub fn examples(&self, rate_hz: f64) -> Result<Vec<usize>, ExampleError> {
        let clip = &self.source;
        let stride = (clip.rate_hz / rate_hz).round().max(1.0) as usize;
        let last = clip.frames() - 1;
        if self.spans_s.is_empty() {
            return Ok((0..=last).step_by(stride).collect());
        }
        let mut frames = Vec::new();
        for &(from_s, to_s) in &self.spans_s {
            let (from, to) = ((from_s * clip.rate_hz).round(), (to_s * clip.rate_hz).round());
            if !(from >= 0.0 && from <= to && from <= last as f64) {
                let (pair, end_s) = (self.name.clone(), clip.duration_s());
                return Err(ExampleError::Span { pair, from_s, to_s, end_s });
            }
            frames.extend((from as usize..=(to as usize).min(last)).step_by(stride));
        }
        frames.sort_unstable();
        frames.dedup();
        Ok(frames)
    }
}
