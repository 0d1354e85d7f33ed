"""Problems as files, tables and objects."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import exid
from conftest import Program
from exid import _core, tables

ROOT = Path(__file__).resolve().parents[2]


def answer(result: exid.Result) -> dict[str, object]:
    document = dict(result.document)
    for key in ("wall_s", "provenance", "inputs"):
        del document[key]
    return document


def test_a_table_and_an_object_are_the_file(fitted: exid.FitResult) -> None:
    problem = exid.Problem.from_file("problems/arm6/problem.toml")
    assert problem.name == "arm6"
    assert problem.robot["urdf"] == "arm6.urdf"
    assert answer(exid.fit(problem)) == answer(fitted)
    table = problem.to_dict()
    table["robot"]["urdf"] = "problems/arm6/arm6.urdf"
    for group in ("train", "validation"):
        files = table["recordings"][group]
        table["recordings"][group] = [f"problems/arm6/{file}" for file in files]
    again = exid.fit(table)
    assert again["parameters"] == fitted["parameters"]


def test_a_saved_result_of_a_table_is_rolled_out_and_repeated(
    fitted: exid.FitResult, program: Program, tmp_path: Path
) -> None:
    problem = exid.Problem.from_file("problems/arm6/problem.toml")
    exid.fit(problem, out=tmp_path / "fit")
    rolled = exid.rollout(exid.load(tmp_path / "fit"))
    assert rolled["horizons"] == exid.rollout(fitted)["horizons"]
    ran = program("repeat", str(tmp_path / "fit"))
    assert ran.returncode == 0, ran.stdout + ran.stderr


def test_a_problem_is_made_of_a_robot_file() -> None:
    problem = exid.Problem.from_urdf(
        "problems/arm6/arm6.urdf",
        drive={"effects": ["coulomb_friction"]},
        robot={"gravity": np.array([0.0, 0.0, -9.81])},
        simulate={"values": {f"a{n}.Fc": 1.0 for n in range(1, 7)}, "periods": 1},
    )
    simulated = exid.simulate(problem)
    assert set(simulated.recordings)


def test_a_law_is_a_table() -> None:
    law = exid.Law("cogging", "a*sin(8*q)", parameters={"a": {"unit": "N*m", "typical": 0.1}})
    problem = exid.Problem.from_urdf("arm.urdf", law=[law])
    assert problem.to_dict()["law"] == [
        {
            "id": "cogging",
            "acts_on": "motor",
            "torque": "a*sin(8*q)",
            "parameters": {"a": {"unit": "N*m", "typical": 0.1}},
        }
    ]
    assert exid.Problem.from_dict(problem.to_dict()).law == [law]


def test_infinite_bounds_are_kept() -> None:
    table = exid.Problem.from_file("problems/arm6/problem.toml").to_dict()
    table["fit"] = {"bounds": {"a1.Fc": [0.0, float("inf")]}, "estimator": "ols"}
    problem = exid.Problem.from_dict(table, folder="problems/arm6")
    assert exid.check(problem).ok


def test_types_of_tables_are_those_of_the_schema() -> None:
    made = subprocess.run(
        [sys.executable, str(ROOT / "python" / "tables")],
        input=_core.schema(), capture_output=True, text=True, check=True,
    )
    written = Path(tables.__file__).read_text(encoding="utf-8")
    assert ast.dump(ast.parse(made.stdout)) == ast.dump(ast.parse(written))
    schema = json.loads(_core.schema())["properties"]
    fields = set(exid.Problem.__dataclass_fields__) - {"law", "folder"}
    assert fields == set(schema) - {"law"}


def test_an_example_comes_with_the_package() -> None:
    file = exid.example()
    assert ROOT not in file.parents
    result = exid.diagnose(file)
    assert result.verdict == "explained"
    assert [finding.kind for finding in result.findings] == ["transmission_efficiency"]
    with pytest.raises(ValueError, match="'arm7'; there are arm6, arm6_gearbox"):
        exid.example("arm7")
