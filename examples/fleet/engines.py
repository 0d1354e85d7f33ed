#!/usr/bin/env python3
"""What `exid fleet` costs, and what kills do to it: on the folder that the example `fleet` has written.

    python examples/fleet/engines.py FOLDER [--program exid] [--items 1000] [--kills 30] [--workers 1 2 4]

Prints throughput on one and on two threads and the memory of the driver; then the manifest is worked through with the process killed
at random moments, and on workers of Dask that are killed at random moments, and every table is compared bit for bit with that of a
run that nothing disturbed. Needs the Python package, and Dask for its part.
"""

from __future__ import annotations

import argparse
import logging
import os
import random
import signal
import subprocess
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path


@dataclass
class Ended:
    """A process that has ended."""

    seconds: float
    processor: float
    megabytes: float


def ended(command: list[str]) -> Ended:
    """Run a command and measure it."""
    began = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"{command[0]} ended with {process.returncode}")
    # Linux counts in kilobytes.
    return Ended(time.perf_counter() - began, used.ru_utime + used.ru_stime, used.ru_maxrss / 1000)


class Fleet:
    """The first items of a fleet, worked through in different ways."""

    def __init__(self, folder: Path, program: str, items: int, work: Path) -> None:
        self.program, self.work = program, work
        rows = (folder / "manifest.csv").read_text().splitlines()
        self.count = min(items, len(rows) - 1)
        # Paths of a manifest start from its folder.
        self.manifest = folder / f"first_{self.count}.csv"
        self.manifest.write_text("\n".join(rows[: self.count + 1]) + "\n")
        self.table = b""

    def command(self, name: str, *options: str) -> list[str]:
        out, items = self.work / name, self.work / f"{name}.items"
        return [self.program, "fleet", str(self.manifest), "--out", str(out), "--items", str(items), "--quiet", *options]

    def kept(self, name: str) -> dict[str, int]:
        """Items that are done, with what tells whether they were written again."""
        return {path.name: path.stat().st_ino for path in (self.work / f"{name}.items").glob("*/*.json")}

    def undisturbed(self) -> None:
        """Throughput, and the table that all others are compared with."""
        runs = [(threads, ended(self.command(f"threads_{threads}", "--threads", str(threads)))) for threads in (1, 2)]
        self.table = (self.work / "threads_1" / "summary.parquet").read_bytes()
        for threads, run in runs:
            rate = self.count / run.seconds
            print(
                f"{self.count} items on {threads} threads: {rate:.1f} a second, {self.count / run.processor:.1f} a second of a processor, "
                f"{run.megabytes:.0f} MB"
            )
        # Neither wall time nor the number of processors says it where others use them too: their time does.
        print(f"efficiency from 1 to 2 threads by time of processors: {100 * runs[0][1].processor / runs[1][1].processor:.0f} %")
        print(f"by wall time: {50 * runs[0][1].seconds / runs[1][1].seconds:.0f} %")
        self.compare("threads_2")

    def driver(self, folder: Path) -> None:
        """The whole fleet, whose items the example has done: what the driver alone takes."""
        manifest = folder / "manifest.csv"
        out = str(self.work / "whole")
        command = [self.program, "fleet", str(manifest), "--items", str(folder / "items"), "--out", out, "--quiet"]
        run = ended(command)
        items = len(manifest.read_text().splitlines()) - 1
        print(f"all {items} items, done before: {run.seconds:.0f} s, {run.processor:.0f} s of processors, {run.megabytes:.0f} MB")

    def compare(self, name: str) -> None:
        same = (self.work / name / "summary.parquet").read_bytes() == self.table
        whole = len(self.kept(name)) == self.count
        print(f"{name}: table {'the same bit for bit' if same else 'ANOTHER'}, {'nothing' if whole else 'SOMETHING'} missing")
        if not (same and whole):
            raise SystemExit(1)

    def killed(self, kills: int, seconds: float) -> None:
        """Kills at random moments of a run that would last so long."""
        again = 0
        for kill in range(kills):
            before = self.kept("killed")
            process = subprocess.Popen(self.command("killed", "--threads", "2"), stdout=subprocess.DEVNULL)
            time.sleep(random.uniform(0.05, 2 * seconds / kills))
            process.kill()
            process.wait()
            after = self.kept("killed")
            again += sum(after.get(name) != inode for name, inode in before.items())
        ended(self.command("killed", "--threads", "2"))
        print(f"{kills} kills: {again} items that were done were done again")
        self.compare("killed")

    def on_dask(self, workers: int, kills: int, seconds: float) -> None:
        """The same on workers of Dask, of which one is killed again and again."""
        from dask.distributed import Client, LocalCluster

        from exid import fleet

        name = f"dask_{workers}"
        over = threading.Event()
        killed = 0
        with LocalCluster(workers, threads_per_worker=1, dashboard_address=None, silence_logs=logging.CRITICAL) as cluster, Client(cluster) as client:

            def kill() -> None:
                nonlocal killed
                while killed < kills and not over.wait(random.uniform(0.1, 2 * seconds / max(kills, 1))):
                    nannies = [nanny for nanny in cluster.workers.values() if nanny.pid]
                    if nannies:
                        os.kill(random.choice(nannies).pid, signal.SIGKILL)
                        killed += 1

            killer = threading.Thread(target=kill)
            killer.start()
            began = time.perf_counter()
            try:
                fleet.run(
                    self.manifest,
                    client,
                    out=self.work / name,
                    items=self.work / f"{name}.items",
                    parts=4 * max(workers, kills),
                    program=self.program,
                )
            finally:
                over.set()
                killer.join()
        print(f"{workers} workers of Dask, {killed} of them killed: {time.perf_counter() - began:.0f} s")
        self.compare(name)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--program", default=os.environ.get("EXID_PROGRAM", "exid"))
    parser.add_argument("--items", type=int, default=1000)
    parser.add_argument("--whole", action="store_true", help="measure the driver with all items, which the example has done")
    parser.add_argument("--kills", type=int, default=30)
    parser.add_argument("--workers", type=int, nargs="*", default=[1, 2, 4])
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    random.seed(asked.seed)
    with tempfile.TemporaryDirectory() as work:
        fleet = Fleet(asked.folder.resolve(), asked.program, asked.items, Path(work))
        began = time.perf_counter()
        fleet.undisturbed()
        # With another build of the program the items of the example are not done.
        if asked.whole:
            fleet.driver(asked.folder.resolve())
        seconds = (time.perf_counter() - began) / 4
        fleet.killed(asked.kills, seconds)
        for workers in asked.workers:
            fleet.on_dask(workers, asked.kills // max(len(asked.workers), 1), seconds)


if __name__ == "__main__":
    main()
