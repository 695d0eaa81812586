//! Bodies the laws are tried on: rods on a base, and the figure with all but a few joints welded.

use std::f64::consts::PI;
use std::sync::Arc;

use bodies::{Body, Character, JointClass};
use motion::{Joint, Link, Skeleton, Vec3};
use nalgebra::Matrix3;

/// Mass of a rod, kg.
pub const ROD_MASS: f64 = 2.0;
/// Length of a rod, m.
pub const ROD_LENGTH: f64 = 0.6;

/// A box-shaped rod from its origin to `along · ROD_LENGTH`, three different principal inertias.
fn rod(along: Vec3) -> Body {
    let (l, w, d) = (ROD_LENGTH, 0.10, 0.06);
    let across = [along.x.abs(), along.y.abs(), along.z.abs()];
    // the two thin sides follow the long one in x → y → z order
    let long = (0..3).max_by(|&a, &b| across[a].total_cmp(&across[b])).unwrap();
    let mut size = [0.0; 3];
    (size[long], size[(long + 1) % 3], size[(long + 2) % 3]) = (l, w, d);
    let [x, y, z] = size.map(|s| s * s * ROD_MASS / 12.0);
    Body {
        mass: ROD_MASS,
        com: along * (0.5 * l),
        inertia: Matrix3::from_diagonal(&Vec3::new(y + z, x + z, x + y)),
        shapes: Vec::new(),
    }
}

/// Rods in a row on a base that does not move, each hung on the one before by `joint`.
pub fn rods(count: usize, joint: Joint, along: Vec3) -> Character {
    let mut links = vec![Link::new("base", None, Vec3::y(), Joint::Fixed)];
    let mut bodies =
        vec![Body { mass: 1.0, com: Vec3::zeros(), inertia: Matrix3::identity(), shapes: Vec::new() }];
    for i in 0..count {
        let offset = if i == 0 { Vec3::zeros() } else { along * ROD_LENGTH };
        links.push(Link::new(format!("rod_{i}"), Some(i), offset, joint));
        bodies.push(rod(along));
    }
    character(links, bodies, None)
}

fn character(links: Vec<Link>, bodies: Vec<Body>, rest: Option<Vec<f64>>) -> Character {
    let classes = vec![JointClass::Other; links.len()];
    let skeleton = Arc::new(Skeleton::new(links).unwrap());
    let rest = rest.unwrap_or_else(|| skeleton.zero_pose());
    Character { name: "law".into(), skeleton, bodies, classes, contacts: Vec::new(), rest }.check().unwrap()
}

/// The body `c` with every joint welded at the pose `q`, its root too, except those of `free`.
///
/// Its rest pose is `q`. The joints that stay keep their limits and classes.
pub fn locked(c: &Character, q: &[f64], free: &[usize]) -> Character {
    let mut links = c.skeleton.links().to_vec();
    let mut rest = Vec::new();
    for (i, link) in links.iter_mut().enumerate() {
        if free.contains(&i) {
            let at = c.skeleton.q_at(i);
            rest.extend_from_slice(&q[at..at + link.joint.nq()]);
        } else {
            link.parent_from_zero *= c.skeleton.joint_transform(q, i);
            (link.joint, link.limits) = (Joint::Fixed, None);
        }
    }
    let mut out = character(links, c.bodies.clone(), Some(rest));
    out.classes.clone_from(&c.classes);
    out
}

/// The standard figure.
pub fn human() -> Character {
    bodies::anthropometry::human::human().0
}

/// Poses of the figure within its limits: rest, arms lifted and bent, bent over and twisted.
pub fn poses(c: &Character) -> Vec<(&'static str, Vec<f64>)> {
    let rest = c.rest.clone();
    let s = &c.skeleton;
    let turn = |q: &mut Vec<f64>, name: &str, r: [f64; 3]| {
        let link = s.link(name).unwrap();
        let at = s.q_at(link);
        match s.links()[link].joint {
            Joint::Revolute(_) => q[at] = r[0].to_radians(),
            _ => {
                let r = motion::rotation::exp(&(Vec3::from(r) * (PI / 180.0))) * s.rotation(q, link);
                s.set_rotation(q, link, &r);
            }
        }
    };
    let mut lifted = rest.clone();
    turn(&mut lifted, "shoulder_l", [0.0, 0.0, 50.0]);
    turn(&mut lifted, "shoulder_r", [-50.0, 20.0, 0.0]);
    turn(&mut lifted, "elbow_l", [70.0, 0.0, 0.0]);
    turn(&mut lifted, "elbow_r", [40.0, 0.0, 0.0]);
    turn(&mut lifted, "hip_l", [-40.0, 0.0, 10.0]);
    turn(&mut lifted, "knee_l", [60.0, 0.0, 0.0]);
    let mut bent = rest.clone();
    turn(&mut bent, "abdomen", [20.0, 5.0, 5.0]);
    turn(&mut bent, "chest", [15.0, 0.0, -5.0]);
    turn(&mut bent, "neck", [10.0, 15.0, 0.0]);
    turn(&mut bent, "shoulder_l", [-30.0, 0.0, 30.0]);
    turn(&mut bent, "elbow_r", [100.0, 0.0, 0.0]);
    turn(&mut bent, "hip_r", [-25.0, 0.0, 0.0]);
    let mut all = vec![("rest", rest), ("lifted", lifted), ("bent", bent)];
    for (_, q) in &mut all {
        s.clamp_to_limits(q);
    }
    all
}
