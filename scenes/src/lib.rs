//! Text to checked specifications: scenes, characters, patches, contact phases.
//!
//! In: RON files that people write. Out: plain values in SI units with every name resolved, or a [`SceneError`] at the very
//! value that is wrong. Opens no clip and composes nothing: that is the crate `takes`.
//!
//! | module | holds |
//! |---|---|
//! | [`scene`] | a scene file, checked |
//! | [`schema`] | its words |
//! | [`conditions`] | what acts on a performer, as a file states it |
//! | [`overrides`] | numbers of the dynamic pass given beside the file |
//! | [`props`] | boxes and ramps of a scene or a command line, checked |
//! | [`patch`] | parameters of tension and balance in a file of their own |
//! | [`strip_spec`] | how film strips are drawn |
//! | [`tune_spec`] | what a scene says about its tuning |
//! | [`contact_file`] | contact phases found by a run, edited by hand |
//! | [`character_file`] | characters as RON |
//! | [`library`] | scenes, characters and key poses inside the program, and their names |
//! | [`angle`] | joint values in degrees |
//! | [`error`] | errors with file, line and column |
//! | [`source_map`] | where the values of a RON text stand |

pub mod angle;
pub mod character_file;
pub mod conditions;
pub mod contact_file;
pub mod error;
pub mod library;
pub mod overrides;
pub mod patch;
pub mod program_spec;
pub mod props;
pub mod scene;
pub mod schema;
pub mod source_map;
pub mod strip_spec;
pub mod tune_spec;

pub use angle::Angle;
pub use conditions::{ConditionsSpec, Physics};
pub use error::{SceneError, Source};
pub use overrides::Overrides;
pub use patch::Patch;
pub use program_spec::ProgramSpec;
pub use props::prop_of;
pub use scene::{Scene, SceneSource};
pub use strip_spec::StripSpec;
pub use tune_spec::TuneSpec;
