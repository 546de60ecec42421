"""The assets of the mist scene: trunks of trees on uneven ground."""

import numpy as np

from . import box, files, noise, solids, stone

TRUNKS = 44
SIZE = 12.0  # half the width of the ground


def height(x, z):
    """Returns the height of the ground."""
    p = np.stack([0.35 * x, np.zeros_like(x), 0.35 * z], axis=-1)
    return 0.5 * noise.fractal_3d(p, 3, 41) - 0.25


def ground(rows):
    line = np.linspace(-SIZE, SIZE, rows)
    x, z = np.meshgrid(line, line)
    points = np.stack([x, height(x, z), z], axis=2).transpose(1, 0, 2).reshape(-1, 3)
    faces = stone.grid_faces(rows, rows)
    a, b, c = (points[faces[0, k]] for k in range(3))
    if np.cross(b - a, c - a)[1] < 0:
        faces = faces[:, ::-1]
    uv = points[:, [0, 2]]
    return {"positions": points, "uv": uv, "faces": faces,
            "normals": stone.smooth_normals(points, faces)}


def trunks(steps):
    parts = []
    for i in range(TRUNKS):
        x = ((0.5 + i * 0.7548776662466927) % 1 * 2 - 1) * 6.5
        z = 3.2 - 12.5 * ((0.5 + i * 0.5698402909980532) % 1)
        if abs(x) < 0.7 and z > 0:
            continue  # the view
        thick = 0.09 + 0.13 * (i * 0.618033988749895 % 1)
        low = height(np.array([x]), np.array([z]))[0] - 0.1
        profile = [(0, 0), (1.9 * thick, 0), (1.25 * thick, 0.3), (thick, 0.9), (0.8 * thick, 4.5),
                   (0.6 * thick, 7.0), (0, 7.0)]
        tilt = solids.turn(2, 7 * np.sin(2.4 * i)) @ solids.turn(0, 6 * np.cos(1.7 * i))
        parts.append(solids.moved(stone.lathe(profile, 2 * steps), (x, low, z), tilt))
    return box.together(parts)


def make(folder, scale):
    """Writes the files. Returns the number of triangles."""
    steps = max(4, int(round(10 / scale)))
    return files.write_plys(folder, {"ground": ground(max(8, int(round(80 / scale)))),
                                     "trunks": trunks(steps)})
