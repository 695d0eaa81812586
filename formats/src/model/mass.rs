//! Mass and inertia of the bodies of a model file, and whether a solid could have them.
//!
//! In: bodies with explicit inertia or geoms. Out: mass, centre of mass and inertia about it, along the
//! body's axes. Every fault names the body and the place of its `<inertial>`, geom or joint.

use crate::limits::NUMBER;
use crate::model_file::{
    Effect, FileBody, FileJoint, Format, LeftOut, ModelFault, ModelFile, ModelFileError,
};
use crate::place::Place;
use motion::{Quat, Transform, Vec3};
use nalgebra::{Matrix3, Point3};

use super::{ImportError, ImportedJoint, solid};
use bodies::Character;
use bodies::mass::fuse;
use dynamics::articulated::{AxisInertia, axis_inertias};
use dynamics::{Model, State};

/// Mass, centre of mass (body's frame, m) and inertia about it (body's axes, kg·m²).
pub type MassOf = (f64, Vec3, Matrix3<f64>);

/// Name of a body for messages.
pub fn title(file: &ModelFile, body: usize) -> String {
    file.bodies[body].name.clone().unwrap_or_else(|| format!("body{body}"))
}

/// Masses of all bodies but a base that is only scenery (its mass is zero).
pub fn masses(
    file: &ModelFile,
    base_counts: bool,
    left_out: &mut Vec<LeftOut>,
) -> Result<Vec<MassOf>, ImportError> {
    let mut all = Vec::new();
    // bodies whose own inertia no solid has, and why
    let mut odd: Vec<(usize, ImportError)> = Vec::new();
    for (i, body) in file.bodies.iter().enumerate() {
        if i == 0 && !base_counts {
            all.push(nothing());
            continue;
        }
        let (mass, fault) = mass_of(file, i, body, left_out)?;
        all.push(mass);
        odd.extend(fault.map(|fault| (i, fault)));
    }
    if !odd.is_empty() {
        weigh_welded(file, &mut all, odd, left_out)?;
    }
    if let Some(total) = file.total_mass {
        let sum: f64 = all.iter().map(|m| m.0).sum();
        if sum > 0.0 {
            for (mass, _, inertia) in &mut all {
                *mass *= total / sum;
                *inertia *= total / sum;
            }
        }
    }
    for (at, (mass, _, inertia)) in all.iter().enumerate() {
        // no entry is larger than the trace, however the axes are turned; a file holds no larger number
        let found = mass.max(inertia.trace());
        if found > NUMBER {
            let attribute = format!("mass or inertia of body `{}`", title(file, at));
            let fault =
                ModelFault::OutOfBounds { attribute, found: format!("{found:e}"), allowed: "at most 1e12" };
            return Err(ModelFileError::Model { fault, place: file.bodies[at].place.clone() }.into());
        }
    }
    Ok(all)
}

/// Weighs bodies whose own inertia is no solid's together with all they are welded to: only the sum moves, and it is the sum
/// that has to be a solid's. It is given to the innermost of them, the others weigh nothing.
fn weigh_welded(
    file: &ModelFile,
    all: &mut [MassOf],
    odd: Vec<(usize, ImportError)>,
    left_out: &mut Vec<LeftOut>,
) -> Result<(), ImportError> {
    // a world that is scenery carries no mass of others; a root link that stands fast does
    let scenery = file.format == Format::Mjcf;
    // per body: the innermost of those it is welded to, and where it is in that one's frame
    let mut welded: Vec<(usize, Transform)> = Vec::with_capacity(all.len());
    for (i, body) in file.bodies.iter().enumerate() {
        welded.push(match body.parent {
            Some(parent) if body.joints.is_empty() && !(scenery && parent == 0) => {
                let (top, there) = welded[parent];
                (top, there * body.pose)
            }
            _ => (i, Transform::identity()),
        });
    }
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); all.len()];
    for (i, (top, _)) in welded.iter().enumerate() {
        members[*top].push(i);
    }
    for (i, fault) in odd {
        let top = welded[i].0;
        let members = std::mem::take(&mut members[top]);
        if !members.is_empty() {
            let mut sum = nothing();
            for member in members {
                let there = welded[member].1;
                let (mass, com, inertia) = std::mem::replace(&mut all[member], nothing());
                let inertia = turned(&there.rotation, &inertia);
                let moved = (mass, (there * Point3::from(com)).coords, inertia);
                // without mass on either side there is no common centre, but the inertia stays
                sum = if sum.0 + mass == 0.0 { (0.0, com, sum.2 + inertia) } else { fuse(sum, moved) };
            }
            all[top] = sum;
        }
        let (mass, _, inertia) = all[top];
        let mut reason = "no solid's; weighed with the bodies it is welded to";
        if check(file, i, mass, &inertia, &file.bodies[i].place).is_err() {
            if top != 0 {
                return Err(fault);
            }
            // what never moves resists nothing
            all[0] = nothing();
            reason = "no solid's; it never moves and weighs nothing here";
        }
        left_out.push(LeftOut {
            what: format!("inertial of body `{}`", title(file, i)),
            reason,
            effect: Effect::Look,
            missing: None,
            place: file.bodies[i].inertial.as_ref().map_or(&file.bodies[i].place, |n| &n.place).clone(),
        });
    }
    Ok(())
}

