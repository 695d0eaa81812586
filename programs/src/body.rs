//! What a program sees of the simulated body: `fn react(body, params)`.
//!
//! In: a [`ControlStep`]. Out: for every joint by how much its goal is turned, and the factor on its tension. What a program is handed are
//! `body` and `muscle` (a joint with muscles), named places in one copy of the state, which is filled anew every step; what was written
//! holds for one step. World frame, Y up.

use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

use controllers::ControlStep;
use dynamics::{ContactSample, Model, State};
use motion::names::hint;
use motion::skeleton::vec_at;
use motion::{Dof, Joint, Skeleton, Value, Vec3};
use rhai::{Array, Dynamic, Engine, ImmutableString, Map};

use crate::error::refuse;
use crate::frames::{joints_of, place};
use crate::values::{self, Answer, list, within};

/// The most by which a goal may be turned, degrees.
const MOST_TURN_DEG: f64 = 180.0;
/// The least and the largest factor on a tension.
const TENSION: (f64, f64) = (0.05, 20.0);

/// The state of a step, and what a program wrote.
pub(crate) struct Sensed {
    model: Arc<Model>,
    state: State,
    time_s: f64,
    dt_s: f64,
    q: Vec<f64>,
    v: Vec<f64>,
    goal_q: Vec<f64>,
    goal_v: Vec<f64>,
    com: Vec3,
    com_velocity: Vec3,
    contacts: Vec<ContactSample>,
    /// Joints that muscles move: name, body, degree of freedom.
    muscles: BTreeMap<String, (usize, Dof)>,
    /// Turn of the goal of each body's joint, rad; in `.x` for a hinge.
    pub(crate) turns: Vec<Vec3>,
    /// Factor on the tension of each body's joint.
    pub(crate) tension: Vec<f64>,
}

/// Whether two models move alike: what is carried changes masses.
fn same(a: &Model, b: &Model) -> bool {
    Arc::ptr_eq(&a.skeleton, &b.skeleton)
        && a.bodies.iter().zip(&b.bodies).all(|(a, b)| a.mass == b.mass && a.com == b.com)
}

impl Sensed {
    /// Of a body in its first step.
    pub(crate) fn new(model: &Model) -> Self {
        let s = &model.skeleton;
        let moved = |(i, b): (usize, &dynamics::MovingBody)| match b.joint {
            Joint::Revolute(_) | Joint::Spherical => {
                Some((s.links()[b.link].name.clone(), (i, Dof::of_link(s, b.link)?)))
            }
            Joint::Free | Joint::Prismatic(_) | Joint::Fixed => None,
        };
        Self {
            state: State::new(model),
            model: Arc::new(model.clone()),
            time_s: 0.0,
            dt_s: 0.0,
            q: Vec::new(),
            v: Vec::new(),
            goal_q: Vec::new(),
            goal_v: Vec::new(),
            com: Vec3::zeros(),
            com_velocity: Vec3::zeros(),
            contacts: Vec::new(),
            muscles: model.bodies.iter().enumerate().filter_map(moved).collect(),
            turns: vec![Vec3::zeros(); model.bodies.len()],
            tension: vec![1.0; model.bodies.len()],
        }
    }

    /// Takes in a step; its time is counted from `by_s` on.
    pub(crate) fn fill(&mut self, step: &ControlStep<'_>, by_s: f64) {
        if !same(&self.model, step.model) {
            self.model = Arc::new(step.model.clone());
        }
        (self.time_s, self.dt_s) = (step.time_s + by_s, step.dt);
        for (to, from) in [
            (&mut self.q, step.q),
            (&mut self.v, step.v),
            (&mut self.goal_q, step.goal_q),
            (&mut self.goal_v, step.goal_v),
        ] {
            to.clear();
            to.extend_from_slice(from);
        }
        self.contacts.clear();
        self.contacts.extend_from_slice(step.contacts);
        self.state.update(step.model, step.q, step.v);
        self.com = self.state.com(step.model);
        self.com_velocity = self.state.momentum(step.model).linear / step.model.mass;
        self.forget();
    }

    /// Takes back what was written.
    pub(crate) fn forget(&mut self) {
        self.turns.fill(Vec3::zeros());
        self.tension.fill(1.0);
    }

    fn skeleton(&self) -> &Skeleton {
        &self.model.skeleton
    }

    /// Names of joints with their bodies and degrees of freedom.
    pub(crate) fn muscles(&self) -> &BTreeMap<String, (usize, Dof)> {
        &self.muscles
    }

    fn muscle(&self, name: &str) -> Answer<(usize, Dof)> {
        match self.muscles.get(name) {
            Some(found) => Ok(*found),
            None => refuse(format!(
                "there is no joint `{name}` that muscles move{}",
                hint(name, self.muscles.keys().map(String::as_str))
            )),
        }
    }

    fn rate(&self, v: &[f64], body: usize) -> Dynamic {
        let b = &self.model.bodies[body];
        match b.joint {
            Joint::Spherical => list(vec_at(v, b.v_at).map(f64::to_degrees).into()),
            _ => v[b.v_at].to_degrees().into(),
        }
    }

    /// The goal of a joint without and with its turn, within the limits of the joint.
    pub(crate) fn goals(&self, body: usize, dof: Dof) -> (Value, Value) {
        let asked = dof.read(self.skeleton(), &self.goal_q);
        let turned = values::turned(&asked, &self.turns[body]);
        (asked, edits::poses::within_limits(self.skeleton(), dof, &asked, &turned).0)
    }
}

type Shared = Arc<RwLock<Sensed>>;

/// `body`.
#[derive(Clone)]
pub(crate) struct BodyHandle(Shared);

impl BodyHandle {
    pub(crate) fn new(model: &Model) -> Self {
        Self(Arc::new(RwLock::new(Sensed::new(model))))
    }

