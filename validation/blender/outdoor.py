"""A garden under a clear sky: a brick house, instanced trees, painted stones."""
import math

import bpy
import numpy as np

import images
from common import add, add_camera, add_light, add_operator, link_new, look_at, principled, set_world, start

BOUNCES = 6


def _tree():
    """Returns a collection with a tree, which isn't in the scene itself."""
    collection = bpy.data.collections.new("tree")
    bark = principled("bark", Base_Color=(0.12, 0.07, 0.04), Roughness=0.9)
    leaves = principled("leaves", Base_Color=(0.06, 0.16, 0.03), Roughness=0.6)
    trunk = add_operator(bpy.ops.mesh.primitive_cone_add, "trunk", bark, True, radius1=0.16, radius2=0.06, depth=1.8,
                         location=(0, 0, 0.9))
    rng = np.random.default_rng(1)
    points, faces = [], []
    for _ in range(2500):  # leaves in a ball
        center = rng.normal(size=3)
        center *= 0.95 * rng.random() ** (1 / 3) / np.linalg.norm(center)
        a, b = np.linalg.qr(rng.normal(size=(3, 2)))[0].T * 0.07
        center += (0, 0, 2.3)
        faces.append(range(len(points), len(points) + 4))
        points += [center - a, center - 0.5 * b, center + a, center + 0.5 * b]
    mesh = bpy.data.meshes.new("leaves")
    mesh.from_pydata(points, [], [tuple(f) for f in faces])
    mesh.materials.append(leaves)
    crown = add("crown", mesh)
    for thing in (trunk, crown):
        bpy.context.scene.collection.objects.unlink(thing)
        collection.objects.link(thing)
    return collection


def _house():
    bricks = principled("bricks", Roughness=0.85)
    color, height = images.bricks()
    link_new(bricks, "ShaderNodeTexImage", "Base Color", image=images.image("bricks", color))
    tree = bricks.node_tree
    normal_map, texture = tree.nodes.new("ShaderNodeNormalMap"), tree.nodes.new("ShaderNodeTexImage")
    texture.image = images.image("brick normals", images.normals(height, 0.8), is_data=True)
    tree.links.new(texture.outputs["Color"], normal_map.inputs["Color"])
    tree.links.new(normal_map.outputs["Normal"], tree.nodes["Principled BSDF"].inputs["Normal"])
    walls = add_operator(bpy.ops.mesh.primitive_cube_add, "walls", bricks, size=1, location=(1.6, 3.5, 1.2))
    walls.scale = (4, 3, 2.4)
    layer = walls.data.uv_layers[0].uv
    for polygon in walls.data.polygons:  # two repetitions across every wall
        for corner, uv in zip(polygon.loop_indices, ((0, 0), (2, 0), (2, 1.2), (0, 1.2))):
            layer[corner].vector = uv
    roof = principled("roof", Base_Color=(0.25, 0.09, 0.06), Roughness=0.7)
    mesh = bpy.data.meshes.new("roof")
    mesh.from_pydata([(-2.2, -1.8, 0), (2.2, -1.8, 0), (2.2, 1.8, 0), (-2.2, 1.8, 0), (-2.2, 0, 1.2), (2.2, 0, 1.2)],
                     [], [(0, 1, 5, 4), (2, 3, 4, 5), (0, 4, 3), (1, 2, 5), (3, 2, 1, 0)])
    mesh.materials.append(roof)
    add("roof", mesh, (1.6, 3.5, 2.4))
    pane = principled("pane", Base_Color=(0.02, 0.03, 0.04), Roughness=0.02, IOR=1.5)
    frame = principled("window frame", Base_Color=(0.8, 0.8, 0.78), Roughness=0.4)
    for x in (0.5, 2.7):
        for name, material, y, size in (("frame", frame, 1.98, (0.95, 0.08, 1.15)),
                                        ("pane", pane, 1.93, (0.8, 0.05, 1.0))):
            thing = add_operator(bpy.ops.mesh.primitive_cube_add, name, material, size=1, location=(x, y, 1.3))
            thing.scale = size


def _stones():
    """Stones with vertex colours."""
    material = principled("painted stone", Roughness=0.5)
    link_new(material, "ShaderNodeVertexColor", "Base Color", layer_name="paint")
    for i, (x, y, size) in enumerate(((-1.9, 0.2, 0.35), (-1.2, -0.35, 0.22), (0.0, -0.1, 0.28))):
        stone = add_operator(bpy.ops.mesh.primitive_ico_sphere_add, "stone", material, True, subdivisions=4,
                             radius=size, location=(x, y, 0.6 * size))
        stone.scale = (1.2, 1, 0.7)
        attribute = stone.data.color_attributes.new("paint", "FLOAT_COLOR", "POINT")
        for vertex, value in zip(stone.data.vertices, attribute.data):
            t = 0.5 + 0.5 * math.sin(10 * vertex.co.z / size + i)
            value.color = (0.1 + 0.7 * t, 0.25, 0.7 - 0.6 * t, 1)


def build(width, height):
    scene = start(width, height, BOUNCES)
    grass = principled("grass", Base_Color=(0.10, 0.17, 0.05), Roughness=1.0)
    add_operator(bpy.ops.mesh.primitive_plane_add, "ground", grass, size=60)
    path = principled("slabs", Base_Color=(0.45, 0.43, 0.40), Roughness=0.7)
    slab = None
    for i in range(7):
        slab = add("slab", slab.data) if slab else add_operator(bpy.ops.mesh.primitive_cube_add, "slab", path, size=1)
        slab.location, slab.scale = (-0.6 + 0.25 * i, -2.2 + 0.6 * i, 0.02), (0.55, 0.45, 0.06)
        slab.rotation_euler = (0, 0, 0.2 * math.sin(3 * i))
    _house()
    _stones()
    tree = _tree()
    for x, y, size in ((-3.2, 2.6, 1.1), (-4.6, 4.5, 1.4), (-1.9, 5.2, 1.2), (4.6, 1.2, 1.0), (-6, 2.0, 1.0)):
        thing = add("tree", None, (x, y, 0), (0, 0, x), (size, size, size))
        thing.instance_type, thing.instance_collection = "COLLECTION", tree
    bronze = principled("bronze", Base_Color=(0.55, 0.34, 0.18), Metallic=1.0, Roughness=0.35)
    statue = add_operator(bpy.ops.mesh.primitive_monkey_add, "statue", bronze, True, size=0.9,
                          location=(-0.8, 1.0, 0.95))
    statue.modifiers.new("smooth", "SUBSURF").render_levels = 2
    plinth = add_operator(bpy.ops.mesh.primitive_cube_add, "plinth", path, size=1, location=(-0.8, 1.05, 0.3))
    plinth.scale = (0.7, 0.7, 0.6)
    sky = set_world((1, 1, 1), 0.12)
    node = sky.nodes.new("ShaderNodeTexSky")
    node.sky_type, node.sun_disc = "NISHITA", False
    node.sun_elevation, node.sun_rotation = math.radians(38), math.radians(215)
    sky.links.new(node.outputs["Color"], sky.nodes["Background"].inputs["Color"])
    sun = add_light("sun", "SUN", 4.5, color=(1, 0.93, 0.82))
    look_at(sun, (-4, -5.5, 5.2), (0, 0, 0))
    add_camera((-1.5, -6.0, 1.6), (-0.2, 1.2, 1.15), lens=32)
    return scene
