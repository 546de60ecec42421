"""Tests of validation/run.sh benchmark: work that is skipped to save time, and the scenes that fit
a time limit."""

import argparse
import dataclasses
import pathlib
import sys
import time
import types
import unittest
import unittest.mock

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path[:0] = [str(ROOT / "validation"), str(ROOT / "tests/support")]
from suite import analysis, arguments, benchmark, tables, truth  # noqa: E402
from suite.peers import Configuration, configurations  # noqa: E402
from suite.schedule import DEFAULT_SECONDS, Clock, Schedule, duration  # noqa: E402
from suite.store import Store  # noqa: E402
from validation_suite_test import EFFORT, FakeKinome, FakeReferences, InFolder  # noqa: E402

HEBE, CAR, GRACE = tables.SCENES[:3]
MACHINE = {"processor": "A", "cores": 2}


class Search(InFolder):
    """Tests which of Mitsuba's configurations are tried, for given seconds and errors."""

    def rows(self, seconds=lambda c: 1.0, error=lambda c, samples: 1 / samples):
        renders = []

        def measure(renderer, samples, seed, _truth, warm=None, **_part):
            c = renderer.configuration
            renders.append((c.name, samples, warm))
            e = error(c, samples)
            return {"seconds": seconds(c) * samples, "samples": samples, "seed": seed,
                    "relmse": e, "trimmed": e}

        effort = dataclasses.replace(EFFORT, max_samples=256, search_samples=(16, 256),
                                     search_seeds=2)
        made = benchmark.Benchmark(FakeKinome(), None, None, FakeReferences(), effort,
                                   Store(self.folder / "store.jsonl"), self.folder, self.log)
        with unittest.mock.patch.object(made, "measure", measure), \
                unittest.mock.patch.object(benchmark, "Theirs", lambda _m, c, *_:
                                           types.SimpleNamespace(configuration=c, name=c.name)):
            rows = made.search(HEBE, (24, 18), None)
        return rows, renders

    def test_alike_are_all_tried_in_full(self):
        rows, renders = self.rows()
        self.assertEqual(len(rows), 2 * len(configurations(HEBE)))
        self.assertFalse(any(row["left_behind"] for row in rows))
        # With many samples, the first render is the warm-up.
        self.assertEqual({warm for _, samples, warm in renders if samples == 16}, {True})
        self.assertEqual([warm for name, samples, warm in renders
                          if samples == 256 and name == configurations(HEBE)[0].name],
                         [False, True])

    def test_configurations_worse_at_few_samples_are_tried_once(self):
        rows, renders = self.rows(error=lambda c, n: (3.1 if c.sampler == "independent" else 1) / n)
        names = {row["name"] for row in rows if row["samples"] == 256}
        self.assertFalse(any("independent" in name for name in names))
        self.assertEqual(len([row for row in rows if row["samples"] == 16]),
                         len(configurations(HEBE)))
        self.assertEqual(len([r for r in renders if "independent" in r[0]]),
                         len(configurations(HEBE)) / 3)

    def test_configurations_worse_at_many_samples_are_no_finalists(self):
        def error(c, samples):
            return (2.1 if c.integrator == "path" and samples > 16 else 1) / samples

        rows, renders = self.rows(error=error)
        behind = [row for row in rows if row["left_behind"]]
        self.assertEqual({row["integrator"] for row in behind}, {"path"})
        self.assertTrue(all("direct" in name for name in analysis.finalists(rows, 2)))
        self.assertEqual(len([r for r in renders if r[1] == 256 and "path" in r[0]]), len(behind))

    def test_a_far_slower_variant_is_tried_with_one_sampler(self):
        rows, _ = self.rows(lambda c: 2.6 if c.variant == "scalar_rgb" else 1)
        scalar = [row for row in rows if row["variant"] == "scalar_rgb"]
        self.assertEqual([(row["integrator"], row["samples"]) for row in scalar],
                         [("direct", 16), ("path", 16)])

    def test_a_winner_that_starts_slowly_is_a_finalist(self):
        def error(c, samples):
            winner = c == Configuration("llvm_ad_rgb", "path", "independent", False)
            return (2.4 / 16 if samples == 16 else 0.5 / 256) if winner else 1 / samples

        rows, _ = self.rows(error=error)
        self.assertEqual("Mitsuba path, independent, llvm_ad_rgb", analysis.finalists(rows, 2)[0])


