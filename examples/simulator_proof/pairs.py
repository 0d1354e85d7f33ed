"""Pairs of a simulation and a "robot" that differ in one to three of thirty things: what differs is named, and what does not is not.

    pairs.py EXID FOLDER [PAIRS] [SEED]

Both are of MuJoCo: the simulation without noise and at other motions, the robot with encoder counts and noise of its currents.
For every pair `exid diagnose` is given the simulation's recording as `recordings.simulated`. Prints a table and the counts.
"""

import copy
import json
import subprocess
import sys
from pathlib import Path

import numpy as np

from machine import Course, Machine, record, write

JOINTS = 4


def things():
    """The thirty: a kind and the joint or link that has it."""
    several = ["viscous", "coulomb", "rotor", "efficiency", "ripple", "stribeck"]
    all = [(kind, joint) for kind in several for joint in range(JOINTS)]
    return all + [("mass", link) for link in range(1, JOINTS)] + [("spring", joint) for joint in range(1, JOINTS)]


def change(machine, kind, joint, rng):
    """Makes one thing different, by a size drawn at random."""
    more = rng.uniform(1.2, 1.8) if rng.random() < 0.5 else rng.uniform(0.5, 0.8)
    if kind == "viscous":
        machine.Fv[joint] *= more
    elif kind == "coulomb":
        machine.Fc[joint] *= more
    elif kind == "rotor":
        machine.armature[joint] *= more
    elif kind == "mass":
        machine.mass[joint] *= more
        machine.inertia[joint] = machine.inertia[joint] * more
    elif kind == "efficiency":
        machine.with_effect("transmission_efficiency", joint, R=rng.uniform(0.72, 0.92))
    elif kind == "ripple":
        size = machine.Fc[joint] * rng.uniform(0.15, 0.5)
        machine.with_effect("torque_ripple", joint, amplitude=size, order=int(rng.integers(6, 24)), phase=rng.uniform(0, 6))
    elif kind == "stribeck":
        machine.with_effect("stribeck_friction", joint, Fs=machine.Fc[joint] * rng.uniform(0.3, 0.8), vs=rng.uniform(0.08, 0.2))
    elif kind == "spring":
        machine.with_effect("joint_spring", joint, k=machine.Fc[joint] * rng.uniform(1.0, 3.0), q0=rng.uniform(-0.3, 0.3))


EFFECTS = {"efficiency": "transmission_efficiency", "ripple": "torque_ripple", "stribeck": "stribeck_friction", "spring": "joint_spring"}

# What a law may be called by another name that the recordings do not tell from it.
PARAMETERS = {"viscous": "viscous_friction.Fv", "coulomb": "coulomb_friction.Fc", "rotor": "rotor_inertia.Jm"}


def moments(machine):
    """Raw parameters of the links by name: mass, first moments and inertia about the joint."""
    values = {}
    for k, (m, c, i) in enumerate(zip(machine.mass, machine.com, machine.inertia)):
        xx, yy, zz, xy, xz, yz = i
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) + m * (c @ c * np.eye(3) - np.outer(c, c))
        link = f"link{k + 1}"
        values |= {f"{link}.m": m} | {f"{link}.mc{a}": m * x for a, x in zip("xyz", c)}
        values |= {f"{link}.I{a}{b}": tensor["xyz".index(a), "xyz".index(b)] for a, b in ("xx", "xy", "yy", "xz", "yz", "zz")}
    for k, jm in enumerate(machine.armature):
        values[f"joint{k + 1}.rotor_inertia.Jm"] = jm
    for k in range(len(machine.names)):
        values[f"joint{k + 1}.coulomb_friction.Fc"] = machine.Fc[k]
        values[f"joint{k + 1}.coulomb_friction.w"] = machine.w[k]
        values[f"joint{k + 1}.viscous_friction.Fv"] = machine.Fv[k]
    return values


def terms(expression):
    """Coefficients of a combination as it is written."""
    sign, found = 1.0, {}
    for word in expression.split(" "):
        if word in "+-":
            sign = 1.0 if word == "+" else -1.0
            continue
        factor, _, name = word.rpartition("*")
        found[name] = sign * (float(factor) if factor not in ("", "-") else 1.0) * (-1.0 if factor == "-" else 1.0)
    return found


