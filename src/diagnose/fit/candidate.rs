//! A candidate: a hypothesis with the initial values of its fit.

use crate::chain::effect::Memory;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::start::Start;
use crate::diagnose::fit::start_grid::Grid;

/// A hypothesis with the points from which it promises most.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// What may be missing.
    pub hypothesis: Hypothesis,
    /// Weighted sum of squares that one step of all parameters takes away.
    pub gain: f64,
    /// Values of the hypothesis' own parameters.
    pub start: Start,
    /// Further ones, of a law whose shape has several parameters and may have several optima.
    pub others: Vec<Start>,
    /// Of a law with memory, values of what a search for it may lose: scales of speed that have run against a limit
    /// take what belongs to them out of the model.
    pub anew: Vec<Anew>,
}

/// Values from which a search begins again.
#[derive(Debug, Clone)]
pub struct Anew {
    /// All of them.
    pub start: Start,
    /// Those of them that are scales of speed, which stay until what belongs to them is found.
    pub scales: Start,
}

/// What the hypotheses that are open beside one model promise.
#[derive(Debug, Clone, Default)]
pub struct Screening {
    /// Hypotheses that the model does not have and that are not ruled out.
    pub open: Vec<Hypothesis>,
    /// All that promise something, by a glance at some of the rows.
    pub glance: Vec<Candidate>,
    /// The foremost of them by all rows, the most promising first.
    pub candidates: Vec<Candidate>,
}

impl Screening {
    /// What a glance found of a hypothesis, if it promised something.
    pub fn glance_at(&self, hypothesis: &Hypothesis) -> Option<&Candidate> {
        let mut candidates = self.glance.iter();
        candidates.find(|candidate| candidate.hypothesis == *hypothesis)
    }
}

/// Further starts of a law whose shape has several parameters.
const OTHERS: usize = 2;

/// A point of a grid, from one of the values of all other parameters.
#[derive(Debug, Clone)]
pub struct Point {
    /// Weighted sum of squares that one step of all parameters takes away; where a search has ended, what the law takes there.
    pub gain: f64,
    /// The same of a step of the linear parameters, those of the hypothesis at their shapes.
    pub of_sizes: f64,
    /// Number of the other values.
    pub base: usize,
    /// Of the own parameters.
    pub at: Vec<f64>,
}

impl Point {
    /// One that gains nothing.
    pub fn hopeless(at: Vec<f64>) -> Self {
        Self {
            gain: f64::NEG_INFINITY,
            of_sizes: f64::NEG_INFINITY,
            base: 0,
            at,
        }
    }
}

/// How points become starts.
#[derive(Debug)]
pub struct Naming<'a> {
    /// Names of the own parameters.
    pub own: Vec<String>,
    /// What each base has otherwise than the fit.
    pub bases: Vec<&'a Start>,
    /// The grid that the points are of.
    pub grid: &'a Grid,
}

impl Naming<'_> {
    /// The candidate of a hypothesis from its points, the most promising first; `None` without any.
    pub fn candidate(&self, hypothesis: &Hypothesis, best_first: &[Point]) -> Option<Candidate> {
        let best = best_first.first()?;
        let mut apart = vec![best];
        if let Some(main) = self.grid.main_shape() {
            for point in best_first {
                let is_new = apart.iter().all(|known| known.at[main] != point.at[main]);
                if apart.len() <= OTHERS && is_new {
                    apart.push(point);
                }
            }
        }
        let remembers = hypothesis.effect.needs.memory == Memory::WholeMotion;
        let anew = match remembers {
            true => self.anew(),
            false => Vec::new(),
        };
        Some(Candidate {
            hypothesis: hypothesis.clone(),
            gain: best.gain,
            start: self.start(best),
            others: apart[1..].iter().map(|point| self.start(point)).collect(),
            anew,
        })
    }

    fn anew(&self) -> Vec<Anew> {
        let is_scale = |(own, _): &(usize, f64)| self.grid.is_scale(*own);
        let of = |values: Vec<(usize, f64)>| Anew {
            scales: self.named(values.iter().copied().filter(is_scale).collect()),
            start: self.named(values),
        };
        self.grid.anew().into_iter().map(of).collect()
    }

    fn start(&self, point: &Point) -> Start {
        let mut start = self.named(point.at.iter().copied().enumerate().collect());
        start.extend(self.bases[point.base].iter().cloned());
        start
    }

    fn named(&self, values: Vec<(usize, f64)>) -> Start {
        let name = |(k, x): (usize, f64)| (self.own[k].clone(), x);
        values.into_iter().map(name).collect()
    }
}