    /// The state, to be read.
    pub(crate) fn read(&self) -> RwLockReadGuard<'_, Sensed> {
        self.0.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// The state, to be written.
    pub(crate) fn write(&self) -> RwLockWriteGuard<'_, Sensed> {
        self.0.write().unwrap_or_else(PoisonError::into_inner)
    }
}

/// `muscle`: a joint that muscles move.
#[derive(Clone)]
pub(crate) struct MuscleHandle(BodyHandle, usize, Dof);

/// Sum of the forces on a link, N.
fn force(body: &Sensed, link: usize) -> Vec3 {
    body.contacts.iter().filter(|c| c.link == link).map(|c| c.force).sum()
}

/// Makes the values of this module known to the language.
pub(crate) fn register(e: &mut Engine) {
    e.register_type_with_name::<BodyHandle>("body").register_type_with_name::<MuscleHandle>("muscle");
    e.register_get("time_s", |b: &mut BodyHandle| b.read().time_s)
        .register_get("dt_s", |b: &mut BodyHandle| b.read().dt_s)
        .register_get("mass_kg", |b: &mut BodyHandle| b.read().model.mass)
        .register_get("com_m", |b: &mut BodyHandle| list(b.read().com.into()))
        .register_get("com_m_s", |b: &mut BodyHandle| list(b.read().com_velocity.into()))
        .register_get("contacts", |b: &mut BodyHandle| -> Array {
            let body = b.read();
            let one = |c: &ContactSample| {
                let name = ImmutableString::from(body.skeleton().links()[c.link].name.as_str());
                let mut map = Map::new();
                map.insert("link".into(), name.into());
                map.insert("point_m".into(), list(c.point.into()));
                map.insert("force_n".into(), list(c.force.into()));
                Dynamic::from_map(map)
            };
            body.contacts.iter().map(one).collect()
        })
        .register_fn("force_n", |b: &mut BodyHandle, name: &str| -> Answer<Dynamic> {
            let body = b.read();
            let (link, _) = place(body.skeleton(), name)?;
            Ok(list(force(&body, link).into()))
        })
        .register_fn("place_m", |b: &mut BodyHandle, name: &str| -> Answer<Dynamic> {
            let body = b.read();
            let (link, at) = place(body.skeleton(), name)?;
            Ok(list(body.state.point(&body.model, link, &at).into()))
        })
        .register_fn("speed_m_s", |b: &mut BodyHandle, name: &str| -> Answer<Dynamic> {
            let body = b.read();
            let (link, at) = place(body.skeleton(), name)?;
            Ok(list(body.state.point_velocity(&body.model, link, &at).into()))
        })
        .register_fn("joints", |b: &mut BodyHandle, part: &str| -> Answer<Array> {
            let body = b.read();
            let mut all = joints_of(body.skeleton(), part)?;
            all.retain(|name| {
                name.clone().into_immutable_string().is_ok_and(|n| body.muscles.contains_key(n.as_str()))
            });
            Ok(all)
        })
        .register_indexer_get(|b: &mut BodyHandle, name: &str| -> Answer<MuscleHandle> {
            let (body, dof) = b.read().muscle(name)?;
            Ok(MuscleHandle(b.clone(), body, dof))
        });
    register_muscle(e);
}

fn register_muscle(e: &mut Engine) {
    e.register_get("angle_deg", |m: &mut MuscleHandle| {
        let body = m.0.read();
        let s = body.skeleton();
        values::deg(s, m.2, &m.2.read(s, &body.q), "angle_deg")
    })
    .register_get("goal_deg", |m: &mut MuscleHandle| {
        let body = m.0.read();
        let s = body.skeleton();
        values::deg(s, m.2, &m.2.read(s, &body.goal_q), "goal_deg")
    })
    .register_get("off_deg", |m: &mut MuscleHandle| -> Dynamic {
        let body = m.0.read();
        let s = body.skeleton();
        match (m.2.read(s, &body.goal_q), m.2.read(s, &body.q)) {
            (Value::Rotation(goal), Value::Rotation(now)) => list(values::rotation_between(&goal, &now)),
            (Value::Scalar(goal), Value::Scalar(now)) => (now - goal).to_degrees().into(),
            // a joint has one kind of value
            _ => Dynamic::UNIT,
        }
    })
    .register_get("rate_deg_s", |m: &mut MuscleHandle| {
        let body = m.0.read();
        body.rate(&body.v, m.1)
    })
    .register_get("goal_rate_deg_s", |m: &mut MuscleHandle| {
        let body = m.0.read();
        body.rate(&body.goal_v, m.1)
    })
    .register_get_set(
        "turn_deg",
        |m: &mut MuscleHandle| -> Dynamic {
            let turn = m.0.read().turns[m.1].map(f64::to_degrees);
            if m.2.is_rotation() { list(turn.into()) } else { turn.x.into() }
        },
        |m: &mut MuscleHandle, by: Dynamic| -> Answer<()> {
            let turn = values::turn(m.0.read().skeleton(), m.2, &by, "turn_deg")?;
            let deg = turn.norm().to_degrees();
            if deg > MOST_TURN_DEG {
                return refuse(format!("turn_deg turns by {deg:.0}°; allowed: up to {MOST_TURN_DEG}°"));
            }
            m.0.write().turns[m.1] = turn;
            Ok(())
        },
    )
    .register_get_set(
        "tension",
        |m: &mut MuscleHandle| -> Dynamic { m.0.read().tension[m.1].into() },
        |m: &mut MuscleHandle, factor: Dynamic| -> Answer<()> {
            let factor = within("tension", &factor, TENSION.0, TENSION.1)?;
            m.0.write().tension[m.1] = factor;
            Ok(())
        },
    );
}
