//! Minimisation with L-BFGS and the Moré–Thuente line search of argmin.
//!
//! argmin asks for value and gradient one after the other; both come from one evaluation, kept until the
//! point changes. Its first step is the bare gradient, however long: the objective is scaled so that it has
//! length one.

use std::cell::RefCell;
use std::ops::ControlFlow;

use argmin::core::{CostFunction, Error, Executor, Gradient, State};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;

use crate::dense::dot;
use crate::error::FitError;

/// Pairs of differences L-BFGS remembers.
const MEMORY: usize = 10;
/// Evaluations per iteration before the line search is taken for lost.
const EVALUATIONS: usize = 20;
/// Improvement of the value in one iteration, relative, at which there is nothing left to win.
const ENOUGH: f64 = 1e-10;

/// Something to minimise.
pub(crate) trait Objective {
    /// Writes the gradient at `p`, returns the value.
    fn evaluate(&mut self, p: &[f64], gradient: &mut [f64]) -> Result<f64, FitError>;
}

/// Who looks on while a model is fitted: told how often the likelihood was evaluated so far, before the next time; may end it.
pub type Watch<'a> = dyn Fn(usize) -> ControlFlow<()> + Sync + 'a;

/// An objective that is watched. Once it was ended, nothing is evaluated.
pub(crate) struct Watched<'a, 'w, O> {
    objective: &'a mut O,
    watch: &'a Watch<'w>,
    evaluations: usize,
    ended: bool,
}

impl<'a, 'w, O: Objective> Watched<'a, 'w, O> {
    pub(crate) fn new(objective: &'a mut O, watch: &'a Watch<'w>) -> Self {
        Self { objective, watch, evaluations: 0, ended: false }
    }

    /// As [`descend`]; [`FitError::Cancelled`] where the watcher ended it, whatever the optimiser made of that.
    pub(crate) fn descend(mut self, start: Vec<f64>, iterations: usize) -> Result<Descent, FitError> {
        let found = descend(&mut self, start, iterations);
        if self.ended { Err(FitError::Cancelled { evaluations: self.evaluations }) } else { found }
    }
}

impl<O: Objective> Objective for Watched<'_, '_, O> {
    fn evaluate(&mut self, p: &[f64], gradient: &mut [f64]) -> Result<f64, FitError> {
        if self.ended || (self.watch)(self.evaluations).is_break() {
            self.ended = true;
            return Err(FitError::Cancelled { evaluations: self.evaluations });
        }
        self.evaluations += 1;
        self.objective.evaluate(p, gradient)
    }
}

/// Where a minimisation ended.
#[derive(Clone, Debug)]
pub(crate) struct Descent {
    pub point: Vec<f64>,
    pub value: f64,
    pub start_value: f64,
    pub iterations: usize,
    pub evaluations: usize,
    /// Why it ended, in the optimiser's words.
    pub stopped: String,
}

struct Last<'a, O> {
    objective: &'a mut O,
    point: Vec<f64>,
    gradient: Vec<f64>,
    value: f64,
    scale: f64,
    evaluations: usize,
    most: usize,
}

impl<O: Objective> Last<'_, O> {
    fn at(&mut self, p: &[f64]) -> Result<(), Error> {
        if self.point == p {
            return Ok(());
        }
        if self.evaluations >= self.most {
            return Err(Error::msg("the line search does not end"));
        }
        self.evaluations += 1;
        self.value = self.objective.evaluate(p, &mut self.gradient)?;
        if !self.value.is_finite() || self.gradient.iter().any(|g| !g.is_finite()) {
            self.point.clear();
            return Err(Error::msg("the likelihood is not finite"));
        }
        self.point.clear();
        self.point.extend_from_slice(p);
        Ok(())
    }
}

struct Shared<'a, O>(RefCell<Last<'a, O>>);

impl<O: Objective> CostFunction for Shared<'_, O> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, p: &Vec<f64>) -> Result<f64, Error> {
        let mut last = self.0.borrow_mut();
        last.at(p)?;
        Ok(last.scale * last.value)
    }
}

impl<O: Objective> Gradient for Shared<'_, O> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, p: &Vec<f64>) -> Result<Vec<f64>, Error> {
        let mut last = self.0.borrow_mut();
        last.at(p)?;
        Ok(last.gradient.iter().map(|g| g * last.scale).collect())
    }
}

/// Minimises from `start` with at most `iterations` steps.
///
/// # Errors
/// The objective cannot be evaluated at the start.
pub(crate) fn descend<O: Objective>(
    objective: &mut O,
    start: Vec<f64>,
    iterations: usize,
) -> Result<Descent, FitError> {
    let mut gradient = vec![0.0; start.len()];
    let start_value = objective.evaluate(&start, &mut gradient)?;
    let length = dot(&gradient, &gradient).sqrt();
    if iterations == 0 || length == 0.0 {
        let stopped = if iterations == 0 { "no iterations asked for" } else { "the gradient is zero" }.into();
        return Ok(Descent {
            point: start,
            value: start_value,
            start_value,
            iterations: 0,
            evaluations: 1,
            stopped,
        });
    }
    let scale = 1.0 / length;
    let last = Last {
        objective,
        point: start.clone(),
        gradient,
        value: start_value,
        scale,
        evaluations: 1,
        most: EVALUATIONS * iterations,
    };
    let refused = |e: Error| FitError::Optimiser { iterations: 0, reason: e.to_string() };
    let solver = LBFGS::new(MoreThuenteLineSearch::new(), MEMORY)
        .with_tolerance_grad(1e-9)
        .and_then(|s| s.with_tolerance_cost(ENOUGH * scale * start_value.abs().max(1.0)))
        .map_err(refused)?;
    let result = Executor::new(Shared(RefCell::new(last)), solver)
        .configure(|state| state.param(start).max_iters(iterations as u64))
        .ctrlc(false)
        .run()
        .map_err(refused)?;
    let state = result.state();
    let best = state.get_best_param().cloned();
    let Some(point) = best else {
        return Err(FitError::Optimiser { iterations: 0, reason: "no step was taken".into() });
    };
    let stopped = match state.get_termination_reason() {
        Some(reason) => reason.text().to_string(),
        None => "unknown".into(),
    };
    let evaluations = result.problem.problem.as_ref().map_or(0, |p| p.0.borrow().evaluations);
    Ok(Descent {
        value: state.get_best_cost() / scale,
        point,
        start_value,
        iterations: state.get_iter() as usize,
        evaluations,
        stopped,
    })
}
