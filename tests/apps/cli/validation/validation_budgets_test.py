"""Tests of validation/run.sh budgets: derived scene files, errors at equal time, and the page of a
tiny scene; and of the page of seeds.py."""
import contextlib
import dataclasses
import io
import json
import os
import pathlib
import re
import shutil
import sys
import tempfile
import unittest
import unittest.mock
import xml.etree.ElementTree as tree

from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path.insert(0, str(ROOT / "validation"))
import bounces  # noqa: E402
import seeds  # noqa: E402
from suite import arguments, budget_scenes, budgets, budgets_page, command  # noqa: E402
from suite.problems import Problem  # noqa: E402

BUILD = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build"))
LIGHT = """<scene version="3.0.0"><default name="radiance" value="2"/>
    <emitter type="constant"><rgb name="radiance" value="$radiance"/></emitter></scene>"""
SCENE = """<scene version="3.0.0">
    <default name="light" value="sky"/>
    <include filename="parts/$light.xml"/>
    <integrator type="direct"/>
    <sensor type="perspective">
        <transform name="to_world"> <lookat origin="0, 2, 5" target="0, 1, 0" up="0, 1, 0"/> </transform>
        <film type="hdrfilm"> <integer name="width" value="600"/> <integer name="crop_width" value="3"/>
            <integer name="height" value="400"/> <rfilter type="box"/> </film>
    </sensor>
    <shape type="rectangle"> <transform name="to_world"> <rotate x="1" angle="-90"/> <scale value="3"/>
        </transform> </shape>
    <shape type="cube"/>
</scene>
"""


