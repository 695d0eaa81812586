//! An analysis in the form of a trace, so that every figure of a trace is one of a clip too.

use std::sync::Arc;

use motion::Clip;
use motion::skeleton::vec_at;

use crate::analysis::Contact;
use crate::analysis::ground::SPACING_M;
use crate::{Against, Analysis, ContactSample, Model, RootMode, State, Trace};
use bodies::Character;

/// A trace whose motion is the analysed one, asked for by `given` (the clip before it was smoothed, on the
/// character's skeleton), and whose forces are those of the analysis.
///
/// The root counts as pinned, by the residual. Torques are those the joints need; gains are zero: nobody
/// knows them. Contacts of a frame are each loaded foot's force at its centre of pressure, and, without
/// force, the points of that foot near the ground: their hull is the support. Unlike in a recorded
/// trace, the forces of a row act at its time, not during the step before it.
pub fn trace_of(character: &Arc<Character>, given: &Clip, a: &Analysis) -> Trace {
    let skeleton = &character.skeleton;
    let (rows, nv) = (a.frames(), skeleton.nv());
    let model = Model::new(character, a.gravity);
    let mut state = State::new(&model);
    let mut torque = a.tau.clone();
    let mut energy = Vec::with_capacity(2 * rows);
    let mut contacts = Vec::new();
    let mut momentum = Vec::with_capacity(6 * rows);
    let root = skeleton.links()[0].joint.nv();
    let near = Contact::default().height_m;
    let soles = character.edged_soles(SPACING_M);
    for row in 0..rows {
        state.update(&model, a.clip.pose(row), &a.v[row * nv..(row + 1) * nv]);
        torque[row * nv..row * nv + root].fill(0.0);
        let (kinetic, potential) = state.energy(&model);
        energy.extend([kinetic, potential]);
        momentum.extend(&(vec_at(&a.com_velocity, 3 * row) * a.mass));
        momentum.extend(&vec_at(&a.angular_momentum, 3 * row));
        for foot in a.feet.iter().filter(|f| f.contact[row] && f.share[row] > 0.0) {
            let (point, force) = (vec_at(&foot.cop, 3 * row), foot.force_at(row));
            contacts.push(ContactSample {
                row,
                link: foot.link,
                against: Against::Ground,
                point,
                force,
                depth: -foot.height[row],
            });
            let sole = soles.iter().filter(|s| s.link == foot.link);
            for (link, at) in sole.flat_map(|s| &s.corners) {
                let point = state.point(&model, *link, at);
                let height = point.y - a.ground_m.unwrap_or(0.0);
                if height < near {
                    let force = motion::Vec3::zeros();
                    contacts.push(ContactSample {
                        row,
                        link: foot.link,
                        against: Against::Ground,
                        point,
                        force,
                        depth: -height,
                    });
                }
            }
        }
    }
    Trace {
        character: character.clone(),
        rate_hz: a.rate_hz(),
        substeps: 1,
        root: RootMode::Pinned,
        ground_m: a.ground_m,
        gravity: a.gravity,
        q: a.clip.data().to_vec(),
        v: a.v.clone(),
        target: given.data().to_vec(),
        torque,
        stop_torque: vec![0.0; rows * nv],
        k_lo: vec![0.0; rows * nv],
        k_hi: vec![0.0; rows * nv],
        kd: vec![0.0; rows * nv],
        contacts,
        root_wrench: a.residual.clone(),
        com: a.com.clone(),
        momentum,
        link_com: Vec::new(),
        disturbed: crate::Disturbed::default(),
        energy,
        plan: motion::ContactPlan::default(),
        colors: Vec::new(),
        wall_s: 0.0,
    }
}
