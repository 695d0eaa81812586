//! Timing: what the muscles of a scripted joint know of the motion that they are asked.

use crate::names::Word;

/// How a transition is performed by muscles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Timing {
    /// They know the load of gravity at the end pose: limbs lag behind and swing past, the more the less tension \[NF03\].
    #[default]
    Loose,
    /// They also foresee the inertia of the motion asked for: poses arrive when they are asked, at any tension.
    Led,
}

impl Word for Timing {
    const KIND: &'static str = "timing";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Loose, "loose", "Limbs lag behind and swing, as their tension lets them"),
        (Self::Led, "led", "Muscles foresee the motion: poses arrive in time at any tension"),
    ];
}
