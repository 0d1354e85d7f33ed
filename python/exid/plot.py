"""Plots of results on axes of matplotlib. Each method draws on the axes that it is given, or on new ones, and returns them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from exid.result import Recorded, Result, _Estimated

__all__ = ["Plots"]

RECORDED = "#8a8f98"
BEFORE = "#d1782a"
AFTER = "#1f5fa8"
NOISE = "#5c9e6f"

# Dots beyond which a plot shows a part of the samples: more hide one another.
DOTS = 4000


class Plots:
    """Plots of one result."""

    def __init__(self, result: Result) -> None:
        self._result = result

    def residuals(self, ax: Axes | None = None) -> Axes:
        """Spread of what the last model leaves of each joint, over the noise level where it is known.

        Boxes from the first to the third quartile with the median, whiskers from 2.5 % to 97.5 %; held-out samples where there are
        any. Dashes are the standard deviation of the noise.
        """
        ax = _axes(ax)
        recordings = _held_out(self._estimated().predictions)
        joints = recordings[0].joints
        residuals = [np.concatenate([r.residual(joint) for r in recordings]) for joint in joints]
        unit = self._unit(joints[0])
        boxes = ax.boxplot(
            [values[np.isfinite(values)] for values in residuals],
            whis=(2.5, 97.5),
            showfliers=False,
            patch_artist=True,
            widths=0.5,
            medianprops={"color": "black"},
        )
        for box in boxes["boxes"]:
            box.set(facecolor=AFTER, alpha=0.45, edgecolor=AFTER)
        for at, joint in enumerate(joints, start=1):
            noise = self._figures(joint).get("noise_rms")
            if noise is not None:
                label = "noise, one standard deviation" if at == 1 else "_"
                ax.hlines([-noise, noise], at - 0.38, at + 0.38, color=NOISE, ls="--", lw=1.4, label=label)
        ax.axhline(0.0, color="black", lw=0.6)
        ax.set_xticks(range(1, len(joints) + 1), joints)
        ax.set_ylabel(f"predicted − recorded [{unit}]")
        ax.set_title(f"Residuals, {_split_words(recordings)}")
        if ax.get_legend_handles_labels()[0]:
            ax.legend(frameon=False, fontsize="small")
        return ax

    def prediction(self, joint: str, recording: str | None = None, ax: Axes | None = None) -> Axes:
        """The recorded signal of a joint beside what the models predict, over time.

        Parameters
        ----------
        joint : str
        recording : str, optional
            Name of the recording; the first one that was held out, or else the first, if None.
        """
        ax = _axes(ax)
        recordings = self._estimated().predictions
        if recording is None:
            shown = _held_out(recordings)[0]
        else:
            shown = _named(recordings, recording)
        _require_joint(joint, shown.joints)
        ax.plot(shown.t, shown.series[joint, "recorded"], color=RECORDED, lw=2.2, label="recorded")
        if (joint, "baseline") in shown.series:
            ax.plot(shown.t, shown.series[joint, "baseline"], color=BEFORE, lw=1.1, label="declared model")
        last = shown.last_model(joint)
        words = "final model" if last == "final" else "model"
        ax.plot(shown.t, shown.series[joint, last], color=AFTER, lw=1.1, ls=(0, (4, 2)), label=words)
        ax.margins(x=0.01)
        ax.set_xlabel("time [s]")
        ax.set_ylabel(f"{joint} [{self._unit(joint)}]")
        ax.set_title(f"{shown.name}, {_split_words([shown])}")
        ax.legend(frameon=False, fontsize="small", ncols=3)
        return ax

    def friction(self, joint: str, ax: Axes | None = None) -> Axes:
        """What a joint takes beyond standstill at each speed, all others at rest, by the fitted laws.

        The line is the model in the code that `export` writes, at position zero; dots are the line plus the residual of
        each sample (partial residuals), held-out samples where there are any.
        """
        ax = _axes(ax)
        recordings = _held_out(self._estimated().predictions)
        joints = recordings[0].joints
        _require_joint(joint, joints)
        if (joint, "velocity") not in recordings[0].series:
            raise ValueError("the result has no speeds of the joints, over which friction could be drawn")
        speed = np.concatenate([r.series[joint, "velocity"] for r in recordings])
        residual = np.concatenate([r.residual(joint) for r in recordings])
        fastest = float(np.nanmax(np.abs(speed)))
        unit = self._unit(joint)
        law = _ExportedDrive(self._result, joint, "motor_current" if unit == "A" else "motor_torque")
        # Close to standstill the law turns within thousandths of the range.
        fine = np.concatenate([-np.geomspace(fastest, 1e-4 * fastest, 200), [0.0], np.geomspace(1e-4 * fastest, fastest, 200)])
        line = law.beyond_standstill(fine)
        step = max(1, len(speed) // DOTS)
        dots = np.interp(speed, fine, line) - residual
        label = "samples, partial residuals"
        ax.plot(speed[::step], dots[::step], ".", color=RECORDED, ms=2.5, alpha=0.5, label=label, rasterized=True)
        ax.plot(fine, line, color=AFTER, lw=1.8, label="fitted law")
        ax.axhline(0.0, color="black", lw=0.6)
        ax.axvline(0.0, color="black", lw=0.6)
        ax.set_xlabel(f"speed of {joint} [{'m/s' if law.slides else 'rad/s'}]")
        ax.set_ylabel(f"friction [{unit}]")
        ax.set_title(f"Friction of {joint}")
        ax.legend(frameon=False, fontsize="small", markerscale=4)
        return ax

    def evidence(self, ax: Axes | None = None, most: int = 12) -> Axes:
        """What each candidate effect alone would explain of the misfit of the declared model, the largest first.

        Parameters
        ----------
        most : int
            Candidates shown.
        """
        if "evidence" not in self._result:
            raise ValueError(f"a result of {self._result.verb} weighs no candidates; exid.diagnose does")
        ax = _axes(ax)
        entries = [e for e in self._result["evidence"] if e["step"] == 0 and e["relief"] is not None]
        entries.sort(key=lambda entry: -entry["relief"])
        shown = entries[:most][::-1]
        if not shown:
            ax.text(0.5, 0.5, "no candidate was weighed", ha="center", transform=ax.transAxes)
            return ax
        names = [f"{entry['effect'].replace('_', ' ')}, {_few(entry['joints'])}" for entry in shown]
        colours = [AFTER if entry["accepted"] else RECORDED for entry in shown]
        ax.barh(range(len(shown)), [100 * entry["relief"] for entry in shown], color=colours, height=0.7)
        ax.set_yticks(range(len(shown)), names, fontsize="small")
        ax.set_xlim(left=0.0)
        ax.set_xlabel("fall of the held-out error by the effect alone [%]")
        ax.set_title("Candidates, each alone (blue: accepted)")
        return ax

    def rollout(self, joint: str | None = None, ax: Axes | None = None) -> Axes:
        """Median error of position over the time that the models are simulated forward.

        Parameters
        ----------
        joint : str, optional
            The joint; the one with the largest error of the model after two seconds if None.
        """
        if "curves" not in self._result:
            raise ValueError(f"a result of {self._result.verb} has no rollouts; exid.rollout makes them of it")
        ax = _axes(ax)
        curves = self._result["curves"]
        if joint is None:
            curve = max(curves, key=lambda c: max(_medians(c["after"])[-1:] or [0.0]))
        else:
            _require_joint(joint, [c["joint"] for c in curves])
            curve = next(c for c in curves if c["joint"] == joint)
        models = [
            ("before", BEFORE, "declared model"),
            ("after", AFTER, "final model"),
            ("noise", NOISE, "a right model, under the noise"),
        ]
        for model, colour, label in models:
            spread = curve[model]
            if not spread:
                continue
            # At the start all are where the recording is.
            t = np.array(curve["t"], dtype=float)[1:]
            lower, middle, upper = (_numbers(spread, key)[1:] for key in ("lower_quartile", "median", "upper_quartile"))
            ax.plot(t, middle, color=colour, lw=1.6, label=label)
            ax.fill_between(t, lower, upper, color=colour, alpha=0.15, lw=0)
        ax.set_yscale("log")
        ax.margins(x=0.01)
        ax.set_xlabel("time simulated [s]")
        ax.set_ylabel(f"error of position of {curve['joint']} [{curve['unit']}]")
        ax.set_title("Rollout: median and quartiles")
        ax.legend(frameon=False, fontsize="small")
        return ax

    def _estimated(self) -> _Estimated:
        if not hasattr(self._result, "predictions") or not self._result.predictions:
            raise ValueError(f"a result of {self._result.verb} has no predictions; those of exid.fit and exid.diagnose have")
        return cast("_Estimated", self._result)

    def _figures(self, joint: str) -> dict[str, Any]:
        figures: list[dict[str, Any]] = self._result["joints"]
        return next((entry for entry in figures if entry["joint"] == joint), {})

    def _unit(self, joint: str) -> str:
        return str(self._figures(joint).get("unit", ""))


class _ExportedDrive:
    """The drives of a result in the code that is exported for NumPy."""

    def __init__(self, result: Result, joint: str, function: str) -> None:
        files = result.export("numpy").files
        space: dict[str, Any] = {"__name__": "exid_exported"}
        for text in files.values():
            exec(compile(text, "exported", "exec"), space)  # what exid itself has written
        self._function = space.get(f"{function}_with_load") or space[function]
        machine = result["machine"] if "machine" in result else result["fit"]["machine"]
        joints = machine["joints"]
        self._count = len(joints)
        self._at = [entry["name"] for entry in joints].index(joint)
        self.slides = joints[self._at]["motion"] == "prismatic"

    def beyond_standstill(self, speeds: NDArray[np.float64]) -> NDArray[np.float64]:
        """Signal of the joint at each speed less that at standstill."""
        still = np.zeros(self._count)
        rest = self._signal(still, still)
        values = []
        for speed in speeds:
            moving = still.copy()
            moving[self._at] = speed
            values.append(self._signal(still, moving) - rest)
        return np.array(values)

    def _signal(self, q: NDArray[np.float64], dq: NDArray[np.float64]) -> float:
        return float(self._function(q, dq, np.zeros(self._count))[self._at])


def _axes(ax: Axes | None) -> Axes:
    if ax is not None:
        return ax
    from matplotlib import pyplot

    figure, made = pyplot.subplots(figsize=(7.0, 3.6), layout="constrained")
    made.spines[["top", "right"]].set_visible(False)
    return made


def _held_out(recordings: list[Recorded]) -> list[Recorded]:
    held_out = [r for r in recordings if r.split == "validation"]
    return held_out or recordings


def _named(recordings: list[Recorded], name: str) -> Recorded:
    for recording in recordings:
        if recording.name == name:
            return recording
    known = ", ".join(sorted({r.name for r in recordings}))
    raise ValueError(f"there is no recording {name!r}; there are {known}")


def _require_joint(joint: str, known: list[str]) -> None:
    if joint not in known:
        raise ValueError(f"there is no joint {joint!r}; there are {', '.join(known)}")


def _split_words(recordings: list[Recorded]) -> str:
    return "held out" if recordings[0].split == "validation" else "fitted"


def _few(joints: list[str]) -> str:
    return ", ".join(joints) if len(joints) <= 2 else f"{len(joints)} joints"


def _numbers(spread: list[dict[str, Any]], key: str) -> NDArray[np.float64]:
    return np.array([np.nan if s[key] is None else s[key] for s in spread], dtype=float)


def _medians(spread: list[dict[str, Any]]) -> list[float]:
    return [s["median"] or 0.0 for s in spread]
