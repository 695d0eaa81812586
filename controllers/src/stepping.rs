//! Stepping: the motion of a clip made possible before it is performed.
//!
//! In: a clip on a body, what stands when. Out: a [`Possible`]: the plan with its places, and a clip whose feet stand there
//! (`motion::tread`), whose centre of pressure is inside the soles and whose flights fall ([`crate::shift`]), nearest to the
//! clip asked for; and in words what shifts, and what could not be made possible.
//!
//! The motion is smoothed as inverse dynamics smooths it. The upper body keeps its pose; the root moves it, and legs
//! are solved by IK to feet that roll where they stand, without what IK makes of nearly straight knees. Units: m, s; world frame, y up.

use bodies::Character;
use dynamics::analysis::smoothed;
use dynamics::{Model, State};
use motion::ik::{IkError, Reach, solve_two_bone_oriented};
use motion::plant::{Knee, Plant, shortfall};
use motion::smooth::whittaker::{Whittaker, lambda};
use motion::support::Vec2;
use motion::tread::{Tread, treads};
use motion::{Clip, ContactPlan, Kinematics, Limb, Sole, Transform, Vec3, runs};

use crate::bearing::{BEARS, HELD_S, borne, needs};
use crate::likeness::{Likeness, moved, root_mean_square, turns};
use crate::shift::{Ground, asked, com_and_spin, heights, path};
use crate::unmet::{Unmet, WeightShift};

/// What legs cannot reach is made up for over this time before and after, s.
const REACH_S: f64 = 0.06;
/// Knees of legs that are nearly straight turn by degrees for a millimetre of the foot. What IK changes of a leg keeps half of its amplitude at
/// this frequency, and the foot gives way by millimetres, Hz.
const EASED_HZ: f64 = 5.0;
/// Rounds of path and pose: legs that move change the angular momentum a little.
const ROUNDS: usize = 4;
/// The centre of mass is brought this near to its path, m: differences of it are accelerations.
const ARRIVED_M: f64 = 1e-10;

/// A motion that a body can perform where it steps. See the module header.
#[derive(Clone, Debug)]
pub struct Possible {
    /// What stands when and where.
    pub plan: ContactPlan,
    /// The motion.
    pub clip: Clip,
    /// Height of the ground, m.
    pub ground_m: f64,
    /// Movement of the centre of mass, frame by frame, m.
    pub shift: Vec<Vec3>,
    /// The shifts worth a word.
    pub shifts: Vec<WeightShift>,
    /// What could not be made possible.
    pub unmet: Vec<Unmet>,
    /// How much of it changed.
    pub measures: Measures,
    /// How near it is to the capture; `None` where nothing steps.
    pub likeness: Option<Likeness>,
}

impl Possible {
    /// What shifts and what could not be made possible, a line each.
    pub fn words(&self) -> impl Iterator<Item = String> {
        let unmet = self.unmet.iter().map(|u| format!("not possible: {u}"));
        self.shifts.iter().map(ToString::to_string).chain(unmet)
    }
}

/// How far a possible motion is from the one asked for, and what it asks of the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measures {
    /// Share of the frames on the ground whose centre of pressure is inside the soles that stand, before; `None` without any.
    pub inside_before: Option<f64>,
    /// And after.
    pub inside_after: Option<f64>,
    /// Movement of the centres of all links in all frames, RMS, m.
    pub links_rms_m: f64,
    /// The largest mean over the links in a frame, m.
    pub links_worst_m: f64,
    /// Largest turn of a link that belongs to no leg, degrees.
    pub upper_deg: f64,
    /// Furthest that a foot stays from its way because the leg is too short, m.
    pub out_of_reach_m: f64,
    /// Frames in which nothing stands.
    pub flights: usize,
    /// Largest difference of the acceleration of the centre of mass from gravity in flight, m/s².
    pub flight_error_m_s2: f64,
}

/// A leg with its sole.
struct Leg {
    limb: Limb,
    tread: Tread,
    /// Whether it stands, frame by frame.
    stands: Vec<bool>,
}

