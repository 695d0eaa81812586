//! Snapshots: the whole state of a core, saved and restored without allocation.
//!
//! In: a [`Core`]. Out: everything the next step depends on: pose, velocity, springs, stops, forces that contacts start from, the
//! ground and how it turns, the root's path, wrenches that wait, masses. What a step overwrites is not in it, the contacts
//! on record ([`Engine::contacts`](crate::Engine::contacts)) least of all: there are none between a restore and the next step.

use dynamics::Wrench;
use motion::Vec3;
use nalgebra::Matrix3;

use super::Core;

/// The state of a [`Core`]. See the module header.
#[derive(Clone, Debug)]
pub struct Snapshot {
    q: Vec<f64>,
    v: Vec<f64>,
    steps: usize,
    stops: Vec<f64>,
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    rest: Vec<f64>,
    trend: Vec<f64>,
    forces: Vec<[f64; 3]>,
    path: Option<[f64; 6]>,
    up: Vec3,
    next_up: Vec3,
    ground_rate: Vec3,
    wrenches: Vec<Wrench>,
    mass: f64,
    masses: Vec<(f64, Vec3, Matrix3<f64>)>,
}

impl Snapshot {
    /// Pose, `nq`.
    pub fn q(&self) -> &[f64] {
        &self.q
    }

    /// Velocity, `nv`.
    pub fn v(&self) -> &[f64] {
        &self.v
    }

    /// Bytes it takes.
    pub fn bytes(&self) -> usize {
        let numbers = self.q.capacity()
            + self.v.capacity()
            + self.stops.capacity()
            + self.stiffness.capacity()
            + self.damping.capacity()
            + self.rest.capacity()
            + self.trend.capacity();
        size_of::<Self>()
            + size_of::<f64>() * numbers
            + size_of::<[f64; 3]>() * self.forces.capacity()
            + size_of::<Wrench>() * self.wrenches.capacity()
            + size_of::<(f64, Vec3, Matrix3<f64>)>() * self.masses.capacity()
    }
}

impl Core {
    /// The state, in memory of its own.
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            q: self.q.clone(),
            v: self.v.clone(),
            steps: self.steps,
            stops: self.stops.clone(),
            stiffness: self.stiffness.clone(),
            damping: self.damping.clone(),
            rest: self.rest.clone(),
            trend: self.trend.clone(),
            forces: self.forces.clone(),
            path: self.path,
            up: self.up(),
            next_up: self.next_up,
            ground_rate: self.ground_rate,
            wrenches: self.wrenches.clone(),
            mass: self.model.mass,
            masses: self.model.bodies.iter().map(|b| (b.mass, b.com, b.inertia)).collect(),
        }
    }

    /// Writes the state into a snapshot of a core of the same body; does not allocate while no more wrenches wait than it has held.
    pub fn save(&self, to: &mut Snapshot) {
        to.q.copy_from_slice(&self.q);
        to.v.copy_from_slice(&self.v);
        to.steps = self.steps;
        to.stops.copy_from_slice(&self.stops);
        to.stiffness.copy_from_slice(&self.stiffness);
        to.damping.copy_from_slice(&self.damping);
        to.rest.copy_from_slice(&self.rest);
        to.trend.copy_from_slice(&self.trend);
        to.forces.copy_from_slice(&self.forces);
        to.path = self.path;
        (to.up, to.next_up, to.ground_rate) = (self.up(), self.next_up, self.ground_rate);
        to.wrenches.clone_from(&self.wrenches);
        to.mass = self.model.mass;
        for (to, b) in to.masses.iter_mut().zip(&self.model.bodies) {
            *to = (b.mass, b.com, b.inertia);
        }
    }

    /// Takes the state of a snapshot of a core of the same body and settings; does not allocate while no more wrenches wait
    /// than it has held.
    ///
    /// # Panics
    /// If the snapshot is of another body.
    pub fn restore(&mut self, from: &Snapshot) {
        self.q.copy_from_slice(&from.q);
        self.v.copy_from_slice(&from.v);
        self.steps = from.steps;
        self.stops.copy_from_slice(&from.stops);
        self.stiffness.copy_from_slice(&from.stiffness);
        self.damping.copy_from_slice(&from.damping);
        self.rest.copy_from_slice(&from.rest);
        self.trend.copy_from_slice(&from.trend);
        self.forces.copy_from_slice(&from.forces);
        self.path = from.path;
        if let Some(ground) = &mut self.settings.ground {
            ground.up = from.up;
        }
        (self.next_up, self.ground_rate) = (from.next_up, from.ground_rate);
        self.wrenches.clone_from(&from.wrenches);
        self.model.mass = from.mass;
        for (b, from) in self.model.bodies.iter_mut().zip(&from.masses) {
            (b.mass, b.com, b.inertia) = *from;
        }
        self.state.update(&self.model, &self.q, &self.v);
        self.forget_touches();
    }

    fn up(&self) -> Vec3 {
        self.settings.ground.map_or(Vec3::y(), |g| g.up)
    }
}

#[cfg(test)]
mod tests {
    use bodies::anthropometry::human::human;
    use controllers::{Drive, Rest};
    use motion::{Floor, Vec3};

    use super::*;
    use crate::{Engine, EngineSettings};

    impl Core {
        /// Fills everything that a step overwrites with numbers that spoil what reads them.
        fn spoil(&mut self) {
            let bad = f64::NAN;
            self.factor.spoil();
            for scratch in [
                &mut self.force,
                &mut self.change,
                &mut self.expected,
                &mut self.free,
                &mut self.before,
                &mut self.before_v,
            ] {
                scratch.fill(bad);
            }
            for b in &mut self.state.bodies {
                b.com = Vec3::repeat(bad);
                b.omega = Vec3::repeat(bad);
                b.velocity = Vec3::repeat(bad);
                b.inertia.fill(bad);
                b.rotation.fill(bad);
                b.zero.fill(bad);
                b.world.translation.vector = Vec3::repeat(bad);
            }
            for c in &mut self.contacts {
                c.rows = [[bad; 6]; 3];
                c.depth = bad;
            }
            self.solver.spoil();
        }
    }

    /// What a step reads beside the snapshot is nothing: from memory full of NaN a limp body falls to the same bytes.
    #[test]
    fn nothing_but_the_snapshot_matters() {
        let c = human().0;
        let settings = EngineSettings::free(240.0, 2, Some(Floor::level(0.0, 0.8)));
        let mut core = Core::new(&c, settings, &c.rest, &vec![0.0; c.skeleton.nv()]).unwrap();
        let limp = vec![Drive { stiffness: 20.0, damping: 2.0, rest: Rest::None }; core.model.bodies.len()];
        for start in [0, 60, 200] {
            for _ in 0..start {
                core.set_drives(&limp);
                core.step().unwrap();
            }
            let saved = core.snapshot();
            let run = |core: &mut Core| {
                for _ in 0..20 {
                    core.set_drives(&limp);
                    core.step().unwrap();
                }
                core.q().iter().chain(core.v()).map(|x| x.to_bits()).collect::<Vec<_>>()
            };
            let first = run(&mut core);
            core.spoil();
            core.restore(&saved);
            assert!(run(&mut core) == first, "after {start} steps");
        }
    }
}
