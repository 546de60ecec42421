#!/usr/bin/python3
"""Tests of the Python module's interface in Mitsuba's form: transforms, objects of scenes and objects
loaded alone, meshes from arrays, and names of parameters.

KINOME_BUILD is the build folder.
"""
import os
import pathlib
import sys
import tempfile
import unittest

import numpy as np

BUILD = pathlib.Path(os.environ["KINOME_BUILD"])
sys.path.insert(0, str(BUILD / "python"))
import kinome as mi  # noqa: E402
from small_box import small_box  # noqa: E402
from kinome import ScalarTransform4f as T  # noqa: E402


class Transforms(unittest.TestCase):
    def assert_close(self, a, b, tolerance=1e-12):
        np.testing.assert_allclose(np.asarray(getattr(a, "matrix", a), float),
                                   np.asarray(getattr(b, "matrix", b), float), rtol=0,
                                   atol=tolerance)

    def test_class_methods_equal_those_of_the_identity(self):
        for one, other in ((T.translate([1, 2, 3]), T().translate([1, 2, 3])),
                           (T.scale(2), T().scale([2, 2, 2])),
                           (T.look_at(origin=[0, 0, 4], target=[0, 0, 0], up=[0, 1, 0]),
                            T().look_at([0, 0, 4], [0, 0, 0], [0, 1, 0]))):
            self.assertEqual(one, other)
        self.assertNotEqual(T.scale(2), T.scale(3))

    def test_points_directions_and_normals(self):
        turn = T().translate([1, 2, 3]).rotate([0, 0, 1], 90).scale([2, 1, 1])
        self.assert_close(turn @ mi.ScalarPoint3f(1, 0, 0), [1, 4, 3])
        self.assert_close(turn @ [1, 0, 0], [1, 4, 3])
        self.assert_close(turn @ mi.ScalarVector3f(1, 0, 0), [0, 2, 0])
        self.assert_close(turn @ mi.ScalarNormal3f([1, 0, 0]), [0, 0.5, 0])
        self.assertIsInstance(turn @ mi.ScalarVector3f(1), mi.Vector3f)
        points = np.random.default_rng(1).random((5, 3))
        self.assert_close(turn @ points, [turn @ point for point in points])
        self.assert_close(turn.inverse() @ (turn @ points), points)
        self.assert_close((turn @ T.scale(3)) @ points, turn @ (3 * points))
        self.assert_close(turn.translation(), [1, 2, 3])
        self.assertTrue(turn.has_scale())
        self.assertFalse(T.rotate([1, 1, 0], 30).has_scale())

    def test_projections(self):
        """A perspective maps the corners of its pyramid to those of the box."""
        near, far = 0.5, 20
        project = T.perspective(fov=60, near=near, far=far)
        edge = np.tan(np.radians(30))
        self.assert_close(project @ [edge * near, -edge * near, near], [1, -1, 0])
        self.assert_close(project @ [-edge * far, edge * far, far], [-1, 1, 1])
        self.assert_close(T.orthographic(near, far) @ [3, 4, far], [3, 4, 1])
        self.assert_close(T.orthographic(near, far) @ [3, 4, near], [3, 4, 0])
        for wrong in (lambda: T.perspective(180, 1, 2), lambda: T.perspective(60, 2, 1),
                      lambda: T.orthographic(1, 1)):
            with self.assertRaises(ValueError):
                wrong()

    def test_frames(self):
        for n in ([0, 0, 1], [0, 0, -1], [0.6, 0, 0.8], [0.36, 0.48, -0.8]):
            frame = mi.Frame3f(n)
            to, back = T().to_frame(frame), T().from_frame(frame)
            self.assert_close(to @ mi.Vector3f(0, 0, 1), n)
            self.assert_close(to @ mi.Vector3f(1, 0, 0), frame.s)
            self.assert_close(to @ back, np.eye(4))
            self.assertAlmostEqual(np.linalg.det(to.matrix), 1)

    def test_sizes_of_boxes(self):
        box = mi.BoundingBox3f([0, 0, 0], [1, 2, 3])
        self.assertEqual((box.volume(), box.surface_area()), (6, 22))
        empty = mi.BoundingBox3f()
        self.assertEqual((empty.volume(), empty.surface_area()), (0, 0))
        self.assertEqual(empty.extents().tolist(), [-np.inf] * 3)
        self.assertTrue(np.isnan(empty.center()).all())
        self.assertIsInstance(box.extents(), mi.Vector3f)

    def test_wrong_vectors_are_named(self):
        box = mi.BoundingBox3f([0, 0, 0], [1, 1, 1])
        for wrong, kind, text in (
                (lambda: mi.Frame3f([[0, 0, 1], [0, 0, 0]]), ValueError, "n is the zero vector"),
                (lambda: mi.Point3f(np.zeros(4), np.zeros(3), 0), ValueError, "Point3f takes three"),
                (lambda: box.expand("x"), TypeError, "other takes three numbers"),
                (lambda: box.expand([1, 2]), TypeError, "other takes three numbers"),
                (lambda: box.expand(None), TypeError, "other takes three numbers")):
            with self.assertRaisesRegex(kind, text) as raised:
                wrong()
            self.assertNotIn("\n", str(raised.exception))


