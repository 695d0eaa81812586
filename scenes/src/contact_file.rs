//! Contact plans as RON: found by a run, edited by hand, given to the next.
//!
//! In: a file that lists for each point of a body the times at which it stands, and where. Out: a checked
//! [`ContactPlan`], or [`Phase`]s of a puppet; and back. A point that is not listed stands nowhere.
//!
//! ```ron
//! Contacts(
//!     // first and last moment of each contact, s
//!     points: {
//!         "toe_l": [(0.433, 0.867), (1.367, 1.833)],
//!         "toe_r": [(0, 0.367)],
//!     },
//!     // where the point then is: m, degrees; without it, where the motion has it
//!     places: {
//!         "toe_r": [At(at_m: (0.1, 0, 0.35), rotation_deg: (0, 12.5, 0))],
//!     },
//! )
//! ```

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use motion::rotation::{deg_from_quat, quat_from_deg};
use motion::{Contact, ContactPlan, Transform, Vec3};
use retarget::Puppet;
use retarget::contacts::Phase;
use serde::Deserialize;

use crate::{SceneError, Source};

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Contacts")]
struct ContactsRon {
    points: BTreeMap<String, Vec<(f64, f64)>>,
    #[serde(default)]
    places: BTreeMap<String, Vec<PlaceRon>>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields, rename = "At")]
struct PlaceRon {
    at_m: (f64, f64, f64),
    rotation_deg: (f64, f64, f64),
}

/// Names of a puppet's contact points.
pub fn points(puppet: &Puppet) -> impl Iterator<Item = &str> {
    let sites = puppet.character.skeleton.sites();
    puppet.contacts.iter().map(|c| sites[c.site].name.as_str())
}

/// Reads the plan of a motion that ends at `end_s`; `names`: the points that may stand.
///
/// # Errors
/// Anything wrong with the file, at its place: unknown points, times that are reversed, outside the motion or overlap, places
/// that are not as many as the contacts of their point.
pub fn read_plan(path: &Path, names: &[&str], end_s: f64) -> Result<ContactPlan, SceneError> {
    let source = Source::read(path)?;
    let ron: ContactsRon = source.parse()?;
    let known = |at: &str, point: &str| {
        let known = names.contains(&point);
        known
            .then_some(())
            .ok_or_else(|| source.unknown(at, "contact point", point, "", names.iter().copied()))
    };
    for (point, places) in &ron.places {
        let at = format!("places{{\"{point}\"}}");
        known(&at, point)?;
        let contacts = ron.points.get(point).map_or(0, Vec::len);
        if places.len() != contacts {
            let what = format!("{} places; allowed: one for each of the {contacts} contacts", places.len());
            return Err(source.error(&at, what));
        }
        let finite = |p: &PlaceRon| {
            let (a, r) = (p.at_m, p.rotation_deg);
            [a.0, a.1, a.2, r.0, r.1, r.2].iter().all(|x| x.is_finite())
        };
        if let Some(i) = places.iter().position(|p| !finite(p)) {
            return Err(source.error(&format!("{at}[{i}]"), "a number that is not finite".to_owned()));
        }
    }
    let mut out = Vec::new();
    for (point, times) in &ron.points {
        let at = format!("points{{\"{point}\"}}");
        known(&at, point)?;
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
            let place = ron.places.get(point).map(|places| {
                let PlaceRon { at_m: (x, y, z), rotation_deg: (a, b, c) } = places[i];
                Transform::from_parts(Vec3::new(x, y, z).into(), quat_from_deg([a, b, c]))
            });
            out.push(Contact { point: point.clone(), from_s, to_s, world_from_point: place });
        }
    }
    ContactPlan::new(out).map_err(|e| source.error("points", e.to_string()))
}

/// Reads the phases of a puppet's contact points in a motion that ends at `end_s`, point by point.
///
/// # Errors
/// As [`read_plan`]; places, which a puppet's steps do not have.
pub fn read(path: &Path, puppet: &Puppet, end_s: f64) -> Result<Vec<Phase>, SceneError> {
    let names: Vec<&str> = points(puppet).collect();
    let plan = read_plan(path, &names, end_s)?;
    if plan.contacts().iter().any(|c| c.world_from_point.is_some()) {
        let what = "the steps of a retargeted motion have times, and find their places; allowed: no places";
        return Err(Source::read(path)?.error("places", what.to_owned()));
    }
    let of = |point: &&str| -> Vec<Phase> {
        let phase = |c: &Contact| Phase { point: c.point.clone(), from_s: c.from_s, to_s: c.to_s };
        plan.of(point).map(phase).collect()
    };
    Ok(plan.points().iter().flat_map(of).collect())
}

/// What rounding in the file may add to a time, s.
const ROUNDING_S: f64 = 1e-3;

/// The text of a file that gives these phases.
pub fn text(puppet: &Puppet, phases: &[Phase]) -> String {
    let contact = |p: &Phase| Contact {
        point: p.point.clone(),
        from_s: p.from_s,
        to_s: p.to_s,
        world_from_point: None,
    };
    // phases of one point are apart
    let plan = ContactPlan::new(phases.iter().map(contact).collect()).unwrap_or_default();
    plan_text(&points(puppet).collect::<Vec<_>>(), &plan)
}

/// The text of a file that gives the contacts of `names`, in their order; places where all contacts of a point have one.
pub fn plan_text(names: &[&str], plan: &ContactPlan) -> String {
    let mut out = String::from("Contacts(\n    // first and last moment of each contact, s\n    points: {\n");
    for point in names {
        let times: Vec<String> =
            plan.of(point).map(|c| format!("({}, {})", rounded(c.from_s), rounded(c.to_s))).collect();
        // writing to a String cannot fail
        let _ = writeln!(out, "        {point:?}: [{}],", times.join(", "));
    }
    out += "    },\n";
    let placed =
        |point: &&&str| plan.of(point).count() > 0 && plan.of(point).all(|c| c.world_from_point.is_some());
    let placed: Vec<&&str> = names.iter().filter(placed).collect();
    if !placed.is_empty() {
        out += "    // where the point then is: m, degrees; without it, where the motion has it\n    places: {\n";
        for point in placed {
            let _ = writeln!(out, "        {point:?}: [");
            for at in plan.of(point).filter_map(|c| c.world_from_point) {
                let [x, y, z] = <[f64; 3]>::from(at.translation.vector).map(rounded);
                let [a, b, c] = deg_from_quat(&at.rotation).map(rounded);
                let _ =
                    writeln!(out, "            At(at_m: ({x}, {y}, {z}), rotation_deg: ({a}, {b}, {c})),");
            }
            out += "        ],\n";
        }
        out += "    },\n";
    }
    out + ")\n"
}

/// To a tenth of a millisecond, millimetre or thousandth of a degree.
fn rounded(t: f64) -> f64 {
    let r = (t * 1e4).round() / 1e4;
    if r == 0.0 { 0.0 } else { r }
}
