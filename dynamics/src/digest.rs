//! Digests: a number that tells values apart, for what depends on all of them.
//!
//! In: bodies, motions, conditions. Out: FNV-1a (64 bits) of their values, never of how types print.
//!
//! A number is its eight bytes (little endian; −0 counts as 0), a count the same as an integer, a text its length and bytes, an
//! option a count of 0 or 1 before the value, a list its length before the values, a named value its name. Structures are taken
//! apart field by field, so a field that is added does not compile before it has a place here.

use bodies::soles::{Pad, Pads, Toes};
use bodies::{Body, Carried, Character, Prop};
use motion::names::Word;
use motion::{
    BallLimits, Clip, Curve, Floor, Fnv, Joint, Knee, Limb, Limits, Link, Plant, Quat, Range, Shape, Tilt,
    Transform, Vec3,
};

use crate::{Carrying, Push};

/// A running digest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Digest(Fnv);

impl Digest {
    /// Adds bytes.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.0.bytes(bytes);
    }

    /// Adds a number.
    pub fn number(&mut self, x: f64) {
        self.bytes(&(x + 0.0).to_bits().to_le_bytes());
    }

    /// Adds numbers without their count.
    pub fn numbers<'a>(&mut self, numbers: impl IntoIterator<Item = &'a f64>) {
        for &x in numbers {
            self.number(x);
        }
    }

    /// Adds a count or an index.
    pub fn count(&mut self, n: usize) {
        self.bytes(&(n as u64).to_le_bytes());
    }

    /// Adds counts or indices without their number.
    pub fn counts(&mut self, counts: impl IntoIterator<Item = usize>) {
        counts.into_iter().for_each(|n| self.count(n));
    }

    /// Adds a text.
    pub fn text(&mut self, text: &str) {
        self.count(text.len());
        self.bytes(text.as_bytes());
    }

    /// Adds a list: its length, then every value by `add`.
    pub fn list<T>(&mut self, list: &[T], mut add: impl FnMut(&mut Self, &T)) {
        self.count(list.len());
        list.iter().for_each(|x| add(self, x));
    }

    /// Adds a value that may be missing.
    pub fn option<T>(&mut self, value: Option<&T>, add: impl FnMut(&mut Self, &T)) {
        self.list(value.map_or(&[][..], std::slice::from_ref), add);
    }

    /// The number.
    pub fn value(&self) -> u64 {
        self.0.value()
    }

    /// 16 hexadecimal digits.
    pub fn hex(self) -> String {
        format!("{:016x}", self.0.value())
    }
}

/// A motion: rate, numbers per pose, all poses.
pub fn clip(d: &mut Digest, clip: &Clip) {
    d.number(clip.rate_hz);
    d.count(clip.skeleton.nq());
    d.count(clip.frames());
    d.numbers(clip.data());
}

/// A curve of a transition.
pub fn curve(d: &mut Digest, curve: &Curve) {
    d.text(curve.name().word());
    if let Curve::Bezier(x1, y1, x2, y2) = curve {
        d.numbers([x1, y1, x2, y2]);
    }
}

/// A limb that stays where it is.
pub fn plant(d: &mut Digest, plant: &Plant) {
    let Plant { limb: held, world_from_end, knee } = plant;
    limb(d, held);
    transform(d, world_from_end);
    d.count(usize::from(*knee == Knee::Follows));
}

/// A limb.
pub fn limb(d: &mut Digest, limb: &Limb) {
    let Limb { name, kind, upper, lower, end } = limb;
    d.text(name);
    d.text(kind.word());
    d.counts([*upper, *lower, *end]);
}

/// A vector.
pub fn vector(d: &mut Digest, v: &Vec3) {
    d.numbers(v);
}

fn vectors(d: &mut Digest, vectors: [&Vec3; 2]) {
    vectors.into_iter().for_each(|v| vector(d, v));
}

fn rotation(d: &mut Digest, q: &Quat) {
    d.numbers(q.as_vector());
}

/// A place and a turn.
pub fn transform(d: &mut Digest, t: &Transform) {
    vector(d, &t.translation.vector);
    rotation(d, &t.rotation);
}

fn range(d: &mut Digest, r: &Range) {
    let Range { lo, hi } = r;
    d.numbers([lo, hi]);
}

/// A body: links (name, parent, joint, zero frame, limits), classes, mass, shapes, limbs, contact points, rest; not its name.
pub fn character(d: &mut Digest, character: &Character) {
    // the cost does not depend on the name of the body
    let Character { name: _, skeleton, bodies, classes, contacts, rest } = character;
    d.list(skeleton.links(), link);
    d.list(classes, |d, class| d.text(class.word()));
    d.list(bodies, body);
    d.list(skeleton.limbs(), limb);
    d.list(contacts, |d, &contact| {
        let site = &skeleton.sites()[contact];
        d.text(&site.name);
        d.count(site.link);
        vector(d, &site.at);
    });
    d.numbers(rest);
}

