"""Torques of exported robots in Pinocchio (URDF) and MuJoCo (MJCF), as JSON.

    simulators.py REQUEST.json

The request names the files, gravity in the base frame, the joints, and their motion as
[position, velocity, acceleration] by joint and state. Torques are lists by joint and state, in the order
of the request's joints. MuJoCo's hold armature and damping, and no constraint: neither limits nor dry
friction, whose sizes are given as `frictionloss`.
"""

import json
import sys
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
# The folder holds a file with a library's name: it must not be searched for it.
sys.path = [p for p in sys.path if Path(p or ".").resolve() != FOLDER]

import mujoco
import numpy as np
import pinocchio as pin


def main(path):
    request = json.loads(Path(path).read_text())
    model = mujoco.MjModel.from_xml_path(request["mjcf"])
    joints = [model.joint(name) for name in request["joints"]]
    answer = {
        "pinocchio": of_pinocchio(request),
        "mujoco": of_mujoco(request, model, joints),
        "frictionloss": [float(model.dof_frictionloss[joint.dofadr[0]]) for joint in joints],
    }
    print(json.dumps(answer))


def of_pinocchio(request):
    model = pin.buildModelFromUrdf(request["urdf"])
    model.gravity.linear = np.array(request["gravity"])
    data = model.createData()
    joints = [model.joints[model.getJointId(name)] for name in request["joints"]]
    motion = np.array(request["motion"])
    torques = []
    for state in range(motion.shape[2]):
        at, speed, rate = pin.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
        for joint, (q, dq, ddq) in zip(joints, motion[:, :, state].T):
            value = [q] if joint.nq == 1 else [np.cos(q), np.sin(q)]
            at[joint.idx_q : joint.idx_q + joint.nq] = value
            speed[joint.idx_v], rate[joint.idx_v] = dq, ddq
        torque = pin.rnea(model, data, at, speed, rate)
        torques.append([torque[joint.idx_v] for joint in joints])
    return np.array(torques).T.tolist()


def of_mujoco(request, model, joints):
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data = mujoco.MjData(model)
    motion = np.array(request["motion"])
    torques = []
    for state in range(motion.shape[2]):
        for joint, (q, dq, ddq) in zip(joints, motion[:, :, state].T):
            data.qpos[joint.qposadr[0]] = q
            data.qvel[joint.dofadr[0]] = dq
            data.qacc[joint.dofadr[0]] = ddq
        mujoco.mj_inverse(model, data)
        torques.append([data.qfrc_inverse[joint.dofadr[0]] for joint in joints])
    return np.array(torques).T.tolist()


if __name__ == "__main__":
    main(sys.argv[1])
