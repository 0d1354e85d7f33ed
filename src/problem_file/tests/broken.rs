//! Broken files: each row is a text, the code of its fault, where it lies, and what the message
//! has to say.

use super::{EFFECTS, FULL, parse};
use crate::fault::Fault;
use crate::problem_file::ProblemFile;
use std::path::Path;

/// Text, code, line and column, key, and a part of the message or remedy.
type Case = (
    &'static str,
    &'static str,
    (usize, usize),
    &'static str,
    &'static str,
);

/// Faults of TOML and of the robot: the text is the whole file.
#[rustfmt::skip]
const WHOLE_FILES: &[Case] = &[
    ("name = \n", "syntax", (1, 8), "", "not TOML"),
    ("name = \"a\"\nname = \"b\"", "syntax", (2, 1), "", "duplicate key"),
    ("[robot\nurdf = \"r\"", "syntax", (1, 7), "", "not TOML"),
    ("[robot]\nurdf = r.urdf", "syntax", (2, 8), "", "quotes"),
    ("x = [1, 2", "syntax", (1, 10), "", "not TOML"),
    ("# nothing\n", "missing-key", (0, 0), "robot", "[robot]"),
    ("name = \"a\"", "missing-key", (0, 0), "robot", "[robot]"),
    ("robot = 3", "wrong-type", (1, 9), "robot", "a table"),
    ("[robt]\nurdf = \"r\"", "unknown-key", (1, 2), "robt", "mean \"robot\"?"),
    ("urdf = \"r\"", "unknown-key", (1, 1), "urdf", "a key of [robot]"),
    ("[robot]\n", "missing-key", (1, 2), "robot.urdf", "mechanism"),
    ("[robot]\nurfd = \"r\"", "unknown-key", (2, 1), "robot.urfd", "mean \"urdf\"?"),
    ("[robot]\nurdf = 3", "wrong-type", (2, 8), "robot.urdf", "the number 3"),
    ("[robot]\nurdf = \" \"", "empty-text", (2, 8), "robot.urdf", "empty"),
    ("[robot]\nurdf = \"r\"\nmdh = \"m\"", "conflict", (3, 1), "robot.mdh", "urdf"),
    ("[robot]\nurdf = \"r\"\nmjcf = \"m\"", "conflict", (3, 1), "robot.mjcf", "urdf"),
    ("[robot]\nmjfc = \"r\"", "unknown-key", (2, 1), "robot.mjfc", "mean \"mjcf\"?"),
    ("[robot]\nmechanism = \"h5\"", "unknown-mechanism", (2, 13), "robot.mechanism", "h4"),
    ("[robot]\nurdf = \"r\"\n[robot.h4]\na = 1", "conflict", (3, 8), "robot.h4", "keep one"),
];

/// Lines before the texts of the other cases, which begin in line 3.
const ROBOT: &str = "[robot]\nurdf = \"r.urdf\"\n";

#[rustfmt::skip]
const ROBOT_CASES: &[Case] = &[
    ("gravity = [0, -9.81]", "wrong-length", (3, 11), "robot.gravity", "is 2; give three"),
    ("gravity = 9.81", "wrong-type", (3, 11), "robot.gravity", "the number 9.81"),
    ("gravity = [0, 0, nan]", "not-a-number", (3, 18), "robot.gravity", "NaN"),
    ("gravity = [0, 0, -inf]", "infinite", (3, 18), "robot.gravity", "-inf"),
    ("gravity = [0, 0, 1e999]", "number-too-large", (3, 18), "robot.gravity", "1e999"),
    ("joints = [\"a\", \"a\"]", "duplicate", (3, 16), "robot.joints", "\"a\""),
    ("joints = []", "empty-list", (3, 10), "robot.joints", "at least one"),
    ("joints = \"a1\"", "wrong-type", (3, 10), "robot.joints", "a list of joints"),
    ("joints = [\"a\"]\nlocked = { a = 0 }", "conflict", (4, 16), "robot.locked.a", "locked"),
    ("locked = [\"a\"]", "wrong-type", (3, 10), "robot.locked", "a table"),
    ("inertials = \"knwon\"", "unknown-inertials", (3, 13), "robot.inertials", "\"known\""),
    ("payload = true", "wrong-type", (3, 11), "robot.payload", "found true"),
    ("zero = [1]", "wrong-type", (3, 9), "robot.zero", "a text"),
];

