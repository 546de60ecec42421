"""Python's values, and what the compiled module takes in their place (see python/src/values.h)."""
import numpy as np

from ._transform import Transform

ARRAYS = {"vertex_positions": np.float32, "vertex_normals": np.float32,
          "vertex_texcoords": np.float32, "faces": np.uint32}


def pixels(value, raw=False):
    """An image of floats. Bytes stand for sRGB-encoded values, unless they are `raw`."""
    image = np.asarray(value)
    is_bytes = image.dtype == np.uint8
    image = image.astype(np.float32)
    if is_bytes:
        image /= 255
        if not raw:
            image = np.where(image <= 0.04045, image / 12.92, ((image + 0.055) / 1.055) ** 2.4)
    if image.ndim == 2:
        image = image[:, :, None]
    return "image", np.ascontiguousarray(image, np.float32)


def to_core(value, name, where, raw=False):
    """`name`: of the parameter; `where`: for messages."""
    if name in ("data", "bitmap"):
        return pixels(value, raw)
    if name in ARRAYS:
        kind = "indices" if name == "faces" else "floats"
        return kind, np.ascontiguousarray(np.asarray(value).ravel(), ARRAYS[name])
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, str) or hasattr(value, "__fspath__"):
        return str(value)
    if hasattr(value, "matrix"):
        return "transform", Transform(value).matrix.ravel().tolist()
    try:
        array = np.asarray(value, np.float64)
    except (TypeError, ValueError):
        array = None
    if array is not None and array.size == 1:
        return float(array.ravel()[0])
    if array is not None and array.size == 3:
        return "vector", array.ravel().tolist()
    if array is not None and array.shape == (4, 4):
        return "transform", array.ravel().tolist()
    raise TypeError(f"{where}: {type(value).__name__} is no value of a parameter: expected a "
                    "number, a string, three numbers, a 4x4 matrix or a dict")


def to_python(value):
    """The other way round."""
    if not isinstance(value, tuple):
        return value
    kind, what = value
    if kind == "transform":
        return Transform(what)
    return np.array(what, np.float32) if kind in ("rgb", "vector") else what
