//! Races on a published excitation problem: best value against time from its published starts.
//!
//! ```text
//! cargo run --release --example excitation_race -- PROBLEM.json [condition|d_optimal] [SECONDS] [SEED]
//! ```
//!
//! PROBLEM.json states robot, series, limits and base columns; beside it lie the URDF and `…_starts.json`. The
//! matrix is the bare base regressor at the stated samples; limits hold at every time, not at the samples only.
//! Prints the price of one value and one gradient, then every improvement as `wall_s,cpu_s,starts,value`.

use exid::chain::base_parameters::BaseParameters;
use exid::chain::model::{Model, ModelSettings, Signal};
use exid::design::constraints::joint_limits::{self, Ends};
use exid::design::criterion::parameters_of_interest::{Scale, Target};
use exid::design::criterion::{CRITERIA, Criterion};
use exid::design::information::columns::Columns;
use exid::design::problem::{Excitation, Experiment, Plan};
use exid::design::search::multistart::{Search, Settings};
use exid::design::trajectory::fourier_series::Series;
use exid::design::trajectory::motion::Joints;
use exid::design::verify;
use exid::problem::Problem;
use exid::problem::solution::Control;
use exid::robot::tree::Tree;
use exid::robot::urdf;
use exid::setup::limits::JointLimits;
use nalgebra::{DMatrix, DVector};
use serde_json::Value;
use std::error::Error;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Repetitions of which the median is the price of one evaluation.
const REPETITIONS: usize = 301;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let path = PathBuf::from(arguments.first().ok_or("name the problem's JSON file")?);
    let word = arguments.get(1).map_or("condition", String::as_str);
    let seconds: f64 = arguments.get(2).map_or(Ok(60.0), |s| s.parse())?;
    let seed: u64 = arguments.get(3).map_or(Ok(0), |s| s.parse())?;
    let criterion = *CRITERIA
        .iter()
        .find(|c| c.id() == word)
        .ok_or("the criterion is condition, d_optimal, a_optimal or e_optimal")?;
    let stated: Value = serde_json::from_str(&std::fs::read_to_string(&path)?)?;
    let model = model(&path, &stated)?;
    let none = DMatrix::zeros(0, model.parameters().len());
    let base = BaseParameters::structural(&model, &[false], &none).kept();
    let published: Vec<usize> = serde_json::from_value(stated["base_columns"].clone())?;
    if base != published {
        return Err("the base columns differ from the published ones".into());
    }
    let settings = Settings {
        budget: Some(Duration::from_secs_f64(seconds)),
        given: starts(&path)?,
        seed,
        ..Settings::default()
    };
    let columns = Columns::new(&model, base, &[false], &vec![1.0; model.tree().len()]);
    race(&model, (&stated, &columns, criterion), &settings)
}

