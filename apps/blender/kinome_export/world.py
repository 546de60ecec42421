"""Converts the nodes of a world, given as dictionaries, to an emitter."""
import numpy as np

from . import elements as e
from .matrices import ENVIRONMENT
from .textures import Inputs, as_color, as_number, fold, is_link


def world(name, node, files, report, bake):
    """Returns the emitter of a world whose node is connected to a world's output; None if it is black.
    Worlds that are neither a colour nor an image are baked: bake() writes a latitude-longitude image
    of Blender's and returns its file name."""
    if node is None:
        return None
    inputs = Inputs("world", name, files, report)
    if node["type"] == "BACKGROUND":
        color, strength = (fold(node["inputs"][name]) for name in ("Color", "Strength"))
        if not is_link(color) and not is_link(strength):
            radiance = [as_number(strength) * c for c in as_color(color)]
            return e.plugin("emitter", "constant", e.rgb("radiance", radiance)) if any(radiance) else None
        if not is_link(strength) and color["node"]["type"] == "TEX_ENVIRONMENT":
            to_world = _image_to_world(color["node"], inputs)
            if to_world is not None:
                return _envmap(files.image(color["node"]), as_number(strength), to_world)
    return _envmap(bake(), 1, np.eye(4))


def _envmap(filename, scale, to_world):
    return e.plugin("emitter", "envmap", e.string("filename", filename),
                    e.floating("scale", scale) if scale != 1 else None,
                    e.transform("to_world", to_world @ ENVIRONMENT))


def _image_to_world(node, inputs):
    """Returns the rotation of an environment texture; None if it isn't a rotation."""
    if node["projection"] != "EQUIRECTANGULAR":
        return None
    vector = node["inputs"].get("Vector")
    rotation = np.eye(4)
    while is_link(vector) and vector["node"]["type"] == "MAPPING":
        rotation = rotation @ inputs.mapping_matrix(vector["node"])
        vector = vector["node"]["inputs"].get("Vector")
    if is_link(vector) and not (vector["node"]["type"] == "TEX_COORD" and vector["output"] == "Generated"):
        return None
    linear = rotation[:3, :3]
    if rotation[:3, 3].any() or not np.allclose(linear @ linear.T, np.eye(3), atol=1e-5):
        return None
    return rotation.T  # the texture coordinates are rotated, so that the image turns the other way
