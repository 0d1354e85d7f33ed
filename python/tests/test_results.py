"""What results give: frames, arrays, plots, folders."""

from __future__ import annotations

import pydoc
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas
import pytest
from matplotlib.axes import Axes

import exid


def test_parameters_are_a_frame_with_units(fitted: exid.FitResult) -> None:
    frame = fitted.parameters
    assert isinstance(frame, pandas.DataFrame)
    row = frame.set_index("name").loc["a1.coulomb_friction.Fc"]
    assert row["unit"] == "N·m" and row["source"] == "data"
    assert row["ci95_lower"] < row["value"] < row["ci95_upper"]
    assert fitted.value("a1.coulomb_friction.Fc") == row["value"]


@pytest.mark.parametrize("absent", [["pandas"], ["pandas", "polars"]])
def test_frames_are_of_what_is_there(absent: list[str]) -> None:
    code = f"""
import sys
for name in {absent!r}:
    sys.modules[name] = None
import importlib.util
found = importlib.util.find_spec
importlib.util.find_spec = lambda name: None if name in {absent!r} else found(name)
import exid
print(type(exid.fit("problems/arm6/problem.toml").parameters).__module__)
"""
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout.startswith("polars" if len(absent) == 1 else "builtins")


def test_the_covariance_is_that_of_the_standard_deviations(fitted: exid.FitResult) -> None:
    covariance = fitted.covariance
    names = fitted.covariance_names
    assert covariance.shape == (len(names), len(names))
    assert np.array_equal(covariance, covariance.T)
    frame = fitted.parameters.set_index("name")
    for name in ("a1.coulomb_friction.Fc", "a4.viscous_friction.Fv"):
        at = names.index(name)
        assert np.sqrt(covariance[at, at]) == pytest.approx(frame.loc[name, "std_dev"], rel=1e-9)


def test_predictions_have_the_errors_that_the_result_states(fitted: exid.FitResult) -> None:
    held_out = next(r for r in fitted.predictions if r.split == "validation")
    for entry in fitted["joints"]:
        residual = held_out.residual(entry["joint"])
        assert np.sqrt(np.mean(residual**2)) == pytest.approx(entry["rmse_validation"], rel=1e-9)


def test_a_diagnosis_names_what_is_missing(diagnosed: exid.DiagnoseResult) -> None:
    assert diagnosed.verdict == "explained"
    finding = diagnosed.findings[0]
    assert (finding.kind, finding.joints) == ("transmission_efficiency", ["a3"])
    assert finding.probability is not None and finding.probability > 0.9


def test_a_folder_is_read_as_it_was_saved(fitted: exid.FitResult, tmp_path: Path) -> None:
    fitted.save(tmp_path / "first")
    loaded = exid.load(tmp_path / "first")
    assert isinstance(loaded, exid.FitResult)
    assert loaded.document == fitted.document
    series = loaded.predictions[0].series["a1", "predicted"]
    assert np.allclose(series, fitted.predictions[0].series["a1", "predicted"], rtol=1e-9)
    loaded.save(tmp_path / "second")
    for path in (tmp_path / "first").iterdir():
        assert path.read_bytes() == (tmp_path / "second" / path.name).read_bytes()


def test_a_folder_of_others_is_not_replaced(fitted: exid.FitResult, tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("mine")
    with pytest.raises(exid.ProblemError) as caught:
        fitted.save(tmp_path)
    assert caught.value.code == "out-is-not-a-result"
    heard: list[str] = []
    with pytest.raises(exid.ProblemError):
        exid.fit("problems/arm6/problem.toml", progress=heard.append, out=tmp_path)
    assert heard == [], "refused before the work"


def test_tables_of_a_loaded_result_are_those_that_were_made(tmp_path: Path) -> None:
    made = exid.simulate("problems/arm6/problem.toml", out=tmp_path / "simulated")
    loaded = exid.load(tmp_path / "simulated")
    assert isinstance(loaded, exid.SimulateResult)
    assert list(loaded.recordings) == list(made.recordings)
    for name, columns in made.recordings.items():
        for column, values in columns.items():
            assert np.allclose(loaded.recordings[name][column], values, rtol=1e-6, atol=1e-6)


def test_every_plot_gives_its_axes(fitted: exid.FitResult, diagnosed: exid.DiagnoseResult) -> None:
    rolled = exid.rollout(diagnosed)
    plots = [
        fitted.plot.residuals(),
        fitted.plot.prediction("a2"),
        fitted.plot.friction("a2"),
        diagnosed.plot.residuals(),
        diagnosed.plot.prediction("a3"),
        diagnosed.plot.friction("a3"),
        diagnosed.plot.evidence(),
        rolled.plot.rollout(),
        rolled.plot.rollout("a3"),
    ]
    for axes in plots:
        assert isinstance(axes, Axes)
        assert axes.get_title()
        axes.figure.canvas.draw()
    again = fitted.plot.residuals(plots[0])
    assert again is plots[0]


def test_the_line_of_friction_is_that_of_the_parameters(fitted: exid.FitResult) -> None:
    axes = fitted.plot.friction("a1")
    line = next(line for line in axes.lines if line.get_label() == "fitted law")
    x, y = (np.asarray(values, dtype=float) for values in line.get_data())
    viscous, coulomb = (fitted.value(f"a1.{name}") for name in ("viscous_friction.Fv", "coulomb_friction.Fc"))
    assert viscous is not None and coulomb is not None
    constant = fitted["problem"]["drive"]["torque_constant"][0]
    width = fitted.value("a1.coulomb_friction.w") or 0.0
    expected = (coulomb * x[-1] / (x[-1] + width) + viscous * x[-1]) / constant
    assert y[-1] == pytest.approx(expected, rel=1e-6)


def test_what_has_no_such_plot_says_so(fitted: exid.FitResult) -> None:
    with pytest.raises(ValueError, match="exid.diagnose"):
        fitted.plot.evidence()
    with pytest.raises(ValueError, match="a9"):
        fitted.plot.prediction("a9")


def test_words_for_notebooks_and_terminals(fitted: exid.FitResult) -> None:
    assert "arm6: fit" in repr(fitted)
    assert "<pre" in fitted._repr_html_() and "RMSE" in fitted._repr_html_()


@pytest.mark.parametrize("name", ["fit", "check", "diagnose", "design", "simulate", "rollout", "export", "load"])
def test_help_answers(name: str) -> None:
    text = pydoc.render_doc(getattr(exid, name))
    assert "Returns" in text
