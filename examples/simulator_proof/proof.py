"""Does a diagnosis make the simulator move like the robot?

    proof.py EXID FOLDER TRIALS [CASES...]

For every recording of TRIALS and for own robots with one to three effects concealed: `exid diagnose`, `exid export --to mujoco`, the
plugin compiled, the model loaded in MuJoCo and driven by the recorded currents of another recording, from starts all over it. Error
of position after half a second: of the declared model as fitted, of the diagnosed one, and of the true one. For own robots that is
the robot itself, in NumPy; for TRIALS, of which only the effects are known, the model fitted with these effects at their true values.
Results in FOLDER are kept: what was cut short goes on where it was.
"""

import json
import os
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import mujoco

import windows
from machine import STEP, Course, Machine, feed_forward, record, write

OWN = 12
JOINTS = (3, 4, 5)
HORIZON = 0.5

# How much farther off than the true model a diagnosed one may be: what is told is in how many cases it is.
ALLOWED = 1.3

EFFECTS = ["transmission_efficiency", "stribeck_friction", "torque_ripple", "joint_spring", "asymmetric_friction",
           "torque_current_nonlinearity", "load_dependent_friction", "presliding_hysteresis"]


def own_machine(number):
    """A robot with one to three effects of sizes that are drawn, the motions of its two recordings, and the generator of their noise."""
    rng = np.random.default_rng([2026, number])
    joints = int(rng.choice(JOINTS))
    machine = Machine(rng, joints)
    chosen = rng.choice(len(EFFECTS), size=int(rng.integers(1, 4)), replace=False)
    for k, joint in zip(chosen, rng.permutation(joints)[: len(chosen)]):
        fc = machine.Fc[joint]
        size = rng.uniform(0.5, 1.5)
        parameters = {
            "transmission_efficiency": {"R": 1 - 0.16 * size},
            "stribeck_friction": {"Fs": 0.5 * fc * size, "vs": rng.uniform(0.08, 0.2)},
            "torque_ripple": {"amplitude": 0.3 * fc * size, "order": int(rng.integers(6, 24)), "phase": rng.uniform(0, 6)},
            "joint_spring": {"k": 2.0 * fc * size, "q0": rng.uniform(-0.3, 0.3)},
            "asymmetric_friction": {"dFc": 0.3 * fc * size, "dFv": 0.1 * machine.Fv[joint] * size},
            "torque_current_nonlinearity": {"c3": -0.06 * size},
            "load_dependent_friction": {"mu": 0.12 * size},
            "presliding_hysteresis": {"sigma0": fc / rng.uniform(0.01, 0.03), "sigma1": 0.5 * machine.Fv[joint]},
        }[EFFECTS[k]]
        machine.with_effect(EFFECTS[k], int(joint), **{key: float(value) for key, value in parameters.items()})
    courses = [Course(rng, joints) for _ in range(2)]
    largest = np.max([np.abs(feed_forward(machine, course, STEP)[1]).max(axis=0) for course in courses], axis=0) / machine.kt
    for effect in machine.effects:
        if effect["effect"] == "torque_current_nonlinearity":
            # A share of the torque at the largest current that the motions ask for: beyond 15 % it does not reach their torques.
            effect["parameters"]["c3"] /= largest[machine.names.index(effect["joints"][0])] ** 2
    return machine, courses, rng


def problem(robot, drive, period, inertials, more=""):
    return f"""name = "proof"
[robot]
{robot}
inertials = "{inertials}"
[drive]
torque_constant = {drive["kt"]}
rotor_inertia = {drive["rotor_inertia"]}
effects = ["coulomb_friction", "viscous_friction"]
{more}
[recordings]
train = ["train.csv"]
validation = ["validation.csv"]
signal = "current"
period = {period}
"""


def true_model(robot, drive, truth, here):
    """The problem of a recording with the concealed effects at their true values."""
    lists, values = {}, []
    for effect in truth["effects"]:
        name, parameters = effect["effect"], dict(effect["parameters"])
        if name == "unmodelled_payload":
            (here / "loaded.urdf").write_text(loaded((here / "robot.urdf").read_text(), effect["joints"][0], parameters))
            robot = robot.replace("robot.urdf", "loaded.urdf")
            continue
        if name == "thermal_drift":
            # It is stated in N·m·s/rad, and not as a share of a viscous friction, which nobody tells: it is fitted.
            del parameters["gain"]
        second = parameters.pop("second_harmonic", None)
        if second is not None:
            parameters |= {"amplitude2": second["amplitude"], "phase2": second["phase"]}
        # A coupling is of the joint that the other's motor moves too.
        for joint in effect["joints"][1:] if name == "kinematic_coupling" else effect["joints"]:
            lists.setdefault(joint, []).append(name)
            numbers = {key: value for key, value in parameters.items() if isinstance(value, (int, float))}
            values += [f'"{joint}.{name}.{key}" = {float(value)}' for key, value in numbers.items()]
    more = "[drive.effects_of]\n" if lists else ""
    for joint, names in lists.items():
        more += f'{joint} = {json.dumps(["coulomb_friction", "viscous_friction"] + names)}\n'
    more += "[drive.values]\n" + "\n".join(values) + "\n" if values else ""
    return problem(robot, drive, drive["period"], drive["inertials"], more)


