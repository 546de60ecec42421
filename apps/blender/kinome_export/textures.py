"""Converts inputs of shader nodes, given as dictionaries, to colours, numbers and textures.

An input is a number, a list of numbers, or a link: {"node": NODE, "output": NAME, "default": VALUE}.
A node has its `type`, `name`, `inputs` by name, and the properties of its type.
"""
import numpy as np

from . import elements as e
from .matrices import euler_xyz, homogeneous

_WRAP = {"REPEAT": "repeat", "EXTEND": "clamp", "MIRROR": "mirror", "CLIP": "clamp"}
_FLIP_V = homogeneous(np.diag([1, -1, 1]), (0, 1, 0))


class Unsupported(Exception):
    """An input that Mitsuba's textures can't express."""


def is_link(value):
    return isinstance(value, dict)


def links_of(node):
    """Returns the links of a node's inputs."""
    values = [*node["inputs"].values(), *node.get("values", ()), *node.get("shaders", ())]
    return [value for value in values if is_link(value)]


def nodes_below(node):
    """Returns a node and all nodes that it depends on, each once, in the order of its inputs."""
    found, waiting = {}, [node]
    while waiting:
        one = waiting.pop()
        if id(one) not in found:
            found[id(one)] = one
            waiting += [link["node"] for link in reversed(links_of(one))]
    return list(found.values())


def luminance(color):
    return 0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]


def as_color(value):
    return [float(value)] * 3 if np.isscalar(value) else [float(c) for c in value[:3]]


def as_number(value):
    return float(value) if np.isscalar(value) else float(luminance(value))


class Inputs:
    """Inputs of the nodes of one material or of the world. `files` is a files.Files."""

    def __init__(self, kind, name, files, report):
        self.owner, self.name = f"{kind} '{name}'", name  # in warnings, and in names of files
        self.files, self.report = files, report

    def color(self, name, value):
        """Returns the element of a colour or of a texture, with the given name."""
        return self._element(name, value, lambda v: e.rgb(name, as_color(v)))

    def number(self, name, value, map=lambda x: x):
        """Returns the element of a number or of a texture. Only numbers are mapped."""
        return self._element(name, value, lambda v: e.floating(name, map(as_number(v))))

    def constant(self, label, value):
        """Returns a number or a colour. A texture is replaced by its default, with a warning."""
        if not is_link(value):
            return value
        folded = fold(value)
        if not is_link(folded):
            return folded
        self.report.warn(self.owner, f"'{label}' can't have a texture; the value "
                                     f"{_text(value['default'])} is used")
        return value["default"]

    def _element(self, name, value, constant):
        value = fold(value)
        if not is_link(value):
            return constant(value)
        try:
            return e.named(self.texture(value), name)
        except Unsupported as problem:
            self.report.warn(self.owner, f"{problem}; the value {_text(value['default'])} is used")
            return constant(value["default"])

    def texture(self, link):
        node = link["node"]
        kind = node["type"]
        if kind == "TEX_IMAGE":
            return self._image(node, link["output"])
        if kind == "TEX_CHECKER":
            return self._checker(node)
        if kind in ("VERTEX_COLOR", "ATTRIBUTE"):
            if not node["is_color"]:
                raise Unsupported(f"node '{node['name']}' reads the attribute '{node['attribute']}', "
                                  "which isn't a colour of the mesh")
            return e.plugin("texture", "mesh_attribute", e.string("name", "vertex_color"))
        return self._baked(link)

    def _baked(self, link):
        from .baking import bake  # which needs this module
        texels, node = bake(link, self.files.pixels)
        name = f"{self.name}-{link['node']['name']}"
        return self._bitmap(node, self.files.baked(name, texels), raw=False)

    def _image(self, node, output):
        if output != "Color":
            return self._baked({"node": node, "output": output})
        return self._bitmap(node, self.files.image(node), node["is_data"])

    def _bitmap(self, node, filename, raw):
        if node["projection"] != "FLAT":
            raise Unsupported(f"projection {node['projection']} of node '{node['name']}' is unsupported")
        if node["extension"] == "CLIP":
            self.report.warn(self.owner, f"the image of node '{node['name']}' is extended instead of clipped")
        to_uv = self._to_uv(node, is_image=True)
        return e.plugin(
            "texture", "bitmap", e.string("filename", filename), e.boolean("raw", True) if raw else None,
            e.string("filter_type", "nearest") if node["interpolation"] == "Closest" else None,
            e.string("wrap_mode", _WRAP[node["extension"]]) if node["extension"] != "REPEAT" else None,
            to_uv)

    def _checker(self, node):
        inputs = node["inputs"]
        scale = as_number(self.constant("Scale", inputs["Scale"])) / 2
        to_uv = self._to_uv(node, is_image=False, scale=scale)
        # Cycles has Color1 where the sum of the squares' numbers is odd, Mitsuba color0 where it is even.
        return e.plugin("texture", "checkerboard", self.color("color0", inputs["Color2"]),
                        self.color("color1", inputs["Color1"]), to_uv)

    def _to_uv(self, node, is_image, scale=1.0):
        """Returns the transform of texture coordinates; None for the identity. Meshes are exported with
        v downwards, because the rows of Mitsuba's images count downwards."""
        matrix = homogeneous(np.diag([scale, scale, 1])) @ self._mapping(node, is_image)
        matrix = (_FLIP_V if is_image else np.eye(4)) @ matrix @ _FLIP_V
        return None if np.allclose(matrix, np.eye(4)) else e.transform("to_uv", matrix)

    def _mapping(self, node, is_image):
        vector = node["inputs"].get("Vector")
        if not is_link(vector):
            if is_image:
                return np.eye(4)
            raise Unsupported(f"node '{node['name']}' without texture coordinates is unsupported; "
                              "connect the output UV")
        source = vector["node"]
        if source["type"] == "MAPPING":
            return self.mapping_matrix(source) @ self._mapping(source, is_image)
        if source["type"] == "UVMAP" or (source["type"] == "TEX_COORD" and vector["output"] == "UV"):
            return np.eye(4)
        raise Unsupported(f"texture coordinates '{vector['output']}' of node '{source['name']}' are unsupported")

    def mapping_matrix(self, node):
        values = {name: as_color(self.constant(name, node["inputs"].get(name, default)))
                  for name, default in (("Location", [0] * 3), ("Rotation", [0] * 3), ("Scale", [1] * 3))}
        rotation, scale = euler_xyz(values["Rotation"]), np.diag(values["Scale"])
        if node["vector_type"] == "POINT":
            return homogeneous(rotation @ scale, values["Location"])
        if node["vector_type"] == "TEXTURE":
            return np.linalg.inv(homogeneous(rotation @ scale, values["Location"]))
        return homogeneous(rotation @ scale)


