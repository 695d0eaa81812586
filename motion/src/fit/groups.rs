//! Which joints of a fit have their keys at the same times: those of a limb, and those of the trunk.
//!
//! In: a skeleton. Out: its moving links in groups. A limb has its own links, what hangs on them (fingers), and what
//! carries nothing but it (a clavicle); all other links are the trunk: the root, the spine, the head, a tail, and the whole
//! of a body without limbs.

use crate::{Joint, Skeleton};

/// Name of the group of all that is no limb.
pub const TRUNK: &str = "trunk";

/// Links that share their key times.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// The limb, or [`TRUNK`].
    pub name: String,
    /// Its links that are not welded, parents first.
    pub links: Vec<usize>,
}

/// The groups of a skeleton: the trunk, then each limb that moves.
pub fn groups(skeleton: &Skeleton) -> Vec<Group> {
    let limbs = skeleton.limbs();
    let within = |link: usize, root: usize| link == root || skeleton.ancestors(link).any(|a| a == root);
    // the limb of each link: what hangs on it, or all that it carries
    let limb_of: Vec<Option<usize>> = (0..skeleton.links().len())
        .map(|link| {
            if let Some(own) = limbs.iter().position(|l| within(link, l.upper)) {
                return Some(own);
            }
            let mut carried = (0..limbs.len()).filter(|l| within(limbs[*l].upper, link));
            let first = carried.next()?;
            // a link that also carries something that is no limb is of the trunk
            let alone = carried.next().is_none()
                && link != 0
                && (0..skeleton.links().len()).all(|other| {
                    !within(other, link)
                        || within(other, limbs[first].upper)
                        || within(limbs[first].upper, other)
                });
            alone.then_some(first)
        })
        .collect();
    let of = |limb: Option<usize>| -> Vec<usize> {
        let moves = |link: &usize| !matches!(skeleton.links()[*link].joint, Joint::Fixed);
        (0..skeleton.links().len()).filter(|l| limb_of[*l] == limb).filter(moves).collect()
    };
    let trunk = Group { name: TRUNK.into(), links: of(None) };
    let limbs = limbs.iter().enumerate().map(|(i, l)| Group { name: l.name.clone(), links: of(Some(i)) });
    [trunk].into_iter().chain(limbs).filter(|g| !g.links.is_empty()).collect()
}
