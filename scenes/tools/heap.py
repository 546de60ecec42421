"""The assets of the heap scene: a pile of pebbles, dice and rings.

Each body lies in a ball; the balls are put where they come to lie lowest, on those before them.
"""

import numpy as np

from . import box, files, solids

BODIES = 110
GOLDEN = 137.50776405  # degrees; directions at its multiples are far from each other


def places(radii, slope=0.55, reach=1.6, steps=81):
    """Returns the centres of balls of these radii. They pile up towards the middle."""
    x, z = (a.ravel() for a in np.meshgrid(np.linspace(-reach, reach, steps),
                                           np.linspace(-reach, reach, steps), indexing="ij"))
    centres = []
    for i, radius in enumerate(radii):
        height = np.full(len(x), radius)
        for c, other in zip(centres, radii):
            room = (radius + other) ** 2 - (x - c[0]) ** 2 - (z - c[2]) ** 2
            height = np.maximum(height, c[1] + np.sqrt(np.maximum(room, 0.0)) * (room > 0.0) -
                                1e3 * (room <= 0.0))
        angle = np.radians(GOLDEN * i)
        lean = 0.02 * (x * np.cos(angle) + z * np.sin(angle))  # breaks ties between equal positions
        at = np.argmin(height + slope * np.hypot(x, z) + lean)
        centres.append(np.array([x[at], height[at], z[at]]))
    return centres


def pebble(x, y, z):
    """Returns a rounded stone."""
    return (1.0 + 0.10 * np.sin(2.3 * x + 1.0) * np.sin(3.1 * y) + 0.08 * np.sin(4.1 * z + 2.0 * x)
            ) / np.sqrt(x * x + 1.5 * y * y + z * z)


def die(x, y, z):
    """Returns a cube with rounded edges."""
    return 0.72 / (x ** 8 + y ** 8 + z ** 8) ** 0.125


def make(folder, scale):
    """Writes the files. Returns the number of triangles."""
    rows = max(8, int(round(20 / scale)))
    shapes = {"pebbles": solids.star(pebble, rows), "dice": solids.star(die, rows),
              "rings": solids.torus(0.72, 0.28, rows)}
    names = tuple(shapes)
    radii = [0.13 + 0.13 * ((i * 0.7548776662) % 1.0) for i in range(BODIES)]
    parts = {name: [] for name in names}
    for i, (centre, radius) in enumerate(zip(places(radii), radii)):
        rotation = solids.turn(1, GOLDEN * i) @ solids.turn(0, 61.0 * i) @ solids.turn(2, 47.0 * i)
        name = names[i % 3]
        parts[name].append(solids.moved(shapes[name], centre, rotation, 1.12 * radius))
    return files.write_plys(folder, {name: box.together(p) for name, p in parts.items()})
