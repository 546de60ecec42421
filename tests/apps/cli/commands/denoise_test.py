"""Tests of `kinome --denoise`, with a fake library that doubles colours: the library is loaded and
called as documented, errors say what to do, and the layers have the right contents. One test uses
Open Image Denoise itself where it is installed."""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

import numpy as np
import OpenImageIO as oiio

ROOT = pathlib.Path(__file__).resolve().parents[4]
BUILD = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build")).resolve()
PROGRAM = BUILD / "bin/kinome"
FAKE = BUILD / "tests/apps/cli/fake_oidn"
SCENE = """<scene version="3.0.0">
  <default name="integrator" value="path"/> <default name="spp" value="4"/>
  <default name="filter" value="box"/> <default name="format" value="openexr"/>
  <integrator type="$integrator"/>
  <sensor type="perspective">
    <transform name="to_world"> <lookat origin="0,2,4" target="0,0.5,0" up="0,1,0"/> </transform>
    <sampler type="independent"> <integer name="sample_count" value="$spp"/> </sampler>
    <film type="hdrfilm">
      <integer name="width" value="40"/> <integer name="height" value="30"/>
      <string name="file_format" value="$format"/>
      <string name="component_format" value="float32"/> <rfilter type="$filter"/>
    </film>
  </sensor>
  <emitter type="constant"/>
  <shape type="sphere"> <point name="center" value="0,1,0"/> <bsdf type="roughplastic"/> </shape>
  <shape type="rectangle">
    <transform name="to_world"> <rotate x="1" angle="-90"/> <scale value="3"/> </transform>
  </shape>
</scene>
"""


def read(path):
    image = oiio.ImageInput.open(str(path))
    spec = image.spec()
    pixels = image.read_image(oiio.FLOAT).reshape(spec.height, spec.width, spec.nchannels)
    header = {a.name: a.value for a in spec.extra_attribs}
    return {name: pixels[:, :, i] for i, name in enumerate(spec.channelnames)}, header


def colour(channels, layer=""):
    return np.stack([channels[layer + c] for c in "RGB"], axis=-1)