class Scenes(unittest.TestCase):
    def test_cornell_box_and_its_objects(self):
        scene = mi.load_dict(small_box())
        self.assertEqual([one.id() for one in scene.sensors()], ["sensor"])
        self.assertEqual([one.id() for one in scene.shapes()],
                         ["light", "floor", "ceiling", "back", "green-wall", "red-wall", "small-box",
                          "large-box"])
        self.assertEqual([one.plugin for one in scene.emitters()], ["area"])
        self.assertEqual(scene.integrator().plugin, "path")
        self.assertIsNone(scene.environment())
        np.testing.assert_allclose(scene.bbox().min, [-1, -1.01, -1], atol=1e-6)
        np.testing.assert_allclose(scene.bbox().max, [1, 1, 1], atol=1e-6)
        light, wall = scene.shapes()[0], scene.shapes()[4]
        self.assertTrue(light.is_emitter())
        self.assertFalse(wall.is_emitter())
        self.assertEqual(wall.bsdf().id(), "green")
        np.testing.assert_allclose(wall.bbox().extents(), [0, 2, 2], atol=1e-6)
        film = scene.sensors()[0].film()
        self.assertEqual(film.size().tolist(), [16, 16])
        self.assertEqual(film.rfilter().plugin, "gaussian")
        lit = mi.render(scene, spp=64).rgb.mean(axis=(0, 1))
        # Means of Mitsuba 3.9.1. The standard errors of this image are 3 % to 4 %.
        np.testing.assert_allclose(lit, [0.2402, 0.1412, 0.0600], rtol=0.25)

    def test_texts(self):
        scene = mi.load_dict(small_box())
        text = repr(scene)
        for line in ("Scene[\n", "integrator = path[max_depth=8]", "green-wall: rectangle[",
                     "light.emitter: area[radiance=[18.387, 13.9873, 6.75357]]"):
            self.assertIn(line, text)
        self.assertIn("film=hdrfilm[\n", repr(scene.sensors()[0]))
        self.assertEqual(repr(mi.load_dict({"type": "diffuse", "reflectance": 0.25})),
                         "diffuse[\n  reflectance=0.25,\n]")
        many = {f"s{i}": {"type": "sphere"} for i in range(30)}
        self.assertIn("and 10 more", repr(mi.load_dict({"type": "scene", **many})))

    def test_sensors_of_other_scenes(self):
        """A sensor that was loaded alone gives the image of the same sensor in the scene."""
        scene = mi.load_dict(small_box())
        expected = mi.render(scene)
        camera = mi.load_dict(small_box()["sensor"])
        for sensor in (camera, small_box()["sensor"], scene.sensors()[0], "sensor", 0,
                       mi.load_dict(small_box()).sensors()[0]):
            np.testing.assert_array_equal(mi.render(scene, sensor=sensor), expected)
        camera.parameters().update({"film.size": [8, 4], "x_fov": 20.0})
        self.assertEqual(mi.render(scene, sensor=camera).shape, (4, 8, 3))
        self.assertEqual(mi.load_dict({"type": "perspective"}).film().size().tolist(), [768, 576])
        # This sensor depends on the bounds of the scene.
        distant = {"type": "distant", "direction": [0, 0, -1],
                   "film": {"type": "hdrfilm", "width": 1, "height": 1,
                            "rfilter": {"type": "box"}}}
        np.testing.assert_array_equal(
            mi.render(mi.load_dict(small_box(sensor=distant)), spp=4),
            mi.render(scene, sensor=mi.load_dict(distant), spp=4))
        meter = mi.load_dict({"type": "irradiancemeter"})
        with self.assertRaisesRegex(mi.Error, "must be part of the rendered scene"):
            mi.render(scene, sensor=meter)
        with self.assertRaisesRegex(TypeError, "^sensor takes"):
            mi.render(scene, sensor=scene.shapes()[0])

    def test_integrators_alone(self):
        scene = mi.load_dict(small_box())
        direct = {"type": "path", "max_depth": 2}
        np.testing.assert_array_equal(mi.render(scene, integrator=mi.load_dict(direct)),
                                      mi.render(scene, integrator=direct))
        np.testing.assert_array_equal(mi.render(scene, integrator=scene.integrator()),
                                      mi.render(scene))