impl Leg {
    fn new(limb: Limb, tread: Tread, plan: &ContactPlan, clip: &Clip) -> Self {
        let stands = plan.stands(&limb.name, clip.rate_hz, clip.frames());
        Self { limb, tread, stands }
    }
}

/// The ground that a motion is made possible on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Its height, m.
    pub height_m: f64,
    /// Coulomb friction coefficient.
    pub friction: f64,
    /// Whether its height was found of the clip's soles. It is then moved to where they lie flat on average (or where a given plan has them), so that
    /// the body is not: a guessed sole is some centimetres off.
    pub found: bool,
}

/// Makes the motion of `clip` possible on the feet of `character`, standing as `plan` says, over `level` ground. A found plan gives way a
/// little where forces speak against it (`given` false); one that a person gave does not. See the module header.
///
/// # Errors
/// Legs that two-bone IK cannot solve.
pub fn possible(
    character: &Character,
    clip: &Clip,
    plan: &ContactPlan,
    given: bool,
    level: Level,
    gravity: Vec3,
) -> Result<Possible, IkError> {
    let model = Model::new(character, gravity);
    let legs: Vec<(Limb, Sole)> =
        character.leg_soles().into_iter().map(|(limb, sole)| (limb.clone(), sole)).collect();
    let soles: Vec<Sole> = legs.iter().map(|(_, sole)| sole.clone()).collect();
    let smooth = smoothed(&model, clip);
    let mut base = smooth.clone();
    // the floor of the capture, which need not be that of the performance
    let floor_m = motion::contacts(&base, &soles).1.unwrap_or(level.height_m);
    let needs = needs(&model, &base, floor_m);
    let plan = if given { plan.clone() } else { borne(plan, &needs, &base, &soles, floor_m) };
    let feet = |ground_m: f64| {
        let plan = motion::contacts::placed(&plan, &base, &soles, ground_m);
        let ways = treads(&base, &soles, &plan, ground_m);
        (plan, ways, ground_m)
    };
    let (plan, ways, ground_m) = match feet(level.height_m) {
        (plan, _, _) if level.found && given => {
            feet(stood_on(&plan, &soles, &base).unwrap_or(level.height_m))
        }
        (_, ways, ground_m) if level.found => feet(ground_m - risen(&ways)),
        as_asked => as_asked,
    };
    lift(&mut base, &ways);
    let legs: Vec<Leg> =
        legs.into_iter().zip(ways).map(|((limb, _), tread)| Leg::new(limb, tread, &plan, &base)).collect();
    let mut ground = Ground::of(&plan, &soles, &base, ground_m, level.friction);
    for run in runs(0..base.frames(), |f| ground.hull[f].is_empty() && needs[f].0 > BEARS) {
        // shorter ones are what smoothing leaves of a take-off
        if run.len() as f64 >= HELD_S * base.rate_hz {
            ground.held[run].fill(true);
        }
    }
    let solver = Solver { model: &model, base: &base, legs: &legs, ground: &ground };
    let solved = solver.solve()?;
    let moved = moved(character, clip, &solved.clip);
    let measures = solver.measures(&moved, &turns(character, clip, &solved.clip), &solved);
    let mut unmet = solver.unmet(&moved, &solved);
    let shifts = WeightShift::all(&solved.shift, &plan, &soles, &base);
    let likeness = Likeness::of(character, (clip, &smooth), &solved.clip, (&plan, given), ground_m, gravity);
    unmet.extend(likeness.iter().flat_map(Likeness::unlike));
    Ok(Possible { plan, clip: solved.clip, ground_m, shift: solved.shift, shifts, unmet, measures, likeness })
}

/// How far soles were lifted, on average, m.
fn risen(ways: &[Tread]) -> f64 {
    let moved: Vec<f64> = ways.iter().filter(|w| !w.flat.is_empty()).map(|w| w.moved.y).collect();
    moved.iter().sum::<f64>() / moved.len().max(1) as f64
}

