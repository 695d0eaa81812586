//! The motion of a scene that has no script, checked: a clip, or a human motion put on the character.
//!
//! In: `motion: …` of a scene file. Out: paths and options, or an error at the very value. Nothing is opened here.

use std::path::{Path, PathBuf};

use retarget::{GlobalOptions, RefineOptions, SizeRatio};

use crate::schema::{GroundRon, MotionRon, PlaneRon, SceneRon};
use crate::{SceneError, library};

use super::Check;
use super::script::ScriptSpec;

/// Where the motion of a scene comes from.
#[expect(clippy::large_enum_variant, reason = "one per scene")]
#[derive(Clone, Debug)]
pub enum SceneSource {
    /// A script of poses.
    Script(ScriptSpec),
    /// A clip, on the scene's character.
    Clip(PathBuf),
    /// A human motion, put on the scene's character.
    Retarget(Box<RetargetSpec>),
}

impl SceneSource {
    /// The script, if it is one.
    pub fn script(&self) -> Option<&ScriptSpec> {
        match self {
            Self::Script(script) => Some(script),
            Self::Clip(_) | Self::Retarget(_) => None,
        }
    }

    /// The files it names.
    pub fn files(&self) -> Vec<&PathBuf> {
        match self {
            Self::Script(_) => Vec::new(),
            Self::Clip(path) => vec![path],
            Self::Retarget(spec) => {
                let files = [&spec.of].into_iter().chain(&spec.key_poses).chain(&spec.contacts);
                files.collect()
            }
        }
    }

    /// What it is, for people: `script`, `clip walk.bvh`.
    pub fn describe(&self) -> String {
        match self {
            Self::Script(_) => "script".into(),
            Self::Clip(path) => format!("clip {}", path.display()),
            Self::Retarget(spec) => format!("retargeted {}", spec.of.display()),
        }
    }
}

/// A human motion to be put on the character of a scene.
#[derive(Clone, Debug)]
pub struct RetargetSpec {
    /// The performance or clip.
    pub of: PathBuf,
    /// The character's file.
    pub to: PathBuf,
    /// The key poses; `None` takes those beside the character.
    pub key_poses: Option<PathBuf>,
    /// Contact phases by hand; `None` finds them.
    pub contacts: Option<PathBuf>,
    /// How it is done.
    pub options: retarget::Options,
}

impl Check<'_> {
    /// Refuses words of scripts beside a `motion`.
    pub(crate) fn motion_or_script(&self, ron: &SceneRon) -> Result<(), SceneError> {
        if ron.motion.is_none() {
            return Ok(());
        }
        let p = &ron.properties;
        let inherits =
            p.curve.is_some() || p.tension.is_some() || p.duration_s.is_some() || p.hold_s.is_some();
        let of_scripts = [
            ("script", !ron.script.is_empty()),
            ("inserts", !ron.inserts.is_empty()),
            ("footwork", !ron.footwork.is_empty()),
            ("planted", ron.planted.is_some()),
            ("settle_s", ron.settle_s.is_some()),
            ("properties", inherits),
        ];
        let used: Vec<&str> = of_scripts.iter().filter(|(_, used)| *used).map(|(field, _)| *field).collect();
        if let Some(first) = used.first() {
            let all: Vec<String> = used.iter().map(|field| format!("`{field}`")).collect();
            let are = if all.len() == 1 { "is" } else { "are" };
            let e =
                format!("a scene has either a `motion` or a script; {} {are} of a script", all.join(", "));
            return Err(self.source.error(first, e));
        }
        Ok(())
    }

    /// Where the motion of a scene comes from.
    pub(crate) fn motion(
        &self,
        ron: &SceneRon,
        character: &Path,
        script: ScriptSpec,
    ) -> Result<SceneSource, SceneError> {
        let Some(motion) = &ron.motion else { return Ok(SceneSource::Script(script)) };
        match motion {
            MotionRon::Clip(file) => self.clip(ron, file),
            MotionRon::Retarget { of, keyposes, model, stop_after, size, refine, sway, contacts } => {
                self.level(
                    ron,
                    "the ground under a retargeted motion is level: its feet are put on level ground",
                )?;
                let contacts = contacts.as_ref();
                let contacts = contacts
                    .map(|file| self.source.beside("motion.contacts", "file of contact phases", file));
                Ok(SceneSource::Retarget(Box::new(RetargetSpec {
                    of: self.source.beside("motion.of", "performance", of)?,
                    to: character.to_owned(),
                    key_poses: keyposes.as_ref().map(|k| library::beside(self.source.path(), k)),
                    contacts: contacts.transpose()?,
                    options: retarget::Options {
                        model: model.0,
                        stop_after: stop_after.0,
                        global: GlobalOptions { size: self.size(size.0)?, ..GlobalOptions::default() },
                        refine: RefineOptions { dofs: refine.0.clone(), ..RefineOptions::default() },
                        sway: *sway,
                        ..retarget::Options::default()
                    },
                })))
            }
        }
    }

    /// Refuses ground that is tilted from the start.
    fn level(&self, ron: &SceneRon, reason: &str) -> Result<(), SceneError> {
        match ron.world.ground.0 {
            GroundRon::Plane(PlaneRon { tilt_deg, .. }) if tilt_deg != 0.0 => {
                let e = self.source.error("world.ground.tilt_deg", reason);
                Err(e.with_help("`tilts` turn it during the run"))
            }
            _ => Ok(()),
        }
    }

    /// A clip that the character performs.
    fn clip(&self, ron: &SceneRon, file: &str) -> Result<SceneSource, SceneError> {
        self.level(ron, "the ground under a clip is level: it was captured on level ground")?;
        let clip = self.source.beside("motion", "clip", file)?;
        if library::is_location(&clip) {
            let e = format!(
                "`{}` is no clip: the library holds scenes, characters and key poses",
                clip.display()
            );
            return Err(self.source.error("motion", e));
        }
        Ok(SceneSource::Clip(clip))
    }

    fn size(&self, size: SizeRatio) -> Result<SizeRatio, SceneError> {
        match size {
            SizeRatio::Fixed(x) if !(x > 0.0 && x.is_finite()) => {
                let e = format!("the size ratio is {x}; allowed: positive numbers");
                Err(self.source.error("motion.size", e))
            }
            _ => Ok(size),
        }
    }
}
