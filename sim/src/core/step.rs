//! Stepping: drives, root path, wrenches and the step itself, as [`Engine`] asks for them.

use bodies::Character;
use controllers::{Drive, Rest};
use dynamics::{Against, Model, State, Wrench};
use motion::rotation::log;
use motion::skeleton::{quat_at, vec_at};
use motion::{Floor, Joint, Vec3};

use super::shapes::{ENDS, MANIFOLD};
use super::{Core, NAME, Touch};
use crate::{ContactForce, Engine, EngineError, Impulse, Ledger};

impl Engine for Core {
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
        self.stops.copy_from_slice(stiffness);
    }

    fn set_masses(&mut self, character: &Character) -> Result<(), EngineError> {
        self.model = Model::new(character, self.settings.gravity);
        self.state.update(&self.model, &self.q, &self.v);
        Ok(())
    }

    fn set_drives(&mut self, drives: &[Drive]) {
        for (i, drive) in drives.iter().enumerate() {
            let b = &self.model.bodies[i];
            if matches!(b.joint, Joint::Free | Joint::Fixed) {
                continue;
            }
            // muscle and stop act in parallel: one spring with the sum of their stiffnesses and of their torques
            let (stop, back) = self.stop(i).unwrap_or((0.0, Vec3::zeros()));
            let muscle = match drive.rest {
                Rest::Scalar(rest) => Vec3::x() * (rest - self.q[b.q_at]),
                Rest::Ball { .. } => drive.pull(&quat_at(&self.q, b.q_at)),
                Rest::None => Vec3::zeros(),
            };
            let stiffness = drive.stiffness + stop;
            let away = (muscle * drive.stiffness + back * stop) / stiffness.max(f64::MIN_POSITIVE);
            let dofs = b.v_at..b.v_at + b.joint.nv();
            self.stiffness[dofs.clone()].fill(stiffness);
            self.damping[dofs.clone()].fill(drive.damping);
            self.rest[dofs.clone()].copy_from_slice(&away.as_slice()[..dofs.len()]);
        }
    }

    fn move_root(&mut self, _: &State, q_next: &[f64]) {
        if self.held() == 0 {
            return;
        }
        let b = &self.model.bodies[0];
        let rate = self.settings.rate_hz;
        let linear = (vec_at(q_next, b.q_at) - vec_at(&self.q, b.q_at)) * rate;
        let turn = quat_at(q_next, b.q_at + 3) * quat_at(&self.q, b.q_at + 3).inverse();
        let angular = log(&turn) * rate;
        self.path = Some(std::array::from_fn(|k| if k < 3 { linear[k] } else { angular[k - 3] }));
    }

    fn turn_ground(&mut self, up: &Vec3) {
        let Some(ground) = self.settings.ground.filter(|g| g.turns) else { return };
        let next = Floor { up: *up, ..ground };
        self.ground_rate = log(&(next.turn() * ground.turn().inverse())) * self.settings.rate_hz;
        self.next_up = *up;
    }

    fn add_wrench(&mut self, w: &Wrench) {
        self.wrenches.push(*w);
    }

    fn step(&mut self) -> Result<(), EngineError> {
        self.forget_touches();
        self.ledger.root_correction = Impulse::default();
        self.ledger.root_correction_j = 0.0;
        self.gained = 0.0;
        self.steps += 1;
        let substeps = self.settings.substeps;
        let dt = 1.0 / (self.settings.rate_hz * substeps as f64);
        let mut failed = Ok(());
        for k in 0..substeps {
            failed = self.advance(dt * k as f64, dt, 0);
            if failed.is_err() {
                break;
            }
        }
        self.wrenches.clear();
        if let Some(ground) = &mut self.settings.ground {
            ground.up = self.next_up;
            self.ground_rate = Vec3::zeros();
        }
        self.path = None;
        self.ledger.steps += 1;
        self.ledger.correction_squared += self.ledger.root_correction.linear.norm_squared();
        if let Err(dof) = failed {
            return Err(self.diverged(self.joint_of(dof)));
        }
        match self.runaway() {
            None => Ok(()),
            Some(body) => Err(self.diverged(body)),
        }
    }

    fn ledger(&self) -> Option<&Ledger> {
        Some(&self.ledger)
    }

    fn contacts(&self, out: &mut Vec<ContactForce>) {
        let shapes = &self.shapes;
        let link = |body: usize| self.model.bodies[body].link;
        for group in &shapes.groups {
            for touch in &self.touches[group.from..group.to] {
                out.extend(self.force(touch, link(group.body), Against::Ground));
            }
            for solid in group.solids.clone() {
                for prop in 0..shapes.props.len() {
                    let first = shapes.on_prop(solid, prop);
                    for touch in &self.touches[first..first + MANIFOLD] {
                        out.extend(self.force(touch, link(group.body), Against::Prop(prop)));
                    }
                }
            }
        }
        for (number, pair) in shapes.pairs.iter().enumerate() {
            let first = shapes.of_pair(number);
            let [one, other] = pair.links;
            for touch in &self.touches[first..first + ENDS] {
                let on_one = self.force(touch, one, Against::Link(other));
                let back = |c: ContactForce| ContactForce {
                    link: other,
                    against: Against::Link(one),
                    force: -c.force,
                    ..c
                };
                out.extend(on_one.into_iter().chain(on_one.map(back)));
            }
        }
    }
}

impl Core {
    fn force(&self, touch: &Touch, link: usize, against: Against) -> Option<ContactForce> {
        (touch.weight > 0.0).then(|| ContactForce {
            link,
            against,
            point: touch.place / touch.weight,
            force: touch.impulse * self.settings.rate_hz,
            depth: touch.depth,
        })
    }

    fn diverged(&self, body: &str) -> EngineError {
        EngineError::Diverged {
            step: self.steps,
            time_s: self.steps as f64 / self.settings.rate_hz,
            body: body.into(),
        }
    }
}
