//! The two edits that ship, from performances written as scripts: "lean back while walking, but stand straight" and "arms out while walking,
//! hanging while standing" (IAF09, Fig. 6).
//!
//! In: which one. Out: its training pair, an errand of two minutes with turns, starts and stops that was never taught, with the truth, and how
//! far the learned edit is from it. Units: degrees, s.

use std::path::PathBuf;

use edits::by_example::edit::Applied;
use edits::by_example::outputs::{differences, joint_columns};
use edits::by_example::{ExampleEdit, ExampleOptions, Pair, Rig};
use motion::{Clip, Kinematics, Vec3};
use serde::Serialize;
use takes::{Ask, Input};

use super::PropagateError;
use super::route::{Change, Leg, Scene};

/// An edit that ships.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shipped {
    /// The trunk leans back while walking; taught by some 550 frames.
    LeanBack,
    /// The arms are out while walking; taught by 74 frames.
    ArmsOut,
}

/// How far a learned edit is from what the script has, degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Held {
    /// What the script asks for while the body walks, mean over those frames.
    pub asked_deg: f64,
    /// While it walks: RMS and largest distance of the answer from the script.
    pub walking_deg: (f64, f64),
    /// While it stands or turns on the spot: the same; the script asks for the source there.
    pub standing_deg: (f64, f64),
    /// In between.
    pub between_deg: (f64, f64),
    /// Frames that count as walking, as standing, and as neither.
    pub frames: (usize, usize, usize),
}

impl Shipped {
    /// Both.
    pub const ALL: [Self; 2] = [Self::LeanBack, Self::ArmsOut];

