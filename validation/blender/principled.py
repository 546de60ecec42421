"""Compares the exported Principled BSDF with Cycles on a grid of spheres: prints a table, and writes
principled.jpg beside this file. Runs in a Python with bpy.

    principled.py [--samples COUNT] [SWEEP...]
"""
import argparse
import io
import pathlib
import tempfile

import bpy
import numpy as np

from common import Report, add, add_camera, add_operator, environment, export, principled, quiet, render_cycles, \
    render_kinome, set_world, start
from pictures import save_jpeg

HERE = pathlib.Path(__file__).resolve().parent
CELL = 40  # pixels a sphere
SPACING = 3.0
RED = (0.8, 0.25, 0.1)
SWEEPS = {
    "roughness": [dict(Roughness=x) for x in (0.05, 0.25, 0.5, 0.75, 1.0)],
    "metal, roughness": [dict(Metallic=1.0, Roughness=x) for x in (0.05, 0.25, 0.5, 0.75, 1.0)],
    "metallic": [dict(Metallic=x, Roughness=0.3) for x in (0.0, 0.25, 0.5, 0.75, 1.0)],
    "specular level": [dict(Specular_IOR_Level=x, Roughness=0.3) for x in (0.0, 0.25, 0.5, 0.75, 1.0)],
    "IOR": [dict(IOR=x, Roughness=0.3) for x in (1.1, 1.3, 1.5, 1.8, 2.4)],
    "glass, roughness": [dict(Transmission_Weight=1.0, Base_Color=(0.8, 0.9, 1.0), Roughness=x)
                         for x in (0.0, 0.1, 0.3, 0.6, 1.0)],
    "transmission": [dict(Transmission_Weight=x, Base_Color=(0.8, 0.9, 1.0), Roughness=0.2)
                     for x in (0.0, 0.25, 0.5, 0.75, 1.0)],
    "coat": [dict(Coat_Weight=x, Roughness=0.6) for x in (0.0, 0.25, 0.5, 0.75, 1.0)],
    "coat, roughness": [dict(Coat_Weight=1.0, Coat_Roughness=x, Roughness=0.6) for x in (0.0, 0.1, 0.2, 0.4, 0.8)],
    "anisotropic": [dict(Metallic=1.0, Anisotropic=x, Roughness=0.4) for x in (0.0, 0.25, 0.5, 0.75, 1.0)],
    "sheen": [dict(Sheen_Weight=x, Roughness=0.8, Base_Color=(0.1, 0.1, 0.2)) for x in (0.0, 0.25, 0.5, 0.75, 1.0)],
}


def build(sweeps, furnace):
    """Spheres on a grid, a row for each sweep, in a white furnace or under three soft lights. All spheres have
    the same light and, by an orthographic camera, the same view."""
    columns = max(len(SWEEPS[name]) for name in sweeps)
    start(columns * CELL, len(sweeps) * CELL, 16)
    if furnace:
        set_world((1, 1, 1), 1.0)
    else:
        environment(1.0, sharpness=400)
    ball = add_operator(bpy.ops.mesh.primitive_uv_sphere_add, "ball", None, True, radius=1, segments=96, ring_count=48)
    data = ball.data
    bpy.data.objects.remove(ball)
    for row, name in enumerate(sweeps):
        for column, inputs in enumerate(SWEEPS[name]):
            thing = add("ball", data.copy(), (SPACING * (column + 0.5), 0, -SPACING * (row + 0.5)))
            thing.data.materials.append(principled(f"{name} {column}", **{"Base_Color": RED, **inputs}))
    width, height = SPACING * columns, SPACING * len(sweeps)
    camera = add_camera((width / 2, -20, -height / 2), (width / 2, 0, -height / 2))
    camera.type, camera.ortho_scale = "ORTHO", max(width, height)


def render_both(sweeps, furnace, samples):
    """Returns the cells of Kinome's image and of Cycles': by row and column."""
    build(sweeps, furnace)
    with tempfile.TemporaryDirectory() as folder:
        xml = f"{folder}/scene.xml"
        with quiet():
            export(xml, report=Report(io.StringIO()))
        images = render_kinome(xml, samples), render_cycles(samples)
    return [image.reshape(len(sweeps), CELL, -1, CELL, 3).swapaxes(1, 2) for image in images]


def sphere_mask():
    y, x = (np.mgrid[0:CELL, 0:CELL] + 0.5) / CELL - 0.5
    return np.hypot(x, y) < 0.97 / SPACING


def ratios(ours, theirs):
    """Returns the ratio of means per channel, and the root mean square of the differences of squares of four
    pixels, relative to the mean."""
    mask = sphere_mask()

    def blocks(image):
        return image.reshape(CELL // 4, 4, CELL // 4, 4, -1).mean(axis=(1, 3))
    inside = blocks(mask.astype(float))[..., 0] == 1
    difference = (blocks(ours) - blocks(theirs))[inside]
    return ours[mask].mean(axis=0) / theirs[mask].mean(axis=0), np.sqrt((difference**2).mean()) / theirs[mask].mean()


def text_of(inputs):
    return ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in inputs.items() if name != "Base_Color")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("sweeps", nargs="*", default=list(SWEEPS))
    parser.add_argument("--samples", type=int, default=128)
    options = parser.parse_args()
    in_furnace = render_both(options.sweeps, True, options.samples)
    in_lights = render_both(options.sweeps, False, options.samples)
    print("| Principled BSDF | white sky: red, green, blue | lights: red, green, blue | difference |\n|---|---|---|---|")
    for row, name in enumerate(options.sweeps):
        for column, inputs in enumerate(SWEEPS[name]):
            white, _ = ratios(*(cells[row, column] for cells in in_furnace))
            lit, difference = ratios(*(cells[row, column] for cells in in_lights))
            print(f"| {text_of(inputs)} | {' '.join(f'{x:.3f}' for x in white)} | "
                  f"{' '.join(f'{x:.3f}' for x in lit)} | {100 * difference:.1f} % |")
    # Cycles is on the left, Kinome on the right.
    ours, theirs = (cells.swapaxes(1, 2).reshape(len(options.sweeps) * CELL, -1, 3) for cells in in_lights)
    save_jpeg(HERE / "principled.jpg", np.concatenate([theirs, np.ones((len(ours), 8, 3)), ours], 1))


if __name__ == "__main__":
    main()
