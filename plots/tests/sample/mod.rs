//! A body, two motions and a trace to draw: a capsule figure of 75 kg that bows and then points.
//!
//! Made by formulas, not simulated: the contact forces are those the centre of mass needs
//! (F = m (a − g)), so momentum balances by construction.

use std::f64::consts::PI;
use std::sync::Arc;

use bodies::{Body, Character, JointClass};
use dynamics::{ContactSample, RootMode, Trace};
use motion::rotation::exp;
use motion::{
    BallLimits, Clip, Joint, Kinematics, Limb, LimbKind, Limits, Link, Range, Shape, Site, Skeleton, Vec3,
};
use nalgebra::Matrix3;

const RATE: f64 = 120.0;
const GRAVITY: Vec3 = Vec3::new(0.0, -9.81, 0.0);
const LEG: f64 = 0.84;
const ANKLE: f64 = 0.08;

/// Capsule human, about 1.75 m; zero pose standing with arms down.
pub fn human() -> Arc<Character> {
    let mut links: Vec<Link> = Vec::new();
    let mut bodies = Vec::new();
    let mut classes = Vec::new();
    let mut add = |name: &str,
                   parent: Option<&str>,
                   offset: [f64; 3],
                   joint: Joint,
                   class,
                   mass: f64,
                   shapes: Vec<Shape>| {
        let parent = parent.map(|p| links.iter().position(|l| l.name == p).unwrap());
        let mut link = Link::new(name, parent, offset.into(), joint);
        link.limits = match joint {
            Joint::Revolute(_) => Some(Limits::Axis(Range::new(0.0, 2.5))),
            Joint::Spherical if name.starts_with("arm") || name.starts_with("thigh") => {
                let axes = [Vec3::x(), Vec3::z(), -Vec3::y()];
                let ranges = [Range::new(-2.6, 1.0), Range::new(-1.9, 1.9), Range::new(-1.2, 1.2)];
                Some(Limits::Ball(BallLimits { axes, ranges }))
            }
            _ => None,
        };
        links.push(link);
        let com = match shapes[0] {
            Shape::Capsule { a, b, .. } | Shape::Cone { a, b, .. } => (a + b) * 0.5,
            Shape::Box { center, .. } | Shape::Sphere { center, .. } => center,
        };
        bodies.push(Body { mass, com, inertia: Matrix3::identity() * (0.01 * mass), shapes });
        classes.push(class);
    };
    let bone = |a: [f64; 3], b: [f64; 3], radius| Shape::Capsule { a: a.into(), b: b.into(), radius };
    use JointClass as C;
    let ball = Joint::Spherical;
    add(
        "pelvis",
        None,
        [0.0; 3],
        Joint::Free,
        C::Root,
        9.0,
        vec![bone([0.07, 0.0, 0.0], [-0.07, 0.0, 0.0], 0.115)],
    );
    add(
        "spine",
        Some("pelvis"),
        [0.0, 0.1, 0.0],
        ball,
        C::Spine,
        10.0,
        vec![bone([0.04, 0.07, 0.0], [-0.04, 0.07, 0.0], 0.12)],
    );
    add(
        "chest",
        Some("spine"),
        [0.0, 0.16, 0.0],
        ball,
        C::Spine,
        15.0,
        vec![
            bone([0.07, 0.12, 0.0], [-0.07, 0.12, 0.0], 0.135),
            bone([0.12, 0.2, 0.0], [-0.12, 0.2, 0.0], 0.075),
        ],
    );
    add(
        "neck",
        Some("chest"),
        [0.0, 0.27, 0.0],
        ball,
        C::Neck,
        1.5,
        vec![bone([0.0, 0.0, 0.0], [0.0, 0.07, 0.01], 0.055)],
    );
    add(
        "head",
        Some("neck"),
        [0.0, 0.09, 0.01],
        ball,
        C::Neck,
        4.5,
        vec![bone([0.0, 0.06, 0.015], [0.0, 0.12, 0.01], 0.092)],
    );
    for (s, x) in [("l", 1.0), ("r", -1.0)] {
        let n = |part: &str| format!("{part}_{s}");
        add(
            &n("arm"),
            Some("chest"),
            [0.2 * x, 0.2, 0.0],
            ball,
            C::Shoulder,
            2.1,
            vec![bone([0.0; 3], [0.0, -0.28, 0.0], 0.05)],
        );
        add(
            &n("forearm"),
            Some(&n("arm")),
            [0.0, -0.3, 0.0],
            Joint::Revolute(-Vec3::x()),
            C::Elbow,
            1.2,
            vec![bone([0.0; 3], [0.0, -0.23, 0.0], 0.04)],
        );
        add(
            &n("hand"),
            Some(&n("forearm")),
            [0.0, -0.26, 0.0],
            Joint::Fixed,
            C::Wrist,
            0.45,
            vec![bone([0.0, -0.03, 0.0], [0.0, -0.11, 0.01], 0.035)],
        );
        add(
            &n("thigh"),
            Some("pelvis"),
            [0.095 * x, -0.03, 0.0],
            ball,
            C::Hip,
            8.5,
            vec![bone([0.0, -0.03, 0.0], [0.0, -0.4, 0.0], 0.078)],
        );
        add(
            &n("shin"),
            Some(&n("thigh")),
            [0.0, -0.42, 0.0],
            Joint::Revolute(Vec3::x()),
            C::Knee,
            3.4,
            vec![bone([0.0, -0.02, 0.0], [0.0, -0.38, -0.01], 0.054)],
        );
        add(
            &n("foot"),
            Some(&n("shin")),
            [0.0, -0.42, 0.0],
            ball,
            C::Ankle,
            1.1,
            vec![Shape::Box {
                center: Vec3::new(0.0, -0.045, 0.06),
                half: Vec3::new(0.045, 0.035, 0.125),
                rotation: exp(&Vec3::zeros()),
            }],
        );
    }
    let at = |name: &str| links.iter().position(|l| l.name == name).unwrap();
    let mut limbs = Vec::new();
    let mut sites = Vec::new();
    for s in ["l", "r"] {
        let limb = |kind, name: &str, parts: [&str; 3]| Limb {
            name: format!("{name}_{s}"),
            kind,
            upper: at(&format!("{}_{s}", parts[0])),
            lower: at(&format!("{}_{s}", parts[1])),
            end: at(&format!("{}_{s}", parts[2])),
        };
        limbs.push(limb(LimbKind::Arm, "arm", ["arm", "forearm", "hand"]));
        limbs.push(limb(LimbKind::Leg, "leg", ["thigh", "shin", "foot"]));
        for (i, (x, z)) in
            [(0.045, -0.065), (-0.045, -0.065), (0.045, 0.185), (-0.045, 0.185)].iter().enumerate()
        {
            let link = at(&format!("foot_{s}"));
            sites.push(Site { name: format!("sole_{s}{i}"), link, at: Vec3::new(*x, -ANKLE, *z) });
        }
    }
    let skeleton = Skeleton::new(links).unwrap().with_limbs(limbs).unwrap().with_sites(sites).unwrap();
    let mut rest = skeleton.zero_pose();
    rest[1] = 0.03 + LEG + ANKLE;
    let contacts = (0..8).collect();
    Arc::new(
        Character { name: "human".into(), skeleton: Arc::new(skeleton), bodies, classes, contacts, rest }
            .check()
            .unwrap(),
    )
}

