//! Pushes asked for beside the file, as on a command line.
//!
//! In: texts of pushes as a scene has them, a [`Take`] of the whole motion or of a part of it. Out: pushes in the time of the run. A push keeps
//! the motion's time or the world's, as in a scene; one that would begin before the run or after it is refused, as nobody would see it.

use dynamics::Push;
use scenes::conditions::{Clock, Timed};
use scenes::scene::push_of;
use scenes::{SceneError, Source};

use crate::{Ask, Take};

/// The pushes asked for. See the module header.
///
/// # Errors
/// Syntax, unknown links, numbers out of range, times outside the run: at their place in the text.
pub(crate) fn pushes(take: &Take, ask: &Ask) -> Result<Vec<Push>, SceneError> {
    let clip = &take.asked.clip;
    // a part of a clip begins with the frame that is nearest to its time
    let begins_s = match (ask.overrides.span_s, take.clip_source()) {
        (Some((from, _)), Some(_)) => (from * clip.rate_hz).round() / clip.rate_hz,
        _ => 0.0,
    };
    let ends_s = begins_s + clip.duration_s();
    let one = |(i, text): (usize, &String)| {
        let name = if ask.pushes.len() == 1 { "--push".to_owned() } else { format!("--push ({})", i + 1) };
        let source = Source::new(name, text.clone());
        let Timed { value, clock } = push_of(&source, take.character())?;
        let start_s = match clock {
            Clock::Motion => take.asked.times.at(value.start_s),
            Clock::World => value.start_s,
        };
        if !(begins_s..ends_s).contains(&start_s) {
            let message = format!(
                "begins at {start_s} s; allowed: while the motion lasts, {begins_s:.3} to {ends_s:.3} s"
            );
            return Err(source.error("start_s", message));
        }
        Ok(Push { start_s: start_s - begins_s, ..value })
    };
    ask.pushes.iter().enumerate().map(one).collect()
}
