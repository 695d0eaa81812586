//! Building: bodies, colliders, joints and the ground of a character in rapier.
//!
//! In: a character, settings, a pose and a velocity. Out: a [`Rapier`] in that state.

use bodies::Character;
use dynamics::{Model, MovingBody, State};
use motion::{Joint, Quat, Shape, Transform, Vec3};
use rapier3d::dynamics::FrictionModel;
use rapier3d::prelude as rp;

use super::{Rapier, pose, to_glam};
use crate::{ContactLaw, EngineError, EngineSettings};

/// Factor on the engine's natural frequencies of contacts. At 1 feet sink deeper the smaller the step, because
/// the compliance follows the apparent mass M + dt D + dt² K: 0.15 mm at 240 Hz, 0.63 mm at 1920 Hz under
/// the bow, and knees drift with it. At 4 it is 0.014 mm at 240 Hz, and the run converges.
const CONTACT_STIFFENING: f64 = 4.0;

/// Gauss–Seidel sweeps over the contact rows of spring contacts.
const SPRING_SWEEPS: usize = 50;

impl Rapier {
    /// Builds the body at the pose `q` with the velocity `v`.
    ///
    /// # Errors
    /// [`EngineError::RootFrame`], [`EngineError::Joint`]; [`EngineError::Failed`] for compliant contacts.
    pub fn new(
        character: &Character,
        settings: EngineSettings,
        q: &[f64],
        v: &[f64],
    ) -> Result<Self, EngineError> {
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
                // contacts with ground that turns use the dynamic softness: as stiff as with fixed ground
                p.contact_softness = p.static_contact_softness;
            }
            ContactLaw::Spring { natural_frequency_hz, damping_ratio } => {
                let law = rp::SpringCoefficients { natural_frequency: natural_frequency_hz, damping_ratio };
                p.contact_softness = law;
                p.static_contact_softness = law;
                // stabilization iterations solve without bias, which makes contacts inelastic; springs need converged rows instead
                p.num_internal_stabilization_iterations = 0;
                p.num_internal_pgs_iterations = SPRING_SWEEPS;
                // predicted contacts, before they touch, are rigid whatever the softness: predict none
                p.normalized_prediction_distance = 0.0;
            }
            ContactLaw::Compliant { .. } => {
                let why = "rapier's contact springs are per apparent mass, not in N/m; compliant contacts need the core";
                return Err(EngineError::Failed(why.into()));
            }
        }

        let root = &model.bodies[0];
        let free_root = matches!(root.joint, Joint::Free);
        if free_root && root.parent_from_zero != Transform::identity() {
            return Err(EngineError::RootFrame(character.skeleton.links()[root.link].name.clone()));
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
        let frictions = Frictions::of(&settings);
        let touching = if settings.self_collision { Touching::new(character) } else { Touching::default() };
        for (i, body) in character.bodies.iter().enumerate() {
            let (owner, owner_from_link) = model.body_of[i];
            let frame = nalgebra::Translation3::from(-shift_of(owner)) * owner_from_link;
            for (k, shape) in body.shapes.iter().enumerate() {
                let mut collider = collider(shape, &frame)
                    .density(0.0)
                    .friction(frictions.body)
                    .user_data(shape_key(i, k))
                    .collision_groups(groups(rp::Group::GROUP_1, rp::Group::GROUP_2));
                if touching.contains(i, k) {
                    collider = collider.active_hooks(rp::ActiveHooks::FILTER_CONTACT_PAIRS).collision_groups(
                        groups(rp::Group::GROUP_1, rp::Group::GROUP_1 | rp::Group::GROUP_2),
                    );
                }
                physics.insert_collider(collider, Some(handles[owner]));
            }
        }
        let props = settings
            .props
            .iter()
            .map(|prop| {
                let collider = rp::ColliderBuilder::cuboid(prop.half.x, prop.half.y, prop.half.z)
                    .position(pose(&prop.place));
                physics.insert_collider(frictions.world(collider, prop.friction), None)
            })
            .collect();
        let mut turning = None;
        if let Some(ground) = settings.ground {
            let plane = |up: Vec3| {
                let plane = rp::ColliderBuilder::halfspace(nalgebra::Unit::new_unchecked(to_glam(up)));
                frictions.world(plane, ground.friction)
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
                .ok_or_else(|| EngineError::Joint(character.skeleton.links()[b.link].name.clone()))?;
            any_joint = Some(handle);
        }
        let bodies = model.bodies.len();
        let mut built = Self {
            physics,
            model,
            settings,
            handles,
            props,
            touching,
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
        built.prepare();
        built.set_state(q, v);
        Ok(built)
    }

    fn prepare(&mut self) {
        let Some(any) = self.any_joint else { return };
        let (mb, _) = self.physics.multibody_joints.get_mut(any).expect("own joint");
        mb.set_self_contacts_enabled(self.settings.self_collision);
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
}

/// Friction of colliders, so that each pair has the coefficient that it should.
struct Frictions {
    /// Of the body's.
    body: f64,
    /// Whether the world's are told as multiples of it.
    relative: bool,
}

impl Frictions {
    /// Where only the ground is touched, its coefficient is the body's too. Else the body has one of its own, which holds between
    /// links, and the ground and each prop have theirs.
    fn of(settings: &EngineSettings) -> Self {
        let relative = settings.self_collision || !settings.props.is_empty();
        let ground = settings.ground.map_or(0.0, |g| g.friction);
        Self { body: if relative { motion::floor::FRICTION } else { ground }, relative }
    }

    fn world(&self, collider: rp::ColliderBuilder, friction: f64) -> rp::ColliderBuilder {
        let collider = collider.collision_groups(groups(rp::Group::GROUP_2, rp::Group::GROUP_1));
        if self.relative {
            let product = rp::CoefficientCombineRule::Multiply;
            collider.friction(friction / self.body).friction_combine_rule(product)
        } else {
            collider.friction(friction)
        }
    }
}

/// A shape of a link as a collider's user data.
fn shape_key(link: usize, shape: usize) -> u128 {
    (link as u128) << 64 | shape as u128
}

/// Which shapes of the body touch each other: rapier asks for each pair that comes near.
#[derive(Debug, Default)]
pub(super) struct Touching {
    /// Sorted, the lesser first.
    pairs: Vec<[u128; 2]>,
    /// Sorted.
    shapes: Vec<u128>,
}

impl Touching {
    fn new(character: &Character) -> Self {
        let all = character.capsules();
        let key = |c: usize| shape_key(all[c].link, all[c].shape);
        let mut pairs: Vec<[u128; 2]> = character
            .self_pairs()
            .into_iter()
            .map(|[i, j]| [key(i).min(key(j)), key(i).max(key(j))])
            .collect();
        pairs.sort_unstable();
        let mut shapes: Vec<u128> = pairs.iter().flatten().copied().collect();
        shapes.sort_unstable();
        shapes.dedup();
        Self { pairs, shapes }
    }

    fn contains(&self, link: usize, shape: usize) -> bool {
        self.shapes.binary_search(&shape_key(link, shape)).is_ok()
    }
}

impl rp::PhysicsHooks for Touching {
    fn filter_contact_pair(&self, pair: &rp::PairFilterContext<'_>) -> Option<rp::SolverFlags> {
        let [one, other] = [pair.collider1, pair.collider2].map(|c| &pair.colliders[c]);
        let world = one.parent().is_none_or(|b| !pair.bodies[b].is_dynamic())
            || other.parent().is_none_or(|b| !pair.bodies[b].is_dynamic());
        let (a, b) = (one.user_data, other.user_data);
        let allowed = world || self.pairs.binary_search(&[a.min(b), a.max(b)]).is_ok();
        allowed.then_some(rp::SolverFlags::COMPUTE_RIGID_IMPULSES)
    }
}

pub(super) fn mass_properties(b: &MovingBody, shift: &Vec3) -> rp::MassProperties {
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
            let corners: Vec<_> = standing_rims(shape).iter().map(at).collect();
            // two rims of positive radius have a hull; where rounding leaves none, a capsule replaces it
            rp::ColliderBuilder::convex_hull(&corners)
                .unwrap_or_else(|| rp::ColliderBuilder::capsule_from_endpoints(at(a), at(b), *radius_a))
        }
    }
}

/// How far four points of a rim stand out along the axis, over its radius.
const PROUD: f64 = 1e-3;

/// The rims of a cone, four evenly spread points of each a little outside. parry 0.31 touches with the first four corners of a
/// face, which of a round one are neighbours: a cone that stands would touch at one side only, and tip over. So the face that
/// touches first has four corners all round.
fn standing_rims(cone: &Shape) -> Vec<Vec3> {
    let mut rims = cone.rims();
    let Shape::Cone { a, b, radius_a, radius_b } = cone else { return rims };
    let outward = (a - b).try_normalize(0.0).unwrap_or_default();
    let around = rims.len() / 2;
    for (i, point) in rims.iter_mut().enumerate() {
        let (end, k) = (i / around, i % around);
        if 4 * k % around == 0 {
            *point += if end == 0 { outward * (PROUD * radius_a) } else { outward * (-PROUD * radius_b) };
        }
    }
    rims
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
