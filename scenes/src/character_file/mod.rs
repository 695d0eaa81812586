//! Characters as RON.
//!
//! In: a `.ron` file in metres, kilograms and degrees. Out: a checked [`Character`](bodies::Character), or a
//! [`SceneError`](crate::SceneError) at the very value that is wrong. [`write()`] is the inverse, to the digits written.
//!
//! Links may stand in any order and name their parents; inertia is `(xx, yy, zz, xy, xz, yz)` about
//! the centre of mass along the link's axes, or all three follow from `density_kg_m3` and the shapes; rotations are Euler angles `(x, y, z)`, see
//! [`angle`](crate::angle).

mod read;
mod read_link;
mod schema;
mod write;

pub use read::{CharacterFile, parse, parse_file, read, read_file};
pub use write::write;

/// The text of `characters/human.ron`.
pub fn human_text() -> String {
    let (character, _) = bodies::anthropometry::human::human();
    let comment = "\
The standard figure: 1.75 m, 75 kg, 19 links, 52 degrees of freedom.

Zero pose: upright, facing +Z, arms straight out sideways, palms down, soles flat on height 0 when
the pelvis is at 0.9275 m; every zero frame is parallel to the world (+X is the figure's left, +Y up).
A link is named after its joint. Positive degrees bend elbows and knees.
Masses, centres and inertias: de Leva 1996, Table 4 (men). Lengths: Drillis & Contini 1966. Limits:
Boone & Azen 1979, AAOS 1965, Inman 1944, widened for dance; swing about two axes, twist about the bone.

Made by: cargo run --release -p scenes --example make_human
The rules are in bodies/src/anthropometry: change them there, not here.";
    write(&character, comment)
}
