//! The take of a clip: a captured motion on a body.
//!
//! In: a BVH file or a clip in memory, with or without a body, the conditions, the clip edits of a scene. Out: its [`Take`].
//!
//! ```text
//! clip ─→ body guessed or given ─→ repeated, where asked ─→ clip edits ─→ limits ─→ feet planted where it stands ⇄ pins ─→ Take
//! ```

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bodies::Character;
use bodies::anthropometry::{BodyOptions, BodyReport, guess_body_of_clip};
use bodies::pose_map::PoseMap;
use controllers::Dense;
use dynamics::conditions::RootMode;
use edits::{EditLog, Motion};
use formats::bvh::{ImportOptions, ImportReport};
use motion::{Clip, Cycle, Floor, Kinematics, TimeMap};
use scenes::StripSpec;
use scenes::library::{self, Kind};
use scenes::scene::{self, Scene, SceneEdit};
use scenes::{ConditionsSpec, SceneError, Source as Text, TuneSpec, character_file};

use crate::clip_edits::{self, Clips};
use crate::conditions::begin_in_time;
use crate::error::MOST_STEPS;
use crate::limited::within_limits;
use crate::pins;
use crate::standing::{contacts, stance};
use crate::take::{Asked, Body, ClipSource, Source, Take};
use crate::user_programs::reactions;
use crate::{Ask, Conditions, TakeError};

/// A clip with the body that is to perform it.
pub(crate) struct ClipInput {
    name: String,
    /// What errors call it.
    shown: String,
    clip: Clip,
    import: Option<ImportReport>,
    /// What of it was repeated.
    cycle: Option<Cycle>,
    body: Body,
    guess: Option<BodyReport>,
    map: PoseMap,
    files: Vec<PathBuf>,
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "clip".into(), |s| s.to_string_lossy().into_owned())
}

impl ClipInput {
    /// Reads a clip; its body is the one asked for, or guessed.
    pub(crate) fn read(path: &Path, ask: &Ask) -> Result<Self, TakeError> {
        let given = given_body(ask)?;
        let character = given.as_ref().map(|body| body.character.as_ref());
        let (clip, import) = open_for(path, &ask.import, character)?;
        let input = Self::new(stem(path), path.display().to_string(), clip, Some(import), given)?;
        let body = ask.body.iter().filter(|file| library::is_file(file) && !library::is_location(file));
        let files = body.cloned().chain([path.to_owned()]).collect();
        Self { files, ..input }.looped(ask.loop_s)
    }

    /// Reads the clip of a scene; its body is the scene's.
    pub(crate) fn read_for(path: &Path, scene: &Scene, ask: &Ask) -> Result<Self, TakeError> {
        let (clip, import) = open_for(path, &ask.import, Some(&scene.character))?;
        let clip = match scene.rate_hz {
            Some(rate_hz) if rate_hz != clip.rate_hz => clip.resample(rate_hz),
            _ => clip,
        };
        let body = Body { character: scene.character.clone(), colors: scene.colors.clone() };
        let input = Self::of(scene.name.clone(), path.display().to_string(), clip, Some(import), body, None)?;
        Self { files: scene.files.clone(), ..input }.looped(ask.loop_s.or(scene.loop_s))
    }

    /// A clip in memory.
    pub(crate) fn of_memory(clip: Clip, name: String, ask: &Ask) -> Result<Self, TakeError> {
        let given = given_body(ask)?;
        Self::new(name.clone(), name, clip, None, given)?.looped(ask.loop_s)
    }

    /// The clip going on for `seconds`, if it is to.
    fn looped(mut self, seconds: Option<f64>) -> Result<Self, TakeError> {
        let Some(seconds) = seconds else { return Ok(self) };
        let path = || self.shown.clone();
        if seconds * self.clip.rate_hz > MOST_STEPS {
            return Err(TakeError::Long { path: path(), duration_s: seconds, rate_hz: self.clip.rate_hz });
        }
        let fault = |source| TakeError::Cycling { path: path(), source };
        let cycle = Cycle::find(&self.clip).map_err(fault)?;
        self.clip = cycle.repeat(&self.clip, seconds).map_err(fault)?;
        self.cycle = Some(cycle);
        Ok(self)
    }

