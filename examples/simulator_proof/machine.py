"""Robots in MuJoCo with drives of their own: what they record in closed loop, with effects that a model may lack.

The laws are written here a second time, in NumPy, from their equations and not from exid's code:

    tau_motor = kt i (1 + c3 i^2)                               what the motor exerts
    tau_in = tau_motor - Jm a - friction(v) - ripple(q)          what reaches the gear
    tau_in = g tau,  g = 1/R where the motor drives, R where it is driven
    M(q) a + h(q, v) + k (q - q0) = tau

sign(v) is v / (|v| + w) everywhere, also in the choice of g. The rotor's inertia is MuJoCo's armature, over g.
"""

import numpy as np
import mujoco

STEP = 5e-4
RATE = 200.0
WARM_UP = 1
COUNTS = 2**19


class Machine:
    """An arm of hinges: bodies, drives, and what the drives do beside Coulomb and viscous friction."""

    def __init__(self, rng, joints):
        self.names = [f"joint{k + 1}" for k in range(joints)]
        size = 0.55 ** np.arange(joints)
        self.mass = 12.0 * size * rng.uniform(0.8, 1.2, joints)
        self.length = rng.uniform(0.25, 0.4, joints)
        self.com = np.column_stack([self.length * rng.uniform(0.35, 0.6, joints), rng.uniform(-0.03, 0.03, (joints, 2))])
        self.inertia = [self._inertia(rng, m, l) for m, l in zip(self.mass, self.length)]
        # Yaw, then pitches and rolls in turn.
        self.axis = ["0 0 1"] + [["0 1 0", "1 0 0"][k % 2 if k > 1 else 0] for k in range(joints - 1)]
        self.kt = np.round(12.0 * size**0.5 * rng.uniform(0.9, 1.1, joints), 2)
        self.armature = np.round(1.2 * size * rng.uniform(0.8, 1.2, joints), 3)
        self.Fc = np.round(8.0 * size * rng.uniform(0.7, 1.3, joints), 3)
        self.Fv = np.round(9.0 * size * rng.uniform(0.7, 1.3, joints), 3)
        self.w = np.full(joints, 0.01)
        self.noise = 0.006 * 12.0 * size**0.5 / self.kt * rng.uniform(0.8, 1.5, joints)
        self.effects = []
        self.delay = 0.0

    @staticmethod
    def _inertia(rng, mass, length):
        """About the centre of mass, of a rod with some width: xx, yy, zz, xy, xz, yz."""
        long, wide = mass * length**2 / 12, mass * 0.05**2
        off = 0.1 * wide
        return np.array([wide, long + wide, long + wide, *(off * rng.uniform(-1, 1, 3))])

    def with_effect(self, effect, joint, **parameters):
        self.effects.append({"effect": effect, "joints": [self.names[joint]], "parameters": parameters})

    def mjcf(self, drives=True):
        """The model; with its drives' armature, damping and dry friction, or as bodies alone."""
        text = '<mujoco model="machine">\n  <compiler angle="radian" autolimits="true"/>\n  <option gravity="0 0 -9.81"/>\n  <worldbody>\n'
        at, indent = "0 0 0.3", "    "
        for k, name in enumerate(self.names):
            law = f' armature="{self.armature[k]}" damping="{self.Fv[k]}" frictionloss="{self.Fc[k]}"' if drives else ""
            i = self.inertia[k]
            text += f'{indent}<body name="link{k + 1}" pos="{at}">\n'
            text += f'{indent}  <joint name="{name}" axis="{self.axis[k]}" range="-2.9 2.9"{law}/>\n'
            text += f'{indent}  <inertial pos="{row(self.com[k])}" mass="{self.mass[k]:.9g}" fullinertia="{row(i)}"/>\n'
            at, indent = f"{self.length[k]:.9g} 0 0", indent + "  "
        for k in range(len(self.names)):
            indent = indent[:-2]
            text += f"{indent}</body>\n"
        text += "  </worldbody>\n  <actuator>\n"
        for name, kt in zip(self.names, self.kt):
            text += f'    <motor name="{name}" joint="{name}" gear="{kt}"/>\n'
        return text + "  </actuator>\n</mujoco>\n"

    def parameters(self, name):
        """Parameters of an effect by joint; absent where the joint does not have it."""
        found = {e["joints"][0]: e["parameters"] for e in self.effects if e["effect"] == name}
        return [found.get(joint) for joint in self.names]


