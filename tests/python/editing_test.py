#!/usr/bin/python3
"""Edit sessions by traverse(): after any number of random edits the picture is the one of the saved
scene, to the bit; refused edits leave no trace; memory doesn't grow; what is saved keeps its text.

Of the build folder KINOME_BUILD. KINOME_EDITS=2000 makes longer sessions, KINOME_SEED=5 another one.
"""
import ctypes
import os
import pathlib
import random
import re
import sys
import tempfile
import unittest

import numpy as np

BUILD = pathlib.Path(os.environ["KINOME_BUILD"])
sys.path.insert(0, str(BUILD / "python"))
import kinome  # noqa: E402

EDITS = int(os.environ.get("KINOME_EDITS", 200))
SEED = int(os.environ.get("KINOME_SEED", 1))

SCENE = """\
<?xml version="1.0" encoding="utf-8"?>
<!-- A table, by hand. -->
<scene version="3.0.0">
    <default name="spp" value="2"/>   <!-- samples -->
    <integrator type="path"><integer name="max_depth" value="4"/></integrator>

    <sensor type="thinlens" id="camera">
        <float   name="fov"   value="45"/>  <!-- wide -->
        <float name="aperture_radius" value="0.1"/> <float name="focus_distance" value="6"/>
        <transform name="to_world">
            <lookat origin="0, 2, 6" target="0, 0.5, 0" up="0, 1, 0"/>
        </transform>
        <sampler type="independent"><integer name="sample_count" value="$spp"/></sampler>
        <film type="hdrfilm">
            <integer name="width" value="20"/> <integer name="height" value="14"/>
            <string name="component_format" value="float32"/>
        </film>
    </sensor>

    <include filename="parts/materials.xml"/>
    <texture type="bitmap" id="wood"><string name="filename" value="parts/wood.ppm"/></texture>

    <shape type="ply" id="mesh">
        <string name="filename" value="parts/mesh.ply"/>
        <transform name="to_world"><scale x="-1"/><rotate y="1" angle="20"/></transform>
        <ref id="shiny"/>
    </shape>
    <shape type="obj" id="sheet">
        <string name="filename" value="parts/sheet.obj"/>
        <boolean name="flip_normals" value="true"/>
        <bsdf type="twosided"><bsdf type="diffuse">
            <ref name="reflectance" id="wood"/>
        </bsdf></bsdf>
    </shape>
    <shape type="ply" id="meter">
        <string name="filename" value="parts/mesh.ply"/>
        <boolean name="face_normals" value="true"/>
        <transform name="to_world"><translate x="2" z="-1"/></transform>
        <bsdf type="diffuse"/>
        <sensor type="irradiancemeter">
            <film type="hdrfilm"><integer name="width" value="1"/><integer name="height" value="1"/>
            </film>
        </sensor>
    </shape>
    <shape type="sphere"><point name="center" x="-1" y="0.5" z="0"/><float name="radius" value="0.5"/>
        <bsdf type="roughplastic"><float name="alpha" value="0.2"/></bsdf></shape>
    <shape type="sphere" id="shape_1"><point name="center" x="1" y="0.4" z="1"/>
        <float name="radius" value="0.4"/><ref id="shiny"/></shape>
    <shape type="rectangle"><transform name="to_world">
            <scale value="4"/><rotate x="1" angle="-90"/></transform>
        <bsdf type="diffuse"><texture type="checkerboard" name="reflectance">
            <transform name="to_uv"><scale value="4"/></transform></texture></bsdf></shape>
    <shape type="ply" id="lamp">
        <string name="filename" value="parts/mesh.ply"/>
        <transform name="to_world"><translate y="3"/></transform>
        <emitter type="area"><rgb name="radiance" value="6, 5, 4"/></emitter>
    </shape>
    <shape type="shapegroup" id="group"><shape type="ply" id="box">
        <string name="filename" value="parts/mesh.ply"/>
        <transform name="to_world"><scale value="0.2"/></transform></shape></shape>
    <shape type="instance" id="near"><ref id="group"/>
        <transform name="to_world"><translate x="1.2" y="1.3" z="1"/></transform></shape>
    <emitter type="point"><point name="position" x="2" y="3" z="4"/>
        <rgb name="intensity" value="9"/></emitter>
    <emitter type="spot"><rgb name="intensity" value="20"/><transform name="to_world">
        <lookat origin="-2, 4, 3" target="0, 0, 0" up="0, 1, 0"/></transform></emitter>
    <!-- the sky -->
    <emitter type="envmap" id="sky"><string name="filename" value="parts/sky.pfm"/></emitter>
</scene>
"""

