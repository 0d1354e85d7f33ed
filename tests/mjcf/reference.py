"""Writes reference.json: joint torques of the models beside this file by MuJoCo's inverse dynamics.

    pip install mujoco numpy
    python3 tests/mjcf/reference.py [folder of public recordings]

Torques are those of the rigid bodies and of armature: constraints, contacts, springs, dampers and friction are switched
off. Free and ball joints stand where the file draws them and have no entry. `go2` is read from the folder of public
recordings with its meshes taken out, which its bodies do not need. Under `followers` joints move as their leaders say,
and their torques are brought to the leaders by virtual work; `arm_hand.urdf` is read by MuJoCo, its floating and planar
joints as fixed ones.
"""

import json
import pathlib
import re
import sys

import mujoco
import numpy as np

HERE = pathlib.Path(__file__).parent
OFF = (
    mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    | mujoco.mjtDisableBit.mjDSBL_SPRING
    | mujoco.mjtDisableBit.mjDSBL_DAMPER
    | mujoco.mjtDisableBit.mjDSBL_ACTUATION
)
SINGLE = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))


def reference(model, rng):
    model.opt.disableflags |= int(OFF)
    data = mujoco.MjData(model)
    joints = [j for j in range(model.njnt) if int(model.jnt_type[j]) in SINGLE]
    position = [model.jnt_qposadr[j] for j in joints]
    speed = [model.jnt_dofadr[j] for j in joints]
    states = []
    for _ in range(4):
        mujoco.mj_resetData(model, data)
        q, dq, ddq = (np.round(rng.uniform(-s, s, len(joints)), 3) for s in (1.5, 2.0, 4.0))
        data.qpos[position], data.qvel[speed], data.qacc[speed] = q, dq, ddq
        mujoco.mj_inverse(model, data)
        states.append({"q": q, "dq": dq, "ddq": ddq, "tau": data.qfrc_inverse[speed].copy()})
    as_lists = [{k: [float(x) for x in v] for k, v in state.items()} for state in states]
    return {
        "joints": [model.joint(j).name for j in joints],
        "states": as_lists,
    }


def followers(model, laws, rng):
    """`laws`: joint -> (leader, multiplier, offset), leaders that move by themselves."""
    model.opt.disableflags |= int(OFF)
    data = mujoco.MjData(model)
    names = [model.joint(j).name for j in range(model.njnt)]
    moving = [name for name in names if name not in laws]
    states = []
    for _ in range(4):
        mujoco.mj_resetData(model, data)
        scale = np.array([0.03 if "finger" in name or name == "left" else 1.0 for name in moving])
        q, dq, ddq = (np.round(scale * rng.uniform(-s, s, len(moving)), 4) for s in (1.0, 2.0, 4.0))
        for name, *state in zip(moving, q, dq, ddq):
            j = model.joint(name)
            data.qpos[j.qposadr[0]], data.qvel[j.dofadr[0]], data.qacc[j.dofadr[0]] = state
        for name, (leader, multiplier, offset) in laws.items():
            j, k = model.joint(name), model.joint(leader)
            data.qpos[j.qposadr[0]] = multiplier * data.qpos[k.qposadr[0]] + offset
            data.qvel[j.dofadr[0]] = multiplier * data.qvel[k.dofadr[0]]
            data.qacc[j.dofadr[0]] = multiplier * data.qacc[k.dofadr[0]]
        mujoco.mj_inverse(model, data)
        torque = {name: float(data.qfrc_inverse[model.joint(name).dofadr[0]]) for name in names}
        for name, (leader, multiplier, _) in laws.items():
            torque[leader] += multiplier * torque[name]
        motion = {"q": q, "dq": dq, "ddq": ddq}
        state = {k: [float(x) for x in v] for k, v in motion.items()}
        states.append(state | {"tau": [torque[name] for name in moving]})
    return {"joints": moving, "states": states}


def main():
    rng = np.random.default_rng(1)
    models = {}
    for path in sorted((HERE / "models").glob("*.xml")):
        model = mujoco.MjModel.from_xml_path(str(path))
        models[path.stem] = reference(model, rng)
    if len(sys.argv) > 1:
        text = (pathlib.Path(sys.argv[1]) / "go2" / "go2.xml").read_text()
        text = re.sub(r"<mesh [^>]*/>|<geom [^>]*mesh=[^>]*/>", "", text)
        models["go2"] = reference(mujoco.MjModel.from_xml_string(text), rng)
    # q_right - 0 = 0.005 + 1.5 (q_left - 0.01)
    coupled = mujoco.MjModel.from_xml_path(str(HERE / "models" / "couplings.xml"))
    text = re.sub(r'"(floating|planar)"', '"fixed"', (HERE / "arm_hand.urdf").read_text())
    text = text.replace("</robot>", '<mujoco><compiler fusestatic="false"/></mujoco></robot>')
    hand = mujoco.MjModel.from_xml_string(text)
    following = {
        "couplings": followers(coupled, {"right": ("left", 1.5, 0.005 - 0.015)}, rng),
        "arm_hand": followers(
            hand,
            {"finger_joint2": ("finger_joint1", 1, 0), "thumb_joint": ("finger_joint1", -30, 0.2)},
            rng,
        ),
    }
    parts = []
    for key, part in (("models", models), ("followers", following)):
        lines = ",\n".join(f"{json.dumps(name)}: {json.dumps(found)}" for name, found in part.items())
        parts.append(f"{json.dumps(key)}: {{\n{lines}\n}}")
    (HERE / "reference.json").write_text("{\n" + ",\n".join(parts) + "\n}\n")


if __name__ == "__main__":
    main()
