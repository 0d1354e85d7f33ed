"""Writes recordings of an H4 at the parameters that the paper identified, with the equations of the paper.

Motor positions are the closed-form inverse kinematics along motions of the platform; their derivatives, and the
Jacobian, are central differences of it, so that the recordings owe nothing to exid:
    Γ = I q̈ + Jᵀ M (ẍ − G) + Fv q̇ + Fc sign(q̇),    J⁻¹ = ∂q/∂x,    V = Γ / G_T + noise

    pip install numpy && python make.py
"""

import gzip
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
LEVER, ROD, H, D, R = 0.26, 0.48, 0.06, 0.06, 0.14  # m, chosen: the paper prints none
ALPHA = np.array([0, np.pi, 1.5 * np.pi, 1.5 * np.pi])
SIDE, END = np.array([1, -1, -1, 1]), np.array([1, 1, -1, -1])
MOTOR = np.stack([SIDE * H + R * np.cos(ALPHA), END * D + R * np.sin(ALPHA), np.zeros(4)], axis=1)
OUT = np.stack([np.cos(ALPHA), np.sin(ALPHA), np.zeros(4)], axis=1)
INERTIA = np.array([0.0167, 0.0164, 0.0176, 0.0234])  # Table 3, kg·m² (printed as N·m²)
MASS, BAR = 0.984, 0.0029  # kg, kg·m²
VISCOUS = np.array([0.2112, 0.1236, 0.1266, 0.1133])  # N·m·s/rad
COULOMB = np.array([1.2186, 1.0252, 0.7902, 1.0394])  # N·m
GAIN = np.array([2.85, 2.65, 2.70, 2.87])  # Table 1, N·m/V
RATE = 250.0  # Hz
TICK = 2 * np.pi / 2**17  # rad, of the motors' encoders
NOISE = 0.28  # V
BAR_TICK, ACCELEROMETER = 2 * np.pi / 2**16, 0.3  # rad, m/s²
HOME = np.array([0.0, 0.0, -0.42, 0.0])
STEP = 1e-4  # s, m, rad: of the central differences


def inverse(pose):
    """Motor positions (N, 4) at poses (N, 4)."""
    x, y, z, theta = pose.T
    q = np.empty_like(pose)
    for i in range(4):
        end = np.stack([x + SIDE[i] * H * np.cos(theta), y + END[i] * D + SIDE[i] * H * np.sin(theta), z], axis=1)
        reach = end - MOTOR[i]
        u, w = reach @ OUT[i], -reach[:, 2]
        wanted = (np.sum(reach**2, axis=1) + LEVER**2 - ROD**2) / (2 * LEVER)
        q[:, i] = np.arctan2(w, u) - np.arccos(wanted / np.hypot(u, w))
    return q


def motion(rng, seconds):
    """A motion of the platform: slow sines where friction prevails, then fast ones where inertia does."""
    size = np.array([0.10, 0.10, 0.07, 0.5])
    terms = []
    for axis in range(4):
        slow = [(f, a * size[axis], p) for f, a, p in zip(rng.uniform(0.1, 0.5, 3), [0.5, 0.3, 0.2], rng.uniform(0, 6.28, 3))]
        fast = [(f, a * size[axis], p) for f, a, p in zip(rng.uniform(1.0, 4.0, 4), [0.35, 0.25, 0.2, 0.15], rng.uniform(0, 6.28, 4))]
        terms.append((slow, fast))

    def pose(t):
        blend = 0.5 * (1 + np.tanh((t - 0.45 * seconds) / 0.5))
        out = np.tile(HOME, (len(t), 1))
        for axis, (slow, fast) in enumerate(terms):
            total = lambda group: sum(a * np.sin(2 * np.pi * f * t + p) for f, a, p in group)
            out[:, axis] += (1 - blend) * total(slow) + 0.8 * blend * total(fast)
        return out

    return pose


def difference(f, t):
    return (f(t + STEP) - f(t - STEP)) / (2 * STEP), (f(t + STEP) - 2 * f(t) + f(t - STEP)) / STEP**2


def forces(x, ddx):
    """Jᵀ M (ẍ − G) at poses (N, 4)."""
    rates = np.empty((len(x), 4, 4))
    for axis in range(4):
        away = np.zeros(4)
        away[axis] = STEP
        rates[:, :, axis] = (inverse(x + away) - inverse(x - away)) / (2 * STEP)
    load = ddx * np.array([MASS, MASS, MASS, BAR])
    load[:, 2] += MASS * 9.81
    return np.einsum("nij,ni->nj", np.linalg.inv(rates), load)


