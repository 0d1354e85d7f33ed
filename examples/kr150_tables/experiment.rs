//! One experiment: a motion in the manner of Table 1, its recording, and the load by each approach.

use crate::Outcome;
use crate::approach::{self, Approach, Load};
use exid::problem::solution::Control;
use exid::problem_file::{Located, Named, ProblemFile};
use exid::robot::random::{generator, symmetric};
use exid::simulate::{self, write_csv};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::fs::{self, File};
use std::path::Path;

/// s.
const PERIOD: f64 = 36.96;

/// Points of a motion's file: more than twice as many as its fastest harmonic needs.
const POINTS: usize = 154;

/// Noise of one sample, N·m, axes 1 to 6.
const NOISE: [f64; 6] = [0.0, 0.0, 40.0, 12.0, 10.0, 8.0];

/// What no model declares: (axis, amplitude in N·m, order per turn of the axis over 2π). The orders are those of
/// the motors, the sizes what Table 3 leaves.
const RIPPLE: [(&str, f64, f64); 4] = [
    ("a3", 126.0, 171.0),
    ("a4", 63.0, 159.0),
    ("a5", 58.0, 147.0),
    ("a6", 56.0, 101.0),
];

/// What an experiment gives.
#[derive(Debug, Serialize)]
pub struct Result {
    pub number: u64,
    /// Mass, centre of mass and the six inertia entries of [`approach::NAMES`].
    pub truth: Load,
    pub approaches: Vec<approach::Result>,
}

/// Simulates an experiment and estimates its load by every approach.
pub fn run(problem: &Path, folder: &Path, number: u64) -> Outcome<Result> {
    let motion = folder.join(format!("motion{number}.csv"));
    let recording = folder.join(format!("experiment{number}.csv"));
    fs::write(&motion, table(&axes(number)))?;
    let overrides = [
        "recordings.signal=torque".to_string(),
        format!("recordings.train=[{:?}]", recording.display().to_string()),
        "recordings.validation=[]".to_string(),
    ];
    let mut simulated = open(
        problem,
        &overrides,
        &[
            format!("simulate.trajectory={:?}", motion.display().to_string()),
            format!("simulate.noise={NOISE:?}"),
            "simulate.mode=inverse".to_string(),
        ],
    )?;
    conceal_ripple(&mut simulated, number);
    let made = simulate::run(&simulated, number, &Control::default())?;
    write_csv(File::create(&recording)?, &made.recordings[0])?;
    let approaches = Approach::ALL
        .into_iter()
        .map(|approach| approach::estimate(problem, &overrides, approach))
        .collect::<Outcome<_>>()?;
    Ok(Result {
        number,
        truth: approach::load_of(&made.truth)?,
        approaches,
    })
}

/// The problem with keys replaced.
pub fn open(problem: &Path, overrides: &[String], further: &[String]) -> Outcome<ProblemFile> {
    let all = [overrides, further].concat();
    Ok(ProblemFile::read(
        problem,
        &all,
        &exid::chain::effect::ids(),
    )?)
}

fn conceal_ripple(problem: &mut ProblemFile, number: u64) {
    let place = problem.simulate.mode.place.clone();
    let mut rng = generator(500 + number);
    for (axis, amplitude, order) in RIPPLE {
        let phase = symmetric(&mut rng, TAU / 2.0);
        for (name, value) in [
            ("amplitude", amplitude),
            ("amplitude2", 0.0),
            ("order", order),
            ("phase", phase),
        ] {
            problem.simulate.values.push(Named {
                name: format!("{axis}.torque_ripple.{name}"),
                value: Located {
                    value,
                    place: place.clone(),
                },
            });
        }
    }
}

/// Offset and (harmonic, sine, cosine) terms of an axis, rad.
type Axis = (f64, Vec<(f64, f64, f64)>);

/// Axes 3 to 6. The first experiment is that of Table 1, b_15 of axis 6 as the problem file says; in the others
/// offsets, phases and fast harmonics are drawn anew, at the amplitudes of Table 1.
fn axes(number: u64) -> [Axis; 4] {
    if number == 0 {
        return [
            (1.57, vec![(25.0, 8.72e-2, -4.62e-3)]),
            (0.0, vec![(1.0, 1.57, 0.0), (18.0, 4.60e-1, -1.76e-2)]),
            (
                0.0,
                vec![(1.0, -8.38e-1, 1.78e-3), (19.0, -2.10e-1, 8.52e-3)],
            ),
            (0.0, vec![(1.0, 0.0, 1.57), (15.0, 2.56e-2, 0.80)]),
        ];
    }
    let mut rng = generator(100 + number);
    let lift = vec![term(&mut rng, (22, 28), 8.72e-2)];
    let wrist = |rng: &mut ChaCha8Rng, (slow, range, fast): (f64, (i32, i32), f64)| -> Axis {
        let offset = symmetric(rng, 0.2);
        (
            offset,
            vec![term(rng, (1, 1), slow), term(rng, range, fast)],
        )
    };
    [
        (1.57 + symmetric(&mut rng, 0.1), lift),
        wrist(&mut rng, (1.57, (16, 20), 0.46)),
        wrist(&mut rng, (0.838, (17, 21), 0.21)),
        wrist(&mut rng, (1.57, (13, 17), 0.80)),
    ]
}

/// A harmonic out of a range, of random phase.
fn term(rng: &mut ChaCha8Rng, (low, high): (i32, i32), amplitude: f64) -> (f64, f64, f64) {
    let span = f64::from(high - low) + 1.0;
    let harmonic = f64::from(low)
        + (0.5 * (1.0 + symmetric(rng, 1.0)) * span)
            .floor()
            .min(span - 1.0);
    let phase = symmetric(rng, TAU / 2.0);
    (harmonic, amplitude * phase.cos(), amplitude * phase.sin())
}

fn table(axes: &[Axis; 4]) -> String {
    let mut text = String::from("t,q_a3,q_a4,q_a5,q_a6\n");
    for k in 0..POINTS {
        let turn = k as f64 / POINTS as f64;
        text.push_str(&(PERIOD * turn).to_string());
        for (offset, terms) in axes {
            let sum: f64 = terms
                .iter()
                .map(|(h, a, b)| a * (TAU * h * turn).sin() + b * (TAU * h * turn).cos())
                .sum();
            // Writing into a text cannot fail.
            let _ = write!(text, ",{}", offset + sum);
        }
        text.push('\n');
    }
    text
}