    fn new(
        name: String,
        shown: String,
        clip: Clip,
        import: Option<ImportReport>,
        given: Option<Body>,
    ) -> Result<Self, TakeError> {
        if clip.frames() < 2 {
            return Err(TakeError::Short { path: shown, frames: clip.frames() });
        }
        let (body, guess) = match given {
            Some(body) => (body, None),
            None => {
                let guessed = guess_body_of_clip(&clip, &BodyOptions::default());
                let (c, report) =
                    guessed.map_err(|source| TakeError::Body { path: shown.clone(), source })?;
                (Body { character: Arc::new(c), colors: Vec::new() }, Some(report))
            }
        };
        Self::of(name, shown, clip, import, body, guess)
    }

    fn of(
        name: String,
        shown: String,
        clip: Clip,
        import: Option<ImportReport>,
        body: Body,
        guess: Option<BodyReport>,
    ) -> Result<Self, TakeError> {
        if clip.frames() < 2 {
            return Err(TakeError::Short { path: shown, frames: clip.frames() });
        }
        let map = PoseMap::of_clip(&clip, &body.character.skeleton)
            .map_err(|source| TakeError::Map { path: shown.clone(), source })?;
        Ok(Self { name, shown, clip, import, cycle: None, body, guess, map, files: Vec::new() })
    }
}

/// The body asked for.
fn given_body(ask: &Ask) -> Result<Option<Body>, TakeError> {
    let Some(file) = &ask.body else { return Ok(None) };
    let read = character_file::read_file(&library::resolve(file, &[Kind::Character])?)?;
    Ok(Some(Body { character: Arc::new(read.character), colors: read.colors }))
}

/// A clip for a body, which says the unit of length where nobody else does: guesses are made for people, and a clip of a lamp
/// in centimetres is no short person in inches.
fn open_for(
    path: &Path,
    import: &ImportOptions,
    body: Option<&Character>,
) -> Result<(Clip, ImportReport), TakeError> {
    let (clip, report) = formats::open_clip(path, import)?;
    let larger = body.filter(|_| import.metres_per_unit.is_none()).and_then(|c| larger(c, &clip));
    let Some(larger) = larger.filter(|x| (x - 1.0).abs() > SAME_SIZE) else { return Ok((clip, report)) };
    let metres_per_unit = Some(larger * report.units.metres_per_unit);
    let (clip, mut report) = formats::open_clip(path, &ImportOptions { metres_per_unit, ..*import })?;
    report.notes.push("unit of length: that of the body's bones".into());
    Ok((clip, report))
}

/// How much larger a body is than the skeleton of a clip; `None` unless all bones agree.
fn larger(body: &Character, clip: &Clip) -> Option<f64> {
    let pairs = body.skeleton.links().iter().zip(clip.skeleton.links()).skip(1);
    let offset = |link: &motion::Link| link.parent_from_zero.translation.vector;
    let (same, all) = pairs.clone().fold((0.0, 0.0), |(same, all), (own, theirs)| {
        (same + offset(own).norm() * offset(theirs).norm(), all + offset(theirs).norm_squared())
    });
    let larger = same / all;
    let longest = pairs.clone().map(|(own, _)| offset(own).norm()).fold(0.0, f64::max);
    let off = |(own, theirs): (&motion::Link, &motion::Link)| {
        (offset(own).norm() - larger * offset(theirs).norm()).abs()
    };
    let agree = body.skeleton.links().len() == clip.skeleton.links().len()
        && pairs.map(off).all(|off| off < SAME_SIZE * longest);
    (agree && larger.is_finite() && larger > 0.0).then_some(larger)
}

/// Share of a length below which two are the same.
const SAME_SIZE: f64 = 0.01;

