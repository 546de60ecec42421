#!/usr/bin/python3
"""Steps of Mitsuba's tutorials, written anew with `import kinome as mi`.

Left out are the steps that need derivatives (inverse rendering), polarization (the polarizer), plugins
written in Python, Dr.Jit arrays, ray queries (Scene.ray_intersect), and BSDF.eval and sample.
KINOME_BUILD is the build folder.
"""
import os
import pathlib
import sys
import tempfile
import unittest

import numpy as np

BUILD = pathlib.Path(os.environ["KINOME_BUILD"])
sys.path.insert(0, str(BUILD / "python"))
import kinome as mi  # noqa: E402

SIDE = 24

TWO_BALLS = """\
<scene version="3.0.0">
    <default name="spp" value="8"/>
    <default name="res" value="24"/>
    <integrator type="path"><integer name="max_depth" value="4"/></integrator>
    <sensor type="perspective" id="camera">
        <float name="fov" value="40"/>
        <transform name="to_world"><lookat origin="0, 1, 6" target="0, 0, 0" up="0, 1, 0"/></transform>
        <sampler type="independent"><integer name="sample_count" value="$spp"/></sampler>
        <film type="hdrfilm">
            <integer name="width" value="$res"/> <integer name="height" value="$res"/>
        </film>
    </sensor>
    <emitter type="constant" id="sky"/>
    <shape type="sphere" id="left">
        <point name="center" x="-1.2" y="0" z="0"/>
        <bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.2, 0.1"/></bsdf>
    </shape>
    <shape type="ply" id="patch">
        <string name="filename" value="patch.ply"/>
        <bsdf type="twosided"><bsdf type="diffuse"/></bsdf>
    </shape>
</scene>
"""


