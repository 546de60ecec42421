"""Converts the nodes of a material, given as dictionaries, to a BSDF and an area emitter."""
from dataclasses import dataclass, field
from typing import Optional
import xml.etree.ElementTree as ET

from . import elements as e, principled
from .textures import Inputs, as_color, as_number, fold, is_link, multiplied

_DEFAULT_COLOR = [0.8, 0.8, 0.8]


@dataclass
class Material:
    bsdf: Optional[ET.Element] = None    # None if the surface only emits light
    radiance: Optional[ET.Element] = None  # named 'radiance'; None if the surface emits no light
    transmits: bool = False
    is_clear: bool = False               # lets light pass without a change
    # Pairs of a weight and a BSDF whose sum `bsdf` is, if it is a blend with constant weights.
    parts: list = field(default_factory=list)


def material(name, node, files, report, ids=None):
    """Converts the node that is connected to the output of a material. `node` may be None. `ids` are the
    elements.Names of the scene, for BSDFs of nodes with several links."""
    converter = _Converter(Inputs("material", name, files, report))
    result = converter.surface(node) if node else Material()
    if result.bsdf is None:
        result.bsdf = converter.diffuse([0, 0, 0])
    ids = ids or e.Names()
    e.share_bsdfs(result.bsdf, lambda: ids.unique(f"mat-{name}-part"))
    return result