#[rustfmt::skip]
const DRIVE_CASES: &[Case] = &[
    ("[drive]\nratio = [1, 0]", "zero", (4, 13), "drive.ratio", "is 0"),
    ("[drive]\nratio = []", "empty-list", (4, 9), "drive.ratio", "empty"),
    ("[drive]\nratio = [1, \"2\"]", "wrong-type", (4, 13), "drive.ratio", "text \"2\""),
    ("[drive]\nrotor_inertia = [-1]", "negative", (4, 18), "drive.rotor_inertia", "-1"),
    ("[drive]\nrotor_inertia = [0xfffffffffffffffff]", "number-too-large", (4, 18), "drive.rotor_inertia", "beyond"),
    ("[drive]\ntorque_constant = [1]\ncurrent_polynomial = [[0, 1, 0, 0]]", "conflict", (5, 1), "drive.current_polynomial", "torque_constant"),
    ("[drive]\ncurrent_polynomial = [[0, 1, 0]]", "wrong-length", (4, 23), "drive.current_polynomial", "is 3; give four"),
    ("[drive]\ncoupling = [[1, 0], [1]]", "wrong-length", (4, 21), "drive.coupling", "is 1"),
    ("[drive]\ncoupling = [1, 0]", "wrong-type", (4, 13), "drive.coupling", "a row"),
    ("[drive]\neffects = [\"coulomb\"]", "unknown-effect", (4, 12), "drive.effects", "mean \"coulomb_friction\"?"),
    ("[drive]\neffects = [\"time_delay\", \"time_delay\"]", "duplicate", (4, 26), "drive.effects", "twice"),
    ("[drive]\neffects = \"time_delay\"", "wrong-type", (4, 11), "drive.effects", "a list"),
    ("[drive.effects_of]\na5 = [\"viscous\"]", "unknown-effect", (4, 7), "drive.effects_of.a5", "viscous_friction"),
    ("[drive.values]\n\"a.Fc\" = \"x\"", "wrong-type", (4, 10), "drive.values.\"a.Fc\"", "x"),
    ("[drive.values]\na.Fc = 3", "unquoted-name", (4, 1), "drive.values.a", "in quotes"),
    ("[drive.values]\n\"\" = 3", "empty-text", (4, 1), "drive.values.\"\"", "empty"),
];

