//! What else than the ground a body touched, as `report.json` gives it under `dynamic.touched`.
//!
//! In: a [`Trace`]. Out: a [`TouchReport`] for every two that touched.

use dynamics::{Against, Trace};
use motion::Vec3;
use serde::Serialize;

/// What a prop, or a link to another one, did to the body.
#[derive(Clone, Debug, Serialize)]
pub struct TouchReport {
    /// The link.
    pub link: String,
    /// The prop or the other link; each two links are named once.
    pub against: String,
    /// When it first touched, s.
    pub from_s: f64,
    /// Largest force, N.
    pub peak_n: f64,
}

/// What else than the ground was touched, in order of time.
pub(super) fn touched(t: &Trace) -> Vec<TouchReport> {
    let links = t.character.skeleton.links();
    let mut out: Vec<(usize, Against, TouchReport)> = Vec::new();
    for row in t.contacts.chunk_by(|a, b| a.row == b.row) {
        let mut sums: Vec<(usize, Against, Vec3)> = Vec::new();
        for c in row {
            let once = match c.against {
                Against::Ground => false,
                Against::Prop(_) => true,
                Against::Link(other) => c.link < other,
            };
            if !once {
                continue;
            }
            match sums.iter_mut().find(|s| (s.0, s.1) == (c.link, c.against)) {
                Some(s) => s.2 += c.force,
                None => sums.push((c.link, c.against, c.force)),
            }
        }
        for (link, against, force) in sums {
            let known = out.iter_mut().find(|o| (o.0, o.1) == (link, against));
            let Some((_, _, report)) = known else {
                let name = row.iter().find(|c| c.against == against).map_or("", |c| t.against(c));
                let report = TouchReport {
                    link: links[link].name.clone(),
                    against: name.into(),
                    from_s: row[0].row as f64 / t.rate_hz,
                    peak_n: force.norm(),
                };
                out.push((link, against, report));
                continue;
            };
            report.peak_n = report.peak_n.max(force.norm());
        }
    }
    out.into_iter().map(|o| o.2).collect()
}
