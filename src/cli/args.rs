//! The flags of every verb.

use crate::fleet::shard::Shard;
use crate::init::NamedColumn;
use crate::trials::plan::AtOnce;
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Excite, identify, diagnose: robot models that are right.
#[derive(Parser, Debug)]
#[command(name = "exid", version, about, max_term_width = 100)]
#[command(
    after_help = "Example:\n  exid fit problem.toml\n\n`exid <COMMAND> --help` has examples of each command."
)]
pub struct Arguments {
    #[command(subcommand)]
    pub verb: Verb,
}

#[derive(Subcommand, Debug)]
pub enum Verb {
    /// An excitation trajectory within the robot's limits
    #[command(after_help = DESIGN_EXAMPLES)]
    Design(Run),
    /// Parameters from recordings
    #[command(after_help = FIT_EXAMPLES)]
    Fit(Run),
    /// Where model and recordings differ, what physics is missing, the model with it
    #[command(after_help = DIAGNOSE_EXAMPLES)]
    Diagnose(Run),
    /// Read everything, run nothing: what is wrong with the inputs and what to do
    #[command(after_help = CHECK_EXAMPLES)]
    Check(Look),
    /// Recordings from a model, with noise and quantisation
    #[command(after_help = SIMULATE_EXAMPLES)]
    Simulate(Run),
    /// Random robots with concealed physics: how often the diagnosis is right
    #[command(after_help = TRIALS_EXAMPLES)]
    Trials(Campaign),
    /// Many recordings of many robots: each fitted once, one table, and which robots have changed
    #[command(after_help = FLEET_EXAMPLES)]
    Fleet(FleetRun),
    /// The physics that the tool knows
    #[command(
        after_help = "Examples:\n  exid effects\n  exid effects backlash\n  exid effects --markdown > effects.md && exid effects --plots effects"
    )]
    Effects(Query),
    /// The identified robot as URDF, MJCF, TOML, or code of its inverse dynamics
    #[command(after_help = EXPORT_EXAMPLES)]
    Export(Conversion),
    /// The models of a result simulated forward beside the held-out recording: error of position over horizon
    #[command(after_help = ROLLOUT_EXAMPLES)]
    Rollout(Simulation),
    /// Render the HTML report of a result again
    #[command(after_help = "Example:\n  exid report results/arm6/fit")]
    Report(Rendering),
    /// The same run again, from the problem kept in the result; exit code 1 where the answer differs
    #[command(after_help = REPEAT_EXAMPLES)]
    Repeat(Repetition),
    /// Two results side by side: parameters, errors, findings, and what differs significantly
    #[command(
        after_help = "Examples:\n  exid compare results/arm6/fit results/arm6_after/fit\n  exid compare results/arm6/fit results/arm6_after/fit --all\n  exid compare A/result.json B/result.json --json"
    )]
    Compare(Pair),
    /// A commented problem file from what a robot's description and its recordings show
    #[command(after_help = INIT_EXAMPLES)]
    Init(Drafting),
    /// JSON schema of the problem file, or the reference of its keys
    #[command(after_help = SCHEMA_EXAMPLES)]
    Schema(Schema),
    /// Completions for a shell
    #[command(after_help = COMPLETIONS_EXAMPLES)]
    Completions(Shells),
    /// Pages for `man`, one of the program and one for each verb
    #[command(after_help = "Example:\n  exid man man1 && man -l man1/exid-fit.1")]
    Man(Pages),
}

const DESIGN_EXAMPLES: &str = "Examples:
  exid design problem.toml
  exid design problem.toml --set design.starts=20 --seed 3 --out results/motion
  exid design problem.toml --set design.criterion=condition --set 'design.limits.velocity=[1.0, 1.0, 1.5]'";
const FIT_EXAMPLES: &str = "Examples:
  exid fit problem.toml
  exid fit problem.toml --set fit.estimator=feasible --out results/feasible
  exid fit problem.toml --json | jq '.parameters[] | select(.source == \"data\")'";
const DIAGNOSE_EXAMPLES: &str = "Examples:
  exid diagnose problem.toml
  exid diagnose problem.toml --set 'diagnose.effects=[\"time_delay\", \"backlash\"]'";
const CHECK_EXAMPLES: &str = "Examples:
  exid check problem.toml
  exid check problem.toml --json | jq -r '.findings[].message'
  exid check --columns run.csv session.mcap";
const SIMULATE_EXAMPLES: &str = "Examples:
  exid simulate problem.toml --seed 1
  exid simulate problem.toml --set simulate.trajectory=sweeps --out recordings";
