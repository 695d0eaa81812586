//! Faces of bare heads.

use std::sync::Arc;

use bodies::{Body, Character, JointClass};
use motion::rotation::exp;
use motion::{Clip, Joint, Link, Shape, Site, Vec3};
use nalgebra::Matrix3;
use plots::figure::Mark;
use plots::solid::BANDS;
use plots::style::Color;
use plots::{Figure, StripOptions, StripRow, View, film_strip_with};

use super::{around, middle};
use crate::sample;

/// Marks of a round solid: its contour and its bands.
const ROUND: usize = 1 + BANDS;

/// The sample body with a point between its eyes.
fn looking(character: &Character) -> Arc<Character> {
    let skeleton = (*character.skeleton).clone();
    let mut sites = skeleton.sites().to_vec();
    let link = skeleton.link("head").unwrap();
    sites.push(Site { name: "eyes".into(), link, at: Vec3::new(0.0, 0.11, 0.1) });
    let skeleton = Arc::new(skeleton.with_sites(sites).unwrap());
    Arc::new(Character { skeleton, ..character.clone() }.check().unwrap())
}

/// A strip of one figure at rest, its head turned to its left, deg, seen from `view`, deg.
fn strip(character: &Character, turn: f64, view: f64) -> Vec<Mark> {
    let skeleton = &character.skeleton;
    let mut q = character.rest.clone();
    let turned = exp(&Vec3::new(0.0, turn.to_radians(), 0.0));
    skeleton.set_rotation(&mut q, skeleton.link("head").unwrap(), &turned);
    let clip = Clip::new(skeleton.clone(), 30.0, q);
    let options = StripOptions { count: 1, view: View::degrees(view).unwrap(), ..StripOptions::default() };
    film_strip_with(&[StripRow::new("head", &clip)], character, "", &options).marks
}

/// A face as it is drawn.
struct Seen {
    /// Its parts in the order in which they are drawn, [`ROUND`] marks each.
    parts: Vec<Vec<Mark>>,
    /// Middle of the head, px, and half its breadth without its contour.
    head: [f64; 2],
    half: f64,
    /// Left, top, right and bottom of the head.
    around: [f64; 4],
    /// Whether each part is drawn over the head.
    over: Vec<bool>,
}

impl Seen {
    /// Middle of a part, half breadths of the head: to the viewer's right, and up.
    fn at(&self, part: usize) -> [f64; 2] {
        let [x, y] = middle(&self.parts[part]);
        [(x - self.head[0]) / self.half, (self.head[1] - y) / self.half]
    }

    fn inside(&self, part: usize) -> bool {
        let [left, top, right, bottom] = around(&self.parts[part]);
        let head = self.around;
        left > head[0] && top > head[1] && right < head[2] && bottom < head[3]
    }
}

/// The marks that a strip has more with a site `eyes` than without.
fn face(turn: f64, view: f64) -> Seen {
    let bare = sample::human();
    let (plain, faced) = (strip(&bare, turn, view), strip(&looking(&bare), turn, view));
    let (more, same): (Vec<(usize, &Mark)>, Vec<_>) =
        faced.iter().enumerate().partition(|(_, m)| !plain.contains(m));
    assert!(same.iter().map(|m| m.1).eq(&plain), "a face changes nothing but itself");
    // of what is round the head's contour reaches highest
    let round = |m: &&Mark| matches!(m, Mark::Fill { points, .. } if points.len() > 8);
    let top = |m: &Mark| Figure::bounds(m)[1];
    let head = plain.iter().filter(round).min_by(|a, b| top(a).total_cmp(&top(b))).unwrap();
    let at = faced.iter().position(|m| m == head).unwrap();
    let bounds = Figure::bounds(head);
    let parts: Vec<&[(usize, &Mark)]> = more.chunks(ROUND).collect();
    assert_eq!(more.len() % ROUND, 0, "{} marks", more.len());
    Seen {
        over: parts.iter().map(|p| p[0].0 > at).collect(),
        parts: parts.iter().map(|p| p.iter().map(|m| m.1.clone()).collect()).collect(),
        head: middle(std::slice::from_ref(head)),
        half: 0.5 * (bounds[2] - bounds[0]) - 1.6,
        around: bounds,
    }
}

fn brightness(part: &[Mark]) -> u32 {
    let of = |m: &Mark| match m {
        Mark::Fill { color: Color(r, g, b), .. } => u32::from(*r) + u32::from(*g) + u32::from(*b),
        _ => panic!("{m:?}"),
    };
    // the third band has the colour itself
    of(&part[3])
}