def write(name, header, columns):
    # A header without name and time: the same bytes on every run.
    with open(HERE / name, "wb") as raw, gzip.GzipFile("", "wb", 9, raw, 0) as file:
        lines = [",".join(header)] + [",".join(row) for row in zip(*columns)]
        file.write(("\n".join(lines) + "\n").encode())


def text(series, digits):
    return [f"{value:.{digits}f}" for value in series]


def record(name, seed, seconds):
    rng = np.random.default_rng(seed)
    pose = motion(rng, seconds)
    t = np.arange(round(seconds * RATE)) / RATE
    x, q = pose(t), inverse(pose(t))
    dq, ddq = difference(lambda t: inverse(pose(t)), t)
    _, ddx = difference(pose, t)
    torque = INERTIA * ddq + forces(x, ddx) + VISCOUS * dq + COULOMB * np.sign(dq)
    volts = torque / GAIN + NOISE * rng.standard_normal(torque.shape)
    felt = ddx[:, :3] + ACCELEROMETER * rng.standard_normal((len(t), 3))
    columns = [text(t, 3)]
    columns += [text(np.round(q[:, k] / TICK) * TICK, 6) for k in range(4)]
    columns += [text(volts[:, k], 3) for k in range(4)]
    columns += [text(felt[:, k], 2) for k in range(3)]
    columns += [text(np.round(x[:, 3] / BAR_TICK) * BAR_TICK, 6)]
    header = ["t"] + [f"q{k}" for k in range(1, 5)] + [f"v{k}" for k in range(1, 5)] + ["ax", "ay", "az", "theta"]
    write(name, header, columns)
    print(name, "motors within", q.min(axis=0).round(2), q.max(axis=0).round(2), "rad/s", np.abs(dq).max().round(1), "m/s²", np.abs(ddx[:, :3]).max().round(1), "N·m", np.abs(torque).max().round(1))


def hold(name, seed):
    """The platform clamped to a force sensor at one pose; each amplifier in turn gets steps of its reference.

    With a dither on the references static friction keeps up to a tenth of Coulomb friction in either direction, anew
    at every step: what a gain rests on is the number of steps, so there are five rounds of them.
    """
    rng = np.random.default_rng(seed)
    pose = HOME + rng.uniform(-1, 1, 4) * np.array([0.08, 0.08, 0.06, 0.4])
    rate, steady, between = 100.0, 30, 20  # Hz, samples
    volts, valid = [], []
    levels = [0.5, 1.0, 1.5, -1.5, -1.0, -0.5]
    for motor, level in [(motor, level) for _ in range(5) for motor in range(4) for level in levels]:
        reference = np.zeros(4)
        reference[motor] = level
        volts += [reference] * (steady + between)
        valid += [0] * (between // 2) + [1] * steady + [0] * (between // 2)
    volts = np.array(volts)
    x = np.tile(pose, (len(volts), 1))
    steps = len(volts) // (steady + between)
    stuck = np.repeat(rng.uniform(-1, 1, (steps, 4)) * COULOMB / 10, steady + between, axis=0)
    rates = np.empty((len(x), 4, 4))
    for axis in range(4):
        away = np.zeros(4)
        away[axis] = STEP
        rates[:, :, axis] = (inverse(x + away) - inverse(x - away)) / (2 * STEP)
    # What the sensor exerts on the platform: M (ẍ − G) = f + J⁻ᵀ (Γ − friction) at rest.
    force = np.array([0, 0, MASS * 9.81, 0]) - np.einsum("nij,ni->nj", rates, volts * GAIN - stuck)
    force += np.array([0.2, 0.2, 0.2, 0.01]) * rng.standard_normal(force.shape)
    q = np.round(inverse(x) / TICK) * TICK
    columns = [text(np.arange(len(x)) / rate, 2), [str(v) for v in valid]]
    columns += [text(q[:, k], 6) for k in range(4)]
    columns += [text(volts[:, k] + 0.005 * rng.standard_normal(len(x)), 4) for k in range(4)]
    columns += [text(force[:, k], 3) for k in range(4)]
    header = ["t", "valid"] + [f"q{k}" for k in range(1, 5)] + [f"v{k}" for k in range(1, 5)] + ["fx", "fy", "fz", "mz"]
    write(name, header, columns)


if __name__ == "__main__":
    hold("static1.csv.gz", 3)
    hold("static2.csv.gz", 4)
    record("train.csv.gz", 1, 24.0)
    record("validation.csv.gz", 2, 12.0)
