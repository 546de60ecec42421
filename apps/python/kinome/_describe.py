"""Dicts in Mitsuba's form, as what the compiled module takes for an object of a scene."""
import numpy as np

from . import _kinome
from ._errors import Error
from ._values import numbers, to_core

TAGS = ("bsdf", "emitter", "film", "integrator", "rfilter", "sampler", "sensor", "shape", "texture")


def fail(where, message):
    raise Error(f"{where}: {message}", message, where, 0, 0)


def tag_of(plugin, name, where):
    """The category of a plugin; where there are several of this name, the one that the object is
    named after."""
    known = _kinome.plugin_names()
    found = [tag for tag in TAGS if plugin in known[tag]]
    if name in found:
        return name
    if not found:
        # The core says what there is instead, if it is told what was meant.
        if name in TAGS:
            return name
        fail(where, f"there is no plugin '{plugin}'")
    return found[0]


def spectrum(said, where):
    """The text that stands for it in XML."""
    value = said.get("value")
    if value is None:
        wavelengths, values = said.get("wavelengths"), said.get("values")
        if wavelengths is None or values is None:
            fail(where, "a spectrum needs a 'value'")
        if np.ndim(wavelengths) != 1 or np.shape(wavelengths) != np.shape(values):
            fail(where, "a spectrum needs as many 'values' as 'wavelengths'")
        value = list(zip(wavelengths, values))
    if np.ndim(value) == 0:
        return str(value)
    pairs = numbers(value)
    if pairs is None or pairs.ndim != 2 or pairs.shape[1] != 2:
        fail(where, "a spectrum's 'value' is a number, or pairs of a wavelength and a value")
    return ", ".join(f"{at!r}:{power!r}" for at, power in pairs.tolist())


def colour(value, where):
    """Three numbers, or one for all."""
    channels = None if value is None else numbers(value)
    if channels is None or channels.shape not in ((), (1,), (3,)):
        fail(where, "an rgb needs a 'value' of three numbers, or of one")
    return np.broadcast_to(channels, 3).tolist()


def description_of(said, where):
    """Of what is set as a parameter in place of a value: a texture, a reference, a BSDF, a colour."""
    kind = said.get("type")
    if kind == "rgb":
        return "rgb", colour(said.get("value"), where)
    if kind == "ref":
        if not isinstance(said.get("id"), str):
            fail(where, "a ref needs an 'id', a string")
        return "object", ("ref", "", "", said["id"], where, [], [])
    return "object", describe(said, "", where)


def describe(said, name="", where="scene", tag=None):
    """`name`: the key that it has in the dict around it; `tag`: what it must be, if known."""
    if not isinstance(said, dict) or not isinstance(said.get("type"), str):
        fail(where, "must be a dict with a 'type', a string")
    if not isinstance(said.get("id", ""), str):
        fail(where, "an 'id' is a string")
    plugin = said["type"]
    is_scene = plugin == "scene"
    tag = "scene" if is_scene else tag or tag_of(plugin, name, where)
    values, parts = [], []
    for key, value in said.items():
        if not isinstance(key, str):
            fail(where, f"keys are strings, {key!r} is none")
        place = f"{where}.{key}"
        if key in ("type", "id"):
            continue
        if not isinstance(value, dict):
            is_pixels = key in ("data", "bitmap") and not isinstance(value, str)
            values.append(("data" if is_pixels else key,
                           to_core(value, key, place, said.get("raw", False)), place))
            continue
        kind = value.get("type")
        if kind == "rgb":
            values.append((key, ("rgb", colour(value.get("value"), place)), place))
        elif kind == "spectrum":
            parts.append(("spectrum", spectrum(value, place), key, "", place, [], []))
        elif kind == "ref":
            if not isinstance(value.get("id"), str):
                fail(place, "a ref needs an 'id', a string")
            parts.append(("ref", "", "" if is_scene else key, value["id"], place, [], []))
        else:
            part = describe(value, key, place)
            # In a scene, keys are what others refer to.
            parts.append((*part[:3], part[3] or key, *part[4:]) if is_scene else part)
    return tag, "" if is_scene else plugin, name, said.get("id", ""), where, values, parts
