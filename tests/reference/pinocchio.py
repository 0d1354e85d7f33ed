"""Reference values of robot dynamics from Pinocchio, as JSON.

    pinocchio.py                        writes pinocchio.json for the robots of the repository
    pinocchio.py --compare FILE...      prints the same for other URDF files

Needs Python 3.11, numpy and the package `pin`. Lists are in Pinocchio's order of joints, which is
given by name; readers match by name. Rows of a matrix are lists. Units are SI.
"""

import json
import sys
import tomllib
import xml.etree.ElementTree as ElementTree
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
ROOT = FOLDER.parent.parent
# This file has the library's name: its own folder must not be searched for it.
sys.path = [p for p in sys.path if Path(p or ".").resolve() != FOLDER]

import numpy as np
import pinocchio as pin

STATES = 3
SEED = 20240607
STANDARD_GRAVITY = [0.0, 0.0, -9.81]
# Of robots of the repository: a base that stands in no special direction.
TILTED_GRAVITY = [1.5, -4.0, -8.75]
# Largest difference between two ways to the base reaction, relative to its largest entry.
AGREEMENT = 1e-11
# Digits that are kept: two more than the tests ask for.
DIGITS = 13


def main(arguments):
    if arguments[:1] == ["--compare"]:
        robots = [reference(Path(file), STANDARD_GRAVITY) for file in arguments[1:]]
        print(json.dumps(document(robots)))
    elif arguments:
        sys.exit(__doc__)
    else:
        files = [ROOT / "problems/panda_like/panda_like.mdh.toml"]
        files += sorted((FOLDER / "robots").glob("*.urdf"))
        robots = [reference(file, TILTED_GRAVITY) for file in files]
        text = json.dumps(document(robots), separators=(",", ":"))
        (FOLDER / "pinocchio.json").write_text(text.replace('{"file"', '\n{"file"') + "\n")


def document(robots):
    return {"generator": "pinocchio", "version": pin.__version__, "robots": robots}


def reference(file, gravity):
    """All values of one robot: of the first state with regressors and placements of the links."""
    build = mdh_model if file.suffix == ".toml" else urdf_model
    model, links = build(file, None)
    carried, _ = build(file, pin.JointModelFreeFlyer())
    # What does not move against the base is no load of the first joint.
    carried.inertias[1] = pin.Inertia.Zero()
    for each in (model, carried):
        each.gravity.linear = np.array(gravity)
    draw = np.random.default_rng(SEED)
    states = []
    for k in range(STATES):
        # Few digits, so that the file holds the very state that was evaluated.
        state = [draw.uniform(-span, span, model.nv).round(3) for span in (3.0, 2.0, 8.0)]
        states.append(dynamics(model, state) | base_reaction(model, carried, state))
        if k == 0:
            states[0] |= regressors(model, carried, state) | placements(model, links, state)
    return {
        "file": str(file.relative_to(ROOT) if file.is_relative_to(ROOT) else file),
        "gravity": gravity,
        "joints": list(model.names)[1:],
        "links": links,
        "states": states,
    }


def urdf_model(file, root):
    model = pin.buildModelFromUrdf(str(file), *([root] if root else []))
    joints = ElementTree.parse(file).getroot().findall("joint")
    child = {joint.get("name"): joint.find("child").get("link") for joint in joints}
    return model, [child.get(name) for name in list(model.names)[1:]]


def mdh_model(file, root):
    """A chain from modified Denavit-Hartenberg parameters: Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d)."""
    model, parent = pin.Model(), 0
    if root:
        parent = model.addJoint(0, root, pin.SE3.Identity(), "root")
    rows = tomllib.loads(file.read_text())["joint"]
    for row in rows:
        tilt = pin.utils.rotate("x", row.get("alpha", 0.0))
        turn = pin.utils.rotate("z", row.get("theta", 0.0))
        first = pin.SE3(tilt, tilt @ np.array([row.get("a", 0.0), 0.0, 0.0]))
        second = pin.SE3(turn, np.array([0.0, 0.0, row.get("d", 0.0)]))
        slides = row.get("type") == "prismatic"
        kind = pin.JointModelPZ() if slides else pin.JointModelRZ()
        parent = model.addJoint(parent, kind, first * second, row["name"])
        xx, xy, xz, yy, yz, zz = row["inertia"]
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        body = pin.Inertia(row["mass"], np.array(row["com"]), tensor)
        model.appendBodyToJoint(parent, body, pin.SE3.Identity())
    return model, [f"link{k + 1}" for k in range(len(rows))]