/// The take of a clip. `scene` has edits and pictures, where there is one; `spec` is what it says of conditions.
pub(crate) fn take(
    input: ClipInput,
    mut spec: ConditionsSpec,
    scene: Option<&Scene>,
    ask: &Ask,
) -> Result<Take, TakeError> {
    let ClipInput { name, shown, clip: mut source, import, cycle, body, guess, map, mut files } = input;
    if scene.is_none() {
        ask.overrides.apply(&mut spec.physics, &body.character);
        ask.overrides.apply_world(&mut spec);
        if ask.engine.is_some() {
            spec.engine.clone_from(&ask.engine);
        }
    }
    let character = &body.character;
    let given = map.clip_to_character(&source, &character.skeleton);
    let (unedited, mut clamped, mut limited) = within_limits(given.clone());
    let mut log = EditLog::default();
    let mut times = TimeMap::identity();
    let mut clip = unedited.clone();
    let mut dense = Dense::default();
    let asked = edits_asked(&ask.edits, character)?;
    files.extend(asked.iter().filter_map(|(_, e)| e.kind.file().cloned()));
    let of_scene = scene.iter().flat_map(|s| s.edits.iter().map(|e| (&s.source, e)));
    let edits: Vec<(&Text, &SceneEdit)> = of_scene.chain(asked.iter().map(|(text, e)| (text, e))).collect();
    if !ask.no_edits && !edits.is_empty() {
        // every step, also those that no standing span has
        let (contacts, _) = contacts(character, &unedited);
        let floor_m = Some(stance(character, &unedited).ground_m);
        let motion = Motion { contacts, floor_m, ..Motion::of(given) };
        let clips =
            clip_edits::apply_all(edits.iter().copied(), motion, spec.physics.root, &mut log, |_| Ok(None))?;
        dense = clips.tense();
        let Clips { motion, changed, .. } = clips;
        if changed {
            times = motion.times;
            (clip, clamped, limited) = within_limits(motion.clip);
            if !times.is_identity() {
                source = times.retime(&source);
            }
        }
    }
    let ground = ground(&spec, character, &clip);
    let mut stance = stance(character, &clip);
    if let (true, Some(g)) = (spec.height_given, ground) {
        stance.ground_m = g.height_m;
    }
    let take = Take {
        name,
        source: Source::Clip(Box::new(ClipSource { clip: source, map, import, cycle, body: guess })),
        conditions: Conditions::resolve(&spec, scene.map_or(Ok(Vec::new()), reactions)?, &times, ground),
        asked: Asked {
            contacts: contacts(character, &clip).0,
            clip,
            tracks: None,
            dense,
            plants: Vec::new(),
            stance: Some(stance),
            times,
            clamped,
            ignored: Vec::new(),
            limited,
            shifted: None,
            contacts_given: false,
            stepping: Vec::new(),
        },
        unedited,
        log,
        strip: scene.map_or_else(StripSpec::default, |s| s.strip),
        tune: scene.map_or_else(
            || TuneSpec { own_run: true, pushes: Vec::new(), ..TuneSpec::default() },
            |s| s.tune.clone(),
        ),
        files,
        body,
    };
    let duration_s = take.asked.clip.duration_s();
    let rate_hz = take.asked.clip.rate_hz.max(take.control_rate_hz());
    if duration_s * rate_hz > MOST_STEPS {
        return Err(TakeError::Long { path: shown, duration_s, rate_hz });
    }
    if let Some(scene) = scene {
        let lengths_s = [take.unedited.duration_s(), duration_s];
        begin_in_time(scene, lengths_s, "the motion is as long as its clip")?;
    }
    let (take, shift_s) = match ask.overrides.span_s {
        Some(span) => {
            let frames = frames_of(span, &take.asked.clip, &shown)?;
            let shift_s = -(frames.start as f64) / take.asked.clip.rate_hz;
            (take.cut(frames), shift_s)
        }
        None => (take, 0.0),
    };
    let mut take = match &ask.contacts {
        Some(file) => {
            let mut take = take;
            take.give_contacts(file)?;
            take
        }
        None => stand_throughout(take, &shown)?,
    };
    if !ask.no_edits {
        hold_pins(&mut take, &edits, shift_s)?;
    }
    Ok(take)
}

