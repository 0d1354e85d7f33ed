"""Fleets of robots on clusters: Dask, Ray, or any executor, over the program ``exid fleet``.

A manifest is worked through in parts, ``exid fleet MANIFEST --shard i/n``, each a task of the engine. Results of items are
kept by the hash of all that they depend on, so that a part that is lost, or done twice, changes nothing; when all parts
are done the table is made from them, ``exid fleet MANIFEST``, and is the same bit for bit however many workers there were.
Campaigns of ``exid trials`` go the same way, :func:`trials`.

>>> from exid import fleet
>>> night = fleet.run("nights.parquet", "tcp://scheduler:8786")        # doctest: +SKIP
>>> for robot in night.look_at: print(robot["sentence"])               # doctest: +SKIP
"""

from __future__ import annotations

import importlib
import json
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

__all__ = ["Fleet", "FleetError", "Ray", "run", "trials"]

#: Parts for each thread of an engine: what is lost with a worker is a quarter of an hour's work at most of a long hour.
PARTS_PER_THREAD = 4

#: Times that an engine does a part again whose worker is lost.
RETRIES = 5


class FleetError(RuntimeError):
    """The program ended with an error, in its own words.

    Parameters
    ----------
    code
        The exit code of the program, negative where a signal has ended it.
    message
        What it said.
    """

    def __init__(self, code: int, message: str) -> None:
        super().__init__(code, message)
        self.code = code
        self.message = message

    def __str__(self) -> str:
        return self.message or f"exid ended with {self.code}"


class Future(Protocol):
    """What an engine gives for a task."""

    def result(self) -> Any:
        """Wait for the task and give what it came to, or raise its error."""


class Engine(Protocol):
    """Anything that does tasks: a Dask ``Client``, an executor of ``concurrent.futures``, :class:`Ray`."""

    def submit(self, task: Callable[..., Any], /, *arguments: Any) -> Future:
        """Begin a task."""


@dataclass(frozen=True)
class Fleet:
    """The result of a fleet."""

    #: The results folder, with ``summary.parquet``, ``fleet.html`` and ``result.json``.
    folder: Path
    #: ``result.json``.
    result: dict[str, Any] = field(repr=False)

    @property
    def look_at(self) -> list[dict[str, Any]]:
        """Robots to look at, the surest first: robot, type, kind, joint, sentence, evidence, history."""
        return list(self.result["look_at"])

    @property
    def summary(self) -> str:
        """The fleet in a sentence."""
        return str(self.result["summary"])

    def table(self) -> Any:
        """The table in long form, as a frame of pandas, else of polars, else as a table of PyArrow."""
        path = self.folder / "summary.parquet"
        try:
            import pandas

            return pandas.read_parquet(path)
        except ImportError:
            pass
        try:
            import polars

            return polars.read_parquet(path)
        except ImportError:
            pass
        import pyarrow.parquet

        return pyarrow.parquet.read_table(path)


class Ray:
    """Ray as an engine: ``fleet.run(manifest, fleet.Ray())``.

    Parameters
    ----------
    address
        Of a cluster; ``None`` begins one on this machine, or joins the one that ``ray.init`` has begun.
    """

    def __init__(self, address: str | None = None) -> None:
        import ray

        if not ray.is_initialized():
            ray.init(address=address)
        self._ray = ray

    @property
    def threads(self) -> int:
        """Processors of the cluster."""
        return max(1, int(self._ray.cluster_resources().get("CPU", 1)))

    def submit(self, task: Callable[..., Any], /, *arguments: Any) -> Future:
        """Begin a task on the cluster; tasks of workers that are lost are done again."""
        remote = self._ray.remote(max_retries=RETRIES)(task)
        return _RayFuture(self._ray, remote.remote(*arguments))


@dataclass(frozen=True)
class _RayFuture:
    ray: Any
    reference: Any

    def result(self) -> Any:
        return self.ray.get(self.reference)


class _Dask:
    """A Dask client, which does parts again whose worker is lost."""

    def __init__(self, client: Any) -> None:
        self._client = client

    @property
    def threads(self) -> int:
        workers = self._client.scheduler_info(n_workers=-1)["workers"].values()
        return max(1, sum(int(worker["nthreads"]) for worker in workers))

    def submit(self, task: Callable[..., Any], /, *arguments: Any) -> Future:
        future: Future = self._client.submit(task, *arguments, pure=False, retries=RETRIES)
        return future


def run(
    manifest: str | os.PathLike[str],
    engine: Any = None,
    *,
    out: str | os.PathLike[str] | None = None,
    items: str | os.PathLike[str] | None = None,
    store: str | None = None,
    parts: int | None = None,
    options: Sequence[str] = (),
    program: str | None = None,
) -> Fleet:
    """Work through a manifest on an engine, and say which robots have changed.

    Parameters
    ----------
    manifest
        The manifest (.csv, .parquet or .toml), under a path that every worker sees, as are the files that it names.
    engine
        A Dask ``Client`` or the address of a scheduler, :class:`Ray`, an executor of ``concurrent.futures``, or anything with
        ``submit``. ``None`` begins a ``LocalCluster`` of Dask with a thread for each processor.
    out
        The results folder; default ``results/<manifest>/fleet``.
    items
        The folder in which results of items are kept, under a path that every worker sees; default beside ``out``. With
        ``store`` it is a copy of the store on this machine.
    store
        An address of fsspec, such as ``s3://bucket/items``, to which workers write results of items and from which they
        take those that are done, where they share no folder.
    parts
        Into how many parts the manifest is cut; default four for each thread of the engine.
    options
        Further options of ``exid fleet``, such as ``["--timeout", "60", "--set", "fit.estimator=wls"]``.
    program
        The program on workers and here; default ``EXID_PROGRAM``, else ``exid`` on the path.

    Returns
    -------
    Fleet
        The result, whose table does not depend on engine, parts and interruptions.

    Raises
    ------
    FleetError
        The manifest is wrong, or a folder cannot be written. Faults of single items are in the table.
    """
    manifest = Path(manifest).absolute()
    folder = Path(out) if out is not None else Path("results") / manifest.stem / "fleet"
    command = [_program(program), "fleet", str(manifest), *options]
    return Fleet(folder, _in_parts(_Work(command, folder, items, store, parts), engine))


