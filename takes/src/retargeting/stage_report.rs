//! How far each stage of a retargeting went, its flights and its contacts that gave way: as numbers, and in words where a bound was reached.
//!
//! In: what came out of the pipeline. Out: parts of the report, and sentences that a person should read.

use motion::names::Word;
use retarget::{FlightReport, Phase, PipelineStage, Retargeted, StepReport};
use serde::Serialize;

/// A contact phase.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhaseNumbers {
    /// The contact point.
    pub point: String,
    /// Beginning, s.
    pub from_s: f64,
    /// End, s.
    pub to_s: f64,
}

impl PhaseNumbers {
    /// Of phases, in their order.
    pub(super) fn of(phases: &[Phase]) -> Vec<Self> {
        let one = |p: &Phase| Self { point: p.point.clone(), from_s: p.from_s, to_s: p.to_s };
        phases.iter().map(one).collect()
    }
}

/// How far a stage moved the motion from the stage before, and how far it may.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageNumbers {
    /// The stage: `global`, `contact`, `sway` (parts that swing, links turned apart) or `refine`.
    pub stage: &'static str,
    /// The joint that was turned farthest; absent if none was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint: Option<String>,
    /// How far, degrees.
    pub joint_deg: f64,
    /// The farthest that is allowed, degrees.
    pub joint_bound_deg: f64,
    /// The farthest that is allowed of joints that follow by dynamics, degrees.
    pub swaying_bound_deg: f64,
    /// How far the root was moved, mm.
    pub root_mm: f64,
    /// The farthest that is allowed, mm.
    pub root_bound_mm: f64,
    /// How far it was turned, degrees.
    pub root_deg: f64,
    /// The farthest that is allowed, degrees.
    pub root_bound_deg: f64,
    /// Largest speed over the fastest of the stage before within a quarter of a second.
    pub speed_ratio: f64,
    /// The largest that is allowed.
    pub speed_bound: f64,
    /// Largest acceleration likewise.
    pub acceleration_ratio: f64,
    /// The largest that is allowed.
    pub acceleration_bound: f64,
    /// Deepest that links are in one another before and after, mm.
    pub penetration_mm: [f64; 2],
    /// Times in which the stage was held back, from and to, s; absent if it was not.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub held_back_s: Vec<[f64; 2]>,
}

/// A flight of the human on the character.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FlightNumbers {
    /// From, s.
    pub from_s: f64,
    /// To, s.
    pub to_s: f64,
    /// Height of the human's, scaled by the statures, mm.
    pub human_mm: f64,
    /// Height of the character's after each stage, mm.
    pub stages_mm: Vec<(&'static str, f64)>,
}

/// Numbers of the stages that are held to bounds.
pub(super) fn stages(done: &Retargeted) -> Vec<StageNumbers> {
    let of_step = |s: &StepReport| StageNumbers {
        stage: s.step.word(),
        joint: s.joint.as_ref().map(|j| j.link.clone()),
        joint_deg: s.joint.as_ref().map_or(0.0, |j| j.rad.to_degrees()),
        joint_bound_deg: s.bounds.joint_rad.to_degrees(),
        swaying_bound_deg: s.bounds.swaying_rad.to_degrees(),
        root_mm: 1e3 * s.root_m,
        root_bound_mm: 1e3 * s.root_bound_m,
        root_deg: s.root_rad.to_degrees(),
        root_bound_deg: s.bounds.root_rad.to_degrees(),
        speed_ratio: s.speed,
        speed_bound: s.bounds.speed,
        acceleration_ratio: s.acceleration,
        acceleration_bound: s.bounds.acceleration,
        penetration_mm: s.penetration_m.map(|m| 1e3 * m),
        held_back_s: s.held_back_s.clone(),
    };
    done.steps.iter().map(of_step).collect()
}

/// Flights of the human.
pub(super) fn flights(done: &Retargeted) -> Vec<FlightNumbers> {
    let of_flight = |f: &FlightReport| FlightNumbers {
        from_s: f.from_s,
        to_s: f.to_s,
        human_mm: 1e3 * f.scaled_m,
        stages_mm: f.heights_m.iter().map(|(stage, m)| (stage.word(), 1e3 * m)).collect(),
    };
    done.flights.iter().map(of_flight).collect()
}

