//! Takes: who performs what, under which conditions. The only composer.
//!
//! ```text
//! Source (script | clip | retarget) ─→ track edits ─→ sampled ─→ clip edits ─→ limits, plants ─→ Asked
//!                                                         Asked + Body + Conditions ─→ perform ─→ Performed ─→ results
//! ```
//!
//! | module | holds |
//! |---|---|
//! | [`mod@open`] | a file, a text or a clip to a take |
//! | `opening` | files that name files |
//! | [`ask`], [`error`] | what a take is opened from; why there is none |
//! | [`take`] | the take: body, source, motion asked for, conditions |
//! | [`conditions`], `pushed` | what acts on the body; pushes asked for beside the file |
//! | [`script`], `possible`, [`ignored`] | the take of a script, made possible; its keys that cannot act |
//! | `keyed` | how much keys rule what balance and feet set otherwise |
//! | `steps` | feet of a script that lift, travel and stand again |
//! | [`limited`] | joints that their limits changed |
//! | `clip`, `clip_edits` | the take of a clip; edits of sampled motion |
//! | [`retargeting`] | human motion put on a character |
//! | [`posing`] | a clip posed by dragging |
//! | [`blocking`] | a clip as a script of a few key poses |
//! | [`standing`] | the parts of a clip a body can perform on its own feet |
//! | [`styles`] | style components of two takes, put into a third |
//! | `pins` | the pins of a scene, held after every other edit |
//! | [`stepping`] | a motion that steps, made possible before it is performed |
//! | [`perform`] | the dynamic pass |
//! | [`replay`] | offsets that foresight chose, as a file |
//! | [`results`] | what a take leaves |
//! | [`inspect`] | what is in a file |
//! | [`export`] | a body as MJCF |
//! | [`analysis`] | a trace, clip or scene to be analysed and drawn |
//! | [`starter`] | a project to start from |
//! | [`progress`] | what a long call says while it runs |

pub mod analysis;
pub mod ask;
pub mod blocking;
mod clip;
mod clip_edits;
pub mod conditions;
pub mod error;
pub mod export;
pub mod ignored;
pub mod inspect;
mod keyed;
pub mod limited;
pub mod open;
mod opening;
pub mod perform;
mod pins;
pub mod posing;
mod possible;
pub mod progress;
mod pushed;
pub mod replay;
pub mod results;
pub mod retargeting;
pub mod script;
pub mod slides;
pub mod standing;
pub mod starter;
pub mod stepping;
mod steps;
pub mod styles;
pub mod take;
mod user_programs;

pub use analysis::{AnalysisInput, AnalysisInputError, AnalysisSettings, AnalysisSource};
pub use ask::{Ask, Input, LookAhead, is_ron};
pub use conditions::Conditions;
pub use controllers::stepping::Possible;
pub use dynamics::{Analysis, RootMode, Trace};
pub use error::TakeError;
pub use ignored::{Ignored, Why};
pub use inspect::character_in;
pub use limited::Limited;
pub use open::open;
pub use perform::{PerformError, Performed, PerformedSpan, Runs};
pub use possible::Shifted;
pub use progress::{Event, Progress};
pub use results::analysis_report::AnalysisReport;
pub use results::report::Report;
pub use results::write::{What, WriteError, Written};
pub use retarget;
pub use scenes::conditions::{ENGINE, SEARCH_ENGINE};
pub use scenes::{Overrides, Patch, SceneError, character_file, library, overrides};
pub use sim::foresight;
pub use sim::{EngineEntry, Engines, Outcome, UnknownEngine};
pub use take::{Asked, Body, ClipSource, RetargetSource, Source, Take};