/// Bow, hold, point up to the right, hold; each spine and arm joint starts `offset_s` after the one below.
pub fn bow(character: &Character, offset_s: f64) -> Clip {
    let skeleton = character.skeleton.clone();
    let frames = (4.6 * RATE) as usize + 1;
    let mut data = Vec::new();
    for frame in 0..frames {
        let t = frame as f64 / RATE;
        let smooth = |start: f64, length: f64| {
            let s = ((t - start) / length).clamp(0.0, 1.0);
            s * s * (3.0 - 2.0 * s)
        };
        let bowed = |depth: f64| smooth(0.3 + offset_s * depth, 1.0);
        let risen = |depth: f64| smooth(2.1 + 1.5 * offset_s * depth, 0.9);
        let between = |depth: f64, down: Vec3, up: Vec3| {
            down * (bowed(depth) * (1.0 - risen(depth))) + up * risen(depth)
        };
        let mut q = character.rest.clone();
        let pitch = between(0.0, Vec3::new(0.45, 0.0, 0.0), Vec3::new(-0.03, 0.0, 0.0)).x;
        let lean = between(0.0, Vec3::new(0.13, 0.0, 0.0), Vec3::new(0.0, 0.0, 0.0)).x;
        q[1] = 0.03 * pitch.cos() + LEG * lean.cos() + ANKLE;
        q[2] = -LEG * lean.sin() + 0.03 * pitch.sin();
        let mut set = |name: &str, r: Vec3| {
            let link = skeleton.link(name).unwrap();
            match skeleton.links()[link].joint {
                Joint::Revolute(_) => q[skeleton.q_at(link)] = r.x,
                _ => skeleton.set_rotation(&mut q, link, &exp(&r)),
            }
        };
        set("pelvis", Vec3::new(pitch, 0.0, 0.0));
        set("spine", between(0.0, Vec3::new(0.35, 0.0, 0.0), Vec3::new(-0.08, -0.2, -0.05)));
        set("chest", between(1.0, Vec3::new(0.4, 0.0, 0.0), Vec3::new(-0.12, -0.3, -0.1)));
        set("neck", between(2.0, Vec3::new(0.3, 0.0, 0.0), Vec3::new(-0.1, -0.25, 0.0)));
        set("head", between(3.0, Vec3::new(0.3, 0.0, 0.0), Vec3::new(-0.15, -0.3, 0.0)));
        set("arm_l", between(2.0, Vec3::new(0.2, 0.0, 0.35), Vec3::new(-0.5, 0.0, 0.25)));
        set("forearm_l", between(3.0, Vec3::new(0.3, 0.0, 0.0), Vec3::new(0.9, 0.0, 0.0)));
        set("arm_r", between(2.0, Vec3::new(-0.9, 0.0, 0.2), Vec3::new(-0.6, 0.0, -2.1)));
        set("forearm_r", between(3.0, Vec3::new(1.4, 0.0, 0.0), Vec3::new(0.15, 0.0, 0.0)));
        for s in ["l", "r"] {
            set(&format!("thigh_{s}"), Vec3::new(-pitch - lean, 0.0, 0.0));
            set(&format!("foot_{s}"), Vec3::new(lean, 0.0, 0.0));
        }
        data.extend(q);
    }
    Clip::new(skeleton, RATE, data)
}