fn race(
    model: &Model,
    (stated, columns, criterion): (&Value, &Columns, &'static dyn Criterion),
    settings: &Settings,
) -> Result<(), Box<dyn Error>> {
    let bounds = bounds(stated)?;
    let values = model.values();
    let samples = stated["sampling"]["n"]
        .as_u64()
        .ok_or("sampling.n is missing")?;
    let plan = Plan {
        model,
        columns,
        values: &values,
        loads: &[false],
        joints: joints(stated, bounds.len())?,
        samples: usize::try_from(samples)?,
        bounds,
        rules: Vec::new(),
        target: Target {
            criterion,
            wanted: None,
            prior: DMatrix::zeros(columns.len(), columns.len()),
            scale: Scale::None,
        },
        rivals: None,
    };
    let experiment = plan.experiment();
    price(&experiment, settings)?;
    let rows = joint_limits::rows(&experiment.joints, &experiment.bounds, Ends::Free);
    let search = Search {
        experiment: &experiment,
        rows: &rows,
        settings,
        shrink: 1.0,
    };
    println!("wall_s,cpu_s,starts,value");
    let began = processor_seconds();
    let found = search.run(&Control::default(), |i| {
        let spent = processor_seconds() - began;
        println!("{:.2},{spent:.2},{},{:.6}", i.elapsed, i.starts, i.value);
    })?;
    let violation = verify::violation(&verify::margins(&experiment, &found.x));
    println!(
        "{} {:.6} after {} starts, {} iterations, {} evaluations; largest violation of a limit on a grid {} times \
         finer, as a share of it: {violation:.1e}",
        criterion.id(),
        found.value,
        found.starts,
        found.iterations,
        found.evaluations,
        verify::FINER
    );
    Ok(())
}

/// Prints medians of one value, and of one value with its gradient, at the first start.
fn price(experiment: &Experiment<'_>, settings: &Settings) -> Result<(), Box<dyn Error>> {
    let exponent = experiment.target.criterion.exponents()[0];
    let problem = Excitation::new(experiment, exponent, 1.0);
    let x = settings.given.first().ok_or("no published start")?;
    let median = |evaluate: &dyn Fn()| -> f64 {
        let mut times: Vec<f64> = (0..REPETITIONS)
            .map(|_| {
                let began = Instant::now();
                evaluate();
                began.elapsed().as_secs_f64()
            })
            .collect();
        times.sort_by(f64::total_cmp);
        1e3 * times[REPETITIONS / 2]
    };
    problem.linearize(x)?;
    let value = median(&|| drop(black_box(problem.values(black_box(x)))));
    let gradient = median(&|| drop(black_box(problem.linearize(black_box(x)))));
    println!(
        "one value {value:.3} ms, one value with gradient {gradient:.3} ms, ratio {:.2}",
        gradient / value
    );
    Ok(())
}

fn model(path: &Path, stated: &Value) -> Result<Model, Box<dyn Error>> {
    let name = stated["urdf"].as_str().ok_or("urdf is missing")?;
    let tree: Tree = urdf::read(&path.with_file_name(name))?;
    Ok(Model::new(ModelSettings::bodies(tree, Signal::Torque))?)
}

fn joints(stated: &Value, count: usize) -> Result<Joints, Box<dyn Error>> {
    let of = &stated["trajectory"];
    let harmonics = of["harmonics"].as_u64().ok_or("harmonics are missing")?;
    let harmonics = usize::try_from(harmonics)?;
    Ok(Joints {
        harmonics: vec![harmonics; count],
        series: Series {
            harmonics,
            period: of["period_s"].as_f64().ok_or("period_s is missing")?,
        },
        count,
        moving: (0..count).collect(),
        standing: vec![0.0; count],
        trajectories: 1,
        loops: None,
    })
}

fn bounds(stated: &Value) -> Result<Vec<JointLimits>, Box<dyn Error>> {
    let list = |key: &str| -> Result<Vec<f64>, serde_json::Error> {
        serde_json::from_value(stated["limits"][key].clone())
    };
    let (lower, upper) = (list("q_min")?, list("q_max")?);
    let (velocity, acceleration) = (list("qd_max")?, list("qdd_max")?);
    let of = |j: usize| JointLimits {
        lower: lower[j],
        upper: upper[j],
        velocity: velocity[j],
        acceleration: acceleration[j],
        jerk: None,
        torque: None,
    };
    Ok((0..lower.len()).map(of).collect())
}

/// The published starts, in the order of their seeds.
fn starts(path: &Path) -> Result<Vec<DVector<f64>>, Box<dyn Error>> {
    let stem = path
        .file_stem()
        .and_then(|s| s.to_str())
        .unwrap_or_default();
    let text = std::fs::read_to_string(path.with_file_name(format!("{stem}_starts.json")))?;
    let stated: Value = serde_json::from_str(&text)?;
    let mut given = Vec::new();
    while let Some(start) = stated.get(given.len().to_string()) {
        let x: Vec<f64> = serde_json::from_value(start["x"].clone())?;
        given.push(DVector::from_vec(x));
    }
    Ok(given)
}

/// Seconds that all threads of this process have computed, from the kernel's ticks; not a number elsewhere
/// than on Linux.
fn processor_seconds() -> f64 {
    const TICKS_PER_SECOND: f64 = 100.0;
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // Behind the name in brackets, the twelfth and thirteenth fields are user and system time.
    let fields = text
        .rsplit(')')
        .next()
        .unwrap_or_default()
        .split_whitespace();
    let ticks: Vec<f64> = fields
        .skip(11)
        .take(2)
        .filter_map(|f| f.parse().ok())
        .collect();
    match ticks[..] {
        [user, system] => (user + system) / TICKS_PER_SECOND,
        _ => f64::NAN,
    }
}
