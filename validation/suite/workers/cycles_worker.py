"""Renders a scene file with Blender's Cycles on request: cycles_worker.py THREADS. Runs in a Python with bpy.
Supports perspective, constant, rectangle, cube, diffuse and the operations of a transform. Rejects scenes
with other elements.
"""
import math
import sys
import tempfile
import time
import xml.etree.ElementTree as tree

import bpy
import numpy as np
from mathutils import Matrix, Vector
from serve import serve

THREADS = int(sys.argv[1])
CUBE = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
CUBE_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
SQUARE = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
SHAPES = {"cube": (CUBE, CUBE_FACES), "rectangle": (SQUARE, [(0, 1, 2, 3)])}


def numbers(text):
    return [float(x) for x in text.replace(",", " ").split()]


def vector(node, default=0.0):
    if "value" in node.attrib:
        found = numbers(node.get("value"))
        return Vector(found * 3 if len(found) == 1 else found)
    return Vector([float(node.get(axis, default)) for axis in "xyz"])


def look_at(node):
    """Returns the transform of a camera that looks along +z, with +x to the left."""
    origin, target, up = (Vector(numbers(node.get(k))) for k in ("origin", "target", "up"))
    ahead = (target - origin).normalized()
    left = up.cross(ahead).normalized()
    found = Matrix.Identity(4)
    for i, axis in enumerate((left, ahead.cross(left), ahead, origin)):
        found.col[i][:3] = axis
    return found


def transform(node):
    total = Matrix.Identity(4)
    for step in node if node is not None else ():
        if step.tag == "translate":
            one = Matrix.Translation(vector(step))
        elif step.tag == "scale":
            one = Matrix.Diagonal((*vector(step, 1.0), 1))
        elif step.tag == "rotate":
            one = Matrix.Rotation(math.radians(float(step.get("angle"))), 4, vector(step))
        elif step.tag == "lookat":
            one = look_at(step)
        else:
            raise ValueError(f"unsupported <{step.tag}> in a transform")
        total = one @ total
    return total


def colour(node, name):
    found = node.find(f"rgb[@name='{name}']")
    if found is None:
        raise ValueError(f'<{node.tag} type="{node.get("type")}">: missing rgb "{name}"')
    value = numbers(found.get("value"))
    return (*(value * 3 if len(value) == 1 else value), 1.0)


def material(bsdf):
    if bsdf is None or bsdf.get("type") != "diffuse":
        raise ValueError("unsupported bsdf: must be diffuse")
    made = bpy.data.materials.new("diffuse")
    made.use_nodes = True
    nodes = made.node_tree.nodes
    nodes.clear()
    shader, out = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = colour(bsdf, "reflectance")
    made.node_tree.links.new(shader.outputs[0], out.inputs[0])
    return made


def add_shape(node):
    if node.get("type") not in SHAPES:
        raise ValueError(f'unsupported shape "{node.get("type")}"')
    points, faces = SHAPES[node.get("type")]
    matrix = transform(node.find("transform"))
    mesh = bpy.data.meshes.new("mesh")
    mesh.from_pydata([matrix @ Vector(p) for p in points], [], faces)
    mesh.materials.append(material(node.find("bsdf")))
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("shape", mesh))


def add_camera(node):
    camera = bpy.data.cameras.new("camera")
    camera.sensor_fit = "HORIZONTAL"
    camera.angle_x = math.radians(float(node.find("float[@name='fov']").get("value")))
    thing = bpy.data.objects.new("camera", camera)
    # Blender's camera looks along -z, with +x to the right.
    thing.matrix_world = transform(node.find("transform")) @ Matrix.Diagonal((-1, 1, -1, 1))
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.scene.camera = thing


def add_sky(node):
    if node.get("type") != "constant":
        raise ValueError(f'unsupported emitter "{node.get("type")}"')
    world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = colour(node, "radiance")
    bpy.context.scene.world = world


ADD = {"shape": add_shape, "sensor": add_camera, "emitter": add_sky}


def settings(width, height):
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    cycles.device = "CPU"
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    render.threads_mode, render.threads = "FIXED", THREADS
    render.use_persistent_data = True  # the scene is built once, as Mitsuba's is
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
    cycles.max_bounces = 0  # direct light
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    scene.view_settings.view_transform = "Raw"
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"


def hello():
    return {"version": bpy.app.version_string}


def load(file, width, height):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    for node in tree.parse(file).getroot():
        if node.tag in ADD:
            ADD[node.tag](node)
        elif node.tag not in ("default", "include"):
            raise ValueError(f"unsupported <{node.tag}>")
    settings(width, height)
    return {}


def render(samples, seed, output):
    """Renders; returns the wall time of the whole operator, because Cycles has no clock for less."""
    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.seed = samples, seed
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = f"{folder}/picture.exr"
        start = time.perf_counter()
        bpy.ops.render.render(write_still=True)
        seconds = time.perf_counter() - start
        image = bpy.data.images.load(scene.render.filepath)
        image.colorspace_settings.name = "Non-Color"
        width, height = image.size
        pixels = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
    # Blender's first row is at the bottom.
    np.save(output, pixels.reshape(height, width, -1)[::-1, :, :3])
    return {"seconds": seconds, "samples": samples}


if __name__ == "__main__":
    serve({"hello": hello, "load": load, "render": render})