/// Strides in place of the origin: a motion that travels, for the follower.
pub fn walk(character: &Character) -> Clip {
    let skeleton = character.skeleton.clone();
    let frames = (2.4 * RATE) as usize + 1;
    let mut data = Vec::new();
    for frame in 0..frames {
        let t = frame as f64 / RATE;
        let phase = 2.0 * PI * t / 1.2;
        let mut q = character.rest.clone();
        q[1] -= 0.03 + 0.015 * (2.0 * phase).cos();
        q[2] = 1.2 * t;
        for (s, sign) in [("l", 1.0), ("r", -1.0)] {
            let swing = sign * phase.sin();
            let bend = (0.15 + 0.45 * (sign * phase.cos()).max(0.0)).max(0.0);
            let mut set = |name: &str, r: Vec3| {
                let link = skeleton.link(&format!("{name}_{s}")).unwrap();
                match skeleton.links()[link].joint {
                    Joint::Revolute(_) => q[skeleton.q_at(link)] = r.x,
                    _ => skeleton.set_rotation(&mut q, link, &exp(&r)),
                }
            };
            set("thigh", Vec3::new(-0.45 * swing - 0.1, 0.0, 0.0));
            set("shin", Vec3::new(bend, 0.0, 0.0));
            set("arm", Vec3::new(0.4 * swing, 0.0, 0.08 * sign));
            set("forearm", Vec3::new(0.4, 0.0, 0.0));
        }
        data.extend(q);
    }
    Clip::new(skeleton, RATE, data)
}

