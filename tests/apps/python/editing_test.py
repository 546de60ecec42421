#!/usr/bin/python3
"""Tests of edit sessions by traverse(). After any number of random edits, the image is
bit-identical to that of the saved scene. Refused edits change nothing, and memory doesn't grow.

KINOME_BUILD is the build folder. KINOME_EDITS=2000 makes sessions longer, KINOME_SEED=5 changes
them.
"""
import ctypes
import os
import pathlib
import random
import unittest

import numpy as np

from edit_sessions import SessionTest
import kinome  # found by edit_sessions

EDITS = int(os.environ.get("KINOME_EDITS", 200))
SEED = int(os.environ.get("KINOME_SEED", 1))


class RandomEdits:
    """Random edits with values of all types, some of which are invalid."""

    def __init__(self, parameters, parts, seed):
        self.parameters = parameters
        self.parts = parts
        self.dice = random.Random(seed)
        self.noise = np.random.default_rng(seed)
        self.refused = self.done = 0

    def value(self, row):
        dice = self.dice
        name = row.path.removesuffix(".value").rpartition(".")[2]
        if row.type == "array":
            array = self.parameters[row.path]
            if name == "faces":
                return self.noise.permutation(array.reshape(-1, 3)).ravel()
            if array.size == 0:
                return None
            return array + self.noise.uniform(-0.05, 0.05, array.shape).astype(np.float32)
        if row.type == "pixels":
            return self.noise.uniform(0, 1, (4, 8, dice.choice([1, 3]))).astype(np.float32)
        if row.type == "boolean":
            return dice.random() < 0.5
        if row.type == "integer":
            limits = {"width": (8, 24), "height": (8, 16), "sample_count": (1, 4)}
            return dice.randint(*limits.get(name, (-1, 6))) if "crop" not in name else None
        if name in ("near_clip", "far_clip"):
            return None  # the image might be black
        if row.type in ("float", "float or name"):
            usual = row.value if isinstance(row.value, (int, float)) else 1.0
            return dice.choice([usual * dice.uniform(0.7, 1.4), dice.uniform(0, 1), -1.0])
        if "texture" in row.type or row.type == "emission":
            return dice.choice([[dice.random() for _ in range(3)], dice.random(), 2.5])
        if row.type == "vector":
            return self.noise.uniform(-1, 1, 3)
        if row.type == "transform":
            turn = kinome.Transform().translate(self.noise.uniform(-0.1, 0.1, 3))
            return turn @ row.value if row.value is not None else turn
        if row.type == "file":
            ending = {"mesh": "*.ply", "meter": "*.ply", "lamp": "*.ply", "box": "*.ply",
                      "wood": "*.ppm", "sky": "*.pfm"}.get(row.path.split(".")[0])
            files = sorted(self.parts.glob(ending)) if ending else []
            return str(dice.choice(files)) if files else None
        if row.type == "string":
            return dice.choice(row.choices or ["no such"])
        raise AssertionError(f"a parameter of unknown type: {row}")

    def texture(self):
        dice = self.dice
        return dice.choice([
            {"type": "bitmap", "filename": str(self.parts / "wood.ppm"), "raw": dice.random() < 0.5},
            {"type": "checkerboard", "color0": dice.random(), "color1": [0.2, 0.5, 0.9]},
            {"type": "bitmap", "data": self.noise.uniform(0, 1, (2, 3, 3)).astype(np.float32)},
            {"type": "bitmap", "filename": "nowhere.png"},
            {"type": "ref", "id": "wood"}])

    def put_or_take(self):
        """Sets textures and maps around BSDFs, or reverts and removes them."""
        dice = self.dice
        rows = self.parameters.parameters()
        slots = [row.path for row in rows if "texture" in row.type] + list(self.parameters.textures())
        bsdfs = [path for path, plugin in self.parameters.objects() if plugin.startswith("bsdf/")]
        do = dice.random()
        if do < 0.4:
            self.parameters[dice.choice(slots)] = self.texture()
        elif do < 0.6:
            self.parameters[dice.choice(bsdfs)] = dice.choice([
                {"type": "bumpmap", "any": self.texture(), "scale": 0.3},
                {"type": "normalmap", "normalmap": self.texture()}])
        elif do < 0.7:
            self.parameters.unset(dice.choice(bsdfs))
        elif do < 0.85:
            large = (".width", ".height", ".sample_count")  # their defaults are large
            self.parameters.unset(dice.choice([r.path for r in rows if not r.path.endswith(large)]))
        else:
            self.parameters.revert(dice.choice([row.path for row in rows if row.type != "array"]))

    def step(self):
        """Sets one to three values and updates the scene."""
        rows = self.parameters.parameters()
        try:
            if self.dice.random() < 0.25:
                self.put_or_take()
            for row in self.dice.choices(rows, k=self.dice.randint(1, 3)):
                value = self.value(row)
                if value is not None:
                    self.parameters[row.path] = value
            self.parameters.update()
            self.done += 1
        except kinome.Error:
            self.refused += 1
            # Apply the values that were set before the invalid one.
            try:
                self.parameters.update()
            except kinome.Error:
                pass


