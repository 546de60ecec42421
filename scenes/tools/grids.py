"""Grids of voxels, evaluated slice by slice."""

import numpy as np


def sampled(size, density):
    """Returns the (z, y, x) array of density(p) at the centres of the voxels. `size`: numbers of
    voxels along x, y, z. `p`: points (y, x, 3) in the unit cube."""
    x, y, z = ((np.arange(n) + 0.5) / n for n in size)
    grid = np.empty(size[::-1], np.float32)
    for k, depth in enumerate(z):
        p = np.empty((size[1], size[0], 3))
        p[..., 0], p[..., 1], p[..., 2] = x[None, :], y[:, None], depth
        grid[k] = density(p)
    return grid
