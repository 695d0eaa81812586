//! The stage: a scene or a clip, ready to be performed.
//!
//! In: a scene file, or a motion-capture BVH with (or without) a body. Out: a [`Stage`]: a character, the
//! kinematic motion asked of it, and how to run the dynamic pass. Preview is a stage without its
//! simulation.
//!
//! ```text
//! scene.ron ─→ tracks ─→ edits ─→ sampled, limits, feet planted, balanced ─→ Stage
//! human.bvh ─→ clip ─→ body guessed or given ─→ limits, feet planted where it stands → Stage
//! scene.ron with a motion of a human ─→ retargeting ───────────────────────→ Stage
//! ```

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use controllers::{BalanceSettings, Gaze, Goal, Reactive, Setup, posture};
use dynamics::anthropometry::{BodyOptions, BodyReport, GuessError, guess_body_of_clip};
use dynamics::pose_map::{PoseMap, PoseMapError};
use dynamics::{Carrying, Character, Model, RootMode, State};
use edits::EditLog;
use motion::format::bvh::{self, BvhFileError, ImportOptions, ImportReport};
use motion::plant::{Plant, plant};
use motion::skeleton::quat_at;
use motion::stance::Stance;
use motion::support::ground;
use motion::{Clip, Joint, Kinematics, Shape, Tracks, Transform, Vec3};
use nalgebra::{Point3, Translation3};
use sim::{Ground, Pass, PassError, Push, Tilt};

use crate::overrides::Overrides;
use crate::retargeting::{RetargetingError, Session};
use crate::scene::{self, Physics, Scene};
use crate::scene_motion::SceneMotion;
use crate::schema::StripRon;
use crate::standing::{FRICTION, stance};
use crate::tune::TuneSpec;
use crate::{SceneError, character_file};

/// Why nothing can be staged.
#[derive(Debug, thiserror::Error)]
pub enum StageError {
    /// A scene or character file.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A BVH file.
    #[error(transparent)]
    Bvh(#[from] BvhFileError),
    /// No body for a clip.
    #[error(
        "{path}: {source}\n  help: give a body with --body FILE.ron; `contrapposto inspect CLIP --write-body FILE.ron` writes one of any skeleton it understands"
    )]
    Body {
        /// The clip.
        path: String,
        /// Why.
        source: GuessError,
    },
    /// A body that does not fit the clip.
    #[error("the body does not fit {path}: {source}")]
    Map {
        /// The clip.
        path: String,
        /// Why.
        source: PoseMapError,
    },
    /// A clip too short to perform.
    #[error("{path}: the clip has {frames} frame(s); a motion needs at least 2")]
    Short {
        /// The clip.
        path: String,
        /// Frames found.
        frames: usize,
    },
    /// A clip too long to perform.
    #[error("{path}: {text}", text = too_long(*duration_s, *rate_hz))]
    Long {
        /// The clip.
        path: String,
        /// Its length, s.
        duration_s: f64,
        /// Frames or control steps per second, whichever are more.
        rate_hz: f64,
    },
    /// A span that is not in the clip.
    #[error(
        "{path}: no span {from}..{to} s; the clip lasts {duration_s:.3} s, and a span has at least two frames"
    )]
    Span {
        /// The clip.
        path: String,
        /// Begin asked for, s.
        from: f64,
        /// End asked for, s.
        to: f64,
        /// Length of the clip, s.
        duration_s: f64,
    },
    /// Legs that cannot be planted.
    #[error(
        "{path}: its feet cannot be planted: {source}\n  help: --root pinned performs it without the ground"
    )]
    Legs {
        /// The clip.
        path: String,
        /// Why.
        source: motion::ik::IkError,
    },
    /// Something else than a scene or clip.
    #[error("{0}: neither a scene (.ron) nor a clip (.bvh)")]
    Kind(String),
}

