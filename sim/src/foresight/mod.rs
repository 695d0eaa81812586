//! Foresight: a body that looks half a second ahead keeps its feet where muscles alone let it fall.
//!
//! In: the plan of a motion, the state of the engine that performs. Out: offsets of the targets of some joints, and
//! what they were ([`Used`]). There is no outside wrench: the body does what its muscles do.
//!
//! Every window ([`Settings::window_s`]) copies of the body run ahead in [`crate::core`] from the performing engine's own state, each
//! with offsets of its own; the cheapest way is performed for one window, then all is searched again about it. Any engine performs. The
//! same numbers come out on any number of threads.
//!
//! | file | holds |
//! |---|---|
//! | `settings` | how far it looks, how hard it searches |
//! | `channels` | which joints are moved, and how far |
//! | `spline` | offsets over time |
//! | `ahead` | what is known of the rows to come |
//! | `beside` | what acts beside the plan: pushes under way, reactive properties as they are now |
//! | `cost` | what a state costs |
//! | `search` | the tree of rollouts |
//! | `random` | seeded numbers |
//! | `error` | why it cannot start or go on |
//! | `replay` | offsets of an earlier run, performed again |
//!
//! A push is answered from the step on in which it begins: all is searched again at once, and it is taken to go on until its end. Reactive
//! properties are frozen as they are when a search begins. Not foreseen: pushes that have not begun, and masses that nobody knows of. It is asleep
//! where the balance property stands on planted feet. `docs/WALKING.md` has numbers.

mod ahead;
mod beside;
mod channels;
mod cost;
mod error;
mod random;
mod replay;
mod search;
mod settings;
mod spline;

use std::sync::Arc;

use bodies::{Character, OnSoles, Soles};
use controllers::{Controller, Drive, Plan};
use dynamics::{Carrying, Model, Push, RootMode, State};
use motion::Tilt;

use crate::core::Core;
use crate::{Engine, EngineError, EngineSettings};
use ahead::Ahead;
use beside::Beside;
use cost::Cost;
use search::{Question, Search};
use spline::{between, on_the_way};

pub use channels::Channel;
pub use cost::Scales;
pub use error::ForesightError;
pub use replay::{Replay, ReplayError};
pub use settings::{Choice, ChoiceError, Settings};
pub use spline::Knot;

/// A body lower than this has the scales of one of this height, m.
const LEAST_HEIGHT: f64 = 0.05;

/// Foresight asked of a pass.
#[derive(Clone, Debug, PartialEq)]
pub enum Foreseen {
    /// Searched for while it performs.
    Search(Settings),
    /// The offsets of an earlier run.
    Replay(Arc<Replay>),
}

/// What foresight did in a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Used {
    /// How it searched; `None` of a replay.
    pub settings: Option<Settings>,
    /// What the run was made of, as a number: see [`Replay::input`].
    pub input: u64,
    /// What it moved.
    pub channels: Vec<Channel>,
    /// Offsets per row that was performed, `rows × channels`, rad (m for slides).
    pub offsets: Vec<f64>,
    /// Cost per window of the plan chosen, in the order of the searches.
    pub costs: Vec<f64>,
}

impl Used {
    /// RMS of the offsets over rows and channels, rad; zero of none.
    pub fn offset_rms(&self) -> f64 {
        let sum = self.offsets.iter().fold(0.0, |sum, x| sum + x * x);
        (sum / self.offsets.len().max(1) as f64).sqrt()
    }

    /// The largest offset, rad; zero of none.
    pub fn offset_max(&self) -> f64 {
        self.offsets.iter().fold(0.0, |a, x| a.max(x.abs()))
    }
}

/// Offsets that go along with a pass. See the module header.
pub(crate) struct Foresight {
    way: Way,
    now: Vec<f64>,
    used: Used,
}

enum Way {
    Search(Box<Searching>),
    Replay(Arc<Replay>),
}

