//! Parts that follow by dynamics.

use std::sync::Arc;

use bodies::{Body, Character, JointClass};
use motion::{Clip, Joint, Link, Skeleton, Vec3};
use nalgebra::Matrix3;
use retarget::{ContactPoint, Follow, Puppet, Sway, sway};

/// A block with a tail of one link, 0.3 m straight back.
fn puppet(frequency_hz: f64, damping_ratio: f64) -> Puppet {
    let links = vec![
        Link::new("block", None, Vec3::zeros(), Joint::Free),
        Link::new("tail", Some(0), Vec3::new(0.0, 0.0, -0.1), Joint::Spherical),
    ];
    let body = |mass: f64, com: Vec3, i: f64| Body {
        mass,
        com,
        inertia: Matrix3::from_diagonal_element(i),
        shapes: Vec::new(),
    };
    let site = motion::Site { name: "foot".into(), link: 0, at: Vec3::zeros() };
    let skeleton = Skeleton::new(links).unwrap().with_sites(vec![site]).unwrap();
    let rest = skeleton.zero_pose();
    let character = Character {
        name: "block".into(),
        skeleton: Arc::new(skeleton),
        bodies: vec![body(2.0, Vec3::zeros(), 0.01), body(0.1, Vec3::new(0.0, 0.0, -0.15), 1e-4)],
        classes: vec![JointClass::Root, JointClass::Other],
        contacts: vec![0],
        rest,
    }
    .check()
    .unwrap();
    let contact = ContactPoint { site: 0, human: vec!["heel_l".into()], follow: Follow::Any };
    let mut puppet = Puppet::new(character, vec![contact]).unwrap();
    puppet.sways = vec![Sway { links: vec![1], frequency_hz, damping_ratio }];
    puppet
}

/// Where nothing moves, nothing sways: gravity is carried.
#[test]
fn a_still_tail_stays() {
    let p = puppet(1.0, 0.3);
    let clip = Clip::new(p.character.skeleton.clone(), 30.0, p.character.rest.repeat(60));
    let (out, report) = sway(&p, &clip, 9.81);
    assert!(report.most_rad < 1e-12, "{report:?}");
    assert_eq!(out.frames(), 60);
}

/// Set off by a jerk of its body, a tail swings at the frequency it was given.
#[test]
fn it_swings_at_its_frequency() {
    let (frequency, rate) = (3.0, 120.0);
    let p = puppet(frequency, 0.01);
    let mut q = Vec::new();
    for i in 0..480 {
        let mut pose = p.character.rest.clone();
        pose[0] = if i > 10 { 0.02 } else { 0.0 }; // a step to the side
        q.extend(pose);
    }
    let (out, report) = sway(&p, &Clip::new(p.character.skeleton.clone(), rate, q), 9.81);
    let s = &out.skeleton;
    let yaw: Vec<f64> = (0..480).map(|i| motion::rotation::log(&s.rotation(out.pose(i), 1)).y).collect();
    let crossings: Vec<usize> = (60..479).filter(|&i| yaw[i] < 0.0 && yaw[i + 1] >= 0.0).collect();
    let periods = (crossings.len() - 1) as f64;
    let found = periods * rate / (crossings[crossings.len() - 1] - crossings[0]) as f64;
    assert!(report.most_rad > 0.01, "{report:?}");
    assert!((found / frequency - 1.0).abs() < 0.03, "{found}"); // implicit steps are a little slow: 1 % seen
}

/// The body itself goes where it went.
#[test]
fn only_the_tail_moves() {
    let p = puppet(2.0, 0.3);
    let q = (0..60).flat_map(|i| {
        let mut pose = p.character.rest.clone();
        pose[1] = (0.3 * f64::from(i)).sin() * 0.1;
        pose
    });
    let clip = Clip::new(p.character.skeleton.clone(), 30.0, q.collect());
    let (out, report) = sway(&p, &clip, 9.81);
    assert!(report.most_rad > 0.01);
    for i in 0..60 {
        assert_eq!(out.pose(i)[..7], clip.pose(i)[..7]);
    }
    assert_eq!(sway(&p, &clip, 9.81).0, out);
}