/// The most frames or control steps of a motion: half an hour at 240 Hz makes a trace of some gigabytes.
pub const MOST_STEPS: f64 = 5e5;

fn too_long(duration_s: f64, rate_hz: f64) -> String {
    let shown = if duration_s < 1e7 { format!("{duration_s:.1}") } else { format!("{duration_s:e}") };
    let most = MOST_STEPS / rate_hz;
    format!(
        "the motion lasts {shown} s; at {rate_hz} Hz (frames or control steps) allowed: up to {most:.0} s"
    )
}

/// What a clip came with.
#[derive(Clone, Debug)]
pub struct ClipSource {
    /// The clip as read, with all its joints.
    pub clip: Clip,
    /// Between the clip's joints and the character's.
    pub map: PoseMap,
    /// What was read and guessed of the file.
    pub import: ImportReport,
    /// What was guessed of the body; `None` if it was given.
    pub body: Option<BodyReport>,
}

/// A motion with the body that is to perform it. See the module header.
#[derive(Clone)]
pub struct Stage {
    /// Name, for output folders.
    pub name: String,
    /// The body.
    pub character: Arc<Character>,
    /// The motion asked for: edited, within joint limits, feet planted; at the frame rate.
    pub kinematic: Clip,
    /// The same without edits (equal to `kinematic` when there are none).
    pub unedited: Clip,
    /// The elements behind it, edited; `None` for a clip.
    pub tracks: Option<Tracks>,
    /// The elements without edits; `None` for a clip.
    pub plain: Option<Tracks>,
    /// Who edited what.
    pub log: EditLog,
    /// Feet that stay where they are.
    pub plants: Vec<Plant>,
    /// Numbers of the dynamic pass.
    pub physics: Physics,
    /// Turns of the ground, in order of time.
    pub tilts: Vec<Tilt>,
    /// Pushes from outside.
    pub pushes: Vec<Push>,
    /// Gazes: reactive properties beside the balance.
    pub gazes: Vec<Gaze>,
    /// Masses carried.
    pub carried: Vec<Carrying>,
    /// How film strips are drawn.
    pub strip: StripRon,
    /// How it is tuned.
    pub tune: TuneSpec,
    /// Colour of each link, where the character's file has one.
    pub colors: Vec<Option<[u8; 3]>>,
    /// The clip behind it; `None` for a scene.
    pub clip: Option<ClipSource>,
    /// Where the feet of a clip stand and step; `None` for a scene.
    pub stance: Option<Stance>,
    /// Fraction of the frames that joint limits changed.
    pub clamped: f64,
}

/// Opens a scene (`.ron`) or a clip (`.bvh`); `body` is a character file for a clip.
///
/// # Errors
/// [`StageError`]: anything wrong with the files.
pub fn open(path: &Path, body: Option<&Path>, import: &ImportOptions) -> Result<Stage, StageError> {
    open_with(path, body, import, &Overrides::default())
}

/// [`open`] with numbers of the dynamic pass other than the file's. They must be known this early: a
/// pinned root is not moved to balance the feet.
///
/// # Errors
/// As [`open`].
pub fn open_with(
    path: &Path,
    body: Option<&Path>,
    import: &ImportOptions,
    overrides: &Overrides,
) -> Result<Stage, StageError> {
    let kind = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match kind.as_deref() {
        Some("ron") => {
            let mut scene = scene::read(path)?;
            overrides.apply(&mut scene.physics, &scene.character);
            Ok(stage_scene(scene)?)
        }
        Some("bvh") => {
            let mut stage = stage_clip(path, body, import)?;
            overrides.apply(&mut stage.physics, &stage.character.clone());
            let duration_s = stage.kinematic.duration_s();
            let rate_hz = stage.kinematic.rate_hz.max(stage.physics.rate_hz);
            if duration_s * rate_hz > MOST_STEPS {
                return Err(StageError::Long { path: path.display().to_string(), duration_s, rate_hz });
            }
            if let Some(span) = overrides.span_s {
                stage = stage.cut(frames_of(span, &stage.kinematic, path)?);
            }
            stand_throughout(stage, path)
        }
        _ => Err(StageError::Kind(path.display().to_string())),
    }
}

