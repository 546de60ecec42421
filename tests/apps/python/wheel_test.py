"""Tests of the wheel and the sdist. They are built from the compiled build folder KINOME_BUILD,
installed into an empty environment, and used there."""
import os
import pathlib
import re
import subprocess
import sys
import tarfile
import tempfile
import unittest
import zipfile

from scikit_build_core import build

ROOT = pathlib.Path(__file__).resolve().parents[3]
BUILD = pathlib.Path(os.environ["KINOME_BUILD"])


class WheelTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(ROOT)

    def run_program(self, *command, **options):
        result = subprocess.run([str(word) for word in command], capture_output=True, text=True,
                                check=False, **options)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        return result.stdout

    def test_wheel_is_complete(self):
        module = next((BUILD / "python/kinome").glob("_kinome*.so"))
        library = (BUILD / "lib/libkinome.so").resolve()
        # Restore the build folder for its next user.
        self.addCleanup(self.run_program, "cmake", "-U", "SKBUILD*", "-U", "CMAKE_INSTALL_PREFIX",
                        "-U", "Python_EXECUTABLE", BUILD)
        before = module.stat().st_mtime_ns, library.stat().st_mtime_ns
        sets = re.search("^KINOME_ISAS:[A-Z]+=(.*)$", (BUILD / "CMakeCache.txt").read_text("utf-8"),
                         re.MULTILINE)[1]
        name = build.build_wheel(str(self.folder), {
            "build-dir": str(BUILD), "cmake.define.KINOME_BUILD_TESTS": "ON",
            "cmake.define.KINOME_ISAS": sets})
        self.assertEqual((module.stat().st_mtime_ns, library.stat().st_mtime_ns), before,
                         "something was compiled again")
        with zipfile.ZipFile(self.folder / name) as wheel:
            files = wheel.namelist()
        for file in ("kinome/__init__.py", "kinome/py.typed", "kinome/bin/kinome",
                     "kinome/lib/libkinome.so.0", "kinome/lib/kinome/plugins/bsdf/diffuse.so",
                     "kinome/lib/kinome/python/compare/verdict.py"):
            self.assertIn(file, files)
        self.assertTrue([file for file in files if file.startswith("kinome/_images.")])
        self.assertFalse([file for file in files if "/include/" in file])

        # The environment contains only Debian's numpy besides the wheel.
        self.run_program("/usr/bin/python3", "-m", "venv", "--system-site-packages",
                         self.folder / "clean")
        python = self.folder / "clean/bin/python"
        self.run_program(python, "-m", "pip", "install", "--no-deps", "--no-index",
                         "--disable-pip-version-check", self.folder / name)
        clean = {key: value for key, value in os.environ.items()
                 if key not in ("PYTHONPATH", "KINOME_PLUGIN_PATH")}
        # Run all tests of the module with the installed one.
        self.run_program(python, ROOT / "tests/apps/python/module_test.py", cwd=self.folder,
                         env={**clean, "KINOME_PACKAGE": "installed"})
        used = self.run_program(python, "-c", "import kinome; print(kinome.__file__)",
                                cwd=self.folder, env=clean)
        self.assertTrue(used.startswith(str(self.folder)), used)
        version = self.run_program(python, "-m", "kinome", "--version", cwd=self.folder, env=clean)
        self.assertIn("0.1.0", version)

    def test_sdist_has_all_sources(self):
        name = build.build_sdist(str(self.folder))
        with tarfile.open(self.folder / name) as archive:
            archive.extractall(self.folder)
        source = self.folder / name.removesuffix(".tar.gz")
        self.run_program("cmake", "-G", "Ninja", "-S", source, "-B", self.folder / "build",
                         "-DKINOME_BUILD_TESTS=OFF", "-DKINOME_PYTHON_MODULE=ON",
                         f"-Dnanobind_DIR={self.nanobind()}")
        # CMake has checked the named sources; headers aren't named anywhere.
        for folder in ("core", "libs", "plugins", "apps", "validation/compare"):
            self.assertTrue((ROOT / folder).is_dir(), folder)
            for file in (ROOT / folder).rglob("*"):
                if file.is_file() and "__pycache__" not in file.parts:
                    self.assertTrue((source / file.relative_to(ROOT)).is_file(), file)

    @staticmethod
    def nanobind():
        import nanobind
        return nanobind.cmake_dir()


if __name__ == "__main__":
    sys.exit(unittest.main())
