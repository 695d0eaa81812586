//! Estimate of the ground under the feet, from soles that lie flat: how far it has turned since the feet were planted.
//!
//! A foot that presses with most of its sole lies flat on the ground, so its turn since it was planted is the ground's. A
//! foot on an edge does not count: it tips, and its plant must stay where it was so that the foot is put down again. Turns
//! below [`LEVEL`] are those of yielding contacts, not of the ground.
//!
//! In: contacts of the last step, the state. Out: where the feet stand now. World frame.

use dynamics::{ContactSample, Model, State};
use motion::plant::Plant;
use motion::rotation::{exp, log};
use motion::support::Support;
use motion::{Quat, Transform, Vec3};

use crate::support::Foot;

/// Ground turned by less counts as unturned, rad (0.3°).
const LEVEL: f64 = 0.3 * std::f64::consts::PI / 180.0;
/// Part of a sole's area within the points that press from which on the foot lies flat.
const FLAT: f64 = 0.5;

/// Feet on ground that may turn. See the module header.
#[derive(Clone, Debug)]
pub(super) struct Soles {
    /// Where the feet were planted, and the middle of each sole there.
    homes: Vec<(Plant, Vec3)>,
    /// Which feet lie flat.
    flat: Vec<bool>,
    /// Turn of the ground, about horizontal axes, rad.
    turn: Vec3,
    /// Rise of the ground under the middle of the feet, m.
    rise: f64,
}

impl Soles {
    pub fn new(feet: &[Foot], plants: &[Plant]) -> Self {
        let home = |(foot, plant): (&Foot, &Plant)| {
            let own = foot.sole.corners.iter().filter(|(link, _)| *link == plant.limb.end);
            let (sum, n) = own.fold((Vec3::zeros(), 0.0), |(sum, n), (_, at)| (sum + at, n + 1.0));
            let middle = plant.world_from_end * nalgebra::Point3::from(sum / f64::max(n, 1.0));
            (plant.clone(), middle.coords)
        };
        let homes: Vec<_> = feet.iter().zip(plants).map(home).collect();
        Self { flat: vec![false; homes.len()], homes, turn: Vec3::zeros(), rise: 0.0 }
    }

    /// Updates the estimate from the contacts of the last step; `state` is of the pose at its end.
    pub fn observe_contacts(
        &mut self,
        feet: &[Foot],
        model: &Model,
        state: &State,
        contacts: &[ContactSample],
    ) {
        let lies_flat = |foot: &Foot| {
            let pressing = contacts.iter().filter(|c| model.body_of[c.link].0 == foot.body);
            let pressed: Vec<Vec3> = pressing.map(|c| c.point).collect();
            let sole = Support::of(foot.corners_in_world(model, state).iter()).area();
            Support::of(pressed.iter()).area() > FLAT * sole
        };
        for (flat, foot) in self.flat.iter_mut().zip(feet) {
            *flat = lies_flat(foot);
        }
        let (mut turn, mut count) = (Vec3::zeros(), 0.0);
        for (i, (plant, _)) in self.homes.iter().enumerate().filter(|(i, _)| self.flat[*i]) {
            let now = foot_pose(&feet[i], model, state);
            let turned = log(&(now.rotation * plant.world_from_end.rotation.inverse()));
            turn += Vec3::new(turned.x, 0.0, turned.z);
            count += 1.0;
        }
        if count == 0.0 {
            return;
        }
        let turn = turn / count;
        let beyond = 1.0 - LEVEL / turn.norm().max(LEVEL);
        self.turn = turn * beyond;
        if self.turn == Vec3::zeros() {
            self.rise = 0.0;
            return;
        }
        let at = |i: usize| {
            let (plant, middle) = &self.homes[i];
            let local = plant.world_from_end.inverse() * nalgebra::Point3::from(*middle);
            (foot_pose(&feet[i], model, state) * local).y - self.carried(exp(&self.turn), middle).y
        };
        let rises = (0..self.homes.len()).filter(|i| self.flat[*i]).map(at);
        self.rise = rises.sum::<f64>() / count * beyond;
    }

