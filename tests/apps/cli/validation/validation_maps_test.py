"""Tests of validation/run.sh maps: visible surfaces and classes of pixels, and the page of a tiny
scene."""

import contextlib
import dataclasses
import io
import json
import os
import pathlib
import re
import sys
import tempfile
import unittest
import unittest.mock

import numpy as np
from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path.insert(0, str(ROOT / "validation"))
from suite import arguments, command, maps, maps_page, surfaces, tables  # noqa: E402
from suite.problems import Problem  # noqa: E402

BUILD = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build"))
SIZE = (32, 24)
SCENE = f"""<scene version="3.0.0">
    <default name="integrator" value="clustered"/>
    <default name="sampler" value="independent"/>
    <default name="spp" value="16"/>
    <default name="width" value="32"/>
    <default name="height" value="24"/>
    <default name="material" value="roughplastic"/>
    <include filename="{ROOT}/scenes/integrators/$integrator.xml"/>
    <sensor type="perspective">
        <float name="fov" value="50"/>
        <transform name="to_world">
            <lookat origin="0, 1.5, 6" target="0, 1.5, 0" up="0, 1, 0"/>
        </transform>
        <sampler type="$sampler"> <integer name="sample_count" value="$spp"/> </sampler>
        <film type="hdrfilm">
            <integer name="width" value="$width"/>
            <integer name="height" value="$height"/>
            <rfilter type="box"/>
        </film>
    </sensor>
    <emitter type="constant"/>
    <bsdf type="$material" id="shiny"/>
    <shape type="rectangle" id="floor">
        <transform name="to_world">
            <rotate x="1" angle="-90"/>
            <scale value="3"/>
        </transform>
        <bsdf type="twosided"> <bsdf type="diffuse"/> </bsdf>
    </shape>
    <shape type="cube">
        <transform name="to_world"> <translate y="1.6"/> </transform>
        <ref id="shiny"/>
    </shape>
</scene>
"""