def positions(model, q):
    """Pinocchio's coordinates of the joints' positions: cosine and sine for a continuous joint."""
    coordinates = pin.neutral(model)
    for joint in list(model.joints)[1:]:
        if joint.nv == 1:
            at = q[joint.idx_v]
            value = [at] if joint.nq == 1 else [np.cos(at), np.sin(at)]
            coordinates[joint.idx_q : joint.idx_q + joint.nq] = value
    return coordinates


def dynamics(model, state):
    q, dq, ddq = state
    data, at = model.createData(), positions(model, q)
    torque = pin.rnea(model, data, at, dq, ddq).copy()
    # Matrices of one joint come back as vectors.
    derivatives = pin.computeRNEADerivatives(model, data, at, dq, ddq)
    by_position, by_velocity, mass = (np.reshape(m, (model.nv, model.nv)) for m in derivatives)
    mass = np.triu(mass) + np.triu(mass, 1).T
    return {
        "q": numbers(q),
        "dq": numbers(dq),
        "ddq": numbers(ddq),
        "torque": numbers(torque),
        "mass": numbers(mass),
        "torque_by_position": numbers(by_position),
        "torque_by_velocity": numbers(by_velocity),
    }


def on_carriage(carried, state):
    """The state of the robot on a free base that rests at the origin; speeds of the base come first."""
    q, dq, ddq = (np.concatenate([np.zeros(6), part]) for part in state)
    return positions(carried, q), dq, ddq


def base_reaction(model, carried, state):
    """Force and moment (about the base origin) on the moving links, from the torque of a free base;
    the same from the rate of momentum minus gravity has to agree."""
    reaction = pin.rnea(carried, carried.createData(), *on_carriage(carried, state))[:6]
    q, dq, ddq = state
    data, at = model.createData(), positions(model, q)
    pin.computeCentroidalMomentumTimeVariation(model, data, at, dq, ddq)
    centre, mass = pin.centerOfMass(model, data, at), pin.computeTotalMass(model)
    force = data.dhg.linear - mass * model.gravity.linear
    moment = data.dhg.angular + np.cross(centre, force)
    difference = np.abs(np.concatenate([force, moment]) - reaction).max()
    assert difference <= AGREEMENT * np.abs(reaction).max(), (model.name, difference)
    return {"base_reaction": numbers(reaction)}


def regressors(model, carried, state):
    """Columns: ten for each joint's link, in the order of `toDynamicParameters`."""
    q, dq, ddq = state
    of_torque = pin.computeJointTorqueRegressor(model, model.createData(), positions(model, q), dq, ddq)
    at = on_carriage(carried, state)
    of_base = pin.computeJointTorqueRegressor(carried, carried.createData(), *at)[:6, 10:]
    bodies = [inertia.toDynamicParameters() for inertia in list(model.inertias)[1:]]
    return {
        "parameters": numbers(np.concatenate(bodies)),
        "torque_regressor": numbers(np.reshape(of_torque, (model.nv, -1))),
        "base_regressor": numbers(of_base),
    }


def placements(model, links, state):
    """Position and rotation (row after row) of each link in the base frame, by name."""
    data = model.createData()
    pin.framesForwardKinematics(model, data, positions(model, state[0]))
    poses = dict(zip(links, list(data.oMi)[1:]))
    for frame, pose in zip(model.frames, data.oMf):
        if frame.type == pin.FrameType.BODY and frame.name != "universe":
            poses[frame.name] = pose
    return {
        "placements": {
            name: numbers(np.concatenate([pose.translation, pose.rotation.ravel()]))
            for name, pose in sorted(poses.items())
        }
    }


def numbers(array):
    """Nested lists of decimal numbers, zeros short."""
    if np.ndim(array) == 0:
        return float(f"{array:.{DIGITS}g}") or 0
    return [numbers(entry) for entry in array]


if __name__ == "__main__":
    main(sys.argv[1:])
