"""Conversion of dicts in Mitsuba's form to the compiled module's descriptions of objects."""
import difflib

import numpy as np

from . import _kinome
from ._errors import Error
from ._values import grid, numbers, to_core

TAGS = ("bsdf", "emitter", "film", "integrator", "medium", "phase", "rfilter", "sampler", "sensor",
        "shape", "texture", "volume")


def fail(where, message):
    raise Error(f"{where}: {message}", message, where, 0, 0)


def tag_of(plugin, name, where):
    """Returns the category of a plugin. If several categories have a plugin of this name, prefers the
    one that is the object's name."""
    known = _kinome.plugin_names()
    found = [tag for tag in TAGS if plugin in known[tag]]
    if name in found:
        return name
    if not found:
        # The object's name is a category, so the core can suggest similar plugins of that category.
        if name in TAGS:
            return name
        near = difflib.get_close_matches(plugin, sorted(set().union(*known.values())), 1, 0.7)
        fail(where, f"there is no plugin '{plugin}'" +
             "".join(f" (did you mean '{one}'?)" for one in near))
    return found[0]


def spectrum(description, where):
    """Returns the text of a spectrum in XML."""
    value = description.get("value")
    if value is None:
        wavelengths, values = description.get("wavelengths"), description.get("values")
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
    """Returns three numbers from three, or from one for all channels."""
    channels = None if value is None else numbers(value)
    if channels is None or channels.shape not in ((), (1,), (3,)):
        fail(where, "an rgb needs a 'value' of three numbers, or of one")
    return np.broadcast_to(channels, 3).tolist()


def description_of(description, where):
    """Describes a dict that is set as a parameter: a texture, a reference, a BSDF or a colour."""
    kind = description.get("type")
    if kind == "rgb":
        return "rgb", colour(description.get("value"), where)
    if kind == "ref":
        if not isinstance(description.get("id"), str):
            fail(where, "a ref needs an 'id', a string")
        return "object", ("ref", "", "", description["id"], where, [], [])
    return "object", describe(description, "", where)


class Located(dict):
    """A dict whose position in messages is `where`, not its key in the enclosing dict."""

    def __init__(self, description, where):
        super().__init__(description)
        self.where = where


def describe(description, name="", where="scene", tag=None):
    """Describes an object. `name` is its key in the enclosing dict. `tag` is its category, if it is
    known."""
    where = getattr(description, "where", where)
    if hasattr(description, "as_dict"):
        description = description.as_dict()
    if not isinstance(description, dict) or not isinstance(description.get("type"), str):
        fail(where, "must be a dict with a 'type', a string")
    if not isinstance(description.get("id", ""), str):
        fail(where, "an 'id' is a string")
    plugin = description["type"]
    is_scene = plugin == "scene"
    tag = "scene" if is_scene else tag or tag_of(plugin, name, where)
    values, parts = [], []
    for key, value in description.items():
        if not isinstance(key, str):
            fail(where, f"keys must be strings, got {key!r}")
        place = f"{where}.{key}"
        if key in ("type", "id"):
            continue
        if hasattr(value, "as_dict"):
            value = value.as_dict()
        if not isinstance(value, dict):
            if plugin == "gridvolume" and key in ("data", "grid") and not isinstance(value, str):
                rows, slices = grid(value, place)
                values += [("data", rows, place), ("slices", slices, place)]
                continue
            is_pixels = key in ("data", "bitmap") and not isinstance(value, str)
            values.append(("data" if is_pixels else key,
                           to_core(value, key, place, description.get("raw", False)), place))
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
            # References use the keys of a scene as ids.
            parts.append((*part[:3], part[3] or key, *part[4:]) if is_scene else part)
    return tag, "" if is_scene else plugin, name, description.get("id", ""), where, values, parts
