"""Makes the files of this problem again, with MuJoCo:  python record.py

`model.xml` is a simulation of an arm of three joints as it stands before anybody compared it with the robot; `simulated.csv.gz` is what it
records. The robot, which is a simulation too so that the truth is known, has half as much more viscous friction on the second joint and
a gear on the third that loses 18 % of what it transmits.
"""

import copy
import gzip
import io
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "examples" / "simulator_proof"))

import machine as robots


def save(name, recording):
    text = io.StringIO()
    t, q, i = recording
    columns = ["t"] + [f"{kind}_joint{k + 1}" for kind in "qi" for k in range(q.shape[1])]
    np.savetxt(text, np.column_stack([t, q, i]), delimiter=",", header=",".join(columns), comments="", fmt="%.7g")
    # Without a time stamp: the same bytes every time.
    (HERE / name).write_bytes(gzip.compress(text.getvalue().encode(), mtime=0))


def main():
    robots.RATE = 100.0
    rng = np.random.default_rng(4)
    simulation = robots.Machine(rng, 3)
    robot = copy.deepcopy(simulation)
    robot.Fv[1] *= 1.5
    robot.with_effect("transmission_efficiency", 2, R=0.82)
    motions = [robots.Course(rng, 3, period=8.0) for _ in range(3)]
    save("train.csv.gz", robots.record(robot, motions[0], 4, rng))
    save("validation.csv.gz", robots.record(robot, motions[1], 3, rng))
    save("simulated.csv.gz", robots.record(simulation, motions[2], 2))
    (HERE / "model.xml").write_text(simulation.mjcf())


if __name__ == "__main__":
    main()