    /// Its name, of files.
    pub fn name(self) -> &'static str {
        match self {
            Self::LeanBack => "lean-back",
            Self::ArmsOut => "arms-out",
        }
    }

    /// Its name, of figures.
    pub fn title(self) -> &'static str {
        match self {
            Self::LeanBack => "Lean back while walking, stand straight",
            Self::ArmsOut => "Arms out while walking, hanging while standing",
        }
    }

    /// What the artist changes.
    pub fn change(self) -> Change {
        match self {
            Self::LeanBack => Change::LeanBack,
            Self::ArmsOut => Change::ArmsOut,
        }
    }

    /// Name of the performance that it is taught on.
    pub fn taught_on(self) -> &'static str {
        match self {
            Self::LeanBack => "stroll",
            Self::ArmsOut => "setting-off",
        }
    }

    /// The performance that it is taught on.
    pub fn training(self) -> Vec<Leg> {
        match self {
            Self::LeanBack => vec![
                stand(1.1, 20.0),
                steps(6, 0.5, 0.56, 0.0),
                stand(1.0, -25.0),
                steps(4, 0.0, 0.55, 45.0),
                stand(0.9, 15.0),
                steps(6, 0.42, 0.6, -14.0),
                stand(0.9, 20.0),
                steps(6, 0.58, 0.52, 10.0),
                stand(1.4, -15.0),
            ],
            Self::ArmsOut => vec![stand(0.3, 12.0), steps(4, 0.5, 0.5, 0.0)],
        }
    }

    /// Parts of it that are examples, s; none is all.
    pub fn spans_s(self) -> Vec<(f64, f64)> {
        match self {
            Self::LeanBack => Vec::new(),
            // 74 frames at 30 Hz
            Self::ArmsOut => vec![(0.1, 2.55)],
        }
    }

    /// The training pair: two performances, with and without the change.
    ///
    /// # Errors
    /// Scripts that do not open.
    pub fn pair(self) -> Result<Pair, PropagateError> {
        let spans_s = self.spans_s();
        Ok(Pair { spans_s, ..pair(self.taught_on(), &self.training(), self.change())? })
    }

    /// The edit, learned from its pair.
    ///
    /// # Errors
    /// Of learning.
    pub fn learn(self) -> Result<ExampleEdit, PropagateError> {
        Ok(ExampleEdit::learn(&[self.pair()?], &ExampleOptions::default())?)
    }

    /// The edit as the scene of its name has it: from examples far enough apart for a small file.
    ///
    /// # Errors
    /// Of learning.
    pub fn learn_small(self) -> Result<ExampleEdit, PropagateError> {
        let examples_hz = match self {
            Self::LeanBack => 10.0,
            Self::ArmsOut => 30.0,
        };
        Ok(ExampleEdit::learn(&[self.pair()?], &ExampleOptions { examples_hz, ..ExampleOptions::default() })?)
    }

    /// The scenes that ship, below `scenes/`, with their texts: what it is taught on, the same as it should be, and the scene that uses it.
    pub fn scenes(self) -> [(String, String); 3] {
        let (name, taught_on, training) = (self.name(), self.taught_on(), self.training());
        let (before, after) = self.about();
        let uses = format!("ByExample(model: \"{}\")", self.model());
        let beside = "../characters/human.ron";
        let text =
            |change, about| Scene { legs: &training, change, character: beside, about, edits: "" }.text();
        let (legs, about) = (&short_errand(), self.look());
        let character = "characters/human.ron";
        let scene = Scene { legs, change: Change::None, character, about, edits: &uses }.text();
        [
            (format!("propagate/{taught_on}.ron"), text(Change::None, before)),
            (format!("propagate/{taught_on}-{name}.ron"), text(self.change(), after)),
            (format!("{name}.ron"), scene),
        ]
    }

    /// The learned edit that ships, below `scenes/`.
    pub fn model(self) -> String {
        format!("propagate/{}.edit", self.name())
    }

    /// What it is about, degrees, one a frame: how far the trunk leans forward, or how far the arms are from hanging (mean of both).
    ///
    /// # Panics
    /// Of a clip that is not of the standard figure.
    pub fn measure(self, clip: &Clip) -> Vec<f64> {
        let s = &clip.skeleton;
        let link = |name: &str| s.link(name).unwrap_or_else(|| panic!("the standard figure has `{name}`"));
        let mut k = Kinematics::new(s, clip.pose(0));
        let (pelvis, trunk, neck) = (link("pelvis"), link("abdomen"), link("neck"));
        let arms = [("shoulder_l", "elbow_l"), ("shoulder_r", "elbow_r")].map(|(a, b)| (link(a), link(b)));
        (0..clip.frames())
            .map(|f| {
                k.update(s, clip.pose(f));
                match self {
                    Self::LeanBack => {
                        let up = k.origin(neck) - k.origin(trunk);
                        let front = k.world[pelvis].rotation * Vec3::z();
                        let level = Vec3::new(front.x, 0.0, front.z).normalize();
                        up.dot(&level).atan2(up.y).to_degrees()
                    }
                    Self::ArmsOut => {
                        let away = |(a, b): (usize, usize)| (k.origin(b) - k.origin(a)).angle(&-Vec3::y());
                        (0.5 * (away(arms[0]) + away(arms[1]))).to_degrees()
                    }
                }
            })
            .collect()
    }

    /// How far an answer is from the script.
    pub fn held(self, source: &Clip, truth: &Clip, answer: &Clip) -> Held {
        let [a, b, c] = [source, truth, answer].map(|clip| self.measure(clip));
        let change: Vec<f64> = a.iter().zip(&b).map(|(a, b)| (b - a).abs()).collect();
        let most = change.iter().copied().fold(0.0, f64::max);
        let of = |chosen: &dyn Fn(f64) -> bool| {
            let apart: Vec<f64> =
                (0..a.len()).filter(|&f| chosen(change[f])).map(|f| (c[f] - b[f]).abs()).collect();
            let rms = (apart.iter().map(|x| x * x).sum::<f64>() / apart.len().max(1) as f64).sqrt();
            ((rms, apart.iter().copied().fold(0.0, f64::max)), apart.len())
        };
        let walks = |x: f64| x > WALKS * most;
        let stands = |x: f64| x < STANDS_DEG;
        let asked: Vec<f64> = change.iter().copied().filter(|x| walks(*x)).collect();
        let (walking_deg, walking) = of(&walks);
        let (standing_deg, standing) = of(&stands);
        let (between_deg, between) = of(&|x| !walks(x) && !stands(x));
        Held {
            asked_deg: asked.iter().sum::<f64>() / asked.len().max(1) as f64,
            walking_deg,
            standing_deg,
            between_deg,
            frames: (walking, standing, between),
        }
    }

    /// The joint and the axis of its difference (body axes: x lateral, z front) that tell most.
    fn joint(self) -> (&'static str, usize) {
        match self {
            Self::LeanBack => ("chest", 0),
            Self::ArmsOut => ("shoulder_l", 2),
        }
    }

    /// What [`Shipped::predicted`] returns, in words.
    pub fn joint_label(self) -> &'static str {
        match self {
            Self::LeanBack => "chest, bend from source, °",
            Self::ArmsOut => "left shoulder, raise, °",
        }
    }

    fn column(self, edit: &ExampleEdit) -> usize {
        let (joint, axis) = self.joint();
        joint_columns(&edit.rig, joint).map_or(0, |columns| columns.start + axis)
    }

    /// Of one joint about one axis ([`Shipped::joint_label`]), as differences to the source, degrees: what the model alone predicts, its standard
    /// deviation, and the blended answer.
    pub fn predicted(self, edit: &ExampleEdit, done: &Applied) -> [Vec<f64>; 3] {
        let column = self.column(edit);
        let deg = |m: &nalgebra::DMatrix<f64>| m.column(column).iter().map(|x| x.to_degrees()).collect();
        let answer = &done.answer;
        let unsure = answer.unsure.iter().map(|x| x.to_degrees()).collect();
        [deg(&answer.predicted), unsure, deg(&answer.differences)]
    }

    /// The same of the script.
    ///
    /// # Errors
    /// A pair of another rig.
    pub fn truth(self, edit: &ExampleEdit, pair: &Pair) -> Result<Vec<f64>, PropagateError> {
        let [source, target] = [&pair.source, &pair.target].map(|clip| Rig::find(&edit.rig, &clip.skeleton));
        let d = differences((&source?, &pair.source), (&target?, &pair.target), None);
        Ok(d.column(self.column(edit)).iter().map(|x| x.to_degrees()).collect())
    }

    /// What to look at in the training performance, before and after the change.
    fn about(self) -> (&'static str, &'static str) {
        match self {
            Self::LeanBack => (
                "A stroll to teach an edit on: walks at three speeds, straight and turning, stops, and a turn on the spot.\n\
                 `stroll-lean-back.ron` is the same frame by frame, leaning back where it walks.",
                "The stroll of `stroll.ron`, leaning back by 20° while it walks and straight while it stands.\n\
                 Look at the starts and stops: the lean comes with the first step and goes with the last.",
            ),
            Self::ArmsOut => (
                "Setting off: stands, four steps, stops; 74 frames of it teach an edit.\n\
                 `setting-off-arms-out.ron` is the same frame by frame, with the arms out where it walks.",
                "The steps of `setting-off.ron` with the arms held out while they walk, hanging before and after.\n\
                 Look at the arms: they are up by the first step.",
            ),
        }
    }

    /// What to look at in the scene that uses the edit.
    fn look(self) -> &'static str {
        match self {
            Self::LeanBack => {
                "A short errand, edited by what was learned from `propagate/stroll.ron`: it leans back while it walks, and stands straight.\n\
                 Look at the stops and at the turn on the spot between: nobody keyed a frame of this one."
            }
            Self::ArmsOut => {
                "A short errand, edited by what 74 frames of `propagate/setting-off.ron` taught: arms out while walking, hanging while standing.\n\
                 Look at the turn on the spot, which the examples do not have: there the edit gives way."
            }
        }
    }
}

