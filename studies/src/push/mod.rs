//! Push recovery: how hard a standing body can be pushed, in every direction, before it falls or steps.
//!
//! In: a [`Take`] whose root is free and whose feet stand. Out: a [`PushMap`]: per direction the largest
//! impulse survived, found by bisection, beside the physical limit of a body that only moves its centre of
//! pressure.
//!
//! One push: a constant horizontal force over T = 0.1 s once the body has settled. It acts at the whole body's
//! centre of mass as it is when the push begins, a point fixed to the trunk link whose own centre lies nearest:
//! a push at the height of the centre of mass that turns the body about no axis.
//!
//! Survived: until 5 s after the push nothing but feet carried load and the root kept its height (not
//! [fallen](sim::Run::fell_s)), the middle of no sole was ever more than 1 cm from where it was, and in the end
//! the centre of mass is within 2 cm of where it is without the push.
//!
//! The limit is in [`limit_ns`].
//!
//! Directions are horizontal, degrees about +Y: 0 forward (+Z), 90 left (+X), 180 back, 270 right.
//! Every direction is searched by itself, so a map is the same on any number of threads.

mod confirm;
mod limit;
mod map;
pub mod results;

use std::collections::BTreeMap;
use std::sync::Mutex;

use bodies::Character;
use dynamics::{Push, RootMode};
use motion::support::{Support, ground};
use motion::{Kinematics, Limb, Sole, Vec3};
use rayon::prelude::*;
use sim::{EngineEntry, Pass, PassError};

use takes::Take;

use crate::level_ground::LevelGround;
use map::symmetry_error;

pub use confirm::confirm;
pub use limit::{limit_ns, to_edge};
pub use map::{Confirmation, ConfirmedDirection, PushDirection, PushMap};
pub use scenes::angle::direction;

/// A foot that moved farther has stepped, m.
pub const FOOT_MOVED_M: f64 = 0.01;
/// A centre of mass farther away in the end has not come back, m.
pub const COM_AWAY_M: f64 = 0.02;

/// How a map is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PushSettings {
    /// Directions, evenly spaced from 0° on.
    pub directions: usize,
    /// Bisection ends when the least impulse that failed is within this part of the largest survived.
    pub tolerance: f64,
    /// When the push begins, s: the body has settled by then.
    pub at_s: f64,
    /// How long it lasts, s; rounded to whole control steps.
    pub lasts_s: f64,
    /// How long after it the body must have recovered, s.
    pub after_s: f64,
}

impl Default for PushSettings {
    fn default() -> Self {
        Self { directions: 16, tolerance: 0.01, at_s: 1.0, lasts_s: 0.1, after_s: 5.0 }
    }
}

/// Why there is no map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PushError {
    /// A body that something else than its feet holds.
    #[error(
        "{scene}: {what}; a push map needs a free root, ground that stays, gravity downwards, and planted feet"
    )]
    Held {
        /// The scene.
        scene: String,
        /// What is in the way.
        what: String,
    },
    /// A body that does not even stand without a push.
    #[error("{scene}: without any push of the map, {what}")]
    Unsteady {
        /// The scene.
        scene: String,
        /// What happened.
        what: String,
    },
    /// A body that no push moves.
    #[error(
        "a push of {impulse_ns:.0} N·s towards {deg}°, {times} times the limit, is survived: something holds the body"
    )]
    Unmoved {
        /// Direction, degrees.
        deg: f64,
        /// Impulse, N·s.
        impulse_ns: f64,
        /// That over the limit.
        times: f64,
    },
    /// The pass.
    #[error(transparent)]
    Pass(#[from] PassError),
}

impl PushError {
    /// Whether the fault lies in the scene rather than in the run.
    pub fn is_input(&self) -> bool {
        matches!(self, Self::Held { .. })
    }
}

/// How a push ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// The body stands as before.
    Survived,
    /// It fell, at this time, s.
    Fell(f64),
    /// A foot moved, at this time, s.
    FootMoved(f64),
    /// Its centre of mass is this far away in the end, m.
    Away(f64),
    /// The simulation ran away, at this time, s.
    Diverged(f64),
}

