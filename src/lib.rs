//! exid: excite, identify, diagnose.
//!
//! A robot is a chain from motion to measured signal, s = ŝ(q, q̇, q̈; θ) + ε. This library designs motions that determine
//! its parameters θ, estimates them with their uncertainty, and finds and names the physics that the model lacks where it and
//! the recordings differ. Everything is in SI units at the joint.
//!
//! # From URDF and CSV to a fit
//!
//! A [`ProblemBuilder`](problem_file::builder::ProblemBuilder) states what a problem file would; a [task](estimate::task) runs it.
//!
//! ```
//! use exid::chain::effect::ids;
//! use exid::estimate::task as fit;
//! use exid::problem::solution::Control;
//! use exid::problem_file::builder::ProblemBuilder;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let problem = ProblemBuilder::in_folder(concat!(env!("CARGO_MANIFEST_DIR"), "/problems/arm6"))
//!     .urdf("arm6.urdf")
//!     .train("train.csv.gz") // t, s; q1 to q6, rad; i1 to i6, A
//!     .validation("validation.csv.gz")
//!     .torque_constant([13.1, 13.0, 12.8, 9.2, 9.1, 9.3])
//!     .rotor_inertia([1.40, 1.50, 1.10, 0.35, 0.34, 0.33])
//!     .effects(&["coulomb_friction", "viscous_friction", "torque_offset"])
//!     .build(&ids())?;
//! let fitted = fit::run(&problem, &Control::default(), |_| ())?.fitted;
//! let friction = fitted.estimate.find("a1.viscous_friction.Fv").ok_or("not estimated")?;
//! println!("{} = {:?} ± {:?} {}", friction.name, friction.value, friction.std_dev, friction.unit);
//! # let (value, std_dev) = friction.value.zip(friction.std_dev).ok_or("undetermined")?;
//! # assert!((value - 11.7).abs() < 4.0 * std_dev, "{value} ± {std_dev}: the recordings were simulated with 11.7");
//! # Ok(())
//! # }
//! ```
//!
//! # To a diagnosis
//!
//! The same arm with a gear that loses torque on its third axis, of which the model knows nothing: the
//! [diagnosis](diagnose::task) locates the misfit, names the effect, and tests it on a recording that no fit has seen.
//!
//! ```
//! use exid::chain::effect::ids;
//! use exid::diagnose::task as diagnose;
//! use exid::problem::solution::Control;
//! use exid::problem_file::builder::ProblemBuilder;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let problem = ProblemBuilder::in_folder(concat!(env!("CARGO_MANIFEST_DIR"), "/problems/arm6_gearbox"))
//!     .urdf("../arm6/arm6.urdf")
//!     .train("train.csv.gz")
//!     .validation("validation.csv.gz")
//!     .torque_constant([13.1, 13.0, 12.8, 9.2, 9.1, 9.3])
//!     .rotor_inertia([1.40, 1.50, 1.10, 0.35, 0.34, 0.33])
//!     .effects(&["coulomb_friction", "viscous_friction"])
//!     .build(&ids())?;
//! let diagnosis = diagnose::run(&problem, &Control::default(), &|_| ())?.diagnosis;
//! println!("{}", diagnosis.summary);
//! for finding in &diagnosis.findings {
//!     println!("{} of {:?}, p = {:.1e}: {}", finding.effect, finding.joints, finding.p_value, finding.sentence);
//! }
//! # let first = diagnosis.findings.first().ok_or("nothing was found")?;
//! # assert_eq!((first.effect.as_str(), first.joints[0].as_str()), ("transmission_efficiency", "a3"));
//! # Ok(())
//! # }
//! ```
//!
//! # An effect of one's own
//!
//! A law states its torque twice: as numbers with derivatives, for fits, and as a formula, for exported code. A
//! [registered](chain::effect::catalogue::register) one is fitted, simulated, searched for, explained and exported like those
//! of the [vocabulary](chain::effect).
//!
//! ```
//! use exid::chain::effect::catalogue::register;
//! use exid::chain::effect::expression::{Expression, Variable};
//! use exid::chain::effect::{Contribution, Dependence, Effect, ParameterInfo, Power, Samples, TorqueLaw, Unit, ids};
//! use exid::estimate::task as fit;
//! use exid::problem::solution::Control;
//! use exid::problem_file::builder::ProblemBuilder;
//!
//! #[derive(Debug)]
//! struct OilDrag;
//!
//! impl TorqueLaw for OilDrag {
//!     fn add(&self, samples: Samples<'_>, parameters: &[f64], out: &mut Contribution<'_>) {
//!         for (k, v) in samples.velocity.iter().enumerate() {
//!             out.torque[k] += parameters[0] * v;
//!             out.by_parameter[0][k] = *v;
//!         }
//!     }
//!     fn power(&self) -> Power {
//!         Power::Dissipates
//!     }
//!     fn torque(&self) -> Expression {
//!         Expression::parameter(0) * Variable::Velocity
//!     }
//! }
//!
//! static OIL_DRAG: Effect = Effect {
//!     sentence: "The oil in the gear drags in proportion to speed.",
//!     equation: "c·v",
//!     depends_on: &[Dependence::Speed],
//!     ..Effect::at_motor(
//!         "oil_drag",
//!         &[ParameterInfo::linear("c", Unit::TorquePerSpeed, "drag per speed", 1.0).within(0.0, f64::INFINITY)],
//!         &OilDrag,
//!     )
//! };
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! register(&OIL_DRAG)?;
//! let problem = ProblemBuilder::in_folder(concat!(env!("CARGO_MANIFEST_DIR"), "/problems/arm6"))
//!     .urdf("arm6.urdf")
//!     .train("train.csv.gz")
//!     .torque_constant([13.1, 13.0, 12.8, 9.2, 9.1, 9.3])
//!     .rotor_inertia([1.40, 1.50, 1.10, 0.35, 0.34, 0.33])
//!     .effects(&["coulomb_friction", "oil_drag", "torque_offset"])
//!     .build(&ids())?;
//! let fitted = fit::run(&problem, &Control::default(), |_| ())?.fitted;
//! let drag = fitted.estimate.find("a1.oil_drag.c").ok_or("not estimated")?;
//! # let (value, std_dev) = drag.value.zip(drag.std_dev).ok_or("undetermined")?;
//! # assert!((value - 11.7).abs() < 4.0 * std_dev, "{value} ± {std_dev}: the recordings were simulated with 11.7");
//! # Ok(())
//! # }
//! ```
//!
//! Each of these is a program too: `examples/fit_arm.rs`, `examples/diagnose_gear.rs` and `examples/own_effect.rs`.
//!
//! # Features
//!
//! All are on by default. A library that identifies and diagnoses needs none: plain text is read without.
//!
//! - `bags`: recordings of ROS 1 and 2 (`.bag`, `.db3`, `.mcap`).
//! - `compression`: compressed text (gzip, bzip2, Zstandard).
//! - `hdf5`: HDF5 and MATLAB.
//! - `npz`: arrays of NumPy.
//! - `parquet`: Parquet.
//! - `report`: HTML, pictures and text of outcomes, and [`verb`] with its folders of results.
//! - `fleet`: [`fleet`].
//! - `cli`: the program, [`cli`].
//!
//! # Map
//!
//! From the command line down to numbers. A folder's own first lines say what its files are.
//!
//! - [`cli`]: the commands of the program, one file per verb.
//! - [`verb`]: a run of a verb: what it read, what it found, how it ended; for program and Python alike.
//! - [`report`]: a result as HTML page or as text for a terminal, one file per section.
//! - [`export`]: the identified robot as URDF, MJCF, TOML, or code in Rust, C and NumPy.
//! - [`trials`]: tests of the diagnosis: simulated robots with concealed physics.
//! - [`rollout`]: forward simulation of a result beside held-out recordings.
//! - [`fleet`]: many recordings of many robots, and which robots have changed.
//! - [`diagnose`]: which physics the model lacks: residuals, candidates, selection, findings.
//! - [`init`]: a first problem file from robot description and recordings.
//! - [`design`]: excitation: motions that determine parameters best within the robot's limits.
//! - [`estimate`]: from recordings to parameters with their covariance, over possible bodies too.
//! - [`motors`]: torque constants from motions of single joints at constant speed.
//! - [`simulate`]: recordings from a model, with controllers and sensors.
//! - [`check`]: mistakes in robot files and recordings, before anything is fitted.
//! - [`setup`]: from a problem to model, data and priors.
//! - [`chain`]: the model from motion to signal: parameters, their base, predictions with derivatives; all physics beside rigid
//!   bodies is in [`chain::effect`], one file per effect.
//! - [`outcome`]: the data of `result.json` and the results folder.
//! - [`problem_file`]: the keys of problem files: reader, reference, schema, and the builder for programs.
//! - [`mechanism`]: kinematics and dynamics of closed loops.
//! - [`robot`]: kinematic trees from URDF, MJCF and Denavit-Hartenberg tables; Newton-Euler, regressors, inertias.
//! - [`recording`]: from files to motion and signal: formats, columns, timing, periods, derivatives, noise.
//! - [`solve`]: solvers: Levenberg-Marquardt, sequential quadratic programming, interior point, cones.
//! - [`problem`]: the one form of every optimisation: minimise f(x) subject to g(x) in K.
//! - [`linalg`]: dense linear algebra that crates do not offer in this shape.
//! - [`stats`]: distributions, robust scales, tests, change points, false discoveries.
//! - [`fault`]: the shape of errors: place, message, remedy, stable code.
//!
//! A module uses only modules of lower layers, and `tests/architecture` holds it to this table; inside a module neither
//! files nor folders use each other in a circle:
//!
//! | layer | modules |
//! |---|---|
//! | 6 | `cli` |
//! | 5b | `verb` |
//! | 5a | `report`, `export` |
//! | 4d | `trials`, `rollout`, `fleet` |
//! | 4c | `diagnose`, `init` |
//! | 4b | `design`, `estimate`, `motors`, `simulate`, `check` |
//! | 4a | `setup` |
//! | 3 | `chain`, `outcome`, `problem_file` |
//! | 2b | `mechanism` |
//! | 2a | `robot`, `recording`, `solve` |
//! | 1 | `problem` |
//! | 0 | `linalg`, `stats` |
//! | every layer uses | `fault` |

#![deny(missing_docs)]

pub mod fault;

pub mod linalg;
pub mod stats;

pub mod problem;

pub mod recording;
pub mod robot;
pub mod solve;

pub mod mechanism;

pub mod chain;
pub mod outcome;
pub mod problem_file;

pub mod setup;

pub mod check;
pub mod design;
pub mod estimate;
pub mod motors;
pub mod simulate;

pub mod diagnose;
pub mod init;

#[cfg(feature = "fleet")]
pub mod fleet;
pub mod rollout;
pub mod trials;

pub mod export;
#[cfg(feature = "report")]
pub mod report;

#[cfg(feature = "report")]
pub mod verb;

#[cfg(feature = "cli")]
pub mod cli;
