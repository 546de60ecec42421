"""A small scene, as a file and as a dict, and the base class of tests that render it."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

BUILD = pathlib.Path(os.environ["KINOME_BUILD"])
if "KINOME_PACKAGE" not in os.environ:
    sys.path.insert(0, str(BUILD / "python"))
import kinome  # noqa: E402

SCENE = """\
<scene version="3.0.0">
    <default name="spp" value="4"/>
    <integrator type="path"/>
    <sensor type="perspective">
        <transform name="to_world">
            <lookat origin="0, 2, 6" target="0, 0, 0" up="0, 1, 0"/>
        </transform>
        <sampler type="independent"><integer name="sample_count" value="$spp"/></sampler>
        <film type="hdrfilm">
            <integer name="width" value="40"/> <integer name="height" value="30"/>
            <string name="component_format" value="float32"/>
        </film>
    </sensor>
    <bsdf type="diffuse" id="red"><rgb name="reflectance" value="0.6, 0.2, 0.1"/></bsdf>
    <shape type="sphere" id="ball"><ref id="red"/></shape>
    <emitter type="constant" id="sky"><rgb name="radiance" value="0.5, 0.6, 0.7"/></emitter>
    <emitter type="point"><point name="position" x="2" y="3" z="4"/>
        <rgb name="intensity" value="9"/></emitter>
</scene>
"""

# The same scene as a dict in Mitsuba's form, with the values of the text.
DICT = {
    "type": "scene",
    "integrator": {"type": "path"},
    "sensor": {
        "type": "perspective",
        "to_world": kinome.Transform().look_at([0, 2, 6], [0, 0, 0], [0, 1, 0]),
        "sampler": {"type": "independent", "sample_count": 4},
        "film": {"type": "hdrfilm", "width": 40, "height": 30, "component_format": "float32"},
    },
    "red": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.6, 0.2, 0.1]}},
    "ball": {"type": "sphere", "bsdf": {"type": "ref", "id": "red"}},
    "sky": {"type": "constant", "radiance": {"type": "rgb", "value": [0.5, 0.6, 0.7]}},
    "lamp": {"type": "point", "position": [2, 3, 4],
             "intensity": {"type": "rgb", "value": 9}},
}


def with_parts(scene, **parts):
    return {**scene, **parts}


def read_exr(path):
    """Returns the colour of an image, read by Debian's OpenImageIO."""
    import OpenImageIO as oiio
    return oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT)[:, :, :3]


class SceneTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.path = self.folder / "scene.xml"
        self.path.write_text(SCENE)

    def load(self, **defines):
        return kinome.load_file(self.path, **defines)

    def program(self, *arguments):
        """Returns the colour of the program's image."""
        output = self.folder / "program.exr"
        subprocess.run([sys.executable, "-m", "kinome", "-q", self.path, "-o", output, *arguments],
                       check=True, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)})
        return read_exr(output)

    def said_by(self, code):
        """Runs code in its own process and returns its stderr."""
        result = subprocess.run([sys.executable, "-c", "import sys, time, kinome\n" + code, self.path],
                                env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
                                check=False, text=True, capture_output=True, timeout=1200)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stderr
