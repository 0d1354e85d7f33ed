//! Whole simulations: limits, sensors, concealed effects, the way back through files.

mod aperiodic;
mod dynamics;

use crate::chain::effect;
use crate::fault::Fault;
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::recording::preprocess::prepare;
use crate::recording::settings::InCommon;
use crate::setup::limits::of_joints;
use crate::setup::recording_file::RecordedRobot;
use crate::setup::robot;
use crate::setup::robot::Robot;
use crate::simulate::error::SimulateError;
use crate::simulate::path::Motion;
use crate::simulate::random_path::{RecordingConditions, torques};
use crate::simulate::truth::{DEFAULT_WIDTH, Truth, build};
use crate::simulate::{Simulated, run, write_csv};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

const FRICTION: &str = r#"
[drive]
effects = ["coulomb_friction", "viscous_friction"]
[drive.values]
"joint1.Fc" = 4.0
"joint1.Fv" = 6.0
"joint2.Fc" = 4.0
"joint2.Fv" = 6.0
"joint3.Fc" = 3.0
"joint3.Fv" = 4.0
"joint4.Fc" = 3.0
"joint4.Fv" = 4.0
"joint5.Fc" = 1.0
"joint5.Fv" = 1.0
"joint6.Fc" = 1.0
"joint6.Fv" = 1.0
"joint7.Fc" = 0.5
"joint7.Fv" = 0.5
"#;

/// A robot file of the seven-joint arm of which every link is a body that can exist.
fn arm() -> PathBuf {
    static FOLDER: OnceLock<tempfile::TempDir> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let text = include_str!("../../problems/panda_like/panda_like.mdh.toml");
        let possible = text.replace("[0.0380, -0.0020", "[0.0370, -0.0020");
        std::fs::write(folder.path().join("arm.mdh.toml"), possible).unwrap();
        folder
    });
    folder.path().join("arm.mdh.toml")
}

/// A problem about the seven-joint arm; `drive` is its table, `rest` what comes behind it.
fn panda(drive: &str, rest: &str) -> ProblemFile {
    let head = format!("[robot]\nmdh = {:?}\n", arm());
    parse(Path::new("p.toml"), &format!("{head}{drive}\n{rest}"))
}

fn parse(path: &Path, text: &str) -> ProblemFile {
    ProblemFile::parse(path, text, &[], &effect::ids()).unwrap()
}

fn simulated(problem: &ProblemFile, seed: u64) -> Simulated {
    run(problem, seed, &Control::default()).unwrap()
}

fn truth_of(problem: &ProblemFile) -> (Robot, Truth) {
    let robot = robot::open(problem).unwrap();
    let truth = build(problem, &robot).unwrap();
    (robot, truth)
}

fn code(problem: &ProblemFile) -> &'static str {
    let error: SimulateError = run(problem, 1, &Control::default()).unwrap_err();
    error.describe().code
}

/// Columns of a recording by the start of their names, in order.
fn columns<'a>(simulated: &'a Simulated, recording: usize, prefix: &str) -> Vec<&'a [f64]> {
    let table = &simulated.recordings[recording].table;
    let named = table.header.iter().zip(&table.data);
    named
        .filter(|(name, _)| {
            let number = name.strip_prefix(prefix);
            number.is_some_and(|rest| rest.parse::<usize>().is_ok())
        })
        .map(|(_, column)| column.as_slice())
        .collect()
}

const ALL_MOTION: &str = r#"
[recordings]
train = ["train.csv"]
validation = ["validation.csv"]
signal = "torque"
period = 5.0
[recordings.columns]
position = "q{n}"
velocity = "dq{n}"
acceleration = "ddq{n}"
torque = "tau{n}"
"#;

fn motion_of(simulated: &Simulated, recording: usize) -> Motion {
    ["q", "dq", "ddq"].map(|prefix| {
        let found = columns(simulated, recording, prefix);
        found.into_iter().map(<[f64]>::to_vec).collect()
    })
}

