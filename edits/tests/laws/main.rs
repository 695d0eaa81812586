//! The laws of edits, one file for each subject.

mod body;
mod clip_body;

mod amplitude;
mod by_example;
mod clip_log;
mod extent;
mod identity;
mod log;
mod on_fit;
mod order;
mod pin;
mod place;
mod pose_delta;
mod selectors;
mod succession;
mod tension;
mod warp;