#[rustfmt::skip]
const RECORDINGS_CASES: &[Case] = &[
    ("[recordings]\n", "missing-key", (3, 2), "recordings.train", "training"),
    ("[recordings]\ntrain = \"a.csv\"", "wrong-type", (4, 9), "recordings.train", "a list"),
    ("[recordings]\ntrain = []", "missing-key", (3, 2), "recordings.train", "training"),
    ("[recordings]\ntrain = [\"a\", \"a\"]", "duplicate", (4, 15), "recordings.train", "twice"),
    ("[recordings]\nloaded = [\"a\"]", "conflict", (4, 11), "recordings.loaded", "payload"),
    ("[recordings]\ntrain = [\"a\"]\nsignal = \"curent\"", "unknown-signal", (5, 10), "recordings.signal", "mean \"current\"? known: current, torque, motor_torque"),
    ("[recordings]\ntrain = [\"a\"]\nposition_side = \"moter\"", "unknown-position-side", (5, 17), "recordings.position_side", "\"motor\""),
    ("[recordings]\ntrain = [\"a\"]\nrate = 0", "not-positive", (5, 8), "recordings.rate", "0"),
    ("[recordings]\ntrain = [\"a\"]\nrate = 2024-01-01", "wrong-type", (5, 8), "recordings.rate", "the date 2024-01-01"),
    ("[recordings]\ntrain = [\"a\"]\nperiod = -12.5", "not-positive", (5, 10), "recordings.period", "-12.5"),
    ("[recordings]\ntrain = [\"a\"]\ncutoff_hz = 5", "unknown-key", (5, 1), "recordings.cutoff_hz", "a key of [recordings.differentiation]"),
    ("[recordings]\ntrain = [\"a\"]\n[recordings.columns]\nwrench = [\"fx\"]", "wrong-length", (6, 10), "recordings.columns.wrench", "is 1; give six"),
    ("[recordings]\ntrain = [\"a\"]\ncolumns.postion = \"q\"", "unknown-key", (5, 9), "recordings.columns.postion", "\"position\""),
    ("[recordings]\ntrain = [\"a\"]\ndifferentiation.method = \"spline\"", "unknown-differentiation-method", (5, 26), "recordings.differentiation.method", "lowpass"),
    ("[recordings]\ntrain = [\"a\"]\ndifferentiation.method = \"fourier\"", "conflict", (5, 26), "recordings.differentiation.method", "period"),
    ("[recordings]\ntrain = [\"a\"]\nrate = 20\ndifferentiation.cutoff_hz = 10", "cutoff-above-nyquist", (6, 29), "recordings.differentiation.cutoff_hz", "half the rate"),
    ("[recordings]\ntrain = [\"a\"]\ndifferentiation.parallel_hz = 0", "not-positive", (5, 31), "recordings.differentiation.parallel_hz", "greater than zero"),
];

#[rustfmt::skip]
const FIT_CASES: &[Case] = &[
    ("[fit]\nestimator = \"WLS\"", "unknown-estimator", (4, 13), "fit.estimator", "mean \"wls\"? known: ols, wls"),
    ("[fit]\nfeasible_by = \"cone\"", "unknown-way-to-feasibility", (4, 15), "fit.feasible_by", "log_cholesky"),
    ("[fit]\nload = \"twice\"", "unknown-way-to-the-load", (4, 8), "fit.load", "difference"),
    ("[fit]\nfeasible_by = \"log_cholesky\"", "conflict", (4, 15), "fit.feasible_by", "leave feasible_by out"),
    ("[fit.prior]\nkind = \"lasso\"", "conflict", (4, 8), "fit.prior.kind", "set estimator"),
    ("[fit.prior]\nkind = \"riemann\"", "unknown-prior-kind", (4, 8), "fit.prior.kind", "entropic"),
    ("[fit.prior]\nkind = \"entropic\"\nstrength = \"held-out\"", "unknown-strength", (5, 12), "fit.prior.strength", "\"held_out\""),
    ("[fit.prior]\nkind = \"entropic\"\nstrength = -1", "not-positive", (5, 12), "fit.prior.strength", "-1"),
    ("[fit.prior]\nstrength = \"noise\"", "missing-key", (3, 6), "fit.prior.kind", "kind ="),
    ("[fit.prior.values]\n\"l.mass\" = 120", "wrong-type", (4, 12), "fit.prior.values.\"l.mass\"", "std_dev = 5.0"),
    ("[fit.prior.values]\nl.mass = { value = 1, std_dev = 1 }", "unquoted-name", (4, 1), "fit.prior.values.l", "in quotes"),
    ("[fit.prior.values]\nm = { value = 120 }", "missing-key", (4, 1), "fit.prior.values.m.std_dev", "trust"),
    ("[fit.prior.values]\nm = { value = 120, std_dev = 0 }", "not-positive", (4, 30), "fit.prior.values.m.std_dev", "0"),
    ("[fit.bounds]\nm = [6.0, 0.5]", "lower-above-upper", (4, 5), "fit.bounds.m", "lower 6 is above upper 0.5"),
    ("[fit.bounds]\nm = [nan, 0.5]", "not-a-number", (4, 6), "fit.bounds.m", "NaN"),
    ("[fit.bounds]\nm = [1]", "wrong-length", (4, 5), "fit.bounds.m", "is 1; give two"),
    ("[fit.compare]\nname = \"x\"", "wrong-type", (3, 6), "fit.compare", "a list of tables"),
    ("[[fit.compare]]\neffects = []", "missing-key", (3, 1), "fit.compare.name", "name"),
    ("[[fit.compare]]\nname = \"x\"\neffects = []\n[[fit.compare]]\nname = \"x\"\neffects = []", "duplicate", (7, 8), "fit.compare.name", "\"x\""),
];

