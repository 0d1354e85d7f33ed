"""Problems: what is known of a robot, what was recorded, and what is asked."""

from __future__ import annotations

import copy
import json
import math
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Mapping, Sequence, cast

from exid import _core
from exid.tables import (
    ControllerTable,
    DesignTable,
    DiagnoseTable,
    DriveTable,
    FitTable,
    RecordingsTable,
    RobotTable,
    SimulateTable,
)

__all__ = ["Law", "Problem"]


@dataclass
class Law:
    """A torque law of one's own, as a `[[law]]` of a problem.

    Attributes
    ----------
    id : str
        Name that lists of effects may hold.
    torque : str
        Expression in q, v, acc, tau, i, t, T and the parameters.
    acts_on : str
        `"motor"`, `"joint"`, `"signal"` or `"gain"`.
    sentence : str
        What the law says, for a report.
    parameters : dict
        By name: a mapping with any of `unit`, `lower`, `upper`, `typical`, `search`.

    Examples
    --------
    >>> cogging = Law("cogging", "a*sin(8*q)", parameters={"a": {"unit": "N*m", "typical": 0.1}})
    >>> cogging.to_dict()["acts_on"]
    'motor'
    """

    id: str
    torque: str
    acts_on: str = "motor"
    sentence: str = ""
    parameters: dict[str, Mapping[str, Any]] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """The table `[[law]]`."""
        table: dict[str, Any] = {"id": self.id, "acts_on": self.acts_on, "torque": self.torque}
        if self.sentence:
            table["sentence"] = self.sentence
        if self.parameters:
            table["parameters"] = {name: dict(of) for name, of in self.parameters.items()}
        return table


@dataclass
class Problem:
    """A problem, table by table; keys and defaults are those of problem files.

    Attributes
    ----------
    robot : RobotTable
        The kinematics, what is known of it, and what is to be estimated.
    name : str or None
        Name of the problem and of its results.
    drive : DriveTable or None
        The motors, and the physics between motor and joint.
    recordings : RecordingsTable or None
        The files, what they hold, and how positions give velocities and accelerations.
    controller : ControllerTable or None
        The position controllers, where the signal is `"position_command"`.
    fit : FitTable or None
        The estimator, and what is known before the data.
    design : DesignTable or None
        The motions among which an excitation is sought, and its limits.
    simulate : SimulateTable or None
        The trajectory, how it is recorded, and the truth behind it.
    diagnose : DiagnoseTable or None
        The physics to look for, and how sure a finding has to be.
    law : list of Law
        Torque laws of one's own.
    laws : list of str or path
        Files with tables `[[law]]`, or folders of such files.
    folder : str or path
        Where relative paths of the tables start from.

    Examples
    --------
    >>> problem = Problem.from_urdf("arm.urdf", drive={"effects": ["coulomb_friction"]})
    >>> problem.to_dict()
    {'robot': {'urdf': 'arm.urdf'}, 'drive': {'effects': ['coulomb_friction']}}
    """

    robot: RobotTable
    name: str | None = None
    drive: DriveTable | None = None
    recordings: RecordingsTable | None = None
    controller: ControllerTable | None = None
    fit: FitTable | None = None
    design: DesignTable | None = None
    simulate: SimulateTable | None = None
    diagnose: DiagnoseTable | None = None
    law: list[Law] = field(default_factory=list)
    laws: list[str | os.PathLike[str]] = field(default_factory=list)
    folder: str | os.PathLike[str] = "."

    @classmethod
    def from_urdf(cls, path: str | os.PathLike[str], **tables: Any) -> Problem:
        """A problem of the robot of a URDF.

        Parameters
        ----------
        path : str or path
            The robot description.
        **tables
            The other attributes of the problem; `robot` is added to the table of the robot.
        """
        return cls._of_robot("urdf", path, tables)

    @classmethod
    def from_mjcf(cls, path: str | os.PathLike[str], **tables: Any) -> Problem:
        """A problem of the robot of a MuJoCo model; parameters as :meth:`from_urdf`."""
        return cls._of_robot("mjcf", path, tables)

    @classmethod
    def from_file(
        cls, path: str | os.PathLike[str], set: Mapping[str, Any] | None = None
    ) -> Problem:
        """Reads a problem file.

        Parameters
        ----------
        path : str or path
            The file.
        set : dict, optional
            Keys to override, as `{"fit.estimator": "wls"}`.
        """
        text = _core.read_problem(os.fspath(path), overrides(set))
        return cls.from_dict(json.loads(text), folder=Path(path).parent)

    @classmethod
    def from_dict(
        cls, table: Mapping[str, Any], folder: str | os.PathLike[str] = "."
    ) -> Problem:
        """A problem from the table that its file would hold."""
        tables = copy.deepcopy(dict(table))
        laws = [Law(**law) for law in tables.pop("law", [])]
        return cls(**tables, law=laws, folder=folder)

    @classmethod
    def _of_robot(
        cls, kind: str, path: str | os.PathLike[str], tables: dict[str, Any]
    ) -> Problem:
        robot = {kind: os.fspath(path), **tables.pop("robot", {})}
        return cls(robot=cast(RobotTable, robot), **tables)

    def to_dict(self) -> dict[str, Any]:
        """The table that a problem file would hold."""
        named = {
            "name": self.name,
            "robot": self.robot,
            "drive": self.drive,
            "recordings": self.recordings,
            "controller": self.controller,
            "fit": self.fit,
            "design": self.design,
            "simulate": self.simulate,
            "diagnose": self.diagnose,
        }
        table: dict[str, Any] = {
            key: copy.deepcopy(value) for key, value in named.items() if value is not None
        }
        if self.law:
            table["law"] = [law.to_dict() for law in self.law]
        if self.laws:
            table["laws"] = [os.fspath(path) for path in self.laws]
        return table


def overrides(set: Mapping[str, Any] | Sequence[str] | None) -> list[str]:
    """Overrides as the command line has them, `key=value`."""
    if set is None:
        return []
    if isinstance(set, Mapping):
        return [f"{key}={_toml(value)}" for key, value in set.items()]
    return [str(text) for text in set]


def as_json(table: Mapping[str, Any]) -> str:
    """A table of a problem as JSON."""
    return json.dumps(_plain(table), allow_nan=False)


def _plain(value: Any) -> Any:
    """Values of Python and NumPy as JSON has them; an infinite number is a text there."""
    if isinstance(value, Mapping):
        return {str(key): _plain(below) for key, below in value.items() if below is not None}
    if isinstance(value, Law):
        return _plain(value.to_dict())
    if isinstance(value, (str, bool)) or value is None:
        return value
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [_plain(below) for below in value]
    if isinstance(value, float) and math.isinf(value):
        return "inf" if value > 0 else "-inf"
    return value


def _toml(value: Any) -> str:
    """A value as TOML writes it."""
    plain = _plain(value)
    if isinstance(plain, dict):
        entries = [f"{json.dumps(key)} = {_toml(below)}" for key, below in plain.items()]
        return "{ " + ", ".join(entries) + " }"
    if isinstance(plain, list):
        return "[" + ", ".join(_toml(below) for below in plain) + "]"
    if plain in ("inf", "-inf"):
        return str(plain)
    return json.dumps(plain, ensure_ascii=False)