class Turns(InFolder):
    def counts(self, kind, claimed, seconds, error, own=1e-9):
        """Returns the sample counts requested of a renderer, for its seconds and its error with one
        sample."""
        made = benchmark.Benchmark(FakeKinome(), None, None, FakeReferences(),
                                   dataclasses.replace(tables.FULL, seeds=2),
                                   Store(self.folder / "store.jsonl"), self.folder, self.log)
        asked = []

        class Renderer:
            name, samples, converges_to_points = "it", tables.FAST, False

        Renderer.kind, Renderer.claimed = kind, claimed

        def measure(_renderer, samples, seed, _truth):
            asked.append((seed, samples))
            values = {"seconds": seconds * samples, "relmse": error / samples}
            return values | {"trimmed": values["relmse"], "samples": samples, "seed": seed,
                             "not_finite": 0}

        with unittest.mock.patch.object(made, "measure", measure), \
                unittest.mock.patch.object(benchmark, "own_error", lambda _truth: own):
            made.compete(HEBE, [Renderer()], None)
        first, second = ([n for s, n in asked if s == seed] for seed in (1, 2))
        self.assertEqual(first, second)
        return first

    def test_no_more_samples_below_the_targets(self):
        self.assertEqual(self.counts("peer", True, 1e-6, 2e-3), [4, 16, 64])
        self.assertEqual(self.counts("ours", True, 1e-6, 2e-3), [4, 16, 64, 256, 1024])
        # The same for errors below the reference's own.
        self.assertEqual(self.counts("ours", True, 1e-6, 2e-3, own=1e-3), [4, 16])

    def test_slow_configurations_get_less_time(self):
        self.assertEqual(self.counts("ours", True, 0.01, 1e3), [4, 16, 64, 256])
        self.assertEqual(self.counts("ours", False, 0.01, 1e3), [4, 16, 64])
        # Three counts may take longer, to determine a slope.
        self.assertEqual(self.counts("ours", True, 0.1, 1e3), [4, 16, 64])
        self.assertEqual(self.counts("ours", False, 0.1, 1e3), [4, 16])

    def test_a_peer_that_is_first_nowhere_is_left_behind(self):
        def curve(*pairs):
            return {"kind": "peer", "points": [
                {"samples": i, "runs": [{"seconds": s, "relmse": e, "trimmed": e, "not_finite": 0}]}
                for i, (s, e) in enumerate(pairs)]}

        best = [(s, 1e-2 / s) for s in (0.1, 1, 10, 100)]
        curves = {"best": curve(*best), "near": curve(*((1.4 * s, e) for s, e in best)),
                  "slow": curve(*((1.6 * s, e) for s, e in best)),
                  # Slow at first.
                  "late": curve((0.5, 0.1), (2, 1e-2), (4, 1e-3), (8, 5e-5)),
                  "ours": curve((0.001, 1e-9)) | {"kind": "ours"}}
        entry = {"reference": {"own_error": 1e-9}, "curves": curves}
        self.assertEqual(analysis.behind(entry), {"slow"})
        nobody = {"a": curve((0.1, 9.0), (1, 9.0)), "b": curve((1, 9.0), (2, 9.0))}
        self.assertEqual(analysis.behind(entry | {"curves": nobody}), set())

    def test_slower_equivalents_are_timed_at_the_shown_targets(self):
        by_name = {scene.name: scene for scene in tables.SCENES}
        for name, is_timed in (("hebe", True), ("chess", False), ("evening", True)):
            found = [method.name for method in benchmark.methods_timed(by_name[name])]
            self.assertEqual("path" in found, is_timed, name)
            self.assertIn("clustered product", found)


class References(InFolder):
    def test_timed_configurations_may_use_less(self):
        made = truth.References(self.folder / "none", self.folder, tables.FULL, self.log)
        for share, wanted in ((1, (512, 32)), (1 / 2, (512, 16)), (1 / 4, (256, 16))):
            scene = dataclasses.replace(HEBE, timed_share=share)
            self.assertEqual(made.samples_and_seeds(scene, True), wanted)
            self.assertEqual(made.samples_and_seeds(scene, False), (512, 32))
        for scene in tables.SCENES:
            samples, seeds = made.samples_and_seeds(scene, True)
            self.assertGreaterEqual(seeds, tables.RENDERS, scene.name)
            self.assertGreaterEqual(samples, 16, scene.name)
            self.assertTrue(scene.envmap or not scene.truth_compensated, scene.name)


class FakeTruths:
    def __init__(self):
        self.made = set()

    def is_there(self, scene, _size, **_for):
        return scene.name in self.made


