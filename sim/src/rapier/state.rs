//! State: `q`, `v` to and from rapier's joint coordinates and velocities.
//!
//! The frame of a free root lies at its centre of mass in rapier and at its origin in ours; the shift between the two is
//! added here. Coordinates of a ball joint are the running integral of ω in rapier, so a pose is set by displacements.

use motion::rotation::log;
use motion::skeleton::{quat_at, vec_at};
use motion::{Joint, Quat, Transform, Vec3};

use super::{Rapier, from_glam, from_rot, pose, to_glam};

impl Rapier {
    /// Puts the body at the pose `q` with velocity `v`.
    pub fn set_state(&mut self, q: &[f64], v: &[f64]) {
        self.q.copy_from_slice(q);
        self.v.copy_from_slice(v);
        let Some(any) = self.any_joint else { return self.set_lone_body() };
        let (mb, _) = self.physics.multibody_joints.get_mut(any).expect("own joint");
        let mut displacement = vec![0.0; mb.ndofs()];
        let mut velocity = vec![0.0; mb.ndofs()];
        for (b, &id) in self.model.bodies.iter().zip(&self.mb_link) {
            let link = mb.link(id).expect("own link");
            let at = link.assembly_id();
            let turn = |target: Quat| log(&(target * from_rot(link.joint().joint_rot()).inverse()));
            match b.joint {
                Joint::Free => {
                    let r = quat_at(q, b.q_at + 3);
                    let shift = if b.parent.is_none() { self.root_shift } else { Vec3::zeros() };
                    let goal = vec_at(q, b.q_at) + r * shift;
                    let omega = vec_at(v, b.v_at + 3);
                    let linear = vec_at(v, b.v_at) + omega.cross(&(r * shift));
                    for k in 0..3 {
                        displacement[at + k] = goal[k] - link.joint().coords()[k];
                        velocity[at + k] = linear[k];
                        velocity[at + 3 + k] = omega[k];
                    }
                    displacement[at + 3..at + 6].copy_from_slice(turn(r).as_slice());
                }
                Joint::Spherical => {
                    displacement[at..at + 3].copy_from_slice(turn(quat_at(q, b.q_at)).as_slice());
                    velocity[at..at + 3].copy_from_slice(&v[b.v_at..b.v_at + 3]);
                }
                Joint::Revolute(_) => {
                    displacement[at] = q[b.q_at] - link.joint().coords()[3];
                    velocity[at] = v[b.v_at];
                }
                Joint::Prismatic(_) => {
                    displacement[at] = q[b.q_at] - link.joint().coords()[0];
                    velocity[at] = v[b.v_at];
                }
                Joint::Fixed => {}
            }
        }
        mb.apply_displacements(&displacement);
        mb.generalized_velocity_mut().copy_from_slice(&velocity);
        mb.forward_kinematics(&self.physics.bodies, false);
        mb.update_rigid_bodies(&mut self.physics.bodies, true);
    }

    /// A free root that carries nothing is no multibody for the engine, but a plain body, whose velocity is
    /// that of its centre of mass.
    fn set_lone_body(&mut self) {
        let b = &self.model.bodies[0];
        if !matches!(b.joint, Joint::Free) {
            return;
        }
        let r = quat_at(&self.q, b.q_at + 3);
        let shift = r * self.root_shift;
        let omega = vec_at(&self.v, b.v_at + 3);
        let at = Transform::from_parts((vec_at(&self.q, b.q_at) + shift).into(), r);
        let body = &mut self.physics.bodies[self.handles[0]];
        body.set_position(pose(&at), true);
        body.set_linvel(to_glam(vec_at(&self.v, b.v_at) + omega.cross(&shift)), true);
        body.set_angvel(to_glam(omega), true);
    }

    fn read_lone_body(&mut self) {
        let b = &self.model.bodies[0];
        if !matches!(b.joint, Joint::Free) {
            return;
        }
        let body = &self.physics.bodies[self.handles[0]];
        let r = from_rot(*body.rotation());
        let omega = from_glam(body.angvel());
        let shift = r * self.root_shift;
        let at = from_glam(body.translation()) - shift;
        let velocity = from_glam(body.linvel()) - omega.cross(&shift);
        self.q[b.q_at..b.q_at + 3].copy_from_slice(at.as_slice());
        self.q[b.q_at + 3..b.q_at + 7].copy_from_slice(&[r.w, r.i, r.j, r.k]);
        self.v[b.v_at..b.v_at + 3].copy_from_slice(velocity.as_slice());
        self.v[b.v_at + 3..b.v_at + 6].copy_from_slice(omega.as_slice());
    }

    pub(super) fn read_state(&mut self) {
        let Some(any) = self.any_joint else { return self.read_lone_body() };
        let (mb, _) = self.physics.multibody_joints.get(any).expect("own joint");
        let velocity = mb.generalized_velocity();
        for (b, &id) in self.model.bodies.iter().zip(&self.mb_link) {
            let link = mb.link(id).expect("own link");
            let at = link.assembly_id();
            let coords = link.joint().coords();
            let r = from_rot(link.joint().joint_rot());
            let store = |q: &mut [f64], at: usize| {
                q[at..at + 4].copy_from_slice(&[r.w, r.i, r.j, r.k]);
            };
            match b.joint {
                Joint::Free => {
                    let shift = if b.parent.is_none() { r * self.root_shift } else { Vec3::zeros() };
                    let omega = Vec3::new(velocity[at + 3], velocity[at + 4], velocity[at + 5]);
                    let back = omega.cross(&shift);
                    for k in 0..3 {
                        self.q[b.q_at + k] = coords[k] - shift[k];
                        self.v[b.v_at + k] = velocity[at + k] - back[k];
                        self.v[b.v_at + 3 + k] = omega[k];
                    }
                    store(&mut self.q, b.q_at + 3);
                }
                Joint::Spherical => {
                    store(&mut self.q, b.q_at);
                    for k in 0..3 {
                        self.v[b.v_at + k] = velocity[at + k];
                    }
                }
                Joint::Revolute(_) => {
                    self.q[b.q_at] = coords[3];
                    self.v[b.v_at] = velocity[at];
                }
                Joint::Prismatic(_) => {
                    self.q[b.q_at] = coords[0];
                    self.v[b.v_at] = velocity[at];
                }
                Joint::Fixed => {}
            }
        }
    }
}
