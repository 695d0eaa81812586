//! Replay: the offsets of an earlier run, performed again without a search.
//!
//! In: offsets and the number of the input they were found for. Out: the same offsets, row by row. In the same engine the same bytes come out;
//! an input that differs in anything that the run depends on is refused.

use thiserror::Error;

use super::Subject;
use dynamics::Model;
use motion::Fnv;

/// Offsets of a run. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// What the run was made of, as a number: the motion asked for, body, muscles, ground, rate, substeps and engine.
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
        "the offsets to be replayed were found for another input ({found:016x}; this one is {needed:016x}): motion, body, soles, muscles, ground, rate, substeps and engine have to be the same"
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

/// The number of what a run is made of: FNV-1a over the bits of everything that enters it.
pub(super) fn input(of: &Subject<'_>, model: &Model) -> u64 {
    let mut hash = Input::default();
    let goal = &of.plan.goal;
    hash.text(of.name);
    for numbers in [&goal.q, &goal.v, &goal.vd] {
        hash.numbers(numbers);
    }
    let e = &of.engine;
    hash.numbers(&[goal.rate_hz, e.rate_hz, e.substeps as f64]);
    hash.numbers(e.gravity.as_slice());
    if let Some(ground) = &e.ground {
        hash.numbers(&[ground.height_m, ground.friction]);
        hash.numbers(ground.up.as_slice());
    }
    hash.numbers(of.stops);
    for bears in of.plan.bears() {
        hash.numbers(bears);
    }
    for (b, impedance) in model.bodies.iter().zip(&of.plan.impedances) {
        hash.text(&model.skeleton.links()[b.link].name);
        hash.numbers(&[b.mass, impedance.stiffness, impedance.damping]);
        hash.numbers(b.com.as_slice());
        hash.numbers(b.inertia.as_slice());
        hash.numbers(b.parent_from_zero.translation.vector.as_slice());
        hash.numbers(b.parent_from_zero.rotation.coords.as_slice());
    }
    for body in &of.body.bodies {
        body.shapes.iter().for_each(|shape| hash.text(&format!("{shape:?}")));
    }
    if !of.soles.are_rigid() {
        hash.text(&format!("{:?}", of.soles));
    }
    hash.0.value()
}

#[derive(Default)]
struct Input(Fnv);

impl Input {
    fn numbers(&mut self, numbers: &[f64]) {
        self.0.bytes(&(numbers.len() as u64).to_le_bytes());
        numbers.iter().for_each(|x| self.0.bytes(&x.to_bits().to_le_bytes()));
    }

    fn text(&mut self, text: &str) {
        self.0.bytes(&(text.len() as u64).to_le_bytes());
        self.0.bytes(text.as_bytes());
    }
}
