//! A scene's script, checked: actions, cycles, poses, elements, planted limbs.
//!
//! In: the words of [`crate::schema`]. Out: [`motion::Script`] in SI units with every joint resolved, or an error at the very value.

use std::collections::BTreeMap;

use dynamics::conditions::RootMode;
use motion::names;
use motion::script::{Action, Cycle, Insert, Pose, PoseValue, Properties, Script};
use motion::{Curve, Dof, Joint, LimbKind, Value};

use super::Check;
use super::footwork::Footwork;
use crate::angle::quat_from_deg;
use crate::schema::{CycleRon, PoseRon, PropertiesRon, SceneRon};
use crate::{Angle, SceneError};

/// A script with what it says about feet and time.
#[derive(Clone, Debug)]
pub struct ScriptSpec {
    /// The actions.
    pub script: Script,
    /// Still time after the last element, s.
    pub settle_s: f64,
    /// Indices of the limbs whose ends stay planted.
    pub planted: Vec<usize>,
    /// Steps and jumps of those limbs.
    pub footwork: Footwork,
}

impl ScriptSpec {
    /// Whether it asks for any motion.
    pub fn moves(&self) -> bool {
        !self.script.actions.is_empty() || !self.script.inserts.is_empty()
    }
}

/// Still time after the last element of a script that says nothing about it, s.
const SETTLE_S: f64 = 1.5;

