//! Where a nonlinear fit starts: the linear unknowns at their optimum, and the shape of every friction law at the
//! best point of its grid.
//!
//! A friction law has shallow optima besides the deepest one (bristles as stiff as sampling can tell, a scale of speed
//! that no speed reaches), and one search finds the nearest. So every joint's law is tried at every point of its grid,
//! all joints at a time with the linear unknowns solved for, and every joint keeps the point at which its own channel
//! leaves least.
//!
//! Bristles that bend before they slide show their stiffness so much more than how friction falls with speed that a
//! search settles the latter wrongly while it still looks for the former. With the stiffness found, it is begun anew
//! from every scale of speed, and every joint keeps the better end.

use crate::chain::effect::{Law, Memory, ParameterInfo, Search};
use crate::chain::model::Model;
use crate::chain::parameter::Role;
use crate::estimate::error::EstimateError;
use crate::estimate::fit::{ITERATIONS_PER_ROUND, solve};
use crate::estimate::problem::FitProblem;
use crate::estimate::reach::Motion;
use crate::estimate::unknowns::Unknowns;
use crate::problem::Problem;
use crate::problem::form::Structure;
use crate::problem::solution::Control;
use nalgebra::DVector;

/// Points of a joint's grid that are tried at most.
const MOST_POINTS: usize = 36;

/// Iterations of a search that is compared with others.
const ITERATIONS_ANEW: usize = 40;

/// Values of some parameters, by their positions in the model.
type Point = Vec<(usize, f64)>;

/// The unknowns from which a search begins.
pub(super) fn find(
    problem: &FitProblem<'_>,
    control: &Control<'_>,
) -> Result<DVector<f64>, EstimateError> {
    if problem.form().structure == Structure::Affine {
        return Ok(problem.start());
    }
    let grids: Vec<Vec<Point>> = (0..problem.model.joints().len())
        .map(|joint| grid(problem, joint))
        .collect();
    let count = grids.iter().map(Vec::len).max().unwrap_or(1);
    if count <= 1 {
        return at(problem, &[], control);
    }
    let mut least = vec![(f64::INFINITY, 0); grids.len()];
    for k in 0..count {
        let tried: Vec<Point> = grids
            .iter()
            .map(|g| g[k.min(g.len() - 1)].clone())
            .collect();
        let start = at(problem, &tried, control)?;
        for (joint, left) in left(problem, &start).into_iter().enumerate() {
            if k < grids[joint].len() && left < least[joint].0 {
                least[joint] = (left, k);
            }
        }
    }
    let best = least.iter().zip(&grids).map(|((_, k), g)| g[*k].clone());
    let start = at(problem, &best.collect::<Vec<_>>(), control)?;
    match problem.model.memory() {
        Memory::Course => begun_anew(problem, start, control),
        _ => Ok(start),
    }
}

/// The end of a search, or of those from its end with the scales of speed at every value of their grid: all of the
/// end that costs least, and of every joint the law of the end that leaves least in its own channel.
fn begun_anew(
    problem: &FitProblem<'_>,
    start: DVector<f64>,
    control: &Control<'_>,
) -> Result<DVector<f64>, EstimateError> {
    let search = |from: &DVector<f64>| solve(problem, from, (ITERATIONS_ANEW, control));
    let mut ends = vec![search(&start)?];
    let positions = problem.unknowns.positions();
    let resets = resets(problem);
    let count = resets.iter().map(|(_, values)| values.len()).max();
    for k in 0..count.unwrap_or(0) {
        let mut from = ends[0].x.clone();
        for (unknown, values) in &resets {
            from[*unknown] = values[k.min(values.len() - 1)];
        }
        // Friction at high speed made up for what the law lacked: it is solved for anew.
        let shapes = positions.iter().copied().zip(from.iter().copied());
        let shapes: Point = shapes.skip(problem.unknowns.base.base.len()).collect();
        ends.push(search(&at(problem, &[shapes], control)?)?);
    }
    let left: Vec<Vec<f64>> = ends.iter().map(|end| left(problem, &end.x)).collect();
    let least = |of: &dyn Fn(usize) -> f64| {
        let order = |a: &usize, b: &usize| of(*a).total_cmp(&of(*b));
        (0..ends.len()).min_by(order).unwrap_or(0)
    };
    let mut best = ends[least(&|k| ends[k].cost)].x.clone();
    for (unknown, &p) in positions.iter().enumerate() {
        if let Role::Effect { joint, .. } = problem.model.parameters()[p].role {
            best[unknown] = ends[least(&|k| left[k][joint])].x[unknown];
        }
    }
    Ok(best)
}

