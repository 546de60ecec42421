"""Formats of pixels, and conversions between them."""
import enum

import numpy as np

LUMINANCE = np.array([0.212671, 0.715160, 0.072169])  # of linear Rec.709
TO_XYZ = np.array([[0.412453, 0.357580, 0.180423], LUMINANCE, [0.019334, 0.119193, 0.950227]])


class Struct:
    """Namespace of the types of components."""

    class Type(enum.Enum):
        """Type of a component, with the name of the numpy type as its value."""
        UInt8 = "uint8"
        Int8 = "int8"
        UInt16 = "uint16"
        Int16 = "int16"
        UInt32 = "uint32"
        Int32 = "int32"
        UInt64 = "uint64"
        Int64 = "int64"
        Float16 = "float16"
        Float32 = "float32"
        Float64 = "float64"


class PixelFormat(enum.Enum):
    """Channels of the pixels. The value has a letter for each channel; it is empty if any channels are
    allowed."""
    Y = "Y"
    YA = "YA"
    RGB = "RGB"
    RGBA = "RGBA"
    XYZ = "XYZ"
    XYZA = "XYZA"
    MultiChannel = ""


class AlphaTransform(enum.Enum):
    """Change of colours by convert(): none, multiplication by alpha, or division by it."""
    Empty = 0
    Premultiply = 1
    Unpremultiply = 2


def srgb_to_linear(value):
    """Decodes values of sRGB from 0 to 1, in an array of any shape."""
    value = np.asarray(value)
    return np.where(value <= 0.04045, value / 12.92,
                    ((np.maximum(value, 0.04045) + 0.055) / 1.055) ** 2.4)


def linear_to_srgb(value):
    """Encodes linear values as sRGB, in an array of any shape."""
    value = np.asarray(value)
    return np.where(value <= 0.0031308, value * 12.92,
                    1.055 * np.maximum(value, 0.0031308) ** (1 / 2.4) - 0.055)


def luminance(color):
    """Returns the luminance of linear Rec.709 colours: arrays with three channels as the last axis."""
    return np.asarray(color) @ LUMINANCE


def scaled(array):
    """Returns the values as floats, integers divided by the largest value of their type."""
    if array.dtype.kind == "f":
        return array.astype(np.float64)
    return array / np.float64(np.iinfo(array.dtype).max)


def unscaled(values, dtype):
    """Converts floats to a type, the inverse of scaled(). Clamps to the range of integers."""
    if dtype.kind == "f":
        return np.ascontiguousarray(values, dtype)
    limits = np.iinfo(dtype)
    scaled = np.rint(np.clip(np.nan_to_num(values), -2, 2).astype(np.float64) * limits.max)
    # For 64-bit integers, the largest float below the limit is the largest that can be converted.
    high = limits.max if dtype.itemsize < 8 else np.nextafter(float(limits.max), 0)
    return np.clip(scaled, limits.min, high).astype(dtype)


def resampled(values, axis, count, table, radius):
    """Returns an array with `count` values along an axis. `table` has the values of a filter at
    equidistant offsets from 0 to `radius`, in pixels of the coarser array."""
    values = np.moveaxis(values, axis, 0)
    before = len(values)
    width = radius * max(1, before / count)
    centers = (np.arange(count) + 0.5) * before / count - 0.5
    indices = (np.ceil(centers - width)[:, None] + np.arange(int(2 * width) + 1)).astype(np.int64)
    offsets = np.abs(indices - centers[:, None]) / width
    weights = np.interp(offsets, np.linspace(0, 1, len(table)), table, right=0)
    sums = weights.sum(axis=1, keepdims=True)
    weights = (weights / np.where(sums == 0, 1, sums)).astype(values.dtype)
    indices = indices.clip(0, before - 1)
    taps = indices.shape[1]
    result = np.zeros((count, *values.shape[1:]), values.dtype)
    if count < taps:
        for i in range(count):
            result[i] = np.tensordot(weights[i], values[indices[i]], 1)
    else:
        for k in range(taps):
            result += weights[:, k].reshape(-1, *[1] * (values.ndim - 1)) * values[indices[:, k]]
    return np.moveaxis(result, 0, axis)


def in_format(values, names, old, new):
    """Returns linear values in another pixel format."""
    if new is PixelFormat.MultiChannel:
        return values
    if old is PixelFormat.MultiChannel:
        raise ValueError("pixel_format can't be changed from MultiChannel; split() the bitmap")
    alpha = values[..., [names.index("A")]] if "A" in names else np.ones_like(values[..., :1])
    if old in (PixelFormat.Y, PixelFormat.YA):
        rgb = np.repeat(values[..., :1], 3, axis=2)
    elif old in (PixelFormat.XYZ, PixelFormat.XYZA):
        rgb = values[..., :3] @ np.linalg.inv(TO_XYZ).T
    else:
        rgb = values[..., :3]
    if new in (PixelFormat.Y, PixelFormat.YA):
        color = values[..., :1] if old in (PixelFormat.Y, PixelFormat.YA) else (
            luminance(rgb)[..., None])
    elif new in (PixelFormat.XYZ, PixelFormat.XYZA):
        color = rgb @ TO_XYZ.T
    else:
        color = rgb
    return np.concatenate([color, alpha], axis=2) if "A" in new.value else np.array(color)
