//! The task behind `exid design`: from a problem file to motions, what they are worth, and their files.

use std::time::Duration;

use nalgebra::{DMatrix, DVector};

use crate::design::constant_velocity;
use crate::design::constraints::joint_limits::{self, Ends};
use crate::design::context::DesignContext;
use crate::design::criterion::parameters_of_interest::{Scale, Target};
use crate::design::error::{DesignError, Unsuitable};
use crate::design::information::columns::Columns;
use crate::design::inputs::prepared::{self, Prepared};
use crate::design::inputs::request::DesignRequest;
use crate::design::inputs::rival_models;
use crate::design::inputs::stated_motion::StatedMotion;
use crate::design::problem::{Excitation, Experiment, Plan};
use crate::design::results::comparison;
use crate::design::results::designed::{Designed, End, NamedTrajectory};
use crate::design::results::report;
use crate::design::search::inter_sample_limits::{self, VerifiedMotion};
use crate::design::search::multistart::{Improvement, Search, Settings};
use crate::design::search::starts::Starts;
use crate::design::search::validation_motion;
use crate::design::trajectory::fourier_series::Series;
use crate::design::trajectory::motion::{Joints, Motion};
use crate::design::trajectory::sampled::Sampled;
use crate::design::verify;
use crate::problem::linear_rows::LinearRows;
use crate::problem::solution::{Control, Stop};
use crate::problem_file::choices::{DesignKind, Scaling};
use crate::problem_file::{Located, ProblemFile};
use crate::robot::random::generator;
use crate::setup;

/// Instants per cycle of the highest harmonic below which the samples of a design see too little of it.
const LEAST_PER_CYCLE: usize = 4;

/// Random motions whose columns' norms make the fixed scale.
const SCALE_MOTIONS: usize = 8;

/// Designs the motions of a problem file; `on_improvement` hears of every improvement.
///
/// # Errors
/// Faults of the problem file and the files it names; as [`design`].
pub fn run(
    problem: &ProblemFile,
    seed: u64,
    control: &Control,
    on_improvement: impl Fn(&Improvement) + Sync,
) -> Result<Designed, DesignError> {
    let robot = setup::robot::open(problem)?;
    let request = DesignRequest::of(problem, &robot)?;
    design(&request, seed, control, on_improvement)
}

/// Designs the motions that are asked for; `on_improvement` hears of every improvement.
///
/// # Errors
/// Requests that no design can meet; nothing to estimate.
pub fn design(
    request: &DesignRequest<'_>,
    seed: u64,
    control: &Control,
    on_improvement: impl Fn(&Improvement) + Sync,
) -> Result<Designed, DesignError> {
    let settings = request.settings;
    let prepared = Prepared::of(request, &request.model)?;
    prepared.check_unknowns(&request.place)?;
    let columns = columns(settings.scaling.value, &prepared);
    let mut experiment = experiment(request, &prepared, &columns)?;
    if settings.kind.value == DesignKind::ConstantVelocity {
        return constant_velocity::task::run(&DesignContext {
            request,
            prepared: &prepared,
            experiment: &experiment,
        });
    }
    let ends = match settings.rest_to_rest.value {
        true => Ends::AtRest,
        false => Ends::Free,
    };
    let rows = joint_limits::rows(&experiment.joints, &experiment.bounds, ends);
    if settings.scaling.value == Scaling::Columns {
        experiment.target.scale = columns_scale(&experiment, &rows, seed);
    }
    if experiment.rivals.is_some() && !experiment.value(&any(&experiment, &rows, seed)).is_finite()
    {
        let place = &settings.criterion.place;
        return Err(DesignError::unsuitable(place, Unsuitable::SameRivals));
    }
    let context = DesignContext {
        request,
        prepared: &prepared,
        experiment: &experiment,
    };
    let reference = reference(&context)?;
    let settings = search_settings(&context, reference.as_ref(), seed)?;
    let search = Search {
        experiment: &experiment,
        rows: &rows,
        settings: &settings,
        shrink: 1.0,
    };
    let verified = inter_sample_limits::run(&search, control, on_improvement)?;
    let mut designed = conclude(&context, &search, verified)?;
    designed.design.reference = reference.map(|r| comparison::reference(&context, &r));
    Ok(designed)
}

