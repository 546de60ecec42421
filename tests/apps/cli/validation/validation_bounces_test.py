"""Tests of validation/bounces.py and load_times.py: errors, the page, and the files."""
import argparse
import pathlib
import struct
import sys
import tempfile
import unittest
import xml.etree.ElementTree as tree
import zlib

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path.insert(0, str(ROOT / "validation"))
import bounces  # noqa: E402
import bounces_page  # noqa: E402
import load_times  # noqa: E402


def curve(seconds, errors):
    return [{"samples": 4 ** i, "processor": [0.9 * s, s, 5 * s], "relmse": e, "trimmed": e}
            for i, (s, e) in enumerate(zip(seconds, errors), 1)]


def entry(ours, peer):
    return {"peer": "Mitsuba path, independent, llvm_ad_rgb, depth -1", "commit": "0" * 40,
            "difference": 0.001, "difference_error": 0.002, "curves": {"ours": ours, "peer": peer}}


class Bounces(unittest.TestCase):
    def test_the_error_is_the_variance_of_one_image(self):
        rng = np.random.default_rng(1)
        truth = rng.uniform(0.5, 1.5, (40, 50, 3))
        images = [truth * (1 + 0.1 * rng.standard_normal(truth.shape)) for _ in range(4)]
        found = bounces.errors(images, truth)
        expected = float((0.01 * truth ** 2 / (truth ** 2 + 0.01 * truth.mean() ** 2)).mean())
        # 6,000 values of a variance with 3 degrees of freedom: 4 standard deviations are 4 %.
        self.assertAlmostEqual(found["relmse"] / expected, 1, delta=0.045)
        self.assertLess(found["trimmed"], found["relmse"])

    def test_the_table_has_the_times_and_the_goals(self):
        faster = entry(curve([1, 10], [1e-2, 1e-4]), curve([2, 80], [5e-2, 1e-3]))
        slower = entry(curve([8, 16], [1e-2, 1e-3]), curve([1, 4], [1e-2, 1e-3]))
        times = bounces_page.figures(faster)
        self.assertAlmostEqual(times[1e-3][4], 80 / 10 ** 0.5, places=6)
        page = bounces_page.page({"processor": "A", "cores": 2}, {"one": faster, "two": slower},
                                 argparse.Namespace(seeds=3))
        self.assertIn("| 16 | 4 | 0.25 |", page)
        self.assertIn("not met by two", page)
        self.assertIn("2.51 | not met", page)  # the geometric mean of 25.3 and 0.25
        self.assertEqual(len(bounces_page.measurements({"one": faster}).splitlines()), 1 + 4 * 3)
        self.assertTrue(bounces_page.plot({"one": faster, "two": slower}).startswith(b"\x89PNG"))

    def test_extrapolated_errors_fall_at_most_with_the_time(self):
        steep = bounces_page.points(curve([1, 2], [1, 1e-2]))
        flat = bounces_page.points(curve([1, 4], [4e-2, 2e-2]))
        self.assertEqual(bounces_page.reach(steep, 1e-3, "ours"), (20, "extrapolated"))
        self.assertEqual(bounces_page.reach(flat, 2e-3, "peer"), (40, "extrapolated"))
        self.assertAlmostEqual(bounces_page.reach(flat, 2e-3, "ours")[0], 400, places=6)

    def test_every_scene_exists_and_the_boxes_match_their_names(self):
        with tempfile.TemporaryDirectory() as folder:
            scenes = {name: bounces.scene_of(name, pathlib.Path(folder)) for name in bounces.NAMES}
            for name in scenes:
                tree.parse(scenes[name].path)
            kinds = {name: [bsdf.get("type") for bsdf in tree.parse(scenes[name].path).iter("bsdf")
                            if bsdf.get("type") not in ("diffuse", None)]
                     for name in scenes if name.startswith("cornell")}
        self.assertEqual(kinds, {"cornell_diffuse": [], "cornell_metal": ["roughconductor"] * 2,
                                 "cornell_glass": ["roughconductor", "dielectric"]})


class LoadTimes(unittest.TestCase):
    def test_the_serialized_file_holds_the_mesh(self):
        mesh = load_times.sheet(5)
        self.assertEqual((len(mesh["positions"]), len(mesh["faces"])), (25, 32))
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "a.serialized"
            load_times.write_serialized(path, mesh)
            data = path.read_bytes()
        self.assertEqual(struct.unpack("<HH", data[:4]), (0x041C, 4))
        self.assertEqual(struct.unpack("<QI", data[-12:]), (0, 1))
        body = zlib.decompress(data[4:-12])
        self.assertEqual(len(body), 4 + 6 + 16 + 25 * 8 * 4 + 32 * 12)


if __name__ == "__main__":
    unittest.main()
