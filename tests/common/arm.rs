//! A planar arm of two joints in a folder of its own: robot file, recordings computed from it with known
//! friction, and a problem file that fits them.
//!
//! ```text
//! i = (ID(q, q̇, q̈; π) + Fc·v/(|v| + w) + Fv·v) / k + noise
//! ```

use exid::robot::newton_euler::NewtonEuler;
use exid::robot::urdf;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// N·m/A at the joint side.
const TORQUE_CONSTANT: [f64; 2] = [12.0, 8.0];
/// N·m.
const COULOMB: [f64; 2] = [3.0, 1.2];
/// N·m·s/rad.
const VISCOUS: [f64; 2] = [2.0, 0.8];
/// rad/s.
const WIDTH: f64 = 0.01;
/// Hz.
const RATE: f64 = 100.0;
/// s.
pub const PERIOD: f64 = 2.0;
/// A; half of the width of the noise of every current.
const NOISE: f64 = 0.02;

pub const URDF: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="upper">
    <inertial>
      <origin xyz="0.2 0.01 0.0"/>
      <mass value="4.0"/>
      <inertia ixx="0.02" ixy="0.0" ixz="0.0" iyy="0.06" iyz="0.0" izz="0.06"/>
    </inertial>
  </link>
  <link name="fore">
    <inertial>
      <origin xyz="0.15 0.0 0.02"/>
      <mass value="2.0"/>
      <inertia ixx="0.01" ixy="0.0" ixz="0.0" iyy="0.02" iyz="0.0" izz="0.02"/>
    </inertial>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/>
    <child link="upper"/>
    <axis xyz="0 1 0"/>
    <limit lower="-3.0" upper="3.0" velocity="4.0" effort="100"/>
  </joint>
  <joint name="elbow" type="revolute">
    <origin xyz="0.4 0 0"/>
    <parent link="upper"/>
    <child link="fore"/>
    <axis xyz="0 1 0"/>
    <limit lower="-2.5" upper="2.5" velocity="4.0" effort="50"/>
  </joint>
</robot>
"#;

pub const PROBLEM: &str = r#"name = "arm"

[robot]
urdf = "arm.urdf"

[drive]
torque_constant = [12.0, 8.0]
effects = ["coulomb_friction", "viscous_friction"]

[drive.values]
"shoulder.coulomb_friction.w" = 0.01
"elbow.coulomb_friction.w" = 0.01

[recordings]
train = ["train.csv"]

[recordings.differentiation]
cutoff_hz = 12.0

[fit]
estimator = "wls"
"#;

/// Keeps every sample of the recordings, which repeat their motion.
pub const EVERY_SAMPLE: &str = "recordings.differentiation.method=\"lowpass\"";

/// A folder with `arm.urdf`, `train.csv`, `validation.csv` and `problem.toml`, removed in the end.
pub struct Arm {
    folder: TempDir,
}

impl Arm {
    /// Recordings of so many periods of 2 s at 100 Hz.
    pub fn new(periods: usize) -> Self {
        let arm = Self {
            folder: tempfile::tempdir().unwrap(),
        };
        arm.write("arm.urdf", URDF);
        arm.write("problem.toml", PROBLEM);
        arm.write("train.csv", recording(periods, 1));
        arm.write("validation.csv", recording(periods, 2));
        arm
    }

    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder().join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).unwrap();
    }

    /// Replaces the first `from` of a file.
    pub fn edit(&self, name: &str, from: &str, to: &str) {
        let text = fs::read_to_string(self.path(name)).unwrap();
        assert!(text.contains(from), "{name} has no {from:?}");
        self.write(name, text.replacen(from, to, 1));
    }

    /// `exid fit problem.toml --out out`, in the folder, with further arguments.
    pub fn fit(&self, out: &str, further: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_exid"));
        command
            .current_dir(self.folder())
            .args(["fit", "problem.toml", "--quiet", "--out", out])
            .args(further);
        command
    }
}

/// A recording as CSV. The seed tells the motions and the noise of two recordings apart.
fn recording(periods: usize, seed: u64) -> String {
    let tree = urdf::parse(URDF, Path::new("arm.urdf")).unwrap();
    let parameters = tree.parameters();
    let mut dynamics = NewtonEuler::new(&tree);
    let mut noise = Noise(seed);
    let mut text = String::from("t,q1,q2,i1,i2\n");
    let samples = (periods as f64 * PERIOD * RATE) as usize;
    for k in 0..samples {
        let t = k as f64 / RATE;
        let motion = [0, 1].map(|joint| motion(joint, seed, t));
        let state: [Vec<f64>; 3] = [0, 1, 2].map(|order| motion.map(|m| m[order]).to_vec());
        let mut torque = [0.0; 2];
        let [q, dq, ddq] = [&state[0][..], &state[1][..], &state[2][..]];
        dynamics.torque(&tree, &parameters, [q, dq, ddq], &mut torque);
        let current = [0, 1].map(|j| {
            let friction = COULOMB[j] * dq[j] / (dq[j].abs() + WIDTH) + VISCOUS[j] * dq[j];
            (torque[j] + friction) / TORQUE_CONSTANT[j] + NOISE * noise.next()
        });
        let [first, second] = current;
        writeln!(
            text,
            "{t:.2},{:.9},{:.9},{first:.6},{second:.6}",
            q[0], q[1]
        )
        .unwrap();
    }
    text
}

/// Position, velocity and acceleration of a joint: two harmonics of the period.
fn motion(joint: usize, seed: u64, t: f64) -> [f64; 3] {
    let size = 0.7 + 0.1 * seed as f64;
    let terms = match joint {
        0 => [(1.0, size, 0.3), (3.0, 0.15, 1.1)],
        _ => [(2.0, 0.5 * size, 0.7), (3.0, 0.2, 2.0)],
    };
    let mut out = [0.0; 3];
    for (harmonic, amplitude, phase) in terms {
        let pulsation = TAU * harmonic / PERIOD;
        let angle = pulsation * t + phase;
        out[0] += amplitude * angle.sin();
        out[1] += amplitude * pulsation * angle.cos();
        out[2] -= amplitude * pulsation * pulsation * angle.sin();
    }
    out
}

/// Numbers spread evenly over -1 .. 1: the generator SplitMix64 (Steele, Lea and Flood 2014).
pub struct Noise(pub u64);

impl Noise {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}
