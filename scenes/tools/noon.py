"""The asset of the noon scene: a sky with a sun of four texels."""

import numpy as np

from . import files


def sky(height, width):
    """Returns the sky as latitude and longitude: constant blue, and a sun at 58 degrees, from which a
    floor receives 9/10 of its light."""
    image = np.tile(np.array([0.10, 0.13, 0.20]), (height, width, 1))
    row, column = int(height * (90 - 58) / 180), width // 2
    texel = (np.pi / height) * (2 * np.pi / width) * np.sin(np.pi * (row + 1) / height)
    floor = np.pi * 0.13 / (4 * texel * np.sin(np.radians(58)))  # as much as from the sky
    image[row:row + 2, column:column + 2] = 9 * floor * np.array([1.06, 1.0, 0.88])
    return image


def make(folder, scale):
    """Writes the file; there are no triangles."""
    files.write_pfm(folder / "sky.pfm", sky(256, 512))
    return 0
