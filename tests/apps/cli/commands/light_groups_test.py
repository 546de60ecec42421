"""Tests of light groups in files: they add up to the image in merged parts, with a budget of time
and with a denoiser's layers, and `kinome relight` gives the image that a render with other lamps
gives.
"""

import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np
import OpenImageIO as oiio

ROOT = pathlib.Path(__file__).resolve().parents[4]
PROGRAM = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build")).resolve() / "bin/kinome"
SCENE = """<scene version="3.0.0">
  <default name="sky" value="0.4"/> <default name="lamp" value="3"/>
  <default name="groups" value="sky: sky; lamps: ball"/> <default name="format" value="float32"/>
  <integrator type="aov">
    <string name="light_groups" value="$groups"/> <integrator type="path"/>
  </integrator>
  <sensor type="perspective">
    <transform name="to_world"> <lookat origin="0,2,4" target="0,0.5,0" up="0,1,0"/> </transform>
    <sampler type="independent"> <integer name="sample_count" value="6"/> </sampler>
    <film type="hdrfilm">
      <integer name="width" value="24"/> <integer name="height" value="16"/>
      <string name="component_format" value="$format"/>
    </film>
  </sensor>
  <emitter type="constant" id="sky"> <float name="radiance" value="$sky"/> </emitter>
  <emitter type="point"> <point name="position" value="2,2,2"/> </emitter>
  <shape type="sphere" id="ball">
    <point name="center" value="0,1,0"/> <float name="radius" value="0.4"/>
    <emitter type="area"> <float name="radiance" value="$lamp"/> </emitter>
  </shape>
  <shape type="rectangle">
    <transform name="to_world"> <rotate x="1" angle="-90"/> <scale value="3"/> </transform>
  </shape>
</scene>
"""


def layers(path):
    """Returns the layers of three channels by name; "" is the colour."""
    image = oiio.ImageInput.open(str(path))
    names = list(image.spec().channelnames)
    pixels = image.read_image(oiio.FLOAT).reshape(image.spec().height, image.spec().width, -1)
    found = {}
    for i, name in enumerate(names):
        if name == "R" or name.endswith(".R"):
            group = name[:-1].rstrip(".")
            channels = [names.index((group + "." if group else "") + c) for c in "RGB"]
            found[group] = pixels[:, :, channels].astype(np.float64)
    return found


def sum_of_groups(found):
    return sum(values for name, values in found.items() if name.startswith("lights."))