def row(values):
    return " ".join(f"{x:.9g}" for x in values)


class Drives:
    """The drives of a machine beside a MuJoCo model of its bodies, whose currents are followed step by step."""

    def __init__(self, machine, step=STEP):
        self.machine, self.step = machine, step
        self.model = mujoco.MjModel.from_xml_string(machine.mjcf(drives=False))
        self.model.opt.timestep = step
        self.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        self.data = mujoco.MjData(self.model)
        n = len(machine.names)

        def of(effect, key, default):
            return np.array([default if p is None else p[key] for p in machine.parameters(effect)])

        self.R = of("transmission_efficiency", "R", 1.0)
        self.Fs, self.vs = of("stribeck_friction", "Fs", 0.0), of("stribeck_friction", "vs", 1.0)
        self.amplitude = of("torque_ripple", "amplitude", 0.0)
        self.order, self.phase = of("torque_ripple", "order", 1.0), of("torque_ripple", "phase", 0.0)
        self.k, self.q0 = of("joint_spring", "k", 0.0), of("joint_spring", "q0", 0.0)
        self.dFc, self.dFv = of("asymmetric_friction", "dFc", 0.0), of("asymmetric_friction", "dFv", 0.0)
        self.c3 = of("torque_current_nonlinearity", "c3", 0.0)
        self.mu = of("load_dependent_friction", "mu", 0.0)
        self.sigma0, self.sigma1 = of("presliding_hysteresis", "sigma0", 0.0), of("presliding_hysteresis", "sigma1", 0.0)
        self.bristled = self.sigma0 > 0
        self.z = np.zeros(n)
        self.tau_in = np.zeros(n)

    def friction(self, v):
        m = self.machine
        sign = v / (np.abs(v) + m.w)
        force = m.Fv * v + m.Fc * sign + self.Fs * np.exp(-((v / self.vs) ** 2)) * sign + self.dFc + self.dFv * np.abs(v)
        if self.bristled.any():
            rate = v - self.sigma0 * np.abs(v) * self.z / np.maximum(m.Fc, 1e-9)
            bristles = m.Fv * v + self.sigma0 * self.z + self.sigma1 * rate
            force = np.where(self.bristled, bristles, force)
        return force, sign

    def advance_bristles(self, v):
        if self.bristled.any():
            # Exact for a speed that is constant over the step.
            lag = self.sigma0 * np.abs(v) / np.maximum(self.machine.Fc, 1e-9)
            end = np.sign(v) * self.machine.Fc / np.maximum(self.sigma0, 1e-9)
            moved = np.where(lag > 0, end + (self.z - end) * np.exp(-lag * self.step), self.z)
            self.z = np.where(self.bristled, moved, 0.0)

    def follow(self, current):
        """One step under currents that are held."""
        m, d = self.machine, self.data
        q, v = d.qpos, d.qvel
        friction, sign = self.friction(v)
        u = m.kt * current * (1.0 + self.c3 * current**2) - friction - self.amplitude * np.sin(self.order * q + self.phase)
        side = np.sign(self.tau_in) * sign
        g = 0.5 * (1 / self.R + self.R) + (0.5 * (1 / self.R - self.R) + self.mu) * side
        f = 1.0 / g
        self.model.dof_armature[:] = f * m.armature
        d.qfrc_applied[:] = f * u - self.k * (q - self.q0)
        mujoco.mj_step(self.model, d)
        self.tau_in = u - m.armature * d.qacc
        self.advance_bristles(v)


