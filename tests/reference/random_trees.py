"""Writes the random trees of robots/: what URDF allows and robots rarely have, all at once.

Branches, sliding and continuous joints, tilted axes that are not of unit length, fixed joints at the
base, inside chains and at their ends, inertial frames turned and shifted, links without inertial,
and elements in an order that is not the one of the tree. Needs numpy.
"""

from pathlib import Path

import numpy as np

# Number of moving joints of each tree.
SIZES = [3, 4, 5, 6, 7, 8]
POINTS = 6


def main():
    folder = Path(__file__).resolve().parent / "robots"
    folder.mkdir(exist_ok=True)
    for seed, size in enumerate(SIZES):
        draw = np.random.default_rng(1000 + seed)
        (folder / f"tree{size}.urdf").write_text(tree(draw, f"tree{size}", size))


def tree(draw, name, size):
    elements, links = [], ["base"]
    elements.append(link(draw, "base", "inertial"))
    # Letters in random order, so that sorting by name is not the order of the tree.
    letters = list(draw.permutation(list("abcdefgh")[:size]))
    for k, letter in enumerate(letters):
        parent = links[-1] if draw.random() < 0.7 else links[draw.integers(len(links))]
        if draw.random() < 0.5:
            flange = f"flange_{letter}"
            elements += [link(draw, flange, "inertial"), joint(draw, f"fix_{letter}", "fixed", parent, flange)]
            parent = flange
        kind = str(draw.choice(["revolute", "continuous", "prismatic"], p=[0.5, 0.25, 0.25]))
        # A link without inertial in the middle of the tree: its parameters are zeros, not missing.
        content = "none" if k == size // 2 else "inertial"
        child = f"link_{letter}"
        elements += [link(draw, child, content), joint(draw, f"joint_{letter}", kind, parent, child)]
        links.append(child)
    for end in ("tool", "camera"):
        elements += [link(draw, end, "inertial"), joint(draw, f"fix_{end}", "fixed", links[-1], end)]
    elements += [link(draw, "tip", "none"), joint(draw, "fix_tip", "fixed", "tool", "tip")]
    body = "\n".join(elements[i] for i in draw.permutation(len(elements)))
    return f'<?xml version="1.0"?>\n<robot name="{name}">\n{body}\n</robot>\n'


def link(draw, name, content):
    if content == "none":
        return f'  <link name="{name}"/>'
    roll_pitch_yaw = draw.uniform(-1.5, 1.5, 3).round(4)
    turn = rotation(roll_pitch_yaw)
    points = draw.uniform(-0.3, 0.3, (POINTS, 3))
    mass = round(draw.uniform(0.5, 5.0), 4)
    arms = points - points.mean(axis=0)
    second = arms.T @ arms * mass / POINTS
    tensor = turn.T @ (np.trace(second) * np.eye(3) - second) @ turn
    entries = [("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2)]
    inertia = " ".join(f'{key}="{tensor[i, j]:.8f}"' for key, i, j in entries)
    return (
        f'  <link name="{name}">\n    <inertial>\n'
        f'      <origin xyz="{triple(points.mean(axis=0))}" rpy="{triple(roll_pitch_yaw)}"/>\n'
        f'      <mass value="{mass}"/>\n      <inertia {inertia}/>\n    </inertial>\n  </link>'
    )


def joint(draw, name, kind, parent, child):
    origin = f'<origin xyz="{triple(draw.uniform(-0.5, 0.5, 3))}" rpy="{triple(draw.uniform(-3, 3, 3))}"/>'
    axis = "" if kind == "fixed" else f'\n    <axis xyz="{triple(draw.uniform(-1, 1, 3).round(1))}"/>'
    limit = "" if kind == "fixed" else '\n    <limit lower="-3.0" upper="3.0" velocity="2.0" effort="100.0"/>'
    return (
        f'  <joint name="{name}" type="{kind}">\n    <parent link="{parent}"/>\n    <child link="{child}"/>\n'
        f"    {origin}{axis}{limit}\n  </joint>"
    )


def rotation(roll_pitch_yaw):
    """Rot_z(yaw) Rot_y(pitch) Rot_x(roll)."""
    (sx, sy, sz), (cx, cy, cz) = np.sin(roll_pitch_yaw), np.cos(roll_pitch_yaw)
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def triple(values):
    return " ".join(f"{value:.6g}" for value in values)


if __name__ == "__main__":
    main()
