//! Contact phases as RON: found by a run, edited by hand, given to the next.
//!
//! In: a file that lists for each contact point of a character the times at which it stands. Out: checked
//! [`Phase`]s; and back. A point that is not listed stands nowhere.
//!
//! ```ron
//! Contacts(
//!     // first and last moment of each contact, s
//!     points: {
//!         "toe_l": [(0.433, 0.867), (1.367, 1.833)],
//!         "toe_r": [(0, 0.367)],
//!     },
//! )
//! ```

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use retarget::Puppet;
use retarget::contacts::Phase;
use serde::Deserialize;

use crate::{SceneError, Source};

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Contacts")]
struct ContactsRon {
    points: BTreeMap<String, Vec<(f64, f64)>>,
}

/// Names of a puppet's contact points.
pub fn points(puppet: &Puppet) -> impl Iterator<Item = &str> {
    let sites = puppet.character.skeleton.sites();
    puppet.contacts.iter().map(|c| sites[c.site].name.as_str())
}

/// Reads the phases of a puppet's contact points in a motion that ends at `end_s`.
///
/// # Errors
/// Anything wrong with the file, at its place: unknown points, times that are reversed, outside the motion or overlap.
pub fn read(path: &Path, puppet: &Puppet, end_s: f64) -> Result<Vec<Phase>, SceneError> {
    let source = Source::read(path)?;
    let ron: ContactsRon = source.parse()?;
    let mut out = Vec::new();
    for (point, times) in &ron.points {
        let at = format!("points{{\"{point}\"}}");
        if !points(puppet).any(|p| p == point) {
            return Err(source.unknown(&at, "contact point", point, "", points(puppet)));
        }
        let mut before: Option<(f64, f64)> = None;
        for (i, &(from_s, to_s)) in times.iter().enumerate() {
            let fault = |what: String| source.error(&format!("{at}[{i}]"), what);
            if !(from_s >= 0.0 && to_s <= end_s + ROUNDING_S && from_s <= to_s) {
                return Err(fault(format!(
                    "a contact from {from_s} to {to_s} s; allowed: 0 to {end_s:.3} s, the earlier time first"
                )));
            }
            if let Some((_, last)) = before.filter(|(_, last)| *last >= from_s) {
                return Err(fault(format!(
                    "a contact from {from_s} s on; the one before ends at {last} s: join them, or leave a gap"
                )));
            }
            before = Some((from_s, to_s));
            out.push(Phase { point: point.clone(), from_s, to_s });
        }
    }
    Ok(out)
}

/// What rounding in the file may add to a time, s.
const ROUNDING_S: f64 = 1e-3;

/// The text of a file that gives these phases.
pub fn text(puppet: &Puppet, phases: &[Phase]) -> String {
    let mut out = String::from("Contacts(\n    // first and last moment of each contact, s\n    points: {\n");
    for point in points(puppet) {
        let times: Vec<String> = phases
            .iter()
            .filter(|p| p.point == point)
            .map(|p| format!("({}, {})", rounded(p.from_s), rounded(p.to_s)))
            .collect();
        // writing to a String cannot fail
        let _ = writeln!(out, "        {point:?}: [{}],", times.join(", "));
    }
    out + "    },\n)\n"
}

/// A time to a tenth of a millisecond.
fn rounded(t: f64) -> f64 {
    (t * 1e4).round() / 1e4
}
