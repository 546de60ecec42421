"""Evaluates nodes between images and a material's inputs for every texel, as Cycles does for every point.

All images below a baked input must have the same size, texture coordinates, extension and interpolation.
"""
import collections

import numpy as np

from .textures import Unsupported, is_link, links_of, luminance, nodes_below


def bake(link, pixels_of):
    """Returns the linear texels of an input, an array of rows from top to bottom, and the node of the
    image whose coordinates it has. pixels_of(node) returns an image's linear RGBA texels. Raises
    Unsupported if the input depends on other things than images."""
    evaluator = _Evaluator(pixels_of)
    values = evaluator.evaluate(link)
    if evaluator.image is None:
        raise Unsupported(f"node '{link['node']['name']}' ({link['node']['type']}) is unsupported")
    return np.broadcast_to(_color(values), (*evaluator.size, 3)), evaluator.image


def constant(link):
    """Returns the value of an input that depends on no image; None if it can't be evaluated."""
    def refuse(node):
        raise Unsupported(node["name"])
    try:
        value = _Evaluator(refuse).evaluate(link)
    except Unsupported:
        return None
    return float(value[0]) if len(value) == 1 else [float(c) for c in value]


# Values have one channel or three, in the last dimension. Texels have two dimensions before it.
def _color(value):
    return value * np.ones(3)


def _grey(value):
    return value if value.shape[-1] == 1 else luminance(np.moveaxis(value, -1, 0))[..., None]


def _factor(value):
    return np.clip(_grey(value), 0, 1)


def _key(link):
    return id(link["node"]), link["output"]


class _Evaluator:
    def __init__(self, pixels_of):
        self.pixels_of, self.image, self.size = pixels_of, None, None
        self.kept = {}  # results of outputs with several links, which may have many texels

    def evaluate(self, link):
        """Returns the value of an input. Evaluates each output once."""
        uses = collections.Counter()
        for node in nodes_below(link["node"]):
            uses.update(map(_key, links_of(node)))
        self.kept = {key: None for key, count in uses.items() if count > 1}
        return self.value(link)

    def value(self, link):
        if not is_link(link):
            return np.array([link] if np.isscalar(link) else link[:3], float)
        key = _key(link)
        if self.kept.get(key) is not None:
            return self.kept[key]
        node = link["node"]
        evaluate = getattr(self, "_" + node["type"].lower(), None)
        if evaluate is None:
            raise Unsupported(f"node '{node['name']}' ({node['type']}) is unsupported")
        result = evaluate(node, node["inputs"], link["output"])
        if key in self.kept:
            self.kept[key] = result
        return result

    def _tex_image(self, node, values, output):
        if self.image is not None and any(self.image.get(k) != node.get(k) for k in ("extension", "interpolation")) or \
                self.image is not None and self.image["inputs"].get("Vector") != values.get("Vector"):
            raise Unsupported(f"node '{node['name']}' is unsupported: its texture coordinates differ from those of "
                              f"node '{self.image['name']}'")
        texels = self.pixels_of(node)
        if self.image is not None and texels.shape[:2] != self.size:
            raise Unsupported(f"node '{node['name']}' is unsupported: its image's size differs from that of "
                              f"node '{self.image['name']}'")
        self.image, self.size = node, texels.shape[:2]
        return texels[..., 3:] if output == "Alpha" else texels[..., :3]

    def _rgb(self, node, values, output):
        return self.value(node["value"])

    _value = _rgb

    def _mix(self, node, values, output):
        if node["data_type"] not in ("RGBA", "FLOAT"):
            raise Unsupported(f"node '{node['name']}' (MIX of {node['data_type']}) is unsupported")
        kind = node["blend_type"] if node["data_type"] == "RGBA" else "MIX"
        return self._blend(node, kind, values["Factor"], values["A"], values["B"])

    def _mix_rgb(self, node, values, output):
        return self._blend(node, node["blend_type"], values["Fac"], values["Color1"], values["Color2"])

    def _blend(self, node, kind, factor, a, b):
        if kind not in _BLENDS:
            raise Unsupported(f"node '{node['name']}' (MIX, {kind}) is unsupported")
        t, a, b = _factor(self.value(factor)), _color(self.value(a)), _color(self.value(b))
        result = a + t * (_BLENDS[kind](a, b) - a)
        return np.clip(result, 0, 1) if node.get("clamp_result") or node.get("use_clamp") else result

    def _math(self, node, values, output):
        if node["operation"] not in _OPERATIONS:
            raise Unsupported(f"node '{node['name']}' (MATH, {node['operation']}) is unsupported")
        operands = [_grey(self.value(v)) for v in node["values"]]
        with np.errstate(divide="ignore", invalid="ignore"):
            result = np.nan_to_num(_OPERATIONS[node["operation"]](*operands), nan=0, posinf=0, neginf=0)
        return np.clip(result, 0, 1) if node["use_clamp"] else result

    def _valtorgb(self, node, values, output):
        table = np.asarray(node["ramp"])  # RGBA at equal distances from 0 to 1
        at = np.clip(_grey(self.value(values["Fac"])), 0, 1) * (len(table) - 1)
        channels = [np.interp(at, np.arange(len(table)), table[:, c]) for c in range(4)]
        return channels[3] if output == "Alpha" else np.concatenate(channels[:3], -1)

    def _invert(self, node, values, output):
        color = _color(self.value(values["Color"]))
        return color + _factor(self.value(values["Fac"])) * (1 - 2 * color)

    def _gamma(self, node, values, output):
        color, gamma = _color(self.value(values["Color"])), _grey(self.value(values["Gamma"]))
        return np.where(color > 0, np.maximum(color, 1e-30) ** gamma, color)

    def _brightcontrast(self, node, values, output):
        bright, contrast = (_grey(self.value(values[k])) for k in ("Bright", "Contrast"))
        return np.maximum(_color(self.value(values["Color"])) * (1 + contrast) + bright - 0.5 * contrast, 0)

    def _hue_sat(self, node, values, output):
        color = _color(self.value(values["Color"]))
        hue, saturation, brightness = (_grey(self.value(values[k])) for k in ("Hue", "Saturation", "Value"))
        h, s, v = _to_hsv(color)
        changed = _from_hsv((h + hue + 0.5) % 1, np.clip(s * saturation, 0, 1), v * brightness)
        return np.maximum(color + _factor(self.value(values["Fac"])) * (changed - color), 0)

    def _rgbtobw(self, node, values, output):
        return _grey(_color(self.value(values["Color"])))

    def _separate_color(self, node, values, output):
        if node["mode"] != "RGB":
            raise Unsupported(f"node '{node['name']}' (SEPARATE_COLOR, {node['mode']}) is unsupported")
        return _color(self.value(values["Color"]))[..., [("Red", "Green", "Blue").index(output)]]

    def _clamp(self, node, values, output):
        low, high = _grey(self.value(values["Min"])), _grey(self.value(values["Max"]))
        return np.clip(_grey(self.value(values["Value"])), low, high)


