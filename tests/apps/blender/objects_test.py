#!/usr/bin/python3
"""Tests of the exporter from Blender that need neither bpy nor Kinome: units of lights, cameras, worlds, meshes, and
the XML that is written.
"""
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ET

import numpy as np

from nodes import CAMERA, FILM, IDENTITY, ROOT, Images, link, node, numbers, numbers_of_transform, quiet_report, value
from kinome_export import camera, elements as e, lights, ply, world  # found by nodes
from kinome_export.textures import blackbody


class LightTest(unittest.TestCase):
    def setUp(self):
        self.report, self.images = quiet_report(), Images()

    def light(self, kind, **settings):
        base = {"type": kind, "name": "a", "matrix": IDENTITY, "color": [1, 0.5, 0.25], "energy": 100.0,
                "normalize": True, "radius": 0.0, "spread": math.pi, "angle": 0.01}
        return lights.light({**base, **settings}, self.images, self.report)

    def test_a_point_light_emits_its_power_with_any_radius(self):
        intensity = numbers(self.light("POINT"), "intensity")
        np.testing.assert_allclose(intensity, 100 / (4 * math.pi) * np.array([1, 0.5, 0.25]), rtol=1e-6)
        sphere = self.light("POINT", radius=0.3)
        self.assertEqual((sphere.tag, sphere.get("type"), value(sphere, "radius")), ("shape", "sphere", "0.3"))
        radiance = numbers(sphere.find("emitter"), "radiance")
        # The flux of a sphere is pi L A.
        np.testing.assert_allclose(np.array(radiance) * math.pi * 4 * math.pi * 0.3**2, [100, 50, 25], rtol=1e-6)

    def test_an_area_light_has_the_same_power_with_any_size_and_shape(self):
        fluxes = []
        for settings in ({"shape": "SQUARE", "size": 2.0}, {"shape": "RECTANGLE", "size": 2.0, "size_y": 0.5},
                         {"shape": "DISK", "size": 2.0}, {"shape": "ELLIPSE", "size": 3.0, "size_y": 0.5},
                         {"shape": "SQUARE", "size": 2.0, "matrix": np.diag([3.0, 0.5, 1, 1])}):
            element = self.light("AREA", **settings)
            m = np.array(numbers_of_transform(element)).reshape(4, 4)
            # Both shapes have a half-width of 1; both shine along -z.
            area = 4 * np.linalg.norm(m[:3, 0]) * np.linalg.norm(m[:3, 1])
            area *= math.pi / 4 if element.get("type") == "disk" else 1
            np.testing.assert_allclose(m[:3, 2] / np.linalg.norm(m[:3, 2]), [0, 0, -1], atol=1e-7)
            fluxes.append(math.pi * area * numbers(element.find("emitter"), "radiance")[0])
        np.testing.assert_allclose(fluxes, 100, rtol=1e-6)

    def test_without_normalization_the_energy_is_that_of_a_unit_area(self):
        element = self.light("AREA", shape="SQUARE", size=3.0, normalize=False)
        self.assertAlmostEqual(numbers(element.find("emitter"), "radiance")[0], 100 / math.pi, 5)

    def test_a_sun_has_an_irradiance_and_shines_downwards(self):
        sun = self.light("SUN", energy=3.0)
        np.testing.assert_allclose(numbers(sun, "irradiance"), [3, 1.5, 0.75])
        self.assertEqual(numbers_of_transform(sun)[8:11], [0, 0, -1])
        self.assertEqual(self.report.lines, [])
        self.light("SUN", angle=0.2)
        self.assertIn("light 'a': the angle of 11.45916 degrees is left out", self.report.lines[0])

    def test_a_spot_keeps_its_flux(self):
        theta = (np.arange(20000) + 0.5) / 20000 * math.pi / 2
        for size in (0.2, 1.0, 2.5):
            for blend in (0.0, 0.15, 0.6, 1.0):
                cutoff, beam = lights.linear_falloff(size, blend)
                self.assertTrue(0 <= beam <= cutoff <= size / 2 + 1e-9)
                flux = [np.sum(np.sin(theta) * f) for f in (
                    lights.spot_falloff(np.cos(theta), size, blend),
                    np.clip((cutoff - theta) / max(cutoff - beam, 1e-9), 0, 1))]
                self.assertAlmostEqual(flux[1] / flux[0], 1, delta=4e-3, msg=(size, blend))

    def test_a_soft_spot_has_the_falloff_of_cycles_as_a_texture(self):
        spot = self.light("SPOT", spot_size=1.0, spot_blend=0.5, radius=0.1)
        image, = self.images.stored.values()
        self.assertEqual(value(spot.find("texture"), "filename"), "textures/spot-57.3-0.5.exr")
        cutoff = math.radians(float(value(spot, "cutoff_angle")))
        for x, y in ((128, 128), (250, 128), (60, 90), (0, 0)):
            # (u, v) = 1/2 + 1/2 (x, y) / (z tan(cutoff)) in Mitsuba.
            tangent = math.hypot((x + 0.5) / 128 - 1, (y + 0.5) / 128 - 1) * math.tan(cutoff)
            self.assertAlmostEqual(image[y, x, 0], float(lights.spot_falloff(math.cos(math.atan(tangent)), 1.0, 0.5)))
        self.assertGreater(image[128, 128, 0], 0.99)
        self.assertEqual(image[0, 0, 0], 0)
        self.assertIn("the radius 0.1 of a spot light is left out", self.report.lines[0])

    def test_a_black_light_is_left_out(self):
        self.assertIsNone(self.light("POINT", energy=0.0))
        self.assertIsNone(self.light("POINT", color=[0, 0, 0]))


