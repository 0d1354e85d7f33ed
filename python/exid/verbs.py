"""The verbs: fit, check, diagnose, design, simulate, rollout, export."""

from __future__ import annotations

import os
import warnings
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Iterator, Mapping, Union

from exid import _core
from exid.data import Data, recordings
from exid.errors import InterruptedWarning, NoSolutionWarning
from exid.problem import Problem, as_json, overrides
from exid.result import (
    CheckResult,
    DesignResult,
    DiagnoseResult,
    Export,
    FitResult,
    Result,
    RolloutResult,
    SimulateResult,
)

__all__ = [
    "check",
    "design",
    "diagnose",
    "export",
    "fit",
    "load",
    "rollout",
    "simulate",
]

AnyProblem = Union[str, "os.PathLike[str]", Mapping[str, Any], Problem]
AnyResult = Union[Result, str, "os.PathLike[str]"]
Progress = Union[Callable[[str], object], bool, None]


def fit(
    problem: AnyProblem,
    data: Data | None = None,
    *,
    set: Mapping[str, Any] | None = None,
    seed: int = 0,
    threads: int | None = None,
    force: bool = False,
    progress: Progress = None,
    out: str | os.PathLike[str] | None = None,
    max_rows: int | None = None,
) -> FitResult:
    """Estimate parameters from recordings.

    Parameters
    ----------
    problem : path, dict or Problem
        A problem file, the table that it would hold, or a :class:`exid.Problem`.
    data : path, dict of arrays, frame, or groups of them, optional
        Recordings that take the place of those that the problem names: one, a list of them, or a dictionary with any of
        `train`, `validation` and `loaded`. Groups that are not given stay as the problem has them. Names of columns are
        those of files: `t`, `q1`, `tau1` and so on, or as `recordings.columns` says; a matrix `q` of shape
        (samples, joints) gives `q1`, `q2`, ... SI units unless the problem states others.
    set : dict, optional
        Keys of the problem to override, as `{"fit.estimator": "wls"}`.
    seed : int
        Seed of everything random.
    threads : int, optional
        Number of threads; all processors if None. The result does not depend on it.
    force : bool
        Go on where mistakes in the inputs make every figure meaningless.
    progress : callable or bool, optional
        Called with what is going on, in words; True shows it with tqdm.
    out : path, optional
        Folder that the result is saved to, as :meth:`Result.save` does.
    max_rows : int, optional
        Rows of a recording beyond which it is refused; ten million if None.

    Returns
    -------
    FitResult
        Parameters, their covariance, errors of each joint, and the rest of `result.json`.

    Raises
    ------
    ProblemError
        The problem is wrong, or `out` cannot be written.
    DataError
        A recording or the robot file is wrong.
    NoSolutionError
        No estimate can be made.
    KeyboardInterrupt
        Ctrl-C before anything was found. Later it ends the run with what was reached, and
        :class:`exid.InterruptedWarning` says so.

    See Also
    --------
    diagnose : also says which physics the model lacks.

    Examples
    --------
    >>> result = exid.fit("problems/arm6/problem.toml")        # doctest: +SKIP
    >>> result.parameters                                      # doctest: +SKIP
    """
    call = _Call("fit", set, seed, threads, force, progress, out, max_rows)
    return FitResult(call.run(problem, data))


def check(
    problem: AnyProblem,
    data: Data | None = None,
    *,
    set: Mapping[str, Any] | None = None,
    threads: int | None = None,
    progress: Progress = None,
    out: str | os.PathLike[str] | None = None,
    max_rows: int | None = None,
) -> CheckResult:
    """Read everything, run nothing: say what is wrong with the inputs and what to do.

    Parameters are those of :func:`fit`.

    Returns
    -------
    CheckResult
        Findings about units, signs, order of joints, sampling, delay, saturation and identifiability; nothing is raised
        for what a recording or the robot file has wrong.
    """
    call = _Call("check", set, threads=threads, progress=progress, out=out, max_rows=max_rows)
    return CheckResult(call.run(problem, data))


def diagnose(
    problem: AnyProblem,
    data: Data | None = None,
    *,
    set: Mapping[str, Any] | None = None,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress = None,
    out: str | os.PathLike[str] | None = None,
    max_rows: int | None = None,
) -> DiagnoseResult:
    """Say where model and recordings differ, which physics is missing, and fit the model with it.

    Parameters and errors are those of :func:`fit`.

    Returns
    -------
    DiagnoseResult
        Verdict, findings with their rivals and probabilities, the fitted model, the next experiment.
    """
    call = _Call("diagnose", set, seed, threads, progress=progress, out=out, max_rows=max_rows)
    return DiagnoseResult(call.run(problem, data))


def design(
    problem: AnyProblem,
    *,
    set: Mapping[str, Any] | None = None,
    seed: int = 0,
    threads: int | None = None,
    force: bool = False,
    progress: Progress = None,
    out: str | os.PathLike[str] | None = None,
) -> DesignResult:
    """Design an excitation trajectory within the robot's limits.

    Parameters and errors are those of :func:`fit`. A run that ends by `design.budget_s` need not give the same bits again;
    one that ends by `design.starts` does.

    Returns
    -------
    DesignResult
        The trajectory, and the standard deviations that a recording of it promises.
    """
    call = _Call("design", set, seed, threads, force, progress, out)
    return DesignResult(call.run(problem))