/// Frames of a span of time.
fn frames_of((from, to): (f64, f64), clip: &Clip, path: &Path) -> Result<Range<usize>, StageError> {
    let duration_s = clip.duration_s();
    let frame = |t: f64| (t * clip.rate_hz).round() as usize;
    if to > duration_s + 0.5 / clip.rate_hz || frame(to) <= frame(from) {
        return Err(StageError::Span { path: path.display().to_string(), from, to, duration_s });
    }
    Ok(frame(from)..(frame(to) + 1).min(clip.frames()))
}

/// A clip that stands from beginning to end, its root not pinned, is performed on planted feet.
fn stand_throughout(stage: Stage, path: &Path) -> Result<Stage, StageError> {
    let Some(stance) = &stage.stance else { return Ok(stage) };
    match &stance.spans[..] {
        [span] if span.stands && stage.physics.root != RootMode::Pinned => stage
            .stand(span, stance.ground_m)
            .map_err(|source| StageError::Legs { path: path.display().to_string(), source }),
        _ => Ok(stage),
    }
}

/// Builds and edits the tracks of a scene, with and without edits.
///
/// # Errors
/// Scripts and edits that make no sense, at their place in the file.
pub fn edited_tracks(scene: &Scene) -> Result<(Tracks, Tracks, EditLog), SceneError> {
    let whole = |e: &dyn std::error::Error| scene.source.error("script", e.to_string());
    let skeleton = &scene.character.skeleton;
    let plain = scene.script.build(skeleton, &scene.character.rest).map_err(|e| whole(&e))?;
    let mut tracks = plain.clone();
    let mut log = EditLog::default();
    for e in &scene.edits {
        for selector in &e.on {
            let fault = |field: &str, text: String| scene.source.error(&format!("{}{field}", e.at), text);
            let selection = selector.select(&tracks).map_err(|x| fault(".on", x.to_string()))?;
            if selection.is_empty() && !selection.is_whole_script() {
                return Err(fault(".on", "nothing is selected: the place has none of these parts".into()));
            }
            e.edit.apply(&mut tracks, &selection, &mut log).map_err(|x| fault("", x.to_string()))?;
        }
    }
    Ok((plain, tracks, log))
}

/// A scene's stage.
///
/// # Errors
/// As [`edited_tracks`], and legs that cannot be solved.
pub fn stage_scene(scene: Scene) -> Result<Stage, SceneError> {
    if let Some(motion) = &scene.motion {
        return stage_retargeted(&scene, motion);
    }
    let (mut plain, mut tracks, log) = edited_tracks(&scene)?;
    let end = tracks.duration_s.max(plain.duration_s) + scene.settle_s;
    let rate_hz = scene.rate_hz.max(scene.physics.rate_hz);
    if end * rate_hz > MOST_STEPS {
        return Err(scene.source.error("script", too_long(end, rate_hz)));
    }
    for (i, t) in scene.tilts.iter().enumerate() {
        begins(&scene, &format!("world.ground.tilts[{i}].start_s"), t.start_s, end)?;
    }
    for (i, p) in scene.pushes.iter().enumerate() {
        begins(&scene, &format!("pushes[{i}].start_s"), p.start_s, end)?;
    }
    for (i, c) in scene.carried.iter().enumerate() {
        begins(&scene, &format!("carried[{i}].from_s"), c.from_s, end)?;
    }
    tracks.duration_s = end;
    plain.duration_s = end;
    let character = scene.character.clone();
    let skeleton = &character.skeleton;
    let mut plants: Vec<Plant> =
        scene.planted.iter().map(|&l| Plant::here(skeleton, &character.rest, &skeleton.limbs()[l])).collect();
    if let Some(ground) = &scene.physics.ground {
        let onto = onto(ground);
        for plant in &mut plants {
            plant.world_from_end = onto * plant.world_from_end;
        }
    }
    let sampler = Sampler { scene: &scene, plants: &plants };
    let (kinematic, clamped) = sampler.sample(&tracks)?;
    let (unedited, _) = sampler.sample(&plain)?;
    Ok(Stage {
        name: scene.name.clone(),
        kinematic,
        unedited,
        tracks: Some(tracks),
        plain: Some(plain),
        log,
        plants,
        physics: scene.physics,
        tilts: scene.tilts.clone(),
        pushes: scene.pushes.clone(),
        carried: scene.carried.clone(),
        gazes: scene.gazes.clone(),
        strip: scene.strip,
        tune: scene.tune.clone(),
        colors: scene.colors.clone(),
        clip: None,
        stance: None,
        clamped,
        character,
    })
}

