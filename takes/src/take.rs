//! A take: who performs what, under which conditions.
//!
//! In: what [`crate::open()`] made of a file, a text or a clip. Out: a [`Take`]: a body, where its motion came from, the motion asked of
//! it, and the conditions. A value: built once and whole. Preview is a take that is not performed.
//!
//! Nobody downstream asks where a motion came from: reports, figures, passes and studies read [`Take::asked`],
//! [`Take::body`] and [`Take::conditions`].

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bodies::Character;
use bodies::anthropometry::BodyReport;
use bodies::pose_map::PoseMap;
use bodies::soles::{OnSoles, Pads, Soles};
use controllers::{Dense, Goal, Reactive, Setup, Tunable};
use dynamics::conditions::RootMode;
use dynamics::verdict::{Reason, Verdict};
use edits::EditLog;
use formats::bvh::ImportReport;
use motion::stance::Stance;
use motion::{Clip, ContactPlan, Cycle, Kinematics, Plant, Shape, TimeMap, Tracks};
use retarget::contacts::Phase;
use scenes::conditions::{SoleKind, ToesKind};
use scenes::{SceneError, StripSpec, TuneSpec, contact_file};
use sim::{Outcome, Pass};

use crate::Conditions;
use crate::ignored::Ignored;
use crate::limited::Limited;
use crate::possible::Shifted;
use crate::results::gaze_report::GazeReport;

/// The body of a take.
#[derive(Clone, Debug)]
pub struct Body {
    /// Mass, shapes, limits.
    pub character: Arc<Character>,
    /// Colour of each link, where the character's file has one.
    pub colors: Vec<Option<[u8; 3]>>,
}

impl Body {
    /// Its solids, each with its link.
    pub fn solids(&self) -> Vec<(usize, Shape)> {
        let links = self.character.bodies.iter().enumerate();
        links.flat_map(|(link, body)| body.shapes.iter().map(move |shape| (link, *shape))).collect()
    }
}

/// A clip that a motion came from.
#[derive(Clone, Debug)]
pub struct ClipSource {
    /// The clip as read, with all its joints, at the frames and times of the motion asked for.
    pub clip: Clip,
    /// Between the clip's joints and the character's.
    pub map: PoseMap,
    /// What was read and guessed of the file; `None` for a clip from memory.
    pub import: Option<ImportReport>,
    /// What of it was repeated so that it goes on, if it was asked to.
    pub cycle: Option<Cycle>,
    /// What was guessed of the body; `None` if it was given.
    pub body: Option<BodyReport>,
}

/// A human motion that a motion was made of.
#[derive(Clone, Debug)]
pub struct RetargetSource {
    /// Name of the performance.
    pub performance: String,
    /// When each contact point of the character stands.
    pub phases: Vec<Phase>,
}

/// Where the motion of a take came from.
#[derive(Clone, Debug)]
pub enum Source {
    /// A script of poses.
    Script,
    /// A clip.
    Clip(Box<ClipSource>),
    /// A human motion put on the body.
    Retarget(Box<RetargetSource>),
}

/// The motion asked of a body.
#[derive(Clone, Debug)]
pub struct Asked {
    /// The motion: edited, within joint limits, feet planted; at the frame rate.
    pub clip: Clip,
    /// The elements behind it, edited: they are performed as transitions; `None` where all of it is performed as a dense clip.
    pub tracks: Option<Tracks>,
    /// Joints of a script that a clip edit changed: they are performed as a dense clip, at the tension that the script says.
    pub dense: Dense,
    /// Limbs whose ends stay where they are from beginning to end.
    pub plants: Vec<Plant>,
    /// What stands when.
    pub contacts: ContactPlan,
    /// Whether a person said what stands when: then it is kept as it is.
    pub contacts_given: bool,
    /// What was made possible of a motion that steps, and what could not be, in words; empty of others.
    pub stepping: Vec<String>,
    /// Where the feet of a clip stand and step; `None` where that is written (scripts) or not looked for.
    pub stance: Option<Stance>,
    /// From the time of the source to that of `clip`.
    pub times: TimeMap,
    /// Fraction of the frames that joint limits changed.
    pub clamped: f64,
    /// Keys of a script that do not act.
    pub ignored: Vec<Ignored>,
    /// Joints that limits changed, the furthest first.
    pub limited: Vec<Limited>,
    /// How the root of a script gave way so that its feet can carry it.
    pub shifted: Option<Shifted>,
}

