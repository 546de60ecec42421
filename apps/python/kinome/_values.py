"""Conversion of values between Python and the compiled module (see apps/python/src/values.h)."""
import numpy as np

from ._color import srgb_to_linear
from ._transform import Transform

FLOAT_ARRAYS = ("vertex_positions", "vertex_normals", "vertex_texcoords")


def numbers(value):
    """Converts to an array of floats. Returns None if that is impossible."""
    try:
        return None if value is None else np.asarray(value, np.float64)
    except (TypeError, ValueError, OverflowError):
        return None


def pixels(value, where, raw=False):
    """Converts to an image of floats. Integers are scaled to [0, 1] by the largest value of their
    type, as in Mitsuba's Bitmap. Bytes (uint8), and a Bitmap with srgb_gamma(), are decoded from
    sRGB, unless `raw` is set."""
    is_encoded = value.srgb_gamma() if hasattr(value, "srgb_gamma") else None
    image = np.asarray(value)
    if image.dtype.kind not in "fiu" or image.ndim not in (2, 3):
        raise TypeError(f"{where}: expected pixels, numbers of the shape (height, width) or "
                        f"(height, width, channels), got {type(value).__name__}")
    kind = image.dtype
    if kind.kind in "iu" and kind.itemsize > 4:
        raise TypeError(f"{where}: pixels of the type {kind} have no scale; give uint8, uint16 or "
                        "uint32, whose largest value is 1, or floats: pixels.astype(numpy.float32)")
    if kind.kind in "iu":
        image = image / np.iinfo(kind).max
    if not raw and (kind == np.uint8 if is_encoded is None else is_encoded):
        image = srgb_to_linear(image)
    if image.ndim == 2:
        image = image[:, :, None]
    return "image", np.ascontiguousarray(image, np.float32)


def grid(value, where):
    """Converts a grid of voxels of the shape (z, y, x) or (z, y, x, channels). Returns an image of the
    rows of all slices, and the number of slices."""
    array = np.asarray(value)
    if array.dtype.kind not in "fiu" or array.ndim not in (3, 4) or array.size == 0:
        raise TypeError(f"{where}: expected a grid of numbers of the shape (z, y, x) or (z, y, x, "
                        f"channels), got {type(value).__name__} of the shape {array.shape}")
    if array.ndim == 3:
        array = array[..., None]
    slices, height, width, channels = array.shape
    rows = array.reshape(slices * height, width, channels)
    return ("grid", np.ascontiguousarray(rows, np.float32)), slices


def indices(value, where):
    """Converts to vertex indices. Raises an error for values that numpy would round or wrap."""
    array = np.asarray(value).ravel()
    limits = np.iinfo(np.uint32)
    is_fine = array.size == 0 or (np.issubdtype(array.dtype, np.integer) and
                                  array.min() >= limits.min and array.max() <= limits.max)
    if not is_fine:
        raise ValueError(f"{where}: vertex indices must be whole numbers from 0 to {limits.max}")
    return np.ascontiguousarray(array, np.uint32)


def to_core(value, name, where, raw=False):
    """Converts a value of the parameter `name` for the compiled module. `where` is for messages."""
    if name in ("data", "bitmap"):
        return pixels(value, where, raw)
    if name == "faces":
        return "indices", indices(value, where)
    if name in FLOAT_ARRAYS:
        array = numbers(value)
        if array is None:
            raise TypeError(f"{where}: expected an array of numbers, got {type(value).__name__}")
        return "floats", np.ascontiguousarray(array.ravel(), np.float32)
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        if not -2 ** 63 <= value < 2 ** 63:
            raise ValueError(f"{where}: {value} is too large")
        return int(value)
    if isinstance(value, str) or hasattr(value, "__fspath__"):
        return str(value)
    if hasattr(value, "matrix"):
        return "transform", Transform(value).matrix.ravel().tolist()
    array = numbers(value)
    if array is not None and array.size == 1:
        return float(array.ravel()[0])
    if array is not None and array.size == 3:
        return "vector", array.ravel().tolist()
    if array is not None and array.shape == (4, 4):
        return "transform", array.ravel().tolist()
    raise TypeError(f"{where}: expected a number, a string, three numbers, a 4x4 matrix or a dict, "
                    f"got {type(value).__name__}")


def to_python(value):
    """Converts a value of the compiled module to Python."""
    if not isinstance(value, tuple):
        return value
    kind, what = value
    if kind == "transform":
        return Transform(what)
    return np.array(what, np.float32) if kind in ("rgb", "vector") else what
