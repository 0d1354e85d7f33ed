"""Frames of whichever library is there."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any, Iterable, Mapping

__all__ = ["frame"]


def frame(rows: Iterable[Mapping[str, Any]]) -> Any:
    """Rows as a frame of pandas, else of polars, else as a dictionary of lists."""
    records = [dict(row) for row in rows]
    if find_spec("pandas") is not None:
        import pandas

        return pandas.DataFrame.from_records(records)
    if find_spec("polars") is not None:
        import polars

        return polars.DataFrame(records, infer_schema_length=None)
    names = list(records[0]) if records else []
    return {name: [record.get(name) for record in records] for name in names}
