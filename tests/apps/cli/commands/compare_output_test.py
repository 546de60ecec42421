"""Tests of the kinome-compare command: output files, and what it prints."""

import contextlib
import importlib.util
import io
import json
import os
import resource
import subprocess
import sys
import threading
import types
import unittest
import unittest.mock

import numpy as np
import OpenImageIO as oiio

from compared_files import ROOT, ComparedFiles
from compare import images  # noqa: E402
from compare.command import main, report  # noqa: E402
from simulated_renders import picture, write_rgb  # noqa: E402

FLIP_OF_THE_SYSTEM = importlib.util.find_spec("flip_evaluator")


class Output(ComparedFiles):
    def test_outputs_that_cannot_be_written_are_refused_first(self):
        # Neither A nor B exists: the error is reported before any file is read.
        for option in ("--json", "--picture"):
            for path, words in (("no/out.png", "No such file or directory"),
                                ("file/out.png", "Not a directory"), ("", "Is a directory"),
                                ("new.png/", "Is a directory"), (".", "Is a directory"),
                                ("x" * 300, "File name too long")):
                (self.folder / "file").write_text("")
                path = f"{self.folder}/{path}" if path else path
                self.assert_bad(f"{path}: can't be written: {words}", "none", "none", option, path)
        with self.assertRaises(SystemExit), contextlib.redirect_stderr(io.StringIO()) as said:
            main(["a", "b", "--json", f"{self.folder}/x", "--picture", f"{self.folder}/./x"])
        self.assertIn("--json and --picture are the same file", said.getvalue())
        for name in ("out.jpg", "out.png.pdf", "out.svg"):
            self.assert_bad(f"{name}: --picture writes a PNG", "none", "none", "--picture", name)
        if os.geteuid():  # root may write anywhere
            for path in (self.folder / "read.png", self.folder / "only/out.png"):
                path.parent.mkdir(exist_ok=True)
                path.write_text("")
                (path if path.name == "read.png" else path.parent).chmod(0o500)
                self.assert_bad("Permission denied", "none", "none", "--json", path)
            (self.folder / "only").chmod(0o700)

    def test_no_compared_image_is_overwritten(self):
        a = self.renders("a", picture(), 1, count=4)
        one = self.folder / "a01.exr"
        (self.folder / "link.png").symlink_to(one)
        for path in (one, self.folder / "link.png"):
            before = one.read_bytes()
            self.assert_bad(f"{path}: is one of the compared images", a, a, "--json", path)
            self.assertEqual(one.read_bytes(), before)

    def test_a_full_disk_is_no_verdict(self):
        a = self.renders("a", picture(), 1, count=4)
        with open("/dev/full", "w") as full:
            result = subprocess.run([sys.executable, ROOT / "validation/kinome-compare", a, a],
                                    stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual(result.returncode, 2)
        self.assertEqual(result.stderr, "kinome-compare: stdout can't be written: "
                                        "No space left on device\n")

    def test_outputs_are_complete_or_missing(self):
        a, out = self.renders("a", picture(), 1, count=4), self.folder / "out"
        out.mkdir()
        before = out / "result.json"
        before.write_text("old")
        importlib.import_module("compare.picture")  # matplotlib may write its own files
        limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (500, limits[1]))
        try:
            self.assert_bad("result.json: can't be written: File too large", a, a, "--json", before)
            self.assert_bad("out/picture: can't be written", a, a, "--picture", out / "picture")
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        self.assertEqual([p.name for p in out.iterdir()], ["result.json"])
        self.assertEqual(before.read_text(), "old")
        # A link stays a link, and a name without an extension is used unchanged.
        (out / "link").symlink_to("result.json")
        status, _, errors = self.run_command(a, a, "--json", out / "link", "--picture", out / "p")
        self.assertEqual(status, 0, errors)
        self.assertTrue((out / "link").is_symlink())
        self.assertTrue(json.loads(before.read_text())["passed"])
        self.assertTrue((out / "p").read_bytes().startswith(b"\x89PNG"))
        self.assertEqual(len(list(out.iterdir())), 3)

    def test_a_pipe_is_written_to_and_stays_one(self):
        a, pipe, read = self.renders("a", picture(), 1, count=4), self.folder / "pipe", []
        os.mkfifo(pipe)
        reader = threading.Thread(target=lambda: read.append(pipe.read_text()), daemon=True)
        reader.start()
        self.assertEqual(self.run_command(a, a, "--json", pipe)[0], 0)
        reader.join(10)
        self.assertTrue(json.loads(read[0])["passed"])
        self.assertTrue(pipe.is_fifo())
        self.assert_bad("/dev/full: can't be written: No space", a, a, "--json", "/dev/full")

    def test_stdout_that_is_a_file_keeps_all_that_is_printed(self):
        a = self.renders("a", picture(), 1, count=4)
        with open(self.folder / "all.txt", "wb") as out:
            result = subprocess.run([sys.executable, ROOT / "validation/kinome-compare", a, a,
                                     "--json", "/dev/stdout"], stdout=out, check=False)
        self.assertEqual(result.returncode, 0)
        text = (self.folder / "all.txt").read_text()
        figures, end = json.JSONDecoder().raw_decode(text)
        self.assertTrue(figures["passed"])
        self.assertIn("relMSE of A's mean", text[end:])
        self.assertTrue(text.endswith("pass\n"))

    def test_an_error_below_the_noise_is_described(self):
        a, b = self.renders("a", picture(), 1), self.folder / "out.json"
        status, out, _ = self.run_command(a, a, "--json", b)
        self.assertEqual(status, 0, out)
        figures = json.loads(b.read_text())
        # A compared with itself: only the subtracted noise remains.
        self.assertLess(figures["relmse"]["relmse"], 0)
        mean, one = (line for line in out.splitlines() if line.startswith("relMSE of"))
        self.assertIn("A's mean: below the reference's noise (-", mean)
        self.assertIn("0.1 %: below the reference's noise (-", mean)
        self.assertNotIn("below", one)
        figures["relmse"] = {"relmse": 2e-3, "trimmed": -1.2e-6, "maximum": 0.0}
        self.assertIn("relMSE of A's mean: 0.002, without the worst 0.1 %: below the reference's "
                      "noise (-1.2e-06), maximum 0", report(figures))

    def test_how_to_get_flip(self):
        a = self.renders("a", picture(), 1, count=4)
        with unittest.mock.patch.dict(sys.modules, {"flip_evaluator": None}):
            status, out, errors = self.run_command(a, a)
            quiet = self.run_command(a, a, "-q")
        self.assertEqual((status, errors), (0, ""))
        line, = (line for line in out.splitlines() if "FLIP" in line)
        self.assertIn("flip-evaluator is missing", line)
        self.assertIn("sh validation/run.sh", line)
        self.assertEqual(quiet, (0, "pass\n", ""))

    def test_flip_has_no_exposures_for_a_black_reference(self):
        made = types.SimpleNamespace(evaluate=lambda *_: self.fail("would end the process"))
        a = self.renders("a", 0 * picture(), 1, count=4)
        with unittest.mock.patch.dict(sys.modules, {"flip_evaluator": made}):
            status, out, errors = self.run_command(a, a)
        self.assertEqual((status, errors), (0, ""), out)
        self.assertIn("HDR-FLIP: not measured, because B is black\n", out)

    @unittest.skipIf(FLIP_OF_THE_SYSTEM, "the system's own comes first")
    def test_flip_of_the_virtual_environment_is_found(self):
        a = self.renders("a", picture(), 1, count=4)
        packages = self.folder / "build/validation/mitsuba/lib/python3/site-packages"
        packages.mkdir(parents=True)
        (packages / "flip_evaluator.py").write_text("def evaluate(*_):\n    return None, 0.125\n")
        command = [sys.executable, ROOT / "validation/kinome-compare", a, a]
        result = subprocess.run(command, capture_output=True, text=True, check=False,
                                env=os.environ | {"KINOME_BUILD": str(self.folder / "build")})
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("HDR-FLIP of A's mean: 0.125", result.stdout)

    def test_half_floats_are_reported(self):
        for i in range(4):
            write_rgb(self.folder / f"h{i}.exr", np.full((20, 20, 3), 0.1), oiio.HALF)
        status, out, _ = self.run_command(self.folder / "h*.exr", self.folder / "h*.exr")
        self.assertEqual(status, 0)
        self.assertIn("half floats", out)


if __name__ == "__main__":
    unittest.main()
