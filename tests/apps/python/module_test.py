"""Tests of the Python module: the program's images, dicts, edits, arguments and errors.

KINOME_BUILD is the build folder. With KINOME_PACKAGE, the installed module is tested.
"""
import contextlib
import copy
import io
import os
import pathlib
import pickle
import re
import subprocess
import sys
import tempfile
import unittest

import numpy as np

from small_scene import DICT, SCENE, SceneTest, kinome, read_exr, with_parts


class ModuleTest(SceneTest):
    def test_gives_the_programs_image(self):
        ours = kinome.render(self.load(spp=9), seed=3)
        self.assertEqual((ours.shape, ours.dtype), ((30, 40, 3), np.float32))
        self.assertEqual(ours.channels, ["R", "G", "B"])
        self.assertTrue(ours.stats["complete"])
        np.testing.assert_array_equal(ours, self.program("-D", "spp=9", "--seed", "3"))
        # The array is a view of the core's memory.
        self.assertIsNotNone(ours.base)
        self.assertFalse(ours.flags.owndata)
        np.testing.assert_array_equal(kinome.render(self.load(), spp=9, seed=3, threads=1), ours)

    def test_a_scene_from_a_text(self):
        scene = kinome.load_string(SCENE, spp=9)
        np.testing.assert_array_equal(kinome.render(scene), kinome.render(self.load(spp=9)))
        parameters = kinome.traverse(scene)
        parameters.update({"red.reflectance.value": [0.1, 0.2, 0.3]})
        parameters.save(self.folder / "saved.xml")
        np.testing.assert_array_equal(kinome.render(kinome.load_file(self.folder / "saved.xml")),
                                      kinome.render(scene))
        with self.assertRaisesRegex(kinome.Error, "^<string>:14:.*did you mean 'diffuse'"):
            kinome.load_string(SCENE.replace("diffuse", "difuse"))
        with self.assertRaisesRegex(TypeError, "string takes the text of a scene file, got 5"):
            kinome.load_string(5)

    def test_mitsubas_arguments_without_effect(self):
        expected = kinome.render(self.load(), spp=1)
        for scene in (self.load(parallel=False, optimize=False, update_scene=True),
                      kinome.load_string(SCENE, parallel=False, optimize=False),
                      kinome.load_dict(DICT, parallel=False, optimize=False)):
            np.testing.assert_array_equal(kinome.render(scene, spp=1), expected)

    def test_a_dict_is_a_scene_as_well(self):
        np.testing.assert_array_equal(kinome.render(kinome.load_dict(DICT)),
                                      kinome.render(self.load()))

    def test_a_dict_in_the_manner_of_a_cornell_box(self):
        """Tests features of Mitsuba's dicts: references by id, matrices, and parameters without
        effect."""
        def wall(color, *rows):
            return {"type": "rectangle", "to_world": np.array([*rows, [0, 0, 0, 1]], float),
                    "bsdf": {"type": "ref", "id": color}}

        light = wall("white", [0.3, 0, 0, 0], [0, 0, -0.3, 0.99], [0, 0.3, 0, 0])
        light["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": [9, 8, 7]}}
        scene = kinome.load_dict({
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 8},
            "sensor": {
                "type": "perspective", "fov_axis": "smaller", "near_clip": 0.001, "far_clip": 100.0,
                "focus_distance": 1000, "fov": 39.3,
                "to_world": kinome.Transform().look_at([0, 0, 4], [0, 0, 0], [0, 1, 0]),
                "sampler": {"type": "independent", "sample_count": 4},
                "film": {"type": "hdrfilm", "width": 8, "height": 8, "rfilter": {"type": "gaussian"},
                         "pixel_format": "rgb", "component_format": "float32"},
            },
            "white": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.9, 0.9, 0.9]}},
            "left-red": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.6, 0.1, 0.1]}},
            "light": light,
            "back": wall("white", [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, -1]),
            "red-wall": wall("left-red", [0, 0, 1, -1], [0, 1, 0, 0], [-1, 0, 0, 0]),
            "box": {"type": "cube", "to_world": kinome.Transform().scale(0.3),
                    "bsdf": {"type": "ref", "id": "white"}},
        })
        self.assertGreater(float(np.min(kinome.render(scene).rgb.mean(axis=(0, 1)))), 0.01)

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
        mixed = kinome.Picture(np.arange(12.).reshape(1, 2, 6), ["a.R", "b.R", "a.G", "b.G", "a.B", "b.B"])
        np.testing.assert_array_equal(mixed["b"], np.asarray(mixed)[..., 1::2])
        with self.assertRaises(KeyError):
            aov["albedo"]
        with self.assertRaisesRegex(kinome.Error, "no sensor '1'"):
            kinome.render(scene, sensor=1)

    def test_edits_give_the_image_of_the_edited_file(self):
        scene = self.load()
        parameters = kinome.traverse(scene)
        self.assertIn("red.reflectance.value", parameters)
        self.assertNotIn("red.reflectanc.value", parameters)
        self.assertEqual(parameters.get("red.reflectanc.value", 3), 3)
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

    def test_pixels_of_integers(self):
        """Follows mi.Bitmap of Mitsuba 3.9.1: only bytes are encoded, and the largest value is 1.
        """
        def first_texel(value, kind, raw=False):
            pixels = np.full((1, 1), value, kind)
            scene = kinome.load_dict(with_parts(DICT, red={
                "type": "diffuse",
                "reflectance": {"type": "bitmap", "bitmap": pixels, "raw": raw}}))
            return float(kinome.traverse(scene)["red.reflectance.data"][0, 0, 0])

        for kind, value in ((np.uint16, 2 ** 15), (np.uint32, 2 ** 31), (np.int8, 64),
                            (np.int16, 2 ** 14), (np.int32, 2 ** 30)):
            self.assertAlmostEqual(first_texel(value, kind), value / np.iinfo(kind).max, 6)
        self.assertAlmostEqual(first_texel(128, np.uint8, raw=True), 128 / 255, 6)
        self.assertAlmostEqual(first_texel(0.5, np.float16), 0.5, 6)
        for kind in (np.int64, np.uint64):
            with self.assertRaisesRegex(TypeError, f"of the type {np.dtype(kind)} have no scale"):
                first_texel(1, kind)

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
            with self.assertRaisesRegex(ValueError, "mesh.faces: vertex indices must be whole"):
                parameters["mesh.faces"] = wrong
        positions = parameters["mesh.vertex_positions"].reshape(-1, 3)
        changes = parameters.update({"mesh.vertex_positions": positions + [0, 0, 1.5]})
        self.assertEqual((changes.made, changes.refitted, changes.has_new_structure), ([], 1, True))
        self.assertFalse(np.array_equal(kinome.render(scene), before))
        parameters.update({"mesh.vertex_positions": positions})
        np.testing.assert_array_equal(kinome.render(scene), before)

    def test_no_file_that_a_scene_reads_is_written_over(self):
        sky, text = self.folder / "sky.exr", self.folder / "sky.xml"
        kinome.Picture(np.ones((2, 4, 3), np.float32), ["R", "G", "B"]).write(sky)
        before = sky.read_bytes()
        text.write_text(re.sub('<emitter type="constant".*', '<emitter type="envmap">'
                               '<string name="filename" value="sky.exr"/></emitter>', SCENE))
        scene = kinome.load_file(text, spp=1)
        picture = kinome.render(scene)
        with self.assertRaisesRegex(kinome.Error, "sky.exr': this file was read"):
            picture.write(sky)
        other, own = map(kinome.traverse, (kinome.load_dict(DICT), scene))
        for path in (sky, text):
            with self.assertRaisesRegex(kinome.Error, "this file was read"):
                other.save(path)
        own.save(text)
        self.assertEqual(sky.read_bytes(), before)
        del scene, own
        picture.write(sky)

    def test_channels_keep_their_names(self):
        picture = kinome.render(self.load(), variance=4, integrator={
            "type": "aov", "aovs": "dd:depth,sn:sh_normal", "nested": {"type": "path"}})
        names = picture.channels
        self.assertEqual(names[:3], ["R", "G", "B"])
        for key, expected in (((slice(None), slice(None), slice(3)), names[:3]),
                              ((Ellipsis, slice(None, None, -1)), names[::-1]),
                              ((Ellipsis, [4, 0]), [names[4], names[0]]),
                              ((Ellipsis, np.array([n.startswith("sn") for n in names])),
                               [n for n in names if n.startswith("sn")]),
                              (slice(2, 9), names), (Ellipsis, names)):
            part = picture[key]
            self.assertEqual(part.channels, expected, key)
            self.assertEqual(part.shape[2], len(expected))
            for i, name in enumerate(expected):
                np.testing.assert_array_equal(part[..., i], np.asarray(picture)[key][..., i])
        # A single channel, a row or another order gives a plain array, or one without names.
        for key in (0, (0, 0), (Ellipsis, 1), (slice(None), [1, 2]), picture[..., 0] > 0.5, None):
            self.assertIs(type(picture[key]), np.ndarray, key)
        for other in (picture.T, picture.reshape(-1), picture.swapaxes(0, 1)):
            self.assertEqual((getattr(other, "channels", []), getattr(other, "stats", {})), ([], {}))
        for other in (picture.mean(axis=2), picture.sum(axis=(0, 1)), np.asarray(picture)):
            self.assertIs(type(other), np.ndarray)
        self.assertIsInstance(picture.mean(), np.floating)
        # Statistics of a whole image aren't valid for a part of it, nor for twice the image.
        self.assertEqual(picture[...].stats, picture.stats)
        self.assertNotIn("renders", picture[1:].stats)
        self.assertTrue(picture[1:].stats["complete"])
        half = (picture + picture.copy()) / 4
        self.assertEqual((half.channels, half.stats), (names, {}))
        np.testing.assert_array_equal(half.rgb, np.asarray(picture)[:, :, :3] / 2)
        self.assertIs(type(picture @ np.eye(len(names), dtype=np.float32)), np.ndarray)
        for same in (picture.copy(), picture.astype(np.float64), copy.deepcopy(picture),
                     pickle.loads(pickle.dumps(picture))):
            self.assertEqual((same.channels, same.stats), (names, picture.stats))
            np.testing.assert_array_equal(same["dd"], picture["dd"])
        before = picture.copy()
        picture *= 2
        self.assertEqual(picture.channels, names)
        np.testing.assert_array_equal(picture, 2 * np.asarray(before))
        half[:, :, :3].write(self.folder / "half.exr")
        np.testing.assert_array_equal(read_exr(self.folder / "half.exr"), half.rgb)
        self.assertEqual(kinome.Picture(np.ones((2, 3, 1)), ["Y"]).rgb.shape, (2, 3, 1))
        for wrong, message in ((lambda: kinome.Picture(np.ones((2, 3, 2)), ["Y"]), "1 channel"),
                               (lambda: picture[:, :, 3:].rgb, "no colour among"),
                               (lambda: picture.T.write("x.exr"), "have no names")):
            with self.assertRaisesRegex(ValueError, message):
                wrong()

    def test_arguments(self):
        """An error is one line, which names the argument and states the accepted values."""
        scene, parameters = self.load(), kinome.traverse(self.load())
        pictures = [kinome.render(scene, spp=1) for _ in range(4)]
        whole = "takes a whole number from"
        turn = kinome.Transform()
        for error, message, call in (
                (TypeError, "^scene takes what load_file", lambda: kinome.render(None)),
                (TypeError, "^scene takes what load_file", lambda: kinome.traverse(self.path)),
                (TypeError, "^scene takes what load_file", lambda: kinome.inspect("x", 1, 1)),
                (TypeError, f"^spp {whole} 1 to .*, got 1.5", lambda: kinome.render(scene, spp=1.5)),
                (TypeError, f"^spp {whole} 1 to .*, got '4'", lambda: kinome.render(scene, spp="4")),
                (ValueError, f"^spp {whole} 1 to .*, got 0", lambda: kinome.render(scene, spp=0)),
                (ValueError, f"^spp {whole} 1 to", lambda: kinome.render(scene, spp=2 ** 40)),
                (ValueError, f"^seed {whole} 0 to .*, got -1", lambda: kinome.render(scene, seed=-1)),
                (ValueError, f"^seed {whole}", lambda: kinome.inspect(scene, 1, 1, seed=2 ** 64)),
                (TypeError, f"^seed {whole}", lambda: kinome.render(scene, seed=None)),
                (ValueError, f"^threads {whole}", lambda: kinome.render(scene, threads=-1)),
                (ValueError, f"^variance {whole} 4", lambda: kinome.render(scene, variance=3)),
                (TypeError, f"^variance {whole} 4", lambda: kinome.render(scene, variance=True)),
                (ValueError, "^time takes a finite", lambda: kinome.render(scene, time=0)),
                (TypeError, "^time takes a finite", lambda: kinome.render(scene, time="1")),
                (ValueError, "^error takes", lambda: kinome.render(scene, error=float("nan"))),
                (TypeError, "^sensor takes an index, an id or", lambda: kinome.render(scene, sensor=1.5)),
                (ValueError, "^sensor takes .* an id or a sensor", lambda: kinome.render(scene, sensor=-1)),
                (TypeError, "^integrator takes", lambda: kinome.render(scene, integrator=3)),
                (TypeError, "^progress takes", lambda: kinome.render(scene, progress=True)),
                (TypeError, "^on_pass takes", lambda: kinome.render(scene, on_pass=3)),
                (TypeError, "^x takes", lambda: kinome.inspect(scene, "a", 1)),
                (TypeError, "^a takes a picture by", lambda: kinome.compare(3, pictures)),
                (ValueError, "^a takes .* without a vari", lambda: kinome.compare(pictures[0], 3)),
                (ValueError, "^a takes .* of seed 0", lambda: kinome.compare(pictures, pictures)),
                (ValueError, "^a: 1 renders", lambda: kinome.compare(pictures[:1], pictures)),
                (ValueError, "^alpha takes", lambda: kinome.compare(pictures, pictures, alpha=2)),
                (TypeError, "^path takes a path", lambda: kinome.load_file(3)),
                (TypeError, "^search_paths takes a list",
                 lambda: kinome.load_file(self.path, search_paths="textures")),
                (TypeError, "^search_paths takes", lambda: kinome.load_dict(DICT, search_paths=3)),
                (TypeError, "^path takes a path", lambda: pictures[0].write(None)),
                (ValueError, "^level takes one of", lambda: kinome.set_log_level("loud")),
                (TypeError, "^a parameter's path takes", lambda: parameters[3]),
                (TypeError, "^values takes a dict", lambda: parameters.update([1])),
                (TypeError, "^matrix takes a 4x4", lambda: kinome.Transform([1, 2, 3])),
                (TypeError, "^offset takes three", lambda: turn.translate([1, 2])),
                (TypeError, "^factor takes a number or three", lambda: turn.scale("a")),
                (TypeError, "^angle takes", lambda: turn.rotate([0, 1, 0], "a")),
                (ValueError, "^axis is the zero", lambda: turn.rotate([0, 0, 0], 1)),
                (ValueError, "^up has", lambda: turn.look_at([0, 0, 0], [0, 1, 0], [0, 2, 0])),
                (ValueError, "too large",
                 lambda: kinome.load_dict(with_parts(DICT, s={"type": "sphere", "radius": 2**70}))),
                (kinome.Error, "^scene.red.reflectance: an rgb needs", lambda: kinome.load_dict(
                    with_parts(DICT, red={"type": "diffuse", "reflectance": {"type": "rgb"}}))),
                (kinome.Error, "^scene.ball.bsdf: a ref needs an 'id'", lambda: kinome.load_dict(
                    with_parts(DICT, ball={"type": "sphere", "bsdf": {"type": "ref"}})))):
            with self.subTest(message), self.assertRaisesRegex(error, message) as caught:
                call()
            self.assertNotIn("\n", str(caught.exception))
        for number in (np.int64(4), np.uint8(4)):
            self.assertEqual(kinome.render(scene, spp=number).stats["samples"], 4)

    def test_has_the_programs_version(self):
        said = subprocess.run([sys.executable, "-m", "kinome", "--version"], check=True, text=True,
                              env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
                              stdout=subprocess.PIPE).stdout
        self.assertIn(f"kinome {kinome.__version__}", said)

    def test_a_module_of_the_users_called_compare(self):
        (self.folder / "compare.py").write_text("raise ImportError('the user has his own')")
        self.said_by(f"sys.path.insert(0, {str(self.folder)!r})\n"
                     "pictures = [kinome.render(kinome.load_file(sys.argv[1]), seed=i)\n"
                     "            for i in range(8)]\n"
                     "sys.modules['scipy'] = None\n"
                     "try:\n"
                     "    raise SystemExit(kinome.compare(pictures[:4], pictures[4:]))\n"
                     "except ImportError as reason:\n"
                     "    assert 'compare needs scipy' in str(reason), reason\n"
                     "del sys.modules['scipy']\n"
                     "kinome.compare(pictures[:4], pictures[4:])\n"
                     "assert 'compare' not in sys.modules\n")

    def test_plugins_and_inspection(self):
        tables = {(p["category"], p["name"]): p for p in kinome.plugins()}
        diffuse = {row["name"]: row for row in tables["bsdf", "diffuse"]["parameters"]}
        self.assertEqual(diffuse["reflectance"]["default"], "0.5")
        found = kinome.inspect(self.load(), 20, 15, integrator="clustered")
        self.assertTrue(found[0]["clusters"])

    def test_errors_have_their_positions(self):
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
        with self.assertRaisesRegex(kinome.Error, "^scene.red: there is no plugin 'difuse' "
                                    r"\(did you mean 'diffuse'\?\)$"):
            kinome.load_dict(with_parts(DICT, red={"type": "difuse"}))
        with self.assertRaisesRegex(kinome.Error, "did you mean 'sensor.near_clip'"):
            kinome.traverse(kinome.load_dict(DICT))["sensor.near_clp"] = 1.0
        with self.assertRaisesRegex(TypeError, "scene.red.reflectance"):
            kinome.load_dict(with_parts(DICT, red={"type": "diffuse", "reflectance": [1, 2]}))


