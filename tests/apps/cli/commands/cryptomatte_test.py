"""Tests of Cryptomatte layers (`aov` with crypto:object and crypto:material). They are decoded here by the
specification, independent of Kinome's code, and by the package decryptomatte, which tests/run.sh installs.
"""
import json
import logging
import os
import pathlib
import resource
import struct
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import OpenImageIO as oiio

ROOT = pathlib.Path(__file__).resolve().parents[4]
BUILD = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build")).resolve()
PROGRAM = BUILD / "bin/kinome"
# The left wall covers 0.4 of column 2 and 0.3 of column 5 of 16, and the ball is in front of the right wall.
SCENE = """<scene version="3.0.0">
  <default name="filter" value="box"/> <default name="spp" value="4"/>
  <default name="aovs" value="crypto:object,crypto:material,i:shape_index"/>
  <integrator type="aov"> <string name="aovs" value="$aovs"/>
    <integer name="crypto_samples" value="256"/> <integer name="crypto_depth" value="4"/>
    <integrator type="direct"/> </integrator>
  <sensor type="orthographic">
    <transform name="to_world"> <lookat origin="0,0,4" target="0,0,0" up="0,1,0"/> </transform>
    <sampler type="independent"> <integer name="sample_count" value="$spp"/> </sampler>
    <film type="hdrfilm"> <integer name="width" value="16"/> <integer name="height" value="16"/>
      <rfilter type="$filter"/> </film>
  </sensor>
  <emitter type="constant"/>
  <bsdf type="diffuse" id="chalk \\ &quot;white&quot;"/> <bsdf type="diffuse" id="brick"/>
  <shape type="rectangle" id="left"> <ref id="brick"/>
    <transform name="to_world"> <scale x="0.16875"/> <translate x="-0.50625"/> </transform> </shape>
  <shape type="rectangle" id="m&#xe4;rz"> <ref id="brick"/>
    <transform name="to_world"> <scale x="0.25"/> <translate x="0.5"/> </transform> </shape>
  <shape type="sphere"> <ref id="chalk \\ &quot;white&quot;"/> <float name="radius" value="0.4"/>
    <point name="center" x="0.5" y="0" z="1"/> </shape>
</scene>
"""
OBJECTS = ["left", "märz", "shape 3"]
MATERIALS = ["brick", 'chalk \\ "white"']


def murmur3(data):
    """MurmurHash3_x86_32 with seed 0 (Appleby's description of the algorithm)."""
    mask, value = 0xffffffff, 0
    whole = len(data) // 4 * 4
    words = list(struct.unpack(f"<{whole // 4}I", data[:whole]))
    tail = data[whole:]

    def turned(word, bits):
        return (word << bits | word >> 32 - bits) & mask

    def scrambled(word):
        return turned(word * 0xcc9e2d51 & mask, 15) * 0x1b873593 & mask

    for word in words:
        value = (turned(value ^ scrambled(word), 13) * 5 + 0xe6546b64) & mask
    if tail:
        value ^= scrambled(int.from_bytes(tail, "little"))
    value ^= len(data)
    for shift, factor in ((16, 0x85ebca6b), (13, 0xc2b2ae35)):
        value = (value ^ value >> shift) * factor & mask
    return value ^ value >> 16


def processor_seconds_of_children():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def id_bits(name):
    value = murmur3(name.encode())
    return value ^ 1 << 23 if (value >> 23 & 255) in (0, 255) else value


class Matte:
    """The layers of a file, decoded by the specification."""

    def __init__(self, path):
        file = oiio.ImageInput.open(str(path))
        spec = file.spec()
        self.attributes = {a.name: a.value for a in spec.extra_attribs}
        values = file.read_image(oiio.FLOAT).reshape(spec.height, spec.width, spec.nchannels)
        self.channels = {name: values[:, :, i] for i, name in enumerate(spec.channelnames)}

    def manifest(self, layer):
        key = f"cryptomatte/{murmur3(layer.encode()):08x}"[:len("cryptomatte/") + 7]
        assert self.attributes[f"{key}/name"] == layer
        assert self.attributes[f"{key}/hash"] == "MurmurHash3_32"
        assert self.attributes[f"{key}/conversion"] == "uint32_to_float32"
        return {name: int(text, 16) for name, text in
                json.loads(self.attributes[f"{key}/manifest"]).items()}

    def levels(self, layer):
        """(bits of the ids, coverage), from the largest coverage on."""
        for pair in range(100):
            for index, cover in ("RG", "BA"):
                name = f"{layer}{pair:02}."
                if name + index not in self.channels:
                    return
                ids = np.ascontiguousarray(self.channels[name + index]).view(np.uint32)
                yield ids, self.channels[name + cover]

    def coverage(self, layer, name):
        bits = self.manifest(layer)[name]
        return sum(np.where(ids == bits, cover, 0) for ids, cover in self.levels(layer))