class ScenesFor(InFolder):
    def setUp(self):
        super().setUp()
        self.truths = FakeTruths()
        self.now = 0.0
        clock = unittest.mock.patch.object(time, "monotonic", lambda: self.now)
        clock.start()
        self.addCleanup(clock.stop)
        wall = unittest.mock.patch.object(time, "time", lambda: 1e6 + self.now)
        wall.start()
        self.addCleanup(wall.stop)

    def schedule(self, program="1"):
        return Schedule(Store(self.folder / "store.jsonl"), self.truths, tables.FULL, program,
                        MACHINE)

    def take(self, seconds, program="1", scenes=(HEBE, CAR, GRACE), search=50, turns=40):
        """Returns (names taken, names left). A reference takes 100 s, once, and so does a search.
        """
        schedule, end = self.schedule(program), self.now + seconds
        names = []

        def measure(scene):
            clock = Clock()
            self.now += 0 if scene.name in self.truths.made else 100
            clock.lap("reference")
            self.now += 0 if scene.name in self.truths.made else search
            clock.lap("search")
            self.now += turns
            clock.lap("turns")
            clock.lap("startup")
            self.truths.made.add(scene.name)
            schedule.note(scene, clock.laps)
            names.append(scene.name)

        _, left = schedule.run(list(scenes), end, measure, self.log)
        self.now += 1
        return names, [scene.name for scene, _ in left]

    def test_the_same_command_goes_on(self):
        usual = sum(DEFAULT_SECONDS.values())
        self.assertEqual(self.take(usual - 1), ([], ["hebe", "car", "grace"]))
        self.assertEqual(self.take(usual), (["hebe"], ["car", "grace"]))
        # The others are assumed to take as long as hebe, except for the unknown start-up.
        needs = 190 + DEFAULT_SECONDS["startup"]
        self.assertEqual(self.take(needs - 1), (["hebe"], ["car", "grace"]))
        self.assertEqual(self.take(needs), (["car"], ["grace", "hebe"]))
        self.assertEqual(self.take(needs), (["grace"], ["hebe", "car"]))
        # All are measured: the oldest come first, without reference and search.
        self.assertEqual(self.take(80), (["hebe", "car"], ["grace"]))
        self.assertEqual(self.take(80), (["grace", "hebe"], ["car"]))
        said = self.log.stream.getvalue()
        self.assertIn("measured in 80 s: grace 40 s, hebe 40 s\n", said)
        self.assertIn("remaining scenes: car (about 40 s)\n", said)

    def test_another_program_measures_all_anew(self):
        self.take(1e4)
        self.take(1e4, scenes=[CAR])
        self.assertEqual(self.take(80, "2"), (["hebe", "grace"], ["car"]))
        self.assertEqual(self.take(80, "2"), (["car", "hebe"], ["grace"]))

    def test_scenes_that_dont_fit_are_skipped(self):
        self.take(1e4, scenes=[HEBE], turns=200)
        self.take(1e4, scenes=[CAR, GRACE])
        self.assertEqual(self.take(100, "2"), (["car", "grace"], ["hebe"]))

    def test_turns_are_forgotten_before_they_are_taken_again(self):
        size = tables.FULL.timed_size(HEBE)
        turn = {"name": "hebe", "size": size, "renderer": "a", "seed": 1}
        keys = [turn, turn | {"program": "1"}, turn | {"part": "search"}, turn | {"name": "car"},
                turn | {"size": (1, 1)}, {"name": "hebe", "size": size, "startup": "a"}]
        path = self.folder / "store.jsonl"

        def kept(program):
            for key in keys:
                Store(path).put(key, {"seconds": 1})
            self.take(1e4, program, scenes=[HEBE])
            store = Store(path)
            return [store.get(key) is not None for key in keys]

        # An interrupted run of this program continues.
        self.assertEqual(kept("1"), [True] * 6)
        # Another program's results, or a new run.
        self.assertEqual(kept("2"), [False, False, True, True, True, True])
        self.assertEqual(kept("1"), [False, False, True, True, True, True])

    def test_a_run_with_everything_stored_prints_nothing(self):
        schedule = self.schedule()
        schedule.note(HEBE, {"reference": 90, "search": 9, "turns": 40, "startup": 5})
        known = schedule.seconds(HEBE)
        schedule.note(HEBE, {"reference": 0.1, "search": 0.1, "turns": 0.5, "startup": 0})
        self.assertEqual(schedule.seconds(HEBE), known)
        schedule.note(HEBE, {"reference": 0.1, "search": 0.1, "turns": 30, "startup": 0})
        self.assertEqual(schedule.seconds(HEBE), known | {"turns": 30})


class Words(unittest.TestCase):
    def test_times(self):
        self.assertEqual([duration(text) for text in ("90s", "15m", "2h", "1.5h")],
                         [90, 900, 7200, 5400])
        for text in ("", "15", "m", "0m", "-1m", "1d", "1 m"):
            with self.assertRaisesRegex(ValueError, "is not a time such as 90s, 15m or 2h"):
                duration(text)
        with self.assertRaises(argparse.ArgumentTypeError):
            arguments.time_given("soon")

    def test_all_scenes(self):
        names = [scene.name for scene in tables.SCENES]
        self.assertEqual(arguments.parse(["benchmark", "all"]).words, names)
        self.assertEqual(arguments.parse(["benchmark", "--scenes-for", "15m"]).words, names)
        chosen = arguments.parse(["benchmark", "hard", "tree", "--scenes-for=2h"])
        self.assertEqual(chosen.words, ["reeds", "sponge", "tree", "focus", "hammered"])
        self.assertEqual(chosen.scenes_for, 7200)


if __name__ == "__main__":
    unittest.main()
