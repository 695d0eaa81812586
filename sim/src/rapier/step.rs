//! Stepping: drives, root path, wrenches and the step itself, as [`Engine`] asks for them.

use bodies::Character;
use controllers::{Drive, Rest};
use dynamics::{Model, State, Wrench};
use motion::rotation::log;
use motion::skeleton::{quat_at, vec_at};
use motion::{Joint, Vec3};

use super::build::mass_properties;
use super::{NAME, Rapier, pose, to_glam};
use crate::{ContactForce, Engine, EngineError};

impl Engine for Rapier {
    fn name(&self) -> &str {
        NAME
    }

    fn model(&self) -> &Model {
        &self.model
    }

    fn q(&self) -> &[f64] {
        &self.q
    }

    fn v(&self) -> &[f64] {
        &self.v
    }

    fn stops(&self) -> &[f64] {
        &self.stops
    }

    fn set_stops(&mut self, stiffness: &[f64]) {
        self.stops.clear();
        self.stops.extend_from_slice(stiffness);
    }

    fn set_masses(&mut self, character: &Character) -> Result<(), EngineError> {
        let model = Model::new(character, self.settings.gravity);
        let root = &model.bodies[0];
        if matches!(root.joint, Joint::Free) && root.com != self.root_shift {
            // the root's frame is its centre of mass, which moves: build the body anew around it
            let mut built = Rapier::new(character, self.settings.clone(), &self.q, &self.v)?;
            built.stops = std::mem::take(&mut self.stops);
            built.steps = self.steps;
            *self = built;
            return Ok(());
        }
        for (i, b) in model.bodies.iter().enumerate() {
            let old = &self.model.bodies[i];
            if (b.mass, b.com, b.inertia) != (old.mass, old.com, old.inertia) {
                let shift = if i == 0 { self.root_shift } else { Vec3::zeros() };
                let body = &mut self.physics.bodies[self.handles[i]];
                body.set_additional_mass_properties(mass_properties(b, &shift), true);
            }
        }
        self.model = model;
        Ok(())
    }

    fn set_drives(&mut self, drives: &[Drive]) {
        let Some(any) = self.any_joint else { return };
        for i in 0..self.stopping.len() {
            self.stopping[i] = self.stop(i).unwrap_or((0.0, Vec3::zeros()));
        }
        let (mb, _) = self.physics.multibody_joints.get_mut(any).expect("own joint");
        for (i, (b, drive)) in self.model.bodies.iter().zip(drives).enumerate() {
            let first = match b.joint {
                Joint::Revolute(_) | Joint::Spherical => 3,
                Joint::Prismatic(_) => 0,
                Joint::Free | Joint::Fixed => continue,
            };
            // muscle and stop act in parallel: one spring with the sum of their stiffnesses and of their torques
            let (stop, back) = self.stopping[i];
            let muscle = match drive.rest {
                Rest::Scalar(rest) => Vec3::x() * (rest - self.q[b.q_at]),
                Rest::Ball { .. } => drive.pull(&quat_at(&self.q, b.q_at)),
                Rest::None => Vec3::zeros(),
            };
            let stiffness = drive.stiffness + stop;
            let error = (muscle * drive.stiffness + back * stop) / stiffness.max(f64::MIN_POSITIVE);
            let link = mb.link_mut(self.mb_link[i]).expect("own link");
            let (at, coords) = (link.assembly_id(), link.joint.coords());
            for k in 0..b.joint.nv() {
                link.joint.set_spring(first + k, stiffness, coords[first + k] + error[k]);
            }
            for k in 0..b.joint.nv() {
                mb.damping_mut()[at + k] = drive.damping;
            }
        }
    }

    fn move_root(&mut self, state: &State, q_next: &[f64]) {
        let Some(any) = self.any_joint else { return };
        if !matches!(self.model.bodies[0].joint, Joint::Free) {
            return;
        }
        let dt = 1.0 / self.settings.rate_hz;
        let q_at = self.model.bodies[0].q_at;
        let at = |q: &[f64]| {
            let r = quat_at(q, q_at + 3);
            (vec_at(q, q_at) + r * self.root_shift, r)
        };
        let ((c0, r0), (c1, r1)) = (at(&self.q), at(q_next));
        let linear = (c1 - c0) / dt;
        let angular = log(&(r1 * r0.inverse())) / dt;
        let (mb, _) = self.physics.multibody_joints.get_mut(any).expect("own joint");
        let mut velocity = mb.generalized_velocity_mut();
        let old_linear = Vec3::new(velocity[0], velocity[1], velocity[2]);
        let old_angular = Vec3::new(velocity[3], velocity[4], velocity[5]);
        for k in 0..3 {
            velocity[k] = linear[k];
            velocity[3 + k] = angular[k];
        }
        let (a, alpha) = ((linear - old_linear) / dt, (angular - old_angular) / dt);
        for (i, b) in self.model.bodies.iter().enumerate().skip(1) {
            let s = &state.bodies[i];
            let force = -(a + alpha.cross(&(s.com - c0))) * b.mass;
            let body = &mut self.physics.bodies[self.handles[i]];
            body.add_force(to_glam(force), true);
            body.add_torque(to_glam(-(s.inertia * alpha)), true);
        }
    }

    fn turn_ground(&mut self, up: &Vec3) {
        let (Some(body), Some(ground)) = (self.turning, &mut self.settings.ground) else { return };
        ground.up = *up;
        self.physics.bodies[body].set_next_kinematic_position(pose(&ground.place()));
    }

    fn add_wrench(&mut self, w: &Wrench) {
        let body = &mut self.physics.bodies[self.handles[self.model.body_of[w.link].0]];
        body.add_force_at_point(to_glam(w.force), to_glam(w.point), true);
        body.add_torque(to_glam(w.moment), true);
    }

    fn step(&mut self) -> Result<(), EngineError> {
        self.physics.step_with_events(&self.touching, &());
        self.steps += 1;
        for &h in &self.handles {
            let body = &mut self.physics.bodies[h];
            body.reset_forces(true);
            body.reset_torques(true);
        }
        self.read_state();
        match self.runaway() {
            None => Ok(()),
            Some(body) => Err(EngineError::Diverged {
                step: self.steps,
                time_s: self.steps as f64 / self.settings.rate_hz,
                body: body.into(),
            }),
        }
    }

    fn contacts(&self, out: &mut Vec<ContactForce>) {
        self.read_contacts(out);
    }
}