class Cryptomatte(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        (self.folder / "scene.xml").write_text(SCENE, "utf-8")

    def run_program(self, *words, status=0):
        result = subprocess.run([PROGRAM, *map(str, words), "-q"], cwd=self.folder, check=False,
                                capture_output=True, text=True, timeout=600)
        self.assertEqual(result.returncode, status, result.stderr)
        return result.stderr

    def render(self, *options):
        self.run_program("scene.xml", "-o", "a.exr", *options)
        return Matte(self.folder / "a.exr")

    def test_hash_has_the_published_values(self):
        for text, value in ((b"", 0), (b"test", 0xba6bd213), (b"Hello, world!", 0xc0363e43)):
            self.assertEqual(murmur3(text), value)

    def test_manifest_has_the_names_of_the_scene(self):
        matte = self.render()
        for layer, names in (("CryptoObject", OBJECTS), ("CryptoMaterial", MATERIALS)):
            self.assertEqual(matte.manifest(layer), {name: id_bits(name) for name in names})
            self.assertEqual(len(list(matte.levels(layer))), 4)

    def test_coverage_equals_that_of_the_shapes(self):
        matte = self.render()
        left = matte.coverage("CryptoObject", "left")
        np.testing.assert_array_equal(left[:, 3:5], 1)
        np.testing.assert_array_equal(left[:, 6:], 0)
        # 4096 samples of a probability of 0.3 or 0.4: 6 standard deviations are 0.043.
        self.assertLess(abs(left[:, 5].mean() - 0.3), 0.043)
        self.assertLess(abs(left[:, 2].mean() - 0.4), 0.046)
        # The area of the disk in pixels, with as many samples in each pixel of its border.
        ball = matte.coverage("CryptoObject", "shape 3")
        self.assertLess(abs(ball.sum() - np.pi * (0.4 * 8) ** 2), 0.9)
        np.testing.assert_array_equal(ball, matte.coverage("CryptoMaterial", MATERIALS[1]))
        brick = matte.coverage("CryptoMaterial", "brick")
        np.testing.assert_allclose(brick, left + matte.coverage("CryptoObject", "märz"), atol=1e-6)
        for layer in ("CryptoObject", "CryptoMaterial"):
            covers = [cover for _, cover in matte.levels(layer)]
            for more, less in zip(covers, covers[1:]):
                self.assertTrue((more >= less).all())

    def test_coverage_has_the_films_filter(self):
        for name in ("gaussian", "mitchell"):
            matte = self.render("-D", f"filter={name}", "-D", "spp=1024")
            mean = sum((i + 1) * matte.coverage("CryptoObject", each) for i, each in enumerate(OBJECTS))
            self.assertLess(np.abs(mean - matte.channels["i.I"]).max(), 0.25)
            self.assertLess(np.sqrt(np.mean((mean - matte.channels["i.I"]) ** 2)), 0.04)

    def test_values_depend_on_nothing_else(self):
        first = self.render()
        self.run_program("scene.xml", "-o", "part1.exr", "--part", "1/2")
        self.run_program("scene.xml", "-o", "part2.exr", "--part", "2/2")
        self.run_program("merge", "part1.exr", "part2.exr", "-o", "merged.exr")
        for other in (self.render("-t", 1), self.render("--seed", 7), self.render("-D", "spp=9"),
                      self.render("--error", 0.001),
                      Matte(self.folder / "merged.exr")):
            for layer in ("CryptoObject", "CryptoMaterial"):
                for (ids, cover), (other_ids, other_cover) in zip(first.levels(layer),
                                                                  other.levels(layer)):
                    np.testing.assert_array_equal(ids, other_ids)
                    np.testing.assert_array_equal(cover, other_cover)

    def test_the_rays_follow_the_samples(self):
        """With a box filter, the coverage of n rays is a multiple of 1 / n."""
        text = SCENE.replace('<integer name="crypto_samples" value="256"/>', "")
        (self.folder / "scene.xml").write_text(text, "utf-8")
        for options, counts in ((["-D", "spp=1"], [4]), (["-D", "spp=9"], [9]),
                                (["-D", "spp=100"], [16]), (["--error", 0.001], [16]),
                                (["--time", 0.2], range(1, 17))):
            matte = self.render(*options)
            left = matte.coverage("CryptoObject", "left")
            np.testing.assert_array_equal(left[:, 3:5], 1)
            self.assertTrue(any(np.abs(left * n - np.round(left * n)).max() < 1e-4 for n in counts),
                            options)

    def test_a_time_limit_bounds_a_given_number_of_rays(self):
        """Half a billion rays take many seconds."""
        text = SCENE.replace('"crypto_samples" value="256"', '"crypto_samples" value="4096"')
        for side in ("width", "height"):
            text = text.replace(f'name="{side}" value="16"', f'name="{side}" value="352"')
        (self.folder / "scene.xml").write_text(text, "utf-8")
        start = processor_seconds_of_children()
        result = subprocess.run([PROGRAM, "scene.xml", "-D", "filter=box", "--time", "0.4", "-t", "4",
                                 "-o", "a.exr"],
                                cwd=self.folder, check=True, capture_output=True, text=True, timeout=600)
        self.assertLess(processor_seconds_of_children() - start, 10)
        self.assertRegex(result.stderr, "crypto_samples=4096 takes more than half of the time limit: the mattes "
                               r"have at most \d+ rays per pixel")

    def test_another_reader_decodes_it(self):
        sys.path += map(str, (BUILD / "python-env/lib").glob("python3*/site-packages"))
        try:
            from decryptomatte.decrypt import Decrypt
        except ImportError:
            self.skipTest("decryptomatte isn't installed")
        logging.disable(logging.WARNING)
        matte = self.render()
        reader = Decrypt(self.folder / "a.exr")
        found = reader.get_mattes_by_names(reader.list_layers())
        self.assertEqual(len(found), len(OBJECTS) + len(MATERIALS))
        for name, values in found.items():
            layer = "CryptoObject" if name.split(".")[-1] in OBJECTS else "CryptoMaterial"
            np.testing.assert_allclose(values.reshape(16, 16),
                                       matte.coverage(layer, name.split(".")[-1]), atol=1e-6)

    def test_wrong_lists_are_errors(self):
        for aovs, text in (("crypto:object,crypto:object", "twice"), ("crypto:shape", "unknown type"),
                           ("mine:object", "unknown type")):
            self.assertIn(text, self.run_program("scene.xml", "-D", f"aovs={aovs}", status=1))


if __name__ == "__main__":
    unittest.main()
