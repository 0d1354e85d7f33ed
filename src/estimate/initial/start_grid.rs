//! Local searches for the nonlinear parameters of friction laws from the points of a grid, each joint by itself.
//!
//! ```text
//! min over γ and δ of ½ ‖ r(γ) + N δ ‖²
//! ```
//!
//! with the residual r of the joint's own channel, the shapes γ of the laws at its motor, and the derivatives N with
//! respect to all other unknowns, which the search takes as they are at its reference. Laws at motors act on their own
//! channel alone, so all joints are searched at a time, each with its own damping; N is projected out once (variable
//! projection, Golub and Pereyra 1973, in the form of Kaufman 1975), so that a step of all joints costs one evaluation
//! of the model.

use crate::chain::dataset::Prepared;
use crate::chain::effect::{self, Linearity};
use crate::chain::evaluate::KnownBodies;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::estimate::residual::compress::stacked;
use crate::estimate::residual::rows::{RowBlock, Task, tasks, visit_errors, whole_motion};
use crate::linalg::triangular::Triangular;
use crate::solve::bounded::{self, Bounds};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Values of some parameters, by their positions in the model.
pub(super) type Point = Vec<(usize, f64)>;

/// Where the search on a joint ends.
#[derive(Debug, Clone)]
pub(super) struct LocalOptimum {
    /// Sum of the squared residuals.
    pub squares: f64,
    pub point: Point,
}

/// Rows of a joint that are looked at, about: a hundred for each of forty unknowns.
const ROWS: usize = 4000;

/// Part of a column's length below which what other columns leave of it is rounding.
const DEPENDENT: f64 = 1e-9;

/// Damping of the first step; its factors after a step that is taken and after one that is not.
const DAMPING: f64 = 1e-3;
const LARGER_STEP: f64 = 0.2;
const SMALLER_STEP: f64 = 5.0;

/// What a search takes to be known of the other unknowns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OtherUnknowns {
    /// Nothing: whatever is wrong with the laws of other joints, the joint's own channel decides.
    Free,
    /// What all other channels and the prior say, by their errors at the reference, with laws as they are there.
    AsElsewhere,
}

/// What is asked of the shapes of a joint's laws.
struct JointShapes {
    channel: usize,
    weight: f64,
    /// Positions in the model.
    shapes: Vec<usize>,
    /// Residuals that the shapes do not change, below those of the channel.
    elsewhere: DVector<f64>,
    /// Orthonormal columns that span what the other unknowns can do.
    others: DMatrix<f64>,
}

/// A search on one joint.
struct Search {
    /// Where it is, and the triangular factor of the derivatives and the residual there.
    at: Option<(DVector<f64>, Triangular)>,
    tried: DVector<f64>,
    damping: f64,
    /// The largest norms of the derivatives so far.
    norms: DVector<f64>,
}

/// Derivatives with respect to all unknowns and the residual of a channel, with their weight.
struct ChannelSystem {
    channel: usize,
    weight: f64,
    system: DMatrix<f64>,
}

/// A channel and columns among those that are computed.
struct Pick {
    channel: usize,
    columns: Vec<usize>,
}

/// The searches of a fit's joints.
pub(super) struct JointSearches<'a> {
    problem: &'a FitProblem<'a>,
    reference: DVector<f64>,
    /// One for every joint; `None` without shapes or without a channel of its own.
    joints: Vec<Option<JointShapes>>,
    /// Every how many rows one is looked at.
    every: usize,
    /// What the bodies do at the reference, of every recording.
    bodies: Vec<Option<KnownBodies>>,
}

impl<'a> JointSearches<'a> {
    /// Searches about the unknowns x, with the positions of the shapes of every joint.
    pub fn new(
        problem: &'a FitProblem<'a>,
        x: &DVector<f64>,
        shapes: &[Vec<usize>],
        others: OtherUnknowns,
    ) -> Self {
        let rows: usize = problem.recordings.iter().map(|r| r.rows()).sum();
        let mut all = Self {
            problem,
            reference: problem.parameters(x),
            joints: Vec::new(),
            every: (rows / ROWS).max(1),
            bodies: vec![None; problem.recordings.len()],
        };
        let channels = all.channels(others);
        let known = |recording: &&Prepared| {
            let whole_motion = whole_motion(problem.model, recording);
            KnownBodies::linear(problem.model, &all.reference, &[], whole_motion)
        };
        all.bodies = problem.recordings.iter().map(known).collect();
        let joints = shapes.iter().enumerate();
        all.joints = joints
            .map(|(joint, shapes)| all.own(&channels, joint, shapes, others))
            .collect();
        all
    }