/// From the front: two dark eyes, as far left as right, over a nose between them that is as bright as a head.
#[test]
fn a_head_has_eyes_and_a_nose_in_front() {
    let seen = face(0.0, 0.0);
    assert_eq!(seen.over, [true; 3]);
    let [left, right, nose] = [0, 1, 2].map(|i| seen.at(i));
    // half breadths; 0.42 to each side, seen within 1e-14
    assert!((left[0] - 0.42).abs() < 1e-6 && (right[0] + 0.42).abs() < 1e-6, "{left:?} {right:?}");
    assert!((left[1] - right[1]).abs() < 1e-6 && nose[0].abs() < 1e-6, "{left:?} {right:?} {nose:?}");
    assert!(nose[1] < left[1] - 0.2, "{left:?} {nose:?}");
    assert!((0..3).all(|i| seen.inside(i)));
    let bright = [0, 1, 2].map(|i| brightness(&seen.parts[i]));
    assert!(bright[0] < 200 && bright[1] < 200 && bright[2] > 250, "{bright:?}");
}

/// From behind: no eyes, and the nose is under the head, which covers it.
#[test]
fn a_head_has_no_face_behind() {
    for (turn, view) in [(0.0, 180.0), (180.0, 0.0)] {
        let seen = face(turn, view);
        assert_eq!(seen.over, [false], "turned by {turn}°, seen from {view}°");
        assert!(seen.inside(0) && seen.at(0)[0].abs() < 1e-6, "{:?}", seen.at(0));
    }
}

/// From the side: the eye on that side, and a nose that stands out in front, which is left of the viewer who is on its left.
#[test]
fn a_nose_stands_out_in_profile() {
    for (view, ahead) in [(90.0, -1.0), (-90.0, 1.0)] {
        let seen = face(0.0, view);
        assert_eq!(seen.parts.len(), 2, "{view}°");
        assert!(!seen.inside(1) && ahead * seen.at(1)[0] > 0.8, "{view}°: {:?}", seen.at(1));
        assert!(seen.over[0] && ahead * seen.at(0)[0] > 0.6, "{view}°: {:?}", seen.at(0));
    }
}

/// A head that is turned carries its face along, by the sine of the angle, to either side; the far eye goes first.
#[test]
fn a_face_turns_with_its_head() {
    let (ahead, left, right) = (face(0.0, 0.0), face(35.0, 0.0), face(-35.0, 0.0));
    let across = |seen: &Seen| [0, 1, 2].map(|i| seen.at(i)[0]);
    // of the body's left eye, its right eye
    let eye = 0.42_f64.asin().to_degrees();
    for (deg, seen) in [(35.0, &left), (0.0, &ahead), (-35.0, &right)] {
        let [l, r, nose] = across(seen);
        let asked = [deg + eye, deg - eye].map(|x: f64| x.to_radians().sin());
        // a head is 3 % deeper than it is broad, and its middle not on the axis: 0.03 half breadths; seen 0.011
        assert!((l - asked[0]).abs() < 0.03 && (r - asked[1]).abs() < 0.03, "{deg}°: {l} {r} for {asked:?}");
        assert!(nose * deg > 0.5 * deg.abs() || deg == 0.0, "{deg}°: {nose}");
    }
    let (l, r) = (across(&left), across(&right));
    let mirrored = [(l[0], r[1]), (l[1], r[0]), (l[2], r[2])];
    assert!(mirrored.iter().all(|(a, b)| (a + b).abs() < 1e-6), "{l:?} {r:?}");
    // turned by 75° the left eye, at 100°, is gone; the right one, at 50°, is not
    let profile = face(75.0, 0.0);
    assert_eq!(profile.parts.len(), 2);
    assert!((profile.at(0)[0] - (75.0 - eye).to_radians().sin()).abs() < 0.03, "{:?}", profile.at(0));
}

/// A head with a beak has a face already.
#[test]
fn a_head_that_something_is_welded_to_has_no_drawn_face() {
    let bare = sample::human();
    let mut links = bare.skeleton.links().to_vec();
    let head = bare.skeleton.link("head");
    links.push(Link::new("beak", head, Vec3::new(0.0, 0.08, 0.12), Joint::Fixed));
    let mut beaked = (*bare).clone();
    beaked.bodies.push(Body {
        mass: 0.05,
        com: Vec3::zeros(),
        inertia: Matrix3::identity() * 1e-5,
        shapes: vec![Shape::Sphere { center: Vec3::zeros(), radius: 0.02 }],
    });
    beaked.classes.push(JointClass::Other);
    let skeleton = motion::Skeleton::new(links).unwrap();
    let skeleton = skeleton.with_limbs(bare.skeleton.limbs().to_vec()).unwrap();
    beaked.skeleton = Arc::new(skeleton.with_sites(bare.skeleton.sites().to_vec()).unwrap());
    assert_eq!(strip(&beaked, 0.0, 0.0), strip(&looking(&beaked), 0.0, 0.0));
    assert_ne!(strip(&bare, 0.0, 0.0), strip(&looking(&bare), 0.0, 0.0));
}
