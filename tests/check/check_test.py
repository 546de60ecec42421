"""Tests that `kinome check` reports the faults of faulty plugins, and none of the project's own."""
import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import unittest

from wrong_plugins import WRONG_PLUGINS, library, planted

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs"))
import checks  # noqa: E402

BUILD = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build"))
PROGRAM = BUILD / "bin/kinome"
WRONG = BUILD / "tests/check/plugins"

# Options for the project's own plugins: required parameters, and checks that don't apply.
OWN = {
    "bsdf/hair": ["--except", "reciprocity"],  # its scales are tilted
    "emitter/envmap": ["-D", "filename=FOLDER/image.pfm"],
    "integrator/aov": ["-D", "aovs=depth:depth"],
    "integrator/path": ["--against", "ptracer"],
    "sensor/distant": ["-D", "film=ONE_PIXEL"],
    "sensor/radiancemeter": ["-D", "film=ONE_PIXEL"],
    "shape/bsplinecurve": ["-D", "filename=FOLDER/curves.txt"],
    "shape/instance": ["-D", "group=<shape type='shapegroup'><shape type='cube'/></shape>"],
    "shape/linearcurve": ["-D", "filename=FOLDER/curves.txt"],
    "shape/merge": ["-D", "part=<shape type='cube'/>"],
    "shape/obj": ["-D", "filename=FOLDER/mesh.obj"],
    "shape/ply": ["-D", "filename=FOLDER/mesh.ply"],
    "phase/sggx": ["-D", "S=<volume name='S' type='gridvolume'><string name='filename' "
                         "value='FOLDER/flakes.vol'/></volume>"],
    "phase/tabphase": ["-D", "values=1 0 3"],
    "texture/bitmap": ["-D", "filename=FOLDER/image.pfm"],
    "texture/blackbody": ["-D", "temperature=5000"],
    "texture/irregular": ["-D", "wavelengths=400 500 700", "-D", "values=0.1 0.5 0.2"],
    "texture/mesh_attribute": ["-D", "name=vertex_color"],
    "texture/regular": ["-D", "wavelength_min=400", "-D", "wavelength_max=700",
                        "-D", "values=0.1 0.5 0.2"],
    "texture/scale": ["-D", "texture=<texture type='checkerboard'/>"],
    "volume/gridvolume": ["-D", "filename=FOLDER/grid.vol", "-D", "wrap_mode=mirror",
                          "-D", "to_world=0.9 0.2 0 1  -0.3 1.1 0 0  0 0.4 2 -1  0 0 0 1"],
}
# Too complex to be built from options here: gltf and serialized have their own tests.
LEFT_OUT = {"shape/gltf", "shape/glb", "shape/serialized"}
ONE_PIXEL = ("<film type='hdrfilm'><integer name='width' value='1'/><integer name='height' value='1'/>"
             "</film>")


def check(plugin, *options):
    """Returns (exit status, {name of a failed check: message}, whole output)."""
    result = subprocess.run([PROGRAM, "check", plugin, "--effort", "0.3", *options],
                            capture_output=True, text=True, timeout=2000)
    faults = {}
    for line in result.stdout.splitlines():
        if line.startswith("  FAULT "):
            name, text = line.split(None, 2)[1:]
            faults[name] = text
    return result.returncode, faults, result.stdout + result.stderr


class WrongPlugins(unittest.TestCase):
    def test_right_ones_pass(self):
        for source in WRONG_PLUGINS:
            with self.subTest(source):
                status, faults, text = check(WRONG / library(source))
                self.assertEqual((status, faults), (0, {}), text)

    def test_each_fault_is_named(self):
        for source, rows in WRONG_PLUGINS.items():
            for fault, _, name, said in rows:
                with self.subTest(source=source, fault=fault):
                    status, faults, text = check(WRONG / library(source), "-D", f"fault={fault}",
                                                 "--only", name)
                    self.assertEqual(status, 1, text)
                    self.assertEqual(list(faults), [name], text)
                    self.assertTrue(any(way in faults[name] for way in said.split("|")), text)


def without_numbers(text):
    return re.sub(r"[\d.]+", "0", text)


