//! Figures of motions and traces, as SVG and PNG: what the body was asked to do, what it did, and
//! every force it needed.
//!
//! In: [`motion::Clip`]s and [`dynamics::Trace`]s. Out: [`Figure`]s, written by [`Figure::save`].
//! Nothing is computed here that is not in the trace, but differences, sums and support hulls. The
//! typeface (DejaVu Sans) is embedded; no system library is needed. Same input, same bytes.
//!
//! | module | holds |
//! |---|---|
//! | [`strip`] | film strips: figures evenly spaced in time |
//! | [`angles`] | joint angles asked for against performed |
//! | [`gains`] | gains and torques of the joints that work hardest |
//! | [`contacts`] | ground forces per foot, in total, against body weight |
//! | [`balance`] | centre of mass over the support |
//! | [`residual`] | momentum that neither gravity nor contacts explain |
//! | [`camera`], [`solid`] | who looks at them, and how shapes become polygons |
//! | [`panel`] | axes, curves, legends, pages of small multiples |
//! | [`figure`] | a page as a list of marks; SVG and PNG |
//! | [`mod@style`] | colours, sizes, the typeface |
//!
//! Text on figures is in degrees, newtons and metres.

pub mod angles;
pub mod balance;
pub mod camera;
mod columns;
pub mod contacts;
pub mod figure;
pub mod gains;
pub mod panel;
pub mod residual;
pub mod solid;
pub mod strip;
pub mod style;

pub use angles::joint_angles;
pub use balance::center_of_mass;
pub use camera::Camera;
pub use contacts::contact_forces;
pub use figure::{Figure, FigureError};
pub use gains::gains_and_torques;
pub use residual::momentum_residual;
pub use strip::{StripOptions, StripRow, film_strip, film_strip_with};
