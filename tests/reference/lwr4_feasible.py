"""Feasible fit of the LWR4+ by Pinocchio and CVXPY: held-out errors for tests/real_recordings.rs.

    lwr4_feasible.py FOLDER    (of measurements_1.csv, measurements_2.csv and lwr4.urdf)

Everything low-passed at 6 Hz, trained on recording 1, held out recording 2. Every pseudo-inertia is positive
semidefinite, friction brakes, channels are weighted by their own residual until that settles. Printed in N·m.
"""

import sys
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
# The folder holds a file with a library's name: it must not be searched for it.
sys.path = [p for p in sys.path if Path(p or ".").resolve() != FOLDER]

import cvxpy as cp
import numpy as np
import pinocchio as pin
from scipy.signal import butter, filtfilt

JOINTS = 7
RATE_HZ = 200.0
CUTOFF_HZ = 6.0
TRANSITION = 0.008  # rad/s
EDGE = 60  # samples
ROUNDS = 8
# Entries of the pseudo-inertia in Pinocchio's order m, mc, Ixx, Ixy, Iyy, Ixz, Iyz, Izz.
MOMENTS = {(0, 0): [-1, 1, 1], (1, 1): [1, -1, 1], (2, 2): [1, 1, -1]}


def main(folder):
    train, held_out = (read(folder, number) for number in (1, 2))
    weights = np.ones(JOINTS)
    for _ in range(ROUNDS):
        x = solve(train, weights)
        weights = 1.0 / errors(x, train)
    print(errors(x, held_out).round(4).tolist())


def read(folder, number):
    model = pin.buildModelFromUrdf(f"{folder}/lwr4.urdf")
    data = model.createData()
    table = np.genfromtxt(f"{folder}/measurements_{number}.csv", delimiter=",", names=True)
    q, torque = (np.stack([table[f"{c}{j + 1}"] for j in range(JOINTS)], 1) for c in ("q", "tau"))
    low = butter(4, CUTOFF_HZ / (RATE_HZ / 2))
    q = filtfilt(*low, q, axis=0)
    dq = np.gradient(q, 1 / RATE_HZ, axis=0)
    ddq = np.gradient(dq, 1 / RATE_HZ, axis=0)
    rows = np.zeros((len(q), JOINTS, 13 * JOINTS))
    for k in range(len(q)):
        rows[k, :, : 10 * JOINTS] = pin.computeJointTorqueRegressor(model, data, q[k], dq[k], ddq[k])
    for j in range(JOINTS):
        speed = dq[:, j]
        rows[:, j, 10 * JOINTS + j] = speed / (abs(speed) + TRANSITION)
        rows[:, j, 11 * JOINTS + j] = speed
        rows[:, j, 12 * JOINTS + j] = 1.0
    rows, torque = filtfilt(*low, rows, axis=0), filtfilt(*low, torque, axis=0)
    return rows[EDGE:-EDGE], torque[EDGE:-EDGE]


def solve(recording, weights):
    rows, torque = recording
    whole = np.concatenate([rows, torque[:, :, None]], 2) * weights[None, :, None]
    triangle = np.linalg.qr(whole.reshape(-1, whole.shape[2]), mode="r")
    x = cp.Variable(13 * JOINTS)
    constraints = [x[10 * JOINTS : 12 * JOINTS] >= 0]
    basis = pseudo_inertia()
    for j in range(JOINTS):
        body = cp.reshape(basis @ x[10 * j : 10 * j + 10], (4, 4), order="C")
        constraints.append(body >> 1e-6 * np.eye(4))
    residual = triangle[:, :-1] @ x - triangle[:, -1]
    # The pull keeps what the motion does not determine from running away.
    cost = cp.sum_squares(residual) + 1e-8 * cp.sum_squares(x)
    cp.Problem(cp.Minimize(cost), constraints).solve(solver="CLARABEL")
    return x.value


def pseudo_inertia():
    basis = np.zeros((4, 4, 10))
    for entry, signs in MOMENTS.items():
        basis[entry][[4, 6, 9]] = 0.5 * np.array(signs)
    for (i, j), k in {(0, 1): 5, (0, 2): 7, (1, 2): 8}.items():
        basis[i, j, k] = basis[j, i, k] = -1.0
    for k in range(3):
        basis[k, 3, 1 + k] = basis[3, k, 1 + k] = 1.0
    basis[3, 3, 0] = 1.0
    return basis.reshape(16, 10)


def errors(x, recording):
    rows, torque = recording
    return np.sqrt(np.mean((rows @ x - torque) ** 2, axis=0))


if __name__ == "__main__":
    main(sys.argv[1])
