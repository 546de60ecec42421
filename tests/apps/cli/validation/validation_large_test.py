"""Tests of validation/run.sh large: the rows and the page."""

import pathlib
import sys
import tempfile
import unittest
import unittest.mock

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path.insert(0, str(ROOT / "validation"))
from suite import arguments, large, large_page, tables  # noqa: E402


class Large(unittest.TestCase):
    def rows(self, folder):
        """Renders take 50 bytes and a microsecond per pixel, in addition to 1,000,000 bytes and 1 s.

        Renders of more than 32x32 pixels also trace 1000 light rays in 0.1 s.
        """
        self.runs = []

        def run(_build, _scene, image, defines, _seed):
            image.touch()
            pixels = defines["width"] * defines["height"]
            self.runs.append(pixels)
            light = pixels > 32 * 32
            return {"rays": {"camera": 3 * pixels, "light": 1000 * light, "shadow": pixels},
                    "processor_seconds": 1 + 1e-6 * pixels + 0.1 * light,
                    "stage_threads": [{"stage": "points", "busy": [0.06 * light, 0.04 * light]},
                                      {"stage": "plan", "busy": [9.0]}],
                    "peak_memory_bytes": 1_000_000 + 50 * pixels}

        work = large.Large(unittest.mock.Mock(), large.SIZES, folder, unittest.mock.Mock())
        with unittest.mock.patch.object(large, "run_kinome", run), \
                unittest.mock.patch.object(large, "MAX_REPEATED", 5):
            return work.scene(tables.SCENES[0])

    def test_rows_exclude_scene_and_film(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            rows = self.rows(folder)
            self.assertEqual(list(folder.iterdir()), [])
        self.assertEqual([(row.way, row.size) for row in rows],
                         [(way, size) for way in large.WAYS for size in large.SIZES])
        for row in rows:
            self.assertAlmostEqual(row.bytes_per_pixel, 50 - 32, delta=0.2)
            pixels = row.size[0] * row.size[1]
            self.assertAlmostEqual(row.rays_per_second, (4 * pixels + 1000) / (1e-6 * pixels + 0.1),
                                   delta=0.01 * 4e6)
            self.assertAlmostEqual(row.image_rays_per_second / 4e6, 1, delta=0.01)
        # Only long renders aren't repeated.
        self.assertEqual(self.runs.count(3840 * 2160), len(large.WAYS))
        self.assertEqual(self.runs.count(512 * 512), large.REPEATS * len(large.WAYS))
        text = large_page.page(rows, {"processor": "a processor", "cores": 2}, "0123456789ab")
        self.assertIn("on a processor, 2 cores", text)
        self.assertEqual(text.count("| 3840x2160 |"), 3)
        self.assertEqual(large_page.measurements(rows).count("\n"), 10)

    def test_arguments(self):
        self.assertEqual(arguments.parse(["large"]).output, ROOT / "validation/large")
        with self.assertRaises(SystemExit), unittest.mock.patch("sys.stderr"):
            arguments.parse(["large", "nowhere"])
        self.assertLessEqual(set(large.SCENES), {scene.name for scene in tables.SCENES})


if __name__ == "__main__":
    unittest.main()
