//! Human motion put on a character, from files.
//!
//! In: a performance (a scene of the human figure, or a BVH clip), a character file, a file of key poses. Out: a
//! [`Session`], which runs the pipeline of `retarget` and names moments whose poses are worth making.
//!
//! ```text
//! performance ─┐
//! character   ─┼─→ Session ─→ run ─→ Retargeted ─→ Take, files
//! key poses   ─┘         └─→ guess, a first pose for a moment
//! contacts (found by a run, edited by hand) ─→ options of the next run
//! ```

pub mod files;
pub mod key_pose_file;
pub mod report;
pub mod stage_report;
pub mod take;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use formats::bvh::ImportOptions;
use motion::Clip;
use retarget::contacts::Phase;
use retarget::{Mapping, Options, Performer, Puppet, RetargetError, Retargeted};

use crate::opening::Opening;
use crate::take::{Body, ClipSource};
use crate::{Ask, TakeError};
use scenes::SceneError;
use scenes::character_file::{self, CharacterFile};
use scenes::contact_file;
use scenes::library::{self, Kind};

pub use key_pose_file::KeyPoseFile;
pub use report::RetargetReport;

/// Why nothing can be put on a character.
#[derive(Debug, thiserror::Error)]
pub enum RetargetingError {
    /// A file of a person.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The performance.
    #[error(transparent)]
    Take(#[from] TakeError),
    /// The request as a whole.
    #[error("{path}: {source}")]
    Retarget {
        /// The file it is about.
        path: String,
        /// What is wrong.
        source: Box<RetargetError>,
    },
    /// No key poses were named, and none lie where they are looked for.
    #[error("no key poses for `{character}`: {} does not exist\n  help: name a file of key poses with --keyposes FILE.ron", .looked.display())]
    NoKeyPoses {
        /// The character.
        character: String,
        /// Where they were looked for.
        looked: PathBuf,
    },
    /// A moment that the performance does not have.
    #[error("{path}: no frame at {at_s} s; the performance runs from 0 to {end_s:.3} s")]
    Moment {
        /// The performance.
        path: String,
        /// Moment asked for, s.
        at_s: f64,
        /// Its last, s.
        end_s: f64,
    },
}

/// A human motion and whose it is.
#[derive(Clone, Debug)]
pub struct Performance {
    /// Name of the file.
    pub name: String,
    /// The motion, on the performer's skeleton.
    pub clip: Clip,
    /// The body with its feature points.
    pub performer: Arc<Performer>,
    /// Height of the ground, m.
    pub ground_m: f64,
    /// How film strips of it are drawn.
    pub strip: scenes::StripSpec,
    /// What was read and guessed of a BVH file; `None` for a scene.
    pub clip_source: Option<ClipSource>,
}

impl Performance {
    /// Opened because of others; a body is a clip's.
    pub(crate) fn opened_by(
        opening: &Opening,
        path: &Path,
        body: Option<&Path>,
        import: &ImportOptions,
    ) -> Result<Self, RetargetingError> {
        let ask = Ask { body: body.map(Path::to_owned), import: *import, ..Ask::default() };
        let take = opening.take(path, &ask)?;
        let performer = Performer::new(take.body.character.as_ref().clone()).map_err(|source| {
            RetargetingError::Retarget { path: path.display().to_string(), source: Box::new(source) }
        })?;
        Ok(Self {
            name: take.name.clone(),
            clip: take.asked.clip.clone(),
            performer: Arc::new(performer),
            ground_m: take.conditions.physics.ground.map_or(0.0, |g| g.height_m),
            strip: take.strip,
            clip_source: take.clip_source().cloned(),
        })
    }

    /// Makes the sites that the puppet's contact points follow contact points of the performer, if they are not:
    /// a hand counts as touching the ground only for bodies that walk on theirs.
    pub fn make_counterparts(&mut self, puppet: &Puppet) {
        let names: Vec<&String> = puppet.contacts.iter().flat_map(|c| &c.human).collect();
        let body = &self.performer.character;
        let sites = body.skeleton.sites().iter().enumerate();
        let new = sites.filter(|(i, s)| names.contains(&&s.name) && !body.contacts.contains(i));
        let new: Vec<usize> = new.map(|(i, _)| i).collect();
        if !new.is_empty() {
            // the feature points stay those of a body without them
            Arc::make_mut(&mut self.performer).character.contacts.extend(new);
        }
    }

    /// The frame at a moment (s).
    ///
    /// # Errors
    /// Before the first or after the last.
    pub fn frame(&self, at_s: f64) -> Result<usize, RetargetingError> {
        let frame = (at_s * self.clip.rate_hz).round();
        if frame >= 0.0 && frame < self.clip.frames() as f64 {
            return Ok(frame as usize);
        }
        Err(RetargetingError::Moment { path: self.name.clone(), at_s, end_s: self.clip.duration_s() })
    }
}

/// A character that can be given a human motion.
#[derive(Clone, Debug)]
pub struct Actor {
    /// What its file says.
    pub file: CharacterFile,
    /// The body with its markers and contact points.
    pub puppet: Puppet,
    /// The file.
    pub path: PathBuf,
}

impl Actor {
    /// Reads a character (also by its name in the library) and checks that it can be given a human motion.
    ///
    /// # Errors
    /// Anything wrong with the file; no contact point with a human counterpart.
    pub fn open(path: &Path) -> Result<Self, RetargetingError> {
        let path = &library::resolve(path, &[Kind::Character]).map_err(TakeError::from)?;
        let file = character_file::read_file(path)?;
        let mut puppet = Puppet::new(file.character.clone(), file.follows.clone()).map_err(|source| {
            RetargetingError::Retarget { path: path.display().to_string(), source: Box::new(source) }
        })?;
        puppet.sways.clone_from(&file.sways);
        Ok(Self { file, puppet, path: path.into() })
    }