#[test]
fn invariant_random_trajectories_stay_within_four_fifths_of_every_limit() {
    for seed in 0..8 {
        let problem = panda(
            FRICTION,
            &format!("{ALL_MOTION}[design.limits]\nacceleration = 5.0\n[simulate]\nperiods = 1"),
        );
        let simulated = simulated(&problem, seed);
        let robot = robot::open(&problem).unwrap();
        let limits = of_joints(&problem, &robot).unwrap();
        for recording in 0..2 {
            let [q, dq, ddq] = motion_of(&simulated, recording);
            let tau = columns(&simulated, recording, "tau");
            for (j, limit) in limits.iter().enumerate() {
                // Peaks between the instants that are looked at: 1 - cos(π/24) is 0.86 %.
                let share = 0.8 * 1.01;
                let middle = 0.5 * (limit.lower + limit.upper);
                let peak = |x: &[f64]| x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                let away: Vec<f64> = q[j].iter().map(|x| x - middle).collect();
                assert!(peak(&away) <= share * 0.5 * (limit.upper - limit.lower));
                assert!(peak(&dq[j]) <= share * limit.velocity);
                assert!(peak(&ddq[j]) <= share * 5.0);
                assert!(peak(tau[j]) <= share * limit.torque.unwrap());
            }
        }
    }
}

#[test]
fn recovers_known_noise_and_steps_of_the_encoder() {
    let rest = format!(
        "{}[simulate]\nperiods = 4\nnoise = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]\nencoder_counts = 4096",
        ALL_MOTION.replace(
            "signal = \"torque\"",
            "signal = \"torque\"\nposition_side = \"motor\""
        )
    );
    let drive = FRICTION.replace("[drive]", "[drive]\nratio = -50.0");
    let problem = panda(&drive, &rest);
    let result = simulated(&problem, 7);
    let (_, truth) = truth_of(&problem);
    let clean = panda(
        &drive,
        &rest
            .replace("encoder_counts = 4096", "")
            .replace("noise", "#"),
    );
    let exact = simulated(&clean, 7);
    assert_eq!(truth.plant.joints().len(), 7);
    for j in 0..7 {
        let (q, reference) = (columns(&result, 0, "q")[j], columns(&exact, 0, "q")[j]);
        let step = TAU / 4096.0;
        for (a, b) in q.iter().zip(reference) {
            assert!((a / step - (a / step).round()).abs() < 1e-9);
            assert!((a - b).abs() <= 0.5 * step * (1.0 + 1e-9));
        }
        let (a, b) = (columns(&result, 0, "tau")[j], columns(&exact, 0, "tau")[j]);
        let count = a.len() as f64;
        let squares: f64 = a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum();
        let given = 0.1 * (j + 1) as f64;
        // Standard error of a standard deviation: 1/√(2n).
        let bound = 5.0 / (2.0 * count).sqrt();
        assert!(((squares / count).sqrt() / given - 1.0).abs() <= bound);
        let position = &result.positions[j];
        let columns = [position.channel.clone(), position.column.clone()];
        assert_eq!(columns, [format!("tau{}", j + 1), format!("q{}", j + 1)]);
        assert_eq!((position.unit.as_str(), position.factor), ("rad", 1.0));
        let realised = &result.realised_noise[j];
        assert_eq!(realised.channel, format!("tau{}", j + 1));
        assert!((realised.std_dev / given - 1.0).abs() <= bound);
    }
}

#[test]
fn invariant_same_seed_same_bits_for_any_number_of_threads_and_other_seeds_differ() {
    let rest = format!(
        "{ALL_MOTION}[simulate]\nmode = \"closed_loop\"\nperiods = 1\nwarmup_periods = 0\nnoise = 0.1"
    )
    .replace("period = 5.0", "period = 1.0");
    let problem = panda(FRICTION, &rest);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| simulated(&problem, 9))
    };
    let (one, three) = (with(1), with(3));
    assert_eq!(one.recordings, three.recordings);
    assert_ne!(one.recordings[0].table, one.recordings[1].table);
    assert_ne!(one.recordings, simulated(&problem, 10).recordings);
}

/// The plant is told in torques and knows no current; the recorded signal does.
#[test]
fn known_values_of_a_law_of_the_current_are_those_of_the_recorded_signal() {
    let of_current = [("c0", 0.1), ("c1", 10.0), ("c2", 0.3), ("c3", -0.02)];
    let name = |short: &str| format!("joint2.torque_current_nonlinearity.{short}");
    let lines = of_current.map(|(short, value)| format!("\"{}\" = {value}\n", name(short)));
    let listed = "[drive.effects_of]\njoint2 = [\"coulomb_friction\", \"viscous_friction\", \
                  \"torque_current_nonlinearity\"]";
    let constant = FRICTION.replace("[drive]", "[drive]\ntorque_constant = 10.0");
    let drive = format!("{constant}{}{listed}", lines.concat());
    let rest = "[recordings]\nsignal = \"current\"\ntrain = [\"train.csv\"]\nperiod = 5.0\n[simulate]\nperiods = 2";
    let (_, truth) = truth_of(&panda(&drive, rest));
    for (short, value) in of_current {
        let parameter = truth.recorded.find(&name(short)).unwrap();
        assert_eq!(truth.recorded.parameters()[parameter].value, value);
        assert!(truth.parameters.iter().any(|p| p.name == name(short)));
    }
}