/// A clip as it looks where tilted ground, given for every frame, is level.
pub(crate) fn levelled(clip: &Clip, ground: impl Fn(usize) -> Ground) -> Clip {
    let skeleton = &clip.skeleton;
    let mut out = clip.clone();
    if !matches!(skeleton.links()[0].joint, Joint::Free) {
        return out;
    }
    let at = skeleton.q_at(0) + 3;
    for f in 0..out.frames() {
        let back = onto(&ground(f)).inverse();
        let q = out.pose_mut(f);
        let p = back * Point3::from(skeleton.position(q, 0));
        skeleton.set_position(q, 0, &p.coords);
        let r = back.rotation * quat_at(q, at);
        q[at..at + 4].copy_from_slice(&[r.w, r.i, r.j, r.k]);
    }
    out
}

/// Refuses what would begin after the motion's end and so never happen.
fn begins(scene: &Scene, at: &str, begins_s: f64, end_s: f64) -> Result<(), SceneError> {
    if begins_s < end_s {
        return Ok(());
    }
    let message = format!("begins at {begins_s} s; allowed: before the motion ends, at {end_s} s");
    let help = "settle_s makes the still time after the last element longer";
    Err(scene.source.error(at, message).with_help(help))
}

/// From level ground to tilted ground: a turn about the point of the ground under the world's origin.
fn onto(ground: &Ground) -> Transform {
    ground.place() * Translation3::from(ground.pivot()).inverse()
}

/// The stage of a scene whose motion is a human's.
fn stage_retargeted(scene: &Scene, motion: &SceneMotion) -> Result<Stage, SceneError> {
    let fault = |e: RetargetingError| match e {
        RetargetingError::Scene(e) => e, // it has a place of its own
        e => scene.source.error("motion", e.to_string()),
    };
    let import = ImportOptions::default();
    let session =
        Session::open(&motion.of, &motion.to, motion.key_poses.as_deref(), &import).map_err(fault)?;
    let mut options = motion.options.clone();
    if let Some(path) = &motion.contacts {
        options.contact.phases = Some(session.contacts(path).map_err(fault)?);
    }
    let mapping = session.learn(&options).map_err(fault)?;
    let done = session.run(&mapping, &options).map_err(fault)?;
    let mut stage = session.stage(&done);
    stage.name.clone_from(&scene.name);
    stage.physics = Physics { rate_hz: stage.physics.rate_hz, ..scene.physics };
    stage.tilts.clone_from(&scene.tilts);
    stage.pushes.clone_from(&scene.pushes);
    stage.strip = scene.strip;
    Ok(stage)
}

struct Sampler<'a> {
    scene: &'a Scene,
    plants: &'a [Plant],
}

