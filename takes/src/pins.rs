//! The pins of a scene, held after every other edit.
//!
//! In: a motion that a body may try (limits kept, feet planted, balanced), the pins. Out: the same motion with the pins held, and still
//! such a motion: what a pinned arm changes moves the centre of mass, the balance moves the pelvis, and the hand is off again. So both
//! are done in turn, pins last, until the pelvis rests within [`RESTS_M`]; each turn leaves a third or less of the way. Where a pin
//! cannot be reached they may not agree: then the pins are held as far as they go, and the log says how far the pelvis is from
//! where it would balance.

use edits::{ClipEdit, ClipPlace, EditError, EditLog, Edited, Motion, Pins, Where};
use motion::Clip;
use motion::ik::IkError;
use scenes::scene::{EditKind, Scene, SceneEdit};
use scenes::{SceneError, Source};

/// A pelvis nearer than this to where it balances rests, m: a fiftieth of what the balance keeps to the edges of soles.
const RESTS_M: f64 = 1e-3;
/// Most turns.
const MOST_TURNS: usize = 16;

/// Edits, each with the text it stands in.
type Edits<'a> = &'a [(&'a Source, &'a SceneEdit)];

/// The edits of a scene.
pub(crate) fn edits(scene: &Scene) -> Vec<(&Source, &SceneEdit)> {
    scene.edits.iter().map(|e| (&scene.source, e)).collect()
}

/// The pins among edits, and the first of them.
fn of<'a>(edits: Edits<'a>) -> Option<(Pins, &'a Source, &'a SceneEdit)> {
    let mut first = None;
    let mut pins = Vec::new();
    for (source, edit) in edits {
        if let EditKind::Pin(pin) = &edit.kind {
            first.get_or_insert((*source, *edit));
            pins.push(pin.clone());
        }
    }
    first.map(|(source, first)| (Pins { pins }, source, first))
}

/// Holds the pins among edits, if there are any; whether there are.
///
/// * `shift_s`: what is added to their times; pins that are then outside the motion are left out
/// * `again`: makes a motion one that the body may try, once more
///
/// # Errors
/// Pins that make no sense, limbs that cannot be solved: at the first pin.
pub(crate) fn hold(
    edits: Edits<'_>,
    motion: &Motion,
    shift_s: f64,
    again: &dyn Fn(&mut Clip) -> Result<(), IkError>,
    log: &mut EditLog,
) -> Result<Option<Clip>, SceneError> {
    let Some((mut pins, source, first)) = of(edits) else { return Ok(None) };
    if shift_s != 0.0 {
        let end_s = motion.clip.duration_s();
        pins.pins.retain_mut(|pin| {
            let (from_s, to_s) = (pin.from_s + shift_s, pin.to_s + shift_s);
            (pin.from_s, pin.to_s) = (from_s.max(0.0), to_s.min(end_s));
            pin.from_s <= pin.to_s
        });
    }
    let edited = InTurn { pins, again }
        .apply(motion, &Where::default(), log)
        .map_err(|e| source.error(&first.at, e.to_string()))?;
    Ok(Some(edited.clip))
}

struct InTurn<'a> {
    pins: Pins,
    again: &'a dyn Fn(&mut Clip) -> Result<(), IkError>,
}

impl ClipEdit for InTurn<'_> {
    fn name(&self) -> &'static str {
        self.pins.name()
    }

    fn change(&self, motion: &Motion, at: &ClipPlace, log: &mut EditLog) -> Result<Edited, EditError> {
        let mut holds = self.pins.holds(motion, at)?;
        let mut edited = Edited::unchanged(motion);
        let mut apart = f64::INFINITY;
        for _ in 0..MOST_TURNS {
            holds.hold(&mut edited.clip)?;
            let mut possible = edited.clip.clone();
            (self.again)(&mut possible)?;
            apart = root_apart(&edited.clip, &possible);
            if apart < RESTS_M {
                break;
            }
            edited.clip = possible;
        }
        if apart >= RESTS_M {
            holds.hold(&mut edited.clip)?;
            log.note(format!(
                "balance and pins do not agree: held, the pelvis is up to {:.1} mm from where it would balance",
                1e3 * apart
            ));
        }
        for missed in holds.missed(&edited.clip) {
            log.note(missed.to_string());
        }
        Ok(edited)
    }
}

/// The largest distance of the roots of two clips of as many frames, m.
fn root_apart(a: &Clip, b: &Clip) -> f64 {
    let root = |clip: &Clip, f: usize| motion::Kinematics::new(&clip.skeleton, clip.pose(f)).origin(0);
    (0..a.frames()).map(|f| (root(a, f) - root(b, f)).norm()).fold(0.0, f64::max)
}
