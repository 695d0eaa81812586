//! What names the input of a tuning: a digest of all values that its cost depends on.
//!
//! In: a [`Take`] and a [`TuneSpec`]. Out: 16 hexadecimal digits. Samples on disk carry it: a search goes on, and tables are
//! merged, only where it is the same.
//!
//! It is FNV-1a (64 bits) of values, never of how types print: renaming a type or a field leaves it as it is. The order:
//!
//! 1. the motion: rate, numbers per pose, all poses;
//! 2. the elements behind it, where it has any: length, base pose and tensions, then by track and element the degree of freedom,
//!    start, duration, hold, end, curve, tension;
//! 3. the plants: limb and place;
//! 4. the body: links (name, parent, joint, zero frame, limits, class, mass, centre, inertia, shapes), limbs, contact points, rest;
//! 5. the conditions: numbers of the dynamic pass, balance, turns of the ground, pushes, carried masses, gazes, engine, foresight;
//! 6. the tuning: names of the parameters, weights, pushes, times, rate, substeps, own run.
//!
//! A number is its eight bytes (little endian; −0 counts as 0), a count the same as an integer, a text its length and bytes, an
//! option a count of 0 or 1 before the value, a list its length before the values, a named value its name. Structures are taken
//! apart field by field, so a field that is added does not compile before it has a place here.

use bodies::soles::{Pad, Pads, Toes};
use bodies::{Body, Carried, Character, Prop};
use controllers::{BalanceSettings, Gaze, GazeSettings};
use dynamics::conditions::Carrying;
use dynamics::{Push, RootMode};
use motion::names::Word;
use motion::{
    BallLimits, Clip, Curve, Dof, Element, Floor, Fnv, Joint, Knee, Limb, Limits, Plant, Quat, Range, Shape,
    Tilt, Tracks, Value, Vec3,
};
use motion::{Link, Transform};
use scenes::conditions::{Physics, SoleKind, ToesKind};
use sim::foresight::{self, Foreseen};
use takes::{Conditions, Take};

use super::{FixedPush, TuneSpec};

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

    /// 16 hexadecimal digits.
    pub fn hex(self) -> String {
        format!("{:016x}", self.0.value())
    }
}

/// What names a tuning's input: two runs of the same digest cost alike. See the module header.
pub fn digest(take: &Take, spec: &TuneSpec) -> String {
    let mut d = Digest::default();
    clip(&mut d, &take.asked.clip);
    d.option(take.asked.tracks.as_ref(), tracks);
    d.list(&take.asked.plants, plant);
    character(&mut d, &take.body.character);
    conditions(&mut d, &take.conditions);
    tuning(&mut d, spec);
    d.hex()
}

fn clip(d: &mut Digest, clip: &Clip) {
    d.number(clip.rate_hz);
    d.count(clip.skeleton.nq());
    d.count(clip.frames());
    d.numbers(clip.data());
}

fn tracks(d: &mut Digest, tracks: &Tracks) {
    let Tracks { skeleton: _, base, base_tension, tracks, duration_s } = tracks;
    d.number(*duration_s);
    d.numbers(base);
    d.numbers(base_tension);
    d.list(tracks, |d, track| {
        d.counts(match track.dof {
            Dof::Axis(link) => [0, link, 0],
            Dof::Rotation(link) => [1, link, 0],
            Dof::Coordinate(link, axis) => [2, link, axis],
        });
        d.list(&track.elements, |d, element| {
            // its label says where it stands in the script: no cost depends on that
            let Element { label: _, start_s, duration_s, hold_s, end, curve: shape, tension, timing } =
                element;
            d.numbers([start_s, duration_s, hold_s, tension]);
            match end {
                Value::Scalar(x) => d.numbers([&0.0, x]),
                Value::Rotation(q) => d.numbers(std::iter::once(&1.0).chain(q.as_vector())),
            }
            curve(d, shape);
            d.text(timing.word());
        });
    });
}

fn curve(d: &mut Digest, curve: &Curve) {
    d.text(curve.name().word());
    if let Curve::Bezier(x1, y1, x2, y2) = curve {
        d.numbers([x1, y1, x2, y2]);
    }
}