    /// Where its key poses are looked for: `keyposes/NAME.ron` beside the folder of characters.
    pub fn key_poses_beside(&self) -> PathBuf {
        let name = self.path.file_name().unwrap_or_default();
        library::beside(&self.path, Path::new("../keyposes").join(name))
    }
}

/// A performance, the character that gets it, and the key poses between them.
#[derive(Clone, Debug)]
pub struct Session {
    /// The human motion.
    pub performance: Performance,
    /// The character.
    pub actor: Actor,
    /// The pairs.
    pub key_poses: KeyPoseFile,
}

impl Session {
    /// Of a performance; `opening` is what it is opened because of.
    pub(crate) fn opened_by(
        opening: &Opening,
        mut performance: Performance,
        character: &Path,
        key_poses: Option<&Path>,
    ) -> Result<Self, RetargetingError> {
        let actor = Actor::open(character)?;
        performance.make_counterparts(&actor.puppet);
        let beside = actor.key_poses_beside();
        let path = match key_poses {
            Some(path) => library::resolve(path, &[Kind::KeyPoses]).map_err(TakeError::from)?,
            None if library::is_file(&beside) => beside,
            None => {
                let character = actor.file.character.name.clone();
                return Err(RetargetingError::NoKeyPoses { character, looked: beside });
            }
        };
        let key_poses = key_pose_file::read(&path, &actor.puppet, opening)?;
        Ok(Self { performance, actor, key_poses })
    }

    /// Contact phases of a file, see [`contact_file`].
    ///
    /// # Errors
    /// Anything wrong with it.
    pub fn contacts(&self, path: &Path) -> Result<Vec<Phase>, RetargetingError> {
        Ok(contact_file::read(path, &self.actor.puppet, self.performance.clip.duration_s())?)
    }

    /// Learns the mapping.
    ///
    /// # Errors
    /// A model that cannot be learned from these pairs, with their file.
    pub fn learn(&self, options: &Options) -> Result<Mapping, RetargetingError> {
        let pairs = &self.key_poses.key_poses;
        Mapping::learn(&self.actor.puppet, pairs, options.model, &options.gplvm).map_err(|source| {
            RetargetingError::Retarget {
                path: self.key_poses.path.display().to_string(),
                source: Box::new(source),
            }
        })
    }

    /// Runs the pipeline with a mapping learned from the same key poses.
    ///
    /// # Errors
    /// [`RetargetError`], with the performance's name.
    pub fn run(&self, mapping: &Mapping, options: &Options) -> Result<Retargeted, RetargetingError> {
        let Performance { clip, performer, .. } = &self.performance;
        let options =
            Options { ground_m: options.ground_m.or(Some(self.performance.ground_m)), ..options.clone() };
        retarget::run_with(mapping, clip, performer, &self.actor.puppet, &options)
            .map_err(|source| self.fault(source))
    }

    /// Up to `count` moments of the motion whose poses the model would learn most from, the most wanted first.
    ///
    /// # Errors
    /// As [`Mapping::suggest`].
    pub fn suggest(
        &self,
        mapping: &Mapping,
        done: &Retargeted,
        count: usize,
    ) -> Result<Vec<report::Suggestion>, RetargetingError> {
        let frames = mapping
            .suggest(&self.performance.performer, &done.human, count)
            .map_err(|source| self.fault(source))?;
        let suggestion = |frame: usize| report::Suggestion {
            at_s: frame as f64 / done.clip.rate_hz,
            confidence: done.mapping.confidence[frame],
        };
        Ok(frames.into_iter().map(suggestion).collect())
    }

    /// An error of the pipeline, with the performance it is about.
    pub fn fault(&self, source: RetargetError) -> RetargetingError {
        RetargetingError::Retarget { path: self.performance.name.clone(), source: Box::new(source) }
    }

    /// Name of the result, for output folders.
    pub fn name(&self) -> String {
        format!("{}-{}", self.performance.name, self.actor.file.character.name)
    }

    /// The body that gets the motion.
    pub fn body(&self) -> Body {
        Body { character: self.actor.puppet.character.clone(), colors: self.actor.file.colors.clone() }
    }
}

/// A first guess for a key pose: the line of a key-pose file for the moment `at_s` (s) of a performance.
///
/// # Errors
/// A moment that the performance does not have; no eyes to look with.
pub fn guess(performance: &Performance, actor: &Actor, at_s: f64) -> Result<String, RetargetingError> {
    let frame = performance.frame(at_s)?;
    let fault =
        |source| RetargetingError::Retarget { path: performance.name.clone(), source: Box::new(source) };
    let skeleton = &performance.performer.character.skeleton;
    let mut human = performance.clip.pose(frame).to_vec();
    human[skeleton.q_at(0) + 1] -= performance.ground_m;
    let q = retarget::guess(&performance.performer, &human, &actor.puppet).map_err(fault)?;
    Ok(key_pose_file::line(&actor.file.character, &performance.name, at_s, &q))
}
