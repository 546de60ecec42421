"""Parameters of Mitsuba that combine several of Kinome's parameters, or are computed from them."""
import math

import numpy as np

from . import _arguments as check
from ._errors import Error

PAIRS = {"size": ("width", "height"), "crop_size": ("crop_width", "crop_height"),
         "crop_offset": ("crop_offset_x", "crop_offset_y")}
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


def is_alias(editor, path):
    """Returns True for the path of such a parameter."""
    owner, _, name = path.rpartition(".")
    if name in ("x_fov", "shutter_open_time"):
        part = "fov_axis" if name == "x_fov" else "shutter_close"
        return _exists(editor, f"{owner}.{part}") and not _exists(editor, path)
    return name in PAIRS and not _exists(editor, path) and all(
        _exists(editor, f"{owner}.{part}") for part in PAIRS[name])


def get(editor, path):
    """Returns the value of an alias."""
    owner, _, name = path.rpartition(".")
    if name == "x_fov":
        return _x_fov(editor, owner)
    if name == "shutter_open_time":
        return editor.get(f"{owner}.shutter_close") - editor.get(f"{owner}.shutter_open")
    values = [editor.get(f"{owner}.{part}") for part in PAIRS[name]]
    if name == "crop_size":
        values = [whole if part is None else part
                  for part, whole in zip(values, get(editor, f"{owner}.size").tolist())]
    return np.array(values)


def values(editor, path, value):
    """Returns pairs of paths and values, which set the alias."""
    owner, _, name = path.rpartition(".")
    if name == "x_fov":
        return [(f"{owner}.focal_length", UNSET), (f"{owner}.fov", check.positive(value, path)),
                (f"{owner}.fov_axis", "x")]
    if name == "shutter_open_time":
        opened = editor.get(f"{owner}.shutter_open")
        return [(f"{owner}.shutter_close", opened + check.real(value, path))]
    array = np.asarray(value)
    if array.shape != (2,):
        raise check.fault(TypeError, path, "two whole numbers", value)
    return [(f"{owner}.{part}", check.whole(one, path, 0, 2 ** 31 - 1))
            for part, one in zip(PAIRS[name], array.tolist())]


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
