"""Fleets on engines: the same table whatever the engine, and parts that are lost are done again."""

from __future__ import annotations

import math
import shutil
import stat
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from dask.distributed import Client, LocalCluster

from exid import fleet

from conftest import PROGRAM, ROOT, Program

#: A robot of one joint and its problem, which the tests of the program have too.
SHARED = ROOT / "tests" / "data" / "fleet"


def make(folder: Path, items: int) -> Path:
    """A fleet of a robot of one joint."""
    for name in ("r.urdf", "p.toml"):
        shutil.copy(SHARED / name, folder)
    rows = ["robot,type,recordings,problem,time"]
    for n in range(items):
        lines = ["t,q1,tau1"]
        for k in range(600):
            t = 0.01 * k
            angle, speed = 2 * math.pi * 0.5 * t, math.pi
            q, v, a = math.sin(angle), speed * math.cos(angle), -speed * speed * math.sin(angle)
            noise = 0.01 * math.sin(12.9898 * (k + 77 * n)) + 0.01 * math.sin(78.233 * k * (n + 1))
            gravity = -4 * 9.81 * 0.2 * math.cos(q)
            tau = (0.06 + 4 * 0.04 + 0.1) * a + gravity + 2.0 * v / (abs(v) + 0.01) + 1.0 * v + noise
            lines.append(f"{t:.2f},{q:.9f},{tau:.6f}")
        (folder / f"{n}.csv").write_text("\n".join(lines))
        rows.append(f"r{n % 3},t,{n}.csv,p.toml,{n}")
    manifest = folder / "nights.csv"
    manifest.write_text("\n".join(rows) + "\n")
    return manifest


def test_a_program_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(fleet.FleetError, match="no_such_program"):
        fleet.run(tmp_path / "m.csv", ThreadPoolExecutor(1), program="no_such_program")


def test_engines_and_stores_give_the_table_of_the_program(program: Program, tmp_path: Path) -> None:
    manifest = make(tmp_path, 9)
    ran = program("fleet", str(manifest), "--out", str(tmp_path / "program"), "--quiet")
    assert ran.returncode == 0, ran.stderr
    tables = [(tmp_path / "program" / "summary.parquet").read_bytes()]
    with ThreadPoolExecutor(2) as pool:
        plain = fleet.run(manifest, pool, out=tmp_path / "a", program=str(PROGRAM), parts=4)
        tables.append((plain.folder / "summary.parquet").read_bytes())
        assert plain.result["items"] == 9 and plain.result["set_aside"] == 0, plain.result
        assert plain.summary.startswith("9 items of 3 robots")
        assert set(plain.table()["robot"]) == {"r0", "r1", "r2"}
        store = f"file://{tmp_path}/store"
        stored = fleet.run(manifest, pool, out=tmp_path / "b", store=store, program=str(PROGRAM), parts=3)
        tables.append((stored.folder / "summary.parquet").read_bytes())
        assert len(list((tmp_path / "store").glob("*/*.json"))) == 9
    with LocalCluster(2, threads_per_worker=1, dashboard_address=None, processes=False) as cluster:
        with Client(cluster) as client:
            by_dask = fleet.run(manifest, client, out=tmp_path / "c", program=str(PROGRAM))
            tables.append((by_dask.folder / "summary.parquet").read_bytes())
    assert all(table == tables[0] for table in tables)


def test_a_campaign_in_parts_is_that_of_one_run(tmp_path: Path) -> None:
    few = ["--effects", "torque_offset", "--robots", "arm3", "--seed", "2"]
    with ThreadPoolExecutor(2) as pool:
        whole, parts = (
            fleet.trials(2, pool, out=tmp_path / str(n), options=few, program=str(PROGRAM), parts=n) for n in (1, 2)
        )
    answers = [[trial | {"seconds": None} for trial in campaign["trials"]] for campaign in (whole, parts)]
    assert len(answers[0]) == 2 and answers[0] == answers[1]


def test_a_wrong_manifest_is_said_in_the_program_s_words(tmp_path: Path) -> None:
    manifest = tmp_path / "m.csv"
    manifest.write_text("robot,problem,time\nr,p.toml,1\n")
    with ThreadPoolExecutor(1) as pool, pytest.raises(fleet.FleetError, match="recordings") as caught:
        fleet.run(manifest, pool, out=tmp_path / "out", program=str(PROGRAM), parts=1)
    assert caught.value.code == 2


def test_errors_of_the_program_reach_the_caller(tmp_path: Path) -> None:
    program = tmp_path / "exid"
    program.write_text("#!/bin/sh\necho 'error: broken' >&2\nexit 4\n")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    with ThreadPoolExecutor(1) as pool, pytest.raises(fleet.FleetError, match="error: broken"):
        fleet.run(tmp_path / "m.csv", pool, out=tmp_path / "out", program=str(program), parts=1)
