//! Problem files that break, by themselves and with the robot that they name.

use crate::bench::Bench;
use crate::{Case, case};

/// Adds a line after the one with this text.
fn after(bench: &Bench, line: &str, added: &str) {
    bench.problem(line, &format!("{line}\n{added}"));
}

/// Adds a key to `[robot]`.
fn robot(bench: &Bench, text: &str) {
    after(bench, "urdf = \"arm.urdf\"", text);
}

/// Adds a key to `[drive]`.
fn drive(bench: &Bench, text: &str) {
    after(bench, "torque_constant = [12.0, 8.0]", text);
}

/// Adds a key to `[recordings]`.
fn recordings(bench: &Bench, text: &str) {
    after(bench, "train = [\"train.csv\"]", text);
}

/// Faults that show in the file alone.
#[rustfmt::skip]
pub const CASES: &[Case] = &[
    case("no problem file", 2, ["none.toml: ", "no such file", "check the path"], |b| b.command(&["fit", "none.toml"])),
    case("a directory for a problem", 2, ["problems: ", "a directory, not a file", "name the problem file"], |b| { b.folder("problems"); b.command(&["fit", "problems"]); }),
    case("a problem file nobody may read", 2, ["problem.toml: ", "no permission", "make the file readable"], |b| b.forbid("problem.toml", 0o000)),
    case("an empty problem file", 2, ["problem.toml: ", "the file is empty", "[robot]"], |b| b.write("problem.toml", "")),
    case("a binary problem file", 2, ["problem.toml:2:6", "0xff", "save the file as UTF-8"], |b| b.write("problem.toml", b"\n# caf\xff\n")),
    case("a gigabyte of problem", 2, ["problem.toml: ", "1073741824 bytes", "recording"], |b| b.sparse("problem.toml", 1 << 30)),
    case("a problem without end", 2, ["/dev/zero: ", "bytes or more", "recording"], |b| b.command(&["fit", "/dev/zero"])),
    case("no TOML", 2, ["problem.toml:4:8", "not TOML", "texts need quotes"], |b| b.problem("\"arm.urdf\"", "arm.urdf")),
    case("a truncated problem file", 2, ["problem.toml:17:1", "not TOML", "correct the text here"], |b| b.problem("= [\"train.csv\"]", "= [\"train.csv\"")),
    case("a key twice", 2, ["problem.toml:5:1", "duplicate key", "once in a table"], |b| robot(b, "urdf = \"arm.urdf\"")),
    case("no robot", 2, ["problem.toml: robot: ", "required and missing", "[robot]"], |b| b.write("problem.toml", "name = \"arm\"\n")),
    case("a misspelled table", 2, ["problem.toml:6:2: drives", "\"drives\"", "mean \"drive\"?"], |b| { b.problem("[drive]", "[drives]"); b.problem("[drive.values]", "[drives.values]"); }),
    case("a misspelled key", 2, ["problem.toml:4:1: robot.urfd", "\"urfd\"", "mean \"urdf\"?"], |b| b.problem("urdf =", "urfd =")),
    case("a key of another table", 2, ["problem.toml:16:1: recordings.cutoff_hz", "\"cutoff_hz\"", "a key of [recordings.differentiation]"], |b| recordings(b, "cutoff_hz = 3")),
    case("two robots", 2, ["problem.toml:5:1: robot.mdh", "urdf", "keep one"], |b| robot(b, "mdh = \"arm.toml\"")),
    case("a text for a number", 2, ["problem.toml:16:8: recordings.rate", "\"100\"", "give a number"], |b| recordings(b, "rate = \"100\"")),
    case("a negative rate", 2, ["problem.toml:16:8: recordings.rate", "-100", "greater than zero"], |b| recordings(b, "rate = -100")),
    case("gravity that is NaN", 2, ["problem.toml:5:18: robot.gravity", "NaN", "give a number"], |b| robot(b, "gravity = [0, 0, nan]")),
    case("gravity in two dimensions", 2, ["problem.toml:5:11: robot.gravity", "is 2", "three numbers"], |b| robot(b, "gravity = [0, -9.81]")),
    case("an unknown effect", 2, ["problem.toml:8:12: drive.effects", "\"coulomb\"", "mean \"coulomb_friction\"?"], |b| b.problem("\"coulomb_friction\"", "\"coulomb\"")),
    case("an unknown effect of a joint", 2, ["problem.toml:23:10: drive.effects_of.elbow", "\"viscous\"", "mean \"viscous_friction\"?"], |b| b.append("[drive.effects_of]\nelbow = [\"viscous\"]\n")),
    case("an effect twice", 2, ["problem.toml:8:32: drive.effects", "\"coulomb_friction\" stands here twice", "remove one"], |b| b.problem("\"viscous_friction\"", "\"coulomb_friction\"")),
    case("an unknown estimator", 2, ["problem.toml:21:13: fit.estimator", "\"least_squares\"", "known: ols, wls"], |b| b.problem("\"wls\"", "\"least_squares\"")),
    case("an unknown signal", 2, ["problem.toml:16:10: recordings.signal", "\"curent\"", "mean \"current\"?"], |b| recordings(b, "signal = \"curent\"")),
    case("a name with dots and no quotes", 2, ["problem.toml:12:1: drive.values.elbow", "found a table", "in quotes"], |b| b.problem("\"elbow.coulomb_friction.w\"", "elbow.coulomb_friction.w")),
    case("a ratio of zero", 2, ["problem.toml:8:13: drive.ratio", "value is 0", "other than zero"], |b| drive(b, "ratio = [1, 0]")),
    case("a coupling with a short row", 2, ["problem.toml:8:21: drive.coupling", "is 1", "give"], |b| drive(b, "coupling = [[1, 0], [0]]")),
    case("a joint twice", 2, ["problem.toml:5:20: robot.joints", "\"elbow\"", "remove one"], |b| robot(b, "joints = [\"elbow\", \"elbow\"]")),
    case("no training", 2, ["problem.toml:14:2: recordings.train", "required and missing", "list the training recordings"], |b| b.problem("train = [\"train.csv\"]", "")),
    case("a recording twice", 2, ["problem.toml:15:23: recordings.train", "\"train.csv\"", "remove one"], |b| b.problem("[\"train.csv\"]", "[\"train.csv\", \"train.csv\"]")),
    case("a load without a payload", 2, ["problem.toml:16:11: recordings.loaded", "the robot has none", "payload = \"last\""], |b| recordings(b, "loaded = [\"validation.csv\"]")),
    case("a Fourier series without a period", 2, ["problem.toml:19:10: recordings.differentiation.method", "\"fourier\" without a period", "recordings.period"], |b| after(b, "cutoff_hz = 12.0", "method = \"fourier\"")),
    case("a cut-off above half of the stated rate", 2, ["problem.toml:19:13: recordings.differentiation.cutoff_hz", "60 Hz", "lower the cut-off"], |b| { recordings(b, "rate = 100"); b.problem("cutoff_hz = 12.0", "cutoff_hz = 60.0"); }),
    case("bounds the wrong way round", 2, ["problem.toml:23:16: fit.bounds.\"upper.mass\"", "lower 6 is above upper 0.5", "lower value first"], |b| b.append("[fit.bounds]\n\"upper.mass\" = [6.0, 0.5]\n")),
    case("a prior without its strength", 2, ["problem.toml:23:1: fit.prior.values.\"elbow.Fc\".std_dev", "required and missing", "trust"], |b| b.append("[fit.prior.values]\n\"elbow.Fc\" = { value = 1.0 }\n")),
    case("a name that is a path", 2, ["problem.toml:1:8: name", "\"../arm\"", "letters, digits"], |b| b.problem("\"arm\"", "\"../arm\"")),
];

