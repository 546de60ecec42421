"""The assets of the hammered scene: a bowl, and the normal map of the hammer's marks."""

import numpy as np

from . import files, solids, stone

PROFILE = [(0.30, 0.0), (0.36, 0.06), (0.80, 0.24), (1.12, 0.72), (1.16, 0.86), (1.13, 0.87),
           (1.08, 0.73), (0.77, 0.28), (0.34, 0.11), (0.0, 0.09)]
MARKS = (26, 40)  # along v and u


def normal_map(height, width):
    """Returns normals of shallow dents: x along u, y along v, z outwards. u is around the bowl."""
    v = (np.arange(height) + 0.5)[:, None] / height * MARKS[0]
    u = (np.arange(width) + 0.5)[None, :] / width * MARKS[1] + 0.5 * (np.floor(v) % 2)
    row, column = np.floor(v), np.floor(u) % MARKS[1]
    number = row * MARKS[1] + column
    # The centre of each mark is slightly off the grid.
    x = u - np.floor(u) - 0.5 + 0.22 * ((number * 0.618034) % 1.0 - 0.5)
    y = v - row - 0.5 + 0.22 * ((number * 0.754878) % 1.0 - 0.5)
    slope = 0.34 * np.minimum(1.0, 1.6 * np.exp(-(x * x + y * y) / 0.18))
    n = np.stack([slope * x, slope * y, np.ones_like(x)], axis=2)
    n /= np.linalg.norm(n, axis=2)[:, :, None]
    return 0.5 * n + 0.5


def make(folder, scale):
    """Writes the files. Returns the number of triangles."""
    steps = max(2, int(round(10 / scale)))
    files.write_png(folder / "marks.png", normal_map(1024, 2048))
    return files.write_plys(folder, {
        "bowl": stone.lathe(solids.curve(PROFILE, steps), 16 * steps, 60.0)})
