#!/usr/bin/python3
"""Tests of the materials of the exporter from Blender. They need neither bpy nor Kinome."""
import math
import unittest

import numpy as np

from nodes import Images, image_node, link, node, numbers, numbers_of_transform, principled_node, quiet_report, value
from kinome_export import energy, materials, principled  # found by nodes


class MaterialTest(unittest.TestCase):
    def setUp(self):
        self.report, self.images = quiet_report(), Images()

    def material(self, surface):
        return materials.material("Oak", surface, self.images, self.report)

    def bsdf(self, **changes):
        """Returns the `principled` BSDF of a Principled BSDF with some inputs changed."""
        bsdf = self.material(principled_node(**changes)).bsdf
        return bsdf if bsdf.get("type") == "principled" else bsdf.find(".//bsdf[@type='principled']")

    def test_a_plain_principled_bsdf(self):
        material = self.material(principled_node())
        self.assertEqual(material.bsdf.get("type"), "twosided")
        bsdf = material.bsdf.find("bsdf")
        self.assertEqual(bsdf.get("type"), "principled")
        np.testing.assert_allclose(numbers(bsdf, "base_color"), [0.8, 0.2, 0.1], atol=0.07)
        self.assertAlmostEqual(float(value(bsdf, "eta")), 1.5, 5)
        self.assertIsNone(bsdf.find("*[@name='clearcoat']"))
        self.assertEqual(self.report.lines, [])
        self.assertIsNone(material.radiance)

    def test_specular_level_scales_the_reflectance(self):
        for level, ior in ((0.0, 1.5), (0.25, 1.5), (1.0, 1.33), (0.5, 2.0)):
            eta = float(value(self.bsdf(Specular_IOR_Level=level, IOR=ior), "eta"))
            self.assertAlmostEqual(principled.reflectance_of_ior(eta),
                                   2 * level * principled.reflectance_of_ior(ior), 6)

    def test_glass_keeps_its_index_and_has_no_back(self):
        material = self.material(principled_node(Transmission_Weight=1.0, IOR=1.33, Specular_IOR_Level=0.2))
        self.assertEqual(material.bsdf.get("type"), "principled")
        self.assertEqual(value(material.bsdf, "eta"), "1.33")
        self.assertEqual(value(material.bsdf, "spec_trans"), "1")
        self.assertEqual(numbers(material.bsdf, "base_color"), [0.8, 0.2, 0.1])

    def test_partial_transmission_is_a_blend_whose_opaque_part_is_two_sided(self):
        blend = self.material(principled_node(Transmission_Weight=0.5, Metallic=0.2)).bsdf
        self.assertEqual((blend.get("type"), value(blend, "weight")), ("blendbsdf", "0.4"))
        opaque, glass = blend.findall("bsdf")
        self.assertEqual((opaque.get("type"), glass.get("type")), ("twosided", "principled"))
        # 0.2 of all light meets metal, 0.4 glass, 0.4 the diffuse base.
        self.assertAlmostEqual(float(value(opaque.find("bsdf"), "metallic")), 0.2 / 0.6, 6)
        metal = self.material(principled_node(Transmission_Weight=0.5, Metallic=1.0)).bsdf
        self.assertEqual(metal.get("type"), "twosided")

    def test_alpha_and_emission(self):
        material = self.material(principled_node(Alpha=0.25, Emission_Color=[1, 0.5, 0, 1], Emission_Strength=8.0))
        self.assertEqual(material.bsdf.get("type"), "mask")
        self.assertEqual(value(material.bsdf, "opacity"), "0.25")
        self.assertEqual(material.radiance.get("value"), "8 4 0")

    def test_images(self):
        wood = image_node(extension="EXTEND", interpolation="Closest")
        rough = image_node("rough.png", is_data=True)
        bsdf = self.bsdf(Base_Color=link(wood), Roughness=link(rough))
        color, roughness = (bsdf.find(f"texture[@name='{name}']") for name in ("base_color", "roughness"))
        self.assertEqual(color.get("type"), "bitmap")
        self.assertEqual(value(color, "filename"), "textures/wood.png")
        self.assertEqual((value(color, "filter_type"), value(color, "wrap_mode")), ("nearest", "clamp"))
        self.assertIsNone(color.find("*[@name='raw']"))
        self.assertEqual(value(roughness, "raw"), "true")
        self.assertEqual(self.report.lines, [])

    def test_mapping_nodes_transform_texture_coordinates(self):
        uv = link(node("TEX_COORD"), "UV", [0, 0, 0])
        mapping = node("MAPPING", Vector=uv, Location=[0.25, 0.5, 0], Rotation=[0, 0, math.pi / 2], Scale=[2.0, 3, 1])
        mapping["vector_type"] = "POINT"
        image = image_node(vector=link(mapping, "Vector", [0, 0, 0]))
        m = np.array(numbers_of_transform(self.bsdf(Base_Color=link(image)).find("texture"))).reshape(4, 4)
        for u, v in ((0, 0), (0.3, 0.1), (0.7, 0.9)):
            # Scaled, turned by 90 degrees, moved; rows of images count from the top.
            x, y = -3 * v + 0.25, 2 * u + 0.5
            np.testing.assert_allclose((m @ [u, 1 - v, 0, 1])[:2], [x, 1 - y], atol=1e-6)

    def test_normal_maps_and_bumps_are_nested_in_two_sided(self):
        normal_map = {**node("NORMAL_MAP", Strength=1.0, Color=link(image_node(is_data=True))), "space": "TANGENT"}
        bump = {**node("BUMP", Strength=0.5, Distance=0.2, Height=link(image_node())), "invert": True}
        for source, kind in ((normal_map, "normalmap"), (bump, "bumpmap")):
            bsdf = self.material(principled_node(Normal=link(source, "Normal"))).bsdf
            self.assertEqual([b.get("type") for b in bsdf.iter("bsdf")], ["twosided", kind, "principled"])
        self.assertEqual(value(bsdf.find("bsdf"), "scale"), "-0.1")

    def test_unsupported_nodes_are_reported_once_with_the_material(self):
        noise = link(node("TEX_NOISE", "Noise Texture"), "Fac", [0.1, 0.2, 0.3, 1])
        bsdf = self.bsdf(Base_Color=noise)
        np.testing.assert_allclose(numbers(bsdf, "base_color"), [0.1, 0.2, 0.3], rtol=1e-6)
        self.bsdf(Base_Color=noise)
        self.assertEqual(self.report.lines, ["material 'Oak': node 'Noise Texture' (TEX_NOISE) is unsupported; "
                                             "the value 0.1 0.2 0.3 is used"])
        self.material(node("BSDF_TOON", "Toon"))
        self.assertIn("node 'Toon' (BSDF_TOON) is unsupported; a diffuse surface is used", self.report.lines[-1])
        self.bsdf(Subsurface_Weight=0.5)
        self.assertEqual(self.report.lines[-1], "material 'Oak': 'Subsurface Weight' is left out")

    def test_nodes_between_images_and_inputs_are_baked(self):
        texels = np.random.default_rng(1).random((2, 3, 4))
        self.images.texels = {"wood.png": texels, "dirt.png": texels[::-1]}
        darker = {**node("MIX", Factor=0.5, A=link(image_node()), B=[0.5, 1, 1, 1]), "data_type": "RGBA",
                  "blend_type": "MULTIPLY", "clamp_result": False}
        ramp = {**node("VALTORGB", "Ramp", Fac=link(image_node("dirt.png"))), "ramp": [[0, 0, 0, 1], [1, 0.5, 0.25, 1]]}
        bsdf = self.bsdf(Base_Color=link(darker), Roughness=link(ramp), Alpha=link(image_node(), "Alpha"))
        self.assertEqual(self.report.lines, [])
        color, roughness = self.images.stored["Oak-node"], self.images.stored["Oak-Ramp"]
        np.testing.assert_allclose(color, texels[..., :3] * [0.75, 1, 1])
        grey = texels[::-1, :, :3] @ [0.2126, 0.7152, 0.0722]
        np.testing.assert_allclose(roughness, grey[..., None] * [1, 0.5, 0.25])
        np.testing.assert_allclose(self.images.stored["Oak-Image"], np.repeat(texels[..., 3:], 3, -1))
        self.assertEqual(value(bsdf.find("texture"), "filename"), "textures/Oak-node.exr")
        # Two images with different coordinates have no common texels.
        mapping = {**node("MAPPING", Scale=[2.0, 2, 2]), "vector_type": "POINT"}
        moved = image_node("dirt.png", link(mapping, "Vector"))
        self.bsdf(Base_Color=link({**darker, "inputs": {**darker["inputs"], "B": link(moved)}}))
        self.assertIn("its texture coordinates differ from those of node 'Image'", self.report.lines[0])

    def test_nodes_of_constants_are_evaluated(self):
        half = {**node("MATH"), "operation": "MULTIPLY", "use_clamp": False,
                "values": [link({**node("VALUE"), "value": 0.5}, "Value"), 0.5]}
        turned = node("HUE_SAT", Hue=0.5 + 1 / 3, Saturation=1.0, Value=0.5, Fac=1.0, Color=[1, 0, 0, 1])
        bsdf = self.bsdf(Roughness=link(half, "Value"), Base_Color=link(turned))
        self.assertEqual(value(bsdf, "roughness"), "0.25")
        np.testing.assert_allclose(numbers(bsdf, "base_color"), [0, 0.5, 0], atol=0.05)

    def test_mixed_shaders(self):
        clear = link(node("BSDF_TRANSPARENT", Color=[1, 1, 1, 1]))
        red = link(node("BSDF_DIFFUSE", Color=[1, 0, 0, 1], Roughness=0.0))
        shiny = link(node("BSDF_GLOSSY", Color=[1, 1, 1, 1], Roughness=0.3, Anisotropy=0.0))

        def mix(*shaders):
            return self.material({**node("MIX_SHADER", Fac=0.25), "shaders": shaders}).bsdf
        cut = mix(clear, red)
        self.assertEqual((cut.get("type"), value(cut, "opacity")), ("mask", "0.25"))
        self.assertEqual(value(mix(red, clear), "opacity"), "0.75")
        blend = mix(red, shiny)
        self.assertEqual((blend.get("type"), value(blend, "weight")), ("blendbsdf", "0.25"))
        self.assertEqual([b.get("type") for b in blend], [None, "twosided", "twosided"])
        self.assertAlmostEqual(float(value(blend.find(".//bsdf[@type='roughconductor']"), "alpha")), 0.09, 6)

    def test_an_emission_without_bsdf_is_black(self):
        material = self.material(node("EMISSION", Color=[1, 0.5, 0, 1], Strength=2.0))
        self.assertEqual(material.radiance.get("value"), "2 1 0")
        self.assertEqual(numbers(material.bsdf.find("bsdf"), "reflectance"), [0, 0, 0])

    def test_a_base_color_keeps_the_reflectance(self):
        """The albedo of Mitsuba's lobes is that of Cycles' layers."""
        for roughness, ior in ((0.1, 1.5), (0.5, 1.5), (0.9, 1.3)):
            color = np.array([0.8, 0.3, 0.05])
            base = principled.base_color_of(color, roughness, ior)
            single, full = energy.ggx(roughness**2, ior)[1], energy.specular(roughness**2, ior)
            np.testing.assert_allclose(single + np.array(base) * energy.diffuse(roughness), full + (1 - full) * color)
        # Smooth metals keep their colour; rough metals become brighter, at most white.
        np.testing.assert_allclose(principled.base_color_of(color, 0.05, 1.5, metallic=1.0), color, rtol=2e-3)
        metal = principled.base_color_of([1.0, 0.5], 0.8, 1.5, metallic=1.0)
        self.assertEqual(metal[0], 1)
        self.assertTrue(0.52 < metal[1] < 0.7)
        # Cycles' albedo in a white furnace of a metal of roughness 1 and colour 0.25, with 32 samples: 0.117.
        white, _, schlick = energy.ggx(1.0, 1.5)
        color, = principled.base_color_of([0.25], 1.0, 1.5, metallic=1.0)
        self.assertAlmostEqual(white * (color + (1 - color) * schlick), 0.117, delta=0.002)

    def test_reflectances_are_those_of_closed_forms(self):
        # The mean Fresnel reflectance of glass of index 1.5 (Walsh 1926). Those of (1 - cosine)^5 are 1/21.
        self.assertAlmostEqual(energy.ggx(1e-3, 1.5)[1], 0.0918, delta=3e-3)
        self.assertAlmostEqual(energy.ggx(1e-3, 1.5)[0], 1, delta=1e-3)
        self.assertAlmostEqual(energy.diffuse(0.0), (1 - 0.5 / 21) ** 2, delta=2e-3)

    def test_a_coat_has_the_reflectance_and_the_width_of_blenders(self):
        clearcoat, gloss = principled.clearcoat_of(1.0, 0.03, 1.5)
        self.assertEqual(gloss, 1)
        self.assertAlmostEqual(clearcoat * energy.clearcoat(1.0), energy.specular(1e-3, 1.5), 6)
        self.assertEqual(principled.clearcoat_of(1.0, 0.9, 1.5)[1], 0)
        self.assertGreater(principled.clearcoat_of(1.0, 0.1, 1.8)[0], clearcoat)
        bsdf = self.bsdf(Coat_Weight=0.5, Metallic=1.0)
        self.assertAlmostEqual(float(value(bsdf, "clearcoat")), clearcoat / 2, 5)

    def test_the_coat_of_plastic_is_the_specular_lobe(self):
        bsdf = self.bsdf(Coat_Weight=1.0, Coat_Roughness=0.1, Coat_IOR=1.6, Roughness=0.7)
        self.assertEqual((value(bsdf, "roughness"), bsdf.find("*[@name='clearcoat']")), ("0.1", None))
        self.assertAlmostEqual(float(value(bsdf, "eta")), 1.6, 5)
        blend = self.material(principled_node(Coat_Weight=0.25, Roughness=0.7)).bsdf
        self.assertEqual((blend.get("type"), value(blend, "weight")), ("blendbsdf", "0.25"))
        self.assertEqual([value(b, "roughness") for b in blend.iter("bsdf") if b.get("type") == "principled"],
                         ["0.7", "0.03"])

    def test_rough_plastic_is_diffuse(self):
        bsdf = self.material(principled_node(Roughness=0.9)).bsdf.find("bsdf")
        self.assertEqual(bsdf.get("type"), "diffuse")
        specular = energy.specular(0.81, 1.5)
        np.testing.assert_allclose(numbers(bsdf, "reflectance"),
                                   specular + (1 - specular) * np.array([0.8, 0.2, 0.1]), rtol=1e-6)
        self.assertEqual(self.bsdf(Roughness=0.9, Metallic=1.0).get("type"), "principled")

    def test_sheen_brightens_the_base(self):
        plain, velvet = (numbers(self.bsdf(Sheen_Weight=w, Sheen_Tint=[1, 0, 1]), "base_color") for w in (0.0, 0.5))
        np.testing.assert_allclose(np.array(velvet) - np.array(plain) * (1 - 0.045), [0.045, 0, 0.045], atol=1e-6)


if __name__ == "__main__":
    unittest.main()
