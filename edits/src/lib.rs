//! Edits: changes to motion in an animator's words, of two kinds.
//!
//! - [`TrackEdit`]: in transition-element tracks (NF03) and a [`Selection`] of their elements, out the tracks changed;
//! - [`ClipEdit`]: in a [`Motion`], a clip wherever it came from, and a [`ClipPlace`] in it, out the motion changed.
//!
//! Both are placed by a [`Where`] and keep one [`EditLog`], which says what each edit changed. Edits know nothing of
//! files, of physics or of each other; they run in the order the caller applies them, those of tracks first.
//!
//! | module | holds |
//! |---|---|
//! | [`track_edit`] | what an edit of tracks is |
//! | [`clip_edit`] | what an edit of clips is, and how one is written |
//! | [`clip_motion`] | what clip edits are given and give |
//! | [`place`] | where edits of both kinds apply |
//! | [`selector`] | what an edit applies to: script, action, cycle, repetition, pose, element, body part |
//! | [`param`] | parameters: constants, curves over time or repetition, one value for each pose |
//! | [`argument`] | what a scene gives to a program of the user |
//! | [`log`] | which edits changed each element and joint, by how much; conflicts |
//! | [`clip_change`] | what a clip edit changed: when, which joints, by how much |
//! | [`succession`] | joints start one after another along the body |
//! | [`amplitude`] | how far a movement goes about its average or a reference pose |
//! | [`extent_shoulder`] | how far the arms are from the body |
//! | [`extent_reach`] | how far the hands are from the shoulders |
//! | [`tension`] | how stiff the muscles are |
//! | [`on_fit`] | an edit of tracks on a clip, through elements fitted to it |
//! | [`fit_place`] | where it acts there |
//! | `feet` | feet that stand where they stood |
//! | [`warp`] | a clip retimed by anchors |
//! | [`by_example`] | an edit learned from a few edited seconds |
//! | [`pin`] | points held in the world, on a link, or where they were, by whole-body IK |
//! | [`pose_delta`] | one pose corrected and blended, or a block of them |
//! | [`pose_request`] | a pose asked for by dragging |
//! | [`time_delta`] | one pose dragged in time |
//! | [`style`] | components of two clips, put into a third |
//! | [`poses`] | elements grouped by pose: for edits that think in poses |
//! | [`error`] | what can be wrong |
//!
//! ```
//! # use motion::script::{Action, Cycle, Pose, PoseValue, Script};
//! # use motion::{Joint, Link, Skeleton, Vec3};
//! use edits::{Amplitude, EditLog, Selector, TrackEdit};
//! # let hinge = Joint::Revolute(Vec3::x());
//! # let links = vec![Link::new("lamp", None, Vec3::zeros(), hinge)];
//! # let lamp = std::sync::Arc::new(Skeleton::new(links).unwrap());
//! # let pose = |x| Pose { values: vec![PoseValue::scalar("lamp", x)], ..Pose::default() };
//! # let cycle = Cycle { repetitions: 4, poses: vec![pose(0.5), pose(0.1)], ..Cycle::default() };
//! # let nod = Action { name: "nod".into(), cycles: vec![cycle], ..Action::default() };
//! # let script = Script { actions: vec![nod], ..Script::default() };
//! let mut tracks = script.build(&lamp, &lamp.zero_pose()).unwrap();
//! let mut log = EditLog::default();
//! for (edit, on) in [(Amplitude::new(0.5), "nod"), (Amplitude::new(2.0), "nod_0_1")] {
//!     let selection = Selector::label(on).select(&tracks).unwrap();
//!     edit.apply(&mut tracks, &selection, &mut log).unwrap();
//! }
//! assert_eq!(log.conflicts().len(), 4); // nod_0_1, in each repetition, was written twice
//! ```
//!
//! A new edit is a type that implements [`TrackEdit`] or [`ClipEdit`]; their `apply` gives it the log, the check that
//! results are possible and the promise that a failed edit leaves the motion alone.
//!
//! NF03: Neff, Fiume. Aesthetic edits for character animation. SCA 2003.

pub mod amplitude;
pub mod argument;
pub mod by_example;
pub mod clip_change;
pub mod clip_edit;
pub mod clip_motion;
pub mod error;
pub mod extent_reach;
pub mod extent_shoulder;
mod feet;
pub mod fit_place;
pub mod log;
pub mod on_fit;
pub mod param;
pub mod pin;
pub mod place;
pub mod pose_delta;
pub mod pose_request;
pub mod poses;
pub mod selector;
pub mod style;
pub mod succession;
pub mod tension;
pub mod time_delta;
pub mod track_edit;
pub mod warp;

pub use amplitude::{Amplitude, Reference};
pub use argument::Argument;
pub use by_example::{ByExample, ExampleEdit, ExampleError};
pub use clip_change::{ClipChange, JointChange, Largest};
pub use clip_edit::ClipEdit;
pub use clip_motion::{Edited, Motion};
pub use error::EditError;
pub use extent_reach::ExtentReach;
pub use extent_shoulder::ExtentShoulder;
pub use fit_place::FitPlace;
pub use log::{Conflict, EditLog, Field};
pub use on_fit::OnFit;
pub use param::Parameter;
pub use pin::{Pin, PinAt, Pins};
pub use place::{ClipPlace, Where};
pub use pose_delta::{PoseChange, PoseDelta};
pub use pose_request::{Met, PoseAnswer, PoseRequest};
pub use selector::{Place, Selection, Selector};
pub use style::Style;
pub use succession::{Direction, Succession};
pub use tension::{Amount, Tension};
pub use time_delta::TimeDelta;
pub use track_edit::TrackEdit;
pub use warp::Warp;
