"""Noise for maps: a fixed integer hash, so that the result is the same on every machine."""

import numpy as np


def smooth_noise(height, width, cells, seed):
    """Returns periodic value noise in [0, 1], from a fixed integer hash."""
    rows, columns = cells
    i, j = np.meshgrid(np.arange(rows, dtype=np.uint64), np.arange(columns, dtype=np.uint64),
                       indexing="ij")
    h = (i * np.uint64(73856093)) ^ (j * np.uint64(19349663)) ^ np.uint64(seed * 83492791)
    h = (h ^ (h >> np.uint64(13))) * np.uint64(0x9E3779B97F4A7C15)
    lattice = ((h >> np.uint64(40)) & np.uint64(0xFFFF)).astype(np.float64) / 65535.0
    y = np.arange(height) * (rows / height)
    x = np.arange(width) * (columns / width)
    y0, x0 = y.astype(int), x.astype(int)
    fy, fx = (y - y0), (x - x0)
    fy, fx = (fy * fy * (3 - 2 * fy))[:, None], (fx * fx * (3 - 2 * fx))[None, :]
    y1, x1 = (y0 + 1) % rows, (x0 + 1) % columns
    top = lattice[np.ix_(y0, x0)] * (1 - fx) + lattice[np.ix_(y0, x1)] * fx
    low = lattice[np.ix_(y1, x0)] * (1 - fx) + lattice[np.ix_(y1, x1)] * fx
    return top * (1 - fy) + low * fy
