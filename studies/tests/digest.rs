//! The digest that names the input of a tuning: equal for equal inputs, another for every value that is changed.

use std::collections::BTreeMap;
use std::sync::Arc;

use bodies::Character;
use motion::{Curve, Joint, LimbKind, Limits, Link, Shape, Skeleton, Value, Vec3};
use scenes::TuneSpec;
use studies::tune::digest;
use takes::{Ask, Input, Take, open};

/// A scene with something of everything: elements, plants, a push, a carried mass, a gaze.
fn take() -> Take {
    let ron = r#"Scene(
        character: "characters/human.ron", rate_hz: 30, root: Free, settle_s: 0.2,
        physics: (rate_hz: 240, substeps: 2),
        balance: (ankle_stiffness: 1.1),
        script: [Action(name: "nod", cycles: [Cycle(poses: [
            Pose(duration_s: 0.3, hold_s: 0.1, set_deg: {"elbow_r": 20, "neck": (10, 0, 0)}),
        ])])],
        pushes: [Push(link: "chest", impulse_ns: 5, towards_deg: 90, start_s: 0.3)],
        carried: [Carried(link: "wrist_r", mass_kg: 1)],
        reactive: [Gaze(at_m: (0, 1.5, 3)), Program(file: "programs/tremor.rhai", params: {"seed": 5})],
    )"#;
    let base = support::root().join("scenes");
    open(Input::Text { ron: ron.into(), base }, &Ask::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// The character with its links changed.
fn with_links(c: &Character, change: impl Fn(&mut Vec<Link>)) -> Arc<Skeleton> {
    let s = &c.skeleton;
    let mut links = s.links().to_vec();
    change(&mut links);
    let turned = Skeleton::new(links)
        .and_then(|x| x.with_sites(s.sites().to_vec()))
        .and_then(|x| x.with_limbs(s.limbs().to_vec()))
        .and_then(|x| x.with_parts(s.parts().clone()));
    Arc::new(turned.unwrap())
}

fn body(t: &mut Take) -> &mut Character {
    Arc::make_mut(&mut t.body.character)
}

fn link(t: &mut Take, change: impl Fn(&mut Link)) {
    let c = body(t);
    let elbow = c.skeleton.link("elbow_r").unwrap();
    c.skeleton = with_links(c, |links| change(&mut links[elbow]));
}

fn element(t: &mut Take) -> &mut motion::Element {
    let tracks = &mut t.asked.tracks.as_mut().unwrap().tracks;
    let track = tracks.iter_mut().find(|t| !t.elements.is_empty()).unwrap();
    &mut track.elements[0]
}

type Change = fn(&mut Take, &mut TuneSpec);

/// One change each: what it is of, and how it is made.
const CHANGES: &[(&str, Change)] = &[
    ("frame", |t, _| {
        let clip = &t.asked.clip;
        let mut q = clip.data().to_vec();
        q[100] += 1e-12;
        t.asked.clip = motion::Clip::new(clip.skeleton.clone(), clip.rate_hz, q);
    }),
    ("frame rate", |t, _| t.asked.clip.rate_hz += 1.0),
    ("length of the elements", |t, _| t.asked.tracks.as_mut().unwrap().duration_s += 0.1),
    ("base pose", |t, _| t.asked.tracks.as_mut().unwrap().base[3] += 0.1),
    ("base tension", |t, _| t.asked.tracks.as_mut().unwrap().base_tension[3] += 0.1),
    ("no elements", |t, _| t.asked.tracks = None),
    ("start", |t, _| element(t).start_s += 0.01),
    ("duration", |t, _| element(t).duration_s += 0.01),
    ("hold", |t, _| element(t).hold_s += 0.01),
    ("end", |t, _| {
        let end = &mut element(t).end;
        *end = match *end {
            Value::Scalar(x) => Value::Scalar(x + 0.01),
            Value::Rotation(q) => Value::Rotation(q.inverse()),
        };
    }),
    ("curve", |t, _| element(t).curve = Curve::Linear),
    ("handle", |t, _| element(t).curve = Curve::Bezier(0.1, 0.2, 0.3, 0.4)),
    ("another handle", |t, _| element(t).curve = Curve::Bezier(0.1, 0.2, 0.3, 0.5)),
    ("element's tension", |t, _| element(t).tension += 0.1),
    ("place of a plant", |t, _| t.asked.plants[0].world_from_end.translation.x += 0.01),
    ("turn of a plant", |t, _| {
        let turn = &mut t.asked.plants[0].world_from_end.rotation;
        *turn *= motion::Quat::from_euler_angles(0.1, 0.0, 0.0);
    }),
    ("limb of a plant", |t, _| t.asked.plants[0].limb.lower += 1),
    ("one plant less", |t, _| {
        t.asked.plants.pop();
    }),
    ("name of a link", |t, _| link(t, |l| l.name = "elbow".into())),
    ("offset", |t, _| link(t, |l| l.parent_from_zero.translation.y += 0.01)),
    ("axis", |t, _| link(t, |l| l.joint = Joint::Revolute(Vec3::x()))),
    ("slide", |t, _| link(t, |l| l.joint = Joint::Prismatic(Vec3::x()))),
    ("limits", |t, _| {
        link(t, |l| match &mut l.limits {
            Some(Limits::Axis(r)) => r.hi += 0.1,
            _ => panic!("an elbow has limits"),
        });
    }),
    ("no limits", |t, _| link(t, |l| l.limits = None)),
    ("limits of a ball", |t, _| {
        let c = body(t);
        c.skeleton = with_links(c, |links| {
            let ball = links.iter_mut().find_map(|l| match &mut l.limits {
                Some(Limits::Ball(b)) => Some(b),
                _ => None,
            });
            ball.unwrap().ranges[2].lo -= 0.01;
        });
    }),
    ("limb", |t, _| {
        let c = body(t);
        let mut limbs = c.skeleton.limbs().to_vec();
        limbs[0].kind = if limbs[0].kind == LimbKind::Arm { LimbKind::Leg } else { LimbKind::Arm };
        c.skeleton = Arc::new((*c.skeleton).clone().with_limbs(limbs).unwrap());
    }),
    ("class", |t, _| body(t).classes[1] = bodies::JointClass::Other),
    ("mass", |t, _| body(t).bodies[2].mass += 0.01),
    ("centre", |t, _| body(t).bodies[2].com.z += 0.01),
    ("inertia", |t, _| body(t).bodies[2].inertia[(0, 1)] += 0.001),
    ("shape", |t, _| {
        let radius = body(t).bodies.iter_mut().flat_map(|b| &mut b.shapes).find_map(|s| match s {
            Shape::Capsule { radius, .. } => Some(radius),
            _ => None,
        });
        *radius.unwrap() += 0.001;
    }),
    ("one shape less", |t, _| {
        body(t).bodies.iter_mut().find_map(|b| b.shapes.pop());
    }),
    ("contact point", |t, _| {
        let c = body(t);
        let mut sites = c.skeleton.sites().to_vec();
        sites[c.contacts[0]].at.x += 0.001;
        c.skeleton = Arc::new((*c.skeleton).clone().with_sites(sites).unwrap());
    }),
    ("one contact point less", |t, _| {
        body(t).contacts.pop();
    }),
    ("rest", |t, _| body(t).rest[10] += 0.1),
    ("control rate", |t, _| t.conditions.physics.rate_hz = Some(241.0)),
    ("no control rate", |t, _| t.conditions.physics.rate_hz = None),
    ("substeps", |t, _| t.conditions.physics.substeps = Some(3)),
    ("tension", |t, _| t.conditions.physics.tension += 0.1),
    ("blend", |t, _| t.conditions.physics.blend = controllers::GainBlend::Gains),
    ("pinned", |t, _| t.conditions.physics.root = dynamics::RootMode::Pinned),
    ("assisted", |t, _| {
        t.conditions.physics.root = dynamics::RootMode::Assisted { force_n: 1.0, moment_nm: 2.0 }
    }),
    ("budget", |t, _| {
        t.conditions.physics.root = dynamics::RootMode::Assisted { force_n: 1.0, moment_nm: 3.0 }
    }),
    ("gravity", |t, _| t.conditions.physics.gravity.y -= 0.01),
    ("no ground", |t, _| t.conditions.physics.ground = None),
    ("friction", |t, _| t.conditions.physics.ground.as_mut().unwrap().friction += 0.1),
    ("height", |t, _| t.conditions.physics.ground.as_mut().unwrap().height_m += 0.1),
    ("slope", |t, _| t.conditions.physics.ground.as_mut().unwrap().up.x += 0.1),
    ("a strategy", |t, _| t.conditions.physics.balance.hip = false),
    ("another strategy", |t, _| t.conditions.physics.balance.ankle = false),
    ("ankle stiffness", |t, _| t.conditions.physics.balance.ankle_stiffness = Some(1.2)),
    ("push", |t, _| t.conditions.pushes[0].force.x += 0.1),
    ("point of a push", |t, _| t.conditions.pushes[0].at.x += 0.1),
    ("link of a push", |t, _| t.conditions.pushes[0].link += 1),
    ("start of a push", |t, _| t.conditions.pushes[0].start_s += 0.1),
    ("length of a push", |t, _| t.conditions.pushes[0].duration_s += 0.1),
    ("no push", |t, _| t.conditions.pushes.clear()),
    ("tilt", |t, _| {
        let tilt =
            motion::Tilt { start_s: 0.0, duration_s: 1.0, tilt: 0.1, towards: 0.0, curve: Curve::Linear };
        t.conditions.tilts.push(tilt);
    }),
    ("carried mass", |t, _| t.conditions.carried[0].what.mass += 0.1),
    ("carried inertia", |t, _| t.conditions.carried[0].what.inertia[(2, 2)] += 0.1),
    ("carried until", |t, _| t.conditions.carried[0].to_s = 0.5),
    ("carried unknown", |t, _| t.conditions.carried[0].known = false),
    ("gaze", |t, _| {
        let g = t.conditions.gazes[0].clone().during(0.1, f64::INFINITY);
        t.conditions.gazes[0] = g;
    }),
    ("time of a program", |t, _| t.conditions.programs[0] = t.conditions.programs[0].shifted(0.1)),
    ("no program", |t, _| t.conditions.programs.clear()),
    ("engine", |t, _| t.conditions.engine = Some("mujoco".into())),
    ("parameters", |_, s| {
        s.parameters.pop();
    }),
    ("weight", |_, s| s.weights[2] += 0.01),
    ("direction", |_, s| s.pushes[1].deg += 1.0),
    ("impulse", |_, s| s.pushes[1].of_limit += 0.01),
    ("one push less", |_, s| {
        s.pushes.pop();
    }),
    ("when pushed", |_, s| s.push_at_s += 0.1),
    ("how long watched", |_, s| s.after_s += 0.1),
    ("rate of runs", |_, s| s.rate_hz = Some(120.0)),
    ("substeps of runs", |_, s| s.substeps = Some(2)),
    ("own run", |_, s| s.own_run = !s.own_run),
];

/// All digests differ, from the first and from one another. So do those of every number of tension and balance.
#[test]
fn every_change_changes_it() {
    let (first, spec) = (take(), TuneSpec::default());
    let mut seen = BTreeMap::from([(digest(&first, &spec), "nothing".to_owned())]);
    let mut add = |name: String, take: &Take, spec: &TuneSpec| {
        if let Some(other) = seen.insert(digest(take, spec), name.clone()) {
            panic!("`{name}` and `{other}` have one digest");
        }
    };
    for (name, change) in CHANGES {
        let (mut take, mut spec) = (first.clone(), spec.clone());
        change(&mut take, &mut spec);
        add((*name).into(), &take, &spec);
    }
    for p in controllers::PARAMETERS.iter().filter(|p| p.name != "tension") {
        let mut t = first.tunable();
        p.set(&mut t, p.at(0.123));
        add(p.name.into(), &first.with_tunable(&t), &spec);
    }
}

/// Equal inputs have one digest: read twice, copied, under another name, with other figures.
#[test]
fn equal_inputs_have_one() {
    let (first, spec) = (take(), TuneSpec::default());
    let of = digest(&first, &spec);
    assert_eq!(digest(&take(), &spec.clone()), of);
    let mut other = first.clone();
    (other.name, other.strip.figures) = ("another".into(), 3);
    body(&mut other).name = "another".into();
    assert_eq!(digest(&other, &spec), of);
    assert_eq!(of.len(), 16);
}
