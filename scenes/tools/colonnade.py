"""The assets of the colonnade scene: a hall of four rows of columns under a coffered ceiling."""

from . import box, files, solids, stone

ROWS = (-4.2, -1.4, 1.4, 4.2)  # x of the rows
PLACES = [2.4 * i for i in range(9)]  # z along a row, backwards
HEIGHT = 4.0


def column(segments):
    """Returns a column: base, shaft with entasis, and capital."""
    profile = [(0.50, 0.0), (0.50, 0.12)]
    profile += stone.arc((0.42, 0.19), 0.07, -90, 90, 7)
    profile += stone.arc((0.43, 0.33), 0.06, 270, 180, 5)
    profile += solids.curve([(0.36, 0.36), (0.37, 1.4), (0.345, 2.5), (0.31, 3.5)], 4)
    profile += stone.arc((0.33, 3.55), 0.04, -90, 90, 5)
    profile += stone.arc((0.47, 3.62), 0.14, 180, 90, 6)
    profile += [(0.49, 3.78), (0.49, HEIGHT)]
    return stone.lathe(profile, segments)


def ceiling():
    """Returns the beams along and across the rows, and the slab above."""
    back = PLACES[-1] + 1.0
    parts = [solids.cuboid((x - 0.35, HEIGHT, -1.0), (x + 0.35, HEIGHT + 0.5, back)) for x in ROWS]
    parts += [solids.cuboid((-5.0, HEIGHT, z - 0.3), (5.0, HEIGHT + 0.45, z + 0.3))
              for z in PLACES]
    return box.together(parts + [solids.cuboid((-5.4, HEIGHT + 0.45, -1.4),
                                               (5.4, HEIGHT + 1.1, back + 0.4))])


def make(folder, scale):
    """Writes the files. Returns the number of triangles."""
    shaft = column(max(12, int(round(44 / scale))))
    columns = [solids.moved(shaft, (x, 0.0, z)) for x in ROWS for z in PLACES]
    # Walls at the far end and along one side: light comes only from the other two sides.
    walls = [solids.cuboid((-5.4, 0.0, PLACES[-1] + 0.8), (5.4, HEIGHT + 0.5, PLACES[-1] + 1.4)),
             solids.cuboid((-5.6, 0.0, -1.0), (-5.0, HEIGHT + 0.5, PLACES[-1] + 1.4))]
    return files.write_plys(folder, {"columns": box.together(columns), "ceiling": ceiling(),
                                     "walls": box.together(walls)})
