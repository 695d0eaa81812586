//! Scenes and characters as files people write.
//!
//! | module | holds |
//! |---|---|
//! | [`character_file`] | characters as RON |
//! | [`angle`] | joint values in degrees |
//! | [`error`] | errors with file, line and column |
//! | [`source_map`] | where the values of a RON text stand |

pub mod angle;
pub mod character_file;
pub mod error;
pub mod source_map;

pub use angle::Angle;
pub use error::{SceneError, Source};
