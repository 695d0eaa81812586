//! Traces: everything a dynamic run recorded, one row per control step.
//!
//! Row `k` holds the state at `k / rate_hz` and the forces that acted during the step that led to it,
//! so that `momentum[k] − momentum[k−1] = (m g + Σ contacts[k] + root_wrench[k] + disturbed.wrench[k]) / rate_hz`,
//! m with what is carried. Row 0 is the start: its forces are zero. SI units, world frame unless said; layouts of `q` and `v` are
//! those of [`motion::skeleton`].

use std::sync::Arc;

use motion::{Clip, ContactPlan, Quat, Vec3};

use bodies::{Carried, Character, Prop};

use crate::RootMode;

/// What a link touches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Against {
    /// The ground.
    #[default]
    Ground,
    /// A prop, by its number.
    Prop(usize),
    /// Another link of the same body.
    Link(usize),
}

impl Against {
    /// Whether it is the world: its force is an outside force.
    pub fn is_world(self) -> bool {
        !matches!(self, Self::Link(_))
    }
}

/// Force at one contact point during one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactSample {
    /// Row of the trace.
    pub row: usize,
    /// Link that is touched.
    pub link: usize,
    /// What it touches. Where that is another link, there are two samples at one point: equal and opposite forces.
    pub against: Against,
    /// Point of contact, world, m.
    pub point: Vec3,
    /// Force on the link, mean over the step, world, N.
    pub force: Vec3,
    /// Depth of penetration, m (negative when apart).
    pub depth: f64,
}

/// A mass that is carried for a part of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Handed {
    /// The mass.
    pub what: Carried,
    /// First row whose forces move it.
    pub from_row: usize,
    /// First row whose forces move it no more; beyond the last row if it is kept.
    pub to_row: usize,
}

impl Handed {
    /// Whether the forces of a row move it.
    pub fn in_row(&self, row: usize) -> bool {
        (self.from_row..self.to_row).contains(&row)
    }
}

/// What the world does to the body beyond gravity, level ground and contacts.
#[derive(Clone, Debug, PartialEq)]
pub struct Disturbed {
    /// Direction in which the ground faces, unit length: one for all rows, or one per row where it turns. It turns about
    /// the point of it under the world's origin.
    pub ground_up: Vec<Vec3>,
    /// Wrench of pushes and of hands that give and take what is carried, `rows × 6`: force (N), moment about the
    /// root's origin (N·m). A mass is given and taken at the velocity of its link: its momentum comes and goes
    /// within one row. Empty where there is none.
    pub wrench: Vec<f64>,
    /// Masses carried.
    pub carried: Vec<Handed>,
    /// World position of the centre of each of them, `rows × carried × 3`, m: in rows without it, where it would be.
    pub carried_com: Vec<f64>,
    /// What the engine put on the root, `rows × 7`, so that forces alone change the momentum: impulse (N·s), its moment about the root's
    /// origin (N·m·s), its work (J). The balance of the momentum holds with it in place and does not contain it; without it, it would be
    /// left over. Empty of engines that do not correct.
    pub root_correction: Vec<f64>,
    /// Boxes and ramps beside the ground.
    pub props: Vec<Prop>,
}

impl Default for Disturbed {
    fn default() -> Self {
        Self {
            ground_up: vec![Vec3::y()],
            wrench: Vec::new(),
            carried: Vec::new(),
            carried_com: Vec::new(),
            root_correction: Vec::new(),
            props: Vec::new(),
        }
    }
}