/// What a foresight is made for.
pub(crate) struct Subject<'a> {
    pub(crate) controller: &'a Controller,
    /// With what it is known to carry.
    pub(crate) body: &'a Character,
    /// What the performing engine was built for.
    pub(crate) engine: EngineSettings,
    /// Its name.
    pub(crate) name: &'a str,
    /// Stiffness of its stops, N·m/rad.
    pub(crate) stops: &'a [f64],
    /// What its soles do under load.
    pub(crate) soles: &'a Soles,
    /// What holds its root.
    pub(crate) root: RootMode,
    /// Pushes from outside; of those to come it sees nothing.
    pub(crate) pushes: &'a [Push],
    /// Masses carried, known and unknown.
    pub(crate) carried: &'a [Carrying],
    /// Turns of the ground.
    pub(crate) tilts: &'a [Tilt],
}

impl Subject<'_> {
    fn plan(&self) -> &Plan {
        self.controller.plan()
    }
}

impl Foresight {
    /// Foresight of a body for a plan in which nobody else keeps it on its feet.
    ///
    /// # Errors
    /// What the core finds wrong with the body; a replay of another input.
    pub(crate) fn new(foreseen: &Foreseen, of: &Subject<'_>) -> Result<Self, ForesightError> {
        let model = Model::new(of.body, of.engine.gravity);
        let channels = channels::of(of.body, &model, of.plan());
        let input = replay::input(of)?;
        let (way, settings) = match foreseen {
            Foreseen::Search(settings) => {
                let search = Searching::new(*settings, of, &model, channels.clone())?;
                (Way::Search(Box::new(search)), Some(*settings))
            }
            Foreseen::Replay(replay) => {
                replay.check(input, channels.len())?;
                (Way::Replay(replay.clone()), None)
            }
        };
        Ok(Self {
            now: vec![0.0; channels.len()],
            used: Used { settings, input, channels, offsets: Vec::new(), costs: Vec::new() },
            way,
        })
    }

    /// Offsets the targets of `controller` for the step that ends at `row`; `engine` is in the state before it. Of `pushes` it knows those that
    /// act in that step.
    pub(crate) fn act(
        &mut self,
        row: usize,
        engine: &dyn Engine,
        controller: &mut Controller,
        pushes: &[Push],
    ) -> Result<(), ForesightError> {
        match &mut self.way {
            Way::Search(search) => {
                let (q, v) = engine.whole();
                let felt = Felt { q, v, drives: controller.drives(), pushes };
                search.offsets(row, &felt, &mut self.now, &mut self.used)?;
            }
            Way::Replay(replay) => replay.offsets(row, &mut self.now),
        }
        channels::shift(&self.used.channels, &self.now, controller.drives_mut());
        self.used.offsets.extend_from_slice(&self.now);
        Ok(())
    }

    /// What it did.
    pub(crate) fn used(self) -> Used {
        self.used
    }
}

/// What a body feels of the step to come.
struct Felt<'a> {
    /// Its state before the step, parts of its soles included.
    q: &'a [f64],
    v: &'a [f64],
    /// Drives before they are offset.
    drives: &'a [Drive],
    /// All pushes; those that act in the step are felt.
    pushes: &'a [Push],
}

/// A search that goes along with a pass.
struct Searching {
    settings: Settings,
    rate_hz: f64,
    /// Rows per window.
    window: usize,
    channels: Vec<Channel>,
    cost: Cost,
    ahead: Ahead,
    beside: Beside,
    search: Search,
    /// Searches so far: part of the seeds.
    searches: u64,
    /// The row at which the present window began; knots at its beginning and end, and those planned for after it.
    since: Option<usize>,
    from: Knot,
    to: Knot,
    next: Vec<Knot>,
}

