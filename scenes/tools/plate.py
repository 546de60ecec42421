"""The asset of the plate scene: a shallow dish turned from metal."""

from . import files, stone

SMOOTH = 60.0  # bends of the profile up to this angle (degrees) are smooth


def profile(steps):
    """Returns (radius, height) from the underside, around the rim, to the inside."""
    foot = [(0.0, 0.0), (0.80, 0.0), (0.84, 0.060), (1.08, 0.205)]
    rim = stone.arc((1.42, 0.310), 0.02, -90, 90, steps)
    hollow = stone.arc((0.70, 0.30), 0.24, -35, -90, steps)
    return foot + rim + [(1.10, 0.270)] + hollow + [(0.35, 0.060), (0.0, 0.060)]


def make(folder, scale):
    """Writes the file. Returns the number of triangles."""
    steps = max(3, int(round(12 / scale)))
    mesh = stone.lathe(profile(steps), max(24, int(round(160 / scale))), SMOOTH)
    files.write_ply(folder / "plate.ply", mesh)
    return len(mesh["faces"])
