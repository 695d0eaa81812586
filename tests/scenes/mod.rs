//! What the scenes of the library promise.

mod edits_move_their_numbers;
mod library;
mod person;
mod standing;
mod steps;
