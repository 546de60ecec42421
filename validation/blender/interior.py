"""A living room: sun through a window, a floor lamp, wood, glass, brass, and cushions."""
import math

import bpy

import images
from common import (add, add_camera, add_light, add_operator, link_new, look_at, principled, set_world, start)

BOUNCES = 8


def _box(name, material, location, size, rotation=(0, 0, 0), bevel=0.0):
    thing = add_operator(bpy.ops.mesh.primitive_cube_add, name, material, size=1, location=location)
    thing.scale, thing.rotation_euler = size, rotation
    if bevel:
        modifier = thing.modifiers.new("bevel", "BEVEL")
        modifier.width, modifier.segments = bevel, 2
    return thing


def _room():
    plaster = principled("plaster", Base_Color=(0.78, 0.74, 0.68), Roughness=0.9)
    floor = principled("planks")
    color, roughness = images.planks()
    link_new(floor, "ShaderNodeTexImage", "Base Color", image=images.image("planks", color))
    link_new(floor, "ShaderNodeTexImage", "Roughness", image=images.image("planks roughness", roughness, is_data=True))
    add_operator(bpy.ops.mesh.primitive_plane_add, "floor", floor, size=5)
    bpy.context.object.data.uv_layers[0].uv.foreach_set("vector", [0, 0, 2, 0, 2, 2, 0, 2])
    _box("ceiling", plaster, (0, 0, 2.85), (5, 5, 0.1))
    _box("back", plaster, (0, 2.55, 1.4), (5, 0.1, 2.8))
    _box("right", plaster, (2.55, 0, 1.4), (0.1, 5, 2.8))
    _box("front", plaster, (0, -2.55, 1.4), (5, 0.1, 2.8))
    # The left wall has a window.
    for name, y, z, sy, sz in (("below", 0, 0.4, 5, 0.8), ("above", 0, 2.55, 5, 0.5), ("near", -1.7, 1.55, 1.6, 1.5),
                               ("far", 1.9, 1.55, 1.2, 1.5)):
        _box(f"wall {name}", plaster, (-2.55, y, z), (0.1, sy, sz))
    frame = principled("frame", Base_Color=(0.85, 0.85, 0.82), Roughness=0.35, Coat_Weight=0.5)
    for y in (-0.9, 0.2, 1.3):
        _box(f"bar {y}", frame, (-2.55, y, 1.55), (0.08, 0.06, 1.5))


def _furniture():
    wood = principled("walnut", Base_Color=(0.16, 0.07, 0.03), Roughness=0.35, Coat_Weight=1.0, Coat_Roughness=0.05)
    _box("table top", wood, (0.35, 0.1, 0.62), (1.5, 0.8, 0.05), bevel=0.02)
    leg = bpy.data.meshes.new("leg")
    source = add_operator(bpy.ops.mesh.primitive_cylinder_add, "leg", wood, True, radius=0.035, depth=0.6, vertices=24)
    source.location = (-0.3, -0.2, 0.3)
    bpy.data.meshes.remove(leg)
    for x, y in ((1.0, -0.2), (-0.3, 0.4), (1.0, 0.4)):
        add("leg", source.data, (x, y, 0.3))
    fabric = principled("fabric", Base_Color=(0.12, 0.25, 0.32), Roughness=1.0, Specular_IOR_Level=0.2)
    _box("sofa seat", fabric, (0.4, 1.9, 0.3), (2.4, 0.9, 0.5), bevel=0.08)
    _box("sofa back", fabric, (0.4, 2.35, 0.7), (2.4, 0.25, 0.7), bevel=0.08)
    cushion = principled("cushion", Base_Color=(0.75, 0.42, 0.10), Roughness=0.95)
    for x, turn in ((-0.35, 0.3), (1.2, -0.25)):
        thing = _box("cushion", cushion, (x, 2.05, 0.78), (0.5, 0.2, 0.5), (-0.35, 0, turn))
        modifier = thing.modifiers.new("round", "SUBSURF")
        modifier.levels, modifier.render_levels = 1, 3
    painting = principled("painting", Roughness=0.6)
    link_new(painting, "ShaderNodeTexImage", "Base Color", image=images.image("painting", images.abstract()))
    add_operator(bpy.ops.mesh.primitive_plane_add, "painting", painting, size=1, location=(0.4, 2.48, 1.75))
    bpy.context.object.rotation_euler, bpy.context.object.scale = (math.pi / 2, 0, 0), (1.3, 0.8, 1)


def _things():
    glass = principled("glass", Base_Color=(1, 1, 1), Roughness=0.0, Transmission_Weight=1.0, IOR=1.5)
    brass = principled("brass", Base_Color=(0.89, 0.68, 0.30), Metallic=1.0, Roughness=0.22)
    glaze = principled("glaze", Base_Color=(0.75, 0.78, 0.75), Roughness=0.15)
    add_operator(bpy.ops.mesh.primitive_uv_sphere_add, "glass ball", glass, True, radius=0.12,
                 location=(0.75, 0.0, 0.765), segments=64, ring_count=32)
    add_operator(bpy.ops.mesh.primitive_torus_add, "brass ring", brass, True, major_radius=0.12, minor_radius=0.035,
                 location=(0.1, -0.08, 0.68))
    head = add_operator(bpy.ops.mesh.primitive_monkey_add, "head", glaze, True, size=0.3, location=(0.36, 0.22, 0.79))
    head.rotation_euler = (-0.5, 0, 0.2)
    head.modifiers.new("smooth", "SUBSURF").render_levels = 2
    shade = principled("shade", Base_Color=(0.9, 0.85, 0.7), Roughness=1.0, Specular_IOR_Level=0.0)
    add_operator(bpy.ops.mesh.primitive_cone_add, "shade", shade, True, radius1=0.28, radius2=0.18, depth=0.35,
                 end_fill_type="NOTHING", location=(1.95, 1.6, 1.75), vertices=48)
    add_operator(bpy.ops.mesh.primitive_cylinder_add, "pole", brass, True, radius=0.015, depth=1.6,
                 location=(1.95, 1.6, 0.8))
    add_light("bulb", "POINT", 14, (1.95, 1.6, 1.75), color=(1.0, 0.72, 0.42), shadow_soft_size=0.05)


def build(width, height):
    scene = start(width, height, BOUNCES)
    _room()
    _furniture()
    _things()
    sun = add_light("sun", "SUN", 9, color=(1.0, 0.86, 0.66))
    look_at(sun, (-5, -1.6, 3.6), (0.0, 0.4, 0.2))
    add_light("window", "AREA", 110, (-2.75, 0.2, 1.55), (0, -math.pi / 2, 0), color=(0.7, 0.83, 1.0),
              shape="RECTANGLE", size=1.5, size_y=2.2)
    set_world((0.5, 0.7, 1.0), 0.3)
    add_camera((-1.55, -2.3, 1.45), (0.5, 0.9, 0.75), lens=24)
    return scene