/// Faults that show once the robot is known, and in earlier results.
#[rustfmt::skip]
pub const SETUP_CASES: &[Case] = &[
    case("no table of recordings", 2, ["problem.toml: recordings: ", "required and missing", "[recordings]"], |b| { b.problem("[recordings]\ntrain = [\"train.csv\"]\n\n[recordings.differentiation]\ncutoff_hz = 12.0\n", ""); b.problem("torque_constant = [12.0, 8.0]\n", ""); }),
    case("too many torque constants", 2, ["problem.toml:7:19: drive.torque_constant", "is 3", "shoulder, elbow"], |b| b.problem("[12.0, 8.0]", "[12.0, 8.0, 6.0]")),
    case("too few ratios", 2, ["problem.toml:8:9: drive.ratio", "is 1", "shoulder, elbow"], |b| drive(b, "ratio = [32]")),
    case("a coupling for three joints", 2, ["problem.toml:8:12: drive.coupling", "3 rows for 2 joints", "2 rows of 2"], |b| drive(b, "coupling = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]")),
    case("a coupling of rank one", 2, ["problem.toml:8:12: drive.coupling", "cannot be inverted", "independent rows"], |b| drive(b, "coupling = [[1, 2], [2, 4]]")),
    case("an unknown joint locked", 2, ["problem.toml:5:20: robot.locked.wrist", "`wrist`", "shoulder, elbow"], |b| robot(b, "locked = { wrist = 0.0 }")),
    case("every joint locked", 2, ["problem.toml:5:23: robot.locked.shoulder", "every joint is locked", "leave at least one"], |b| robot(b, "locked = { shoulder = 0.0, elbow = 0.0 }")),
    case("a locked joint that a motor moves", 2, ["problem.toml:9:12: drive.coupling", "`elbow` is locked", "identity"], |b| { robot(b, "locked = { elbow = 0.0 }"); drive(b, "coupling = [[1, 0], [1, 1]]"); }),
    case("an unknown joint in the order", 2, ["problem.toml:5:23: robot.joints", "`wrist`", "shoulder, elbow"], |b| robot(b, "joints = [\"shoulder\", \"wrist\"]")),
    case("a joint left out of the order", 2, ["problem.toml:5:10: robot.joints", "leaves out shoulder", "robot.locked"], |b| robot(b, "joints = [\"elbow\"]")),
    case("effects of an unknown joint", 2, ["problem.toml:23:9: drive.effects_of.wrist", "`wrist`", "shoulder, elbow"], |b| b.append("[drive.effects_of]\nwrist = []\n")),
    case("an unknown parameter", 2, ["problem.toml:12:29: drive.values.\"elbw.coulomb_friction.w\"", "`elbw.coulomb_friction.w`", "mean `elbow.coulomb_friction.w`?"], |b| b.problem("\"elbow.c", "\"elbw.c")),
    case("a value out of its bounds", 2, ["problem.toml:12:30: drive.values.\"elbow.coulomb_friction.w\"", "-0.01 lies outside 0", "within the bounds"], |b| b.problem("\"elbow.coulomb_friction.w\" = 0.01", "\"elbow.coulomb_friction.w\" = -0.01")),
    case("a centre of mass without the mass", 2, ["problem.toml:13:16: drive.values.\"fore.com_x\"", "`com_x`", "link's mass too"], |b| after(b, "\"elbow.coulomb_friction.w\" = 0.01", "\"fore.com_x\" = 0.1")),
    case("a parameter to be zero that is none", 2, ["problem.toml:5:9: robot.zero", "`upper.com_w`", "mean `upper.com_"], |b| robot(b, "zero = [\"upper.com_w\"]")),
    case("a bound of an unknown parameter", 2, ["problem.toml:23:15: fit.bounds.\"hand.mass\"", "`hand.mass`", "or link.mass"], |b| b.append("[fit.bounds]\n\"hand.mass\" = [0, 1]\n")),
    case("a prior of an unknown parameter", 2, ["problem.toml:23:1: fit.prior.values.\"elbow.Fstatic\"", "`elbow.Fstatic`", "mean `elbow."], |b| b.append("[fit.prior.values]\n\"elbow.Fstatic\" = { value = 1.0, std_dev = 1.0 }\n")),
    case("no torque constant", 2, ["problem.toml: recordings.signal", "the signal is a current", "drive.torque_constant"], |b| b.problem("torque_constant = [12.0, 8.0]\n", "")),
    case("positions of the motor without a ratio", 2, ["problem.toml:16:17: recordings.position_side", "no ratio", "drive.ratio"], |b| recordings(b, "position_side = \"motor\"")),
    case("torques of the motor without a ratio", 2, ["problem.toml:16:10: recordings.signal", "no ratio", "drive.ratio"], |b| { recordings(b, "signal = \"motor_torque\""); after(b, "signal = \"motor_torque\"", "columns = { position = \"q{n}\", torque = \"i{n}\" }"); }),
    case("a load on no link", 2, ["problem.toml:5:11: robot.payload", "`hand`", "upper, fore"], |b| robot(b, "payload = \"hand\"")),
    case("no earlier result", 2, ["earlier/result.json: ", "No such file", "check the path"], |b| robot(b, "parameters = \"earlier/result.json\"")),
    case("a design with too few samples", 2, ["problem.toml:23:11: design.samples", "12 samples of a period do not show its fastest harmonic", "at least 20"], |b| { b.command(&["design", "problem.toml"]); b.append("[design]\nsamples = 12\n"); }),
    case("an earlier result that is none", 2, ["train.csv: ", "not the result of a run", "a run wrote"], |b| robot(b, "parameters = \"train.csv\"")),
    case("an earlier result cut off", 2, ["old.json: ", "not the result of a run: EOF", "run it again"], |b| { b.write("old.json", "{\"name\": \"arm\", \"verb\": \"fit\""); robot(b, "parameters = \"old.json\""); }),
];
