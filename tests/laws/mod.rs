//! Laws of the dynamic pass (DESIGN §4), each measured in the simulation.

mod bodies;
mod stage;

mod actuators;
mod clips;
mod determinism;
mod gaze;
mod momentum;
mod pushes;
mod sagging;
mod steps;
mod stiffness;
