"""Results of the verbs."""

from __future__ import annotations

import html
import json
import os
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Sequence

import numpy as np
from numpy.typing import NDArray

from exid import _core
from exid.frames import frame
from exid.plot import Plots

__all__ = [
    "CheckResult",
    "DesignResult",
    "DiagnoseResult",
    "Export",
    "Finding",
    "FitResult",
    "Recorded",
    "Result",
    "RolloutResult",
    "SimulateResult",
    "Solver",
]


@dataclass(frozen=True)
class Finding:
    """Physics that the model lacks, or a mistake in the inputs.

    Attributes
    ----------
    kind : str
        Id of the effect, or code of the mistake.
    joints : list of str
        Joints that it acts on; of a mistake, the channel it is about.
    sentence : str
        What it is, in words.
    severity : str
        Of a mistake: `"error"`, `"warning"` or `"note"`; of an effect: `"finding"`.
    remedy : str or None
        Of a mistake: what to do.
    probability : float or None
        Of an effect: that it, and not a rival or nothing, is what is there.
    p_value : float or None
        Of an effect: corrected for all hypotheses tried and for autocorrelation.
    explained_share : float or None
        Of an effect: share of the excess of the held-out misfit that it explains.
    details : dict
        Everything that `result.json` says of it.
    """

    kind: str
    joints: list[str]
    sentence: str
    severity: str
    remedy: str | None = None
    probability: float | None = None
    p_value: float | None = None
    explained_share: float | None = None
    details: dict[str, Any] = field(default_factory=dict, repr=False)

    @classmethod
    def of(cls, entry: dict[str, Any]) -> Finding:
        """A finding of `result.json`."""
        if "effect" in entry:
            return cls(
                kind=entry["effect"],
                joints=list(entry["joints"]),
                sentence=entry["sentence"],
                severity="finding",
                probability=entry.get("probability"),
                p_value=entry.get("p_value"),
                explained_share=entry.get("explained_share"),
                details=entry,
            )
        channel = entry.get("channel")
        return cls(
            kind=entry["code"],
            joints=[] if channel is None else [channel],
            sentence=entry["message"],
            severity=entry["severity"],
            remedy=entry["remedy"],
            details=entry,
        )


@dataclass(frozen=True)
class Solver:
    """How a search ended.

    Attributes
    ----------
    name, stop : str
        The method, and why it stopped.
    converged : bool
        Whether the point is a solution within the tolerances.
    iterations, evaluations : int
    cost : float or None
        Value of the objective, without unit.
    """

    name: str
    stop: str
    converged: bool
    iterations: int
    evaluations: int
    cost: float | None


@dataclass(frozen=True)
class Recorded:
    """A recording beside what the models predict, after preprocessing.

    Attributes
    ----------
    name : str
    split : str
        `"train"` or `"validation"`.
    t : ndarray
        Time, s.
    series : dict
        Arrays as long as `t` by (joint, quantity): `recorded`, `predicted` (of a diagnosis `baseline` and `final`) in the
        unit of the signal, `velocity` in rad/s (m/s).
    """

    name: str
    split: str
    t: NDArray[np.float64]
    series: dict[tuple[str, str], NDArray[np.float64]] = field(repr=False)

    @property
    def joints(self) -> list[str]:
        """Joints with a recorded signal."""
        return [joint for joint, quantity in self.series if quantity == "recorded"]

    def residual(self, joint: str, of: str | None = None) -> NDArray[np.float64]:
        """Predicted minus recorded, in the unit of the signal.

        Parameters
        ----------
        joint : str
        of : str, optional
            `"predicted"`, `"baseline"` or `"final"`; the last model there is if None.
        """
        model = of or self.last_model(joint)
        return self.series[joint, model] - self.series[joint, "recorded"]

    def last_model(self, joint: str) -> str:
        """Quantity of the last model's predictions."""
        return "final" if (joint, "final") in self.series else "predicted"