impl Sampler<'_> {
    /// Samples tracks at the frame rate, keeps joint limits, plants the feet, and moves the pelvis so
    /// that the centre of mass stays where it is at rest (plus what the script moves the root).
    fn sample(&self, tracks: &Tracks) -> Result<(Clip, f64), SceneError> {
        let character = &self.scene.character;
        let skeleton = &character.skeleton;
        let model = Model::new(character, self.scene.physics.gravity);
        let mut state = State::new(&model);
        state.update(&model, &character.rest, &vec![0.0; model.nv()]);
        let onto = self.scene.physics.ground.as_ref().map_or(Transform::identity(), onto);
        let floor = self.scene.physics.ground.map_or(0.0, |g| g.height_m);
        let com = ground(&state.com(&model));
        let stance = ground(&(onto * Point3::new(com.x, floor, com.y)).coords);
        let home = skeleton.position(&character.rest, 0);
        let ik = |e: motion::ik::IkError| self.scene.source.error("planted", e.to_string());
        let mut clip = tracks.sample(self.scene.rate_hz);
        let mut clamped = 0;
        for f in 0..clip.frames() {
            let q = clip.pose_mut(f);
            clamped += usize::from(skeleton.clamp_to_limits(q));
            if self.plants.is_empty() {
                continue;
            }
            if self.scene.physics.root == RootMode::Pinned {
                let (plants, height) = self.scene.footwork.at(f as f64 / self.scene.rate_hz, self.plants);
                if height > 0.0 {
                    let root = skeleton.position(q, 0) + Vec3::y() * height;
                    skeleton.set_position(q, 0, &root);
                }
                plant(skeleton, q, &plants).map_err(ik)?;
            } else {
                let moved = ground(&(skeleton.position(q, 0) - home));
                posture::settle(&model, &mut state, q, self.plants, stance + moved).map_err(ik)?;
            }
        }
        let share = clamped as f64 / clip.frames() as f64;
        Ok((clip, share))
    }
}

fn stage_clip(path: &Path, body: Option<&Path>, import: &ImportOptions) -> Result<Stage, StageError> {
    let shown = path.display().to_string();
    let (clip, report) = bvh::read_file(path, import)?;
    if clip.frames() < 2 {
        return Err(StageError::Short { path: shown, frames: clip.frames() });
    }
    let mut colors = Vec::new();
    let (character, guess) = match body {
        Some(file) => {
            let read = character_file::read_file(file)?;
            colors = read.colors;
            (read.character, None)
        }
        None => {
            let guessed = guess_body_of_clip(&clip, &BodyOptions::default());
            let (c, r) = guessed.map_err(|source| StageError::Body { path: shown.clone(), source })?;
            (c, Some(r))
        }
    };
    let character = Arc::new(character);
    let skeleton = &character.skeleton;
    let map =
        PoseMap::new(&clip.skeleton, skeleton).map_err(|source| StageError::Map { path: shown, source })?;
    let mut kinematic = map.clip_to_character(&clip, skeleton);
    let mut clamped = 0;
    for f in 0..kinematic.frames() {
        clamped += usize::from(skeleton.clamp_to_limits(kinematic.pose_mut(f)));
    }
    let name = path.file_stem().map_or_else(|| "clip".into(), |s| s.to_string_lossy().into_owned());
    let floor = floor(&character, &kinematic);
    let clamped = clamped as f64 / kinematic.frames() as f64;
    let stance = stance(&character, &kinematic);
    let mut stage = Stage::of_clip(name, character, kinematic);
    stage.physics.ground = floor.map(|height_m| Ground::level(height_m, FRICTION));
    stage.colors = colors;
    stage.clamped = clamped;
    stage.clip = Some(ClipSource { clip, map, import: report, body: guess });
    stage.stance = Some(stance);
    Ok(stage)
}

