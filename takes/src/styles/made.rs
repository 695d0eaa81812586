//! The styles that ship, made again.
//!
//! In: a name. Out: the components of its two performances, `walk-neutral` and `walk-NAME` of the library
//! (`cargo run --release -p takes --example make_styles` writes the files and their contact sheets).

use std::collections::BTreeMap;
use std::path::PathBuf;

use edits::style::{Representation, StyleSet};
use motion::Clip;
use scenes::library;

use super::Find;
use super::library::NEUTRAL;
use crate::{Ask, Take, TakeError};

/// The part of every performance that walks in its style from beginning to end.
const WALKS: (f64, f64) = (0.3, 0.74);

/// Components of each: all decompositions of so many come to rest.
const COMPONENTS: usize = 3;
/// Of the childish walk, whose bounce is a component of its own.
const BOUNCING: usize = 4;

/// The style of this name made again: the neutral performance, and the components of both.
///
/// # Errors
/// Performances that there are not.
///
/// # Panics
/// If they cannot be decomposed, which tests rule out.
pub fn made(name: &str) -> Result<(Take, StyleSet), TakeError> {
    let open = |performance: &str| {
        crate::open(
            PathBuf::from(format!("{}performances/{performance}.ron", library::PREFIX)),
            &Ask::default(),
        )
    };
    // standing before and after the walk is no style
    let walking = |mut take: Take| {
        let clip = &take.asked.clip;
        let nq = clip.skeleton.nq();
        let frame = |part: f64| (part * clip.frames() as f64) as usize;
        let data = clip.data()[frame(WALKS.0) * nq..frame(WALKS.1) * nq].to_vec();
        take.asked.clip = Clip::new(clip.skeleton.clone(), clip.rate_hz, data);
        take
    };
    let neutral = walking(open(NEUTRAL)?);
    let styled = walking(open(&format!("walk-{name}"))?);
    let find = Find {
        count: Some(if name == "childish" { BOUNCING } else { COMPONENTS }),
        variance: 1.0,
        representation: Representation::Positions,
        merge: Vec::new(),
        names: BTreeMap::new(),
    };
    let set = find.set(&neutral, &styled, false).expect("performances of one figure");
    Ok((neutral, set))
}
