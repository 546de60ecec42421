"""kinome-compare as a command: what it reads, prints and refuses."""

import contextlib
import io
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import OpenImageIO as oiio

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "validation"), str(ROOT / "tests/support")]
from compare import BadInput, Estimate, load  # noqa: E402
from compare.command import main  # noqa: E402
from simulated_renders import (HEIGHT, RENDERS, WIDTH, noisy, picture, write_exr,  # noqa: E402
                               write_rgb)


class Command(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = pathlib.Path(self.temporary.name)

    def renders(self, name, image, seed, count=RENDERS, samples=50):
        rng = np.random.default_rng(seed)
        for i in range(count):
            made = noisy(rng, image, samples, "gamma")
            write_rgb(self.folder / f"{name}{i:02}.exr", np.stack([made] * 3, axis=2))
        return str(self.folder / f"{name}*.exr")

    def reference(self, name, seeds=RENDERS, change=lambda channels: None):
        e = Estimate.from_renders("x", [np.repeat(noisy(np.random.default_rng(100 + i), picture(),
                                                        50, "gamma")[:, :, None], 3, axis=2)
                                        for i in range(RENDERS)])
        channels = {n: e.mean[:, :, i] for i, n in enumerate("RGB")}
        channels |= {f"variance.{n}": e.variance[:, :, i] for i, n in enumerate("RGB")}
        change(channels)
        write_exr(self.folder / f"{name}.exr", channels)
        if seeds is not None:
            (self.folder / f"{name}.json").write_text(json.dumps({"seeds": seeds}))
        return str(self.folder / f"{name}.exr")

    def run_command(self, *arguments):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = main([str(a) for a in arguments])
        return status, out.getvalue(), err.getvalue()

    def assert_bad(self, words, *arguments):
        status, _, errors = self.run_command(*arguments)
        self.assertEqual(status, 2, errors)
        self.assertEqual(errors.count("\n"), 1, errors)
        self.assertTrue(errors.startswith("kinome-compare: "), errors)
        self.assertIn(words, errors)

    def test_the_program_itself(self):
        a, b = self.renders("a", picture(), 1), self.renders("b", picture(), 2)
        result = subprocess.run([ROOT / "validation/kinome-compare", a, b, "--json",
                                 self.folder / "out.json", "--picture", self.folder / "out.png"],
                                capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertEqual(result.stdout.splitlines()[-1], "pass")
        self.assertIn("would find a bias of", result.stdout)
        self.assertIn("FLIP", result.stdout)
        figures = json.loads((self.folder / "out.json").read_text())
        self.assertEqual(set(figures["tests"]), {"image", "tiles", "pixels"})
        # The lamp has no noise; its rim, 18 pixels, lies beside noise and is left to the tiles.
        self.assertEqual(figures["tests"]["pixels"]["values"], 3 * (HEIGHT * WIDTH - 18))
        self.assertTrue((self.folder / "out.png").read_bytes().startswith(b"\x89PNG"))
        self.renders("c", picture() * 1.05, 3)
        status, out, _ = self.run_command(self.folder / "c*.exr", b)
        self.assertEqual(status, 1)
        self.assertIn("FAIL: image", out.splitlines()[-1])

    def test_a_stored_mean_with_its_variance(self):
        a = self.renders("a", picture(), 1)
        self.assertEqual(self.run_command(a, self.reference("ref"))[0], 0)
        alone = self.reference("alone", seeds=None)
        self.assert_bad("--renders-b", a, alone)
        self.assertEqual(self.run_command(a, alone, "--renders-b", 16)[0], 0)
        names = ",".join(str(self.folder / f"a{i:02}.exr") for i in range(RENDERS))
        self.assertEqual(self.run_command(names, self.reference("ref"))[0], 0)

    def test_masked_pixels_of_a_reference_are_said_and_left_out(self):
        def mask(channels):
            channels["mask"] = np.zeros((HEIGHT, WIDTH))
            channels["mask"][7, 3] = 1
            channels["R"][7, 3] = np.nan

        a, b = self.renders("a", picture(), 1), self.reference("ref", change=mask)
        status, out, _ = self.run_command(a, b)
        self.assertEqual(status, 0, out)
        self.assertIn(f"1 of {HEIGHT * WIDTH} pixels masked", out)

    def test_nan_and_inf_in_a_fail_and_are_counted(self):
        a, b = self.renders("a", picture(), 1), self.reference("ref")
        image = np.repeat(picture()[:, :, None], 3, axis=2)
        image[4, 5, 0], image[4, 5, 1], image[9, 9, 2] = np.nan, np.inf, np.nan
        write_rgb(self.folder / "a00.exr", image)
        status, out, _ = self.run_command(a, b)
        self.assertEqual(status, 1)
        self.assertIn("NaN in A: 2, Inf in A: 1; 2 of", out)
        self.assertIn("3 values are NaN or Inf", out.splitlines()[-1])

    def test_bad_input(self):
        a, b = self.renders("a", picture(), 1), self.reference("ref")
        self.assert_bad("no such file", a, self.folder / "none.exr")
        self.assert_bad("no such file", self.folder / "none*.exr", b)
        self.assert_bad("without variance", self.folder / "a00.exr", b)
        few = ",".join(str(self.folder / f"a0{i}.exr") for i in range(3))
        self.assert_bad("3 renders, needs at least 4", few, b)
        self.assert_bad("needs at least 4", a, self.reference("two", seeds=2))

        def spoil(channels):
            channels["G"][1, 2] = np.nan

        self.assert_bad("the reference holds 1 NaN", a, self.reference("nan", change=spoil))
        self.assert_bad("different seeds", ",".join(sorted(
            str(p) for p in self.folder.glob("a*.exr")) + [str(self.folder / "a03.exr")]), b)
        for i in range(4):
            write_rgb(self.folder / f"s{i}.exr", np.full((10, 12, 3), i + 1.0))
        self.assert_bad("is 12x10 with 3 channels, but", self.folder / "s*.exr", b)
        write_rgb(self.folder / "s9.exr", np.ones((11, 12, 3)))
        self.assert_bad("is 12x10", self.folder / "s*.exr", b)
        (self.folder / "text.exr").write_text("not a picture")
        self.assert_bad("can't be read", a, self.folder / "text.exr")
        whole = pathlib.Path(b).read_bytes()
        (self.folder / "cut.exr").write_bytes(whole[:len(whole) // 2])
        self.assert_bad("cut.exr", a, self.folder / "cut.exr", "--renders-b", 16)
        write_exr(self.folder / "depth.exr", {"Z": np.ones((HEIGHT, WIDTH))})
        self.assert_bad("needs channels R, G, B", a, self.folder / "depth.exr")
        (self.folder / "ref.json").write_text("[")
        self.assert_bad("ref.json", a, b)
        with self.assertRaises(BadInput):
            load(self.folder / "none.exr")

    def test_half_floats_are_said(self):
        for i in range(4):
            write_rgb(self.folder / f"h{i}.exr", np.full((20, 20, 3), 0.1), oiio.HALF)
        status, out, _ = self.run_command(self.folder / "h*.exr", self.folder / "h*.exr")
        self.assertEqual(status, 0)
        self.assertIn("half floats", out)


if __name__ == "__main__":
    unittest.main()