fn plant(d: &mut Digest, plant: &Plant) {
    let Plant { limb: held, world_from_end, knee } = plant;
    limb(d, held);
    transform(d, world_from_end);
    d.count(usize::from(*knee == Knee::Follows));
}

fn limb(d: &mut Digest, limb: &Limb) {
    let Limb { name, kind, upper, lower, end } = limb;
    d.text(name);
    d.text(kind.word());
    d.counts([*upper, *lower, *end]);
}

fn vector(d: &mut Digest, v: &Vec3) {
    d.numbers(v);
}

fn vectors(d: &mut Digest, vectors: [&Vec3; 2]) {
    vectors.into_iter().for_each(|v| vector(d, v));
}

fn rotation(d: &mut Digest, q: &Quat) {
    d.numbers(q.as_vector());
}

fn transform(d: &mut Digest, t: &Transform) {
    vector(d, &t.translation.vector);
    rotation(d, &t.rotation);
}

fn range(d: &mut Digest, r: &Range) {
    let Range { lo, hi } = r;
    d.numbers([lo, hi]);
}

fn character(d: &mut Digest, character: &Character) {
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

fn conditions(d: &mut Digest, conditions: &Conditions) {
    let Conditions {
        physics: numbers,
        tilts,
        props,
        self_collision,
        pushes,
        carried,
        gazes,
        programs,
        engine: _,
        foresight,
    } = conditions;
    physics(d, numbers);
    d.list(tilts, |d, tilt| {
        let Tilt { start_s, duration_s, tilt, towards, curve: shape } = tilt;
        d.numbers([start_s, duration_s, tilt, towards]);
        curve(d, shape);
    });
    d.list(props, |d, prop| {
        let Prop { name, half, place, friction } = prop;
        d.text(name);
        vectors(d, [half, &place.translation.vector]);
        d.numbers(place.rotation.coords.iter());
        d.number(*friction);
    });
    d.count(usize::from(*self_collision));
    d.list(pushes, |d, push| {
        let Push { link, at, force, start_s, duration_s } = push;
        d.count(*link);
        vectors(d, [at, force]);
        d.numbers([start_s, duration_s]);
    });
    d.list(carried, |d, carrying| {
        let Carrying { what: Carried { link, mass, at, inertia }, from_s, to_s, known } = carrying;
        d.count(*link);
        d.number(*mass);
        vector(d, at);
        d.numbers(inertia);
        d.numbers([from_s, to_s]);
        d.count(usize::from(*known));
    });
    d.list(gazes, gaze);
    d.list(programs, |d, reaction| {
        d.text(reaction.program().text());
        d.number(reaction.begins_s());
        d.list(&reaction.program().parameters(), |d, (name, value)| {
            d.text(name);
            d.text(value);
        });
    });
    d.text(conditions.searcher());
    d.count(usize::from(foresight.is_some()));
    match foresight {
        None => {}
        Some(Foreseen::Search(settings)) => foresight_settings(d, settings),
        Some(Foreseen::Replay(replay)) => {
            d.bytes(&replay.input.to_le_bytes());
            d.numbers(&replay.offsets);
        }
    }
}

fn foresight_settings(d: &mut Digest, settings: &foresight::Settings) {
    let foresight::Settings { horizon_s, rollouts, beam, window_s, stride, effort, width, seed, scales } =
        settings;
    d.numbers([horizon_s, beam, window_s, width]);
    d.count(*rollouts);
    d.count(*stride);
    d.count(usize::from(*effort == sim::core::Effort::Rough));
    d.bytes(&seed.to_le_bytes());
    let foresight::Scales {
        com_m,
        velocity_m_s,
        capture_m,
        spin_nms,
        root_rad,
        pose_rad,
        feet_m,
        impact,
        soft,
        offset,
        change,
    } = scales;
    d.numbers([
        com_m,
        velocity_m_s,
        capture_m,
        spin_nms,
        root_rad,
        pose_rad,
        feet_m,
        impact,
        soft,
        offset,
        change,
    ]);
}

fn gaze(d: &mut Digest, gaze: &Gaze) {
    let GazeSettings { target, from_s, to_s, blend_s, trunk } = gaze.settings();
    vector(d, target);
    d.numbers([from_s, to_s, blend_s, trunk]);
    let links: Vec<usize> = gaze.links().collect();
    d.list(&links, |d, link| d.count(*link));
    let sight = gaze.sight();
    d.count(sight.link);
    vectors(d, [&sight.at, &sight.forward]);
}

fn physics(d: &mut Digest, physics: &Physics) {
    let Physics {
        rate_hz,
        substeps,
        tension,
        blend,
        root,
        gravity,
        ground,
        balance: settings,
        past_fall,
        soles,
        toes,
    } = physics;
    d.count(usize::from(*past_fall));
    d.option(soles.as_ref(), |d, soles| match soles {
        SoleKind::Rigid => d.count(0),
        SoleKind::Pads(Pads { heel, ball }) => {
            d.count(1);
            for Pad { stiffness_n_m, damping_n_s_m, travel_m, compact_n_m } in [heel, ball] {
                d.numbers([stiffness_n_m, damping_n_s_m, travel_m, compact_n_m]);
            }
        }
    });
    d.option(toes.as_ref(), |d, toes| match toes {
        ToesKind::Welded => d.count(0),
        ToesKind::Bend(Toes { stiffness_nm_rad, damping_nm_s_rad }) => {
            d.count(1);
            d.numbers([stiffness_nm_rad, damping_nm_s_rad]);
        }
    });
    d.option(rate_hz.as_ref(), |d, x| d.number(*x));
    d.option(substeps.as_ref(), |d, n| d.count(*n));
    d.number(*tension);
    d.text(blend.word());
    d.text(root.name().word());
    if let RootMode::Assisted { force_n, moment_nm } = root {
        d.numbers([force_n, moment_nm]);
    }
    vector(d, gravity);
    d.option(ground.as_ref(), |d, floor| {
        let Floor { height_m, friction, up, turns } = floor;
        d.numbers([height_m, friction]);
        vector(d, up);
        d.count(usize::from(*turns));
    });
    balance(d, settings);
}

fn balance(d: &mut Digest, settings: &BalanceSettings) {
    let BalanceSettings {
        ankle,
        shift,
        shift_damping,
        shift_rate,
        shift_limit_m,
        pressure,
        pressure_damping,
        margin_m,
        ankle_stiffness,
        weight_shift,
        hip,
        arms,
        wake_from_m_s,
        wake_full_m_s,
        wake_rest_m,
        catch_gain,
        catch_ahead_s,
        catch_margin_m,
        hip_reserve_m,
        hip_gain,
        hip_share,
        hip_moment_nm,
        hip_side_moment_nm,
        hip_stroke_rad,
        hip_brake,
        hip_return_rad_s,
        hip_lag_s,
    } = settings;
    d.counts([ankle, weight_shift, hip, arms].map(|on| usize::from(*on)));
    d.option(ankle_stiffness.as_ref(), |d, x| d.number(*x));
    d.numbers([shift, shift_damping, shift_rate, shift_limit_m, pressure, pressure_damping, margin_m]);
    d.numbers([wake_from_m_s, wake_full_m_s, wake_rest_m, catch_gain, catch_ahead_s, catch_margin_m]);
    d.numbers([hip_reserve_m, hip_gain, hip_share, hip_moment_nm, hip_side_moment_nm, hip_stroke_rad]);
    d.numbers([hip_brake, hip_return_rad_s, hip_lag_s]);
}

fn tuning(d: &mut Digest, spec: &TuneSpec) {
    let TuneSpec { parameters, weights, pushes, push_at_s, after_s, rate_hz, substeps, own_run } = spec;
    d.list(parameters, |d, p| {
        d.text(p.name);
        d.numbers([&p.lo, &p.hi]);
    });
    d.numbers(weights);
    d.list(pushes, |d, FixedPush { deg, of_limit }| d.numbers([deg, of_limit]));
    d.numbers([push_at_s, after_s]);
    d.option(rate_hz.as_ref(), |d, x| d.number(*x));
    d.option(substeps.as_ref(), |d, n| d.count(*n));
    d.count(usize::from(*own_run));
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
