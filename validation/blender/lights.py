"""Compares exported lights with Cycles: prints a table. Runs in a Python with bpy."""
import argparse
import io
import math
import tempfile

import bpy
import numpy as np

from common import (Report, add_camera, add_light, add_operator, environment, export, principled, quiet,
                    ratio_of_means, render_cycles, render_kinome, set_world, start)

SEEDS = 4
DOWN = (0.35, -0.2, 0.1)  # a light that is nearly above the floor


def floor(half=2.0):
    """A diffuse floor that fills the image. Its camera is above; lights between don't hide it."""
    material = bpy.data.materials.new("floor")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader, out = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (0.8, 0.6, 0.4, 1)
    tree.links.new(shader.outputs[0], out.inputs[0])
    add_operator(bpy.ops.mesh.primitive_plane_add, "floor", material, size=2 * half)
    add_operator(bpy.ops.mesh.primitive_cube_add, "block", material, size=0.6, location=(0.5, 0.3, 0.3))
    # Looks from the side, below the lights.
    add_camera((0, -2.5, 1.6), (0, 0, 0.1), lens=40)


def sky():
    tree = set_world((1, 1, 1), 0.1)
    node = tree.nodes.new("ShaderNodeTexSky")
    node.sky_type, node.sun_disc = "NISHITA", True
    node.sun_elevation, node.sun_rotation = math.radians(40), math.radians(70)
    node.sun_size = math.radians(3)
    tree.links.new(node.outputs["Color"], tree.nodes["Background"].inputs["Color"])


def emission():
    """A sphere whose material is an Emission."""
    material = principled("glow", Base_Color=(0, 0, 0), Specular_IOR_Level=0.0, Emission_Color=(1, 0.5, 0.2),
                          Emission_Strength=4.0)
    add_operator(bpy.ops.mesh.primitive_uv_sphere_add, "glow", material, radius=0.4, location=(-0.6, 0, 1.2))


HIGH = (0.2, 0.1, 2.2)
CASES = {
    "point, radius 0": lambda: add_light("a", "POINT", 100, HIGH, color=(1, 0.8, 0.5), shadow_soft_size=0),
    "point, radius 0.3, soft falloff": lambda: add_light("a", "POINT", 100, HIGH, color=(1, 0.8, 0.5),
                                                         shadow_soft_size=0.3),
    "point, radius 0.3, hard falloff": lambda: add_light("a", "POINT", 100, HIGH, shadow_soft_size=0.3,
                                                         use_soft_falloff=False),
    "point, radius 0.3, scale 2": lambda: add_light("a", "POINT", 100, HIGH, scale=(2, 2, 2), shadow_soft_size=0.3),
    "point, exposure 2": lambda: add_light("a", "POINT", 100, HIGH, exposure=2, shadow_soft_size=0),
    "spot, blend 0": lambda: add_light("a", "SPOT", 100, HIGH, DOWN, spot_size=1.0, spot_blend=0, shadow_soft_size=0),
    "spot, blend 0.15": lambda: add_light("a", "SPOT", 100, HIGH, DOWN, spot_size=1.0, spot_blend=0.15,
                                          shadow_soft_size=0),
    "spot, blend 1": lambda: add_light("a", "SPOT", 100, HIGH, DOWN, spot_size=1.0, spot_blend=1,
                                       shadow_soft_size=0),
    "sun": lambda: add_light("a", "SUN", 3, HIGH, DOWN, color=(1, 0.9, 0.7)),
    "area, square": lambda: add_light("a", "AREA", 100, HIGH, DOWN, shape="SQUARE", size=0.8),
    "area, rectangle, scaled": lambda: add_light("a", "AREA", 100, HIGH, DOWN, (1.5, 0.5, 1), shape="RECTANGLE",
                                                 size=0.8, size_y=0.3),
    "area, disk": lambda: add_light("a", "AREA", 100, HIGH, DOWN, shape="DISK", size=0.8),
    "area, ellipse": lambda: add_light("a", "AREA", 100, HIGH, DOWN, shape="ELLIPSE", size=0.8, size_y=0.3),
    "area, not normalized": lambda: add_light("a", "AREA", 100, HIGH, DOWN, shape="SQUARE", size=0.8,
                                              normalize=False),
    "emissive sphere": emission,
    "world, colour": lambda: set_world((0.3, 0.5, 0.9), 2.0),
    "world, image": environment,
    "world, image, rotated": lambda: environment(rotation=(0.3, -0.5, 1.1)),
    "world, large image, rotated": lambda: environment(rotation=(0.3, -0.5, 1.1), height=1024),
    "world, sky with sun": sky,
}


def compare(build, samples, size=64):
    """Returns the ratio of means, its standard error, and the largest deviation of a ninth of the image."""
    start(size, size, 0)
    floor()
    build()
    with tempfile.TemporaryDirectory() as folder:
        xml = f"{folder}/scene.xml"
        with quiet():
            report = export(xml, sky_width=256, report=Report(io.StringIO()))
        ours = [render_kinome(xml, samples, seed, max_depth=2) for seed in range(SEEDS)]
    theirs = [render_cycles(samples, seed) for seed in range(SEEDS)]
    blocks = [np.mean(images, axis=0)[:size // 4 * 4, :size // 4 * 4].reshape(4, size // 4, 4, size // 4, 3)
              .mean(axis=(1, 3)) for images in (ours, theirs)]
    largest = np.abs(blocks[0] - blocks[1]).max() / blocks[1].mean()
    return *ratio_of_means(ours, theirs), largest, report.lines


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("lights", nargs="*", default=list(CASES))
    parser.add_argument("--samples", type=int, default=256)
    options = parser.parse_args()
    print("| light | red | green | blue | standard error | largest difference of a sixteenth |")
    print("|---|---|---|---|---|---|")
    for name in options.lights:
        ratio, error, largest, lines = compare(CASES[name], options.samples)
        columns = [name, *(f"{r:.4f}" for r in ratio), f"{error.max():.4f}", f"{100 * largest:.1f} %"]
        print("|", " | ".join(columns), "|", *lines, flush=True)


if __name__ == "__main__":
    main()
