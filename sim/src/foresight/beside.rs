//! What acts on rollouts beside the plan: pushes under way, and what reactive properties have changed.
//!
//! In: the pushes of a pass, its drives as they are when a search begins. Out: both, carried on through rollouts.
//!
//! *Pushes.* Who looks ahead feels a push from the step in which it begins, and takes it that it goes on as it is until its end; nobody knows of
//! a push before it begins. *Reactive properties* answer the state, which a rollout cannot ask them about: what they have done to the drives of
//! the present step (added stiffness and damping, turned and shifted rests) is frozen, and done to all drives of the rollout.

use controllers::{Drive, Rest};
use dynamics::{Push, Wrench};
use motion::{Quat, Vec3};

use crate::Engine;
use crate::core::Core;

/// What acts beside the plan. See the module header.
#[derive(Clone, Debug, Default)]
pub(super) struct Beside {
    pushes: Vec<Push>,
    rate_hz: f64,
    frozen: Vec<Frozen>,
}

/// What was done to the drive of a body.
#[derive(Clone, Copy, Debug)]
struct Frozen {
    body: usize,
    stiffness: f64,
    damping: f64,
    turn: Turn,
}

#[derive(Clone, Copy, Debug)]
enum Turn {
    Scalar(f64),
    Ball(Quat, Vec3),
    None,
}

impl Beside {
    /// Takes what acts in the step that begins after `row`: pushes that are under way, and what makes `now` of the drives of the plan.
    ///
    /// * `rate_hz`: steps of the pass per second
    pub(super) fn take(
        &mut self,
        row: usize,
        rate_hz: f64,
        pushes: &[Push],
        planned: &[Drive],
        now: &[Drive],
    ) {
        self.rate_hz = rate_hz;
        self.pushes.clear();
        self.pushes.extend(pushes.iter().filter(|p| p.acts(row as f64 / rate_hz)).cloned());
        self.frozen.clear();
        let changed = planned.iter().zip(now).enumerate().filter(|(_, (planned, now))| planned != now);
        self.frozen.extend(changed.map(|(body, (planned, now))| Frozen {
            body,
            stiffness: now.stiffness - planned.stiffness,
            damping: now.damping - planned.damping,
            turn: match (planned.rest, now.rest) {
                (Rest::Scalar(from), Rest::Scalar(to)) => Turn::Scalar(to - from),
                (Rest::Ball { target: a, shift: from }, Rest::Ball { target: b, shift: to }) => {
                    Turn::Ball(b * a.inverse(), to - from)
                }
                _ => Turn::None,
            },
        }));
    }

    /// Whether a push acts in the step after `row` that was not known when this was taken.
    pub(super) fn misses(&self, row: usize, rate_hz: f64, pushes: &[Push]) -> bool {
        pushes.iter().any(|p| p.acts(row as f64 / rate_hz) && !self.pushes.contains(p))
    }

    /// Does to the drives of the plan what reactive properties have done to those of the present.
    pub(super) fn shift(&self, drives: &mut [Drive]) {
        for f in &self.frozen {
            let drive = &mut drives[f.body];
            drive.stiffness = (drive.stiffness + f.stiffness).max(0.0);
            drive.damping = (drive.damping + f.damping).max(0.0);
            match (&mut drive.rest, f.turn) {
                (Rest::Scalar(at), Turn::Scalar(by)) => *at += by,
                (Rest::Ball { target, shift }, Turn::Ball(turn, by)) => {
                    *target = turn * *target;
                    *shift += by;
                }
                _ => {}
            }
        }
    }

    /// Pushes a body for a step of `stride` rows after `row`; a push that ends within it has the same impulse.
    pub(super) fn push(&self, core: &mut Core, row: usize, stride: usize) {
        for p in &self.pushes {
            let acts = (row..row + stride).filter(|&row| p.acts(row as f64 / self.rate_hz)).count();
            if acts > 0 {
                let point = core.state().point(&core.model, p.link, &p.at);
                let force = p.force * (acts as f64 / stride as f64);
                core.add_wrench(&Wrench { link: p.link, point, force, moment: Vec3::zeros() });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motion::rotation::{exp, log};

    fn push(start_s: f64) -> Push {
        Push { link: 0, at: Vec3::zeros(), force: Vec3::x(), start_s, duration_s: 0.1 }
    }

    /// A push is known from the step in which it begins to the one in which it ends, and no push before.
    #[test]
    fn pushes_are_known_while_they_act() {
        let pushes = [push(1.0), push(1.05)];
        let mut beside = Beside::default();
        for (row, acting, new) in
            [(99, 0, true), (100, 1, false), (104, 1, true), (105, 2, false), (110, 1, false)]
        {
            beside.take(row, 100.0, &pushes, &[], &[]);
            assert_eq!(beside.pushes.len(), acting, "row {row}");
            assert_eq!(beside.misses(row + 1, 100.0, &pushes), new, "row {row}");
        }
        beside.take(115, 100.0, &pushes, &[], &[]);
        assert!(beside.pushes.is_empty());
    }

    /// What was done to the present drives is done to the present drives: frozen, it makes one of the other; what was not touched stays.
    #[test]
    fn what_is_frozen_is_what_was_done() {
        let ball = |turn: Vec3, shift| Drive {
            stiffness: 10.0,
            damping: 1.0,
            rest: Rest::Ball { target: exp(&turn), shift },
        };
        let hinge = |at, stiffness| Drive { stiffness, damping: 0.5, rest: Rest::Scalar(at) };
        let planned = [Drive::NONE, ball(Vec3::x() * 0.3, Vec3::zeros()), hinge(0.2, 5.0), hinge(0.1, 4.0)];
        let now =
            [Drive::NONE, ball(Vec3::new(0.1, 0.4, 0.0), Vec3::y() * 0.02), hinge(0.5, 7.0), hinge(0.1, 4.0)];
        let mut beside = Beside::default();
        beside.take(0, 100.0, &[], &planned, &now);
        assert_eq!(beside.frozen.len(), 2);
        let mut drives = planned;
        beside.shift(&mut drives);
        for (a, b) in drives.iter().zip(&now) {
            assert!((a.stiffness - b.stiffness).abs() < 1e-12 && (a.damping - b.damping).abs() < 1e-12);
            match (a.rest, b.rest) {
                (Rest::Ball { target: a, shift: s }, Rest::Ball { target: b, shift: t }) => {
                    assert!(log(&(a * b.inverse())).norm() < 1e-12 && (s - t).norm() < 1e-12);
                }
                (Rest::Scalar(a), Rest::Scalar(b)) => assert!((a - b).abs() < 1e-12),
                (a, b) => assert_eq!(a, b),
            }
        }
        assert_eq!(drives[3], planned[3]);
    }
}
