"""The assets of the kitchen scene: walls and furniture, four dishes that are instanced, and
files of the instances and of a thousand small lamps of five kinds."""

import numpy as np

from . import box, files, solids, stone

WIDE, HIGH, BACK, FRONT, THICK = 2.4, 2.9, -2.0, 2.6, 0.2  # x to both sides, z of back and front
COUNTER, DEPTH = 0.9, 0.6  # height, and depth from the back wall
SHELVES = (1.35, 1.7, 2.05)  # heights; as wide as the counter, 0.3 deep
TABLE = ((-1.0, 0.72, 0.1), (0.9, 0.76, 0.95))
LAMPS = 1000
FLUX = 200.0  # total flux of all emitters
GOLDEN = 0.618033988749895


def walls():
    x0, x1, low, high = -WIDE - THICK, WIDE + THICK, -THICK, HIGH + THICK
    shell = [((x0, low, BACK - THICK), (-WIDE, high, FRONT)), ((WIDE, low, BACK), (x1, high, FRONT)),
             ((-WIDE, low, BACK - THICK), (x1, high, BACK)),
             ((x0, low, FRONT), (x1, high, FRONT + THICK)),
             ((-WIDE, HIGH, BACK), (WIDE, high, FRONT)), ((-WIDE, low, BACK), (WIDE, 0, FRONT))]
    return box.together([solids.cuboid(*corners) for corners in shell])


def furniture():
    """Returns counter, shelves and table."""
    parts = [((-WIDE, 0.1, BACK), (WIDE, COUNTER - 0.04, BACK + DEPTH - 0.04)),
             ((-WIDE, COUNTER - 0.04, BACK), (WIDE, COUNTER, BACK + DEPTH)), TABLE]
    parts += [((-WIDE, y - 0.03, BACK), (WIDE, y, BACK + 0.3)) for y in SHELVES]
    (x0, high, z0), (x1, _, z1) = TABLE
    parts += [((x, 0, z), (x + 0.06, high, z + 0.06)) for x in (x0 + 0.03, x1 - 0.09)
              for z in (z0 + 0.03, z1 - 0.09)]
    return box.together([solids.cuboid(*corners) for corners in parts])


