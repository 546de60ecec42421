#!/usr/bin/python3
"""Tests of the exporter inside Blender: what it reads from objects and nodes, and images of Kinome and Cycles.
Needs a Python with bpy (validation/requirements-cycles.txt). KINOME_BUILD is the build folder.
"""
import io
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ET

import bpy
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[3]
BUILD = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build"))
sys.path.insert(0, str(ROOT / "validation/blender"))
import common
import lights
from kinome_export.report import Report


def value(element, name):
    return element.find(f"*[@name='{name}']").get("value")


class ExportTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        common.start(16, 16, 2)
        common.add_camera((0, -5, 2), (0, 0, 0))

    def export(self):
        self.report = Report(io.StringIO())
        common.export(str(self.folder / "scene.xml"), report=self.report)
        return ET.parse(self.folder / "scene.xml").getroot()

    def test_hidden_objects_and_render_levels(self):
        cube = bpy.ops.mesh.primitive_cube_add
        hidden, shown = (common.add_operator(cube, name) for name in ("hidden", "shown"))
        hidden.hide_render, shown.hide_viewport = True, True
        modifier = shown.modifiers.new("smooth", "SUBSURF")
        modifier.levels, modifier.render_levels = 0, 2
        scene = self.export()
        self.assertEqual([s.get("id") for s in scene.findall("shape")], ["mesh-shown"])
        header = (self.folder / "meshes/shown.ply").read_bytes().split(b"end_header")[0]
        self.assertIn(b"element face 192\n", header)  # 6 x 16 quadrilaterals
        self.assertEqual((modifier.levels, shown.hide_viewport, hidden.hide_viewport), (0, True, False))

    def test_shared_meshes_and_mirrored_objects(self):
        common.add_operator(bpy.ops.mesh.primitive_cube_add, "small")
        common.add("copy", bpy.data.objects["small"].data, (3, 0, 0), scale=(-1, 1, 1))
        ball = common.add_operator(bpy.ops.mesh.primitive_uv_sphere_add, "ball", segments=128, ring_count=64)
        for x in range(3):
            common.add("ball", ball.data, (x, 0, 0))
        scene = self.export()
        kinds = [s.get("type") for s in scene.findall("shape")]
        self.assertEqual(sorted(kinds), ["instance"] * 4 + ["ply"] * 2 + ["shapegroup"])
        # The mirrored object has its own file of the small mesh, with reversed triangles.
        self.assertEqual(sorted(p.name for p in (self.folder / "meshes").iterdir()),
                         ["ball.ply", "small.ply", "small_2.ply"])

    def test_groups_of_nodes_and_warnings(self):
        group = bpy.data.node_groups.new("tone", "ShaderNodeTree")
        for name, way in (("Tint", "INPUT"), ("Result", "OUTPUT")):
            group.interface.new_socket(name, in_out=way, socket_type="NodeSocketColor")
        inner, outer = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
        gamma = group.nodes.new("ShaderNodeGamma")
        gamma.inputs["Gamma"].default_value = 2
        group.links.new(inner.outputs["Tint"], gamma.inputs["Color"])
        group.links.new(gamma.outputs["Color"], outer.inputs["Result"])
        material = common.principled("painted")
        node = material.node_tree.nodes.new("ShaderNodeGroup")
        node.node_tree = group
        node.inputs["Tint"].default_value = (0.5, 0.4, 0.2, 1)
        shader = material.node_tree.nodes["Principled BSDF"]
        material.node_tree.links.new(node.outputs["Result"], shader.inputs["Base Color"])
        common.link_new(material, "ShaderNodeTexNoise", "Roughness", output="Fac")
        common.add_operator(bpy.ops.mesh.primitive_cube_add, "cube", material)
        bsdf = self.export().find("bsdf/bsdf")
        # The exporter adapts the colour to Mitsuba's lobes, by less than a tenth.
        np.testing.assert_allclose([float(x) for x in value(bsdf, "base_color").split()], [0.25, 0.16, 0.04], rtol=0.1)
        self.assertEqual(self.report.lines, ["material 'painted': node 'Noise Texture' (TEX_NOISE) is unsupported; "
                                             "the value 0.5 is used"])

    def test_textures_look_as_in_cycles(self):
        """Images with their mapping, nodes that are baked, checkers and vertex colours, on an emitting plane."""
        rng = np.random.default_rng(2)

        def textured(name):
            image = bpy.data.images.new("noise", 4, 4)
            image.pixels.foreach_set(np.append(rng.random((16, 3)), np.ones((16, 1)), 1).astype(np.float32).ravel())
            image.pack()
            material = bpy.data.materials.new(name)
            material.use_nodes = True
            nodes, links = material.node_tree.nodes, material.node_tree.links
            nodes.clear()
            emission, output = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
            links.new(emission.outputs[0], output.inputs["Surface"])
            if name == "colors":
                source = nodes.new("ShaderNodeVertexColor")
                source.layer_name = "paint"
            elif name == "checker":
                source = nodes.new("ShaderNodeTexChecker")
                source.inputs["Scale"].default_value = 3
                links.new(nodes.new("ShaderNodeTexCoord").outputs["UV"], source.inputs["Vector"])
            else:
                source = nodes.new("ShaderNodeTexImage")
                source.image, source.interpolation = image, "Closest"
                mapping = nodes.new("ShaderNodeMapping")
                mapping.inputs["Rotation"].default_value = (0, 0, 0.4)
                mapping.inputs["Scale"].default_value = (1.5, 0.8, 1)
                mapping.inputs["Location"].default_value = (0.1, 0.3, 0)
                links.new(nodes.new("ShaderNodeTexCoord").outputs["UV"], mapping.inputs["Vector"])
                links.new(mapping.outputs["Vector"], source.inputs["Vector"])
            if name == "baked":
                hue = nodes.new("ShaderNodeHueSaturation")
                hue.inputs["Hue"].default_value, hue.inputs["Saturation"].default_value = 0.7, 0.6
                links.new(source.outputs["Color"], hue.inputs["Color"])
                source = hue
            links.new(source.outputs["Color"], emission.inputs["Color"])
            return material
        for name in ("image", "checker", "colors", "baked"):
            with self.subTest(name):
                common.start(48, 48, 0)
                camera = common.add_camera((0, 0, 3), (0, 0, 0), lens=54)
                camera.type, camera.ortho_scale = "ORTHO", 2
                plane = common.add_operator(bpy.ops.mesh.primitive_plane_add, "plane", textured(name), size=2)
                paint = plane.data.color_attributes.new("paint", "FLOAT_COLOR", "CORNER")
                paint.data.foreach_set("color", rng.random(16).astype(np.float32))
                self.export()
                self.assertEqual(self.report.lines, [])
                ours = common.render_kinome(self.folder / "scene.xml", 64)
                theirs = common.render_cycles(64)
                # Texels end inside of pixels, which differ by the noise of the edge.
                self.assertLess(np.abs(ours - theirs).mean() / theirs.mean(), 0.03)


class LightTest(unittest.TestCase):
    def test_units_are_those_of_cycles(self):
        """The means of Kinome and Cycles differ by less than 1 % and five standard errors."""
        for name in ("point, radius 0", "spot, blend 1", "sun", "area, rectangle, scaled", "area, disk",
                     "world, colour", "world, image, rotated"):
            with self.subTest(name):
                ratio, error, *_ = lights.compare(lights.CASES[name], 64, 32)
                self.assertTrue((abs(ratio - 1) < 0.01 + 5 * error).all(), (ratio, error))


if __name__ == "__main__":
    unittest.main()
