//! Robots and recordings of others: drafts of `exid init`, beside problem files that somebody wrote who knows the robot.

use crate::common;
use crate::{assert_as_good, drafted, errors};
use std::fs;
use std::path::{Path, PathBuf};

/// A robot of others, recordings of it, and what somebody who knows it writes in a problem file.
struct Foreign {
    robot: &'static str,
    recordings: &'static [&'static str],
    /// Lines of `[robot]`, beside the file.
    of_robot: &'static str,
    /// Lines of `[drive]`, beside the effects.
    of_drive: &'static str,
    /// Lines of `[recordings]`, beside the files.
    of_recordings: &'static str,
    columns: &'static str,
    /// Further tables.
    further: &'static str,
}

/// N·m/A at the joint side, as published.
const UR10E: &str = "torque_constant = [14.87, 13.26, 11.13, 10.62, 11.03, 11.47]";

/// N·m/A at the joint side, as the trials state them.
const BENCH6: &str = "torque_constant = [13.1, 13.0, 12.8, 9.2, 9.1, 9.3]";

const OF_UR10E: Foreign = Foreign {
    robot: "data/ur10e/ur10e.urdf",
    recordings: &[],
    of_robot: "",
    of_drive: UR10E,
    of_recordings: "signal = \"current\"",
    columns: "time = \"t\"\nposition = \"q{n}\"\nvelocity = \"dq{n}\"\ncurrent = \"i{n}\"",
    further: "",
};

const OF_LWR4: Foreign = Foreign {
    robot: "data/lwr4/lwr4.urdf",
    recordings: &[],
    of_robot: "",
    of_drive: "",
    of_recordings: "signal = \"link_torque\"",
    columns: "time = \"t\"\nposition = \"q{n}\"\nvelocity = \"dq{n}\"\ntorque = \"tau{n}\"",
    further: "",
};

const OF_BENCH6: Foreign = Foreign {
    robot: "trials/p01/robot.urdf",
    recordings: &[],
    of_robot: "",
    of_drive: BENCH6,
    of_recordings: "signal = \"current\"",
    columns: "time = \"t\"\nposition = \"q{n}\"\ncurrent = \"i{n}\"",
    further: "",
};

const FOREIGN: &[Foreign] = &[
    Foreign {
        recordings: &[
            "data/ur10e/excitation_30s.csv",
            "data/ur10e/excitation_40s.csv",
        ],
        ..OF_UR10E
    },
    Foreign {
        recordings: &[
            "data/ur10e/excitation_50s.csv",
            "data/ur10e/excitation_30s.csv",
        ],
        ..OF_UR10E
    },
    Foreign {
        recordings: &[
            "data/ur10e/excitation_50s.csv",
            "data/ur10e/point_to_point.csv",
        ],
        ..OF_UR10E
    },
    // One joint moves.
    Foreign {
        recordings: &["data/ur10e/joint2_sweeps.csv"],
        of_robot: "locked = { shoulder_pan_joint = 0.0, elbow_joint = 0.0, wrist_1_joint = -1.5708, wrist_2_joint = 0.0, wrist_3_joint = 0.0 }",
        ..OF_UR10E
    },
    Foreign {
        recordings: &["data/ur10e/joint3_sweeps.csv"],
        of_robot: "locked = { shoulder_pan_joint = 0.0, shoulder_lift_joint = -1.5708, wrist_1_joint = -1.5708, wrist_2_joint = 0.0, wrist_3_joint = 0.0 }",
        ..OF_UR10E
    },
    Foreign {
        recordings: &[
            "data/lwr4/measurements_1.csv",
            "data/lwr4/measurements_2.csv",
        ],
        ..OF_LWR4
    },
    Foreign {
        recordings: &["data/lwr4/measurements_1.npz"],
        of_recordings: "signal = \"link_torque\"\nrate = 200.0",
        columns: "position = \"positions{n}\"\nvelocity = \"velocities{n}\"\ntorque = \"torques{n}\"",
        ..OF_LWR4
    },
    Foreign {
        robot: "data/go2/go2.xml",
        recordings: &["data/go2/held_base.csv"],
        of_robot: "inertials = \"known\"",
        of_drive: "",
        of_recordings: "signal = \"position_command\"",
        columns: "time = \"t\"\nposition = \"q_{joint}\"\ncommand = \"command_{joint}\"",
        further: "[controller]\nkp = \"estimate\"\nkd = \"estimate\"",
    },
    Foreign {
        recordings: &["trials/p01/train.csv", "trials/p01/validation.csv"],
        of_recordings: "signal = \"current\"\nperiod = 12.0",
        ..OF_BENCH6
    },
    // Its currents begin with a transient of 900 A.
    Foreign {
        recordings: &[
            "trials_whole/q01/train.csv",
            "trials_whole/q01/validation.csv",
        ],
        ..OF_BENCH6
    },
];

impl Foreign {
    /// The problem file that somebody writes who knows the robot.
    fn by_hand(&self, data: &Path) -> String {
        let key = match self.robot.ends_with(".xml") {
            true => "mjcf",
            false => "urdf",
        };
        let path = |file: &&str| format!("{:?}", data.join(file));
        let files: Vec<String> = self.recordings.iter().map(path).collect();
        let held_out = match files.get(1) {
            Some(file) => format!("validation = [{file}]\n"),
            None => String::new(),
        };
        format!(
            "name = \"by_hand\"\n[robot]\n{key} = {:?}\n{}\n[drive]\n{}\neffects = [\"coulomb_friction\", \"viscous_friction\", \
             \"torque_offset\", \"rotor_inertia\"]\n[recordings]\ntrain = [{}]\n{held_out}{}\n[recordings.columns]\n{}\n{}\n",
            data.join(self.robot),
            self.of_robot,
            self.of_drive,
            files[0],
            self.of_recordings,
            self.columns,
            self.further
        )
    }
}

/// Recordings of robots of others, as they are: nothing is edited in a draft, and nobody is asked.
#[test]
fn drafts_of_foreign_robots_fit_as_well_as_by_hand() {
    let Some(data) = common::data_dir() else {
        return;
    };
    for foreign in FOREIGN {
        let temporary = tempfile::tempdir().unwrap();
        let files = [&[foreign.robot], foreign.recordings].concat();
        let files: Vec<PathBuf> = files.iter().map(|f| data.join(f)).collect();
        drafted(temporary.path(), &files);
        fs::write(
            temporary.path().join("by_hand.toml"),
            foreign.by_hand(&data),
        )
        .unwrap();
        let found = errors(temporary.path(), "problem.toml", &[]);
        let by_hand = errors(temporary.path(), "by_hand.toml", &[]);
        eprintln!(
            "{:?}: draft {found:.3?}, by hand {by_hand:.3?}",
            foreign.recordings
        );
        assert_as_good(&found, &by_hand, &format!("{:?}", foreign.recordings));
    }
}
