//! A small body and a small dance to try edits on. T-pose at zero, palms down, facing +Z.

use std::collections::BTreeMap;
use std::sync::Arc;

use edits::{EditLog, Selector, TrackEdit};
use motion::rotation::exp;
use motion::script::{Action, Cycle, Insert, Pose, PoseValue, Properties, Script};
use motion::skeleton::BallLimits;
use motion::{
    Curve, Dof, Element, Joint, Label, Limb, LimbKind, Limits, Link, Quat, Range, Skeleton, Tracks, Value,
    Vec3,
};

/// Pelvis, two spine joints, neck, clavicles, arms with hinge elbows, welded fingers, legs.
pub fn skeleton() -> Arc<Skeleton> {
    let v = Vec3::new;
    let ball = Joint::Spherical;
    let mut links = vec![
        Link::new("pelvis", None, v(0.0, 0.0, 0.0), Joint::Free),
        Link::new("spine1", Some(0), v(0.0, 0.1, -0.02), ball),
        Link::new("spine2", Some(1), v(0.0, 0.2, 0.01), ball),
        Link::new("neck", Some(2), v(0.0, 0.28, 0.02), ball),
    ];
    for (side, x) in [("l", 1.0), ("r", -1.0)] {
        let n = |name: &str| format!("{name}_{side}");
        let at = links.len();
        links.push(Link::new(n("clavicle"), Some(2), v(0.03 * x, 0.22, 0.0), ball));
        let mut shoulder = Link::new(n("shoulder"), Some(at), v(0.14 * x, 0.0, -0.01), ball);
        let ranges = [Range::new(-1.7, 1.7), Range::new(-2.0, 2.0), Range::new(-1.5, 1.5)];
        shoulder.limits = Some(Limits::Ball(BallLimits { axes: [Vec3::z(), Vec3::y(), Vec3::x()], ranges }));
        links.push(shoulder);
        let mut elbow =
            Link::new(n("elbow"), Some(at + 1), v(0.3 * x, 0.0, 0.0), Joint::Revolute(v(0.0, -x, 0.0)));
        elbow.limits = Some(Limits::Axis(Range::new(0.0, 2.5)));
        links.push(elbow);
        links.push(Link::new(n("wrist"), Some(at + 2), v(0.26 * x, 0.0, 0.0), ball));
        links.push(Link::new(n("fingers"), Some(at + 3), v(0.09 * x, 0.0, 0.0), Joint::Fixed));
    }
    for (side, x) in [("l", 1.0), ("r", -1.0)] {
        let n = |name: &str| format!("{name}_{side}");
        let at = links.len();
        links.push(Link::new(n("hip"), Some(0), v(0.09 * x, -0.05, 0.0), ball));
        links.push(Link::new(n("knee"), Some(at), v(0.0, -0.42, 0.0), Joint::Revolute(Vec3::x())));
        links.push(Link::new(n("ankle"), Some(at + 1), v(0.0, -0.41, 0.0), ball));
    }
    let find = |name: &str| links.iter().position(|l| l.name == name).unwrap();
    let mut limbs = Vec::new();
    for side in ["l", "r"] {
        for (name, kind, [a, b, c]) in [
            ("arm", LimbKind::Arm, ["shoulder", "elbow", "wrist"]),
            ("leg", LimbKind::Leg, ["hip", "knee", "ankle"]),
        ] {
            let at = |j: &str| find(&format!("{j}_{side}"));
            limbs.push(Limb { name: format!("{name}_{side}"), kind, upper: at(a), lower: at(b), end: at(c) });
        }
    }
    let trunk = BTreeMap::from([("trunk".to_string(), vec![find("spine1"), find("spine2")])]);
    let s = Skeleton::new(links).unwrap().with_limbs(limbs).unwrap().with_parts(trunk).unwrap();
    Arc::new(s)
}

/// Standing, arms a little out, elbows a little bent.
pub fn base(s: &Skeleton) -> Vec<f64> {
    let mut q = s.zero_pose();
    s.set_position(&mut q, 0, &Vec3::new(0.1, 0.95, -0.05));
    for (name, r) in
        [("shoulder_l", [0.1, 0.0, -1.2]), ("shoulder_r", [0.1, 0.0, 1.2]), ("spine1", [0.05, 0.0, 0.0])]
    {
        s.set_rotation(&mut q, s.link(name).unwrap(), &exp(&Vec3::from(r)));
    }
    for name in ["elbow_l", "elbow_r"] {
        q[s.q_at(s.link(name).unwrap())] = 0.3;
    }
    q
}

