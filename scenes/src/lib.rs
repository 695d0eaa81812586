//! Scenes and characters as files people write, and the pipeline that renders them.
//!
//! ```text
//! open ─→ Stage (kinematic preview) ─→ perform ─→ Outcome ─→ Report, files
//! ```
//!
//! | module | holds |
//! |---|---|
//! | [`scene`] | a scene file, checked |
//! | [`scene_motion`] | the human motion of a scene that retargets one |
//! | [`schema`] | its words |
//! | [`stage`] | a scene or a clip, ready to be performed |
//! | [`disturbance_report`] | disturbances and falls, as reports give them |
//! | [`export`] | a body as MJCF |
//! | [`footwork`] | planted feet that step, and jumps |
//! | [`inspect`] | what is in a file |
//! | [`overrides`] | numbers of the dynamic pass given beside the file |
//! | [`patch`] | parameters of tension and balance in a file of their own |
//! | [`standing`] | the parts of a clip a body can perform on its own feet |
//! | [`pareto`] | the trade between fidelity and help from outside |
//! | [`push`] | the push-recovery map of a standing body |
//! | [`retargeting`] | human motion put on a character |
//! | [`reactive`] | gazes of a scene, and how far they missed |
//! | [`report`] | the numbers of a run |
//! | [`tune`] | parameters chosen by a search over a cost |
//! | [`study`] | a trace, clip or scene to be analysed and drawn |
//! | [`study_report`] | the numbers of an analysis |
//! | [`character_file`] | characters as RON |
//! | [`angle`] | joint values in degrees |
//! | [`error`] | errors with file, line and column |
//! | [`source_map`] | where the values of a RON text stand |

pub mod angle;
pub mod character_file;
pub mod disturbance_report;
mod disturbances;
pub mod error;
pub mod export;
pub mod footwork;
pub mod inspect;
pub mod overrides;
pub mod pareto;
pub mod patch;
pub mod push;
pub mod reactive;
pub mod report;
pub mod retargeting;
pub mod scene;
pub mod scene_motion;
pub mod schema;
pub mod source_map;
pub mod stage;
pub mod standing;
pub mod study;
pub mod study_report;
pub mod tune;

pub use angle::Angle;
pub use dynamics::analysis::Residual;
pub use dynamics::{Analysis, Character, RootMode, Trace};
pub use dynamics::{analysis_files, ground_forces};
pub use error::{SceneError, Source};
pub use inspect::character_in;
pub use overrides::Overrides;
pub use patch::Patch;
pub use report::Report;
pub use retarget;
pub use scene::Scene;
pub use sim::Outcome;
pub use stage::{Stage, StageError, open, open_with};
pub use study::{Study, StudyError, StudyOptions, StudySource};
pub use study_report::AnalysisReport;
