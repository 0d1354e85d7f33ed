//! `exid init` from outside: the problem files that it writes are accepted by `check`, and `fit` is as good with them as with
//! those that were written by hand.

#[path = "../common/mod.rs"]
mod common;
mod foreign;

use common::arm::Arm;
use common::program::says;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// Held-out (or training) errors of a fit as shares of the signal.
fn errors(folder: &Path, problem: &str, further: &[&str]) -> Vec<f64> {
    let out = folder.join("out");
    let out = out.to_str().unwrap();
    let arguments = [&["fit", problem, "--quiet", "--out", out], further].concat();
    says(folder, &arguments, 0);
    let text = fs::read_to_string(folder.join("out/result.json")).unwrap();
    let result: Value = serde_json::from_str(&text).unwrap();
    let joints = result["joints"].as_array().unwrap().iter();
    let error = |joint: &Value| {
        joint["relative_validation"]
            .as_f64()
            .or(joint["relative_train"].as_f64())
    };
    joints.map(|joint| error(joint).unwrap()).collect()
}

fn root(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Drafts, checks and fits; what `init` says.
fn drafted(folder: &Path, files: &[PathBuf]) -> String {
    let files: Vec<&str> = files.iter().map(|f| f.to_str().unwrap()).collect();
    let said = says(folder, &[&["init"], &files[..]].concat(), 0);
    says(folder, &["check", "problem.toml", "--out", "checked"], 0);
    said
}

/// A root mean square error within a twentieth of another, over all joints.
fn assert_as_good(found: &[f64], by_hand: &[f64], what: &str) {
    let size = |errors: &[f64]| errors.iter().map(|e| e * e).sum::<f64>().sqrt();
    assert_eq!(found.len(), by_hand.len(), "{what}");
    assert!(
        size(found) < 1.05 * size(by_hand),
        "{what}: {found:?} {by_hand:?}"
    );
}

#[test]
fn shipped_robots_are_fitted_as_well_as_by_hand() {
    const WLS: &[&str] = &["--set", "fit.estimator=wls"];
    for (folder, robot) in [
        ("arm6", "arm6/arm6.urdf"),
        ("panda_friction", "panda_like/panda_like.mdh.toml"),
        ("puma562_reaction", "puma562_reaction/puma562.urdf"),
    ] {
        let temporary = tempfile::tempdir().unwrap();
        let problems = root("problems");
        let recordings =
            ["train.csv.gz", "validation.csv.gz"].map(|f| problems.join(folder).join(f));
        let files = [vec![problems.join(robot)], recordings.to_vec()].concat();
        let said = drafted(temporary.path(), &files);
        assert!(said.contains("problem file: problem.toml"), "{said}");
        let found = errors(temporary.path(), "problem.toml", WLS);
        let by_hand = problems.join(folder).join("problem.toml");
        match folder {
            // Its hand-written problem is of the force under the base.
            "puma562_reaction" => assert!(found.iter().all(|e| *e < 0.05), "{found:?}"),
            _ => {
                let expected = errors(temporary.path(), by_hand.to_str().unwrap(), WLS);
                assert_as_good(&found, &expected, folder);
            }
        }
    }
}

/// Two axes of this arm stand elsewhere than at zero, which its recordings do not hold: the checks see that something is off.
#[test]
fn assumptions_that_are_wrong_are_said() {
    let temporary = tempfile::tempdir().unwrap();
    let files = ["kr150.urdf", "train.csv.gz"].map(|f| root("problems/kr150_payload").join(f));
    let [robot, recording] = files.each_ref().map(|f| f.to_str().unwrap());
    let said = says(temporary.path(), &["init", robot, recording], 0);
    assert!(
        said.contains("assumed: a1, a2 have no columns and are taken to stand at 0"),
        "{said}"
    );
    // The second axis stands a quarter of a turn off: gravity from another side and another zero of the third axis are the same.
    let seen = ["[position-zero]", "[gravity-direction]"]
        .iter()
        .any(|code| said.contains(code));
    assert!(said.contains("error: ") && seen, "{said}");
}

/// The arm's recordings as another logger writes them: other names, degrees, milliseconds, milliamperes, numbers from zero.
fn foreign(arm: &Arm) {
    for name in ["train.csv", "validation.csv"] {
        let text = fs::read_to_string(arm.path(name)).unwrap();
        let mut lines = vec![
            "zeit,achse_0_winkel,achse_1_winkel,strom_0_mA,strom_1_mA,strom_soll_0,strom_soll_1"
                .to_owned(),
        ];
        for line in text.lines().skip(1) {
            let x: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            let degrees = [x[1], x[2]].map(f64::to_degrees);
            lines.push(format!(
                "{},{:.9},{:.9},{},{},0,0",
                1e3 * x[0],
                degrees[0],
                degrees[1],
                1e3 * x[3],
                1e3 * x[4]
            ));
        }
        arm.write(name, lines.join("\n"));
    }
}

#[test]
fn units_and_names_of_another_logger_are_seen() {
    let (arm, plain) = (Arm::new(20), Arm::new(20));
    foreign(&arm);
    for arm in [&arm, &plain] {
        fs::remove_file(arm.path("problem.toml")).unwrap();
    }
    // Limits that no angle in degrees keeps to.
    let files = ["arm.urdf", "train.csv", "validation.csv"].map(PathBuf::from);
    let said = drafted(arm.folder(), &files);
    for words in [
        "time (zeit) is in ms",
        "as degrees",
        "torque constants are not known",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let draft = fs::read_to_string(arm.path("problem.toml")).unwrap();
    for line in [
        "name = \"arm\"",
        "urdf = \"arm.urdf\"",
        "train = [\"train.csv\"]",
        "validation = [\"validation.csv\"]",
        "time = { column = \"zeit\", unit = \"ms\" }",
        "position = { column = [\"achse_0_winkel\", \"achse_1_winkel\"], unit = \"deg\" }",
        "current = { column = [\"strom_0_mA\", \"strom_1_mA\"], unit = \"mA\" }",
        "# period = 2.0000",
    ] {
        assert!(
            draft.lines().any(|l| l.starts_with(line)),
            "{line}: {draft}"
        );
    }
    // The robot file has the inertials with which the recordings were made, and constants of 12 and 8 N·m/A.
    let constants = draft
        .lines()
        .find_map(|line| line.strip_prefix("torque_constant = [")?.split_once(']'));
    let constants = constants.unwrap().0.split(", ");
    let constants: Vec<f64> = constants.map(|k| k.parse().unwrap()).collect();
    for (constant, truth) in constants.iter().zip([12.0, 8.0]) {
        assert!((constant / truth - 1.0).abs() < 0.05, "{constants:?}");
    }
    drafted(plain.folder(), &files);
    let [found, expected] = [&arm, &plain].map(|a| errors(a.folder(), "problem.toml", &[]));
    assert_as_good(&found, &expected, "foreign");
    assert!(expected.iter().all(|e| *e < 0.2), "{expected:?}");
}

#[test]
fn velocities_tell_units_and_rates() {
    let arm = Arm::new(6);
    fs::remove_file(arm.path("problem.toml")).unwrap();
    let text = fs::read_to_string(arm.path("train.csv")).unwrap();
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect())
        .collect();
    let mut lines = vec!["q1,q2,dq1,dq2,tau1,tau2".to_owned()];
    for k in 1..rows.len() - 1 {
        let velocity = |j: usize| (rows[k + 1][j] - rows[k - 1][j]) / 0.02;
        let row = &rows[k];
        lines.push(format!(
            "{},{},{},{},{},{}",
            row[1],
            row[2],
            velocity(1),
            velocity(2),
            12.0 * row[3],
            8.0 * row[4]
        ));
    }
    arm.write("unstamped.csv", lines.join("\n"));
    let said = drafted(
        arm.folder(),
        &["arm.urdf", "unstamped.csv"].map(PathBuf::from),
    );
    assert!(said.contains("no time stamps"), "{said}");
    let draft = fs::read_to_string(arm.path("problem.toml")).unwrap();
    let rate = draft
        .lines()
        .find_map(|l| l.strip_prefix("rate = "))
        .unwrap();
    let rate: f64 = rate.split_whitespace().next().unwrap().parse().unwrap();
    assert!((rate / 100.0 - 1.0).abs() < 0.02, "{rate}");
    assert!(draft.contains("signal = \"torque\""), "{draft}");
    // Degrees a second beside radians.
    let rpm: Vec<String> = lines
        .iter()
        .enumerate()
        .map(|(k, line)| match k {
            0 => format!("t,{line}"),
            _ => {
                let cells: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
                let [a, b] = [cells[2], cells[3]].map(f64::to_degrees);
                format!(
                    "{},{},{},{a},{b},{},{}",
                    0.01 * k as f64,
                    cells[0],
                    cells[1],
                    cells[4],
                    cells[5]
                )
            }
        })
        .collect();
    arm.write("degrees.csv", rpm.join("\n"));
    says(
        arm.folder(),
        &["init", "arm.urdf", "degrees.csv", "--force"],
        0,
    );
    let draft = fs::read_to_string(arm.path("problem.toml")).unwrap();
    assert!(
        draft.contains("velocity = { column = \"dq{n}\", unit = \"deg/s\" }"),
        "{draft}"
    );
}

/// What names and numbers do not say is said on the command line.
#[test]
fn columns_and_a_rate_may_be_named() {
    let arm = Arm::new(6);
    fs::remove_file(arm.path("problem.toml")).unwrap();
    let text = fs::read_to_string(arm.path("train.csv")).unwrap();
    let (header, rows) = text.split_once('\n').unwrap();
    assert_eq!(header, "t,q1,q2,i1,i2");
    let without_stamps = rows.lines().map(|row| row.split_once(',').unwrap().1);
    let lines: Vec<&str> = ["x1,x2,y1,y2"].into_iter().chain(without_stamps).collect();
    arm.write("plain.csv", lines.join("\n"));
    let files = ["init", "arm.urdf", "plain.csv"];
    let said = says(arm.folder(), &files, 3);
    assert!(said.contains("--column 'position=NAME{n}'"), "{said}");
    let named = ["--column", "position=x{n}", "--column", "current=y{n}"];
    let said = says(arm.folder(), &[&files[..], &named].concat(), 3);
    assert!(said.contains("--rate"), "{said}");
    let all = [&files[..], &named, &["--rate", "100"]].concat();
    says(arm.folder(), &all, 0);
    says(
        arm.folder(),
        &["check", "problem.toml", "--out", "checked"],
        0,
    );
    let draft = fs::read_to_string(arm.path("problem.toml")).unwrap();
    for line in ["position = \"x{n}\"", "current = \"y{n}\"", "rate = 100.0"] {
        assert!(
            draft.lines().any(|l| l.starts_with(line)),
            "{line}: {draft}"
        );
    }
}

#[test]
fn nothing_is_overwritten_and_what_is_missing_is_said() {
    let arm = Arm::new(4);
    let before = fs::read_to_string(arm.path("problem.toml")).unwrap();
    let said = says(arm.folder(), &["init", "arm.urdf", "train.csv"], 2);
    assert!(
        said.contains("problem.toml: exists already; --force replaces it"),
        "{said}"
    );
    assert_eq!(
        fs::read_to_string(arm.path("problem.toml")).unwrap(),
        before
    );
    let printed = says(
        arm.folder(),
        &["init", "--urdf", "arm.urdf", "train.csv", "--out", "-"],
        0,
    );
    assert!(printed.contains("[recordings.columns]"), "{printed}");
    assert_eq!(
        fs::read_to_string(arm.path("problem.toml")).unwrap(),
        before
    );
    let said = says(arm.folder(), &["init", "train.csv", "--out", "p.toml"], 2);
    assert!(said.contains("name its URDF with --urdf"), "{said}");
    let said = says(arm.folder(), &["init", "arm.urdf", "--out", "p.toml"], 2);
    assert!(said.contains("name at least one"), "{said}");
    let said = says(
        arm.folder(),
        &["init", "arm.urdf", "absent.csv", "--out", "p.toml"],
        3,
    );
    assert!(said.contains("absent.csv"), "{said}");
    arm.edit("train.csv", "t,q1,q2", "t,x1,x2");
    let said = says(
        arm.folder(),
        &["init", "arm.urdf", "train.csv", "--out", "p.toml"],
        3,
    );
    assert!(
        said.contains("positions of the joints shoulder, elbow"),
        "{said}"
    );
    assert!(!arm.path("p.toml").exists());
}

#[test]
fn a_draft_may_stand_in_a_folder_that_is_not_there_yet() {
    let arm = Arm::new(4);
    let out = "new/folder/problem.toml";
    says(
        arm.folder(),
        &["init", "arm.urdf", "train.csv", "--out", out],
        0,
    );
    says(arm.folder(), &["check", out, "--out", "checked"], 0);
}

/// Recordings of real robots, as they are.
#[test]
fn real_recordings_are_drafted() {
    let Some(data) = common::data_dir() else {
        return;
    };
    for (robot, recordings) in [
        (
            "ur10e/ur10e.urdf",
            &["ur10e/excitation_30s.csv", "ur10e/excitation_40s.csv"][..],
        ),
        ("lwr4/lwr4.urdf", &["lwr4/measurements_1.npz"]),
    ] {
        let temporary = tempfile::tempdir().unwrap();
        let files = [&[robot], recordings].concat();
        let files: Vec<PathBuf> = files.iter().map(|f| data.join("data").join(f)).collect();
        drafted(temporary.path(), &files);
        let found = errors(
            temporary.path(),
            "problem.toml",
            &["--set", "fit.estimator=wls"],
        );
        assert!(found.iter().all(|e| *e < 0.5), "{robot}: {found:?}");
    }
}

/// A robot with one joint has columns without a number.
#[test]
fn a_single_joint_needs_no_number() {
    let temporary = tempfile::tempdir().unwrap();
    fs::write(
        temporary.path().join("slide.urdf"),
        "<robot name=\"slide\"><link name=\"base\"/><link name=\"carriage\"><inertial><mass value=\"5\"/><inertia ixx=\"1\" \
         ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link><joint name=\"axis\" type=\"prismatic\"><parent \
         link=\"base\"/><child link=\"carriage\"/><axis xyz=\"1 0 0\"/><limit lower=\"-1\" upper=\"1\" velocity=\"9\" \
         effort=\"900\"/></joint></robot>",
    )
    .unwrap();
    let mut lines = vec!["time,position,force".to_owned()];
    for k in 0..3000 {
        let phase = 0.01 * f64::from(k);
        let wave = |f: f64| 0.2 * (f * phase).sin() / f;
        let [q, v, a] = [
            wave(3.0) + wave(7.1),
            0.2 * (3.0 * phase).cos() + 0.2 * (7.1 * phase).cos(),
            -9.0 * wave(3.0) - 7.1 * 7.1 * wave(7.1),
        ];
        lines.push(format!(
            "{phase},{q},{}",
            5.0 * a + 2.0 * v + 3.0 * v.signum()
        ));
    }
    fs::write(temporary.path().join("run.csv"), lines.join("\n")).unwrap();
    drafted(
        temporary.path(),
        &["slide.urdf", "run.csv"].map(PathBuf::from),
    );
    let draft = fs::read_to_string(temporary.path().join("problem.toml")).unwrap();
    for line in ["position = \"position\"", "torque = \"force\""] {
        assert!(draft.lines().any(|l| l == line), "{line}: {draft}");
    }
    let found = errors(temporary.path(), "problem.toml", &[]);
    assert!(found[0] < 0.1, "{found:?}");
    // What drives an amplifier is no current, and the draft says what is made of it.
    let run = temporary.path().join("run.csv");
    let text = fs::read_to_string(&run).unwrap();
    fs::write(&run, text.replace("force", "voltage")).unwrap();
    let said = says(
        temporary.path(),
        &["init", "slide.urdf", "run.csv", "--force"],
        0,
    );
    assert!(
        said.contains("assumed: `voltage` is taken to ask an amplifier"),
        "{said}"
    );
    assert!(said.contains("N·m/V (N/V)"), "{said}");
}
