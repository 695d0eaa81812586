//! What names the input of a tuning: a digest of all values that its cost depends on.
//!
//! In: a [`Take`] and a [`TuneSpec`]. Out: 16 hexadecimal digits. Samples on disk carry it: a search goes on, and tables are
//! merged, only where it is the same.
//!
//! It is a digest of values, never of how types print: renaming a type or a field leaves it as it is. The order:
//!
//! 1. the motion: rate, numbers per pose, all poses;
//! 2. the elements behind it, where it has any: length, base pose and tensions, then by track and element the degree of freedom,
//!    start, duration, hold, end, curve, tension;
//! 3. the plants: limb and place;
//! 4. the body: links (name, parent, joint, zero frame, limits, class, mass, centre, inertia, shapes), limbs, contact points, rest;
//! 5. the conditions: numbers of the dynamic pass, balance, turns of the ground, pushes, carried masses, gazes, engine, foresight;
//! 6. the tuning: names of the parameters, weights, pushes, times, rate, substeps, own run.
//!
//! How values become bytes: [`dynamics::digest`].

use controllers::Reactive;
use dynamics::RootMode;
use dynamics::digest::{
    Digest, carrying, character, clip, curve, floor, pads, plant, prop, push, tilt, toes as toe_springs,
    vector,
};
use motion::names::Word;
use motion::{Dof, Element, Tracks, Value};
use scenes::conditions::{Physics, SoleKind, ToesKind};
use sim::foresight::{self, Foreseen};
use takes::{Conditions, Take};

use super::{FixedPush, TuneSpec};

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
    d.list(tilts, tilt);
    d.list(props, prop);
    d.count(usize::from(*self_collision));
    d.list(pushes, push);
    d.list(carried, carrying);
    d.list(gazes, |d, gaze| gaze.identify(d));
    d.list(programs, |d, reaction| reaction.identify(d));
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
        stand_m,
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
        stand_m,
        impact,
        soft,
        offset,
        change,
    ]);
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
        SoleKind::Pads(of) => {
            d.count(1);
            pads(d, of);
        }
    });
    d.option(toes.as_ref(), |d, toes| match toes {
        ToesKind::Welded => d.count(0),
        ToesKind::Bend(of) => {
            d.count(1);
            toe_springs(d, of);
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
    d.option(ground.as_ref(), floor);
    settings.identify(d);
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
