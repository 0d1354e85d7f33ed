"""Reference values for src/recording/series/zero_phase.rs: scipy.signal.sosfiltfilt, order 4, at 100 Hz.

Writes zero_phase.csv beside this file. Made with SciPy 1.17.1 and NumPy 2.4.6.
"""

from pathlib import Path

import numpy as np
import scipy
from scipy.signal import butter, sosfiltfilt

RATE = 100.0
CUTOFFS = [1.0, 7.0, 40.0]

t = np.arange(80) / RATE
x = np.round(np.sin(2 * np.pi * 1.3 * t) + 0.3 * np.cos(2 * np.pi * 17.0 * t) + 0.5 * t + (t > 0.4), 6)


def smooth(cutoff):
    padding = min(max(15, int(np.ceil(2 / cutoff * RATE))), x.size - 1)
    return sosfiltfilt(butter(4, cutoff, fs=RATE, output="sos"), x, padlen=padding)


columns = [x] + [smooth(cutoff) for cutoff in CUTOFFS]
with open(Path(__file__).with_suffix(".csv"), "w") as file:
    file.write(f"# tests/reference/zero_phase.py, SciPy {scipy.__version__}\n")
    file.write("x," + ",".join(f"cutoff_{c:g}" for c in CUTOFFS) + "\n")
    for row in zip(*columns):
        file.write(",".join(repr(float(value)) for value in row) + "\n")
