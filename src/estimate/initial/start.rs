//! Initial values of a nonlinear fit: the linear unknowns at their optimum, and the nonlinear parameters of every friction law at
//! the best end of local searches from a grid.
//!
//! A friction law has shallow optima besides the deepest one (bristles as stiff as sampling can tell, a scale of speed
//! that no speed reaches, an excess at low speed that stands in for viscous friction), and one search finds the
//! nearest. So the laws of every joint are searched for from every point of their grid: first on the joint's own
//! channel alone, as the laws of the other joints are not known yet, then, from where the whole fit comes to, by what
//! all channels say, until no joint finds a better shape. What the bodies can do on one channel alone hides much of
//! what tells two shapes apart.

use crate::chain::effect::{Law, Linearity, Search};
use crate::chain::effect_parameter::EffectParameter;
use crate::chain::model::Model;
use crate::estimate::error::EstimateError;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::estimate::fit_problem::unknowns::Unknowns;
use crate::estimate::initial::gap_search::{self, Measure};
use crate::estimate::initial::search_range::{Bounded, MotionRange, lent_sizes};
use crate::estimate::initial::start_grid::{JointSearches, LocalOptimum, OtherUnknowns, Point};
use crate::estimate::residual::noise::predict;
use crate::estimate::solve::least_squares::{ITERATIONS_PER_ROUND, solve};
use crate::problem::Problem;
use crate::problem::form::Structure;
use crate::problem::solution::Control;
use nalgebra::DVector;
use rayon::prelude::*;

/// Points of a joint's grid that are tried at most.
const MOST_POINTS: usize = 36;

/// Values of a scanned parameter from which searches begin.
const MOST_SCANNED: usize = 4;

/// Steps of a round of searches, and the ends of each joint that go on: a few steps from every point of the grid show
/// which are worth more.
const ROUNDS: [(usize, usize); 2] = [(2, 4), (STEPS, 1)];
const STEPS: usize = 30;

/// Iterations of the whole fit before the shapes of single joints are searched for anew.
const ITERATIONS_BETWEEN: usize = 40;

/// Most often that happens. Laws that are not those of the robot can have many optima of nearly the same depth.
const REVISIONS: usize = 3;

/// Weighted squares below which two optima differ by less than one standard deviation of one unknown.
const SETTLED: f64 = 1.0;

/// The unknowns from which a search begins.
pub(in crate::estimate) fn find(
    problem: &FitProblem<'_>,
    control: &Control<'_>,
) -> Result<DVector<f64>, EstimateError> {
    if problem.form().structure == Structure::Affine {
        return Ok(problem.start());
    }
    let declared = at(problem, &[gains(problem)], control)?;
    let x = with_laws(problem, declared.clone(), control)?;
    if !gap_search::is_needed(problem) {
        return Ok(x);
    }
    // Either may hide the other: the gaps what friction does, and friction where a link strikes.
    let with_gaps = |measure: Measure| -> Result<[DVector<f64>; 2], EstimateError> {
        let gaps_last = gap_search::refined(problem, x.clone(), measure, control);
        let gaps_first = gap_search::refined(problem, declared.clone(), measure, control);
        Ok([gaps_last, with_laws(problem, gaps_first, control)?])
    };
    let starts = Measure::ALL.into_par_iter().map(with_gaps);
    let starts = starts.collect::<Result<Vec<_>, _>>()?;
    let tried = starts.concat().into_par_iter().map(|x| {
        let found = solve(problem, &x, ITERATIONS_BETWEEN, control)?;
        let unlikelihood = Measure::Likelihood.of(problem, &found);
        Ok((unlikelihood, found.x))
    });
    let tried = tried.collect::<Result<Vec<_>, EstimateError>>()?;
    let best = tried.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    Ok(best.map_or_else(|| problem.start(), |best| best.1))
}

/// The unknowns with the laws of every joint's motor at the best shapes that a search finds beside the others.
fn with_laws(
    problem: &FitProblem<'_>,
    from: DVector<f64>,
    control: &Control<'_>,
) -> Result<DVector<f64>, EstimateError> {
    let joints = 0..problem.model.joints().len();
    let nonlinear = &problem.unknowns.nonlinear;
    let is_searched = |joint: usize| {
        let mut all = nonlinear.iter();
        all.any(|&p| search(problem.model, joint, p).is_some() || is_lent(problem.model, joint, p))
    };
    if !joints.clone().any(is_searched) {
        return Ok(from);
    }
    let laws: Vec<Vec<usize>> = joints
        .clone()
        .map(|joint| of_motor(problem, joint))
        .collect();
    let alone = JointSearches::new(problem, &from, &laws, OtherUnknowns::Free);
    let grids: Vec<Vec<Point>> = joints.map(|joint| grid(problem, &alone, joint)).collect();
    let ends = best_ends(&alone, &grids).into_iter();
    let mut best: Vec<Point> = ends.map(|end| end.point).collect();
    best.push(beside_laws(problem, &from));
    let mut x = at(problem, &best, control)?;
    for _ in 0..REVISIONS {
        x = solve(problem, &x, ITERATIONS_BETWEEN, control)?.x;
        if control.is_interrupted() {
            break;
        }
        let Some(mut better) = revised(problem, &x, &laws, &grids) else {
            break;
        };
        better.push(beside_laws(problem, &x));
        x = at(problem, &better, control)?;
    }
    Ok(x)
}

