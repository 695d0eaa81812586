//! Rollouts: many runs from many states, on all processors.
//!
//! In: a core, a state per run, what to do before each step. Out: what each run came to, in the order of the states. A run depends on its
//! state and its number alone, so that results are the same on any number of threads.

use rayon::prelude::*;

use super::{Core, Snapshot};
use crate::{Engine, EngineError};

/// Runs `steps` control steps from each state.
///
/// * `before`: called with a core in the state before each step, the number of the run and of the step: sets drives, adds wrenches,
///   reads the state
/// * `after`: what a run came to: called once with the core after its last step, its number, and why it ended early, if it did
///
/// Runs work on clones of `core`, one per job of the thread pool, and do not allocate.
///
/// # Examples
/// ```
/// use bodies::anthropometry::human::human;
/// use motion::{Floor, Vec3};
/// use sim::core::{Core, rollouts};
/// use sim::{Engine, EngineSettings};
/// let body = human().0;
/// let settings = EngineSettings {
///     rate_hz: 240.0,
///     substeps: 1,
///     gravity: Vec3::new(0.0, -9.81, 0.0),
///     ground: Some(Floor::level(0.0, 0.8)),
///     pinned: false,
///     contact: Default::default(),
///     props: Default::default(),
///     self_collision: false,
/// };
/// let core = Core::new(&body, settings, &body.rest, &vec![0.0; body.skeleton.nv()]).unwrap();
/// let states = vec![core.snapshot(); 4];
/// // without muscles the trunk falls
/// let heights = rollouts(&core, &states, 24, |_, _, _| {}, |_, core, ended| (core.q()[1], ended));
/// assert!(heights.iter().all(|(h, ended)| *h < body.rest[1] && ended.is_none()));
/// ```
pub fn rollouts<T: Send>(
    core: &Core,
    states: &[Snapshot],
    steps: usize,
    before: impl Fn(usize, usize, &mut Core) + Sync,
    after: impl Fn(usize, &Core, Option<EngineError>) -> T + Sync,
) -> Vec<T> {
    let run = |core: &mut Core, number: usize, state: &Snapshot| {
        core.restore(state);
        for step in 0..steps {
            before(number, step, core);
            if let Err(error) = core.step() {
                return after(number, core, Some(error));
            }
        }
        after(number, core, None)
    };
    states.par_iter().enumerate().map_init(|| core.clone(), |core, (i, state)| run(core, i, state)).collect()
}
