"""The assets of the grace scene: Martin Newell's teapot (1975) and the map of its wooden table.

The control points are his, as published by Blinn ("What, teapots again?", 1987): body, lid and
bottom by turning a profile, handle and spout as patches with a mirror image.
"""

import numpy as np

from . import files, stone
from .noise import smooth_noise

# (radius, height) of cubic Bezier segments, from the lid's knob down to the bottom.
LID = [[(0.0, 3.15), (0.8, 3.15), (0.0, 2.85), (0.2, 2.7)],
       [(0.2, 2.7), (0.4, 2.55), (1.3, 2.55), (1.3, 2.4)]]
BODY = [[(1.4, 2.4), (1.3375, 2.53125), (1.4375, 2.53125), (1.5, 2.4)],
        [(1.5, 2.4), (1.75, 1.875), (2.0, 1.35), (2.0, 0.9)],
        [(2.0, 0.9), (2.0, 0.45), (1.5, 0.225), (1.5, 0.15)],
        [(1.5, 0.15), (1.5, 0.075), (1.425, 0.0), (0.0, 0.0)]]
# Half patches: for each row, its first and last point (along, height) and its half width.
HANDLE = [[((-1.6, 2.025), (-1.5, 2.25), 0.3), ((-2.3, 2.025), (-2.5, 2.25), 0.3),
           ((-2.7, 2.025), (-3.0, 2.25), 0.3), ((-2.7, 1.8), (-3.0, 1.8), 0.3)],
          [((-2.7, 1.8), (-3.0, 1.8), 0.3), ((-2.7, 1.575), (-3.0, 1.35), 0.3),
           ((-2.5, 1.125), (-2.65, 0.9375), 0.3), ((-2.0, 0.9), (-1.9, 0.6), 0.3)]]
SPOUT = [[((1.7, 1.425), (1.7, 0.6), 0.66), ((2.6, 1.425), (3.1, 0.825), 0.66),
          ((2.3, 2.1), (2.4, 2.025), 0.25), ((2.7, 2.4), (3.3, 2.4), 0.25)],
         [((2.7, 2.4), (3.3, 2.4), 0.25), ((2.8, 2.475), (3.525, 2.49375), 0.25),
          ((2.9, 2.475), (3.45, 2.5125), 0.15), ((2.8, 2.4), (3.2, 2.4), 0.15)]]
ROUND = 0.56  # Newell's quarter circle


def bernstein(t):
    s = 1.0 - t
    return np.stack([s ** 3, 3 * s * s * t, 3 * s * t * t, t ** 3], axis=1)


def tessellate(net, steps, corner, size):
    """Returns the mesh of a 4x4 control net; its uv are inside the square at corner."""
    t = np.linspace(0.0, 1.0, steps + 1)
    b = bernstein(t)
    points = np.einsum("ia,jb,abk->ijk", b, b, np.asarray(net, dtype=np.float64))
    v, u = np.meshgrid(t, t, indexing="ij")
    uv = np.stack([corner[0] + size[0] * u, corner[1] + size[1] * v], axis=2)
    return {"positions": points.reshape(-1, 3), "uv": uv.reshape(-1, 2),
            "faces": stone.grid_faces(steps + 1, steps + 1)}


def turned(segments, steps):
    """Returns surfaces of revolution: four patches around y."""
    parts = []
    for row, segment in enumerate(segments):
        for quarter in range(4):
            c, s = [(1, 0), (0, 1), (-1, 0), (0, -1)][quarter]
            circle = [(1, 0), (1, ROUND), (ROUND, 1), (0, 1)]
            net = [[(r * (c * p - s * q), h, r * (s * p + c * q)) for p, q in circle]
                   for r, h in segment]
            parts.append(tessellate(net, steps, (quarter / 4, row / len(segments)),
                                    (0.25, 1 / len(segments))))
    return parts


def tube(segments, steps):
    """Returns handle or spout: each half patch and its mirror image."""
    parts = []
    for row, segment in enumerate(segments):
        for side in (1.0, -1.0):
            net = [[(a[0], a[1], 0.0), (a[0], a[1], side * w), (b[0], b[1], side * w),
                    (b[0], b[1], 0.0)] for a, b, w in segment]
            part = tessellate(net, steps, (0.5 * (side < 0), row / 2), (0.5, 0.5))
            if side < 0:
                part["faces"] = part["faces"][:, ::-1]
            parts.append(part)
    return parts


def joined(parts):
    """Joins patches into one mesh with smooth normals."""
    starts = np.cumsum([0] + [len(p["positions"]) for p in parts[:-1]])
    mesh = {k: np.concatenate([p[k] for p in parts]) for k in ("positions", "uv")}
    mesh["faces"] = np.concatenate([p["faces"] + s for p, s in zip(parts, starts)])
    mesh = stone.without_slivers(mesh)
    mesh["normals"] = stone.smooth_normals(mesh["positions"], mesh["faces"])
    return mesh


def pot(steps):
    """Returns body, lid and bottom, with `steps` cells per side of each patch."""
    return joined(turned(LID, steps) + turned(BODY, steps))


def fittings(steps):
    """Returns handle and spout."""
    return joined(tube(HANDLE, steps) + tube(SPOUT, steps))


def planks(height, width):
    """Returns boards along u with grain, in sRGB."""
    v = (np.arange(height) + 0.5)[:, None] / height * 8.0
    board = np.floor(v)
    offset = (board * 0.37) % 1.0
    u = np.arange(width)[None, :] / width
    warp = smooth_noise(height, width, (32, 8), 21)
    rings = v * 9.0 + 5.0 * warp + 11.0 * offset + 1.5 * np.sin(2 * np.pi * (u + offset))
    grain = 0.5 + 0.5 * np.sin(2 * np.pi * rings)
    fibre = smooth_noise(height, width, (512, 24), 22)
    tone = 0.62 + 0.16 * grain + 0.12 * (fibre - 0.5) + 0.16 * (offset - 0.5)
    gap = np.exp(-(np.minimum(v - board, board + 1 - v) / 0.012) ** 2)
    tone = tone * (1.0 - 0.75 * gap)
    return np.clip(tone[:, :, None] * np.array([0.78, 0.56, 0.39]) + 0.02, 0.0, 1.0)


def make(folder, scale):
    """Writes the files. Returns the number of triangles."""
    steps = max(4, int(round(24 / scale)))
    body, attached = pot(steps), fittings(steps)
    files.write_ply(folder / "teapot.ply", body)
    files.write_obj(folder / "fittings.obj", attached)
    files.write_png(folder / "planks.png", planks(1024, 1024))
    return len(body["faces"]) + len(attached["faces"])