/// The gain of a joint's controller, by its position in the model.
#[derive(Clone, Copy)]
struct ControllerGain {
    joint: usize,
    gain: usize,
}

/// Gains of controllers that are unknown and that nothing is known of beforehand.
fn unknown_gains(problem: &FitProblem<'_>) -> Vec<ControllerGain> {
    let joints = problem.model.joints().iter().enumerate();
    let gains = joints.filter_map(|(joint, description)| {
        let gain = description.controller?;
        Some(ControllerGain { joint, gain })
    });
    let open = |&ControllerGain { gain, .. }: &ControllerGain| {
        let prior = problem.prior.rows().column(gain);
        problem.unknowns.nonlinear.contains(&gain) && prior.iter().all(|row| *row == 0.0)
    };
    gains.filter(open).collect()
}

/// Unknown gains from which a search is sure to rise to the optimum: the signal goes with 1/kp, on which Newton's step
/// from below doubles kp at most, and from above twice the optimum leads below zero. Half of what makes the signals of a
/// model with usual values as large as those that were recorded.
fn gains(problem: &FitProblem<'_>) -> Point {
    let open = unknown_gains(problem);
    if open.is_empty() {
        return Vec::new();
    }
    let (model, values) = (problem.model, problem.model.generic_values());
    let squares = |series: &[f64]| series.iter().map(|x| x * x).sum::<f64>();
    let mut sums = vec![[0.0; 2]; model.channels().len()];
    for recording in problem.recordings {
        let predicted = predict(model, &values, recording);
        for (c, sums) in sums.iter_mut().enumerate() {
            sums[0] += squares(&predicted[c]);
            sums[1] += squares(recording.signal(c));
        }
    }
    let of = |ControllerGain { joint, gain }: ControllerGain| {
        let [predicted, recorded] = sums[joint];
        let factor = 0.5 * (predicted / recorded).sqrt();
        let usable = factor.is_finite() && factor > 0.0;
        usable.then_some((gain, factor * values[gain]))
    };
    open.into_iter().filter_map(of).collect()
}

/// The nonlinear parameters at x that shape no law of a motor.
fn beside_laws(problem: &FitProblem<'_>, x: &DVector<f64>) -> Point {
    let first = x.len() - problem.unknowns.nonlinear.len();
    let nonlinear = problem.unknowns.nonlinear.iter();
    let values = nonlinear.copied().zip(x.iter().skip(first).copied());
    let others = values.filter(|(p, _)| motor_law(problem.model, *p).is_none());
    others.collect()
}

/// The shapes at x, of every joint with the best end of searches from its grid where that leaves less of what all
/// channels say than the one from x; `None` where none does.
fn revised(
    problem: &FitProblem<'_>,
    x: &DVector<f64>,
    laws: &[Vec<usize>],
    grids: &[Vec<Point>],
) -> Option<Vec<Point>> {
    let unknowns = problem.unknowns.positions();
    let value = |p: &usize| Some((*p, x[unknowns.iter().position(|u| u == p)?]));
    let point = |law: &Vec<usize>| law.iter().filter_map(value).collect();
    let here: Vec<Point> = laws.iter().map(point).collect();
    let whole = JointSearches::new(problem, x, laws, OtherUnknowns::AsElsewhere);
    let mut points = whole.search(&here, STEPS);
    let mut any = false;
    for (point, end) in points.iter_mut().zip(best_ends(&whole, grids)) {
        if end.squares < point.squares - SETTLED {
            *point = end;
            any = true;
        }
    }
    any.then(|| points.into_iter().map(|end| end.point).collect())
}

/// The best end of every joint of searches from all points of its grid.
fn best_ends(shapes: &JointSearches<'_>, grids: &[Vec<Point>]) -> Vec<LocalOptimum> {
    let mut points = grids.to_vec();
    let mut best = Vec::new();
    for (steps, kept) in ROUNDS {
        let count = points.iter().map(Vec::len).max().unwrap_or(0);
        let of = |k: usize| {
            let from = points.iter().map(|own| own[k.min(own.len() - 1)].clone());
            shapes.search(&from.collect::<Vec<Point>>(), steps)
        };
        let ends: Vec<Vec<LocalOptimum>> = (0..count).into_par_iter().map(of).collect();
        best.clear();
        for (joint, points) in points.iter_mut().enumerate() {
            let own = ends
                .iter()
                .take(points.len())
                .map(|ends| ends[joint].clone());
            let mut own: Vec<LocalOptimum> = own.collect();
            own.sort_by(|a, b| a.squares.total_cmp(&b.squares));
            own.truncate(kept);
            best.push(own[0].clone());
            *points = own.into_iter().map(|end| end.point).collect();
        }
    }
    best
}

