//! Everything that can be wrong with a request.

use bodies::anthropometry::AnatomyError;
use bodies::{GuessError, PoseMapError};
use dynamics::penalty::PenaltyError;
use motion::Skeleton;
use motion::names::hint;
use thiserror::Error;

/// Why a motion cannot be put on a character.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RetargetError {
    /// Too few pairs.
    #[error("{found} key pose{}; at least {least} are needed to learn a mapping", if *.found == 1 { "" } else { "s" })]
    TooFewKeyPoses {
        /// Found.
        found: usize,
        /// Needed.
        least: usize,
    },
    /// The same pair twice.
    #[error("key poses `{first}` and `{second}` are the same pair; leave one out")]
    Duplicate {
        /// The earlier one.
        first: String,
        /// The later one.
        second: String,
    },
    /// One human pose, two character poses.
    #[error(
        "key poses `{first}` and `{second}` have the same human pose but character poses {apart_mm:.0} mm (RMS) apart; no mapping can give both"
    )]
    Contradiction {
        /// The earlier one.
        first: String,
        /// The later one.
        second: String,
        /// RMS distance of the character's feature points, mm.
        apart_mm: f64,
    },
    /// A frame that the clip does not have.
    #[error("key pose `{pair}`: frame {frame} does not exist; the clip has frames 0 to {}", .frames.saturating_sub(1))]
    Frame {
        /// The pair.
        pair: String,
        /// Frame asked for.
        frame: usize,
        /// Frames there are.
        frames: usize,
    },
    /// A pose of the wrong length.
    #[error("key pose `{pair}`: its {whose} pose has {found} numbers, the skeleton needs {needed}")]
    PoseLength {
        /// The pair.
        pair: String,
        /// `human` or `character`.
        whose: &'static str,
        /// Length found.
        found: usize,
        /// Length needed.
        needed: usize,
    },
    /// Feature points that a skeleton lacks.
    #[error("`{whose}` lacks the feature points {}", .missing.join(", "))]
    MarkersMissing {
        /// Clip, character or key pose.
        whose: String,
        /// Names.
        missing: Vec<String>,
    },
    /// A feature point that is neither a site nor a link.
    #[error("there is no site or link `{name}` for a feature point{hint}")]
    Marker {
        /// The name.
        name: String,
        /// What exists.
        hint: String,
    },
    /// The clip is not of the performer's skeleton.
    #[error("the clip does not fit the performer: {0}")]
    Skeleton(#[from] PoseMapError),
    /// The skeleton is not human.
    #[error(transparent)]
    Anatomy(#[from] AnatomyError),
    /// No body can be guessed for the clip.
    #[error(transparent)]
    Guess(#[from] GuessError),
    /// A character that touches nothing.
    #[error("character `{character}` has no contact point; it needs at least one to stand on")]
    NoContactPoint {
        /// The character.
        character: String,
    },
    /// A character whose contact points follow no human one.
    #[error(
        "none of the {} contact points of `{character}` ({}) follows a human one; name for each when it touches, such as `follows: {{ \"{}\": Any([\"heel_l\", \"ball_l\"]) }}`",
        .points.len(), .points.join(", "), .points.first().map_or("", String::as_str)
    )]
    NothingFollows {
        /// The character.
        character: String,
        /// Its contact points.
        points: Vec<String>,
    },
    /// A contact point whose site does not exist.
    #[error("contact point at site {site}: the skeleton has only {sites} sites")]
    ContactSite {
        /// Index.
        site: usize,
        /// Sites there are.
        sites: usize,
    },
    /// A contact point without counterpart.
    #[error("contact point `{site}` names no human contact point to follow")]
    NoCounterpart {
        /// The site.
        site: String,
    },
    /// A counterpart that the performer does not have.
    #[error("contact point `{site}` follows `{human}`, which is no contact point of the performer{hint}")]
    Counterpart {
        /// The site.
        site: String,
        /// The name that is missing.
        human: String,
        /// What exists.
        hint: String,
    },
    /// A phase by hand that does not fit.
    #[error("contact phase of `{point}` from {from_s} s to {to_s} s: {reason}")]
    Phase {
        /// The point.
        point: String,
        /// Start, s.
        from_s: f64,
        /// End, s.
        to_s: f64,
        /// What is wrong.
        reason: &'static str,
    },
    /// A link named for the refinement that does not exist.
    #[error("there is no link `{name}` to refine{hint}")]
    RefineLink {
        /// The name.
        name: String,
        /// What exists.
        hint: String,
    },
    /// An option outside its range.
    #[error("{name} is {value}; allowed: {allowed}")]
    Option {
        /// Which one, with its unit.
        name: &'static str,
        /// Value found.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A clip that is too short.
    #[error("the clip has {frames} frames at {rate_hz} Hz; at least {least} are needed")]
    TooShort {
        /// Frames found.
        frames: usize,
        /// Their rate, Hz.
        rate_hz: f64,
        /// Frames needed.
        least: usize,
    },
    /// A root that cannot move.
    #[error("the root `{link}` of `{character}` must have a free joint")]
    Root {
        /// The character.
        character: String,
        /// Its root.
        link: String,
    },
    /// A contact model that no body has.
    #[error(transparent)]
    Penalty(#[from] PenaltyError),
    /// The statistical model could not be learned.
    #[error("the mapping cannot be learned: {0}")]
    Learn(String),
    /// The normal equations of the refinement have no solution.
    #[error("the refinement's normal equations are not positive definite in row {row}")]
    Singular {
        /// First row that failed.
        row: usize,
    },
}

impl RetargetError {
    /// A feature point that is neither a site nor a link.
    pub(crate) fn marker(name: &str, skeleton: &Skeleton) -> Self {
        let sites = skeleton.sites().iter().map(|s| s.name.as_str());
        let links = skeleton.links().iter().map(|l| l.name.as_str());
        Self::Marker { name: name.into(), hint: hint(name, sites.chain(links)) }
    }
}