@dataclass(frozen=True)
class Export:
    """Files of another format.

    Attributes
    ----------
    files : dict
        Texts by the names of the files.
    notes : list of str
        What the format has no place for.
    folder : Path or None
        Where the files are.
    """

    files: dict[str, str]
    notes: list[str]
    folder: Path | None = None


class Result:
    """What a run found.

    Every key of `result.json` is an item, `result["condition_number"]`; what is used most is an attribute.
    """

    def __init__(self, core: _core.Run, source: str = "") -> None:
        self.core = core
        self.source = source or str(core.folder() or "")
        self.document: dict[str, Any] = json.loads(core.json())
        """Everything in `result.json`."""

    @staticmethod
    def of(core: _core.Run) -> Result:
        """A result of the kind of its verb."""
        verb = json.loads(core.json())["verb"]
        return _KINDS.get(verb, Result)(core)

    def __getitem__(self, key: str) -> Any:
        return self.document[key]

    def __contains__(self, key: str) -> bool:
        return key in self.document

    @property
    def name(self) -> str:
        """Name of the problem."""
        return str(self.document["name"])

    @property
    def verb(self) -> str:
        """The verb that was run."""
        return str(self.document["verb"])

    @property
    def version(self) -> str:
        """Version of exid that made the result."""
        return str(self.document["version"])

    @property
    def seed(self) -> int:
        """Seed of everything random."""
        return int(self.document["seed"])

    @property
    def wall_s(self) -> float:
        """Wall time of the run, s."""
        return float(self.document["wall_s"])

    @property
    def inputs(self) -> list[dict[str, str]]:
        """Path and SHA-256 of everything that was read."""
        return list(self.document["inputs"])

    @property
    def exit_code(self) -> int | None:
        """What the program would exit with; None of a result that was loaded."""
        return self.core.exit_code()

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended the run before its end."""
        solver = self.solver
        return self.exit_code == 130 or (solver is not None and solver.stop == "interrupted")

    @property
    def solver(self) -> Solver | None:
        """How the search ended, where there was one."""
        solver = self.document.get("solver")
        if solver is None:
            return None
        return Solver(**{key: solver[key] for key in Solver.__dataclass_fields__})

    @property
    def mistakes(self) -> list[Finding]:
        """What the inputs say wrongly, the worst first."""
        return [Finding.of(entry) for entry in self.document.get("mistakes", [])]

    @property
    def findings(self) -> list[Finding]:
        """Findings of a check or a diagnosis, the strongest first."""
        return [Finding.of(entry) for entry in self.document.get("findings", [])]

    @property
    def notes(self) -> list[str]:
        """What a reader should know, one sentence each."""
        return list(self.document.get("notes", []))

    @cached_property
    def summary(self) -> str:
        """What the program prints."""
        return self.core.summary()

    @cached_property
    def plot(self) -> Plots:
        """Plots of the result on axes of matplotlib."""
        return Plots(self)

    def save(self, folder: str | os.PathLike[str]) -> None:
        """Write the results folder, as the program does: an earlier result is replaced whole or not at all.

        Parameters
        ----------
        folder : path
            Absent, empty, or an earlier result.
        """
        self.core.save(os.fspath(folder))
        self.source = self.source or os.fspath(folder)

    def export(self, to: str, out: str | os.PathLike[str] | None = None) -> Export:
        """The identified robot in another format; see :func:`exid.export`."""
        made = self.core.export(to)
        files = dict(made["files"])
        folder = None
        if out is not None:
            folder = Path(out)
            folder.mkdir(parents=True, exist_ok=True)
            for name, text in files.items():
                partial = folder / f".{name}.partial"
                partial.write_text(text, encoding="utf-8")
                partial.replace(folder / name)
        return Export(files, made["notes"], folder)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name!r}>\n{self.summary}"

    def _repr_html_(self) -> str:
        return _html(self)


class _Estimated(Result):
    """A result with parameters."""

    @cached_property
    def parameters(self) -> Any:
        """Frame (pandas if there, else polars, else a dictionary of lists): name, unit, value, std_dev, lower and upper end of the
        95 % interval, source (`data`, `prior`, `bound`, `known` or `undetermined`)."""
        return frame(
            {
                "name": entry["name"],
                "unit": entry["unit"],
                "value": entry["value"],
                "std_dev": entry["std_dev"],
                "ci95_lower": (entry["ci95"] or [None, None])[0],
                "ci95_upper": (entry["ci95"] or [None, None])[1],
                "source": entry["source"],
            }
            for entry in self.document["parameters"]
        )

    def value(self, name: str) -> float | None:
        """Value of a parameter by its name, in its unit; None where the data do not determine it."""
        for entry in self.document["parameters"]:
            if entry["name"] == name:
                value = entry["value"]
                return None if value is None else float(value)
        raise KeyError(name)

    @cached_property
    def joints(self) -> Any:
        """Frame of the errors of each joint, in the unit of the signal."""
        return frame(self.document["joints"])

    @property
    def covariance(self) -> NDArray[np.float64]:
        """Covariance matrix of the estimated parameters, in the order of :attr:`covariance_names`; units are products of theirs."""
        matrix = (self.document.get("covariance") or {}).get("matrix", [])
        return np.array(matrix, dtype=float).reshape(len(matrix), len(matrix))

    @property
    def covariance_names(self) -> list[str]:
        """Names of the parameters of the covariance matrix."""
        return list((self.document.get("covariance") or {}).get("parameters", []))

    @cached_property
    def predictions(self) -> list[Recorded]:
        """Every recording beside what the models predict."""
        return [Recorded(name, split, _time(series), _others(series)) for name, split, series in self.core.predictions()]


class FitResult(_Estimated):
    """What :func:`exid.fit` found."""

    @cached_property
    def base_parameters(self) -> Any:
        """Frame of the combinations of parameters that the data determine: expression, unit, value, std_dev."""
        entries = self.document["base_parameters"]
        return frame(
            {key: entry.get(key) for key in ("expression", "unit", "value", "std_dev")}
            for entry in entries
        )

    @property
    def rank(self) -> int:
        """Number of combinations that the data determine."""
        return int(self.document["rank"])

    @property
    def condition_number(self) -> float:
        """Condition number of the whitened regressor with columns of one size."""
        return float(self.document["condition_number"])

    @property
    def feasible(self) -> bool | None:
        """Whether bodies exist with these parameters."""
        feasible = self.document["feasible"]
        return None if feasible is None else bool(feasible)

    @property
    def converged(self) -> bool:
        """Whether the search ended with a solution."""
        return self.solver is None or self.solver.converged


class DiagnoseResult(_Estimated):
    """What :func:`exid.diagnose` found."""

    @property
    def verdict(self) -> str | None:
        """`"nothing_missing"`, `"explained"`, `"partly_explained"` or `"unexplained"`."""
        verdict = self.document["verdict"]
        return None if verdict is None else str(verdict)

    @property
    def words(self) -> str:
        """What was found, a paragraph in plain words."""
        return str(self.document["summary"])

    @property
    def next_experiment(self) -> dict[str, Any] | None:
        """The recording that would tell rivals apart: `sentence` and `problem` (the text of a problem file)."""
        next_experiment = self.document["next_experiment"]
        return None if next_experiment is None else dict(next_experiment)


class CheckResult(Result):
    """What :func:`exid.check` found."""

    @property
    def ok(self) -> bool:
        """Whether nothing is wrong with the inputs that has to be mended."""
        return all(finding.severity != "error" for finding in self.findings)


class DesignResult(Result):
    """What :func:`exid.design` found."""

    @cached_property
    def trajectories(self) -> dict[str, dict[str, NDArray[np.float64]]]:
        """Trajectories by name: `t` in s, `q_<joint>` in rad (m), then `dq_` and `ddq_`."""
        tables = self.core.tables()
        if tables is None:
            files = [file for file in self.document["files"] if file.endswith(".csv")]
            tables = {file.removesuffix(".csv"): table for file, table in _read_tables(self.core, files).items()}
        return dict(tables)

    @property
    def trajectory(self) -> dict[str, NDArray[np.float64]]:
        """The first trajectory, one period from t = 0."""
        return next(iter(self.trajectories.values()))

    @property
    def criterion_value(self) -> float:
        """Value of the criterion, without unit."""
        return float(self.document["criterion_value"])

    @property
    def condition_number(self) -> float:
        """Condition number of the matrix that `design.scaling` names."""
        return float(self.document["condition_number"])

    @cached_property
    def expected_std_dev(self) -> Any:
        """Frame: the standard deviation of each parameter that a recording of the trajectory promises, with its unit."""
        return frame(self.document["expected_std_dev"])

    @cached_property
    def worst_margins(self) -> Any:
        """Frame: where the trajectory comes closest to each limit."""
        return frame(self.document["worst_margins"])


class SimulateResult(Result):
    """What :func:`exid.simulate` made."""

    @cached_property
    def recordings(self) -> dict[str, dict[str, NDArray[np.float64]]]:
        """Recordings by the names of their files, columns by theirs, SI units."""
        tables = self.core.tables()
        return _read_tables(self.core, list(self.document["files"])) if tables is None else dict(tables)

    @cached_property
    def truth(self) -> Any:
        """Frame of every value behind the recordings: name, unit, value."""
        return frame(
            {key: entry[key] for key in ("name", "unit", "value")}
            for entry in self.document["parameters"]
        )


class RolloutResult(Result):
    """What :func:`exid.rollout` found."""

    @cached_property
    def horizons(self) -> Any:
        """Frame: errors of position after each horizon (s) for each joint, in rad or m."""
        rows = []
        for horizon in self.document["horizons"]:
            for joint in horizon["joints"]:
                row = {"horizon": horizon["horizon"], "joint": joint["joint"], "unit": joint["unit"]}
                for model in ("before", "after", "noise"):
                    spread = joint[model] or {}
                    row[f"{model}_median"] = spread.get("median")
                    row[f"{model}_rms"] = spread.get("rms")
                rows.append(row)
        return frame(rows)


_KINDS: dict[str, type[Result]] = {
    "fit": FitResult,
    "check": CheckResult,
    "diagnose": DiagnoseResult,
    "design": DesignResult,
    "simulate": SimulateResult,
    "rollout": RolloutResult,
}


def _time(series: dict[tuple[str, str], NDArray[np.float64]]) -> NDArray[np.float64]:
    return series["", "t"]


def _others(
    series: dict[tuple[str, str], NDArray[np.float64]],
) -> dict[tuple[str, str], NDArray[np.float64]]:
    return {key: values for key, values in series.items() if key[0]}


def _read_tables(core: _core.Run, files: Sequence[str]) -> dict[str, dict[str, NDArray[np.float64]]]:
    """Tables of a results folder."""
    folder = Path(str(core.folder()))
    tables = {}
    for file in files:
        path = folder / file
        columns = np.genfromtxt(path, delimiter=",", names=True, deletechars="", encoding="utf-8")
        tables[file] = {
            name: np.asarray(columns[name], dtype=np.float64) for name in columns.dtype.names or ()
        }
    return tables


def _html(result: Result) -> str:
    """The words of the program, and the parameters from data as a table."""
    words = html.escape(result.summary)
    return (
        f"<div><strong>exid {result.verb}</strong> · {html.escape(result.name)}"
        f'<pre style="line-height:1.35;font-size:0.9em;overflow-x:auto">{words}</pre></div>'
    )
