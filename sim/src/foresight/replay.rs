//! Replay: the offsets of an earlier run, performed again without a search.
//!
//! In: offsets and the number of the input they were found for. Out: the same offsets, row by row. In the same engine the same bytes come out;
//! an input that differs in anything that the run depends on is refused.

use bodies::Soles;
use controllers::{Controller, Plan, ReactiveError, Rest};
use dynamics::RootMode;
use dynamics::digest::{self, Digest};
use motion::names::Word;
use thiserror::Error;

use super::Subject;
use crate::{ContactLaw, EngineSettings};

/// Offsets of a run. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// What the run was made of, as a number: the motion asked for, body, muscles, reactive properties, ground, what stands on it, pushes, carried
    /// masses, rate, substeps and engine.
    pub input: u64,
    /// Degrees of freedom that are offset.
    pub channels: usize,
    /// Offsets per row from the first step on, `rows × channels`, rad (m for slides).
    pub offsets: Vec<f64>,
}

/// Offsets that are of another run.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ReplayError {
    /// Found for something else.
    #[error(
        "the offsets to be replayed were found for another input ({found:016x}; this one is {needed:016x}): motion, body, soles, muscles, reactive properties, ground, pushes, carried masses, rate, substeps and engine have to be the same"
    )]
    Input {
        /// Number of the input they were found for.
        found: u64,
        /// Number of the present one.
        needed: u64,
    },
    /// Of another number of degrees of freedom.
    #[error("the offsets to be replayed are for {found} degrees of freedom; this body has {needed}")]
    Channels {
        /// Degrees of freedom of the offsets.
        found: usize,
        /// Those of the body.
        needed: usize,
    },
}

impl Replay {
    /// Whether these are the offsets of an input.
    ///
    /// # Errors
    /// [`ReplayError`]: they are of another.
    pub(super) fn check(&self, input: u64, channels: usize) -> Result<(), ReplayError> {
        if self.input != input {
            return Err(ReplayError::Input { found: self.input, needed: input });
        }
        if self.channels != channels {
            return Err(ReplayError::Channels { found: self.channels, needed: channels });
        }
        Ok(())
    }

    /// Offsets of the step that ends at `row`; zero past the end of what was recorded.
    pub(super) fn offsets(&self, row: usize, out: &mut [f64]) {
        let at = (row - 1) * self.channels;
        match self.offsets.get(at..at + self.channels) {
            Some(offsets) => out.copy_from_slice(offsets),
            None => out.fill(0.0),
        }
    }
}

/// The number of what a run is made of: a digest of everything that enters it.
///
/// The plan enters by what comes of it: the motion asked for, and the drives of every row before anything answers the state.
///
/// # Errors
/// Of the controller.
pub(super) fn input(of: &Subject<'_>) -> Result<u64, ReactiveError> {
    let mut d = Digest::default();
    let plan = of.plan();
    d.text(of.name);
    for numbers in [&plan.goal.q, &plan.goal.v, &plan.goal.vd] {
        d.list(numbers, |d, x| d.number(*x));
    }
    drives(&mut d, plan)?;
    // field by field: one that is added does not compile before it has a place here
    let EngineSettings { rate_hz, substeps, gravity, ground, pinned, contact, props, self_collision } =
        &of.engine;
    d.numbers([&plan.goal.rate_hz, rate_hz]);
    d.count(*substeps);
    digest::vector(&mut d, gravity);
    d.option(ground.as_ref(), digest::floor);
    d.count(usize::from(*pinned));
    match contact {
        ContactLaw::Stiff => d.count(0),
        ContactLaw::Spring { natural_frequency_hz, damping_ratio } => {
            d.count(1);
            d.numbers([natural_frequency_hz, damping_ratio]);
        }
        ContactLaw::Compliant { stiffness_n_m, damping_n_s_m } => {
            d.count(2);
            d.numbers([stiffness_n_m, damping_n_s_m]);
        }
    }
    d.list(props, digest::prop);
    d.count(usize::from(*self_collision));
    for bears in plan.bears() {
        d.list(bears, |d, x| d.number(*x));
    }
    d.list(of.stops, |d, x| d.number(*x));
    digest::character(&mut d, of.body);
    d.text(of.root.name().word());
    if let RootMode::Assisted { force_n, moment_nm } = &of.root {
        d.numbers([force_n, moment_nm]);
    }
    let Soles { pads, toes } = of.soles;
    d.option(pads.as_ref(), digest::pads);
    d.option(toes.as_ref(), digest::toes);
    d.list(of.pushes, digest::push);
    d.list(of.carried, digest::carrying);
    d.list(of.tilts, digest::tilt);
    of.controller.identify_reactive(&mut d);
    Ok(d.value())
}

/// The drives of a plan, row by row.
fn drives(d: &mut Digest, plan: &Plan) -> Result<(), ReactiveError> {
    let mut controller = Controller::unanswering(plan.clone());
    for row in 1..plan.goal.rows() {
        let drives = controller.step(row, plan.goal.pose(row - 1), plan.goal.velocity(row - 1))?;
        d.list(drives, |d, drive| {
            d.numbers([&drive.stiffness, &drive.damping]);
            match &drive.rest {
                Rest::None => d.count(0),
                Rest::Scalar(at) => {
                    d.count(1);
                    d.number(*at);
                }
                Rest::Ball { target, shift } => {
                    d.count(2);
                    d.numbers(target.as_vector());
                    digest::vector(d, shift);
                }
            }
        });
    }
    Ok(())
}
