"""Tests of validation/run.sh without Mitsuba: its arithmetic, stored results, page, and invalid
input."""

import base64
import csv
import dataclasses
import io
import json
import math
import os
import pathlib
import re
import sys
import tempfile
import unittest
import unittest.mock
import xml.etree.ElementTree as tree

import numpy as np
from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path[:0] = [str(ROOT / "validation"), str(ROOT / "tests/support")]
from compare import Estimate  # noqa: E402
from simulated_renders import write_exr  # noqa: E402
from suite import analysis, command, tables, truth  # noqa: E402
from suite.benchmark import Benchmark  # noqa: E402
from suite.contestants import Theirs  # noqa: E402
from suite.kinome import Kinome, Render, scene_hash, with_parameters  # noqa: E402
from suite.peers import Mitsuba, configurations  # noqa: E402
from suite.problems import Log, Problem  # noqa: E402
from suite.store import Store, digest  # noqa: E402
from suite.worker import Dead, Refused, Worker  # noqa: E402

BUILD = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build"))
FAKE = ROOT / "tests/support/fake_renderer.py"
HEBE = tables.SCENES[0]
SIZE = (24, 18)


class InFolder(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        self.log = Log(io.StringIO())

    def mitsuba(self, behaviour):
        made = Mitsuba(sys.executable, self.folder / "mitsuba", self.log,
                       command=[sys.executable, FAKE, behaviour])
        self.addCleanup(made.close)
        return made

    def worker(self, behaviour, **options):
        made = Worker("Fake", [sys.executable, FAKE, behaviour], **options)
        self.addCleanup(made.close)
        return made


class Memory(InFolder):
    def test_nothing_is_measured_twice(self):
        calls = []
        for _ in range(2):
            store = Store(self.folder / "a/store.jsonl")
            for key in ({"scene": "a", "seed": 1}, {"seed": 1, "scene": "a"}, {"scene": "a"}):
                store.recall(key, lambda k=key: calls.append(k) or {"seconds": 1.5})
        self.assertEqual(calls, [{"scene": "a", "seed": 1}, {"scene": "a"}])
        self.assertNotEqual(digest({"a": 1}), digest({"a": 2}))

    def test_a_line_that_was_cut_off_is_measured_again(self):
        path = self.folder / "store.jsonl"
        for seed in range(3):
            Store(path).put({"seed": seed}, {"seconds": seed})
        path.write_bytes(path.read_bytes()[:-9])
        store = Store(path)
        self.assertEqual((store.torn, len(store.values)), (1, 2))
        store.put({"seed": 2}, {"seconds": 2})
        self.assertEqual((Store(path).torn, len(Store(path).values)), (0, 3))

    def test_a_change_of_the_scene_changes_its_hash(self):
        scene = self.folder / "scene.xml"
        scene.write_text("<scene/>")
        before = scene_hash(scene)
        (self.folder / "assets").mkdir()
        (self.folder / "assets/mesh.ply").write_text("ply")
        self.assertNotEqual(scene_hash(scene), before)


class OtherProcesses(InFolder):
    def test_every_configuration_is_tried(self):
        found = configurations(HEBE)
        self.assertEqual(len(found), 2 * 2 * 3 * 2)
        self.assertEqual(len({c.name for c in found}), len(found))
        box = next(s for s in tables.SCENES if s.name == "box")
        self.assertEqual({c.integrator for c in configurations(box)}, {"path", "ptracer"})
        self.assertEqual(len(configurations(box)), 2 * 2 * 3)
        self.assertNotIn("mis_compensation", configurations(box)[0].defines(box, SIZE))
        self.assertEqual(found[1].defines(HEBE, SIZE)["mis_compensation"], "true")

    def test_errors_are_one_line(self):
        refusing = self.worker("refuses")
        with self.assertRaisesRegex(Refused, r"^Fake: .*line 3, col 7\): no such plugin$"):
            refusing.ask(command="load", file="a.xml", defines={"integrator": "direct"})
        self.assertEqual(refusing.ask(command="hello"), {"version": "0"})
        crashing = self.worker("crashes")
        with self.assertRaisesRegex(Dead, r"^Fake: died by SIGILL: .*AVX"):
            crashing.ask(command="render", samples=1, seed=1, output="none.npy")
        with self.assertRaisesRegex(Dead, "^Fake: ended with status 1: libLLVM 19 not found"):
            self.worker("ends").ask(command="hello")
        with self.assertRaisesRegex(Dead, "^Fake: no answer for 0.5 s$"):
            self.worker("hangs", timeout=0.5).ask(command="render", samples=1, seed=1,
                                                  output="none.npy")
        with self.assertRaisesRegex(Dead, "can't be started: No such file"):
            Worker("Fake", [self.folder / "none"])

    def test_a_variant_that_does_not_start_is_reported_once(self):
        missing = Mitsuba(self.folder / "none/python", self.folder / "m", self.log)
        for scene in tables.SCENES[:2]:
            with self.assertRaises(Problem):
                missing.load(configurations(scene)[0], scene, SIZE)
        self.assertEqual(self.log.problems,
                         ["Mitsuba isn't installed (pip failed?), so its columns are left out"])

    def test_a_render_is_timed_when_it_is_warm(self):
        # The first render of a sample count after loading takes twice as long here.
        first, second = (Theirs(self.mitsuba("good"), c, HEBE, SIZE)
                         for c in configurations(HEBE)[:2])
        shared = Theirs(first.mitsuba, second.configuration, HEBE, SIZE)
        for renderer in (first, second, first, shared, first):
            self.assertAlmostEqual(renderer.run(4, 1).seconds, 0.008)
            self.assertEqual(renderer.mitsuba.loaded["llvm_ad_rgb"].what[0], renderer.configuration)

    def test_a_process_that_died_is_started_again_for_the_next_scene(self):
        mitsuba = self.mitsuba("crashes")
        for scene in tables.SCENES[:2]:
            with self.assertRaisesRegex(Dead, "SIGILL"):
                mitsuba.render(configurations(scene)[0], scene, SIZE, 4, 1)


class Explanations(unittest.TestCase):
    """Known failures are explained, and no others."""

    def test_only_known_failures_up_to_their_size_are_explained(self):
        def row(method="direct", t=9.8, red="tiles"):
            tests = {name: {"name": name, "passed": name != red, "t": t if name == red else 1.0}
                     for name in ("image", "tiles", "pixels")}
            return {"scene": "hebe", "method": method, "passed": red is None, "tests": tests}

        self.assertIn("visible normals", tables.explanation(row()))
        self.assertIn("visible normals", tables.explanation(row(t=-9.8)))
        self.assertEqual(tables.explanation(row(red=None)), "")
        self.assertEqual(tables.explanation(row(t=40.0)), "")
        self.assertEqual(tables.explanation(row(red="image")), "")
        self.assertEqual(tables.explanation(row(method="clustered joint")), "")


class FakeKinome:
    """Renders with less noise than the fake Mitsuba, and counts renders."""

    program = "0123"

    def __init__(self):
        self.renders = 0

    def render(self, scene, defines, seed):
        self.renders += 1
        noise = np.random.default_rng(1000 + seed).standard_normal((SIZE[1], SIZE[0], 3))
        if defines["integrator"] == "path" and seed == 1:
            noise[3, 4] = np.nan
        return Render(1 + 0.1 / math.sqrt(defines["spp"]) * noise, 0.001 * defines["spp"],
                      0.001 * defines["spp"] + 0.3, 0.2, defines["spp"])


class FakeReferences:
    def __init__(self, shape=(SIZE[1], SIZE[0], 3)):
        self.truth = Estimate("truth", np.ones(shape), np.full(shape, 1e-9), 16)

    def load(self, _scene, _size, **_for):
        return self.truth, {"hash": "45", "integrator": "DirectIntegrator", "seeds": 16,
                            "variant": "llvm_ad_rgb", "samples_used": 256, "masked_pixels": 2,
                            "sampler": "MultijitterSampler", "not_finite": 5}


EFFORT = dataclasses.replace(tables.QUICK, max_samples=64, seeds=3)


class TimeAgainstError(InFolder):
    def benchmark(self, behaviour="good", references=None):
        self.kinome = FakeKinome()
        made = Benchmark(self.kinome, self.mitsuba(behaviour), self.folder / "none",
                         references or FakeReferences(), EFFORT,
                         Store(self.folder / "store.jsonl"), self.folder, self.log)
        return made.scene(dataclasses.replace(HEBE, size=(2 * SIZE[0], 2 * SIZE[1])))

    def test_a_scene_from_start_to_page(self):
        entry = self.benchmark()
        self.assertEqual(self.log.problems, [])
        self.assertEqual(len(entry["tried"]), 24)
        peers = [n for n, c in entry["curves"].items() if c["kind"] == "peer"]
        self.assertEqual(len(peers), 2)
        self.assertTrue(all("ldsampler" in name for name in peers), peers)
        ours = len(entry["curves"]) - 2
        self.assertEqual(ours, sum(m.serves(HEBE) for m in tables.METHODS))
        found = analysis.summary(entry)
        direct = found["Kinome direct"]
        self.assertEqual([p["samples"] for p in direct["points"]], [4, 16, 64])
        self.assertAlmostEqual(direct["slope"], -1, delta=0.2)
        # Noise and time are known: 0.1²/1.01 at 1 ms, and 0.2²/1.01 at 2 ms, on a slope of -1.
        ratio = analysis.ratios({"hebe": found}, 1e-3)["Kinome direct"]["hebe"]
        self.assertAlmostEqual(ratio[0], 8, delta=2.5)
        self.check_page({"hebe": entry})

        # The search selects finalists partly by chance: they are timed again in the final round.
        keys = [json.loads(key) for key in Store(self.folder / "store.jsonl").values]
        for name in peers:
            parts = {key.get("part") for key in keys
                     if (key.get("renderer"), key.get("samples"), key.get("seed")) == (name, 16, 1)}
            self.assertEqual(parts, {"search", None})

        count = self.kinome.renders
        self.assertGreater(count, 0)
        again = self.benchmark()
        self.assertEqual(self.kinome.renders, 0)
        self.assertEqual(again["curves"], entry["curves"])

    def check_page(self, benchmark):
        row = {"scene": "spot", "method": "direct", "truth": "mitsuba", "passed": False,
               "masked": 3, "notes": ["half <floats>"], "flip": None, "picture": png(),
               "tests": {n: {"t": 1.5, "p": 0.2, "detectable": 0.001}
                         for n in ("image", "tiles", "pixels")}}
        correctness = {"family_alpha": 0.01, "machine": {"processor": "A & B", "cores": 2,
                                                         "system": "Linux"},
                       "commit": "0123456789abcdef", "program": "0123",
                       "rows": [row, row | {"method": "clustered joint", "truth": "groundtruth",
                                            "passed": True}]}
        output = self.folder / "report"
        command.write_report(output, correctness, benchmark, ["bpy isn't there"],
                             self.folder / "pictures", True)
        text = (output / "index.html").read_text(encoding="utf-8")
        page = tree.fromstring(text.split("\n", 1)[1])
        images = page.findall(".//img")
        crops = [i for i in images if i.get("alt") == "crop"]
        self.assertEqual(len(crops), len(benchmark["hebe"]["curves"]))
        self.assertEqual(len(images), len(crops) + 3)
        for image in images:
            found = re.fullmatch(r"data:image/(png|jpeg);base64,(.+)", image.get("src"))
            self.assertTrue(found)
            with Image.open(io.BytesIO(base64.b64decode(found[2]))) as picture:
                picture.load()
        for words in ("bpy isn't there", "FAIL", "<td>groundtruth</td>", "A &amp; B",
                      "half &lt;floats", "geometric mean", "2 pixels are masked", "(faster)", "small form",
                      "Kinome path: 3 pixels of all its renders were NaN or Inf"):
            self.assertIn(words.replace("'", "&#x27;") if "'" in words else words, text)
        self.assertNotIn(str(ROOT), text)
        self.assertNotRegex(text, r"(src|href)=\"(?!data:|#)")
        lines = (output / "summary.md").read_text(encoding="utf-8")
        self.assertIn("2 comparisons on 1 scenes, 1 failed", lines)
        self.assertIn("- missing: bpy isn't there", lines)
        with open(output / "measurements.csv", newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), sum(len(p["runs"]) for c in benchmark["hebe"]["curves"].values()
                                        for p in c["points"]))
        for key in ("seconds", "relmse"):
            self.assertTrue(all(math.isfinite(float(row[key])) for row in rows))
        with open(output / "configurations.csv", newline="", encoding="utf-8") as file:
            self.assertEqual(len(list(file)), 1 + 24)

    def test_without_mitsuba_ours_go_on(self):
        entry = self.benchmark("ends")
        self.assertEqual(entry["tried"], [])
        self.assertTrue(all(c["kind"] == "ours" for c in entry["curves"].values()))
        self.assertEqual(sorted(line.split(":")[0] for line in self.log.problems),
                         ["Mitsuba llvm_ad_rgb", "Mitsuba scalar_rgb"])

    def test_a_slow_variant_is_not_tried_with_other_samplers(self):
        seconds = {"llvm_ad_rgb": {"path": 1.0, "direct": 1.0},
                   "scalar_rgb": {"path": 1.9, "direct": 2.0}}

        def trial(renderer, samples, _truth, _least, _few):
            c = renderer.configuration
            if (*dataclasses.astuple(c)[:3], samples) == ("llvm_ad_rgb", "direct", "ldsampler", 256):
                raise Problem("out of memory")
            return {"seconds": seconds[c.variant][c.integrator], "relmse": 1.0, "trimmed": 1.0,
                    "samples": samples, "left_behind": False,
                    "name": (c.variant, c.integrator, c.sampler)}

        made = Benchmark(FakeKinome(), self.mitsuba("good"), self.folder / "none",
                         FakeReferences(), dataclasses.replace(EFFORT, max_samples=256,
                                                               search_samples=(16, 256)),
                         Store(self.folder / "store.jsonl"), self.folder, self.log)
        with unittest.mock.patch.object(made, "trial", trial):
            rows = made.search(HEBE, SIZE, None)
        long = {row["name"] for row in rows if row["samples"] == 256}
        self.assertIn(("scalar_rgb", "path", "multijitter"), long)
        self.assertNotIn(("scalar_rgb", "direct", "multijitter"), long)
        # No other renderer would have the long count.
        self.assertIn(("scalar_rgb", "direct", "ldsampler"), long)
        self.assertEqual(len([row for row in rows if row["samples"] == 16]), 24)

    def test_errors_below_the_references_noise_are_not_reported(self):
        entry = self.benchmark()
        entry["reference"]["own_error"] = 4e-4
        found = analysis.summary(entry)["Kinome direct"]["seconds_to"]
        self.assertEqual(found[1e-4], (None, "noise"))
        self.assertNotEqual(found[1e-3][1], "noise")

    def test_scenes_that_mitsuba_refuses_are_left_out(self):
        entry = self.benchmark("refuses")
        self.assertEqual({row["integrator"] for row in entry["tried"]}, {"path"})
        self.assertTrue(all("no such plugin" in line for line in self.log.problems))
        self.assertEqual(len(self.log.problems), 2)  # one for each variant

    def test_images_of_another_size_are_reported(self):
        entry = self.benchmark("other size")
        self.assertEqual(entry["tried"], [])
        self.assertIn("the image is 24x19, the reference 24x18", self.log.problems[0])
        with self.assertRaisesRegex(Problem, "hebe: the reference is 18x24"):
            self.benchmark(references=FakeReferences((24, 18, 3)))


