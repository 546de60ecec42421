"""Tests of `kinome film`: frames have the same bits alone and in the animation, an interrupted
animation continues, and cameras and parameters follow their keys."""

import json
import os
import pathlib
import re
import resource
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
LOOKAT = '<lookat origin="0.3,1.1,5" target="0.1,0.2,-0.1" up="0,1,0"/>'
ALPHA = '<float name="alpha" value="0.3"/>'
SKY = '<transform name="to_world"> <rotate y="1" angle="0"/> </transform>'
REFLECTANCE = '<rgb name="reflectance" value="0.2,0.4,0.6"/>'
SCENE = f"""<scene version="3.0.0">
  <default name="spp" value="2"/> <default name="size" value="32"/>
  <integrator type="direct"/>
  <sensor type="perspective">
    <float name="fov" value="40"/>
    <transform name="to_world"> {LOOKAT} </transform>
    <sampler type="independent"> <integer name="sample_count" value="$spp"/> </sampler>
    <film type="hdrfilm">
      <integer name="width" value="$size"/> <integer name="height" value="24"/>
      <string name="component_format" value="float32"/> <rfilter type="box"/>
    </film>
  </sensor>
  <emitter type="envmap" id="sky"> <string name="filename" value="sky.pfm"/> {SKY} </emitter>
  <shape type="sphere" id="ball">
    <bsdf type="roughconductor"> {ALPHA} </bsdf>
  </shape>
  <shape type="rectangle" id="floor">
    <transform name="to_world"> <rotate x="1" angle="-90"/> <scale value="9"/>
      <translate y="-1"/> </transform>
    <bsdf type="diffuse"> {REFLECTANCE} </bsdf>
  </shape>
</scene>
"""


def write_sky(path):
    """Writes a map that is bright on one side, so that its orientation is visible."""
    sky = np.full((8, 16, 3), 0.1, "<f4")
    sky[2:5, 3:6] = [8, 6, 4]
    path.write_bytes(b"PF\n16 8\n-1.0\n" + sky[::-1].tobytes())


def read(path):
    image = oiio.ImageInput.open(str(path))
    spec = image.spec()
    return image.read_image(oiio.FLOAT).reshape(spec.height, spec.width, spec.nchannels)


def bits(path):
    return read(path).view(np.uint32)


def seed_of(path):
    return oiio.ImageInput.open(str(path)).spec().getattribute("kinome:seed")


