//! Soles: any engine, with the body on soles that yield.
//!
//! In: an [`EngineEntry`], [`Soles`]. Out: an entry whose engines simulate [`OnSoles::character`] and show the character that they were given:
//! its pose, velocity, drives, stops and wrenches are those of a body with rigid soles, and what touches a pad touches its foot. So controllers, recorders,
//! plans of contacts and files do not know of the parts; [`Engine::whole`], [`Engine::momentum`] and [`Engine::energy`] have them.
//!
//! The law is that of muscles: every part has a [`Drive`], which each engine integrates as it does drives (implicit springs in
//! rapier and the core, MuJoCo's own), re-based every control step. Where a pad's travel ends its stop acts beside it. Between pad and ground contacts are as
//! they always are.

use bodies::soles::Part;
use bodies::{Character, OnSoles, Soles, SolesError};
use controllers::{Drive, Rest};
use dynamics::{Against, Model, Momentum, State, Wrench};
use motion::Vec3;

use crate::{ContactForce, Engine, EngineEntry, EngineError, EngineSettings, Ledger};

impl From<SolesError> for EngineError {
    fn from(error: SolesError) -> Self {
        Self::Failed(error.to_string())
    }
}

/// The drive of a part.
pub(crate) fn drive(part: &Part) -> Drive {
    Drive { stiffness: part.stiffness, damping: part.damping, rest: Rest::Scalar(part.rest) }
}

/// The same engine, with soles that yield.
pub fn entry(engine: &EngineEntry, soles: Soles) -> EngineEntry {
    let inner = engine.clone();
    let own = EngineEntry::new(engine.name(), engine.description(), move |character, settings, q, v| {
        Ok(Box::new(Yielding::new(&inner, soles, character, settings, q, v)?) as Box<dyn Engine>)
    });
    match engine.substeps() {
        Some(substeps) => own.with_substeps(substeps),
        None => own,
    }
}

/// An engine in which a body stands on soles that yield. See the module header.
struct Yielding {
    inner: Box<dyn Engine>,
    soles: Soles,
    parts: Vec<Part>,
    gravity: Vec3,
    /// The character that is shown.
    model: Model,
    /// All that is simulated.
    whole: State,
    /// Of the character, then of the parts.
    drives: Vec<Drive>,
    /// Whether the inner engine has them for the next step.
    driven: bool,
    /// Of the character.
    links: usize,
}

impl Yielding {
    fn new(
        engine: &EngineEntry,
        soles: Soles,
        character: &Character,
        settings: EngineSettings,
        q: &[f64],
        v: &[f64],
    ) -> Result<Self, EngineError> {
        let OnSoles { character: whole, parts, .. } = OnSoles::new(character, &soles)?;
        let gravity = settings.gravity;
        let model = Model::new(character, gravity);
        let (mut q, mut v) = (q.to_vec(), v.to_vec());
        // parts are at rest against their feet
        q.resize(whole.skeleton.nq(), 0.0);
        v.resize(whole.skeleton.nv(), 0.0);
        let inner = engine.build(&whole, settings, &q, &v)?;
        let mut drives = vec![Drive::NONE; model.bodies.len()];
        drives.extend(parts.iter().map(drive));
        let mut built = Self {
            whole: State::new(inner.model()),
            links: character.bodies.len(),
            driven: false,
            inner,
            soles,
            parts,
            gravity,
            model,
            drives,
        };
        built.set_stops(&vec![0.0; built.model.bodies.len()]);
        built.update();
        Ok(built)
    }

    fn update(&mut self) {
        self.whole.update(self.inner.model(), self.inner.q(), self.inner.v());
    }

    /// The link of the character that a link is, or is a part of.
    fn shown(&self, link: usize) -> usize {
        if link < self.links { link } else { self.parts[link - self.links].foot }
    }
}

impl Engine for Yielding {
    fn name(&self) -> &str {
        self.inner.name()
    }

    fn model(&self) -> &Model {
        &self.model
    }

    fn q(&self) -> &[f64] {
        &self.inner.q()[..self.model.skeleton.nq()]
    }

    fn v(&self) -> &[f64] {
        &self.inner.v()[..self.model.nv()]
    }

    fn whole(&self) -> (&[f64], &[f64]) {
        self.inner.whole()
    }

    fn momentum(&self, _: &State) -> Momentum {
        self.whole.momentum(self.inner.model())
    }

    fn energy(&self, _: &State) -> (f64, f64) {
        self.whole.energy(self.inner.model())
    }

    fn set_stops(&mut self, stiffness: &[f64]) {
        let all: Vec<f64> = stiffness.iter().copied().chain(self.parts.iter().map(|p| p.stop)).collect();
        self.inner.set_stops(&all);
    }

    fn stops(&self) -> &[f64] {
        &self.inner.stops()[..self.model.bodies.len()]
    }

    fn set_masses(&mut self, character: &Character) -> Result<(), EngineError> {
        self.inner.set_masses(&OnSoles::new(character, &self.soles)?.character)?;
        self.model = Model::new(character, self.gravity);
        self.update();
        Ok(())
    }

    fn set_drives(&mut self, drives: &[Drive]) {
        self.drives[..drives.len()].copy_from_slice(drives);
        self.inner.set_drives(&self.drives);
        self.driven = true;
    }

    fn move_root(&mut self, _: &State, q_next: &[f64]) {
        self.inner.move_root(&self.whole, q_next);
    }

    fn turn_ground(&mut self, up: &Vec3) {
        self.inner.turn_ground(up);
    }

    fn add_wrench(&mut self, w: &Wrench) {
        self.inner.add_wrench(w);
    }

    fn step(&mut self) -> Result<(), EngineError> {
        if !std::mem::take(&mut self.driven) {
            self.inner.set_drives(&self.drives);
        }
        self.inner.step()?;
        self.update();
        Ok(())
    }

    fn contacts(&self, out: &mut Vec<ContactForce>) {
        let first = out.len();
        self.inner.contacts(out);
        for c in &mut out[first..] {
            c.link = self.shown(c.link);
            if let Against::Link(other) = &mut c.against {
                *other = self.shown(*other);
            }
        }
    }

    fn ledger(&self) -> Option<&Ledger> {
        self.inner.ledger()
    }

    fn runaway(&self) -> Option<&str> {
        self.inner.runaway()
    }
}
