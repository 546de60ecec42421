"""Images for tests of the kinome-compare command."""

import contextlib
import io
import json
import pathlib
import sys
import tempfile
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path[:0] = [str(ROOT / "validation"), str(ROOT / "tests/support")]
from compare import Estimate  # noqa: E402
from compare.command import main  # noqa: E402
from simulated_renders import RENDERS, noisy, picture, write_exr, write_rgb  # noqa: E402


class ComparedFiles(unittest.TestCase):
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

    def reference(self, name, seeds=RENDERS, change=lambda channels: None, header=()):
        e = Estimate.from_renders("x", [np.repeat(noisy(np.random.default_rng(100 + i), picture(),
                                                        50, "gamma")[:, :, None], 3, axis=2)
                                        for i in range(RENDERS)])
        channels = {n: e.mean[:, :, i] for i, n in enumerate("RGB")}
        channels |= {f"variance.{n}": e.variance[:, :, i] for i, n in enumerate("RGB")}
        change(channels)
        write_exr(self.folder / f"{name}.exr", channels, header=header)
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
