"""Tests of validation/run.sh engine: slopes, medians, goals and page of simulated times, and the
order of renders."""

import csv
import io
import pathlib
import sys
import tempfile
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path.insert(0, str(ROOT / "validation"))
from suite import arguments, command, engine, engine_page, engine_scenes, tables, third_party  # noqa: E402
from suite import engine_analysis as analysis  # noqa: E402
from suite.kinome import Render  # noqa: E402
from suite.peers import Mitsuba  # noqa: E402
from suite.problems import Log, Problem  # noqa: E402
from suite.store import Store  # noqa: E402

FAKE = ROOT / "tests/support/fake_renderer.py"
PIXELS = 256 * 256
MACHINE = {"processor": "A", "cores": 2, "system": "Linux"}


def run(label, seed, samples, seconds, processor, **more):
    return {"label": label, "seed": seed, "samples": samples, "seconds": seconds,
            "processor": processor, "mean": 1.0, **more}


def timed(label, nanoseconds, fixed=0.3, seeds=(1, 2, 3), samples=(16, 64), **more):
    """Returns renders with this processor time in nanoseconds per sample, half of that as elapsed
    time, plus `fixed` seconds. The third seed simulates a busy machine."""
    return [run(label, seed, count, fixed + 0.5e-9 * nanoseconds * PIXELS * count * slow,
                fixed + 1e-9 * nanoseconds * PIXELS * count * slow, **more)
            for seed, slow in zip(seeds, (1, 1, 3)) for count in samples]


def row(part, scene, runs, max_depth=None, size=(256, 256)):
    return {"part": part, "scene": scene, "size": list(size), "max_depth": max_depth, "runs": runs,
            "sampler": "ldsampler", "program": "01", "machine": MACHINE, "commit": "23",
            "cores_of_others": 0.0}


def beside(part, scene, ours, theirs, max_depth=None, **more):
    return row(part, scene, timed("ours", ours, **more) + timed("Mitsuba", theirs, fixed=0.05),
               max_depth)


def goal(rows, what):
    return next(found for found in analysis.goals(rows) if found.what == what)


class Arithmetic(unittest.TestCase):
    def test_a_line_through_points(self):
        slope, start = analysis.line([4, 16, 64], [1.4, 2.6, 7.4])
        self.assertAlmostEqual(slope, 0.1)
        self.assertAlmostEqual(start, 1.0)
        self.assertIsNone(analysis.line([4, 4], [1, 2]))

    def test_a_sample_takes_the_slope_whatever_is_fixed(self):
        for fixed in (0, 0.3, 5):
            found = row("direct", "hebe", timed("ours", 120, fixed))
            self.assertAlmostEqual(analysis.rate(found, "ours"), 120, places=6)
            self.assertAlmostEqual(analysis.rate(found, "ours", "seconds"), 60, places=6)
            self.assertAlmostEqual(analysis.rates(found, "ours")[3], 360, places=6)

    def test_differences_reversed_by_noise_are_left_out(self):
        runs = [run("ours", 1, 16, 1, 2), run("ours", 1, 64, 0.9, 1.9)]
        self.assertIsNone(analysis.rate(row("direct", "hebe", runs), "ours"))
        self.assertIsNone(analysis.faster(row("direct", "hebe", runs + timed("Mitsuba", 50))))
        self.assertIsNone(analysis.rate(row("direct", "hebe", [run("ours", 1, 16, 1, 2)]), "ours"))

    def test_how_many_times_faster(self):
        found = beside("direct", "hebe", 120, 180)
        self.assertAlmostEqual(analysis.faster(found), 1.5)
        for ratio in analysis.spread(found):
            self.assertAlmostEqual(ratio, 1.5)
        found["runs"] += timed("ours", 240, seeds=(4,))
        found["runs"] += timed("Mitsuba", 180, seeds=(4,))
        self.assertAlmostEqual(min(analysis.spread(found)), 0.75)

    def test_product_by_fixed_work_and_by_ray(self):
        runs = []
        for seed, load in ((1, 0.2), (2, 0.25), (3, 0.9)):
            runs.append(run("start", seed, 1, 0.01, load))
            runs += [run("product", seed, n, 0.08 + 0.01 * n, load + 200e-9 * 1e6 * n, rays=1e6 * n)
                     for n in (4, 16, 64)]
        found = row("product", "hebe", runs)
        self.assertAlmostEqual(analysis.fixed_cost(found), 0.08)
        self.assertAlmostEqual(analysis.ray_cost(found), 200)
        self.assertTrue(goal([found], "product, 256x256: fixed cost").met)
        self.assertFalse(goal([found], "product, 256x256, 64 spp: processor time per ray").met)

    def test_differing_images(self):
        found = beside("direct", "hebe", 120, 180, mean=1.04)
        for one in found["runs"]:
            one["mean"] = 1.04 if one["label"] == "ours" else 1.0
        self.assertIsNone(analysis.different_pictures(found))
        for one in found["runs"]:
            one["mean"] *= 1.1 if one["label"] == "ours" else 1.0
        self.assertAlmostEqual(analysis.different_pictures(found), 0.144 / 1.144)