def trials(
    count: int,
    engine: Any = None,
    *,
    out: str | os.PathLike[str] = "results/trials/trials",
    items: str | os.PathLike[str] | None = None,
    store: str | None = None,
    parts: int | None = None,
    options: Sequence[str] = (),
    program: str | None = None,
) -> dict[str, Any]:
    """Run a campaign of concealed-effect trials, ``exid trials``, on an engine.

    Parameters
    ----------
    count
        Number of trials.
    engine, out, items, store, parts, program
        As in :func:`run`: every trial is an item.
    options
        Further options of ``exid trials``, such as ``["--seed", "7", "--motion", "sweeps"]``.

    Returns
    -------
    dict
        ``result.json`` of the campaign.

    Raises
    ------
    FleetError
        An option is wrong, or a folder cannot be written.
    """
    command = [_program(program), "trials", "--count", str(count), *options]
    return _in_parts(_Work(command, Path(out), items, store, parts), engine)


@dataclass(frozen=True)
class _Work:
    """Items that a command of the program works on in parts, and then puts together."""

    command: list[str]
    folder: Path
    items: str | os.PathLike[str] | None
    store: str | None
    parts: int | None


def _in_parts(work: _Work, engine: Any) -> dict[str, Any]:
    """All parts on an engine, then the whole here; gives ``result.json``."""
    folder, store = work.folder, work.store
    kept = Path(work.items) if work.items is not None else folder.with_name(folder.name + ".items")
    kept = kept.absolute()
    with _Opened(engine) as opened:
        count = work.parts or PARTS_PER_THREAD * getattr(opened, "threads", os.cpu_count() or 1)
        tasks = [
            opened.submit(_part, work.command, f"{number}/{count}", str(kept), store)
            for number in range(1, count + 1)
        ]
        for task in tasks:
            task.result()
    if store is not None:
        _pull(store, kept)
    _call([*work.command, "--items", str(kept), "--out", str(folder), "--quiet"])
    if store is not None:
        _push(kept, store, set())
    result: dict[str, Any] = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    return result


class _Opened:
    """An engine that is closed again where it was begun here."""

    def __init__(self, engine: Any) -> None:
        self._engine = engine
        self._begun: list[Any] = []

    def __enter__(self) -> Any:
        engine = self._engine
        if engine is None:
            dask = _dask()
            cluster = dask.LocalCluster(threads_per_worker=1, dashboard_address=None)
            client = dask.Client(cluster)
            self._begun = [client, cluster]
            return _Dask(client)
        if isinstance(engine, str):
            client = _dask().Client(engine)
            self._begun = [client]
            return _Dask(client)
        return _Dask(engine) if hasattr(engine, "scheduler_info") else engine

    def __exit__(self, *_: object) -> None:
        for begun in self._begun:
            begun.close()


def _dask() -> Any:
    """Dask, which is wanted only by who uses it."""
    return importlib.import_module("dask.distributed")


def _part(command: list[str], shard: str, items: str, store: str | None) -> None:
    """One part, on a worker."""
    arguments = ["--shard", shard, "--threads", "1", "--quiet"]
    if store is None:
        _call([*command, *arguments, "--items", items])
        return
    with tempfile.TemporaryDirectory() as folder:
        own = Path(folder)
        before = _pull(store, own)
        try:
            _call([*command, *arguments, "--items", folder])
        finally:
            # What was done before an error is done.
            _push(own, store, before)


def _program(program: str | None) -> str:
    name = program or os.environ.get("EXID_PROGRAM") or "exid"
    found = shutil.which(name)
    if found is None:
        raise FleetError(
            2, f"the program `{name}` is not there; install it, or name it with program= or EXID_PROGRAM"
        )
    return found


def _call(command: list[str]) -> None:
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, check=False)
    if done.returncode != 0:
        raise FleetError(done.returncode, done.stderr.decode(errors="replace").strip())


def _names(paths: Iterable[str], root: str) -> set[str]:
    """Names of items below a root, such as ``ab/ab12….json``."""
    root = root.rstrip("/") + "/"
    names = (path.partition(root)[2] or path for path in paths)
    return {name for name in names if name.endswith(".json")}


def _pull(store: str, folder: Path) -> set[str]:
    """Take from a store what a folder lacks; gives the names of what is in the store."""
    import fsspec

    files, root = fsspec.core.url_to_fs(store)
    there = _names(files.find(root), root) if files.exists(root) else set()
    lacking = sorted(name for name in there if not (folder / name).exists())
    for name in lacking:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
    if lacking:
        files.get([f"{root}/{name}" for name in lacking], [str(folder / name) for name in lacking])
    return there


def _push(folder: Path, store: str, before: set[str]) -> None:
    """Write to a store what a folder has beyond what was there before."""
    import fsspec

    files, root = fsspec.core.url_to_fs(store)
    here = {path.relative_to(folder).as_posix() for path in folder.glob("*/*.json")}
    new = sorted(here - before)
    for parent in sorted({name.partition("/")[0] for name in new}):
        files.makedirs(f"{root}/{parent}", exist_ok=True)
    if new:
        files.put([str(folder / name) for name in new], [f"{root}/{name}" for name in new])
