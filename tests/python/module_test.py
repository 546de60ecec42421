#!/usr/bin/python3
"""The Python module: the program's pictures, edits, callbacks, Ctrl-C and errors.

Of the build folder KINOME_BUILD, or, where KINOME_PACKAGE says so, as it is installed.
"""
import contextlib
import io
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

BUILD = pathlib.Path(os.environ["KINOME_BUILD"])
if "KINOME_PACKAGE" not in os.environ:
    sys.path.insert(0, str(BUILD / "python"))
import kinome  # noqa: E402

SCENE = """\
<scene version="3.0.0">
    <default name="spp" value="4"/>
    <integrator type="path"/>
    <sensor type="perspective">
        <transform name="to_world">
            <lookat origin="0, 2, 6" target="0, 0, 0" up="0, 1, 0"/>
        </transform>
        <sampler type="independent"><integer name="sample_count" value="$spp"/></sampler>
        <film type="hdrfilm">
            <integer name="width" value="40"/> <integer name="height" value="30"/>
            <string name="component_format" value="float32"/>
        </film>
    </sensor>
    <bsdf type="diffuse" id="red"><rgb name="reflectance" value="0.6, 0.2, 0.1"/></bsdf>
    <shape type="sphere" id="ball"><ref id="red"/></shape>
    <emitter type="constant" id="sky"><rgb name="radiance" value="0.5, 0.6, 0.7"/></emitter>
    <emitter type="point"><point name="position" x="2" y="3" z="4"/>
        <rgb name="intensity" value="9"/></emitter>
</scene>
"""

# The same as a dict in Mitsuba's form, its values being the ones that the text stands for.
DICT = {
    "type": "scene",
    "integrator": {"type": "path"},
    "sensor": {
        "type": "perspective",
        "to_world": kinome.Transform().look_at([0, 2, 6], [0, 0, 0], [0, 1, 0]),
        "sampler": {"type": "independent", "sample_count": 4},
        "film": {"type": "hdrfilm", "width": 40, "height": 30, "component_format": "float32"},
    },
    "red": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.6, 0.2, 0.1]}},
    "ball": {"type": "sphere", "bsdf": {"type": "ref", "id": "red"}},
    "sky": {"type": "constant", "radiance": {"type": "rgb", "value": [0.5, 0.6, 0.7]}},
    "lamp": {"type": "point", "position": [2, 3, 4],
             "intensity": {"type": "rgb", "value": 9}},
}


def with_parts(scene, **parts):
    return {**scene, **parts}


class ModuleTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.path = self.folder / "scene.xml"
        self.path.write_text(SCENE)

    def load(self, **defines):
        return kinome.load_file(self.path, **defines)

    def program(self, *arguments):
        """The colour of its picture, as PFM, which both can read without other packages."""
        output = self.folder / "program.exr"
        subprocess.run([sys.executable, "-m", "kinome", "-q", self.path, "-o", output, *arguments],
                       check=True, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)})
        return read_exr(output)

    def test_gives_the_programs_picture(self):
        ours = kinome.render(self.load(spp=9), seed=3)
        self.assertEqual((ours.shape, ours.dtype), ((30, 40, 3), np.float32))
        self.assertEqual(ours.channels, ["R", "G", "B"])
        self.assertTrue(ours.stats["complete"])
        np.testing.assert_array_equal(ours, self.program("-D", "spp=9", "--seed", "3"))
        # Without a copy of what the core has made.
        self.assertIsNotNone(ours.base)
        self.assertFalse(ours.flags.owndata)
        np.testing.assert_array_equal(kinome.render(self.load(), spp=9, seed=3, threads=1), ours)

    def test_a_dict_is_a_scene_as_well(self):
        np.testing.assert_array_equal(kinome.render(kinome.load_dict(DICT)),
                                      kinome.render(self.load()))

    def test_another_integrator_sensor_and_layers(self):
        scene = self.load()
        before = kinome.render(scene)
        direct = kinome.render(scene, integrator={"type": "path", "max_depth": 1})
        self.assertFalse(np.array_equal(before, direct))
        aov = kinome.render(scene, integrator={"type": "aov", "aovs": "dd:depth,sn:sh_normal",
                                               "nested": {"type": "path"}})
        np.testing.assert_array_equal(aov.rgb, before)
        self.assertEqual(aov["sn"].shape, (30, 40, 3))
        self.assertEqual(set(aov.layers), {"nested", "dd", "sn"})
        self.assertTrue(np.shares_memory(aov["sn"], aov))
        with self.assertRaises(KeyError):
            aov["albedo"]
        with self.assertRaisesRegex(kinome.Error, "no sensor '1'"):
            kinome.render(scene, sensor=1)

    def test_edits_make_what_the_edited_file_makes(self):
        scene = self.load()
        parameters = kinome.traverse(scene)
        self.assertIn("red.reflectance.value", parameters)
        np.testing.assert_allclose(parameters["red.reflectance.value"], [0.6, 0.2, 0.1])
        parameters["red.reflectance.value"] = [0.25, 0.5, 0.75]
        parameters["ball.center"] = np.array([0, 0.5, 0])
        parameters["sensor.to_world"] = kinome.Transform().look_at([1, 2, 6], [0, 0, 0], [0, 1, 0])
        changes = parameters.update({"sky.radiance": 2.0})
        self.assertEqual(set(changes.made), {"bsdf/diffuse", "shape/sphere", "sensor/perspective",
                                             "emitter/constant"})
        edited = kinome.render(scene)
        self.path.write_text(
            SCENE.replace("0.6, 0.2, 0.1", "0.25, 0.5, 0.75").replace("0, 2, 6", "1, 2, 6")
            .replace("0.5, 0.6, 0.7", "2")
            .replace('id="ball">', 'id="ball"><point name="center" value="0, 0.5, 0"/>'))
        np.testing.assert_array_equal(edited, kinome.render(self.load()))
        self.assertEqual(parameters.update(), ([], 0, False))

    def test_pixels_need_no_file(self):
        grey = np.full((2, 3, 3), 0.5, np.float32)
        texture = {"type": "bitmap", "data": grey, "raw": True}
        plain = with_parts(DICT, red={"type": "diffuse", "reflectance": 0.5})
        painted = with_parts(DICT, red={"type": "diffuse", "reflectance": texture})
        expected = kinome.render(kinome.load_dict(plain))
        scene = kinome.load_dict(painted)
        np.testing.assert_array_equal(kinome.render(scene), expected)
        parameters = kinome.traverse(scene)
        np.testing.assert_array_equal(parameters["red.reflectance.data"], grey)
        parameters.update({"red.reflectance.data": grey[:, :, :1] / 2})
        self.assertLess(np.mean(kinome.render(scene)), np.mean(expected))
        sky = np.zeros((4, 8, 3), np.float32)
        sky[0] = 5
        lit = kinome.load_dict(with_parts(DICT, sky={"type": "envmap", "bitmap": sky}))
        self.assertFalse(np.array_equal(kinome.render(lit), expected))
        bytes_of = kinome.load_dict(with_parts(DICT, red={
            "type": "diffuse", "reflectance": {"type": "bitmap",
                                               "bitmap": np.full((1, 1), 188, np.uint8)}}))
        linear = kinome.traverse(bytes_of)["red.reflectance.data"]
        self.assertAlmostEqual(float(linear[0, 0, 0]), ((188 / 255 + 0.055) / 1.055) ** 2.4, 5)

    def test_meshes(self):
        (self.folder / "t.ply").write_text(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
            "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
            "-1 0 0\n1 0 0\n0 2 0\n3 0 1 2\n")
        scene = kinome.load_dict(with_parts(DICT, mesh={
            "type": "ply", "filename": str(self.folder / "t.ply"),
            "bsdf": {"type": "ref", "id": "red"}}))
        before = kinome.render(scene)
        parameters = kinome.traverse(scene)
        np.testing.assert_array_equal(parameters["mesh.faces"], [0, 1, 2])
        for wrong in ([0, 1, -1], [0, 1, 1.7], [0, 1, 2**32 + 2], [0, 1, 2**70]):
            with self.assertRaisesRegex(ValueError, "mesh.faces: numbers of vertices are whole"):
                parameters["mesh.faces"] = wrong
        positions = parameters["mesh.vertex_positions"].reshape(-1, 3)
        changes = parameters.update({"mesh.vertex_positions": positions + [0, 0, 1.5]})
        self.assertEqual((changes.made, changes.refitted, changes.has_new_structure), ([], 1, True))
        self.assertFalse(np.array_equal(kinome.render(scene), before))
        parameters.update({"mesh.vertex_positions": positions})
        np.testing.assert_array_equal(kinome.render(scene), before)

    def test_progress_and_passes(self):
        scene = self.load(spp=64)
        fractions, passes = [], []
        picture = kinome.render(scene, progress=fractions.append)
        self.assertEqual(fractions, sorted(fractions))
        self.assertEqual(fractions[-1], 1)
        last = kinome.render(scene, on_pass=lambda p, n: passes.append((n, p.copy())))
        self.assertEqual(passes[-1][0], 64)
        self.assertEqual(last.stats["samples"], 64)
        np.testing.assert_array_equal(passes[-1][1], last)
        np.testing.assert_allclose(np.mean(last), np.mean(picture), rtol=0.05)

        def fail(fraction):
            raise ZeroDivisionError("enough")
        with self.assertRaisesRegex(ZeroDivisionError, "enough"):
            kinome.render(scene, spp=100000, progress=fail)

    def test_a_callback_may_not_use_its_scene_but_may_ask_for_it(self):
        scene = self.load(spp=4)
        refused = []

        def look(picture, samples):
            for use in (lambda: kinome.render(scene, spp=1), lambda: kinome.traverse(scene).update()):
                with self.assertRaisesRegex(kinome.Error, "is being rendered or updated"):
                    use()
                refused.append(samples)
            self.assertTrue(list(kinome.traverse(scene)))
        kinome.render(scene, on_pass=look)
        self.assertTrue(refused)
        kinome.render(scene, spp=1)  # and it is free again

    def test_ctrl_c_gives_what_there_is(self):
        scene = self.load()
        threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        start = time.monotonic()
        picture = kinome.render(scene, spp=1000000)
        self.assertLess(time.monotonic() - start, 60)
        self.assertFalse(picture.stats["complete"])
        self.assertGreater(np.mean(picture.rgb), 0)
        self.assertTrue(kinome.render(scene).stats["complete"])

    def test_other_threads_run_meanwhile(self):
        steps, done = [0], threading.Event()

        def count():
            while not done.is_set():
                steps[0] += 1
                time.sleep(0.001)
        counter = threading.Thread(target=count)
        counter.start()
        seconds = kinome.render(self.load(), time=0.5).stats["seconds"]
        done.set()
        counter.join()
        # With the lock it would have been a handful.
        self.assertGreater(steps[0], 50 * seconds)

    def test_budgets_variance_and_comparison(self):
        scene = self.load(spp=32)
        a = kinome.render(scene, variance=16)
        b = kinome.render(scene, variance=16, seed=1)
        self.assertEqual(a["variance"].shape, (30, 40, 3))
        self.assertTrue(kinome.compare(a, b, alpha=1e-6).passed)
        darker = kinome.load_dict(with_parts(DICT, sky={"type": "constant", "radiance": 0.4}))
        self.assertFalse(kinome.compare(kinome.render(darker, spp=32, variance=16), b,
                                        alpha=1e-6).passed)
        self.assertTrue(kinome.compare([kinome.render(scene, seed=i) for i in range(4)], b,
                                       alpha=1e-6).passed)
        by_error = kinome.render(scene, error=1e-3)
        self.assertLess(by_error.stats["relmse"], 1e-3)
        # What is written is what kinome-compare reads.
        for picture, name in ((a, "a.exr"), (b, "b.exr")):
            picture.write(self.folder / name)
        compare = pathlib.Path(__file__).resolve().parents[2] / "validation/kinome-compare"
        subprocess.run([compare, "-q", "--alpha", "1e-6", self.folder / "a.exr",
                        self.folder / "b.exr"], check=True, stdout=subprocess.DEVNULL)

    def test_plugins_and_inspection(self):
        tables = {(p["category"], p["name"]): p for p in kinome.plugins()}
        diffuse = {row["name"]: row for row in tables["bsdf", "diffuse"]["parameters"]}
        self.assertEqual(diffuse["reflectance"]["default"], "0.5")
        found = kinome.inspect(self.load(), 20, 15, integrator="clustered")
        self.assertTrue(found[0]["clusters"])

    def test_errors_have_their_places(self):
        self.path.write_text(SCENE.replace("diffuse", "difuse").replace("sphere", "spere"))
        with self.assertRaises(kinome.Error) as caught:
            self.load()
        error = caught.exception
        self.assertEqual((pathlib.Path(error.file).name, error.line), ("scene.xml", 14))
        self.assertIn("did you mean 'diffuse'?", error.message)
        self.assertTrue(str(error).startswith(f"{self.path}:14:"))
        self.assertEqual(len(error.all), 2)
        with self.assertRaisesRegex(kinome.Error, "^scene.red.reflectance: .*outside"):
            kinome.load_dict(with_parts(DICT, red={"type": "diffuse", "reflectance": 2.0}))
        with self.assertRaisesRegex(kinome.Error, "^scene.red: there is no plugin 'difuse'"):
            kinome.load_dict(with_parts(DICT, red={"type": "difuse"}))
        with self.assertRaisesRegex(kinome.Error, "did you mean 'sensor.near_clip'"):
            kinome.traverse(kinome.load_dict(DICT))["sensor.near_clp"] = 1.0
        with self.assertRaisesRegex(TypeError, "scene.red.reflectance"):
            kinome.load_dict(with_parts(DICT, red={"type": "diffuse", "reflectance": [1, 2]}))
        with self.assertRaises(ValueError):
            kinome.render(kinome.load_dict(DICT), spp=0)


