"""A scene with several files for edit sessions by traverse(), and a test case that opens it."""
import os
import pathlib
import random
import sys
import tempfile
import unittest

import numpy as np

BUILD = pathlib.Path(os.environ["KINOME_BUILD"])
sys.path.insert(0, str(BUILD / "python"))
import kinome  # noqa: E402
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from noise_images import write_pfm, write_ppm  # noqa: E402

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
    """Writes a grid of 5 x 5 vertices, with normals and texture coordinates."""
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
    write_ppm(parts / "wood.ppm", 4, 4, 3)
    write_pfm(parts / "sky.pfm", 8, 4, 3)
    (parts / "materials.xml").write_text(MATERIALS)
    (folder / "scene.xml").write_text(scene)
    return folder / "scene.xml"


class SessionTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.path = write_files(self.folder)
        self.scene = kinome.load_file(self.path)
        self.parameters = kinome.traverse(self.scene)

    def expect_saved(self, path, may_be_black=False):
        """Saves the scene and tests that it renders the same image as the edited one. Returns it.
        """
        self.parameters.save(path)
        saved = kinome.load_file(path)
        if not may_be_black:
            self.assertGreater(np.std(kinome.render(saved, sensor="camera")), 0)
        for sensor in ("camera", 1):
            np.testing.assert_array_equal(kinome.render(saved, sensor=sensor),
                                          kinome.render(self.scene, sensor=sensor))
        return saved
