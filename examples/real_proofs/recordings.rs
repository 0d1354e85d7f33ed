//! Recordings in the form in which the proofs take them: halves of a run, and the TX40 joint by joint.

use crate::Done;
use std::f64::consts::FRAC_PI_2;
use std::fs;
use std::path::Path;

/// Reductions of the TX40's motors; motor 6 turns with joint 5 too, by the last.
const REDUCTION: [f64; 6] = [32.0, 32.0, 45.0, -48.0, 45.0, 32.0];

/// Joint positions of the robot file at motor position zero.
const OFFSET: [f64; 6] = [0.0, -FRAC_PI_2, FRAC_PI_2, 0.0, 0.0, 0.0];

/// Writes the first and the second half of both runs.
pub fn write(data: &Path, folder: &Path) -> Done<()> {
    let emps = fs::read_to_string(data.join("emps/tracking.csv"))?;
    halves(&emps, folder, "emps")?;
    let tx40 = fs::read_to_string(data.join("tx40/excitation.csv"))?;
    halves(&joint_by_joint(&tx40)?, folder, "tx40")
}

fn halves(text: &str, folder: &Path, name: &str) -> Done<()> {
    let (header, rows) = text.split_once('\n').ok_or("a recording without rows")?;
    let rows: Vec<&str> = rows.lines().collect();
    let (first, second) = rows.split_at(rows.len() / 2);
    for (half, rows) in [("first", first), ("second", second)] {
        let file = folder.join(format!("{name}_{half}.csv"));
        fs::write(file, format!("{header}\n{}\n", rows.join("\n")))?;
    }
    Ok(())
}

/// Joint positions as encoders of the joints give them, and the torque of each motor at joint scale: what a reader
/// who knows nothing of the wrist takes for joint torques.
fn joint_by_joint(text: &str) -> Done<String> {
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().ok_or("no header")?.split(',').collect();
    let column = |name: String| {
        let found = header.iter().position(|h| *h == name);
        found.ok_or_else(|| format!("no column {name}"))
    };
    let positions = (1..=6)
        .map(|k| column(format!("qm{k}")))
        .collect::<Result<Vec<_>, _>>()?;
    let torques = (1..=6)
        .map(|k| column(format!("taum{k}")))
        .collect::<Result<Vec<_>, _>>()?;
    let mut out = String::from("t,q1,q2,q3,q4,q5,q6,tau1,tau2,tau3,tau4,tau5,tau6\n");
    for line in lines {
        let row: Vec<f64> = line.split(',').map(str::parse).collect::<Result<_, _>>()?;
        let mut q: Vec<f64> = (0..6).map(|k| row[positions[k]] / REDUCTION[k]).collect();
        q[5] -= q[4];
        let joints = (0..6).map(|k| q[k] + OFFSET[k]);
        let motors = (0..6).map(|k| row[torques[k]] * REDUCTION[k]);
        let all = std::iter::once(row[0]).chain(joints).chain(motors);
        let text: Vec<String> = all.map(|x| x.to_string()).collect();
        out.push_str(&text.join(","));
        out.push('\n');
    }
    Ok(out)
}