class Film(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        (self.folder / "scene.xml").write_text(SCENE)
        write_sky(self.folder / "sky.pfm")

    def run_program(self, *words, **settings):
        return subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True,
                              cwd=self.folder, timeout=1200, **settings)

    def film(self, path, frames, output, *options, status=0, **settings):
        """Returns the messages of `kinome film`."""
        result = self.run_program("film", "scene.xml", "--path", path, "--frames", frames, "-o",
                                  output, *options, **settings)
        self.assertEqual(result.returncode, status, result.stderr)
        return result.stderr

    def keys(self, keys, name="keys.json"):
        (self.folder / name).write_text(keys if isinstance(keys, str) else json.dumps(keys))
        return name

    def frame(self, name):
        return self.folder / name

    def plain(self, scene, seed, *options):
        """Returns the pixels of a render of the scene's text."""
        (self.folder / "plain.xml").write_text(scene)
        result = self.run_program("plain.xml", "-q", "--seed", seed, "-o", "plain.exr", *options)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        return bits(self.folder / "plain.exr")

    # ---- frames

    def test_frames_are_the_same_alone_and_differ_in_their_noise(self):
        says = self.film("ellipse", 5, "a/%04d.exr")
        self.assertRegex(says, r"(?m)^wrote a/%04d.exr: 5 frames, 0.2 s \(.*\)$")
        self.assertIn("wrote one/%d.exr: 1 frame, ", self.film("orbit", 1, "one/%d.exr"))
        self.assertEqual(sorted(p.name for p in (self.folder / "a").iterdir()),
                         [f"000{i}.exr" for i in range(5)] + ["film.json"])
        self.film("ellipse", 5, "b/%d.exr", "--frame", 3, "-t", 1)
        self.film("ellipse", 5, "b/%d.exr", "--range", "1:2")
        self.assertEqual(sorted(p.name for p in (self.folder / "b").iterdir()),
                         ["1.exr", "2.exr", "3.exr", "film.json"])
        for i in (1, 2, 3):
            np.testing.assert_array_equal(bits(self.frame(f"a/000{i}.exr")),
                                          bits(self.frame(f"b/{i}.exr")))
        self.assertEqual(len({seed_of(self.frame(f"a/000{i}.exr")) for i in range(5)}), 5)
        # A static camera sees different noise in each frame, with the same mean.
        still = {"camera": [{"time": 0, "position": [0, 1, 5], "target": [0, 0, 0]}]}
        self.film(self.keys(still), 2, "c-%d.exr", "-D", "spp=16")
        a, b = read(self.frame("c-0.exr")), read(self.frame("c-1.exr"))
        self.assertGreater(np.count_nonzero(a != b), a.size / 4)
        self.assertLess(abs(a.mean() - b.mean()), 0.05 * a.mean())

    def test_frames_can_be_cropped(self):
        self.film("orbit", 2, "a/%d.exr")
        self.film("orbit", 2, "b/%d.exr", "--crop", "8,4,16,12")
        for i in range(2):
            np.testing.assert_array_equal(bits(self.frame(f"a/{i}.exr"))[4:16, 8:24],
                                          bits(self.frame(f"b/{i}.exr")))
        says = self.film("orbit", 2, "b/%d.exr", status=1)
        self.assertIn("image size: 16x12 at 8,4 instead of 32x24", says)
        self.assertIn("--crop 8,4,30,12: must be within the film's 32x24 pixels",
                      self.film("orbit", 2, "c/%d.exr", "--crop", "8,4,30,12", status=1))

    def test_an_animation_continues_with_the_missing_frames(self):
        self.film("orbit", 4, "a/%d.exr", "--png")
        before = {p: (p.stat().st_mtime_ns, p.read_bytes()) for p in (self.folder / "a").iterdir()}
        self.frame("a/1.exr").unlink()
        self.frame("a/2.png").unlink()
        says = self.film("orbit", 4, "a/%d.exr", "--png")
        self.assertIn("2 of 4 frames exist: rendering the others\n", says)
        for path, (written, data) in before.items():
            self.assertEqual(path.read_bytes(), data, path)
            if path.stem in ("0", "3"):
                self.assertEqual(path.stat().st_mtime_ns, written, path)

    def test_an_interrupted_animation_leaves_complete_frames_and_resumes(self):
        options = ["-D", "spp=4096", "-D", "size=160"]
        program = subprocess.Popen([PROGRAM, "film", "scene.xml", "-q", "--path", "orbit", "--frames",
                                    "400", "-o", "a/%d.exr", *options], cwd=self.folder)
        end = time.monotonic() + 60
        while not self.frame("a/1.exr").exists() and time.monotonic() < end:
            time.sleep(0.01)
        program.terminate()
        self.assertEqual(program.wait(60), 128 + 15)
        there = sorted(int(p.stem) for p in (self.folder / "a").glob("*.exr"))
        self.assertEqual(there, list(range(len(there))))
        self.assertLess(len(there), 400)
        self.assertEqual({p.name for p in (self.folder / "a").iterdir()},
                         {f"{i}.exr" for i in there} | {"film.json"})
        alone = there[-1]
        before = bits(self.frame(f"a/{alone}.exr"))
        self.frame(f"a/{alone}.exr").unlink()
        self.film("orbit", 400, "a/%d.exr", "--frame", alone, *options)
        np.testing.assert_array_equal(bits(self.frame(f"a/{alone}.exr")), before)

    def test_frames_of_another_film_are_not_taken_for_its_own(self):
        self.film("orbit", 2, "a/%d.exr")
        for options, what in [(["--seed", 1], "seed: 0 instead of 1"), (["-D", "spp=3"], "scene"),
                              (["--up", "1,0,0"], "--up")]:
            says = self.film("orbit", 2, "a/%d.exr", *options, status=1)
            self.assertRegex(says, rf"^kinome: a/film.json: the frames .* another animation \({what}.*\n$")
            self.assertEqual(says.count("\n"), 1)
        self.film("orbit", 2, "c/%d.jpg", "--exposure", 1)
        self.assertIn("another animation (--exposure: 1 instead of 2)",
                      self.film("orbit", 2, "c/%d.jpg", "--exposure", 2, status=1))
        self.frame("b").mkdir()
        self.frame("b/1.exr").write_text("a picture of someone's")
        self.assertIn("b/1.exr exists, but its animation is unknown",
                      self.film("orbit", 2, "b/%d.exr", status=1))

    def test_a_frame_that_cannot_be_written_is_one_error(self):
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))  # smaller than a frame

        for options in ([], ["-t", 1]):
            says = self.film("orbit", 3, "a/%d.exr", *options, status=1, preexec_fn=limit)
            self.assertRegex(says, r"^kinome: .*a/0\.exr.*\n$")
            self.assertEqual(says.count("\n"), 1, says)
            self.assertEqual([p.name for p in (self.folder / "a").iterdir()], ["film.json"])

    # ---- animated values

    def test_the_camera_follows_its_keys(self):
        keys = {"camera": [{"time": 3, "position": [0.3, 1.1, 5], "target": [0.1, 0.2, -0.1], "fov": 40},
                           {"time": 5, "position": [0.5, 2, 4], "target": [0, 0, 0], "fov": 50}]}
        self.film(self.keys(keys), 3, "%d.exr")
        for i, (lookat, fov) in enumerate([
                (LOOKAT, 40), ('<lookat origin="0.4,1.55,4.5" target="0.05,0.1,-0.05" up="0,1,0"/>', 45),
                ('<lookat origin="0.5,2,4" target="0,0,0" up="0,1,0"/>', 50)]):
            path = self.frame(f"{i}.exr")
            scene = SCENE.replace(LOOKAT, lookat).replace('value="40"', f'value="{fov}"')
            np.testing.assert_array_equal(bits(path), self.plain(scene, seed_of(path)))

    def test_circling_cameras_keep_their_distance_and_their_target(self):
        # A black ball at the target under a white sky looks the same from all sides.
        scene = SCENE.replace('type="envmap"', 'type="constant"').replace(
            '<string name="filename" value="sky.pfm"/>', "").replace(SKY, "").replace(
                "roughconductor", "diffuse").replace(
                    ALPHA, '<float name="reflectance" value="0"/>').replace('id="floor"', "").replace(
                        '<translate y="-1"/>', '<translate y="-100"/>')
        (self.folder / "scene.xml").write_text(scene)
        for path in ("orbit", "ellipse"):
            self.film(path, 4, path + "%d.exr", "--target", "0,0,0", "--angles", "60,40", "-D",
                      "spp=64")
            dark = [np.mean(read(self.frame(f"{path}{i}.exr"))[:, :, 1] < 0.02) for i in range(4)]
            self.assertGreater(min(dark), 0.1)
            self.assertLess(np.ptp(dark), 0.02, (path, dark))

    def test_parameters_follow_their_keys(self):
        keys = {"parameters": {
            "ball.bsdf.alpha": [[0, 0.3], [2, 0.5]],
            "floor.bsdf.reflectance": [[0, [0.2, 0.4, 0.6]], [2, [0.4, 0.2, 0.6]]],
            "sky.to_world": {"axis": [0, 1, 0], "degrees": [[0, 0], [2, 90]]}}}
        self.film(self.keys(keys), 2, "%d.exr")
        turned = SKY.replace('angle="0"', 'angle="90"')
        last = SCENE.replace(ALPHA, '<float name="alpha" value="0.5"/>').replace(SKY, turned).replace(
            REFLECTANCE, '<rgb name="reflectance" value="0.4,0.2,0.6"/>')
        for i, scene in enumerate([SCENE, last]):
            path = self.frame(f"{i}.exr")
            np.testing.assert_array_equal(bits(path), self.plain(scene, seed_of(path)))
        # Also tests an orbiting camera, and the second frame alone.
        self.film(self.keys(keys | {"camera": "orbit"}), 2, "o%d.exr")
        self.film("keys.json", 2, "p%d.exr", "--frame", 1)
        np.testing.assert_array_equal(bits(self.frame("o1.exr")), bits(self.frame("p1.exr")))
        self.assertGreater(np.count_nonzero(bits(self.frame("o1.exr")) != bits(self.frame("1.exr"))), 9)

    # ---- output

    def test_a_video(self):
        self.film("orbit", 6, "%d.png", "-D", "spp=16", "-D", "size=31", "--exposure", 1)
        self.assertEqual(list(self.folder.glob("*.exr")), [])
        says = self.film("orbit", 6, "a.mp4", "--fps", 12, "-D", "spp=16", "-D", "size=31",
                         "--exposure", 1)
        self.assertRegex(says, r"(?m)^wrote a.mp4: 6 frames, 0.5 s \(")
        self.assertFalse(self.frame("a-frames").exists())
        self.assertEqual(list(self.folder.glob("*unfinished*")), [])
        shown = subprocess.run(["ffmpeg", "-v", "error", "-i", "a.mp4", "-f", "rawvideo", "-pix_fmt",
                                "rgb24", "-"], cwd=self.folder, capture_output=True, check=True).stdout
        frames = np.frombuffer(shown, np.uint8).reshape(-1, 24, 32, 3)  # even numbers of pixels
        self.assertEqual(len(frames), 6)
        for i, frame in enumerate(frames):
            png = 255 * read(self.frame(f"{i}.png"))[:, :, :3]
            other = 255 * read(self.frame(f"{(i + 3) % 6}.png"))[:, :, :3]
            distance = np.abs(frame[:, :31] - png).mean()
            self.assertLess(distance, 12)
            self.assertLess(distance, 0.7 * np.abs(frame[:, :31] - other).mean())

    def test_frames_stay_where_there_is_no_ffmpeg_or_it_fails(self):
        environment = os.environ | {"PATH": str(self.folder)}
        says = self.film("orbit", 2, "a.mp4", env=environment)
        self.assertEqual(says.count("ffmpeg"), 1)
        self.assertIn("ffmpeg not found: writing PNG frames, a-frames/%04d.png, and no video\n", says)
        written = self.frame("a-frames/0001.png").stat().st_mtime_ns
        fake = self.frame("ffmpeg")
        fake.write_text("#!/bin/sh\necho no codec >&2\nexit 1\n")
        fake.chmod(0o755)
        says = self.film("orbit", 2, "a.mp4", env=environment, status=1)
        self.assertIn("kinome: -o a.mp4: ffmpeg can't encode a-frames/%04d.png: no codec\n", says)
        self.assertEqual(self.frame("a-frames/0001.png").stat().st_mtime_ns, written)
        self.assertIn("wrote a.mp4", self.film("orbit", 2, "a.mp4"))
        self.assertFalse(self.frame("a-frames").exists())

    def test_a_camera_that_moves_makes_nothing_else_anew(self):
        says = self.film("orbit", 2, "%d.exr", "-vv")
        for i in range(2):
            self.assertRegex(says, rf"(?m)frame {i}: rebuilt sensor/perspective$")
        keys = {"parameters": {"ball.bsdf.alpha": [[0, 0.3], [1, 0.4]]}}
        says = self.film(self.keys(keys), 2, "a%d.exr", "-vv")
        self.assertRegex(says, r"(?m)frame 1: rebuilt bsdf/roughconductor$")

    def test_other_options_apply_to_each_frame(self):
        result = self.run_program("film", "scene.xml", "-q", "--path", "orbit", "--frames", 3, "-o",
                                  "%d.exr", "--stats=json", "--variance=4")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        stats = [json.loads(line) for line in result.stdout.splitlines()]
        self.assertEqual([s["output"] for s in stats], ["0.exr", "1.exr", "2.exr"])
        self.assertGreater(stats[0]["seconds"]["plugins"], 0)
        self.assertEqual(stats[1]["seconds"]["plugins"], 0)  # the scene is loaded once
        names = oiio.ImageInput.open(str(self.frame("2.exr"))).spec().channelnames
        self.assertIn("variance.G", names)

    def test_a_display_shows_one_image_that_changes(self):
        with Receiver() as receiver:
            self.film("orbit", 3, "%d.exr", "--display", receiver.address)
            receiver.wait()
        picture = receiver.pictures["%d.exr"]
        self.assertEqual(receiver.creations, 1)
        last = read(self.frame("2.exr"))
        np.testing.assert_array_equal(picture.pixels[:, :, :3].view(np.uint32),
                                      last[:, :, :3].view(np.uint32))

    # ---- errors

    def check_mistake(self, words, *options):
        result = self.run_program("film", "scene.xml", *options)
        self.assertEqual(result.returncode, 1, (options, result.stderr))
        self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
        self.assertRegex(result.stderr, r"^kinome: .*" + re.escape(words))

    def test_errors_of_the_command_line(self):
        orbit = ["--path", "orbit", "--frames", 2]
        for words, options in [
                ("--path", ["--frames", 2]),
                ("--frames", ["--path", "orbit"]),
                ("--path: expected orbit, ellipse or a file of keys, got 'orbti' (did you mean 'orbit'?)",
                 ["--path", "orbti", "--frames", 2]),
                ("got 'none.json': no such file", ["--path", "none.json", "--frames", 2]),
                ("--frames: must be between 1 and 1000000, got 0", ["--path", "orbit", "--frames", 0]),
                ("--fps: must be more than 0", [*orbit, "--fps", 0]),
                ("--frame: expected one of the frames 0 to 1, got '2'", [*orbit, "--frame", 2]),
                ("--range: expected FIRST:LAST of the frames 0 to 1, got '1:0'",
                 [*orbit, "--range", "1:0"]),
                ("--range", [*orbit, "--range", "0"]),
                ("--frame: can't be combined with --range", [*orbit, "--frame", 0, "--range", "0:1"]),
                ("--target: expected X,Y,Z, got '1,2'", [*orbit, "--target", "1,2"]),
                ("--up: must not be zero", [*orbit, "--up", "0,0,0"]),
                ("--angles: expected A,B", [*orbit, "--angles", "30"]),
                ("it looks along --up", [*orbit, "--target", "0.3,0,5"]),
                ("names of frames with one number", [*orbit, "-o", "a.exr"]),
                ("names of frames with one number", [*orbit, "-o", "%d-%d.exr"]),
                ("names of frames with one number", [*orbit, "-o", "%s.exr"]),
                ("unknown image format '.jpgg'", [*orbit, "-o", "%d.jpgg"]),
                ("nowhere/on", [*orbit, "-o", "nowhere/on/%d.exr"]),
                ("scene.xml/", [*orbit, "-o", "scene.xml/%d.exr"]),
                ("unknown option '--check'", [*orbit, "--check"]),
                ("--display: expected the viewer's HOST:PORT", [*orbit, "--display", "here"])]:
            with self.subTest(options=options):
                self.check_mistake(words, *options)
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["scene.xml", "sky.pfm"])

    def test_errors_of_keys(self):
        key = {"time": 0, "position": [0, 1, 5], "target": [0, 0, 0]}
        for words, keys in [
                ("keys.json:2:12: syntax error", '{"camera":\n  [{"time" 0}]}'),
                ("keys.json:1:1: ", ""),
                ("keys.json: the key 'time' is given twice", '{"camera": [{"time": 0, "time": 1}]}'),
                ("missing keys", {}),
                ("expected an object", []),
                ("unknown key 'cammera' (did you mean 'camera'?)", {"cammera": []}),
                ("camera: expected a list of at least 1", {"camera": []}),
                ("camera: expected orbit, ellipse or a list of keys, got 'spiral'", {"camera": "spiral"}),
                ("camera[0]: 'target' is missing", {"camera": [{"time": 0, "position": [0, 1, 5]}]}),
                ("camera[0].position: expected three numbers", {"camera": [key | {"position": [0, 1]}]}),
                ("camera[0].position[1]: expected a number", {"camera": [key | {"position": [0, "1", 2]}]}),
                ("camera[0]: unknown key 'fob'", {"camera": [key | {"fob": 3}]}),
                ("camera[1]: times must increase: 0 comes after 0", {"camera": [key, key]}),
                ("camera: 'fov' must be in all keys, or in none",
                 {"camera": [key, key | {"time": 1, "fov": 40}]}),
                ("in frame 0 the camera looks along its 'up'",
                 {"camera": [key | {"position": [0, 0, 0]}]}),
                ("unknown parameter 'ball.bsdf.alpah.value' (did you mean 'ball.bsdf.alpha.value'?)",
                 {"parameters": {"ball.bsdf.alpah.value": [[0, 1]]}}),
                ("parameters.ball.bsdf.alpha[0]: expected [time, value]",
                 {"parameters": {"ball.bsdf.alpha": [0, 1]}}),
                ("expected one number in all keys, or three numbers in all keys",
                 {"parameters": {"ball.bsdf.alpha": [[0, 1], [1, [1, 2, 3]]]}}),
                ("'filename'", {"parameters": {"sky.filename": [[0, 1]]}}),
                ("the axis of a rotation can't be zero",
                 {"parameters": {"sky.to_world": {"axis": [0, 0, 0], "degrees": [[0, 1]]}}}),
                ("'degrees' is missing", {"parameters": {"sky.to_world": {"axis": [0, 0, 1]}}}),
                ("too large", '{"camera": [{"time": 1e999}]}'),
                # Reported before a frame is rendered, though only the last one has the error.
                ("keys.json: ", {"camera": [key | {"fov": 40}, key | {"time": 1, "fov": 300}]}),
                ("keys.json: ", {"parameters": {"floor.bsdf.reflectance": [[0, 0.5], [1, 1.5]]}})]:
            with self.subTest(keys=keys):
                self.check_mistake(words, "--path", self.keys(keys), "--frames", 3, "-o", "%d.exr")
        self.assertEqual(list(self.folder.glob("*.exr")), [])


if __name__ == "__main__":
    unittest.main()
