"""The assets of the tree scene: a tree whose twigs carry single leaves."""

import numpy as np

from . import box, files, solids

GOLDEN = 137.50776405  # degrees, between one branch and the next


def frame(direction, roll):
    """Returns a rotation that maps y to `direction`."""
    helper = np.array([1.0, 0.0, 0.0]) if abs(direction[0]) < 0.8 else np.array([0.0, 0.0, 1.0])
    side = np.cross(direction, helper)
    side /= np.linalg.norm(side)
    return np.stack([side, direction, np.cross(side, direction)], axis=1) @ solids.turn(1, roll)


def grow(base, rotation, length, radius, level, limbs, tips):
    """Adds a limb and, recursively, its branches. `tips` receives (position, rotation) of each leaf."""
    end = base + rotation[:, 1] * length
    limbs.append((base, end, radius))
    if level == 0:
        for i in range(9):
            at = base + rotation[:, 1] * length * (0.25 + 0.75 * i / 8)
            tips.append((at, rotation @ solids.turn(1, GOLDEN * i) @ solids.turn(0, 58.0)))
        return
    count = 7 if level > 1 else 6
    for i in range(count):
        along = 0.42 + 0.58 * (i + 1) / count
        tilt = 62.0 - 26.0 * i / (count - 1)
        turned = rotation @ solids.turn(1, GOLDEN * (i + level)) @ solids.turn(0, tilt)
        # Limbs bend slightly upwards.
        direction = turned[:, 1] + np.array([0.0, 0.18, 0.0])
        child = frame(direction / np.linalg.norm(direction), GOLDEN * i)
        grow(base + rotation[:, 1] * length * along, child, 0.56 * length, 0.5 * radius,
             level - 1, limbs, tips)


def limb(base, end, radius, sides):
    """Returns an open cone."""
    axis = (end - base) / np.linalg.norm(end - base)
    rotation = frame(axis, 0.0)
    sin, cos = solids.circle(sides)
    ring = np.outer(cos, rotation[:, 0]) + np.outer(sin, rotation[:, 2])
    return solids.grid(np.stack([base + radius * ring, end + 0.55 * radius * ring])[:, ::-1])


def leaf():
    """Returns four triangles, folded along the middle."""
    points = np.array([(0, 0, 0), (0.28, 0.45, 0.10), (0, 0.5, 0), (-0.28, 0.45, 0.10),
                       (0, 1, -0.12)], dtype=np.float64)
    return solids.faceted({"positions": points, "uv": points[:, :2] + [0.5, 0.0], "faces": np.array(
        [(0, 1, 2), (0, 2, 3), (2, 1, 4), (3, 2, 4)])})


def make(folder, scale):
    """Writes the files. Returns the number of triangles."""
    limbs, tips = [], []
    grow(np.zeros(3), np.eye(3), 1.5, 0.11, 4 if scale < 2 else 3, limbs, tips)
    wood = box.together([limb(*one, 6 if one[2] < 0.03 else 12) for one in limbs])
    leaves = box.together([solids.moved(leaf(), at, rotation, 0.085) for at, rotation in tips])
    return files.write_plys(folder, {"wood": wood, "leaves": leaves})
