"""Tests that `kinome new` writes a correct plugin of each category: it builds against the installed
package, and `kinome check` finds no fault in it. The printed commands do this for one of them.
"""
import os
import pathlib
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build"))
CATEGORIES = ("emitter", "film", "integrator", "medium", "phase", "rfilter", "sampler", "sensor",
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

    def install(self):
        prefix = self.folder / "prefix"
        self.run_program("cmake", "--install", BUILD, "--prefix", prefix)
        return prefix

    def new_plugin(self, prefix, category):
        return self.run_program(prefix / "bin/kinome", "new", category, f"my_{category}",
                                "--output", self.folder / category)

    def test_printed_commands(self):
        printed = self.new_plugin(self.install(), "bsdf")
        commands = printed.split("\n", 1)[1]
        self.assertIn("100% tests passed, 0 tests failed out of 2",
                      self.run_program("sh", "-ec", commands))

    def test_each_category(self):
        # All of them in one project, because configuring each one alone would take most of the time.
        prefix = self.install()
        for category in CATEGORIES:
            self.new_plugin(prefix, category)
        (self.folder / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.22)\nproject(all LANGUAGES CXX)\nenable_testing()\n" +
            "".join(f"add_subdirectory({category})\n" for category in CATEGORIES))
        build = self.folder / "build"
        self.run_program("cmake", "-S", self.folder, "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}",
                         "-DCMAKE_BUILD_TYPE=Release")
        self.run_program("cmake", "--build", build)
        self.assertIn(f"100% tests passed, 0 tests failed out of {2 * len(CATEGORIES)}",
                      self.run_program("ctest", "--test-dir", build, "--output-on-failure"))

    def test_nothing_is_overwritten(self):
        folder = self.folder / "mine"
        folder.mkdir()
        result = subprocess.run([BUILD / "bin/kinome", "new", "bsdf", "mine", "--output", folder],
                                capture_output=True, text=True)
        self.assertEqual(result.returncode, 1)
        self.assertIn("already exists", result.stderr)


if __name__ == "__main__":
    unittest.main()