impl Verdict {
    /// In words, for tables and reports.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Survived => "survived",
            Self::Fell(_) => "fell",
            Self::FootMoved(_) => "foot moved",
            Self::Away(_) => "not back",
            Self::Diverged(_) => "diverged",
        }
    }
}

/// A map of a take in an engine; `progress` is called with the fraction done, from any thread.
///
/// # Errors
/// [`PushError`].
pub fn map(
    take: &Take,
    settings: PushSettings,
    engine: &EngineEntry,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<PushMap, PushError> {
    PushTest::new(take, settings, engine)?.map(progress)
}

/// A body that stands, ready to be pushed. See the module header.
pub struct PushTest {
    take: Take,
    settings: PushSettings,
    /// Where it is simulated.
    engine: EngineEntry,
    /// Row of the trace at which the push begins.
    start_row: usize,
    /// Control steps it lasts.
    steps: usize,
    /// Row of the verdict.
    end_row: usize,
    /// Soles that are planted.
    soles: Vec<Sole>,
    /// Middles of the soles when the push begins, m.
    home: Vec<Vec3>,
    /// Centre of mass when the push begins, m.
    com: Vec3,
    /// Centre of mass in the end without a push, m.
    com_in_the_end: Vec3,
    /// Support when the push begins.
    support: Support,
    height_m: f64,
    omega: f64,
    link: usize,
    at: Vec3,
}

impl PushTest {
    /// Lets the body stand in `engine` without a push: what it stands on, where it is and stays.
    ///
    /// # Errors
    /// [`PushError::Held`] and [`PushError::Unsteady`]; what the pass finds wrong.
    pub fn new(take: &Take, settings: PushSettings, engine: &EngineEntry) -> Result<Self, PushError> {
        let held = |what: &str| PushError::Held { scene: take.name.clone(), what: what.into() };
        let physics = &take.conditions.physics;
        match physics.root {
            RootMode::Free => {}
            RootMode::Pinned => return Err(held("its root is pinned")),
            RootMode::Assisted { .. } => return Err(held("its root is assisted")),
        }
        let LevelGround { height_m: floor, gravity_m_s2: g } =
            LevelGround::of(&take.conditions).map_err(held)?;
        let planted = |leg: &Limb| take.asked.plants.iter().any(|p| p.limb == *leg);
        let feet = take.body.character.leg_soles().into_iter();
        let soles: Vec<Sole> = feet.filter(|(leg, _)| planted(leg)).map(|(_, sole)| sole).collect();
        if soles.is_empty() {
            return Err(held("no foot with a sole is planted"));
        }
        let rate = take.control_rate_hz();
        let whole = |s: f64| (s * rate).round().max(1.0) as usize;
        let (start_row, steps) = (whole(settings.at_s), whole(settings.lasts_s));
        let end_row = start_row + steps + whole(settings.after_s);
        let mut test = Self {
            take: take.held_until(end_row as f64 / rate),
            settings,
            engine: engine.clone(),
            start_row,
            steps,
            end_row,
            home: Vec::new(),
            soles,
            com: Vec3::zeros(),
            com_in_the_end: Vec3::zeros(),
            support: Support::default(),
            height_m: 0.0,
            omega: 0.0,
            link: 0,
            at: Vec3::zeros(),
        };
        let unsteady = |what: String| PushError::Unsteady { scene: take.name.clone(), what };
        match test.settle()? {
            Verdict::Fell(t) => return Err(unsteady(format!("the body falls at {t:.2} s"))),
            Verdict::FootMoved(t) => {
                return Err(unsteady(format!("a foot moves more than 1 cm at {t:.2} s")));
            }
            Verdict::Diverged(t) => return Err(unsteady(format!("the simulation diverges at {t:.2} s"))),
            Verdict::Survived | Verdict::Away(_) => {}
        }
        test.height_m = test.com.y - floor;
        test.omega = (g / test.height_m).sqrt();
        let inside = test.support.margin(&ground(&test.com));
        if inside < LEAST_MARGIN_M {
            let what = format!("the centre of mass is {:.1} mm inside its support", 1e3 * inside);
            return Err(unsteady(what + ", where no push is survived"));
        }
        Ok(test)
    }

    /// The run without a push.
    fn settle(&mut self) -> Result<Verdict, PushError> {
        let mut run = self.take.pass().start(&self.engine)?;
        let skeleton = &self.take.body.character.skeleton;
        let mut k = Kinematics::new(skeleton, run.trace().pose(0));
        while run.row() < self.end_row && run.step()? {
            if let Some(t) = run.fell_s() {
                return Ok(Verdict::Fell(t));
            }
            let row = run.row();
            k.update(skeleton, run.trace().pose(row));
            if row == self.start_row {
                self.com = run.trace().com_at(row);
                self.home = self.soles.iter().map(|s| s.center(&k)).collect();
                self.support = Sole::support(&self.soles, &k);
                self.link = carrier(&self.take.body.character, &k, &self.com);
                self.at = k.world[self.link].inverse().transform_point(&self.com.into()).coords;
            } else if row > self.start_row && self.stepped(&k) {
                return Ok(Verdict::FootMoved(row as f64 / self.take.control_rate_hz()));
            }
        }
        if run.diverged().is_some() {
            return Ok(Verdict::Diverged(run.row() as f64 / self.take.control_rate_hz()));
        }
        self.com_in_the_end = run.trace().com_at(run.row());
        Ok(Verdict::Survived)
    }

    fn stepped(&self, k: &Kinematics) -> bool {
        self.soles.iter().zip(&self.home).any(|(s, home)| (s.center(k) - home).norm() > FOOT_MOVED_M)
    }

    /// How long a push lasts, in whole control steps, s.
    pub fn push_s(&self) -> f64 {
        self.steps as f64 / self.take.control_rate_hz()
    }

    /// Distance from the centre of mass to the support's edge, m.
    pub fn edge_m(&self, deg: f64) -> f64 {
        to_edge(&self.support, &ground(&self.com), &ground(&direction(deg))).unwrap_or(0.0)
    }

    /// The physical limit in a direction, N·s.
    pub fn limit_ns(&self, deg: f64) -> f64 {
        limit_ns(self.take.body.character.mass(), self.omega, self.edge_m(deg), self.push_s())
    }

    /// The pass of one push, to the end of the verdict and beyond if the stage is longer.
    pub fn pass(&self, deg: f64, impulse_ns: f64) -> Pass {
        let mut pass = self.take.pass();
        pass.pushes.push(Push {
            link: self.link,
            at: self.at,
            force: direction(deg) * (impulse_ns / self.push_s()),
            start_s: self.start_row as f64 / self.take.control_rate_hz(),
            duration_s: self.push_s(),
        });
        pass
    }

    /// Pushes the settled body once; stops as soon as the end is known.
    ///
    /// # Errors
    /// What the pass finds wrong. A simulation that runs away is a verdict.
    pub fn push(&self, deg: f64, impulse_ns: f64) -> Result<Verdict, PushError> {
        let rate = self.take.control_rate_hz();
        let mut run = self.pass(deg, impulse_ns).start(&self.engine)?;
        let skeleton = &self.take.body.character.skeleton;
        let mut k = Kinematics::new(skeleton, run.trace().pose(0));
        while run.row() < self.end_row && run.step()? {
            if let Some(t) = run.fell_s() {
                return Ok(Verdict::Fell(t));
            }
            if run.row() > self.start_row {
                k.update(skeleton, run.trace().pose(run.row()));
                if self.stepped(&k) {
                    return Ok(Verdict::FootMoved(run.row() as f64 / rate));
                }
            }
        }
        if run.diverged().is_some() {
            return Ok(Verdict::Diverged(run.row() as f64 / rate));
        }
        let away = (run.trace().com_at(run.row()) - self.com_in_the_end).norm();
        Ok(if away > COM_AWAY_M { Verdict::Away(away) } else { Verdict::Survived })
    }

    /// Searches one direction; `pushed` is called after every push with the part of the search done, at most 1.
    ///
    /// # Errors
    /// As [`PushTest::push`], and [`PushError::Unmoved`].
    pub fn search(&self, deg: f64, pushed: &dyn Fn(f64)) -> Result<PushDirection, PushError> {
        let (limit, tolerance) = (self.limit_ns(deg), self.settings.tolerance);
        // halvings from one step of the bracket to the tolerance, and the pushes that make the bracket
        let expected = 3.0 + ((STEP - 1.0) / tolerance).log2().max(0.0);
        let (mut survived, mut next, mut pushes) = (0.0, limit, 0);
        let mut failed = None;
        let (failed_ns, lost) = loop {
            match self.push(deg, next)? {
                Verdict::Survived => survived = next,
                lost => failed = Some((next, lost)),
            }
            pushes += 1;
            pushed((f64::from(pushes) / expected).min(1.0));
            next = match failed {
                Some((f, lost)) if f - survived <= tolerance * f || f <= tolerance * limit => {
                    break (f, lost);
                }
                Some((f, _)) if survived == 0.0 => f / STEP,
                Some((f, _)) => 0.5 * (survived + f),
                None if next > MOST * limit => {
                    return Err(PushError::Unmoved { deg, impulse_ns: next, times: MOST });
                }
                None => next * STEP,
            };
        };
        Ok(PushDirection {
            deg,
            survived_ns: survived,
            limit_ns: limit,
            ratio: survived / limit,
            failed_ns,
            lost: lost.name(),
            edge_m: self.edge_m(deg),
            pushes: pushes as usize,
        })
    }

    /// Searches all directions; `progress` is called with the fraction done, from any thread.
    ///
    /// # Errors
    /// As [`PushTest::search`].
    pub fn map(&self, progress: &(dyn Fn(f64) + Sync)) -> Result<PushMap, PushError> {
        let n = self.settings.directions;
        let done = Mutex::new(vec![0.0; n]);
        let search = |i: usize| {
            let report = |part: f64| {
                let mut done = done.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                done[i] = part;
                progress(done.iter().sum::<f64>() / n as f64);
            };
            let found = self.search(360.0 * i as f64 / n as f64, &report);
            report(1.0);
            found
        };
        // the first error in the order of directions is returned, so that it does not depend on threads
        let found: Vec<_> = (0..n).into_par_iter().with_max_len(1).map(search).collect();
        let directions = found.into_iter().collect::<Result<Vec<_>, _>>()?;
        Ok(PushMap {
            scene: self.take.name.clone(),
            engine: self.engine.name().to_owned(),
            mean_ratio: directions.iter().map(|d| d.ratio).sum::<f64>() / n as f64,
            min_ratio: directions.iter().map(|d| d.ratio).fold(f64::INFINITY, f64::min),
            symmetry_error_percent: symmetry_error(&directions).map(|e| 100.0 * e),
            mass_kg: self.take.body.character.mass(),
            com_height_m: self.height_m,
            omega_rad_s: self.omega,
            push_at_s: self.start_row as f64 / self.take.control_rate_hz(),
            push_s: self.push_s(),
            push_link: self.take.body.character.skeleton.links()[self.link].name.clone(),
            tolerance_percent: 100.0 * self.settings.tolerance,
            confirmed: None,
            files: BTreeMap::new(),
            directions,
        })
    }
}

/// A settled centre of mass nearer to the support's edge leaves nothing to measure, m.
const LEAST_MARGIN_M: f64 = 1e-3;
/// Ratio of one push of the bracket to the next.
const STEP: f64 = 1.25;
/// Times the limit that no body that stands on its feet survives.
const MOST: f64 = 30.0;

/// The link of the trunk (no limb, nothing a limb carries) whose own centre of mass lies nearest to `com`.
pub(crate) fn carrier(character: &Character, k: &Kinematics, com: &Vec3) -> usize {
    let skeleton = &character.skeleton;
    let links = skeleton.links();
    let in_limb =
        |link: usize| skeleton.ancestors(link).any(|l| skeleton.limbs().iter().any(|limb| limb.upper == l));
    let distance = |&link: &usize| (k.point(link, &character.bodies[link].com) - com).norm();
    (0..links.len())
        .filter(|&l| !in_limb(l) && character.bodies[l].mass > 0.0)
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .unwrap_or(0)
}
