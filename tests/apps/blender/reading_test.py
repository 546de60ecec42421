#!/usr/bin/python3
"""Tests that Kinome renders exported scenes without a warning: those of Kinome's exporter, and scenes in the style
of the add-on mitsuba-blender. KINOME_BUILD is the build folder.
"""
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np

from nodes import CAMERA, FILM, Images, image_node, link, node, principled_node, quiet_report
from kinome_export import camera, elements as e, lights, materials, ply, world

ROOT = pathlib.Path(__file__).resolve().parents[3]
BUILD = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build"))

# A scene in the style of mitsuba-blender: variables for the size, named elements, numbers as doubles, references with names,
# meshes without normals, area lights as invisible shapes that face backwards, groups for instances.
ADDON = """<scene version="3.8.0">
    <default name="spp" value="4"/>
    <default name="resx" value="16"/>
    <default name="resy" value="9"/>
    <integrator type="path" name="elm__0">
        <integer name="max_depth" value="5"/>
        <boolean name="hide_emitters" value="false"/>
    </integrator>
    <sensor type="perspective" id="Camera" name="Camera">
        <string name="fov_axis" value="x"/>
        <float name="fov" value="39.597755335771296"/>
        <float name="principal_point_offset_x" value="0"/>
        <float name="principal_point_offset_y" value="-0"/>
        <float name="near_clip" value="0.10000000149011612"/>
        <float name="far_clip" value="100"/>
        <transform name="to_world">
            <lookat origin="7.36, 4.96, 6.93" target="6.7, 4.51, 6.31" up="-0.324, 0.895, -0.305"/>
        </transform>
        <sampler type="independent" name="sampler"><integer name="sample_count" value="$spp"/></sampler>
        <film type="hdrfilm" name="film">
            <integer name="width" value="$resx"/>
            <integer name="height" value="$resy"/>
            <rfilter type="gaussian" name="rfilter"><float name="stddev" value="0.5"/></rfilter>
        </film>
    </sensor>
    <bsdf type="twosided" id="default-bsdf" name="default-bsdf"><bsdf type="diffuse" name="bsdf"/></bsdf>
    <bsdf type="diffuse" id="empty-emitter-bsdf" name="empty-emitter-bsdf"><rgb name="reflectance" value="0"/></bsdf>
    <bsdf type="twosided" id="mat-Paint" name="mat-Paint">
        <bsdf type="principled" name="nested">
            <rgb name="base_color" value="0.8000000715255737 0.2 0.1"/>
            <float name="spec_tint" value="0"/>
            <float name="metallic" value="0"/>
            <float name="anisotropic" value="0"/>
            <texture type="bitmap" name="roughness">
                <string name="filename" value="textures/image.exr"/>
                <string name="filter_type" value="bilinear"/>
                <string name="wrap_mode" value="repeat"/>
                <boolean name="raw" value="true"/>
                <transform name="to_uv"><scale x="2" y="2" z="1"/></transform>
            </texture>
            <float name="sheen" value="0"/>
            <float name="sheen_tint" value="0.5"/>
            <float name="clearcoat" value="0"/>
            <float name="clearcoat_gloss" value="0.030000000000000027"/>
            <float name="specular" value="0.5"/>
        </bsdf>
    </bsdf>
    <bsdf type="mask" id="mat-Leaf" name="mat-Leaf">
        <float name="opacity" value="0.5"/>
        <bsdf type="blendbsdf" name="material">
            <float name="weight" value="0.30000001192092896"/>
            <bsdf type="twosided" name="bsdf1"><bsdf type="diffuse" name="bsdf">
                <texture type="mesh_attribute" name="reflectance"><string name="name" value="vertex_color"/></texture>
            </bsdf></bsdf>
            <bsdf type="roughdielectric" name="bsdf2">
                <float name="alpha" value="0.25"/><float name="int_ior" value="1.45"/>
                <string name="distribution" value="beckmann"/>
                <rgb name="specular_transmittance" value="1 1 1"/>
            </bsdf>
        </bsdf>
    </bsdf>
    <bsdf type="twosided" id="mat-Steel" name="mat-Steel">
        <bsdf type="roughconductor" name="bsdf">
            <string name="distribution" value="ggx"/>
            <float name="alpha" value="0.04"/>
            <rgb name="specular_reflectance" value="0.9 0.9 0.9"/>
        </bsdf>
    </bsdf>
    <emitter type="envmap" id="World" name="World">
        <float name="scale" value="1"/>
        <string name="filename" value="textures/image.exr"/>
        <transform name="to_world"><rotate x="1" angle="90"/>
            <matrix value="-1 0 0 0 0 1 0 0 0 0 -1 0 0 0 0 1"/></transform>
    </emitter>
    <emitter type="point" id="emit-Light" name="emit-Light">
        <point name="position" x="4.076245307922363" y="5.903861999511719" z="-1.0054539442062378"/>
        <rgb name="intensity" value="79.57747154594767 79.57747154594767 79.57747154594767"/>
    </emitter>
    <emitter type="spot" id="emit-Spot" name="emit-Spot">
        <rgb name="intensity" value="8 8 8"/>
        <float name="cutoff_angle" value="22.499999403953552"/>
        <float name="beam_width" value="20.5"/>
        <transform name="to_world"><translate value="0 4 0"/></transform>
    </emitter>
    <emitter type="directional" name="elm__7">
        <rgb name="irradiance" value="1 1 1"/>
        <transform name="to_world"><matrix value="1 0 0 0 0 0 -1 0 0 1 0 0 0 0 0 1"/></transform>
    </emitter>
    <emitter type="projector" name="elm__8">
        <texture type="bitmap" name="irradiance"><string name="filename" value="textures/image.exr"/></texture>
        <float name="fov" value="30"/>
        <transform name="to_world"><lookat origin="0 5 0" target="0 0 0" up="0 0 1"/></transform>
    </emitter>
    <shape type="rectangle" id="emit-Area" name="emit-Area">
        <boolean name="flip_normals" value="true"/>
        <transform name="to_world"><scale value="0.5"/><rotate x="1" angle="-90"/><translate value="0 3 0"/></transform>
        <emitter type="area" name="emitter"><rgb name="radiance" value="2.5 2.5 2.5"/></emitter>
        <bsdf type="null" name="bsdf"/>
    </shape>
    <shape type="ply" name="elm__9">
        <string name="filename" value="meshes/mesh.ply"/>
        <ref name="bsdf" id="empty-emitter-bsdf"/>
        <emitter type="area" name="emitter"><rgb name="radiance" value="1.95 5 1.79"/></emitter>
    </shape>
    <shape type="ply" id="mesh-Plane" name="mesh-Plane">
        <string name="filename" value="meshes/mesh.ply"/>
        <boolean name="face_normals" value="true"/>
        <ref name="bsdf" id="mat-Paint"/>
    </shape>
    <shape type="shapegroup" id="mesh-Tree" name="mesh-Tree">
        <shape type="ply" name="Tree-Leaf">
            <string name="filename" value="meshes/mesh.ply"/><ref name="bsdf" id="mat-Leaf"/></shape>
        <shape type="ply" name="Tree-Steel">
            <string name="filename" value="meshes/mesh.ply"/><ref name="bsdf" id="mat-Steel"/></shape>
    </shape>
    <shape type="instance" name="elm__12">
        <ref name="shape" id="mesh-Tree"/>
        <transform name="to_world"><translate value="0 1 0"/></transform>
    </shape>
    <shape type="ply" name="elm__13">
        <string name="filename" value="meshes/mesh.ply"/><ref name="bsdf" id="default-bsdf"/></shape>
</scene>
"""


class ReadingTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        for name in ("meshes", "textures"):
            (self.folder / name).mkdir()
        write_image(self.folder / "textures/image.pfm", np.random.default_rng(1).random((8, 16, 3)))
        points, corners = np.array([[-3.0, 0, -3], [-3, 0, 3], [3, 0, 3], [3, 0, -3]]), np.array([0, 1, 2, 0, 2, 3])
        ply.write(self.folder / "meshes/mesh.ply", points, corners, np.tile([0.0, 1, 0], (6, 1)),
                  points[corners][:, ::2] / 6 + 0.5, np.full((6, 3), 0.5))

    def render(self, *options):
        command = [BUILD / "bin/kinome", self.folder / "scene.xml", "-o", self.folder / "a.exr", *options]
        result = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertNotIn("warning", result.stderr + result.stdout)

    def test_scenes_of_the_add_on(self):
        (self.folder / "scene.xml").write_text(ADDON.replace("image.exr", "image.pfm"))
        self.render("-D", "spp=1", "-D", "resx=8")

    def test_scenes_of_the_exporter(self):
        report, images = quiet_report(), FolderOfImages(self.folder)
        scene = e.ET.Element("scene", {"version": "3.0.0"})
        for name, value in (("spp", "1"), ("resx", "16"), ("resy", "16")):
            e.ET.SubElement(scene, "default", {"name": name, "value": value})
        scene.append(e.plugin("integrator", "volpath", e.integer("max_depth", 4)))
        to_world = np.array([[1.0, 0, 0, 0], [0, 0, 1, 5], [0, -1, 0, 0], [0, 0, 0, 1]])
        focus = {"matrix": to_world, "dof": {"fstop": 2, "distance": 5}}
        scene.append(camera.sensor({**CAMERA, **focus}, FILM, report))
        image = {**image_node("textures/image.pfm"), "is_data": True}
        sky = {**node("TEX_ENVIRONMENT"), "image": "textures/image.pfm", "projection": "EQUIRECTANGULAR"}
        scene.append(world.world("Sky", node("BACKGROUND", Color=link(sky), Strength=0.5), images, report, None))
        light = {"name": "a", "matrix": to_world, "color": [1, 0.5, 0.25], "energy": 9, "normalize": True, "radius": 0,
                 "spread": 4, "angle": 0, "spot_size": 1, "spot_blend": 0.5, "shape": "SQUARE", "size": 1, "size_y": 2}
        for kind, more in (("POINT", {}), ("POINT", {"radius": 0.1}), ("SUN", {}), ("SPOT", {}),
                           ("SPOT", {"spot_size": 3.0}), ("AREA", {}), ("AREA", {"shape": "ELLIPSE"})):
            scene.append(lights.light({**light, "type": kind, **more}, images, report))
        bump = {**node("BUMP", Strength=1.0, Distance=0.1, Height=link(image)), "invert": False}
        normal_map = {**node("NORMAL_MAP", Strength=1.0, Color=link(image)), "space": "TANGENT"}
        shiny = node("BSDF_GLOSSY", Color=[1, 1, 1], Roughness=0.2, Anisotropy=0.0)
        mix = {**node("MIX_SHADER", Fac=0.5), "shaders": [link(node("BSDF_TRANSPARENT", Color=[1, 1, 1])), link(shiny)]}
        glass = {"Transmission_Weight": 1.0, "Roughness": 0.0}
        for i, surface in enumerate((
                principled_node(Base_Color=link(image), Roughness=link(image), Normal=link(bump)),
                principled_node(Coat_Weight=1.0, Normal=link(normal_map)), principled_node(**glass),
                principled_node(Specular_IOR_Level=0.0), principled_node(Alpha=link(image), Emission_Strength=2.0), mix,
                node("BSDF_GLASS", Color=[1, 1, 1], Roughness=0.0, IOR=1.5, Normal=[0, 0, 0]),
                node("BSDF_GLASS", Color=[1, 1, 1], Roughness=0.5, IOR=1.5, Normal=[0, 0, 0]),
                node("EMISSION", Color=link(image), Strength=1.0))):
            material = materials.material(f"m{i}", surface, images, report)
            emitter = None if material.radiance is None else e.plugin("emitter", "area", material.radiance)
            scene.append(e.plugin("shape", "ply", e.string("filename", "meshes/mesh.ply"), material.bsdf, emitter))
        self.assertEqual(report.lines, [])
        e.write(scene, self.folder / "scene.xml")
        self.render()


class FolderOfImages(Images):
    def __init__(self, folder):
        super().__init__()
        self.folder = folder

    def image(self, node):
        return node["image"]

    def pixels(self, node):
        return np.full((2, 2, 4), 0.5)

    def baked(self, name, texels, is_exact=False):
        write_image(self.folder / f"textures/{name}.pfm", texels)
        return f"textures/{name}.pfm"


def write_image(path, texels):
    height, width = texels.shape[:2]
    path.write_bytes(b"PF\n%d %d\n-1\n" % (width, height) + texels[::-1].astype("<f4").tobytes())


if __name__ == "__main__":
    unittest.main()