    /// Derivatives with respect to all unknowns and the residual of every active channel, in deviations of its residual
    /// where channels are compared.
    fn channels(&self, others: OtherUnknowns) -> Vec<ChannelSystem> {
        let unknowns = self.problem.unknowns.positions();
        let channels = self.problem.model.channels().iter().enumerate();
        let picks: Vec<Option<Pick>> = channels
            .filter(|(_, c)| c.active)
            .map(|(channel, _)| {
                let columns = (0..unknowns.len()).collect();
                Some(Pick { channel, columns })
            })
            .collect();
        let systems = self.systems(&self.reference, &unknowns, &picks);
        let weighted = |(pick, system): (Option<Pick>, Option<DMatrix<f64>>)| {
            let system = system?;
            let rows = system.nrows().max(1) as f64;
            let deviation = system.column(unknowns.len()).norm() / rows.sqrt();
            let weight = match others {
                OtherUnknowns::AsElsewhere if deviation > 0.0 => 1.0 / deviation,
                _ => 1.0,
            };
            Some(ChannelSystem {
                channel: pick?.channel,
                weight,
                system: weight * system,
            })
        };
        let all = picks.into_iter().zip(systems).filter_map(weighted);
        all.collect()
    }

    fn own(
        &self,
        channels: &[ChannelSystem],
        joint: usize,
        shapes: &[usize],
        others: OtherUnknowns,
    ) -> Option<JointShapes> {
        let of = |channel: usize| self.problem.model.channels()[channel].joint;
        let position = channels
            .iter()
            .position(|own| of(own.channel) == Some(joint));
        let own = &channels[position.filter(|_| !shapes.is_empty())?];
        let unknowns = self.problem.unknowns.positions();
        let count = unknowns.len();
        let mut elsewhere = Triangular::new(count + 1);
        if others == OtherUnknowns::AsElsewhere {
            for (k, ChannelSystem { system, .. }) in channels.iter().enumerate() {
                if Some(k) != position {
                    elsewhere.absorb(system.as_slice());
                }
            }
            let prior = self.problem.prior.system(&unknowns, 0, &self.reference);
            elsewhere.absorb(prior.as_slice());
        }
        let elsewhere = elsewhere.matrix();
        let columns: Vec<usize> = (0..count)
            .filter(|&k| !shapes.contains(&unknowns[k]))
            .collect();
        let free = [&own.system, &elsewhere].map(|rows| rows.select_columns(&columns));
        Some(JointShapes {
            channel: own.channel,
            weight: own.weight,
            shapes: shapes.to_vec(),
            elsewhere: elsewhere.column(count).into_owned(),
            others: orthonormal(&stacked(&free, columns.len())),
        })
    }

    /// Where searches end that begin at one point of every joint; what the points
    /// do not name begins at the reference. Infinite where there is nothing to search.
    ///
    /// Where a law acts at a place of the range alone, the first step is one of the linear parameters: with a size of the wrong sign a
    /// search leaves the place.
    pub fn search(&self, from: &[Point], steps: usize) -> Vec<LocalOptimum> {
        let mut searches: Vec<Option<Search>> = (self.joints.iter().zip(from))
            .map(|(own, point)| Some(self.begun(own.as_ref()?, point)))
            .collect();
        for step in 0..=steps {
            let systems = self.projected(&searches);
            let joints = self.joints.iter().zip(&mut searches).zip(systems);
            for ((own, search), system) in joints {
                if let (Some(own), Some(search), Some(system)) = (own, search, system) {
                    search.take(system);
                    let moves = |k: &usize| {
                        step > 0 || !self.has_place(own) || self.is_linear(own.shapes[*k])
                    };
                    let moved = (0..own.shapes.len()).filter(moves).collect::<Vec<usize>>();
                    self.try_next(own, search, &moved);
                }
            }
        }
        let joints = self.joints.iter().zip(searches).zip(from);
        joints
            .map(
                |((own, search), from)| match (own, search.and_then(|s| s.at)) {
                    (Some(own), Some((x, system))) => {
                        let point = own.shapes.iter().copied().zip(x.iter().copied());
                        LocalOptimum {
                            squares: residual_squares(&system),
                            point: point.collect(),
                        }
                    }
                    _ => LocalOptimum {
                        squares: f64::INFINITY,
                        point: from.clone(),
                    },
                },
            )
            .collect()
    }

