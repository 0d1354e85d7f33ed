"""Windows of a held-out recording: a model started where the motion is and driven by the recorded currents.

The start's position and speed are those of a cubic through nine samples (Savitzky and Golay 1964). For a quarter of a second
before, the model is led along the motion under the recorded currents, so that bristles, lags and play are where it brought them.
"""

import json
import re
import subprocess
from pathlib import Path

import mujoco
import numpy as np
from scipy.signal import savgol_filter

from machine import STEP, Drives

WINDOWS = 60
LEAD = 0.25

# Farther than this a window is lost, rad or m.
LOST = 1.0


class Held:
    """Positions, speeds and currents of a recording."""

    def __init__(self, path, period):
        self.period = period
        table = np.genfromtxt(path, delimiter=",", names=True)
        n = sum(name.startswith("q") for name in table.dtype.names)
        column = lambda kind: np.column_stack([table[f"{kind}{k + 1}"] for k in range(n)])
        self.t, self.raw, self.current = table["t"], column("q"), column("i")
        self.h = float(np.median(np.diff(self.t)))
        if period is not None:
            # The mean of the periods, and one more to wrap.
            rows = round(period / self.h)
            whole = len(self.t) // rows
            mean = lambda series: np.tile(series[: whole * rows].reshape(whole, rows, n).mean(axis=0), (2, 1))
            self.raw, self.current, self.t = mean(self.raw), mean(self.current), self.h * np.arange(2 * rows)
        smooth = lambda order: savgol_filter(self.raw, 9, 3, deriv=order, delta=self.h, axis=0)
        self.q, self.v = smooth(0), smooth(1)

    def starts(self, horizon):
        first, last = self.t[0] + LEAD + 0.1, self.t[-1] - horizon - 0.1
        if self.period is not None:
            last = first + self.period
        return np.linspace(first, last, WINDOWS)

    def at(self, series, t):
        """Values at a time, or at times."""
        return np.array([np.interp(t, self.t, column) for column in series.T]).T


class Exported:
    """The model that `exid export --to mujoco` wrote of a result, with its plugin compiled and loaded."""

    step = STEP

    def __init__(self, folder, result):
        folder = Path(folder)
        root = Path(mujoco.__file__).parent
        library = next(p.name for p in root.iterdir() if p.name.startswith("libmujoco.so."))
        plugin = folder / "libexid_drive.so"
        subprocess.run(["cc", "-O2", "-shared", "-fPIC", f"-I{root}/include", folder / "exid_drive.c", "-o", plugin,
                        f"-L{root}", f"-l:{library}", "-lm"], check=True)
        self.path, self.plugin, self.source = folder / "model.xml", plugin, (folder / "exid_drive.c").read_text()
        self.late = _late(json.loads((Path(result) / "result.json").read_text()))

    def roll(self, recording, horizon):
        """End positions, in a process of its own: plugins of one name cannot be loaded twice."""
        import multiprocessing

        with multiprocessing.get_context("spawn").Pool(1) as pool:
            return pool.apply(_roll_exported, (str(self.path), str(self.plugin), self.source, self.late, self.step, recording, horizon))


class Lags:
    """By how much motors are ahead of their links, where gears are elastic or have play: among what the drives remember."""

    def __init__(self, source, model):
        find = lambda name: {int(j): int(k) for k, j in re.findall(rf"state\[(\d+)\] = {name}(\d+);", source)}
        self.angle, self.speed, self.joints = find("lag"), find("dlag"), model.nv

    def of(self, data, states):
        lag = np.zeros(self.joints)
        for joint, k in states.items():
            lag[joint] = data.plugin_state[k]
        return lag

    def lead(self, data, q, v):
        """Sets the links so that the motors are where the encoders were."""
        data.qpos, data.qvel = q - self.of(data, self.angle), v - self.of(data, self.speed)


def _late(result):
    """s by which each recorded current is late."""
    values = {p["name"]: p["value"] for p in result["parameters"]}
    return np.array([values.get(f"{joint['joint']}.time_delay.delay", 0.0) for joint in result["joints"]])


def _roll_exported(path, plugin, source, late, step, recording, horizon):
    mujoco.mj_loadPluginLibrary(plugin)
    model = mujoco.MjModel.from_xml_path(path)
    lags = Lags(source, model)
    current = lambda t: np.array([np.interp(t + l, recording.t, column) for l, column in zip(late, recording.current.T)]).T
    model.opt.timestep = step
    # As the recordings were made: neither limits nor contacts.
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
    data = mujoco.MjData(model)
    ends = []
    for start in recording.starts(horizon):
        mujoco.mj_resetData(model, data)
        t = start - step * np.arange(round(LEAD / step), 0, -1)
        for q, v, i in zip(recording.at(recording.q, t), recording.at(recording.v, t), current(t + step / 2)):
            lags.lead(data, q, v)
            data.ctrl = i
            mujoco.mj_step(model, data)
        # The clock of the drives, which begins at zero.
        data.plugin_state[0] += start - LEAD
        lags.lead(data, recording.at(recording.q, start), recording.at(recording.v, start))
        for i in current(start + (np.arange(round(horizon / step)) + 0.5) * step):
            data.ctrl = i
            mujoco.mj_step(model, data)
        ends.append(data.qpos + lags.of(data, lags.angle))
    return np.array(ends)


class Own:
    """The robot itself, without noise."""

    def __init__(self, machine):
        self.machine = machine

    def roll(self, recording, horizon):
        ends = []
        for start in recording.starts(horizon):
            drives = Drives(self.machine)
            data = drives.data
            for v in recording.at(recording.v, start - STEP * np.arange(round(LEAD / STEP), 0, -1)):
                drives.advance_bristles(v)
            data.qpos, data.qvel = recording.at(recording.q, start), recording.at(recording.v, start)
            drives.tau_in = self.machine.kt * recording.at(recording.current, start) - drives.friction(data.qvel)[0]
            for i in recording.at(recording.current, start + (np.arange(round(horizon / STEP)) + 0.5) * STEP):
                drives.follow(i)
            ends.append(data.qpos.copy())
        return np.array(ends)


def errors(recording, model, horizon, joints):
    """Medians over the windows of the length of the error at the horizon: of some joints, and of all."""
    ends = np.nan_to_num(model.roll(recording, horizon), nan=LOST)
    there = recording.at(recording.q, recording.starts(horizon) + horizon)
    missed = np.clip(ends - there, -LOST, LOST)
    length = lambda columns: float(np.median(np.linalg.norm(missed[:, columns], axis=1)))
    return length(joints), length(slice(None))
