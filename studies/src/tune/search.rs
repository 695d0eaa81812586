//! The search: a solver walks, every point it asks for is costed once and kept.
//!
//! In: an [`Objective`] over the unit cube, [`Search`], samples of an earlier, interrupted run. Out: all samples in the
//! order in which they were asked for.
//!
//! A solver is a function of its seed and of the costs it is given. So an interrupted search is resumed by running it
//! again: points already costed are answered from the samples kept, and from the first new one on it is as if it
//! had never stopped. Nothing of a solver's inside has to be saved, and any solver of argmin can be resumed.

use std::cell::RefCell;
use std::collections::HashMap;

use argmin::core::{
    CostFunction, Error, IterState, Problem, SendAlias, Solver, State, SyncAlias, TerminationStatus,
};
use argmin::solver::neldermead::NelderMead;
use motion::names::Word;
use rand::SeedableRng;
use rand_pcg::Pcg64;
use rayon::prelude::*;

use super::cmaes::{CmaEs, Iteration, uniform};
use super::point::Point;

/// What is minimised.
pub trait Objective: Sync {
    /// Costs a point of the unit cube.
    fn sample(&self, u: &[f64]) -> Sample;
    /// What identifies it: the values of the parameters at a point.
    fn values(&self, u: &[f64]) -> Vec<f64>;
}

/// A point costed.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Values of the parameters, in their units.
    pub values: Vec<f64>,
    /// The cost.
    pub cost: f64,
    /// What it is made of, unweighted, by [`super::TERMS`].
    pub terms: Vec<f64>,
    /// Runs survived.
    pub survived: usize,
}

/// A solver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SolverKind {
    /// CMA-ES: many parameters, costs that jump; uses all cores.
    #[default]
    CmaEs,
    /// Nelder and Mead: few parameters, smooth costs; one point after another.
    NelderMead,
}

impl Word for SolverKind {
    const KIND: &'static str = "solver";
    const WORDS: &'static [(Self, &'static str, &'static str)] =
        &[(Self::CmaEs, "cma-es", "CMA-ES"), (Self::NelderMead, "nelder-mead", "Nelder and Mead")];
}

/// Where a search starts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SearchStart {
    /// At the scene's values.
    #[default]
    Scene,
    /// Anywhere in the ranges, by the seed.
    Random,
}

impl Word for SearchStart {
    const KIND: &'static str = "start";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Scene, "scene", "At the scene's values"),
        (Self::Random, "random", "Anywhere in the ranges"),
    ];
}

/// How a search runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    /// Who walks.
    pub solver: SolverKind,
    /// Seed of all random numbers.
    pub seed: u64,
    /// No generation begins when this many points have been costed.
    pub evaluations: usize,
    /// Where it starts; `None`: a random point.
    pub start: Option<Vec<f64>>,
    /// First step, part of the ranges.
    pub step: f64,
}

impl Search {
    /// The name of where it starts.
    pub fn start_name(&self) -> SearchStart {
        if self.start.is_some() { SearchStart::Scene } else { SearchStart::Random }
    }
}

/// CMA-ES ends when its points are this near to each other, part of the ranges.
const NEAR: f64 = 1e-4;
/// Nelder and Mead end when the costs of the simplex have this standard deviation.
const ALIKE: f64 = 1e-6;

/// Runs a search in `n` dimensions. `known`: samples of the same search, interrupted. After every generation `kept` is
/// given all samples so far; its error ends the search.
///
/// # Errors
/// Those of `kept`, as text.
pub fn search(
    objective: &dyn Objective,
    n: usize,
    how: &Search,
    known: Vec<Sample>,
    kept: &mut dyn FnMut(&[Sample]) -> Result<(), String>,
) -> Result<Vec<Sample>, String> {
    let start = how.start.clone().unwrap_or_else(|| {
        let mut random = Pcg64::seed_from_u64(how.seed);
        (0..n).map(|_| uniform(&mut random)).collect()
    });
    let costs = Costs::new(objective, known);
    let walk = match how.solver {
        SolverKind::CmaEs => {
            costs.all(&[Point(start.clone())]);
            // a random start has used this seed's numbers; the solver gets others
            let solver = CmaEs::new(&start, how.step, how.seed ^ WALK, NEAR);
            run(solver, &costs, how.evaluations, kept)
        }
        SolverKind::NelderMead => {
            let corner = |i: usize| {
                let mut x = start.clone();
                // towards the middle, so that no corner is mirrored onto another
                x[i] += if x[i] > 0.5 { -how.step } else { how.step };
                Point(x)
            };
            let simplex: Vec<Point> =
                std::iter::once(Point(start.clone())).chain((0..n).map(corner)).collect();
            // cost the whole generation on all cores first; the solver then finds the costs in the cache
            costs.all(&simplex);
            if costs.kept.borrow().fresh {
                kept(&costs.kept.borrow().samples)?;
            }
            let solver = NelderMead::new(simplex).with_sd_tolerance(ALIKE).map_err(|e| e.to_string())?;
            run(solver, &costs, how.evaluations, kept)
        }
    };
    walk.map_err(|e| e.to_string())?;
    Ok(costs.kept.into_inner().samples)
}