/// A trace of `target` performed with a lag and a little overshoot, on a ground that carries it.
pub fn trace(character: &Arc<Character>, target: &Clip) -> Trace {
    let skeleton = &character.skeleton;
    let (nq, nv, rows) = (skeleton.nq(), skeleton.nv(), target.frames());
    let mass = character.mass();
    let mut t = Trace {
        character: character.clone(),
        rate_hz: RATE,
        substeps: 2,
        root: RootMode::Free,
        ground_m: Some(0.0),
        gravity: GRAVITY,
        q: Vec::new(),
        v: vec![0.0; rows * nv],
        target: target.data().to_vec(),
        torque: Vec::new(),
        stop_torque: vec![0.0; rows * nv],
        k_lo: Vec::new(),
        k_hi: Vec::new(),
        kd: vec![2.0; rows * nv],
        contacts: Vec::new(),
        root_wrench: vec![0.0; rows * 6],
        com: Vec::new(),
        momentum: Vec::new(),
        link_com: Vec::new(),
        disturbed: dynamics::Disturbed::default(),
        energy: vec![0.0; rows * 2],
        plan: motion::ContactPlan::default(),
        colors: Vec::new(),
        wall_s: 0.5,
    };
    let mut pose = vec![0.0; nq];
    let mut kinematics = Kinematics::new(skeleton, &character.rest);
    let mut positions: Vec<Vec3> = Vec::new();
    for row in 0..rows {
        let time = row as f64 / RATE;
        target.sample(time - 0.07 - 0.015 * (time * 9.0).sin(), &mut pose);
        kinematics.update(skeleton, &pose);
        let mut com = Vec3::zeros();
        for (i, body) in character.bodies.iter().enumerate() {
            let at = kinematics.point(i, &body.com);
            t.link_com.extend_from_slice(at.as_slice());
            com += at * (body.mass / mass);
        }
        t.q.extend_from_slice(&pose);
        t.com.extend_from_slice(com.as_slice());
        positions.push(com);
        for dof in 0..nv {
            let wave = ((time * 1.7 + dof as f64).sin() * 0.5 + 0.5) * (6.0 + (dof % 7) as f64 * 5.0);
            t.torque.push(if dof < 6 { 0.0 } else { wave * (0.4 + 0.6 * (time - 1.5).tanh()) });
            t.k_lo.push(if dof < 6 { 0.0 } else { 40.0 + wave });
            t.k_hi.push(if dof < 6 { 0.0 } else { 55.0 - 0.5 * wave });
        }
        let soles: Vec<Vec3> = (character.contacts.iter())
            .map(|&c| kinematics.point(skeleton.sites()[c].link, &skeleton.sites()[c].at))
            .collect();
        let velocity =
            |i: usize| if i == 0 { Vec3::zeros() } else { (positions[i] - positions[i - 1]) * RATE };
        let p = velocity(row) * mass;
        t.momentum.extend([p.x, p.y, p.z, 0.0, 0.0, 0.0]);
        if row > 0 {
            let force = (velocity(row) - velocity(row - 1)) * (mass * RATE) - GRAVITY * mass;
            let mut weights: Vec<f64> = soles
                .iter()
                .map(|s| (-(s - com).component_mul(&Vec3::new(1.0, 0.0, 1.0)).norm_squared() / 0.02).exp())
                .collect();
            let sum: f64 = weights.iter().sum();
            weights.iter_mut().for_each(|w| *w /= sum);
            for (i, &c) in character.contacts.iter().enumerate() {
                let link = skeleton.sites()[c].link;
                t.contacts.push(ContactSample {
                    against: Default::default(),
                    row,
                    link,
                    point: soles[i],
                    force: force * weights[i],
                    depth: 0.001,
                });
            }
        }
    }
    t
}
