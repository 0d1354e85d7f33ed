"""How long a minute of a seven-joint arm takes: exid's bench, and MuJoCo's own loop on the same model under the same torques.

    speed.py CARGO

Both have Coulomb and viscous friction and take steps of a millisecond; MuJoCo's with its dry friction as a constraint, on one thread.
"""

import re
import subprocess
import sys
import time
from pathlib import Path

import mujoco
import numpy as np
from mujoco import rollout

ROOT = Path(__file__).resolve().parents[2]
SECONDS, RATE, JOINTS = 60, 1000, 7
REPEATS = 10


def of_mujoco(integrator):
    """Least s of some repeats, to leave out what else the machine does."""
    model = mujoco.MjModel.from_xml_path(str(ROOT / "benches/arm7.xml"))
    model.opt.integrator = integrator
    data = mujoco.MjData(model)
    t = np.arange(SECONDS * RATE)[:, None] / RATE
    joint = np.arange(JOINTS)
    torque = 8.0 * np.sin((1.0 + 0.3 * joint) * t + joint)
    start = np.zeros((1, mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)))
    times = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        rollout.rollout(model, [data], start, torque[None])
        times.append(time.perf_counter() - began)
    return min(times)


def main():
    cargo = sys.argv[1] if len(sys.argv) > 1 else "cargo"
    printed = subprocess.run([cargo, "bench", "--bench", "rollout"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    unit = {"s": 1.0, "ms": 1e-3, "µs": 1e-6}
    # The name, and behind it the least, middle and greatest time.
    found = re.findall(r"rollout/(.*?)\s+time:\s+\[([\d.]+) (\S+) ([\d.]+) (\S+) ", printed)
    print("| what | s |\n|---|---|")
    for name, _, _, middle, scale in found:
        print(f"| exid: {name} | {float(middle) * unit[scale]:.3f} |")
    for name in ("EULER", "IMPLICITFAST", "RK4"):
        print(f"| MuJoCo {mujoco.__version__}, {name.lower()}: a minute | {of_mujoco(getattr(mujoco.mjtIntegrator, f'mjINT_{name}')):.3f} |")


if __name__ == "__main__":
    main()
