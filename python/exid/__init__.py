"""exid: excite, identify, diagnose. Robot models that are right.

The verbs are those of the program `exid`, and every call gives the bits of the program:

=====================  ==========================================================================
:func:`exid.fit`       parameters from recordings
:func:`exid.check`     what is wrong with the inputs, and what to do
:func:`exid.diagnose`  which physics the model lacks, and the model with it
:func:`exid.design`    an excitation trajectory
:func:`exid.simulate`  recordings from a model
:func:`exid.rollout`   models simulated forward beside the recording that was held out
:func:`exid.export`    the identified robot in another format
:func:`exid.load`      a results folder
:func:`exid.example`   a problem with recordings that comes with the package
=====================  ==========================================================================

:mod:`exid.fleet` works through recordings of many robots on Dask, Ray or any executor.
:class:`exid.Problem` states a problem in Python, :class:`exid.Robot` has the rigid-body functions in batches. SI units
throughout: m, rad, s, kg, N·m, A, °C.
"""

from exid import fleet
from exid._core import __version__
from exid.data import Data, Recording
from exid.errors import (
    DataError,
    DefectError,
    ExidError,
    InterruptedWarning,
    NoSolutionError,
    NoSolutionWarning,
    Place,
    ProblemError,
)
from exid.problem import Law, Problem
from exid.result import (
    CheckResult,
    DesignResult,
    DiagnoseResult,
    Export,
    Finding,
    FitResult,
    Recorded,
    Result,
    RolloutResult,
    SimulateResult,
    Solver,
)
from exid.robot import Derivatives, Robot
from exid.shipped import example
from exid.verbs import check, design, diagnose, export, fit, load, rollout, simulate

__all__ = [
    "CheckResult",
    "Data",
    "DataError",
    "DefectError",
    "Derivatives",
    "DesignResult",
    "DiagnoseResult",
    "ExidError",
    "Export",
    "Finding",
    "FitResult",
    "InterruptedWarning",
    "Law",
    "NoSolutionError",
    "NoSolutionWarning",
    "Place",
    "Problem",
    "ProblemError",
    "Recorded",
    "Recording",
    "Result",
    "Robot",
    "RolloutResult",
    "SimulateResult",
    "Solver",
    "__version__",
    "check",
    "design",
    "diagnose",
    "example",
    "export",
    "fit",
    "fleet",
    "load",
    "rollout",
    "simulate",
]