/// The lowest ground that soles stand on by a plan, m; `None` of one without places.
fn stood_on(plan: &ContactPlan, soles: &[Sole], clip: &Clip) -> Option<f64> {
    let k = Kinematics::new(&clip.skeleton, clip.pose(0));
    let corners = plan.contacts().iter().filter_map(|c| {
        let sole = soles.iter().find(|s| s.name == c.point)?;
        let place = c.world_from_point?;
        Some(sole.in_link(&k).into_iter().map(move |at| place.transform_point(&at.into()).y))
    });
    corners.flatten().min_by(f64::total_cmp)
}

/// Lifts the root as far as its soles were lifted, on average.
fn lift(clip: &mut Clip, ways: &[Tread]) {
    let by = risen(ways);
    let skeleton = clip.skeleton.clone();
    for f in 0..clip.frames() {
        let q = clip.pose_mut(f);
        let at = skeleton.position(q, 0) + Vec3::y() * by;
        skeleton.set_position(q, 0, &at);
    }
}

/// What is needed to pose the body on its path.
struct Solver<'a> {
    model: &'a Model,
    base: &'a Clip,
    legs: &'a [Leg],
    ground: &'a Ground,
}

/// A solved motion.
struct Solved {
    clip: Clip,
    shift: Vec<Vec3>,
    /// How far each leg is from its way, frame by frame, m.
    missing: Vec<Vec<f64>>,
}

