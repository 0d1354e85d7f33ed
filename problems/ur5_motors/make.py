"""Writes ur5.urdf from Tables 1 and 2 of the paper, and recordings simulated at the constants of its Table 3.

Gravity torques are Pinocchio's, so that the recordings owe nothing to exid:
    current = (Fc sign(v) + Fv v + G(q)) / k_ct + noise
One ROS 1 bag per joint: the joint goes to and fro at constant speeds, the others stand. On joints 4 to 6 with a
known mass off the axis of joint 6, as in section 3.2.

    pip install numpy pin rosbags && python make.py
"""

from pathlib import Path

import numpy as np
import pinocchio as pin
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_typestore

HERE = Path(__file__).parent
JOINT_STATE = "sensor_msgs/msg/JointState"
PI = np.pi
D = [0.1519, 0, 0, 0.10915, 0.09465, 0.0823]
R = [0, -0.425, -0.39225, 0, 0, 0]
ALPHA = [PI / 2, 0, 0, PI / 2, -PI / 2, 0]
MASS = [3.7, 8.393, 2.33, 1.219, 1.219, 0.1879]
COM = [[0, -0.02561, 0.00193], [0.2125, 0, 0.11336], [0.15, 0, 0.0265], [0, -0.0018, 0.01634], [0, 0.0018, 0.01634], [0, 0, -0.001159]]
K_CT = [12.3, 12.6351, 12.0383, 7.7366, 7.9228, 7.4723]
K_FV = [8.1272, 7.7891, 6.9762, 2.4405, 2.6265, 3.6058]
K_FC = [12.3141, 11.881, 10.7667, 1.8286, 1.2794, 0.8921]
LOAD, LOAD_COM = 1.5, np.array([0.12, 0.0, 0.10])  # kg; m in the frame of link 6
SPEEDS = [[0.25, 0.5, 0.75, 1.0]] * 3 + [[0.3, 0.7, 1.1, 1.5]] * 3
RATE, ACCELERATION, NOISE = 50.0, 4.0, 0.1  # Hz, rad/s², A
RANGE = 1.6  # rad
RUNS = 2
TICK = 2 * PI / 2**18  # rad


def transform(k):
    """The part of A_k behind the joint's rotation: standard Denavit-Hartenberg parameters."""
    c, s = np.cos(ALPHA[k]), np.sin(ALPHA[k])
    return pin.SE3(np.array([[1, 0, 0], [0, c, -s], [0, s, c]]), np.array([R[k], 0, D[k]]))


def text(values):
    return " ".join(f"{v:.12g}" for v in values)


def urdf():
    lines = ["<!-- UR5 of Tables 1 and 2; the frame of a link is that of its joint. Inertias are not in the tables and", "     do not act at constant speed of one joint: spheres of 5 cm. -->", '<robot name="ur5">', '  <link name="base"/>']
    origin = pin.SE3.Identity()
    for k in range(6):
        com = transform(k).act(np.array(COM[k]))
        i = 0.4 * MASS[k] * 0.05**2
        lines += [
            f'  <link name="link{k + 1}">',
            f'    <inertial><origin xyz="{text(com)}"/><mass value="{MASS[k]}"/>',
            f'      <inertia ixx="{i:.6g}" ixy="0" ixz="0" iyy="{i:.6g}" iyz="0" izz="{i:.6g}"/></inertial>',
            "  </link>",
            f'  <joint name="joint{k + 1}" type="revolute">',
            f'    <parent link="{"base" if k == 0 else f"link{k}"}"/><child link="link{k + 1}"/>',
            f'    <origin xyz="{text(origin.translation)}" rpy="{text(pin.rpy.matrixToRpy(origin.rotation))}"/><axis xyz="0 0 1"/>',
            '    <limit lower="-6.283185307179586" upper="6.283185307179586" velocity="3.141592653589793" effort="150"/>',
            "  </joint>",
        ]
        origin = transform(k)
    (HERE / "ur5.urdf").write_text("\n".join(lines + ["</robot>", ""]))


def models():
    bare = pin.buildModelFromUrdf(str(HERE / "ur5.urdf"))
    loaded = bare.copy()
    loaded.appendBodyToJoint(6, pin.Inertia(LOAD, LOAD_COM, 1e-6 * np.eye(3)), pin.SE3.Identity())
    return bare, loaded


def gravity(model, data, q, j):
    return pin.computeGeneralizedGravity(model, data, q)[j]


def pose(model, j, rng):
    """The pose, of a thousand, in which gravity varies most over the range of joint j."""
    data, best = model.createData(), (-1.0, None)
    for _ in range(1000):
        q = rng.uniform(-PI / 2, PI / 2, 6).round(2)
        torques = []
        for s in np.linspace(0, RANGE, 9):
            moved = q.copy()
            moved[j] += s
            torques.append(gravity(model, data, moved, j))
        best = max(best, (float(np.std(torques)), q.tolist()))
    return np.array(best[1])


def sweep(speed):
    """Trapezoidal motion over the range at the rate, then a rest."""
    ramp = speed / ACCELERATION
    total = RANGE / speed + ramp
    t = np.arange(0, total + 0.4, 1 / RATE)
    up = np.minimum(t, ramp)
    down = np.clip(t - (total - ramp), 0, ramp)
    level = np.clip(t - ramp, 0, total - 2 * ramp)
    return np.minimum(ACCELERATION * up**2 / 2 + speed * level + speed * down - ACCELERATION * down**2 / 2, RANGE)


def motion(j):
    path, at = [np.zeros(20)], 0.0
    for _ in range(RUNS):
        for speed in SPEEDS[j]:
            for direction in (1, -1):
                path.append(at + direction * sweep(speed))
                at += direction * RANGE
    return np.concatenate(path)


def write(j, model, rng):
    store = get_typestore(Stores.ROS1_NOETIC)
    types = store.types
    q0, path = pose(model, j, rng), motion(j)
    speed = np.gradient(path) * RATE
    acceleration = np.gradient(speed) * RATE
    data = model.createData()
    file = HERE / f"joint{j + 1}.bag"
    file.unlink(missing_ok=True)
    writer = Writer(file)
    writer.set_compression(Writer.CompressionFormat.BZ2)
    names = [f"joint{k + 1}" for k in range(6)]
    with writer:
        states = writer.add_connection("/joint_states", JOINT_STATE, typestore=store)
        for n in range(len(path)):
            q, dq, ddq = q0.copy(), np.zeros(6), np.zeros(6)
            q[j] += path[n]
            dq[j], ddq[j] = speed[n], acceleration[n]
            torque = pin.rnea(model, data, q, dq, ddq) + K_FC * np.sign(dq) + K_FV * dq
            current = torque / K_CT + NOISE * rng.standard_normal(6)
            stamp = 1_600_000_000 * 10**9 + round(n / RATE * 1e9)
            message = types[JOINT_STATE](
                header=types["std_msgs/msg/Header"](seq=n, stamp=types["builtin_interfaces/msg/Time"](sec=stamp // 10**9, nanosec=stamp % 10**9), frame_id=""),
                name=names,
                position=np.round(q / TICK) * TICK,
                velocity=np.zeros(0),
                effort=np.round(current, 3),
            )
            writer.write(states, stamp, store.serialize_ros1(message, JOINT_STATE))


def main():
    urdf()
    bare, loaded = models()
    rng = np.random.default_rng(4)
    for j in range(6):
        write(j, loaded if j >= 3 else bare, rng)


if __name__ == "__main__":
    main()
