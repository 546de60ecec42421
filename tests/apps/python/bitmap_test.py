#!/usr/bin/python3
"""Tests of kinome.Bitmap, kinome.util and the pictures in notebooks.

KINOME_BUILD is the build folder.
"""
import io
import os
import pathlib
import sys
import tempfile
import unittest
import warnings

import numpy as np

BUILD = pathlib.Path(os.environ["KINOME_BUILD"])
sys.path.insert(0, str(BUILD / "python"))
import kinome as mi  # noqa: E402
from small_box import small_box  # noqa: E402
from kinome import Bitmap, Struct  # noqa: E402

Format, Type = Bitmap.PixelFormat, Struct.Type


class BitmapTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.pixels = np.random.default_rng(3).random((5, 7, 3), np.float32)

    def test_formats_of_arrays(self):
        for shape, wanted in (((5, 7), Format.Y), ((5, 7, 1), Format.Y), ((5, 7, 2), Format.YA),
                              ((5, 7, 3), Format.RGB), ((5, 7, 4), Format.RGBA),
                              ((5, 7, 6), Format.MultiChannel)):
            bitmap = Bitmap(np.zeros(shape, np.float32))
            self.assertIs(bitmap.pixel_format(), wanted)
            self.assertEqual(bitmap.size().tolist(), [7, 5])
            self.assertEqual(bitmap.component_format(), Type.Float32)
            self.assertFalse(bitmap.srgb_gamma())
        self.assertTrue(Bitmap(np.zeros((2, 2), np.uint8)).srgb_gamma())
        self.assertIs(Bitmap(self.pixels, Format.XYZ).pixel_format(), Format.XYZ)
        for wrong in (3, "missing.png", np.zeros(4), np.zeros((0, 2)), np.zeros((2, 2), bool)):
            with self.subTest(wrong), self.assertRaises((TypeError, mi.Error)):
                Bitmap(wrong)

    def test_copies_are_independent(self):
        bitmap = Bitmap(np.ones((2, 3, 4), np.float32))
        bitmap.set_premultiplied_alpha(False)
        for copy in (Bitmap(bitmap), bitmap.convert(), bitmap.resample([3, 2])):
            copy.metadata()["artist"] = "somebody"
            copy.clear()
        self.assertEqual((bitmap.metadata(), float(np.array(bitmap).min())), ({}, 1))
        self.assertFalse(bitmap.split()[0][1].premultiplied_alpha())

    def test_names_are_only_for_arrays(self):
        for source in ("image.png", Bitmap(self.pixels)):
            with self.assertRaisesRegex(ValueError, "pixel_format and channel_names are only for arrays"):
                Bitmap(source, Format.XYZ)
        with self.assertRaisesRegex(TypeError, "a channel's name takes a string, got 1"):
            Bitmap(self.pixels, channel_names=[1, 2, 3])

    def test_conversions(self):
        bitmap = Bitmap(self.pixels)
        self.assertFalse(bitmap.convert(component_format=Type.UInt8).srgb_gamma())
        coded = bitmap.convert(component_format=Type.UInt8, srgb_gamma=True)
        self.assertTrue(coded.srgb_gamma())
        np.testing.assert_array_equal(np.array(coded),
                                      np.rint(mi.linear_to_srgb(self.pixels) * 255))
        self.assertTrue(coded.convert(component_format=Type.Float32).srgb_gamma())
        back = coded.convert(component_format=Type.Float32, srgb_gamma=False)
        np.testing.assert_allclose(np.array(back), self.pixels, atol=0.005)
        # A conversion back and forth keeps all bytes.
        self.assertEqual(back.convert(component_format=Type.UInt8, srgb_gamma=True), coded)
        grey = np.array(bitmap.convert(Format.Y))
        np.testing.assert_allclose(grey, mi.luminance(self.pixels), rtol=1e-6)
        xyz = bitmap.convert(Format.XYZ)
        np.testing.assert_allclose(np.array(xyz)[..., 1], grey, rtol=1e-6)
        np.testing.assert_allclose(np.array(xyz.convert(Format.RGB)), self.pixels, atol=1e-6)
        opaque = np.array(bitmap.convert(Format.RGBA))
        np.testing.assert_array_equal(opaque[..., 3], 1)
        for kind in (Type.UInt16, Type.UInt32, Type.Float16, Type.Float64):
            other = bitmap.convert(component_format=kind)
            self.assertEqual(other.component_format(), kind)
            np.testing.assert_allclose(np.array(other.convert(component_format=Type.Float32)),
                                       self.pixels, atol=1e-3)
        clamped = Bitmap(np.array([[-1, 0.5, 7, np.nan]], np.float32)).convert(
            component_format=Type.UInt8, srgb_gamma=False)
        self.assertEqual(np.array(clamped)[0].tolist(), [0, 128, 255, 0])

    def test_alpha(self):
        image = np.full((1, 1, 4), 0.5, np.float32)
        straight = Bitmap(image).convert(alpha_transform=Bitmap.AlphaTransform.Unpremultiply)
        np.testing.assert_allclose(np.array(straight)[0, 0], [1, 1, 1, 0.5])
        self.assertFalse(straight.premultiplied_alpha())
        again = straight.convert(alpha_transform=Bitmap.AlphaTransform.Premultiply)
        np.testing.assert_allclose(np.array(again)[0, 0], image[0, 0])
        # Colours that aren't multiplied by alpha stay as they are.
        same = straight.convert(alpha_transform=Bitmap.AlphaTransform.Unpremultiply)
        self.assertEqual(same, straight)

    def test_files(self):
        """What a file can store comes back."""
        ramp = np.repeat(np.linspace(0.2, 0.8, 16, dtype=np.float32), 3).reshape(1, 16, 3)
        for extension, tolerance in ((".exr", 0), (".pfm", 0), (".hdr", 0.01), (".png", 0.005),
                                     (".bmp", 0.005), (".tga", 0.005), (".tif", 0), (".jpg", 0.02)):
            with self.subTest(extension):
                path = self.folder / ("image" + extension)
                pixels = ramp if extension == ".jpg" else self.pixels
                Bitmap(pixels).write(path, quality=100)
                read = Bitmap(str(path))
                self.assertIs(read.pixel_format(), Format.RGB)
                self.assertEqual(read.srgb_gamma(), extension in (".png", ".bmp", ".tga", ".jpg"))
                linear = np.array(read.convert(component_format=Type.Float32, srgb_gamma=False))
                np.testing.assert_allclose(linear, pixels, atol=tolerance)
        for extension in (".webp", ".gif"):  # sRGB of 0.25 is 137
            path = self.folder / ("grey" + extension)
            Bitmap(np.full((8, 8, 3), 0.25, np.float32)).write(path)
            np.testing.assert_allclose(np.array(Bitmap(str(path)))[..., :3], 137, atol=3)
        names = ["R", "G", "B", "depth", "albedo.R", "albedo.G", "albedo.B"]
        many = Bitmap(np.zeros((2, 3, 7), np.float16), channel_names=names)
        many.write(self.folder / "many.exr")
        read = Bitmap(str(self.folder / "many.exr"))
        self.assertEqual(read.component_format(), Type.Float16)
        layers = dict(read.split())
        self.assertEqual(layers["albedo"].pixel_format(), Format.RGB)
        self.assertEqual(set(read.channel_names()), set(names))
        with self.assertRaisesRegex(mi.Error, "missing.png: no such file$"):
            Bitmap(str(self.folder / "missing.png"))
        with self.assertRaisesRegex(mi.Error, "it is a folder, not a file$"):
            Bitmap(str(self.folder))
        with self.assertRaisesRegex(mi.Error, "image.xyz: unknown image format") as failure:
            Bitmap(self.pixels).write(self.folder / "image.xyz")
        self.assertNotIn(tempfile.gettempdir() + "/tmp", str(failure.exception).replace(
            str(self.folder), ""))

    def test_pictures_have_the_formats_of_bitmaps(self):
        names = ["R", "G", "B", "depth"]
        picture = mi.Picture(np.concatenate([self.pixels, self.pixels[..., :1]], axis=2), names)
        for extension, channels in ((".jpg", 3), (".hdr", 3), (".tif", 4), (".webp", 3)):
            with self.subTest(extension):
                ours, other = (self.folder / (name + extension) for name in ("ours", "other"))
                picture.write(ours)
                Bitmap(picture).write(other)
                self.assertEqual(ours.read_bytes(), other.read_bytes())
                self.assertEqual(Bitmap(ours).channel_count(), channels)
        for name in ("image.xyz", "image"):
            with self.assertRaisesRegex(mi.Error, f"{name}: unknown image format"):
                picture.write(self.folder / name)
            self.assertFalse((self.folder / name).exists())

    def test_files_have_the_same_bytes_again(self):
        """OpenImageIO stores the file's name in DPX files, the time in RLA files, and memory that it doesn't
        initialize in SGI files."""
        pixels = np.full((8, 8, 3), 0.5, np.float32)
        for extension, header in ((".dpx", slice(36, 136)), (".rla", slice(528, 548)),
                                  (".sgi", slice(24, 104))):
            paths = [self.folder / (name + extension) for name in ("a", "other")]
            for path in paths:
                Bitmap(pixels).write(path)
            first, second = (path.read_bytes() for path in paths)
            self.assertEqual(first, second, extension)
            self.assertEqual(first[header].strip(b"\0"), b"", extension)

    def test_formats_of_bytes_store_srgb(self):
        """Floats become sRGB bytes, also in formats of which OpenImageIO would accept floats."""
        pixels = np.full((40, 40, 4), [0.2, 0.2, 0.2, 1], np.float32)
        pixels[0, 0] = [np.nan, -1, np.inf, 1]
        byte = 124  # 0.2 in sRGB
        for extension, channels in ((".webp", 3), (".gif", 4), (".ico", 4), (".sgi", 4), (".jp2", 4),
                                    (".ppm", 3), (".dpx", 4)):
            with self.subTest(extension), warnings.catch_warnings():
                warnings.simplefilter("error")
                path = self.folder / ("image" + extension)
                Bitmap(pixels).write(path)
                read = Bitmap(str(path))
                self.assertIs(read.component_format(), Type.UInt8)
                self.assertGreaterEqual(read.channel_count(), channels)
                np.testing.assert_allclose(np.array(read)[-1, -1, :3].astype(int), byte, atol=3)
        Bitmap(pixels).write(self.folder / "image.fits")
        np.testing.assert_array_equal(np.array(Bitmap(str(self.folder / "image.fits"))), pixels)
        for name, size, limits in (("a.jp2", (20, 40), "at least 32"), ("a.jpg", (1, 65501), "to 65500"),
                                   ("a.webp", (1, 16384), "to 16383"), ("a.gif", (1, 65536), "to 65535")):
            with self.subTest(name), self.assertRaisesRegex(mi.Error, limits):
                Bitmap(np.zeros(size, np.float32)).write(self.folder / name)
            self.assertFalse((self.folder / name).exists())

    def test_transparent_png(self):
        image = np.array(np.random.default_rng(1).integers(0, 256, (4, 4, 4)), np.uint8)
        Bitmap(image).write(self.folder / "a.png")
        np.testing.assert_array_equal(np.array(Bitmap(str(self.folder / "a.png"))), image)

    def test_files_of_bytes_have_straight_alpha(self):
        """Floats are divided by alpha, and bytes are written as they are, as in Mitsuba."""
        image = Bitmap(np.full((1, 1, 4), [0.1, 0.1, 0.1, 0.5], np.float32))
        image.write(self.folder / "float.png")
        self.assertEqual(np.array(Bitmap(str(self.folder / "float.png")))[0, 0].tolist(),
                         [124, 124, 124, 128])  # 0.2 in sRGB
        encoded = image.convert(component_format=Type.UInt8, srgb_gamma=True)
        encoded.write(self.folder / "bytes.png")
        np.testing.assert_array_equal(np.array(Bitmap(str(self.folder / "bytes.png"))),
                                      np.array(encoded))
        image.write(self.folder / "black.jpg")  # over black
        self.assertAlmostEqual(int(np.array(Bitmap(str(self.folder / "black.jpg")))[0, 0, 0]), 89,
                               delta=2)

    def test_grey_files(self):
        Bitmap(np.full((2, 2, 3), [0.2, 0.2, 0.2], np.float32)).write(self.folder / "a.pgm")
        self.assertEqual((self.folder / "a.pgm").read_bytes()[:2], b"P5")
        self.assertEqual(np.array(Bitmap(str(self.folder / "a.pgm")))[0, 0], 124)

    def test_mattes_have_their_names(self):
        scene = mi.load_dict({**small_box(8, 1), "integrator": {
            "type": "aov", "aovs": "crypto:object", "nested": {"type": "direct"}}})
        image = mi.render(scene)
        for write in (image.write, Bitmap(image).write):
            write(self.folder / "crypto.exr")
            names = Bitmap(str(self.folder / "crypto.exr")).metadata()
            manifest, = (text for key, text in names.items() if key.endswith("/manifest"))
            self.assertIn('"red-wall":', manifest)
        Bitmap(image.rgb).write(self.folder / "plain.exr")
        self.assertFalse(any("cryptomatte" in key for key in
                             Bitmap(str(self.folder / "plain.exr")).metadata()))

    def test_resampling(self):
        ramp = np.repeat(np.linspace(0, 1, 32, dtype=np.float32)[None, :, None], 8, axis=0)
        for name in ("box", "tent", "gaussian", "mitchell", "catmullrom", "lanczos"):
            for size in ((16, 8), (64, 4)):
                with self.subTest(name, size=size):
                    filtered = Bitmap(ramp).resample(size, mi.load_dict({"type": name}))
                    self.assertEqual(filtered.size().tolist(), list(size))
                    row = np.array(filtered)[2]
                    at = (np.arange(size[0]) + 0.5) / size[0] * 32 - 0.5
                    inside = slice(size[0] // 4, -size[0] // 4)
                    np.testing.assert_allclose(row[inside], at[inside] / 31, atol=0.02)
        # Weights of a filter at the centres of pixels, for a single bright pixel.
        dot = np.zeros((1, 9), np.float32)
        dot[0, 4] = 1
        weights = np.exp(-(np.arange(9) - 4) ** 2 / (2 * 0.8 ** 2)) - np.exp(-16 / 2)
        weights *= np.abs(np.arange(9) - 4) < 4 * 0.8
        blurred = np.array(Bitmap(dot).resample([9, 2], {"type": "gaussian", "stddev": 0.8}))
        np.testing.assert_allclose(blurred[0], weights / weights.sum(), atol=2e-4)
        even = np.array(Bitmap(np.full((6, 6, 3), 0.25, np.float32)).resample([11, 3]))
        np.testing.assert_allclose(even, 0.25, rtol=1e-5)
        # One axis is magnified and the other one is reduced, which takes linear time.
        column = np.linspace(0, 1, 5)[:, None] * np.ones((5, 4))
        wide = np.array(Bitmap(column.T).resample([16384, 1], "tent"))[0]
        np.testing.assert_allclose(wide, np.clip((np.arange(16384) + 0.5) * 5 / 16384 - 0.5, 0, 4) / 4,
                                   atol=1e-3)
        with self.assertRaisesRegex(mi.Error, "no plugin 'sinc'"):
            Bitmap(ramp).resample([4, 4], "sinc")
        with self.assertRaisesRegex(TypeError, "rfilter takes a reconstruction filter"):
            Bitmap(ramp).resample([4, 4], mi.load_dict({"type": "sphere"}))
        with self.assertRaises(ValueError):
            Bitmap(ramp).resample([4, 0])

    def test_textures(self):
        """A bitmap may be the pixels of a texture, with its own encoding."""
        coded = Bitmap(self.pixels).convert(component_format=Type.UInt16, srgb_gamma=True)
        for bitmap, tolerance in ((Bitmap(self.pixels), 1e-6), (coded, 1e-3)):
            bsdf = mi.load_dict({"type": "diffuse",
                                 "reflectance": {"type": "bitmap", "bitmap": bitmap}})
            np.testing.assert_allclose(mi.traverse(bsdf)["reflectance.data"], self.pixels,
                                       atol=tolerance)

    def test_helpers(self):
        path = self.folder / "r.png"
        mi.util.write_bitmap(path, self.pixels)
        coded = mi.util.convert_to_bitmap(self.pixels)
        np.testing.assert_array_equal(np.array(Bitmap(str(path))), np.array(coded))
        linear = mi.util.convert_to_bitmap(coded, uint8_srgb=False)
        self.assertEqual(linear.component_format(), Type.Float32)
        values = np.linspace(0, 1, 101)
        np.testing.assert_allclose(mi.srgb_to_linear(mi.linear_to_srgb(values)), values, atol=1e-12)
        self.assertAlmostEqual(float(mi.srgb_to_linear(0.5)), 0.2140411, 6)

    def test_notebooks(self):
        """The PNG files that notebooks show have the pixels of those that write() makes."""
        import matplotlib.image
        names = ["R", "G", "B", "depth"]
        picture = mi.Picture(np.concatenate([self.pixels, self.pixels[..., :1]], axis=2), names)
        expected = np.rint(mi.linear_to_srgb(self.pixels) * 255)
        for image in (picture, Bitmap(picture), Bitmap(self.pixels),
                      mi.util.convert_to_bitmap(self.pixels)):
            shown = matplotlib.image.imread(io.BytesIO(image._repr_png_()))
            np.testing.assert_allclose(shown[..., :3] * 255, expected, atol=0.6)
        self.assertIsNone(mi.Picture(self.pixels[..., :2], ["x", "y"])._repr_png_())

    def test_text(self):
        text = repr(Bitmap(self.pixels))
        for line in ("pixel_format = RGB", "component_format = float32", "size = [7, 5]"):
            self.assertIn(line, text)


if __name__ == "__main__":
    unittest.main()
