//! Helpers shared by the promises.