impl Check<'_> {
    /// The script of a scene.
    pub(crate) fn script_spec(
        &self,
        ron: &SceneRon,
        root: RootMode,
        gravity: f64,
    ) -> Result<ScriptSpec, SceneError> {
        let planted = self.planted(ron.planted.as_deref())?;
        Ok(ScriptSpec {
            script: self.script(ron)?,
            settle_s: self.within("settle_s", ron.settle_s.unwrap_or(SETTLE_S), 0.0, 3600.0, "s")?,
            footwork: self.footwork(&ron.footwork, &planted, root, gravity)?,
            planted,
        })
    }

    fn script(&self, ron: &SceneRon) -> Result<Script, SceneError> {
        let top = self.properties("properties", ron.properties)?;
        let mut script = Script { properties: top, actions: Vec::new(), inserts: Vec::new() };
        for (i, a) in ron.script.iter().enumerate() {
            let at = format!("script[{i}]");
            names::check(&a.name).map_err(|e| self.source.error(&format!("{at}.name"), e))?;
            let before = &ron.script[..i];
            if before.iter().any(|o| o.name == a.name) {
                let message = format!("two actions are called `{}`; names must be unique", a.name);
                return Err(self.source.error(&format!("{at}.name"), message));
            }
            let inherited = PropertiesRon {
                curve: a.curve,
                tension: a.tension,
                duration_s: a.duration_s,
                hold_s: a.hold_s,
                timing: a.timing,
            };
            let mut cycles = Vec::new();
            for (j, c) in a.cycles.iter().enumerate() {
                cycles.push(self.cycle(&format!("{at}.cycles[{j}]"), &a.name, c)?);
            }
            script.actions.push(Action {
                name: a.name.clone(),
                start_s: self.within(&format!("{at}.start_s"), a.start_s, 0.0, 86_400.0, "s")?,
                properties: self.properties(&at, inherited)?,
                cycles,
            });
        }
        for (i, n) in ron.inserts.iter().enumerate() {
            let at = format!("inserts[{i}]");
            names::check(&n.name).map_err(|e| self.source.error(&format!("{at}.name"), e))?;
            let start_s = self.within(&format!("{at}.start_s"), n.start_s, 0.0, 86_400.0, "s")?;
            let properties = PropertiesRon {
                curve: n.curve,
                tension: n.tension,
                duration_s: n.duration_s,
                hold_s: n.hold_s,
                timing: n.timing,
            };
            let properties = self.properties(&at, properties)?;
            let within = format!(" in Insert \"{}\"", n.name);
            for mut value in self.values(&at, &within, &n.set_deg, &n.set_m)? {
                value.properties = properties;
                script.inserts.push(Insert { name: n.name.clone(), start_s, value });
            }
        }
        Ok(script)
    }

    fn cycle(&self, at: &str, action: &str, c: &CycleRon) -> Result<Cycle, SceneError> {
        if !(1..=10_000).contains(&c.repetitions) {
            let message = format!("{} repetitions; allowed: 1 to 10000", c.repetitions);
            return Err(self.source.error(&format!("{at}.repetitions"), message));
        }
        let inherited = PropertiesRon {
            curve: c.curve,
            tension: c.tension,
            duration_s: c.duration_s,
            hold_s: c.hold_s,
            timing: c.timing,
        };
        let mut poses = Vec::new();
        for (k, p) in c.poses.iter().enumerate() {
            poses.push(self.pose(&format!("{at}.poses[{k}]"), action, p)?);
        }
        Ok(Cycle { repetitions: c.repetitions as usize, properties: self.properties(at, inherited)?, poses })
    }

    fn pose(&self, at: &str, action: &str, p: &PoseRon) -> Result<Pose, SceneError> {
        let within = format!(" in a pose of \"{action}\"");
        let mut values = self.values(at, &within, &p.set_deg, &p.set_m)?;
        for (k, name) in p.rest.iter().enumerate() {
            let at = format!("{at}.rest[{k}]");
            let dof = self.dof(&at, name, &within)?;
            if values.iter().any(|v| v.dof == *name) {
                return Err(self.source.error(&at, format!("`{name}` is set twice{within}")));
            }
            let value = dof.read(&self.character.skeleton, &self.character.rest);
            values.push(PoseValue { dof: name.clone(), value, properties: Properties::default() });
        }
        for (name, own) in &p.elements {
            let place = format!("{at}.elements{{\"{name}\"}}");
            let properties = self.properties(&place, *own)?;
            let Some(value) = values.iter_mut().find(|v| v.dof == *name) else {
                let known = p.set_deg.keys().chain(p.set_m.keys()).map(String::as_str);
                return Err(self.source.unknown(&place, "element", name, &within, known));
            };
            value.properties = properties;
        }
        let properties = PropertiesRon {
            curve: p.curve,
            tension: p.tension,
            duration_s: p.duration_s,
            hold_s: p.hold_s,
            timing: p.timing,
        };
        Ok(Pose { properties: self.properties(at, properties)?, values })
    }

    fn values(
        &self,
        at: &str,
        within: &str,
        set_deg: &BTreeMap<String, Angle>,
        set_m: &BTreeMap<String, f64>,
    ) -> Result<Vec<PoseValue>, SceneError> {
        let skeleton = &self.character.skeleton;
        let mut out = Vec::new();
        for (name, angle) in set_deg {
            let at = format!("{at}.set_deg{{\"{name}\"}}");
            let dof = self.dof(&at, name, within)?;
            let numbers = match angle {
                Angle::One(x) => vec![*x],
                Angle::Ball(xyz) => xyz.to_vec(),
            };
            if let Some(bad) = numbers.iter().find(|x| !(-3600.0..=3600.0).contains(*x)) {
                return Err(self.source.error(&at, format!("`{name}` is {bad}°; allowed: -3600 to 3600")));
            }
            let hinge = matches!(skeleton.links()[dof.link()].joint, Joint::Revolute(_));
            let value = match (angle, dof.is_rotation(), hinge) {
                (Angle::Ball(xyz), true, _) => Value::Rotation(quat_from_deg(*xyz)),
                (Angle::One(x), false, true) => Value::Scalar(x.to_radians()),
                (_, true, _) => {
                    let message = format!(
                        "`{name}` is a ball joint{within}: it takes (x, y, z) in degrees, found one number"
                    );
                    return Err(self.source.error(&at, message));
                }
                (Angle::Ball(_), false, true) => {
                    let message =
                        format!("`{name}` is a hinge{within}: it takes one number of degrees, found three");
                    return Err(self.source.error(&at, message));
                }
                (_, false, false) => {
                    let message = format!("`{name}` is a length{within}: set it in set_m, in metres");
                    return Err(self.source.error(&at, message));
                }
            };
            out.push(PoseValue { dof: name.clone(), value, properties: Properties::default() });
        }
        for (name, &x) in set_m {
            let at = format!("{at}.set_m{{\"{name}\"}}");
            let dof = self.dof(&at, name, within)?;
            let hinge = matches!(skeleton.links()[dof.link()].joint, Joint::Revolute(_));
            if dof.is_rotation() || hinge {
                let message = format!("`{name}` is an angle{within}: set it in set_deg, in degrees");
                return Err(self.source.error(&at, message));
            }
            let x = self.within(&at, x, -1e3, 1e3, "m")?;
            let rest = dof.read(skeleton, &self.character.rest).scalar().unwrap_or(0.0);
            out.push(PoseValue::scalar(name.clone(), rest + x));
        }
        Ok(out)
    }

    fn dof(&self, at: &str, name: &str, within: &str) -> Result<Dof, SceneError> {
        let skeleton = &self.character.skeleton;
        if let Some(dof) = Dof::find(skeleton, name) {
            return Ok(dof);
        }
        if skeleton.link(name).is_some() {
            let message = format!("`{name}`{within} is welded to its parent and cannot move");
            return Err(self.source.error(at, message));
        }
        let names: Vec<String> = Dof::all(skeleton).iter().map(|d| d.name(skeleton)).collect();
        Err(self.source.unknown(at, "joint", name, within, names.iter().map(String::as_str)))
    }

    pub(crate) fn curve(&self, at: &str, curve: Curve) -> Result<Curve, SceneError> {
        if curve.is_valid() {
            return Ok(curve);
        }
        Err(self.source.error(at, "a Bezier handle is out of range; allowed: x from 0 to 1, y finite"))
    }

    fn properties(&self, at: &str, p: PropertiesRon) -> Result<Properties, SceneError> {
        let time = |field: &str, x: Option<f64>| {
            x.map(|x| self.within(&format!("{at}.{field}"), x, 0.0, 86_400.0, "s")).transpose()
        };
        let tension = p
            .tension
            .map(|x| self.within(&format!("{at}.tension"), x, 1e-3, 1e3, "(1 = natural)"))
            .transpose()?;
        let curve = p.curve.map(|c| self.curve(&format!("{at}.curve"), c.0)).transpose()?;
        Ok(Properties {
            curve,
            tension,
            duration_s: time("duration_s", p.duration_s)?,
            hold_s: time("hold_s", p.hold_s)?,
            timing: p.timing.map(|t| t.0),
        })
    }

    fn planted(&self, names: Option<&[String]>) -> Result<Vec<usize>, SceneError> {
        let limbs = self.character.skeleton.limbs();
        let Some(names) = names else {
            return Ok((0..limbs.len()).filter(|&i| limbs[i].kind == LimbKind::Leg).collect());
        };
        names
            .iter()
            .enumerate()
            .map(|(i, name)| {
                limbs.iter().position(|l| l.name == *name).ok_or_else(|| {
                    let known = limbs.iter().map(|l| l.name.as_str());
                    self.source.unknown(&format!("planted[{i}]"), "limb", name, " in planted", known)
                })
            })
            .collect()
    }
}
