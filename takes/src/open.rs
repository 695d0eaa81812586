//! Opening a take: a file, a text or a clip, with what is asked beside it.
//!
//! In: an [`Input`] and an [`Ask`]. Out: a [`Take`], or a [`TakeError`] with the place of what is wrong.
//!
//! ```text
//! script   ─→ track edits ─→ sampled ─┐
//! clip     ─→ on the body ────────────┼─→ clip edits ─→ limits, feet planted ─→ Take
//! human    ─→ retargeted ─────────────┘
//! ```

use scenes::library::{self, Kind};
use scenes::scene::{self, Scene};
use scenes::{ConditionsSpec, SceneSource, Source as Text};

use crate::ask::is_ron;
use crate::clip::ClipInput;
use crate::{Ask, Input, Take, TakeError, clip, retargeting, script};

/// Opens a take.
///
/// # Errors
/// [`TakeError`]: anything wrong with the input and the files it names.
pub fn open(input: impl Into<Input>, ask: &Ask) -> Result<Take, TakeError> {
    match input.into() {
        Input::Path(path) => {
            let path = library::resolve(&path, &[Kind::Scene])?;
            if is_ron(&path) {
                of_scene(scene::read(&path)?, ask)
            } else if formats::table::is_clip(&path) {
                let input = ClipInput::read(&path, ask)?;
                clip::take(input, ConditionsSpec::of_clip(), None, ask)
            } else {
                Err(TakeError::Kind(path.display().to_string()))
            }
        }
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

/// The take of a checked scene.
///
/// # Errors
/// As [`open()`].
pub fn of_scene(mut scene: Scene, ask: &Ask) -> Result<Take, TakeError> {
    ask.overrides.apply(&mut scene.conditions.physics, &scene.character);
    if let Some(engine) = &ask.engine {
        scene.conditions.engine.clone_from(engine);
    }
    match &scene.motion {
        SceneSource::Script(script) => Ok(script::take(&scene, script, ask)?),
        SceneSource::Clip(path) => {
            let input = ClipInput::read_for(path, &scene, ask)?;
            clip::take(input, scene.conditions.clone(), Some(&scene), ask)
        }
        SceneSource::Retarget(spec) => {
            Ok(retargeting::take::take(&scene, spec, ask, &|path, ask| open(path, ask))?)
        }
    }
}
