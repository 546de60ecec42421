"""Tests of validation/run.sh slope: errors, slopes, and the page."""

import pathlib
import sys
import tempfile
import unittest
import unittest.mock

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path.insert(0, str(ROOT / "validation"))
import bounces  # noqa: E402
from suite import arguments, slope, slope_page  # noqa: E402
from suite.problems import Problem  # noqa: E402


def point(samples, seconds, relmse, integrator="clustered"):
    return slope.Point("hebe", integrator, samples, seconds, relmse, 4, relmse / 2, 2 * relmse)


class FakeKinome:
    """Renders images whose relative error is 1 / sqrt(samples), in 0.1 s and 0.01 s per sample. The error of a
    reference's two renders cancels in their mean."""

    def render(self, _scene, defines, seed, _options):
        samples = defines["spp"]
        sign = 1 if seed % 2 else -1
        image = np.full((4, 4, 3), 2 + sign * 2 / np.sqrt(samples))
        return unittest.mock.Mock(image=image, stats={"processor_seconds": 0.09 + 0.01 * samples})


class Slopes(unittest.TestCase):
    def test_slopes_use_logarithms(self):
        curve = [point(1, 0.1, 1e-1), point(2, 0.2, 1e-2), point(3, 0.2, 1e-3)]
        slope.set_slopes(curve)
        self.assertIsNone(curve[0].slope)
        self.assertAlmostEqual(curve[1].slope, np.log(0.1) / np.log(2))
        self.assertIsNone(curve[2].slope)

    def test_errors_at_a_time(self):
        curve = [point(1, 1, 1e-2), point(4, 4, 1e-3)]
        self.assertAlmostEqual(slope.error_at(curve, 2), 10 ** -2.5)
        self.assertAlmostEqual(slope.error_at(curve, 0.5), 2e-2)
        self.assertAlmostEqual(slope.error_at(curve, 8), 5e-4)

    def test_error_without_the_references_noise(self):
        mean = np.full((2, 2), 2.0)
        self.assertAlmostEqual(slope.relmse(mean + 0.2, mean, 0.001), 0.04 / 4.04 - 0.001)

    def test_a_scene(self):
        with tempfile.TemporaryDirectory() as name:
            work = slope.Slope(FakeKinome(), pathlib.Path(name), True, unittest.mock.Mock())
            points = work.scene("hebe")
        self.assertEqual([(p.integrator, p.samples) for p in points],
                         [(who, n) for who, counts in slope.QUICK.items() for n in counts])
        own = 4 / 256 / 4.04  # of the reference
        for p in points:
            self.assertAlmostEqual(p.relmse, 4 / p.samples / 4.04 - own)
            self.assertAlmostEqual(p.seconds, max(0.01 * (p.samples - 1), 1e-3))


class Page(unittest.TestCase):
    def test_steep_slopes_are_bold(self):
        curve = [point(1, 0.1, 1e-1), point(2, 0.2, 1e-2), point(4, 0.4, 5e-3)]
        slope.set_slopes(curve)
        points = [*curve, point(1, 0.1, 0.2, "path")]
        text = slope_page.page(points, {"processor": "a processor", "cores": 2}, "0123456789ab")
        self.assertIn("| hebe | 1 | 100 | 0.1 | 0.05 to 0.2 |  | 2 |", text)
        self.assertIn("| hebe | 2 | 200 | 0.01 | 0.005 to 0.02 | **-3.3** | 10 |", text)
        self.assertIn("| -1.0 |", text)
        self.assertEqual(slope_page.measurements(points).count("\n"), 5)
        self.assertEqual(slope_page.plot(points)[:4], b"\x89PNG")


class Command(unittest.TestCase):
    def test_arguments(self):
        self.assertEqual(arguments.parse(["slope"]).output, ROOT / "validation/slope")
        self.assertEqual(arguments.parse(["slope", "hebe"]).words, ["hebe"])
        with self.assertRaises(SystemExit), unittest.mock.patch("sys.stderr"):
            arguments.parse(["slope", "nowhere"])

    def test_scenes(self):
        self.assertEqual(slope.names_of([]), list(slope.DEPTHS))
        with self.assertRaises(Problem):
            slope.names_of(["cornell"])
        with tempfile.TemporaryDirectory() as name:
            for scene in slope.DEPTHS:
                self.assertEqual(bounces.scene_of(scene, pathlib.Path(name)).name, scene)


if __name__ == "__main__":
    unittest.main()
