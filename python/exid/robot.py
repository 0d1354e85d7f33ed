"""Rigid-body functions of a robot for batches of states."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from exid import _core

__all__ = ["Derivatives", "Robot"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Derivatives:
    """Derivatives of joint torques, each (samples, n, n) or (n, n): rows are torques, columns joints.

    Attributes
    ----------
    by_position : ndarray
        ∂τ/∂q, N·m/rad (N/m).
    by_velocity : ndarray
        ∂τ/∂q̇, N·m·s/rad (N·s/m).
    by_acceleration : ndarray
        ∂τ/∂q̈ = M(q), kg·m² (kg).
    """

    by_position: Floats
    by_velocity: Floats
    by_acceleration: Floats


class Robot:
    """A robot on a fixed base, with the inertial parameters of its file.

    States are arrays of shape (samples, n), or (n,) for one state; what is returned has the same leading shape. Positions in
    rad (m), torques in N·m (N), joints in the order of :attr:`joints`. Inertial parameters are ten per link,
    `(m, m·cx, m·cy, m·cz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz)` about the origin of the link's frame, in Pinocchio's order.

    Examples
    --------
    >>> robot = Robot.from_urdf("problems/arm6/arm6.urdf")                 # doctest: +SKIP
    >>> torque = robot.inverse_dynamics(q, dq, ddq)                        # doctest: +SKIP
    """

    def __init__(self, core: _core.Robot) -> None:
        self._core = core

    @classmethod
    def from_urdf(cls, path: str | os.PathLike[str], gravity: Sequence[float] | None = None) -> Robot:
        """Read a URDF.

        Parameters
        ----------
        path : path
        gravity : three floats, optional
            In the base frame, m/s²; that of the file, or (0, 0, -9.81), if None.
        """
        return cls._read("urdf", path, gravity)

    @classmethod
    def from_mjcf(cls, path: str | os.PathLike[str], gravity: Sequence[float] | None = None) -> Robot:
        """Read a model of MuJoCo; parameters as :meth:`from_urdf`."""
        return cls._read("mjcf", path, gravity)

    @classmethod
    def from_mdh(cls, path: str | os.PathLike[str], gravity: Sequence[float] | None = None) -> Robot:
        """Read a table of modified Denavit-Hartenberg parameters; parameters as :meth:`from_urdf`."""
        return cls._read("mdh", path, gravity)

    @classmethod
    def _read(cls, kind: str, path: str | os.PathLike[str], gravity: Sequence[float] | None) -> Robot:
        return cls(_core.Robot(kind, os.fspath(path), None if gravity is None else list(gravity)))

    @property
    def joints(self) -> list[str]:
        """Names of the n joints."""
        return self._core.joints

    @property
    def links(self) -> list[str]:
        """Names of the n moving links."""
        return self._core.links

    @property
    def gravity(self) -> Floats:
        """Gravity in the base frame, m/s²."""
        return np.array(self._core.gravity_vector)

    @property
    def parameters(self) -> Floats:
        """The 10 n inertial parameters of the file."""
        return self._core.parameters

    @property
    def parameter_names(self) -> list[str]:
        """Names of the inertial parameters."""
        return self._core.parameter_names

    @property
    def base_expressions(self) -> list[str]:
        """The combinations of parameters that torques depend on, in words."""
        return self._core.base_expressions

    @property
    def base_map(self) -> Floats:
        """Matrix K of shape (b, 10 n): the base parameters are β = K π, and τ = Y_b β."""
        return self._core.base_map

    def inverse_dynamics(self, q: ArrayLike, dq: ArrayLike, ddq: ArrayLike, parameters: ArrayLike | None = None) -> Floats:
        """Joint torques τ = M(q) q̈ + C(q, q̇) q̇ + g(q).

        Parameters
        ----------
        q, dq, ddq : array_like, (samples, n) or (n,)
        parameters : array_like, (10 n,), optional
            Inertial parameters; those of the file if None.

        Returns
        -------
        ndarray, shape of `q`
            N·m (N).
        """
        states = _states(q, dq, ddq)
        at, speed, acceleration = states.arrays
        return states.shaped(self._core.inverse_dynamics(at, speed, acceleration, _vector(parameters)))

    def gravity_torque(self, q: ArrayLike, parameters: ArrayLike | None = None) -> Floats:
        """Torques g(q) that hold the robot still, N·m (N); arguments as :meth:`inverse_dynamics`."""
        zero = np.zeros_like(np.asarray(q, dtype=float))
        return self.inverse_dynamics(q, zero, zero, parameters)

    def regressor(self, q: ArrayLike, dq: ArrayLike, ddq: ArrayLike) -> Floats:
        """Regressor Y with τ = Y π.

        Returns
        -------
        ndarray, (samples, n, 10 n) or (n, 10 n)
        """
        states = _states(q, dq, ddq)
        at, speed, acceleration = states.arrays
        return states.shaped(self._core.regressor(at, speed, acceleration, None))

    def base_regressor(self, q: ArrayLike, dq: ArrayLike, ddq: ArrayLike) -> Floats:
        """Regressor Y_b of the base parameters, τ = Y_b K π.

        Returns
        -------
        ndarray, (samples, n, b) or (n, b)
        """
        states = _states(q, dq, ddq)
        at, speed, acceleration = states.arrays
        return states.shaped(self._core.regressor(at, speed, acceleration, self._core.base_columns))

    def mass_matrix(self, q: ArrayLike, parameters: ArrayLike | None = None) -> Floats:
        """Mass matrices M(q), kg·m² (kg), (samples, n, n) or (n, n)."""
        states = _states(q)
        return states.shaped(self._core.mass_matrix(states.arrays[0], _vector(parameters)))

    def forward_dynamics(
        self,
        q: ArrayLike,
        dq: ArrayLike,
        torque: ArrayLike,
        parameters: ArrayLike | None = None,
        rotor_inertia: ArrayLike | None = None,
    ) -> Floats:
        """Accelerations q̈ under torques τ.

        Parameters
        ----------
        q, dq, torque : array_like, (samples, n) or (n,)
        parameters : array_like, (10 n,), optional
        rotor_inertia : array_like, (n,), optional
            Added to the diagonal of M, kg·m² (kg).

        Raises
        ------
        ValueError
            The mass matrix is not positive definite.
        """
        states = _states(q, dq, torque)
        at, speed, applied = states.arrays
        added = _vector(rotor_inertia)
        return states.shaped(self._core.forward_dynamics(at, speed, applied, _vector(parameters), added))

    def derivatives(self, q: ArrayLike, dq: ArrayLike, ddq: ArrayLike, parameters: ArrayLike | None = None) -> Derivatives:
        """Derivatives of the torques by position, velocity and acceleration; arguments as :meth:`inverse_dynamics`."""
        states = _states(q, dq, ddq)
        at, speed, acceleration = states.arrays
        slopes = self._core.derivatives(at, speed, acceleration, _vector(parameters))
        return Derivatives(*(states.shaped(slope) for slope in slopes))

    def __repr__(self) -> str:
        return f"<Robot with joints {', '.join(self.joints)}>"


@dataclass(frozen=True)
class _States:
    arrays: list[Floats]
    single: bool

    def shaped(self, result: Floats) -> Floats:
        return result[0] if self.single else result


def _states(*given: ArrayLike) -> _States:
    arrays = [np.asarray(states, dtype=np.float64) for states in given]
    single = arrays[0].ndim == 1
    return _States([np.atleast_2d(states) for states in arrays], single)


def _vector(given: ArrayLike | None) -> Floats | None:
    return None if given is None else np.asarray(given, dtype=np.float64)
