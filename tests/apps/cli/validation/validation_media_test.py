"""Tests of validation/run.sh media: speed-ups, times per sample, the page, and the arguments."""

import pathlib
import sys
import unittest
import unittest.mock

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path.insert(0, str(ROOT / "validation"))
from suite import arguments, media_page, tables  # noqa: E402


def curve(seconds, errors):
    return [{"samples": 4 ** i, "processor": [0.9 * s, s, 1.1 * s], "relmse": e, "trimmed": e / 2}
            for i, (s, e) in enumerate(zip(seconds, errors), 1)]


def entry():
    return {"peer": "Mitsuba volpathmis, independent, llvm_ad_rgb, depth -1", "commit": "0123456789ab",
            "size": [96, 72], "cores_of_others": 0.5, "tried": [],
            "differences": {"volpath": [0.01, 0.02], "clustered": [-0.01, 0.02]},
            "curves": {"volpath": curve([1, 4], [0.08, 0.02]), "clustered": curve([1, 4], [0.04, 0.01]),
                       "peer": curve([2, 8], [0.16, 0.04])}}


class Page(unittest.TestCase):
    def test_speed_ups_are_to_the_error_of_the_peers_longest_render(self):
        target, seconds, found = media_page.speed_ups(entry())
        self.assertEqual((target, seconds), (0.04, 8))
        self.assertAlmostEqual(found["volpath"][0], 2)
        self.assertAlmostEqual(found["volpath"][2], 4)
        self.assertEqual(found["clustered"], (1, "at most", 8))

    def test_time_of_a_sample_excludes_fixed_work(self):
        found = media_page.nanoseconds(curve([1.25, 2], [1, 1]), (100, 100))
        self.assertAlmostEqual(found, 1e9 * 0.75 / 12 / 1e4)

    def test_the_page_has_all_scenes_and_goals(self):
        scenes = {name: entry() for name in tables.MEDIA_GOALS}
        text = media_page.page({"processor": "A", "cores": 2}, scenes, 3)
        for name, goal in tables.MEDIA_GOALS.items():
            self.assertIn(f"| {name} | volpathmis, independent | 0.04 | 8 | 2 | 4 | 4 | <1 | ~8 | ~8 | "
                          f"{goal or ''} |", text)
        self.assertIn("| lanterns | 0.01 | 4 | 32 | 8 | 8 |", text)
        self.assertIn("| `clustered`, lanterns | 20 | 8 | 8 | not met |", text)
        self.assertIn("| `volpath`, geometric mean | 1.5 | 4 |  | met |", text)
        self.assertIn("0.5 to 0.5 of the 2 cores", text)
        self.assertEqual(len(media_page.measurements(scenes).splitlines()), 1 + 3 * 2 * 3 * len(scenes))
        self.assertTrue(media_page.plot(scenes).startswith(b"\x89PNG"))


class Command(unittest.TestCase):
    def test_arguments(self):
        self.assertEqual(arguments.parse(["media"]).output, ROOT / "validation/media")
        self.assertEqual(arguments.parse(["media", "cloud", "wax"]).words, ["cloud", "wax"])
        for words in (["media", "hebe"], ["media", "hard"], ["benchmark", "cloud"]):
            with self.assertRaises(SystemExit), unittest.mock.patch("sys.stderr"):
                arguments.parse(words)

    def test_scenes_exist(self):
        for scene in tables.MEDIA_SCENES:
            self.assertTrue(scene.path.is_file(), scene.name)


if __name__ == "__main__":
    unittest.main()
