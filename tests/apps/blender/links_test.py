#!/usr/bin/python3
"""Tests that graphs of shader nodes are read and evaluated in linear time: nodes may have several links, so that
there are exponentially many paths to them. Objects of this file stand for Blender's.
"""
import sys
import types
import unittest

import numpy as np

sys.modules["bpy"] = types.ModuleType("bpy")
from nodes import Images, image_node, link, node, quiet_report, value  # noqa: E402
from kinome_export import blender_nodes, blender_scene  # noqa: E402
from kinome_export.materials import material  # noqa: E402
from kinome_export.textures import Inputs, fold, nodes_below  # noqa: E402

LENGTH = 60  # of a chain of nodes with 2^60 paths


class Socket(types.SimpleNamespace):
    def __init__(self, name, node=None, value=None, kind="RGBA"):
        super().__init__(name=name, node=node, default_value=value, type=kind, links=[], enabled=True)

    @property
    def is_linked(self):
        return bool(self.links)


class Node:
    """A node that counts how often its type is read."""
    mute = False
    label = ""

    def __init__(self, kind, outputs=("Color",), **fields):
        self.kind, self.name, self.reads, self.inputs = kind, kind, 0, []
        self.outputs = [Socket(name, self) for name in outputs]
        self.__dict__.update(fields)

    def add(self, name, source=None, value=None, kind="RGBA"):
        socket = Socket(name, self, value, kind)
        if source is not None:
            socket.links = [types.SimpleNamespace(from_socket=source.outputs[0])]
        self.inputs.append(socket)
        return self

    def as_pointer(self):
        return id(self)

    @property
    def type(self):
        return self.kind

    @property
    def color_ramp(self):
        self.reads += 1
        return types.SimpleNamespace(evaluate=lambda at: (at, at, at, 1))


def chain():
    """Returns a tree whose colour is a chain of MIX nodes, with two links each to the one before, and its nodes."""
    nodes = [Node("VALTORGB").add("Fac", value=0.25)]
    for _ in range(LENGTH):
        mix = Node("MIX", data_type="RGBA", blend_type="MIX", clamp_result=False)
        nodes.append(mix.add("Factor", value=0.5).add("A", nodes[-1]).add("B", nodes[-1]))
    shader = Node("BSDF_DIFFUSE").add("Color", nodes[-1]).add("Roughness", value=0.0)
    out = Node("OUTPUT_MATERIAL", bl_idname="ShaderNodeOutputMaterial", is_active_output=True)
    out.add("Surface", shader, kind="SHADER")

    class Inputs(list):
        def __contains__(self, name):
            return any(socket.name == name for socket in self)

        def __getitem__(self, name):
            return next(socket for socket in self if socket.name == name)
    out.inputs = Inputs(out.inputs)
    for other in (*nodes, shader):
        other.bl_idname = other.kind
    return types.SimpleNamespace(nodes=[*nodes, shader, out]), nodes


class Links(unittest.TestCase):
    def test_nodes_are_read_once(self):
        tree, nodes = chain()
        surface = blender_nodes.surface_of(tree)
        self.assertEqual(nodes[0].reads, 257)  # the entries of a ramp
        top = surface["inputs"]["Color"]["node"]
        self.assertIs(top["inputs"]["A"]["node"], top["inputs"]["B"]["node"])
        self.assertEqual(len(nodes_below(surface)), LENGTH + 2)
        np.testing.assert_allclose(fold(surface["inputs"]["Color"]), [0.25] * 3)
        self.assertIsNone(blender_scene._attribute(surface))
        self.assertTrue(blender_nodes.has(tree, "Surface"))
        self.assertFalse(blender_nodes.has(tree, "Volume"))

    def test_baked_chains(self):
        images, top = Images(), image_node()
        images.texels["wood.png"] = np.random.default_rng(1).random((2, 3, 4))
        for _ in range(LENGTH):
            top = {**node("MIX", "Mix", Factor=0.5, A=link(top), B=link(top)), "data_type": "RGBA",
                   "blend_type": "MIX", "clamp_result": False}
        Inputs("material", "m", images, quiet_report()).texture(link(top, "Result"))
        np.testing.assert_allclose(images.stored["m-Mix"], images.texels["wood.png"][..., :3])

    @staticmethod
    def shader(red):
        return node("BSDF_DIFFUSE", Color=[red, 0.5, 0.5, 1], Roughness=0.0)

    def chain_of_shaders(self, fraction):
        """Returns the BSDF of a chain of nodes that mix the two before each."""
        nodes = [self.shader(0.1), self.shader(0.9)]
        for i in range(20):
            nodes.append({**node("MIX_SHADER", f"Mix {i}", Fac=fraction),
                          "shaders": [link(one, "Shader") for one in nodes[-2:]]})
        # A mix of a shader with itself is this shader.
        top = {**node("MIX_SHADER", "Top", Fac=0.5), "shaders": [link(nodes[-1], "Shader")] * 2}
        return material("m", top, Images(), quiet_report()).bsdf

    def test_chains_of_shaders_with_constant_weights(self):
        """They are sums of their two BSDFs."""
        bsdf = self.chain_of_shaders(0.25)
        weights = [0., 1.]  # of the second BSDF
        for _ in range(20):
            weights.append(0.75 * weights[-2] + 0.25 * weights[-1])
        self.assertEqual(bsdf.get("type"), "blendbsdf")
        self.assertEqual([one.get("type") for one in bsdf.iter("bsdf")], ["blendbsdf", *["twosided", "diffuse"] * 2])
        reds = [float(rgb.get("value").split()[0]) for rgb in bsdf.iter("rgb")]
        weight = float(value(bsdf, "weight"))
        self.assertAlmostEqual((1 - weight) * reds[0] + weight * reds[1], 0.1 + 0.8 * weights[-1], 6)

    def test_chains_of_shaders_with_textures(self):
        """Each node is written once."""
        bsdf = self.chain_of_shaders(link(image_node()))
        found = [one.get("type") for one in bsdf.iter("bsdf")]
        self.assertEqual([found.count(kind) for kind in ("blendbsdf", "twosided", "diffuse")], [20, 2, 2])
        defined = []
        for one in bsdf.iter():
            if one.tag == "ref":
                self.assertIn(one.get("id"), defined)
            elif one.get("id"):
                defined.append(one.get("id"))
        self.assertEqual(len(set(defined)), len(defined))

    def test_the_first_colour_attribute(self):
        def attribute(name, is_color):
            return {**node("ATTRIBUTE"), "attribute": name, "is_color": is_color}
        top = node("MIX", A=link(attribute("density", False)),
                   B=link(node("GAMMA", Color=link(attribute("first", True)))), Factor=link(attribute("last", True)))
        self.assertEqual(blender_scene._attribute(top), "first")

    def test_materials_without_a_surface(self):
        tree, _ = chain()
        tree.nodes[-1].inputs.clear()
        sys.modules["bpy"].data = types.SimpleNamespace(
            materials={"none": types.SimpleNamespace(use_nodes=True, node_tree=tree)})
        export = types.SimpleNamespace(report=quiet_report())
        self.assertEqual(blender_scene._Export._nodes_of_material(export, "none"), (None, None))


if __name__ == "__main__":
    unittest.main()
