//! What the soles of a body were, as `report.json` gives it under `dynamic.soles`.
//!
//! In: [`Soles`]. Out: a [`SolesReport`].

use std::fmt;

use bodies::Soles;
use bodies::soles::{Pad, Toes};
use serde::Serialize;

/// What the soles were; numbers of what does not yield are null.
#[derive(Clone, Debug, Serialize)]
pub struct SolesReport {
    /// The pad under the heel; null of a rigid sole.
    pub heel: Option<PadReport>,
    /// The pad under the ball; null of a rigid sole.
    pub ball: Option<PadReport>,
    /// Stiffness of the hinge of the toes, N·m/rad; null of welded toes.
    pub toes_nm_rad: Option<f64>,
    /// Its damping, N·m·s/rad; null of welded toes.
    pub toes_nm_s_rad: Option<f64>,
}

/// A pad.
#[derive(Clone, Debug, Serialize)]
pub struct PadReport {
    /// Stiffness, N/m.
    pub stiffness_n_m: f64,
    /// Damping, N·s/m.
    pub damping_n_s_m: f64,
    /// How far it gives way before it is compact, mm.
    pub travel_mm: f64,
    /// Stiffness beyond that, N/m.
    pub compact_n_m: f64,
}

impl SolesReport {
    pub(crate) fn new(soles: &Soles) -> Self {
        let pad = |p: &Pad| PadReport {
            stiffness_n_m: p.stiffness_n_m,
            damping_n_s_m: p.damping_n_s_m,
            travel_mm: 1e3 * p.travel_m,
            compact_n_m: p.compact_n_m,
        };
        let toes = |of: fn(&Toes) -> f64| soles.toes.as_ref().map(of);
        Self {
            heel: soles.pads.as_ref().map(|p| pad(&p.heel)),
            ball: soles.pads.as_ref().map(|p| pad(&p.ball)),
            toes_nm_rad: toes(|t| t.stiffness_nm_rad),
            toes_nm_s_rad: toes(|t| t.damping_nm_s_rad),
        }
    }
}

impl fmt::Display for SolesReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.heel, &self.ball) {
            (Some(heel), Some(ball)) => {
                let [heel, ball] = [heel, ball].map(|p| p.stiffness_n_m / 1e3);
                write!(f, "pads of {heel:.0} kN/m under the heel, {ball:.0} under the ball")?;
            }
            _ => write!(f, "rigid")?,
        }
        match self.toes_nm_rad {
            Some(k) => write!(f, "; toes bend at {k:.0} N·m/rad"),
            None => Ok(()),
        }
    }
}
