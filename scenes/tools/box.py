"""The assets of the box scene: a room with bevelled edges, a block in it, and the teapot."""

import itertools

import numpy as np

from . import files, grace

SIDES = {"left": (0, -1), "right": (0, 1), "floor": (1, -1), "ceiling": (1, 1), "back": (2, -1),
         "front": (2, 1)}


def polygon(corners, outward, inside):
    """Returns a flat convex polygon. Its normal is `outward`, or the opposite if it is seen from inside."""
    corners = np.array(corners, dtype=np.float64)
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    normal /= np.linalg.norm(normal)
    wanted = -np.asarray(outward) if inside else np.asarray(outward)
    if np.dot(normal, wanted) < 0:
        corners, normal = corners[::-1], -normal
    uv = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])[:len(corners)]
    faces = np.array([(0, i, i + 1) for i in range(1, len(corners) - 1)])
    return {"positions": corners, "normals": np.tile(normal, (len(corners), 1)), "uv": uv,
            "faces": faces}


def together(parts):
    starts = np.cumsum([0] + [len(p["positions"]) for p in parts[:-1]])
    mesh = {k: np.concatenate([p[k] for p in parts]) for k in ("positions", "normals", "uv")}
    mesh["faces"] = np.concatenate([p["faces"] + s for p, s in zip(parts, starts)])
    return mesh


def bevelled_box(low, high, bevel, inside):
    """Returns meshes by name: the six sides, and "bevels", the surfaces between them."""
    low, high = np.array(low, dtype=np.float64), np.array(high, dtype=np.float64)
    centre, half = (low + high) / 2, (high - low) / 2

    def corner(axis, signs):
        """Returns the corner nearest to `signs` of the side perpendicular to `axis`."""
        offset = np.where(np.arange(3) == axis, half, half - bevel)
        return centre + np.array(signs) * offset

    meshes = {}
    for name, (axis, sign) in SIDES.items():
        # The corners in order around the side; u is the first of the other axes.
        first, second = [k for k in range(3) if k != axis]
        ring = []
        for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            signs = [0, 0, 0]
            signs[axis], signs[first], signs[second] = sign, a, b
            ring.append(corner(axis, signs))
        outward = np.eye(3)[axis] * sign
        meshes[name] = polygon(ring, outward, inside)
    between = []
    for axis in range(3):
        first, second = [k for k in range(3) if k != axis]
        for a, b in itertools.product((-1, 1), repeat=2):
            ends = []
            for end in (-1, 1):
                signs = [0, 0, 0]
                signs[axis], signs[first], signs[second] = end, a, b
                ends.append(signs)
            ring = [corner(first, ends[0]), corner(first, ends[1]), corner(second, ends[1]),
                    corner(second, ends[0])]
            outward = np.zeros(3)
            outward[first], outward[second] = a, b
            between.append(polygon(ring, outward, inside))
    for signs in itertools.product((-1, 1), repeat=3):
        between.append(polygon([corner(k, signs) for k in range(3)], signs, inside))
    meshes["bevels"] = together(between)
    return meshes


def make(folder, scale):
    """Writes the files. Returns the number of triangles."""
    steps = max(4, int(round(18 / scale)))
    room = bevelled_box((-4.0, 0.0, -4.0), (4.0, 5.6, 7.0), 0.5, inside=True)
    block = bevelled_box((-1.3, 0.0, -1.1), (1.3, 0.9, 1.1), 0.08, inside=False)
    meshes = {**room, "block": together([m for name, m in block.items() if name != "floor"]),
              "pot": grace.pot(steps), "fittings": grace.fittings(steps)}
    for name, mesh in meshes.items():
        files.write_ply(folder / f"{name}.ply", mesh)
    return sum(len(m["faces"]) for m in meshes.values())
