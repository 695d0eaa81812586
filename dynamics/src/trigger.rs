//! Triggers: what the motion asked for, or the world, brought that no balance withstands.
//!
//! In: a [`Trace`] up to the row of a fall. Out: [`Trigger`]s, in order of time. A margin that is lost (see [`crate::fall`]) says
//! what happened to the body; a trigger says what to change.
//!
//! *Pressure outside.* The motion asked for needs the ground to push where no sole is: `F = ṗ − m g` through the point of the
//! ground where the horizontal moment of the wrench vanishes, and the hull of the soles that are down in it, where at
//! least half of the body's weight is needed. Of all spans in which that point is further outside than [`OUTSIDE_M`] for
//! longer than [`OUTSIDE_S`], the one where it is furthest.
//!
//! Units: m, s, N·s, rad; level ground.

use std::fmt;

use motion::support::ground as plane;
use motion::{Clip, Derivatives, Sole, Support, Vec3};

use crate::analysis::ground::{SPACING_M, pressure_center};
use crate::spans::{Span, beyond};
use crate::{Model, State, Trace};

/// A centre of pressure this far outside the soles asked for cannot be given, m: balance keeps 10 to 20 mm inside, so that
/// rounding and short transients are none.
pub const OUTSIDE_M: f64 = 0.01;
/// For so long it topples nobody, s: a body that is out of balance by 10 cm has then gained 5 cm/s.
pub const OUTSIDE_S: f64 = 0.05;
/// Least vertical force that is judged, body weights: of a body that is about to leave the ground the centre of pressure runs
/// away.
const LOADED: f64 = 0.5;
/// A point of a sole of the motion asked for that is lower is down, m.
const DOWN_M: f64 = 0.03;
/// Soles that begin higher over the ground are in the air, m.
const ABOVE_M: f64 = 0.1;
/// Time over which the motion asked for is differentiated, s: that of a goal.
const WINDOW_S: f64 = 1.0 / 15.0;

/// What brought a body down. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub enum Trigger {
    /// It has no leg with a sole: nothing balances it.
    NoLegs,
    /// Nothing is under its feet when it begins.
    NoGround {
        /// Height of the lowest sole over the ground, m.
        above_m: f64,
    },
    /// The motion asks for a centre of pressure outside the soles.
    PressureOutside {
        /// How far at most, m.
        by_m: f64,
        /// From when on, s.
        from_s: f64,
    },
    /// It was pushed, or handed something.
    Pushed {
        /// Impulse before the fall, N·s.
        impulse_ns: f64,
        /// When it began, s.
        from_s: f64,
    },
    /// The ground under it is tilted.
    Tilted {
        /// How steep at most before the fall, rad.
        by_rad: f64,
        /// When it began to turn, s; 0 where it always was.
        from_s: f64,
    },
}

impl Trigger {
    /// As reports name it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::NoLegs => "no legs",
            Self::NoGround { .. } => "no ground under the feet",
            Self::PressureOutside { .. } => "pressure outside the soles",
            Self::Pushed { .. } => "pushed",
            Self::Tilted { .. } => "tilted ground",
        }
    }

    /// When it began, s.
    pub fn from_s(&self) -> f64 {
        match self {
            Self::NoLegs | Self::NoGround { .. } => 0.0,
            Self::PressureOutside { from_s, .. }
            | Self::Pushed { from_s, .. }
            | Self::Tilted { from_s, .. } => *from_s,
        }
    }
}

impl fmt::Display for Trigger {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoLegs => write!(f, "it has no legs to stand on, and nothing holds its root"),
            Self::NoGround { above_m } => write!(f, "its soles begin {above_m:.2} m above the ground"),
            Self::PressureOutside { by_m, from_s } => {
                let mm = 1e3 * by_m;
                write!(
                    f,
                    "the motion asks for the centre of pressure {mm:.0} mm outside the soles from {from_s:.2} s"
                )
            }
            Self::Pushed { impulse_ns, from_s } => {
                write!(f, "it is pushed by {impulse_ns:.1} N·s from {from_s:.2} s")
            }
            Self::Tilted { by_rad, from_s } => {
                write!(f, "the ground is tilted by {:.0}° from {from_s:.2} s", by_rad.to_degrees())
            }
        }
    }
}