fn nothing() -> MassOf {
    (0.0, Vec3::zeros(), Matrix3::zeros())
}

fn turned(by: &Quat, inertia: &Matrix3<f64>) -> Matrix3<f64> {
    let r = by.to_rotation_matrix();
    r.matrix() * inertia * r.matrix().transpose()
}

/// `<inertial>` or geoms, and what is wrong with the inertia taken for itself. As MuJoCo, an inertial that shall give way to
/// geoms gives way only to geoms that weigh something.
fn mass_of(
    file: &ModelFile,
    at: usize,
    body: &FileBody,
    left_out: &mut Vec<LeftOut>,
) -> Result<(MassOf, Option<ImportError>), ImportError> {
    let Some(inertial) = &body.inertial else { return Ok((of_geoms(file, at, body)?, None)) };
    if body.geoms_first {
        let geoms = of_geoms(file, at, body)?;
        if geoms.0 > 0.0 {
            left_out.push(LeftOut {
                what: format!("inertial of body `{}`", title(file, at)),
                reason: "the file asks for inertia from geoms",
                effect: Effect::Look,
                missing: None,
                place: inertial.place.clone(),
            });
            return Ok((geoms, None));
        }
    }
    let mass = inertial.mass;
    let fault = match check(file, at, mass, &inertial.inertia, &inertial.place) {
        // no sum with others mends these
        Err(e) if !(mass >= 0.0 && mass.is_finite() && inertial.inertia.iter().all(|x| x.is_finite())) => {
            return Err(e);
        }
        checked => checked.err(),
    };
    let inertia = turned(&inertial.pose.rotation, &inertial.inertia);
    Ok(((mass, inertial.pose.translation.vector, inertia), fault))
}

fn of_geoms(file: &ModelFile, at: usize, body: &FileBody) -> Result<MassOf, ImportError> {
    let mut sum = nothing();
    for geom in body.geoms.iter().filter(|g| g.counts) {
        let mesh = || ImportError::MeshMass { body: title(file, at), place: geom.place.clone() };
        let mass = solid::mass(&geom.shape, &geom.weight).ok_or_else(mesh)?;
        if mass == 0.0 {
            continue;
        }
        let principal = solid::inertia_per_mass(&geom.shape).ok_or_else(mesh)? * mass;
        let own = Matrix3::from_diagonal(&principal);
        check(file, at, mass, &own, &geom.place)?;
        let inertia = turned(&geom.pose.rotation, &own);
        let com = (geom.pose * Point3::origin()).coords;
        sum = fuse(sum, (mass, com, inertia));
    }
    Ok(sum)
}

/// No mass and no inertia, or both positive and the triangle inequality kept.
fn check(
    file: &ModelFile,
    at: usize,
    mass: f64,
    inertia: &Matrix3<f64>,
    place: &Place,
) -> Result<(), ImportError> {
    if mass == 0.0 && *inertia == Matrix3::zeros() {
        return Ok(());
    }
    let (body, place) = (title(file, at), place.clone());
    if mass <= 0.0 || !mass.is_finite() {
        return Err(ImportError::Mass { body, mass, place });
    }
    if !inertia.iter().all(|x| x.is_finite()) {
        return Err(ImportError::Inertia { body, principal: [f64::NAN; 3], place });
    }
    let mut principal: [f64; 3] = inertia.symmetric_eigenvalues().into();
    principal.sort_by(f64::total_cmp);
    if principal[0] <= 0.0 {
        return Err(ImportError::Inertia { body, principal, place });
    }
    // equality holds for a flat plate; 1e-9 is rounding of written files
    if principal[2] > (principal[0] + principal[1]) * (1.0 + 1e-9) {
        return Err(ImportError::Triangle { body, principal, place });
    }
    Ok(())
}

/// Every joint must move something that resists, whatever the joints it carries do.
///
/// M = LᵀDL from the tips inward: Dᵢ is the inertia about axis i of all it carries, the joints further out
/// left free (Featherstone 2008, §8.5). It is zero where two axes coincide with no mass between them, or
/// where nothing outboard has mass. One pose without symmetries stands for all.
pub fn check_axes(
    file: &ModelFile,
    character: &Character,
    joints: &[ImportedJoint],
    origin: &[(usize, usize)],
) -> Result<(), ImportError> {
    let model = Model::new(character, Vec3::zeros());
    let mut state = State::new(&model);
    let n = model.nv();
    let skeleton = &character.skeleton;
    let mut q = character.rest.clone();
    let turn: Vec<f64> = (0..n).map(|i| 0.4 + 0.3 * (1.7 * i as f64).sin()).collect();
    skeleton.integrate(&mut q, &turn, 1.0);
    state.update_pose(&model, &q);
    // the least share of any model of the test data is 0.008; rounding leaves 1e-16
    let fixed = |a: &AxisInertia| a.free <= 1e-10 * a.held || !a.free.is_finite();
    let bad = axis_inertias(&model, &state).iter().rposition(fixed);
    let Some(dof) = bad else { return Ok(()) };
    let at = joints.iter().rposition(|j| skeleton.v_at(j.link) <= dof).unwrap_or(0);
    let (body, joint) = origin[at];
    let source: &FileJoint = &file.bodies[body].joints[joint];
    Err(ImportError::NoInertia {
        joint: joints[at].name.clone(),
        body: title(file, body),
        place: source.place.clone(),
    })
}
