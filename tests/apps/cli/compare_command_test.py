"""Tests of the kinome-compare command: input, output and errors."""

import contextlib
import importlib.util
import io
import json
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import tempfile
import threading
import types
import unittest
import unittest.mock

import numpy as np
import OpenImageIO as oiio

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "validation"), str(ROOT / "tests/support")]
from compare import BadInput, Estimate, images, load  # noqa: E402
from compare.command import main, report  # noqa: E402
from simulated_renders import (HEIGHT, RENDERS, WIDTH, noisy, picture, write_exr,  # noqa: E402
                               write_parts, write_rgb)

FLIP_OF_THE_SYSTEM = importlib.util.find_spec("flip_evaluator")


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
        # The emitter has no noise. Its rim of 18 pixels is next to noise and is tested only by
        # tiles.
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

    def test_the_header_says_how_many_renders_there_are(self):
        a = self.renders("a", picture(), 1)
        told = self.reference("told", seeds=None, header={"kinome:renders": "16"})
        status, out, errors = self.run_command(a, told)
        self.assertEqual((status, errors), (0, ""), out)
        self.assertIn("told.exr, 16 renders", out)
        self.assertIn("told.exr, 5 renders", self.run_command(a, told, "--renders-b", 5)[1])
        for text in ("3", "many", "-16"):
            self.reference("told", seeds=None, header={"kinome:renders": text})
            self.assert_bad(f"comes from {text} independent renders, by kinome:renders", a, told)
        self.reference("told", seeds=None, header={"kinome:renders": "2",
                                                   "kinome:complete": "false"})
        self.assert_bad("in its header, because it was interrupted; needs at least 4", a, told)

    def test_damaged_variances_of_tiles_are_refused(self):
        a, header = self.renders("a", picture(), 1), {"kinome:renders": "16"}

        def tiles(value):
            def change(channels):
                for name in "RGB":
                    channels[f"tile_variance.{name}"] = np.full((HEIGHT, WIDTH), value)
            return change

        for value, text, words in ((1e-5, None, "no kinome:variance_of_mean"),
                                   (1e-5, "1e-7 1e-7", "no kinome:variance_of_mean"),
                                   (1e-5, "a b c", "no kinome:variance_of_mean"),
                                   (-1e-5, "1e-7 1e-7 1e-7", "negative or not finite"),
                                   (np.nan, "1e-7 1e-7 1e-7", "negative or not finite"),
                                   (1e-5, "1e-7 nan 1e-7", "negative or not finite")):
            if text is not None:
                header["kinome:variance_of_mean"] = text
            bad = self.reference("bad", change=tiles(value), header=header)
            self.assert_bad(words, a, bad)
        header["kinome:variance_of_mean"] = "1e-7 1e-7 1e-7"
        good = self.reference("good", seeds=None, change=tiles(1e-5), header=header)
        self.assertEqual(self.run_command(a, good)[2], "")

    def test_patterns_that_the_shell_spells_out(self):
        self.renders("a", picture(), 1), self.renders("b", picture(), 2)
        a, b = (sorted(map(str, self.folder.glob(f"{name}*.exr"))) for name in "ab")
        reference = self.reference("ref")
        status, out, errors = self.run_command(*a, reference, "-q")
        self.assertEqual((status, out, errors), (0, "pass\n", ""))
        for command in ((*a, "--reference", *b), (*a, "-q", "-r", *b),
                        (self.folder / "a*.exr", "-r", *b), (*a, self.folder / "b*.exr")):
            status, out, errors = self.run_command(*command)
            self.assertEqual((status, errors), (0, ""), out)
            if "-q" not in command:
                self.assertIn("a15.exr, 16 renders\nB: ", out)
                self.assertIn("b15.exr, 16 renders\n", out)
        # It is ambiguous whether the files in the middle belong to A or B, and which side a file
        # with a variance belongs to.
        self.assert_bad("32 files, and it is ambiguous which of them are the reference B", *a, *b)
        other = self.reference("other")
        self.assert_bad("Put --reference before", other, reference, self.reference("third"))
        self.assert_bad("none.exr: no such file", *a, self.folder / "none.exr")
        for arguments in ((), (reference,), ("--reference", reference)):
            with self.assertRaises(SystemExit) as end, contextlib.redirect_stderr(
                    io.StringIO()) as said:
                main([str(argument) for argument in arguments])
            self.assertEqual(end.exception.code, 2)
            self.assertIn("expected two images to compare, A and B", said.getvalue())

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
        self.assert_bad("one render, without a variance", self.folder / "a00.exr", b)
        few = ",".join(str(self.folder / f"a0{i}.exr") for i in range(3))
        self.assert_bad("3 renders, needs at least 4", few, b)
        self.assert_bad("needs at least 4", a, self.reference("two", seeds=2))

        def spoil(channels):
            channels["G"][1, 2] = np.nan

        self.assert_bad("the reference contains 1 NaN", a, self.reference("nan", change=spoil))
        shutil.copy(self.folder / "a03.exr", self.folder / "a99.exr")
        self.assert_bad("different seeds", a, b)
        (self.folder / "a99.exr").unlink()
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

    def test_colours_of_any_name_are_compared(self):
        """Tests XYZ films, layers, and a part after a depth part."""
        image = picture()[:, :, None] * (0.8, 0.2, 0.05)
        to_xyz = np.array([[0.412453, 0.357580, 0.180423], [0.212671, 0.715160, 0.072169],
                           [0.019334, 0.119193, 0.950227]])
        stored = {"X": image @ to_xyz[0], "Y": image @ to_xyz[1], "Z": image @ to_xyz[2]}
        write_exr(self.folder / "xyz.exr", stored)
        layers = {f"View.AO.{n}": np.ones((HEIGHT, WIDTH)) for n in "RGB"}
        layers |= {f"View.Combined.{n}": image[:, :, i] for i, n in enumerate("RGB")}
        write_exr(self.folder / "layers.exr", layers)
        parts = [({"Z": np.ones((HEIGHT, WIDTH))}, "depth"),
                 ({n: image[:, :, i] for i, n in enumerate("rgb")}, "beauty")]
        write_parts(self.folder / "parts.exr", parts)
        for name in ("xyz", "layers", "parts"):
            channels = images.read(self.folder / f"{name}.exr").channels
            found = images.colour(name, channels)
            np.testing.assert_allclose(found, image, rtol=0, atol=2e-6, err_msg=name)

    def test_a_file_given_twice_is_no_other_render(self):
        a, b = self.renders("a", picture(), 1, count=5), self.reference("ref")
        one = self.folder / "a00.exr"
        self.assert_bad("a00.exr: given more than once", ",".join([str(one)] * 4), b)
        self.assert_bad("a00.exr: given more than once", a, f"{b},{one},{one}")
        self.assert_bad("a01.exr: given more than once", f"{a},{self.folder}/a01*", b)
        self.assert_bad("the same file", f"{a},{self.folder}/../{self.folder.name}/a02.exr", b)
        for make in (os.symlink, os.link):
            make(one, self.folder / "a10.exr")
            self.assert_bad(f"{one} and {self.folder}/a10.exr: the same file", a, b)
            (self.folder / "a10.exr").unlink()
        # Python interns the shortest names.
        shutil.copy(one, self.folder / "q")
        with contextlib.chdir(self.folder):
            self.assert_bad("q: given more than once", "q,q,q,q", b)
        # A broken link is no repetition, but no image either.
        os.symlink("none.exr", self.folder / "a10.exr")
        self.assert_bad("a10.exr: can't be read", a, b)
        # Without noise, several files may contain the same image.
        for i in range(4):
            write_rgb(self.folder / f"s{i}.exr", np.full((20, 20, 3), 0.1))
        same = self.folder / "s*.exr"
        self.assertEqual(self.run_command(same, same)[0], 0)

    def test_what_tells_nothing_is_said(self):
        a = self.renders("a", picture(), 1)
        itself = "a00.exr is both in A and in B"
        self.assertIn(itself, self.run_command(a, a)[1])
        others = self.renders("c", picture(), 2)
        self.assertNotIn("is both in A and in B", self.run_command(a, "--reference", others)[1])
        for i in range(8):
            write_rgb(self.folder / f"k{i}.exr", np.zeros((20, 20, 3)))
        status, out, errors = self.run_command(*(self.folder / f"k{i}.exr" for i in range(4)),
                                               "--reference",
                                               *(self.folder / f"k{i}.exr" for i in range(4, 8)))
        self.assertEqual(status, 0, errors)
        self.assertIn("both images are black", out)

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

    def test_no_picture_that_is_compared_is_written_over(self):
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

    def test_outputs_are_whole_or_not_there(self):
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

    def test_an_error_below_the_noise_is_said_in_words(self):
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

    def test_half_floats_are_said(self):
        for i in range(4):
            write_rgb(self.folder / f"h{i}.exr", np.full((20, 20, 3), 0.1), oiio.HALF)
        status, out, _ = self.run_command(self.folder / "h*.exr", self.folder / "h*.exr")
        self.assertEqual(status, 0)
        self.assertIn("half floats", out)


if __name__ == "__main__":
    unittest.main()