/// Height below which 2 % of the frames' lowest contact points lie, m; `None` without contact points.
fn floor(character: &Character, clip: &Clip) -> Option<f64> {
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

impl Stage {
    /// A stage for a clip of a character, on ground at height 0, with its root pinned.
    pub fn of_clip(name: String, character: Arc<Character>, kinematic: Clip) -> Self {
        let rate = kinematic.rate_hz;
        Self {
            name,
            unedited: kinematic.clone(),
            tracks: None,
            plain: None,
            log: EditLog::default(),
            plants: Vec::new(),
            physics: Physics {
                // whole control steps per frame, near 240 Hz
                rate_hz: rate * (240.0 / rate).round().max(1.0),
                substeps: None,
                tension: 1.0,
                blend: controllers::GainBlend::RestAngle,
                root: RootMode::Pinned,
                gravity: Vec3::new(0.0, -9.81, 0.0),
                ground: Some(Ground::level(0.0, FRICTION)),
                balance: BalanceSettings::default(),
            },
            tilts: Vec::new(),
            pushes: Vec::new(),
            carried: Vec::new(),
            gazes: Vec::new(),
            tune: TuneSpec { own_run: true, pushes: Vec::new(), ..TuneSpec::default() },
            strip: StripRon::default(),
            colors: Vec::new(),
            clamped: 0.0,
            kinematic,
            clip: None,
            stance: None,
            character,
        }
    }

    /// The same stage with none of its edits.
    pub fn without_edits(&self) -> Self {
        Self {
            kinematic: self.unedited.clone(),
            tracks: self.plain.clone(),
            log: EditLog::default(),
            ..self.clone()
        }
    }

    /// The dynamic pass of this stage.
    pub fn pass(&self) -> Pass {
        let p = &self.physics;
        let held = p.root == RootMode::Pinned;
        let goal = Goal::new(&self.kinematic, p.rate_hz);
        Pass {
            setup: Setup {
                character: self.character.clone(),
                gravity: p.gravity,
                goal,
                tracks: self.tracks.clone(),
                tension: p.tension,
                plants: if held { Vec::new() } else { self.plants.clone() },
                ground_m: if held { None } else { p.ground.map(|g| g.height_m) },
                balance: p.balance,
                blend: p.blend,
                reactive: self.gazes.iter().map(|g| Box::new(g.clone()) as Box<dyn Reactive>).collect(),
            },
            substeps: p.substeps,
            root: p.root,
            // a pinned clip passes through the floor as it was captured: contact would fight the pin
            ground: if held && self.clip.is_some() { None } else { p.ground },
            tilts: self.tilts.clone(),
            pushes: self.pushes.clone(),
            carried: self.carried.clone(),
        }
    }

    /// Runs the dynamic pass.
    ///
    /// # Errors
    /// [`PassError`].
    pub fn perform(&self, progress: &mut dyn FnMut(f64)) -> Result<sim::Outcome, PassError> {
        self.pass().run(progress)
    }

    /// A clip of the character at the frame rate.
    pub fn at_frames(&self, clip: &Clip) -> Clip {
        if clip.rate_hz == self.kinematic.rate_hz {
            clip.clone()
        } else {
            clip.resample(self.kinematic.rate_hz)
        }
    }

    /// A clip of the character at the frame rate, as it is written to files: with all joints of the
    /// clip it came from.
    pub fn for_files(&self, clip: &Clip) -> Clip {
        let clip = self.at_frames(clip);
        match &self.clip {
            Some(source) => source.map.clip_to_source(&clip, &source.clip),
            None => clip,
        }
    }

    /// Unit of length of the BVH files written, m: that of the clip read, else the centimetre.
    pub fn metres_per_unit(&self) -> f64 {
        self.clip.as_ref().map_or(0.01, |source| source.import.units.metres_per_unit)
    }

    /// The body's solids, each with its link.
    pub fn solids(&self) -> Vec<(usize, Shape)> {
        let links = self.character.bodies.iter().enumerate();
        links.flat_map(|(link, body)| body.shapes.iter().map(move |shape| (link, *shape))).collect()
    }
}
