"""Does a diagnosis make the simulator move like the robot?

    proof.py EXID FOLDER TRIALS [CASES...]

For every recording of TRIALS and for own robots with one to three effects concealed: `exid diagnose`, `exid export --to mujoco`, the
plugin compiled, the model loaded in MuJoCo and driven by the recorded currents of another recording, from starts all over it. Error
of position after half a second: of the declared model as fitted, of the diagnosed one, and of the true one. For own robots that is
the robot itself, in NumPy; for TRIALS, of which only the effects are known, the model fitted with these effects at their true values.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import mujoco

import windows
from machine import COUNTS, RATE, Course, Machine, record, write

OWN = 12
JOINTS = (3, 4, 5)
HORIZON = 0.5

EFFECTS = ["transmission_efficiency", "stribeck_friction", "torque_ripple", "joint_spring", "asymmetric_friction",
           "torque_current_nonlinearity", "load_dependent_friction", "presliding_hysteresis"]


def own_machine(number):
    """A robot with one to three effects of sizes that are drawn."""
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
            "torque_current_nonlinearity": {"c3": -0.06 * size * (machine.kt[joint] / (fc + machine.Fv[joint])) ** 2},
            "load_dependent_friction": {"mu": 0.12 * size},
            "presliding_hysteresis": {"sigma0": fc / rng.uniform(0.01, 0.03), "sigma1": 0.5 * machine.Fv[joint]},
        }[EFFECTS[k]]
        machine.with_effect(EFFECTS[k], int(joint), **{key: float(value) for key, value in parameters.items()})
    return machine, rng


def problem(robot, drive, period, inertials, effects='["coulomb_friction", "viscous_friction"]', more=""):
    return f"""name = "proof"
[robot]
{robot}
inertials = "{inertials}"
[drive]
torque_constant = {drive["kt"]}
rotor_inertia = {drive["rotor_inertia"]}
effects = {effects}
{more}
[recordings]
train = ["train.csv"]
validation = ["validation.csv"]
signal = "current"
period = {period}
"""


def true_drive(truth, joints):
    """The drive with the concealed effects at their true values, and the robot's own keys."""
    lists, values, robot = {}, [], ""
    for effect in truth["effects"]:
        name, parameters = effect["effect"], dict(effect["parameters"])
        if name == "presliding_hysteresis":
            parameters.pop("law", None)
        if name == "position_dependent_friction":
            return None
        for joint in effect["joints"]:
            if name == "kinematic_coupling" and joint != effect["joints"][1]:
                continue
            lists.setdefault(joint, []).append(name)
            if name == "thermal_drift":
                continue
            for key, value in parameters.items():
                if isinstance(value, (int, float)) and name != "unmodelled_payload":
                    values.append(f'"{joint}.{name}.{key}" = {float(value)}')
        if name == "unmodelled_payload":
            return None
    text = "[drive.effects_of]\n"
    for joint, names in lists.items():
        text += f'{joint} = {json.dumps(["coulomb_friction", "viscous_friction"] + names)}\n'
    return text + "[drive.values]\n" + "\n".join(values) + "\n" if lists else ""