class Documentation(unittest.TestCase):
    def test_examples_run(self):
        """All of the page's, one after the other, of smaller pictures."""
        page = pathlib.Path(__file__).resolve().parents[2] / "docs/python.md"
        text = "\n".join(re.findall(r"^```python\n(.*?)^```", page.read_text("utf-8"),
                                     re.MULTILINE | re.DOTALL))
        for large, small in (('480, "height": 320', '48, "height": 32'), ("240, 160", "24, 16")):
            self.assertIn(large, text)
            text = text.replace(large, small)
        shown = []
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "scene.xml").write_text(SCENE)
            before = os.getcwd()
            self.addCleanup(os.chdir, before)
            os.chdir(folder)
            names = {"show": shown.append}
            with contextlib.redirect_stdout(io.StringIO()):
                exec(compile(text, str(page), "exec"), names)  # noqa: S102
            os.chdir(before)
        self.assertEqual(len(shown), 9)
        self.assertTrue(names["verdict"].passed)
        made = names["changes"].made
        self.assertEqual(set(made),
                         {"bsdf/roughconductor", "sampler/independent", "sensor/perspective"})


def read_exr(path):
    """Its colour, by Debian's OpenImageIO."""
    import OpenImageIO as oiio
    return oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT)[:, :, :3]


if __name__ == "__main__":
    unittest.main()