    /// Where the feet stand now.
    pub fn plants(&self, out: &mut [Plant]) {
        if self.turn == Vec3::zeros() {
            for (out, (plant, _)) in out.iter_mut().zip(&self.homes) {
                out.world_from_end = plant.world_from_end;
            }
            return;
        }
        let turn = exp(&self.turn);
        for (out, (plant, _)) in out.iter_mut().zip(&self.homes) {
            let home = &plant.world_from_end;
            let place = self.carried(turn, &home.translation.vector) + Vec3::y() * self.rise;
            out.world_from_end = Transform::from_parts(place.into(), turn * home.rotation);
        }
    }

    /// A point turned about the middle between the soles, m.
    fn carried(&self, turn: Quat, p: &Vec3) -> Vec3 {
        let middle = self.homes.iter().map(|(_, m)| m).sum::<Vec3>() / self.homes.len() as f64;
        middle + turn * (p - middle)
    }
}

fn foot_pose(foot: &Foot, model: &Model, state: &State) -> Transform {
    let (body, body_from_link) = &model.body_of[foot.limb.end];
    state.bodies[*body].world * body_from_link
}

#[cfg(test)]
mod tests {
    use super::*;
    use bodies::anthropometry::human::human;

    /// Plants of feet that lie flat follow the turned ground; those of feet on their toes, and of feet that hardly turned,
    /// stay.
    #[test]
    fn flat_feet_tell_of_the_ground() {
        let (c, _) = human();
        let model = Model::new(&c, Vec3::y() * -9.81);
        let feet = Foot::of(&c, &model);
        let plants: Vec<Plant> = feet.iter().map(|f| Plant::here(&c.skeleton, &c.rest, &f.limb)).collect();
        let still = vec![0.0; model.nv()];
        let mut state = State::new(&model);
        for (angle, on_toes, follows) in [(5.0, false, true), (5.0, true, false), (0.2, false, false)] {
            let turn = exp(&(Vec3::new(0.8, 0.0, -0.6) * f64::to_radians(angle)));
            // a body turned as a whole about the point under the origin stands on ground turned likewise
            let mut q = c.rest.clone();
            let p = turn * c.skeleton.position(&q, 0);
            c.skeleton.set_position(&mut q, 0, &p);
            let r = turn * motion::skeleton::quat_at(&q, 3);
            q[3..7].copy_from_slice(&[r.w, r.i, r.j, r.k]);
            state.update(&model, &q, &still);
            let mut touching = Vec::new();
            for foot in &feet {
                let corners = foot.corners_in_world(&model, &state);
                let front = corners.iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
                let here = corners.iter().filter(|p| !on_toes || p.z > front - 0.05);
                touching.extend(here.map(|p| ContactSample {
                    row: 0,
                    link: foot.limb.end,
                    against: Default::default(),
                    point: *p,
                    force: Vec3::y(),
                    depth: 0.0,
                }));
            }
            let mut soles = Soles::new(&feet, &plants);
            let mut found = plants.clone();
            soles.observe_contacts(&feet, &model, &state, &touching);
            soles.plants(&mut found);
            for ((foot, plant), found) in feet.iter().zip(&plants).zip(&found) {
                if !follows {
                    assert_eq!(found, plant, "{angle}°");
                    continue;
                }
                let there = foot_pose(foot, &model, &state);
                let off = log(&(there.rotation * found.world_from_end.rotation.inverse())).norm();
                let apart = (there.translation.vector - found.world_from_end.translation.vector).norm();
                println!("{:.3}° {:.2} mm", off.to_degrees(), 1e3 * apart);
                assert!(off < 1.01 * LEVEL, "{}°", off.to_degrees());
                assert!(apart < 2e-3, "{apart}"); // 1.2 mm seen, of 15
            }
        }
    }
}