def run(*command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{' '.join(map(str, command))}: {done.stderr[-600:]}{done.stdout[-200:]}")
    return done.stdout


def exported(exid, here, verb, toml, name):
    """The MuJoCo model of a result; the folder with model.xml and the plugin."""
    result, out = here / name, here / f"{name}_mujoco"
    if not (result / "result.json").exists():
        run(exid, verb, here / toml, "--out", result, "--quiet", "--threads", "1")
    if not (out / "model.xml").exists():
        run(exid, "export", result, "--to", "mujoco", "--out", out)
    return out


def prepare(exid, folder, case, trials):
    """Recordings and problems of a case; its robot, where it is an own one."""
    here = folder / case
    here.mkdir(parents=True, exist_ok=True)
    if case.startswith("own"):
        machine, rng = own_machine(int(case[3:]))
        if not (here / "validation.csv").exists():
            courses = [Course(rng, len(machine.names)) for _ in range(2)]
            write(here / "train.csv", record(machine, courses[0], 4, rng))
            write(here / "validation.csv", record(machine, courses[1], 3, rng))
            (here / "model.xml").write_text(machine.mjcf(drives=False))
        drive = {"kt": machine.kt.tolist(), "rotor_inertia": machine.armature.tolist()}
        (here / "problem.toml").write_text(problem('mjcf = "model.xml"', drive, 10.0, "estimate"))
        return machine, machine.effects, None, 10.0
    source = trials / case
    for name in ("robot.urdf", "train.csv", "validation.csv"):
        if not (here / name).exists():
            os.symlink(source / name, here / name)
    drive = json.loads((source / "drive.json").read_text())
    truth = json.loads((source / "truth.json").read_text())
    robot = f'urdf = "robot.urdf"\ngravity = {[float(g) for g in drive["gravity"]]}'
    (here / "problem.toml").write_text(problem(robot, drive, drive["period"], drive["inertials"]))
    more = true_drive(truth, None)
    if more is not None:
        (here / "truth.toml").write_text(problem(robot, drive, drive["period"], drive["inertials"], more=more))
    return None, truth["effects"], more, drive["period"]


def main():
    exid, folder, trials = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
    cases = sys.argv[4:] or sorted(p.name for p in trials.iterdir() if (p / "truth.json").exists()) + [f"own{k:02}" for k in range(1, OWN + 1)]
    print("| case | concealed | before | after | true model | after/before | after/true | all joints: after/before | after/true |\n"
          "|---|---|---|---|---|---|---|---|---|")
    ratios = []
    for case in cases:
        try:
            machine, effects, more, period = prepare(exid, folder, case, trials)
            here = folder / case
            before = exported(exid, here, "fit", "problem.toml", "declared")
            after = exported(exid, here, "diagnose", "problem.toml", "diagnosed")
            # What changes from period to period is not in their mean.
            changes = any(e["effect"] == "thermal_drift" for e in effects)
            recording = windows.Held(here / "validation.csv", None if changes else period)
            errors, nothing = {}, (float("nan"), float("nan"))
            joints = sorted({int(j[5:]) - 1 for e in effects for j in e["joints"]}) or slice(None)
            for name, model in (("before", before), ("after", after)):
                errors[name] = windows.errors(recording, windows.Exported(model), HORIZON, joints)
            if machine is not None:
                errors["true"] = windows.errors(recording, windows.Own(machine), HORIZON, joints)
            elif (here / "truth.toml").exists():
                errors["true"] = windows.errors(recording, windows.Exported(exported(exid, here, "fit", "truth.toml", "truth")), HORIZON, joints)
            else:
                errors["true"] = nothing
        except RuntimeError as failed:
            print(f"| {case} | {failed} |", flush=True)
            continue
        concealed = ", ".join(f"{e['effect']} {'+'.join(j[5:] for j in e['joints'])}" for e in effects) or "nothing"
        (b, b_all), (a, a_all), (t, t_all) = errors["before"], errors["after"], errors["true"]
        ratios.append((len(effects) > 0, a / b, a / t, a_all / b_all, a_all / t_all))
        print(f"| {case} | {concealed} | {1e3 * b:.3f} | {1e3 * a:.3f} | {1e3 * t:.3f} | {a / b:.3f} | {a / t:.2f} | "
              f"{a_all / b_all:.3f} | {a_all / t_all:.2f} |", flush=True)
    with_effects = np.array([r[1:] for r in ratios if r[0]])
    if len(with_effects):
        for name, k in (("joints with an effect", 0), ("all joints", 2)):
            before, true = with_effects[:, k], with_effects[:, k + 1]
            print(f"\n{name}: after/before median {np.median(before):.3f}, largest {before.max():.3f}; after/true median "
                  f"{np.nanmedian(true):.2f}, largest {np.nanmax(true):.2f}; {len(before)} cases with something concealed.")


if __name__ == "__main__":
    main()