def loaded(urdf, joint, load):
    """The robot with a load fixed to the link that a joint moves."""
    tree = ElementTree.fromstring(urdf)
    link = tree.find(f"joint[@name='{joint}']/child").get("link")
    body = ElementTree.SubElement(ElementTree.SubElement(tree, "link", name="load"), "inertial")
    ElementTree.SubElement(body, "origin", xyz=" ".join(map(str, load["com"])))
    ElementTree.SubElement(body, "mass", value=str(load["mass"]))
    ElementTree.SubElement(body, "inertia", {f"i{axes}": str(value) for axes, value in load["inertia_about_com"].items()})
    held = ElementTree.SubElement(tree, "joint", name="load", type="fixed")
    ElementTree.SubElement(held, "parent", link=link)
    ElementTree.SubElement(held, "child", link="load")
    return ElementTree.tostring(tree, encoding="unicode")


def run(leaves, *command):
    """Runs a command that leaves a file, unless that is there. A search that did not converge leaves what it has come to."""
    if leaves.exists():
        return
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if not leaves.exists():
        raise RuntimeError(f"{' '.join(map(str, command))}: {done.stderr[-600:]}{done.stdout[-200:]}")


def exported(exid, here, verb, toml, name):
    """The MuJoCo model of a result, with its plugin."""
    result, out = here / name, here / f"{name}_mujoco"
    run(result / "result.json", exid, verb, here / toml, "--out", result, "--quiet", "--threads", "1")
    run(out / "model.xml", exid, "export", result, "--to", "mujoco", "--out", out)
    return windows.Exported(out, result)


def prepare(folder, case, trials):
    """Recordings and problems of a case; what is concealed in it, its period, and the robot itself where it is an own one."""
    here = folder / case
    here.mkdir(parents=True, exist_ok=True)
    if case.startswith("own"):
        machine, courses, rng = own_machine(int(case[3:]))
        if not (here / "validation.csv").exists():
            write(here / "train.csv", record(machine, courses[0], 4, rng))
            write(here / "validation.csv", record(machine, courses[1], 3, rng))
            (here / "model.xml").write_text(machine.mjcf(drives=False))
        drive = {"kt": machine.kt.tolist(), "rotor_inertia": machine.armature.tolist()}
        (here / "problem.toml").write_text(problem('mjcf = "model.xml"', drive, courses[0].period, "estimate"))
        return machine.effects, courses[0].period, machine
    source = trials / case
    for name in ("robot.urdf", "train.csv", "validation.csv"):
        if not (here / name).exists():
            os.symlink((source / name).resolve(), here / name)
    drive = json.loads((source / "drive.json").read_text())
    truth = json.loads((source / "truth.json").read_text())
    robot = f'urdf = "robot.urdf"\ngravity = {[float(g) for g in drive["gravity"]]}'
    (here / "problem.toml").write_text(problem(robot, drive, drive["period"], drive["inertials"]))
    (here / "truth.toml").write_text(true_model(robot, drive, truth, here))
    return truth["effects"], drive["period"], None


HEAD = ("| case | concealed | before | after | true model | after/before | after/true | all joints: after/before | after/true |\n"
        "|---|---|---|---|---|---|---|---|---|")


class Rolled:
    """Errors of the declared, the diagnosed and the true model: of the joints with an effect, and of all."""

    def __init__(self, exid, folder, case, trials):
        self.effects, period, machine = prepare(folder, case, trials)
        here = folder / case
        # What changes from period to period is not in their mean.
        changes = any(e["effect"] == "thermal_drift" for e in self.effects)
        recording = windows.Held(here / "validation.csv", None if changes else period)
        models = [exported(exid, here, "fit", "problem.toml", "declared"), exported(exid, here, "diagnose", "problem.toml", "diagnosed"),
                  windows.Own(machine) if machine else exported(exid, here, "fit", "truth.toml", "truth")]
        joints = sorted({int(j[5:]) - 1 for e in self.effects for j in e["joints"]}) or slice(None)
        errors = np.array([windows.errors(recording, model, HORIZON, joints) for model in models])
        self.error = errors[:, 0]
        # Of the joints with an effect and of all: after/before and after/true.
        self.ratios = np.array([errors[1] / errors[0], errors[1] / errors[2]]).T

    def row(self, case):
        concealed = ", ".join(f"{e['effect']} {'+'.join(j[5:] for j in e['joints'])}" for e in self.effects) or "nothing"
        cells = [case, concealed] + [f"{1e3 * e:.3f}" for e in self.error] + [f"{r[0]:.3f} | {r[1]:.2f}" for r in self.ratios]
        return f"| {' | '.join(cells)} |"


def table(exid, folder, cases, trials):
    """Prints a row for every case; what has been rolled out."""
    print(HEAD)
    done = []
    for case in cases:
        try:
            done.append(Rolled(exid, folder, case, trials))
            print(done[-1].row(case), flush=True)
        except RuntimeError as failed:
            print(f"| {case} | {failed} |", flush=True)
    return done


def main():
    exid, folder, trials = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
    cases = sys.argv[4:] or sorted(p.name for p in trials.iterdir() if (p / "truth.json").exists()) + [f"own{k:02}" for k in range(1, OWN + 1)]
    controls = [case for case in cases if not case.startswith("own") and not json.loads((trials / case / "truth.json").read_text())["effects"]]
    done = table(exid, folder, [case for case in cases if case not in controls], trials)
    for k, name in enumerate(("joints with an effect", "all joints")) if done else ():
        before, true = np.array([rolled.ratios[k] for rolled in done]).T
        print(f"\n{name}: after/before median {np.median(before):.3f}, largest {before.max():.3f}; after/true median "
              f"{np.median(true):.2f}, largest {true.max():.2f}, above {ALLOWED} in {(true > ALLOWED).sum()} of {len(true)} cases.")
    if controls:
        print("\nNothing concealed, all joints:\n")
        table(exid, folder, controls, trials)


if __name__ == "__main__":
    main()
