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


def hashed(x, y, z, seed):
    """Returns numbers in [0, 1) for arrays of integers, from a fixed integer hash."""
    def words(a):
        return a.astype(np.int64).astype(np.uint64)

    h = (words(x) * np.uint64(73856093) ^ words(y) * np.uint64(19349663)
         ^ words(z) * np.uint64(83492791) ^ np.uint64(seed * 2654435761))
    h = (h ^ (h >> np.uint64(13))) * np.uint64(0x9E3779B97F4A7C15)
    h = (h ^ (h >> np.uint64(29))) * np.uint64(0xBF58476D1CE4E5B9)
    return ((h >> np.uint64(40)) & np.uint64(0xFFFFFF)).astype(np.float32) / np.float32(1 << 24)


def noise_3d(p, seed):
    """Returns value noise in [0, 1] at points p (..., 3), with one lattice point per unit."""
    cell = np.floor(p)
    f = (p - cell).astype(np.float32)
    f = f * f * (3 - 2 * f)
    x, y, z = (cell[..., a].astype(np.int64) for a in range(3))
    total = np.zeros(p.shape[:-1], np.float32)
    for corner in range(8):
        dx, dy, dz = corner & 1, corner >> 1 & 1, corner >> 2
        weight = ((f[..., 0] if dx else 1 - f[..., 0]) * (f[..., 1] if dy else 1 - f[..., 1])
                  * (f[..., 2] if dz else 1 - f[..., 2]))
        total += weight * hashed(x + dx, y + dy, z + dz, seed)
    return total


def fractal_3d(p, octaves, seed):
    """Returns a sum of `octaves` of noise_3d in [0, 1], each of half the size and weight."""
    total, weight = np.zeros(p.shape[:-1], np.float32), 0.0
    for octave in range(octaves):
        total += 0.5 ** octave * noise_3d(p * 2.0 ** octave, seed + octave)
        weight += 0.5 ** octave
    return total / weight
