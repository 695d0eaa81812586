//! What is cross-checked, and the whole of it.
//!
//! In: a scene, a clip, a character or a model file, and options. Out: a [`CrossCheck`]: the checks, and the
//! curves behind them.
//!
//! | file | ours | MuJoCo's | compared |
//! |---|---|---|---|
//! | scene `.ron`, clip `.bvh` | its character | the same, as MJCF | states, motion, and on its feet: contact |
//! | character `.ron` | the character | the same, as MJCF | states |
//! | MJCF `.xml`, URDF `.urdf` | as [`formats::model`] reads it | as MuJoCo reads it | states |

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use bodies::Character;
use dynamics::{Model, RootMode};
use formats::mjcf::{self, MjcfOptions};
use formats::model::{ImportOptions, Imported};
use formats::model_file::Format;
use formats::mujoco_layout::Layout;
use motion::{Quat, Vec3};
use scenes::Patch;
use scenes::library::{self, Kind};
use scenes::overrides::{Overrides, RootChoice};
use studies::push::PushSettings;
use takes::{Ask, LookAhead, Take, TakeError};

use crate::box_contact::{self, LandingRun};
use crate::bridge::{Bridge, Shared, Source, lock};
use crate::check::Check;
use crate::engine::{engine, engine_in, standing};
use crate::environment;
use crate::error::CrossCheckError;
use crate::forward::{self, ForwardRun};
use crate::ground::{self, SceneRun};
use crate::inject::{Injection, InjectionError};
use crate::push::{self, PushMaps};
use crate::rigid::{self, Compared, LARGEST, OFF, Pair};
use crate::stepping::stepping;

/// How to cross-check.
#[derive(Clone, Debug)]
pub struct Options {
    /// Seed of the random states.
    pub seed: u64,
    /// Number of random states.
    pub states: usize,
    /// Leave out and list what a model file has and rigid-body dynamics has not, instead of refusing it.
    pub dynamics_only: bool,
    /// Another file for MuJoCo's side.
    pub against: Option<PathBuf>,
    /// Faults to put into our side.
    pub inject: Vec<Injection>,
    /// Random states only: no motion, no contact.
    pub states_only: bool,
    /// Compare the push-recovery maps of both engines too.
    pub push_map: Option<PushSettings>,
    /// Patch of tension and balance, for a scene.
    pub patch: Option<Patch>,
    /// What holds the root, other than the file says.
    pub root: Option<RootChoice>,
    /// Factor on every tension.
    pub tension: Option<f64>,
    /// How a free body that steps looks ahead.
    pub foresight: LookAhead,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            seed: 1,
            states: 1000,
            dynamics_only: false,
            against: None,
            inject: Vec::new(),
            patch: None,
            root: None,
            tension: None,
            foresight: LookAhead::Usual,
            states_only: false,
            push_map: None,
        }
    }
}

/// All that was compared.
pub struct CrossCheck {
    /// Name of the subject.
    pub name: String,
    /// MuJoCo's version.
    pub mujoco: String,
    /// Seed of the random states.
    pub seed: u64,
    /// Number of random states.
    pub states: usize,
    /// The checks, in order.
    pub checks: Vec<Check>,
    /// Quantities of which there is nothing to compare, each with the reason.
    pub nothing: Vec<String>,
    /// What a model file has and the comparison has not.
    pub left_out: Vec<String>,
    /// Motion without contacts.
    pub forward: Option<ForwardRun>,
    /// The landing box.
    pub landing: Option<LandingRun>,
    /// The scene on its feet, or the motion that steps.
    pub scene: Option<SceneRun>,
    /// Push-recovery maps.
    pub push: Option<PushMaps>,
}

impl CrossCheck {
    fn take(&mut self, compared: Compared) {
        self.checks.extend(compared.checks);
        self.nothing.extend(compared.nothing);
    }

    /// Checks that failed.
    pub fn failed(&self) -> usize {
        self.checks.iter().filter(|c| !c.pass).count()
    }
}