class LightGroups(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        (self.folder / "scene.xml").write_text(SCENE)

    def run_program(self, *words, status=0):
        """Returns the messages."""
        done = subprocess.run([PROGRAM, *words], cwd=self.folder, capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, status, done.stderr)
        return done.stderr

    def check_sum(self, name, tolerance=1e-5):
        found = layers(self.folder / name)
        self.assertEqual({group for group in found if group.startswith("lights.")},
                         {"lights.sky", "lights.lamps", "lights.rest"})
        np.testing.assert_allclose(sum_of_groups(found), found[""], rtol=tolerance, atol=1e-7)
        return found

    def test_relit_image_is_that_of_other_lamps(self):
        self.run_program("scene.xml", "-o", "image.exr")
        self.check_sum("image.exr")
        self.run_program("scene.xml", "-Dsky=0.1", "-Dlamp=6", "-o", "other.exr")
        self.run_program("relight", "image.exr", "sky=0.25", "lamps=2,2,2", "-o", "relit.exr", "--png")
        expected, relit = layers(self.folder / "other.exr"), self.check_sum("relit.exr")
        for name, values in expected.items():
            np.testing.assert_allclose(relit[name], values, rtol=1e-5, atol=1e-7, err_msg=name)
        self.assertTrue((self.folder / "relit.png").is_file())
        self.assertIn(".png files store only colour",
                      self.run_program("relight", "image.exr", "sky=1", "-o", "colour.png"))

    def test_parts_and_budgets_add_up(self):
        for part in "12":
            self.run_program("scene.xml", f"--part={part}/2", "-o", part)
        self.run_program("merge", "1.exr", "2.exr", "-o", "merged.exr")
        self.check_sum("merged.exr")
        self.assertIn("merge the parts first",
                      self.run_program("relight", "1.exr", "sky=1", "-o", "part.exr", status=1))
        self.run_program("scene.xml", "--time=0.3", "-o", "timed.exr")
        self.check_sum("timed.exr")
        self.run_program("scene.xml", "--crop=3,4,12,7", "-Dformat=float16", "-o", "cropped.exr")
        self.check_sum("cropped.exr", tolerance=2e-3)
        self.run_program("relight", "cropped.exr", "sky=2", "-o", "relit.exr")
        window = oiio.ImageInput.open(str(self.folder / "relit.exr")).spec()
        self.assertEqual((window.x, window.y, window.width, window.height), (3, 4, 12, 7))
        self.assertEqual((window.full_x, window.full_y, window.full_width, window.full_height),
                         (0, 0, 24, 16))

    def test_clustered_warns_of_lost_caustics_alone(self):
        """A mirror may send light of the point emitter to the floor, which no group contains."""
        clustered = SCENE.replace('<integrator type="path"/>', '<integrator type="clustered"> '
                                  '<boolean name="trial" value="false"/> </integrator>')
        mirror = ('<shape type="sphere"> <float name="radius" value="0.2"/> <bsdf type="conductor"/> </shape>'
                  '</scene>')
        scenes = {"mirror": clustered.replace("</scene>", mirror), "plain": clustered}
        point = next(line for line in SCENE.splitlines() if 'type="point"' in line)
        scenes["no_lamp"] = scenes["mirror"].replace(point, "")
        for name, text in scenes.items():
            (self.folder / "scene.xml").write_text(text)
            said = self.run_program("scene.xml", "-o", f"{name}.exr")
            self.assertEqual("(caustics)" in said, name == "mirror", said)

    def test_check_reports_the_errors_of_the_render(self):
        plain = '<integrator type="path"/>'
        clustered = '<integrator type="clustered"> {} </integrator>'
        vpl = '<emitter type="vpl"> <emitter type="point" id="bouncing"/> </emitter> </scene>'
        for integrator, end, message in (
                (clustered.format('<float name="max_geometry_term" value="10"/>'), "</scene>",
                 "isn't supported by 'clustered' with max_geometry_term"),
                (clustered.format(""), vpl, "or if indirect emitters are restricted"),
                (clustered.format('<string name="importance" value="joint"/>'), "</scene>",
                 "requires importance 'product'")):
            (self.folder / "scene.xml").write_text(SCENE.replace(plain, integrator).replace("</scene>", end))
            said = self.run_program("scene.xml", "-o", "a.exr", status=1)
            self.assertIn(message, said)
            checked = subprocess.run([PROGRAM, "scene.xml", "--check"], cwd=self.folder, capture_output=True,
                                     text=True, check=False)
            self.assertEqual((checked.returncode, "kinome: " + checked.stdout), (1, said))

    def test_wrong_command_lines_are_refused(self):
        said = self.run_program("scene.xml", "-Dgroups=a: skyy", "-o", "a.exr", status=1)
        self.assertEqual(said, "kinome: scene.xml:5:5: 'light_groups' names the unknown emitter 'skyy' "
                               "(did you mean 'sky'?)\n")
        self.run_program("scene.xml", "-o", "image.exr")
        # The PNG would replace the file that was read.
        (self.folder / "image.exr").rename(self.folder / "a.png")
        self.assertIn("a.png': this file was read",
                      self.run_program("relight", "a.png", "sky=1", "-o", "a.exr", "--png", status=1))
        (self.folder / "a.png").rename(self.folder / "image.exr")
        for words, message in (
                (("image.exr", "sky=1"), "--output is required"),
                (("image.exr", "-o", "a.exr"), "GROUP=FACTOR is required"),
                (("image.exr", "sky=x", "-o", "a.exr"), "expected GROUP=FACTOR"),
                (("image.exr", "lamp=1", "-o", "a.exr"),
                 "image.exr: the image has no light group 'lamp' (did you mean 'lamps'?); its groups are "
                 "lamps, rest, sky"),
                (("image.exr", "sky=1", "-o", "image.exr"), "image.exr': this file was read"),
                (("none.exr", "sky=1", "-o", "a.exr"), "none.exr: can't be read")):
            self.assertIn(message, self.run_program("relight", *words, status=1))
        self.assertFalse((self.folder / "a.exr").exists())


if __name__ == "__main__":
    unittest.main()
