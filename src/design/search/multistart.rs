//! Multistart search by sequential quadratic programming: many initial values, promising ones refined, best so far at any time.
//!
//! Starts come in rounds. Those of the first are random; those of later ones change the best motion of the rounds
//! before: all of it a little, the motion of one to three joints altogether, or when a joint does what it does,
//! because optima near a good one are better than those of random motions. Where that leads no farther, a round is
//! random again. All starts of a round are improved for a few steps, in parallel; the best are carried to the end.
//! What a round does depends on the seed and on earlier rounds only, so the number of threads changes nothing.

use std::time::{Duration, Instant};

use nalgebra::DVector;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::design::problem::{Excitation, Experiment};
use crate::design::search::starts::Starts;
use crate::problem::Problem;
use crate::problem::linear_rows::LinearRows;
use crate::problem::solution::{Control, Stop};
use crate::problem::view::Nlp;
use crate::robot::random::generator;
use crate::solve::error::SolveError;
use crate::solve::sqp::{self, Constrained, Settings as SqpSettings};

/// Starts of a round, and how many of them are carried to the end.
const ROUND: usize = 6;
const CARRIED: usize = 2;

/// Steps before the starts of a round are compared.
const SCREENING: usize = 50;

/// Steps of one exponent of the criterion, at most.
const REFINING: usize = 250;

/// Share of what is minimised that ten steps have to gain, of starts that are compared and of those carried to the end.
const COMPARED: f64 = 1e-5;
const CARRIED_ON: f64 = 1e-6;

/// How the starts of later rounds come about, in turn.
const CHANGES: [Change; ROUND] = [
    Change::Redrawn(2),
    Change::Disturbed(0.3),
    Change::Redrawn(1),
    Change::Redrawn(2),
    Change::Shifted,
    Change::Redrawn(3),
];

/// Rounds without progress after which a search begins again with random motions, and progress as a share of what
/// is minimised.
const PATIENCE: usize = 4;
const PROGRESS: f64 = 1e-4;

/// Σ of violated shares up to which a motion counts as feasible; the dense check decides in the end.
const FEASIBLE: f64 = 1e-5;

/// When a search ends, and what it starts from.
#[derive(Debug, Clone, Default)]
pub struct Settings {
    /// Number of starts.
    pub starts: Option<usize>,
    /// Wall time.
    pub budget: Option<Duration>,
    /// Of the random starts: the same seed, the same starts.
    pub seed: u64,
    /// Coefficients to start from before random ones.
    pub given: Vec<DVector<f64>>,
}

/// Starts of a search for which nothing is stated.
pub const DEFAULT_STARTS: usize = 12;

/// An improvement of the best value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Improvement {
    /// s since the search began.
    pub elapsed: f64,
    /// Starts made by then.
    pub starts: usize,
    /// The criterion's reported value.
    pub value: f64,
}

/// The end of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchResult {
    /// Fourier coefficients of all trajectories, in the order of [`crate::design::trajectory::motion::Joints`].
    pub x: DVector<f64>,
    /// The criterion's reported value.
    pub value: f64,
    /// Σ of violated shares at the samples; zero where the motion is feasible.
    pub infeasibility: f64,
    /// Why the search ended.
    pub stop: Stop,
    /// Starts made.
    pub starts: usize,
    /// Of all starts together.
    pub iterations: usize,
    /// Of all starts together, values and gradients alike.
    pub evaluations: usize,
    /// Every improvement, in the order of time.
    pub history: Vec<Improvement>,
    /// Other motions that keep every limit at the samples, the best first.
    pub runners_up: Vec<DVector<f64>>,
}

impl SearchResult {
    /// Whether it keeps every limit at the samples.
    pub fn is_feasible(&self) -> bool {
        self.infeasibility <= FEASIBLE
    }
}

/// A search over one experiment.
pub struct Search<'a> {
    /// What is designed.
    pub experiment: &'a Experiment<'a>,
    /// Limits that are linear in the coefficients.
    pub rows: &'a LinearRows,
    /// When it ends, and what it starts from.
    pub settings: &'a Settings,
    /// Share of the limits of torque and workspace that is used.
    pub shrink: f64,
}

/// What makes a start of the best motion so far.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Change {
    /// Every coefficient by this share of a change that matters.
    Disturbed(f64),
    /// The whole motion of this many joints.
    Redrawn(usize),
    /// When a joint does what it does.
    Shifted,
}

