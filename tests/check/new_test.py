"""Tests that `kinome new` writes a correct plugin of each category. With the printed commands, it
builds against the installed package, and `kinome check` finds no fault in it.
"""
import os
import pathlib
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build"))
CATEGORIES = ("bsdf", "emitter", "film", "integrator", "medium", "phase", "rfilter", "sampler", "sensor",
              "shape", "texture", "volume")


class NewPlugins(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_program(self, *words):
        result = subprocess.run(words, capture_output=True, text=True, timeout=2000)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        return result.stdout

    def test_each_category(self):
        prefix = self.folder / "prefix"
        self.run_program("cmake", "--install", BUILD, "--prefix", prefix)
        for category in CATEGORIES:
            with self.subTest(category):
                printed = self.run_program(prefix / "bin/kinome", "new", category, "my_own",
                                           "--output", self.folder / category)
                commands = printed.split("\n", 1)[1]
                self.assertIn("100% tests passed, 0 tests failed out of 2",
                              self.run_program("sh", "-ec", commands))

    def test_nothing_is_overwritten(self):
        folder = self.folder / "mine"
        folder.mkdir()
        result = subprocess.run([BUILD / "bin/kinome", "new", "bsdf", "mine", "--output", folder],
                                capture_output=True, text=True)
        self.assertEqual(result.returncode, 1)
        self.assertIn("already exists", result.stderr)


if __name__ == "__main__":
    unittest.main()
