#!/usr/bin/python3
"""Tests of kinome.denoise with the fake library of tests/apps/cli, which doubles colours.

KINOME_BUILD is the build folder. With KINOME_PACKAGE, the installed module is tested.
"""
import os
import pathlib
import sys
import unittest

import numpy as np

BUILD = pathlib.Path(os.environ["KINOME_BUILD"]).resolve()
os.environ["KINOME_OIDN"] = str(BUILD / "tests/apps/cli/fake_oidn")
if "KINOME_PACKAGE" not in os.environ:
    sys.path.insert(0, str(BUILD / "python"))
import kinome  # noqa: E402

AOV = {"type": "aov", "aovs": "albedo:guide_albedo,normal:guide_normal", "image": {"type": "path"}}
SCENE = {
    "type": "scene",
    "integrator": AOV,
    "sensor": {
        "type": "perspective",
        "to_world": kinome.Transform().look_at([0, 1, 6], [0, 0, 0], [0, 1, 0]),
        "sampler": {"type": "independent", "sample_count": 4},
        "film": {"type": "hdrfilm", "width": 16, "height": 12, "rfilter": {"type": "box"}},
    },
    "ball": {"type": "sphere"},
    "sky": {"type": "constant"},
}


class Denoise(unittest.TestCase):
    def setUp(self):
        self.scene = kinome.load_dict(SCENE)

    def test_the_colour_is_denoised_and_the_rest_remains(self):
        picture = kinome.render(self.scene)
        denoised = kinome.denoise(picture, threads=1)
        self.assertEqual(denoised.channels, picture.channels)
        np.testing.assert_array_equal(denoised.rgb, 2 * picture.rgb)
        np.testing.assert_array_equal(denoised["albedo"], picture["albedo"])
        self.assertEqual(denoised.stats, picture.stats)
        plain = kinome.Picture(np.ones((3, 4, 1), np.float32), ["Y"])
        np.testing.assert_allclose(kinome.denoise(plain), 2 * plain, rtol=1e-6)

    def test_a_variance_combines_it_with_the_noisy_colour(self):
        picture = kinome.render(self.scene, spp=256, variance=4)
        difference = np.abs(kinome.denoise(picture).rgb - picture.rgb).mean()
        self.assertLess(difference, 0.05 * picture.rgb.mean())
        unknown = np.full_like(picture.rgb, np.inf)
        np.testing.assert_array_equal(kinome.denoise(picture, variance=unknown).rgb,
                                      2 * picture.rgb)

    def test_arguments_are_checked(self):
        picture = kinome.render(self.scene)
        with self.assertRaisesRegex(ValueError, r"albedo takes an array of the shape \(12, 16, 3\)"):
            kinome.denoise(picture, albedo=np.zeros((3, 3)))
        with self.assertRaisesRegex(TypeError, "picture takes a Picture"):
            kinome.denoise(np.zeros((3, 3, 3)))


if __name__ == "__main__":
    unittest.main()
