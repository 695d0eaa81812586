//! A program as a reactive property: `fn react(body, params)`, every control step.
//!
//! In: the simulated state. Out: the drives of the joints whose goals it turned or whose tension it changed. A goal is turned from what the
//! motion and earlier properties ask of the joint, within its limits; the load that the muscles carry stays what it was, so that more
//! tension does not move the pose. Muscles answer as they answer any goal: stiff ones soon, relaxed ones late.
//!
//! The memory of a program is `this`, a map of numbers, texts, truths, lists and maps. A [`Reaction`] that is cloned has a copy of
//! it, so that a look-ahead which replays steps comes to the same end; noise is a function of time and seed for the same reason.

use std::fmt;
use std::sync::Arc;

use controllers::{ControlStep, Drive, Reactive, ReactiveError, Rest};
use dynamics::digest::Digest;
use motion::Value;
use rhai::{Dynamic, Engine};

use crate::body::BodyHandle;
use crate::engine::engine;
use crate::limits::REACT_STEPS;
use crate::program::is_plain;
use crate::{Entry, Program, ProgramError};

/// What a program did to one joint in a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Reacted {
    /// The joint.
    pub joint: String,
    /// The furthest turn of its goal, degrees.
    pub turned_deg: f64,
    /// When, s.
    pub turned_at_s: f64,
    /// Least and largest factor on its tension.
    pub tension: (f64, f64),
}

/// A program that reacts, with its memory. See the module header.
pub struct Reaction {
    program: Arc<Program>,
    engine: Arc<Engine>,
    memory: Dynamic,
    /// The motion begins so much after the time that the program counts from, s.
    by_s: f64,
    body: Option<BodyHandle>,
    reacted: Vec<Reacted>,
}

impl Clone for Reaction {
    fn clone(&self) -> Self {
        Self {
            program: self.program.clone(),
            engine: self.engine.clone(),
            memory: self.memory.clone(),
            by_s: self.by_s,
            // handles of one run must not write into another
            body: None,
            reacted: self.reacted.clone(),
        }
    }
}

impl fmt::Debug for Reaction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Reaction")
            .field("file", &self.program.file())
            .field("memory", &self.memory)
            .field("by_s", &self.by_s)
            .finish_non_exhaustive()
    }
}

impl Reaction {
    /// A program before its first step.
    ///
    /// # Errors
    /// [`ProgramError::File`] without `fn react(body, params)`.
    pub fn new(program: Program) -> Result<Self, ProgramError> {
        program.must(Entry::React)?;
        Ok(Self {
            memory: Dynamic::from_map(program.memory()),
            program: Arc::new(program),
            engine: Arc::new(engine(REACT_STEPS)),
            by_s: 0.0,
            body: None,
            reacted: Vec::new(),
        })
    }

    /// The program.
    pub fn program(&self) -> &Program {
        &self.program
    }

    /// The same, its time counted from `by_s` seconds later: the motion was cut out of a longer one, or shifted.
    pub fn shifted(&self, by_s: f64) -> Self {
        Self { by_s: self.by_s - by_s, ..self.clone() }
    }

    /// The program's time when the run begins, s.
    pub fn begins_s(&self) -> f64 {
        self.by_s
    }

    /// What it did so far, joint by joint.
    pub fn reacted(&self) -> &[Reacted] {
        &self.reacted
    }

    fn note(&mut self, joint: &str, turned_deg: f64, tension: f64, at_s: f64) {
        let known = self.reacted.iter().position(|r| r.joint == joint);
        let at = known.unwrap_or_else(|| {
            let new =
                Reacted { joint: joint.into(), turned_deg: 0.0, turned_at_s: at_s, tension: (1.0, 1.0) };
            self.reacted.push(new);
            self.reacted.len() - 1
        });
        let r = &mut self.reacted[at];
        if turned_deg > r.turned_deg {
            (r.turned_deg, r.turned_at_s) = (turned_deg, at_s);
        }
        r.tension = (r.tension.0.min(tension), r.tension.1.max(tension));
    }
}

/// The drive of a joint whose goal is turned from `asked` to `goal`, and its tension multiplied.
fn turned(
    drive: &Drive,
    step: &ControlStep<'_>,
    body: usize,
    asked: &Value,
    goal: &Value,
    factor: f64,
) -> Drive {
    let stiffness = drive.stiffness * factor;
    // damping goes with the root of stiffness
    let damping = drive.damping * factor.sqrt();
    let set_points = &step.set_points[body];
    let rest = match (drive.rest, asked, goal) {
        (Rest::Scalar(rest), Value::Scalar(asked), Value::Scalar(goal)) => {
            // what the springs carry at the goal
            let load = motion::Vec3::x() * (drive.stiffness * (asked - rest));
            set_points.rest(&Rest::Scalar(*goal), load, stiffness)
        }
        (Rest::Ball { target, shift }, Value::Rotation(asked), Value::Rotation(goal)) => {
            let target = Rest::ball(goal * asked.inverse() * target);
            set_points.rest(&target, -shift * drive.stiffness, stiffness)
        }
        (rest, ..) => rest,
    };
    Drive { stiffness, damping, rest }
}

impl Reactive for Reaction {
    fn identify(&self, d: &mut Digest) {
        d.text(self.program.text());
        d.number(self.by_s);
        d.list(&self.program.parameters(), |d, (name, value)| {
            d.text(name);
            d.text(value);
        });
    }

    fn react(&mut self, step: &ControlStep<'_>, drives: &mut [Drive]) -> Result<(), ReactiveError> {
        let body = self.body.get_or_insert_with(|| BodyHandle::new(step.model)).clone();
        body.write().fill(step, self.by_s);
        let (program, engine) = (self.program.clone(), self.engine.clone());
        let again = || {
            body.write().forget();
            body.clone()
        };
        program.call(&engine, Entry::React, Some(&mut self.memory), body.clone(), again)?;
        if !is_plain(&self.memory) {
            let message = "`this` may hold numbers, texts, true or false, lists and maps of them: what a joint or the body is belongs to one step";
            return Err(program.at_function("react", message).into());
        }
        let sensed = body.read();
        for (name, &(i, dof)) in sensed.muscles() {
            let factor = sensed.tension[i];
            if factor == 1.0 && sensed.turns[i] == motion::Vec3::zeros() {
                continue;
            }
            let (asked, goal) = sensed.goals(i, dof);
            drives[i] = turned(&drives[i], step, i, &asked, &goal, factor);
            self.note(name, asked.distance(&goal).to_degrees(), factor, step.time_s);
        }
        Ok(())
    }

    fn lines(&self) -> Vec<String> {
        let file = self.program.file().display();
        if self.reacted.is_empty() {
            return vec![format!("{file}: changed nothing")];
        }
        let one = |r: &Reacted| {
            let mut text = r.joint.clone();
            if r.turned_deg > 0.0 {
                text += &format!(" turned by at most {:.2}° at {:.2} s", r.turned_deg, r.turned_at_s);
            }
            match r.tension {
                (1.0, 1.0) => {}
                (lo, hi) => text += &format!(" tension × {lo:.2} to {hi:.2}"),
            }
            text
        };
        self.reacted.iter().map(|r| format!("{file}: {}", one(r))).collect()
    }
}