class Denoise(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        (self.folder / "scene.xml").write_text(SCENE)

    def run_program(self, *words, status=0, library=FAKE, **env):
        result = subprocess.run([str(PROGRAM), *map(str, words)], cwd=self.folder, check=False,
                                capture_output=True, text=True, timeout=1200,
                                env=os.environ | {"KINOME_OIDN": str(library)} | env)
        self.assertEqual(result.returncode, status, (words, result.stdout, result.stderr))
        return result.stderr

    def render(self, *words, scene="scene.xml", output="out.exr", **more):
        self.run_program(scene, "-o", output, *words, **more)
        return read(self.folder / output)

    def refused(self, words, *options, **more):
        says = self.run_program(*options, status=1, **more)
        self.assertEqual(says.count("\n"), 1, says)
        self.assertRegex(says, r"^kinome: .*" + re.escape(words))
        self.assertFalse((self.folder / "scene.exr").exists())

    def test_the_image_is_denoised_and_the_noisy_one_is_a_layer(self):
        plain, _ = self.render()
        channels, header = self.render("--denoise")
        self.assertEqual(list(channels), ["R", "G", "B", "noisy.R", "noisy.G", "noisy.B"])
        self.assertEqual(header["kinome:denoised"], "image")
        np.testing.assert_array_equal(colour(channels, "noisy."), colour(plain))
        np.testing.assert_array_equal(colour(channels), 2 * colour(plain))
        channels, header = self.render("--denoise=layer")
        self.assertEqual(header["kinome:denoised"], "layer")
        np.testing.assert_array_equal(colour(channels), colour(plain))
        np.testing.assert_array_equal(colour(channels, "denoised."), 2 * colour(plain))

    def test_albedo_and_normal_are_denoised_first(self):
        says = self.run_program("scene.xml", "-q", "--denoise", "-t", 1, FAKE_OIDN="log")
        self.assertEqual(says.splitlines(), [
            "fake: albedo threads=1", "fake: normal threads=1",
            "fake: albedo color normal cleanAux=1 hdr=1 threads=1"])

    def test_the_bits_dont_depend_on_threads(self):
        for words in (["-D", "spp=16"], ["-D", "integrator=clustered", "-D", "spp=20"]):
            one, _ = self.render(*words, "--denoise", "-t", 1)
            two, _ = self.render(*words, "--denoise", "-t", 2)
            self.assertEqual(list(one), list(two))
            for name, values in one.items():
                np.testing.assert_array_equal(values, two[name])

    def test_enough_samples_are_combined_with_the_noise(self):
        """The fake's bias of 100 % is far above the noise, so that the noisy image remains."""
        channels, header = self.render("--denoise", "-D", "spp=64")
        self.assertNotIn("kinome:renders", header)
        noisy, image = colour(channels, "noisy."), colour(channels)
        self.assertLess(np.abs(image - noisy).mean(), 0.05 * noisy.mean())
        channels, header = self.render("--denoise", "--variance=4")
        self.assertEqual(header["kinome:renders"], "4")
        self.assertIn("variance.R", channels)

    def test_a_wide_filter_is_applied_to_the_denoised_pixels(self):
        box, _ = self.render("--denoise")
        tent, _ = self.render("--denoise", "-D", "filter=tent")
        np.testing.assert_allclose(colour(tent), colour(box))  # a tent of radius 1
        wide, _ = self.render("--denoise", "-D", "filter=gaussian")
        rows = np.exp(-2.0 * np.array([-1, 0, 1]) ** 2) - np.exp(-8)
        kernel = np.outer(rows, rows) / rows.sum() ** 2
        expected = sum(kernel[1 + v, 1 + u] * colour(box)[10 + v, 20 + u]
                       for v in (-1, 0, 1) for u in (-1, 0, 1))
        np.testing.assert_allclose(colour(wide)[10, 20], expected, rtol=1e-4)

    def test_channels_of_the_scene_remain(self):
        text = SCENE.replace('<integrator type="$integrator"/>', """<integrator type="aov">
            <string name="aovs" value="d:depth"/> <integrator type="path" name="img"/>
            </integrator>""").replace('<rfilter', '<string name="pixel_format" value="rgba"/><rfilter')
        (self.folder / "aov.xml").write_text(text)
        plain, _ = self.render(scene="aov.xml")
        channels, _ = self.render("--denoise", scene="aov.xml")
        self.assertEqual(sorted(channels), sorted([*plain, "noisy.R", "noisy.G", "noisy.B"]))
        for name in ("A", "d.T", "img.R"):
            np.testing.assert_array_equal(channels[name], plain[name])

    def test_parts_are_denoised_when_they_are_merged(self):
        for part in (1, 2):
            self.run_program("scene.xml", "--denoise", "--part", f"{part}/2", "-D", "filter=gaussian",
                             "-o", f"{part}.exr", library="/nowhere")
        self.run_program("merge", "1.exr", "2.exr", "--denoise", "-o", "merged.exr")
        whole, _ = self.render("--denoise", "--part", "all/2", "-D", "filter=gaussian")
        merged, header = read(self.folder / "merged.exr")
        self.assertEqual(header["kinome:denoised"], "image")
        self.assertEqual(list(merged), list(whole))
        for name, values in whole.items():
            np.testing.assert_array_equal(values, merged[name])
        # The parts' noise shows that the fake's bias of 100 % is far above it.
        noisy = colour(merged, "noisy.")
        self.assertLess(np.abs(colour(merged) - noisy).mean(), 0.1 * noisy.mean())
        # Without --denoise, merging gives the same channels, and the same image up to denoising.
        self.run_program("merge", "1.exr", "2.exr", "-o", "plain.exr")
        plain, header = read(self.folder / "plain.exr")
        self.assertEqual(sorted(plain), ["B", "G", "R"])
        self.assertNotIn("kinome:denoised", header)
        self.assertNotIn("kinome:filter_of_part", header)
        np.testing.assert_array_equal(colour(plain), noisy)
        self.run_program("scene.xml", "--part", "1/1", "-o", "one.exr")
        self.refused("the parts lack albedo and normals", "merge", "one.exr", "--denoise", "-o",
                     "no.exr")

    def test_frames_are_denoised(self):
        self.run_program("film", "scene.xml", "--path", "orbit", "--frames", 2, "--denoise", "-o",
                         "frames/%d.exr")
        for frame in range(2):
            channels, _ = read(self.folder / f"frames/{frame}.exr")
            np.testing.assert_array_equal(colour(channels), 2 * colour(channels, "noisy."))
        self.refused("another animation", "film", "scene.xml", "--path", "orbit", "--frames", 2,
                     "-o", "frames/%d.exr")

    def test_a_time_includes_denoising(self):
        channels, _ = self.render("--denoise", "--time", 1)
        self.assertIn("noisy.R", channels)

    def test_errors_suggest_what_to_do(self):
        self.refused("--denoise: Open Image Denoise can't be loaded: /nowhere: cannot open shared "
                     "object file: No such file or directory; `pip install pyoidn` into",
                     "scene.xml", "--denoise", library="/nowhere")
        self.refused("version 1 is unsupported, expected 2", "scene.xml", "--denoise",
                     FAKE_OIDN="old")
        self.refused("--denoise: Open Image Denoise failed: the fake is broken", "scene.xml", "-q",
                     "--denoise", FAKE_OIDN="broken")
        self.refused("has no function oidnNewDevice", "scene.xml", "--denoise",
                     library=BUILD / "lib/libkinome.so")
        self.refused("--denoise: needs an .exr file; .pfm files can't store the noisy image",
                     "scene.xml", "--denoise", "-D", "format=pfm")
        self.refused("--denoise: expected no value, or 'layer', got 'both'", "scene.xml",
                     "--denoise=both")
        self.refused("--denoise: can't be combined with --inspect", "scene.xml", "--denoise",
                     "--inspect", "3,4")

    def test_pyoidn_is_found_beside_python(self):
        libraries = self.folder / "env/lib/python3.99/site-packages/pyoidn/oidn/lib"
        libraries.mkdir(parents=True)
        (libraries / "libOpenImageDenoise.so.2").symlink_to(FAKE / "libOpenImageDenoise.so.2")
        says = self.run_program("scene.xml", "-q", "--denoise", library="", FAKE_OIDN="log",
                                VIRTUAL_ENV=str(self.folder / "env"))
        self.assertIn("fake: albedo", says)

    def test_open_image_denoise_lowers_the_error(self):
        try:
            denoised, _ = self.render("--denoise", library=os.environ.get("KINOME_OIDN", ""))
        except AssertionError as error:
            if "can't be loaded" in str(error):
                self.skipTest("Open Image Denoise isn't installed")
            raise
        reference, _ = self.render("-D", "spp=1024", "--seed", 9)
        error = [np.square(colour(denoised, layer) - colour(reference)).mean()
                 for layer in ("", "noisy.")]
        self.assertLess(error[0], 0.5 * error[1])


if __name__ == "__main__":
    unittest.main()
