//! Likeness: how near a motion made possible stays to its capture, measure by measure, against the smoothed capture and the raw one.
//!
//! In: a clip as captured, the same made possible, its plan. Out: a [`Likeness`]; [`Likeness::unlike`] names what is further off than is allowed.
//!
//! | measure | allowed |
//! |---|---|
//! | centres of all links, RMS, from the raw capture | [`LINKS_M`] |
//! | turn of links that no leg moves, RMS, from the smoothed capture | [`UPPER_DEG`] |
//! | when soles come down and leave: of the motion made possible as contacts are found of any motion, against its plan | [`TIMES_S`] |
//! | rise of the centre of mass in flights against the smoothed capture's | [`PART`], or [`RISE_M`] |
//! | strides, from stance to next stance of the same sole, against the smoothed capture's | [`PART`], or [`STRIDE_M`] |
//!
//! The rise is that of the highest point of the plan's flight over the mean of its ends, at the same times in both motions; a stance lies where the
//! middle of its sole is on average. Units: m, s, degrees.

use bodies::Character;
use dynamics::{Model, State};
use motion::{Clip, Contact, ContactPlan, Kinematics, Sole, Vec3, runs};

use crate::bearing::{borne, needs};
use crate::unmet::Unmet;

/// See the module header: largest RMS distance of the centres of all links, m.
pub const LINKS_M: f64 = 0.08;
/// Largest RMS turn of a link of the upper body, degrees.
pub const UPPER_DEG: f64 = 3.0;
/// Largest difference of the time of a contact's beginning or end, s.
pub const TIMES_S: f64 = 0.05;
/// A contact that an end of the clip cuts to less than this is not looked for, s.
const CUT_S: f64 = 0.1;
/// Largest difference of rises and strides, as a part of the captured.
pub const PART: f64 = 0.1;
/// Rises that differ by less are alike, m: a run rises by little more.
pub const RISE_M: f64 = 0.01;
/// Strides that differ by less are alike, m: a foot that turns on the spot has a stride of centimetres.
pub const STRIDE_M: f64 = 0.02;

/// A length as captured and as made possible, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// When, s.
    pub at_s: f64,
    /// Of the smoothed capture.
    pub captured_m: f64,
    /// Of the motion made possible.
    pub made_m: f64,
}

/// A contact that begins or ends beside its time.
#[derive(Clone, Debug, PartialEq)]
pub struct Beside {
    /// What stands.
    pub point: String,
    /// When it is planned to begin or end, s.
    pub at_s: f64,
    /// How much later it does, s.
    pub by_s: f64,
}

impl Pair {
    /// Difference as a part of the captured; zero where they differ by less than `least_m`.
    fn off(&self, least_m: f64) -> f64 {
        let by = self.made_m - self.captured_m;
        if by.abs() <= least_m { 0.0 } else { by / self.captured_m.abs().max(least_m) }
    }
}

/// How near a motion made possible is to its capture. See the module header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Likeness {
    /// Distance of the centres of all links from the raw capture, RMS, m.
    pub links_m: f64,
    /// RMS turn of the upper body's links from the smoothed capture, degrees.
    pub upper_deg: f64,
    /// And from the raw one.
    pub upper_raw_deg: f64,
    /// The largest difference of the times of contacts that were found again; `None` without any.
    pub times: Option<Beside>,
    /// Contacts of the plan.
    pub contacts: usize,
    /// Those of which none is found again, and those found that are in no plan.
    pub strange: usize,
    /// Rise in every flight.
    pub rises: Vec<Pair>,
    /// Strides.
    pub strides: Vec<Pair>,
}

impl Likeness {
    /// Of `made`, which is `captured` made possible on the feet of `character` with `plan`, over ground `ground_m` high. `smooth`: the capture as inverse
    /// dynamics smooths it (`dynamics::analysis::smoothed`).
    ///
    /// A plan that is `given` is what is asked for, and soles stand by it: times of contacts are compared where the plan was found.
    ///
    /// `None` of clips that differ in frames or rate: an edit of times.
    pub fn of(
        character: &Character,
        (captured, smooth): (&Clip, &Clip),
        made: &Clip,
        (plan, given): (&ContactPlan, bool),
        ground_m: f64,
        gravity: Vec3,
    ) -> Option<Self> {
        if captured.frames() != made.frames() || captured.rate_hz != made.rate_hz {
            return None;
        }
        let model = Model::new(character, gravity);
        let soles: Vec<Sole> = character.leg_soles().into_iter().map(|(_, sole)| sole).collect();
        let (times, strange) = if given {
            (None, 0)
        } else {
            let found = motion::contacts(made, &soles).0;
            let found = borne(&found, &needs(&model, made, ground_m), made, &soles, ground_m);
            times(plan, &found, &soles, made.duration_s())
        };
        let turned = |from: &Clip| root_mean_square(&turns(character, from, made)).to_degrees();
        Some(Self {
            links_m: root_mean_square(moved(character, captured, made).iter().flatten()),
            upper_deg: turned(smooth),
            upper_raw_deg: turned(captured),
            times,
            contacts: plan.contacts().len(),
            strange,
            rises: rises(&model, smooth, made, plan),
            strides: strides(smooth, made, plan, &soles),
        })
    }