_BLENDS = {
    "MIX": lambda a, b: b,
    "MULTIPLY": lambda a, b: a * b,
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "SCREEN": lambda a, b: 1 - (1 - a) * (1 - b),
    "DARKEN": np.minimum,
    "LIGHTEN": np.maximum,
    "DIFFERENCE": lambda a, b: np.abs(a - b),
    "OVERLAY": lambda a, b: np.where(a < 0.5, 2 * a * b, 1 - 2 * (1 - a) * (1 - b)),
}
_OPERATIONS = {
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "MULTIPLY": lambda a, b: a * b,
    "DIVIDE": lambda a, b: a / b,
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "POWER": lambda a, b: a**b,
    "MINIMUM": np.minimum,
    "MAXIMUM": np.maximum,
    "SQRT": np.sqrt,
    "ABSOLUTE": np.abs,
}


def _to_hsv(color):
    high, low = color.max(-1, keepdims=True), color.min(-1, keepdims=True)
    chroma = high - low
    safe = np.where(chroma > 0, chroma, 1)
    r, g, b = (color[..., [c]] for c in range(3))
    hue = np.where(high == r, (g - b) / safe % 6, np.where(high == g, (b - r) / safe + 2, (r - g) / safe + 4)) / 6
    return np.where(chroma > 0, hue, 0), np.where(high > 0, chroma / np.where(high > 0, high, 1), 0), high


def _from_hsv(hue, saturation, value):
    shares = np.clip(np.abs((6 * hue + np.array([0, 4, 2])) % 6 - 3) - 1, 0, 1)
    return value * (1 - saturation * (1 - shares))
