//! What a better model is worth: an arm follows a path under computed-torque control with the identified
//! model, with the drawings' model, and without one.
//!
//! ```text
//! τ = M(θ) a_θ + c(θ, θ̇) θ̇ + g(θ) + friction(θ̇_d),   a_θ = θ̈_d − K_d (θ̇ − θ̇_d) − K_p (θ − θ_d)
//! K_p = ω²·1,   K_d = 2 ω·1
//! ```
//!
//! (Gilbert, Maina and Byiringiro 2024, eqs 23 to 27; friction acts along the desired speed, because a
//! measured one near standstill would let the controller push itself.) The identified model comes from recordings that this program
//! simulates and fits first; the drawings' model has the true geometry and rotors, masses off by up to 20 %
//! and no friction; without a model the command is J a_θ with one constant inertia per joint.
//!
//!     cargo run --release --example computed_torque

use exid::chain::model::Model;
use exid::chain::parameter::Role;
use exid::estimate::task;
use exid::problem::solution::Control;
use exid::problem_file::ProblemFile;
use exid::robot::random::{generator, symmetric};
use exid::setup;
use exid::simulate::path::Motion;
use exid::simulate::plant::{Plant, State};
use exid::simulate::{self, truth, write_csv};
use nalgebra::DVector;
use std::error::Error;
use std::fs::{self, File};
use std::path::Path;

/// ω of eq. 27, rad/s.
const BANDWIDTH: f64 = 20.0;

/// Of the controller, s.
const TICK: f64 = 1e-3;

/// Steps of the integration per tick: friction turns over within milliseconds.
const STEPS: usize = 4;

/// Largest relative error of a mass of the drawings.
const DRAWING_ERROR: f64 = 0.2;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/panda_control/problem.toml");
    let problem = open(&file, &[])?;
    let robot = setup::robot::open(&problem)?;
    let truth = truth::build(&problem, &robot)?.plant;
    let goal = path(&file)?;
    println!(
        "| controller | RMS tracking error, mrad: {} |",
        names(&truth).join(" | ")
    );
    println!("|---|{}", "---|".repeat(truth.joints().len()));
    for (name, model) in [
        ("identified model", identified(&file)?),
        ("model of the drawings", drawn(&truth)?),
    ] {
        let bodies = without_friction(&model);
        let mut controller = Controller::new(&model, &bodies)?;
        let command = |state: &State, goal: &Goal| controller.torque(state, goal);
        report(name, &follow(&truth, &goal, command)?);
    }
    let inertia = own_inertias(&truth, &goal)?;
    let command = |state: &State, goal: &Goal| -> Outcome<Vec<f64>> {
        let wanted = wanted(state, goal);
        Ok(wanted.iter().zip(&inertia).map(|(a, j)| j * a).collect())
    };
    report("no model", &follow(&truth, &goal, command)?);
    Ok(())
}

fn open(file: &Path, overrides: &[String]) -> Outcome<ProblemFile> {
    Ok(ProblemFile::read(
        file,
        overrides,
        &exid::chain::effect::ids(),
    )?)
}

fn names(model: &Model) -> Vec<String> {
    model.joints().iter().map(|j| j.name.clone()).collect()
}

fn report(name: &str, errors: &[f64]) {
    let cells: Vec<String> = errors.iter().map(|e| format!("{:.2}", 1e3 * e)).collect();
    println!("| {name} | {} |", cells.join(" | "));
}

/// A path that no model was fitted to, of another seed than the recordings, at the ticks of the controller.
fn path(file: &Path) -> Outcome<Motion> {
    const SEED: u64 = 77;
    let rate = format!("recordings.rate={}", 1.0 / TICK);
    let problem = open(file, &[rate, "simulate.periods=1".to_string()])?;
    let simulated = simulate::run(&problem, SEED, &Control::default())?;
    let table = &simulated.trajectories[0].table;
    let n = (table.data.len() - 1) / 3;
    let order = |k: usize| table.data[1 + k * n..1 + (k + 1) * n].to_vec();
    Ok([order(0), order(1), order(2)])
}