class InFolder(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        (self.folder / "tiny/parts").mkdir(parents=True)
        self.path = self.folder / "tiny/scene.xml"
        self.path.write_text(SCENE)
        (self.folder / "tiny/parts/sky.xml").write_text(LIGHT)


class SceneFiles(InFolder):
    def test_integrator_size_and_samples_are_set(self):
        one, = budget_scenes.scenes_of([str(self.path)], None)
        copy, options = budget_scenes.derived(one, self.folder / "work", "path", 7, (32, 24))
        root = tree.parse(copy).getroot()
        self.assertEqual([i.get("type") for i in root.findall("integrator")], ["path"])
        self.assertEqual([e.get("type") for e in root.findall("emitter")], ["constant"])
        values = {i.get("name"): i.get("value") for i in root.find("sensor").iter("integer")}
        self.assertEqual(values, {"width": "32", "height": "24", "sample_count": "7"})
        self.assertEqual(options, ("-a", f"{self.path.parent};{self.path.parent / 'parts'}"))

    def test_folders_hold_the_files_that_have_a_sensor(self):
        found = budget_scenes.scenes_of([str(self.folder)], None)
        self.assertEqual([one.name for one in found], ["tiny"])

    def test_names(self):
        for path, name in (("a/b/scene.xml", "b"), ("b/b.xml", "b"), ("b/c.xml", "b/c")):
            self.assertEqual(budget_scenes.name_of(pathlib.Path(path)), name)

    def test_every_scene_of_the_project_can_be_derived(self):
        # A copy of the scene files with empty included assets, because a fresh clone has none.
        copies = self.folder / "copies"
        shutil.copytree(ROOT / "scenes", copies, ignore=shutil.ignore_patterns("assets", "tools"))
        for asset in ("kitchen/assets/instances", "kitchen/assets/lamps", "lamps/assets/pillars",
                      "lamps/assets/area1000"):
            path = copies / f"{asset}.xml"
            path.parent.mkdir(exist_ok=True)
            path.write_text('<scene version="3.0.0"/>')
        boxes = [bounces.scene_of(name, self.folder) for name in bounces.NAMES if "cornell" in name]
        found = budget_scenes.scenes_of([], lambda: boxes)
        self.assertGreater(len(found), 30)
        for one in found:
            if one.path.is_relative_to(ROOT / "scenes"):
                one = dataclasses.replace(one, path=copies / one.path.relative_to(ROOT / "scenes"))
            budget_scenes.derived(one, self.folder / "work", "clustered", 4, (16, 12))

    def test_missing_rows_are_reported(self):
        with self.assertRaisesRegex(Problem, "no scene, file or folder nowhere"):
            budget_scenes.scenes_of(["nowhere"], None)
        self.path.write_text(SCENE.replace("$light", "moon"))
        with self.assertRaisesRegex(Problem, "moon.xml"):
            budget_scenes.derived(budget_scenes.BudgetScene("tiny", self.path), self.folder, "path", 4,
                                  (16, 12))


def curve(*points):
    return [{"budget": name, "samples": 4, "processor": [seconds, 2 * seconds, seconds / 2],
             "relmse": error, "trimmed": error, "by_paths": 0, "why": ""}
            for name, seconds, error in points]


def entry(**curves):
    return {"curves": curves, "commit": "0" * 40, "seeds": 3, "difference": 0.01,
            "difference_error": 0.02}


class EqualTime(unittest.TestCase):
    def test_errors_are_interpolated_and_fall_by_the_time_beyond(self):
        found = curve(("a", 1, 1e-2), ("b", 4, 1e-3))
        self.assertAlmostEqual(budgets.error_at(found, 2), 10 ** -2.5)
        self.assertAlmostEqual(budgets.error_at(found, 8), 5e-4)
        self.assertAlmostEqual(budgets.error_at(found, 0.5), 2e-2)
        timed = [*found, *curve(("1 s", 2, 5e-3))]
        self.assertAlmostEqual(budgets.error_at(timed, 2), 10 ** -2.5)
        self.assertAlmostEqual(budgets.error_at(timed, 1, "1 s"), 1e-2)

    def test_the_better_peer_counts(self):
        one = entry(path=curve(("x", 1, 1e-2)), ptracer=curve(("x", 1, 1e-3)),
                    clustered=curve(("8 samples", 2, 1e-3)))
        row, = budgets.ratios(one)
        self.assertEqual((row["peer"], row["budget"]), ("ptracer", "8 samples"))
        self.assertAlmostEqual(row["ratio"], 0.5)
        self.assertAlmostEqual(row["path_ratio"], 5)
        page = budgets_page.page({"processor": "A", "cores": 2}, {"one": one})
        self.assertIn("| one | – | **0.5**† |", page)
        self.assertIn("1 values, 1 below 0.9", page)
        self.assertEqual(len(budgets_page.measurements({"one": one}).splitlines()), 1 + 3 * 3)

    def test_light_tracing_counts_where_it_finds_the_same(self):
        self.assertTrue(budgets.is_same((1, 0.001), (1.009, 0.001)))
        self.assertTrue(budgets.is_same((1, 0.03), (1.1, 0.03)))
        self.assertFalse(budgets.is_same((1, 0.001), (0.9, 0.001)))


class ATinyScene(InFolder):
    def test_from_renders_to_page(self):
        build = self.folder / "build"
        build.mkdir()
        for name in ("bin", "plugins"):
            (build / name).symlink_to(BUILD / name)
        words = ["budgets", str(self.path), "--build", str(build), "--seeds", "2", "--output",
                 str(self.folder / "page")]
        options = arguments.parse(words)
        options.seconds = (0.3,)
        said = io.StringIO()
        with unittest.mock.patch.object(budgets, "SIZE", (32, 24)), \
                unittest.mock.patch.object(budgets, "SAMPLES", (2,)), \
                unittest.mock.patch.object(budgets, "ERRORS", (0.05,)), \
                contextlib.redirect_stderr(said):
            self.assertEqual(command.main(options), 0, said.getvalue())
            renders = build / "validation/budgets/measurements.jsonl"
            lines = len(renders.read_text("utf-8").splitlines())
            self.assertEqual(command.main(options), 0, said.getvalue())
            self.assertEqual(len(renders.read_text("utf-8").splitlines()), lines)
        found = json.loads((self.folder / "page/budgets.json").read_text("utf-8"))["scenes"]["tiny"]
        self.assertEqual([one["budget"] for one in found["curves"]["clustered"]],
                         ["2 samples", "0.3 s", "relMSE 0.05"])
        self.assertLess(abs(found["difference"]), 0.1)
        self.assertRegex((self.folder / "page/README.md").read_text("utf-8"), r"\| tiny \|")
        with Image.open(self.folder / "page/plot.png") as picture:
            self.assertGreater(picture.height, 400)
        text = (self.folder / "page/measurements.csv").read_text("utf-8")
        self.assertTrue(re.search(r"^tiny,clustered,2 samples,\d+,", text, re.MULTILINE), text)

    def test_words(self):
        self.assertEqual(arguments.parse(["budgets", "tree", str(self.path)]).words,
                         ["tree", str(self.path)])
        self.assertEqual(arguments.parse(["budgets"]).output, ROOT / "validation/budgets")
        found = arguments.parse(["budgets", "--size", "40x30", "--seconds", "1,30"])
        self.assertEqual((found.size, found.seconds), ((40, 30), (1, 30)))
        for words in (["budgets", "nowhere.xml"], ["budgets", "--seeds", "1"], ["maps", str(self.path)],
                      ["budgets", "--size", "40"], ["budgets", "--seconds", "2"]):
            with contextlib.redirect_stderr(io.StringIO()), self.assertRaises(SystemExit):
                arguments.parse(words)


class Seeds(unittest.TestCase):
    def test_the_report_is_drawn(self):
        def test(name, **more):
            return {"name": f"AreAllRight/{name}", "mean": "2", "limit": "0.06",
                    "means": "1.9 2 2.01 2.02"} | more

        report = {"testsuites": [
            {"name": "Few/Seeds", "testsuite": [test("Court"), test("Box", failures=["x"])]},
            {"name": "Each/SeedsOfProduct", "testsuite": [test("CourtDepth2")]}]}
        found = seeds.rows_of(report)
        self.assertEqual([row[:2] for row in found["Seeds"]], [("Court", True), ("Box", False)])
        self.assertIn("| Box | 2 | 0.06 | 1.9 | 2.005 | 2.02 | fails |", seeds.page(found))
        self.assertTrue(seeds.plot(found).startswith(b"\x89PNG"))


if __name__ == "__main__":
    unittest.main()
