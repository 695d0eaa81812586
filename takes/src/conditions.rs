//! The conditions of a take: what acts on the body, what holds it, how it is simulated.
//!
//! In: a [`ConditionsSpec`], the floor the motion stands on, how edits moved time. Out: [`Conditions`], one plain value that every
//! take carries whole, wherever its motion came from. SI; times are those of the edited motion.

use bodies::Prop;
use controllers::Gaze;
use dynamics::conditions::Carrying;
use dynamics::conditions::Push;
use motion::{Floor, Tilt, TimeMap};
use programs::Reaction;
use scenes::SceneError;
use scenes::conditions::{Clock, ConditionsSpec, ENGINE, Physics, SEARCH_ENGINE, Timed};
use scenes::scene::Scene;
use sim::foresight::Foreseen;

/// What acts on the body of a take. See the module header.
#[derive(Clone, Debug)]
pub struct Conditions {
    /// Numbers of the dynamic pass.
    pub physics: Physics,
    /// Turns of the ground, in order of time.
    pub tilts: Vec<Tilt>,
    /// Boxes and ramps fixed in the world.
    pub props: Vec<Prop>,
    /// Whether links touch each other.
    pub self_collision: bool,
    /// Pushes from outside.
    pub pushes: Vec<Push>,
    /// Masses carried.
    pub carried: Vec<Carrying>,
    /// Gazes: reactive properties beside the balance.
    pub gazes: Vec<Gaze>,
    /// Programs of the user: reactive properties that act after the gazes.
    pub programs: Vec<Reaction>,
    /// Name of the engine that was asked for, if one was: [`Conditions::performer`], [`Conditions::searcher`].
    pub engine: Option<String>,
    /// How a free body that steps looks ahead; `None`: muscles and contacts alone. It sleeps where the balance stands on planted feet.
    pub foresight: Option<Foreseen>,
}

impl Conditions {
    /// The conditions of a motion that `times` has moved, on `ground`.
    ///
    /// What keeps the motion's clock begins (and a gaze, a carried mass and a turn of the ground end) at the moments of the
    /// motion that the file names; what keeps the world's clock stays at the seconds that it names. A push lasts as long as
    /// it lasted: its impulse is stated. Programs keep the world's clock: they are told the time of the run.
    pub fn resolve(
        spec: &ConditionsSpec,
        programs: Vec<Reaction>,
        times: &TimeMap,
        ground: Option<Floor>,
    ) -> Self {
        let at = |clock: Clock, t_s: f64| match clock {
            Clock::Motion if t_s.is_finite() && !times.is_identity() => times.at(t_s),
            Clock::Motion | Clock::World => t_s,
        };
        let tilt = |Timed { value, clock }: &Timed<Tilt>| {
            let start_s = at(*clock, value.start_s);
            let duration_s = match (clock, times.is_identity()) {
                (Clock::Motion, false) => at(*clock, value.start_s + value.duration_s) - start_s,
                _ => value.duration_s,
            };
            Tilt { start_s, duration_s, ..*value }
        };
        let push = |Timed { value, clock }: &Timed<Push>| Push {
            start_s: at(*clock, value.start_s),
            ..value.clone()
        };
        let carried = |Timed { value, clock }: &Timed<Carrying>| Carrying {
            from_s: at(*clock, value.from_s),
            to_s: at(*clock, value.to_s),
            ..value.clone()
        };
        let gaze = |Timed { value, clock }: &Timed<Gaze>| {
            let s = value.settings();
            value.clone().during(at(*clock, s.from_s), at(*clock, s.to_s))
        };
        Self {
            physics: Physics { ground, ..spec.physics },
            tilts: spec.tilts.iter().map(tilt).collect(),
            props: spec.props.clone(),
            self_collision: spec.self_collision,
            pushes: spec.pushes.iter().map(push).collect(),
            carried: spec.carried.iter().map(carried).collect(),
            gazes: spec.gazes.iter().map(gaze).collect(),
            programs,
            engine: spec.engine.clone(),
            foresight: None,
        }
    }

    /// Name of the engine that performs: the one asked for, else rapier.
    pub fn performer(&self) -> &str {
        self.engine.as_deref().unwrap_or(ENGINE)
    }

    /// Name of the engine in which studies search: the one asked for, else the core.
    pub fn searcher(&self) -> &str {
        self.engine.as_deref().unwrap_or(SEARCH_ENGINE)
    }

    /// The same conditions with all times moved by `by_s` seconds.
    pub fn shifted(&self, by_s: f64) -> Self {
        let mut shifted = self.clone();
        shifted.tilts.iter_mut().for_each(|t| t.start_s += by_s);
        shifted.pushes.iter_mut().for_each(|p| p.start_s += by_s);
        for c in &mut shifted.carried {
            (c.from_s, c.to_s) = (c.from_s + by_s, c.to_s + by_s);
        }
        let moved = |g: &Gaze| {
            let s = g.settings();
            g.clone().during(s.from_s + by_s, s.to_s + by_s)
        };
        shifted.gazes = self.gazes.iter().map(moved).collect();
        shifted.programs = self.programs.iter().map(|p| p.shifted(by_s)).collect();
        shifted
    }
}

/// Refuses what would begin after the motion's end and so never happen. `end_s`: of the motion as written, and as retimed.
pub(crate) fn begin_in_time(scene: &Scene, end_s: [f64; 2], help: &str) -> Result<(), SceneError> {
    let c = &scene.conditions;
    let all = |i: usize, list: &str, field: &str, begins_s: f64, clock: Clock| {
        let end_s = if clock == Clock::World { end_s[1] } else { end_s[0] };
        begins(scene, &format!("{list}[{i}].{field}"), begins_s, end_s, help)
    };
    for (i, Timed { value, clock }) in c.tilts.iter().enumerate() {
        all(i, "world.ground.tilts", "start_s", value.start_s, *clock)?;
    }
    for (i, Timed { value, clock }) in c.pushes.iter().enumerate() {
        all(i, "pushes", "start_s", value.start_s, *clock)?;
    }
    for (i, Timed { value, clock }) in c.carried.iter().enumerate() {
        all(i, "carried", "from_s", value.from_s, *clock)?;
    }
    Ok(())
}

fn begins(scene: &Scene, at: &str, begins_s: f64, end_s: f64, help: &str) -> Result<(), SceneError> {
    if begins_s < end_s {
        return Ok(());
    }
    let message = format!("begins at {begins_s} s; allowed: before the motion ends, at {end_s:.3} s");
    Err(scene.source.error(at, message).with_help(help))
}