def dishes(steps):
    """Returns meshes by name; each stands on y = 0."""
    def turned(points):
        return stone.lathe(points, 4 * steps)

    cup = turned([(0, 0), (0.03, 0), *solids.curve([(0.034, 0.01), (0.041, 0.05), (0.042, 0.09)],
                                                   steps // 2), (0.039, 0.09), (0.036, 0.03),
                  (0.028, 0.007), (0, 0.006)])
    handle = solids.moved(solids.torus(0.022, 0.005, steps), (0.06, 0.05, 0),
                          solids.turn(0, 90.0))
    plate = turned([(0, 0), (0.07, 0), *solids.curve([(0.08, 0.004), (0.11, 0.014), (0.13, 0.02)],
                                                     steps // 2), (0.13, 0.023), (0.08, 0.008),
                    (0, 0.007)])
    bowl = turned([(0, 0), (0.045, 0), *solids.curve([(0.06, 0.01), (0.095, 0.045), (0.11, 0.09)],
                                                     steps), (0.106, 0.09), (0.09, 0.046),
                   (0.055, 0.014), (0, 0.012)])
    pan = turned([(0, 0), (0.1, 0), (0.115, 0.008), (0.125, 0.055), (0.121, 0.055), (0.111, 0.012),
                  (0.098, 0.005), (0, 0.005)])
    return {"cup": box.together([cup, handle]), "plate": plate, "bowl": bowl, "pan": pan,
            "grip": solids.cuboid((0.12, 0.038, -0.012), (0.29, 0.052, 0.012))}


def places():
    """Returns (name, x, y, z, angle) of every dish; plates and bowls are stacked."""
    for shelf, y in enumerate(SHELVES):
        for i in range(15):
            k = 15 * shelf + i
            name = ("cup", "plate", "bowl", "cup", "pan")[int(5 * ((k + 1) * GOLDEN % 1))]
            x = -WIDE + 0.2 + i * (2 * WIDE - 0.4) / 14
            count = {"plate": 6, "bowl": 3}.get(name, 1)
            for j in range(count):
                yield (name, x, y + j * {"plate": 0.012, "bowl": 0.03}.get(name, 0), BACK + 0.15,
                       360 * (GOLDEN * (7 * k + j) % 1) if name != "pan" else -90 + 40 * (k % 2))
    for i in range(7):
        yield ("pan" if i % 3 == 1 else "bowl", -1.9 + 0.62 * i, COUNTER, BACK + 0.33 + 0.1 * (i % 2),
               -60 - 25 * i)
    for i, (x, z) in enumerate(((-0.75, 0.3), (-0.25, 0.7), (0.25, 0.3), (0.65, 0.7))):
        yield "plate", x, TABLE[1][1], z, 0
        yield ("cup", "bowl")[i % 2], x, TABLE[1][1] + 0.007, z, 80 * i
        yield "cup", x + 0.2, TABLE[1][1], z - 0.1, 50 + 100 * i


def instances():
    for name, x, y, z, angle in places():
        yield (f'<shape type="instance"><ref id="{name}"/><transform name="to_world">'
               f'<rotate y="1" angle="{angle:.4g}"/>'
               f'<translate x="{x:.5g}" y="{y:.5g}" z="{z:.5g}"/></transform></shape>')


def lamps(count):
    """Returns strings of emitters under the ceiling: rectangles, spheres, point lights and spot lights
    that face down, all of the same flux."""
    i = np.arange(count)
    x = ((0.5 + i * 0.7548776662466927) % 1.0 * 2 - 1) * (WIDE - 0.3)
    z = BACK + 0.45 + (0.5 + i * 0.5698402909980532) % 1.0 * (FRONT - BACK - 0.75)
    y = HIGH - 0.25 - 0.2 * ((0.5 + i * 0.8191725133961645) % 1.0)
    hue = 2 * np.pi * ((0.5 + i * GOLDEN) % 1.0)
    colour = np.array([1.0, 0.8, 0.55]) * (
        1 + 0.5 * np.stack([np.cos(hue), np.cos(hue - 2.1), np.cos(hue + 2.1)], axis=1))
    flux = FLUX / count
    for k in range(count):
        at = f'x="{x[k]:.5g}" y="{y[k]:.5g}" z="{z[k]:.5g}"'
        kind = k % 10
        if kind < 4:  # a square of 4 cm, which emits to one side
            yield (f'<shape type="rectangle"><transform name="to_world"><scale value="0.02"/>'
                   f'<rotate x="1" angle="{90 + 50 * ((k * GOLDEN) % 1 - 0.5):.4g}"/>'
                   f'<translate {at}/></transform>'
                   f'{area(colour[k] * flux / (np.pi * 0.04 ** 2))}</shape>')
        elif kind < 7:  # a ball of 2 cm
            yield (f'<shape type="sphere"><point name="center" {at}/><float name="radius" '
                   f'value="0.01"/>{area(colour[k] * flux / (np.pi * 4 * np.pi * 0.01 ** 2))}'
                   '</shape>')
        elif kind < 9:
            yield (f'<emitter type="point"><point name="position" {at}/>'
                   f'{rgb("intensity", colour[k] * flux / (4 * np.pi))}</emitter>')
        else:
            yield (f'<emitter type="spot">{rgb("intensity", colour[k] * flux / 1.5)}'
                   '<float name="cutoff_angle" value="50"/><float name="beam_width" value="30"/>'
                   f'<transform name="to_world"><lookat origin="{x[k]:.5g}, {y[k]:.5g}, {z[k]:.5g}" '
                   f'target="{x[k] + 0.3:.5g}, 0, {z[k] - 0.2:.5g}" up="0, 0, 1"/></transform>'
                   '</emitter>')


def rgb(name, value):
    return f'<rgb name="{name}" value="{value[0]:.5g}, {value[1]:.5g}, {value[2]:.5g}"/>'


def area(radiance):
    return f'<emitter type="area">{rgb("radiance", radiance)}</emitter>'


def make(folder, scale):
    """Writes the files. Returns the number of triangles, with each dish counted once."""
    for name, elements in (("instances", instances()),
                           ("lamps", lamps(max(10, int(LAMPS / scale))))):
        (folder / f"{name}.xml").write_text(files.scene_xml(elements), encoding="ascii")
    return files.write_plys(folder, {"walls": walls(), "furniture": furniture(),
                                     **dishes(max(4, int(round(10 / scale))))})
