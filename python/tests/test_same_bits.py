"""Every call gives the bits of the program: result.json but for provenance and wall time, and every other file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import exid

from conftest import Program

# A design that ends by its number of starts repeats to the bit; one that ends by its budget does not.
SHORT_DESIGN = {"design.starts": 2, "design.budget_s": 600}

CASES = [
    ("fit", "arm6", {}),
    ("fit", "kr150_payload", {}),
    ("fit", "ur5_motors", {}),
    ("fit", "arm6", {"fit.estimator": "feasible"}),
    ("check", "arm6", {}),
    ("check", "arm6", {"recordings.train": ["absent.csv"]}),
    ("diagnose", "arm6_gearbox", {}),
    ("design", "scara_excitation", SHORT_DESIGN),
    ("simulate", "arm6", {}),
]


def document(folder: Path) -> dict[str, Any]:
    """What a result answers; provenance and wall time differ from run to run."""
    result: dict[str, Any] = json.loads((folder / "result.json").read_text())
    del result["wall_s"], result["provenance"]
    for improvement in result.get("convergence", []):
        del improvement["elapsed_s"]
    return result


def assert_same(first: Path, second: Path) -> None:
    assert document(first) == document(second)
    # The report shows provenance and wall time.
    others = {p.name for p in first.iterdir()} - {"result.json", "report.html"}
    assert {p.name for p in second.iterdir()} - {"result.json", "report.html"} == others
    for name in others:
        assert (first / name).read_bytes() == (second / name).read_bytes(), name


@pytest.mark.parametrize(("verb", "name", "keys"), CASES, ids=lambda part: str(part)[:24])
def test_a_call_gives_the_bits_of_the_program(
    verb: str, name: str, keys: dict[str, Any], program: Program, tmp_path: Path
) -> None:
    problem = f"problems/{name}/problem.toml"
    sets = [word for key, value in keys.items() for word in ("--set", f"{key}={json.dumps(value)}")]
    ran = program(verb, problem, "--out", str(tmp_path / "program"), "--quiet", *sets)
    result = getattr(exid, verb)(problem, set=keys, out=tmp_path / "package")
    assert result.exit_code == ran.returncode, ran.stderr
    assert_same(tmp_path / "program", tmp_path / "package")


def test_a_seed_is_that_of_the_program(program: Program, tmp_path: Path) -> None:
    problem = "problems/arm6/problem.toml"
    ran = program("simulate", problem, "--seed", "7", "--out", str(tmp_path / "program"), "--quiet")
    assert ran.returncode == 0, ran.stderr
    exid.simulate(problem, seed=7, threads=1, out=tmp_path / "package")
    assert_same(tmp_path / "program", tmp_path / "package")


def test_a_rollout_gives_the_bits_of_the_program(program: Program, tmp_path: Path) -> None:
    fitted = tmp_path / "fit"
    exid.fit("problems/arm6/problem.toml", out=fitted)
    ran = program("rollout", str(fitted), "--out", str(tmp_path / "program"), "--quiet")
    assert ran.returncode == 0, ran.stderr
    exid.rollout(fitted, out=tmp_path / "package")
    assert_same(tmp_path / "program", tmp_path / "package")


@pytest.mark.parametrize("to", ["urdf", "mjcf", "mujoco", "toml", "rust", "c", "numpy"])
def test_an_export_gives_the_bytes_of_the_program(
    to: str, fitted: exid.FitResult, program: Program, tmp_path: Path
) -> None:
    fitted.save(tmp_path / "fit")
    ran = program("export", str(tmp_path / "fit"), "--to", to, "--out", str(tmp_path / "program"))
    assert ran.returncode == 0, ran.stderr
    made = exid.export(fitted, to, out=tmp_path / "package")
    written = {p.name: p.read_bytes() for p in (tmp_path / "program").iterdir()}
    assert {name: text.encode() for name, text in made.files.items()} == written
    assert {p.name: p.read_bytes() for p in (tmp_path / "package").iterdir()} == written


def test_the_number_of_threads_changes_no_bit(fitted: exid.FitResult) -> None:
    again = exid.fit("problems/arm6/problem.toml", threads=1)
    first, second = dict(fitted.document), dict(again.document)
    for document in (first, second):
        del document["wall_s"], document["provenance"]
    assert first == second