impl Searching {
    fn new(
        settings: Settings,
        of: &Subject<'_>,
        model: &Model,
        channels: Vec<Channel>,
    ) -> Result<Self, ForesightError> {
        let supports = channels::supports(of.body, model);
        let window = ((settings.window_s * of.engine.rate_hz).round() as usize).max(1);
        let goal = &of.plan().goal;
        let coarse = EngineSettings {
            rate_hz: of.engine.rate_hz / settings.stride.max(1) as f64,
            substeps: 1,
            contact: crate::ContactLaw::Stiff,
            ..of.engine.clone()
        };
        let on = OnSoles::new(of.body, of.soles).map_err(EngineError::from)?;
        let on = if of.engine.self_collision { on } else { on.on_edges() };
        let (mut q, mut v) = (goal.pose(0).to_vec(), goal.velocity(0).to_vec());
        q.resize(on.character.skeleton.nq(), 0.0);
        v.resize(on.character.skeleton.nv(), 0.0);
        let mut core = Core::new(&on.character, coarse, &q, &v)?;
        let stops: Vec<f64> = of.stops.iter().copied().chain(on.parts.iter().map(|p| p.stop)).collect();
        core.set_stops(&stops);
        core.set_effort(settings.effort);
        let mut state = State::new(model);
        state.update(model, &of.body.rest, &vec![0.0; model.nv()]);
        let lowest = supports.iter().map(|&b| state.bodies[b].com.y).fold(f64::INFINITY, f64::min);
        let height = (state.com(model).y - lowest).max(LEAST_HEIGHT);
        Ok(Self {
            cost: Cost::new(&settings.scales, model, height, &supports),
            ahead: Ahead::new(of.plan(), model, supports, window * settings.windows(), &on.parts),
            beside: Beside::default(),
            search: Search::new(core, &settings, channels.len()),
            searches: 0,
            rate_hz: of.engine.rate_hz,
            since: None,
            from: Knot::zero(channels.len()),
            to: Knot::zero(channels.len()),
            next: Vec::new(),
            channels,
            window,
            settings,
        })
    }

    /// Offsets of the step that ends at `row`.
    fn offsets(
        &mut self,
        row: usize,
        felt: &Felt<'_>,
        now: &mut [f64],
        used: &mut Used,
    ) -> Result<(), ForesightError> {
        let before = row - 1;
        let over = self.since.is_none_or(|since| before >= since + self.window);
        if over || self.beside.misses(before, self.rate_hz, felt.pushes) {
            used.costs.push(self.search(before, felt)?);
        }
        let since = self.since.unwrap_or(before);
        between(&self.from, &self.to, (row - since) as f64 / self.window as f64, now);
        Ok(())
    }

    /// Searches for the offsets of the window that begins at `row`; the cost of what was found.
    fn search(&mut self, row: usize, felt: &Felt<'_>) -> Result<f64, ForesightError> {
        let windows = self.settings.windows();
        let last = (row + self.window * windows).min(self.ahead.rows().count() - 1);
        self.ahead.reach(last)?;
        self.beside.take(row, self.rate_hz, felt.pushes, self.ahead.rows().drives(row + 1), felt.drives);
        self.go_on(row);
        self.search.core().place(felt.q, felt.v);
        self.next.resize(windows, Knot::zero(self.channels.len()));
        let width = self.settings.width * self.cost.width(self.search.core(), self.ahead.rows(), row);
        let question = Question {
            width,
            settings: &self.settings,
            channels: &self.channels,
            cost: &self.cost,
            rows: self.ahead.rows(),
            row,
            window: self.window,
            number: self.searches,
            beside: &self.beside,
            from: &self.from,
            last: &self.next,
        };
        let (mut knots, cost) = self.search.plan(&question);
        self.to = if knots.is_empty() { self.from.clone() } else { knots.remove(0) };
        self.next = knots;
        self.since = Some(row);
        self.searches += 1;
        Ok(cost)
    }

    /// Makes `row` the beginning of a window: `from` is what the offsets are there, `next` what was planned for the ends of this window
    /// and of those after it.
    fn go_on(&mut self, row: usize) {
        let gone = row - self.since.unwrap_or(row);
        if self.since.is_none() || gone >= self.window {
            std::mem::swap(&mut self.from, &mut self.to);
            return;
        }
        let s = gone as f64 / self.window as f64;
        let mut knots = vec![self.from.clone(), self.to.clone()];
        knots.append(&mut self.next);
        let mut moved: Vec<Knot> = knots.windows(2).map(|pair| on_the_way(&pair[0], &pair[1], s)).collect();
        self.from = moved.remove(0);
        self.next = moved;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_of_nothing_and_of_zeros() {
        let used = |offsets: Vec<f64>| Used {
            settings: None,
            input: 0,
            channels: Vec::new(),
            offsets,
            costs: Vec::new(),
        };
        for of in [vec![], vec![0.0; 6]] {
            assert_eq!((used(of.clone()).offset_rms(), used(of).offset_max()), (0.0, 0.0));
        }
        let of = used(vec![3.0, -4.0, 0.0, 0.0]);
        assert_eq!((of.offset_rms(), of.offset_max()), (2.5, 4.0));
    }
}