    /// Rise that differs most, as a part of the captured; zero without flights.
    pub fn rise_off(&self) -> f64 {
        furthest(&self.rises, RISE_M)
    }

    /// Stride that differs most, as a part of the captured; zero without strides.
    pub fn stride_off(&self) -> f64 {
        furthest(&self.strides, STRIDE_M)
    }

    /// What is further off than is allowed, in words of [`Unmet`]; a motion with any of them is not the captured one.
    pub fn unlike(&self) -> Vec<Unmet> {
        let mut out = Vec::new();
        if self.links_m > LINKS_M {
            out.push(Unmet::Links { by_m: self.links_m });
        }
        if self.upper_deg > UPPER_DEG {
            out.push(Unmet::Upper { by_deg: self.upper_deg });
        }
        if let Some(Beside { point, at_s, by_s }) = self.times.clone().filter(|t| t.by_s.abs() > TIMES_S) {
            out.push(Unmet::Times { limb: point, at_s, by_s });
        }
        if self.strange > 0 {
            out.push(Unmet::Contacts { count: self.strange });
        }
        let (rise, stride) = (self.rise_off(), self.stride_off());
        if rise.abs() > PART {
            out.push(Unmet::Rise { by: rise });
        }
        if stride.abs() > PART {
            out.push(Unmet::Stride { by: stride });
        }
        out
    }
}

fn furthest(pairs: &[Pair], least_m: f64) -> f64 {
    pairs.iter().map(|p| p.off(least_m)).fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a })
}

/// How far the centre of every link is apart in two motions of one body, frame by frame, m.
pub(crate) fn moved(character: &Character, a: &Clip, b: &Clip) -> Vec<Vec<f64>> {
    let one = |f: usize| {
        let (a, b) = (Kinematics::new(&a.skeleton, a.pose(f)), Kinematics::new(&b.skeleton, b.pose(f)));
        let links = character.bodies.iter().enumerate().filter(|(_, body)| body.mass > 0.0);
        links.map(|(link, body)| (a.point(link, &body.com) - b.point(link, &body.com)).norm()).collect()
    };
    (0..b.frames()).map(one).collect()
}

/// By how much every link that no leg moves is turned in one motion against the other, in all frames, rad.
pub(crate) fn turns(character: &Character, a: &Clip, b: &Clip) -> Vec<f64> {
    let skeleton = &b.skeleton;
    let of_leg = |link: usize| {
        character.legs().any(|leg| leg.upper == link || skeleton.ancestors(link).any(|l| l == leg.upper))
    };
    let upper: Vec<usize> = (0..skeleton.links().len()).filter(|link| !of_leg(*link)).collect();
    let mut all = Vec::with_capacity(upper.len() * b.frames());
    for f in 0..b.frames() {
        let (a, b) = (Kinematics::new(skeleton, a.pose(f)), Kinematics::new(skeleton, b.pose(f)));
        all.extend(upper.iter().map(|link| a.world[*link].rotation.angle_to(&b.world[*link].rotation)));
    }
    all
}

/// Root of the mean square; zero of nothing.
pub(crate) fn root_mean_square<'a>(all: impl IntoIterator<Item = &'a f64>) -> f64 {
    let (sum, count) = all.into_iter().fold((0.0, 0_usize), |(sum, count), x| (sum + x * x, count + 1));
    (sum / count.max(1) as f64).sqrt()
}

/// Largest difference of the times of contacts in both plans, and how many contacts are in one only. Ends of the clip are no ends of contacts.
fn times(plan: &ContactPlan, found: &ContactPlan, soles: &[Sole], end_s: f64) -> (Option<Beside>, usize) {
    let (mut worst, mut strange): (Option<Beside>, usize) = (None, 0);
    let counts = |c: &Contact| {
        let cut = c.from_s < TIMES_S || c.to_s > end_s - TIMES_S;
        c.to_s - c.from_s > if cut { CUT_S } else { TIMES_S }
    };
    for sole in soles {
        let mut left: Vec<&Contact> = found.of(&sole.name).collect();
        for c in plan.of(&sole.name) {
            let shared = |o: &Contact| o.to_s.min(c.to_s) - o.from_s.max(c.from_s);
            let best = (0..left.len()).max_by(|a, b| shared(left[*a]).total_cmp(&shared(left[*b])));
            let Some(best) = best.filter(|i| shared(left[*i]) > 0.0) else {
                strange += usize::from(counts(c));
                continue;
            };
            let other = left.remove(best);
            let begins = (c.from_s.max(other.from_s) > TIMES_S).then_some((c.from_s, other.from_s));
            let ends = (c.to_s.min(other.to_s) < end_s - TIMES_S).then_some((c.to_s, other.to_s));
            for (asked_s, is_s) in begins.into_iter().chain(ends) {
                let by_s = is_s - asked_s;
                if worst.as_ref().is_none_or(|w| by_s.abs() > w.by_s.abs()) {
                    worst = Some(Beside { point: sole.name.clone(), at_s: asked_s, by_s });
                }
            }
        }
        strange += left.iter().filter(|c| counts(c)).count();
    }
    (worst, strange)
}

