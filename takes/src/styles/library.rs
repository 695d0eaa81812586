//! The styles that ship: what makes a walk tired, proud, sneaky, limping or childish, taken from performances of the library.
//!
//! In: a name. Out: the [`StyleSet`] that is inside the program ([`made`](super::made) makes it again).
//!
//! The bones of a set are those of the standard figure. A body of other names is told by what its links are for ([`names_for`]).

use std::collections::BTreeMap;
use std::io::Cursor;

use bodies::{Character, JointClass};
use edits::style::StyleSet;
use formats::style_file::{self, StyleFileError};
use motion::LimbKind;

/// A style that ships.
#[derive(Clone, Copy, Debug)]
pub struct Shipped {
    /// Its name.
    pub name: &'static str,
    bytes: &'static [u8],
}

/// All of them.
pub const SHIPPED: [Shipped; 5] = [
    Shipped { name: "tired", bytes: include_bytes!("../../styles/tired.style") },
    Shipped { name: "proud", bytes: include_bytes!("../../styles/proud.style") },
    Shipped { name: "sneaky", bytes: include_bytes!("../../styles/sneaky.style") },
    Shipped { name: "limping", bytes: include_bytes!("../../styles/limping.style") },
    Shipped { name: "childish", bytes: include_bytes!("../../styles/childish.style") },
];

/// The performance that they are told apart from.
pub const NEUTRAL: &str = "walk-neutral";

/// The style of this name.
pub fn shipped(name: &str) -> Option<&'static Shipped> {
    SHIPPED.iter().find(|style| style.name == name)
}

impl Shipped {
    /// Its components.
    ///
    /// # Errors
    /// Never, for files that [`made`](super::made::made) wrote.
    pub fn set(&self) -> Result<StyleSet, StyleFileError> {
        style_file::read(Cursor::new(self.bytes))
    }

    /// Its file.
    pub fn bytes(&self) -> &'static [u8] {
        self.bytes
    }
}

/// A component of a style that ships is part of it if it tells the performances apart by this much: both were made to differ in nothing
/// else, so less is asked than of captured clips.
const CLEAR: f64 = 0.3;

/// The components that make a style that ships, counted from 0.
pub fn components(set: &StyleSet) -> Vec<usize> {
    (0..set.components()).filter(|&c| set.separation(c).best() >= CLEAR).collect()
}

/// Bones of the standard figure, and what a body calls them: by what its limbs and links are for. Names that it has itself are left out.
pub fn names_for(character: &Character) -> BTreeMap<String, String> {
    let s = &character.skeleton;
    let mut found: Vec<(String, usize)> = vec![("pelvis".into(), 0)];
    for limb in s.limbs() {
        let side = if limb.name.ends_with('l') { "l" } else { "r" };
        let bones = match limb.kind {
            LimbKind::Arm => ["shoulder", "elbow", "wrist"],
            LimbKind::Leg => ["hip", "knee", "ankle"],
        };
        for (bone, link) in bones.into_iter().zip(limb.links()) {
            found.push((format!("{bone}_{side}"), link));
        }
        let above = s.links()[limb.upper].parent;
        if let (LimbKind::Arm, Some(link)) = (limb.kind, above)
            && character.classes[link] == JointClass::Clavicle
        {
            found.push((format!("clavicle_{side}"), link));
        }
    }
    // a spine of any number of links: its first and its last; the same of the neck
    for (class, low, high) in [(JointClass::Spine, "abdomen", "chest"), (JointClass::Neck, "neck", "head")] {
        let links: Vec<usize> = (0..s.links().len()).filter(|&l| character.classes[l] == class).collect();
        if let (Some(&first), Some(&last)) = (links.first(), links.last()) {
            found.push((high.into(), last));
            if first != last {
                found.push((low.into(), first));
            }
        }
    }
    let names = found.into_iter().map(|(bone, link)| (bone, s.links()[link].name.clone()));
    names.filter(|(bone, link)| bone != link && s.link(bone).is_none()).collect()
}
