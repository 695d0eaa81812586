//! Scenes: a scene file, checked, in SI units and with every name resolved.
//!
//! In: a path. Out: a [`Scene`], or a [`SceneError`] at the very value that is wrong. The words are in
//! [`crate::schema`].

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use controllers::{BalanceSettings, GainBlend, Gaze, Strategy};
use dynamics::{Carrying, Character, RootMode};
use edits::{
    Amount, Amplitude, Direction, Edit, ExtentReach, ExtentShoulder, Parameter, Place, Selector, Succession,
    Tension,
};
use motion::script::{Action, Cycle, Insert, Pose, PoseValue, Properties, Script};
use motion::{Curve, Dof, Joint, LimbKind, Value, Vec3};
use sim::{Ground, Push, Tilt};

use crate::angle::quat_from_deg;
use crate::footwork::Footwork;
use crate::overrides::{RATES, SUBSTEPS, TENSIONS, set_fidelity};
use crate::scene_motion::SceneMotion;
use crate::schema::*;
use crate::tune::TuneSpec;
use crate::{Angle, Patch, SceneError, Source, character_file};

/// An edit with what it applies to.
pub struct SceneEdit {
    /// The edit.
    pub edit: Box<dyn Edit + Send + Sync>,
    /// Selectors; their selections are taken together, one after another.
    pub on: Vec<Selector>,
    /// Path of the edit in the file, for errors.
    pub at: String,
}

/// Numbers of the dynamic pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Physics {
    /// Control steps per second, Hz.
    pub rate_hz: f64,
    /// Engine substeps; `None`: as many as the stiffest joint needs, at least two.
    pub substeps: Option<usize>,
    /// Factor on every tension.
    pub tension: f64,
    /// What transitions interpolate.
    pub blend: GainBlend,
    /// What holds the root.
    pub root: RootMode,
    /// Gravity, m/s².
    pub gravity: Vec3,
    /// The ground, if any.
    pub ground: Option<Ground>,
    /// Parameters of the balance property.
    pub balance: BalanceSettings,
}

/// A checked scene.
pub struct Scene {
    /// The file, kept for errors found later.
    pub source: Source,
    /// Name: the file's stem.
    pub name: String,
    /// The body.
    pub character: Arc<Character>,
    /// Frames per second of the clips written, Hz.
    pub rate_hz: f64,
    /// The script.
    pub script: Script,
    /// A human motion put on the character instead of the script.
    pub motion: Option<SceneMotion>,
    /// Edits in order.
    pub edits: Vec<SceneEdit>,
    /// Still time after the last element, s.
    pub settle_s: f64,
    /// Indices of the limbs whose ends stay planted.
    pub planted: Vec<usize>,
    /// Steps and jumps of those limbs.
    pub footwork: Footwork,
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
    /// Colour of each link, where the character's file has one.
    pub colors: Vec<Option<[u8; 3]>>,
    /// How it is tuned.
    pub tune: TuneSpec,
}

/// Reads a scene and its character.
///
/// # Errors
/// Anything wrong with either file, at its place.
pub fn read(path: &Path) -> Result<Scene, SceneError> {
    let source = Source::read(path)?;
    let name = path.file_stem().map_or_else(|| "scene".into(), |s| s.to_string_lossy().into_owned());
    parse(source, name)
}

/// Builds a scene from a source; its character is looked for beside the source's path.
///
/// # Errors
/// As [`read`].
pub fn parse(source: Source, name: String) -> Result<Scene, SceneError> {
    let ron: SceneRon = source.parse()?;
    let beside = source.beside("character", "character file", &ron.character)?;
    let read = character_file::read_file(&beside)?;
    let (character, colors) = (Arc::new(read.character), read.colors);
    let check = Check { source: &source, character: &character };
    let mut physics = check.physics(&ron)?;
    if let Some(file) = &ron.patch {
        Patch::read(&source.beside("patch", "patch", file)?)?.apply(&mut physics);
    }
    let scripted = !ron.script.is_empty() || !ron.inserts.is_empty();
    let tune = TuneSpec::read(ron.tune.as_ref(), scripted, &source)?;
    let (script, edits) = (check.script(&ron)?, check.edits(&ron.edits)?);
    let planted = check.planted(ron.planted.as_deref())?;
    let footwork = check.footwork(&ron.footwork, &planted, &physics)?;
    let tilts = check.tilts(&ron.world.ground, physics.root)?;
    let pushes = check.pushes(&ron.pushes)?;
    let carried = check.carried(&ron.carried)?;
    let gazes = check.gazes(&ron.reactive)?;
    let motion = check.motion(&ron, &beside)?;
    let rate_hz = check.within("rate_hz", ron.rate_hz, 1.0, 1000.0, "Hz")?;
    let settle_s = check.within("settle_s", ron.settle_s, 0.0, 3600.0, "s")?;
    if ron.strip.figures < 2 || ron.strip.figures > 40 {
        return Err(source.error("strip.figures", format!("{} figures; allowed: 2 to 40", ron.strip.figures)));
    }
    Ok(Scene {
        name,
        rate_hz,
        script,
        motion,
        edits,
        settle_s,
        planted,
        footwork,
        physics,
        tilts,
        pushes,
        carried,
        gazes,
        strip: ron.strip,
        tune,
        colors,
        character,
        source,
    })
}

