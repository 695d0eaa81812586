//! Reactive properties of a scene, checked.
//!
//! In: `reactive: […]` of a scene file. Out: properties ready to be handed to a pass.
//! Balance has its own words (`physics`, patches).

use bodies::{Character, JointClass};
use controllers::{Gaze, GazeError, GazeSettings};
use dynamics::Model;
use motion::Vec3;

use super::Check;
use crate::conditions::Timed;
use crate::schema::ReactiveRon;
use crate::{ProgramSpec, SceneError};

impl Check<'_> {
    /// Gazes.
    pub(crate) fn gazes(&self, ron: &[ReactiveRon]) -> Result<Vec<Timed<Gaze>>, SceneError> {
        let one = |(i, r): (usize, &ReactiveRon)| {
            let ReactiveRon::Gaze { at_m, from_s, to_s, blend_s, eyes, joints, trunk, clock } = r else {
                return Ok(None);
            };
            let at = format!("reactive[{i}]");
            for x in [at_m.0, at_m.1, at_m.2] {
                self.within(&format!("{at}.at_m"), x, -1e4, 1e4, "m")?;
            }
            let from_s = self.within(&format!("{at}.from_s"), *from_s, 0.0, 86_400.0, "s")?;
            let to_s = match to_s {
                Some(to_s) if *to_s > from_s => *to_s,
                Some(to_s) => {
                    let message = format!("to_s is {to_s} s; allowed: later than from_s, {from_s} s");
                    return Err(self.source.error(&format!("{at}.to_s"), message));
                }
                None => f64::INFINITY,
            };
            let blend_s = self.within(&format!("{at}.blend_s"), *blend_s, 0.0, 60.0, "s")?;
            let target = Vec3::new(at_m.0, at_m.1, at_m.2);
            let trunk = trunk.unwrap_or(if joints.is_none() { TRUNK } else { 0.0 });
            let trunk = self.within(&format!("{at}.trunk"), trunk, 0.0, 1.0, "")?;
            let settings = GazeSettings { target, from_s, to_s, blend_s, trunk };
            let links = match joints {
                None => neck(self.character, eyes),
                Some(names) => {
                    let mut links = Vec::new();
                    for (k, name) in names.iter().enumerate() {
                        links.push(self.link(&format!("{at}.joints[{k}]"), name, " in a Gaze")?);
                    }
                    links.sort_unstable();
                    links.dedup();
                    links
                }
            };
            let model = Model::new(self.character, Vec3::zeros());
            let gaze = Gaze::new(self.character, &model, eyes, &links, settings).map_err(|e| {
                let field = match &e {
                    GazeError::Eyes { .. } => "eyes",
                    GazeError::Empty | GazeError::NotABall(_) | GazeError::Apart { .. } => "joints",
                };
                self.source.error(&format!("{at}.{field}"), e.to_string())
            })?;
            Ok(Some(Timed { value: gaze, clock: clock.0 }))
        };
        ron.iter().enumerate().filter_map(|r| one(r).transpose()).collect()
    }

    /// Programs.
    pub(crate) fn programs(&self, ron: &[ReactiveRon]) -> Result<Vec<ProgramSpec>, SceneError> {
        let one = |(i, r): (usize, &ReactiveRon)| match r {
            ReactiveRon::Gaze { .. } => None,
            ReactiveRon::Program { file, params } => {
                Some(self.program(&format!("reactive[{i}]"), file, params))
            }
        };
        ron.iter().enumerate().filter_map(one).collect()
    }
}

/// Share of the spine's range of a gaze that says nothing about it.
const TRUNK: f64 = 0.5;

/// Joints of the neck that carry a site, from the trunk outward; empty if there is no such site.
fn neck(character: &Character, eyes: &str) -> Vec<usize> {
    let skeleton = &character.skeleton;
    let up = skeleton.site(eyes).into_iter().flat_map(|s| skeleton.ancestors(s.link));
    let mut links: Vec<usize> = up.filter(|&l| character.classes[l] == JointClass::Neck).collect();
    links.reverse();
    links
}
