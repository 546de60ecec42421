"""Builds small scenes in Blender, and renders them with Cycles and Kinome. Runs in a Python with bpy."""
import os
import pathlib
import subprocess
import sys
import tempfile

import bpy
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build"))
sys.path.insert(0, str(ROOT / "apps/blender"))
from kinome_export.blender_scene import export  # noqa: E402
from kinome_export.report import Report  # noqa: E402


def start(width, height, max_bounces):
    """Opens an empty scene with settings for linear images without clamping."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    cycles.device = "CPU"
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    render.threads_mode, render.threads = "FIXED", int(os.environ.get("KINOME_THREADS", "2"))
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
    set_bounces(max_bounces)
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = 0.0
    cycles.use_light_tree = True
    scene.view_settings.view_transform = "Raw"
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    return scene


def set_bounces(count):
    cycles = bpy.context.scene.cycles
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = count
    cycles.transmission_bounces = cycles.transparent_max_bounces = count


def add(name, data, location=(0, 0, 0), rotation=(0, 0, 0), scale=(1, 1, 1)):
    thing = bpy.data.objects.new(name, data)
    thing.location, thing.rotation_euler, thing.scale = location, rotation, scale
    bpy.context.scene.collection.objects.link(thing)
    return thing


def look_at(thing, origin, target):
    from mathutils import Vector
    thing.location = origin
    thing.rotation_euler = (Vector(target) - Vector(origin)).to_track_quat("-Z", "Y").to_euler()


def add_camera(origin, target, lens=35.0, **settings):
    data = bpy.data.cameras.new("camera")
    data.lens = lens
    for name, value in settings.items():
        setattr(data, name, value)
    thing = add("camera", data)
    look_at(thing, origin, target)
    bpy.context.scene.camera = thing
    return data


def add_light(name, kind, energy, location=(0, 0, 0), rotation=(0, 0, 0), scale=(1, 1, 1), **settings):
    data = bpy.data.lights.new(name, kind)
    data.energy = energy
    for key, value in settings.items():
        setattr(data, key, value)
    return add(name, data, location, rotation, scale)


def add_operator(operator, name, material=None, smooth=False, **arguments):
    """Adds a primitive by one of bpy.ops.mesh's operators."""
    operator(**arguments)
    thing = bpy.context.object
    thing.name = name
    if material is not None:
        thing.data.materials.append(material)
    if smooth:
        for polygon in thing.data.polygons:
            polygon.use_smooth = True
    return thing


def principled(name, **inputs):
    """Returns a material with a Principled BSDF. Underscores in names of inputs are blanks."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    for key, value in inputs.items():
        socket = shader.inputs[key.replace("_", " ")]
        socket.default_value = (*value, 1.0) if socket.type == "RGBA" and len(value) == 3 else value
    return material


def link_new(material, node_type, input_name, output="Color", **settings):
    """Adds a node and connects it to an input of the material's Principled BSDF."""
    tree = material.node_tree
    node = tree.nodes.new(node_type)
    for name, value in settings.items():
        setattr(node, name, value)
    tree.links.new(node.outputs[output], tree.nodes["Principled BSDF"].inputs[input_name])
    return node


def set_world(color, strength=1.0):
    """Sets a world of one colour, and returns its nodes."""
    world = bpy.data.worlds.new("world")
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*color, 1.0)
    background.inputs["Strength"].default_value = strength
    bpy.context.scene.world = world
    return world.node_tree


def environment(strength=1.5, sharpness=60, rotation=None, height=128):
    """Sets a world of an image with a red, a green and a blue light on a dark ground. `height` is in pixels."""
    tree = set_world((1, 1, 1), strength)
    image = bpy.data.images.new("environment", 2 * height, height, float_buffer=True)
    v, u = (np.mgrid[0:height, 0:2 * height] + 0.5) / np.array([height, 2 * height])[:, None, None]
    pixels = np.ones((height, 2 * height, 4), np.float32)
    for channel, (cu, cv) in enumerate(((0.3, 0.7), (0.55, 0.55), (0.85, 0.35))):
        du = np.abs(u - cu)
        squared = np.minimum(du, 1 - du) ** 2 + (v - cv) ** 2
        pixels[..., channel] = 0.05 + sharpness / 15 * np.exp(-sharpness * squared)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    node = tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = image
    tree.links.new(node.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    if rotation:
        coordinates, mapping = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeMapping")
        mapping.inputs["Rotation"].default_value = rotation
        tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
        tree.links.new(mapping.outputs["Vector"], node.inputs["Vector"])


def read_image(path):
    """Returns the linear pixels of an image file, from top to bottom."""
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    channels = image.channels
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, channels)[::-1, :, :3].astype(float)


def render_cycles(samples, seed=0, denoise=False):
    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.seed, scene.cycles.use_denoising = samples, seed, denoise
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = f"{folder}/image.exr"
        with quiet():
            bpy.ops.render.render(write_still=True)
        return read_image(scene.render.filepath)


def render_kinome(xml, samples, seed=0, options=(), **defines):
    with tempfile.TemporaryDirectory() as folder:
        output = f"{folder}/image.exr"
        command = [BUILD / "bin/kinome", xml, "-o", output, "--seed", str(seed), *options, "-D", f"spp={samples}",
                       *(x for name, value in defines.items() for x in ("-D", f"{name}={value}"))]
        subprocess.run(command, check=True, capture_output=True)
        # Blender takes no color from files with layers.
        return read_layered(output) if "--denoise" in options else read_image(output)


def read_layered(path):
    """Returns the colour of a file with layers, by Debian's Python with OpenImageIO."""
    code = ("import sys, numpy; sys.path.insert(0, sys.argv[1]); from compare.images import read, colour;"
            "numpy.save(sys.argv[2] + '.npy', colour(sys.argv[2], read(sys.argv[2]).channels))")
    subprocess.run(["/usr/bin/python3", "-c", code, ROOT / "validation", path], check=True, env={})
    return np.load(f"{path}.npy")


def render_mitsuba(xml, samples, seed=0):
    """Renders with Mitsuba 3, if KINOME_MITSUBA is a Python that has it."""
    code = ("import sys, numpy, mitsuba as mi; mi.set_variant('scalar_rgb');"
            "s = mi.load_file(sys.argv[1], spp=int(sys.argv[2]));"
            "numpy.save(sys.argv[3], numpy.array(mi.render(s, seed=int(sys.argv[4])))[..., :3])")
    with tempfile.TemporaryDirectory() as folder:
        output = f"{folder}/image.npy"
        subprocess.run([os.environ["KINOME_MITSUBA"], "-c", code, xml, str(samples), output, str(seed)], check=True)
        return np.load(output).astype(float)


class quiet:
    """Hides what Blender's C++ code prints."""

    def __enter__(self):
        sys.stdout.flush()
        self._saved, null = os.dup(1), os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, 1)
        os.close(null)

    def __exit__(self, *_):
        os.dup2(self._saved, 1)
        os.close(self._saved)


def ratio_of_means(ours, theirs):
    """Returns the ratio of two lists of images' means per channel, and its standard error."""
    a, b = (np.array([image.mean(axis=(0, 1)) for image in images]) for images in (ours, theirs))
    ratio = a.mean(axis=0) / b.mean(axis=0)
    variance = sum(x.var(axis=0, ddof=1) / len(x) / x.mean(axis=0) ** 2 for x in (a, b))
    return ratio, ratio * np.sqrt(variance)