/// What a person should know of a run: bounds that were reached, contacts that gave way, flights that are none.
pub(super) fn warnings(done: &Retargeted) -> Vec<String> {
    let mut out = Vec::new();
    for s in &done.steps {
        of_stage(s, &mut out);
    }
    if !done.gave_way.is_empty() {
        let mut points: Vec<&str> = done.gave_way.iter().map(|p| p.point.as_str()).collect();
        points.sort_unstable();
        points.dedup();
        let times = spans(done.gave_way.iter().map(|p| [p.from_s, p.to_s]).collect());
        out.push(format!("contacts that cannot be kept gave way: {} ({times})", points.join(", ")));
    }
    for f in &done.flights {
        of_flight(f, &mut out);
    }
    out
}

fn of_stage(s: &StepReport, out: &mut Vec<String>) {
    let stage = s.step.word();
    if s.at_bound() {
        let (mut what, mut allowed) = (Vec::new(), Vec::new());
        if let Some(j) = &s.joint {
            what.push(format!("{} turned {:.0}° at {:.2} s", j.link, j.rad.to_degrees(), j.at_s));
        }
        allowed.push(format!("joints {:.0}°", s.bounds.joint_rad.to_degrees()));
        if s.bounds.swaying_rad != s.bounds.joint_rad {
            allowed.push(format!("swaying ones {:.0}°", s.bounds.swaying_rad.to_degrees()));
        }
        if s.root_bound_m > 0.0 {
            let [moved, turned] = [1e3 * s.root_m, s.root_rad.to_degrees()];
            what.push(format!("the root moved {moved:.0} mm and turned {turned:.0}°"));
            let [moved, turned] = [1e3 * s.root_bound_m, s.bounds.root_rad.to_degrees()];
            allowed.push(format!("the root {moved:.0} mm and {turned:.0}°"));
        }
        out.push(format!("{stage} is at a bound: {} (allowed: {})", what.join(", "), allowed.join(", ")));
    }
    if !s.held_back_s.is_empty() {
        let times = spans(s.held_back_s.clone());
        out.push(format!(
            "{stage} was held back ({times}): it would have gone beyond a bound, been more than {:.0} × as fast as the motion before, accelerated more than {:.0} ×, or put links deeper into one another",
            s.bounds.speed, s.bounds.acceleration
        ));
    } else if s.speed > StepReport::AT_BOUND * s.bounds.speed
        || s.acceleration > StepReport::AT_BOUND * s.bounds.acceleration
    {
        out.push(format!(
            "{stage} is at a bound: {:.1} × as fast as the motion before, {:.1} × the acceleration (allowed: {:.0} ×, {:.0} ×)",
            s.speed, s.acceleration, s.bounds.speed, s.bounds.acceleration
        ));
    }
}

fn of_flight(f: &FlightReport, out: &mut Vec<String>) {
    let mut before = f.scaled_m;
    for &(stage, height_m) in f.heights_m.iter().filter(|(stage, _)| *stage != PipelineStage::Map) {
        if height_m < retarget::flights::KEPT * before - 1e-3 {
            out.push(format!(
                "the flight from {:.2} to {:.2} s falls from {:.0} to {:.0} mm with `{}`",
                f.from_s,
                f.to_s,
                1e3 * before,
                1e3 * height_m,
                stage.word()
            ));
        }
        before = height_m;
    }
}

/// Spans of time in words: joined where they overlap, the first few.
fn spans(mut of: Vec<[f64; 2]>) -> String {
    const SHOWN: usize = 4;
    of.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut joined: Vec<[f64; 2]> = Vec::new();
    for [from, to] in of {
        match joined.last_mut().filter(|last| from <= last[1] + 0.02) {
            Some(last) => last[1] = last[1].max(to),
            None => joined.push([from, to]),
        }
    }
    let more = joined.len().saturating_sub(SHOWN);
    let shown: Vec<String> =
        joined.iter().take(SHOWN).map(|[from, to]| format!("{from:.2}–{to:.2} s")).collect();
    let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
    shown.join(", ") + &rest
}

