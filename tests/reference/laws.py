"""Signals of two pendulums with one effect each, for the value tests of the laws: writes laws.json.

Both pendulums hang on the base and turn about its y axis. Closed forms by NumPy; what has memory is integrated by
SciPy along the same motion. Needs numpy and scipy; shares nothing with exid.
"""

import json
import pathlib

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

HERE = pathlib.Path(__file__).parent
SAMPLES, PERIOD = 40, 1.6
T = np.arange(SAMPLES) * PERIOD / SAMPLES
W = 2 * np.pi / PERIOD
# Amplitude (rad), harmonic, phase of every motor.
MOTION = [[(0.45, 1, 0.3), (0.04, 3, 1.0)], [(0.6, 1, -0.8), (0.15, 2, 0.4)]]
# kg, centre of mass in m, inertia about it in kg m².
BODIES = [
    (4.0, (0.3, 0.02, -0.05), (0.02, 0.06, 0.06)),
    (2.0, (0.1, 0.0, -0.2), (0.03, 0.02, 0.01)),
]
GRAVITY = np.array([0.0, 0.0, -9.81])
CONSTANT = [11.0, 7.0]


def motor(j, t):
    t = np.asarray(t, dtype=float)
    q, v, a = np.zeros_like(t), np.zeros_like(t), np.zeros_like(t)
    for size, h, phase in MOTION[j]:
        w, x = h * W, h * W * t + phase
        q, v, a = q + size * np.sin(x), v + size * w * np.cos(x), a - size * w * w * np.sin(x)
    return q, v, a


def gravity_torque(q, mass, com, gravity):
    """Torque against gravity about y: minus the moment of the weight."""
    points = Rotation.from_euler("y", np.atleast_1d(q)[:, None]).apply(com)
    return -np.cross(points, mass * gravity)[:, 1]


def body(j, q, a, gravity=GRAVITY, load=None):
    """Torque at a joint: inertia and gravity of the link and of a load fixed to it."""
    parts = [BODIES[j]] + ([load] if load and j == 1 else [])
    torque = np.zeros_like(np.atleast_1d(q))
    for mass, com, inertia in parts:
        own = inertia[1] + mass * (com[0] ** 2 + com[2] ** 2)
        torque = torque + own * a + gravity_torque(q, mass, com, gravity)
    return torque


def sign(v, w=0.0):
    return v / (np.abs(v) + w) if w else np.sign(v)


def rigid(t=T, **more):
    return [body(j, motor(j, t)[0], motor(j, t)[2], **more) for j in range(2)]


CASES = []


def case(effect, values, expected, refine=1, tolerance=1e-9, signal="torque", lenders=()):
    """`tolerance` is a share of the largest change that the effect makes."""
    CASES.append(
        {
            "effects": list(lenders) + [effect],
            "values": values,
            "signal": signal,
            "refine": refine,
            "tolerance": tolerance,
            "cyclic": effect in ("joint_elasticity", "backlash"),
            "expected": [list(map(float, e)) for e in expected],
            "without": [list(map(float, e)) for e in WITHOUT],
        }
    )


def both(names, numbers):
    """The same parameters on both joints, other numbers."""
    values = {}
    for j, joint in enumerate(["first", "second"]):
        for name, number in zip(names, numbers):
            values[f"{joint}.{name}"] = number[j]
    return values


def motor_law(effect, names, numbers, law, w=None, **more):
    """A torque of the motor's own motion on top of the body's."""
    values = both([f"{effect}.{n}" for n in names], numbers)
    expected = []
    for j in range(2):
        q, v, a = motor(j, T)
        own = [n[j] for n in numbers]
        expected.append(rigid()[j] + law(j, q, v, a, *own))
    case(effect, values, expected, **more)


WITHOUT = rigid()
motor_law("coulomb_friction", ["Fc", "w"], [(3.0, 1.2), (0.05, 0.2)],
          lambda j, q, v, a, fc, w: fc * sign(v, w))
motor_law("viscous_friction", ["Fv"], [(2.0, 0.8)], lambda j, q, v, a, fv: fv * v)
motor_law("asymmetric_friction", ["dFc", "dFv"], [(0.7, -0.2), (0.3, 0.5)],
          lambda j, q, v, a, c, f: c + f * np.abs(v))
motor_law("stribeck_friction", ["Fs", "vs"], [(1.5, 0.8), (0.6, 0.9)],
          lambda j, q, v, a, fs, vs: fs * np.exp(-((np.abs(v) / vs) ** 2)) * sign(v))
motor_law("viscous_nonlinearity", ["Fn", "p"], [(1.1, -0.4), (0.5, 2.5)],
          lambda j, q, v, a, fn, p: fn * np.abs(v) ** p * np.sign(v))
