//! The human motion of a scene, checked: which performance, onto which character, how.
//!
//! In: `motion: Retarget(…)` of a scene file. Out: paths and options, or an error at the very value. The retargeting
//! itself is [`crate::retargeting`].

use std::path::{Path, PathBuf};

use retarget::{GlobalOptions, MappingModel, RefineDofs, RefineOptions, SizeRatio};

use crate::SceneError;
use crate::scene::Check;
use crate::schema::{ModelRon, MotionRon, RefineRon, SceneRon, SizeRon, StopAfterRon};

/// A human motion to be put on the character of a scene.
#[derive(Clone, Debug)]
pub struct SceneMotion {
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
    /// The human motion of a scene that has no script of its own.
    pub(crate) fn motion(&self, ron: &SceneRon, character: &Path) -> Result<Option<SceneMotion>, SceneError> {
        let Some(MotionRon::Retarget { of, keyposes, model, stop_after, size, refine, sway, contacts }) =
            &ron.motion
        else {
            return Ok(None);
        };
        for (field, used) in [
            ("script", !ron.script.is_empty()),
            ("inserts", !ron.inserts.is_empty()),
            ("edits", !ron.edits.is_empty()),
            ("footwork", !ron.footwork.is_empty()),
        ] {
            if used {
                let e = format!("a scene has either a `motion` or a script; `{field}` is of a script");
                return Err(self.source.error(field, e));
            }
        }
        let folder = self.source.path().parent().unwrap_or(Path::new(""));
        Ok(Some(SceneMotion {
            of: self.source.beside("motion.of", "performance", of)?,
            to: character.to_owned(),
            key_poses: keyposes.as_ref().map(|k| folder.join(k)),
            contacts: match contacts {
                Some(file) => Some(self.source.beside("motion.contacts", "file of contact phases", file)?),
                None => None,
            },
            options: retarget::Options {
                model: match model {
                    ModelRon::Gplvm => MappingModel::Gplvm,
                    ModelRon::Gp => MappingModel::Gp,
                    ModelRon::Pca => MappingModel::Pca,
                    ModelRon::Nn3 => MappingModel::Nn3,
                    ModelRon::Nn10 => MappingModel::Nn10,
                },
                stop_after: match stop_after {
                    StopAfterRon::Map => retarget::Stage::Map,
                    StopAfterRon::Global => retarget::Stage::Global,
                    StopAfterRon::Contact => retarget::Stage::Contact,
                    StopAfterRon::Refine => retarget::Stage::Refine,
                },
                global: GlobalOptions { size: self.size(*size)?, ..GlobalOptions::default() },
                refine: RefineOptions {
                    dofs: match refine {
                        RefineRon::RootHeight => RefineDofs::RootHeight,
                        RefineRon::Root => RefineDofs::Root,
                        RefineRon::RootAndLegs => RefineDofs::RootAndLegs,
                        RefineRon::Links(names) => RefineDofs::Links(names.clone()),
                    },
                    ..RefineOptions::default()
                },
                sway: *sway,
                ..retarget::Options::default()
            },
        }))
    }

    fn size(&self, size: SizeRon) -> Result<SizeRatio, SceneError> {
        Ok(match size {
            SizeRon::Stride => SizeRatio::Stride,
            SizeRon::PerAxis => SizeRatio::PerAxis,
            SizeRon::Uniform => SizeRatio::Uniform,
            SizeRon::Fixed(x) if x > 0.0 && x.is_finite() => SizeRatio::Fixed(x),
            SizeRon::Fixed(x) => {
                let e = format!("the size ratio is {x}; allowed: positive numbers");
                return Err(self.source.error("motion.size", e));
            }
        })
    }
}
