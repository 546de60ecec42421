"""Tests of `kinome --part` and `kinome merge`: separately rendered parts are merged into the same
file as a single program writes, and the scripts of scenes/farm work."""

import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import numpy as np
import OpenImageIO as oiio

ROOT = pathlib.Path(__file__).resolve().parents[4]
PROGRAM = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build")).resolve() / "bin/kinome"
MERGE = PROGRAM.with_name("kinome-merge")
SCENE = """<scene version="3.0.0">
  <default name="integrator" value="path"/> <default name="spp" value="6"/>
  <default name="size" value="40"/> <default name="format" value="openexr"/>
  <integrator type="$integrator"/>
  <sensor type="perspective">
    <transform name="to_world"> <lookat origin="0,2,4" target="0,0.5,0" up="0,1,0"/> </transform>
    <sampler type="independent"> <integer name="sample_count" value="$spp"/> </sampler>
    <film type="hdrfilm">
      <integer name="width" value="$size"/> <integer name="height" value="30"/>
      <string name="file_format" value="$format"/>
    </film>
  </sensor>
  <emitter type="constant"/>
  <shape type="sphere"> <point name="center" value="0,1,0"/> <bsdf type="roughplastic"/> </shape>
  <shape type="rectangle">
    <transform name="to_world"> <rotate x="1" angle="-90"/> <scale value="3"/> </transform>
    <emitter type="area"/>
  </shape>
</scene>
"""


def header(path):
    return {a.name: a.value for a in oiio.ImageInput.open(str(path)).spec().extra_attribs}


def colours(path):
    image = oiio.ImageInput.open(str(path))
    spec = image.spec()
    return image.read_image(oiio.FLOAT).reshape(spec.height, spec.width, spec.nchannels)[:, :, :3]


