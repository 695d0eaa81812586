//! What a search found, before it is written.

use super::{Sample, Slice};
use crate::push::PushMap;

/// What a search found.
#[derive(Clone, Debug)]
pub struct SearchResult {
    /// The scene as it was.
    pub before: Sample,
    /// The best point.
    pub after: Sample,
    /// The same two in a second engine, by its name.
    pub confirmed: Option<(String, [Sample; 2])>,
    /// All points.
    pub samples: Vec<Sample>,
    /// Costs along the parameters.
    pub slices: Vec<Slice>,
    /// Push maps, before and after.
    pub maps: Option<(PushMap, Option<PushMap>)>,
    /// Why one of them is missing.
    pub missing: Option<String>,
}