class Goals(unittest.TestCase):
    def test_each_and_the_mean(self):
        rows = [beside("direct", "hebe", 100, 150, bsdfs=["roughplastic"], embree_share=0.2),
                beside("direct", "ball", 100, 130, bsdfs=["roughplastic"], embree_share=0.2),
                beside("direct", "spot", 100, 300, bsdfs=["diffuse"], embree_share=0.45),
                beside("direct", "penumbra", 100, 140, bsdfs=["diffuse", "roughplastic"]),
                beside("direct", "noon", 100, 300, bsdfs=["diffuse", "twosided"],
                       embree_share=0.35)]
        each = goal(rows, "`direct`")
        self.assertEqual((each.met, each.verdict), (False, "not met by 1 of 5: ball"))
        self.assertEqual(goal(rows, "`direct`, rough plastic alone").verdict,
                         "not met by 2 of 2: ball, hebe")
        mean = goal(rows, "`direct`, geometric mean")
        self.assertAlmostEqual(mean.known["mean of 5"], (1.5 * 1.3 * 9 * 1.4) ** 0.2)
        self.assertEqual(mean.verdict, "met")
        share = goal(rows, "share inside Embree, `direct`, diffuse scenes")
        self.assertEqual(share.verdict, "not met by 1 of 2: noon")

    def test_nothing_measured_is_no_goal_met(self):
        for found in analysis.goals([]):
            self.assertIsNone(found.met)
            self.assertIn("not measured", found.verdict)

    def test_a_scene_that_mitsuba_refuses_is_left_out_of_all(self):
        rows = [beside("direct", "hebe", 100, 150), row("direct", "phong", timed("ours", 100))]
        self.assertEqual(goal(rows, "`direct`").known.keys(), {"hebe"})
        self.assertEqual(list(goal(rows, "`direct`, geometric mean").known), ["mean of 1"])

    def test_depths_of_path_are_two_goals(self):
        rows = [beside("path", "box", 100, 140, 2), beside("path", "box", 100, 120, 5)]
        self.assertTrue(goal(rows, "`path` to depth 2").met)
        self.assertFalse(goal(rows, "`path` to depth 5").met)

    def test_instruction_sets_against_the_best(self):
        runs = [one for isa, ns in zip(tables.ISAS, (100, 130, 350)) for one in timed(isa, ns)]
        rows = [row("isa", "hebe", runs)]
        self.assertTrue(goal(rows, "AVX2 against AVX-512").met)
        self.assertEqual(goal(rows, "baseline against AVX-512").verdict, "not met")

    def test_a_plugin_for_single_points_against_the_wide_one(self):
        what = "a plugin with only scalar functions"
        for nanoseconds, met in ((190, True), (210, False)):
            rows = [row("plugin", "sponge",
                        timed("wide", 100) + timed("point by point", nanoseconds))]
            self.assertAlmostEqual(goal(rows, what).known["sponge"], nanoseconds / 100)
            self.assertEqual(goal(rows, what).met, met)

    def test_cost_of_watertight_surfaces(self):
        rows = [row("watertight", "tree", timed("watertight", 120) + timed("not watertight", 100))]
        self.assertEqual(engine_page.watertight(rows)[1], [["tree", "120", "100", "1.2"]])
        self.assertIn("robust intersections", engine_page.page(rows, [], False))

    def test_seconds_threads_and_memory(self):
        rows = [row("short", "noon", [run("ours", s, 4, t, t) for s, t in enumerate((3, 1, 2))] +
                    [run("Mitsuba", s, 4, t, t) for s, t in enumerate((2.5, 9, 1))]),
                row("threads", "hebe", [run(f"{m}, {n}", 1, 64, t, t) for m, n, t in
                                        (("direct", 1, 2), ("direct", 2, 1), ("product", 1, 1.8),
                                         ("product", 2, 1))]),
                row("memory", "hebe", [run("direct", 1, 16, 1, 1, memory=140e6),
                                       run("product", 1, 16, 1, 1, memory=160e6)])]
        short = goal(rows, "`direct` at 4 spp, 192x144: seconds of rendering")
        self.assertAlmostEqual(short.known["noon"], 0.8)
        self.assertEqual(goal(rows, "2 threads against 1").verdict,
                         "not met by 1 of 2: product of hebe")
        self.assertEqual(goal(rows, "peak memory at 1024x1024").known["direct of hebe"], 140)


