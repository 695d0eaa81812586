//! What may be asked of a pose, and what is said of the rest.

use thiserror::Error;

use super::{Handle, Hold, Poser};

/// What is wrong with what is asked of a pose.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PoseError {
    /// A pose or weights of another length.
    #[error("{what}: {found} numbers; the skeleton needs {needed}")]
    Length {
        /// Which.
        what: &'static str,
        /// Numbers found.
        found: usize,
        /// Numbers needed.
        needed: usize,
    },
    /// A number that is not finite.
    #[error("{0} is not finite")]
    NotFinite(String),
    /// A link that does not exist.
    #[error("link {found} does not exist; the skeleton has {exist}, counted from 0")]
    Link {
        /// As asked.
        found: usize,
        /// How many there are.
        exist: usize,
    },
    /// A weight out of range.
    #[error("the weight of `{link}` is {weight}; allowed: {allowed}")]
    Weight {
        /// The link.
        link: String,
        /// As asked.
        weight: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A piece of fewer than two links, or a link in two of them.
    #[error("`{link}` {what}")]
    Group {
        /// The link.
        link: String,
        /// What is wrong.
        what: &'static str,
    },
    /// One point, two places.
    #[error("`{link}` is to be at two places, {apart_m:.4} m apart; a point is dragged or pinned to one")]
    Opposed {
        /// The link.
        link: String,
        /// Distance of the places, m.
        apart_m: f64,
    },
    /// No handle.
    #[error("nothing is dragged or pinned")]
    Nothing,
    /// A call before [`Poser::begin`].
    #[error("no pose to start from: `begin` comes before `drag`")]
    NotBegun,
}

/// Points of a link nearer than this are one, m.
const SAME_M: f64 = 1e-9;

impl Poser {
    pub(super) fn check_pose(&self, q: &[f64]) -> Result<(), PoseError> {
        let needed = self.skeleton.nq();
        if q.len() != needed {
            return Err(PoseError::Length { what: "the pose", found: q.len(), needed });
        }
        match q.iter().position(|x| !x.is_finite()) {
            Some(i) => Err(PoseError::NotFinite(format!("number {i} of the pose"))),
            None => Ok(()),
        }
    }

    pub(super) fn check_handles(&self, handles: &[Handle]) -> Result<(), PoseError> {
        if !self.begun {
            return Err(PoseError::NotBegun);
        }
        if handles.is_empty() {
            return Err(PoseError::Nothing);
        }
        let exist = self.skeleton.links().len();
        for (i, h) in handles.iter().enumerate() {
            let Some(link) = self.skeleton.links().get(h.link) else {
                return Err(PoseError::Link { found: h.link, exist });
            };
            if !h.at.iter().chain(&h.place).all(|x| x.is_finite()) {
                return Err(PoseError::NotFinite(format!("a place of `{}`", link.name)));
            }
            if let Hold::Dragged(weight) = h.hold
                && !(weight > 0.0 && weight.is_finite())
            {
                let link = link.name.clone();
                return Err(PoseError::Weight { link, weight, allowed: "finite, above 0" });
            }
            let same = |o: &&Handle| o.link == h.link && (o.at - h.at).norm() < SAME_M;
            if let Some(other) = handles[..i].iter().find(same) {
                let apart_m = (other.place - h.place).norm();
                if apart_m > SAME_M {
                    return Err(PoseError::Opposed { link: link.name.clone(), apart_m });
                }
            }
        }
        Ok(())
    }

    pub(super) fn check_groups(&self, groups: &[Vec<usize>]) -> Result<(), PoseError> {
        let links = self.skeleton.links();
        let all = || groups.iter().flatten().copied();
        if let Some(found) = all().find(|&l| l >= links.len()) {
            return Err(PoseError::Link { found, exist: links.len() });
        }
        let fault = |link: usize, what| Err(PoseError::Group { link: links[link].name.clone(), what });
        for group in groups {
            if let [link] = group[..] {
                return fault(link, "is a piece alone; a piece that moves as one needs two links or more");
            }
        }
        match all().enumerate().find(|&(i, l)| all().take(i).any(|other| other == l)) {
            Some((_, link)) => fault(link, "is named twice; a link belongs to one piece"),
            None => Ok(()),
        }
    }
}