pub fn turn(x: f64, y: f64, z: f64) -> Quat {
    exp(&Vec3::new(x, y, z))
}

pub fn ball(name: &str, x: f64, y: f64, z: f64) -> PoseValue {
    PoseValue::rotation(name, turn(x, y, z))
}

pub fn hinge(name: &str, angle: f64) -> PoseValue {
    PoseValue::scalar(name, angle)
}

pub fn pose(duration_s: f64, hold_s: f64, values: Vec<PoseValue>) -> Pose {
    let properties =
        Properties { duration_s: Some(duration_s), hold_s: Some(hold_s), ..Properties::default() };
    Pose { properties, values }
}

pub fn cycle(repetitions: usize, poses: Vec<Pose>) -> Cycle {
    Cycle { repetitions, poses, ..Cycle::default() }
}

pub fn action(name: &str, start_s: f64, cycles: Vec<Cycle>) -> Action {
    Action { name: name.into(), start_s, cycles, ..Action::default() }
}

pub fn build(actions: Vec<Action>) -> Tracks {
    let s = skeleton();
    Script { actions, ..Script::default() }.build(&s, &base(&s)).unwrap()
}

/// A bow with the trunk, three waves of the right arm with a closing pose, and a nod put in directly.
pub fn dance() -> Tracks {
    let s = skeleton();
    let bow = action(
        "bow",
        0.0,
        vec![cycle(
            1,
            vec![
                pose(
                    0.8,
                    0.3,
                    vec![
                        ball("spine1", 0.5, 0.0, 0.0),
                        ball("spine2", 0.4, 0.05, 0.0),
                        ball("shoulder_l", 0.3, -0.2, -0.9),
                        hinge("elbow_l", 0.7),
                        hinge("pelvis_y", 0.93),
                        hinge("knee_l", 0.1),
                    ],
                ),
                pose(
                    0.9,
                    0.1,
                    vec![
                        ball("spine1", -0.05, 0.4, 0.1),
                        ball("spine2", 0.0, 0.3, 0.0),
                        ball("shoulder_l", -0.1, 0.4, 0.2),
                        hinge("elbow_l", 0.2),
                        hinge("pelvis_y", 0.96),
                    ],
                ),
            ],
        )],
    );
    let wave = action(
        "wave",
        0.5,
        vec![
            cycle(
                3,
                vec![
                    pose(0.3, 0.05, vec![ball("shoulder_r", 0.2, 0.5, 0.3), hinge("elbow_r", 1.5)]),
                    pose(0.25, 0.0, vec![ball("shoulder_r", 0.1, 0.3, 0.1), hinge("elbow_r", 0.6)]),
                ],
            ),
            cycle(1, vec![pose(0.5, 0.0, vec![ball("shoulder_r", 0.1, 0.0, 1.2)])]),
        ],
    );
    let inserts = vec![Insert { name: "nod".into(), start_s: 1.0, value: ball("neck", 0.3, 0.1, 0.0) }];
    let properties = Properties { curve: Some(Curve::Overshoot), ..Properties::default() };
    Script { properties, actions: vec![bow, wave], inserts }.build(&s, &base(&s)).unwrap()
}

pub fn apply(edit: &dyn TrackEdit, tracks: &mut Tracks, selector: &Selector) -> EditLog {
    let mut log = EditLog::default();
    let selection = selector.select(tracks).unwrap();
    edit.apply(tracks, &selection, &mut log).unwrap();
    log
}

/// The labels with DOF names, in the order of labels.
pub fn names<'a>(tracks: &Tracks, labels: impl IntoIterator<Item = &'a Label>) -> Vec<String> {
    let mut names: Vec<String> = labels.into_iter().map(|l| l.named(&tracks.skeleton)).collect();
    names.sort();
    names
}

pub fn element<'a>(tracks: &'a Tracks, name: &str) -> &'a Element {
    let found = tracks.elements().find(|(_, e)| e.label.named(&tracks.skeleton) == name);
    found.unwrap_or_else(|| panic!("no element {name}")).1
}

pub fn scalar(value: &Value) -> f64 {
    value.scalar().unwrap()
}

pub fn dof(tracks: &Tracks, name: &str) -> Dof {
    Dof::find(&tracks.skeleton, name).unwrap()
}