class CameraTest(unittest.TestCase):
    def sensor(self, film={}, **changes):
        self.report = quiet_report()
        return camera.sensor({**CAMERA, **changes}, {**FILM, **film}, self.report)

    def test_looks_along_the_negative_z_axis_of_blender(self):
        m = np.array(numbers_of_transform(self.sensor(matrix=np.diag([2.0, 2, 2, 1])))).reshape(4, 4)
        np.testing.assert_allclose(m, np.diag([-1, 1, -1, 1]))

    def test_field_of_view_follows_the_fitted_side(self):
        angle = math.degrees(2 * math.atan(36 / 100))
        for film, fit, axis, expected in (({}, "AUTO", "x", angle), ({"height": 400}, "AUTO", "y", angle),
                                          ({"height": 400}, "HORIZONTAL", "x", angle),
                                          ({}, "VERTICAL", "y", math.degrees(2 * math.atan(24 / 100)))):
            sensor = self.sensor(film, sensor_fit=fit)
            self.assertEqual(value(sensor, "fov_axis"), axis)
            self.assertAlmostEqual(float(value(sensor, "fov")), expected, 4)

    def test_depth_of_field_is_a_thin_lens(self):
        sensor = self.sensor(dof={"fstop": 2.5, "distance": 3.0})
        self.assertEqual(sensor.get("type"), "thinlens")
        self.assertEqual((value(sensor, "aperture_radius"), value(sensor, "focus_distance")), ("0.01", "3"))
        sensor = self.sensor(dof={"fstop": 2.5, "distance": 3.0}, shift_x=0.1)
        self.assertEqual(sensor.get("type"), "perspective")
        self.assertEqual(len(self.report.lines), 1)

    def test_shift_is_relative_to_the_fitted_side(self):
        sensor = self.sensor(shift_x=0.1, shift_y=0.2)
        self.assertEqual(float(value(sensor, "principal_point_offset_x")), 0.1)
        self.assertAlmostEqual(float(value(sensor, "principal_point_offset_y")), -0.32, 6)

    def test_panoramas_are_reported(self):
        self.sensor(type="PANO")
        self.assertEqual(self.report.lines, ["camera 'c': panoramic cameras are unsupported; "
                                             "exported with a field of view of 90 degrees"])


class WorldTest(unittest.TestCase):
    def world(self, surface):
        self.report = quiet_report()
        return world.world("Sky", surface, Images(), self.report, lambda: "textures/baked.exr")

    def test_a_color_is_constant(self):
        sky = self.world(node("BACKGROUND", Color=[0.5, 0.25, 1, 1], Strength=2.0))
        self.assertEqual((sky.get("type"), numbers(sky, "radiance")), ("constant", [1, 0.5, 2]))
        self.assertIsNone(self.world(node("BACKGROUND", Color=[1, 1, 1, 1], Strength=0.0)))
        self.assertIsNone(self.world(None))

    def test_directions_of_an_image(self):
        angle = 0.7
        mapping = {**node("MAPPING", Rotation=[0, 0, angle]), "vector_type": "POINT"}
        image = {**node("TEX_ENVIRONMENT", Vector=link(mapping, "Vector")), "image": "sky.exr",
                 "projection": "EQUIRECTANGULAR"}
        sky = self.world(node("BACKGROUND", Color=link(image), Strength=1.5))
        self.assertEqual((sky.get("type"), value(sky, "scale")), ("envmap", "1.5"))
        m = np.array(numbers_of_transform(sky)).reshape(4, 4)[:3, :3]
        self.assertAlmostEqual(np.linalg.det(m), 1, 5)
        for u, v in ((0.5, 0.5), (0.25, 0.5), (0.1, 0.8)):
            # Blender: direction of (u, v), with v upwards, before the rotation of its coordinates.
            phi, theta = -2 * math.pi * (u - 0.5), math.pi * (v - 0.5)
            blender = np.array([math.cos(theta) * math.cos(phi), math.cos(theta) * math.sin(phi), math.sin(theta)])
            turned = np.array([[math.cos(angle), math.sin(angle), 0], [-math.sin(angle), math.cos(angle), 0],
                               [0, 0, 1]]) @ blender
            # Mitsuba: d = (sin phi sin theta, cos theta, -cos phi sin theta), phi = 2 pi u.
            theta = math.pi * (1 - v)
            local = [math.sin(2 * math.pi * u) * math.sin(theta), math.cos(theta),
                     -math.cos(2 * math.pi * u) * math.sin(theta)]
            np.testing.assert_allclose(m @ local, turned, atol=1e-6)

    def test_other_worlds_are_baked(self):
        sky = self.world(node("BACKGROUND", Color=link(node("TEX_SKY")), Strength=0.1))
        self.assertEqual((value(sky, "filename"), sky.find("*[@name='scale']")), ("textures/baked.exr", None))