/// Frames walk where the script changes more than this share of the most it changes.
const WALKS: f64 = 0.8;
/// And stand where it changes less than this, degrees.
const STANDS_DEG: f64 = 0.5;

/// The errand that neither edit is taught on: two minutes, with turns, starts and stops.
pub fn errand() -> Vec<Leg> {
    let mut legs = Vec::new();
    for lap in 0..3 {
        let more = f64::from(lap);
        legs.extend([
            stand(1.4 + 0.4 * more, 25.0),
            steps(10, 0.47 + 0.025 * more, 0.57 - 0.02 * more, 0.0),
            stand(2.2 - 0.5 * more, -20.0),
            steps(2, 0.0, 0.55, 60.0),
            stand(0.7, 15.0),
            steps(5, 0.48, 0.55, 9.0 - 4.0 * more),
            steps(4, 0.52, 0.53, -9.0 + 6.0 * more),
            stand(1.0, 30.0),
            steps(3, 0.0, 0.58, -55.0),
            steps(8, 0.5, 0.53, 6.0),
            stand(1.8, -30.0),
            steps(12, 0.5, 0.52 + 0.02 * more, -10.0 + 7.0 * more),
            stand(0.9 + 0.5 * more, 18.0),
            steps(6, 0.46, 0.56, 0.0),
            stand(1.2, -15.0),
            steps(4, 0.0, 0.55, 45.0),
        ]);
    }
    legs.push(stand(1.5, 20.0));
    legs
}

/// The performance of the scenes that ship: a short errand.
pub fn short_errand() -> Vec<Leg> {
    vec![
        stand(1.0, 20.0),
        steps(6, 0.48, 0.57, 6.0),
        stand(1.3, -25.0),
        steps(3, 0.0, 0.55, 50.0),
        stand(0.6, 15.0),
        steps(6, 0.52, 0.55, -8.0),
        stand(0.6, 20.0),
    ]
}

/// A route with and without a change.
///
/// # Errors
/// Scripts that do not open.
pub fn pair(name: &str, legs: &[Leg], change: Change) -> Result<Pair, PropagateError> {
    Ok(Pair::new(name, clip(legs, Change::None)?, clip(legs, change)?))
}

/// The motion of a route.
///
/// # Errors
/// A script that does not open.
pub fn clip(legs: &[Leg], change: Change) -> Result<Clip, PropagateError> {
    let ron = Scene { legs, change, character: "library:characters/human.ron", about: "", edits: "" }.text();
    let take = takes::open(Input::Text { ron, base: PathBuf::new() }, &Ask::default());
    Ok(take.map_err(Box::new)?.asked.clip)
}

fn stand(seconds: f64, look_deg: f64) -> Leg {
    Leg::Stand { seconds, look_deg }
}

fn steps(count: usize, stride_m: f64, beat_s: f64, turn_deg: f64) -> Leg {
    Leg::Steps { count, stride_m, beat_s, turn_deg }
}
