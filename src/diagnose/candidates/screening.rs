//! Screening: which of the hypotheses that a model leaves open promise most, and from where their fits begin.

use crate::diagnose::candidates::grid_search::{best_first, halved};
use crate::diagnose::candidates::score_test::{Enlarged, ScoreTests};
use crate::diagnose::candidates::screening_reuse::Reusable;
use crate::diagnose::candidates::shape_search::ShapeSearch;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::fit::candidate::{Candidate, Naming, Point, Screening};
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::fit::start_grid::Grid;
use crate::diagnose::residuals::effect_size::Room;
use crate::estimate::noise::counting_rows;
use crate::estimate::search_range::MotionRange;
use crate::linalg::lanes::inner_product::dot;
use crate::recording::split::Split;
use rayon::prelude::*;

/// A value that makes the squared residual so many times larger is far too large.
const HOPELESS: f64 = 10.0;

/// Rows that tell which hypotheses are worth a closer look: what takes 1 % of the squares of so many rows, the least that
/// matters, gains 25 where noise gives each parameter 1 (Wilks 1938).
const ENOUGH: usize = 2500;

/// Hypotheses that get a closer look, several times as many as are fitted.
const CLOSER: usize = 40;

impl ScoreTests<'_> {
    /// The best point of a hypothesis; `None` where it cannot be in the model or takes nothing.
    pub fn examine(&self, context: &Context<'_>, hypothesis: &Hypothesis) -> Option<Candidate> {
        let enlarged = self.enlarged(context, hypothesis)?;
        let Enlarged { model, own, .. } = &enlarged;
        let bases = self.bases(model, hypothesis);
        let motion = MotionRange::of(&context.recordings(Split::Train), hypothesis.joints[0]);
        let grid = Grid::new(model, own, hypothesis.effect, &motion);
        let gain = |at: Vec<f64>| {
            let from = |base: usize| {
                let values = bases[base].with(own, &at);
                let here = self.linearised(&enlarged, &values);
                let sizes = |k: usize| enlarged.is_linear(k);
                Point {
                    gain: enlarged.step(&values, &here, &|_| true).gain,
                    of_sizes: enlarged.step(&values, &here, &sizes).gain,
                    base,
                    at: at.clone(),
                }
            };
            let all = (0..bases.len()).map(from);
            let best = all.max_by(|a, b| a.gain.total_cmp(&b.gain));
            best.unwrap_or_else(|| Point::hopeless(at.clone()))
        };
        let squares = self.linear().residual.iter().map(|r| dot(r, r));
        let hopeless = -HOPELESS * squares.sum::<f64>();
        let rising = grid.is_rising().then_some(hopeless);
        let best_first = |points: Vec<Vec<f64>>| best_first(points, rising, &gain);
        let scanned = best_first(grid.scan());
        let scanned = scanned.first();
        let mut points = best_first(grid.all(scanned.map(|point| point.at.as_slice())));
        if grid.is_rising() {
            points = halved(points, &best_first);
        }
        if grid.main_shape().is_some() {
            let search = ShapeSearch {
                tests: self,
                enlarged: &enlarged,
                bases: &bases,
            };
            points = search.ends(&points);
        }
        let naming = Naming {
            own: own
                .iter()
                .map(|&p| model.parameters()[p].name.clone())
                .collect(),
            bases: bases.iter().map(|base| &base.changed).collect(),
            grid: &grid,
        };
        let mut candidate = naming.candidate(hypothesis, &points)?;
        candidate.gain = scanned.map_or(0.0, |point| point.gain).max(candidate.gain);
        Some(candidate)
    }

    /// The same candidate with what it gains at its start over these rows.
    fn confirmed(&self, context: &Context<'_>, candidate: Candidate) -> Option<Candidate> {
        let enlarged = self.enlarged(context, &candidate.hypothesis)?;
        let mut values = self.fit.values_of(&enlarged.model);
        for (name, value) in &candidate.start {
            values[enlarged.model.position(name)?] = *value;
        }
        let here = self.linearised(&enlarged, &values);
        let gain = enlarged.step(&values, &here, &|_| true).gain;
        Some(Candidate { gain, ..candidate })
    }
}

/// What hypotheses promise beside a model: by a glance at some rows, and a look of those in front at all. Those of joints of which the
/// model leaves too little for an effect that matters are not looked at.
pub fn screen(
    context: &Context<'_>,
    fit: &ModelFit,
    mut open: Vec<Hypothesis>,
) -> Result<Screening, DiagnoseError> {
    let room = Room::beside(context, fit);
    open.retain(|hypothesis| room.has_some_for(hypothesis));
    let by_gain =
        |candidates: &mut Vec<Candidate>| candidates.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let is_going_on = || !context.control.is_interrupted();
    let train = context.recordings(Split::Train);
    let every = (counting_rows(&train) / ENOUGH).max(1);
    let rough = ScoreTests::of_every(every, context, fit);
    let earlier = Reusable::of(context, fit);
    let examined = open.par_iter().filter(|_| is_going_on());
    let examined = examined.filter_map(|hypothesis| match earlier.screening(hypothesis) {
        Some(screening) => rough.confirmed(context, screening.glance_at(hypothesis)?.clone()),
        None => rough.examine(context, hypothesis),
    });
    let mut glance: Vec<Candidate> = examined.filter(|candidate| candidate.gain > 0.0).collect();
    by_gain(&mut glance);
    let mut candidates = glance.clone();
    if every > 1 {
        let look = ScoreTests::new(context, fit);
        candidates.truncate(CLOSER);
        let closer = candidates.into_par_iter().filter(|_| is_going_on());
        candidates = closer
            .filter_map(|candidate| look.confirmed(context, candidate))
            .collect();
        by_gain(&mut candidates);
    }
    Ok(Screening {
        open,
        glance,
        candidates,
    })
}
