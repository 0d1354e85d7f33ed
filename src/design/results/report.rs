//! A finished design as the data of `result.json`.

use crate::design::constraints::joint_limits::INSTANTS_PER_CYCLE;
use crate::design::context::DesignContext;
use crate::design::criterion::condition::Condition;
use crate::design::criterion::d_optimal::DOptimal;
use crate::design::criterion::parameters_of_interest::{Scale, Target};
use crate::design::inputs::prepared::Prepared;
use crate::design::problem::Experiment;
use crate::design::results::coverage::EffectCoverage;
use crate::design::results::designed::End;
use crate::design::results::expected_deviations::Deviation;
use crate::design::search::inter_sample_limits::VerifiedMotion;
use crate::design::search::multistart::SearchResult;
use crate::design::trajectory::motion::Motion;
use crate::design::verify::{self, Margin};
use crate::outcome::design::{
    Coefficients, Coverage, Design, ExpectedDeviation, JointCoefficients, Progress, WorstMargin,
};
use crate::outcome::estimate::Solver;
use crate::problem::solution::Stop;
use crate::problem_file::DesignTable;
use crate::problem_file::choices::{Choice, Scaling};
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// The series, as the result states it.
const FORMULA: &str = "q(t) = q0 + sum_l a_l/(l w) sin(l w t) - b_l/(l w) cos(l w t) = q0 + sum_l \
                       sine_l sin(l w t) + cosine_l cos(l w t), w = 2 pi / period";

/// What the motion is worth and how it keeps its limits; expected deviations and coverage come later.
pub fn of_search(context: &DesignContext<'_>, verified: &VerifiedMotion) -> Design {
    let DesignContext {
        request,
        prepared,
        experiment,
    } = *context;
    let VerifiedMotion { found, margins, .. } = verified;
    let information = experiment.information(&found.x);
    Design {
        criterion_value: found.value,
        columns: (0..prepared.base.base.len())
            .map(|k| prepared.base.expression(&prepared.model, k))
            .collect(),
        coefficients: coefficients(prepared, experiment, found),
        worst_margins: margins.iter().map(margin).collect(),
        verification: verification(experiment),
        convergence: found
            .history
            .iter()
            .map(|i| Progress {
                elapsed_s: i.elapsed,
                starts: i.starts as u64,
                value: i.value,
            })
            .collect(),
        starts: found.starts as u64,
        ..judged(request.settings, experiment, &information)
    }
}

/// What is asked of a motion, and what its information is worth.
fn judged(table: &DesignTable, experiment: &Experiment<'_>, information: &DMatrix<f64>) -> Design {
    let matrix = Target {
        scale: match table.scaling.value {
            Scaling::Columns => Scale::Own,
            Scaling::None | Scaling::Whitened => Scale::None,
        },
        ..experiment.target.clone()
    }
    .matrix(information);
    let condition = matrix
        .as_ref()
        .map_or(f64::INFINITY, |m| Condition.ratio(m));
    let log_det = matrix.and_then(|m| DOptimal.log_det(&m));
    Design {
        kind: table.kind.value.word().to_string(),
        criterion: experiment.criterion_id().to_string(),
        criterion_meaning: experiment.criterion_meaning().to_string(),
        condition_number: condition,
        log_det: log_det.unwrap_or(f64::NEG_INFINITY),
        scaling: scaling(table.scaling.value, &experiment.target.scale).to_string(),
        ..Design::default()
    }
}

/// A plan of constant velocities; it is made, not searched for.
pub fn of_plan(context: &DesignContext<'_>, planned: &PlannedMotion) -> Design {
    let experiment = context.experiment;
    let PlannedMotion {
        motion,
        margins,
        step,
    } = planned;
    let mut memory = experiment.observation.workspace(motion.len());
    let information = experiment.observation.information(motion, &mut memory);
    let matrix = experiment.target.matrix(&information);
    let value = matrix.map_or(f64::INFINITY, |m| experiment.target.criterion.value(&m));
    Design {
        criterion_value: value,
        worst_margins: margins.iter().map(margin).collect(),
        verification: format!(
            "Strokes keep the limits of position, velocity and acceleration by the way they are made. Margins are the \
             least at the {} instants of the plan, {step} s apart.",
            motion.len()
        ),
        ..judged(context.request.settings, experiment, &information)
    }
}

/// A plan of constant velocities with its margins.
#[derive(Debug)]
pub struct PlannedMotion {
    /// The motion of all joints.
    pub motion: Motion,
    /// The least of every limit.
    pub margins: Vec<Margin>,
    /// s from one sample of the motion to the next.
    pub step: f64,
}

/// How the making of a plan of constant velocities ended.
pub fn solver_of_plan(cost: f64, end: End) -> Solver {
    Solver {
        name: "strokes about the posture of rest".to_string(),
        stop: match end {
            End::Infeasible => "infeasible".to_string(),
            _ => "planned".to_string(),
        },
        converged: end == End::Feasible,
        iterations: 0,
        evaluations: 1,
        cost,
    }
}