/// Holds the pins among edits in a take that stands or steps as it will.
fn hold_pins(take: &mut Take, edits: &[(&Text, &SceneEdit)], shift_s: f64) -> Result<(), SceneError> {
    let stands = !take.asked.plants.is_empty();
    let (steps, _) = contacts(&take.body.character, &take.asked.clip);
    let motion = Motion {
        contacts: if stands { take.asked.contacts.clone() } else { steps },
        floor_m: take.asked.stance.as_ref().map(|s| s.ground_m),
        unedited: Some(take.unedited.clone().into()),
        times: take.asked.times.clone(),
        ..Motion::of(take.asked.clip.clone())
    };
    let again = |clip: &mut Clip| if stands { take.carry(clip) } else { Ok(()) };
    let mut log = take.log.clone();
    let held = pins::hold(edits, &motion, shift_s, &again, &mut log)?;
    take.log = log;
    if let Some(clip) = held {
        take.asked.clip = clip;
    }
    Ok(())
}

/// The edits asked for beside the file, each a text of its own; the files they name are relative to the working folder.
///
/// # Errors
/// Texts that are no edit, at their place.
fn edits_asked(texts: &[String], character: &Character) -> Result<Vec<(Text, SceneEdit)>, SceneError> {
    let read = |(i, text): (usize, &String)| {
        let name = if texts.len() == 1 { "--edit".to_owned() } else { format!("--edit ({})", i + 1) };
        let text = Text::new(name, text.clone());
        let edit = scene::edit_of_clip(&text, character)?;
        Ok((text, edit))
    };
    texts.iter().enumerate().map(read).collect()
}

/// Frames of a span of time.
fn frames_of((from, to): (f64, f64), clip: &Clip, shown: &str) -> Result<Range<usize>, TakeError> {
    let duration_s = clip.duration_s();
    let frame = |t: f64| (t * clip.rate_hz).round() as usize;
    if to > duration_s + 0.5 / clip.rate_hz || frame(to) <= frame(from) {
        return Err(TakeError::Span { path: shown.into(), from, to, duration_s });
    }
    Ok(frame(from)..(frame(to) + 1).min(clip.frames()))
}

/// A clip that stands from beginning to end, its root not pinned, is performed on planted feet.
fn stand_throughout(take: Take, shown: &str) -> Result<Take, TakeError> {
    let Some(stance) = &take.asked.stance else { return Ok(take) };
    match &stance.spans[..] {
        [span] if span.stands && take.conditions.physics.root != RootMode::Pinned => {
            take.stand(span, stance.ground_m).map_err(|source| TakeError::Legs { path: shown.into(), source })
        }
        _ => Ok(take),
    }
}

/// The ground under a clip: as high as its conditions say, else where its lowest contact points lie.
fn ground(spec: &ConditionsSpec, character: &Character, clip: &Clip) -> Option<Floor> {
    let said = spec.physics.ground?;
    if spec.height_given {
        return Some(said);
    }
    lowest(character, clip).map(|height_m| Floor { height_m, ..said })
}

/// Height below which 2 % of the frames' lowest contact points lie, m; `None` without contact points.
fn lowest(character: &Character, clip: &Clip) -> Option<f64> {
    let sites: Vec<_> = character.contacts.iter().map(|&c| &character.skeleton.sites()[c]).collect();
    let mut k = Kinematics::new(&clip.skeleton, clip.pose(0));
    let mut lowest: Vec<f64> = (0..clip.frames())
        .map(|f| {
            k.update(&clip.skeleton, clip.pose(f));
            sites.iter().map(|s| k.point(s.link, &s.at).y).fold(f64::INFINITY, f64::min)
        })
        .collect();
    lowest.sort_by(f64::total_cmp);
    let height = lowest[lowest.len() / 50];
    height.is_finite().then_some(height)
}
