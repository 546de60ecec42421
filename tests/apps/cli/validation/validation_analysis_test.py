"""Tests of validation/run.sh report: the arithmetic of times and errors, and the tables."""

import pathlib
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path.insert(0, str(ROOT / "validation"))
from suite import analysis, page, tables_of_results  # noqa: E402


def line(seconds, errors):
    return [{"samples": i, "seconds": s, "relmse": e}
            for i, (s, e) in enumerate(zip(seconds, errors), 1)]


class Analysis(unittest.TestCase):
    def test_medians_and_quartiles(self):
        self.assertEqual(analysis.quartiles([5, 1, 3, 2, 4]), (2, 3, 4))
        self.assertEqual(analysis.quartiles([7]), (7, 7, 7))
        points = analysis.curve([{"samples": 4, "runs": [{"seconds": s, "relmse": s / 10}
                                                         for s in (1, 2, 3, 4, 50)]}])
        self.assertEqual(points[0]["seconds"], 3)
        self.assertEqual(points[0]["relmse_quartiles"], [0.2, 0.4])

    def test_seconds_to_an_error_on_a_power_law(self):
        points = line([0.1, 1, 10], [0.1, 0.01, 0.001])
        seconds, kind = analysis.seconds_to(points, 0.003)
        self.assertEqual(kind, "measured")
        self.assertAlmostEqual(seconds, 10 / 3, places=9)
        seconds, kind = analysis.seconds_to(points, 2e-4)
        self.assertEqual(kind, "extrapolated")
        self.assertAlmostEqual(seconds, 50, places=6)
        self.assertEqual(analysis.seconds_to(points, 0.9e-4), (None, "beyond"))
        self.assertEqual(analysis.seconds_to(points, 0.2), (0.1, "at most"))
        self.assertAlmostEqual(analysis.slope(points), -1, places=9)
        self.assertAlmostEqual(analysis.efficiency(points), 100, places=6)

    def test_a_curve_that_went_flat_never_arrives(self):
        points = line([0.1, 1, 10, 100], [0.1, 0.01, 0.009, 0.0088])
        self.assertEqual(analysis.seconds_to(points, 1e-3), (None, "never"))
        self.assertEqual(analysis.seconds_to(points, 0.0095)[1], "measured")
        self.assertEqual(analysis.seconds_to(line([1], [0.1]), 1e-3), (None, "unknown"))
        self.assertEqual(analysis.seconds_to([], 1e-3), (None, "unknown"))

    def test_errors_below_the_references_noise_are_left_out(self):
        points = line([1, 2, 3, 4], [1e-2, 1e-3, 4e-5, -1e-6])
        self.assertEqual(len(analysis.trusted(points, 1e-4)), 2)
        self.assertEqual(len(analysis.trusted(points, 0.0)), 3)

    def test_errors_below_the_noise_bound_the_others(self):
        points = line([1, 3, 9], [1.1e-2, 2e-3, -1e-6])
        bounded = analysis.bounded(points, 8e-3)
        self.assertEqual([p["relmse"] for p in bounded], [1.1e-2, 4e-3])
        seconds, kind = analysis.seconds_to(bounded, 1e-2)
        self.assertEqual(kind, "measured")
        # Later than with the point itself, never earlier.
        self.assertGreater(seconds, analysis.seconds_to(points, 1e-2)[0])
        self.assertLess(seconds, 3)
        self.assertEqual(analysis.bounded(points, 1.0), [])
        self.assertEqual(len(analysis.bounded(points, 1e-6)), 3)

    def test_a_peer_is_followed_farther_in_its_favour(self):
        def seconds(points, target):
            return analysis.seconds_to(points, target, analysis.PEER_REACH)

        slow = line([1, 4, 16], [1, 0.5, 0.25])  # a slope of -1/2
        self.assertEqual(analysis.seconds_to(slow, 1e-2), (None, "beyond"))
        self.assertEqual(seconds(slow, 1e-2), (200, "extrapolated"))
        self.assertEqual(seconds(slow, 0.05), (160, "extrapolated"))
        self.assertEqual(seconds(slow, 1e-3), (None, "beyond"))
        steep = line([1, 4, 16], [1, 1 / 8, 1 / 64])  # a slope of -3/2
        self.assertAlmostEqual(seconds(steep, 1 / 64 / 27 / 8)[0], 16 * 36, places=6)

    def test_ratios_and_their_mean(self):
        def one(kind, seconds):
            return {"kind": kind, "seconds_to": {1e-3: (seconds, "measured" if seconds else
                                                        "unknown")}}

        scenes = {"a": {"X": one("ours", 2.0), "Y": one("ours", 8.0), "P": one("peer", 4.0),
                        "Q": one("peer", 6.0)},
                  "b": {"X": one("ours", None), "P": one("peer", 1.0)}}
        self.assertEqual(analysis.ratios(scenes, 1e-3),
                         {"X": {"a": (2.0, "measured"), "b": (None, "peer only")},
                          "Y": {"a": (0.5, "measured")}})
        # A renderer that never reaches the error loses, and no mean hides it.
        rows = tables_of_results.overview(scenes)[1]
        self.assertEqual([row[-1] for row in rows],
                         ["2.00 (faster)", "peer only (slower)", "2.00 (faster)"])
        self.assertEqual(rows[-1][0], "geometric mean of 1 of 2")
        self.assertEqual(tables_of_results.by_renderer(scenes)[1],
                         [["X", "2.00", "peer only", "2.00 (of 1)"],
                          ["Y", "0.50", "–", "0.50 (of 1)"]])
        self.assertEqual(analysis.best(scenes["a"], "peer", 1e-3), ("P", 4.0, "measured"))
        self.assertIsNone(analysis.best(scenes["b"], "ours", 1e-3))
        self.assertAlmostEqual(analysis.geometric_mean([2.0, 0.5, 8.0]), 2.0)
        self.assertIsNone(analysis.geometric_mean([]))

    def test_a_ratio_of_bounds_is_a_bound(self):
        for ours, peer, kind, text in (
                ((2, "measured"), (1, "measured"), "measured", "0.50 (slower)"),
                ((2, "measured"), (4, "extrapolated"), "extrapolated", "~2.00 (faster)"),
                ((2, "at most"), (4, "measured"), "at least", "≥ 2.00 (faster)"),
                ((2, "at most"), (1, "measured"), "at least", "≥ 0.50"),
                ((2, "measured"), (4, "at most"), "at most", "≤ 2.00"),
                ((2, "measured"), (1, "at most"), "at most", "≤ 0.50 (slower)"),
                ((2, "at most"), (4, "at most"), "extrapolated", "~2.00 (faster)"),
                ((2, "measured"), (None, "never"), "ours only", "ours only (faster)"),
                ((None, "never"), (None, "beyond"), "neither", "–")):
            found = analysis.ratio(ours, peer)
            self.assertEqual(found[1], kind)
            self.assertEqual(tables_of_results.verdict(*found), text)

    def test_a_mean_of_extrapolated_values_is_marked(self):
        mean = tables_of_results.mean_of
        self.assertEqual(mean([(2.0, "measured"), (0.5, "measured")]), (1.0, "measured"))
        self.assertEqual(mean([(2.0, "measured"), (0.5, "at most")]), (1.0, "extrapolated"))
        self.assertIsNone(mean([]))

    def test_rows_of_several_programs_are_reported(self):
        data = {"machine": {"processor": "A", "cores": 2, "system": "L"}, "commit": "0" * 40,
                "program": "1", "rows": [{"program": "1"}, {"program": "1"}]}
        self.assertNotIn("different versions", page.machine_text([data]))
        data["rows"][1]["program"] = "0"
        self.assertIn("measured with different versions of the program", page.machine_text([data]))

    def test_the_best_configurations_at_each_number_of_samples(self):
        rows = [{"name": n, "samples": s, "seconds": t, "relmse": 1.0, "trimmed": e,
                 "sampler": "independent" if n in "ad" else "ldsampler"} for n, s, t, e in (
            ("a", 16, 2, 1e-2), ("b", 16, 9, 1e-2), ("d", 16, 1, 1e-2), ("a", 64, 4, 1e-2),
            ("b", 64, 1, 1e-2), ("c", 64, 2, -1e-7), ("d", 64, 9, 1e-2))]
        self.assertEqual(analysis.finalists(rows, 2), ["c", "b", "d"])
        self.assertEqual(analysis.finalists(rows, 2, ("ldsampler",)), ["c", "b", "a", "d"])
        self.assertEqual(analysis.finalists(rows, 3), ["c", "b", "a", "d"])
        self.assertEqual(analysis.finalists([], 2), [])


if __name__ == "__main__":
    unittest.main()
