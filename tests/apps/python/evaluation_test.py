#!/usr/bin/python3
"""Tests of evaluating and sampling BSDFs and emitters in the Python module.

KINOME_BUILD is the build folder.
"""
import os
import pathlib
import sys
import unittest

import numpy as np

BUILD = pathlib.Path(os.environ["KINOME_BUILD"])
sys.path.insert(0, str(BUILD / "python"))
import kinome as mi  # noqa: E402
from query_points import CTX, SUN, interaction, scene_of  # noqa: E402
from small_box import small_box  # noqa: E402


class Bsdfs(unittest.TestCase):
    def test_diffuse(self):
        bsdf = mi.load_dict({"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.2, 0.4, 0.6]}})
        value = bsdf.eval(CTX, interaction(SUN), [0, 0.6, 0.8])
        np.testing.assert_allclose(value, np.array([0.2, 0.4, 0.6]) / np.pi * 0.8, rtol=1e-6)
        self.assertAlmostEqual(bsdf.pdf(CTX, interaction(SUN), [0, 0.6, 0.8]), 0.8 / np.pi, 6)
        wo = np.array([[0, 0, 1], [0, 0, -1], [0, 0.6, 0.8]])
        values, pdf = bsdf.eval_pdf(CTX, interaction(SUN), wo, np.array([True, True, False]))
        np.testing.assert_allclose(values[:, 0], [0.2 / np.pi, 0, 0], rtol=1e-6)
        np.testing.assert_allclose(pdf, [1 / np.pi, 0, 0], rtol=1e-6)
        np.testing.assert_allclose(bsdf.eval_diffuse_reflectance(interaction(SUN)), [0.2, 0.4, 0.6],
                                   rtol=1e-6)

    def test_samples_have_the_weight_of_value_and_density(self):
        random = np.random.default_rng(2)
        u1, u2 = random.random(4000, np.float32), random.random((4000, 2), np.float32)
        for bsdf in ({"type": "roughconductor", "alpha": 0.3}, {"type": "roughplastic"},
                     {"type": "roughdielectric", "alpha": 0.4}, {"type": "principled"}):
            bsdf = mi.load_dict(bsdf)
            sample, weight = bsdf.sample(CTX, interaction(SUN), u1, u2)
            value, pdf = bsdf.eval_pdf(CTX, interaction(SUN), sample.wo)
            drawn = sample.pdf > 1e-3
            np.testing.assert_allclose(pdf[drawn], sample.pdf[drawn], rtol=2e-3)
            np.testing.assert_allclose((value / np.maximum(pdf, 1e-9)[:, None])[drawn], weight[drawn],
                                       rtol=5e-3, atol=1e-5)
            self.assertTrue((sample.sampled_type[drawn] & int(mi.BSDFFlags.Smooth) != 0).all())

    def test_glass(self):
        bsdf = mi.load_dict({"type": "dielectric", "int_ior": 1.5, "ext_ior": 1})
        sample, weight = bsdf.sample(CTX, interaction([[0.6, 0, 0.8], [0.6, 0, -0.8]]), [0.999, 0.0],
                                     np.full((2, 2), 0.5))
        self.assertEqual(sample.sampled_type.tolist(),
                         [int(mi.BSDFFlags.DeltaTransmission), int(mi.BSDFFlags.DeltaReflection)])
        np.testing.assert_allclose(sample.wo[0], [-0.4, 0, -np.sqrt(1 - 0.16)], rtol=1e-5)
        np.testing.assert_allclose(sample.eta, [1.5, 1], rtol=1e-6)
        np.testing.assert_allclose(weight[0], [1 / 1.5 ** 2] * 3, rtol=1e-5)

    def test_kinds(self):
        bsdf = mi.load_dict({"type": "roughplastic", "diffuse_reflectance": 0.5, "alpha": 0.2})
        parts = [bsdf.eval(mi.BSDFContext(type_mask=mask), interaction([0, 0, 1]), [0, 0, 1])
                 for mask in (mi.BSDFFlags.Diffuse, mi.BSDFFlags.Glossy, mi.BSDFFlags.All)]
        np.testing.assert_allclose(parts[0] + parts[1], parts[2], rtol=1e-5)
        self.assertGreater(parts[1][0], 0.3 * parts[0][0])
        for kind, text, fields in (
                (ValueError, "type_mask takes a sum of", {"type_mask": mi.BSDFFlags.DiffuseReflection}),
                (TypeError, "type_mask takes a sum of", {"type_mask": "diffuse"}),
                (TypeError, "type_mask takes a sum of", {"type_mask": 6.}),
                (ValueError, "mode takes", {"mode": mi.TransportMode.Importance}),
                (ValueError, "component takes -1", {"component": 0})):
            edited = mi.BSDFContext()
            for name, value in fields.items():
                setattr(edited, name, value)
            for wrong in (mi.BSDFContext(**fields), edited):
                with self.assertRaisesRegex(kind, text):
                    bsdf.eval(wrong, interaction(SUN), SUN)
                with self.assertRaisesRegex(kind, text):
                    bsdf.sample(wrong, interaction(SUN), 0.5, [0.5, 0.5])
        with self.assertRaises(AttributeError):
            mi.BSDFContext().types = mi.BSDFFlags.Diffuse
        with self.assertRaisesRegex(TypeError, "ctx takes a BSDFContext"):
            bsdf.eval(None, interaction(SUN), SUN)

    def test_each_point_has_its_own_bsdf(self):
        scene = scene_of(
            a={"type": "sphere", "bsdf": {"type": "diffuse", "reflectance": 0.25}},
            b={"type": "sphere", "center": [5, 0, 0], "bsdf": {"type": "roughconductor", "alpha": 0.3}})
        si = scene.ray_intersect(mi.Ray3f([[0, 0, 9], [5, 0, 9], [0, 50, 9]], [0, 0, -1]))
        own = si.bsdf().eval(CTX, si, [0, 0, 1])
        for i, shape in enumerate(scene.shapes()):
            expected = shape.bsdf().eval(CTX, interaction([0, 0, 1]), [0, 0, 1])
            np.testing.assert_allclose(own[i], expected, rtol=1e-4)
        self.assertEqual(own[2].tolist(), [0, 0, 0])

    def test_textures_read_the_points(self):
        checks = {"type": "checkerboard", "color0": 0.1, "color1": 0.7}
        bsdf = mi.load_dict({"type": "diffuse", "reflectance": checks})
        si = interaction([0, 0, 1])
        si.uv = [[0.25, 0.25], [0.75, 0.25]]
        found = bsdf.eval_diffuse_reflectance(si)[:, 0]
        np.testing.assert_allclose(sorted(found), [0.1, 0.7], rtol=1e-5)
        painted = mi.load_dict({"type": "diffuse", "reflectance": {"type": "mesh_attribute",
                                                                   "name": "vertex_color"}})
        with self.assertRaisesRegex(mi.Error, "reads the mesh attribute 'vertex_color'"):
            painted.eval(CTX, interaction([0, 0, 1]), [0, 0, 1])


class Emitters(unittest.TestCase):
    def test_radiance(self):
        scene = scene_of(
            panel={"type": "rectangle", "emitter": {"type": "area", "radiance": 3.}},
            lamp={"type": "point", "position": [0, 0, 5], "intensity": 2.},
            sky={"type": "constant", "radiance": {"type": "rgb", "value": [1, 2, 4]}})
        si = scene.ray_intersect(mi.Ray3f([[0, 0, 1], [0, 0, -1], [5, 0, 1]],
                                          [[0, 0, -1], [0, 0, 1], [0, 0, -1]]))
        np.testing.assert_allclose(si.emitter(scene).eval(si), [[3, 3, 3], [0, 0, 0], [1, 2, 4]],
                                   rtol=1e-6)
        np.testing.assert_allclose(scene.environment().eval(si), [[1, 2, 4]] * 3, rtol=1e-6)
        lamp = next(one for one in scene.emitters() if one.plugin == "point")
        self.assertFalse(lamp.eval(si).any())
        ds, weight = lamp.sample_direction(si, [0.5, 0.5])
        self.assertTrue(ds.delta.all())
        np.testing.assert_allclose(ds.dist, np.linalg.norm(si.p - [0, 0, 5], axis=1), rtol=1e-6)
        np.testing.assert_allclose(weight[:, 0], 2 / ds.dist ** 2, rtol=1e-5)
        np.testing.assert_allclose(ds.p[:2], [[0, 0, 5]] * 2, atol=1e-5)

    def test_an_integrator_in_numpy(self):
        """Direct light by both kinds of samples, and that of the integrator `direct`. The differences
        are below 5 standard deviations, one false alarm in a million for each of the two."""
        scene = mi.load_dict(small_box(8, 64))
        random = np.random.default_rng(3)
        count = 8 * 8 * 64
        ray, _ = scene.sensors()[0].sample_ray(0, 0, random.random((count, 2)), [0.5, 0.5])
        si = scene.ray_intersect(ray)
        emitted = si.emitter(scene).eval(si)
        ds, weight = scene.sample_emitter_direction(si, random.random((count, 2)))
        by_emitter = emitted + weight * si.bsdf().eval(CTX, si, si.to_local(ds.d))
        bs, weight = si.bsdf().sample(CTX, si, random.random(count), random.random((count, 2)))
        hit = scene.ray_intersect(si.spawn_ray(si.to_world(bs.wo)))
        by_bsdf = emitted + weight * hit.emitter(scene).eval(hit)
        image = mi.render(scene, integrator="direct", spp=256, variance=16)
        expected = image.rgb.mean()
        of_render = np.sqrt(np.mean(image.stats["variance_of_mean"]))
        for estimate in (by_emitter, by_bsdf):
            values = np.asarray(estimate).mean(axis=1)
            error = np.hypot(values.std() / np.sqrt(count), of_render)
            self.assertLess(abs(values.mean() - expected), 5 * error)
        known = mi.DirectionSample3f(scene, hit, si)
        lit = np.asarray(hit.emitter(scene).eval(hit)).any(axis=1)
        np.testing.assert_allclose(scene.eval_emitter_direction(si, known)[lit],
                                   hit.emitter(scene).eval(hit)[lit], rtol=1e-5)
        # The light is a square of side 0.46 that faces down.
        cosine = np.abs(np.sum(np.asarray(hit.n) * np.asarray(known.d), axis=1))
        area = scene.shapes()[0].bbox().extents()
        density = known.dist[lit] ** 2 / cosine[lit] / np.prod(area[area > 1e-3])
        np.testing.assert_allclose(scene.pdf_emitter_direction(si, known)[lit], density, rtol=1e-3)


if __name__ == "__main__":
    unittest.main()