/// What brought the body down that fell in a row.
pub fn before(trace: &Trace, model: &Model, row: usize) -> Vec<Trigger> {
    let mut all = Vec::new();
    let soles = trace.character.leg_soles();
    if soles.is_empty() {
        all.push(Trigger::NoLegs);
    } else {
        let k = motion::Kinematics::new(&trace.character.skeleton, trace.target_pose(0));
        let points = soles.iter().flat_map(|(_, sole)| sole.points(&k));
        let above_m = crate::feet::lowest(trace, 0, points);
        if above_m > ABOVE_M {
            all.push(Trigger::NoGround { above_m });
        }
    }
    all.extend(pushed(trace, row));
    all.extend(tilted(trace, row));
    if trace.ground_up(0) == Vec3::y() && !soles.is_empty() {
        all.extend(pressure_outside(trace, model, row));
    }
    all.sort_by(|a, b| a.from_s().total_cmp(&b.from_s()));
    all
}

fn pushed(trace: &Trace, row: usize) -> Option<Trigger> {
    let all = trace.disturbed.wrench.chunks_exact(6).take(row + 1);
    let forces: Vec<f64> = all.map(|w| Vec3::new(w[0], w[1], w[2]).norm()).collect();
    let first = forces.iter().position(|f| *f > 0.0)?;
    let impulse_ns = forces.iter().sum::<f64>() / trace.rate_hz;
    // the force of a row acted during the step that led to it
    Some(Trigger::Pushed { impulse_ns, from_s: first.saturating_sub(1) as f64 / trace.rate_hz })
}

fn tilted(trace: &Trace, row: usize) -> Option<Trigger> {
    let steep = |r: usize| trace.ground_up(r).angle(&Vec3::y());
    let by_rad = (0..=row).map(steep).fold(0.0, f64::max);
    if by_rad < 1e-6 {
        return None;
    }
    let first = (0..=row).find(|&r| trace.ground_up(r) != trace.ground_up(0));
    let from_s = first.filter(|_| trace.ground_turns()).map_or(0.0, |r| r as f64 / trace.rate_hz);
    Some(Trigger::Tilted { by_rad, from_s })
}

fn pressure_outside(trace: &Trace, model: &Model, row: usize) -> Option<Trigger> {
    let outside = asked_outside(trace, model, row + 1);
    let long = (OUTSIDE_S * trace.rate_hz).round().max(1.0) as usize;
    let mut worst: Option<Span> = None;
    for span in beyond(&outside, OUTSIDE_M, long) {
        if worst.as_ref().is_none_or(|w| w.largest < span.largest) {
            worst = Some(span);
        }
    }
    let Span { rows, largest } = worst?;
    Some(Trigger::PressureOutside { by_m: largest, from_s: rows.start as f64 / trace.rate_hz })
}

/// How far the centre of pressure that the motion asked for needs is outside its soles, m, in the first `rows` rows; zero
/// inside, and where no sole is down or hardly any force is needed.
fn asked_outside(trace: &Trace, model: &Model, rows: usize) -> Vec<f64> {
    let c = &trace.character;
    let (nq, nv) = (c.skeleton.nq(), c.skeleton.nv());
    let asked = Clip::new(c.skeleton.clone(), trace.rate_hz, trace.target[..rows * nq].to_vec());
    let d = Derivatives::new(&asked, WINDOW_S);
    let height = trace.ground_m.unwrap_or(0.0);
    let legs: Vec<usize> = c.legs().map(|l| l.end).collect();
    let soles = c.edged_soles(SPACING_M).into_iter().filter(|s| legs.contains(&s.link));
    let soles: Vec<Sole> = soles.collect();
    let mut state = State::new(model);
    (0..rows)
        .map(|row| {
            let (v, vd) = (&d.v[row * nv..(row + 1) * nv], &d.vd[row * nv..(row + 1) * nv]);
            state.update(model, asked.pose(row), v);
            let rate = state.momentum_rate(model, v, vd);
            let force = rate.linear - model.gravity * model.mass;
            if force.y < LOADED * model.mass * model.gravity.norm() {
                return 0.0;
            }
            let corners = soles.iter().flat_map(|sole| &sole.corners);
            let points: Vec<Vec3> = corners
                .map(|(link, at)| state.point(model, *link, at))
                .filter(|p| p.y - height < DOWN_M)
                .collect();
            let at = plane(&pressure_center(rate.com, force, rate.angular, height));
            Support::of(&points).nearest(&at).map_or(0.0, |near| (at - near).norm())
        })
        .collect()
}
