"""The assets of the reeds scene: metal with ridges that are finer than a pixel."""

import numpy as np

from . import files, solids, stone

PROFILE = [(0.0, 0.0), (0.62, 0.0), (0.66, 0.05), (0.66, 1.25), (0.62, 1.30), (0.0, 1.30)]


def sheet(ridges, width, depth):
    """A flat sheet whose ridges run along z, each with two flat flanks of 30 degrees."""
    pitch = width / ridges
    flank = np.radians(30.0)
    x = np.arange(2 * ridges + 1) * (pitch / 2) - width / 2
    y = 0.5 * pitch * np.tan(flank) * (np.arange(2 * ridges + 1) % 2)
    parts = []
    a, b = np.stack([x[:-1], y[:-1]], 1), np.stack([x[1:], y[1:]], 1)
    for point in (a, b):
        for z in (-depth / 2, depth / 2):
            parts.append(np.stack([point[:, 0], point[:, 1], np.full(len(point), z)], axis=1))
    slope = np.where(np.arange(len(a)) % 2 == 0, -1.0, 1.0) * np.sin(flank)
    normal = np.stack([slope, np.full(len(a), np.cos(flank)), np.zeros(len(a))], axis=1)
    n, i = len(a), np.arange(len(a))
    faces = np.concatenate([np.stack([i, i + n, i + 3 * n], 1),
                            np.stack([i, i + 3 * n, i + 2 * n], 1)])
    return {"positions": np.concatenate(parts), "normals": np.tile(normal, (4, 1)), "faces": faces}


def drum(ridges, rows):
    """A drum whose side has ridges that run upwards, of four points each."""
    sin, cos = solids.circle(4 * ridges)
    deep = 0.0011 * np.cos(2 * np.pi * np.arange(4 * ridges + 1) / 4)
    radius = 0.6 + deep[None, :] + 0.05 * np.sin(np.linspace(0, np.pi, rows))[:, None]
    height = np.broadcast_to(np.linspace(0.0, 1.3, rows)[:, None], radius.shape)
    return solids.grid(np.stack([radius * sin, height, radius * cos], axis=2))


def make(folder, scale):
    """Writes the files, returns the number of triangles."""
    few = max(1.0, scale)
    lid = stone.lathe([(0.6, 1.3), (0.6, 1.32), (0.58, 1.34), (0.0, 1.34)], int(160 / few))
    return files.write_plys(folder, {"sheet": sheet(int(4000 / few), 6.0, 6.0),
                                     "drum": drum(int(2000 / few), 9), "lid": lid})
