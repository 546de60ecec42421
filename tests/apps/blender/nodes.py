"""Dictionaries of nodes for tests of the exporter from Blender, and what such tests have in common."""
import io
import pathlib
import sys

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "apps/blender"))
from kinome_export.report import Report  # noqa: E402

IDENTITY = np.eye(4)
PRINCIPLED = {
    "Base Color": [0.8, 0.2, 0.1, 1], "Metallic": 0.0, "Roughness": 0.5, "IOR": 1.5, "Alpha": 1.0, "Normal": [0, 0, 0],
    "Specular IOR Level": 0.5, "Specular Tint": [1, 1, 1, 1], "Anisotropic": 0.0, "Transmission Weight": 0.0,
    "Coat Weight": 0.0, "Coat Roughness": 0.03, "Coat IOR": 1.5, "Coat Tint": [1, 1, 1, 1], "Sheen Weight": 0.0,
    "Sheen Tint": [1, 1, 1, 1], "Emission Color": [1, 1, 1, 1], "Emission Strength": 0.0, "Subsurface Weight": 0.0}

FILM = {"width": 320, "height": 200, "filter": "BOX", "filter_width": 1.0}
CAMERA = {"name": "c", "type": "PERSP", "matrix": IDENTITY, "sensor_fit": "AUTO", "sensor_width": 36.0,
          "sensor_height": 24.0, "lens": 50.0, "shift_x": 0.0, "shift_y": 0.0, "clip_start": 0.1, "clip_end": 100.0,
          "ortho_scale": 6.0, "dof": None}


class Images:
    """Stands for the folder of textures."""

    def __init__(self):
        self.texels, self.stored = {}, {}

    def image(self, node):
        return f"textures/{node['image']}"

    def pixels(self, node):
        return self.texels[node["image"]]

    def baked(self, name, texels, is_exact=False):
        self.stored[name] = texels
        return f"textures/{name}.exr"


def quiet_report():
    return Report(io.StringIO())


def node(kind, name="node", **inputs):
    return {"type": kind, "name": name, "inputs": {k.replace("_", " "): v for k, v in inputs.items()}}


def link(to, output="Color", default=0.5):
    return {"node": to, "output": output, "default": default}


def image_node(name="wood.png", vector=None, **settings):
    return {**node("TEX_IMAGE", "Image", **({"Vector": vector} if vector else {})), "image": name, "is_data": False,
            "projection": "FLAT", "extension": "REPEAT", "interpolation": "Linear", **settings}


def principled_node(**changes):
    return {"type": "BSDF_PRINCIPLED", "name": "Principled BSDF",
            "inputs": {**PRINCIPLED, **{k.replace("_", " "): v for k, v in changes.items()}}}


def value(element, name):
    """Returns the text of a parameter."""
    return element.find(f"*[@name='{name}']").get("value")


def numbers(element, name):
    return [float(x) for x in value(element, name).split()]


def numbers_of_transform(element):
    return [float(x) for x in element.find("transform/matrix").get("value").split()]
