"""Converts lights, given as dictionaries, to emitters. Blender's power is that of Cycles [W]."""
import math

import numpy as np

from . import elements as e
from .matrices import TURN_X, scales, scaling, without_scale


# Whole angle [rad] below which the cross-section of a spot's cone is small enough for an image.
_MAX_SIZE_WITH_TEXTURE = 2.9


def sphere_radiance(power, radius):
    """Radiance of a point light with a radius: a sphere that emits `power` [W/(m^2 sr)]."""
    return power / (4 * math.pi**2 * radius**2)


def point_intensity(power):
    """Intensity of a point light without a radius, or of a spot light [W/sr]."""
    return power / (4 * math.pi)


def area_radiance(power, area):
    """Radiance of an area light [W/(m^2 sr)]."""
    return power / (math.pi * area)


def spot_falloff(cosine, size, blend):
    """Cycles' factor on a spot light's intensity. `size` is the cone's whole angle [rad]."""
    edge = math.cos(size / 2)
    width = (1 - edge) * blend
    if width <= 0:
        return np.where(cosine > edge, 1.0, 0.0)
    t = np.clip((cosine - edge) / width, 0, 1)
    return t * t * (3 - 2 * t)


def falloff_image(size, blend, count=256):
    """Returns the factors on a spot light's intensity in the cross-section of its cone: rows of colours."""
    x = (2 * np.arange(count) + 1) / count - 1
    tangent2 = (x[:, None] ** 2 + x**2) * math.tan(size / 2) ** 2
    return spot_falloff(1 / np.sqrt(1 + tangent2), size, blend)[..., None] * np.ones(3)


def linear_falloff(size, blend, count=1024):
    """Returns the angles [rad] of a spot that decreases linearly with the angle, as Mitsuba's does,
    instead of Cycles' smooth step in the cosine: cutoff_angle and beam_width. The flux is the same,
    and the mean squared difference over directions is least."""
    edge = size / 2
    theta = (np.arange(count) + 0.5) / count * edge
    weight = np.sin(theta)
    smooth = spot_falloff(np.cos(theta), size, blend)
    if blend <= 0:
        return edge, edge
    flux = np.sum(weight * smooth)
    # The flux increases with the beam's width: a bisection for all cutoff angles at once.
    cutoff = np.linspace(0.5, 1, 51)[:, None] * edge
    low, high = np.zeros_like(cutoff), cutoff.copy()
    for _ in range(24):
        beam = (low + high) / 2
        ramp = np.clip((cutoff - theta) / np.maximum(cutoff - beam, 1e-9), 0, 1)
        is_narrow = np.sum(weight * ramp, axis=1, keepdims=True) < flux
        low, high = np.where(is_narrow, beam, low), np.where(is_narrow, high, beam)
    # Some cones have another flux even with a sharp or a fully blurred edge.
    is_equal = np.abs(np.sum(weight * ramp, axis=1) / flux - 1) < 1e-3
    error = np.where(is_equal, np.sum(weight * (ramp - smooth) ** 2, axis=1), np.inf)
    best = np.argmin(error)
    return float(cutoff[best, 0]), float(beam[best, 0])


def _area(light, color, report, owner):
    sx, sy, _ = scales(light["matrix"])
    is_round = light["shape"] in ("DISK", "ELLIPSE")
    x = light["size"] * sx
    y = (light["size_y"] if light["shape"] in ("RECTANGLE", "ELLIPSE") else light["size"]) * sy
    area = x * y * (math.pi / 4 if is_round else 1)
    if light["spread"] < math.pi - 1e-3:
        report.warn(owner, "the spread is left out; the light shines to all directions")
    power = light["energy"] if light["normalize"] else light["energy"] * area
    radiance = [c * area_radiance(power, area) for c in color]
    to_world = without_scale(light["matrix"]) @ TURN_X @ scaling(x / 2, y / 2, 1)
    return e.plugin("shape", "disk" if is_round else "rectangle", e.transform("to_world", to_world),
                    e.plugin("emitter", "area", e.rgb("radiance", radiance)), e.plugin("bsdf", "null"))


def _point(light, color):
    if light["radius"] <= 0:
        return e.plugin("emitter", "point", _position("position", light["matrix"]),
                        e.rgb("intensity", [c * point_intensity(light["energy"]) for c in color]))
    radiance = sphere_radiance(light["energy"], light["radius"])
    return e.plugin("shape", "sphere", _position("center", light["matrix"]),
                    e.floating("radius", light["radius"]),
                    e.plugin("emitter", "area", e.rgb("radiance", [c * radiance for c in color])),
                    e.plugin("bsdf", "null"))


def _position(name, matrix):
    x, y, z = (e.number(row[3]) for row in matrix[:3])
    return e.ET.Element("point", {"name": name, "x": x, "y": y, "z": z})


def _spot(light, color, files, report, owner):
    if light["radius"] > 0:
        report.warn(owner, f"the radius {e.number(light['radius'])} of a spot light is left out; "
                           "its shadows are sharp")
    size, blend = light["spot_size"], light["spot_blend"]
    texture = None
    if blend > 0 and size < _MAX_SIZE_WITH_TEXTURE:
        cutoff = beam = size / 2
        file = files.baked(f"spot-{math.degrees(size):.4g}-{blend:.4g}", falloff_image(size, blend), is_exact=True)
        texture = e.plugin("texture", "bitmap", e.string("filename", file), e.string("wrap_mode", "clamp"),
                           name="texture")
    else:
        cutoff, beam = linear_falloff(size, blend)
    intensity = point_intensity(light["energy"])
    return e.plugin("emitter", "spot", e.rgb("intensity", [c * intensity for c in color]),
                    e.floating("cutoff_angle", math.degrees(cutoff)),
                    e.floating("beam_width", 0.9999 * math.degrees(beam)), texture,
                    e.transform("to_world", without_scale(light["matrix"]) @ TURN_X))


def _sun(light, color, report, owner):
    if light["angle"] > math.radians(1.5):
        report.warn(owner, f"the angle of {e.number(math.degrees(light['angle']))} degrees is left out; "
                           "the shadows are sharp")
    return e.plugin("emitter", "directional", e.rgb("irradiance", [c * light["energy"] for c in color]),
                    e.transform("to_world", without_scale(light["matrix"]) @ TURN_X))


def light(light, files, report):
    """Returns the element of a light; None if it is black. `light` has Blender's parameters: type,
    name, matrix (to the world), color, energy (with the exposure and the strength of its nodes) and
    normalize, and those of its type."""
    owner = f"light '{light['name']}'"
    color = light["color"]
    if light["energy"] <= 0 or not any(c > 0 for c in color):
        return None
    if light["type"] == "AREA":
        return _area(light, color, report, owner)
    if light["type"] == "SUN":
        return _sun(light, color, report, owner)
    if not light["normalize"]:
        # Without normalization, Blender's energy is per area of the sphere's cross-section.
        report.warn(owner, "'Normalize' is assumed to be on")
    if light["type"] == "SPOT":
        return _spot(light, color, files, report, owner)
    return _point(light, color)