MATERIALS = """\
<scene version="3.0.0">
    <!-- Shared by all. -->
    <bsdf type="roughconductor" id="shiny"><float name="alpha" value="0.2"/></bsdf>
</scene>
"""


def write_mesh(path, seed=0):
    """A grid of 5 x 5 vertices, with normals and texture coordinates."""
    dice = np.random.default_rng(seed)
    lines, faces = [], []
    for j in range(5):
        for i in range(5):
            n = np.array([0.1, 0.2, 1]) + dice.uniform(-0.3, 0.3, 3)
            p = (i / 2 - 1, j / 2, dice.uniform(-0.2, 0.2))
            lines.append(" ".join(str(round(float(x), 4)) for x in (*p, *n, i / 4, j / 4)))
            if i < 4 and j < 4:
                a = 5 * j + i
                faces += [f"3 {a} {a + 1} {a + 6}", f"3 {a} {a + 6} {a + 5}"]
    names = "\n".join(f"property float {name}" for name in "x y z nx ny nz u v".split())
    path.write_text("\n".join(
        ["ply\nformat ascii 1.0\nelement vertex 25", names,
         f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header",
         *lines, *faces, ""]))


def write_obj(path):
    rows = [f"v {i - 1} {0.3 + 0.1 * i * j} {j - 3}\nvt {i / 2} {j / 2}"
            for j in range(3) for i in range(3)]
    faces = [f"f {a}/{a} {a + 1}/{a + 1} {a + 4}/{a + 4} {a + 3}/{a + 3}" for a in (1, 2, 4, 5)]
    path.write_text("\n".join([*rows, *faces, ""]))


def write_files(folder, scene=SCENE):
    parts = folder / "parts"
    parts.mkdir()
    write_mesh(parts / "mesh.ply")
    write_mesh(parts / "other.ply", 1)
    write_obj(parts / "sheet.obj")
    dice = np.random.default_rng(3)
    (parts / "wood.ppm").write_bytes(b"P6 4 4 255\n" + dice.bytes(48))
    sky = dice.uniform(0, 1, (4, 8, 3)).astype("<f4")
    (parts / "sky.pfm").write_bytes(b"PF\n8 4\n-1\n" + sky.tobytes())
    (parts / "materials.xml").write_text(MATERIALS)
    (folder / "scene.xml").write_text(scene)
    return folder / "scene.xml"


class RandomEdits:
    """Values of all types, some of which can't be."""

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
            return None  # nothing would be seen any more
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
            choices = {"filter_type": ["bilinear", "nearest"], "distribution": ["beckmann", "ggx"],
                       "wrap_mode": ["repeat", "mirror", "clamp"], "fov_axis": ["x", "y"]}
            return dice.choice(choices.get(name, ["no such"]))
        raise AssertionError(f"a parameter of unknown type: {row}")

    def step(self):
        """One to three values, then an update."""
        rows = self.parameters.parameters()
        try:
            for row in self.dice.choices(rows, k=self.dice.randint(1, 3)):
                value = self.value(row)
                if value is not None:
                    self.parameters[row.path] = value
            self.parameters.update()
            self.done += 1
        except kinome.Error:
            self.refused += 1
            # What was noted before the one that can't be noted is for this update.
            try:
                self.parameters.update()
            except kinome.Error:
                pass


