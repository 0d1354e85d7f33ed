"""Recordings in memory: where they are read, and that they give what files give."""

from __future__ import annotations

import csv
import gzip
from pathlib import Path

import numpy as np
import pandas
import polars
import pytest
from numpy.typing import NDArray

import exid
from exid.data import arrays

Columns = dict[str, NDArray[np.float64]]


def read(name: str) -> Columns:
    """A shipped recording as columns."""
    with gzip.open(Path("problems/arm6") / name, "rt") as file:
        rows = list(csv.reader(file))
    table = np.array(rows[1:], dtype=float)
    return {column: table[:, k].copy() for k, column in enumerate(rows[0])}


@pytest.fixture
def columns() -> Columns:
    return read("train.csv.gz")


@pytest.fixture
def validation() -> Columns:
    return read("validation.csv.gz")


def assert_same_parameters(first: exid.FitResult, second: exid.FitResult) -> None:
    assert first["parameters"] == second["parameters"]
    assert first["joints"] == second["joints"]
    assert np.array_equal(first.covariance, second.covariance)


def test_the_reader_reads_where_numpy_has_the_numbers() -> None:
    rng = np.random.default_rng(0)
    by_rows = rng.normal(size=(50, 6))
    by_columns = np.asfortranarray(rng.normal(size=(50, 6)))
    vector = np.arange(50.0)
    held = arrays({"q": by_rows, "tau": by_columns, "t": vector})
    assert held.addresses() == {
        "q": by_rows.ctypes.data,
        "tau": by_columns.ctypes.data,
        "t": vector.ctypes.data,
    }


def test_what_is_not_float64_or_not_in_one_piece_is_converted() -> None:
    strided = np.zeros((50, 12))[:, ::2]
    short = np.zeros(50, dtype=np.float32)
    addresses = arrays({"q": strided, "t": short}).addresses()
    assert addresses["q"] != strided.ctypes.data
    assert addresses["t"] != short.ctypes.data


def test_arrays_give_what_the_files_give(
    fitted: exid.FitResult, columns: Columns, validation: Columns
) -> None:
    result = exid.fit("problems/arm6/problem.toml", {"train": columns, "validation": validation})
    assert_same_parameters(result, fitted)
    assert [r.name for r in result.predictions] == ["train", "validation"]
    hashed = {entry["path"]: entry["sha256"] for entry in result.inputs}
    assert len(hashed["problems/arm6/train"]) == 64


def test_groups_that_are_not_given_stay_those_of_the_problem(
    fitted: exid.FitResult, columns: Columns
) -> None:
    result = exid.fit("problems/arm6/problem.toml", columns)
    assert_same_parameters(result, fitted)
    assert {r.name for r in result.predictions} == {"train", "validation.csv.gz"}


@pytest.mark.parametrize("kind", ["pandas", "pandas of one block", "polars", "matrices", "list"])
def test_frames_and_matrices_give_what_columns_give(
    kind: str, fitted: exid.FitResult, columns: Columns
) -> None:
    joints = [name for name in columns if name not in ("t", "time")]
    given: object
    match kind:
        case "pandas":
            given = pandas.DataFrame(columns)
        case "pandas of one block":
            given = pandas.DataFrame(np.column_stack(list(columns.values())), columns=list(columns))
        case "polars":
            given = polars.DataFrame(columns)
        case "list":
            given = [columns]
        case _:
            groups = dict.fromkeys(name.rstrip("0123456789") for name in joints)
            given = {
                group: np.column_stack([columns[name] for name in joints if name.rstrip("0123456789") == group])
                for group in groups
            }
            given |= {name: columns[name] for name in columns if name not in joints}
    result = exid.fit("problems/arm6/problem.toml", given)  # type: ignore[arg-type]
    assert_same_parameters(result, fitted)


def test_paths_are_found_from_where_the_call_is(fitted: exid.FitResult) -> None:
    result = exid.fit(
        "problems/arm6/problem.toml",
        {"train": "problems/arm6/train.csv.gz", "validation": ["problems/arm6/validation.csv.gz"]},
    )
    assert_same_parameters(result, fitted)


def test_a_simulation_is_data(tmp_path: Path) -> None:
    simulated = exid.simulate("problems/arm6/problem.toml", seed=3)
    names = sorted(simulated.recordings)
    train = next(name for name in names if name.startswith("train"))
    result = exid.fit("problems/arm6/problem.toml", simulated.recordings[train])
    truth = {row["name"]: row["value"] for row in simulated["parameters"]}
    for joint in ("a1", "a2", "a3"):
        name = f"{joint}.coulomb_friction.Fc"
        value = result.value(name)
        assert value is not None
        assert value == pytest.approx(truth[name], rel=0.05)


def test_a_rollout_refuses_arrays_that_have_changed(columns: Columns) -> None:
    result = exid.fit("problems/arm6/problem.toml", columns)
    exid.rollout(result, threads=1)
    first = next(iter(columns))
    columns[first][3] += 1.0
    with pytest.raises(exid.DataError) as caught:
        exid.rollout(result)
    assert caught.value.code == "changed-inputs"