/// What a dynamic run recorded. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// The body.
    pub character: Arc<Character>,
    /// Control steps per second, Hz.
    pub rate_hz: f64,
    /// Substeps of the engine per control step.
    pub substeps: usize,
    /// What held the root.
    pub root: RootMode,
    /// Height of the ground plane, m; `None` without ground.
    pub ground_m: Option<f64>,
    /// Gravity, m/s².
    pub gravity: Vec3,
    /// Poses, `rows × nq`.
    pub q: Vec<f64>,
    /// Velocities, `rows × nv`.
    pub v: Vec<f64>,
    /// Poses asked for (edited, limits applied), `rows × nq`.
    pub target: Vec<f64>,
    /// Actuator torques (springs and dampers), `rows × nv`, N·m; root entries zero.
    pub torque: Vec<f64>,
    /// Torques of the stops at the ends of the joints' ranges, `rows × nv`, N·m; zero inside.
    pub stop_torque: Vec<f64>,
    /// Gain of the spring towards the lower set point, `rows × nv`, N·m/rad.
    pub k_lo: Vec<f64>,
    /// Gain of the spring towards the upper set point, `rows × nv`, N·m/rad.
    pub k_hi: Vec<f64>,
    /// Damping, `rows × nv`, N·m·s/rad.
    pub kd: Vec<f64>,
    /// Contacts of all rows, in order of row.
    pub contacts: Vec<ContactSample>,
    /// Wrench on the root from outside (assist or pin), `rows × 6`: force (N), moment about the
    /// root's origin (N·m).
    pub root_wrench: Vec<f64>,
    /// Centre of mass, `rows × 3`, m.
    pub com: Vec<f64>,
    /// Momentum, `rows × 6`: linear (N·s), angular about the centre of mass (N·m·s).
    pub momentum: Vec<f64>,
    /// World position of each link's centre of mass, `rows × links × 3`, m; empty when not recorded.
    /// With the masses it gives momentum by a road that does not pass through `v` or `momentum`.
    pub link_com: Vec<f64>,
    /// Pushes, tilted ground, carried masses.
    pub disturbed: Disturbed,
    /// What was to stand when, and where: of what was asked for, not of what happened. By the clock of the trace.
    pub plan: ContactPlan,
    /// Red, green and blue of each link, where the body has a colour; empty where it has none. Only drawn.
    pub colors: Vec<Option<[u8; 3]>>,
    /// Kinetic and potential energy, `rows × 2`, J; potential from height zero.
    pub energy: Vec<f64>,
    /// Wall time of the run, s. Not written to files: it would break their determinism.
    pub wall_s: f64,
}

impl Trace {
    /// Rows recorded.
    pub fn rows(&self) -> usize {
        self.q.len() / self.character.skeleton.nq()
    }

    /// Pose of a row.
    pub fn pose(&self, row: usize) -> &[f64] {
        let n = self.character.skeleton.nq();
        &self.q[row * n..(row + 1) * n]
    }

    /// Pose asked for in a row.
    pub fn target_pose(&self, row: usize) -> &[f64] {
        let n = self.character.skeleton.nq();
        &self.target[row * n..(row + 1) * n]
    }

    /// The motion performed, at the rate of the trace.
    pub fn clip(&self) -> Clip {
        Clip::new(self.character.skeleton.clone(), self.rate_hz, self.q.clone())
    }

    /// The motion asked for, at the rate of the trace.
    pub fn target_clip(&self) -> Clip {
        Clip::new(self.character.skeleton.clone(), self.rate_hz, self.target.clone())
    }

    /// Centre of mass of a row, m.
    pub fn com_at(&self, row: usize) -> Vec3 {
        motion::skeleton::vec_at(&self.com, 3 * row)
    }

    /// The contacts of a row.
    pub fn contacts_in(&self, row: usize) -> &[ContactSample] {
        let from = self.contacts.partition_point(|c| c.row < row);
        let here = &self.contacts[from..];
        &here[..here.partition_point(|c| c.row == row)]
    }

    /// Sum of the contact forces of each row, N.
    pub fn contact_sums(&self) -> Vec<Vec3> {
        let mut sums = vec![Vec3::zeros(); self.rows()];
        for c in &self.contacts {
            sums[c.row] += c.force;
        }
        sums
    }

    /// Mass that the forces of a row move: the body and what it carries, kg.
    pub fn mass_at(&self, row: usize) -> f64 {
        let carried = self.disturbed.carried.iter().filter(|c| c.in_row(row));
        self.character.mass() + carried.map(|c| c.what.mass).sum::<f64>()
    }

    /// Direction in which the ground faces in a row, unit length.
    pub fn ground_up(&self, row: usize) -> Vec3 {
        let all = &self.disturbed.ground_up;
        all.get(row).or(all.last()).copied().unwrap_or(Vec3::y())
    }

    /// Whether the ground turns during the run.
    pub fn ground_turns(&self) -> bool {
        self.disturbed.ground_up.windows(2).any(|w| w[0] != w[1])
    }

    /// Height of a point over the ground plane of a row, along the plane's normal, m; over zero without ground.
    pub fn height(&self, row: usize, p: &Vec3) -> f64 {
        self.ground_up(row).dot(&(p - self.pivot()))
    }

    /// A point of a row as it lies on the ground, as if that were level and at height zero: `y` is its height over the plane, m.
    pub fn on_ground(&self, row: usize, p: &Vec3) -> Vec3 {
        self.ground_turn(row).inverse() * (p - self.pivot())
    }

    /// Where a point of a row, riding on the ground, was in row 0, m.
    pub fn unturned(&self, row: usize, p: &Vec3) -> Vec3 {
        self.pivot() + self.ground_turn(0) * (self.ground_turn(row).inverse() * (p - self.pivot()))
    }

    /// The rotation that takes level ground to that of a row.
    pub fn ground_turn(&self, row: usize) -> Quat {
        let up = self.ground_up(row);
        if up == Vec3::y() { Quat::identity() } else { motion::rotation::between(&Vec3::y(), &up) }
    }