/// A motion with what it is worth.
#[derive(Debug, Clone)]
struct Candidate {
    x: DVector<f64>,
    cost: f64,
    infeasibility: f64,
    /// Why its last local search ended.
    stop: Stop,
    iterations: usize,
    evaluations: usize,
}

impl Candidate {
    fn is_feasible(&self) -> bool {
        self.infeasibility <= FEASIBLE
    }

    fn rank(&self) -> Rank {
        match self.is_feasible() {
            true => Rank::Feasible(self.cost),
            false => Rank::Infeasible(self.infeasibility),
        }
    }
}

/// A motion with the criterion's reported value.
struct ValuedMotion {
    x: DVector<f64>,
    value: f64,
}

/// Feasible before infeasible, then by what is minimised.
#[derive(Debug, Clone, Copy)]
enum Rank {
    /// What is minimised.
    Feasible(f64),
    /// Σ of violated shares.
    Infeasible(f64),
}

impl Rank {
    fn order(&self, other: &Self) -> std::cmp::Ordering {
        match (self, other) {
            (Self::Feasible(a), Self::Feasible(b)) | (Self::Infeasible(a), Self::Infeasible(b)) => {
                a.total_cmp(b)
            }
            (Self::Feasible(_), Self::Infeasible(_)) => std::cmp::Ordering::Less,
            (Self::Infeasible(_), Self::Feasible(_)) => std::cmp::Ordering::Greater,
        }
    }

    /// Whether it is better by what counts as progress.
    fn progresses_from(&self, before: &Self) -> bool {
        match (before, self) {
            (Self::Infeasible(_), Self::Feasible(_)) => true,
            (Self::Feasible(_), Self::Infeasible(_)) => false,
            (Self::Feasible(before), Self::Feasible(after))
            | (Self::Infeasible(before), Self::Infeasible(after)) => {
                *after < before - PROGRESS * (1.0 + before.abs())
            }
        }
    }
}

/// Since when a search runs, and what its caller may do to it.
#[derive(Clone, Copy)]
struct Clock<'a> {
    control: &'a Control<'a>,
    began: Instant,
}

/// When a local search ends.
struct LocalSearch {
    /// Steps at most.
    steps: usize,
    /// Share of what is minimised that ten steps have to gain.
    progress: f64,
}

/// Iterated local search: rounds that change the best motion of those before.
#[derive(Debug, Default)]
struct IteratedSearch {
    best: Option<Candidate>,
    /// Rounds since it improved by what matters.
    idle: usize,
}

impl IteratedSearch {
    /// What the next round changes; nothing where the search has come to its end.
    fn best(&self) -> Option<&DVector<f64>> {
        self.best.as_ref().map(|b| &b.x)
    }

    /// Takes what a round found, and ends after [`PATIENCE`] rounds without progress.
    fn learn(&mut self, carried: &[Candidate]) {
        let first = carried.iter().min_by(|a, b| a.rank().order(&b.rank()));
        let Some(first) = first else { return };
        let before = self.best.as_ref().map(Candidate::rank);
        let progress = before.is_none_or(|before| first.rank().progresses_from(&before));
        if before.is_none_or(|before| first.rank().order(&before).is_lt()) {
            self.best = Some(first.clone());
        }
        self.idle = if progress { 0 } else { self.idle + 1 };
        if self.idle >= PATIENCE {
            *self = Self::default();
        }
    }
}

