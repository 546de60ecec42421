"""The assets of the vases scene: four vessels turned from metal."""

from . import files, solids, stone

# (radius, height) from the foot around the lip to the inside.
VESSELS = {
    "urn": [(0.30, 0.0), (0.33, 0.04), (0.14, 0.16), (0.16, 0.24), (0.52, 0.70), (0.58, 1.05),
            (0.36, 1.42), (0.30, 1.56), (0.44, 1.72), (0.42, 1.735), (0.27, 1.56), (0.33, 1.40),
            (0.52, 1.05), (0.0, 0.40)],
    "bottle": [(0.30, 0.0), (0.42, 0.10), (0.46, 0.45), (0.30, 0.95), (0.12, 1.30), (0.10, 1.85),
               (0.16, 2.0), (0.145, 2.01), (0.07, 1.85), (0.05, 1.3)],
    "bowl": [(0.22, 0.0), (0.26, 0.05), (0.60, 0.22), (0.82, 0.52), (0.80, 0.535), (0.57, 0.26),
             (0.25, 0.10), (0.0, 0.07)],
    "globe": [(0.20, 0.0), (0.42, 0.14), (0.55, 0.48), (0.42, 0.84), (0.22, 0.96), (0.20, 1.06),
              (0.27, 1.10), (0.25, 1.115), (0.17, 1.05), (0.15, 0.95)]}


def make(folder, scale):
    """Writes the files. Returns the number of triangles."""
    steps = max(2, int(round(8 / scale)))
    return files.write_plys(folder, {
        name: stone.lathe(solids.curve(points, steps), 16 * steps, 60.0)
        for name, points in VESSELS.items()})
