//! What stands in a prop before anything has moved: no engine can begin there, it throws the body out.
//!
//! In: a body, a pose, props. Out: the deepest overlap, by parry's contact of two solids.

use bodies::{Character, Prop};
use motion::{Kinematics, Transform};
use parry3d::query::contact;

use super::shapes::{Obstacle, Solid, pose};

/// A link that stands in a prop.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlap {
    /// The link's name.
    pub link: String,
    /// The prop's name.
    pub prop: String,
    /// How deep, m: the shortest way out.
    pub depth_m: f64,
}

/// The deepest overlap of a body's shapes with props; `None` where nothing overlaps.
///
/// * `q`: its pose
pub fn overlap(character: &Character, q: &[f64], props: &[Prop]) -> Option<Overlap> {
    if props.is_empty() {
        return None;
    }
    let k = Kinematics::new(&character.skeleton, q);
    let props: Vec<Obstacle> = props.iter().map(Obstacle::new).collect();
    let mut deepest: Option<Overlap> = None;
    for (link, body) in character.bodies.iter().enumerate() {
        for shape in &body.shapes {
            let solid = Solid::new(link, shape, &Transform::identity());
            let place = pose(&(k.world[link] * solid.place));
            for p in &props {
                // every pair of a box and a convex solid is supported
                let found = contact(&p.place, &p.solid, &place, solid.solid.as_ref(), 0.0);
                let depth_m = found.ok().flatten().map_or(0.0, |c| -c.dist);
                if depth_m > deepest.as_ref().map_or(0.0, |d| d.depth_m) {
                    let link = character.skeleton.links()[link].name.clone();
                    deepest = Some(Overlap { link, prop: p.prop.name.clone(), depth_m });
                }
            }
        }
    }
    deepest
}
