"""Tests of the kinome-compare command: input and errors."""

import contextlib
import io
import json
import os
import pathlib
import shutil
import subprocess
import unittest

import numpy as np

from compared_files import ROOT, ComparedFiles
from compare import BadInput, images, load  # noqa: E402
from compare.command import main  # noqa: E402
from simulated_renders import (HEIGHT, RENDERS, WIDTH, picture, write_exr, write_parts,  # noqa: E402
                               write_rgb)


class Command(ComparedFiles):
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

    def test_the_header_gives_the_number_of_renders(self):
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

    def test_masked_pixels_of_a_reference_are_reported_and_left_out(self):
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

    def test_inconclusive_comparisons_are_reported(self):
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


if __name__ == "__main__":
    unittest.main()