/// Rise in every flight of the plan that begins and ends in the clip.
fn rises(model: &Model, captured: &Clip, made: &Clip, plan: &ContactPlan) -> Vec<Pair> {
    let frames = made.frames();
    let flies = |f: usize| plan.at(f as f64 / made.rate_hz).next().is_none();
    let flights = runs(0..frames, flies).into_iter().filter(|run| run.start > 0 && run.end < frames);
    let mut state = State::new(model);
    let mut rise = |clip: &Clip, run: &std::ops::Range<usize>| {
        let mut height = |f: usize| {
            state.update_pose(model, clip.pose(f));
            state.com(model).y
        };
        let ends = 0.5 * (height(run.start - 1) + height(run.end));
        run.clone().map(&mut height).fold(f64::NEG_INFINITY, f64::max) - ends
    };
    let pair = |run: std::ops::Range<usize>| Pair {
        at_s: run.start as f64 / made.rate_hz,
        captured_m: rise(captured, &run),
        made_m: rise(made, &run),
    };
    flights.map(pair).collect()
}

/// Strides of every sole.
fn strides(captured: &Clip, made: &Clip, plan: &ContactPlan, soles: &[Sole]) -> Vec<Pair> {
    let mut out = Vec::new();
    for sole in soles {
        let place = |clip: &Clip, c: &Contact| {
            let frames = c.frames(clip.rate_hz, clip.frames());
            let count = frames.len().max(1) as f64;
            let middle = |f: usize| sole.center(&Kinematics::new(&clip.skeleton, clip.pose(f)));
            frames.map(middle).sum::<Vec3>() / count
        };
        let stances: Vec<_> = plan.of(&sole.name).collect();
        for pair in stances.windows(2) {
            let stride = |clip: &Clip| (place(clip, pair[1]) - place(clip, pair[0])).xz().norm();
            out.push(Pair { at_s: pair[1].from_s, captured_m: stride(captured), made_m: stride(made) });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(of: &[(&str, f64, f64)]) -> ContactPlan {
        let one = |(point, from_s, to_s): &(&str, f64, f64)| Contact {
            point: (*point).into(),
            from_s: *from_s,
            to_s: *to_s,
            world_from_point: None,
        };
        ContactPlan::new(of.iter().map(one).collect()).unwrap()
    }

    #[test]
    fn times_are_of_contacts_that_meet() {
        let sole = Sole { name: "l".into(), link: 0, corners: Vec::new() };
        let soles = [sole];
        let asked = plan(&[("l", 0.0, 0.5), ("l", 1.0, 1.6), ("l", 2.0, 2.2)]);
        let same = times(&asked, &asked, &soles, 3.0);
        assert_eq!((same.0.unwrap().by_s, same.1), (0.0, 0));
        let (worst, strange) = times(&asked, &plan(&[("l", 0.02, 0.57), ("l", 0.96, 1.6)]), &soles, 3.0);
        let worst = worst.unwrap();
        assert!(
            (worst.by_s - 0.07).abs() < 1e-12 && worst.at_s == 0.5 && strange == 1,
            "{worst:?} {strange}"
        );
        assert_eq!(times(&plan(&[]), &plan(&[]), &soles, 0.0), (None, 0));
        assert_eq!(times(&plan(&[]), &asked, &soles, 3.0), (None, 3));
        // what the clip's beginning leaves of a contact
        assert_eq!(times(&plan(&[("l", 0.0, 0.07)]), &plan(&[]), &soles, 3.0), (None, 0));
    }

    #[test]
    fn nothing_has_no_mean() {
        assert_eq!(root_mean_square(&[]), 0.0);
        assert_eq!(root_mean_square(&[3.0, -3.0]), 3.0);
    }

    #[test]
    fn what_is_further_off_than_allowed_is_named() {
        let pair = |captured_m, made_m| Pair { at_s: 0.0, captured_m, made_m };
        let mut of = Likeness { strides: vec![pair(1.0, 0.95), pair(0.05, 0.065)], ..Likeness::default() };
        assert!(of.unlike().is_empty());
        of.strides.push(pair(1.0, 0.86));
        of.rises.push(pair(0.3, 0.36));
        of.upper_deg = 4.0;
        let words: Vec<String> = of.unlike().iter().map(ToString::to_string).collect();
        assert_eq!(
            words,
            [
                "the upper body is turned by 4.0°",
                "a flight rises 20 % higher than captured",
                "a stride is 14 % shorter than captured"
            ]
        );
    }
}
