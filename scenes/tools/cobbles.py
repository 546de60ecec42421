"""The assets of the cobbles scene: maps of a wet pavement, and the bollards on it."""

import numpy as np

from . import files, solids, stone
from .noise import smooth_noise

ROWS, COLUMNS = 12, 8  # stones in the map, which repeats


def stones(size):
    """Returns (height, index of the stone) at each texel: rounded setts in a running bond."""
    v = (np.arange(size) + 0.5)[:, None] / size * ROWS
    row = np.floor(v)
    u = np.arange(size)[None, :] / size * COLUMNS + 0.5 * (row % 2)
    column = np.floor(u) % COLUMNS
    du, dv = np.abs(u - np.floor(u) - 0.5) * 2, np.abs(v - row - 0.5) * 2
    edge = (du ** 6 + dv ** 6) ** (1 / 6)
    dome = np.sqrt(np.maximum(1.0 - 0.93 * edge ** 2, 0.0)) * (edge < 0.96)
    return dome, (row * COLUMNS + column) * np.ones_like(u)


def normal_map(size):
    """Returns normals: x along u, y along v, z outwards. The stones are 6 % of the map's width high."""
    dome, number = stones(size)
    rough = smooth_noise(size, size, (96, 96), 31) - 0.5
    relief = size * (0.022 * dome + 0.0016 * rough)
    du = 0.5 * (np.roll(relief, -1, axis=1) - np.roll(relief, 1, axis=1))
    dv = 0.5 * (np.roll(relief, -1, axis=0) - np.roll(relief, 1, axis=0))
    n = np.stack([-du, -dv, np.ones_like(du)], axis=2)
    n /= np.linalg.norm(n, axis=2)[:, :, None]
    return 0.5 * n + 0.5


def colour_map(size):
    """Returns granite of several greys, in sRGB."""
    dome, number = stones(size)
    tone = 0.30 + 0.22 * ((number * 0.618034) % 1.0) + 0.10 * smooth_noise(size, size, (128, 128),
                                                                          32)
    tone = tone * (0.35 + 0.65 * (dome > 0.0))
    return tone[:, :, None] * np.array([1.0, 0.95, 0.88])


def make(folder, scale):
    """Writes the files. Returns the number of triangles."""
    steps = max(3, int(round(8 / scale)))
    profile = [(0.17, 0.0), (0.17, 0.10), (0.12, 0.13)] + solids.curve(
        [(0.115, 0.15), (0.10, 0.62), (0.14, 0.66), (0.14, 0.70), (0.09, 0.73), (0.13, 0.82),
         (0.09, 0.92), (0.0, 0.95)], steps)
    size = 1024
    files.write_png(folder / "cobbles_normal.png", normal_map(size))
    files.write_png(folder / "cobbles.png", colour_map(size))
    return files.write_plys(folder, {"bollard": stone.lathe(profile, 8 * steps)})
