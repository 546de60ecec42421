#!/usr/bin/python3
"""Tests of kinome.denoise with the fake library of tests/apps/cli, which doubles colours.

KINOME_BUILD is the build folder. With KINOME_PACKAGE, the installed module is tested.
"""
import os
import pathlib
import sys
import tempfile
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


# A scene file with the variables that validation/denoising.py sets.
SCENE_FILE = """<scene version="3.0.0">
    <default name="sampler" value="ldsampler"/>
    <default name="spp" value="16"/>
    <default name="width" value="16"/>
    <default name="height" value="12"/>
    <integrator type="clustered"/>
    <sensor type="perspective">
        <transform name="to_world"><lookat origin="0, 1, 6" target="0, 0, 0" up="0, 1, 0"/></transform>
        <sampler type="$sampler"><integer name="sample_count" value="$spp"/></sampler>
        <film type="hdrfilm">
            <integer name="width" value="$width"/>
            <integer name="height" value="$height"/>
            <rfilter type="box"/>
        </film>
    </sensor>
    <shape type="sphere"/>
    <emitter type="constant"/>
</scene>
"""


class Measurements(unittest.TestCase):
    def test_the_images_have_the_same_samples(self):
        """validation/denoising.py denoises one render in both ways."""
        sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "validation"))
        import denoising
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        path = folder / "scene.xml"
        path.write_text(SCENE_FILE, encoding="utf-8")
        for samples in (4, 16):
            noisy, alone, combined = map(np.asarray, denoising.images_of(path, samples, 1, 12, kinome))
            np.testing.assert_array_equal(alone, 2 * noisy)  # what the fake library does
            self.assertEqual(np.array_equal(combined, alone), samples < denoising.COMBINED_FROM)
            share = (combined - alone) / np.where(noisy > 0, noisy - alone, 1)
            self.assertTrue((share > -1e-4).all() and (share < 1 + 1e-4).all())


class Denoise(unittest.TestCase):
    def setUp(self):
        self.scene = kinome.load_dict(SCENE)

    def test_the_colour_is_denoised_and_the_rest_remains(self):
        picture = kinome.render(self.scene)
        denoised = kinome.denoise(picture, threads=1)
        self.assertEqual(denoised.channels, picture.channels)
        np.testing.assert_array_equal(denoised.rgb, 2 * picture.rgb)
        np.testing.assert_array_equal(denoised["albedo"], picture["albedo"])
        self.assertEqual(denoised.stats, {**picture.stats, "denoised": True})
        with tempfile.TemporaryDirectory() as folder:
            for image, expected in ((picture, None), (denoised, "image")):
                file = pathlib.Path(folder) / "image.exr"
                image.write(file)
                self.assertEqual(kinome.Bitmap(file).metadata().get("kinome:denoised"), expected)
        plain = kinome.Picture(np.ones((3, 4, 1), np.float32), ["Y"])
        np.testing.assert_allclose(kinome.denoise(plain), 2 * plain, rtol=1e-6)
        whole = kinome.Picture(np.ones((3, 4, 3), int), ["R", "G", "B"])
        self.assertEqual(kinome.denoise(whole).dtype, np.float32)

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
        with self.assertRaisesRegex(ValueError, "picture has no pixels"):
            kinome.denoise(picture[:0])
        with self.assertRaisesRegex(TypeError, r"albedo takes an array of the shape \(12, 16, 3\)"):
            kinome.denoise(picture, albedo="white")
        with self.assertRaisesRegex(TypeError, "channels takes a list of names"):
            kinome.Picture(np.zeros((2, 2, 1)), None)
        with self.assertRaisesRegex(TypeError, "picture takes a Picture"):
            kinome.denoise(np.zeros((3, 3, 3)))


if __name__ == "__main__":
    unittest.main()
