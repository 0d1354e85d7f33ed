//! The flags of every verb.

use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Excite, identify, diagnose: robot models that are right.
#[derive(Parser, Debug)]
#[command(name = "exid", version, about, max_term_width = 100)]
pub struct Arguments {
    #[command(subcommand)]
    pub verb: Verb,
}

#[derive(Subcommand, Debug)]
pub enum Verb {
    /// An excitation trajectory within the robot's limits
    Design(Run),
    /// Parameters from recordings
    Fit(Run),
    /// Where model and recordings differ, what physics is missing, the model with it
    Diagnose(Run),
    /// Read everything, run nothing: what is wrong with the inputs and what to do
    Check(Look),
    /// Recordings from a model, with noise and quantisation
    Simulate(Run),
    /// Random robots with concealed physics: how often the diagnosis is right
    Trials(Campaign),
    /// The physics that the tool knows
    Effects(Query),
    /// The identified robot as URDF, MJCF, TOML, or code of its inverse dynamics
    Export(Conversion),
    /// Render the HTML report of a result again
    Report(Rendering),
}

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

/// Trials to make; an earlier result of the same trials is continued.
#[derive(Args, Debug)]
pub struct Campaign {
    /// Effects to conceal, by their ids [default: all]
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    pub effects: Vec<String>,
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
    /// Number of threads [default: all processors]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    #[command(flatten)]
    pub printing: Printing,
}

/// What to print of the vocabulary.
#[derive(Args, Debug)]
pub struct Query {
    /// One effect; all of them if absent
    pub id: Option<String>,
    /// Print as JSON
    #[arg(long)]
    pub json: bool,
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
    /// Links, drives and load with their intervals
    Toml,
    /// Source of the inverse dynamics in Rust
    Rust,
    /// Source of the inverse dynamics in C
    C,
}