/// The model that a fit of simulated recordings gives.
fn identified(file: &Path) -> Outcome<Model> {
    let folder = std::env::temp_dir().join(format!("exid-computed-torque-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    let problem = open(file, &[])?;
    let simulated = simulate::run(&problem, 1, &Control::default())?;
    let recording = folder.join("train.csv.gz");
    write_csv(File::create(&recording)?, &simulated.recordings[0])?;
    let train = format!("recordings.train=[{:?}]", recording.display().to_string());
    let fitted = task::run(&open(file, &[train])?, &Control::default(), |_| {})?.fitted;
    fs::remove_dir_all(&folder)?;
    known(&fitted.model, &fitted.values)
}

/// The model with every parameter known.
fn known(model: &Model, values: &DVector<f64>) -> Outcome<Model> {
    let mut model = model.clone();
    for (k, value) in values.iter().enumerate() {
        let parameter = &model.parameters()[k];
        let inside = value.clamp(parameter.lower, parameter.upper);
        model.fix(k, inside)?;
    }
    Ok(model)
}

/// Bodies of the right shape and wrong mass, and no friction.
fn drawn(truth: &Model) -> Outcome<Model> {
    let mut rng = generator(3);
    let factors: Vec<f64> = (0..truth.tree().len())
        .map(|_| 1.0 + symmetric(&mut rng, DRAWING_ERROR))
        .collect();
    let mut values = without_friction(truth).values();
    for (value, parameter) in values.iter_mut().zip(truth.parameters()) {
        if let Role::Inertial { link, .. } = parameter.role {
            *value *= factors[link];
        }
    }
    known(truth, &values)
}

fn without_friction(model: &Model) -> Model {
    let mut bodies = model.clone();
    for k in 0..model.parameters().len() {
        let name = &model.parameters()[k].name;
        if name.ends_with(".Fc") || name.ends_with(".Fv") {
            // Zero lies within the limits of friction.
            let _ = bodies.fix(k, 0.0);
        }
    }
    bodies
}

/// Desired position, velocity and acceleration.
type Goal = [Vec<f64>; 3];

/// `θ̈_d − K_d (θ̇ − θ̇_d) − K_p (θ − θ_d)`.
fn wanted(state: &State, [q, dq, ddq]: &Goal) -> Vec<f64> {
    (0..q.len())
        .map(|j| {
            let (lag, slip) = (q[j] - state.position[j], dq[j] - state.velocity[j]);
            ddq[j] + 2.0 * BANDWIDTH * slip + BANDWIDTH * BANDWIDTH * lag
        })
        .collect()
}

/// Computed torque with a model.
struct Controller<'m> {
    whole: Plant<'m>,
    bodies: Plant<'m>,
}

impl<'m> Controller<'m> {
    fn new(whole: &'m Model, bodies: &'m Model) -> Outcome<Self> {
        let plant = |model| Plant::new(model, false).ok_or("too many joints");
        Ok(Self {
            whole: plant(whole)?,
            bodies: plant(bodies)?,
        })
    }

    fn torque(&mut self, state: &State, goal: &Goal) -> Outcome<Vec<f64>> {
        let wanted = wanted(state, goal);
        let of = |plant: &mut Plant<'m>, speed: &[f64]| -> Outcome<Vec<f64>> {
            let mut out = vec![0.0; wanted.len()];
            plant.torque([&state.position, speed, &wanted], &mut out)?;
            Ok(out)
        };
        let moving = of(&mut self.bodies, &state.velocity)?;
        let with = of(&mut self.whole, &goal[1])?;
        let without = of(&mut self.bodies, &goal[1])?;
        let friction = with.iter().zip(&without).map(|(a, b)| a - b);
        Ok(moving.iter().zip(friction).map(|(m, f)| m + f).collect())
    }
}

/// What each joint moves by itself where the path begins, kg·m².
fn own_inertias(truth: &Model, goal: &Motion) -> Outcome<Vec<f64>> {
    let n = truth.joints().len();
    let start: Vec<f64> = goal[0].iter().map(|series| series[0]).collect();
    let mut plant = Plant::new(truth, false).ok_or("too many joints")?;
    let mut torque = |acceleration: &[f64]| -> Outcome<Vec<f64>> {
        let mut out = vec![0.0; n];
        plant.torque([&start, &vec![0.0; n], acceleration], &mut out)?;
        Ok(out)
    };
    let rest = torque(&vec![0.0; n])?;
    let alone = |j: usize| -> Vec<f64> { (0..n).map(|k| f64::from(u8::from(k == j))).collect() };
    (0..n)
        .map(|j| Ok(torque(&alone(j))?[j] - rest[j]))
        .collect()
}

/// Follows the path once; gives the root mean square of every joint's error, rad.
fn follow(
    truth: &Model,
    path: &Motion,
    mut command: impl FnMut(&State, &Goal) -> Outcome<Vec<f64>>,
) -> Outcome<Vec<f64>> {
    let mut plant = Plant::new(truth, false).ok_or("too many joints")?;
    let (n, ticks) = (path[0].len(), path[0][0].len());
    let at = |tick: usize| -> Goal {
        std::array::from_fn(|order| path[order].iter().map(|series| series[tick]).collect())
    };
    let [position, velocity, _] = at(0);
    let mut state = State { position, velocity };
    let mut squares = vec![0.0; n];
    for tick in 0..ticks {
        let goal = at(tick);
        for j in 0..n {
            squares[j] += (state.position[j] - goal[0][j]).powi(2) / ticks as f64;
        }
        let torque = command(&state, &goal)?;
        for _ in 0..STEPS {
            let chain = plant.linearise(&state)?;
            state = plant
                .step(&state, &chain, &torque, TICK / STEPS as f64)?
                .state;
        }
    }
    Ok(squares.into_iter().map(f64::sqrt).collect())
}