#[rustfmt::skip]
const OTHER_CASES: &[Case] = &[
    ("[design]\nharmonics = 0", "out-of-range", (4, 13), "design.harmonics", "from 1"),
    ("[design]\nharmonics = 5.0", "wrong-type", (4, 13), "design.harmonics", "a whole number"),
    ("[design]\nkind = \"forier\"", "unknown-design-kind", (4, 8), "design.kind", "\"fourier\""),
    ("[design]\ncriterion = \"d-optimal\"", "unknown-criterion", (4, 13), "design.criterion", "mean \"d_optimal\"?"),
    ("[design]\nscaling = \"rows\"", "unknown-scaling", (4, 11), "design.scaling", "whitened"),
    ("[design]\nparameters = \"frictoin\"", "unknown-parameter-group", (4, 14), "design.parameters", "\"friction\""),
    ("[design]\nnoise = [0.5, 0]", "not-positive", (4, 15), "design.noise", "0"),
    ("[design]\nrest_to_rest = \"yes\"", "wrong-type", (4, 16), "design.rest_to_rest", "yes"),
    ("[design.limits]\nvelocity = [-1]", "not-positive", (4, 13), "design.limits.velocity", "-1"),
    ("[design.limits]\nposition_lower = [0, 3]\nposition_upper = 2", "lower-above-upper", (4, 18), "design.limits.position_lower", "lower 3 is above upper 2"),
    ("[[design.workspace.halfspace]]\nframe = \"f\"\nnormal = [0, 0, 0]\noffset = 0", "zero", (5, 10), "design.workspace.halfspace.normal", "0"),
    ("[[design.workspace.clearance]]\nlinks = [\"a\", \"a\"]\ndistance = 0.1", "duplicate", (4, 9), "design.workspace.clearance.links", "\"a\""),
    ("[simulate]\nmode = \"open_loop\"", "unknown-simulation-mode", (4, 8), "simulate.mode", "closed_loop"),
    ("[simulate]\nnoise = [-0.5]", "negative", (4, 10), "simulate.noise", "-0.5"),
    ("[simulate]\nperiods = -3", "out-of-range", (4, 11), "simulate.periods", "-3"),
    ("[simulate]\nnoise_correlation = 1", "out-of-range", (4, 21), "simulate.noise_correlation", "less than 1"),
    ("[simulate]\nencoder_counts = 0", "not-positive", (4, 18), "simulate.encoder_counts", "0"),
    ("[diagnose]\nsignificance = 1", "out-of-range", (4, 16), "diagnose.significance", "less than 1"),
    ("[diagnose]\neffects = \"every\"", "wrong-type", (4, 11), "diagnose.effects", "\"all\""),
    ("[diagnose]\neffects = [\"time_dealy\"]", "unknown-effect", (4, 12), "diagnose.effects", "mean \"time_delay\"?"),
    ("[drive]\n# ü\n\"é\" = 1", "unknown-key", (5, 1), "drive.\"é\"", "known keys: torque_constant"),
    ("[drive]\r\neffects = [ 'é', \"x\"]", "unknown-effect", (4, 13), "drive.effects", "é"),
];