/// Who performs what, under which conditions. See the module header.
#[derive(Clone, Debug)]
pub struct Take {
    /// Name, for output folders.
    pub name: String,
    /// The body.
    pub body: Body,
    /// Where the motion came from.
    pub source: Source,
    /// The motion asked for.
    pub asked: Asked,
    /// The same without edits (equal to the clip asked for when there are none).
    pub unedited: Clip,
    /// Who edited what.
    pub log: EditLog,
    /// What acts on the body.
    pub conditions: Conditions,
    /// How film strips are drawn.
    pub strip: StripSpec,
    /// How it is tuned.
    pub tune: TuneSpec,
    /// Files it was made of: results never replace them.
    pub files: Vec<PathBuf>,
}

/// Planted feet higher over the ground than this stand in the air, m.
const NEAR_M: f64 = 0.1;

/// Control steps per second of a script that says nothing about it, Hz.
pub(crate) const USUAL_RATE_HZ: f64 = 240.0;

impl Take {
    /// The body's character.
    pub fn character(&self) -> &Arc<Character> {
        &self.body.character
    }

    /// The clip it came from, if it came from one.
    pub fn clip_source(&self) -> Option<&ClipSource> {
        match &self.source {
            Source::Clip(source) => Some(source),
            Source::Script | Source::Retarget(_) => None,
        }
    }

    /// Names of the points that may stand: its legs that end in soles, and what its contacts name besides; of a retargeted motion those of
    /// its contacts.
    pub fn contact_points(&self) -> Vec<String> {
        let legs = self.body.character.leg_soles();
        let mut names: Vec<String> = match self.source {
            Source::Retarget(_) => Vec::new(),
            Source::Script | Source::Clip(_) => legs.iter().map(|(limb, _)| limb.name.clone()).collect(),
        };
        for point in self.asked.contacts.points() {
            if !names.iter().any(|n| n == point) {
                names.push(point.to_owned());
            }
        }
        names
    }

    /// Has it stand as a file says: a `contacts.ron` of an earlier run, edited.
    ///
    /// # Errors
    /// Anything wrong with the file, at its place.
    pub(crate) fn give_contacts(&mut self, file: &Path) -> Result<(), SceneError> {
        let mut names = self.contact_points();
        let legs = self.body.character.leg_soles();
        names.extend(legs.iter().map(|(limb, _)| limb.name.clone()));
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        self.asked.contacts = contact_file::read_plan(file, &names, self.asked.clip.duration_s())?;
        self.asked.contacts_given = true;
        self.files.push(file.to_owned());
        Ok(())
    }

    /// Whether it is a clip as it was captured, without edits.
    pub fn is_captured(&self) -> bool {
        self.clip_source().is_some() && self.log.edits().is_empty()
    }

    /// Whether it is performed by transitions from pose to pose.
    pub fn is_scripted(&self) -> bool {
        matches!(self.source, Source::Script)
    }

    /// Control steps per second, Hz: as asked, else 240; of sampled motion whole steps per frame, near 240.
    pub fn control_rate_hz(&self) -> f64 {
        let frames = self.asked.clip.rate_hz;
        match (self.conditions.physics.rate_hz, &self.source) {
            (Some(rate_hz), _) => rate_hz,
            (None, Source::Script) => USUAL_RATE_HZ,
            (None, Source::Clip(_) | Source::Retarget(_)) => {
                frames * (USUAL_RATE_HZ / frames).round().max(1.0)
            }
        }
    }

    /// The dynamic pass of this take.
    pub fn pass(&self) -> Pass {
        let c = &self.conditions;
        let p = &c.physics;
        let held = p.root == RootMode::Pinned;
        let followed = matches!(self.source, Source::Clip(_)) || !self.asked.plants.is_empty();
        Pass {
            setup: Setup {
                character: self.body.character.clone(),
                gravity: p.gravity,
                goal: Goal::new(&self.asked.clip, self.control_rate_hz()),
                tracks: self.asked.tracks.clone(),
                dense: self.asked.dense.clone(),
                tension: p.tension,
                plants: if held || !self.has_ground() { Vec::new() } else { self.asked.plants.clone() },
                ground_m: if held { None } else { p.ground.map(|g| g.height_m) },
                contacts: if self.looks_ahead() { self.asked.contacts.clone() } else { Default::default() },
                balance: p.balance,
                blend: p.blend,
            },
            reactive: {
                let gazes = c.gazes.iter().map(|g| Box::new(g.clone()) as Box<dyn Reactive>);
                gazes.chain(c.programs.iter().map(|p| Box::new(p.clone()) as Box<dyn Reactive>)).collect()
            },
            substeps: p.substeps,
            root: p.root,
            // legs that follow a clip or planted feet under a pinned root are where they are asked to be: contact would
            // fight the pin over every millimetre
            ground: if held && followed { None } else { p.ground },
            tilts: c.tilts.clone(),
            props: c.props.clone(),
            self_collision: c.self_collision,
            pushes: c.pushes.clone(),
            carried: c.carried.clone(),
            past_fall: p.past_fall,
            foresight: c.foresight.clone(),
            soles: self.soles(),
        }
    }