def problem(machine, inertia):
    return f"""name = "pair"
[robot]
mjcf = "model.xml"
[drive]
torque_constant = {machine.kt.tolist()}
effects = ["coulomb_friction", "viscous_friction"{inertia}]
[recordings]
train = ["train.csv"]
validation = ["validation.csv"]
simulated = ["simulated.csv"]
signal = "current"
period = 10.0
"""


def score(result, simulated, robot, changed):
    """What is named of what differs, and what is called different and is not."""
    found = result["simulator"]
    sides = found["only_robot"]
    truth = {}
    for machine, sign in ((robot, 1), (simulated, -1)):
        for name, value in moments(machine).items():
            truth[name] = truth.get(name, 0.0) + sign * value
    named, wrong = set(), []
    for contrast in found["differences"]:
        parts = terms(contrast["parameter"])
        moved = {name for name, c in parts.items() if abs(c * truth.get(name, 0.0)) > 1e-9}
        if not moved or abs(sum(c * truth.get(n, 0.0) for n, c in parts.items())) < 1e-9:
            wrong.append(contrast["parameter"])
        for kind, joint in changed:
            own = f"joint{joint + 1}.{PARAMETERS[kind]}" if kind in PARAMETERS else f"link{joint + 1}."
            if kind not in EFFECTS and any(name.startswith(own) for name in moved):
                named.add((kind, joint))
    for one in sides + found["only_simulator"]:
        hit = [(k, j) for k, j in changed if EFFECTS.get(k) == one["effect"] and f"joint{j + 1}" in one["joints"] and one in sides]
        named.update(hit)
        if not hit:
            finding = next((f for f in result["findings"] if f["effect"] == one["effect"] and f["joints"] == one["joints"]), None)
            alike = [r["effect"] for r in (finding or {"rivals": []})["rivals"] if not r["separable"]]
            hit = [(k, j) for k, j in changed if EFFECTS.get(k) in alike and f"joint{j + 1}" in one["joints"]]
            named.update(hit)
            if not hit:
                wrong.append(f"{one['effect']} of {', '.join(one['joints'])}")
    return named, wrong, found["compared"]


def main():
    exid, folder = sys.argv[1], Path(sys.argv[2])
    pairs = int(sys.argv[3]) if len(sys.argv) > 3 else 20
    seed = int(sys.argv[4]) if len(sys.argv) > 4 else 1
    right = drawn = false = compared = 0
    print("| pair | differs | named | called different and is not | compared |\n|---|---|---|---|---|")
    for pair in range(pairs):
        rng = np.random.default_rng([seed, pair])
        simulated = Machine(rng, JOINTS)
        robot = copy.deepcopy(simulated)
        every = things()
        changed = [every[k] for k in rng.choice(len(every), size=int(rng.integers(1, 4)), replace=False)]
        for kind, joint in changed:
            change(robot, kind, joint, rng)
        here = folder / f"{pair:02}"
        here.mkdir(parents=True, exist_ok=True)
        if not (here / "problem.toml").exists():
            courses = [Course(rng, JOINTS) for _ in range(3)]
            write(here / "simulated.csv", record(simulated, courses[2], 2))
            write(here / "train.csv", record(robot, courses[0], 4, rng))
            write(here / "validation.csv", record(robot, courses[1], 3, rng))
            (here / "model.xml").write_text(simulated.mjcf(drives=False))
            (here / "problem.toml").write_text(problem(simulated, ', "rotor_inertia"'))
        if not (here / "result" / "result.json").exists():
            subprocess.run([exid, "diagnose", here / "problem.toml", "--out", here / "result", "--quiet", "--threads", "1"], check=True)
        result = json.loads((here / "result" / "result.json").read_text())
        named, wrong, count = score(result, simulated, robot, changed)
        right, drawn, false, compared = right + len(named), drawn + len(changed), false + len(wrong), compared + count
        words = lambda all: ", ".join(f"{kind} {joint + 1}" for kind, joint in sorted(all)) or "nothing"
        print(f"| {pair + 1} | {words(changed)} | {words(named)} | {'; '.join(wrong)} | {count} |", flush=True)
    print(f"\nNamed: {right} of {drawn} ({100 * right / drawn:.0f} %). Called different and is not: {false} of {compared} compared "
          f"({100 * false / compared:.1f} %).")


if __name__ == "__main__":
    main()