def grid(side, height):
    """Returns the vertices and faces of a square grid in [-1, 1]^2."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.linspace(-1, 1, side), np.linspace(-1, 1, side)))
    first = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    lower = np.stack([first, first + 1, first + side], axis=1)
    upper = np.stack([first + 1, first + side + 1, first + side], axis=1)
    return np.stack([x, y, height(x, y)], axis=1), np.concatenate([lower, upper])


def waves():
    """Returns a mesh of waves with the colour of each vertex."""
    positions, faces = grid(12, lambda x, y: 0.2 * np.cos(5 * np.hypot(x, y)))
    props = mi.Properties()
    props["material"] = mi.load_dict({"type": "twosided", "nested": {
        "type": "diffuse", "reflectance": {"type": "mesh_attribute", "name": "vertex_color"}}})
    mesh = mi.Mesh("waves", vertex_count=len(positions), face_count=len(faces), props=props)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = positions.ravel()
    parameters["faces"] = faces.ravel()
    parameters.update()
    mesh.add_attribute("vertex_color", 3, np.clip(positions / 2 + 0.5, 0, 1).ravel())
    return mesh


class QuickStart(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        mi.set_variant("scalar_rgb")

    def box(self):
        box = mi.cornell_box()
        box["sensor"]["film"].update(width=SIDE, height=SIDE)
        return box

    def test_rendering(self):
        scene = mi.load_dict(self.box())
        image = mi.render(scene, spp=16)
        self.assertEqual(image.shape, (SIDE, SIDE, 3))
        shown = image ** (1.0 / 2.2)
        self.assertTrue(np.isfinite(shown).all())
        for name in ("box.png", "box.exr"):
            mi.util.write_bitmap(str(self.folder / name), image)
        np.testing.assert_array_equal(np.array(mi.Bitmap(str(self.folder / "box.exr"))), image)
        self.assertTrue(mi.util.convert_to_bitmap(image)._repr_png_().startswith(b"\x89PNG"))

    def test_editing(self):
        positions, faces = grid(3, lambda x, y: 0 * x)
        patch = mi.Mesh("patch", len(positions), len(faces))
        mi.traverse(patch).update({"vertex_positions": positions + [1.2, 0, 0], "faces": faces})
        patch.write_ply(self.folder / "patch.ply")
        path = self.folder / "scene.xml"
        path.write_text(TWO_BALLS)
        scene = mi.load_file(str(path), res=SIDE)
        original = mi.render(scene, spp=16)
        parameters = mi.traverse(scene)
        text = str(parameters)
        for key in ("left.bsdf.reflectance.value", "patch.vertex_positions", "camera.to_world",
                    "sky.radiance.value"):
            self.assertIn(key, text)
        np.testing.assert_allclose(parameters["left.bsdf.reflectance.value"], [0.7, 0.2, 0.1])
        parameters["left.bsdf.reflectance.value"] = [0.1, 0.2, 0.7]
        vertices = np.reshape(parameters["patch.vertex_positions"], (-1, 3))
        vertices[:, 1] += 0.5
        parameters["patch.vertex_positions"] = vertices.ravel()
        parameters.update()
        edited = mi.render(scene, spp=16)
        left = original.shape[1] // 2
        self.assertGreater(original[:, :left, 0].sum(), edited[:, :left, 0].sum())
        self.assertFalse(np.array_equal(original[:, left:], edited[:, left:]))

    def test_several_views(self):
        """Renders one scene with cameras that aren't part of it."""
        scene = mi.load_dict(self.box())

        def camera(distance, phi, theta):
            turn = mi.ScalarTransform4f().rotate([0, 1, 0], phi).rotate([1, 0, 0], theta)
            return mi.load_dict({
                "type": "perspective",
                "fov": 39.3077,
                "to_world": mi.ScalarTransform4f().look_at(
                    origin=turn @ mi.ScalarPoint3f([0, 0, distance]), target=[0, 0, 0],
                    up=[0, 1, 0]),
                "sampler": {"type": "independent", "sample_count": 8},
                "film": {"type": "hdrfilm", "width": SIDE, "height": SIDE,
                         "rfilter": {"type": "tent"}, "pixel_format": "rgb"},
            })
        cameras = [camera(4, 20 * i - 20, -10) for i in range(3)]
        images = [mi.render(scene, spp=8, sensor=one) for one in cameras]
        self.assertEqual({image.shape for image in images}, {(SIDE, SIDE, 3)})
        # From the left the green wall on the right is larger, and the other way round.
        greenness = [image[..., 1].sum() / image[..., 0].sum() for image in images]
        self.assertEqual(greenness, sorted(greenness, reverse=True))

    def test_meshes(self):
        mesh = waves()
        self.assertIn("waves", str(mesh))
        scene = mi.load_dict({
            "type": "scene",
            "integrator": {"type": "path"},
            "light": {"type": "constant"},
            "sensor": {"type": "perspective", "fov": 40,
                       "to_world": mi.ScalarTransform4f().look_at([0, -3, 3], [0, 0, 0], [0, 0, 1]),
                       "film": {"type": "hdrfilm", "width": SIDE, "height": SIDE}},
            "waves": mesh,
        })
        image = mi.render(scene, spp=8)
        # The red part of the colour increases along x.
        middle = image[SIDE // 2, :, 0] / image[SIDE // 2].sum(axis=1)
        self.assertGreater(middle[3 * SIDE // 4], middle[SIDE // 4] + 0.1)
        mesh.write_ply(str(self.folder / "waves.ply"))
        again = mi.load_dict({"type": "ply", "filename": str(self.folder / "waves.ply")})
        self.assertEqual(again.vertex_count(), mesh.vertex_count())
        np.testing.assert_allclose(again.bbox().max, mesh.bbox().max, rtol=1e-6)

    def test_images(self):
        ramp = np.stack(np.meshgrid(np.linspace(0, 1, 16), np.linspace(0, 1, 8)) +
                        [np.full((8, 16), 0.5)], axis=2).astype(np.float32)
        mi.Bitmap(ramp).write(str(self.folder / "ramp.jpg"), quality=95)
        bitmap = mi.Bitmap(str(self.folder / "ramp.jpg"))
        self.assertIn("size = [16, 8]", str(bitmap))
        linear = bitmap.convert(pixel_format=mi.Bitmap.PixelFormat.RGB,
                                component_format=mi.Struct.Type.Float32, srgb_gamma=False)
        self.assertEqual(np.array(linear).dtype, np.float32)
        half = linear.resample([8, 4])
        self.assertEqual((half.width(), half.height()), (8, 4))
        aov = mi.render(mi.load_dict({**self.box(), "integrator": {
            "type": "aov", "aovs": "albedo:albedo,nn:sh_normal",
            "image": {"type": "path"}}}), spp=4)
        mi.Bitmap(aov, channel_names=aov.channels).write(str(self.folder / "layers.exr"))
        layers = dict(mi.Bitmap(str(self.folder / "layers.exr")).split())
        self.assertTrue({"<root>", "albedo", "nn"} <= set(layers))

    def test_transforms(self):
        place = mi.ScalarTransform4f().translate([10, 20, 30]).scale(2)
        np.testing.assert_allclose(place @ mi.ScalarPoint3f([1, 1, 1]), [12, 22, 32])
        np.testing.assert_allclose(place @ mi.ScalarVector3f([1, 1, 1]), [2, 2, 2])
        np.testing.assert_allclose((place.inverse() @ place).matrix, np.eye(4), atol=1e-12)
        frame = mi.Frame3f([0, 1, 0])
        np.testing.assert_allclose(
            mi.ScalarTransform4f().from_frame(frame) @ mi.ScalarVector3f([0, 1, 0]), [0, 0, 1],
            atol=1e-12)


if __name__ == "__main__":
    unittest.main()
