"""Exceptions of exid: what is wrong, where, and what to do about it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Mapping

__all__ = [
    "DataError",
    "DefectError",
    "ExidError",
    "InterruptedWarning",
    "NoSolutionError",
    "NoSolutionWarning",
    "Place",
    "ProblemError",
]


@dataclass(frozen=True)
class Place:
    """Where a fault lies, as far as it is known.

    Attributes
    ----------
    file : str
        The file, or the name of a recording in memory.
    line : int or None
        Line in the file, from 1.
    column : int or None
        Column in the line, from 1.
    key : str or None
        Key of a problem, channel of a recording, or element of a robot description.
    """

    file: str
    line: int | None = None
    column: int | None = None
    key: str | None = None


class ExidError(Exception):
    """A fault of what exid was given, or of exid.

    Attributes
    ----------
    place : Place or None
        Where the fault lies.
    message : str
        What is wrong, with what was found.
    value : str or None
        The value itself, where one value is at fault.
    remedy : str or None
        What to do about it.
    code : str
        Stable identifier of the kind of fault, in kebab-case.
    exit_code : int
        What the program `exid` exits with.
    """

    place: Place | None
    message: str
    value: str | None
    remedy: str | None
    code: str
    exit_code: int

    def __init__(
        self,
        text: str,
        *,
        message: str | None = None,
        code: str = "",
        exit_code: int = 2,
        place: Place | None = None,
        value: str | None = None,
        remedy: str | None = None,
    ) -> None:
        super().__init__(text)
        self.message = text if message is None else message
        self.code = code
        self.exit_code = exit_code
        self.place = place
        self.value = value
        self.remedy = remedy

    def __reduce__(self) -> tuple[object, ...]:
        # Errors travel between processes.
        return (_again, (type(self), str(self), dict(self.__dict__)))


class ProblemError(ExidError):
    """The problem is wrong, or a results folder cannot be written (exit code 2)."""


class DataError(ExidError):
    """A recording or a robot file is wrong (exit code 3)."""


class NoSolutionError(ExidError):
    """There is no solution, and nothing was reached (exit code 4)."""


class DefectError(ExidError):
    """A defect of exid (exit code 70); please report it."""


class NoSolutionWarning(UserWarning):
    """A result was reached that is no solution; no figure of it can be relied on."""


class InterruptedWarning(UserWarning):
    """A run was interrupted; its result is what was reached before."""


_KINDS: Mapping[int, type[ExidError]] = {
    2: ProblemError,
    3: DataError,
    4: NoSolutionError,
    70: DefectError,
}


def of_failure(
    text: str,
    *,
    message: str,
    code: str,
    exit_code: int,
    place: Mapping[str, str | int | None] | None = None,
    value: str | None = None,
    remedy: str | None = None,
) -> ExidError:
    """The exception of a failure of the compiled core."""
    at = None if place is None else Place(**place)  # type: ignore[arg-type]
    kind = _KINDS.get(exit_code, ExidError)
    return kind(
        text,
        message=message,
        code=code,
        exit_code=exit_code,
        place=at,
        value=value,
        remedy=remedy,
    )


def _again(kind: type[ExidError], text: str, state: dict[str, object]) -> ExidError:
    error = kind(text)
    error.__dict__.update(state)
    return error
