//! The tree that the links and joints of a URDF make.
//!
//! In: [`Robot`]. Out: a [`ModelFile`], bodies in depth-first order, children in the order of their joints.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::parse::{Robot, RobotJoint, RobotJointKind, RobotLink};
use crate::model_file::{FileBody, FileJoint, FileJointKind, Format, ModelFault, ModelFile, ModelFileError};
use crate::place::Place;
use crate::xml::Attribute;
use motion::Transform;

/// Standard gravity as robot simulators have it, m/s².
const GRAVITY: f64 = 9.81;

/// Builds the tree.
pub fn read(robot: Robot) -> Result<ModelFile, ModelFileError> {
    let fault = |fault, place: &Place| ModelFileError::Model { fault, place: place.clone() };
    let by_name: HashMap<&str, usize> =
        robot.links.iter().enumerate().map(|(i, link)| (link.name.as_str(), i)).collect();
    let find = |joint: &RobotJoint, end: &Attribute| {
        by_name.get(end.value.as_str()).copied().ok_or_else(|| {
            let known = robot.links.iter().map(|l| l.name.clone()).collect();
            let (joint, link) = (joint.name.clone(), end.value.clone());
            fault(ModelFault::UnknownLink { joint, link, known }, &end.place)
        })
    };
    // per link: the joint above it; the joints below it
    let mut above: Vec<Option<usize>> = vec![None; robot.links.len()];
    let mut below: Vec<Vec<usize>> = vec![Vec::new(); robot.links.len()];
    let mut child_of = Vec::new();
    for (j, joint) in robot.joints.iter().enumerate() {
        let (parent, child) = (find(joint, &joint.parent)?, find(joint, &joint.child)?);
        if let Some(first) = above[child] {
            let (link, first) = (joint.child.value.clone(), robot.joints[first].name.clone());
            let second = joint.name.clone();
            return Err(fault(ModelFault::TwoParents { link, first, second }, &joint.child.place));
        }
        above[child] = Some(j);
        below[parent].push(j);
        child_of.push(child);
    }
    let mut roots = (0..robot.links.len()).filter(|&l| above[l].is_none());
    let Some(root) = roots.next() else {
        return Err(match robot.links.first() {
            Some(link) => fault(ModelFault::LinkLoop { link: link.name.clone() }, &link.place),
            None => fault(ModelFault::Missing { element: "robot".into(), needed: "a <link>" }, &robot.place),
        });
    };
    if let Some(second) = roots.next() {
        let names = (robot.links[root].name.clone(), robot.links[second].name.clone());
        let two = ModelFault::TwoRoots { first: names.0, second: names.1 };
        return Err(fault(two, &robot.links[second].place));
    }
    let mut bodies = Vec::new();
    // a stack, not recursion: a chain may be as long as the file
    let mut open: Vec<(usize, Option<(usize, usize)>)> = vec![(root, None)];
    let mut seen = vec![false; robot.links.len()];
    while let Some((link, hung)) = open.pop() {
        seen[link] = true;
        let at = bodies.len();
        bodies.push(body(&robot.links[link], hung.map(|(parent, j)| (parent, &robot.joints[j]))));
        if let Some((parent, j)) = hung
            && robot.joints[j].kind == RobotJointKind::Floating
            && parent != 0
        {
            return Err(fault(ModelFault::FreeJoint, &robot.joints[j].place));
        }
        open.extend(below[link].iter().rev().map(|&j| (child_of[j], Some((at, j)))));
    }
    if let Some(lost) = seen.iter().position(|s| !s) {
        let link = &robot.links[lost];
        return Err(fault(ModelFault::LinkLoop { link: link.name.clone() }, &link.place));
    }
    Ok(ModelFile {
        format: Format::Urdf,
        name: robot.name,
        gravity: Vector3::new(0.0, 0.0, -GRAVITY),
        total_mass: None,
        rest: None,
        bodies,
        left_out: robot.left_out,
    })
}

fn body(link: &RobotLink, hung: Option<(usize, &RobotJoint)>) -> FileBody {
    let joints = hung.and_then(|(_, joint)| {
        let kind = match joint.kind {
            RobotJointKind::Fixed => return None,
            RobotJointKind::Hinge => FileJointKind::Hinge,
            RobotJointKind::Slide => FileJointKind::Slide,
            RobotJointKind::Floating => FileJointKind::Free,
        };
        Some(FileJoint {
            name: Some(joint.name.clone()),
            kind,
            pos: Vector3::zeros(),
            axis: joint.axis,
            range: joint.range,
            reference: 0.0,
            armature: 0.0,
            damping: joint.damping,
            stiffness: 0.0,
            place: joint.place.clone(),
        })
    });
    FileBody {
        name: Some(link.name.clone()),
        parent: hung.map(|(parent, _)| parent),
        pose: hung.map_or(Transform::identity(), |(_, joint)| joint.origin),
        joints: joints.into_iter().collect(),
        inertial: link.inertial.clone(),
        geoms_first: false,
        geoms: link.geoms.clone(),
        sites: Vec::new(),
        place: link.place.clone(),
    }
}
