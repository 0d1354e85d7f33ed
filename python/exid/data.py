"""Recordings in memory: arrays and frames as the reader of recordings takes them.

Arrays of float64 that lie in one piece are read where they are. The reader makes one copy of the columns that a problem
wants, into the table that it filters and scales; what is not float64 or not in one piece is converted here first.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import Any, Mapping, Protocol, Sequence, TypeAlias, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from exid import _core

__all__ = ["Data", "Frame", "Recording"]


class Frame(Protocol):
    """A frame of pandas or polars: named columns."""

    @property
    def columns(self) -> Any: ...

    def __getitem__(self, key: Any) -> Any: ...


Recording: TypeAlias = Union[str, "os.PathLike[str]", Mapping[str, ArrayLike], Frame]
"""One recording: the path of a file, arrays by name, or a frame.

A vector `t` is the column `t`; a matrix `q` of shape (samples, joints) gives the columns `q1`, `q2`, ...
"""

Data: TypeAlias = Union[Recording, Sequence[Recording], Mapping[str, Union[Recording, Sequence[Recording]]]]
"""Recordings to train on, or recordings by their group: `train`, `validation`, `loaded`."""

GROUPS = ("train", "validation", "loaded")


@dataclass
class Recordings:
    """Recordings that take the place of those of a problem.

    Attributes
    ----------
    groups : dict
        Names of files and of recordings in memory, by the group that they stand in.
    memory : list
        Recordings in memory by their names.
    """

    groups: dict[str, list[str]] = field(default_factory=dict)
    memory: list[tuple[str, _core.Arrays]] = field(default_factory=list)


def recordings(data: Data | None) -> Recordings:
    """Sorts recordings into groups; gives names to those in memory."""
    found = Recordings()
    if data is None:
        return found
    for group, given in _by_group(data).items():
        several = _is_list(given)
        entries = list(given) if several else [given]
        names = found.groups.setdefault(group, [])
        for number, entry in enumerate(entries):
            if isinstance(entry, (str, os.PathLike)):
                # Relative paths of a problem start from its folder; these from where the call is.
                names.append(os.path.abspath(os.fspath(entry)))
                continue
            name = f"{group}_{number + 1}" if several else group
            names.append(name)
            found.memory.append((name, arrays(entry)))
    return found


def arrays(recording: Mapping[str, ArrayLike] | Frame) -> _core.Arrays:
    """The arrays of a recording for the reader."""
    if isinstance(recording, Mapping):
        named = {str(name): _in_one_piece(values) for name, values in recording.items()}
    elif hasattr(recording, "columns"):
        named = {str(name): _column(recording[name]) for name in recording.columns}
    else:
        kind = type(recording).__name__
        raise TypeError(
            f"a recording is a path, arrays by name, or a frame with named columns, not {kind}"
        )
    return _core.Arrays(list(named.items()))


def _column(series: Any) -> NDArray[np.float64]:
    values = series.to_numpy()
    if values.dtype.kind in "OUSM":
        # Columns of text are no channels; their place is kept, and a problem that wants them is told.
        return np.full(len(values), np.nan)
    return _in_one_piece(values)


def _in_one_piece(values: ArrayLike) -> NDArray[np.float64]:
    array = np.asarray(values, dtype=np.float64)
    if array.flags.c_contiguous or array.flags.f_contiguous:
        return array
    return np.ascontiguousarray(array)


def _by_group(data: Data) -> dict[str, Any]:
    if isinstance(data, Mapping) and data and all(key in GROUPS for key in data):
        return dict(data)
    return {"train": data}


def _is_list(given: object) -> bool:
    return isinstance(given, (list, tuple))