class Page(unittest.TestCase):
    """docs/checks.md must be up to date, except for measured numbers."""

    def test_faults_match_the_sources(self):
        self.assertEqual({source: {row[0] for row in rows}
                          for source, rows in WRONG_PLUGINS.items()}, planted())

    def test_the_table_lists_all_faults(self):
        page = (ROOT / "docs/checks.md").read_text("utf-8")
        shown = checks.rows_of(page)
        self.assertEqual([row[:4] for row in shown],
                         [(source, *row[:3]) for source, rows in WRONG_PLUGINS.items()
                          for row in rows], "python3 docs/checks.py writes the page")
        for (*_, printed), said in zip(shown, (row[3] for rows in WRONG_PLUGINS.values() for row in rows)):
            self.assertTrue(any(without_numbers(way) in without_numbers(printed)
                                for way in said.split("|")), printed)

    def test_transcript_has_the_checks_of_today(self):
        page = (ROOT / "docs/checks.md").read_text("utf-8")
        _, _, text = check(WRONG / "emitter/wrong.so")
        names = re.findall("^  ok +([a-z_]+) ", text, re.MULTILINE)
        self.assertGreater(len(names), 8)
        shown = re.findall("^  (?:ok|FAULT) +([a-z_]+) ", page, re.MULTILINE)
        self.assertEqual(shown, 2 * names, "python3 docs/checks.py writes the page")


