//! Contacts: when points touch the ground, and the motion that keeps them there.

/// A time in which a point of the character stays where it is on the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct Phase {
    /// The site's name.
    pub point: String,
    /// First time of contact, s.
    pub from_s: f64,
    /// Last time of contact, s.
    pub to_s: f64,
}
