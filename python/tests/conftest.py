"""What the tests share: the repository, the program beside the package, results that several tests look at."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Callable

import matplotlib
import pytest

import exid

matplotlib.use("Agg")

ROOT = Path(__file__).resolve().parents[2]

TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))

#: The program beside the package.
PROGRAM = Path(os.environ.get("EXID_PROGRAM", TARGET / "release" / "exid")).absolute()

Program = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture(autouse=True)
def in_root(monkeypatch: pytest.MonkeyPatch) -> None:
    """Paths of problems are those of the repository."""
    monkeypatch.chdir(ROOT)


@pytest.fixture(scope="session")
def program() -> Program:
    """Runs the program with arguments."""
    if not PROGRAM.exists():
        pytest.fail(f"{PROGRAM} is missing; build it with cargo build --release, or name it in EXID_PROGRAM")

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [str(PROGRAM), *arguments]
        return subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)

    return run


@pytest.fixture(scope="session")
def fitted() -> exid.FitResult:
    """The shipped arm, fitted."""
    here = os.getcwd()
    os.chdir(ROOT)
    try:
        return exid.fit("problems/arm6/problem.toml")
    finally:
        os.chdir(here)


@pytest.fixture(scope="session")
def diagnosed() -> exid.DiagnoseResult:
    """The arm whose gearbox loses torque, diagnosed."""
    here = os.getcwd()
    os.chdir(ROOT)
    try:
        return exid.diagnose("problems/arm6_gearbox/problem.toml")
    finally:
        os.chdir(here)
