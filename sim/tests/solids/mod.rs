//! Bodies of the tests.

use std::sync::Arc;

use bodies::{Body, Character, JointClass};
use motion::{Link, Skeleton};

/// A character of joints without a class, at rest in its zero pose.
pub fn character(links: Vec<Link>, bodies: Vec<Body>) -> Character {
    let skeleton = Arc::new(Skeleton::new(links).unwrap());
    Character {
        name: "test".into(),
        classes: vec![JointClass::Other; bodies.len()],
        rest: skeleton.zero_pose(),
        skeleton,
        bodies,
        contacts: vec![],
    }
    .check()
    .unwrap()
}
