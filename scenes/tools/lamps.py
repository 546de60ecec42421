"""The assets of the lamps scene: files with many emitters in one hall, and its pillars."""

import numpy as np

from . import files

HALF = 16.0  # half the width and depth of the hall
AREA_LIGHTS = (10, 1000, 100000)
SPOTS = (1000,)
FLUX = 2400.0  # total flux of all emitters
QUADS = 4000  # squares of the emitting mesh


def places(count):
    """Returns positions over the hall (Roberts's sequence) at heights from 2 to 4, colours, and tilts."""
    i = np.arange(count)
    x = ((0.5 + i * 0.7548776662466927) % 1.0 * 2 - 1) * HALF * 0.97
    z = ((0.5 + i * 0.5698402909980532) % 1.0 * 2 - 1) * HALF * 0.97
    other = (0.5 + np.outer(i, (0.8191725133961645, 0.6710436067037893, 0.5497004779019703))) % 1.0
    position = np.stack([x, 2.0 + 2.0 * other[:, 0], z], axis=1)
    hue = 2 * np.pi * other[:, 1]
    colour = 1 + 0.6 * np.stack([np.cos(hue), np.cos(hue - 2.1), np.cos(hue + 2.1)], axis=1)
    return position, colour, 60 * (other[:, 2] - 0.5)


def area_lights(count):
    """Returns squares with a total area of a two-hundredth of the hall, each with its own tilt."""
    side = 2 * HALF * np.sqrt(1 / 200 / count)
    radiance = FLUX / (np.pi * count * side * side)
    for p, c, tilt in zip(*places(count)):
        yield (f'<shape type="rectangle"><transform name="to_world"><scale value="{side / 2:.5g}"/>'
               f'<rotate x="1" angle="{90 + tilt:.4g}"/>'
               f'<translate x="{p[0]:.5g}" y="{p[1]:.5g}" z="{p[2]:.5g}"/></transform>'
               f'<emitter type="area"><rgb name="radiance" value="{c[0] * radiance:.5g}, '
               f'{c[1] * radiance:.5g}, {c[2] * radiance:.5g}"/></emitter></shape>')


def spots(count):
    intensity = FLUX / (count * 2 * np.pi * (1 - np.cos(np.radians(35))))
    for p, c, tilt in zip(*places(count)):
        target = p + (np.sin(np.radians(tilt)), -1.0, np.cos(np.radians(3 * tilt)) - 0.5)
        yield (f'<emitter type="spot"><rgb name="intensity" value="{c[0] * intensity:.5g}, '
               f'{c[1] * intensity:.5g}, {c[2] * intensity:.5g}"/>'
               '<float name="cutoff_angle" value="45"/><float name="beam_width" value="30"/>'
               f'<transform name="to_world"><lookat origin="{p[0]:.5g}, {p[1]:.5g}, {p[2]:.5g}" '
               f'target="{target[0]:.5g}, {target[1]:.5g}, {target[2]:.5g}" up="0, 0.1, 1"/>'
               '</transform></emitter>')


def glowing_mesh(count):
    """Returns one mesh of squares that face down; each has its own texel."""
    position, colour, _ = places(count)
    rows = int(np.ceil(np.sqrt(count)))
    side = 2 * HALF * np.sqrt(1 / 200 / count)
    corners = np.array([(-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1)]) * side / 2
    i = np.arange(count)
    texel = np.stack([(i % rows + 0.5) / rows, (i // rows + 0.5) / rows], axis=1)
    mesh = {"positions": (position[:, None] + corners[None]).reshape(-1, 3),
            "normals": np.tile((0.0, -1.0, 0.0), (4 * count, 1)),
            "uv": np.repeat(texel, 4, axis=0),
            "faces": (4 * i[:, None, None] + np.array([(0, 1, 2), (0, 2, 3)])[None]).reshape(-1, 3)}
    image = np.zeros((rows, rows, 3))
    image[i // rows, i % rows] = colour * FLUX / (np.pi * count * side * side)
    return mesh, image[::-1]  # v points up


def pillars():
    """Returns the XML of cubes between floor and ceiling."""
    for x in np.arange(-12.0, 13.0, 6.0):
        for z in np.arange(-12.0, 13.0, 6.0):
            yield ('<shape type="cube"><transform name="to_world"><scale x="0.4" y="2.5" z="0.4"/>'
                   f'<rotate y="1" angle="{7 * x + 3 * z:g}"/>'
                   f'<translate x="{x:g}" y="2.5" z="{z:g}"/></transform><ref id="stone"/></shape>')


def make(folder, scale):
    """Writes the files. Returns the number of triangles of the mesh."""
    for name, count, kind in (*((f"area{n}", n, area_lights) for n in AREA_LIGHTS),
                              *((f"spot{n}", n, spots) for n in SPOTS)):
        (folder / f"{name}.xml").write_text(files.scene_xml(kind(max(2, int(count / scale)))),
                                            encoding="ascii")
    mesh, image = glowing_mesh(max(4, int(QUADS / scale)))
    files.write_ply(folder / "glow.ply", mesh)
    files.write_pfm(folder / "glow.pfm", image)
    (folder / "mesh.xml").write_text(files.scene_xml([
        '<shape type="ply"><string name="filename" value="glow.ply"/><emitter type="area">'
        '<texture type="bitmap" name="radiance"><string name="filename" value="glow.pfm"/>'
        '<string name="filter_type" value="nearest"/><boolean name="raw" value="true"/></texture>'
        '</emitter></shape>']), encoding="ascii")
    (folder / "pillars.xml").write_text(files.scene_xml(pillars()), encoding="ascii")
    return len(mesh["faces"])
