//! What a pinned root takes of a captured motion, on the motion smoothed.
//!
//! In: a take and its trace. Out: the wrench that gravity and contacts do not explain, per frame. A pin follows a clip with
//! all its noise, which the second derivative magnifies: a walk would weigh several times the body. So its force is that
//! of `analyze`: the performed motion at the frames of the clip, smoothed as strongly as its noise asks for, without its
//! ends. Where nothing was captured, or anything else acts (ground, pushes, carried masses), the recorded wrench is it.

use dynamics::{AnalysisOptions, FloorChoice, RootMode, Trace, analyze};

use crate::Take;
use crate::take::Source;

/// The wrench on the root, `frames × 6` (N, N·m about the root's origin), its rate (Hz), and the cut-off of its smoothing (Hz).
pub struct RootWrench {
    /// The table.
    pub wrench: Vec<f64>,
    /// Rows per second, Hz.
    pub rate_hz: f64,
    /// Cut-off, Hz; `None` where the recorded wrench is taken.
    pub cutoff_hz: Option<f64>,
}

impl RootWrench {
    /// Of a performed take.
    pub fn of(take: &Take, t: &Trace) -> Self {
        smoothed(take, t).unwrap_or_else(|| Self {
            wrench: t.residual(),
            rate_hz: t.rate_hz,
            cutoff_hz: None,
        })
    }
}

fn smoothed(take: &Take, t: &Trace) -> Option<RootWrench> {
    let captured = t.root == RootMode::Pinned && matches!(take.source, Source::Clip(_));
    let c = &take.conditions;
    let alone = t.contacts.is_empty() && c.pushes.is_empty() && c.carried.is_empty();
    if !(captured && alone) {
        return None;
    }
    let options =
        AnalysisOptions { gravity: t.gravity, ground: FloorChoice::None, ..AnalysisOptions::default() };
    let clip = take.at_frames(&t.clip());
    let a = analyze(&t.character, &clip, &options).ok()?;
    let graded = a.ends.graded.clone();
    let cutoff_hz = Some(a.smoothing.cutoff_hz).filter(|hz| hz.is_finite())?;
    let wrench = a.root_wrench[6 * graded.start..6 * graded.end].to_vec();
    Some(RootWrench { wrench, rate_hz: clip.rate_hz, cutoff_hz: Some(cutoff_hz) })
}
