"""Rigid-body functions beside Pinocchio's."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pinocchio
import pytest
from numpy.typing import NDArray

import exid

URDFS = ["problems/arm6/arm6.urdf", "problems/kr150_payload/kr150.urdf", "problems/ur5_motors/ur5.urdf"]

# What both accumulate over a chain of seven bodies stays below it.
TOLERANCE = 1e-10

Floats = NDArray[np.float64]


class Pair:
    """A robot of both."""

    def __init__(self, urdf: str) -> None:
        self.robot = exid.Robot.from_urdf(urdf)
        self.model = pinocchio.buildModelFromUrdf(str(Path(urdf).resolve()))
        self.data = self.model.createData()
        assert list(self.model.names)[1:] == self.robot.joints

    def states(self, samples: int, seed: int = 1) -> list[Floats]:
        rng = np.random.default_rng(seed)
        return [scale * rng.uniform(-1, 1, (samples, len(self.robot.joints))) for scale in (3.0, 2.0, 8.0)]


@pytest.fixture(params=URDFS)
def pair(request: pytest.FixtureRequest) -> Pair:
    return Pair(request.param)


def agree(ours: Floats, theirs: Floats) -> None:
    """Entries are compared with the largest: sums of large terms lose digits."""
    assert ours.shape == theirs.shape
    assert np.max(np.abs(ours - theirs)) <= TOLERANCE * max(1.0, float(np.max(np.abs(theirs))))


def test_inverse_dynamics_and_gravity(pair: Pair) -> None:
    q, dq, ddq = pair.states(200)
    agree(pair.robot.inverse_dynamics(q, dq, ddq), np.array([pinocchio.rnea(pair.model, pair.data, *s) for s in zip(q, dq, ddq)]))
    agree(
        pair.robot.gravity_torque(q),
        np.array([pinocchio.computeGeneralizedGravity(pair.model, pair.data, s) for s in q]),
    )
    agree(pair.robot.inverse_dynamics(q[0], dq[0], ddq[0]), pinocchio.rnea(pair.model, pair.data, q[0], dq[0], ddq[0]))


def test_regressors(pair: Pair) -> None:
    q, dq, ddq = pair.states(150)
    ours = pair.robot.regressor(q, dq, ddq)
    theirs = np.array([pinocchio.computeJointTorqueRegressor(pair.model, pair.data, *s) for s in zip(q, dq, ddq)])
    agree(ours, theirs)
    torque = pair.robot.inverse_dynamics(q, dq, ddq)
    agree(ours @ pair.robot.parameters, torque)
    base = pair.robot.base_regressor(q, dq, ddq)
    agree(base @ (pair.robot.base_map @ pair.robot.parameters), torque)
    stacked = base.reshape(-1, base.shape[2])
    assert np.linalg.matrix_rank(stacked) == base.shape[2] == len(pair.robot.base_expressions)
    assert np.linalg.matrix_rank(ours.reshape(-1, ours.shape[2])) == base.shape[2]


def test_parameters_are_in_the_order_of_pinocchio(pair: Pair) -> None:
    theirs = np.concatenate([inertia.toDynamicParameters() for inertia in list(pair.model.inertias)[1:]])
    agree(pair.robot.parameters, theirs)


def test_mass_matrix_and_forward_dynamics(pair: Pair) -> None:
    q, dq, ddq = pair.states(100)
    masses = []
    for state in q:
        upper = np.triu(pinocchio.crba(pair.model, pair.data, state))
        masses.append(upper + np.triu(upper, 1).T)
    agree(pair.robot.mass_matrix(q), np.array(masses))
    torque = pair.robot.inverse_dynamics(q, dq, ddq)
    theirs = np.array([pinocchio.aba(pair.model, pair.data, *s) for s in zip(q, dq, torque)])
    agree(pair.robot.forward_dynamics(q, dq, torque), theirs)


def test_derivatives(pair: Pair) -> None:
    q, dq, ddq = pair.states(80)
    ours = pair.robot.derivatives(q, dq, ddq)
    position, velocity = [], []
    for state in zip(q, dq, ddq):
        by_q, by_dq, _ = pinocchio.computeRNEADerivatives(pair.model, pair.data, *state)
        position.append(by_q.copy())
        velocity.append(by_dq.copy())
    agree(ours.by_position, np.array(position))
    agree(ours.by_velocity, np.array(velocity))
    agree(ours.by_acceleration, pair.robot.mass_matrix(q))


def test_shapes_are_checked(pair: Pair) -> None:
    n = len(pair.robot.joints)
    with pytest.raises(ValueError, match="samples, joints"):
        pair.robot.inverse_dynamics(np.zeros((3, n + 1)), np.zeros((3, n)), np.zeros((3, n)))


def test_a_batch_of_regressors_is_three_times_as_fast_as_a_loop() -> None:
    pair = Pair(URDFS[0])
    states = pair.states(100_000)

    def seconds_of(work: str) -> float:
        started = time.perf_counter()
        if work == "batch":
            assert pair.robot.regressor(*states).shape == (100_000, 6, 60)
        else:
            rows = np.empty((100_000, 6, 60))
            for k, state in enumerate(zip(*states)):
                rows[k] = pinocchio.computeJointTorqueRegressor(pair.model, pair.data, *state)
        return time.perf_counter() - started

    # The shortest of several: whatever else the machine does only adds.
    batch = min(seconds_of("batch") for _ in range(8))
    loop = min(seconds_of("loop") for _ in range(3))
    print(f"100 000 regressors: {batch:.3f} s in a batch, {loop:.3f} s in a loop over Pinocchio")
    assert loop >= 3.0 * batch