#[cfg(test)]
mod tests {
    use retarget::{Bounds, Step, Turned};

    use super::*;

    /// A stage far within its bounds.
    fn step() -> StepReport {
        let bounds = Bounds {
            joint_rad: 0.5,
            swaying_rad: 0.5,
            root_share: 0.1,
            root_rad: 0.2,
            speed: 3.0,
            acceleration: 5.0,
            deep_elsewhere: false,
            saturate: true,
        };
        let joint = Some(Turned { link: "knee_l".into(), at_s: 1.25, rad: 0.2 });
        StepReport {
            step: Step::Contact,
            bounds,
            root_bound_m: 0.15,
            joint,
            nearest_bound: 0.4,
            root_m: 0.06,
            root_rad: 0.05,
            speed: 1.5,
            acceleration: 2.0,
            penetration_m: [0.0; 2],
            held_back_s: Vec::new(),
        }
    }

    fn said(step: &StepReport) -> Vec<String> {
        let mut out = Vec::new();
        of_stage(step, &mut out);
        out
    }

    /// Each bound is said from 95 % of it on, with what was reached and what is allowed, and not below.
    #[test]
    fn a_bound_is_said_where_it_is_reached() {
        assert!(said(&step()).is_empty());
        for (nearest_bound, lines) in [(0.949, 0), (0.951, 1)] {
            let at = StepReport { nearest_bound, ..step() };
            assert_eq!(said(&at).len(), lines, "{nearest_bound}");
        }
        assert_eq!(
            said(&StepReport { nearest_bound: 1.0, ..step() }),
            [
                "contact is at a bound: knee_l turned 11° at 1.25 s, the root moved 60 mm and turned 3° (allowed: joints 29°, the root 150 mm and 11°)"
            ]
        );
        for (speed, acceleration, lines) in [(2.84, 4.74, 0), (2.86, 2.0, 1), (1.5, 4.76, 1)] {
            let fast = StepReport { speed, acceleration, ..step() };
            assert_eq!(said(&fast).len(), lines, "{speed} {acceleration}");
        }
        assert_eq!(
            said(&StepReport { speed: 2.95, ..step() }),
            [
                "contact is at a bound: 3.0 × as fast as the motion before, 2.0 × the acceleration (allowed: 3 ×, 5 ×)"
            ]
        );
    }

    /// Where a stage was held back, the times are said instead of the ratio; near ones are joined, of many the first four.
    #[test]
    fn times_in_which_a_stage_was_held_back_are_said() {
        let held_back_s = vec![[2.0, 2.5], [0.5, 1.0], [1.01, 1.2]];
        let held = said(&StepReport { speed: 3.0, held_back_s, ..step() });
        assert_eq!(held.len(), 1);
        assert!(held[0].starts_with("contact was held back (0.50–1.20 s, 2.00–2.50 s): "), "{held:?}");
        assert!(held[0].contains("more than 3 × as fast") && held[0].contains("accelerated more than 5 ×"));
        let many = (0..6).map(|i| [f64::from(i), f64::from(i) + 0.5]).collect();
        let held = said(&StepReport { held_back_s: many, ..step() });
        assert!(held[0].contains("3.00–3.50 s and 2 more"), "{held:?}");
    }

    /// A flight that falls below 80 % of the stage before is said with the stage, one that keeps it is not.
    #[test]
    fn a_flight_that_falls_is_said() {
        let of = |contact: f64, refine: f64| {
            let heights_m = vec![
                (PipelineStage::Map, 0.0),
                (PipelineStage::Global, 0.1),
                (PipelineStage::Contact, contact),
                (PipelineStage::Refine, refine),
            ];
            let mut out = Vec::new();
            of_flight(&FlightReport { from_s: 1.0, to_s: 1.4, scaled_m: 0.1, heights_m }, &mut out);
            out
        };
        assert!(of(0.1, 0.085).is_empty());
        assert_eq!(of(0.1, 0.05), ["the flight from 1.00 to 1.40 s falls from 100 to 50 mm with `refine`"]);
        assert_eq!(of(0.06, 0.055).len(), 1);
        assert_eq!(of(0.06, 0.02).len(), 2);
    }
}
