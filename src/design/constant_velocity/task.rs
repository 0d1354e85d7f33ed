//! Makes and verifies a plan of constant velocities.

use crate::design::constant_velocity::plan::ConstantVelocityPlan;
use crate::design::error::{DesignError, Unsuitable};
use crate::design::inputs::prepared::Prepared;
use crate::design::problem::Experiment;
use crate::design::results::designed::{Designed, End, NamedTrajectory, rate};
use crate::design::results::report;
use crate::design::trajectory::motion::Motion;
use crate::design::trajectory::sampled::Sampled;
use crate::design::verify::{self, Margin};
use crate::fault::Place;
use crate::problem_file::ProblemFile;

/// Shares of the ranges of positions that are tried until torques and workspace keep their limits.
const SHARES: [f64; 7] = [1.0, 0.8, 0.6, 0.45, 0.3, 0.2, 0.1];

/// ConstantVelocityPlan about the posture of rest, as long as the limits allow.
///
/// # Errors
/// A joint without room for strokes.
pub fn run(
    problem: &ProblemFile,
    prepared: &Prepared,
    experiment: &Experiment<'_>,
) -> Result<Designed, DesignError> {
    let mut best: Option<(Motion, Vec<Margin>)> = None;
    let step = 1.0 / rate(problem);
    for share in SHARES {
        let motion = plan(problem, (prepared, experiment), share)?.motion(step);
        let margins = verify::of_samples(experiment, &motion, step);
        let violation = verify::violation(&margins);
        let least = best
            .as_ref()
            .map_or(f64::INFINITY, |b| verify::violation(&b.1));
        if violation < least {
            best = Some((motion, margins));
        }
        if violation <= verify::TOLERANCE {
            break;
        }
    }
    let Some((motion, margins)) = best else {
        let place = Place::file(&problem.path).key("design.limits");
        let joint = String::new();
        return Err(DesignError::unsuitable(
            &place,
            Unsuitable::TooFast { joint },
        ));
    };
    Ok(conclude(
        problem,
        (prepared, experiment),
        (motion, margins, step),
    ))
}

fn plan(
    problem: &ProblemFile,
    (prepared, experiment): (&Prepared, &Experiment<'_>),
    share: f64,
) -> Result<ConstantVelocityPlan, DesignError> {
    let rest = prepared.rest(problem)?;
    let speeds = problem.design.speeds.value.max(2);
    let moving = &experiment.joints.moving;
    let tree = prepared.model.tree();
    ConstantVelocityPlan::new((tree, moving), (&prepared.limits, &rest), (speeds, share)).map_err(
        |joint| {
            let place = Place::file(&problem.path).key("design.limits");
            DesignError::unsuitable(&place, Unsuitable::TooFast { joint })
        },
    )
}

fn conclude(
    problem: &ProblemFile,
    (prepared, experiment): (&Prepared, &Experiment<'_>),
    (motion, margins, step): (Motion, Vec<Margin>, f64),
) -> Designed {
    let end = match verify::violation(&margins) <= verify::TOLERANCE {
        true => End::Feasible,
        false => End::Infeasible,
    };
    let mut design = report::of_steady(problem, experiment, (&motion, &margins, step));
    prepared.judge(experiment, &motion, &mut design);
    if end == End::Infeasible {
        design.notes.insert(0, report::obstacle(&margins));
    }
    let sampled = Sampled::given(motion, step, &prepared.names());
    Designed {
        solver: report::solver_of_steady(design.criterion_value, end),
        design,
        end,
        trajectories: vec![NamedTrajectory {
            name: "trajectory".to_string(),
            sampled: sampled.clone(),
        }],
        // The plan begins and ends at rest by itself.
        with_ramps: vec![NamedTrajectory {
            name: "trajectory_with_ramps".to_string(),
            sampled,
        }],
    }
}