class InFolder(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        self.path = self.folder / "tiny.xml"
        self.path.write_text(SCENE)


class SceneFiles(InFolder):
    def test_camera(self):
        camera = surfaces.camera_of(self.path, 32)
        self.assertEqual(camera.origin, (0, 1.5, 6))
        self.assertAlmostEqual(32 * camera.pixel, 2 * np.tan(np.radians(25)))
        self.path.write_text(SCENE.replace("lookat", "look"))
        with self.assertRaisesRegex(Problem, "^tiny.xml: its sensor has no lookat"):
            surfaces.camera_of(self.path, 32)

    def test_materials(self):
        self.assertEqual(surfaces.glossy_shapes(self.path), [False, True])
        self.path.write_text(SCENE.replace('value="roughplastic"', 'value="diffuse"'))
        self.assertEqual(surfaces.glossy_shapes(self.path), [False, False])

    def test_every_scene_can_be_mapped(self):
        for scene in tables.SCENES:
            surfaces.camera_of(scene.path, 192)
            self.assertGreater(len(surfaces.glossy_shapes(scene.path)), 0, scene.name)
        self.assertLessEqual(set(maps.SCENES), {scene.name for scene in tables.SCENES})


def flat(size=(4, 8, 8)):
    """Points of a floor at a height of 0, seen from above."""
    position = np.zeros((*size, 3), np.float32)
    position[..., 0], position[..., 2] = np.arange(size[2]), np.arange(size[1])[:, None]
    normal = np.broadcast_to(np.array([0, 1, 0], np.float32), position.shape).copy()
    ones = np.ones(size, np.float32)
    return surfaces.Points(ones.astype(int), normal, position, ones, 4 * ones)


class Patches(unittest.TestCase):
    def test_tiles_are_taken_apart_and_put_together(self):
        values = np.random.default_rng(1).random((3, 6, 9, 2))
        tiles = surfaces.in_tiles(values)
        self.assertEqual(tiles.shape, (2 * 3, 16 * 3, 2))
        np.testing.assert_array_equal(
            surfaces.from_tiles(tiles[..., 0], 3, 6, 9), values[..., 0])

    def test_a_plane_is_one_patch(self):
        patch, new = surfaces.patches_of(flat(), 2)
        self.assertEqual((patch.min(), patch.max(), new.any()), (0, 0, False))

    def test_another_shape_normal_or_plane_is_another_patch(self):
        turned = np.array([0, np.cos(0.4), np.sin(0.4)], np.float32)
        for change in ("shape", "normal", "position"):
            points = flat()
            if change == "shape":
                points.shape[:, :, 6:] = 2
            elif change == "normal":
                points.normal[:, :, 6:] = turned
            else:
                points.position[:, :, 6:, 1] = 4.5  # a tile's width is 4
            patch, new = surfaces.patches_of(points, 1)
            self.assertFalse((patch[:, :, :6] == patch[:, :1, 6:7]).all(), change)
            np.testing.assert_array_equal(np.unique(patch[:, :, 6:]), [1])
            self.assertFalse(new.any())

    def test_surfaces_that_the_pilot_missed_are_new(self):
        points = flat()
        points.shape[2:, 5, 5] = 2
        patch, new = surfaces.patches_of(points, 2)
        self.assertEqual((new.sum(), new[2:, 5, 5].all()), (2, True))
        self.assertEqual(set(patch[:, 5, 5]), {0, 1})
        # Without a pilot, no surface is new to it.
        glossy, visible = np.array([False, False, False]), np.ones((8, 8))
        self.assertEqual(set(maps.classify(points, 0, glossy, visible).flat),
                         {maps.NAMES.index("dull"), maps.NAMES.index("several patches")})

    def test_the_rules_match_product(self):
        folder = ROOT / "plugins/integrators/clustered/product"
        texts = {name: (folder / name).read_text("utf-8") for name in (
            "tiles/patches.cpp", "tiles/primaries.h", "pass/renderer_pilot.cpp")}
        for file, name, value in (("tiles/patches.cpp", "kPatchCosine", surfaces.COSINE),
                                  ("tiles/patches.cpp", "kConeFactor", surfaces.CONE_FACTOR),
                                  ("tiles/patches.cpp", "kConeMargin", surfaces.CONE_MARGIN),
                                  ("tiles/patches.cpp", "kPlaneWidths", surfaces.PLANE_WIDTHS),
                                  ("tiles/patches.cpp", "kMaxPatches", surfaces.MAX_PATCHES),
                                  ("tiles/primaries.h", "kTileSide", surfaces.SIDE),
                                  ("pass/renderer_pilot.cpp", "kMinRaysToProbeAll", surfaces.PILOT[0][0])):
            found = re.search(rf"constexpr \w+ {name} = ([\d.]+)f?;", texts[file])
            self.assertIsNotNone(found, name)
            self.assertEqual(float(found[1]), value, name)
        (few, one), (some, two), (_, four) = surfaces.PILOT[1:]
        self.assertIn(f"effort.primaries = rays_per_pixel < {few} ? {one} : rays_per_pixel < "
                      f"{some} ? {two} : {four};", texts["pass/renderer_pilot.cpp"])

    def test_the_pilot_grows_with_the_rays(self):
        self.assertEqual([surfaces.pilot_rays(n) for n in (9, 12, 48, 192)], [0, 1, 2, 4])


class Classes(unittest.TestCase):
    def test_the_first_that_fits(self):
        points = flat((4, 4, 8))
        points.shape[:, 0, 0] = 0  # nothing
        points.shape[2:, 0, 1] = 2  # new
        points.shape[1, 0, 2] = 0  # several: an edge to the background
        points.cosine[:, 0, 3] = 0.05
        points.shape[:, :, 4:] = 3  # glossy: another tile
        visibility = np.ones((4, 8))
        visibility[2] = 0.5
        visibility[3, 2] = 0.01
        found = maps.classify(points, 2, np.array([False, False, False, True]), visibility)
        self.assertEqual([maps.NAMES[i] for i in found[0, :5]],
                         ["nothing", "new patch", "several patches", "grazing view", "glossy"])
        self.assertEqual([maps.NAMES[i] for i in found[2, [1, 5]]],
                         ["dull, partly lit", "glossy, partly lit"])
        self.assertEqual([maps.NAMES[i] for i in found[3, 2:4]], ["deep shade", "dull"])

    def test_shares(self):
        noise = np.random.default_rng(2).standard_normal((8, 10, 20, 3))
        stack = 10 + noise * np.where(np.arange(20) < 10, 0.3, 0.1)[:, None]
        error = maps.relative_variance(stack)
        self.assertAlmostEqual(error[:, :10].mean() * 1.01 * 100 / 0.09, 1, delta=0.1)
        classes = np.broadcast_to(np.where(np.arange(20) < 10, 2, 6), (10, 20))
        found = maps.shares(stack, error, np.ones((10, 20)), classes)
        self.assertEqual(found["several patches"]["pixels"], 0.5)
        self.assertAlmostEqual(found["several patches"]["error"], 0.9, delta=0.02)
        for half in found["glossy"]["halves"]:
            self.assertAlmostEqual(half, 0.1, delta=0.03)
        self.assertEqual(found["several patches"]["worst"], 1)
        self.assertEqual(found["several patches"]["rays"], 0.5)
        self.assertAlmostEqual(sum(row["error"] for row in found.values()), 1)
        spike = np.where(np.arange(200) == 7, 1.0, 0.001).reshape(10, 20)
        self.assertAlmostEqual(maps.share_of_worst(spike), 1.001 / 1.199)


class ATinyScene(InFolder):
    def test_from_renders_to_page(self):
        scene = dataclasses.replace(tables.SCENES[0], name="hebe", file=str(self.path))
        parts = {"all": {}, "no control variate": {"control_variate": "false"}}
        build = self.folder / "build"
        build.mkdir()
        for name in ("bin", "plugins"):
            (build / name).symlink_to(BUILD / name)
        options = arguments.parse(["maps", "hebe", "--spp", "4", "--build", str(build),
                                   "--output", str(self.folder / "maps")])
        said = io.StringIO()
        with unittest.mock.patch.object(maps, "PARTS", parts), \
                unittest.mock.patch.object(command, "chosen", lambda *_: [scene]), \
                unittest.mock.patch.object(tables.Effort, "timed_size", lambda *_: SIZE), \
                contextlib.redirect_stderr(said):
            self.assertEqual(command.main(options), 0, said.getvalue())
        found = json.loads((self.folder / "maps/maps.json").read_text("utf-8"))["hebe"]
        classes = found["classes"]
        self.assertAlmostEqual(sum(row["pixels"] for row in classes.values()), 1)
        self.assertAlmostEqual(sum(row["error"] for row in classes.values()), 1)
        # The sky (where, in some pixels, no camera ray met an edge), the edges of the cube and the
        # floor, the cube's front, and the floor.
        self.assertGreater(classes["nothing"]["pixels"], 0.3)
        self.assertLess(classes["nothing"]["error"], 0.02)
        for name in ("several patches", "dull, partly lit"):
            self.assertGreater(classes[name]["pixels"], 0.02, name)
            self.assertGreater(classes[name]["error"], 0, name)
        self.assertGreater(classes["glossy"]["pixels"] + classes["glossy, partly lit"]["pixels"],
                           0.05)
        self.assertGreater(found["without"]["no control variate"]["all"], 1)
        with Image.open(self.folder / "maps/hebe.png") as picture:
            self.assertGreater(picture.width, 1000)
            self.assertGreater(len(set(picture.convert("RGB").getdata())), 50)
        text = (self.folder / "maps/README.md").read_text("utf-8")
        self.assertIn("![hebe: picture, error and classes](hebe.png)", text)
        self.assertIn("32x24, 4 samples", text)
        self.assertRegex(text, r"\| several patches( \| \d+ %){3} \| \d+ % / \d+ % \|")
        self.assertRegex(text, r"\| no control variate \| \d+\.\d\d \|")
        self.assertNotIn(str(ROOT), text)

    def test_a_scene_without_product_is_reported(self):
        made = maps.Maps(unittest.mock.Mock(build=BUILD), lambda _scene: SIZE, 4,
                         self.folder / "work", unittest.mock.Mock())
        self.path.write_text(SCENE.replace('<emitter type="constant"/>', ""))
        with self.assertRaisesRegex((Problem, SystemExit), "tiny|product"):
            made.scene(dataclasses.replace(tables.SCENES[0], name="tiny", file=str(self.path)))

    def test_words(self):
        self.assertEqual(arguments.parse(["maps"]).spp, 16)
        self.assertEqual(arguments.parse(["maps", "tree", "--spp=64"]).spp, 64)
        self.assertEqual(arguments.parse(["maps"]).output, ROOT / "validation/maps")
        for words in (["report", "--spp", "4"], ["maps", "--spp", "0"], ["maps", "spot"]):
            with contextlib.redirect_stderr(io.StringIO()), self.assertRaises(SystemExit):
                arguments.parse(words)


class Numbers(unittest.TestCase):
    def test_percent(self):
        self.assertEqual([maps_page.percent(x) for x in (0, 0.0042, 0.0096, 0.5, None)],
                         ["0 %", "0.4 %", "1 %", "50 %", ""])


if __name__ == "__main__":
    unittest.main()
