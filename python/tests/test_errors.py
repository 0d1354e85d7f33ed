"""Errors say place, value, remedy and code; Ctrl-C, progress and threads of Python go on beside a run."""

from __future__ import annotations

import os
import pickle
import signal
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import exid

ARM = "problems/arm6/problem.toml"
LONG_DESIGN = {"design.budget_s": 120, "design.starts": 100000}


def test_an_unknown_key_is_an_error_of_the_problem_with_its_place() -> None:
    with pytest.raises(exid.ProblemError) as caught:
        exid.fit(ARM, set={"fit.estimatr": "wls"})
    error = caught.value
    assert error.exit_code == 2
    assert error.code == "unknown-key"
    assert error.value == "estimatr"
    assert error.place is not None and error.place.key is not None and "estimatr" in error.place.key
    assert error.remedy is not None and "estimator" in error.remedy


def test_a_line_of_a_file_is_told(tmp_path: Path) -> None:
    path = tmp_path / "problem.toml"
    path.write_text('[robot]\nurdf = "arm.urdf"\n[fit]\nestimator = "best"\n')
    with pytest.raises(exid.ProblemError) as caught:
        exid.check(path)
    place = caught.value.place
    assert place == exid.Place(str(path), 4, place.column if place else None, "fit.estimator")
    assert caught.value.value == "best"


def test_an_absent_recording_is_an_error_of_the_data() -> None:
    with pytest.raises(exid.DataError) as caught:
        exid.fit(ARM, "absent.csv")
    assert caught.value.exit_code == 3
    assert caught.value.place is not None
    assert caught.value.place.file == os.path.abspath("absent.csv")


def test_a_missing_column_of_arrays_names_the_array() -> None:
    with pytest.raises(exid.DataError) as caught:
        exid.fit(ARM, {"t": np.arange(100.0)})
    assert caught.value.place is not None
    assert caught.value.place.file.endswith("train")


def test_errors_travel_between_processes() -> None:
    with pytest.raises(exid.ExidError) as caught:
        exid.fit(ARM, set={"fit.estimatr": "wls"})
    again = pickle.loads(pickle.dumps(caught.value))
    assert type(again) is exid.ProblemError
    assert again.__dict__ == caught.value.__dict__
    assert str(again) == str(caught.value)


def test_what_is_no_recording_is_a_type_error() -> None:
    with pytest.raises(TypeError, match="arrays by name"):
        exid.fit(ARM, 3)  # type: ignore[arg-type]


def test_progress_is_told_in_words() -> None:
    heard: list[str] = []
    exid.fit(ARM, progress=heard.append)
    assert heard[0] == "looking for mistakes in the inputs"
    assert "fitting" in heard


def test_what_a_callback_raises_ends_the_run() -> None:
    def stop(words: str) -> None:
        raise LookupError(words)

    with pytest.raises(LookupError, match="looking for mistakes"):
        exid.fit(ARM, progress=stop)


def test_ctrl_c_gives_what_there_is() -> None:
    # A shell that runs this in the background has interrupts ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    started = time.monotonic()
    timer = threading.Timer(2.0, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.warns(exid.InterruptedWarning):
        result = exid.design("problems/scara_excitation/problem.toml", set=LONG_DESIGN)
    assert time.monotonic() - started < 60.0
    assert result.interrupted and result.exit_code == 130
    assert result.trajectory["t"].size > 100


def test_other_threads_of_python_run_meanwhile() -> None:
    counted = 0
    done = threading.Event()

    def count() -> None:
        nonlocal counted
        while not done.wait(0.001):
            counted += 1

    thread = threading.Thread(target=count)
    thread.start()
    started = time.monotonic()
    exid.fit(ARM)
    seconds = time.monotonic() - started
    done.set()
    thread.join()
    # With the GIL held there would be none; half a processor's share of turns is far below what a free one gives.
    assert counted > 10 * seconds


def test_a_robot_file_that_is_none(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text("<robot")
    with pytest.raises(exid.DataError):
        exid.Robot.from_urdf(path)