/// Changes the seed for the solver's random numbers (by exclusive or), so that they are not those of a random start.
const WALK: u64 = 0x9e37_79b9_7f4a_7c15;

/// argmin's executor, but for what happens between two generations.
fn run<'a, S: Solver<&'a Costs<'a>, Iteration>>(
    mut solver: S,
    costs: &'a Costs<'a>,
    evaluations: usize,
    kept: &mut dyn FnMut(&[Sample]) -> Result<(), String>,
) -> Result<(), Error> {
    let mut problem = Problem::new(costs);
    let (mut state, _) = solver.init(&mut problem, IterState::new())?;
    loop {
        let before = costs.kept.borrow().samples.len();
        if before >= evaluations || solver.terminate(&state) != TerminationStatus::NotTerminated {
            return Ok(());
        }
        (state, _) = solver.next_iter(&mut problem, state)?;
        let all = costs.kept.borrow();
        if all.samples.len() == before {
            // nothing new: the points are the same to the last bit
            return Ok(());
        }
        if all.fresh {
            kept(&all.samples).map_err(Error::msg)?;
        }
    }
}

/// Costs by point: what is known is not computed again.
struct Costs<'a> {
    objective: &'a dyn Objective,
    kept: RefCell<Kept>,
}

struct Kept {
    /// Samples of the interrupted run.
    known: HashMap<Vec<u64>, Sample>,
    /// Place of every sample of this run.
    at: HashMap<Vec<u64>, usize>,
    samples: Vec<Sample>,
    /// Whether this run has added anything to those.
    fresh: bool,
}

fn key(values: &[f64]) -> Vec<u64> {
    values.iter().map(|x| x.to_bits()).collect()
}

impl<'a> Costs<'a> {
    fn new(objective: &'a dyn Objective, known: Vec<Sample>) -> Self {
        let known = known.into_iter().map(|s| (key(&s.values), s)).collect();
        let kept = Kept { known, at: HashMap::new(), samples: Vec::new(), fresh: false };
        Self { objective, kept: RefCell::new(kept) }
    }

    /// Costs of points, in their order; new ones are computed side by side.
    fn all(&self, points: &[Point]) -> Vec<f64> {
        let folded: Vec<Vec<f64>> = points.iter().map(Point::folded).collect();
        let keys: Vec<Vec<u64>> = folded.iter().map(|u| key(&self.objective.values(u))).collect();
        let mut wanted: Vec<usize> = Vec::new();
        {
            let kept = self.kept.borrow();
            for i in 0..points.len() {
                let have = kept.at.contains_key(&keys[i]) || kept.known.contains_key(&keys[i]);
                if !have && !wanted.iter().any(|&j| keys[j] == keys[i]) {
                    wanted.push(i);
                }
            }
        }
        let objective = self.objective;
        let found: Vec<Sample> =
            wanted.par_iter().with_max_len(1).map(|&i| objective.sample(&folded[i])).collect();
        let mut kept = self.kept.borrow_mut();
        let kept = &mut *kept;
        kept.fresh |= !found.is_empty();
        let mut found: HashMap<&[u64], Sample> =
            wanted.iter().map(|&i| keys[i].as_slice()).zip(found).collect();
        keys.iter()
            .map(|k| {
                if let Some(&at) = kept.at.get(k) {
                    return kept.samples[at].cost;
                }
                let sample = found.remove(k.as_slice()).unwrap_or_else(|| kept.known[k].clone());
                kept.at.insert(k.clone(), kept.samples.len());
                kept.samples.push(sample);
                kept.samples[kept.samples.len() - 1].cost
            })
            .collect()
    }
}