/// What a cross-check says while it runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event<'a> {
    /// Something worth a line.
    Note(&'a str),
    /// A part of the work and the fraction of it that is done.
    Part(&'static str, f64),
}

enum Subject {
    Model(Box<Imported>),
    Character(Character),
    Take(Box<Take>),
}

/// Runs a cross-check; `on_event` receives what is being done.
///
/// # Errors
/// [`CrossCheckError`]. Checks that fail are no error.
pub fn run(
    path: &Path,
    options: &Options,
    on_event: &mut (dyn FnMut(Event<'_>) + Send),
) -> Result<CrossCheck, CrossCheckError> {
    let subject = open(path, options)?;
    if options.push_map.is_some() && !matches!(subject, Subject::Take(_)) {
        return Err(CrossCheckError::NoScene(path.display().to_string()));
    }
    let other = options.against.as_deref().map(|p| open(p, options).map(|s| (p, s))).transpose()?;
    let python = environment::prepare(&mut |text| on_event(Event::Note(text)))?;
    on_event(Event::Part("random states", 0.0));
    let bridge = Bridge::start(&python)?.shared();
    let name = path.file_stem().map_or_else(|| "model".into(), |s| s.to_string_lossy().into_owned());
    let mut out = CrossCheck {
        name,
        mujoco: environment::MUJOCO.into(),
        seed: options.seed,
        states: options.states,
        checks: Vec::new(),
        nothing: Vec::new(),
        left_out: Vec::new(),
        forward: None,
        landing: None,
        scene: None,
        push: None,
    };
    let wrong = |c: &Character| -> Result<Character, InjectionError> {
        options.inject.iter().try_fold(c.clone(), |c, fault| fault.apply(&c))
    };
    let against = |what| CrossCheckError::Against {
        against: options.against.as_ref().map_or_else(String::new, |p| p.display().to_string()),
        what,
    };
    match &subject {
        Subject::Model(ours) => {
            let (file, read) = match &other {
                None => (path, ours),
                Some((p, Subject::Model(read))) => (*p, read),
                Some(_) => return Err(against("a model file")),
            };
            out.left_out = ours.left_out.iter().map(ToString::to_string).collect();
            let character = wrong(&ours.character)?;
            let joints: Vec<usize> = ours.joints.iter().map(|j| j.link).collect();
            let file = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
            let theirs = Theirs {
                source: Source::File(&file),
                file: Some(ours),
                names: body_names(read),
                joints: &joints,
                turn: ours.ours_from_file,
            };
            out.take(states(&character, ours.gravity, &theirs, &bridge, options)?);
        }
        Subject::Character(_) | Subject::Take(_) => {
            let (character, gravity) = subject.body();
            let there = match &other {
                None => character,
                Some((_, Subject::Model(_))) => return Err(against("a scene or character")),
                Some((_, s)) => s.body().0,
            };
            let file = mjcf::write(there, &MjcfOptions { gravity, ..MjcfOptions::default() })?;
            let theirs = Theirs {
                source: Source::Text(&file.text),
                file: None,
                names: None,
                joints: &file.joints,
                turn: Quat::identity(),
            };
            out.take(states(&wrong(character)?, gravity, &theirs, &bridge, options)?);
        }
    }
    if let (Subject::Take(take), false) = (&subject, options.states_only) {
        engines(path, take, options, &bridge, &mut out, on_event)?;
    }
    if let (Subject::Take(take), Some(settings)) = (&subject, options.push_map) {
        pushes(take, settings, &mut out, on_event)?;
    }
    Ok(out)
}

/// The push-recovery maps of a take in both engines.
fn pushes(
    take: &Take,
    settings: PushSettings,
    out: &mut CrossCheck,
    on_event: &mut (dyn FnMut(Event<'_>) + Send),
) -> Result<(), CrossCheckError> {
    on_event(Event::Part("push maps", 0.0));
    let on_event = Mutex::new(on_event);
    let send = |event: Event<'_>| {
        if let Ok(mut on_event) = on_event.lock() {
            on_event(event);
        }
    };
    // the environment was prepared above, so there is nothing to note
    let theirs = engine(|_| {});
    let pair = push::compare(take, settings, &theirs, &|x| send(Event::Part("push maps", x)))?;
    out.checks.push(pair.check.clone());
    out.push = Some(pair);
    Ok(())
}

impl Subject {
    fn body(&self) -> (&Character, Vec3) {
        match self {
            Self::Model(m) => (&m.character, m.gravity),
            Self::Character(c) => (c, dynamics::conditions::GRAVITY),
            Self::Take(s) => (s.character(), s.conditions.physics.gravity),
        }
    }
}

fn open(path: &Path, options: &Options) -> Result<Subject, CrossCheckError> {
    let path = &library::resolve(path, &[Kind::Scene, Kind::Character]).map_err(TakeError::from)?;
    let take = || Ok(Subject::Take(Box::new(take_of(path, options.root, options)?)));
    if formats::table::is_model(path) {
        let read = ImportOptions { dynamics_only: options.dynamics_only };
        return Ok(Subject::Model(Box::new(formats::open_model(path, &read)?)));
    }
    if formats::table::is_clip(path) {
        return take();
    }
    if !takes::is_ron(path) {
        return Err(CrossCheckError::Kind(path.display().to_string()));
    }
    match takes::character_in(path).map_err(TakeError::from)? {
        Some(character) => Ok(Subject::Character(character)),
        None => take(),
    }
}

fn take_of(path: &Path, root: Option<RootChoice>, options: &Options) -> Result<Take, TakeError> {
    let (patch, tension) = (options.patch.clone(), options.tension);
    let overrides = Overrides { patch, tension, root, ..Overrides::default() };
    takes::open(path, &Ask { overrides, foresight: options.foresight.clone(), ..Ask::default() })
}

/// Our names of the bodies of an MJCF, in its order. Those of a URDF all have a name, and MuJoCo may order them in another way.
fn body_names(read: &Imported) -> Option<Vec<&str>> {
    let name =
        |link: &Option<usize>| link.map_or("world", |l| read.character.skeleton.links()[l].name.as_str());
    (read.format == Format::Mjcf).then(|| read.bodies.iter().map(name).collect())
}

struct Theirs<'a> {
    source: Source<'a>,
    /// What was read of it, if both sides read a file.
    file: Option<&'a Imported>,
    /// Our names of its bodies in its order, where those of the file may not be enough.
    names: Option<Vec<&'a str>>,
    joints: &'a [usize],
    turn: Quat,
}

fn states(
    character: &Character,
    gravity: Vec3,
    theirs: &Theirs<'_>,
    bridge: &Shared,
    options: &Options,
) -> Result<Compared, CrossCheckError> {
    let model = Model::new(character, gravity);
    if model.nv() > LARGEST {
        return Err(CrossCheckError::TooLarge(model.nv()));
    }
    let mut bridge = lock(bridge);
    let mut info = bridge.load(&theirs.source, &OFF, true)?;
    if let Some(names) = &theirs.names {
        info.name_bodies(names)?;
    }
    let places = info.places(&character.skeleton, theirs.joints)?;
    let layout = match theirs.file {
        Some(read) => Layout::in_file_axes(&read.character.skeleton, &places, info.nq, info.nv),
        None => Layout::new(&character.skeleton, &places, info.nq, info.nv),
    };
    let pair = Pair {
        model: &model,
        info: &info,
        layout: &layout,
        joints: theirs.joints,
        ours_from_file: theirs.turn,
    };
    Ok(rigid::compare(&pair, &mut bridge, options.seed, options.states)?)
}

/// Motion and contact of a take. Faults are put into our side by giving MuJoCo the take as it was.
fn engines(
    path: &Path,
    take: &Take,
    options: &Options,
    bridge: &Shared,
    out: &mut CrossCheck,
    on_event: &mut dyn FnMut(Event<'_>),
) -> Result<(), CrossCheckError> {
    let faulty = !options.inject.is_empty() || options.against.is_some();
    if faulty {
        // against another body only the states are compared: different bodies move differently
        return Ok(());
    }
    let free = matches!(take.body.character.skeleton.links()[0].joint, motion::Joint::Free);
    let pinned = if free { take_of(path, Some(RootChoice::Pinned), options)? } else { take.clone() };
    on_event(Event::Part("motion without contact", 0.0));
    let forward =
        forward::compare(bridge, &pinned, &mut |x| on_event(Event::Part("motion without contact", x)))?;
    out.checks.extend(forward.checks.clone());
    out.nothing.extend(forward.nothing.clone());
    out.forward = Some(forward);
    if take.looks_ahead() {
        on_event(Event::Part("stepping", 0.0));
        let mujoco = engine_in(bridge, standing());
        let run = stepping(take, &mujoco, &mut |x| on_event(Event::Part("stepping", x)))?;
        out.checks.extend(run.checks.clone());
        out.nothing.extend(run.nothing.clone());
        out.scene = Some(run);
        return Ok(());
    }
    let physics = &take.conditions.physics;
    let on_feet = physics.root == RootMode::Free && free && physics.ground.is_some();
    if !on_feet || take.asked.plants.is_empty() {
        return Ok(());
    }
    if physics.gravity == Vec3::zeros() {
        out.nothing.push("contact: without gravity nothing stands".into());
        return Ok(());
    }
    on_event(Event::Part("boxes", 0.0));
    out.checks.extend(box_contact::resting_box(bridge)?);
    let landing = box_contact::landing(bridge)?;
    out.checks.extend(landing.checks.clone());
    out.landing = Some(landing);
    on_event(Event::Part("standing", 0.0));
    out.checks.push(ground::standing_weight(bridge, take)?);
    on_event(Event::Part("on its feet", 0.0));
    let scene = ground::scene(bridge, take, &mut |x| on_event(Event::Part("on its feet", x)))?;
    out.checks.extend(scene.checks.clone());
    out.nothing.extend(scene.nothing.clone());
    out.scene = Some(scene);
    Ok(())
}
