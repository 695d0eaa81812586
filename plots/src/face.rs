//! A face for heads that are bare: two eyes and a nose, so that where a body looks is seen.
//!
//! In: a character with the site `eyes` on a link that has solids. Out: shapes in that link's frame (m), each with the
//! direction in which it faces. They are drawn only: no mass, no contact. A head that something is welded to (a beak, eyes of
//! its own) has a face already.

use bodies::Character;
use motion::{Joint, Kinematics, Shape, Transform, Vec3};

use crate::solid::hull_points;
use crate::style::{Color, INK};

/// One thing on a face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Feature {
    /// What is drawn.
    pub shape: Shape,
    /// Where it faces, in the head's frame, of length 1: it is seen where the viewer is on that side.
    pub faces: Vec3,
    /// Colour; `None` is the head's, a little darker.
    color: Option<Color>,
}

impl Feature {
    /// Its colour on a head of colour `head`.
    pub fn color(&self, head: Color) -> Color {
        self.color.unwrap_or_else(|| head.mix(INK, NOSE_SHADE))
    }
}

/// The features of a face and the link they are on.
#[derive(Clone, Debug)]
pub(crate) struct Face {
    /// The head.
    pub link: usize,
    /// Eyes, then the nose.
    pub features: [Feature; 3],
}

/// Eyes from the middle of the face, half breadths of the head.
const APART: f64 = 0.42;
/// Radius of an eye and of the nose, half breadths of the head.
const EYE: f64 = 0.2;
const NOSE: f64 = 0.14;
/// How far the nose's tip stands out, and lies under the eyes, half breadths of the head.
const OUT: f64 = 0.36;
const DOWN: f64 = 0.55;
/// How much darker than the head a nose is.
const NOSE_SHADE: f64 = 0.18;
const EYE_COLOR: Color = Color(38, 42, 50);

impl Face {
    /// The face of a character, if it needs one. A body at rest faces +Z, as its gaze does.
    pub fn of(character: &Character) -> Option<Self> {
        let skeleton = &character.skeleton;
        let site = skeleton.site("eyes")?;
        let link = site.link;
        let welded = |l: &motion::Link| l.parent == Some(link) && l.joint == Joint::Fixed;
        let bare = !skeleton
            .links()
            .iter()
            .zip(&character.bodies)
            .any(|(l, body)| welded(l) && !body.shapes.is_empty());
        let shapes = &character.bodies[link].shapes;
        if !bare || shapes.is_empty() {
            return None;
        }
        let rest = Kinematics::new(skeleton, &character.rest);
        let to_link = rest.world[link].rotation.inverse();
        let (left, up, ahead) = (to_link * Vec3::x(), to_link * Vec3::y(), to_link * Vec3::z());
        let own = Transform::identity();
        // of the head's surface, from the point between the eyes
        let reach = |way: &Vec3| {
            let points = shapes.iter().flat_map(|s| hull_points(s, &own));
            points.map(|p| (p - site.at).dot(way)).fold(f64::NEG_INFINITY, f64::max)
        };
        let half = 0.5 * (reach(&left) + reach(&-left));
        let (front, back) = (reach(&ahead), -reach(&-ahead));
        let (middle, depth) = (0.5 * (front + back), 0.5 * (front - back));
        if !(half > 1e-4 && depth > 1e-4) {
            return None;
        }
        let center = site.at + ahead * middle;
        let eye = |side: f64| {
            let (across, along) = (side * APART, (1.0 - APART * APART).sqrt());
            Feature {
                shape: Shape::Sphere {
                    center: center + left * (across * half) + ahead * (along * depth),
                    radius: EYE * half,
                },
                faces: left * across + ahead * along,
                color: Some(EYE_COLOR),
            }
        };
        let nose = Shape::Capsule {
            a: center + ahead * (0.92 * depth) - up * (0.1 * half),
            b: site.at + ahead * (front + (OUT - NOSE) * half) - up * (DOWN * half),
            radius: NOSE * half,
        };
        let nose = Feature { shape: nose, faces: ahead, color: None };
        Some(Self { link, features: [eye(1.0), eye(-1.0), nose] })
    }
}