impl CostFunction for &Costs<'_> {
    type Param = Point;
    type Output = f64;

    fn cost(&self, x: &Point) -> Result<f64, Error> {
        Ok(self.all(std::slice::from_ref(x))[0])
    }

    fn bulk_cost<P>(&self, points: &[P]) -> Result<Vec<f64>, Error>
    where
        P: std::borrow::Borrow<Point> + SyncAlias,
        f64: SendAlias,
        Self: SyncAlias,
    {
        let points: Vec<Point> = points.iter().map(|p| p.borrow().clone()).collect();
        Ok(self.all(&points))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Function(fn(&[f64]) -> f64);

    impl Objective for Function {
        fn sample(&self, u: &[f64]) -> Sample {
            Sample { values: u.to_vec(), cost: (self.0)(u), terms: Vec::new(), survived: 0 }
        }
        fn values(&self, u: &[f64]) -> Vec<f64> {
            u.to_vec()
        }
    }

    /// Optimum 0 at 0.3, 0.35, 0.4, …
    fn sphere(u: &[f64]) -> f64 {
        u.iter().enumerate().map(|(i, x)| (x - 0.3 - 0.05 * i as f64).powi(2)).sum()
    }

    /// Rosenbrock's valley over [−2, 2]ⁿ: optimum 0 at 1, that is 0.75 of the range; from n = 4 on it has a second minimum.
    fn rosenbrock(u: &[f64]) -> f64 {
        let x: Vec<f64> = u.iter().map(|u| 4.0 * u - 2.0).collect();
        x.windows(2).map(|p| 100.0 * (p[1] - p[0] * p[0]).powi(2) + (1.0 - p[0]).powi(2)).sum()
    }

    fn how(solver: SolverKind, seed: u64, evaluations: usize) -> Search {
        Search { solver, seed, evaluations, start: None, step: 0.2 }
    }

    fn best(samples: &[Sample]) -> &Sample {
        samples.iter().min_by(|a, b| a.cost.total_cmp(&b.cost)).unwrap()
    }

    fn found(function: fn(&[f64]) -> f64, n: usize, how: &Search) -> Vec<Sample> {
        search(&Function(function), n, how, Vec::new(), &mut |_| Ok(())).unwrap()
    }

    /// Known optima, from several seeds; what the tolerance of the search leaves is seen.
    #[test]
    fn known_optima_are_found() {
        for seed in [1, 2, 3] {
            for (solver, function, n, most) in [
                (SolverKind::CmaEs, sphere as fn(&[f64]) -> f64, 8, 1e-6),
                (SolverKind::CmaEs, rosenbrock, 3, 1e-6),
                (SolverKind::NelderMead, sphere, 4, 1e-5),
                (SolverKind::NelderMead, rosenbrock, 2, 1e-3),
            ] {
                let samples = found(function, n, &how(solver, seed, 6000));
                let best = best(&samples);
                assert!(best.cost < most, "{solver:?} {seed} {n}: {best:?} of {}", samples.len());
            }
        }
    }

    /// An ellipsoid stretched 1 : 1000 and turned: only a solver that learns the covariance walks along it.
    #[test]
    fn cma_es_learns_the_covariance() {
        fn ellipsoid(u: &[f64]) -> f64 {
            let (a, b) = (u[0] + u[1] - 1.0, u[0] - u[1] - 0.2);
            1e6 * a * a + b * b
        }
        let samples = found(ellipsoid, 2, &how(SolverKind::CmaEs, 4, 1500));
        assert!(best(&samples).cost < 1e-3, "{:?} of {}", best(&samples), samples.len());
    }

    /// Cut anywhere, also inside a generation, a search goes on as if it had not been.
    #[test]
    fn a_resumed_search_is_the_same() {
        for solver in [SolverKind::CmaEs, SolverKind::NelderMead] {
            let how = how(solver, 7, 90);
            let mut states = Vec::new();
            let mut keep = |s: &[Sample]| {
                states.push(s.len());
                Ok(())
            };
            let whole = search(&Function(sphere), 3, &how, Vec::new(), &mut keep).unwrap();
            assert!(states.len() > 5 && states.is_sorted(), "{states:?}");
            for cut in [0, 1, 8, 37, whole.len()] {
                let known = whole[..cut].to_vec();
                let mut states = Vec::new();
                let mut keep = |s: &[Sample]| {
                    states.push(s.len());
                    Ok(())
                };
                let resumed = search(&Function(sphere), 3, &how, known, &mut keep).unwrap();
                assert_eq!(resumed, whole, "{solver:?} {cut}");
                // every table written holds at least the samples of the one before
                assert!(states.iter().all(|n| *n >= cut), "{states:?} {cut}");
            }
            // a larger budget only adds
            let more = found(sphere, 3, &Search { evaluations: 130, ..how.clone() });
            assert_eq!(more[..whole.len()], whole, "{solver:?}");
        }
    }

    #[test]
    fn threads_do_not_matter_and_seeds_do() {
        let on = |threads: usize, seed: u64| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| found(rosenbrock, 5, &how(SolverKind::CmaEs, seed, 60)))
        };
        assert_eq!(on(1, 1), on(2, 1));
        assert_ne!(on(1, 1), on(1, 2));
    }

    /// An error while keeping ends the search.
    #[test]
    fn what_cannot_be_kept_ends_it() {
        let mut full = |_: &[Sample]| Err("the disk is full".to_owned());
        let ended = search(&Function(sphere), 3, &how(SolverKind::CmaEs, 1, 60), Vec::new(), &mut full);
        assert_eq!(ended.unwrap_err(), "the disk is full");
    }
}
