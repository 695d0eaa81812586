//! Opening a take: a file, a text or a clip, with what is asked beside it.
//!
//! In: an [`Input`] and an [`Ask`]. Out: a [`Take`], or a [`TakeError`] with the place of what is wrong.
//!
//! ```text
//! script   ─→ track edits ─→ sampled ─┐
//! clip     ─→ on the body ────────────┼─→ clip edits ─→ limits, feet planted ─→ Take
//! human    ─→ retargeted ─────────────┘
//! ```

use std::path::Path;

use scenes::library::{self, Kind};
use scenes::scene::{self, Scene};
use scenes::{ConditionsSpec, SceneSource, Source as Text};

use crate::ask::is_ron;
use crate::clip::ClipInput;
use crate::opening::Opening;
use crate::{Ask, Input, LookAhead, Take, TakeError, clip, pushed, retargeting, script};

/// Opens a take.
///
/// # Errors
/// [`TakeError`]: anything wrong with the input and the files it names.
pub fn open(input: impl Into<Input>, ask: &Ask) -> Result<Take, TakeError> {
    let mut take = open_asked(input.into(), ask)?;
    take.conditions.foresight = ask.foresight.of(take.scripted_steps());
    let pushes = pushed::pushes(&take, ask)?;
    take.conditions.pushes.extend(pushes);
    let path = take.name.clone();
    take.ready_to_step().map_err(|source| TakeError::Legs { path, source })
}

fn open_asked(input: Input, ask: &Ask) -> Result<Take, TakeError> {
    match input {
        Input::Path(path) => of_path(&path, ask, &Opening::new(of_path)),
        Input::Text { ron, base } => {
            let source = Text::new(base.join("scene.ron"), ron);
            of_scene(scene::parse(source, "scene".into())?, ask)
        }
        Input::Clip { clip, name } => {
            let input = ClipInput::of_memory(clip, name, ask)?;
            clip::take(input, ConditionsSpec::of_clip(), None, ask)
        }
    }
}

/// The take of a file, opened because of others.
pub(crate) fn of_path(path: &Path, ask: &Ask, by: &Opening) -> Result<Take, TakeError> {
    let path = library::resolve(path, &[Kind::Scene])?;
    if is_ron(&path) {
        let opening = by.within(&path)?;
        of_scene_in(scene::read(&path)?, ask, &opening)
    } else if formats::table::is_clip(&path) {
        let input = ClipInput::read(&path, ask)?;
        clip::take(input, ConditionsSpec::of_clip(), None, ask)
    } else {
        Err(TakeError::Kind(path.display().to_string()))
    }
}

/// The take of a checked scene.
///
/// # Errors
/// As [`open()`].
pub fn of_scene(scene: Scene, ask: &Ask) -> Result<Take, TakeError> {
    let path = scene.source.path().to_owned();
    of_scene_in(scene, ask, &Opening::new(of_path).within(&path)?)
}

/// The take of a checked scene, which `opening` has as the youngest file.
fn of_scene_in(mut scene: Scene, ask: &Ask, opening: &Opening) -> Result<Take, TakeError> {
    if !ask.edits.is_empty() {
        return Err(TakeError::Edits { path: scene.source.path().display().to_string() });
    }
    let steps = match &scene.motion {
        SceneSource::Clip(_) => true,
        // its own `contacts` are of its points; those of a motion made possible have places as well
        SceneSource::Retarget(_) => matches!(ask.foresight, LookAhead::As(_)),
        SceneSource::Script(_) => false,
    };
    if ask.contacts.is_some() && !steps {
        return Err(TakeError::Contacts { path: scene.source.path().display().to_string() });
    }
    if ask.loop_s.is_some() && !matches!(scene.motion, SceneSource::Clip(_)) {
        return Err(TakeError::Loop { path: scene.source.path().display().to_string() });
    }
    ask.overrides.apply(&mut scene.conditions.physics, &scene.character);
    ask.overrides.apply_world(&mut scene.conditions);
    if ask.engine.is_some() {
        scene.conditions.engine.clone_from(&ask.engine);
    }
    match &scene.motion {
        SceneSource::Script(script) => Ok(script::take(&scene, script, ask)?),
        SceneSource::Clip(path) => {
            let input = ClipInput::read_for(path, &scene, ask)?;
            clip::take(input, scene.conditions.clone(), Some(&scene), ask)
        }
        SceneSource::Retarget(spec) => Ok(retargeting::take::take(&scene, spec, ask, opening)?),
    }
}