def fold(value):
    """Replaces a link by its value if no image is below it."""
    if not is_link(value):
        return value
    node = value["node"]
    if node["type"] in ("RGB", "VALUE"):
        return node["value"]
    if node["type"] == "BLACKBODY" and not is_link(node["inputs"]["Temperature"]):
        return blackbody(as_number(node["inputs"]["Temperature"]))
    from .baking import constant  # which needs this module
    result = constant(value)
    return value if result is None else result


def multiplied(value, factor):
    """Returns an input multiplied by a colour, which must be a list of three numbers. Textures are baked."""
    if all(abs(f - 1) < 1e-3 for f in factor):
        return value
    folded = fold(value)
    if not is_link(folded):
        return [c * f for c, f in zip(as_color(folded), factor)]
    product = {"type": "MIX", "name": value["node"]["name"], "data_type": "RGBA", "blend_type": "MULTIPLY",
               "clamp_result": False, "inputs": {"Factor": 1.0, "A": value, "B": list(factor)}}
    default = [c * f for c, f in zip(as_color(value.get("default", [1, 1, 1])), factor)]
    return {"node": product, "output": "Result", "default": default}


def blackbody(kelvin):
    """Linear colour of a black body with luminance 1, from Planck's law and the CIE's 1931 observer in
    the approximation of Wyman et al. 2013, "Simple Analytic Approximations to the CIE XYZ Color
    Matching Functions"."""
    nm = np.arange(380.0, 781.0, 5.0)

    def lobe(mean, below, above):
        return np.exp(-0.5 * ((nm - mean) / np.where(nm < mean, below, above)) ** 2)
    x = 1.056 * lobe(599.8, 37.9, 31.0) + 0.362 * lobe(442.0, 16.0, 26.7) - 0.065 * lobe(501.1, 20.4, 26.2)
    y = 0.821 * lobe(568.8, 46.9, 40.5) + 0.286 * lobe(530.9, 16.3, 31.1)
    z = 1.217 * lobe(437.0, 11.8, 36.0) + 0.681 * lobe(459.0, 26.0, 13.8)
    planck = nm**-5 / np.expm1(1.438777e7 / (nm * kelvin))
    xyz = np.array([np.sum(planck * curve) for curve in (x, y, z)])
    rgb = np.array([[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560],
                    [0.0556434, -0.2040259, 1.0572252]]) @ xyz
    return [float(max(c, 0)) for c in rgb / xyz[1]]


def _text(value):
    return e.number(value) if np.isscalar(value) else e.numbers(as_color(value))