class Alone(unittest.TestCase):
    def test_every_category(self):
        for description in (
                {"type": "diffuse"}, {"type": "twosided", "nested": {"type": "conductor"}},
                {"type": "checkerboard"}, {"type": "sphere"}, {"type": "cube"}, {"type": "point"},
                {"type": "area"}, {"type": "constant"}, {"type": "perspective"},
                {"type": "irradiancemeter"}, {"type": "hdrfilm"}, {"type": "independent"},
                {"type": "gaussian"}, {"type": "path"}, {"type": "homogeneous"}, {"type": "hg"},
                {"type": "constvolume", "value": 0.5}):
            with self.subTest(description["type"]):
                one = mi.load_dict(description)
                self.assertEqual(one.plugin, description["type"])
                self.assertTrue(repr(one).startswith(description["type"]))
                self.assertLessEqual(description.items(), one.as_dict().items())
                self.assertGreaterEqual(len(mi.traverse(one)), 0)
        with self.assertRaisesRegex(mi.Error, r"^bsdf\.alhpa: .*did you mean 'alpha'"):
            mi.load_dict({"type": "roughconductor", "alhpa": 0.1})
        with self.assertRaisesRegex(mi.Error, r"^shape\.bsdf\.reflectance: "):
            mi.load_dict({"type": "sphere", "bsdf": {"type": "diffuse", "reflectance": 2}})
        with self.assertRaisesRegex(mi.Error, "no plugin 'difuse'"):
            mi.load_dict({"type": "difuse"})

    def test_parts_of_other_dicts(self):
        """Objects can be shared by dicts, as values of any parameter."""
        red = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.6, 0.2, 0.1]}}
        ball = {"type": "sphere", "radius": 0.3}
        expected = mi.render(mi.load_dict(small_box(ball={**ball, "bsdf": red})))
        bsdf = mi.load_dict(red)
        np.testing.assert_array_equal(
            mi.render(mi.load_dict(small_box(ball={**ball, "bsdf": bsdf}))), expected)
        shape = mi.load_dict({**ball, "bsdf": bsdf})
        np.testing.assert_array_equal(mi.render(mi.load_dict(small_box(ball=shape))), expected)
        with self.assertRaisesRegex(ValueError, "belongs to a scene"):
            mi.load_dict(small_box(ball=mi.load_dict(small_box()).shapes()[0]))

    def test_edits_are_parts_of_the_dict(self):
        shape = mi.load_dict({"type": "sphere", "bsdf": {
            "type": "twosided", "nested": {"type": "diffuse", "reflectance": 0.5}}})
        parameters = mi.traverse(shape)
        parameters["bsdf.bsdf.reflectance.value"] = [0.1, 0.2, 0.3]
        parameters["radius"] = 0.25
        self.assertEqual(shape.as_dict()["bsdf"]["nested"]["reflectance"], 0.5)
        parameters.update()
        self.assertEqual(shape.as_dict()["bsdf"]["nested"]["reflectance"], [0.1, 0.2, 0.3])
        self.assertEqual(shape.as_dict()["radius"], 0.25)
        in_scene = mi.traverse(mi.load_dict(small_box(ball=shape)))
        np.testing.assert_allclose(in_scene["ball.bsdf.bsdf.reflectance"], [0.1, 0.2, 0.3])
        parameters.unset("radius")
        parameters.update()
        self.assertNotIn("radius", shape.as_dict())
        parameters.revert("bsdf.bsdf.reflectance.value")
        parameters.update()
        self.assertEqual(shape.as_dict()["bsdf"]["nested"]["reflectance"], 0.5)
        self.assertNotIn("radius", shape.as_dict())


