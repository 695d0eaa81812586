//! Performing a take: the dynamic pass, whole or span by span.
//!
//! In: a [`Take`], the engines there are. Out: a [`Performed`]: the take with what came of it. A take that is only previewed is one
//! that was not performed; results are written of both in the same way.

use std::sync::Mutex;

use bodies::{OnSoles, SolesError};
use controllers::ReactiveError;
use motion::ik::IkError;
use motion::stance::StanceSpan;
use rayon::prelude::*;
use sim::foresight::ForesightError;
use sim::{EngineEntry, Engines, Outcome, PassError, UnknownEngine};

use crate::slides::Slides;
use crate::{Progress, Take};

/// A standing span of a clip, performed.
pub struct PerformedSpan {
    /// Which of the stance's spans.
    pub span: usize,
    /// Its take.
    pub take: Take,
    /// What came of it.
    pub outcome: Outcome,
}

/// What came of a take.
pub enum Runs {
    /// Nothing was simulated.
    Preview,
    /// It was performed from beginning to end.
    Whole(Box<Outcome>),
    /// A clip that also steps: its standing spans, each by itself, in order.
    Spans(Vec<PerformedSpan>),
}

/// A take and what came of it. See the module header.
pub struct Performed {
    /// Who performed what.
    pub take: Take,
    /// What came of it.
    pub runs: Runs,
}

/// Why a take cannot be performed.
#[derive(Debug, thiserror::Error)]
pub enum PerformError {
    /// An engine that there is not.
    #[error(transparent)]
    Engine(#[from] UnknownEngine),
    /// Legs that two-bone IK cannot solve.
    #[error(transparent)]
    Legs(#[from] IkError),
    /// Joints that no muscle moves.
    #[error(transparent)]
    Slides(#[from] Slides),
    /// Soles that the body cannot have.
    #[error(transparent)]
    Soles(#[from] SolesError),
    /// The pass.
    #[error(transparent)]
    Pass(#[from] PassError),
}

impl PerformError {
    /// Whether the fault lies in the input rather than in the run.
    pub fn is_input(&self) -> bool {
        let program = matches!(self, Self::Pass(PassError::Reactive(ReactiveError::Program { .. })));
        let replay = matches!(self, Self::Pass(PassError::Foresight(ForesightError::Replay(_))));
        let overlap = matches!(self, Self::Pass(PassError::Overlap(_)));
        let refused = matches!(self, Self::Engine(_) | Self::Slides(_) | Self::Soles(_));
        program || replay || overlap || refused
    }
}

impl Performed {
    /// The outcome of a take performed whole.
    pub fn outcome(&self) -> Option<&Outcome> {
        match &self.runs {
            Runs::Whole(outcome) => Some(outcome),
            Runs::Preview | Runs::Spans(_) => None,
        }
    }

    /// The spans of a take performed in parts.
    pub fn spans(&self) -> &[PerformedSpan] {
        match &self.runs {
            Runs::Spans(spans) => spans,
            Runs::Preview | Runs::Whole(_) => &[],
        }
    }

    /// Why the first run that stopped early did.
    pub fn diverged(&self) -> Option<String> {
        let spans = self.spans().iter().map(|s| &s.outcome);
        let mut all = self.outcome().into_iter().chain(spans);
        all.find_map(|o| o.diverged.as_ref()).map(ToString::to_string)
    }
}

impl Take {
    /// The motion asked for, as a result that can be written.
    pub fn preview(self) -> Performed {
        Performed { take: self, runs: Runs::Preview }
    }

    /// Performs the take with the engine its conditions name, made possible where it steps: whole, or, of a free clip that also steps, every standing
    /// span by itself, in parallel; the same on any number of threads.
    ///
    /// # Errors
    /// [`PerformError`]: no such engine, legs that cannot be solved, passes that cannot start. A divergence is an outcome,
    /// not an error: its trace is kept.
    pub fn perform(self, engines: &Engines, progress: &Progress<'_>) -> Result<Performed, PerformError> {
        let take = if self.steps_blind() {
            progress.part("making it possible");
            self.made_possible()?.0
        } else {
            self
        };
        take.perform_as_asked(engines, progress)
    }

    fn perform_as_asked(self, engines: &Engines, progress: &Progress<'_>) -> Result<Performed, PerformError> {
        progress.part("performing");
        let runs = if self.stands_in_parts() {
            Runs::Spans(self.perform_spans(engines, progress)?)
        } else {
            Runs::Whole(Box::new(self.outcome(engines, &mut |x| progress.at(x))?))
        };
        Ok(Performed { take: self, runs })
    }

    /// The engine that performs it.
    ///
    /// # Errors
    /// [`UnknownEngine`], with the nearest name.
    pub fn engine<'a>(&self, engines: &'a Engines) -> Result<&'a EngineEntry, UnknownEngine> {
        engines.get(self.conditions.performer())
    }

    /// The engine in which a study of it searches.
    ///
    /// # Errors
    /// [`UnknownEngine`], with the nearest name.
    pub fn searcher<'a>(&self, engines: &'a Engines) -> Result<&'a EngineEntry, UnknownEngine> {
        engines.get(self.conditions.searcher())
    }

    /// Whether muscles can make the motion at all.
    ///
    /// # Errors
    /// [`Slides`]: joints that no muscle moves.
    pub fn check_performable(&self) -> Result<(), Slides> {
        Slides::of(self).map_or(Ok(()), Err)
    }

    /// What comes of the take performed from beginning to end.
    ///
    /// # Errors
    /// As [`Take::perform`].
    pub fn outcome(&self, engines: &Engines, progress: &mut dyn FnMut(f64)) -> Result<Outcome, PerformError> {
        let engine = self.engine(engines)?;
        self.check_performable()?;
        OnSoles::new(&self.body.character, &self.soles())?;
        let mut outcome = self.pass().run(engine, progress)?;
        outcome.trace.colors.clone_from(&self.body.colors);
        outcome.trace.plan.clone_from(&self.asked.contacts);
        Ok(outcome)
    }

    fn perform_spans(
        &self,
        engines: &Engines,
        progress: &Progress<'_>,
    ) -> Result<Vec<PerformedSpan>, PerformError> {
        let Some(stance) = &self.asked.stance else { return Ok(Vec::new()) };
        let standing: Vec<(usize, &StanceSpan)> =
            stance.spans.iter().enumerate().filter(|(_, s)| s.stands).collect();
        let frames: usize = standing.iter().map(|(_, s)| s.frames.len()).sum();
        let done = Mutex::new(vec![0.0; standing.len()]);
        let one = |(i, (span, of)): (usize, &(usize, &StanceSpan))| {
            let take = self.stand(of, stance.ground_m)?;
            let outcome = take.outcome(engines, &mut |x| {
                if let Ok(mut done) = done.lock() {
                    done[i] = x * of.frames.len() as f64 / frames as f64;
                    progress.at(done.iter().sum());
                }
            })?;
            Ok(PerformedSpan { span: *span, take, outcome })
        };
        standing.par_iter().enumerate().map(one).collect()
    }
}
