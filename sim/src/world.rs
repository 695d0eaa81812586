//! World: one articulated body over a ground plane, stepped by rapier.
//!
//! In: a character, a state, one [`Drive`] per joint, outside wrenches. Out: the
//! state after the step and the forces at every contact. This file and [`crate::contacts`] are the
//! only ones that name rapier; the rest of the workspace sees `q`, `v` and newtons.
//!
//! How rapier is used, and why (all measured):
//! - Springs of the multibody joints are integrated implicitly. Their rest is re-based every step to
//!   `coords + torque/K`, because the coordinates of a ball joint are the running integral of ω.
//! - Default joint damping (0.1 N·m·s/rad, root included) is set to zero.
//! - The root's frame sits at its centre of mass: elsewhere the engine integrates the wrong point.
//! - Coulomb friction, no contact clustering or recycling: forces are read point by point.
//! - A pinned root is a kinematic joint whose velocity is set; the inertial force of its
//!   acceleration, which the engine leaves out, is added to every body.
//! - Ground that turns is a kinematic body; its velocity at every contact is the solver's. What touches it is as stiff as
//!   on fixed ground.

use dynamics::{Character, ContactSample, Model, MovingBody, State, Wrench};
use motion::rotation::log;
use motion::skeleton::{quat_at, vec_at};
use motion::{Joint, Quat, Shape, Transform, Vec3};
use rapier3d::dynamics::FrictionModel;
use rapier3d::prelude as rp;
use thiserror::Error;

use controllers::{Drive, Rest};

use crate::{Engine, Ground};

/// Settings of a world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldSettings {
    /// Control steps per second, Hz.
    pub rate_hz: f64,
    /// Engine substeps per control step; each re-assembles the mass matrix.
    pub substeps: usize,
    /// Gravity, m/s².
    pub gravity: Vec3,
    /// Ground plane, if any.
    pub ground: Option<Ground>,
    /// Whether the root's motion is given instead of simulated.
    pub pinned: bool,
    /// How contacts yield.
    pub contact: ContactLaw,
}

/// How contacts yield.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ContactLaw {
    /// As stiff as the engine's solver allows, inelastic: what characters stand on.
    #[default]
    Stiff,
    /// A spring and a damper at each point: stiffness m ω² and damping 2 ζ m ω with the apparent mass m of the
    /// point, for comparisons at a known compliance. Holds while ω dt ≪ 1 and pushes only.
    Spring {
        /// ω/2π, Hz.
        natural_frequency_hz: f64,
        /// ζ.
        damping_ratio: f64,
    },
}

/// Why a world cannot be built or stepped.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum WorldError {
    /// A free root whose zero frame is turned or shifted.
    #[error("the root `{0}` must have its zero frame at the world's origin")]
    RootFrame(String),
    /// The engine refused a joint.
    #[error("the engine refused the joint of `{0}`")]
    Joint(String),
    /// An engine that stopped working.
    #[error("{0}")]
    Engine(String),
    /// Numbers ran away.
    #[error("the simulation diverged at step {step} ({time_s:.3} s), first seen at `{body}`")]
    Diverged {
        /// Control step.
        step: usize,
        /// Time, s.
        time_s: f64,
        /// Link at which it showed.
        body: String,
    },
}

/// An articulated body in rapier. See the module header.
pub struct World {
    /// The engine.
    pub(crate) physics: rp::PhysicsWorld,
    /// The body, compiled.
    pub model: Model,
    /// The world's settings.
    pub settings: WorldSettings,
    pub(crate) handles: Vec<rp::RigidBodyHandle>,
    /// The ground, if it may turn.
    turning: Option<rp::RigidBodyHandle>,
    any_joint: Option<rp::MultibodyJointHandle>,
    mb_link: Vec<usize>,
    /// Centre of mass of the root body in its own frame; zero unless the root is free.
    root_shift: Vec3,
    /// Stiffness of the stop of each body's joint, N·m/rad; zero without one.
    stops: Vec<f64>,
    /// Stiffness and way back of the stops that act in the next step.
    stopping: Vec<(f64, Vec3)>,
    q: Vec<f64>,
    v: Vec<f64>,
    steps: usize,
}

