"""The assets of the milk scene: a glass of milk. Its three surfaces separate glass from air, milk from
glass, and milk from air. They share the vertices of the circle where they meet."""

from . import files, solids, stone

LEVEL = 0.78  # height of the milk's surface


def outside():
    """Returns the profile (radius, height) of the glass's outside and of its rim."""
    return [(0.0, 0.0), (0.29, 0.0), (0.305, 0.012), (0.31, 0.03), (0.36, 0.95)]


def inside(steps):
    """Returns the profile of the cavity from the axis at the bottom to the rim."""
    floor = solids.curve([(0.0, 0.07), (0.18, 0.072), (0.25, 0.085), (0.28, 0.12)], steps)
    return floor + [(0.28 + 0.055 * (y - 0.12) / 0.83, y) for y in (0.3, 0.5, LEVEL, 0.95)]


def make(folder, scale):
    """Writes the files. Returns the number of triangles."""
    steps = max(4, int(round(16 / scale)))
    segments = 6 * steps
    cavity = inside(steps)
    level = next(i for i, (_, y) in enumerate(cavity) if y == LEVEL)
    rim = stone.arc((0.3475, 0.95), 0.0125, 0, 180, steps)
    glass = outside()[:-1] + rim + cavity[:level - 1:-1]
    return files.write_plys(folder, {
        "glass": stone.lathe(glass, segments),  # outside, rim, and inside above the milk
        "wall": stone.lathe(cavity[:level + 1], segments),
        "surface": stone.lathe([cavity[level], (0.0, LEVEL)], segments)})
