#!/usr/bin/env python3
"""Writes the motions of this folder, one period each: t, q_<axis>, enough points for every harmonic.

    q(t) = q0 + sum_l a_l sin(2 pi l t / T) + b_l cos(2 pi l t / T)

excitation.csv  Table 1 of Swevers, Verdonck, Naumer, Pieters and Biber (2002), axes 3 to 6, T = 36.96 s. The b_15 of axis 6 is
                printed as 1.57, which repeats b_1 and takes the axis to 244 degrees/s, beyond its limit: 0.80 is used.
printed.csv     the same with the printed 1.57.
validation.csv  another motion of the same kind.
wrist.csv       excitation.csv with axis 3 at rest.
"""
from math import cos, pi, sin
from pathlib import Path

PERIOD, POINTS = 36.96, 154
TABLE_1 = {
    "a3": (1.57, {25: (8.72e-2, -4.62e-3)}),
    "a4": (0.0, {1: (1.57, 0.0), 18: (4.60e-1, -1.76e-2)}),
    "a5": (0.0, {1: (-8.38e-1, 1.78e-3), 19: (-2.10e-1, 8.52e-3)}),
    "a6": (0.0, {1: (0.0, 1.57), 15: (2.56e-2, 0.80)}),
}
PRINTED = dict(TABLE_1, a6=(0.0, {1: (0.0, 1.57), 15: (2.56e-2, 1.57)}))
VALIDATION = {
    "a3": (1.50, {21: (7.0e-2, 5.0e-2)}),
    "a4": (0.3, {2: (1.1, 0.4), 15: (-0.30, 0.25)}),
    "a5": (-0.2, {1: (0.30, 0.75), 17: (0.15, -0.12)}),
    "a6": (0.2, {2: (0.9, -0.6), 13: (0.50, 0.45)}),
}
WRIST = dict(TABLE_1, a3=(1.57, {}))


def write(name, motion):
    lines = ["t," + ",".join("q_" + axis for axis in motion)]
    for k in range(POINTS):
        t = PERIOD * k / POINTS
        q = [
            q0 + sum(a * sin(2 * pi * l * t / PERIOD) + b * cos(2 * pi * l * t / PERIOD) for l, (a, b) in terms.items())
            for q0, terms in motion.values()
        ]
        lines.append(",".join(f"{x:.10g}" for x in [t, *q]))
    folder = Path(__file__).parent / "motions"
    folder.mkdir(exist_ok=True)
    (folder / name).write_text("\n".join(lines) + "\n")


write("excitation.csv", TABLE_1)
write("printed.csv", PRINTED)
write("validation.csv", VALIDATION)
write("wrist.csv", WRIST)
