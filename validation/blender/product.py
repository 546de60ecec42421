"""Product photography: a studio with area lights and a spot, seen with a shallow depth of field."""
import bpy

from common import add, add_camera, add_light, add_operator, link_new, look_at, principled, set_world, start

BOUNCES = 12


def _backdrop():
    """A floor that bends up into a wall."""
    profile = [(-6, 0), (2, 0), (2.6, 0.12), (3, 0.5), (3.1, 1.1), (3.1, 6)]
    mesh = bpy.data.meshes.new("backdrop")
    points = [(x, y, z) for x in (-6, 6) for y, z in profile]
    count = len(profile)
    mesh.from_pydata(points, [], [(i, i + count, i + count + 1, i + 1) for i in range(count - 1)])
    mesh.materials.append(principled("paper", Base_Color=(0.55, 0.58, 0.62), Roughness=0.8))
    for polygon in mesh.polygons:
        polygon.use_smooth = True
    thing = add("backdrop", mesh)
    thing.modifiers.new("smooth", "SUBSURF").render_levels = 2


def _bottle(location):
    """A lathed bottle: a profile that a Screw modifier turns around z."""
    profile = [(0.0, 0.02), (0.3, 0.0), (0.33, 0.04), (0.33, 0.8), (0.28, 0.95), (0.11, 1.1), (0.1, 1.35), (0.12, 1.37),
               (0.12, 1.42), (0.0, 1.42)]
    mesh = bpy.data.meshes.new("bottle")
    mesh.from_pydata([(x, 0, z) for x, z in profile], [(i, i + 1) for i in range(len(profile) - 1)], [])
    mesh.materials.append(principled("green glass", Base_Color=(0.55, 0.85, 0.6), Roughness=0.0,
                                     Transmission_Weight=1.0, IOR=1.5))
    thing = add("bottle", mesh, location)
    screw = thing.modifiers.new("lathe", "SCREW")
    screw.steps = screw.render_steps = 64
    screw.use_merge_vertices = screw.use_smooth_shade = True
    screw.use_normal_calculate = True
    return thing


def build(width, height):
    scene = start(width, height, BOUNCES)
    _backdrop()
    _bottle((-0.75, 0.55, 0))
    lacquer = principled("lacquer", Base_Color=(0.5, 0.02, 0.03), Roughness=0.45, Coat_Weight=1.0, Coat_Roughness=0.03)
    head = add_operator(bpy.ops.mesh.primitive_monkey_add, "head", lacquer, True, size=1.0, location=(0.2, 0.3, 0.52))
    head.rotation_euler = (-0.62, 0, 0.15)
    subdivision = head.modifiers.new("smooth", "SUBSURF")
    subdivision.levels, subdivision.render_levels = 1, 3
    gold = principled("gold", Base_Color=(1.0, 0.77, 0.34), Metallic=1.0, Roughness=0.18)
    brushed = principled("brushed steel", Base_Color=(0.6, 0.6, 0.62), Metallic=1.0, Roughness=0.35, Anisotropic=0.6)
    add_operator(bpy.ops.mesh.primitive_torus_add, "ring", gold, True, major_radius=0.2, minor_radius=0.06,
                 location=(-0.25, -0.45, 0.06), major_segments=64, minor_segments=24)
    add_operator(bpy.ops.mesh.primitive_cylinder_add, "tin", brushed, True, radius=0.25, depth=0.5,
                 location=(0.95, 0.2, 0.25), vertices=64)
    bpy.context.object.modifiers.new("edges", "EDGE_SPLIT")
    frosted = principled("frosted", Base_Color=(0.95, 0.97, 1.0), Roughness=0.3, Transmission_Weight=1.0, IOR=1.45)
    add_operator(bpy.ops.mesh.primitive_uv_sphere_add, "ball", frosted, True, radius=0.2, location=(0.55, -0.5, 0.2),
                 segments=64, ring_count=32)
    checks = principled("checks", Roughness=0.3)
    checker = link_new(checks, "ShaderNodeTexChecker", "Base Color")
    checker.inputs["Color1"].default_value = (0.85, 0.85, 0.8, 1)
    checker.inputs["Color2"].default_value = (0.05, 0.1, 0.25, 1)
    checker.inputs["Scale"].default_value = 8
    tree = checks.node_tree
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["UV"], checker.inputs["Vector"])
    cube = add_operator(bpy.ops.mesh.primitive_cube_add, "box", checks, size=0.36, location=(-0.75, -0.3, 0.18))
    cube.rotation_euler = (0, 0, 0.5)
    pill = None
    for x in range(5):  # pills share a mesh
        pill = add("pill", pill.data) if pill else \
            add_operator(bpy.ops.mesh.primitive_uv_sphere_add, "pill", gold, True, radius=0.05)
        pill.location, pill.scale = (-0.05 + 0.14 * x, -0.75 - 0.03 * (x % 2), 0.05), (1, 1, 0.9)
    _lights()
    camera = add_camera((0.4, -4.2, 1.35), (0.03, 0.1, 0.45), lens=60)
    camera.dof.use_dof, camera.dof.focus_object, camera.dof.aperture_fstop = True, head, 1.2
    return scene


def _lights():
    key = add_light("key", "AREA", 260, color=(1, 0.95, 0.88), shape="RECTANGLE", size=1.6, size_y=1.0)
    look_at(key, (-2.6, -1.6, 2.8), (0, 0, 0.4))
    fill = add_light("fill", "AREA", 90, color=(0.75, 0.85, 1), shape="SQUARE", size=2.0)
    look_at(fill, (3.2, -1.2, 1.8), (0, 0, 0.4))
    top = add_light("top", "AREA", 80, shape="DISK", size=1.2)
    look_at(top, (0.2, 0.8, 3.4), (0, 0.2, 0))
    spot = add_light("spot", "SPOT", 500, color=(1, 0.8, 0.6), spot_size=0.7, spot_blend=0.6, shadow_soft_size=0)
    look_at(spot, (1.6, 2.2, 2.6), (0.2, 3.0, 0.9))
    set_world((1, 1, 1), 0.05)
