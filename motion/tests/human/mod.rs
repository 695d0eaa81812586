//! A human of 31 balls, hung as those of motion capture are: joints without length under the pelvis, three branches at the
//! chest, two at each hand.

use std::sync::Arc;

use motion::rotation::exp;
use motion::{Joint, Link, Skeleton, Vec3};

/// Name, parent, way from it (m), end of a bone without children (m).
type Row = (&'static str, &'static str, [f64; 3], Option<[f64; 3]>);

/// The middle and the left side; what ends in `_l` is mirrored.
const ROWS: [Row; 18] = [
    ("hip_joint_l", "pelvis", [0.0, 0.0, 0.0], None),
    ("hip_l", "hip_joint_l", [0.09, -0.1, 0.04], None),
    ("knee_l", "hip_l", [0.03, -0.4, 0.02], None),
    ("ankle_l", "knee_l", [0.0, -0.42, -0.03], None),
    ("toe_l", "ankle_l", [0.01, -0.04, 0.12], Some([0.0, 0.0, 0.06])),
    ("lower_back", "pelvis", [0.0, 0.0, 0.0], None),
    ("spine", "lower_back", [0.0, 0.12, -0.01], None),
    ("chest", "spine", [0.0, 0.12, 0.0], None),
    ("neck", "chest", [0.0, 0.12, 0.01], None),
    ("upper_neck", "neck", [0.0, 0.09, 0.01], None),
    ("head", "upper_neck", [0.0, 0.09, -0.01], Some([0.0, 0.1, -0.01])),
    ("collar_l", "chest", [0.01, 0.12, 0.01], None),
    ("shoulder_l", "collar_l", [0.18, 0.05, -0.03], None),
    ("elbow_l", "shoulder_l", [0.29, 0.0, 0.0], None),
    ("wrist_l", "elbow_l", [0.21, 0.0, 0.0], None),
    ("fingers_l", "wrist_l", [0.1, 0.0, 0.0], None),
    ("index_l", "fingers_l", [0.03, 0.0, 0.0], Some([0.03, 0.0, 0.0])),
    ("thumb_l", "wrist_l", [0.09, 0.0, 0.02], Some([0.03, 0.0, 0.02])),
];

/// The body: 31 links, the root free.
pub fn skeleton() -> Arc<Skeleton> {
    let mut links = vec![Link::new("pelvis", None, Vec3::zeros(), Joint::Free)];
    for side in ["l", "r"] {
        let named = |name: &str| match name.strip_suffix("_l") {
            Some(stem) => format!("{stem}_{side}"),
            None => name.into(),
        };
        for (name, parent, at, end) in ROWS {
            if side == "r" && !name.ends_with("_l") {
                continue;
            }
            let mirrored = |v: [f64; 3]| Vec3::new(if side == "r" { -v[0] } else { v[0] }, v[1], v[2]);
            let parent = links.iter().position(|l| l.name == named(parent));
            let mut link = Link::new(named(name), parent, mirrored(at), Joint::Spherical);
            link.end = end.map(mirrored);
            links.push(link);
        }
    }
    Arc::new(Skeleton::new(links).unwrap())
}

/// Standing: arms hang, elbows and knees a little bent, as motion capture has them; every joint a little turned.
pub fn standing(s: &Skeleton) -> Vec<f64> {
    let mut q = s.zero_pose();
    s.set_position(&mut q, 0, &Vec3::new(0.1, 0.98, -0.2));
    let turns: [(&str, [f64; 3]); 8] = [
        ("hip", [-0.15, 0.1, 0.02]),
        ("knee", [0.3, 0.0, 0.0]),
        ("ankle", [-0.15, 0.0, 0.0]),
        ("shoulder", [0.2, -0.1, -1.3]),
        ("elbow", [0.1, -0.3, -0.05]),
        ("wrist", [0.3, 0.05, -0.1]),
        ("spine", [0.05, 0.0, 0.02]),
        ("head", [0.1, 0.1, 0.0]),
    ];
    for (i, link) in s.links().iter().enumerate().skip(1) {
        let x = i as f64;
        let mut r = exp(&(Vec3::new((1.3 * x).sin(), (2.1 * x).sin(), (0.7 * x).cos()) * 0.03));
        if let Some((_, turn)) = turns.iter().find(|(stem, _)| link.name.starts_with(stem)) {
            let sign = if link.name.ends_with("_r") { -1.0 } else { 1.0 };
            r = exp(&Vec3::new(turn[0], sign * turn[1], sign * turn[2])) * r;
        }
        s.set_rotation(&mut q, i, &r);
    }
    q
}
