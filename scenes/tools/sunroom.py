"""The assets of the sunroom scene: a room whose right wall is a glass door with four leaves, one of
which is open, and whose back wall has a window of thick glass; a table and things on it."""

import numpy as np

from . import box, files, grace, solids, stone

WIDE, HIGH, DEEP, THICK = 2.3, 2.7, 2.6, 0.2  # x from -WIDE to WIDE, z from -DEEP to DEEP
DOOR = (-2.1, 1.9, 0.04, 2.35)  # in the right wall: min z, max z, min y, max y
LEAVES, OPEN = 4, 2  # number of leaves; index of the open one, from the back
WINDOW = (-1.5, 0.1, 1.0, 2.1)  # in the back wall: min x, max x, min y, max y
BAR = 0.05  # width of a frame


def walls():
    """Returns the shell; the right wall surrounds the door, the back wall the window."""
    z0, z1, y0, y1 = DOOR
    u0, u1, v0, v1 = WINDOW
    out, back = WIDE + THICK, -DEEP - THICK
    shell = [((-out, -THICK, back), (-WIDE, HIGH, DEEP + THICK)),
             ((-out, -THICK, DEEP), (out, HIGH, DEEP + THICK)),
             ((-out, HIGH, back), (out, HIGH + THICK, DEEP + THICK)),
             ((-out, -THICK, back), (out, 0, DEEP + THICK)),
             ((WIDE, 0, -DEEP), (out, HIGH, z0)), ((WIDE, 0, z1), (out, HIGH, DEEP)),
             ((WIDE, 0, z0), (out, y0, z1)), ((WIDE, y1, z0), (out, HIGH, z1)),
             ((-WIDE, 0, back), (u0, HIGH, -DEEP)), ((u1, 0, back), (out, HIGH, -DEEP)),
             ((u0, 0, back), (u1, v0, -DEEP)), ((u0, v1, back), (u1, HIGH, -DEEP))]
    return box.together([solids.cuboid(*corners) for corners in shell])


def leaf(k):
    """Returns min z, max z and x of a leaf; the open one is behind the next one."""
    z0, z1 = DOOR[:2]
    step = (z1 - z0) / LEAVES
    at = k + 1 if k == OPEN else k
    return z0 + at * step, z0 + (at + 1) * step, WIDE + (0.13 if k == OPEN else 0.05)


def frames():
    """Returns the frames of the leaves, and the bar of the window."""
    y0, y1 = DOOR[2:]
    parts = []
    for k in range(LEAVES):
        z0, z1, x = leaf(k)
        parts += [((x - 0.02, y0, z0), (x + 0.02, y1, z0 + BAR)),
                  ((x - 0.02, y0, z1 - BAR), (x + 0.02, y1, z1)),
                  ((x - 0.02, y0, z0 + BAR), (x + 0.02, y0 + BAR, z1 - BAR)),
                  ((x - 0.02, y1 - BAR, z0 + BAR), (x + 0.02, y1, z1 - BAR))]
    u0, u1, v0, v1 = WINDOW
    middle = (u0 + u1) / 2
    parts += [((middle - 0.03, v0, -DEEP - 0.07), (middle + 0.03, v1, -DEEP - 0.03))]
    return box.together([solids.cuboid(*corners) for corners in parts])


def panes():
    """Returns one sheet in each leaf."""
    y0, y1 = DOOR[2] + BAR, DOOR[3] - BAR
    sheets = []
    for k in range(LEAVES):
        z0, z1, x = leaf(k)
        corners = [(x, y, z) for y, z in ((y0, z0 + BAR), (y0, z1 - BAR), (y1, z1 - BAR),
                                          (y1, z0 + BAR))]
        sheets.append(box.polygon(corners, np.array((1.0, 0.0, 0.0)), inside=False))
    return box.together(sheets)


def make(folder, scale):
    """Writes the files. Returns the number of triangles."""
    steps = max(4, int(round(12 / scale)))
    u0, u1, v0, v1 = WINDOW
    thick = solids.cuboid((u0, v0, -DEEP - 0.12), (u1, v1, -DEEP - 0.1))
    table = [((-0.4, 0.7, -1.3), (1.2, 0.75, -0.2))]
    table += [((x, 0, z), (x + 0.06, 0.7, z + 0.06)) for x in (-0.35, 1.09) for z in (-1.25, -0.31)]
    table += [((-1.9, 0, -2.3), (-0.9, 0.42, -1.5)), ((-1.9, 0.42, -2.3), (-0.9, 0.8, -2.1))]
    pot = box.together([grace.pot(steps), grace.fittings(steps)])
    bowl = stone.lathe(solids.curve([(0.06, 0.0), (0.16, 0.06), (0.2, 0.14), (0.19, 0.145),
                                     (0.15, 0.07), (0.0, 0.02)], steps), 6 * steps)
    return files.write_plys(folder, {
        "walls": walls(), "frames": frames(), "panes": panes(), "window": thick,
        "furniture": box.together([solids.cuboid(*corners) for corners in table]),
        "pot": solids.moved(pot, (0.6, 0.75, -0.8), solids.turn(1, 35.0), 0.13),
        "bowl": solids.moved(bowl, (0.05, 0.75, -0.6))})
