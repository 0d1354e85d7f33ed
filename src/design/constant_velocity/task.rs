//! Makes and verifies a plan of constant velocities.

use crate::design::constant_velocity::plan::{ConstantVelocityPlan, Request};
use crate::design::context::DesignContext;
use crate::design::error::{DesignError, Unsuitable};
use crate::design::results::designed::{Designed, End, NamedTrajectory};
use crate::design::results::report::{self, PlannedMotion};
use crate::design::trajectory::sampled::Sampled;
use crate::design::verify;

/// Shares of the ranges of positions that are tried until torques and workspace keep their limits.
const SHARES: [f64; 7] = [1.0, 0.8, 0.6, 0.45, 0.3, 0.2, 0.1];

/// Strokes about the posture of rest, as long as the limits allow.
///
/// # Errors
/// A joint without room for strokes.
pub fn run(context: &DesignContext<'_>) -> Result<Designed, DesignError> {
    let mut best: Option<PlannedMotion> = None;
    let step = 1.0 / context.request.rate;
    for share in SHARES {
        let motion = plan(context, share)?.motion(step);
        let margins = verify::of_samples(context.experiment, &motion, step);
        let violation = verify::violation(&margins);
        let least = best
            .as_ref()
            .map_or(f64::INFINITY, |b| verify::violation(&b.margins));
        if violation < least {
            best = Some(PlannedMotion {
                motion,
                margins,
                step,
            });
        }
        if violation <= verify::TOLERANCE {
            break;
        }
    }
    let Some(planned) = best else {
        let place = context.request.place.clone().key("design.limits");
        let joint = String::new();
        return Err(DesignError::unsuitable(
            &place,
            Unsuitable::TooFast { joint },
        ));
    };
    Ok(conclude(context, planned))
}

fn plan(context: &DesignContext<'_>, share: f64) -> Result<ConstantVelocityPlan, DesignError> {
    let DesignContext {
        request,
        prepared,
        experiment,
    } = *context;
    let strokes = Request {
        tree: prepared.model.tree(),
        moving: &experiment.joints.moving,
        limits: &prepared.limits,
        rest: &prepared.rest(request.settings)?,
        speeds: request.settings.speeds.value.max(2),
        share,
    };
    ConstantVelocityPlan::new(strokes).map_err(|joint| {
        let place = request.place.clone().key("design.limits");
        DesignError::unsuitable(&place, Unsuitable::TooFast { joint })
    })
}

fn conclude(context: &DesignContext<'_>, planned: PlannedMotion) -> Designed {
    let end = match verify::violation(&planned.margins) <= verify::TOLERANCE {
        true => End::Feasible,
        false => End::Infeasible,
    };
    let mut design = report::of_plan(context, &planned);
    context.judge(&planned.motion, &mut design);
    if end == End::Infeasible {
        design.notes.insert(0, report::obstacle(&planned.margins));
    }
    let names = context.prepared.names();
    let sampled = Sampled::given(planned.motion, planned.step, &names);
    Designed {
        solver: report::solver_of_plan(design.criterion_value, end),
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
