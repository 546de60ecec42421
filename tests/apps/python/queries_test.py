#!/usr/bin/python3
"""Tests of ray queries in the Python module, and of the arguments of all queries.

KINOME_BUILD is the build folder.
"""
import contextlib
import os
import pathlib
import sys
import threading
import time
import unittest

import numpy as np

BUILD = pathlib.Path(os.environ["KINOME_BUILD"])
sys.path.insert(0, str(BUILD / "python"))
import kinome as mi  # noqa: E402
from query_points import CTX, SUN, interaction, scene_of  # noqa: E402


class Rays(unittest.TestCase):
    def setUp(self):
        self.scene = scene_of(
            ball={"type": "sphere", "radius": 2, "bsdf": {"type": "diffuse", "id": "white"}},
            floor={"type": "rectangle", "to_world": mi.Transform().translate([0, 0, -5]).scale(100)})

    def test_single_ray(self):
        si = self.scene.ray_intersect(mi.Ray3f([0, 0, 10], [0, 0, -2]))
        self.assertTrue(si.is_valid())
        self.assertAlmostEqual(si.t, 4, 5)
        np.testing.assert_allclose(si.p, [0, 0, 2], atol=1e-6)
        np.testing.assert_allclose(si.n, [0, 0, 1], atol=1e-6)
        np.testing.assert_allclose(si.sh_frame.n, [0, 0, 1], atol=1e-6)
        np.testing.assert_allclose(si.wi, [0, 0, 1], atol=1e-6)
        self.assertEqual(si.shape.id(), "ball")
        self.assertEqual(si.shape.bsdf().id(), "white")
        self.assertIsInstance(si.p, mi.Point3f)
        missed = self.scene.ray_intersect(mi.Ray3f([0, 0, 10], [0, 0, 1]))
        self.assertFalse(missed.is_valid())
        self.assertEqual(missed.t, np.inf)
        self.assertIsNone(missed.shape)
        np.testing.assert_allclose(missed.wi, [0, 0, -1])

    def test_arrays_give_the_bits_of_single_rays(self):
        """Also in several blocks, whose rays hit both shapes and nothing."""
        random = np.random.default_rng(1)
        o, d = random.normal(size=(5000, 3)) * 4, random.normal(size=(5000, 3))
        all_rays = self.scene.ray_intersect(mi.Ray3f(o, d))
        self.assertEqual(all_rays.t.shape, (5000,))
        self.assertEqual(all_rays.uv.shape, (5000, 2))
        ids = [None if one is None else one.id() for one in all_rays.shape]
        self.assertEqual({*ids}, {"ball", "floor", None})
        for i in (0, 17, 2047, 2048, 4999):
            one = self.scene.ray_intersect(mi.Ray3f(o[i], d[i]))
            self.assertEqual(one.t, all_rays.t[i])
            self.assertEqual(one.p.tolist(), all_rays.p[i].tolist())
            self.assertEqual(one.uv.tolist(), all_rays.uv[i].tolist())
            self.assertEqual(one.shape and one.shape.id(), ids[i])
        hit = all_rays.is_valid()
        np.testing.assert_allclose(mi.Ray3f(o, d)(np.where(hit, all_rays.t, 0))[hit],
                                   all_rays.p[hit], atol=2e-4)
        np.testing.assert_array_equal(self.scene.ray_test(mi.Ray3f(o, d)), hit)
        np.testing.assert_allclose(all_rays.to_world(all_rays.wi)[hit],
                                   (-d / np.linalg.norm(d, axis=1)[:, None])[hit], atol=1e-5)

    def test_samples_have_a_readable_repr(self):
        scene = scene_of(lamp={"type": "point", "position": [0, 0, 5]}, ball={"type": "sphere"})
        si = scene.ray_intersect(mi.Ray3f([0, 0, 10], [0, 0, -1]))
        sample, _ = si.bsdf().sample(CTX, si, 0.5, [0.5, 0.5])
        self.assertRegex(repr(sample), r"^BSDFSample3f\[wo=\[.*\], pdf=0.\d+, eta=1\]$")
        self.assertEqual(repr(CTX), "BSDFContext[type_mask=<BSDFFlags.All: 127>]")
        toward, _ = scene.sample_emitter_direction(si, [0.5, 0.5])
        self.assertRegex(repr(toward), r"^DirectionSample3f\[d=.*, p=\[0.0, 0.0, 5.0\], dist=4, pdf=1\]$")
        many = scene.ray_intersect(mi.Ray3f(np.full((3, 3), [0, 0, 10]), [0, 0, -1]))
        self.assertEqual(repr(many.bsdf().sample(CTX, many, [0.5] * 3, np.full((3, 2), 0.5))[0]),
                         "BSDFSample3f[3 samples]")
        self.assertEqual(repr(scene.sample_emitter_direction(many, np.full((3, 2), 0.5))[0]),
                         "DirectionSample3f[3 directions]")

    def test_range_and_mask(self):
        ray = mi.Ray3f([0, 0, 10], [0, 0, -1], maxt=[7.9, 8.1, np.inf])
        np.testing.assert_array_equal(self.scene.ray_test(ray), [False, True, True])
        active = np.array([True, False, True])
        np.testing.assert_array_equal(self.scene.ray_test(ray, active), [False, False, True])
        np.testing.assert_array_equal(self.scene.ray_intersect(ray, active).is_valid(),
                                      [False, False, True])
        self.assertIs(self.scene.ray_test(mi.Ray3f([0, 0, 10], [0, 0, -1])), True)
        np.testing.assert_array_equal(self.scene.ray_test(ray, True, active=active),
                                      [False, False, True])
        empty = self.scene.ray_intersect(mi.Ray3f(np.zeros((0, 3)), [0, 0, 1]))
        self.assertEqual(empty.p.shape, (0, 3))

    def test_points_know_their_shapes_after_updates(self):
        """Also after several updates, while some of the points are in use."""
        parameters = mi.traverse(self.scene)
        rays = mi.Ray3f([[0, 0, 10], [30, 0, 10], [0, 0, -9]], [0, 0, -1])
        found = []
        for radius in (2.5, 3., 3.5):
            found.append(self.scene.ray_intersect(rays))
            parameters.update({"ball.radius": radius, "ball.bsdf.reflectance": radius / 10})
            for si in found:
                self.assertEqual([one and one.id() for one in si.shape], ["ball", "floor", None])
                self.assertIn("ball", repr(si.shape[0].id()))
        np.testing.assert_allclose([si.t[0] for si in found], [8, 7.5, 7], atol=1e-5)

    def test_queries_and_updates_of_several_threads(self):
        """An update during a query is refused, or the query. The message fits all of them."""
        rays, done = mi.Ray3f(np.zeros((200000, 3)), [0, 0, -1]), threading.Event()

        def query():
            while not done.is_set():
                with contextlib.suppress(mi.Error):
                    self.scene.ray_test(rays)
        thread = threading.Thread(target=query)
        thread.start()
        try:
            with self.assertRaisesRegex(mi.Error, "this scene is in use: it is being rendered, updated "
                                                  "or queried"):
                end = time.monotonic() + 60
                while time.monotonic() < end:
                    # Queries can begin only between updates, and take longer than this.
                    time.sleep(0.001)
                    mi.traverse(self.scene).update()
        finally:
            done.set()
            thread.join()

    def test_rays_leave_surfaces(self):
        si = self.scene.ray_intersect(mi.Ray3f([[0.1, 0.2, 10], [1, 0, 10]], [0, 0, -1]))
        away = si.spawn_ray(si.n)
        self.assertFalse(self.scene.ray_test(away).any())
        self.assertFalse(self.scene.ray_test(mi.Ray3f([0, 0, 10], [0, 0, -1], maxt=-np.inf)))
        through = self.scene.ray_intersect(si.spawn_ray([0, 0, -1]))
        np.testing.assert_allclose(through.p[:, 2], -si.p[:, 2], atol=1e-4)
        to = si.spawn_ray_to([50, 0, -5])
        self.assertFalse(self.scene.ray_test(to)[1])
        np.testing.assert_allclose(to(to.maxt), [[50, 0, -5]] * 2, atol=0.02)

    def test_sensor(self):
        view = mi.Transform().look_at([1, 2, 10], [1, 2, 0], [0, 1, 0])
        sensor = mi.load_dict({"type": "perspective", "fov": 90, "near_clip": 0.5, "far_clip": 100,
                               "to_world": view, "film": {"type": "hdrfilm", "width": 64, "height": 64}})
        ray, weight = sensor.sample_ray(0, 0, [0.5, 0.5], [0.5, 0.5])
        np.testing.assert_allclose(ray.o, [1, 2, 9.5], atol=1e-6)
        np.testing.assert_allclose(ray.d, [0, 0, -1], atol=1e-6)
        self.assertAlmostEqual(ray.maxt, 99.5, 4)
        self.assertEqual(weight.tolist(), [1, 1, 1])
        ray, _ = sensor.sample_ray(0, 0, [[0, 0.5], [0.5, 1]])
        np.testing.assert_allclose(ray.d, np.array([[-1, 0, -1], [0, -1, -1]]) / np.sqrt(2), atol=1e-6)

    def test_errors(self):
        for wrong, kind, text in (
                (lambda: mi.Ray3f([1, 2], [0, 0, 1]), ValueError,
                 r"o takes three numbers or .* \(n, 3\), got the shape \(2,\)"),
                (lambda: mi.Ray3f(np.zeros((3, 4)), [0, 0, 1]), ValueError, "of the shape"),
                (lambda: mi.Ray3f(None), TypeError, "o takes three numbers"),
                (lambda: mi.Ray3f(np.zeros((3, 3)), np.zeros((2, 3))), ValueError, "2 rows"),
                (lambda: self.scene.ray_intersect([0, 0, 1]), TypeError, "ray takes a Ray3f"),
                (lambda: self.scene.ray_test(mi.Ray3f(), active=1), TypeError, "active takes"),
                (lambda: self.scene.ray_test(mi.Ray3f(), True, False, True), TypeError, "more arguments"),
                (lambda: self.scene.ray_test(mi.Ray3f(), True, False, active=True), TypeError,
                 "more arguments"),
                (lambda: self.scene.ray_test(mi.Ray3f(), hidden=1), TypeError, "hidden"),
                (lambda: self.scene.ray_intersect(mi.Ray3f(), 0, "no"), TypeError, "coherent takes"),
                (lambda: self.scene.shapes()[0].eval(CTX, interaction(SUN), SUN), TypeError,
                 "only bsdfs and emitters have eval"),
                (lambda: self.scene.shapes()[0].sample_ray(), TypeError, "only sensors have sample_ray"),
                (lambda: mi.SurfaceInteraction3f().bsdf(), ValueError, "on no shape")):
            with self.assertRaisesRegex(kind, text) as raised:
                wrong()
            self.assertNotIn("\n", str(raised.exception))

    def test_masks(self):
        """A wrong mask of each function is one line with the expected shape. Positional masks may
        have any of the forms that keywords may have."""
        rays = mi.Ray3f([[0, 0, 10]] * 3, [0, 0, -1])
        si = self.scene.ray_intersect(rays)
        bsdf, lamp = self.scene.shapes()[0].bsdf(), mi.load_dict({"type": "point"})
        sensor = mi.load_dict({"type": "perspective"})
        for call in (lambda active: self.scene.ray_intersect(rays, active),
                     lambda active: self.scene.ray_intersect(rays, active=active),
                     lambda active: self.scene.ray_test(rays, active),
                     lambda active: self.scene.ray_test(rays, True, active),
                     lambda active: bsdf.eval(CTX, si, [0, 0, 1], active),
                     lambda active: bsdf.pdf(CTX, si, [0, 0, 1], active),
                     lambda active: bsdf.sample(CTX, si, 0.5, [0.5, 0.5], active),
                     lambda active: bsdf.eval_diffuse_reflectance(si, active),
                     lambda active: lamp.eval(si, active),
                     lambda active: lamp.sample_direction(si, [0.5, 0.5], active),
                     lambda active: sensor.sample_ray(0, 0, np.zeros((3, 2)), active=active)):
            for wrong in ([True, False], np.ones(5, bool)):
                with self.assertRaisesRegex(ValueError, r"active takes a bool or an array of bools of "
                                                        r"the shape \(3,\), got the shape"):
                    call(wrong)
            for wrong in ("no", np.ones(3), np.ones((3, 1), bool)):
                with self.assertRaisesRegex(TypeError, "active takes a bool or an array"):
                    call(wrong)
            call([True, False, True])
        with self.assertRaisesRegex(ValueError, r"active takes a bool, got the shape \(2,\)"):
            self.scene.ray_test(mi.Ray3f(), np.ones(2, bool))
        self.assertEqual(self.scene.ray_test(rays, [True, False, True]).tolist(), [True, False, True])
        self.assertIs(self.scene.ray_test(mi.Ray3f([0, 0, 10], [0, 0, -1]), False), False)

    def test_numbers_that_are_not_finite(self):
        """Only in active rows."""
        nan, o = np.nan, np.array([[0, 0, 10], [0, np.nan, 10]])
        si = self.scene.ray_intersect(mi.Ray3f([0, 0, 10], [0, 0, -1]))
        bsdf, lit = self.scene.shapes()[0].bsdf(), scene_of(lamp={"type": "point"})
        sensor, odd = mi.load_dict({"type": "perspective"}), interaction([0, nan, 1])
        for wrong, text in (
                (lambda: self.scene.ray_intersect(mi.Ray3f(o, [0, 0, -1])),
                 r"o takes finite numbers, got \[0.0, nan, 10.0\] in row 1"),
                (lambda: self.scene.ray_test(mi.Ray3f([0, 0, 0], [np.inf, 0, 0])), "d takes finite"),
                (lambda: self.scene.ray_test(mi.Ray3f(maxt=nan)), "maxt takes numbers, but not NaN"),
                (lambda: bsdf.eval(CTX, si, [0, nan, 1]), "wo takes finite numbers"),
                (lambda: bsdf.pdf(CTX, odd, [0, 0, 1]), "wi takes finite numbers"),
                (lambda: bsdf.sample(CTX, si, nan, [0, 0]), "sample1 takes random numbers from 0 to 1"),
                (lambda: bsdf.sample(CTX, si, 0, [0, 1.5]), "sample2 takes random numbers from 0 to 1"),
                (lambda: lit.sample_emitter_direction(si, [nan, 0]), "sample takes random numbers"),
                (lambda: lit.sample_emitter_direction(si, [-1, 0]), "sample takes random numbers"),
                (lambda: lit.emitters()[0].sample_direction(si, [2, 0]), "sample takes random numbers"),
                (lambda: sensor.sample_ray(0, 0, [nan, 0]), "sample2 takes finite numbers"),
                (lambda: sensor.sample_ray(0, 0, [[0, 0], [0, 3e38]]),
                 r"sample2 takes positions that the sensor can see, .* got \[0.0, 3.*e\+38\] in row 1")):
            with self.assertRaisesRegex(ValueError, text) as raised:
                wrong()
            self.assertNotIn("\n", str(raised.exception))
        rays = mi.Ray3f(o, [0, 0, -1])
        self.assertEqual(self.scene.ray_test(rays, [True, False]).tolist(), [True, False])
        si = self.scene.ray_intersect(rays, [True, False])
        _, weight = lit.sample_emitter_direction(si, [[0.5, 0.5], [nan, nan]], active=[True, False])
        self.assertTrue(np.isfinite(weight).all())
        ray, _ = sensor.sample_ray(0, 0, [[0, 0], [0, 3e38]], active=[True, False])
        self.assertTrue(np.isfinite(ray.d[0]).all())

    def test_directions_of_any_length(self):
        """Distances are in units of d. Without a result, they would be misses."""
        expected = self.scene.ray_intersect(mi.Ray3f([0.2, 0.1, 10], [0, 0, -1]))
        for length in 1e-25, 1e-10, 1e10, 1e19, 3e38:
            ray = mi.Ray3f([[0.2, 0.1, 10]] * 2, [0, 0, -length], maxt=[np.inf, 9 / length])
            si = self.scene.ray_intersect(ray)
            np.testing.assert_allclose(si.t[0] * length, expected.t, rtol=1e-5)
            np.testing.assert_allclose(si.p, [expected.p] * 2, rtol=1e-5)
            self.assertEqual(self.scene.ray_test(ray).tolist(), [True, True])
            short = mi.Ray3f([0.2, 0.1, 10], [0, 0, -length], maxt=7 / length)
            self.assertFalse(self.scene.ray_test(short))
        self.assertFalse(self.scene.ray_test(mi.Ray3f([0.2, 0.1, 10], [0, 0, 0])))

    def test_rays_beyond_the_range_of_the_tracer(self):
        far = [[0, 0, 10], [0, 0, 2e18]]
        for query in self.scene.ray_test, self.scene.ray_intersect:
            with self.assertRaisesRegex(ValueError, r"^o takes coordinates up to 1e\+18, the range of the ray "
                                        r"tracer, got \[0.0, 0.0, .*e\+18\] in row 1$"):
                query(mi.Ray3f(far, [0, 0, -1]))
        self.assertEqual(self.scene.ray_test(mi.Ray3f(far, [0, 0, -1]), [True, False]).tolist(), [True, False])
        small = scene_of(group={"type": "shapegroup", "ball": {"type": "sphere"}},
                         placed={"type": "instance", "group": {"type": "ref", "id": "group"},
                                 "to_world": mi.Transform().scale(1e-10)})
        self.assertTrue(small.ray_test(mi.Ray3f([0, 0, 1], [0, 0, -1])))
        with self.assertRaisesRegex(ValueError, r"o takes coordinates up to 1e\+08,"):
            small.ray_test(mi.Ray3f([0, 0, 1e9], [0, 0, -1]))

    def test_arguments_of_other_types(self):
        """They are one line, too, and name the argument."""
        si = self.scene.ray_intersect(mi.Ray3f([[0, 0, 10]] * 3, [0, 0, -1]))
        lamp, ds = mi.load_dict({"type": "point"}), mi.DirectionSample3f(self.scene, si, si)
        for wrong, kind, text in (
                (lambda: lamp.sample_direction(None, [0, 0]), TypeError, "it takes a SurfaceInteraction"),
                (lambda: lamp.pdf_direction(None, ds), TypeError, "it takes a SurfaceInteraction"),
                (lambda: lamp.eval_direction(None, ds), TypeError, "it takes a SurfaceInteraction"),
                (lambda: self.scene.pdf_emitter_direction(None, ds), TypeError, "ref takes a Surface"),
                (lambda: mi.DirectionSample3f(None, si, si), TypeError, "scene takes"),
                (lambda: mi.DirectionSample3f(self.scene, None, si), TypeError, "si takes"),
                (lambda: mi.DirectionSample3f(self.scene, si, None), TypeError, "ref takes"),
                (lambda: si.emitter(None), TypeError, "scene takes"),
                (lambda: si.to_local([0, 1]), ValueError, r"v takes three .* the shape \(2,\)"),
                (lambda: si.to_world(np.zeros((2, 3))), ValueError, "v has 2 rows, but the frame has 3"),
                (lambda: si.to_world("up"), TypeError, "v takes three numbers"),
                (lambda: mi.Ray3f([[0, 0, 0]] * 3)(np.zeros(2)), ValueError, "t has 2 rows"),
                (lambda: mi.Ray3f()("far"), TypeError, "t takes a number")):
            with self.assertRaisesRegex(kind, text) as raised:
                wrong()
            self.assertNotIn("\n", str(raised.exception))


if __name__ == "__main__":
    unittest.main()