/// Factor on the engine's natural frequencies of contacts. At 1 feet sink deeper the smaller the step, because
/// the compliance follows the apparent mass M + dt D + dt² K: 0.15 mm at 240 Hz, 0.63 mm at 1920 Hz under
/// the bow, and knees drift with it. At 4 it is 0.014 mm at 240 Hz, and the run converges.
const CONTACT_STIFFENING: f64 = 4.0;

/// Gauss–Seidel sweeps over the contact rows of spring contacts.
const SPRING_SWEEPS: usize = 50;

/// Above this rate (rad/s or m/s) no character moves: the run has diverged.
const RUNAWAY: f64 = 1e3;

impl World {
    /// Builds the body at the pose `q` with the velocity `v`.
    ///
    /// # Errors
    /// [`WorldError::RootFrame`], [`WorldError::Joint`].
    pub fn new(
        character: &Character,
        settings: WorldSettings,
        q: &[f64],
        v: &[f64],
    ) -> Result<Self, WorldError> {
        let model = Model::new(character, settings.gravity);
        let mut physics = rp::PhysicsWorld::new();
        physics.gravity = to_glam(settings.gravity);
        let p = &mut physics.integration_parameters;
        p.dt = 1.0 / settings.rate_hz;
        p.num_solver_iterations = settings.substeps;
        p.friction_model = FrictionModel::Coulomb;
        p.contact_clustering = false;
        p.contact_recycling = false;
        p.max_ccd_substeps = 0;
        match settings.contact {
            ContactLaw::Stiff => {
                p.static_contact_softness.natural_frequency *= CONTACT_STIFFENING;
                // the ground is all there is to touch, whether it turns or not
                p.contact_softness = p.static_contact_softness;
            }
            ContactLaw::Spring { natural_frequency_hz, damping_ratio } => {
                let law = rp::SpringCoefficients { natural_frequency: natural_frequency_hz, damping_ratio };
                p.contact_softness = law;
                p.static_contact_softness = law;
                // the pass without bias makes contacts inelastic; a spring needs its rows converged instead
                p.num_internal_stabilization_iterations = 0;
                p.num_internal_pgs_iterations = SPRING_SWEEPS;
                // contacts foreseen before they touch are rigid whatever the softness
                p.normalized_prediction_distance = 0.0;
            }
        }

        let root = &model.bodies[0];
        let free_root = matches!(root.joint, Joint::Free);
        if free_root && root.parent_from_zero != Transform::identity() {
            return Err(WorldError::RootFrame(character.skeleton.links()[root.link].name.clone()));
        }
        let root_shift = if free_root { root.com } else { Vec3::zeros() };
        let shift_of = |body: usize| if body == 0 { root_shift } else { Vec3::zeros() };

        let mut state = State::new(&model);
        state.update(&model, q, v);
        let anchor = match root.joint {
            Joint::Free | Joint::Fixed => None,
            _ => Some(physics.insert_body(rp::RigidBodyBuilder::fixed())),
        };
        let mut handles = Vec::new();
        for (i, b) in model.bodies.iter().enumerate() {
            let shift = shift_of(i);
            let world = state.bodies[i].world * nalgebra::Translation3::from(shift);
            let builder = if i == 0 && matches!(b.joint, Joint::Fixed) {
                rp::RigidBodyBuilder::fixed()
            } else {
                rp::RigidBodyBuilder::dynamic()
            };
            let mass = mass_properties(b, &shift);
            let handle = physics
                .insert_body(builder.pose(pose(&world)).can_sleep(false).additional_mass_properties(mass));
            handles.push(handle);
        }
        for (i, body) in character.bodies.iter().enumerate() {
            let (owner, owner_from_link) = model.body_of[i];
            let frame = nalgebra::Translation3::from(-shift_of(owner)) * owner_from_link;
            for shape in &body.shapes {
                let collider = collider(shape, &frame)
                    .density(0.0)
                    .friction(settings.ground.map_or(0.0, |g| g.friction))
                    .collision_groups(groups(rp::Group::GROUP_1, rp::Group::GROUP_2));
                physics.insert_collider(collider, Some(handles[owner]));
            }
        }
        let mut turning = None;
        if let Some(ground) = settings.ground {
            let plane = |up: Vec3| {
                rp::ColliderBuilder::halfspace(nalgebra::Unit::new_unchecked(to_glam(up)))
                    .friction(ground.friction)
                    .collision_groups(groups(rp::Group::GROUP_2, rp::Group::GROUP_1))
            };
            if ground.turns {
                let place = pose(&ground.place());
                let body = rp::RigidBodyBuilder::kinematic_position_based().pose(place).can_sleep(false);
                let body = physics.insert_body(body);
                physics.insert_collider(plane(Vec3::y()), Some(body));
                turning = Some(body);
            } else {
                physics.insert_collider(plane(ground.up).translation(to_glam(ground.pivot())), None);
            }
        }
        let mut any_joint = None;
        for (i, b) in model.bodies.iter().enumerate() {
            let parent = match (b.parent, anchor) {
                (Some(p), _) => handles[p],
                (None, Some(a)) => a,
                (None, None) => continue,
            };
            let parent_shift = b.parent.map_or(Vec3::zeros(), shift_of);
            let joint = joint(&b.joint, &b.parent_from_zero, parent_shift);
            let handle = physics
                .insert_multibody_joint(parent, handles[i], joint)
                .ok_or_else(|| WorldError::Joint(character.skeleton.links()[b.link].name.clone()))?;
            any_joint = Some(handle);
        }
        let bodies = model.bodies.len();
        let mut world = Self {
            physics,
            model,
            settings,
            handles,
            turning,
            any_joint,
            mb_link: Vec::new(),
            root_shift,
            stops: vec![0.0; bodies],
            stopping: vec![(0.0, Vec3::zeros()); bodies],
            q: character.skeleton.zero_pose(),
            v: vec![0.0; character.skeleton.nv()],
            steps: 0,
        };
        world.prepare();
        world.set_state(q, v);
        Ok(world)
    }

