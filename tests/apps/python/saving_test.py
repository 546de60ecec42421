#!/usr/bin/python3
"""Tests of scenes that edit sessions save. Text outside of edits stays the same, file names are
relative to the saved scene, and a failed save writes nothing. KINOME_BUILD is the build folder.
"""
import re
import unittest

import numpy as np

from edit_sessions import SessionTest, MATERIALS, SCENE, write_mesh
import kinome  # found by edit_sessions


class SavingTest(SessionTest):
    def test_saved_scenes_keep_their_text(self):
        self.parameters.update({"camera.fov": 50.0, "shiny.alpha": 0.3, "sky.scale": 2.0})
        self.expect_saved(self.folder / "new.xml")
        text = (self.folder / "new.xml").read_text()
        expected = SCENE.replace('<float   name="fov"   value="45"/>',
                                 '<float name="fov" value="50"/>')
        expected = expected.replace("parts/materials.xml", "new-materials.xml")
        expected = expected.replace('id="sky"><string', 'id="sky"><float name="scale" value="2"/><string')
        self.assertEqual(text, expected)
        self.assertEqual((self.folder / "new-materials.xml").read_text(),
                         MATERIALS.replace('value="0.2"', 'value="0.3"'))
        # Defines are written as defaults before all others. Files are found from another folder.
        self.scene = kinome.load_file(self.path, spp=3)
        self.parameters = kinome.traverse(self.scene)
        (self.folder / "far").mkdir()
        self.expect_saved(self.folder / "far/new.xml")
        text = (self.folder / "far/new.xml").read_text()
        first = '<default name="spp" value="'
        self.assertEqual(text, SCENE.replace(first, f'{first}3"/>\n    {first}', 1)
                         .replace('"parts/', '"../parts/'))

    def test_a_texture_that_others_refer_to_is_kept(self):
        text = SCENE.replace('<ref name="reflectance" id="wood"/>',
                             '<texture type="bitmap" id="wood" name="reflectance">'
                             '<string name="filename" value="parts/wood.ppm"/></texture>')
        text = re.sub(r'    <texture type="bitmap" id="wood"><.*\n', "", text, count=1)
        text = text.replace('<bsdf type="roughplastic">',
                            '<bsdf type="roughplastic"><ref name="diffuse_reflectance" id="wood"/>')
        self.path.write_text(text)
        self.scene = kinome.load_file(self.path)
        self.parameters = kinome.traverse(self.scene)
        self.parameters.update({"sheet.bsdf.bsdf.reflectance": 0.5, "wood.wrap_mode": "clamp"})
        self.expect_saved(self.folder / "new.xml")

    def test_dicts_and_old_files_are_saved_as_well(self):
        self.scene = kinome.load_dict({
            "type": "scene", "integrator": {"type": "direct"},
            "camera": {"type": "perspective", "film": {"type": "hdrfilm", "width": 9, "height": 9},
                       "to_world": kinome.Transform().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0])},
            "probe": {"type": "perspective", "film": {"type": "hdrfilm", "width": 4, "height": 4},
                      "to_world": kinome.Transform().look_at([0, 3, 5], [0, 0, 0], [0, 1, 0])},
            "ball": {"type": "sphere", "bsdf": {"type": "diffuse", "reflectance": {
                "type": "bitmap", "data": np.full((2, 2, 3), 0.3, np.float32)}}},
            "mesh": {"type": "ply", "filename": str(self.folder / "parts/mesh.ply")},
            "sky": {"type": "constant", "radiance": 0.7}})
        self.parameters = kinome.traverse(self.scene)
        self.parameters.update({"ball.radius": 0.8, "mesh.faces": self.parameters["mesh.faces"][3:]})
        self.expect_saved(self.folder / "said.xml")
        old = SCENE.replace('version="3.0.0"', 'version="0.6.0"').replace("fov_axis", "fovAxis")
        self.path.write_text(old.replace("aperture_radius", "apertureRadius")
                             .replace("focus_distance", "focusDistance"))
        self.scene = kinome.load_file(self.path, lenient=True)
        self.parameters = kinome.traverse(self.scene)
        self.parameters.update({"camera.aperture_radius": 0.2})
        self.expect_saved(self.folder / "old.xml")

    def load(self, text, **defines):
        self.path.write_text(text)
        self.scene = kinome.load_file(self.path, **defines)
        self.parameters = kinome.traverse(self.scene)

    def files(self):
        return {p: p.read_bytes() for p in self.folder.rglob("*") if p.is_file()}

    def expect_refused(self, message, path):
        before = self.files()
        with self.assertRaisesRegex(kinome.Error, message):
            self.parameters.save(path)
        self.assertEqual(self.files(), before)

    def test_quotes_of_either_kind(self):
        self.load(SCENE.replace('"parts/mesh.ply"', "'parts/mesh.ply'"))
        (self.folder / "parts").rename(self.folder / "it's")
        (self.folder / "parts").symlink_to("it's")
        (self.folder / "a'b").mkdir()
        self.expect_saved(self.folder / "a'b/new.xml")
        text = SCENE.replace('"parts/', '"it&apos;s/').replace('"it&apos;s/mesh.ply"',
                                                               "'it&apos;s/mesh.ply'")
        self.load(text)
        self.expect_saved(self.folder / "a'b/new.xml")
        self.assertIn("'../it&apos;s/mesh.ply'", (self.folder / "a'b/new.xml").read_text())

    def test_no_include_that_is_still_read_is_written_over(self):
        lamp = ('<scene version="3.0.0"><emitter type="point" id="{}"><rgb name="intensity" '
                'value="{}"/></emitter></scene>')
        own, other = self.folder / "room-lights.xml", self.folder / "parts/lights.xml"
        own.write_text(lamp.format("own", 3))
        other.write_text(lamp.format("other", 5))
        self.path = self.folder / "room.xml"
        self.load(SCENE.replace("    <!-- the sky -->", '<include filename="room-lights.xml"/>'
                                '<include filename="parts/lights.xml"/>'))
        self.parameters.update({"other.intensity": 7})
        self.expect_saved(self.path)
        self.assertEqual(own.read_text(), lamp.format("own", 3))
        self.assertEqual(other.read_text(), lamp.format("other", 5))
        self.assertIn("room-lights_1.xml", self.path.read_text())
        # An include that is replaced keeps its name.
        self.scene = kinome.load_file(self.path)
        self.parameters = kinome.traverse(self.scene)
        self.parameters.update({"other.intensity": 8, "own.intensity": 4})
        self.expect_saved(self.path)
        self.assertIn('value="4"', own.read_text())
        self.assertIn('value="8"', (self.folder / "room-lights_1.xml").read_text())
        self.expect_refused("the scene includes it", own)

    def test_includes_in_includes_are_named_once(self):
        (self.folder / "parts/outer.xml").write_text(
            '<scene version="3.0.0"><include filename="materials.xml"/></scene>')
        self.load(SCENE.replace("parts/materials.xml", "parts/outer.xml"))
        self.parameters.update({"shiny.alpha": 0.3})
        self.expect_saved(self.folder / "new.xml")
        self.assertEqual(sorted(p.name for p in self.folder.glob("new*")),
                         ["new-materials.xml", "new-outer.xml", "new.xml"])

    def test_a_session_goes_on_after_its_meshes_file_was_saved_over(self):
        self.parameters.update({"lamp.vertex_positions":
                                self.parameters["lamp.vertex_positions"] + np.float32(0.25)})
        self.expect_saved(self.folder / "new.xml")
        first = (self.folder / "new-lamp.ply").read_bytes()
        # The second session reads a shape from the file that it would write for its edits.
        self.path = self.folder / "new.xml"
        write_mesh(self.folder / "new-meter.ply", 2)
        before, of_meter, after = self.path.read_text().partition('id="meter"')
        self.load(before + of_meter + after.replace('"parts/mesh.ply"', '"new-meter.ply"', 1))
        vertices = self.parameters["meter.vertex_positions"]
        own = (self.folder / "new-meter.ply").read_bytes()
        for i in range(2):
            self.parameters.update({"meter.vertex_positions":
                                    self.parameters["meter.vertex_positions"] + np.float32(0.25)})
            self.expect_saved(self.path)
            # Rebuilds the shape from the file that it was read from.
            self.parameters.update({"meter.sensor.film.compensate": i == 0})
            self.expect_saved(self.path)
        self.assertEqual((self.folder / "new-meter.ply").read_bytes(), own)
        self.assertEqual((self.folder / "new-lamp.ply").read_bytes(), first)
        self.assertTrue((self.folder / "new-meter_1.ply").exists())
        # A parameter of the mesh itself discards the edits of its arrays.
        self.parameters.update({"meter.face_normals": True})
        np.testing.assert_array_equal(self.parameters["meter.vertex_positions"], vertices)

    def test_a_save_that_fails_writes_nothing(self):
        edits = {"lamp.vertex_positions": self.parameters["lamp.vertex_positions"] + np.float32(1),
                 "wood.data": np.full((2, 2, 3), 0.25, np.float32), "shiny.alpha": 0.3}
        self.parameters.update(edits)
        (self.folder / "taken.xml").mkdir()
        for path in ("taken.xml", "nowhere/new.xml"):
            self.expect_refused("cannot write", self.folder / path)
        (self.folder / "parts/a$b.pfm").write_bytes((self.folder / "parts/sky.pfm").read_bytes())
        self.parameters.update({"sky.filename": "parts/a$b.pfm"})
        self.expect_refused("a \\$ begins a name", self.folder / "new.xml")

    def test_values_that_a_scene_file_reads_as_names_are_refused(self):
        message = "can't write '.*' to a scene file, where a \\$ begins a name"
        # Paths of files relative to the saved scene.
        (self.folder / "a$b").mkdir()
        self.path.rename(self.folder / "a$b/scene.xml")
        (self.folder / "parts").rename(self.folder / "a$b/parts")
        self.path = self.folder / "a$b/scene.xml"
        self.load(SCENE)
        self.expect_refused(message, self.folder / "new.xml")
        self.expect_saved(self.path)
        # -D
        self.load(SCENE.replace('"camera"', '"camera$x"').replace("$spp", "2"), x="$y")
        self.expect_refused(message, self.path)
        # Keys of a dict.
        said = {"type": "scene", "integrator": {"type": "direct"}, "camera": {"type": "perspective"},
                "b$ll": {"type": "sphere"}}
        self.parameters = kinome.traverse(kinome.load_dict(said))
        self.expect_refused(message, self.folder / "new.xml")
        said["ball"] = {"type": "sphere", "id": "a$", "bsdf": {"type": "diffuse"}}
        del said["b$ll"]
        self.parameters = kinome.traverse(kinome.load_dict(said))
        self.expect_refused(message, self.folder / "new.xml")

    def test_defines_precede_their_uses(self):
        text = SCENE.replace('    <default name="spp" value="2"/>   <!-- samples -->\n', "")
        text = text.replace("    <!-- the sky -->", '    <default name="spp" value="5"/>')
        self.load(text, spp=3)
        self.expect_saved(self.folder / "new.xml")
        # A texture that is only referred to, and defined nowhere in the saved text, uses a default.
        text = SCENE.replace('<ref name="reflectance" id="wood"/>',
                             '<default name="mode" value="mirror"/><texture type="bitmap" id="wood" '
                             'name="reflectance"><string name="filename" value="parts/wood.ppm"/>'
                             '<string name="wrap_mode" value="$mode"/></texture>')
        text = re.sub(r'    <texture type="bitmap" id="wood"><.*\n', "", text, count=1)
        self.load(text.replace('<bsdf type="roughplastic">', '<bsdf type="roughplastic">'
                               '<ref name="diffuse_reflectance" id="wood"/>'))
        self.parameters.update({"sheet.bsdf.bsdf.reflectance": 0.5})
        self.expect_saved(self.folder / "new.xml")
        self.assertIn('name="wrap_mode" value="mirror"', (self.folder / "new.xml").read_text())
        self.assertIn("<!-- A table", (self.folder / "new.xml").read_text())

    def test_values_of_an_outer_bsdf_precede_a_bsdf_that_is_put_inside(self):
        # The inner element begins where the values of the outer one are inserted.
        self.parameters.update({"sheet.bsdf.allow_transmission": True,
                                "sheet.bsdf.bsdf": {"type": "bumpmap", "any": {"type": "checkerboard"}}})
        self.expect_saved(self.folder / "new.xml")

    def test_a_path_is_one(self):
        for path in (None, 3, object()):
            with self.assertRaisesRegex(TypeError, "^path takes a path"):
                self.parameters.save(path)


if __name__ == "__main__":
    unittest.main()