    /// Sums of the squared residuals that are left at points of one joint by the best that its laws can do there to first
    /// order, in their shapes and their linear parameters.
    pub fn linearised(&self, joint: usize, points: &[Point]) -> Vec<f64> {
        let of = |point: &Point| {
            let own = self.joints[joint].as_ref()?;
            let mut searches: Vec<Option<Search>> = self.joints.iter().map(|_| None).collect();
            searches[joint] = Some(self.begun(own, point));
            let system = self.projected(&searches).swap_remove(joint)?;
            let last = system.columns() - 1;
            Some(system.entry(last, last).powi(2))
        };
        let squares = points
            .par_iter()
            .map(|point| of(point).unwrap_or(f64::INFINITY));
        squares.collect()
    }

    fn begun(&self, own: &JointShapes, point: &Point) -> Search {
        let count = own.shapes.len();
        let of = |p: &usize| {
            let named = point.iter().find(|(named, _)| named == p);
            named.map_or(self.reference[*p], |(_, value)| *value)
        };
        Search {
            at: None,
            tried: DVector::from_iterator(count, own.shapes.iter().map(of)),
            damping: DAMPING,
            norms: DVector::zeros(count),
        }
    }

    /// The factor of every joint at what its search tries, without what the other unknowns can do.
    fn projected(&self, searches: &[Option<Search>]) -> Vec<Option<Triangular>> {
        let mut values = self.reference.clone();
        let mut columns = Vec::new();
        let mut picks = Vec::new();
        for (own, search) in self.joints.iter().zip(searches) {
            let pick = own.as_ref().zip(search.as_ref()).map(|(own, search)| {
                let first = columns.len();
                columns.extend(&own.shapes);
                (own.shapes.iter().zip(search.tried.iter())).for_each(|(&p, x)| values[p] = *x);
                Pick {
                    channel: own.channel,
                    columns: (first..columns.len()).collect(),
                }
            });
            picks.push(pick);
        }
        let systems = self.systems(&values, &columns, &picks);
        let joints = self.joints.iter().zip(systems);
        joints
            .map(|(own, system)| {
                let (own, system) = (own.as_ref()?, system?);
                let (rows, last) = (system.nrows(), system.ncols() - 1);
                let further = own.elsewhere.len();
                let mut system = (own.weight * system).resize_vertically(rows + further, 0.0);
                system
                    .view_mut((rows, last), (further, 1))
                    .copy_from(&own.elsewhere);
                let along = own.others.tr_mul(&system);
                Some(Triangular::of(&(system - &own.others * along)))
            })
            .collect()
    }

    /// Derivatives and residual of the picked channels over the rows that are looked at.
    fn systems(
        &self,
        values: &DVector<f64>,
        columns: &[usize],
        picks: &[Option<Pick>],
    ) -> Vec<Option<DMatrix<f64>>> {
        let (model, problem) = (self.problem.model, self.problem);
        let mut series: Vec<Vec<Vec<f64>>> = picks
            .iter()
            .map(|pick| vec![Vec::new(); pick.as_ref().map_or(0, |p| p.columns.len() + 1)])
            .collect();
        for (k, recording) in problem.recordings.iter().enumerate() {
            let bodies = self.bodies[k].as_ref();
            for task in tasks(model, std::iter::once(*recording)) {
                let task = Task { bodies, ..task };
                visit_errors(model, values, columns, &task, |block| {
                    for (pick, series) in picks.iter().zip(&mut series) {
                        let Some(pick) = pick else { continue };
                        let factors = problem.factors.as_ref().map(|f| &f[k][pick.channel]);
                        append(series, pick, block, factors.map(Vec::as_slice), self.every);
                    }
                });
            }
        }
        let matrix = |series: Vec<Vec<f64>>| {
            let rows = series.first()?.len();
            Some(DMatrix::from_vec(rows, series.len(), series.concat()))
        };
        series.into_iter().map(matrix).collect()
    }

