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
//! | [`overlay`] | ground forces required, given and measured, over each other |
//! | [`balance`] | centre of mass over the support |
//! | [`residual`] | momentum that neither gravity nor contacts explain |
//! | [`graded`] | residual force and moment against OpenSim's guideline |
//! | [`learning`] | learning curves: error over how much was given |
//! | [`predicted`] | what a learned edit predicts, with how unsure it is, and the answer |
//! | [`momentum`] | linear and angular momentum |
//! | [`torque`] | torques of the joints that work hardest, over their noise |
//! | [`energy`] | energies, and the power of the joints |
//! | [`polar`] | push-recovery maps: impulse survived per direction, against the limit |
//! | [`tuning`] | what a search did: costs, slices, before and after |
//! | [`trade`] | tracking error against root wrench, per fidelity |
//! | [`retargeted`] | latent paths, momentum and force matched, confidence, tables |
//! | [`style_components`] | activations of style components over time |
//! | [`stages`] | film strip with a column for every stage of a motion on its way to another body |
//! | [`excerpt`] | a span of a trace, chosen joints |
//! | `face` | eyes and nose of bare heads |
//! | `clear` | places for words |
//! | [`camera`], [`solid`] | who looks at them, and how shapes become polygons |
//! | [`panel`] | axes, curves, legends, pages of small multiples |
//! | [`figure`] | a page as a list of marks; SVG and PNG |
//! | [`mod@style`] | colours, sizes, the typeface |
//!
//! Text on figures is in degrees, newtons and metres.

pub mod angles;
pub mod balance;
pub mod camera;
mod clear;
mod columns;
pub mod contacts;
pub mod energy;
pub mod excerpt;
mod face;
pub mod figure;
pub mod gains;
pub mod graded;
pub mod learning;
pub mod momentum;
pub mod overlay;
pub mod panel;
pub mod polar;
pub mod predicted;
mod raster;
pub mod residual;
pub mod retargeted;
pub mod solid;
pub mod stages;
pub mod strip;
pub mod style;
pub mod style_components;
pub mod torque;
pub mod trade;
pub mod tuning;

pub use angles::joint_angles;
pub use balance::center_of_mass;
pub use camera::{Camera, View, ViewName};
pub use contacts::contact_forces;
pub use energy::energies;
pub use excerpt::Excerpt;
pub use figure::{Figure, FigureError};
pub use gains::gains_and_torques;
pub use graded::graded_residual;
pub use momentum::momenta;
pub use overlay::{ForceSource, ForceSourceKind, contact_overlay};
pub use polar::{Spoke, push_map, push_map_over};
pub use residual::momentum_residual;
pub use retargeted::{
    Confidence, Criteria, LatentPath, Table, confidence_strip, dimension_criteria, force_match, latent_paths,
    momentum_match, table,
};
pub use stages::{PosePair, StageColumn, pose_sheet, stage_strip};
pub use strip::{StripOptions, StripRow, film_strip, film_strip_with};
pub use torque::joint_torques;
pub use trade::{TradePoint, trade_off};
pub use tuning::{CostSlice, TermPair, convergence, cost_slices, terms_before_after};
