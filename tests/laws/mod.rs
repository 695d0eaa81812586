//! Laws of the dynamic pass (DESIGN §4), each measured in the simulation.

mod bodies;
mod stage;

mod actuators;
mod clips;
mod determinism;
mod disturbances;
mod falls;
mod fidelity;
mod gaze;
mod momentum;
mod pushes;
mod sagging;
mod standing;
mod steps;
mod stiffness;
mod verdicts;
mod worlds;