class _Converter:
    def __init__(self, inputs):
        self.inputs = inputs
        self.warn = lambda message: inputs.report.warn(inputs.owner, message)
        self._surfaces = {}  # by id() of the node

    def surface(self, node):
        """Returns the Material of a node. That of a node with several links is the same object in all of them:
        there may be exponentially many ways to a node."""
        if id(node) not in self._surfaces:
            self._surfaces[id(node)] = self._convert(node)
        return self._surfaces[id(node)]

    def _convert(self, node):
        convert = getattr(self, "_" + node["type"].lower(), None)
        if convert is not None:
            return convert(node, node["inputs"])
        color = node["inputs"].get("Color", _DEFAULT_COLOR)
        self.warn(f"node '{node['name']}' ({node['type']}) is unsupported; a diffuse surface is used")
        return Material(self.diffuse(color))

    def diffuse(self, color):
        return _two_sided(e.plugin("bsdf", "diffuse", self.inputs.color("reflectance", color)))

    def _bsdf_principled(self, node, values):
        principled.check(values, self.inputs)
        share, rest = principled.share_of_glass(values, self.inputs)
        is_constant = not is_link(share)
        bsdf = None
        if not is_constant or share > 0:
            bsdf = self._bumped(principled.glass(values, self.inputs), values)
        if not is_constant or share < 1:
            opaque = self._opaque(rest)
            bsdf = opaque if bsdf is None else \
                e.plugin("bsdf", "blendbsdf", self.inputs.number("weight", share), opaque, bsdf)
        result = Material(bsdf, self._radiance(values["Emission Color"], values["Emission Strength"]),
                          not is_constant or share > 0)
        alpha = fold(values["Alpha"])
        if is_link(alpha) or alpha < 1:
            result.bsdf = e.plugin("bsdf", "mask", self.inputs.number("opacity", alpha), bsdf)
            result.transmits = True
        return result

    def _opaque(self, values):
        found = principled.opaque(values, self.inputs)
        if not isinstance(found, list):
            return _two_sided(self._bumped(found, values))
        first, second = (_two_sided(self._bumped(bsdf, values)) for bsdf in found[:2])
        return e.plugin("bsdf", "blendbsdf", e.floating("weight", found[2]), first, second)

    def _bsdf_diffuse(self, node, values):
        if as_number(self.inputs.constant("Roughness", values["Roughness"])) > 0:
            self.warn(f"the roughness of node '{node['name']}' is left out")
        bsdf = e.plugin("bsdf", "diffuse", self.inputs.color("reflectance", values["Color"]))
        return Material(_two_sided(self._bumped(bsdf, values)))

    def _bsdf_glossy(self, node, values):
        bsdf = e.plugin("bsdf", "roughconductor", e.string("material", "none"),
                        e.string("distribution", "ggx"), self._alpha(values),
                        self.inputs.color("specular_reflectance", values["Color"]))
        if not is_link(values["Anisotropy"]) and values["Anisotropy"] != 0:
            self.warn(f"the anisotropy of node '{node['name']}' is left out")
        return Material(_two_sided(self._bumped(bsdf, values)))

    def _bsdf_glass(self, node, values):
        ior = as_number(self.inputs.constant("IOR", values["IOR"]))
        roughness = fold(values["Roughness"])
        colors = [self.inputs.color(f"specular_{what}", values["Color"])
                  for what in ("reflectance", "transmittance")]
        if not is_link(roughness) and roughness**2 < 1e-3:
            bsdf = e.plugin("bsdf", "dielectric", e.floating("int_ior", ior), *colors)
        else:
            bsdf = e.plugin("bsdf", "roughdielectric", e.string("distribution", "ggx"),
                            self._alpha(values), e.floating("int_ior", ior), *colors)
        if is_link(values.get("Normal")):
            self.warn(f"the normal of node '{node['name']}' is left out")
        return Material(bsdf, None, True)

    def _bsdf_transparent(self, node, values):
        color = self.inputs.constant("Color", values["Color"])
        clear = e.plugin("bsdf", "null")
        opacity = 1 - sum(as_color(color)) / 3
        if max(as_color(color)) - min(as_color(color)) > 1e-3:
            self.warn(f"the colour of node '{node['name']}' becomes grey")
        if opacity <= 1e-4:
            return Material(clear, None, True, True)
        return Material(e.plugin("bsdf", "mask", e.floating("opacity", opacity), self.diffuse([0, 0, 0])), None, True)

    def _emission(self, node, values):
        return Material(None, self._radiance(values["Color"], values["Strength"]))

    def _add_shader(self, node, values):
        first, second = self._shaders(node)
        if first.bsdf is not None and second.bsdf is not None:
            self.warn(f"the sum of node '{node['name']}' is exported without its second BSDF")
        if first.radiance is not None and second.radiance is not None:
            self.warn(f"the sum of node '{node['name']}' is exported without its second emission")
        return Material(first.bsdf if first.bsdf is not None else second.bsdf,
                        first.radiance if first.radiance is not None else second.radiance,
                        first.transmits or second.transmits)

    def _mix_shader(self, node, values):
        first, second = self._shaders(node)
        if first is second:
            return first
        fraction = fold(values["Fac"])
        radiance = self._mixed_radiance(node, first, second, fraction)
        a, b = (m.bsdf if m.bsdf is not None else self.diffuse([0, 0, 0]) for m in (first, second))
        if first.is_clear != second.is_clear:
            opaque = b if first.is_clear else a
            if first.is_clear or not is_link(fraction):
                opacity = fraction if first.is_clear else 1 - fraction
                bsdf = e.plugin("bsdf", "mask", self.inputs.number("opacity", opacity), opaque)
                return Material(bsdf, radiance, True)
        bsdf, parts = e.plugin("bsdf", "blendbsdf", self.inputs.number("weight", fraction), a, b), []
        if not is_link(fraction):
            share = min(max(as_number(fraction), 0.), 1.)
            both = _weighted(first.parts or [(1., a)], 1 - share) + _weighted(second.parts or [(1., b)], share)
            parts = _merged(both)
            if len(parts) < len(both):
                bsdf = _sum(parts)
        return Material(bsdf, radiance, first.transmits or second.transmits, parts=parts)

    def _mixed_radiance(self, node, first, second, fraction):
        if first.radiance is None and second.radiance is None:
            return None
        result = first.radiance if first.radiance is not None else second.radiance
        share = 1 - as_number(self.inputs.constant("Fac", fraction)) if result is first.radiance \
            else as_number(self.inputs.constant("Fac", fraction))
        if result.tag != "rgb" or (first.radiance is not None and second.radiance is not None):
            self.warn(f"the emission that node '{node['name']}' mixes is exported at full strength")
            return result
        return e.rgb("radiance", [share * float(c) for c in result.get("value").split()])

    def _shaders(self, node):
        return [self.surface(shader["node"]) if is_link(shader) else Material()
                for shader in node["shaders"]]

    def _alpha(self, values):
        return self.inputs.number("alpha", self._untextured("Roughness", values["Roughness"]),
                                  lambda roughness: max(roughness**2, 1e-4))

    def _untextured(self, label, value):
        return self.inputs.constant(label, value)

    def _radiance(self, color, strength):
        strength = as_number(self.inputs.constant("Emission Strength", strength))
        color = fold(color)
        if strength <= 0 or (not is_link(color) and not any(c > 0 for c in as_color(color))):
            return None
        return self.inputs.color("radiance", multiplied(color, [strength] * 3))

    def _bumped(self, bsdf, values):
        """Nests a BSDF in `normalmap` or `bumpmap` if its normal is connected."""
        normal = values.get("Normal")
        if not is_link(normal):
            return bsdf
        node = normal["node"]
        try:
            if node["type"] == "NORMAL_MAP":
                return self._normal_map(node, bsdf)
            if node["type"] == "BUMP":
                return self._bump(node, bsdf)
        except KeyError:
            pass
        self.warn(f"the normal from node '{node['name']}' ({node['type']}) is left out")
        return bsdf

    def _normal_map(self, node, bsdf):
        if node["space"] != "TANGENT":
            self.warn(f"the normal map '{node['name']}' is left out: its space must be 'Tangent Space'")
            return bsdf
        if abs(as_number(self.inputs.constant("Strength", node["inputs"]["Strength"])) - 1) > 1e-3:
            self.warn(f"the normal map '{node['name']}' is exported with strength 1")
        color = fold(node["inputs"]["Color"])
        return e.plugin("bsdf", "normalmap", self.inputs.color("normalmap", color), bsdf) \
            if is_link(color) else bsdf

    def _bump(self, node, bsdf):
        height = fold(node["inputs"]["Height"])
        if not is_link(height):
            return bsdf
        scale = as_number(self.inputs.constant("Strength", node["inputs"]["Strength"])) * \
            as_number(self.inputs.constant("Distance", node["inputs"]["Distance"])) * (-1 if node["invert"] else 1)
        return e.plugin("bsdf", "bumpmap", self.inputs.number("texture", height), e.floating("scale", scale), bsdf)


def _weighted(parts, factor):
    return [(weight * factor, bsdf) for weight, bsdf in parts]


def _merged(parts):
    """Adds the weights of equal BSDFs. A renderer would otherwise evaluate them once for each path through
    the nodes."""
    merged = {}
    for weight, bsdf in parts:
        before, _ = merged.get(id(bsdf), (0., None))
        merged[id(bsdf)] = before + weight, bsdf
    return list(merged.values())


def _sum(parts):
    """Returns the sum of BSDFs with weights as nested blends."""
    parts = [part for part in parts if part[0] > 0]
    total, result = parts[0]
    for weight, bsdf in parts[1:]:
        total += weight
        result = e.plugin("bsdf", "blendbsdf", e.floating("weight", weight / total), result, bsdf)
    return result


def _two_sided(bsdf):
    return e.plugin("bsdf", "twosided", bsdf)
