"""Does a diagnosis make the models of real robots move like them?

    real.py EXID FOLDER DATA

UR10e, Staubli TX40 and KUKA LWR4+, whose recordings are in DATA: `exid diagnose` of the rigid body with Coulomb and viscous friction,
then `exid rollout` of the result on the recording that was not fitted. Errors of position after half a second, in mrad, by joint: of the declared model
as fitted, of the diagnosed one, and of what the noise of the signal alone would leave of a model that is right.
"""

import json
import math
import sys
from pathlib import Path

from proof import run

ROOT = Path(__file__).resolve().parents[2]
PROBLEMS = {
    "ur10e": ROOT / "examples/real_proofs/ur10e.toml",
    "tx40": ROOT / "examples/real_proofs/tx40.toml",
    "lwr4": ROOT / "tests/real_recordings/lwr4.toml",
}
HORIZON = 0.5

REDUCTION = [32.0, 32.0, 45.0, -48.0, 45.0, 32.0]
QUARTER_TURN = math.pi / 2
OFFSET = [0.0, -QUARTER_TURN, QUARTER_TURN, 0.0, 0.0, 0.0]


def tx40_by_joint(source, folder):
    """Both halves of the run, joint by joint: positions as encoders of the joints give them, torques of the motors at joint scale."""
    header, *rows = source.read_text().splitlines()
    names = header.split(",")
    at = [[names.index(f"{kind}{k + 1}") for k in range(6)] for kind in ("qm", "taum")]
    head = ",".join(["t"] + [f"q{k + 1}" for k in range(6)] + [f"tau{k + 1}" for k in range(6)])
    lines = []
    for row in rows:
        values = [float(x) for x in row.split(",")]
        q = [values[i] / r for i, r in zip(at[0], REDUCTION)]
        q[5] -= q[4]
        torque = [values[i] * r for i, r in zip(at[1], REDUCTION)]
        lines.append(",".join(repr(x) for x in [values[0]] + [x + o for x, o in zip(q, OFFSET)] + torque))
    half = len(lines) // 2
    for name, part in (("first", lines[:half]), ("second", lines[half:])):
        (folder / f"tx40_{name}.csv").write_text("\n".join([head] + part) + "\n")


def prepare(robot, folder, data):
    text = PROBLEMS[robot].read_text()
    if robot == "tx40":
        tx40_by_joint(data / "tx40" / "excitation.csv", folder)
    if robot == "lwr4":
        runs = [f'"{data}/lwr4/measurements_{k}.csv"' for k in (1, 2, 3)]
        text = text.replace("{train}", f"{runs[1]}, {runs[2]}").replace("{validation}", runs[0])
    path = folder / f"{robot}.toml"
    path.write_text(text.replace("{data}", str(data)))
    return path


def size(spread):
    """Median in mrad, and how many windows are lost."""
    if spread is None:
        return "—"
    text = "no limit" if spread["median"] is None else f"{1e3 * spread['median']:.2f}"
    return f"{text} ({spread['lost']} lost)" if spread["lost"] else text


def main():
    exid, folder, data = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3]).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    print("| robot | joint | windows | before | after | noise alone | after/before |\n|---|---|---|---|---|---|---|")
    said = []
    for robot in sys.argv[4:] or list(PROBLEMS):
        path = prepare(robot, folder, data)
        found, rolled = folder / robot, folder / f"{robot}_rollout"
        run(found / "result.json", exid, "diagnose", path, "--out", found, "--quiet", "--threads", "1")
        run(rolled / "result.json", exid, "rollout", found, "--out", rolled, "--quiet", "--threads", "1")
        findings = json.loads((found / "result.json").read_text())["findings"]
        said.append(f"{robot}: " + "; ".join(f"{f['effect']} of {', '.join(f['joints'])}" for f in findings))
        result = json.loads((rolled / "result.json").read_text())
        horizon = next(h for h in result["horizons"] if abs(h["horizon"] - HORIZON) < 1e-9)
        for joint in horizon["joints"]:
            before, after = joint["before"], joint["after"]
            medians = [spread and spread["median"] for spread in (before, after)]
            ratio = f"{medians[1] / medians[0]:.2f}" if all(medians) else "—"
            print(f"| {robot} | {joint['joint']} | {after['windows']} | {size(before)} | {size(after)} | {size(joint['noise'])} | {ratio} |", flush=True)
    print("\nFound:\n\n" + "\n".join(f"- {line}" for line in said))


if __name__ == "__main__":
    main()