class Page(unittest.TestCase):
    ROWS = [beside("direct", "spot", 100, 130, bsdfs=["diffuse"], embree_share=0.45),
            beside("direct", "hebe", 100, 150, bsdfs=["roughplastic"], embree_share=0.2),
            beside("path", "hebe", 100, 150, 5)]

    def test_tables_beside_their_goals(self):
        text = engine_page.page(self.ROWS, ["ball, direct: gone"], False)
        lines = text.splitlines()
        hebe, spot = (next(i for i, line in enumerate(lines) if line.startswith(f"| {name} "))
                      for name in ("hebe", "spot"))
        self.assertLess(hebe, spot)  # small scenes come last
        self.assertIn("| 100 | 150 | 1.5 | 1.5 | at least 1.6: not met | 50 | 75 | 1.5 | 20 % |",
                      lines[hebe])
        self.assertIn("at least 1.35: not met", lines[spot])
        self.assertIn("not met by 1 of 2: spot", text)
        self.assertIn("Samples per pixel: 16 and 64.", text)
        self.assertIn("seeds 1, 2, 3", text)
        self.assertIn("| `path` to depth 5 | at least 1.3 times as fast per sample as Mitsuba | 1.5 "
                      "| met |", text)
        self.assertIn("- missing: ball, direct: gone", text)
        self.assertNotIn("small form", text)
        for table in text.split("\n\n"):
            if table.startswith("|"):
                self.assertEqual(len({line.count("|") for line in table.splitlines()}), 1, table)

    def test_all_renders_are_in_the_raw_numbers(self):
        rows = list(csv.DictReader(io.StringIO(engine_page.measurements(self.ROWS))))
        self.assertEqual(len(rows), 3 * 2 * 6)
        self.assertEqual((rows[0]["scene"], rows[0]["label"], rows[0]["rays"]),
                         ("spot", "ours", ""))
        self.assertEqual(rows[-1]["max_depth"], "5")
        self.assertAlmostEqual(float(rows[1]["processor"]), 0.3 + 100e-9 * PIXELS * 64)

    def test_a_plot(self):
        self.assertTrue(engine_page.plot(self.ROWS).startswith(b"\x89PNG"))
        self.assertIsNone(engine_page.plot([row("isa", "hebe", [])]))


class FakeKinome:
    program = "0123"

    def __init__(self, said):
        self.said = said

    def render(self, scene, defines, seed, options=()):
        if "--isa" in options:
            raise Problem("kinome: unknown option '--isa'")
        self.said.append(("ours", defines["spp"], seed))
        return Render(np.ones((4, 4, 3)), 0.001 * defines["spp"], 1, 0.2, defines["spp"],
                      {"processor_seconds": 0.002 * defines["spp"], "plugins": ["bsdf/diffuse"],
                       "embree_share": 0.2, "rays": {"camera": 5, "shadow": 3}})


