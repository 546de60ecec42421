"""The asset of the lanterns scene: a file with a hundred small spherical lamps."""

from . import files, lamps

COUNT = 100
RADIUS = 0.06
POWER = 60.0  # total power of all lamps


def elements(count):
    """Returns the lamps as XML, over a hall of 6 x 6 at heights from 0.3 to 2.7."""
    radiance = POWER / count / (4 * 3.141592653589793 ** 2 * RADIUS ** 2)
    position, colour, _ = lamps.places(count)
    for p, c in zip(position * (3 / lamps.HALF, 1, 3 / lamps.HALF), colour):
        yield (f'<shape type="sphere"><point name="center" x="{p[0]:.5g}" y="{1.2 * p[1] - 2.1:.5g}" '
               f'z="{p[2]:.5g}"/><float name="radius" value="{RADIUS}"/><emitter type="area"><rgb '
               f'name="radiance" value="{c[0] * radiance:.5g}, {c[1] * radiance:.5g}, '
               f'{c[2] * radiance:.5g}"/></emitter></shape>')


def make(folder, scale):
    """Writes the file. Returns the number of triangles, which is 0."""
    count = max(10, int(round(COUNT / scale)))
    (folder / "lamps.xml").write_text(files.scene_xml(elements(count)), encoding="ascii")
    return 0