def png():
    file = io.BytesIO()
    Image.new("RGB", (4, 4)).save(file, "PNG")
    return "data:image/png;base64," + base64.b64encode(file.getvalue()).decode()


class BadInput(InFolder):
    def test_nan_in_a_reference(self):
        channels = {n: np.ones((8, 8)) for n in ("R", "G", "B", "variance.R", "variance.G",
                                                 "variance.B")}
        channels["G"][2, 3] = np.nan
        path = self.folder / "spot.exr"
        write_exr(path, channels)
        path.with_suffix(".json").write_text('{"seeds": 16}')
        with self.assertRaisesRegex(Problem, r"^spot.exr: the reference contains 1 NaN and 0 Inf"):
            truth.load_reference(path)

    def test_no_reference_without_mitsuba(self):
        made = truth.References(self.folder / "none", self.folder, tables.QUICK, self.log)
        with self.assertRaisesRegex(Problem, "^hebe: no reference without Mitsuba$"):
            made.load(HEBE, HEBE.size)

    def test_a_reference_by_another_version_is_made_again(self):
        made = truth.References(self.folder / "none", self.folder, tables.QUICK, self.log)
        with unittest.mock.patch.object(made, "_make") as make:
            path = made.picture(HEBE, HEBE.size)
            path.parent.mkdir()
            for count, version in ((2, "3.0.0"), (2, truth.REQUIREMENTS.read_text(
                    "utf-8").split("mitsuba==")[1].split()[0])):
                path.with_suffix(".json").write_text(json.dumps({"version": version}))
                made.picture(HEBE, HEBE.size)
                self.assertEqual(make.call_count, count)

    def test_no_program_and_no_scene(self):
        with self.assertRaisesRegex(Problem, "run validation/run.sh, which builds it"):
            Kinome(self.folder, self.folder / "out")
        scene = self.folder / "fixed.xml"
        scene.write_text('<scene version="3.0.0"><integrator type="path"/></scene>')
        with self.assertRaisesRegex(Problem, r'fixed.xml: has no <integrator type="\$integ'):
            with_parameters(scene, self.folder / "copies")
        kinome = Kinome(BUILD, self.folder / "out")
        with self.assertRaisesRegex(Problem, r"^kinome: .*fixed.xml"):
            kinome.render(scene, {"colour": "red"}, 1)


if __name__ == "__main__":
    unittest.main()
