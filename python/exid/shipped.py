"""Problems that come with the package, to try it on."""

from __future__ import annotations

from pathlib import Path

__all__ = ["example"]

_FOLDER = Path(__file__).parent / "problems"


def example(name: str = "arm6_gearbox") -> Path:
    """The problem file of an arm with recordings that comes with the package.

    Args:
        name: ``"arm6"``, whose model is complete, or ``"arm6_gearbox"``, in which the gear of axis 3 loses torque that the model
            does not know.

    Raises:
        ValueError: no problem of this name comes with the package.
    """
    file = _FOLDER / name / "problem.toml"
    if not file.is_file():
        known = ", ".join(sorted(folder.name for folder in _FOLDER.iterdir()))
        raise ValueError(f"no problem is called {name!r}; there are {known}")
    return file