/// A scene being checked.
pub(crate) struct Check<'a> {
    pub(crate) source: &'a Source,
    pub(crate) character: &'a Character,
}

impl Check<'_> {
    pub(crate) fn within(&self, at: &str, x: f64, lo: f64, hi: f64, unit: &str) -> Result<f64, SceneError> {
        if x >= lo && x <= hi {
            return Ok(x);
        }
        let name = at.rsplit('.').next().unwrap_or(at);
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        Err(self.source.error(at, format!("{name} is {x}{unit}; allowed: {lo} to {hi}{unit}")))
    }

    fn vec3(&self, at: &str, v: (f64, f64, f64)) -> Result<Vec3, SceneError> {
        let v = Vec3::new(v.0, v.1, v.2);
        if v.iter().all(|x| x.is_finite()) {
            return Ok(v);
        }
        Err(self.source.error(at, "a number that is not finite; allowed: finite numbers"))
    }

    fn physics(&self, ron: &SceneRon) -> Result<Physics, SceneError> {
        let p = &ron.physics;
        let rate_hz = self.within("physics.rate_hz", p.rate_hz, *RATES.start(), *RATES.end(), "Hz")?;
        if p.substeps.is_some_and(|n| !SUBSTEPS.contains(&n)) {
            let found = p.substeps.unwrap_or(0);
            return Err(self.source.error("physics.substeps", format!("{found} substeps; allowed: 1 to 64")));
        }
        let tension =
            self.within("physics.tension", p.tension, *TENSIONS.start(), *TENSIONS.end(), "(1 = natural)")?;
        let ground = match ron.world.ground {
            GroundRon::None => None,
            GroundRon::Plane { friction, height_m, tilt_deg, towards_deg, .. } => {
                let friction = self.within("world.ground.friction", friction, 0.0, 2.0, "")?;
                let height_m = self.within("world.ground.height_m", height_m, -1e3, 1e3, "m")?;
                let tilt = self.within("world.ground.tilt_deg", tilt_deg, 0.0, 30.0, "°")?;
                let towards = self.within("world.ground.towards_deg", towards_deg, -360.0, 360.0, "°")?;
                let level = Ground::level(height_m, friction);
                Some(if tilt > 0.0 { level.tilted(tilt.to_radians(), towards.to_radians()) } else { level })
            }
        };
        let root = match ron.root {
            RootRon::Free => RootMode::Free,
            RootRon::Pinned => RootMode::Pinned,
            RootRon::Assisted { force_n, moment_nm } => RootMode::Assisted {
                force_n: self.within("root.force_n", force_n, 0.0, 1e6, "N")?,
                moment_nm: self.within("root.moment_nm", moment_nm, 0.0, 1e6, "N·m")?,
            },
            RootRon::Fidelity(_) => RootMode::Free, // set below, with what it needs to know
        };
        let mut physics = Physics {
            rate_hz,
            substeps: p.substeps,
            tension,
            blend: match p.blend {
                BlendRon::RestAngle => GainBlend::RestAngle,
                BlendRon::Gains => GainBlend::Gains,
            },
            root,
            gravity: self.vec3("world.gravity_m_s2", ron.world.gravity_m_s2)?,
            ground,
            balance: self.balance(&ron.balance)?,
        };
        if let RootRon::Fidelity(f) = ron.root {
            set_fidelity(&mut physics, self.within("root", f, 0.0, 1.0, "")?, self.character);
        }
        Ok(physics)
    }

    fn balance(&self, ron: &BalanceRon) -> Result<BalanceSettings, SceneError> {
        let off = |all: BalanceSettings, strategy: &StrategyRon| {
            all.without(match strategy {
                StrategyRon::Ankle => Strategy::Ankle,
                StrategyRon::Hip => Strategy::Hip,
                StrategyRon::Weight => Strategy::Weight,
            })
        };
        let mut balance = ron.without.iter().fold(BalanceSettings::default(), off);
        balance.arms = ron.arms;
        if let Some(x) = ron.ankle_stiffness {
            balance.ankle_stiffness = Some(self.within("balance.ankle_stiffness", x, 0.05, 20.0, "m g h")?);
        }
        Ok(balance)
    }

    fn script(&self, ron: &SceneRon) -> Result<Script, SceneError> {
        let top = self.properties("properties", ron.properties)?;
        let mut script = Script { properties: top, actions: Vec::new(), inserts: Vec::new() };
        for (i, a) in ron.script.iter().enumerate() {
            let at = format!("script[{i}]");
            if a.name.is_empty() {
                return Err(self.source.error(&format!("{at}.name"), "an action needs a name"));
            }
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
            let start_s = self.within(&format!("{at}.start_s"), n.start_s, 0.0, 86_400.0, "s")?;
            let properties = PropertiesRon {
                curve: n.curve,
                tension: n.tension,
                duration_s: n.duration_s,
                hold_s: n.hold_s,
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
        let inherited =
            PropertiesRon { curve: c.curve, tension: c.tension, duration_s: c.duration_s, hold_s: c.hold_s };
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
        let properties =
            PropertiesRon { curve: p.curve, tension: p.tension, duration_s: p.duration_s, hold_s: p.hold_s };
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

    pub(crate) fn curve(&self, at: &str, curve: CurveRon) -> Result<Curve, SceneError> {
        let curve = match curve {
            CurveRon::Linear => Curve::Linear,
            CurveRon::EaseIn => Curve::EaseIn,
            CurveRon::EaseOut => Curve::EaseOut,
            CurveRon::EaseInOut => Curve::EaseInOut,
            CurveRon::Overshoot => Curve::Overshoot,
            CurveRon::Anticipate => Curve::Anticipate,
            CurveRon::Bezier(x1, y1, x2, y2) => Curve::Bezier(x1, y1, x2, y2),
        };
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
        let curve = p.curve.map(|c| self.curve(&format!("{at}.curve"), c)).transpose()?;
        Ok(Properties {
            curve,
            tension,
            duration_s: time("duration_s", p.duration_s)?,
            hold_s: time("hold_s", p.hold_s)?,
        })
    }

    fn edits(&self, ron: &[EditRon]) -> Result<Vec<SceneEdit>, SceneError> {
        let mut out = Vec::new();
        for (i, e) in ron.iter().enumerate() {
            let at = format!("edits[{i}]");
            let (on, repetition, parts) = match e {
                EditRon::Succession { on, repetition, parts, .. }
                | EditRon::Amplitude { on, repetition, parts, .. }
                | EditRon::ExtentShoulder { on, repetition, parts, .. }
                | EditRon::ExtentReach { on, repetition, parts, .. }
                | EditRon::Tension { on, repetition, parts, .. } => (on, repetition, parts),
            };
            let edit: Box<dyn Edit + Send + Sync> = match e {
                EditRon::Succession { offset_s, direction, .. } => Box::new(Succession {
                    offset_s: parameter(offset_s),
                    direction: match direction {
                        DirectionRon::Forward => Direction::Forward,
                        DirectionRon::Reverse => Direction::Reverse,
                    },
                }),
                EditRon::Amplitude { factor, reference, .. } => Box::new(Amplitude {
                    factor: parameter(factor),
                    reference: match reference {
                        ReferenceRon::InterPose => None,
                        ReferenceRon::Rest => Some(self.character.rest.clone()),
                    },
                }),
                EditRon::ExtentShoulder { extent, .. } => {
                    Box::new(ExtentShoulder { extent: parameter(extent) })
                }
                EditRon::ExtentReach { factor, .. } => Box::new(ExtentReach { factor: parameter(factor) }),
                EditRon::Tension { factor: Some(f), absolute: None, .. } => {
                    Box::new(Tension { amount: Amount::Factor(parameter(f)) })
                }
                EditRon::Tension { factor: None, absolute: Some(a), .. } => {
                    Box::new(Tension { amount: Amount::Absolute(parameter(a)) })
                }
                EditRon::Tension { .. } => {
                    let message = "a Tension takes either `factor` or `absolute`";
                    return Err(self.source.error(&at, message));
                }
            };
            let mut selectors = Vec::new();
            for text in on.split(',').map(str::trim) {
                let place = self.place(&format!("{at}.on"), text, *repetition)?;
                selectors.push(Selector { place, parts: parts.clone() });
            }
            out.push(SceneEdit { edit, on: selectors, at });
        }
        Ok(out)
    }

    /// A label as text, with a repetition if one is given: `twist_0` or `twist_0_1` then.
    fn place(&self, at: &str, text: &str, repetition: Option<usize>) -> Result<Place, SceneError> {
        if text.is_empty() && repetition.is_none() {
            return Ok(Place::Script);
        }
        let Some(n) = repetition else { return Ok(Place::Label(text.into())) };
        let number = |s: &str| s.parse::<usize>().ok();
        if let Some((rest, last)) = text.rsplit_once('_')
            && let Some(last) = number(last)
        {
            if let Some((action, cycle)) = rest.rsplit_once('_')
                && let Some(cycle) = number(cycle)
            {
                let action = action.to_owned();
                return Ok(Place::Pose { action, cycle, pose: last, repetition: Some(n) });
            }
            return Ok(Place::Repetition { action: rest.to_owned(), cycle: last, repetition: n });
        }
        let message = format!(
            "`repetition: {n}` needs a cycle or a pose in `on`, such as \"twist_0\" or \"twist_0_1\"; found \"{text}\""
        );
        Err(self.source.error(at, message))
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

fn parameter(p: &ParameterRon) -> Parameter {
    match p {
        ParameterRon::Constant(x) => Parameter::Constant(*x),
        ParameterRon::PerPose(v) => Parameter::PerPose(v.clone()),
        ParameterRon::OverTime(k) => Parameter::OverTime(k.clone()),
        ParameterRon::OverRepetition(k) => Parameter::OverRepetition(k.clone()),
    }
}
