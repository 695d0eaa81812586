//! Where each contact point has to be, in every frame.
//!
//! In: the paths of the points as the motion has them, and their phases. Out: the paths to follow. Those of one link are
//! moved as one rigid body by the smoothest correction that keeps them at rest in their phases (`planted`); a link without
//! phases keeps its own. \[YAH10\] (9) blends corrections of single points with h²(3 − 2h), which matches positions only: the
//! point still has the speed of the source at touchdown (0.1 to 0.4 m/s were measured) and stops dead.
//!
//! \[YAH10\] Yamane, Ariki, Hodgins. Animating Non-Humanoid Characters with Human Motion Data, SCA 2010.

use super::planted::Planted;
use super::{ALLOWED, peak};
use crate::Puppet;

pub use crate::phase::{Path, PhaseFrames};

/// The paths that hold every point in its phases.
pub fn held_paths(puppet: &Puppet, paths: &[Path], spans: &[Vec<PhaseFrames>], rate_hz: f64) -> Vec<Path> {
    let allowed = ALLOWED * peak(paths, spans, rate_hz);
    let mut out = paths.to_vec();
    for of_link in by_link(puppet) {
        if of_link.iter().all(|&c| spans[c].is_empty()) {
            continue;
        }
        let sources = of_link.iter().map(|&c| &paths[c]).collect();
        let spans: Vec<&[PhaseFrames]> = of_link.iter().map(|&c| spans[c].as_slice()).collect();
        for (&c, path) in of_link.iter().zip(Planted::new(sources, &spans, rate_hz).solve(&spans, allowed)) {
            out[c] = path;
        }
    }
    out
}

/// The puppet's contact points, those of a link together.
pub(super) fn by_link(puppet: &Puppet) -> Vec<Vec<usize>> {
    let sites = puppet.character.skeleton.sites();
    let link = |c: usize| sites[puppet.contacts[c].site].link;
    let mut out: Vec<Vec<usize>> = Vec::new();
    for c in 0..puppet.contacts.len() {
        match out.iter_mut().find(|of_link| link(of_link[0]) == link(c)) {
            Some(of_link) => of_link.push(c),
            None => out.push(vec![c]),
        }
    }
    out
}
