#!/usr/bin/python3
"""Tests of media in the Python module: scenes as dicts, their parameters, and grids of voxels as arrays.

KINOME_BUILD is the build folder. With KINOME_PACKAGE, the installed module is tested.
"""
import os
import pathlib
import struct
import sys
import tempfile
import unittest

import numpy as np

if "KINOME_PACKAGE" not in os.environ:
    sys.path.insert(0, str(pathlib.Path(os.environ["KINOME_BUILD"]) / "python"))
import kinome  # noqa: E402

GRID = np.random.default_rng(5).uniform(0, 4, (3, 4, 5)).astype(np.float32)  # z, y, x
TO_WORLD = kinome.Transform([[2, 0, 0, -1], [0, 2, 0, -1], [0, 0, 2, -1], [0, 0, 0, 1]])
XML = """\
<scene version="3.0.0">
    <integrator type="volpath"/>
    <sensor type="perspective">
        <transform name="to_world"><lookat origin="0, 1, 6" target="0, 0, 0" up="0, 1, 0"/></transform>
        <sampler type="independent"><integer name="sample_count" value="4"/></sampler>
        <film type="hdrfilm"> <integer name="width" value="16"/> <integer name="height" value="12"/>
            <string name="component_format" value="float32"/> </film>
    </sensor>
    <shape type="cube" id="air">
        <bsdf type="null"/>
        <medium type="heterogeneous" name="interior">
            <volume type="gridvolume" name="sigma_t">
                <string name="filename" value="grid.vol"/>
                <transform name="to_world"><matrix value="2 0 0 -1 0 2 0 -1 0 0 2 -1 0 0 0 1"/></transform>
            </volume>
            <rgb name="albedo" value="0.9, 0.7, 0.5"/>
            <phase type="hg"> <float name="g" value="0.3"/> </phase>
        </medium>
    </shape>
    <emitter type="constant" id="sky"><rgb name="radiance" value="0.5, 0.6, 0.7"/></emitter>
</scene>
"""


def smoke(**volume):
    """Returns the scene of XML as a dict, with this volume as the extinction."""
    return {
        "type": "scene",
        "integrator": {"type": "volpath"},
        "sensor": {
            "type": "perspective",
            "to_world": kinome.Transform().look_at([0, 1, 6], [0, 0, 0], [0, 1, 0]),
            "sampler": {"type": "independent", "sample_count": 4},
            "film": {"type": "hdrfilm", "width": 16, "height": 12, "component_format": "float32"},
        },
        "air": {
            "type": "cube",
            "bsdf": {"type": "null"},
            "interior": {
                "type": "heterogeneous",
                "sigma_t": {"type": "gridvolume", "to_world": TO_WORLD, **volume},
                "albedo": {"type": "rgb", "value": [0.9, 0.7, 0.5]},
                "phase": {"type": "hg", "g": 0.3},
            },
        },
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": [0.5, 0.6, 0.7]}},
    }


def write_vol(path, grid):
    z, y, x = grid.shape
    path.write_bytes(b"VOL\x03" + struct.pack("<5i6f", 1, x, y, z, 1, 0, 0, 0, 1, 1, 1)
                     + grid.astype("<f4").tobytes())


class Media(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def of_file(self, grid, text=XML):
        """Returns the image of the scene with a grid from a file."""
        write_vol(self.folder / "grid.vol", grid)
        (self.folder / "scene.xml").write_text(text)
        return kinome.render(kinome.load_file(self.folder / "scene.xml"))

    def test_a_dict_with_an_array_is_the_scene_with_a_file(self):
        expected = self.of_file(GRID)
        self.assertGreater(np.ptp(expected), 0.1)
        for grid in ({"data": GRID}, {"grid": GRID[..., None]}, {"data": GRID.tolist()}):
            np.testing.assert_array_equal(kinome.render(kinome.load_dict(smoke(**grid))), expected)

    def test_arrays_and_files_replace_each_other(self):
        self.of_file(GRID)
        scene = kinome.load_file(self.folder / "scene.xml")
        parameters = kinome.traverse(scene)
        path = "air.interior.sigma_t.data"
        self.assertIn(path, parameters)
        self.assertIsNone(parameters[path])
        other = np.arange(24, dtype=np.float32).reshape(2, 3, 4) / 12
        parameters[path] = other
        parameters.update()
        np.testing.assert_array_equal(parameters[path], other[..., None])
        edited = kinome.render(scene)
        parameters.save(self.folder / "saved.xml")
        np.testing.assert_array_equal(
            kinome.render(kinome.load_file(self.folder / "saved.xml")), edited)
        np.testing.assert_array_equal(self.of_file(other), edited)
        write_vol(self.folder / "grid.vol", GRID)
        parameters.update({"air.interior.sigma_t.filename": "grid.vol"})
        np.testing.assert_array_equal(kinome.render(scene), self.of_file(GRID))

    def test_parameters_of_media_have_kinomes_and_mitsubas_names(self):
        scene = kinome.load_dict(smoke(data=GRID))
        parameters = kinome.traverse(scene)
        for path, value in (("air.interior.scale", 2.0), ("air.interior.phase.g", -0.4),
                            ("air.interior.albedo.value", [0.2, 0.4, 0.6])):
            mitsubas = path.replace(".interior", ".interior_medium").replace(".phase.",
                                                                             ".phase_function.")
            parameters[mitsubas] = value
            np.testing.assert_allclose(parameters[path], value, rtol=1e-6)
        changes = parameters.update()
        self.assertNotIn("shape/cube", changes.made)
        text = XML.replace("0.9, 0.7, 0.5", "0.2, 0.4, 0.6").replace('"g" value="0.3"',
                                                                       '"g" value="-0.4"')
        text = text.replace("<phase", '<float name="scale" value="2"/><phase')
        np.testing.assert_array_equal(kinome.render(scene), self.of_file(GRID, text))

    def test_a_volume_can_replace_a_value(self):
        scene = kinome.load_dict(smoke(data=GRID))
        parameters = kinome.traverse(scene)
        parameters.update({"air.interior.albedo": {"type": "gridvolume", "to_world": TO_WORLD,
                                                   "data": GRID / 4}})
        self.assertEqual(parameters.textures()["air.interior.albedo.value"], "air.interior.albedo")
        expected = smoke(data=GRID)
        expected["air"]["interior"]["albedo"] = {"type": "gridvolume", "to_world": TO_WORLD,
                                                 "data": GRID / 4}
        np.testing.assert_array_equal(kinome.render(scene), kinome.render(kinome.load_dict(expected)))

    def test_bad_grids_are_errors(self):
        bad = GRID.copy()
        bad[1, 2, 3] = np.nan
        for grid, message in ((bad, "voxel (3, 2, 1) has the value nan"),
                              (np.zeros((2, 2, 2, 2)), "must have 1, 3 or 6 channels, got 2")):
            with self.assertRaises(kinome.Error) as caught:
                kinome.load_dict(smoke(data=grid))
            self.assertIn(message, str(caught.exception))
        with self.assertRaises(kinome.Error) as caught:
            kinome.load_dict(smoke(data=GRID, filename="grid.vol"))
        self.assertIn("'data' can't be combined with 'filename'", str(caught.exception))
        for grid in (np.zeros((2, 2)), np.zeros((0, 2, 2)), object()):
            with self.assertRaises(TypeError):
                kinome.load_dict(smoke(data=grid))


if __name__ == "__main__":
    unittest.main()
