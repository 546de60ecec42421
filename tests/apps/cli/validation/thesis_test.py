"""Tests validation/thesis.sh in its small form: its page, images and numbers, and its comparison.
"""

import csv
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path.insert(0, str(ROOT / "validation"))
import pictures  # noqa: E402

SCENES = ("hebe", "car", "grace", "box", "plate")


def refuse(constant):
    raise ValueError(f"{constant} among the numbers")


class SmallForm(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.output = pathlib.Path(cls.folder.name)
        command = ["sh", str(ROOT / "validation/thesis.sh"), "--quick", "--output", cls.output]
        result = subprocess.run(command, check=False, capture_output=True, text=True)
        assert result.returncode == 0, result.stdout + result.stderr

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_everything_that_the_page_names_is_there(self):
        page = (self.output / "README.md").read_text(encoding="utf-8")
        links = re.findall(r"\]\(([^)]+)\)", page)
        self.assertGreater(len(links), 12)
        for link in links:
            self.assertTrue((self.output / link).is_file(), link)
        self.assertNotIn(str(ROOT), page)

    def test_images_are_not_uniform(self):
        found = [*self.output.glob("*.jpg"), *self.output.glob("*.png")]
        self.assertEqual(len(found), len(SCENES) + 3)
        for path in found:
            with Image.open(path) as image:
                self.assertGreater(np.asarray(image.convert("L")).std(), 5, path.name)

    def test_numbers_are_finite_and_complete(self):
        text = (self.output / "numbers.json").read_text(encoding="utf-8")
        self.assertNotIn(str(ROOT), text)
        data = json.loads(text, parse_constant=refuse)
        self.assertEqual(tuple(data["scenes"]), SCENES)
        for scene, numbers in data["scenes"].items():
            self.assertEqual(len(numbers["modes"]), 4, scene)
            for mode in numbers["modes"].values():
                self.assertGreater(mode["render_seconds"], 0)
                self.assertGreater(mode["rays"]["shadow"], 0)
                self.assertGreater(mode["error_to_groundtruth"]["relmse"], 0)
                self.assertGreater(mode["error_to_truth"]["relmse"], 0)

    def test_tables_are_numbers(self):
        for name, columns in (("table-5.1.csv", 2), ("sweeps.csv", 2)):
            with open(self.output / name, newline="", encoding="utf-8") as file:
                rows = list(csv.reader(file))
            self.assertGreaterEqual(len(rows), 1 + 4 * len(SCENES))
            for row in rows[1:]:
                self.assertIn(row[0], SCENES)
                self.assertTrue(all(math.isfinite(float(v)) for v in row[columns:]), row)


class Comparison(unittest.TestCase):
    def test_relative_error_of_uniform_images(self):
        reference = np.full((20, 50, 3), 2.0)
        found = pictures.error(reference + 0.2, reference)
        self.assertAlmostEqual(found["relmse"], 0.04 / (4 + 0.04), places=12)
        self.assertAlmostEqual(found["trimmed"], found["relmse"], places=12)

    def test_trimming_leaves_the_worst_thousandth_out(self):
        reference = np.ones((20, 50, 3))
        image = reference.copy()
        image[3, 4] = 100.0
        found = pictures.error(image, reference)
        self.assertAlmostEqual(found["relmse"], 99.0 ** 2 / 1.01 / 1000, places=9)
        self.assertEqual(found["trimmed"], 0.0)

    def test_pfm_rows_run_from_the_top(self):
        rows = np.arange(12, dtype="<f4").reshape(2, 2, 3)
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "a.pfm"
            path.write_bytes(b"PF\n2 2\n-1.0\n" + rows.tobytes())
            np.testing.assert_array_equal(pictures.read_pfm(path), rows[::-1])


if __name__ == "__main__":
    unittest.main()