class FileTest(unittest.TestCase):
    def test_without_blender_the_script_says_what_it_needs(self):
        # -S leaves out packages, of which bpy may be one.
        result = subprocess.run([sys.executable, "-S", ROOT / "apps/blender/export.py", "a.blend", "a.xml"],
                                capture_output=True, text=True)
        self.assertEqual((result.returncode, result.stdout), (1, ""))
        self.assertEqual(result.stderr, "export.py: bpy not found: run this in Blender, or in a Python with "
                                        "`pip install bpy`\n")
        result = subprocess.run([sys.executable, "-S", ROOT / "apps/blender/export.py", "--help"],
                                capture_output=True, text=True)
        self.assertEqual(result.returncode, 0)
        self.assertIn("--sky-width PIXELS", result.stdout)

    def test_corners_share_vertices(self):
        points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
        corners = np.array([0, 1, 2, 0, 2, 3])
        normals, uvs = np.tile([0.0, 0, 1], (6, 1)), points[corners][:, :2].copy()
        colors = np.zeros((6, 3))
        colors[3] = 1  # the second triangle's first corner differs
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "a.ply"
            ply.write(path, points, corners, normals, uvs, colors)
            data = path.read_bytes()
        header, body = data.split(b"end_header\n", 1)
        self.assertIn(b"element vertex 5\n", header)
        names = [line.split()[-1] for line in header.decode().splitlines() if line.startswith("property float")]
        self.assertEqual(names, ["x", "y", "z", "nx", "ny", "nz", "u", "v", "r", "g", "b"])
        vertices = np.frombuffer(body, "<f4", 5 * 11).reshape(5, 11)
        faces = np.frombuffer(body, np.dtype([("count", "u1"), ("index", "<i4", 3)]), 2, 5 * 11 * 4)
        np.testing.assert_allclose(vertices[faces["index"].ravel(), :3], points[corners])
        np.testing.assert_allclose(vertices[:, 7], 1 - vertices[:, 1])  # v counts downwards

    def test_names_are_unique_and_plain(self):
        names = e.Names()
        self.assertEqual([names.unique(n) for n in ("Wood.001", "wood 001", "Wood_001", "ø")],
                         ["Wood_001", "wood_001_2", "Wood_001_3", "unnamed"])

    def test_scene_files_are_complete_xml(self):
        scene = ET.Element("scene", {"version": "3.0.0"})
        scene.append(e.plugin("bsdf", "diffuse", e.rgb("reflectance", [1 / 3, 0, 1e-9]), None, id='a "quoted" <id>'))
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "a.xml"
            e.write(scene, path)
            self.assertEqual([p.name for p in pathlib.Path(folder).iterdir()], ["a.xml"])
            read = ET.parse(path).getroot()
        self.assertEqual(read.find("bsdf").get("id"), 'a "quoted" <id>')
        self.assertEqual(value(read.find("bsdf"), "reflectance"), "0.3333333 0 1e-09")

    def test_a_black_body_is_red_below_and_blue_above_daylight(self):
        for kelvin in (2700, 6500, 12000):
            r, g, b = blackbody(kelvin)
            self.assertAlmostEqual(0.2126 * r + 0.7152 * g + 0.0722 * b, 1, delta=0.02)
            self.assertEqual(r > b, kelvin < 6600)


if __name__ == "__main__":
    unittest.main()