def resident_bytes():
    ctypes.CDLL(None).malloc_trim(0)
    pages = int(pathlib.Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


class EditingTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.path = write_files(self.folder)
        self.scene = kinome.load_file(self.path)
        self.parameters = kinome.traverse(self.scene)

    def expect_saved(self, path, may_be_black=False):
        """The picture of the saved scene: that of the edited one."""
        self.parameters.save(path)
        saved = kinome.load_file(path)
        if not may_be_black:
            self.assertGreater(np.std(kinome.render(saved, sensor="camera")), 0)
        for sensor in ("camera", 1):
            np.testing.assert_array_equal(kinome.render(saved, sensor=sensor),
                                          kinome.render(self.scene, sensor=sensor))
        return saved

    def test_random_edits_end_in_the_picture_of_the_saved_scene(self):
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
        # And what is saved of what was saved.
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
        # 800 edits that kept but a mesh's arrays, or an update's objects, would keep some 8 MB.
        self.assertLess(sizes[1] - sizes[0], 4 << 20)

    def test_what_is_saved_keeps_its_text(self):
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
        # Defines become defaults before all others; files are found from elsewhere.
        self.scene = kinome.load_file(self.path, spp=3)
        self.parameters = kinome.traverse(self.scene)
        (self.folder / "far").mkdir()
        self.expect_saved(self.folder / "far/new.xml")
        text = (self.folder / "far/new.xml").read_text()
        first = '<default name="spp" value="'
        self.assertEqual(text, SCENE.replace(first, f'{first}3"/>\n    {first}', 1)
                         .replace('"parts/', '"../parts/'))

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
        # Until a parameter of its own says what it is.
        self.parameters.update({"meter.face_normals": True})
        self.assertFalse(np.array_equal(self.parameters["meter.vertex_positions"], edited))

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
        # One that is replaced keeps its name.
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
        # The second session makes a shape of the very file that it would write for its edits.
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
            # Made once more, of the file that it was read from.
            self.parameters.update({"meter.sensor.film.compensate": i == 0})
            self.expect_saved(self.path)
        self.assertEqual((self.folder / "new-meter.ply").read_bytes(), own)
        self.assertEqual((self.folder / "new-lamp.ply").read_bytes(), first)
        self.assertTrue((self.folder / "new-meter_1.ply").exists())
        # A parameter of its own takes the edits away.
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

    def test_what_a_scene_file_takes_for_a_name_is_refused(self):
        message = "can't say '.*': a \\$ begins a name"
        # Where files are, as seen from the saved scene.
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
        # A dict's keys.
        said = {"type": "scene", "integrator": {"type": "direct"}, "camera": {"type": "perspective"},
                "b$ll": {"type": "sphere"}}
        self.parameters = kinome.traverse(kinome.load_dict(said))
        self.expect_refused(message, self.folder / "new.xml")
        said["ball"] = {"type": "sphere", "id": "a$", "bsdf": {"type": "diffuse"}}
        del said["b$ll"]
        self.parameters = kinome.traverse(kinome.load_dict(said))
        self.expect_refused(message, self.folder / "new.xml")

    def test_defines_stand_before_what_uses_them(self):
        text = SCENE.replace('    <default name="spp" value="2"/>   <!-- samples -->\n', "")
        text = text.replace("    <!-- the sky -->", '    <default name="spp" value="5"/>')
        self.load(text, spp=3)
        self.expect_saved(self.folder / "new.xml")
        # A texture that others refer to, and that stands nowhere any more, uses a default.
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

    def test_an_update_that_fails_notes_nothing(self):
        before = kinome.render(self.scene)
        for wrong in ({"shiny.alphaa": 1.0}, {"shiny.alpha": "no"}, {"shiny.alpha": object()},
                      {"shiny.alpha": -1.0}, {"shiny.alpha": None}):
            with self.assertRaises((kinome.Error, TypeError)):
                self.parameters.update({"camera.fov": 70.0, **wrong})
            self.assertEqual(self.parameters["camera.fov"], 45)
            self.assertEqual(self.parameters.update(), ([], 0, False))
        # What was noted before goes on being noted.
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

    def test_a_path_is_one(self):
        for path in (None, 3, object()):
            with self.assertRaisesRegex(TypeError, "^path takes a path"):
                self.parameters.save(path)


if __name__ == "__main__":
    unittest.main()
