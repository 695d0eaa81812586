//! Extent at the shoulder: how far the arms are from the body (NF03 §4.3.3).
//!
//! In: selected elements of shoulders. Out: their end values, `slerp(down, pose, x)`, where `down` is the
//! rotation with which the straight arm hangs along the chest: the smallest swing that takes the
//! direction from shoulder to hand, as it is at zero joint values, to "down" in the chest's frame. `x = 1`
//! changes nothing, `x < 1` brings the arms closer to the body, `x > 1` moves them further out. Elbows stay
//! as they are.
//!
//! Needs arms among the skeleton's limbs, with a ball for a shoulder. The chest is the link both arms hang
//! on, or the parent of a single arm; "down" is −Y at zero joint values, carried along with the chest.
//! Values are kept within joint limits, or as far outside as they were before.

use std::collections::BTreeMap;

use motion::rotation::{between, slerp};
use motion::{Dof, Joint, Kinematics, Limb, LimbKind, Quat, Skeleton, Tracks, Value, Vec3};

use crate::fit_place::FitPlace;
use crate::param::PoseOrder;
use crate::poses::{groups, selected, within_limits};
use crate::{EditError, EditLog, Parameter, Selection, TrackEdit};

/// The shoulder extent edit. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct ExtentShoulder {
    /// `x`, at least 0.
    pub extent: Parameter,
}

impl ExtentShoulder {
    /// Close to the body, timid: half the way up from hanging.
    pub const NEAR: f64 = 0.5;
    /// As it is.
    pub const MID: f64 = 1.0;
    /// Out into space, confident.
    pub const FAR: f64 = 1.4;

    /// With an extent, such as one of the presets.
    pub fn new(extent: impl Into<Parameter>) -> Self {
        Self { extent: extent.into() }
    }
}

/// The link that carries both arms, or the parent of a single one.
fn chest(skeleton: &Skeleton, limb: &Limb) -> Option<usize> {
    let links = skeleton.links();
    let above = |link: usize| std::iter::successors(links[link].parent, |&p| links[p].parent);
    let others = skeleton.limbs().iter().filter(|l| l.kind == LimbKind::Arm && l.upper != limb.upper);
    let common = others.filter_map(|o| above(limb.upper).find(|a| above(o.upper).any(|b| b == *a)));
    common.max().or(links[limb.upper].parent)
}

/// Rotation of the shoulder at which the straight arm hangs down along the chest, in the pose `q`
/// (length `nq`). `None` for a limb without length or without a chest.
pub fn arm_down(skeleton: &Skeleton, q: &[f64], limb: &Limb) -> Option<Quat> {
    let chest = chest(skeleton, limb)?;
    let parent = skeleton.links()[limb.upper].parent?;
    let zero = Kinematics::new(skeleton, &skeleton.zero_pose());
    let arm = zero.origin(limb.end) - zero.origin(limb.upper);
    let along = zero.world[limb.upper].rotation.inverse() * arm;
    let now = Kinematics::new(skeleton, q);
    let down_in_chest = zero.world[chest].rotation.inverse() * -Vec3::y();
    let world_from_zero = now.world[parent].rotation * skeleton.links()[limb.upper].parent_from_zero.rotation;
    let down = world_from_zero.inverse() * (now.world[chest].rotation * down_in_chest);
    (along.norm() > 1e-9).then(|| between(&along, &down))
}

impl TrackEdit for ExtentShoulder {
    fn name(&self) -> &'static str {
        "extent_shoulder"
    }

    fn change(&self, tracks: &mut Tracks, selection: &Selection, log: &mut EditLog) -> Result<(), EditError> {
        let order = PoseOrder::new(selected(tracks, selection));
        self.extent.check(self.name(), "extent", order.len(), "0 or more", |x| x >= 0.0)?;
        let skeleton = tracks.skeleton.clone();
        let mut changes = BTreeMap::new();
        let poses = groups(tracks, selection);
        for limb in skeleton.limbs().iter().filter(|l| l.kind == LimbKind::Arm) {
            if skeleton.links()[limb.upper].joint != Joint::Spherical {
                log.note(format!("{}: its shoulder is no ball; nothing was changed", limb.name));
                continue;
            }
            let dof = Dof::Rotation(limb.upper);
            for group in &poses {
                let Some(e) = group.element(dof) else { continue };
                let x = self.extent.at(&order.instant(&e.label, e.start_s));
                let Value::Rotation(end) = e.end else { continue };
                if x == 1.0 {
                    continue;
                }
                let Some(down) = arm_down(&skeleton, &group.goal(tracks), limb) else { continue };
                // slerp(down, end, x), from `end`
                let new = Value::Rotation(slerp(&end, &down, 1.0 - x));
                let (new, cut) = within_limits(&skeleton, dof, &e.end, &new);
                changes.insert(e.label.clone(), (new, cut));
            }
        }
        if changes.is_empty() && !selection.is_empty() {
            log.note("no selected element moves a shoulder, or the extent is 1 there");
        }
        for (_, e) in tracks.elements_mut() {
            if let Some((new, cut)) = changes.get(&e.label) {
                e.end = *new;
                if *cut {
                    log.clamp(&e.label);
                }
            }
        }
        Ok(())
    }

    fn change_fit(&self, tracks: &mut Tracks, place: &FitPlace, log: &mut EditLog) -> Result<(), EditError> {
        self.extent.of_time(self.name(), "extent")?;
        self.change(tracks, &place.selection, log)
    }
}