impl Search<'_> {
    /// Runs until the starts or the budget are used up, or the caller stops it; `on_improvement` hears of every
    /// improvement.
    pub fn run(
        &self,
        control: &Control,
        on_improvement: impl Fn(&Improvement) + Sync,
    ) -> Result<SearchResult, SolveError> {
        let clock = Clock {
            control,
            began: Instant::now(),
        };
        let budget = self.settings.budget;
        let starts = match (self.settings.starts, budget) {
            (Some(starts), _) => starts,
            (None, Some(_)) => usize::MAX,
            (None, None) => DEFAULT_STARTS,
        };
        let mut found: Option<SearchResult> = None;
        let mut feasible: Vec<ValuedMotion> = Vec::new();
        let mut iterated = IteratedSearch::default();
        let (mut made, mut iterations, mut evaluations) = (0, 0, 0);
        let stop = loop {
            if control.is_interrupted() {
                break Stop::Interrupted;
            }
            if made >= starts {
                break Stop::IterationLimit;
            }
            if budget.is_some_and(|b| clock.began.elapsed() >= b) && found.is_some() {
                break Stop::TimeLimit;
            }
            let round = made..(made + ROUND).min(starts);
            made = round.end;
            let carried = self.round(round, iterated.best(), clock)?;
            iterated.learn(&carried);
            for candidate in carried {
                iterations += candidate.iterations;
                evaluations += candidate.evaluations;
                let improvement = Improvement {
                    elapsed: clock.began.elapsed().as_secs_f64(),
                    starts: made,
                    value: self.value(&candidate.x),
                };
                if candidate.is_feasible() {
                    feasible.push(ValuedMotion {
                        x: candidate.x.clone(),
                        value: improvement.value,
                    });
                }
                if improves(found.as_ref(), &candidate, improvement.value) {
                    if candidate.is_feasible() {
                        on_improvement(&improvement);
                    }
                    found = Some(self.adopt(found, &candidate, improvement));
                }
            }
        };
        let mut found = found.unwrap_or_else(|| self.nothing());
        (found.stop, found.starts) = (self.verdict(stop, &found), made);
        (found.iterations, found.evaluations) = (iterations, evaluations);
        feasible.sort_by(|a, b| a.value.total_cmp(&b.value));
        found.runners_up = feasible
            .into_iter()
            .skip(1)
            .map(|motion| motion.x)
            .collect();
        Ok(found)
    }

    /// All planned starts made is the end of a search, not a failure of it: then the local search that came to the best motion
    /// says whether that is a solution.
    fn verdict(&self, stop: Stop, found: &SearchResult) -> Stop {
        match stop {
            Stop::Interrupted => Stop::Interrupted,
            _ if !found.is_feasible() => Stop::Infeasible,
            Stop::IterationLimit => found.stop,
            other => other,
        }
    }

    /// Standstill, where the search was stopped before the first round.
    fn nothing(&self) -> SearchResult {
        let problem = Excitation::new(self.experiment, 1.0, self.shrink);
        let x = self.starts(&problem).middle();
        SearchResult {
            value: f64::INFINITY,
            infeasibility: f64::INFINITY,
            x,
            stop: Stop::Interrupted,
            starts: 0,
            iterations: 0,
            evaluations: 0,
            history: Vec::new(),
            runners_up: Vec::new(),
        }
    }

    fn adopt(
        &self,
        before: Option<SearchResult>,
        candidate: &Candidate,
        by: Improvement,
    ) -> SearchResult {
        let mut history = before.map_or_else(Vec::new, |f| f.history);
        if candidate.is_feasible() {
            history.push(by);
        }
        SearchResult {
            x: candidate.x.clone(),
            value: by.value,
            infeasibility: candidate.infeasibility,
            stop: candidate.stop,
            starts: by.starts,
            iterations: 0,
            evaluations: 0,
            history,
            runners_up: Vec::new(),
        }
    }

    /// The criterion's reported value.
    pub fn value(&self, x: &DVector<f64>) -> f64 {
        self.experiment.value(x)
    }

    fn starts<'b>(&'b self, problem: &'b Excitation<'b>) -> Starts<'b> {
        Starts::of(self.experiment, problem, self.rows)
    }

    /// The candidates that a round carries to the end.
    fn round(
        &self,
        round: std::ops::Range<usize>,
        best: Option<&DVector<f64>>,
        clock: Clock<'_>,
    ) -> Result<Vec<Candidate>, SolveError> {
        let mut screened: Vec<Candidate> = round
            .into_par_iter()
            .map(|number| self.screen(number, best, clock))
            .collect::<Result<_, _>>()?;
        screened.sort_by(|a, b| a.rank().order(&b.rank()));
        let rest: (usize, usize) = screened
            .iter()
            .skip(CARRIED)
            .fold((0, 0), |s, c| (s.0 + c.iterations, s.1 + c.evaluations));
        screened.truncate(CARRIED);
        let mut carried: Vec<Candidate> = screened
            .into_par_iter()
            .map(|candidate| self.refine(candidate, clock))
            .collect::<Result<_, _>>()?;
        if let Some(first) = carried.first_mut() {
            first.iterations += rest.0;
            first.evaluations += rest.1;
        }
        Ok(carried)
    }

    /// The generator of one start.
    fn generator(&self, number: usize) -> ChaCha8Rng {
        let mut rng = generator(self.settings.seed);
        rng.set_stream(number as u64 + 1);
        rng
    }

    /// One start, a few steps on.
    fn screen(
        &self,
        number: usize,
        best: Option<&DVector<f64>>,
        clock: Clock<'_>,
    ) -> Result<Candidate, SolveError> {
        let exponent = self.experiment.exponents()[0];
        let problem = Excitation::new(self.experiment, exponent, self.shrink);
        let starts = self.starts(&problem);
        let mut rng = self.generator(number);
        let x = match (self.settings.given.get(number), best) {
            (Some(given), _) => starts.given(given, &mut rng),
            (None, Some(best)) => match CHANGES[number % ROUND] {
                Change::Disturbed(size) => starts.disturbed(best, size, &mut rng),
                Change::Redrawn(joints) => starts.redrawn(best, joints, &mut rng),
                Change::Shifted => starts.shifted(best, &mut rng),
            },
            (None, None) => starts.random(&mut rng),
        };
        let until = LocalSearch {
            steps: SCREENING,
            progress: COMPARED,
        };
        self.improve(&problem, &x, until, clock)
    }

    /// A candidate carried through all exponents of the criterion.
    fn refine(&self, candidate: Candidate, clock: Clock<'_>) -> Result<Candidate, SolveError> {
        let mut current = candidate;
        for &exponent in self.experiment.exponents() {
            let problem = Excitation::new(self.experiment, exponent, self.shrink);
            let until = LocalSearch {
                steps: REFINING,
                progress: CARRIED_ON,
            };
            let next = self.improve(&problem, &current.x, until, clock)?;
            // A search that is cut off may end outside limits that it began within.
            let is_lost = current.is_feasible() && !next.is_feasible();
            current = Candidate {
                iterations: current.iterations + next.iterations,
                evaluations: current.evaluations + next.evaluations,
                ..if is_lost { current } else { next }
            };
        }
        Ok(current)
    }

    /// Continues from coefficients of an earlier search; a short one, as after a change of the limits.
    pub fn continued(
        &self,
        x: &DVector<f64>,
        control: &Control,
        limit: Option<Duration>,
    ) -> Result<SearchResult, SolveError> {
        let exponents = self.experiment.exponents();
        let exponent = exponents[exponents.len() - 1];
        let problem = Excitation::new(self.experiment, exponent, self.shrink);
        let start = self.starts(&problem).given(x, &mut self.generator(0));
        let settings = Settings {
            budget: limit,
            ..Settings::default()
        };
        let limited = Search {
            settings: &settings,
            ..*self
        };
        let until = LocalSearch {
            steps: REFINING,
            progress: COMPARED,
        };
        let clock = Clock {
            control,
            began: Instant::now(),
        };
        let end = limited.improve(&problem, &start, until, clock)?;
        Ok(SearchResult {
            value: self.value(&end.x),
            infeasibility: end.infeasibility,
            x: end.x,
            stop: end.stop,
            starts: 0,
            iterations: end.iterations,
            evaluations: end.evaluations,
            history: Vec::new(),
            runners_up: Vec::new(),
        })
    }

    fn improve(
        &self,
        problem: &Excitation<'_>,
        x: &DVector<f64>,
        until: LocalSearch,
        clock: Clock<'_>,
    ) -> Result<Candidate, SolveError> {
        let view = Nlp::try_from(problem as &dyn Problem)?.within(self.rows);
        let settings = SqpSettings {
            max_iterations: until.steps,
            cost_tolerance: 1e-7,
            progress_tolerance: until.progress,
            ..SqpSettings::default()
        };
        let limit = self.settings.budget;
        let own = Control {
            interrupt: clock.control.interrupt.clone(),
            time_limit: limit.map(|b| b.saturating_sub(clock.began.elapsed())),
            ..Control::default()
        };
        let Constrained {
            solution,
            infeasibility,
        } = sqp::minimize(view, x, &settings, &own)?;
        Ok(Candidate {
            cost: solution.cost,
            x: solution.x,
            stop: ended(solution.stop),
            infeasibility,
            iterations: solution.iterations,
            evaluations: solution.evaluations,
        })
    }
}

/// How a local search ended: one whose last steps gained next to nothing is at its end, one that was cut off is not.
fn ended(stop: Stop) -> Stop {
    match stop {
        Stop::IterationLimit | Stop::TimeLimit | Stop::Interrupted => stop,
        _ => Stop::CostTolerance,
    }
}

/// Whether a candidate takes the place of the best so far.
fn improves(best: Option<&SearchResult>, candidate: &Candidate, value: f64) -> bool {
    let Some(best) = best else {
        return true;
    };
    match (best.is_feasible(), candidate.is_feasible()) {
        (false, true) => true,
        (true, false) => false,
        (false, false) => candidate.infeasibility < best.infeasibility,
        (true, true) => value < best.value,
    }
}