/// The motion to compare with.
fn reference(context: &DesignContext<'_>) -> Result<Option<StatedMotion>, DesignError> {
    let path = context.request.settings.reference.as_ref();
    let joints = &context.experiment.joints;
    path.map(|path| StatedMotion::read(path, joints, &context.prepared.names()))
        .transpose()
}

fn search_settings(
    context: &DesignContext<'_>,
    reference: Option<&StatedMotion>,
    seed: u64,
) -> Result<Settings, DesignError> {
    let table = context.request.settings;
    let joints = &context.experiment.joints;
    let mut given = Vec::new();
    if let Some(path) = &table.start_from {
        let stated = StatedMotion::read(path, joints, &context.prepared.names())?;
        let own = stated.within(joints);
        given.push(
            own.ok_or_else(|| DesignError::unsuitable(&path.place, Unsuitable::OtherSeries))?,
        );
    }
    given.extend(reference.and_then(|r| r.within(joints)));
    Ok(Settings {
        starts: table.starts.as_ref().map(|s| s.value),
        budget: table
            .budget_s
            .as_ref()
            .map(|b| Duration::from_secs_f64(b.value)),
        seed,
        given,
    })
}

/// A random motion within the limits.
fn any(experiment: &Experiment<'_>, rows: &LinearRows, seed: u64) -> DVector<f64> {
    let problem = Excitation::new(experiment, 1.0, 1.0);
    Starts::of(experiment, &problem, rows).random(&mut generator(seed))
}

/// The columns; a bare regressor has no weights.
fn columns(scaling: Scaling, prepared: &Prepared) -> Columns {
    let bare = vec![1.0; prepared.noise.len()];
    let noise = match scaling {
        Scaling::None => &bare,
        Scaling::Columns | Scaling::Whitened => &prepared.noise,
    };
    let kept = prepared.base.kept();
    Columns::new(&prepared.model, kept, &prepared.loads, noise)
}

fn experiment<'a>(
    request: &DesignRequest<'_>,
    prepared: &'a Prepared,
    columns: &'a Columns,
) -> Result<Experiment<'a>, DesignError> {
    let table = request.settings;
    let model = &prepared.model;
    let n = model.joints().len();
    let standing = |j: usize| prepared.robot.locked[j].unwrap_or(0.0);
    let moving: Vec<usize> = (0..n).filter(|&j| !model.joints()[j].locked).collect();
    let harmonics = prepared.harmonics(table)?;
    let joints = Joints {
        series: Series {
            harmonics: table.harmonics.value.most(),
            period: table.period.value,
        },
        count: n,
        harmonics: moving.iter().map(|&j| harmonics[j]).collect(),
        moving,
        standing: (0..n).map(standing).collect(),
        trajectories: table.trajectories.value,
        loops: prepared.robot.mechanism.clone(),
    };
    check_samples(&table.samples, joints.series.harmonics)?;
    let plan = Plan {
        model,
        columns,
        values: &prepared.values,
        loads: &prepared.loads,
        samples: table.samples.value,
        joints,
        bounds: prepared.limits.clone(),
        rules: prepared.rules(table)?,
        target: Target {
            criterion: prepared::criterion(table),
            wanted: prepared.wanted(table)?,
            prior: match table.scaling.value {
                Scaling::None => DMatrix::zeros(columns.len(), columns.len()),
                Scaling::Columns | Scaling::Whitened => prepared.prior_information(),
            },
            scale: Scale::None,
        },
        rivals: rival_models::of(request, prepared)?,
    };
    Ok(plan.experiment())
}

/// # Errors
/// Samples between which the fastest harmonic is not seen.
fn check_samples(stated: &Located<usize>, harmonics: usize) -> Result<(), DesignError> {
    let least = LEAST_PER_CYCLE * harmonics;
    if stated.value >= least {
        return Ok(());
    }
    let kind = Unsuitable::TooFewSamples {
        found: stated.value,
        least,
    };
    Err(DesignError::unsuitable(&stated.place, kind))
}