def simulate(
    problem: AnyProblem,
    *,
    set: Mapping[str, Any] | None = None,
    seed: int = 0,
    threads: int | None = None,
    force: bool = False,
    progress: Progress = None,
    out: str | os.PathLike[str] | None = None,
) -> SimulateResult:
    """Make recordings from a model, with noise, quantisation and any effects.

    Parameters and errors are those of :func:`fit`.

    Returns
    -------
    SimulateResult
        Recordings as dictionaries of arrays, ready to be the `data` of :func:`fit`, and the truth behind them.
    """
    call = _Call("simulate", set, seed, threads, force, progress, out)
    return SimulateResult(call.run(problem))


def rollout(
    result: AnyResult,
    *,
    set: Mapping[str, Any] | None = None,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress = None,
    out: str | os.PathLike[str] | None = None,
) -> RolloutResult:
    """Simulate the models of a result forward beside the recording that was held out.

    Parameters
    ----------
    result : Result or path
        A result of :func:`fit` or :func:`diagnose`, or its folder.
    set, seed, threads, progress, out
        As in :func:`fit`; `seed` is that of the noise.

    Returns
    -------
    RolloutResult
        Errors of position over the time simulated, of the models before and after.
    """
    call = _Call("rollout", set, seed, threads, progress=progress, out=out)
    source = result.source if isinstance(result, Result) else os.fspath(result)
    return RolloutResult(call.rollout(_held(result), source))


def export(result: AnyResult, to: str, out: str | os.PathLike[str] | None = None) -> Export:
    """Write the identified robot in another format.

    Parameters
    ----------
    result : Result or path
        A result of :func:`fit` or :func:`diagnose`, or its folder.
    to : str
        `"urdf"`, `"mjcf"`, `"mujoco"`, `"toml"`, `"rust"`, `"c"` or `"numpy"`.
    out : path, optional
        Folder to write the files to; they are not written if None.

    Returns
    -------
    Export
        The files with their text, and notes on what the format has no place for.
    """
    return _held(result).export(to, out)


def load(folder: str | os.PathLike[str]) -> Result:
    """Read a results folder of any verb.

    Parameters
    ----------
    folder : path
        The folder, written by the program or by :meth:`Result.save`.

    Returns
    -------
    Result
        A result of the verb's kind. Predictions have the ten digits of the file.
    """
    return Result.of(_core.load(os.fspath(folder)))


def _held(result: AnyResult) -> Result:
    """A result, or that of a folder."""
    return result if isinstance(result, Result) else load(result)


@dataclass
class _Given:
    path: str
    table: str | None
    overrides: list[str]
    memory: list[tuple[str, _core.Arrays]]
    max_rows: int | None


@dataclass
class _Options:
    seed: int
    threads: int | None
    force: bool
    progress: Callable[[str], object] | None
    command: list[str]


@dataclass
class _Call:
    """One call of a verb."""

    verb: str
    set: Mapping[str, Any] | None
    seed: int = 0
    threads: int | None = None
    force: bool = False
    progress: Progress = None
    out: str | os.PathLike[str] | None = None
    max_rows: int | None = None

    def run(self, problem: AnyProblem, data: Data | None = None) -> _core.Run:
        given = self._given(problem, data)
        return self._watched(lambda options: _core.run(self.verb, given, options))

    def rollout(self, result: Result, source: str) -> _core.Run:
        set = overrides(self.set)
        return self._watched(lambda options: _core.rollout(result.core, set, source, options))

    def _given(self, problem: AnyProblem, data: Data | None) -> _Given:
        read = recordings(data)
        set = overrides(self.set)
        if isinstance(problem, (str, os.PathLike)):
            set += overrides({f"recordings.{group}": names for group, names in read.groups.items()})
            return _Given(os.fspath(problem), None, set, read.memory, self.max_rows)
        if not isinstance(problem, Problem):
            problem = Problem.from_dict(problem)
        table = problem.to_dict()
        if read.groups:
            table.setdefault("recordings", {}).update(read.groups)
        # A table has no file, but a folder from which its relative paths start.
        path = os.path.normpath(Path(problem.folder) / "problem")
        return _Given(path, as_json(table), set, read.memory, self.max_rows)

    def _watched(self, work: Callable[[_Options], _core.Run]) -> _core.Run:
        if self.out is not None:
            # Refused before the work, not after it.
            _core.require_writable(os.fspath(self.out))
        command = [f"exid.{self.verb}"]
        with self._told() as told:
            run = work(_Options(self.seed, self.threads, self.force, told, command))
        self._warn(run)
        if self.out is not None:
            run.save(os.fspath(self.out))
        return run

    @contextmanager
    def _told(self) -> Iterator[Callable[[str], object] | None]:
        """Who is told how far the run is."""
        if self.progress is True:
            from tqdm.auto import tqdm

            with tqdm(total=0, bar_format="{desc} {elapsed}", desc=self.verb) as bar:
                yield bar.set_description_str
        else:
            yield self.progress if callable(self.progress) else None

    def _warn(self, run: _core.Run) -> None:
        code = run.exit_code()
        if code == 130:
            warnings.warn("interrupted: the result is what was reached", InterruptedWarning, 5)
        elif code == 4:
            warnings.warn("no solution: no figure of what was reached can be relied on", NoSolutionWarning, 5)
        elif code == 70:
            warnings.warn(f"{run.defect()}; the result is what was found before it", NoSolutionWarning, 5)
