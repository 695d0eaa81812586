//! MuJoCo in the table of engines ([`sim::Engines`]).
//!
//! In: a function that is called when the Python environment is being made. Out: an [`EngineEntry`] whose engines simulate in MuJoCo.
//! The environment is prepared by the first build. Every engine has a MuJoCo process of its own while it lives: a process
//! holds one model. Processes that became idle are used again, so their number is that of the engines that live at once.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use sim::{ContactLaw, Engine, EngineEntry, EngineError, EngineSettings};

use crate::bridge::{Bridge, Shared, lock};
use crate::environment;
use crate::mujoco::{Integration, Mujoco, NAME};

const DESCRIPTION: &str = "MuJoCo in a Python environment made on first use; much slower";

/// MuJoCo; `note` is called, from any thread, when its Python environment is made.
pub fn engine(note: impl Fn(&str) + Send + Sync + 'static) -> EngineEntry {
    let processes = Processes::default();
    EngineEntry::new(NAME, DESCRIPTION, move |character, settings, q, v| {
        let integration = integration(&settings)?;
        let bridge = processes.idle(&note)?;
        Ok(Box::new(Mujoco::new(bridge, &integration, character, settings, q, v)?) as Box<dyn Engine>)
    })
    .with_substeps(standing().substeps)
}

/// MuJoCo in one running process, integrated in one way: for one engine at a time.
pub fn engine_in(bridge: &Shared, integration: Integration) -> EngineEntry {
    let bridge = bridge.clone();
    let substeps = integration.substeps;
    EngineEntry::new(NAME, DESCRIPTION, move |character, settings, q, v| {
        let mujoco = Mujoco::new(bridge.clone(), &integration, character, settings, q, v)?;
        Ok(Box::new(mujoco) as Box<dyn Engine>)
    })
    .with_substeps(substeps)
}

/// How bodies stand in MuJoCo.
pub fn standing() -> Integration {
    Integration {
        integrator: "discrete",
        substeps: 8,
        solref: Some([0.004, 1.0]),
        solimp: Some([0.9, 0.95, 0.001, 0.5, 2.0]),
    }
}

/// How a body with these settings is integrated, in as many steps as they say: where it may touch something so that its contact solver sees the implicit damping,
/// elsewhere to fourth order.
fn integration(settings: &EngineSettings) -> Result<Integration, EngineError> {
    let touches = settings.ground.is_some() || !settings.props.is_empty() || settings.self_collision;
    match (settings.contact, touches) {
        (ContactLaw::Spring { .. } | ContactLaw::Compliant { .. }, true) => Err(EngineError::Failed(
            "spring contacts are not translated to MuJoCo, whose solref is per mass of the body; use stiff ones".into(),
        )),
        (ContactLaw::Stiff, true) => Ok(Integration { substeps: settings.substeps, ..standing() }),
        (_, false) => Ok(Integration::reference(settings.substeps)),
    }
}

/// Python with MuJoCo, and its processes.
#[derive(Default)]
struct Processes {
    /// `None` until it is prepared.
    python: Mutex<Option<PathBuf>>,
    /// A process to which no other reference exists is idle.
    started: Mutex<Vec<Shared>>,
}

impl Processes {
    /// A process that no engine uses.
    fn idle(&self, note: &dyn Fn(&str)) -> Result<Shared, EngineError> {
        let python = self.python(note)?;
        if let Some(idle) = self.reused() {
            return Ok(idle);
        }
        let bridge = Bridge::start(&python).map_err(|e| EngineError::Failed(e.to_string()))?.shared();
        unpoisoned(&self.started).push(bridge.clone());
        Ok(bridge)
    }

    fn python(&self, note: &dyn Fn(&str)) -> Result<PathBuf, EngineError> {
        let mut python = unpoisoned(&self.python);
        if python.is_none() {
            let prepared = environment::prepare(&mut |text| note(text));
            *python = Some(prepared.map_err(|e| EngineError::Failed(e.to_string()))?);
        }
        Ok(python.clone().expect("prepared above"))
    }

    /// A process that became idle; those that ended are forgotten.
    fn reused(&self) -> Option<Shared> {
        let mut started = unpoisoned(&self.started);
        // only this list holds an idle process, so that nobody can take it between the count and the clone
        let idle = |b: &Shared| Arc::strong_count(b) == 1;
        started.retain(|b| !idle(b) || !lock(b).is_gone());
        started.iter().find(|b| idle(b)).cloned()
    }
}

fn unpoisoned<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