    /// What to try next: the damped step of some shapes within the limits.
    fn try_next(&self, own: &JointShapes, search: &mut Search, moved: &[usize]) {
        let Some((x, system)) = &search.at else {
            return;
        };
        let count = x.len();
        let mut matrix = DMatrix::zeros(count + moved.len(), moved.len());
        let mut right = DVector::zeros(count + moved.len());
        for i in 0..count {
            for (to, &j) in moved.iter().enumerate().filter(|(_, j)| **j >= i) {
                matrix[(i, to)] = system.entry(i, j);
            }
            right[i] = -system.entry(i, count);
        }
        for (to, &j) in moved.iter().enumerate() {
            matrix[(count + to, to)] = search.damping.sqrt() * search.norms[j];
        }
        let parameters = self.problem.model.parameters();
        let room = |limit: &dyn Fn(usize) -> f64| {
            let of = moved.iter().map(|&j| limit(own.shapes[j]) - x[j]);
            DVector::from_iterator(moved.len(), of)
        };
        let bounds = Bounds {
            lower: room(&|p| parameters[p].lower).map(|room| room.min(0.0)),
            upper: room(&|p| parameters[p].upper).map(|room| room.max(0.0)),
        };
        let step = bounded::minimize(&matrix, &right, &bounds);
        search.tried.copy_from(x);
        for (&j, step) in moved.iter().zip(step.iter()) {
            search.tried[j] += step;
        }
    }

    /// Whether a law of a joint lies at a place of its range.
    fn has_place(&self, own: &JointShapes) -> bool {
        let mut searches = own.shapes.iter().filter_map(|&p| {
            let parameter = self.problem.model.effect_parameter(p)?;
            Some(parameter.info.search)
        });
        searches.any(|search| matches!(search, effect::Search::Position(_)))
    }

    fn is_linear(&self, parameter: usize) -> bool {
        self.problem.model.parameters()[parameter].linearity == Linearity::Linear
    }
}

impl Search {
    /// Goes where it was tried if the residual is smaller there.
    fn take(&mut self, system: Triangular) {
        let better = match &self.at {
            None => true,
            Some((_, best)) => residual_squares(&system) < residual_squares(best),
        };
        if !better {
            self.damping *= SMALLER_STEP;
            return;
        }
        if self.at.is_some() {
            self.damping *= LARGER_STEP;
        }
        let count = self.tried.len();
        let norms = system.column_norms().rows(0, count).into_owned();
        // A law that does nothing at a point says nothing of its shape there.
        let least = norms.max() * DEPENDENT;
        self.norms = self.norms.sup(&norms).map(|norm| norm.max(least));
        self.at = Some((self.tried.clone(), system));
    }
}

/// Sum of the squared residuals.
fn residual_squares(system: &Triangular) -> f64 {
    let last = system.columns() - 1;
    (0..=last).map(|i| system.entry(i, last).powi(2)).sum()
}

/// Appends every n-th row that counts of a block to the series of a joint, the residual last.
fn append(
    series: &mut [Vec<f64>],
    pick: &Pick,
    block: &RowBlock<'_>,
    factors: Option<&[f64]>,
    every: usize,
) {
    let keep = block.counting();
    let counts = |row: &usize| {
        let whole = block.start() + row;
        whole.is_multiple_of(every) && keep.as_ref().is_none_or(|keep| keep[*row])
    };
    let rows: Vec<usize> = (0..block.range.len()).filter(counts).collect();
    let factor = |row: usize| factors.map_or(1.0, |factors| factors[block.start() + row]);
    let (predicted, recorded) = (block.predicted(pick.channel), block.recorded(pick.channel));
    let (residual, derivatives) = match series.split_last_mut() {
        Some(parts) => parts,
        None => return,
    };
    residual.extend(
        rows.iter()
            .map(|&k| factor(k) * (predicted[k] - recorded[k])),
    );
    for (to, &column) in derivatives.iter_mut().zip(&pick.columns) {
        match block.derivative(pick.channel, column) {
            Some(from) => to.extend(rows.iter().map(|&k| factor(k) * from[k])),
            None => to.resize(residual.len(), 0.0),
        }
    }
}

/// Orthonormal columns with the span of a matrix.
fn orthonormal(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let kept = Triangular::of(matrix).independent_columns(DEPENDENT).kept;
    match kept.is_empty() {
        true => DMatrix::zeros(matrix.nrows(), 0),
        false => matrix.select_columns(&kept).qr().q(),
    }
}