    /// Control steps taken.
    pub fn steps(&self) -> usize {
        self.steps
    }

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

    fn prepare(&mut self) {
        let Some(any) = self.any_joint else { return };
        let (mb, _) = self.physics.multibody_joints.get_mut(any).expect("own joint");
        mb.set_self_contacts_enabled(false);
        mb.forward_kinematics(&self.physics.bodies, true);
        mb.damping_mut().fill(0.0);
        if self.settings.pinned && matches!(self.model.bodies[0].joint, Joint::Free) {
            mb.root_mut().joint.kinematic = true;
        }
        self.mb_link = self
            .handles
            .iter()
            .map(|h| self.physics.multibody_joints.rigid_body_link(*h).expect("own body").id)
            .collect();
    }

    fn read_state(&mut self) {
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

impl Engine for World {
    const NAME: &'static str = "rapier";

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

    fn set_masses(&mut self, character: &Character) -> Result<(), WorldError> {
        let model = Model::new(character, self.settings.gravity);
        let root = &model.bodies[0];
        if matches!(root.joint, Joint::Free) && root.com != self.root_shift {
            // the frame of the root sits at its centre of mass: a new one is built around it
            let mut world = World::new(character, self.settings, &self.q, &self.v)?;
            world.stops = std::mem::take(&mut self.stops);
            world.steps = self.steps;
            *self = world;
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
            // muscle and stop side by side: one spring of both stiffnesses with their common torque
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

    fn step(&mut self) -> Result<(), WorldError> {
        self.physics.step();
        self.steps += 1;
        for &h in &self.handles {
            let body = &mut self.physics.bodies[h];
            body.reset_forces(true);
            body.reset_torques(true);
        }
        self.read_state();
        for b in &self.model.bodies {
            let q = &self.q[b.q_at..b.q_at + b.joint.nq()];
            let v = &self.v[b.v_at..b.v_at + b.joint.nv()];
            if q.iter().any(|x| !x.is_finite()) || v.iter().any(|x| x.is_nan() || x.abs() >= RUNAWAY) {
                return Err(WorldError::Diverged {
                    step: self.steps,
                    time_s: self.steps as f64 / self.settings.rate_hz,
                    body: self.model.skeleton.links()[b.link].name.clone(),
                });
            }
        }
        Ok(())
    }

    fn contacts(&self, row: usize, out: &mut Vec<ContactSample>) {
        self.read_contacts(row, out);
    }
}

fn mass_properties(b: &MovingBody, shift: &Vec3) -> rp::MassProperties {
    let inertia = rp::Matrix::from_cols_array_2d(&b.inertia.into());
    rp::MassProperties::with_inertia_matrix(to_glam(b.com - shift), b.mass, inertia)
}

fn groups(own: rp::Group, other: rp::Group) -> rp::InteractionGroups {
    rp::InteractionGroups::new(own, other, rp::InteractionTestMode::And)
}

fn collider(shape: &Shape, frame: &Transform) -> rp::ColliderBuilder {
    let at = |p: &Vec3| to_glam((frame * nalgebra::Point3::from(*p)).coords);
    match shape {
        Shape::Capsule { a, b, radius } => rp::ColliderBuilder::capsule_from_endpoints(at(a), at(b), *radius),
        Shape::Sphere { center, radius } => rp::ColliderBuilder::ball(*radius).translation(at(center)),
        Shape::Box { center, half, rotation } => {
            let local = Transform::from_parts((*center).into(), *rotation);
            rp::ColliderBuilder::cuboid(half.x, half.y, half.z).position(pose(&(frame * local)))
        }
        Shape::Cone { a, b, radius_a, .. } => {
            let corners: Vec<_> = shape.rims().iter().map(at).collect();
            // rims of positive radius apart from each other always have a hull; if rounding ate it, a rod stands in
            rp::ColliderBuilder::convex_hull(&corners)
                .unwrap_or_else(|| rp::ColliderBuilder::capsule_from_endpoints(at(a), at(b), *radius_a))
        }
    }
}

fn joint(joint: &Joint, parent_from_zero: &Transform, parent_shift: Vec3) -> rp::GenericJoint {
    use rp::JointAxesMask as Mask;
    // hinges and slides of rapier run along x of the joint frame
    let to_x = |axis: &Vec3| motion::rotation::between(&Vec3::x(), axis);
    let (locked, frame) = match joint {
        Joint::Free => (Mask::empty(), Quat::identity()),
        Joint::Spherical => (Mask::LIN_AXES, Quat::identity()),
        Joint::Revolute(axis) => (Mask::LIN_AXES | Mask::ANG_Y | Mask::ANG_Z, to_x(axis)),
        Joint::Prismatic(axis) => (Mask::LIN_Y | Mask::LIN_Z | Mask::ANG_AXES, to_x(axis)),
        Joint::Fixed => (Mask::all(), Quat::identity()),
    };
    let frame1 = nalgebra::Translation3::from(-parent_shift) * parent_from_zero * frame;
    let frame2 = Transform::from_parts(Vec3::zeros().into(), frame);
    rp::GenericJointBuilder::new(locked)
        .local_frame1(pose(&frame1))
        .local_frame2(pose(&frame2))
        .contacts_enabled(false)
        .build()
}

pub(crate) fn to_glam(v: Vec3) -> rp::Vector {
    rp::Vector::new(v.x, v.y, v.z)
}

pub(crate) fn from_glam(v: rp::Vector) -> Vec3 {
    Vec3::new(v.x, v.y, v.z)
}

fn from_rot(r: rp::Rotation) -> Quat {
    Quat::new_normalize(nalgebra::Quaternion::new(r.w, r.x, r.y, r.z))
}

fn pose(t: &Transform) -> rp::Pose {
    let r = t.rotation;
    rp::Pose::from_parts(to_glam(t.translation.vector), rp::Rotation::from_xyzw(r.i, r.j, r.k, r.w))
}