class Parts(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        (self.folder / "scene.xml").write_text(SCENE)

    def run_program(self, *words, program=PROGRAM, status=0, env=None):
        result = subprocess.run([str(program), *map(str, words)], cwd=self.folder, check=False,
                                capture_output=True, text=True, timeout=1200,
                                env=os.environ | (env or {}))
        self.assertEqual(result.returncode, status, (words, result.stdout, result.stderr))
        return result.stderr

    def render(self, part, *options, **more):
        return self.run_program("scene.xml", "--part", part, *options, **more)

    def refused(self, words, *options, program=PROGRAM):
        says = self.run_program(*options, program=program, status=1)
        self.assertEqual(says.count("\n"), 1, says)
        self.assertRegex(says, r"^kinome: .*" + re.escape(words))

    def bytes(self, name):
        return (self.folder / name).read_bytes()

    def test_merged_parts_equal_the_whole_file(self):
        for integrator in ("path", "clustered"):
            options = ["-D", f"integrator={integrator}", "--seed", 5]
            self.render("all/3", *options, "-o", "whole", "--png", "-t", 1)
            for i in (1, 2, 3):
                self.render(f"{i}/3", *options, "-t", i)
            says = self.run_program(*[f"scene-part{i}of3.exr" for i in (2, 3, 1)], "-o", "merged",
                                    "--png", program=MERGE)
            self.assertRegex(says, r"^wrote merged.exr: 3 of 3 parts \(")
            for extension in ("exr", "png"):
                self.assertEqual(self.bytes(f"merged.{extension}"), self.bytes(f"whole.{extension}"))
        found = header(self.folder / "merged.exr")
        self.assertEqual((found["kinome:parts"], found["kinome:samples"], found["kinome:seed"]),
                         ("3", "6", "5"))

    def test_a_part_is_an_image_that_describes_itself(self):
        says = self.render("3/12", "--png")
        self.assertIn("12 parts with 1 sample each have 12 in total, but the scene requests 6", says)
        self.assertIn("wrote scene-part03of12.exr", says)
        path = self.folder / "scene-part03of12.exr"
        found = header(path)
        self.assertEqual((found["kinome:part"], found["kinome:samples"], found["kinome:complete"]),
                         ("3/12", "1", "true"))
        self.assertEqual(colours(path).shape, (30, 40, 3))
        self.assertGreater(colours(path).mean(), 0.1)
        # The part has one sample: it is noisy, but otherwise correct.
        self.render("all/12", "-o", "whole")
        whole = colours(self.folder / "whole.exr")
        self.assertLess(abs(colours(path).mean() / whole.mean() - 1), 0.1)
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()),
                         ["scene-part03of12.exr", "scene-part03of12.png", "scene.xml", "whole.exr"])

    def test_parts_that_are_missing(self):
        for i in (1, 2, 4):
            self.render(f"{i}/5", "-o", f"{i}")
        parts = ["4.exr", "2.exr", "1.exr"]
        self.refused("parts 3 and 5 of 5 are missing: add --allow-missing to merge the parts that exist",
                     "merge", *parts, "-o", "a")
        says = self.run_program("merge", *parts, "-o", "a", "--allow-missing")
        self.assertRegex(says, r"^wrote a.exr: 3 of 5 parts; parts 3 and 5 are missing \(")
        found = header(self.folder / "a.exr")
        self.assertEqual((found["kinome:missing_parts"], found["kinome:samples"],
                          found["kinome:complete"]), ("3 and 5", "6", "false"))
        self.refused("2.exr: it is given twice", "merge", *parts, "2.exr", "-o", "b")
        # Parts of other images, by their difference.
        for words, *options in [("its seed is 1, expected 0", "--seed", 1),
                                ("its scene (scene.xml) or its values of -D differ",
                                 "-D", "size=41")]:
            self.render("3/5", "-o", "3", *options)
            self.refused("3.exr: it is not a part of the same image as 4.exr: " + words, "merge", *parts,
                         "3.exr", "-o", "b")
        self.render("3/6", "-o", "3")
        self.refused("its number of parts is 6, expected 5", "merge", *parts, "3.exr", "-o", "b")
        self.assertFalse((self.folder / "b.exr").exists())

    def test_files_that_are_no_parts(self):
        self.render("1/1", "-o", "1")
        self.run_program("scene.xml", "-o", "picture")
        data = self.bytes("1.exr")
        for name, contents in [("empty", b""), ("cut", data[:len(data) // 2]), ("head", data[:300]),
                               ("text", b"a letter"), ("sums", data[:-900] + bytes(900))]:
            (self.folder / f"{name}.exr").write_bytes(contents)
            self.refused(f"{name}.exr: ", "merge", f"{name}.exr", "-o", "a")
        self.refused("picture.exr: it is an image, but not a part", "merge", "picture.exr", "-o", "a")
        self.refused("none.exr: can't be read: no such file", "merge", "1.exr", "none.exr", "-o", "a")
        self.refused("1.exr': this file was read", "merge", "1.exr", "-o", "1")
        self.refused("unknown image format '.pngg'", "merge", "1.exr", "-o", "1.pngg")
        self.refused("--output is required", "merge", "1.exr", program=PROGRAM)
        self.refused("nowhere", "merge", "1.exr", "-o", "nowhere/a.exr")
        self.assertFalse((self.folder / "a.exr").exists())

    def test_errors_of_the_command_line(self):
        for text in ("3", "0/4", "5/4", "3/", "/4", "3/4/5", "all", "all/0", "-1/4", "1/65537",
                     "1.5/4"):
            self.refused("--part: expected I/N, such as 3/16", "scene.xml", f"--part={text}")
        for options in (["--time", 1], ["--error", 0.1], ["--variance"]):
            self.refused(f"{options[0]}: can't be combined with --part: ", "scene.xml", "--part", "1/2",
                         *options)
        self.refused("--part: can't be combined with --inspect", "scene.xml", "--part", "1/2",
                     "--inspect=1,1")
        self.refused("writes .pfm files, which can't hold its sums", "scene.xml", "--part", "1/2", "-D",
                     "format=pfm")
        self.assertIn("--part is ignored", self.run_program("scene.xml", "--check", "--part", "1/2"))
        self.assertEqual([p.name for p in self.folder.iterdir()], ["scene.xml"])

    def test_a_part_that_is_interrupted(self):
        options = ["-D", "spp=40000", "-D", "size=200", "--checkpoint", "c", "--every", "0"]
        program = subprocess.Popen([PROGRAM, "-q", "scene.xml", "--part", "2/4", "-o", "2", *options],
                                   cwd=self.folder)
        end = time.monotonic() + 60
        while not (self.folder / "c").exists() and time.monotonic() < end:
            time.sleep(0.01)
        program.send_signal(signal.SIGINT)
        self.assertEqual(program.wait(60), 128 + signal.SIGINT)
        self.assertEqual(header(self.folder / "2.exr")["kinome:complete"], "false")
        self.refused("parts 1, 3 and 4 of 4 are missing", "merge", "2.exr", "-o", "a")
        says = self.run_program("merge", "2.exr", "-o", "a", "--allow-missing")
        self.assertRegex(says, r"parts 1, 3 and 4 are missing; part 2 is incomplete, "
                               r"\d+ % of the pixels missing")
        self.refused("checkpoint 'c': it belongs to another render: its --part is '2/4', expected "
                     "'3/4'", "scene.xml", "--part", "3/4", "-o", "3", *options, "--resume")

    def test_a_part_goes_on_from_its_checkpoint(self):
        options = ["-D", "spp=2000", "-D", "size=64", "-t", 1]
        self.render("2/2", "-o", "whole", *options)
        program = subprocess.Popen([PROGRAM, "-q", "scene.xml", "--part", "2/2", "-o", "2", *map(str, options),
                                    "--checkpoint", "c", "--every", "0"], cwd=self.folder)
        end = time.monotonic() + 60
        while not (self.folder / "c").exists() and time.monotonic() < end:
            time.sleep(0.001)
        program.kill()
        program.wait(60)
        self.render("2/2", "-o", "2", *options, "--checkpoint", "c", "--resume")
        self.assertEqual(self.bytes("2.exr"), self.bytes("whole.exr"))
        self.assertFalse((self.folder / "c").exists())

    def check_script(self, *command, count, env=None):
        self.run_program(*command[1:], program=command[0],
                         env={"KINOME": str(PROGRAM), "KINOME_ISA": ""} | (env or {}))
        self.render(f"all/{count}", "-o", "whole", env={"KINOME_ISA": ""})
        return self.bytes("whole.exr")

    def test_the_script_for_gnu_parallel_and_xargs(self):
        whole = self.check_script("sh", ROOT / "scenes/farm/parts.sh", "scene.xml", 3, "out", "-t", 1,
                                  count=3)
        self.assertEqual(self.bytes("out/picture.exr"), whole)
        # Only missing parts are rendered again.
        before = (self.folder / "out/part-1of3.exr").stat().st_mtime_ns
        (self.folder / "out/part-2of3.exr").unlink()
        self.check_script("sh", ROOT / "scenes/farm/parts.sh", "scene.xml", 3, "out", count=3)
        self.assertEqual((self.folder / "out/part-1of3.exr").stat().st_mtime_ns, before)
        self.assertEqual(self.bytes("out/picture.exr"), whole)

    def test_the_script_for_dask(self):
        """Uses a stand-in for Dask if it isn't installed: a bag that runs its tasks immediately."""
        if shutil.which("dask") is None:
            (self.folder / "dask").mkdir()
            (self.folder / "dask/__init__.py").touch()
            (self.folder / "dask/bag.py").write_text(
                "class Bag(list):\n"
                "    def map(self, function, **more): return Bag(function(i, **more) for i in self)\n"
                "    def compute(self): return list(self)\n"
                "def from_sequence(items, npartitions): return Bag(items)\n")
        whole = self.check_script(sys.executable, ROOT / "scenes/farm/parts_dask.py", "scene.xml", 3,
                                  "out", "-t", 1, count=3, env={"PYTHONPATH": str(self.folder)})
        self.assertEqual(self.bytes("out/picture.exr"), whole)

    def test_the_script_for_slurm(self):
        """Runs the script with the environment of an array's tasks."""
        script = ROOT / "scenes/farm/parts.slurm"
        isa = {"KINOME_ISA": header_isa(self)}
        for i in (1, 2, 3):
            task = {"SLURM_ARRAY_TASK_ID": str(i), "SLURM_ARRAY_TASK_COUNT": "3",
                    "SLURM_CPUS_PER_TASK": "1", "KINOME": str(PROGRAM)} | isa
            if i == 3:  # submitted again by itself
                task |= {"SLURM_ARRAY_TASK_COUNT": "1", "PARTS": "3"}
            self.run_program(script, "scene.xml", "out", "-q", program="sh", env=task)
        self.run_program("merge", *sorted((self.folder / "out").glob("*.exr")), "-o", "merged")
        self.render("all/3", "-o", "whole", env=isa)
        self.assertEqual(self.bytes("merged.exr"), self.bytes("whole.exr"))
        self.assertRegex(script.read_text(), r"(?m)^#SBATCH --array=1-\d+$")
        self.assertIn("this is a script for sbatch",
                      self.run_program(script, "scene.xml", "out", program="sh", status=2))


def header_isa(test):
    """Returns the instruction set of plugins here. The scripts request one that all machines
    support."""
    test.render("1/1", "-o", "isa")
    return header(test.folder / "isa.exr")["kinome:isa"]


if __name__ == "__main__":
    unittest.main()
