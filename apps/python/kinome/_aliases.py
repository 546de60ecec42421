"""Parameters of Mitsuba that combine several of Kinome's parameters, or are computed from them."""
import math

import numpy as np

from . import _arguments as check
from . import _kinome
from ._errors import Error
from ._values import to_python

PAIRS = {"size": ("width", "height"), "crop_size": ("crop_width", "crop_height"),
         "crop_offset": ("crop_offset_x", "crop_offset_y")}
CONDUCTORS = "bsdf/conductor", "bsdf/roughconductor"
INDEX = "eta", "k"  # of conductors, whose `material` sets both
UNSET = object()  # value of an edit that unsets a parameter
REVERTED = object()  # value of an edit that restores a parameter
DEFAULT_SIZE = 768, 576  # of films
HALF_DIAGONAL = math.hypot(36, 24) / 2  # of a 35 mm film in mm, to which focal_length refers


def _exists(editor, path):
    try:
        editor.get(path)
    except Error:
        return False
    return True


def measured(editor, path):
    """Returns the colour that a conductor's `material` gives to eta or k. Returns None for other
    paths, and for conductors without a material."""
    owner, _, name = path.removesuffix(".value").rpartition(".")
    if name not in INDEX or not all(_exists(editor, f"{owner}.{part}")
                                    for part in ("material", *INDEX)):
        return None
    material = editor.get(f"{owner}.material")
    index = _kinome.measured_index(material) if isinstance(material, str) else None
    return None if index is None else np.array(index[INDEX.index(name)], np.float32)


def is_alias(editor, path):
    """Returns True for the path of such a parameter."""
    if measured(editor, path) is not None:
        return True
    owner, _, name = path.rpartition(".")
    if name in ("x_fov", "shutter_open_time"):
        part = "fov_axis" if name == "x_fov" else "shutter_close"
        return _exists(editor, f"{owner}.{part}") and not _exists(editor, path)
    if name == "eta":
        return not _exists(editor, path) and all(_exists(editor, f"{owner}.{part}")
                                                 for part in ("int_ior", "ext_ior"))
    return name in PAIRS and not _exists(editor, path) and all(
        _exists(editor, f"{owner}.{part}") for part in PAIRS[name])


def get(editor, path):
    """Returns the value of an alias."""
    color = measured(editor, path)
    if color is not None:
        return color
    owner, _, name = path.rpartition(".")
    if name == "x_fov":
        return _x_fov(editor, owner)
    if name == "shutter_open_time":
        return editor.get(f"{owner}.shutter_close") - editor.get(f"{owner}.shutter_open")
    if name == "eta":
        return _eta(editor, owner)
    values = [editor.get(f"{owner}.{part}") for part in PAIRS[name]]
    if name == "crop_size":
        values = [whole if part is None else part
                  for part, whole in zip(values, get(editor, f"{owner}.size").tolist())]
    return np.array(values)


def values(editor, path, value, others=()):
    """Returns pairs of paths and values, which set the alias. `others` are the values of other paths
    that are set at the same time."""
    if measured(editor, path) is not None:
        return _index_values(editor, path, value, others)
    owner, _, name = path.rpartition(".")
    if name == "x_fov":
        return [(f"{owner}.focal_length", UNSET), (f"{owner}.fov", check.positive(value, path)),
                (f"{owner}.fov_axis", "x")]
    if name == "shutter_open_time":
        opened = editor.get(f"{owner}.shutter_open")
        return [(f"{owner}.shutter_close", opened + check.real(value, path))]
    if name == "eta":
        return [(f"{owner}.int_ior", check.positive(value, path)), (f"{owner}.ext_ior", 1.)]
    array = np.asarray(value)
    if array.shape != (2,):
        raise check.fault(TypeError, path, "two whole numbers", value)
    return [(f"{owner}.{part}", check.whole(one, path, 0, 2 ** 31 - 1))
            for part, one in zip(PAIRS[name], array.tolist())]


def _index_values(editor, path, value, others):
    """Returns pairs of paths and values, which set eta or k in place of a conductor's material."""
    if not isinstance(value, dict) and np.array_equal(value, measured(editor, path)):
        return []
    owner, _, name = path.removesuffix(".value").rpartition(".")
    other = f"{owner}.{INDEX[1 - INDEX.index(name)]}"
    kept = others.get(other, others.get(f"{other}.value")) if others else None
    kept = measured(editor, other) if kept is None else kept
    return [(f"{owner}.material", UNSET), (other, kept), (f"{owner}.{name}", value)]


def material_values(editor, path, value):
    """Returns pairs of paths and values, which set a conductor's material in place of eta and k. Returns
    None for other paths, and for the material that the conductor has."""
    owner, _, name = path.rpartition(".")
    if name != "material" or not _is_new_material(editor, owner, value):
        return None
    return [*((f"{owner}.{part}", UNSET) for part in INDEX), (path, value)]


def is_replaced(editor, path, value, others):
    """Returns True for the current eta or k of a conductor that gets another material at the same time.
    `others` are the values of all paths that are set."""
    owner, _, name = path.removesuffix(".value").rpartition(".")
    if name not in INDEX or not _is_new_material(editor, owner, others.get(f"{owner}.material")):
        return False
    return _exists(editor, path) and np.array_equal(value, to_python(editor.get(path)))


def _is_new_material(editor, owner, value):
    """Returns True if `owner` is a conductor of another material."""
    try:
        return (isinstance(value, str) and editor.plugin(owner) in CONDUCTORS and
                value != editor.get(f"{owner}.material"))
    except Error:
        return False


def _eta(editor, bsdf):
    """Returns the relative index of refraction."""
    inside, outside = (editor.get(f"{bsdf}.{part}") for part in ("int_ior", "ext_ior"))
    if not isinstance(inside, str) and not isinstance(outside, str):
        return inside / outside
    index = editor.relative_index(bsdf)  # 1 if the surface reflects only
    if index == 1:
        text = f"{bsdf}.eta is unknown, because int_ior or ext_ior is a name: read these"
        raise Error(text, text, "", 0, 0)
    return index


def _x_fov(editor, sensor):
    """Returns the horizontal field of view in degrees."""
    film = editor.parts(sensor).get("film")
    width, height = get(editor, f"{film}.size").tolist() if film else DEFAULT_SIZE
    of_diagonal = width / math.hypot(width, height)
    fov = editor.get(f"{sensor}.fov")
    if fov is None:
        focal_length = float(editor.get(f"{sensor}.focal_length").removesuffix("mm"))
        tangent = HALF_DIAGONAL / focal_length * of_diagonal
    else:
        axis = editor.get(f"{sensor}.fov_axis")
        if axis in ("smaller", "larger"):
            axis = "x" if (width < height) == (axis == "smaller") else "y"
        factor = {"x": 1, "y": width / height, "diagonal": of_diagonal}[axis]
        tangent = math.tan(math.radians(fov) / 2) * factor
    return math.degrees(2 * math.atan(tangent))