const TRIALS_EXAMPLES: &str = "Examples:
  exid trials --count 100 --seed 1
  exid trials --effects backlash,time_delay --robots arm6 --motion moves
  exid trials --outside --count 300 --seed 1
  exid trials --seed 1 --only 57 --keep trials";
const FLEET_EXAMPLES: &str = "Examples:
  exid fleet nights.csv
  exid fleet nights.parquet --shard 3/16 --items /shared/items    (one of 16 jobs; they can be killed and started again)
  exid fleet nights.parquet --items /shared/items                 (after them: what is left, the table and fleet.html)
  exid fleet nights.csv --set fit.estimator=wls --timeout 60 --json | jq '.look_at[].sentence'

The manifest has a row for each item, or in TOML an [[item]]: robot, recordings (with ; between several), problem, time, and
where wanted type, validation and verb (fit or diagnose). Paths start from its folder. What is done is not done again.";
const EXPORT_EXAMPLES: &str = "Examples:
  exid export results/arm6/fit --to urdf
  exid export results/arm6/fit --to c --out controller
  exid export results/arm6/diagnose --to mujoco --out simulator";
const ROLLOUT_EXAMPLES: &str = "Examples:
  exid rollout results/arm6_gearbox/diagnose
  exid rollout results/arm6/fit --seed 1 --out results/arm6/rollout_1
  exid rollout results/arm6/fit --json | jq '.horizons[2].joints[] | {joint, after: .after.median, noise: .noise.median}'

From starts all over the recordings that were not fitted, at the recorded position and speed, the motion is integrated under the
recorded torques for up to two seconds, by the model before and after, and by the final model under its own torques with the
noise of the signal: what a right model would reach. Where the recordings hold commands, the identified position controllers are
told them and act on the position of the model.";
const REPEAT_EXAMPLES: &str = "Examples:
  exid repeat results/arm6/fit
  exid repeat results/arm6/fit --threads 1 --out again";
const INIT_EXAMPLES: &str = "Examples:
  exid init --urdf arm.urdf run1.csv run2.csv
  exid init arm.urdf session.mcap --out arm/problem.toml
  exid init arm.urdf run.parquet --out - > problem.toml
  exid init arm.urdf trace.csv --column 'position=AIPos.{joint}' --column 'current=MACur.{joint}' --rate 250

What the files do not show is assumed, said, and written into the file as comments.";
const SCHEMA_EXAMPLES: &str = "Examples:
  exid schema > problem.schema.json
  exid schema --markdown > keys.md

A problem file whose first line is `#:schema problem.schema.json` is completed and checked by editors that know Taplo.";
const COMPLETIONS_EXAMPLES: &str = "Examples:
  exid completions bash > ~/.local/share/bash-completion/completions/exid
  exid completions fish > ~/.config/fish/completions/exid.fish";

/// A problem file and the options that all runs share.
#[derive(Args, Debug)]
pub struct Run {
    /// The problem file (TOML)
    pub problem: PathBuf,
    /// Results folder [default: results/<name>/<verb>]
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Override a key of the problem file, for example --set fit.estimator=wls
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// A file with tables [[law]], or a folder of such files, in the place of those that `laws` in the problem file names
    #[arg(long, value_name = "PATH")]
    pub laws: Vec<PathBuf>,
    /// Number of threads [default: all processors]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Seed of everything random
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// Rows of a recording beyond which it is refused [default: 10000000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub max_rows: Option<u64>,
    /// Go on where mistakes in the inputs make every figure meaningless
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub printing: Printing,
}

/// A problem to check, or recordings to look into.
#[derive(Args, Debug)]
pub struct Look {
    #[command(flatten)]
    pub run: Run,
    /// Show what recordings hold, which stand in the place of the problem file: columns, kinds, ranges, rates, empty cells,
    /// and units as they seem
    #[arg(long)]
    pub columns: bool,
    /// Further recordings to look into
    #[arg(requires = "columns", value_name = "FILE")]
    pub further: Vec<PathBuf>,
}