class Course:
    """A motion that repeats: a Fourier series of five harmonics within a range and a speed."""

    def __init__(self, rng, joints, period=10.0, reach=1.0, speed=1.4):
        self.period = period
        self.rate = 2 * np.pi * np.arange(1, 6)[:, None] / period
        self.a, self.b = rng.normal(size=(2, 5, joints)) / np.arange(1, 6)[:, None] ** 0.5
        self.middle = rng.uniform(-0.4, 0.4, joints)
        t = np.linspace(0, period, 2001)
        q, v, _ = self.at(t)
        wide = np.abs(q - self.middle).max(axis=0) / (reach * rng.uniform(0.7, 1.0, joints))
        fast = np.abs(v).max(axis=0) / (speed * rng.uniform(0.7, 1.0, joints))
        scale = 1 / np.maximum(wide, fast)
        self.a, self.b = self.a * scale, self.b * scale

    def at(self, t):
        angle = np.asarray(t)[:, None] * self.rate.T
        s, c, w = np.sin(angle), np.cos(angle), self.rate[:, 0]
        q = self.middle + s @ self.a + c @ self.b
        return q, (c * w) @ self.a - (s * w) @ self.b, -(s * w**2) @ self.a - (c * w**2) @ self.b


def feed_forward(machine, course, step):
    """Torques of the bodies, rotors and friction along a period, by which a controller helps itself."""
    drives = Drives(machine, step)
    model, data = drives.model, drives.data
    model.dof_armature[:] = machine.armature
    t = np.arange(round(course.period / step)) * step
    motion = course.at(t)
    torque = np.zeros_like(motion[0])
    for k, (q, v, a) in enumerate(zip(*motion)):
        data.qpos, data.qvel, data.qacc = q, v, a
        mujoco.mj_inverse(model, data)
        torque[k] = data.qfrc_inverse + machine.Fv * v + machine.Fc * v / (np.abs(v) + machine.w)
    return motion, torque


def record(machine, course, periods, rng=None, step=STEP):
    """Positions and currents in closed loop; with encoder counts and noise of the currents where there is a generator."""
    (q_ref, v_ref, _), torque = feed_forward(machine, course, step)
    drives = Drives(machine, step)
    data = drives.data
    data.qpos, data.qvel = q_ref[0], v_ref[0]
    stiff = machine.armature + machine.mass * machine.length**2
    kp, kd = 400.0 * stiff, 40.0 * stiff
    loop, every = len(q_ref), round(1 / (RATE * step))
    q, i = [], []
    for k in range(loop * (WARM_UP + periods)):
        at = k % loop
        current = (torque[at] + kp * (q_ref[at] - data.qpos) + kd * (v_ref[at] - data.qvel)) / machine.kt
        if k >= loop * WARM_UP and k % every == 0:
            q.append(data.qpos.copy())
            i.append(current.copy())
        drives.follow(current)
    q, i = np.array(q), np.array(i)
    if not (np.isfinite(q).all() and np.abs(q).max() < 6.0):
        raise RuntimeError("the machine runs away")
    if machine.delay:
        # The channel of the currents is late.
        t = np.arange(len(q)) / RATE
        period = periods * course.period
        i = np.column_stack([np.interp((t - machine.delay) % period, t, column, period=period) for column in i.T])
    if rng is not None:
        quantum = 2 * np.pi / COUNTS
        q = np.round(q / quantum) * quantum
        i = i + rng.normal(size=i.shape) * machine.noise
    return np.arange(len(q)) / RATE, q, i


def write(path, recording):
    t, q, i = recording
    n = q.shape[1]
    head = ",".join(["t"] + [f"q{k + 1}" for k in range(n)] + [f"i{k + 1}" for k in range(n)])
    np.savetxt(path, np.column_stack([t, q, i]), delimiter=",", header=head, comments="", fmt="%.9g")
