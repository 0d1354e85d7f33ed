"""Writes recordings of the parallelogram, with Pinocchio on the cut tree and the linkage's own closed form.

In a parallelogram the angles of the passive joints are differences of those of the motors,
    elbow = lift − shoulder,   coupling = shoulder − lift,
and so torques come to the motors by a constant matrix, which owes nothing to exid.

    pip install numpy pin && python make.py
"""

import gzip
from pathlib import Path

import numpy as np
import pinocchio as pin

HERE = Path(__file__).parent
RATE, TICK, NOISE = 200.0, 2 * np.pi / 2**18, 0.5  # Hz, rad, N·m
COULOMB, VISCOUS = np.array([6.0, 4.0]), np.array([9.0, 7.0])  # N·m, N·m·s/rad
MODEL = pin.buildModelFromUrdf(str(HERE / "parallelogram.urdf"))
DATA = MODEL.createData()
# Rows in the order of Pinocchio's joints, columns shoulder and lift.
ROWS = {"shoulder": [1, 0], "elbow": [-1, 1], "lift": [0, 1], "coupling": [1, -1]}
MAP = np.array([ROWS[name] for name in list(MODEL.names)[1:]], dtype=float)


def motion(rng, t):
    """Sines of both motors with their derivatives."""
    q, dq, ddq = np.zeros((3, len(t), 2))
    for joint in range(2):
        for f, a in zip(rng.uniform(0.1, 1.1, 6), rng.uniform(0.03, 0.16, 6)):
            phase, w = rng.uniform(0, 6.28), 2 * np.pi * f
            q[:, joint] += a * np.sin(w * t + phase)
            dq[:, joint] += a * w * np.cos(w * t + phase)
            ddq[:, joint] -= a * w * w * np.sin(w * t + phase)
    return q, dq, ddq


def record(name, seed, seconds):
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds * RATE)) / RATE
    q, dq, ddq = motion(rng, t)
    open_tree = [pin.rnea(MODEL, DATA, MAP @ a, MAP @ b, MAP @ c) for a, b, c in zip(q, dq, ddq)]
    torque = np.array(open_tree) @ MAP + COULOMB * np.sign(dq) + VISCOUS * dq
    torque += NOISE * rng.standard_normal(torque.shape)
    q = np.round(q / TICK) * TICK
    header = "t,q_shoulder,q_lift,tau_shoulder,tau_lift"
    rows = [f"{a:.3f},{b:.6f},{c:.6f},{d:.2f},{e:.2f}" for a, (b, c), (d, e) in zip(t, q, torque)]
    # A header without name and time: the same bytes on every run.
    with open(HERE / name, "wb") as raw, gzip.GzipFile("", "wb", 9, raw, 0) as file:
        file.write(("\n".join([header] + rows) + "\n").encode())
    print(name, np.abs(q).max(axis=0), np.abs(torque).max(axis=0))


if __name__ == "__main__":
    record("train.csv.gz", 1, 40.0)
    record("validation.csv.gz", 2, 20.0)