/// Unknowns of the laws at a joint's motor.
fn of_motor(problem: &FitProblem<'_>, joint: usize) -> Vec<usize> {
    let own = |p: &usize| motor_law(problem.model, *p).is_some_and(|law| law.joint == joint);
    let unknowns = problem.unknowns.positions().into_iter();
    unknowns.filter(own).collect()
}

/// The optimum over the linear unknowns with the others at a point, or where they start.
fn at(
    problem: &FitProblem<'_>,
    point: &[Point],
    control: &Control<'_>,
) -> Result<DVector<f64>, EstimateError> {
    let mut model = problem.model.clone();
    for &(parameter, value) in point.iter().flatten() {
        model.start(parameter, value);
    }
    let linear = Unknowns {
        base: problem.unknowns.base.clone(),
        nonlinear: Vec::new(),
    };
    let frozen = problem.with_unknowns(&model, &linear);
    let solved = solve(&frozen, &frozen.start(), ITERATIONS_PER_ROUND, control)?;
    let mut start = problem.unknowns.among(&model.values());
    start.rows_mut(0, solved.x.len()).copy_from(&solved.x);
    Ok(start)
}

/// Points of the shapes of the laws at a joint's motor, the declared one first.
fn grid(problem: &FitProblem<'_>, alone: &JointSearches<'_>, joint: usize) -> Vec<Point> {
    let model = problem.model;
    let motion = MotionRange::of(problem.recordings, joint);
    let mut points = vec![Vec::new()];
    let mut declared = Vec::new();
    let unknowns = problem.unknowns.nonlinear.iter();
    let searched = unknowns
        .clone()
        .filter_map(|&p| Some((p, search(model, joint, p)?)));
    // What is scanned varies slowest: the best of it keeps its points where there are too many.
    let (scanned, others): (Vec<_>, Vec<_>) =
        searched.partition(|(_, search)| *search == Search::Cycles);
    for (p, search) in scanned.into_iter().chain(others) {
        let parameter = &model.parameters()[p];
        declared.push((p, parameter.value));
        let mut values = motion.grid(search, Bounded::of(parameter));
        if search == Search::Cycles {
            values = most_promising(alone, joint, p, &values);
        }
        let longer = |point: Point| -> Vec<Point> {
            let with = |x: &f64| point.iter().copied().chain([(p, *x)]).collect();
            values.iter().map(with).collect()
        };
        points = points.into_iter().flat_map(longer).collect();
    }
    let sizes = lent_sizes(model, problem.recordings, joint);
    let lent = unknowns.clone().find(|p| is_lent(model, joint, **p));
    if let Some(&p) = lent.filter(|_| !sizes.is_empty()) {
        let with = |point: &Point, size: &f64| [&point[..], &[(p, *size)]].concat();
        let of = |point: &Point| {
            sizes
                .iter()
                .map(|size| with(point, size))
                .collect::<Vec<_>>()
        };
        points = points.iter().flat_map(of).collect();
    }
    if points.len() > MOST_POINTS {
        let squares = alone.linearised(joint, &points);
        let mut ranked: Vec<(f64, Point)> = squares.into_iter().zip(points).collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        ranked.truncate(MOST_POINTS);
        points = ranked.into_iter().map(|(_, point)| point).collect();
    }
    if !declared.is_empty() {
        points.insert(0, declared);
    }
    points
}

/// The values of a scanned parameter that leave least to first order, of those that leave less than their neighbours.
fn most_promising(
    alone: &JointSearches<'_>,
    joint: usize,
    parameter: usize,
    values: &[f64],
) -> Vec<f64> {
    let points: Vec<Point> = values.iter().map(|&x| vec![(parameter, x)]).collect();
    let squares = alone.linearised(joint, &points);
    let of = |k: usize| squares.get(k).copied().unwrap_or(f64::INFINITY);
    let is_least = |k: &usize| of(*k) <= of(k.wrapping_sub(1)) && of(*k) <= of(k + 1);
    let mut least: Vec<usize> = (0..values.len()).filter(is_least).collect();
    least.sort_by(|&a, &b| of(a).total_cmp(&of(b)));
    least.truncate(MOST_SCANNED);
    least.into_iter().map(|k| values[k]).collect()
}

/// How a parameter is looked for, where it shapes a friction law of the joint's motor.
fn search(model: &Model, joint: usize, parameter: usize) -> Option<Search> {
    let law = motor_law(model, parameter)?;
    let has_grid = matches!(
        law.info.search,
        Search::Values(_)
            | Search::Position(_)
            | Search::Range(_)
            | Search::Speed(_)
            | Search::OverSpeed(_)
            | Search::Cycles
    );
    (law.joint == joint && has_grid).then_some(law.info.search)
}

/// Whether a parameter of a joint's motor is the size of one law and stands inside another that takes its place.
fn is_lent(model: &Model, joint: usize, parameter: usize) -> bool {
    motor_law(model, parameter)
        .is_some_and(|own| own.joint == joint && own.info.linearity == Linearity::Linear)
}

/// A parameter of a law at a motor.
fn motor_law(model: &Model, parameter: usize) -> Option<EffectParameter> {
    let own = model.effect_parameter(parameter)?;
    matches!(own.effect.law, Law::Motor(_)).then_some(own)
}