/// What a run prints.
#[derive(Args, Debug, Clone, Copy)]
pub struct Printing {
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
    /// Print the result as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

impl Printing {
    /// Nothing, as of a run within another.
    pub const SILENT: Self = Self {
        quiet: true,
        json: false,
    };
}

/// Trials to make; an earlier result of the same trials is continued.
#[derive(Args, Debug)]
pub struct Campaign {
    /// Effects to conceal, by their ids [default: all]
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    pub effects: Vec<String>,
    /// A file with tables [[law]], or a folder of such files: its laws are concealed and looked for beside the vocabulary
    #[arg(long, value_name = "PATH")]
    pub laws: Option<PathBuf>,
    /// How many effects a trial conceals at once, as 3-8 [default: one, two in some]
    #[arg(long, value_name = "N-M")]
    pub at_once: Option<AtOnce>,
    /// Conceal laws outside the vocabulary, drawn from a grammar, and count the formulas that are proposed for them
    #[arg(long, conflicts_with_all = ["effects", "laws", "at_once"])]
    pub outside: bool,
    /// Kinds of random robots, arm3 to arm7 and slide3 to slide7 [default: all]
    #[arg(long, value_name = "X,Y", value_delimiter = ',')]
    pub robots: Vec<String>,
    /// Kinds of motion: fourier, fourier_unstated (its period is not declared), tones, moves, sweeps [default: all]
    #[arg(long, value_name = "M,N", value_delimiter = ',')]
    pub motion: Vec<String>,
    /// Kinds of noise: white, red [default: both, red in a third of the trials]
    #[arg(long, value_name = "W,R", value_delimiter = ',')]
    pub noise: Vec<String>,
    /// Number of trials; every fifth is a control that conceals nothing
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub count: u64,
    /// Seed of everything random
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// Run these trials alone, by their numbers, and again if an earlier result has them
    #[arg(
        long,
        value_name = "N,N",
        value_delimiter = ',',
        conflicts_with = "count"
    )]
    pub only: Vec<u64>,
    /// Keep the problem, recordings and truth of every trial that is run, in a folder of its number in this one
    #[arg(long, value_name = "FOLDER")]
    pub keep: Option<PathBuf>,
    /// Results folder [default: results/trials/trials; with --only: results/trials/only]
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Keep what every trial came to in a folder, as a fleet does, and take from it what is done
    #[arg(long, value_name = "FOLDER", conflicts_with = "only")]
    pub items: Option<PathBuf>,
    /// Run every N-th trial from the I-th on, and write no result
    #[arg(long, value_name = "I/N", requires = "items")]
    pub shard: Option<Shard>,
    /// Number of threads [default: all processors]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    #[command(flatten)]
    pub printing: Printing,
}

/// A fleet to work through; items that are done are not done again.
#[derive(Args, Debug)]
pub struct FleetRun {
    /// The manifest (.csv, .parquet or .toml)
    pub manifest: PathBuf,
    /// Results folder [default: results/<manifest>/fleet]
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Folder in which the result of every item is kept [default: beside the results folder, its name with .items]
    #[arg(long, value_name = "FOLDER")]
    pub items: Option<PathBuf>,
    /// Work on every N-th item from the I-th on, and write no table
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Rate of false discoveries among the robots that are listed
    #[arg(long, value_name = "Q", default_value_t = 0.05, value_parser = rate)]
    pub rate: f64,
    /// Seconds after which an attempt at an item is over
    #[arg(long, value_name = "SECONDS", default_value_t = 600.0, value_parser = seconds)]
    pub timeout: f64,
    /// Attempts beyond the first at an item whose time is over or that meets a defect
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(0..=100))]
    pub retries: u32,
    /// Try items again that were set aside
    #[arg(long)]
    pub again: bool,
    /// Override a key of every problem file, for example --set fit.estimator=wls
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Number of items that are worked on at a time [default: all processors]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Rows of a recording beyond which it is refused [default: 10000000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub max_rows: Option<u64>,
    #[command(flatten)]
    pub printing: Printing,
}

/// A rate of false discoveries.
fn rate(text: &str) -> Result<f64, String> {
    let rate = text
        .parse::<f64>()
        .ok()
        .filter(|rate| *rate > 0.0 && *rate < 1.0);
    rate.ok_or_else(|| format!("`{text}` is no rate: write a number between 0 and 1"))
}

/// Samples per second.
fn hertz(text: &str) -> Result<f64, String> {
    let rate = text
        .parse::<f64>()
        .ok()
        .filter(|hz| *hz > 0.0 && hz.is_finite());
    rate.ok_or_else(|| format!("`{text}` is no rate: write samples per second"))
}

/// A time that is long enough to begin in.
fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse::<f64>().ok().filter(|s| *s > 0.0 && *s < 1e9);
    seconds.ok_or_else(|| format!("`{text}` is no time: write seconds above 0"))
}