/// What is wrong with the error that a case gives; nothing where it is as stated.
fn complaint(prefix: &str, (text, code, position, key, says): &Case) -> Option<String> {
    let text = format!("{prefix}{text}");
    let Err(error) = parse(&text, &[]) else {
        return Some(format!("no error for\n{text}"));
    };
    let place = error.place();
    let found = (place.line.unwrap_or(0), place.column.unwrap_or(0));
    let as_stated = error.describe().code == *code
        && found == *position
        && place.key.as_deref().unwrap_or("") == *key
        && error.to_string().contains(says)
        && error.to_string().starts_with("folder/p.toml:")
        && !error.describe().remedy.is_empty();
    (!as_stated).then(|| format!("{text}\n{}: {error}", error.describe().code))
}

#[test]
fn broken_files_are_refused_with_code_place_and_remedy() {
    let tables = [
        ROBOT_CASES,
        DRIVE_CASES,
        RECORDINGS_CASES,
        FIT_CASES,
        OTHER_CASES,
    ];
    let whole = WHOLE_FILES.iter().map(|case| complaint("", case));
    let rest = tables
        .into_iter()
        .flatten()
        .map(|case| complaint(ROBOT, case));
    let complaints: Vec<String> = whole.chain(rest).flatten().collect();
    assert!(complaints.is_empty(), "{}", complaints.join("\n\n"));
}

/// A recording or a robot in the place of a problem file is not to be corrected as one.
#[test]
fn other_files_are_told_from_broken_problem_files() {
    let remedy = |path: &str| {
        let read = ProblemFile::parse(Path::new(path), "t,q1\n0,1", &[], EFFECTS);
        read.unwrap_err().describe().remedy
    };
    for other in ["run.csv", "robot.urdf", "run"] {
        assert!(remedy(other).contains("`exid init`"), "{other}");
    }
    assert!(remedy("problem.toml").contains("correct the text"));
}

#[test]
fn names_of_results_folders_stay_in_the_results() {
    for name in ["../up", "a/b", "a\\b", "..", ".", "a\nb"] {
        let text = format!("name = {}\n{ROBOT}", toml::Value::from(name));
        let error = parse(&text, &[]).expect_err(name);
        assert_eq!(error.describe().code, "not-a-folder-name", "{name}");
        assert_eq!(error.place().column, Some(8));
    }
}

#[test]
fn invariant_no_prefix_of_the_complete_file_panics() {
    for (end, _) in FULL.char_indices() {
        // Either result is right; what counts is that there is one, with a place in this file.
        if let Err(error) = parse(&FULL[..end], &[]) {
            let line = error.place().line.unwrap_or(1);
            assert!(line <= FULL[..end].lines().count() + 1, "{error}");
        }
    }
}

#[test]
fn invariant_every_key_of_the_complete_file_is_checked_for_spelling() {
    for (index, line) in FULL.lines().enumerate() {
        let Some((key, value)) = line.split_once(" = ") else {
            continue;
        };
        // Below a table of names every key is right.
        if key.starts_with('"') || key == "a3" || key == "total_mass" {
            continue;
        }
        let mut lines: Vec<String> = FULL.lines().map(str::to_owned).collect();
        lines[index] = format!("{key}x = {value}");
        let error = parse(&lines.join("\n"), &[]).expect_err(line);
        assert_eq!(error.describe().code, "unknown-key", "{line}: {error}");
        assert_eq!(error.place().line, Some(index + 1), "{line}");
        let remedy = error.describe().remedy;
        assert!(remedy.contains(&format!("mean \"{key}\"?")), "{remedy}");
    }
}

/// Places are counted from one to the next: from the start of the line, a million of them take minutes.
#[test]
fn a_list_on_one_line_is_as_long_as_a_file_may_be() {
    let numbers = "1,".repeat(1_000_000);
    let begun = std::time::Instant::now();
    let text = format!("{ROBOT}[drive]\ntorque_constant = [{numbers} true]\n");
    let error = parse(&text, &[]).unwrap_err();
    assert_eq!(error.describe().code, "wrong-type");
    let before = "torque_constant = [".len() + numbers.len() + 1;
    assert_eq!(error.place().column, Some(before + 1));
    assert!(begun.elapsed().as_secs() < 20, "{:?}", begun.elapsed());
}
