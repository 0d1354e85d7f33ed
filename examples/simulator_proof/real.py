"""Rollouts of real robots: `exid diagnose`, then `exid rollout` on the recording that was not fitted.

    real.py EXID FOLDER DATA [ROBOTS...]

Prints the median over windows of the error of every joint half a second after the start: by the declared model as fitted, by the
diagnosed one, and what the noise of the signal alone would make of a model that is right.
"""

import csv
import json
import math
import subprocess
import sys
from pathlib import Path

HORIZON = 0.5
PROBLEMS = Path(__file__).resolve().parents[1] / "real_proofs"
REDUCTION = [32.0, 32.0, 45.0, -48.0, 45.0, 32.0]
OFFSET = [0.0, -math.pi / 2, math.pi / 2, 0.0, 0.0, 0.0]

LWR4 = """name = "lwr4"
[robot]
urdf = "{data}/lwr4/lwr4.urdf"
[drive]
effects = ["coulomb_friction", "viscous_friction", "torque_offset"]
[recordings]
train = ["{data}/lwr4/measurements_1.csv"]
validation = ["{data}/lwr4/measurements_3.csv"]
signal = "link_torque"
[recordings.differentiation]
method = "lowpass"
cutoff_hz = 6.0
parallel_hz = 6.0
"""


def tx40(data, folder):
    """Halves of the run, joint by joint: positions of joints, torques of motors at joint scale."""
    rows = []
    for row in csv.DictReader((data / "tx40/excitation.csv").open()):
        q = [float(row[f"qm{k + 1}"]) / REDUCTION[k] for k in range(6)]
        q[5] -= q[4]
        torques = [float(row[f"taum{k + 1}"]) * REDUCTION[k] for k in range(6)]
        rows.append([float(row["t"])] + [a + b for a, b in zip(q, OFFSET)] + torques)
    head = ",".join(["t"] + [f"q{k}" for k in range(1, 7)] + [f"tau{k}" for k in range(1, 7)])
    half = len(rows) // 2
    for name, part in (("first", rows[:half]), ("second", rows[half:])):
        text = "\n".join(",".join(map(repr, row)) for row in part)
        (folder / f"tx40_{name}.csv").write_text(f"{head}\n{text}\n")


def main():
    exid, folder, data = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
    folder.mkdir(parents=True, exist_ok=True)
    tx40(data, folder)
    print(f"{'robot':7}{'joint':22}{'before':>10}{'after':>10}{'noise':>10}  after/before")
    for robot in sys.argv[4:] or ["ur10e", "tx40", "lwr4"]:
        text = LWR4 if robot == "lwr4" else (PROBLEMS / f"{robot}.toml").read_text()
        (folder / f"{robot}.toml").write_text(text.replace("{data}", str(data.resolve())))
        found, rolled = folder / robot, folder / f"{robot}_rollout"
        steps = [(found, ["diagnose", folder / f"{robot}.toml"]), (rolled, ["rollout", found])]
        for out, command in steps:
            if not (out / "result.json").exists():
                subprocess.run([exid, *command, "--out", out, "--quiet", "--threads", "1"], check=True)
        result = json.loads((rolled / "result.json").read_text())
        at = next(h for h in result["horizons"] if h["horizon"] == HORIZON)
        for joint in at["joints"]:
            before, after, noise = [(joint[key] or {}).get("median") or math.nan for key in ("before", "after", "noise")]
            print(f"{robot:7}{joint['joint']:22}{1e3 * before:10.3f}{1e3 * after:10.3f}{1e3 * noise:10.3f}  {after / before:.2f}", flush=True)


if __name__ == "__main__":
    main()