class Documentation(unittest.TestCase):
    def test_examples_run(self):
        """Runs all examples of the page in order, with smaller images."""
        import matplotlib.image
        matplotlib.use("Agg")
        page = pathlib.Path(__file__).resolve().parents[3] / "docs/python.md"
        text = "\n".join(re.findall(r"^```python\n(.*?)^```", page.read_text("utf-8"),
                                     re.MULTILINE | re.DOTALL))
        for large, small in (('480, "height": 320', '48, "height": 32'), ("240, 160", "24, 16")):
            self.assertIn(large, text)
            text = text.replace(large, small)
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "scene.xml").write_text(SCENE)
            matplotlib.image.imsave(pathlib.Path(folder) / "wood.png", np.eye(4))
            before = os.getcwd()
            self.addCleanup(os.chdir, before)
            os.chdir(folder)
            names, printed = {}, io.StringIO()
            with contextlib.redirect_stdout(printed):
                exec(compile(text, str(page), "exec"), names)  # noqa: S102
            os.chdir(before)
        self.assertGreater(printed.getvalue().count("samples per pixel: "), 4)
        self.assertTrue(names["verdict"].passed)
        made = names["changes"].made
        self.assertEqual(set(made),
                         {"bsdf/roughconductor", "sampler/independent", "sensor/perspective"})


if __name__ == "__main__":
    unittest.main()
