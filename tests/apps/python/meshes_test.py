#!/usr/bin/python3
"""Tests of the Python module's meshes from arrays.

KINOME_BUILD is the build folder.
"""
import copy
import os
import pathlib
import pickle
import sys
import tempfile
import unittest

import numpy as np

BUILD = pathlib.Path(os.environ["KINOME_BUILD"])
sys.path.insert(0, str(BUILD / "python"))
import kinome as mi  # noqa: E402
from small_box import small_box  # noqa: E402


class Meshes(unittest.TestCase):
    def mesh(self, **props):
        mesh = mi.Mesh("triangle", 3, 1, has_vertex_texcoords=True, props=props)
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = [[-1, -1, 0], [1, -1, 0], [0, 1, 0]]
        parameters["vertex_texcoords"] = [[0, 0], [1, 0], [0, 1]]
        parameters["faces"] = [0, 1, 2]
        parameters.update()
        return mesh

    def test_arrays(self):
        mesh = self.mesh(bsdf={"type": "diffuse", "reflectance": 0.2})
        self.assertEqual((mesh.vertex_count(), mesh.face_count()), (3, 1))
        self.assertEqual(mesh.bbox().max.tolist(), [1, 1, 0])
        scene = mi.load_dict(small_box(mesh=mesh))
        loaded = scene.shapes()[-1]
        self.assertEqual((loaded.vertex_count(), loaded.face_count()), (3, 1))
        self.assertEqual(loaded.bsdf().plugin, "diffuse")
        self.assertIn("vertex_count=3", repr(mesh))
        with tempfile.TemporaryDirectory() as folder:
            for number, source in enumerate((mesh, loaded)):
                path = os.path.join(folder, f"mesh{number}.ply")
                source.write_ply(path)
                again = mi.load_dict({"type": "ply", "filename": path, "face_normals": True,
                                      "bsdf": {"type": "diffuse", "reflectance": 0.2}})
                np.testing.assert_array_equal(mi.render(mi.load_dict(small_box(mesh=again))),
                                              mi.render(scene))
                before = pathlib.Path(path).read_bytes()
                with self.assertRaisesRegex(mi.Error, "never overwritten"):
                    source.write_ply(path)
                self.assertEqual(pathlib.Path(path).read_bytes(), before)
            with self.assertRaisesRegex(mi.Error, "names a folder"):
                mesh.write_ply(folder)

    def test_copies(self):
        """Deep copies have edits of their own."""
        red = mi.load_dict({"type": "diffuse", "reflectance": 0.2})
        mesh = self.mesh(bsdf=red)
        parts = copy.deepcopy({"mesh": mesh, "red": red})
        mi.traverse(parts["mesh"])["vertex_positions"] = [2] * 9
        edited = mi.traverse(parts["red"])
        edited["reflectance.value"] = 0.5
        edited.update()
        self.assertEqual(mesh.bbox().max.tolist(), [1, 1, 0])
        self.assertEqual(red.as_dict()["reflectance"], 0.2)
        faces = mi.traverse(pickle.loads(pickle.dumps(self.mesh())))["faces"]
        self.assertEqual(faces.tolist(), [0, 1, 2])

    def test_meshes_without_triangles_are_invisible(self):
        empty = mi.render(mi.load_dict(small_box(mesh=mi.Mesh("empty", 0, 0))))
        np.testing.assert_array_equal(empty, mi.render(mi.load_dict(small_box())))

    def test_attributes(self):
        painted = self.mesh(bsdf={"type": "diffuse", "reflectance": {
            "type": "mesh_attribute", "name": "vertex_color"}})
        painted.add_attribute("vertex_color", 3, [0.7] * 9)
        mi.traverse(painted)["vertex_color"] = [0.2] * 9
        plain = self.mesh(bsdf={"type": "diffuse", "reflectance": 0.2})
        np.testing.assert_allclose(mi.render(mi.load_dict(small_box(mesh=painted))),
                                   mi.render(mi.load_dict(small_box(mesh=plain))), rtol=1e-4)

    def test_saved_scenes_have_the_files_of_their_meshes(self):
        scene = mi.load_dict(small_box(one=self.mesh(), two=self.mesh()))
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "saved.xml")
            mi.traverse(scene).save(path)
            self.assertEqual(len(os.listdir(folder)), 3)
            self.assertNotIn(tempfile.gettempdir() + "/kinome-", pathlib.Path(path).read_text())
            saved = mi.load_file(path)
            np.testing.assert_array_equal(mi.render(saved), mi.render(scene))
            # The files that `saved` reads are kept.
            mi.traverse(scene).save(os.path.join(folder, "saved2.xml"))
            np.testing.assert_array_equal(mi.render(saved), mi.render(scene))

    def test_edited_arrays_of_an_object(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "mesh.ply")
            self.mesh().write_ply(path)
            shape = mi.load_dict({"type": "ply", "filename": path})
        parameters = mi.traverse(shape)
        parameters["vertex_positions"] = parameters["vertex_positions"] + 1
        parameters.update()
        self.assertEqual(mi.load_dict({"type": "scene", "m": shape}).bbox().max.tolist(), [2, 2, 1])

    def test_wrong_arrays(self):
        mesh = self.mesh()
        for name, value in (("faces", [0, 1, 3]), ("faces", [0, 1]), ("vertex_positions", [1, 2]),
                            ("vertex_texcoords", [1, 2])):
            parameters = mi.traverse(self.mesh())
            parameters[name] = value
            with self.subTest(name=name, value=value), self.assertRaises(ValueError):
                parameters.update()
        with self.assertRaises(KeyError):
            mi.traverse(mesh)["normals"] = [1]
        for name in ("color", "vertex_positions", "vertex_a b"):
            with self.assertRaises(ValueError):
                mesh.add_attribute(name, 3, [1] * 9)
        with self.assertRaises(ValueError):
            mesh.add_attribute("vertex_color", 3, [1] * 8)

    def test_dicts_that_contain_themselves(self):
        for kind in ("scene", "sphere"):
            endless = {"type": kind}
            endless["part"] = endless
            with self.subTest(kind), self.assertRaisesRegex(ValueError, "contains itself"):
                mi.load_dict(endless)


if __name__ == "__main__":
    unittest.main()