class OwnPlugins(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        texels = [(i * 7 % 15, i * 4 % 13, 100 if i == 8 else 1) for i in range(15)]
        (self.folder / "image.pfm").write_bytes(
            b"PF\n5 3\n-1.0\n" + b"".join(struct.pack("<3f", *texel) for texel in texels))
        (self.folder / "grid.vol").write_bytes(
            b"VOL\x03" + struct.pack("<5i6f", 1, 5, 4, 3, 3, *range(6)) +
            b"".join(struct.pack("<f", (i * 37 + 11) % 101 / 101) for i in range(180)))
        # Two of rotated ellipsoids.
        (self.folder / "flakes.vol").write_bytes(
            b"VOL\x03" + struct.pack("<5i6f", 1, 2, 1, 1, 6, *range(6)) +
            struct.pack("<12f", 0.7, 0.5, 0.3, 0.2, -0.1, 0.15, 1, 0.02, 0.9, 0, 0.3, 0))
        (self.folder / "mesh.obj").write_text(
            "v -1 -1 0\nv 1 -1 0\nv 1 1 0.5\nv -1 1 0\nf 1 2 3\nf 1 3 4\n")
        (self.folder / "mesh.ply").write_text(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
            "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
            "0 0 0\n1 0 0\n0 1 1\n3 0 1 2\n")
        (self.folder / "curves.txt").write_text(
            "-1 0 0 0.2\n-0.5 0.5 0 0.2\n0.5 0 0.3 0.3\n1 0 0 0.2\n1.5 0.2 0 0.2\n")

    def names(self):
        listed = subprocess.run([PROGRAM, "plugins"], capture_output=True, text=True, check=True)
        category = ""
        for line in listed.stdout.splitlines():
            if not line.startswith(" "):
                category = line.strip()
            elif re.match(r"  [a-z0-9_]+ ", line) and "another name for" not in line:
                yield f"{category}/{line.split()[0]}"

    def test_all_are_right(self):
        names = [name for name in self.names() if name not in LEFT_OUT]
        self.assertGreater(len(names), 60)
        self.assertLessEqual(OWN.keys(), set(names))
        for name in names:
            options = [option.replace("FOLDER", str(self.folder)).replace("ONE_PIXEL", ONE_PIXEL)
                       for option in OWN.get(name, [])]
            with self.subTest(name):
                status, faults, text = check(name, *options)
                self.assertEqual((status, faults), (0, {}), text)


class Against(unittest.TestCase):
    """Compares the light of one emitter with that of another."""

    def light(self, plugin, *options):
        status, faults, text = check(plugin, "--only", "light", *options)
        self.assertEqual(status, 1 if faults else 0, text)
        return faults.get("light", "")

    def test_same_light(self):
        half = "<emitter type='spot'><float name='cutoff_angle' value='%s'/></emitter>"
        self.assertEqual(self.light("constant", "--against", "constant", "-D", "radiance=1, 2, 3"), "")
        self.assertEqual(self.light("spot", "--against", half % 20), "")
        self.assertIn("times the light of emitter/spot", self.light("spot", "--against", half % 21))
        self.assertEqual(self.light("area", "--against", "area"), "")
        self.assertEqual(self.light(WRONG / "emitter/wrong.so", "--against", "constant"), "")
        self.assertEqual(self.light("path", "--against", "ptracer", "-D", "max_depth=2"), "")

    def test_other_light(self):
        bright = "<emitter type='constant'><rgb name='radiance' value='1, 1, 1.3'/></emitter>"
        self.assertIn("times the light of emitter/constant to a plane",
                      self.light("constant", "--against", bright))
        self.assertRegex(self.light(WRONG / "emitter/wrong.so", "--against", "constant",
                                    "-D", "fault=twice the density of positions"),
                         r"its sample_emission\(\) sends 0\.(49|50)\d* times the light")
        turned = ("<emitter type='sunsky'><transform name='to_world'><rotate y='1' angle='2'/>"
                  "</transform></emitter>")
        self.assertIn("emitter/sunsky", self.light("sunsky", "--against", turned))


class CommandLines(unittest.TestCase):
    def mistake(self, words, status, said):
        with self.subTest(words=words):
            result = subprocess.run([PROGRAM, *words], capture_output=True, text=True)
            self.assertEqual(result.returncode, status, result.stdout + result.stderr)
            self.assertIn(said, result.stderr)
            self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
            self.assertNotIn("FAULT", result.stdout)

    def test_plugins_that_cannot_be_checked(self):
        for words, said in (
                (["diffus"], "unknown plugin 'diffus' (did you mean 'diffuse'?)"),
                (["diffuse", "-D", "reflectans=1"], "did you mean 'reflectance'?"),
                (["diffuse", "-D", "reflectance=red"], "-D reflectance=red: "),
                (["sphere", "-D", "center=0 0 0", "-D", "radius=wide"], "-D radius=wide: "),
                (["sphere", "-D", "center=0 0", "-D", "radius=1"], "-D center=0 0: "),
                (["roughplastic", "-D", "alpha=-1"], "-D alpha=-1: 'alpha' must not be negative"),
                (["roughplastic", "-D", "distribution=phong"], "-D distribution=phong: "),
                (["bumpmap", "-D", "bsdf=<bsdf type='difuse'/>"],
                 "-D bsdf=<bsdf type='difuse'/>: "),
                (["bumpmap", "-D", "bsdf=<bsdf"], "malformed XML"),
                (["hdrfilm", "-D", "crop_width=10", "-D", "crop_offset_x=5", "-D", "width=12"], "-D"),
                (["ply", "-D", "filename=no/such.ply"], "-D filename=no/such.ply: "),
                (["diffuse", "--against", "path"], "--against: bsdf/diffuse is neither an integrator nor an emitter"),
                (["area", "--against", "constant"], "only one of them is part of a shape"),
                (["point", "--against", "<bsdf type='diffuse'/>"],
                 "--against: emitter/point can't be compared with bsdf/diffuse"),
                (["constant", "--against", "envmap"], "--against: "),
                (["direct", "--against", "pathh"], "--against: "),
                (["diffuse", "--only", "enrgy"], "unknown check 'enrgy'"),
                (["diffuse", "--only", "energy", "--except", "energy"], "no check to run"),
                (["diffuse", "--effort", "nan"],
                 "--effort: must be a number between 0.01 and 1000, got 'nan'"),
                (["diffuse", "--effort", "0"],
                 "--effort: must be a number between 0.01 and 1000, got '0'"),
                (["diffuse", "--ony", "energy"], "did you mean '--only'?"),
                (["diffuse", "-D", "reflectance"], "-D: expected KEY=VALUE"),
                (["nowhere/a.so"], "expected PLUGINS/CATEGORY/NAME.so"),
                (["envmap"], "needs a value for 'filename'"),
                ([], "PLUGIN is required")):
            self.mistake(["check", *words], 2, said)

    def test_names_that_new_refuses(self):
        for words, said in (
                (["emiter", "sky"], "unknown category 'emiter' (did you mean 'emitter'?)"),
                (["lamp", "sky"], "unknown category 'lamp' (must be one of bsdf, emitter, film,"),
                (["emitter", "Sky"], "'Sky': a plugin's name must consist of lower-case letters"),
                (["emitter", "s" * 65], "name must have at most 64 characters, got 65"),
                (["bsdf", "diffuse"], "plugin bsdf/diffuse already exists"),
                (["sampler", "ldsampler"], "plugin sampler/ldsampler already exists")):
            self.mistake(["new", *words], 1, said)


if __name__ == "__main__":
    unittest.main()