/// Unknowns of laws with memory that a search begins anew, and from which values: scales of speed from their grid,
/// what has no grid from where it is declared to start. What has a grid of its own stays as it was found.
fn resets(problem: &FitProblem<'_>) -> Vec<(usize, Vec<f64>)> {
    let model = problem.model;
    let mut resets = Vec::new();
    for (unknown, p) in problem.unknowns.positions().into_iter().enumerate() {
        let parameter = &model.parameters()[p];
        let Some((joint, info)) = motor_law(model, p, Memory::Course) else {
            continue;
        };
        let limits = (parameter.value, parameter.lower, parameter.upper);
        match info.search {
            Search::Speed(_) | Search::OverSpeed(_) => {
                let motion = Motion::of(problem.recordings, joint);
                resets.push((unknown, motion.values(info.search, limits)));
            }
            Search::Typical => resets.push((unknown, vec![parameter.value])),
            _ => {}
        }
    }
    resets
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
    let solved = solve(&frozen, &frozen.start(), (ITERATIONS_PER_ROUND, control))?;
    let values = model.values();
    let all = problem.unknowns.positions();
    let mut start = DVector::from_iterator(all.len(), all.iter().map(|&p| values[p]));
    start.rows_mut(0, solved.x.len()).copy_from(&solved.x);
    Ok(start)
}

/// Sum of the squared residuals of every joint's own channel; zero where it has none.
fn left(problem: &FitProblem<'_>, x: &DVector<f64>) -> Vec<f64> {
    let series = problem.counted_residuals(x);
    let mut left = vec![0.0; problem.model.joints().len()];
    for (c, channel) in problem.model.channels().iter().enumerate() {
        if let Some(joint) = channel.joint {
            let own = series.iter().flat_map(|recording| &recording[c]);
            left[joint] = own.map(|e| e * e).sum();
        }
    }
    left
}

/// Points of the shapes of a joint's friction laws, the declared one first.
fn grid(problem: &FitProblem<'_>, joint: usize) -> Vec<Point> {
    let model = problem.model;
    let motion = Motion::of(problem.recordings, joint);
    let mut points = vec![Vec::new()];
    let mut declared = Vec::new();
    for &p in &problem.unknowns.nonlinear {
        let Some(search) = search(model, (joint, p)) else {
            continue;
        };
        let parameter = &model.parameters()[p];
        declared.push((p, parameter.value));
        let values = motion.values(search, (parameter.value, parameter.lower, parameter.upper));
        let longer = |point: Point| -> Vec<Point> {
            let with = |x: &f64| point.iter().copied().chain([(p, *x)]).collect();
            values.iter().map(with).collect()
        };
        points = points.into_iter().flat_map(longer).collect();
    }
    points.truncate(MOST_POINTS);
    points.insert(0, declared);
    points
}

/// How a parameter is looked for, where it shapes a friction law of the joint's motor.
fn search(model: &Model, (joint, parameter): (usize, usize)) -> Option<Search> {
    let (own, info) = motor_law(model, parameter, Memory::None)?;
    let has_grid = matches!(
        info.search,
        Search::Values(_) | Search::Speed(_) | Search::OverSpeed(_)
    );
    (own == joint && has_grid).then_some(info.search)
}

/// The joint of a parameter of a law at a motor with at least this memory, and what is known of the parameter.
fn motor_law(
    model: &Model,
    parameter: usize,
    memory: Memory,
) -> Option<(usize, &'static ParameterInfo)> {
    let Role::Effect {
        joint,
        effect,
        parameter,
    } = model.parameters()[parameter].role
    else {
        return None;
    };
    let effect = model.joints()[joint].effects.get(effect)?.0;
    let remembers = memory == Memory::None || effect.needs.memory == memory;
    let at_motor = matches!(effect.law, Law::Motor(_));
    let info = effect.parameters.get(parameter)?;
    (at_motor && remembers).then_some((joint, info))
}