class Turns(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        self.log, self.said = Log(io.StringIO()), []

    def engine(self, behaviour="good"):
        mitsuba = Mitsuba(sys.executable, self.folder / "mitsuba", self.log,
                          command=[sys.executable, FAKE, behaviour])
        self.addCleanup(mitsuba.close)
        plain = mitsuba.render

        def render(_configuration, _scene, _size, samples, seed):
            self.said.append(("Mitsuba", samples, seed))
            return plain(_configuration, _scene, _size, samples, seed)

        mitsuba.render = render
        return engine.Engine(FakeKinome(self.said), mitsuba, "ldsampler", "quick",
                             Store(self.folder / "store.jsonl"), self.folder / "scenes", self.log)

    def test_both_take_turns_at_each_count(self):
        rows = self.engine().run(engine.units(["spot"], ["direct"], False), 1e9)
        # The fake takes 32 ms for 16 samples: it is timed at the higher counts.
        turns = [one for one in self.said if one[2] != engine.WARM_UP]
        self.assertEqual(turns, [(who, n, seed) for seed in (1, 2, 3) for n in engine.HIGH
                                 for who in ("ours", "Mitsuba")])
        self.assertEqual([one["rays"] for one in rows[0]["runs"][:2]], [8, 0])
        self.assertAlmostEqual(analysis.faster(rows[0]), 2)  # Kinome: 2 ms per sample, the fake: 4
        self.assertEqual(self.log.problems, [])
        self.said.clear()
        self.assertEqual(self.engine().run(engine.units(["spot"], ["direct"], False), 1e9), rows)
        self.assertEqual(self.said, [])

    def test_a_renderer_that_fails_is_left_out_and_the_others_continue(self):
        rows = self.engine("refuses").run(engine.units(["spot"], ["direct"], True), 1e9)
        self.assertEqual({one["label"] for one in rows[0]["runs"]}, {"ours"})
        self.assertRegex(self.log.problems[0], "^spot, direct: Mitsuba is left out: .*no such plug")
        self.assertEqual(self.engine().run(engine.units(["hebe"], ["isa"], True), 1e9), [])
        self.assertIn("x86-64-v4 is left out: kinome: unknown option '--isa'",
                      self.log.problems)

    def test_the_end_of_the_time_is_reported_and_results_so_far_are_shown(self):
        wanted = engine.units(["spot", "hebe"], ["direct"], True)
        self.engine().run(wanted[1:], 1e9)
        rows = self.engine().run(wanted, 0)
        self.assertEqual([one["scene"] for one in rows], ["spot"])
        self.assertRegex(self.log.problems[0], "^time is up: 1 of 2 measurements are missing; run")

    def test_parts_and_scenes(self):
        options = arguments.parse(["engine", "direct", "hebe", "--scenes", "spot,ball", "--quick"])
        self.assertEqual((options.modes, options.parts), (("engine",), ["direct"]))
        self.assertEqual(options.words, ["hebe", "spot", "ball"])
        self.assertEqual(options.output, ROOT / "out/engine")
        self.assertEqual(arguments.parse([]).modes, arguments.MODES)
        whole = engine.units([], [], False)
        self.assertEqual({unit.part for unit in whole}, set(tables.ENGINE_PARTS))
        names = {unit.scene.name for unit in whole if unit.part == "direct"}
        self.assertEqual(names, {scene.name for scene in tables.SCENES} |
                         {path.stem for path in tables.SMALL_SCENES} - set(tables.WITHOUT_PEER))
        named = engine.units(["noon"], ["path"], False)
        self.assertEqual([(unit.scene.name, unit.max_depth) for unit in named],
                         [("noon", 2), ("noon", 5)])

    def test_fresh_forgets_the_parts_and_scenes_that_are_named(self):
        made = self.engine()

        def forgotten(*words):
            session = command.Session(arguments.parse(["--quick", "--fresh", *words]), self.log)
            is_concerned = session.concerned()
            return {unit.name for unit in engine.units(["hebe", "noon"], [], True)
                    if is_concerned(made.key(unit))}

        self.assertEqual(forgotten("benchmark"), set())
        self.assertEqual(forgotten("engine", "short", "isa"), {"noon, short", "hebe, isa"})
        self.assertEqual(forgotten("engine", "direct", "noon"), {"noon, direct"})
        self.assertEqual(len(forgotten("engine")), len(engine.units(["hebe", "noon"], [], True)))

    def test_a_small_scene_takes_size_and_integrator(self):
        for path in tables.SMALL_SCENES:
            text = engine_scenes.with_size(path, self.folder).read_text("utf-8")
            for name in ("$width", "$height", "$file_format", "/integrators/$integrator.xml"):
                self.assertEqual(text.count(name), 1, (path, name))
            self.assertNotIn('value="maps/', text)

    def test_both_programs_trace_rays_in_the_same_way(self):
        small = tables.SMALL_SCENES[0]
        by_name = {scene.name: scene.path for scene in tables.SCENES}
        for path in (small, by_name["hebe"], by_name["ball"]):
            copy = engine_scenes.like_for_like(path, self.folder, path == small)
            text = copy.read_text("utf-8")
            self.assertIn('<default name="watertight" value="false"/>', text)
            self.assertIn('name="embree_use_robust_intersections" value="$watertight"', text)
            self.assertIn(f'<path value="{path.parent}"/>', text)

    def test_diffuse_surfaces_use_the_plugin(self):
        path = next(scene.path for scene in tables.SCENES if scene.name == tables.PLUGIN_SCENE)
        text = third_party.scene_with_reflector(path, self.folder).read_text("utf-8")
        self.assertEqual(text.count('type="$reflector"'), 2)
        self.assertEqual(text.count('<rgb name="albedo"'), 2)
        self.assertNotIn('type="diffuse"', text)
        self.assertIn(f'value="{path.parent}/assets/sponge.ply"', text)
        self.assertIn(f'<include filename="{path.parent}/../integrators', text)
        glossy = next(scene.path for scene in tables.SCENES if scene.name == "ball")
        with self.assertRaisesRegex(Problem, "ball.xml: has no diffuse surface"):
            third_party.scene_with_reflector(glossy, self.folder)


if __name__ == "__main__":
    unittest.main()