def resident_bytes():
    ctypes.CDLL(None).malloc_trim(0)
    pages = int(pathlib.Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


class EditingTest(SessionTest):
    def test_random_edits_give_the_image_of_the_saved_scene(self):
        edits = RandomEdits(self.parameters, self.folder / "parts", SEED)
        (self.folder / "elsewhere").mkdir()
        seen = 0
        for i in range(EDITS):
            edits.step()
            if i % 40 == 39:
                self.expect_saved(self.folder / f"saved_{i}.xml", may_be_black=True)
                seen += np.std(kinome.render(self.scene, sensor="camera")) > 0
        self.assertGreater(seen, 0)
        self.assertGreater(edits.done, EDITS / 3)
        self.assertGreater(edits.refused, EDITS / 20)
        saved = self.expect_saved(self.folder / "elsewhere/last.xml", may_be_black=True)
        # A saved scene that is saved again stays the same.
        self.parameters = kinome.traverse(saved)
        self.scene = saved
        self.expect_saved(self.folder / "elsewhere/again.xml", may_be_black=True)

    def test_memory_does_not_grow(self):
        edits = RandomEdits(self.parameters, self.folder / "parts", SEED + 1)
        sizes = []
        for i in range(1000):
            edits.step()
            if i % 20 == 0:
                kinome.render(self.scene, spp=1)
            if i + 1 in (200, 1000):
                sizes.append(resident_bytes())
        # Keeping a mesh's arrays, or the objects of an update, for 800 edits would take about 8 MB.
        self.assertLess(sizes[1] - sizes[0], 4 << 20)

    def test_arrays_of_meshes_stay_when_their_shape_is_made_again(self):
        self.parameters.update({
            "meter.vertex_positions": self.parameters["meter.vertex_positions"] + np.float32(0.5)})
        before = kinome.render(self.scene)
        edited = self.parameters["meter.vertex_positions"]
        made = self.parameters.update({"meter.sensor.film.compensate": True}).made
        self.assertIn("shape/ply", made)
        np.testing.assert_array_equal(self.parameters["meter.vertex_positions"], edited)
        np.testing.assert_array_equal(kinome.render(self.scene), before)
        self.expect_saved(self.folder / "new.xml")
        # A parameter of the mesh itself rebuilds it from its file.
        self.parameters.update({"meter.face_normals": True})
        self.assertFalse(np.array_equal(self.parameters["meter.vertex_positions"], edited))

    def test_textures_and_maps_are_put_and_taken_back(self):
        first = kinome.render(self.scene)
        text = self.path.read_text()
        bitmap = {"type": "bitmap", "filename": "parts/wood.ppm"}
        normals = {"type": "normalmap", "normalmap": {**bitmap, "raw": True}}
        edits = {
            "shiny.alpha": {**bitmap, "raw": True},
            "shape.bsdf.diffuse_reflectance": {"type": "checkerboard", "color0": bitmap},
            "shape_1.bsdf": normals,
            "shape_2.bsdf": {"type": "bumpmap", "any": {"type": "ref", "id": "wood"}},
            "camera.to_world": kinome.Transform().look_at([0, 3, 6], [0, 0, 0], [0, 1, 0]),
        }
        pictures = [first]
        for path, value in edits.items():
            self.parameters.update({path: value})
            pictures.append(kinome.render(self.scene))
            self.assertFalse(np.array_equal(*pictures[-2:]), path)
            self.expect_saved(self.folder / "new.xml")
        # A map takes the path of the BSDF that it encloses; that BSDF's path gets one level longer.
        self.assertEqual(self.parameters.textures()["shiny.normalmap.value"], "shiny.normalmap")
        self.assertEqual(self.parameters.textures()["shiny.bsdf.alpha.value"], "shiny.bsdf.alpha")
        self.parameters.update({"shiny.bsdf.alpha.wrap_mode": "mirror", "shiny.normalmap.raw": False})
        self.expect_saved(self.folder / "new.xml")
        self.assertIn('<bsdf type="normalmap" id="shiny">', (self.folder / "new-materials.xml").read_text())
        # Objects that were added are saved like those that were loaded.
        saved = kinome.load_file(self.folder / "new.xml")
        self.assertEqual(sorted(path for path, _ in kinome.traverse(saved).objects()),
                         sorted(path for path, _ in self.parameters.objects()))
        self.parameters.unset("shiny")
        self.parameters.update()
        for path in edits:
            if path == "shape_2.bsdf":
                self.parameters.unset(path)
            elif path != "shape_1.bsdf":
                self.parameters.revert(path)
        self.parameters.update()
        np.testing.assert_array_equal(kinome.render(self.scene), first)
        self.parameters.save(self.folder / "back.xml")
        self.assertEqual((self.folder / "back.xml").read_text(), text)

    def test_impossible_edits_are_errors(self):
        first = kinome.render(self.scene)
        bitmap = {"type": "bitmap", "filename": "parts/wood.ppm"}
        for path, value, message in (
                ("camera.fov", bitmap, "can't be a texture"),
                ("shiny.alpha", {"type": "diffuse"}, "must be a texture, got <bsdf>"),
                ("shiny", bitmap, "must be a bsdf, got <texture>"),
                ("shiny", {"type": "diffuse"}, "takes no bsdf"),
                ("shiny.alpha", {"type": "ref", "id": "wod"}, "unknown id 'wod'"),
                ("shiny.alpha", {"type": "ref", "id": "shiny"}, "."),
                ("shiny.alpha", {**bitmap, "id": "own"}, "can't have an id"),
                ("shiny.alpha", {**bitmap, "filename": "nowhere.png"}, "nowhere.png"),
                ("mesh.faces", bitmap, "an array")):
            with self.assertRaisesRegex(kinome.Error, message):
                self.parameters.update({path: value})
            self.assertEqual(self.parameters.update(), ([], 0, False), path)
        with self.assertRaisesRegex(kinome.Error, "unknown parameter"):
            self.parameters.unset("mesh")
        np.testing.assert_array_equal(kinome.render(self.scene), first)

    def test_a_value_that_excludes_another_is_taken_away(self):
        self.parameters.unset("shiny.alpha")
        self.parameters.update({"shiny.alpha_u": 0.1, "shiny.alpha_v": 0.4})
        self.assertEqual(self.parameters["shiny.alpha_v"], 0.4)
        self.expect_saved(self.folder / "new.xml")
        self.assertNotIn('name="alpha"', (self.folder / "new-materials.xml").read_text())

    def test_texture_coordinates_alone_leave_normals_as_they_are(self):
        def edit(array, amount):
            path = f"sheet.vertex_{array}"
            noise = np.random.default_rng(5).uniform(-amount, amount, self.parameters[path].shape)
            self.parameters.update({path: (self.parameters[path] + noise).astype(np.float32)})
        for array in ("positions", "normals"):
            for _ in range(3):
                edit(array, 0.1)
                normals = self.parameters["sheet.vertex_normals"]
                edit("texcoords", 0.1)
                np.testing.assert_array_equal(self.parameters["sheet.vertex_normals"], normals)
            self.expect_saved(self.folder / "new.xml")

    def test_paths_are_unique_and_all_that_can_be_set_is_listed(self):
        rows = {row.path: row for row in self.parameters.parameters()}
        self.assertEqual(len(rows), len(self.parameters.parameters()))
        self.assertEqual(rows["shape_1.center"].value[0], 1)  # the one with this id
        for row in rows.values():
            value = self.parameters[row.path]
            if row.value is not None:
                self.assertEqual(np.ravel(value).tolist(), np.ravel(row.value).tolist(), row.path)
        self.assertEqual((rows["camera.fov"].value, rows["camera.fov"].is_set), (45, True))
        self.assertEqual((rows["camera.near_clip"].is_set, rows["camera.near_clip"].default),
                         (False, rows["camera.near_clip"].value))
        self.assertIn("camera.focal_length", rows)
        reflectance = next(r for r in rows.values() if "reflectance texture" in r.type)
        self.assertEqual((reflectance.low, reflectance.high), (0, 1))

    def test_pixels_and_files_replace_each_other(self):
        first = kinome.render(self.scene)
        pixels = np.full((2, 2, 3), 0.25, np.float32)
        self.parameters.update({"wood.data": pixels, "sky.data": pixels})
        self.assertIsNone(self.parameters["wood.filename"])
        self.assertFalse(np.array_equal(kinome.render(self.scene), first))
        self.expect_saved(self.folder / "new.xml")
        self.parameters.update({"wood.filename": "parts/wood.ppm", "sky.filename": "parts/sky.pfm"})
        np.testing.assert_array_equal(kinome.render(self.scene), first)

    def test_an_update_that_fails_notes_nothing(self):
        before = kinome.render(self.scene)
        for wrong in ({"shiny.alphaa": 1.0}, {"shiny.alpha": "no"}, {"shiny.alpha": object()},
                      {"shiny.alpha": -1.0}, {"shiny.alpha": None}):
            with self.assertRaises((kinome.Error, TypeError)):
                self.parameters.update({"camera.fov": 70.0, **wrong})
            self.assertEqual(self.parameters["camera.fov"], 45)
            self.assertEqual(self.parameters.update(), ([], 0, False))
        # Values that were set before the failed update remain set.
        self.parameters["camera.fov"] = 60.0
        with self.assertRaises(kinome.Error):
            self.parameters.update({"camera.fov": 70.0, "shiny.alphaa": 1.0})
        self.assertEqual(self.parameters["camera.fov"], 60)
        self.parameters["camera.fov"] = 45.0
        self.parameters.update()
        np.testing.assert_array_equal(kinome.render(self.scene), before)

    def test_a_whole_dict_of_values_can_be_set(self):
        before = kinome.render(self.scene)
        self.parameters.update(dict(self.parameters.items()))
        # Matrices are inverted once more.
        np.testing.assert_allclose(kinome.render(self.scene), before, rtol=1e-4)
        values = dict(self.parameters.items())
        self.parameters.update({**values, "camera.fov": 60.0})
        self.assertEqual(self.parameters["camera.fov"], 60)


if __name__ == "__main__":
    unittest.main()