    /// What its soles do under load: what is asked for; where nothing is, pads of a body that looks ahead and can have them, and toes that
    /// are welded.
    pub fn soles(&self) -> Soles {
        let p = &self.conditions.physics;
        let pads = match p.soles {
            Some(SoleKind::Pads(pads)) => Some(pads),
            Some(SoleKind::Rigid) => None,
            None => Some(Pads::default()).filter(|_| self.looks_ahead()).filter(|pads| {
                OnSoles::new(&self.body.character, &Soles { pads: Some(*pads), toes: None }).is_ok()
            }),
        };
        let toes = match p.toes {
            Some(ToesKind::Bend(toes)) => Some(toes),
            Some(ToesKind::Welded) | None => None,
        };
        Soles { pads, toes }
    }

    /// Whether the ground is under the planted feet as the motion begins. Where it is not, they are limbs in the air.
    fn has_ground(&self) -> bool {
        let Some(ground) = self.conditions.physics.ground else { return false };
        let c = &self.body.character;
        let k = Kinematics::new(&c.skeleton, self.asked.clip.pose(0));
        let planted = |name: &str| self.asked.plants.iter().any(|p| p.limb.name == name);
        let soles = c.leg_soles().into_iter().filter(|(limb, _)| planted(&limb.name));
        let points = soles.flat_map(|(_, sole)| sole.points(&k).collect::<Vec<_>>());
        let lowest = points.map(|p| ground.up.dot(&(p - ground.pivot()))).fold(f64::INFINITY, f64::min);
        lowest < NEAR_M || lowest == f64::INFINITY
    }

    /// How its motion was performed: the verdict on the run, gazes that missed, and the keys of the script that cannot act.
    pub fn verdict(&self, outcome: &Outcome) -> Verdict {
        let mut verdict = outcome.verdict.clone();
        let ignored = self.asked.ignored.iter().map(ToString::to_string).collect();
        for gaze in GazeReport::of(&self.conditions.gazes, &outcome.performed()) {
            verdict.reasons.extend(gaze.rms_deg.and_then(|x| Reason::gaze(gaze.at_m, x, gaze.peak_at_s)));
        }
        verdict.reasons.extend(Reason::ignored(ignored));
        verdict
    }

    /// A clip of the character at the frame rate.
    pub fn at_frames(&self, clip: &Clip) -> Clip {
        if clip.rate_hz == self.asked.clip.rate_hz {
            clip.clone()
        } else {
            clip.resample(self.asked.clip.rate_hz)
        }
    }

    /// A clip of the character at the frame rate, as it is written to files: with all joints of the
    /// clip it came from.
    pub fn for_files(&self, clip: &Clip) -> Clip {
        let clip = self.at_frames(clip);
        match self.clip_source() {
            Some(source) => source.map.clip_to_source(&clip, &source.clip),
            None => clip,
        }
    }

    /// Unit of length of the BVH files written, m: that of the clip read, else the centimetre.
    pub fn metres_per_unit(&self) -> f64 {
        let import = self.clip_source().and_then(|source| source.import.as_ref());
        import.map_or(0.01, |import| import.units.metres_per_unit)
    }

    /// The settings that may be tuned.
    pub fn tunable(&self) -> Tunable {
        let p = &self.conditions.physics;
        Tunable { tension: p.tension, balance: p.balance }
    }

    /// The same take with other settings.
    pub fn with_tunable(&self, t: &Tunable) -> Self {
        let mut take = self.clone();
        take.conditions.physics.tension = t.tension;
        take.conditions.physics.balance = t.balance;
        take
    }

    /// The same take with another fidelity, see [`scenes::overrides::set_fidelity`].
    pub fn with_fidelity(&self, fidelity: f64) -> Self {
        let mut take = self.clone();
        scenes::overrides::set_fidelity(&mut take.conditions.physics, fidelity, &self.body.character);
        take
    }

    /// The same take, its last pose held until `end_s`.
    pub fn held_until(&self, end_s: f64) -> Self {
        let mut take = self.clone();
        let clip = &self.asked.clip;
        let missing = ((end_s * clip.rate_hz).ceil() as usize + 1).saturating_sub(clip.frames());
        if missing > 0 {
            let mut q = clip.data().to_vec();
            let last = clip.pose(clip.frames() - 1);
            (0..missing).for_each(|_| q.extend_from_slice(last));
            let held = Clip::new(clip.skeleton.clone(), clip.rate_hz, q);
            if let Some(tracks) = &mut take.asked.tracks {
                tracks.duration_s = tracks.duration_s.max(held.duration_s());
            }
            take.asked.clip = held;
        }
        take
    }
}
