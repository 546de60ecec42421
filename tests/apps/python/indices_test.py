#!/usr/bin/python3
"""Tests of indices of refraction in the Python module: relative ones of dielectrics, and eta and k of
conductors. KINOME_BUILD is the build folder.
"""
import os
import pathlib
import sys
import unittest

import numpy as np

BUILD = pathlib.Path(os.environ["KINOME_BUILD"])
sys.path.insert(0, str(BUILD / "python"))
import kinome as mi  # noqa: E402


class Indices(unittest.TestCase):
    def test_eta_is_that_of_int_ior_and_ext_ior(self):
        glass = mi.load_dict({"type": "dielectric", "int_ior": 1.5, "ext_ior": "vacuum"})
        parameters = mi.traverse(glass)
        self.assertAlmostEqual(parameters["eta"], 1.5, 6)
        parameters["eta"] = 1.25
        parameters.update()
        self.assertEqual((parameters["int_ior"], parameters["ext_ior"]), (1.25, 1))
        self.assertEqual(glass.as_dict()["int_ior"], 1.25)
        self.assertNotIn("eta", list(parameters))
        self.assertAlmostEqual(mi.traverse(mi.load_dict({"type": "dielectric"}))["eta"],
                               1.5046 / 1.000277, 5)
        with self.assertRaisesRegex(mi.Error, "int_ior or ext_ior is a name"):
            mi.traverse(mi.load_dict({"type": "plastic", "int_ior": "water"}))["eta"]


class Metals(unittest.TestCase):
    """eta and k of a conductor with a material are the material's, and setting them replaces it."""
    GOLD = ([0.143036, 0.375307, 1.44205], [3.983, 2.38556, 1.60336])
    PATHS = ("rough.eta.value", "rough.k.value")

    def setUp(self):
        self.scene = mi.load_dict({
            "type": "scene", "rough": {"type": "roughconductor", "material": "Au", "alpha": 0.3},
            "ball": {"type": "sphere", "bsdf": {"type": "ref", "id": "rough"}}})
        self.parameters = mi.traverse(self.scene)

    def assert_index(self, eta, k):
        for path, expected in zip(self.PATHS, (eta, k)):
            for name in (path, path.removesuffix(".value")):
                np.testing.assert_allclose(self.parameters[name], expected, rtol=1e-6)
            row = next(row for row in self.parameters.parameters() if row.path == path)
            np.testing.assert_allclose(row.value, expected, rtol=1e-6)
        other = mi.load_dict({"type": "roughconductor", "alpha": 0.3, "eta": self.color(eta),
                              "k": self.color(k)})
        si, ctx = mi.SurfaceInteraction3f(), mi.BSDFContext()
        si.wi = [0.6, 0, 0.8]
        np.testing.assert_array_equal(self.scene.shapes()[0].bsdf().eval(ctx, si, [-0.5, 0, 0.8]),
                                      other.eval(ctx, si, [-0.5, 0, 0.8]))

    @staticmethod
    def color(value):
        return {"type": "rgb", "value": value}

    def test_reading(self):
        self.assert_index(*self.GOLD)
        self.parameters.update({"rough.material": "Ag"})
        self.assert_index([0.155276, 0.116728, 0.138388], [4.82835, 3.12222, 2.1469])
        self.parameters.update({"rough.material": "none"})
        self.assert_index(0, 1)

    def test_all_values_can_be_passed_back(self):
        self.parameters.update({**self.parameters, "rough.material": "Cr"})
        self.assertEqual(self.parameters["rough.material"], "Cr")
        before = self.parameters["rough.k"]
        self.parameters.update({**self.parameters})
        self.assertEqual(self.parameters["rough.material"], "Cr")
        np.testing.assert_array_equal(self.parameters["rough.k"], before)

    def test_setting_one_keeps_the_other(self):
        self.parameters["rough.eta.value"] = [0.2, 0.9, 1.1]
        self.assertIn("bsdf/roughconductor", self.parameters.update().made)
        self.assert_index([0.2, 0.9, 1.1], self.GOLD[1])
        self.assertEqual(self.parameters["rough.material"], "none")
        self.parameters.update({"rough.k": 2.5})
        self.assert_index([0.2, 0.9, 1.1], 2.5)

    def test_setting_both(self):
        self.parameters.update({"rough.eta.value": [1, 2, 3], "rough.k": [4, 5, 6]})
        self.assert_index([1, 2, 3], [4, 5, 6])

    def test_material_replaces_both(self):
        silver = [0.155276, 0.116728, 0.138388], [4.82835, 3.12222, 2.1469]
        gold = mi.traverse(mi.load_dict({"type": "conductor", "material": "Au"}))
        for texture in (None, {"type": "checkerboard"}):
            self.parameters.update({"rough.eta": [1, 2, 3]})
            if texture:
                self.parameters.update({"rough.k": texture})
            self.parameters.update({"rough.material": "Ag"})
            self.assert_index(*silver)
            self.parameters["rough.k"] = 2
            self.parameters["rough.material"] = "Au"
            self.parameters.update()
            self.assert_index(*self.GOLD)
        self.parameters.update({"rough.eta": [1, 2, 3]})
        self.parameters.update({**self.parameters, "rough.material": "Ag"})
        self.assert_index(*silver)
        alone = mi.load_dict({"type": "conductor", "eta": 0.2, "k": 3.})
        mi.traverse(alone).update({"material": "Au"})
        self.assertEqual([name for name in alone.as_dict() if name in ("eta", "k", "material")], ["material"])
        found = mi.traverse(mi.load_dict({"type": "scene", "ball": {"type": "sphere", "bsdf": alone}}))
        np.testing.assert_array_equal(found["ball.bsdf.eta"], gold["eta"])

    def test_contradictions_are_errors(self):
        self.parameters.update({"rough.eta": [1, 2, 3], "rough.k": 4})
        with self.assertRaisesRegex(mi.Error, "'Gold'"):
            self.parameters["rough.material"] = "Gold"
            self.parameters.update()
        self.assert_index([1, 2, 3], 4)
        with self.assertRaisesRegex(mi.Error, "'material'"):
            self.parameters.update({"rough.material": "Au", "rough.eta": [3, 2, 1]})
        self.assert_index([1, 2, 3], 4)

    def test_indices_that_are_not_finite(self):
        for value in (float("nan"), float("inf")):
            with self.assertRaisesRegex(mi.Error, "'eta' must be finite"):
                mi.load_dict({"type": "conductor", "eta": self.color([value, 1, 1]), "k": 1.})

    def test_conductors_alone(self):
        metal = mi.load_dict({"type": "conductor", "material": "Cu"})
        parameters = mi.traverse(metal)
        parameters["k.value"] = [1, 2, 3]
        parameters.update()
        scene = mi.load_dict({"type": "scene", "ball": {"type": "sphere", "bsdf": metal}})
        found = mi.traverse(scene)
        np.testing.assert_allclose(found["ball.bsdf.eta.value"], [0.201005, 0.92375, 1.10222], 1e-6)
        np.testing.assert_allclose(found["ball.bsdf.k.value"], [1, 2, 3])


if __name__ == "__main__":
    unittest.main()