/// The condition number sees columns of unit norm along the motion itself; the other criteria would lose
/// what the norms say, so for them each column is divided by its norm over random motions.
fn columns_scale(experiment: &Experiment<'_>, rows: &LinearRows, seed: u64) -> Scale {
    if experiment.target.criterion.id() == "condition" {
        return Scale::Own;
    }
    let problem = Excitation::new(experiment, 1.0, 1.0);
    let starts = Starts::of(experiment, &problem, rows);
    let count = experiment.observation.columns().len();
    let mut sum = DMatrix::zeros(count, count);
    for number in 0..SCALE_MOTIONS {
        let mut rng = generator(seed);
        rng.set_stream(u64::MAX - number as u64);
        sum += experiment.information(&starts.random(&mut rng));
    }
    let diagonal = sum.diagonal() / SCALE_MOTIONS as f64;
    let scale = diagonal.map(|d| if d > 0.0 { 1.0 / d.sqrt() } else { 1.0 });
    Scale::Fixed(match &experiment.target.wanted {
        Some(wanted) => scale.select_rows(wanted),
        None => scale,
    })
}

fn conclude(
    context: &DesignContext<'_>,
    search: &Search<'_>,
    verified: VerifiedMotion,
) -> Result<Designed, DesignError> {
    let experiment = context.experiment;
    let is_feasible = verified.violation() <= verify::TOLERANCE;
    let mut design = report::of_search(context, &verified);
    let VerifiedMotion {
        found,
        margins,
        amplitude_share,
    } = verified;
    let end = match found.stop {
        Stop::Interrupted => End::Interrupted,
        _ if !is_feasible => End::Infeasible,
        _ => End::Feasible,
    };
    let motion = Motion::of(&experiment.joints, &experiment.basis, &found.x);
    let Trajectories {
        periods,
        with_ramps,
    } = trajectories(context, search, &found.x)?;
    context.judge(&motion, &mut design);
    if !is_feasible {
        design.notes.insert(0, report::obstacle(&margins));
    } else if amplitude_share < 1.0 {
        let note = report::smaller(amplitude_share);
        design.notes.insert(0, note);
    }
    Ok(Designed {
        solver: report::solver(&found, end),
        design,
        end,
        trajectories: periods,
        with_ramps,
    })
}

/// The trajectories of a design, one for validation among them.
struct Trajectories {
    /// One period of each.
    periods: Vec<NamedTrajectory>,
    /// The same between ramps from and to standstill.
    with_ramps: Vec<NamedTrajectory>,
}

fn trajectories(
    context: &DesignContext<'_>,
    search: &Search<'_>,
    x: &DVector<f64>,
) -> Result<Trajectories, DesignError> {
    let DesignContext {
        request,
        prepared,
        experiment,
    } = *context;
    let joints = &experiment.joints;
    let single = joints.single();
    let names = prepared.names();
    let mut pieces: Vec<(String, DVector<f64>)> = (0..joints.trajectories)
        .map(|k| {
            let own = x.rows(k * joints.of_trajectory(), joints.of_trajectory());
            let name = match k {
                0 => "trajectory".to_string(),
                _ => format!("trajectory_{}", k + 1),
            };
            (name, own.into_owned())
        })
        .collect();
    if let Some(other) = validation_motion::far_from(search, x) {
        pieces.push(("validation_trajectory".to_string(), other));
    }
    let rest = prepared.rest(request.settings)?;
    let holds = |motion: &Motion| {
        let mut motion = motion.clone();
        single.close(&mut motion);
        let margins = verify::of_dynamics(experiment, &motion, 0.0, 0);
        verify::violation(&margins) <= verify::TOLERANCE
    };
    let mut periods = Vec::new();
    let mut with_ramps = Vec::new();
    for (name, own) in pieces {
        let sampled = Sampled::period(&single, &own, request.rate, &names);
        with_ramps.push(NamedTrajectory {
            name: format!("{name}_with_ramps"),
            sampled: sampled
                .with_ramps(&rest, &single.of_motors(&prepared.limits), holds)
                .closed(&single),
        });
        periods.push(NamedTrajectory { name, sampled });
    }
    Ok(Trajectories {
        periods,
        with_ramps,
    })
}