class Names(unittest.TestCase):
    """Names of parameters as in Mitsuba's traverse()."""

    def test_film(self):
        scene = mi.load_dict(small_box())
        parameters = mi.traverse(scene)
        self.assertEqual(parameters["sensor.film.size"].tolist(), [16, 16])
        self.assertEqual(parameters["sensor.film.crop_size"].tolist(), [16, 16])
        self.assertEqual(parameters["sensor.film.crop_offset"].tolist(), [0, 0])
        self.assertIn("sensor.film.size", parameters)
        whole = mi.render(scene)
        parameters.update({"sensor.film.crop_size": [5, 4], "sensor.film.crop_offset": [3, 2]})
        self.assertEqual(parameters["sensor.film.crop_width"], 5)
        self.assertEqual(parameters["sensor.film.crop_offset"].tolist(), [3, 2])
        np.testing.assert_allclose(mi.render(scene).shape, (4, 5, 3))
        self.assertEqual(whole.shape, (16, 16, 3))
        parameters["sensor.film.size"] = [32, 24]
        parameters.update()
        self.assertEqual(parameters["sensor.film.width"], 32)
        for wrong in (3, [1, 2, 3], [1.5, 2], "x"):
            with self.assertRaises((TypeError, ValueError)):
                parameters["sensor.film.size"] = wrong

    def test_field_of_view(self):
        """x_fov is the horizontal angle for each way to give it. Compares its image with `fov`."""
        def camera(width, height, **angle):
            return {"type": "perspective", **angle, "to_world": T.look_at([0, 0, 4], [0] * 3, [0, 1, 0]),
                    "film": {"type": "hdrfilm", "width": width, "height": height}}
        for width, height in ((12, 6), (6, 12)):
            for angle in ({"fov": 40, "fov_axis": "x"}, {"fov": 40, "fov_axis": "y"},
                          {"fov": 40, "fov_axis": "diagonal"}, {"fov": 40, "fov_axis": "smaller"},
                          {"fov": 40, "fov_axis": "larger"}, {"focal_length": "35mm"}, {}):
                with self.subTest(width=width, **angle):
                    scene = mi.load_dict(small_box(sensor=camera(width, height, **angle)))
                    before, parameters = mi.render(scene, spp=1), mi.traverse(scene)
                    angle_x = parameters["sensor.x_fov"]
                    parameters["sensor.x_fov"] = angle_x
                    parameters.update()
                    np.testing.assert_allclose(mi.render(scene, spp=1), before, rtol=0, atol=0.05)
                    self.assertAlmostEqual(parameters["sensor.x_fov"], angle_x, 4)

    def test_vertices_of_rectangles_and_cubes(self):
        scene = mi.load_dict(small_box())
        before, parameters = mi.render(scene), mi.traverse(scene)
        self.assertEqual(parameters["large-box.vertex_positions"].size, 72)
        corners = parameters["floor.vertex_positions"].reshape(-1, 3)
        self.assertEqual(corners.shape, (4, 3))
        np.testing.assert_allclose(corners[:, 1], -1, atol=1e-6)
        # The same vertices give the same image, up to rounding.
        parameters.update({"floor.vertex_positions": corners, "light.vertex_positions":
                           parameters["light.vertex_positions"]})
        same = mi.render(scene, spp=256)
        self.assertLess(abs(same.mean() / mi.render(mi.load_dict(small_box()), spp=256).mean() - 1),
                        0.02)
        # A bent floor is no rectangle.
        corners[0] += [0, 0.5, 0]
        parameters.update({"floor.vertex_positions": corners})
        self.assertFalse(np.array_equal(mi.render(scene), before))
        np.testing.assert_allclose(scene.shapes()[1].bbox().max[1], -0.5, atol=1e-6)

    def test_an_edited_rectangle_is_the_mesh_of_its_vertices(self):
        """A light that is no rectangle any more is hit, sampled and saved as a mesh."""
        scene = mi.load_dict(small_box())
        parameters = mi.traverse(scene)
        corners = parameters["light.vertex_positions"].reshape(-1, 3)
        corners[0] += [-0.5, -0.1, 0.4]
        parameters.update({"light.vertex_positions": corners})
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "saved.xml")
            parameters.save(path)
            saved = mi.load_file(path)
            self.assertEqual(saved.shapes()[0].plugin, "ply")
            for integrator in ("path", "clustered", "ptracer"):
                np.testing.assert_array_equal(mi.render(scene, integrator=integrator),
                                              mi.render(saved, integrator=integrator))
        # Light from hits alone has the same mean as that of sampled points of the light.
        direct = {"type": "direct", "emitter_samples": 0, "bsdf_samples": 1}
        sampled = {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0}
        hits, points = (mi.render(scene, integrator=one, spp=n, variance=16)
                        for one, n in ((direct, 1024), (sampled, 256)))
        difference = hits.rgb.mean() - points.rgb.mean()
        error = np.sqrt(sum(np.sum(one["variance"]) for one in (hits, points))) / hits.rgb.size
        # False alarms: one in 10^6.
        self.assertLess(abs(difference), 5 * error)

    def test_nested_objects_and_shutters(self):
        bsdf = mi.load_dict({"type": "mask", "opacity": 0.5, "any": {"type": "twosided", "other": {
            "type": "diffuse"}}})
        parameters = mi.traverse(bsdf)
        parameters.update({"nested_bsdf.brdf_0.reflectance.value": mi.Color3f(0.1, 0.2, 0.3)})
        np.testing.assert_allclose(parameters["bsdf.bsdf.reflectance"], [0.1, 0.2, 0.3])
        self.assertEqual(bsdf.as_dict()["any"]["other"]["reflectance"].tolist(), [0.1, 0.2, 0.3])
        camera = mi.traverse(mi.load_dict({"type": "perspective", "shutter_open": 1.0,
                                           "shutter_close": 1.5}))
        self.assertEqual(camera["shutter_open_time"], 0.5)
        camera.update({"shutter_open_time": 2.0})
        self.assertEqual(camera["shutter_close"], 3)

    def test_keep(self):
        parameters = mi.traverse(mi.load_dict(small_box()))
        parameters.keep(["red.reflectance.value", r".*wall\.to_world"])
        self.assertEqual(set(parameters), {"red.reflectance.value", "green-wall.to_world",
                                           "red-wall.to_world"})
        parameters.keep(None)
        self.assertGreater(len(parameters), 50)
        with self.assertRaisesRegex(ValueError, r"keys takes paths or regular expressions, got \['\('\]"):
            parameters.keep("(")


class Variants(unittest.TestCase):
    def test_rgb_only(self):
        mi.set_variant("llvm_ad_spectral", "llvm_ad_rgb")
        self.assertEqual(mi.variant(), "llvm_ad_rgb")
        with self.assertRaisesRegex(ValueError, "renders in RGB"):
            mi.set_variant("scalar_spectral")


if __name__ == "__main__":
    unittest.main()
