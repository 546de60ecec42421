"""Small images as data URLs, which a page can contain."""
import base64
import io

import numpy as np
from PIL import Image

GAP = 2


def encoded(image, scale=1.0):
    """Converts linear values to 8-bit sRGB with three channels."""
    x = np.clip(np.nan_to_num(image, posinf=1e9) * scale, 0, 1)
    x = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    return np.broadcast_to(np.floor(255 * x + 0.5).astype(np.uint8), (*x.shape[:2], 3))


def exposure(reference):
    """Returns a scale that maps the 98th percentile to 0.8."""
    return 0.8 / max(float(np.percentile(reference, 98)), 1e-30)


def url(pixels, kind="JPEG"):
    """Returns a data URL of 8-bit pixels."""
    file = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(file, kind, quality=85)
    return f"data:image/{kind.lower()};base64," + base64.b64encode(file.getvalue()).decode()


def relative(image, reference):
    """Returns an image of the relative difference: red is too bright, blue is too dark. The colour is full at
    the 99th percentile."""
    grey, truth = image.mean(axis=2), reference.mean(axis=2)
    found = (grey - truth) / (truth + 0.1 * max(truth.mean(), 1e-30))
    found /= max(float(np.percentile(np.abs(found), 99)), 1e-6)
    strength = np.clip(np.abs(found), 0, 1)[:, :, None]
    colour = np.where((found > 0)[:, :, None], [230, 30, 20], [20, 60, 230])
    return (255 - (255 - colour) * strength).astype(np.uint8)


def beside(panels):
    """Joins panels of the same height in a row."""
    white = np.full((panels[0].shape[0], GAP, 3), 255, np.uint8)
    row = [x for panel in panels for x in (panel, white)][:-1]
    return np.concatenate(row, axis=1)


def difference(image, reference, masked):
    """Returns the image, the reference and their difference as a data URL."""
    keep = ~masked[:, :, None]
    image, reference = image * keep, reference * keep
    scale = exposure(reference)
    return url(beside([encoded(image, scale), encoded(reference, scale),
                       relative(image, reference)]))
