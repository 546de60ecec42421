#!/usr/bin/python3
"""Tests of kinome-view with scripts instead of a window: edits during a render, their results,
memory and saved files. KINOME_BUILD is the build folder.
"""
import os
import pathlib
import random
import re
import subprocess
import tempfile
import unittest

import numpy as np

from scenes import BUILD, PROGRAM, SCENE, write_scene

EDITS = 200
MEMORY_EDITS = 1000


class SessionTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.scene = write_scene(self.folder)

    def run_script(self, lines, scene=None, errors=0):
        """Returns the output of a script and checks the number of errors."""
        result = subprocess.run(
            [PROGRAM, scene or self.scene, "-t", "2", "--script", "-"], cwd=self.folder,
            input="\n".join(lines), text=True, capture_output=True, timeout=2000)
        told = [line for line in result.stderr.splitlines() if line.startswith("kinome-view: -:")]
        self.assertEqual(len(told), errors, result.stdout + result.stderr)
        self.assertEqual(result.returncode, 1 if errors else 0, result.stderr)
        return result.stdout + (result.stderr if errors else "")

    def random_edits(self, count, seed):
        """Returns script lines that set parameters of all types, each followed by a "wait"."""
        dice = random.Random(seed)
        rows = [line.split("\t") for line in self.run_script(["parameters"]).splitlines()]
        makers = {
            "float": lambda: f"{dice.uniform(0.05, 2):.6f}",
            "transform": lambda: f"1 0 0 {dice.uniform(-1, 1):.4f} 0 1 0 0 0 0 1 0 0 0 0 1",
            "boolean": lambda: dice.choice(["true", "false"]),
            "emission": lambda: " ".join(f"{dice.uniform(0, 5):.6f}" for _ in range(3)),
            "reflectance texture": lambda: " ".join(f"{dice.uniform(0, 1):.6f}" for _ in range(3)),
            "vector": lambda: " ".join(f"{dice.uniform(0.5, 1.5):.6f}" for _ in range(3)),
        }
        left_out = re.compile(r"film|sampler|clip|shutter|principal|camera.to_world")
        usable = [(path, kind) for path, kind, _ in rows
                  if kind in makers and not left_out.search(path)]
        self.assertGreater(len(usable), 15)
        lines, around = [], set()

        def now(path):
            """Returns the current path of a parameter of a BSDF, which depends on whether a map is
            around it."""
            bsdf, _, rest = path.partition(".")
            return f"{bsdf}.bsdf.{rest}" if bsdf in around else path
        for _ in range(count):
            if dice.random() < 0.2:
                lines += [f"orbit {dice.uniform(-20, 20):.4f} {dice.uniform(-5, 5):.4f}", "wait"]
            elif dice.random() < 0.2:
                lines += [self.random_put(dice, now, around), "wait"]
            else:
                path, kind = dice.choice(usable)
                lines += [f"set {now(path)} {makers[kind]()}", "wait"]
        return lines

    @staticmethod
    def random_put(dice, now, around):
        """Returns a line that adds a texture or a map, or removes one."""
        image = dice.choice(["bumps.ppm", "sky.pfm"])
        bsdf = dice.choice(["red", "grey"])
        texture = dice.choice(["red.reflectance", "grey.diffuse_reflectance", "grey.specular_reflectance"])
        do = dice.randrange(4)
        if do == 0:
            return f"texture {now(texture)} {dice.choice([image, 'checkerboard'])}"
        if do == 1:
            around.add(bsdf)
            return f"{dice.choice(['normalmap', 'bumpmap'])} {bsdf} {image}"
        if do == 2:
            around.discard(bsdf)
            return f"unset {bsdf}"
        return f"{dice.choice(['unset', 'revert'])} {now(texture)}"

    def picture(self, path):
        import OpenImageIO as oiio
        pixels = oiio.ImageBuf(str(self.folder / path)).get_pixels(oiio.FLOAT)
        self.assertGreater(np.std(pixels[..., :3]), 0)
        return pixels

    def test_edits_end_in_the_picture_of_the_scene_that_is_saved(self):
        lines = self.random_edits(EDITS, 1)
        out = subprocess.run(
            [PROGRAM, self.scene, "-t", "2", "--script", "-"], cwd=self.folder, text=True,
            input="\n".join([*lines, "save saved.xml", "render 3", "picture a.exr"]),
            capture_output=True, timeout=2000)
        # Some values are invalid for any plugin. These edits report an error and change nothing.
        self.assertLess(out.stdout.count("error: "), EDITS // 4, out.stdout)
        self.run_script(["render 3", "picture b.exr"], scene="saved.xml")
        self.assertEqual((self.folder / "a.exr").read_bytes(), (self.folder / "b.exr").read_bytes())
        # The command-line program renders the same image of it.
        saved = (self.folder / "saved.xml").read_text()
        self.assertIn("<!-- Kept by whoever saves it. -->", saved)
        (self.folder / "saved.xml").write_text(
            saved.replace('name="sample_count" value="2"', 'name="sample_count" value="3"'))
        subprocess.run([BUILD / "bin/kinome", "saved.xml", "-t", "1", "-q", "-o", "c.exr"],
                       cwd=self.folder, check=True, timeout=1000)
        a, c = self.picture("a.exr"), self.picture("c.exr")
        np.testing.assert_array_equal(a, c)
        # The comparison is sensitive: another edit gives another image.
        self.run_script(["set camera.fov 60", "set red.reflectance.value 0.1 0.9 0.1",
                         "set ball.radius 0.7", "render 3", "picture d.exr"], scene="saved.xml")
        self.assertFalse(np.array_equal(a, self.picture("d.exr")))

    def test_pictures_of_nested_integrators_have_light_groups(self):
        """Previews, which are rendered by `path`, have them, too. A moving camera shows only previews."""
        scene = self.folder / "groups.xml"
        scene.write_text(self.scene.read_text().replace(
            """<integrator type="path"><integer name="max_depth" value="4"/></integrator>""",
            """<integrator type="aov"><string name="light_groups" value="all"/>
            <integrator type="clustered" id="nested"><integer name="max_depth" value="4"/></integrator>
            </integrator>"""))
        moves = ["orbit 1 0", "sleep 0.05"] * 20
        self.run_script(["samples 1", "render 2", "picture a.exr", *moves, "picture preview.exr"], scene)
        import OpenImageIO as oiio
        for name in ("a.exr", "preview.exr"):
            image = oiio.ImageBuf(str(self.folder / name))
            names, pixels = list(image.spec().channelnames), image.get_pixels(oiio.FLOAT)
            layers = [pixels[..., [names.index(f"lights.{group}.{c}") for c in "RGB"]]
                      for group in ("lamp", "sky")]
            self.assertGreater(min(layer.mean() for layer in layers), 0.01)
            np.testing.assert_allclose(sum(layers), pixels[..., [names.index(c) for c in "RGB"]],
                                       rtol=1e-5, atol=1e-6)

    def test_previews_are_denoised_on_request(self):
        """The fake library of tests/apps/cli prints its calls. The final image isn't denoised."""
        def run(*lines, library=BUILD / "tests/apps/cli/fake_oidn"):
            return subprocess.run(
                [PROGRAM, self.scene, "-t", "2", "--script", "-"], cwd=self.folder, text=True,
                input="\n".join(lines), capture_output=True, timeout=1000,
                env=os.environ | {"KINOME_OIDN": str(library), "FAKE_OIDN": "log"}).stderr
        edits = ["set camera.fov 60", "wait", "sleep 0.5", "render 2", "picture a.exr"]
        calls = run("denoise on", *edits)
        self.assertIn("fake: albedo color normal cleanAux=1 hdr=1 threads=2\n", calls)
        self.assertEqual(run(*edits[:-1], "picture b.exr"), "")
        self.assertEqual((self.folder / "a.exr").read_bytes(), (self.folder / "b.exr").read_bytes())
        self.assertIn("pip install pyoidn", run("denoise on", "wait", library="/nowhere"))

    def test_memory_does_not_grow_by_edits(self):
        lines = self.random_edits(MEMORY_EDITS, 2)
        some = len(lines) // 4
        # Some of the edits are invalid for any plugin.
        out = subprocess.run(
            [PROGRAM, self.scene, "-t", "2", "--script", "-"], cwd=self.folder, text=True,
            input="\n".join([*lines[:some], "memory", *lines[some:], "wait", "memory"]),
            capture_output=True, timeout=2500)
        before, after = [int(n) for n in re.findall(r"memory (\d+)", out.stdout)]
        # A film of 32 x 24 pixels per edit would take more than ten times as much.
        self.assertLess(after - before, 8e6, out.stderr)

    def test_invalid_edits_leave_the_scene_unchanged(self):
        self.run_script(["render 2", "picture a.exr"])
        out = self.run_script(["set sky.filename nowhere.exr", "wait", "set red.reflectance.value 2",
                               "set camera.fov -3", "set ball.radius nan", "integrator nonsense",
                               "wait", "render 2", "picture b.exr"], errors=5)
        self.assertIn("nowhere.exr", out)
        self.assertEqual((self.folder / "a.exr").read_bytes(), (self.folder / "b.exr").read_bytes())

    def test_edits_are_taken_back(self):
        self.run_script(["render 2", "picture a.exr", "set ball.radius 0.5", "wait",
                         "set red.reflectance.value 0 1 0", "wait", "undo", "undo", "wait",
                         "render 2", "picture b.exr"])
        self.assertEqual((self.folder / "a.exr").read_bytes(), (self.folder / "b.exr").read_bytes())

    def test_textures_and_maps_are_put_and_taken_back(self):
        text = self.scene.read_text()
        edits = ["texture red.reflectance.value bumps.ppm", "bumpmap red bumps.ppm",
                 "set red.bsdf.reflectance.to_uv 4 0 0 0 0 4 0 0 0 0 1 0 0 0 0 1",
                 "texture grey.specular_reflectance.value bumps.ppm", "normalmap grey bumps.ppm",
                 "set red.bsdf.reflectance.value 0.1 0.2 0.3", "unset grey.bsdf.specular_reflectance.value"]
        shown = [line for i, edit in enumerate(edits)
                 for line in (edit, "render 2", f"picture {i}.exr", f"save {i}.xml")]
        back = [line for i in range(len(edits)) for line in ("undo", "wait")]
        self.run_script(["render 2", "picture first.exr", *shown, *back, "render 2",
                         "picture last.exr", "save last.xml"])
        pictures = [(self.folder / f"{i}.exr").read_bytes() for i in ["first", *range(len(edits))]]
        self.assertEqual(len(set(pictures)), len(pictures))
        self.assertEqual((self.folder / "last.exr").read_bytes(), pictures[0])
        self.assertEqual((self.folder / "last.xml").read_text(), text)
        self.run_script(["render 2", "picture again.exr"], scene="6.xml")
        self.assertEqual((self.folder / "again.exr").read_bytes(), pictures[-1])

    def test_undone_defaults_are_not_saved(self):
        text = self.scene.read_text()
        self.run_script(["set camera.near_clip 0.5", "wait", "undo", "unset sky.filename", "wait",
                         "set grey.nonlinear true", "wait", "undo", "save a.xml"], errors=1)
        self.assertEqual((self.folder / "a.xml").read_text(), text)

    def test_refused_edits_cost_no_samples(self):
        samples = [int(s) for s in re.findall(r"samples (\d+)", self.run_script([
            "wait", "sleep 2.5", "samples", "undo", "set red.reflectance.value 2", "wait",
            "sleep 0.3", "samples"], errors=1))]
        self.assertGreater(samples[0], 8)
        self.assertGreaterEqual(samples[1], samples[0])

    def test_only_a_region_is_rendered_on(self):
        (self.folder / "scene.xml").write_text(SCENE.format(width=64, height=48))
        self.run_script(["samples 8", "region 30 20 6 4", "wait", "picture a.exr", "samples 80",
                         "picture b.exr"])
        a, b = self.picture("a.exr"), self.picture("b.exr")
        # Tiles of small images have 16 pixels. The reconstruction filter extends them by two.
        differs = (a != b).any(axis=2)
        ys, xs = np.nonzero(differs)
        self.assertTrue(differs[20:24, 30:36].all())
        self.assertTrue(14 <= xs.min() and xs.max() < 50 and 14 <= ys.min() and ys.max() < 34)
        self.run_script(["region 1 2 3", "region 0 0 0 4", "region"], errors=2)
        self.assertIn("the region is outside of the image",
                      self.run_script(["region 64 0 4 4", "wait"], errors=1))

    def lookats(self, lines):
        out = self.run_script(lines)
        number = r"([-\d.e]+)"
        triple = ", ".join([number] * 3)
        found = re.findall(f'<lookat origin="{triple}" target="{triple}" up="{triple}"/>', out)
        return [np.array(one, float).reshape(3, 3) for one in found]

    def test_all_is_done_in_its_order(self):
        """Commands wait for earlier ones and keep their order."""
        red = "red.reflectance.value"
        self.run_script([f"set {red} 0.3 0.1 0.1", "wait", "undo", f"set {red} 0.61 0.1 0.1",
                         "save a.xml", "undo", "save b.xml", f"set {red} 0.2 0.1 0.1"])
        self.assertIn("0.61", (self.folder / "a.xml").read_text())
        self.assertNotIn("0.61", (self.folder / "b.xml").read_text())
        self.assertNotIn("0.2 0.1 0.1", (self.folder / "b.xml").read_text())

    def test_cameras_follow_the_commands(self):
        start, right, up, pole, panned, near, home = self.lookats([
            "lookat", "orbit 90 0", "lookat", "home", "orbit 0 30", "lookat", "orbit 0 170",
            "lookat", "home", "move 1 2 0", "lookat", "home", "dolly 0.5", "lookat", "home",
            "lookat"])
        # The target is the point where the camera's ray hits the ball.
        np.testing.assert_allclose(start, [[0, 1, 5], [0, 1, 0.8], [0, 1, 0]], atol=1e-3)
        np.testing.assert_allclose(right[0], [4.2, 1, 0.8], atol=1e-3)
        np.testing.assert_allclose(right[1:], start[1:], atol=1e-3)
        np.testing.assert_allclose(up[0], [0, 1 + 2.1, 0.8 + 4.2 * 3 ** 0.5 / 2], atol=1e-3)
        for one in (right, up, pole):
            self.assertAlmostEqual(np.linalg.norm(one[0] - one[1]), 4.2, delta=1e-3)
            self.assertGreaterEqual(one[2][1], 0, "upside down")
        np.testing.assert_allclose(panned, start + [[1, 2, 0], [1, 2, 0], [0, 0, 0]], atol=1e-3)
        np.testing.assert_allclose(near[0], [0, 1, 0.8 + 2.1], atol=1e-3)
        np.testing.assert_allclose(home, start, atol=1e-5)

    def test_the_printed_lookat_gives_the_moved_camera(self):
        line = self.run_script(["orbit 40 20", "move 0.2 0.1 -0.5", "lookat", "render 2",
                                "picture a.exr"]).strip()
        text = SCENE.format(width=32, height=24)
        (self.folder / "moved.xml").write_text(re.sub("<lookat.*/>", line, text, count=1))
        self.run_script(["render 2", "picture b.exr"], scene="moved.xml")
        # The printed numbers have six digits.
        a, b = self.picture("a.exr"), self.picture("b.exr")
        self.assertLess(np.mean(np.abs(a - b) > 1e-2), 0.05)
        self.run_script(["render 2", "picture c.exr"])
        self.assertGreater(np.mean(np.abs(a - self.picture("c.exr")) > 1e-2), 0.3)

    def test_it_is_installed_where_it_is_built(self):
        """The installed program finds its library relative to its own location."""
        installed = self.folder / "installed"
        subprocess.run(["cmake", "--install", BUILD, "--component", "viewer", "--prefix", installed],
                       check=True, capture_output=True, timeout=1000)
        program = installed / "bin/kinome-view"
        for status in (127, 0):
            result = subprocess.run([program, "--version"], text=True, capture_output=True,
                                    timeout=600)
            self.assertEqual(result.returncode, status, result.stderr)
            if status != 0:
                (installed / "lib").symlink_to(BUILD.resolve() / "lib")
        self.assertRegex(result.stdout, r"^kinome-view \d")

    def test_cameras_are_saved_in_their_original_form(self):
        text = self.scene.read_text()
        self.run_script(["orbit 30 10", "dolly 0.9", "render 2", "picture a.exr", "save a.xml",
                         "home", "wait", "save home.xml"])
        moved = (self.folder / "a.xml").read_text()
        self.assertRegex(moved, r'<transform name="to_world"><lookat origin="[^"]+" target="[^"]+" up="')
        self.assertNotIn("<matrix", moved)
        self.run_script(["render 2", "picture b.exr"], scene="a.xml")
        self.assertEqual((self.folder / "a.exr").read_bytes(), (self.folder / "b.exr").read_bytes())
        self.assertEqual((self.folder / "home.xml").read_text(), text)

    def test_picks_return_the_visible_surface(self):
        ball, sky = self.run_script(["pick 16 12", "pick 16 0.5"]).splitlines()
        *point, material = ball.split()
        np.testing.assert_allclose(np.array(point, float), [0, 1, 0.8], atol=1e-3)
        self.assertEqual(material, "red")
        self.assertEqual(sky, "nothing")

    def test_numbers_that_make_no_sense(self):
        for line in ("render -1", "render 1.5", "render 1e300"):
            result = subprocess.run([PROGRAM, self.scene, "--script", "-"], input=line, text=True,
                                    capture_output=True, timeout=600)
            self.assertIn("expected a whole number from 1 to 1048576", result.stderr)
            self.assertEqual(result.returncode, 1)

    def test_a_script_goes_on_after_each_error(self):
        lines = ["", "turn 3", "render 1", "picture none/x.exr", "picture x.jpg", "orbit 1",
                 "sleep x", "set red", "picture last.exr"]
        result = subprocess.run([PROGRAM, self.scene, "--script", "-"], input="\n".join(lines),
                                cwd=self.folder, text=True, capture_output=True, timeout=600)
        places = [line.split(" ")[1] for line in result.stderr.splitlines()]
        self.assertEqual(places, [f"-:{i}:1:" for i in (2, 4, 5, 6, 7, 8)], result.stderr)
        self.assertIn("-:2:1: unknown command 'turn'", result.stderr)
        self.assertEqual(result.returncode, 1)
        self.assertTrue((self.folder / "last.exr").exists())

    def test_errors_say_what_is_expected(self):
        out = self.run_script(["render", "undo 2", "wait x", "picture", "save", "set ball.radiuss 1",
                               "texture ball.radiuss x.png", "set red.reflektance 1",
                               "texture floor.vertex_positions bumps.ppm"], errors=9)
        for message in ("-:1:1: expected a number, got ''", "-:2:1: 'undo' takes no value, got '2'",
                        "-:3:1: 'wait' takes no value", "-:4:1: expected: picture FILE",
                        "-:5:1: expected: save FILE",
                        "-:6:1: unknown parameter 'ball.radiuss' (did you mean 'ball.radius'?)",
                        "-:7:1: unknown parameter 'ball.radiuss' (did you mean 'ball.radius'?)",
                        "-:8:1: unknown parameter 'red.reflektance' (did you mean "
                        "'red.reflectance.value'?)",
                        "-:9:1: floor.vertex_positions: an array can't be a texture"):
            self.assertIn(message, out)

    def test_tabs_and_spaces_at_the_end_of_a_line_separate_words(self):
        self.run_script(["render\t1", "picture  a.exr \t", "wait\t"])
        self.assertTrue((self.folder / "a.exr").exists())
        self.run_script(["texture red.reflectance\t bumps.ppm", "set ball.radius \t0.5", "save edited.xml"])
        edited = (self.folder / "edited.xml").read_text()
        self.assertIn('name="filename" value="bumps.ppm"', edited)
        self.assertIn('name="radius" value="0.5"', edited)

    def test_a_script_that_cannot_be_read(self):
        for script, message in ((self.folder, "it is a folder, not a file"),
                                (self.folder / "no.txt", "no such file")):
            result = subprocess.run([PROGRAM, self.scene, "--script", script], text=True,
                                    capture_output=True, timeout=600)
            self.assertEqual((result.returncode, result.stderr),
                             (1, f"kinome-view: {script}: {message}\n"))

    def test_a_picture_never_replaces_a_texture(self):
        self.run_script(["render 1", "picture map.exr"])
        before = (self.folder / "map.exr").read_bytes()
        out = self.run_script(["texture red.reflectance map.exr", "render 1", "picture map.exr",
                               "save map.exr"], errors=2)
        self.assertIn("map.exr': this file was read", out)
        self.assertEqual((self.folder / "map.exr").read_bytes(), before)


if __name__ == "__main__":
    unittest.main()
