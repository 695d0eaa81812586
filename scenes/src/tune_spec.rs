//! What a scene says about its tuning: parameters, weights, fixed pushes.
//!
//! In: [`TuneRon`]. Out: a [`TuneSpec`] with every name resolved and every number in its
//! range. What is left out has the defaults of [`TuneSpec::default`].

use controllers::{PARAMETERS, Parameter, parameter};

use crate::overrides::{RATES, SUBSTEPS};
use crate::schema::TuneRon;
use crate::{SceneError, Source};

/// Names of the terms of a cost, in the order of [`TuneSpec::weights`]; what each is: `docs/TUNE.md`.
pub const TERMS: [&str; 5] = ["fall", "tracking", "effort", "overshoot", "smoothness"];

/// The most fixed pushes of a cost: more belong into a map, not into every one of some hundred evaluations.
pub const MOST_PUSHES: usize = 8;

/// A push of the cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedPush {
    /// Where it goes: 0 forward, 90 left, 180 back, 270 right, degrees.
    pub deg: f64,
    /// Its impulse, part of the physical limit in that direction.
    pub of_limit: f64,
}

/// How a scene is tuned.
#[derive(Clone, Debug, PartialEq)]
pub struct TuneSpec {
    /// What is searched.
    pub parameters: Vec<&'static Parameter>,
    /// Weights of the terms, in the order of [`TERMS`].
    pub weights: [f64; 5],
    /// Pushes, at most [`MOST_PUSHES`].
    pub pushes: Vec<FixedPush>,
    /// When a push begins, s.
    pub push_at_s: f64,
    /// How long after it the body is watched, s.
    pub after_s: f64,
    /// Control steps per second of the runs costed, Hz; `None`: the scene's.
    pub rate_hz: Option<f64>,
    /// Engine substeps of the runs costed; `None`: the scene's.
    pub substeps: Option<usize>,
    /// Whether the scene itself, without a fixed push, is a run.
    pub own_run: bool,
}

impl Default for TuneSpec {
    /// Every parameter; a left-right symmetric body pushed to one side only, in every direction by 96 to 97 % of what the
    /// shipped defaults survive: what is survived by far says nothing, and what is survived here is a map as large.
    fn default() -> Self {
        let push = |(deg, of_limit)| FixedPush { deg, of_limit };
        let pushes = [
            (0.0, 1.16),
            (22.5, 1.14),
            (45.0, 1.07),
            (67.5, 1.10),
            (90.0, 1.11),
            (112.5, 1.09),
            (135.0, 1.06),
            (180.0, 1.08),
        ];
        Self {
            parameters: PARAMETERS.iter().collect(),
            weights: [1.0, 0.05, 0.05, 0.05, 0.05],
            pushes: pushes.map(push).to_vec(),
            push_at_s: 0.3,
            after_s: 2.5,
            rate_hz: None,
            substeps: None,
            own_run: false,
        }
    }
}

impl TuneSpec {
    /// Reads a scene's section. `scripted`: the scene asks for a motion, which is then a run by itself.
    ///
    /// # Errors
    /// Unknown parameters, numbers out of range, too many pushes: at their place.
    pub fn read(ron: Option<&TuneRon>, scripted: bool, source: &Source) -> Result<Self, SceneError> {
        let default = Self { own_run: scripted, ..Self::default() };
        let Some(ron) = ron else { return Ok(default) };
        let within = |at: &str, x: f64, lo: f64, hi: f64, unit: &str| {
            if x >= lo && x <= hi {
                return Ok(x);
            }
            let name = at.rsplit('.').next().unwrap_or(at);
            Err(source.error(at, format!("{name} is {x}{unit}; allowed: {lo} to {hi}{unit}")))
        };
        let parameters = match &ron.parameters {
            None => default.parameters,
            Some(names) => named(names, |i, name| {
                let known = PARAMETERS.iter().map(|p| p.name);
                source.unknown(&format!("tune.parameters[{i}]"), "parameter", name, " in tune", known)
            })?,
        };
        if parameters.is_empty() {
            return Err(source.error("tune.parameters", "no parameter is named; allowed: at least one"));
        }
        let w = ron.weights.unwrap_or_default();
        let given = [w.fall, w.tracking, w.effort, w.overshoot, w.smoothness];
        let mut weights = default.weights;
        for (i, x) in given.into_iter().enumerate() {
            if let Some(x) = x {
                weights[i] = within(&format!("tune.weights.{}", TERMS[i]), x, 0.0, 1000.0, "")?;
            }
        }
        if weights.iter().all(|w| *w == 0.0) {
            return Err(source.error("tune.weights", "all weights are 0: nothing is minimised"));
        }
        let pushes = match &ron.pushes {
            None => default.pushes,
            Some(list) if list.len() > MOST_PUSHES => {
                let message = format!("{} pushes; allowed: up to {MOST_PUSHES}", list.len());
                return Err(source.error("tune.pushes", message));
            }
            Some(list) => {
                let read = |(i, p): (usize, &crate::schema::FixedPushRon)| {
                    let at = format!("tune.pushes[{i}]");
                    Ok(FixedPush {
                        deg: within(&format!("{at}.deg"), p.deg, -360.0, 360.0, "°")?,
                        of_limit: within(&format!("{at}.of_limit"), p.of_limit, 0.01, 10.0, "")?,
                    })
                };
                list.iter().enumerate().map(read).collect::<Result<_, SceneError>>()?
            }
        };
        let or = |x: Option<f64>, or: f64| x.unwrap_or(or);
        if let Some(n) = ron.substeps.filter(|n| !SUBSTEPS.contains(n)) {
            return Err(source.error("tune.substeps", format!("{n} substeps; allowed: 1 to 64")));
        }
        let rate = |x| within("tune.rate_hz", x, *RATES.start(), *RATES.end(), " Hz");
        Ok(Self {
            parameters,
            weights,
            pushes,
            push_at_s: within("tune.push_at_s", or(ron.push_at_s, default.push_at_s), 0.05, 600.0, " s")?,
            after_s: within("tune.after_s", or(ron.after_s, default.after_s), 0.1, 60.0, " s")?,
            rate_hz: ron.rate_hz.map(rate).transpose()?,
            substeps: ron.substeps,
            own_run: ron.own_run.unwrap_or(default.own_run),
        })
    }
}

/// Parameters by name, each once.
///
/// # Errors
/// What `unknown` makes of a name that does not exist.
pub fn named<E>(names: &[String], unknown: impl Fn(usize, &str) -> E) -> Result<Vec<&'static Parameter>, E> {
    let mut found: Vec<&'static Parameter> = Vec::new();
    for (i, name) in names.iter().enumerate() {
        let p = parameter(name).ok_or_else(|| unknown(i, name))?;
        if !found.contains(&p) {
            found.push(p);
        }
    }
    Ok(found)
}