#[test]
fn recovers_the_motion_and_the_truth_through_files_and_the_recordings_of_a_problem() {
    let folder = tempfile::tempdir().unwrap();
    let drive = FRICTION.replace("[drive]", "[drive]\ntorque_constant = 10.0\nratio = 40.0");
    let rest = "[recordings]\ntrain = [\"a/train.csv.gz\"]\nvalidation = [\"validation.csv\"]\n\
                position_side = \"motor\"\nperiod = 5.0\n[simulate]\nperiods = 2";
    let text = format!(
        "[robot]\nmdh = {:?}\nlocked = {{ joint7 = 0.4 }}\n{drive}\n{rest}",
        arm()
    );
    let problem = parse(&folder.path().join("p.toml"), &text);
    let result = simulated(&problem, 21);
    for recording in &result.recordings {
        let path = folder.path().join(&recording.name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        write_csv(std::fs::File::create(&path).unwrap(), recording).unwrap();
    }
    let (robot, truth) = truth_of(&problem);
    let table = problem.recordings().unwrap();
    let read = crate::setup::recordings::read_one(table, &robot, &table.train[0].value).unwrap();
    assert_eq!(read.position[3], columns(&result, 0, "q")[3]);
    prepare(read, &crate::setup::preparation::preparation(table)).unwrap();
    let read = crate::setup::recordings::read_all(table, &robot).unwrap();
    let recorded = RecordedRobot {
        table,
        robot: &robot,
        model: &truth.recorded,
    };
    let data = crate::setup::recordings::prepare_all(recorded, read, InCommon::default()).unwrap();
    for prepared in &data.recordings {
        let motion = &prepared.experiment.motion;
        let motion: Motion = [
            motion.position.clone(),
            motion.velocity.clone(),
            motion.acceleration.clone(),
        ];
        let conditions = RecordingConditions {
            rate: prepared.experiment.rate_hz,
            cyclic: true,
            loaded: false,
        };
        let predicted = torques(&truth.recorded, &motion, conditions, &[0, 1, 2, 3, 4, 5]);
        for (j, predicted) in predicted.iter().enumerate() {
            for (a, b) in predicted.iter().zip(prepared.signal(j)) {
                // Without noise only the accelerations' rounding and reversals remain.
                assert!((a - b).abs() <= 1e-6, "{j} {a} {b}");
            }
        }
    }
}

#[test]
fn a_trajectory_that_was_written_is_read_back_as_the_same_motion() {
    let folder = tempfile::tempdir().unwrap();
    let text = |rest: &str| {
        let problem = panda(
            FRICTION,
            &format!("{ALL_MOTION}[simulate]\nperiods = 1\n{rest}"),
        );
        ProblemFile {
            path: folder.path().join("p.toml"),
            ..problem
        }
    };
    let first = simulated(&text(""), 4);
    let path = folder.path().join("motion.csv");
    write_csv(
        std::fs::File::create(&path).unwrap(),
        &first.trajectories[0],
    )
    .unwrap();
    let again = simulated(&text(&format!("trajectory = {:?}", path.display())), 5);
    let (a, b) = (motion_of(&first, 0), motion_of(&again, 1));
    for j in 0..7 {
        for k in 0..a[0][j].len() {
            // Fifteen digits of positions, harmonics differentiated twice.
            assert!((a[2][j][k] - b[2][j][k]).abs() <= 1e-9);
        }
    }
}

#[test]
fn concealed_effects_are_in_the_truth_and_not_in_the_declared_model() {
    let values = |names: &str| panda(FRICTION, &format!("[simulate]\n[simulate.values]\n{names}"));
    let names = "\"joint3.asymmetric_friction.dFc\" = 0.4\n\"joint3.asymmetric_friction.dFv\" = 0.1\n\
                 \"joint6.kinematic_coupling.joint4\" = 0.05\n\"joint2.armature\" = 0.2\n\
                 \"joint7.unmodelled_payload.mass\" = 2.0\n\"payload.com_z\" = 0.1\n\"link3.mass\" = 4.0\n\
                 \"joint1.drive_gain.gain\" = 0.9\n\"joint5.coulomb_friction.w\" = 0.01";
    let (_, truth) = truth_of(&values(names));
    assert!(truth.hidden_load);
    let value = |name: &str| {
        let found = truth.parameters.iter().find(|p| p.name == name);
        found.and_then(|p| p.value).unwrap_or(f64::NAN)
    };
    for (name, expected) in [
        ("joint3.asymmetric_friction.dFc", 0.4),
        ("joint6.kinematic_coupling.joint4", 0.05),
        ("joint2.rotor_inertia.Jm", 0.2),
        ("payload.mass", 2.0),
        ("payload.com_z", 0.1),
        ("payload.inertia_xx", 0.0),
        ("link3.mass", 4.0),
        ("link3.com_y", 0.039),
        ("link3.inertia_zz", 0.013),
        ("joint1.drive_gain.gain", 0.9),
        ("joint5.coulomb_friction.w", 0.01),
        ("joint4.coulomb_friction.w", DEFAULT_WIDTH),
    ] {
        assert!(
            (value(name) - expected).abs() < 1e-14,
            "{name} {}",
            value(name)
        );
    }
    assert!(truth.nominal.payload().is_none() && truth.nominal.is_uncoupled());
    assert!(truth.nominal.find("joint2.rotor_inertia.Jm").is_err());
    assert_eq!(truth.plant.coupling(&truth.plant.values())[(5, 3)], 0.05);
}

#[test]
fn incomplete_and_unknown_truths_are_refused() {
    let values = |names: &str| panda(FRICTION, &format!("[simulate]\n[simulate.values]\n{names}"));
    let listed = "[drive]\neffects = [\"viscous_friction\"]";
    for (problem, expected) in [
        (panda(listed, ""), "needs-value"),
        (values("\"joint9.Fc\" = 1.0"), "unknown-parameter"),
        (
            values("\"joint3.coulomb_friction.Fx\" = 1.0"),
            "unknown-parameter",
        ),
        (values("\"joint3.Fc\" = -1.0"), "parameter-out-of-bounds"),
        (
            values("\"joint3.asymmetric_friction.dFv\" = 1.0"),
            "needs-value",
        ),
        (values("\"payload.com_x\" = 1.0"), "body-needs-mass"),
        (
            panda(
                "",
                "[simulate]\nrate = 10.0\nperiods = 1\n[design]\nperiod = 1.0",
            ),
            "simulation-too-short",
        ),
        (
            panda("", "[design.limits]\ntorque = 0.1"),
            "torque-limit-unreachable",
        ),
        (
            panda(
                FRICTION,
                "[simulate]\nmode = \"closed_loop\"\n[simulate.values]\n\"joint2.coulomb_friction.w\" = 0.0",
            ),
            "friction-without-width",
        ),
    ] {
        assert_eq!(code(&problem), expected);
    }
}

#[test]
fn recordings_stay_inside_the_results_folder_wherever_their_files_are() {
    let name = |written: &str| super::task::inside(written);
    assert_eq!(name("runs/train.csv"), "runs/train.csv");
    assert_eq!(name("../runs/train.csv"), "runs/train.csv");
    let absolute = std::env::temp_dir().join("runs").join("train.csv");
    assert_eq!(name(&absolute.to_string_lossy()), "train.csv");
}

#[test]
fn recordings_with_and_without_the_load_differ_by_the_load() {
    let head = "[robot]\npayload = \"last\"\n";
    let rest = "[recordings]\ntrain = [\"../a.csv\"]\nloaded = [\"b.csv\"]\nsignal = \"base_wrench\"\n\
                [simulate]\nperiods = 1\n[simulate.values]\n\"payload.mass\" = 3.0";
    let problem = parse(
        Path::new("p.toml"),
        &format!("{head}mdh = {:?}\n{FRICTION}{rest}", arm()),
    );
    let result = simulated(&problem, 1);
    let names: Vec<&str> = result.recordings.iter().map(|r| r.name.as_str()).collect();
    assert_eq!(names, ["a.csv", "b.csv"]);
    let mean_force = |recording: usize| {
        let table = &result.recordings[recording].table;
        let at = table.header.iter().position(|h| h == "fz").unwrap();
        table.data[at].iter().sum::<f64>() / table.data[at].len() as f64
    };
    // Over whole periods the base carries the weight alone.
    assert!((mean_force(1) - mean_force(0) - 3.0 * 9.81).abs() < 1e-6);
}