fn link(d: &mut Digest, link: &Link) {
    // `end` is only drawn
    let Link { name, parent, parent_from_zero, joint, limits, end: _ } = link;
    d.text(name);
    d.option(parent.as_ref(), |d, parent| d.count(*parent));
    transform(d, parent_from_zero);
    match joint {
        Joint::Free => d.count(0),
        Joint::Spherical => d.count(1),
        Joint::Revolute(axis) => {
            d.count(2);
            vector(d, axis);
        }
        Joint::Prismatic(axis) => {
            d.count(3);
            vector(d, axis);
        }
        Joint::Fixed => d.count(4),
    }
    d.option(limits.as_ref(), |d, limits| match limits {
        Limits::Axis(r) => {
            d.count(0);
            range(d, r);
        }
        Limits::Ball(BallLimits { axes, ranges }) => {
            d.count(1);
            axes.iter().for_each(|axis| vector(d, axis));
            ranges.iter().for_each(|r| range(d, r));
        }
    });
}

fn body(d: &mut Digest, body: &Body) {
    let Body { mass, com, inertia, shapes } = body;
    d.number(*mass);
    vector(d, com);
    d.numbers(inertia);
    d.list(shapes, shape);
}

fn shape(d: &mut Digest, shape: &Shape) {
    match shape {
        Shape::Capsule { a, b, radius } => {
            d.count(0);
            vectors(d, [a, b]);
            d.number(*radius);
        }
        Shape::Box { center, half, rotation: turn } => {
            d.count(1);
            vectors(d, [center, half]);
            rotation(d, turn);
        }
        Shape::Sphere { center, radius } => {
            d.count(2);
            vector(d, center);
            d.number(*radius);
        }
        Shape::Cone { a, b, radius_a, radius_b } => {
            d.count(3);
            vectors(d, [a, b]);
            d.numbers([radius_a, radius_b]);
        }
    }
}

/// A turn of the ground.
pub fn tilt(d: &mut Digest, tilt: &Tilt) {
    let Tilt { start_s, duration_s, tilt, towards, curve: shape } = tilt;
    d.numbers([start_s, duration_s, tilt, towards]);
    curve(d, shape);
}

/// A box or ramp fixed in the world.
pub fn prop(d: &mut Digest, prop: &Prop) {
    let Prop { name, half, place, friction } = prop;
    d.text(name);
    vectors(d, [half, &place.translation.vector]);
    d.numbers(place.rotation.coords.iter());
    d.number(*friction);
}

/// Ground.
pub fn floor(d: &mut Digest, floor: &Floor) {
    let Floor { height_m, friction, up, turns } = floor;
    d.numbers([height_m, friction]);
    vector(d, up);
    d.count(usize::from(*turns));
}

/// A push.
pub fn push(d: &mut Digest, push: &Push) {
    let Push { link, at, force, start_s, duration_s } = push;
    d.count(*link);
    vectors(d, [at, force]);
    d.numbers([start_s, duration_s]);
}

/// A mass carried for a time.
pub fn carrying(d: &mut Digest, carrying: &Carrying) {
    let Carrying { what: Carried { link, mass, at, inertia }, from_s, to_s, known } = carrying;
    d.count(*link);
    d.number(*mass);
    vector(d, at);
    d.numbers(inertia);
    d.numbers([from_s, to_s]);
    d.count(usize::from(*known));
}

/// The pads of soles.
pub fn pads(d: &mut Digest, Pads { heel, ball }: &Pads) {
    for Pad { stiffness_n_m, damping_n_s_m, travel_m, compact_n_m } in [heel, ball] {
        d.numbers([stiffness_n_m, damping_n_s_m, travel_m, compact_n_m]);
    }
}

/// Toes that bend.
pub fn toes(d: &mut Digest, Toes { stiffness_nm_rad, damping_nm_s_rad }: &Toes) {
    d.numbers([stiffness_nm_rad, damping_nm_s_rad]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_fnv() {
        let of = |text: &str| {
            let mut d = Digest::default();
            d.bytes(text.as_bytes());
            d.hex()
        };
        // test vectors of the authors
        assert_eq!(of(""), "cbf29ce484222325");
        assert_eq!(of("foobar"), "85944171f73967e8");
    }

    /// A list and its length, a value and none, a text and its end are told apart.
    #[test]
    fn structure_is_part_of_it() {
        let of = |add: &dyn Fn(&mut Digest)| {
            let mut d = Digest::default();
            add(&mut d);
            d.hex()
        };
        let texts = |a: &str, b: &str| {
            of(&|d| {
                d.text(a);
                d.text(b);
            })
        };
        assert_ne!(texts("ab", "c"), texts("a", "bc"));
        let lists =
            |a: &[f64], b: &[f64]| of(&|d| [a, b].iter().for_each(|l| d.list(l, |d, x| d.number(*x))));
        assert_ne!(lists(&[1.0, 2.0], &[]), lists(&[1.0], &[2.0]));
        let option = |x: Option<f64>| of(&|d| d.option(x.as_ref(), |d, x| d.number(*x)));
        assert_ne!(option(None), option(Some(0.0)));
        assert_eq!(option(Some(-0.0)), option(Some(0.0)));
    }
}