impl Solver<'_> {
    fn solve(&self) -> Result<Solved, IkError> {
        let (frames, rate_hz) = (self.base.frames(), self.base.rate_hz);
        let g = self.model.gravity.norm().max(1e-9);
        let (com, mut spin) = com_and_spin(self.model, self.base);
        let mut reach = vec![0.0; frames];
        let mut shift = vec![Vec3::zeros(); frames];
        let mut solved = self.posed(&com, &shift)?;
        for _ in 0..ROUNDS {
            self.lower(&solved.clip, &shift, &mut reach)?;
            let up = heights(&com, &envelope(&reach, rate_hz), g, rate_hz, self.ground);
            let risen: Vec<Vec3> = com.iter().zip(&up).map(|(c, y)| c + Vec3::y() * *y).collect();
            let asked = asked(self.model, &risen, &spin, rate_hz, self.ground);
            let across: Vec<Vec2> = path(&asked, g, rate_hz, self.ground);
            shift = across.iter().zip(&up).map(|(x, y)| Vec3::new(x.x, *y, x.y)).collect();
            solved = self.posed(&com, &shift)?;
            spin = com_and_spin(self.model, &solved.clip).1;
        }
        Ok(solved)
    }

    /// Where the feet are in a frame: on their ways; in flight they go with the body.
    fn feet(&self, f: usize, shift: &[Vec3]) -> Vec<Transform> {
        let rides = self.rides(f);
        let moved = |leg: &Leg| {
            let way = leg.tread.way[f];
            Transform::from_parts((way.translation.vector + shift[f] * rides).into(), way.rotation)
        };
        self.legs.iter().map(moved).collect()
    }

    /// How much the feet go with the body: not at all on the ground, all of it in the middle of a flight.
    fn rides(&self, f: usize) -> f64 {
        if !self.ground.flies(f) {
            return 0.0;
        }
        let frames = self.base.frames();
        let from = (0..f).rev().find(|x| !self.ground.flies(*x));
        let to = (f..frames).find(|x| !self.ground.flies(*x));
        match (from, to) {
            (Some(a), Some(b)) => (std::f64::consts::PI * (f - a) as f64 / (b - a) as f64).sin().powi(2),
            _ => 0.0,
        }
    }

    /// What legs want of the height in every frame, if they cannot reach the feet of `clip` as it is.
    fn lower(&self, clip: &Clip, shift: &[Vec3], reach: &mut [f64]) -> Result<(), IkError> {
        for f in 0..clip.frames() {
            let plants: Vec<Plant> = self
                .legs
                .iter()
                .zip(self.feet(f, shift))
                .filter(|(leg, _)| leg.stands[f])
                .map(|(leg, at)| Plant { limb: leg.limb.clone(), world_from_end: at, knee: Knee::Kept })
                .collect();
            let by = shortfall(&clip.skeleton, clip.pose(f), &plants)?;
            if by > 0.0 {
                reach[f] -= by;
            }
        }
        Ok(())
    }

    /// The body on its path: the root such that the centre of mass is there, legs to their feet.
    fn posed(&self, com: &[Vec3], shift: &[Vec3]) -> Result<Solved, IkError> {
        let skeleton = &self.base.skeleton;
        let mut clip = self.base.clone();
        let mut state = State::new(self.model);
        let mut missing = vec![vec![0.0; clip.frames()]; self.legs.len()];
        for f in 0..clip.frames() {
            let feet = self.feet(f, shift);
            let target = com[f] + shift[f];
            let q = clip.pose_mut(f);
            let mut at = skeleton.position(q, 0) + shift[f];
            let asked = q.to_vec();
            for turn in 0..60 {
                q.copy_from_slice(&asked);
                skeleton.set_position(q, 0, &at);
                for (i, (leg, foot)) in self.legs.iter().zip(&feet).enumerate() {
                    missing[i][f] = match solve_two_bone_oriented(skeleton, q, &leg.limb, foot)? {
                        Reach::Clamped { residue_m } if leg.stands[f] => residue_m,
                        Reach::Clamped { .. } | Reach::Reached => 0.0,
                    };
                }
                state.update_pose(self.model, q);
                let off = target - state.com(self.model);
                if off.norm() < ARRIVED_M {
                    break;
                }
                // a leg at its end makes whole steps swing
                at += off * if turn < 20 { 1.0 } else { 0.5 };
            }
        }
        self.ease(&mut clip, com, shift);
        Ok(Solved { clip, shift: shift.to_vec(), missing })
    }

    /// What IK changed of the legs, without what is faster than [`EASED_HZ`]; the root once more such that the centre of mass is on its path.
    fn ease(&self, clip: &mut Clip, com: &[Vec3], shift: &[Vec3]) {
        let skeleton = &self.base.skeleton;
        let (frames, nv) = (clip.frames(), skeleton.nv());
        let of_leg = |link: usize| {
            self.legs.iter().any(|leg| {
                link == leg.limb.upper || skeleton.ancestors(link).any(|above| above == leg.limb.upper)
            })
        };
        let columns: Vec<usize> = (0..skeleton.links().len())
            .filter(|link| of_leg(*link))
            .flat_map(|link| {
                let at = skeleton.v_at(link);
                at..at + skeleton.links()[link].joint.nv()
            })
            .collect();
        let mut changed = vec![0.0; nv];
        let mut path = Vec::with_capacity(frames * columns.len());
        for f in 0..frames {
            skeleton.difference(self.base.pose(f), clip.pose(f), 1.0, &mut changed);
            path.extend(columns.iter().map(|k| changed[*k]));
        }
        let smooth = Whittaker::new(frames, lambda(EASED_HZ, clip.rate_hz)).smooth(&path, columns.len());
        let mut state = State::new(self.model);
        for f in 0..frames {
            changed.fill(0.0);
            columns.iter().zip(&smooth[f * columns.len()..]).for_each(|(k, eased)| changed[*k] = *eased);
            let q = clip.pose_mut(f);
            q.copy_from_slice(self.base.pose(f));
            skeleton.integrate(q, &changed, 1.0);
            state.update_pose(self.model, q);
            let at = skeleton.position(q, 0) + com[f] + shift[f] - state.com(self.model);
            skeleton.set_position(q, 0, &at);
        }
    }

    /// Distance of the pressure outside the soles in every frame that stands, m; `None` where it is not known.
    fn beyond(&self, clip: &Clip) -> Vec<Option<f64>> {
        let (com, spin) = com_and_spin(self.model, clip);
        let g = self.model.gravity.norm().max(1e-9);
        let all = asked(self.model, &com, &spin, clip.rate_hz, self.ground);
        let one = |(f, a): (usize, &crate::shift::Asked)| {
            if self.ground.hull[f].is_empty() {
                return None;
            }
            Some((-self.ground.hull[f].margin(&a.pressure(g)?)).max(0.0))
        };
        all.iter().enumerate().map(one).collect()
    }

    /// `moved`: of all links, frame by frame, m; `turns`: of the upper body, rad.
    fn measures(&self, moved: &[Vec<f64>], turns: &[f64], solved: &Solved) -> Measures {
        let (frames, rate_hz) = (self.base.frames(), self.base.rate_hz);
        let share = |clip: &Clip| {
            let known: Vec<f64> = self.beyond(clip).into_iter().flatten().collect();
            let inside = known.iter().filter(|by| **by < INSIDE_M).count();
            (!known.is_empty()).then(|| inside as f64 / known.len() as f64)
        };
        let fall = |f: usize| {
            let rate2 = rate_hz * rate_hz;
            let mut state = State::new(self.model);
            let mut com = |f: usize| {
                state.update_pose(self.model, solved.clip.pose(f));
                state.com(self.model)
            };
            ((com(f - 1) + com(f + 1) - com(f) * 2.0) * rate2 - self.model.gravity).norm()
        };
        let flights: Vec<usize> = (1..frames.saturating_sub(1)).filter(|f| self.ground.flies(*f)).collect();
        Measures {
            inside_before: share(self.base),
            inside_after: share(&solved.clip),
            links_rms_m: root_mean_square(moved.iter().flatten()),
            links_worst_m: moved.iter().map(root_mean_square).fold(0.0, f64::max),
            upper_deg: turns.iter().copied().fold(0.0, f64::max).to_degrees(),
            out_of_reach_m: solved.missing.iter().flatten().copied().fold(0.0, f64::max),
            flights: flights.len(),
            flight_error_m_s2: flights.iter().map(|f| fall(*f)).fold(0.0, f64::max),
        }
    }

    fn unmet(&self, moved: &[Vec<f64>], solved: &Solved) -> Vec<Unmet> {
        let rate_hz = self.base.rate_hz;
        let mut out = Vec::new();
        let beyond: Vec<f64> = self.beyond(&solved.clip).into_iter().map(|x| x.unwrap_or(0.0)).collect();
        out.extend(Unmet::spans(&beyond, PRESSED_M, rate_hz, |from_s, to_s, by_m| Unmet::Pressure {
            from_s,
            to_s,
            by_m,
        }));
        let held: Vec<f64> = self.ground.held.iter().map(|x| f64::from(u8::from(*x))).collect();
        out.extend(Unmet::spans(&held, 0.5, rate_hz, |from_s, to_s, _| Unmet::Held { from_s, to_s }));
        for (leg, missing) in self.legs.iter().zip(&solved.missing) {
            let limb = leg.limb.name.clone();
            out.extend(Unmet::spans(missing, REACHED_M, rate_hz, |from_s, to_s, by_m| Unmet::Reach {
                limb: limb.clone(),
                from_s,
                to_s,
                by_m,
            }));
        }
        let far: Vec<f64> = moved.iter().map(|m| m.iter().sum::<f64>() / m.len().max(1) as f64).collect();
        out.extend(Unmet::spans(&far, FAR_M, rate_hz, |from_s, to_s, by_m| Unmet::Far {
            from_s,
            to_s,
            by_m,
        }));
        out
    }
}

/// A centre of pressure outside by less is on the edge, m.
const INSIDE_M: f64 = 1e-3;
/// A centre of pressure outside by more is named, m.
const PRESSED_M: f64 = 0.01;
/// A foot further from its way is named, m.
const REACHED_M: f64 = 0.01;
/// A body further from what was asked is named, m.
pub const FAR_M: f64 = 0.08;

/// The least of `reach` around every frame.
fn envelope(reach: &[f64], rate_hz: f64) -> Vec<f64> {
    let w = (REACH_S * rate_hz).round() as usize;
    let least = |f: usize| {
        let around = &reach[f.saturating_sub(w)..(f + w + 1).min(reach.len())];
        around.iter().copied().fold(0.0, f64::min)
    };
    (0..reach.len()).map(least).collect()
}
