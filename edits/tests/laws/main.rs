//! The laws of movement-property edits, one file for each subject.

mod body;

mod amplitude;
mod extent;
mod identity;
mod log;
mod order;
mod selectors;
mod succession;
mod tension;