    fn pivot(&self) -> Vec3 {
        Vec3::y() * self.ground_m.unwrap_or(0.0)
    }

    /// Name of what a contact is against: `ground`, a prop, a link.
    pub fn against(&self, contact: &ContactSample) -> &str {
        match contact.against {
            Against::Ground => "ground",
            Against::Prop(i) => self.disturbed.props.get(i).map_or("prop", |p| &p.name),
            Against::Link(l) => &self.character.skeleton.links()[l].name,
        }
    }

    /// Centre of pressure of a row on the ground and the props, m; `None` without load.
    pub fn cop(&self, row: usize) -> Option<Vec3> {
        let (mut sum, mut at) = (0.0, Vec3::zeros());
        for c in self.contacts_in(row).iter().filter(|c| c.against.is_world()) {
            sum += c.force.y;
            at += c.point * c.force.y;
        }
        (sum > 1.0).then(|| at / sum)
    }

    /// What held the body beyond gravity and contacts, `rows × 6`: force (N), moment about the root's
    /// origin (N·m). Of a held root the wrench on record; of a free one `d(momentum)/dt − m g − Σ contacts` without
    /// pushes and hands, which is the error of the integrator. Zero in row 0.
    pub fn residual(&self) -> Vec<f64> {
        if self.root != RootMode::Free {
            return self.root_wrench.clone();
        }
        let rows = self.rows();
        let momentum = |row: usize, at: usize| motion::skeleton::vec_at(&self.momentum, 6 * row + at);
        let mut force = vec![Vec3::zeros(); rows];
        let mut moment = vec![Vec3::zeros(); rows];
        for row in 1..rows {
            let change = |at: usize| (momentum(row, at) - momentum(row - 1, at)) * self.rate_hz;
            (force[row], moment[row]) = (change(0) - self.gravity * self.mass_at(row), change(3));
        }
        for c in self.contacts.iter().filter(|c| c.row > 0) {
            force[c.row] -= c.force;
            moment[c.row] -= (c.point - self.com_at(c.row)).cross(&c.force);
        }
        let root = |row: usize| motion::Kinematics::new(&self.character.skeleton, self.pose(row)).origin(0);
        (0..rows)
            .flat_map(|row| {
                let mut m = moment[row] + (self.com_at(row) - root(row)).cross(&force[row]);
                let mut f = force[row];
                if let Some(w) = self.disturbed.wrench.get(6 * row..6 * row + 6) {
                    f -= motion::skeleton::vec_at(w, 0);
                    m -= motion::skeleton::vec_at(w, 3);
                }
                [f.x, f.y, f.z, m.x, m.y, m.z]
            })
            .collect()
    }

    /// The rows of a range, as a trace of their own.
    ///
    /// # Panics
    /// If the range is empty or ends beyond the last row.
    pub fn cut(&self, rows: std::ops::Range<usize>) -> Self {
        assert!(!rows.is_empty() && rows.end <= self.rows(), "{rows:?} of {} rows", self.rows());
        let all = self.rows();
        let part = |data: &[f64]| {
            let n = data.len() / all;
            data[rows.start * n..rows.end * n].to_vec()
        };
        let inside = |c: &&ContactSample| rows.contains(&c.row);
        let contacts = self.contacts.iter().filter(inside);
        let d = &self.disturbed;
        let shifted = |row: usize| row.saturating_sub(rows.start);
        let handed = |c: &Handed| Handed {
            what: c.what.clone(),
            from_row: shifted(c.from_row),
            to_row: shifted(c.to_row),
        };
        let disturbed = Disturbed {
            ground_up: if d.ground_up.len() == all {
                d.ground_up[rows.clone()].to_vec()
            } else {
                d.ground_up.clone()
            },
            wrench: part(&d.wrench),
            carried: d.carried.iter().map(handed).collect(),
            carried_com: part(&d.carried_com),
            root_correction: part(&d.root_correction),
            props: d.props.clone(),
        };
        Self {
            q: part(&self.q),
            v: part(&self.v),
            target: part(&self.target),
            torque: part(&self.torque),
            stop_torque: part(&self.stop_torque),
            k_lo: part(&self.k_lo),
            k_hi: part(&self.k_hi),
            kd: part(&self.kd),
            contacts: contacts.map(|c| ContactSample { row: c.row - rows.start, ..*c }).collect(),
            root_wrench: part(&self.root_wrench),
            com: part(&self.com),
            momentum: part(&self.momentum),
            link_com: part(&self.link_com),
            disturbed,
            energy: part(&self.energy),
            character: self.character.clone(),
            plan: {
                let time = |row: usize| row as f64 / self.rate_hz;
                self.plan.between(time(rows.start), time(rows.end - 1))
            },
            colors: self.colors.clone(),
            ..*self
        }
    }
}