/// What to print of the vocabulary.
#[derive(Args, Debug)]
pub struct Query {
    /// One effect; all of them if absent
    pub id: Option<String>,
    /// A file with tables [[law]], or a folder of such files: its laws beside the vocabulary
    #[arg(long, value_name = "PATH", conflicts_with = "markdown")]
    pub laws: Option<PathBuf>,
    /// Print as JSON
    #[arg(long)]
    pub json: bool,
    /// Print the catalogue as Markdown, with pictures expected in the folder `effects`
    #[arg(long, conflicts_with_all = ["json", "id"])]
    pub markdown: bool,
    /// Draw the law of each effect into this folder, one SVG file each, and print their names
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["json", "markdown"])]
    pub plots: Option<PathBuf>,
}

/// A result to render.
#[derive(Args, Debug)]
pub struct Rendering {
    /// The results folder
    pub result: PathBuf,
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
}

/// A result to make again.
#[derive(Args, Debug)]
pub struct Repetition {
    /// The results folder
    pub result: PathBuf,
    /// Folder for the results of the repetition [default: they are not kept]
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Number of threads [default: all processors]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    #[command(flatten)]
    pub printing: Printing,
}

/// A result whose models are to be simulated forward.
#[derive(Args, Debug)]
pub struct Simulation {
    /// The results folder of `fit` or `diagnose`
    pub result: PathBuf,
    /// Results folder [default: results/<name>/rollout]
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Override a key of the problem that the result keeps, for example --set recordings.differentiation.cutoff_hz=8
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Number of threads [default: all processors]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Seed of the noise
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    #[command(flatten)]
    pub printing: Printing,
}

/// Two results to compare.
#[derive(Args, Debug)]
pub struct Pair {
    /// A results folder
    pub first: PathBuf,
    /// Another one
    pub second: PathBuf,
    /// Show every parameter, joint, finding and name: without it, what differs and the nearest ten of what does not
    #[arg(long)]
    pub all: bool,
    /// Print as JSON
    #[arg(long)]
    pub json: bool,
}

/// What to make a problem file from.
#[derive(Args, Debug)]
pub struct Drafting {
    /// The robot's description (URDF, or .toml of modified Denavit-Hartenberg parameters)
    #[arg(long, value_name = "FILE")]
    pub urdf: Option<PathBuf>,
    /// The robot's model of MuJoCo (MJCF)
    #[arg(long, value_name = "FILE", conflicts_with = "urdf")]
    pub mjcf: Option<PathBuf>,
    /// Recordings; the robot's description may be among them
    pub files: Vec<PathBuf>,
    /// A column whose name does not say what it holds: time, position, velocity, current, torque or command, with a name as under
    /// [recordings.columns], or the names of all joints with commas between them
    #[arg(long = "column", value_name = "KEY=NAME")]
    pub columns: Vec<NamedColumn>,
    /// Samples per second of recordings without time stamps
    #[arg(long, value_name = "HZ", value_parser = hertz)]
    pub rate: Option<f64>,
    /// The problem file to write; - is standard output [default: problem.toml]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Replace a file that is there
    #[arg(long)]
    pub force: bool,
}

/// In which form to say what a problem file may hold.
#[derive(Args, Debug)]
pub struct Schema {
    /// Every key with type, unit, default, meaning and example, as Markdown
    #[arg(long)]
    pub markdown: bool,
}

/// A shell to complete commands in.
#[derive(Args, Debug)]
pub struct Shells {
    pub shell: clap_complete::Shell,
}

/// Where pages for `man` go.
#[derive(Args, Debug)]
pub struct Pages {
    /// The folder, made where it is missing
    pub folder: PathBuf,
}

/// A result to export.
#[derive(Args, Debug)]
pub struct Conversion {
    /// The results folder
    pub result: PathBuf,
    /// The format
    #[arg(long, value_name = "FORMAT")]
    pub to: Target,
    /// Folder to write to [default: the results folder]
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
    /// Print the names of the files and the notes as JSON
    #[arg(long)]
    pub json: bool,
}

/// Formats of exports.
#[derive(ValueEnum, Debug, Clone, Copy)]
pub enum Target {
    /// Robot description; what it has no place for in a side file
    Urdf,
    /// MuJoCo model
    Mjcf,
    /// MuJoCo model with the source of an actuator plugin that has all of the drives
    Mujoco,
    /// Links, drives and load with their intervals
    Toml,
    /// Source of inverse dynamics and drives in Rust
    Rust,
    /// Source of inverse dynamics and drives in C
    C,
    /// The same as a Python module that needs NumPy alone
    Numpy,
}
