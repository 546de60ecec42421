"""The assets of the haze scene: a lantern whose bars throw shadows, its post, and a wall."""

import numpy as np

from . import box, files, solids, stone

BARS = 7
CENTRE = 2.35  # height of the lamp


def lantern(steps):
    """Returns base, bars, rings and roof around the lamp."""
    low, high, radius = CENTRE - 0.24, CENTRE + 0.22, 0.19
    parts = [stone.lathe([(0, low - 0.07), (0.09, low - 0.07), (0.2, low - 0.02), (0.2, low), (0, low)],
                         4 * steps),
             stone.lathe([(0, high), (0.26, high), (0.26, high + 0.02), (0.12, high + 0.13),
                          (0.05, high + 0.2), (0.03, high + 0.3), (0, high + 0.3)], 4 * steps)]
    for i in range(BARS):
        angle = 2 * np.pi * i / BARS
        x, z = radius * np.cos(angle), radius * np.sin(angle)
        bar = solids.cuboid((-0.012, low, -0.05), (0.012, high, 0.05))
        parts.append(solids.moved(bar, (x, 0, z), solids.turn(1, -np.degrees(angle))))
    return box.together(parts)


def post(steps):
    low = CENTRE - 0.31
    profile = [(0, 0), (0.2, 0), (0.2, 0.08), (0.12, 0.14), (0.07, 0.3), (0.045, 0.4), (0.04, low - 0.1),
               (0.07, low - 0.03), (0.07, low), (0, low)]
    return stone.lathe(profile, 4 * steps)


def surroundings():
    """Returns a wall with pillars behind the lantern, and a bench."""
    parts = [((-6, 0, -2.6), (6, 3.4, -2.3))]
    parts += [((x - 0.16, 0, -2.3), (x + 0.16, 3.6, -2.05)) for x in (-4.2, -2.1, 0.9, 3.0, 5.1)]
    parts += [((-1.9, 0.42, -1.2), (-0.5, 0.47, -0.8)), ((-1.9, 0.55, -1.25), (-0.5, 0.85, -1.21))]
    parts += [((x, 0, z), (x + 0.06, 0.42, z + 0.06)) for x in (-1.8, -0.66) for z in (-1.15, -0.9)]
    parts += [((x, 0.42, -1.25), (x + 0.06, 0.9, -1.21)) for x in (-1.8, -0.66)]
    return box.together([solids.cuboid(*corners) for corners in parts])


def make(folder, scale):
    """Writes the files. Returns the number of triangles."""
    steps = max(4, int(round(12 / scale)))
    return files.write_plys(folder, {"lantern": lantern(steps), "post": post(steps),
                                     "surroundings": surroundings()})
