//! Laws of the dynamic pass (DESIGN §4), each measured in the simulation.

mod bodies;
mod stage;

mod stiffness;
