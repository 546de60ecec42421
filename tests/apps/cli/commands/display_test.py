"""Tests of `--display`: a viewer with tev's protocol finally has the image, bit by bit."""

import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import time
import unittest

import numpy as np
import OpenImageIO as oiio

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path.insert(0, str(ROOT / "tests/support"))
from tev_receiver import Receiver  # noqa: E402

PROGRAM = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build")) / "bin/kinome"
SCENE = """<scene version="3.0.0">
  <default name="width" value="80"/> <default name="height" value="50"/>
  <default name="integrator" value="path"/>
  <integrator type="aov">
    <string name="aovs" value="position:position,z:depth"/>
    <integrator type="$integrator"/>
  </integrator>
  <sensor type="perspective">
    <transform name="to_world"> <lookat origin="0,1,5" target="0,0,0" up="0,1,0"/> </transform>
    <sampler type="independent"> <integer name="sample_count" value="4"/> </sampler>
    <film type="hdrfilm">
      <integer name="width" value="$width"/> <integer name="height" value="$height"/>
      <string name="component_format" value="float32"/>
      <rfilter type="gaussian"/>
    </film>
  </sensor>
  <emitter type="constant"/>
  <shape type="sphere"/>
</scene>
"""


def read(path):
    image = oiio.ImageInput.open(str(path))
    spec = image.spec()
    return list(spec.channelnames), image.read_image(oiio.FLOAT).reshape(
        spec.height, spec.width, spec.nchannels)


class Display(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        (self.folder / "scene.xml").write_text(SCENE)
        self.picture = self.folder / "a.exr"

    def kinome(self, *options):
        return subprocess.run([PROGRAM, self.folder / "scene.xml", "-q", "-t", "2", *options, "-o",
                               self.picture], capture_output=True, text=True, timeout=1200)

    def shown(self, *options):
        """Returns the receiver's image after a render, which must be the same as without a
        receiver."""
        with Receiver() as receiver:
            result = self.kinome(*options, "--display", receiver.address)
            self.assertEqual((result.returncode, result.stderr), (0, ""))
            receiver.wait()
        self.assertEqual(list(receiver.pictures), [str(self.picture)])
        shown = receiver.pictures[str(self.picture)]
        names, pixels = read(self.picture)
        self.assertEqual(sorted(names), sorted(shown.channels))
        received = shown.pixels[:, :, [shown.channels.index(name) for name in names]]
        np.testing.assert_array_equal(received.view(np.uint32), pixels.view(np.uint32))
        alone = self.kinome(*options)
        self.assertEqual(alone.returncode, 0, alone.stderr)
        np.testing.assert_array_equal(read(self.picture)[1].view(np.uint32),
                                      pixels.view(np.uint32))
        return shown, receiver

    def test_tiles_of_a_plain_render(self):
        shown, receiver = self.shown()
        self.assertEqual(receiver.creations, 1)
        self.assertEqual(shown.channels[:3], ["R", "G", "B"])
        self.assertIn("position.Z", shown.channels)
        # All updates consist of whole cells, and none extends beyond the image.
        for x, y, width, height in shown.updates:
            self.assertEqual((x % 32, y % 32), (0, 0))
            self.assertTrue(x + width <= 80 and y + height <= 50)

    def test_tiles_are_sent_before_the_image_is_finished(self):
        with Receiver() as receiver:
            program = subprocess.Popen(
                [PROGRAM, self.folder / "scene.xml", "-q", "-t", "1", "-D", "width=512", "-D",
                 "height=512", "-o", self.picture, "--display", receiver.address, "--time", "60"],
                stderr=subprocess.DEVNULL)
            end = time.monotonic() + 30
            name = str(self.picture)
            while time.monotonic() < end and not (
                    name in receiver.pictures and len(receiver.pictures[name].updates) > 3):
                time.sleep(0.01)
            self.assertIsNone(program.poll())
            program.terminate()  # the incomplete image is written, and shown
            self.assertEqual(program.wait(60), 128 + 15)
            receiver.wait()
        names, pixels = read(self.picture)
        shown = receiver.pictures[name]
        received = shown.pixels[:, :, [shown.channels.index(n) for n in names]]
        np.testing.assert_array_equal(received, pixels)

    def test_passes_and_their_variance(self):
        # Variances are known only after a pass, and the image is then created again. A small image
        # may be finished before the first pass is sent.
        for side in (64, 256, 1024):
            shown, receiver = self.shown("--variance=4", f"-Dwidth={side}", f"-Dheight={side}")
            self.assertIn("tile_variance.G", shown.channels)
            if receiver.creations > 1:
                break
        self.assertEqual(receiver.creations, 2)

    def test_splats(self):
        self.shown("-D", "integrator=ptracer")

    def test_one_warning_where_no_one_listens(self):
        with socket.socket() as unheard:  # bound to a port, but not listening
            unheard.bind(("127.0.0.1", 0))
            self.check_warning("127.0.0.1:%d" % unheard.getsockname()[1], "refused")

    def test_one_warning_of_a_display_that_goes_away(self):
        with Receiver(leave_after=1) as receiver:
            self.check_warning(receiver.address, "reset|pipe", "-D", "width=600", "-D",
                               "height=600")

    def test_no_one_waits_for_a_display_that_takes_nothing(self):
        with Receiver(stalls=True) as receiver:
            start = time.monotonic()
            self.check_warning(receiver.address, "no longer accepts data", "-D", "width=700", "-D",
                               "height=700")
            self.assertLess(time.monotonic() - start, 60)

    def check_warning(self, address, what, *options):
        result = subprocess.run([PROGRAM, self.folder / "scene.xml", *options, "-D",
                                 "integrator=depth", "-o", self.picture, "--display", address],
                                capture_output=True, text=True, timeout=1200)
        self.assertEqual(result.returncode, 0, result.stderr)
        lines = [line for line in result.stderr.splitlines() if "--display" in line]
        self.assertEqual(len(lines), 1, result.stderr)
        self.assertRegex(lines[0], "(?i)kinome: warning: --display " + address + ": .*(" + what +
                         ").*; rendering continues without it")
        self.assertTrue(self.picture.exists())

    def test_invalid_addresses(self):
        for address in ["localhost", "localhost:", ":14158", "localhost:port", "localhost:0",
                        "localhost:70000", ""]:
            result = self.kinome("--display", address)
            self.assertEqual(result.returncode, 1)
            self.assertRegex(result.stderr, r"^kinome: --display: .*\n$", address)
            self.assertEqual(result.stderr.count("\n"), 1)


if __name__ == "__main__":
    unittest.main()