motor_law("sigmoid_friction", ["psi1", "psi2", "psi3"], [(4.0, 2.0), (3.0, 8.0), (0.2, -0.1)],
          lambda j, q, v, a, a1, b, c: a1 / (1 + np.exp(-b * (v + c))) - a1 / (1 + np.exp(-b * c)))
motor_law("position_dependent_friction", ["dF", "q0", "width"], [(1.2, 0.8), (0.1, -0.2), (0.3, 0.4)],
          lambda j, q, v, a, f, q0, width: f * np.exp(-(((q - q0) / width) ** 2)) * sign(v))
motor_law("torque_offset", ["offset"], [(0.8, -0.3)], lambda j, q, v, a, o: o + 0 * q)
motor_law("rotor_inertia", ["Jm"], [(0.4, 0.1)], lambda j, q, v, a, jm: jm * a)
motor_law("torque_ripple", ["order", "amplitude", "phase", "amplitude2", "phase2"],
          [(12.0, 7.0), (0.9, 0.5), (0.4, 1.2), (0.3, 0.2), (-0.6, 2.0)],
          lambda j, q, v, a, n, a1, p1, a2, p2: a1 * np.sin(n * q + p1) + a2 * np.sin(2 * n * q + p2))
motor_law("joint_spring", ["k", "q0"], [(9.0, 4.0), (0.3, -0.5)], lambda j, q, v, a, k, q0: k * (q - q0))
motor_law("external_contact", ["torque", "from", "to"], [(2.0, -1.0), (0.4, 0.7), (0.9, 1.3)],
          lambda j, q, v, a, f, t0, t1: f / (1 + np.exp(-(T - t0) / 0.01)) - f / (1 + np.exp(-(T - t1) / 0.01)))

viscous = both(["viscous_friction.Fv"], [(2.0, 0.8)])
WITHOUT = [rigid()[j] + [2.0, 0.8][j] * motor(j, T)[1] for j in range(2)]
warm = [WITHOUT[j] * 1.0 for j in range(2)]
for j, (gain, constant) in enumerate([(0.6, 0.7), (-0.4, 2.0)]):
    warm[j] = warm[j] + [2.0, 0.8][j] * gain * (1 - np.exp(-T / constant)) * motor(j, T)[1]
case("thermal_drift", viscous | both(["thermal_drift.gain", "thermal_drift.time_constant"], [(0.6, -0.4), (0.7, 2.0)]),
     warm, lenders=["viscous_friction"])

# Losses of the gear act on what it transmits: more to drive, less where the load drives.
WITHOUT = rigid()
share = (0.8, 0.65)
lossy = []
for j in range(2):
    load, v = rigid()[j], motor(j, T)[1]
    lossy.append(np.where(load * v > 0, load / share[j], load * share[j]))
case("transmission_efficiency", both(["transmission_efficiency.R"], [share]), lossy)
case("load_dependent_friction", both(["load_dependent_friction.mu"], [(0.2, 0.3)]),
     [rigid()[j] + (0.2, 0.3)[j] * np.abs(rigid()[j]) * np.sign(motor(j, T)[1]) for j in range(2)])

# Currents.
WITHOUT = [rigid()[j] / CONSTANT[j] for j in range(2)]
case("drive_gain", both(["drive_gain.gain"], [(0.9, 1.2)]),
     [rigid()[j] / CONSTANT[j] / (0.9, 1.2)[j] for j in range(2)], signal="current")
powers = [(0.5, 10.0, 0.4, -0.3), (0.2, 6.0, 0.3, -0.1)]


def current(torque, c):
    size = abs(torque)
    if size <= c[0]:
        return 0.0
    return np.sign(torque) * brentq(lambda i: c[0] + c[1] * i + c[2] * i**2 + c[3] * i**3 - size, 0, 2.9, xtol=1e-14)


case("torque_current_nonlinearity",
     both([f"torque_current_nonlinearity.c{k}" for k in range(4)], list(zip(*powers))),
     [[current(x, powers[j]) for x in rigid()[j]] for j in range(2)], signal="current")

# Each channel records a share of the other's current too.
heard = (0.15, -0.08)
case("channel_crosstalk",
     {"first.channel_crosstalk.second": heard[0], "second.channel_crosstalk.first": heard[1]},
     [WITHOUT[0] + heard[0] * WITHOUT[1], WITHOUT[1] + heard[1] * WITHOUT[0]], signal="current")

# What the bodies do.
WITHOUT = rigid()
load = (1.5, (0.05, -0.03, -0.25), (0.01, 0.008, 0.004))
case("unmodelled_payload", {"payload": [load[0], *load[1], *load[2]]}, rigid(load=load))
roll, pitch = 0.15, -0.2
turned = (Rotation.from_euler("y", pitch) * Rotation.from_euler("x", roll)).inv().apply(GRAVITY)
case("base_tilt", {"base_tilt.roll": roll, "base_tilt.pitch": pitch}, rigid(gravity=turned))

