"""Denoising by Open Image Denoise."""
import importlib.util
import pathlib

import numpy as np

from . import _arguments as check
from . import _kinome
from ._color import luminance
from ._picture import Picture
from ._scene import MAX_THREADS


def _library():
    """Returns the folder of the library in the package pyoidn; "" if it isn't installed."""
    found = importlib.util.find_spec("pyoidn")
    if found is None or not found.submodule_search_locations:
        return ""
    return str(pathlib.Path(next(iter(found.submodule_search_locations))) / "oidn/lib")


def _layer(picture, name, given):
    """Returns the array that is given, or the picture's layer of that name, or None."""
    if given is None:
        if not any(channel.startswith(name + ".") for channel in picture.channels):
            return None
        given = picture[name]
    try:
        array = np.asarray(given, np.float32)
    except (TypeError, ValueError):
        takes = f"an array of the shape {(*picture.shape[:2], 3)}"
        raise check.fault(TypeError, name, takes, given) from None
    if array.ndim == 3 and array.shape[2] == 1:
        array = np.repeat(array, 3, axis=2)
    if array.shape != (*picture.shape[:2], 3):
        raise ValueError(f"{name} takes an array of the shape {(*picture.shape[:2], 3)}, got "
                         f"{array.shape}")
    return np.ascontiguousarray(array)


def denoise(picture, albedo=None, normal=None, variance=None, threads=0):
    """Denoises the colour of a Picture. Returns a Picture whose other channels are unchanged, and whose
    stats have "denoised": True.

    albedo, normal: arrays (height, width, 3) of surfaces seen in the picture; by default, the
    picture's layers of these names. `aov` renders them: "albedo:guide_albedo,normal:guide_normal".
    variance: that of the colour; by default, the layer of render(variance=4). With it, the result is
    combined with the noisy colour where that lowers the expected error. The film should have a box
    filter of one pixel (rfilter "box"). threads: 0 for one per core.

    Needs Open Image Denoise, for instance by `pip install pyoidn`.
    """
    check.instance(picture, "picture", Picture, "a Picture")
    if picture.size == 0:
        raise ValueError("picture has no pixels")
    noisy = picture.rgb
    color = np.ascontiguousarray(np.repeat(noisy, 3, axis=2) if noisy.shape[2] == 1 else noisy,
                                 np.float32)
    denoised = _kinome.denoise(color, _layer(picture, "albedo", albedo),
                               _layer(picture, "normal", normal),
                               _layer(picture, "variance", variance),
                               check.whole(threads, "threads", 0, MAX_THREADS), _library())
    result = picture.copy() if picture.dtype.kind == "f" else picture.astype(np.float32)
    count = noisy.shape[2]
    result.view(np.ndarray)[:, :, :count] = (
        denoised if count == 3 else luminance(denoised)[..., None])
    result.stats["denoised"] = True
    return result
