"""Fleets on engines: the same table whatever the engine, and parts that are lost are done again."""

from __future__ import annotations

import os
import shutil
import stat
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from exid import fleet

PROGRAM = os.environ.get("EXID_PROGRAM") or shutil.which("exid")
needs_program = pytest.mark.skipif(PROGRAM is None, reason="needs the program exid")

URDF = """<robot name="r"><link name="base"/><link name="l"><inertial><origin xyz="0.2 0 0"/><mass value="4"/>
<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.06" iyz="0" izz="0.06"/></inertial></link><joint name="j" type="revolute">
<parent link="base"/><child link="l"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" velocity="4" effort="100"/></joint></robot>
"""

PROBLEM = """[robot]
urdf = "r.urdf"
inertials = "known"
[drive]
effects = ["coulomb_friction", "viscous_friction"]
rotor_inertia = [0.1]
[drive.values]
"j.coulomb_friction.w" = 0.01
[recordings]
train = ["none.csv"]
signal = "torque"
rate = 100.0
[recordings.differentiation]
method = "lowpass"
cutoff_hz = 10.0
"""


def make(folder: Path, items: int) -> Path:
    """A fleet of a robot of one joint."""
    import math

    (folder / "r.urdf").write_text(URDF)
    (folder / "p.toml").write_text(PROBLEM)
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


@needs_program
def test_threads_store_and_dask_give_one_table(tmp_path: Path) -> None:
    manifest = make(tmp_path, 9)
    tables = []
    with ThreadPoolExecutor(2) as pool:
        plain = fleet.run(manifest, pool, out=tmp_path / "a", program=PROGRAM, parts=4)
        tables.append((plain.folder / "summary.parquet").read_bytes())
        assert plain.result["items"] == 9 and plain.result["set_aside"] == 0, plain.result
        assert plain.summary.startswith("9 items of 3 robots")
        try:
            import fsspec  # noqa: F401
        except ImportError:
            pass
        else:
            store = f"file://{tmp_path}/store"
            stored = fleet.run(manifest, pool, out=tmp_path / "b", store=store, program=PROGRAM, parts=3)
            tables.append((stored.folder / "summary.parquet").read_bytes())
            assert len(list((tmp_path / "store").glob("*/*.json"))) == 9
    try:
        from dask.distributed import Client, LocalCluster
    except ImportError:
        pass
    else:
        with LocalCluster(2, threads_per_worker=1, dashboard_address=None, processes=False) as cluster:
            with Client(cluster) as client:
                by_dask = fleet.run(manifest, client, out=tmp_path / "c", program=PROGRAM)
                tables.append((by_dask.folder / "summary.parquet").read_bytes())
    assert all(table == tables[0] for table in tables)


@needs_program
def test_a_wrong_manifest_is_said_in_the_program_s_words(tmp_path: Path) -> None:
    manifest = tmp_path / "m.csv"
    manifest.write_text("robot,problem,time\nr,p.toml,1\n")
    with ThreadPoolExecutor(1) as pool, pytest.raises(fleet.FleetError, match="recordings") as caught:
        fleet.run(manifest, pool, out=tmp_path / "out", program=PROGRAM, parts=1)
    assert caught.value.code == 2


def test_errors_of_the_program_reach_the_caller(tmp_path: Path) -> None:
    program = tmp_path / "exid"
    program.write_text("#!/bin/sh\necho 'error: broken' >&2\nexit 4\n")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    with ThreadPoolExecutor(1) as pool, pytest.raises(fleet.FleetError, match="error: broken"):
        fleet.run(tmp_path / "m.csv", pool, out=tmp_path / "out", program=str(program), parts=1)