# The joints stand further than their encoders show.
further = (0.12, -0.2)
case("encoder_offset", both(["encoder_offset.offset"], [further]),
     [body(j, motor(j, T)[0] + further[j], motor(j, T)[2]) for j in range(2)])

# q2 = m2 + V21 m1; the first motor bears V21 times the second joint's torque.
entry = 0.35
q = [motor(0, T)[0], motor(1, T)[0] + entry * motor(0, T)[0]]
a = [motor(0, T)[2], motor(1, T)[2] + entry * motor(0, T)[2]]
joints = [body(j, q[j], a[j]) for j in range(2)]
case("kinematic_coupling", {"second.kinematic_coupling.first": entry}, [joints[0] + entry * joints[1], joints[1]])

# Between samples the motion is a cubic: its error falls with the fourth power of the step.
late = (0.013, -0.021)
case("time_delay", both(["time_delay.delay"], [late]),
     [body(j, motor(j, T - late[j])[0], motor(j, T - late[j])[2]) for j in range(2)], refine=8, tolerance=1e-3)

# Bristles: dz/dt = v - sigma0 |v| z / g(v), sliding at first.
fc = (3.0, 1.2)
lugre = [(300.0, 2.0, 0.8, 0.3), (100.0, 1.0, 0.5, 0.4)]
WITHOUT = [rigid()[j] + fc[j] * np.sign(motor(j, T)[1]) for j in range(2)]
bristles = []
for j, (s0, s1, fs, vs) in enumerate(lugre):
    def g(v, j=j, fs=fs, vs=vs):
        return fc[j] + fs * np.exp(-((v / vs) ** 2))

    def rate(t, z, j=j, s0=s0, g=g):
        v = float(motor(j, t)[1])
        return v - s0 * abs(v) * z / g(v)

    v = motor(j, T)[1]
    first = g(v[0]) * np.sign(v[0]) / s0
    z = solve_ivp(rate, (0, T[-1]), [first], t_eval=T, rtol=1e-10, atol=1e-13, max_step=1e-3).y[0]
    bristles.append(rigid()[j] + s0 * z + s1 * (v - s0 * np.abs(v) * z / g(v)))
case("presliding_hysteresis",
     both(["coulomb_friction.Fc"], [fc]) | both(["coulomb_friction.w"], [(0.0, 0.0)])
     | both([f"presliding_hysteresis.{n}" for n in ("sigma0", "sigma1", "Fs", "vs")], list(zip(*lugre))),
     bristles, refine=16, tolerance=1e-3, lenders=["coulomb_friction"])

# The link swings on the gear: I q'' + gravity = K (m - q) + D (m' - q'), after it has settled.
WITHOUT = rigid()
springs = [(900.0, 9.0), (300.0, 3.0)]
elastic = []
for j, (k, d) in enumerate(springs):
    mass, com, inertia = BODIES[j]
    own = inertia[1] + mass * (com[0] ** 2 + com[2] ** 2)

    def gear(t, x, j=j, k=k, d=d):
        m, dm, _ = motor(j, t)
        return k * (m - x[0]) + d * (dm - x[1])

    def swing(t, x, j=j, own=own, mass=mass, com=com, gear=gear):
        return [x[1], float((gear(t, x) - gravity_torque(x[0], mass, com, GRAVITY)[0]) / own)]

    begin = [float(motor(j, 0.0)[0]), float(motor(j, 0.0)[1])]
    settled = solve_ivp(swing, (0, 3 * PERIOD), begin, rtol=1e-9, atol=1e-11).y[:, -1]
    x = solve_ivp(swing, (0, T[-1]), settled, t_eval=T, rtol=1e-10, atol=1e-12).y
    elastic.append([float(gear(t, x[:, i])) for i, t in enumerate(T)])
# Backward differences: first order in the step.
case("joint_elasticity", both(["joint_elasticity.K", "joint_elasticity.D"], list(zip(*springs))), elastic,
     refine=128, tolerance=2e-2)

# The first pendulum's weight never lets go of one flank: the link hangs half the play behind its motor. Flanks give way by
# up to 5e-4 rad, which changes twice in a period: their share of the change.
gap = 0.2
q, _, a = motor(0, T)
assert np.all(rigid()[0] * rigid()[0][0] > 0)
hanging = body(0, q - 0.5 * gap * np.sign(rigid()[0]), a)
case("backlash", {"first.backlash.gap": gap, "second.backlash.gap": 0.0}, [hanging, rigid()[1]],
     refine=16, tolerance=3e-2)

out = {
    "period": PERIOD,
    "samples": SAMPLES,
    "torque_constant": CONSTANT,
    "motion": [[list(term) for term in terms] for terms in MOTION],
    "cases": CASES,
}
(HERE / "laws.json").write_text(json.dumps(out, indent=None, separators=(",", ":")).replace('{"effects"', '\n{"effects"') + "\n")
