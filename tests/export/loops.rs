//! Closed loops in MuJoCo: at positions and velocities at which they are closed here, they are closed there.

use super::*;
use exid::mechanism::loops::Mechanism;

/// Most by which a loop may give in half a second under the weight of what it carries and no torque, m: a tenth of a millimetre, less
/// than the play of joints.
const GIVES: f64 = 1e-4;

/// Violation of a constraint, m or rad, that is rounding of frames that become quaternions.
const CLOSED: f64 = 1e-9;

const SCRIPT: &str = r#"
import json, sys
import mujoco, numpy as np
request = json.load(sys.stdin)
model = mujoco.MjModel.from_xml_path(request['model'])
data = mujoco.MjData(model)
out = []
for q, dq in request['states']:
    for name, position, speed in zip(request['joints'], q, dq):
        joint = model.joint(name)
        data.qpos[joint.qposadr[0]], data.qvel[joint.dofadr[0]] = position, speed
    mujoco.mj_forward(model, data)
    rows = [i for i in range(data.nefc) if data.efc_type[i] == mujoco.mjtConstraint.mjCNSTR_EQUALITY]
    columns, column = [], np.zeros(data.nefc)
    for unit in np.eye(model.nv):
        mujoco.mj_mulJacVec(model, data, column, unit)
        columns.append(column[rows])
    jacobian = np.array(columns).T
    out.append([float(np.abs(data.efc_pos[rows]).max()), float(np.abs(jacobian @ data.qvel).max()),
                int(np.linalg.matrix_rank(jacobian, tol=1e-6))])
mujoco.mj_resetDataKeyframe(model, data, model.key('home').id)
given = 0.0
for _ in range(int(0.5 / model.opt.timestep)):
    mujoco.mj_step(model, data)
    rows = [i for i in range(data.nefc) if data.efc_type[i] == mujoco.mjtConstraint.mjCNSTR_EQUALITY]
    given = max(given, float(np.abs(data.efc_pos[rows]).max()))
print(json.dumps({'states': out, 'given': given}))
"#;

/// Positions and velocities of all joints near home.
fn states(mechanism: &Mechanism) -> Vec<[Vec<f64>; 2]> {
    let mut rng = generator(3);
    let mut state = || {
        let mut q = mechanism.home().to_vec();
        let mut dq = vec![0.0; q.len()];
        for &joint in mechanism.actuated() {
            q[joint] += symmetric(&mut rng, 0.2);
            dq[joint] = symmetric(&mut rng, 1.0);
        }
        let mut bias = vec![0.0; q.len()];
        mechanism.complete([&mut q, &mut dq, &mut bias]).unwrap();
        [q, dq]
    };
    (0..5).map(|_| state()).collect()
}

#[test]
fn invariant_loops_that_are_closed_here_are_closed_in_mujoco() {
    let Some(python) = drives::python() else {
        return;
    };
    let asked = Command::new(&python).args(["-c", "import mujoco"]).output();
    if !asked.is_ok_and(|output| output.status.success()) {
        common::skip("no Python with MuJoCo: EXID_PYTHON names one");
        return;
    }
    for name in ["parallelogram", "h4_parallel"] {
        let problems = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems");
        let (problem, robot, model) = open(&problems.join(name).join("problem.toml"));
        let values = drawn_values(&model, 4);
        let declared = ModelSpec::without_prior(&problem, &robot).unwrap();
        let machine = setup::machine::record(&declared, &robot, &model, &values, None);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.xml");
        let joints: Vec<&str> = machine.joints.iter().map(|j| j.name.as_str()).collect();
        let mechanism = model.mechanism().unwrap();
        let request = json!({"model": path, "joints": joints, "states": states(mechanism)});
        let written = export(&outcome(machine.clone()), Format::Mjcf).unwrap();
        fs::write(&path, &written.files[0].text).unwrap();
        fs::write(folder.path().join("request.json"), request.to_string()).unwrap();
        let output = Command::new(&python)
            .args(["-c", SCRIPT])
            .stdin(fs::File::open(folder.path().join("request.json")).unwrap())
            .output()
            .unwrap();
        let words = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{name}: {words}");
        let found: Value = serde_json::from_slice(&output.stdout).unwrap();
        let given = found["given"].as_f64().unwrap();
        assert!(given < GIVES, "{name}: {given:e}");
        let states: Vec<(f64, f64, usize)> =
            serde_json::from_value(found["states"].clone()).unwrap();
        for (open, opening, rank) in states {
            println!("{name}: {open:.1e} m, {opening:.1e} m/s, rank {rank}");
            assert!(
                open < CLOSED && opening < CLOSED,
                "{name}: {open:e} {opening:e}"
            );
            assert_eq!(rank, mechanism.passive().len(), "{name}");
        }
    }
}
