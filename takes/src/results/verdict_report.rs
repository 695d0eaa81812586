//! How a motion was performed, as `report.json` gives it under `dynamic.verdict`.
//!
//! In: a [`Verdict`], see [`dynamics::verdict`]. Out: a [`VerdictReport`]. The words are those of the verdict; where a body
//! looked ahead, how much that had to do comes after them.

use dynamics::verdict::{Reason, Verdict};
use serde::Serialize;

use crate::results::foresight_report::ForesightReport;

/// A verdict.
#[derive(Clone, Debug, Serialize)]
pub struct VerdictReport {
    /// `as asked`, `stands, but`, `in flight`, `fell` or `failed`.
    pub grade: &'static str,
    /// The headline.
    pub text: String,
    /// Why it was not performed as asked.
    pub reasons: Vec<ReasonReport>,
}

/// A reason.
#[derive(Clone, Debug, Serialize)]
pub struct ReasonReport {
    /// `feet slid`, `left the ground`, `landed hard`, `joints at their stops`, `far from asked`, `momentum unexplained`,
    /// `gaze missed` or `keys ignored`.
    pub reason: &'static str,
    /// In words.
    pub text: String,
    /// Its number.
    pub value: f64,
    /// The most that counts as asked.
    pub limit: f64,
    /// Unit of both.
    pub unit: &'static str,
    /// When, s; null of the whole run.
    pub at_s: Option<f64>,
}

impl VerdictReport {
    /// Of a run, and how much foresight had to do in it.
    pub(crate) fn new(verdict: &Verdict, foresight: Option<&ForesightReport>) -> Self {
        let reason = |r: &Reason| ReasonReport {
            reason: r.name(),
            text: r.to_string(),
            value: r.value,
            limit: r.limit,
            unit: r.unit(),
            at_s: r.at_s,
        };
        Self {
            grade: verdict.grade().name(),
            text: match foresight {
                Some(foresight) => format!("{verdict}; {}", foresight.words()),
                None => verdict.to_string(),
            },
            reasons: verdict.reasons.iter().map(reason).collect(),
        }
    }
}
