"""A small scene for tests of the viewer: a red ball on a grey floor under an emitter and a sky."""
import os
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from noise_images import write_pfm, write_ppm  # noqa: E402

BUILD = pathlib.Path(os.environ["KINOME_BUILD"])
PROGRAM = str(BUILD / "bin/kinome-view")

SCENE = """\
<scene version="3.0.0">
    <!-- Kept by whoever saves it. -->
    <integrator type="path"><integer name="max_depth" value="4"/></integrator>
    <sensor type="thinlens" id="camera">
        <float name="fov" value="40"/>
        <float name="aperture_radius" value="0.02"/> <float name="focus_distance" value="5"/>
        <transform name="to_world">
            <lookat origin="0, 1, 5" target="0, 1, 0" up="0, 1, 0"/>
        </transform>
        <sampler type="independent"><integer name="sample_count" value="2"/></sampler>
        <film type="hdrfilm">
            <integer name="width" value="{width}"/> <integer name="height" value="{height}"/>
            <string name="component_format" value="float32"/>
        </film>
    </sensor>
    <bsdf type="diffuse" id="red"><rgb name="reflectance" value="0.7, 0.05, 0.05"/></bsdf>
    <bsdf type="roughplastic" id="grey"><rgb name="diffuse_reflectance" value="0.3"/>
        <float name="alpha" value="0.2"/></bsdf>
    <shape type="sphere" id="ball"><point name="center" x="0" y="1" z="0"/>
        <float name="radius" value="0.8"/><ref id="red"/></shape>
    <shape type="rectangle" id="floor"><transform name="to_world">
        <scale value="4"/><rotate x="1" angle="-90"/></transform><ref id="grey"/></shape>
    <emitter type="point" id="lamp"><point name="position" x="1" y="2.2" z="2"/>
        <rgb name="intensity" value="4"/></emitter>
    <emitter type="envmap" id="sky"><string name="filename" value="sky.pfm"/></emitter>
</scene>
"""


def write_scene(folder, width=32, height=24):
    """Writes the scene's file, with its sky and a texture beside it. Returns its path."""
    write_pfm(folder / "sky.pfm", 8, 4, 3, 0.2, 0.6)
    write_ppm(folder / "bumps.ppm", 4, 4, 4)
    path = folder / "scene.xml"
    path.write_text(SCENE.format(width=width, height=height))
    return path
