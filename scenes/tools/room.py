"""The assets of the room scene: walls with one small window, shelves, a table, things on them."""

from . import box, files, grace, solids, stone

WIDE, HIGH, DEEP, THICK = 2.2, 2.7, 2.6, 0.35  # x from -WIDE to WIDE, z from -DEEP to DEEP
WINDOW = (-0.9, 0.1, 1.2, 2.1)  # in the right wall: min z, max z, min y, max y


def walls():
    """Returns the shell; the right wall surrounds the window."""
    z0, z1, y0, y1 = WINDOW
    x0, x1 = WIDE, WIDE + THICK
    shell = [((-WIDE - THICK, 0, -DEEP), (-WIDE, HIGH, DEEP)),
             ((-WIDE - THICK, 0, -DEEP - THICK), (x1, HIGH, -DEEP)),
             ((-WIDE - THICK, 0, DEEP), (x1, HIGH, DEEP + THICK)),
             ((-WIDE - THICK, HIGH, -DEEP - THICK), (x1, HIGH + THICK, DEEP + THICK)),
             ((-WIDE - THICK, -THICK, -DEEP - THICK), (x1, 0, DEEP + THICK)),
             ((x0, 0, -DEEP), (x1, HIGH, z0)), ((x0, 0, z1), (x1, HIGH, DEEP)),
             ((x0, 0, z0), (x1, y0, z1)), ((x0, y1, z0), (x1, HIGH, z1))]
    return box.together([solids.cuboid(*corners) for corners in shell])


def furniture():
    """Returns a table, a shelf at the far wall, and the bars of the window."""
    z0, z1, y0, y1 = WINDOW
    parts = [((-0.7, 0.72, -0.9), (0.9, 0.78, 0.3))]
    parts += [((x, 0, z), (x + 0.07, 0.72, z + 0.07)) for x in (-0.65, 0.78)
              for z in (-0.85, 0.18)]
    parts += [((-1.7, y, -DEEP), (0.2, y + 0.04, -DEEP + 0.35)) for y in (0.5, 1.0, 1.5, 2.0)]
    parts += [((x, 0, -DEEP), (x + 0.04, 2.04, -DEEP + 0.35)) for x in (-1.74, 0.2)]
    middle, centre = (z0 + z1) / 2, (y0 + y1) / 2
    parts += [((WIDE + 0.15, y0, middle - 0.025), (WIDE + 0.2, y1, middle + 0.025)),
              ((WIDE + 0.15, centre - 0.025, z0), (WIDE + 0.2, centre + 0.025, z1))]
    return box.together([solids.cuboid(*corners) for corners in parts])


def books():
    """Returns books in rows on the shelves, with gaps."""
    parts = []
    for shelf, y in enumerate((0.54, 1.04, 1.54)):
        x = -1.62
        for i in range(30):
            k = 31 * shelf + i
            thick, tall = 0.025 + 0.035 * ((k * 0.618034) % 1), 0.24 + 0.14 * ((k * 0.754878) % 1)
            if x + thick > 0.1:
                break
            if i % 9 != 8:
                parts.append(((x, y, -DEEP + 0.02), (x + thick, y + tall, -DEEP + 0.26)))
            x += thick + (0.003 if i % 9 != 8 else 0.12)
    return box.together([solids.cuboid(*corners) for corners in parts])


def make(folder, scale):
    """Writes the files. Returns the number of triangles."""
    steps = max(4, int(round(14 / scale)))
    pot = box.together([grace.pot(steps), grace.fittings(steps)])
    bowl = stone.lathe(solids.curve([(0.06, 0.0), (0.16, 0.06), (0.2, 0.14), (0.19, 0.145),
                                     (0.15, 0.07), (0.0, 0.02)], steps), 6 * steps)
    vessels = [solids.moved(pot, (0.35, 0.78, -0.35), solids.turn(1, 35.0), 0.13),
               solids.moved(bowl, (-0.3, 0.78, -0.2))]
    return files.write_plys(folder, {"walls": walls(), "furniture": furniture(), "books": books(),
                                     "vessels": box.together(vessels)})