fn scaling(word: Scaling, used: &Scale) -> &'static str {
    match (word, used) {
        (Scaling::None, _) => "the bare base regressor: neither columns nor rows are scaled",
        (Scaling::Whitened, _) => "rows divided by the standard deviation of the noise",
        (Scaling::Columns, Scale::Own) => {
            "rows divided by the standard deviation of the noise, columns divided by their norms"
        }
        (Scaling::Columns, _) => {
            "rows divided by the standard deviation of the noise; the criterion's columns divided by \
             their root mean square norms over random motions within the limits, because norms that follow \
             the motion would not reward a larger one; condition_number and log_det are of columns of unit norm"
        }
    }
}

fn verification(experiment: &Experiment<'_>) -> String {
    let h = experiment.joints.series.harmonics;
    let samples = INSTANTS_PER_CYCLE * h;
    let factor = experiment.joints.series.between_samples(samples);
    format!(
        "Position, velocity, acceleration and jerk: limits divided by {factor:.6} at {samples} instants, \
         which bounds a series of {h} harmonics at every time (Ehlich and Zeller 1964). Torque and \
         workspace: checked at {} instants, {} times as many as designed with. Margins are the least \
         over these instants.",
        verify::FINER * experiment.basis.samples,
        verify::FINER
    )
}

fn coefficients(
    prepared: &Prepared,
    experiment: &Experiment<'_>,
    found: &SearchResult,
) -> Coefficients {
    let joints = &experiment.joints;
    let h = joints.series.harmonics;
    let omega = TAU / joints.series.period;
    let of = |trajectory: usize| {
        let one = |(m, j): (usize, &usize)| {
            let own = joints.coefficients_of(&found.x, trajectory, m);
            let joint = &prepared.model.tree().joints()[*j];
            let limits = &prepared.limits[*j];
            let (a, b) = (own[1..=h].to_vec(), own[h + 1..].to_vec());
            let over = |(l, value): (usize, &f64)| value / ((l + 1) as f64 * omega);
            JointCoefficients {
                joint: joint.name.clone(),
                unit: joint.kind.position_unit().to_string(),
                q0: own[0],
                sine: a.iter().enumerate().map(over).collect(),
                cosine: b.iter().enumerate().map(|p| -over(p)).collect(),
                a,
                b,
                limits: [
                    limits.lower,
                    limits.upper,
                    limits.velocity,
                    limits.acceleration,
                ],
            }
        };
        joints.moving.iter().enumerate().map(one).collect()
    };
    Coefficients {
        formula: FORMULA.to_string(),
        period: joints.series.period,
        harmonics: h,
        trajectories: (0..joints.trajectories).map(of).collect(),
    }
}

/// A margin as the outcome has it.
pub fn margin(m: &Margin) -> WorstMargin {
    WorstMargin {
        constraint: m.constraint.clone(),
        joint: m.joint.clone(),
        trajectory: m.trajectory + 1,
        time: m.time,
        margin: m.margin,
        relative: m.relative,
        limit: m.limit,
        unit: m.unit.clone(),
    }
}

/// Expected deviations as the outcome has them.
pub fn deviations(all: Vec<Deviation>) -> Vec<ExpectedDeviation> {
    all.into_iter()
        .map(|d| ExpectedDeviation {
            name: d.name,
            unit: d.unit,
            std_dev: d.std_dev,
            value: d.value,
        })
        .collect()
}

/// Coverage as the outcome has it.
pub fn coverage(all: Vec<EffectCoverage>) -> Vec<Coverage> {
    all.into_iter()
        .map(|s| Coverage {
            joint: s.joint,
            effect: s.effect.to_string(),
            shown: s.shown,
            sentence: s.sentence,
        })
        .collect()
}

/// What stands in the way of a feasible motion.
pub fn obstacle(margins: &[Margin]) -> String {
    let worst = margins
        .iter()
        .min_by(|a, b| a.relative.total_cmp(&b.relative));
    let Some(worst) = worst else {
        return "No feasible motion was found.".to_string();
    };
    let of = worst
        .joint
        .as_ref()
        .map_or(String::new(), |joint| format!(" of joint `{joint}`"));
    format!(
        "No feasible motion was found. In the way stands the {}{of}: at t = {:.3} s it misses its limit \
         {:.6} {} by {:.4} {} in the motion that comes closest. Widen this limit, or let the robot move \
         elsewhere.",
        worst.constraint, worst.time, worst.limit, worst.unit, -worst.margin, worst.unit
    )
}

/// What is said of a motion that keeps its limits with smaller amplitudes alone.
pub fn smaller(amplitude_share: f64) -> String {
    format!(
        "The motion that the search came to keeps its limits with {:.2} % of its amplitudes, and is given so. More time \
         (`design.budget_s`) or more starts (`design.starts`) may find a better one.",
        100.0 * amplitude_share
    )
}

/// How the search ended: a motion that keeps its limits is no solution where the search for a better one was cut off.
pub fn solver(found: &SearchResult, end: End) -> Solver {
    let stop = match (end, found.stop) {
        (End::Infeasible, _) => Stop::Infeasible,
        (_, Stop::Infeasible) => Stop::IterationLimit,
        (_, stop) => stop,
    };
    Solver {
        name: "sequential quadratic programming from many starts".to_string(),
        stop: stop.name().replace('-', "_"),
        converged: end == End::Feasible && stop.converged(),
        iterations: found.iterations as u64,
        evaluations: found.evaluations as u64,
        cost: found.value,
    }
}
