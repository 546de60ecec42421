"""The asset of the cloud scene: a cumulus of 128³ voxels at scale 1."""

import numpy as np

from . import files, grids, noise

PUFFS = 60  # balls that form the cloud
FLOOR = 0.22  # height of its flat base


def puffs():
    """Returns centres and radii in the unit cube: large ones low in the middle, small ones around
    and above them."""
    i = np.arange(PUFFS)
    angle = 2 * np.pi * (i * 0.618033988749895 % 1)
    at = (0.5 + i * 0.7548776662466927) % 1
    high = ((0.5 + i * 0.5698402909980532) % 1) ** 1.6
    away = 0.33 * np.sqrt(at) * (1 - 0.75 * high)
    centre = np.stack([0.5 + away * np.cos(angle), FLOOR + 0.04 + 0.46 * high,
                       0.5 + 0.8 * away * np.sin(angle)], axis=1)
    radius = 0.06 + 0.10 * (1 - at) * (1 - 0.4 * high)
    return centre, radius


def density(p, centre, radius):
    """Returns the density at points in the unit cube, from 0 to 1."""
    warp = np.stack([noise.fractal_3d(6 * p, 3, seed) for seed in (11, 23, 37)], axis=-1) - 0.5
    q = p + 0.05 * warp
    inside = np.full(p.shape[:-1], -1.0)
    for c, r in zip(centre, radius):
        inside = np.maximum(inside, 1 - np.linalg.norm(q - c, axis=-1) / r)
    lumps = noise.fractal_3d(14 * q, 4, 5)
    value = inside - 0.55 * (1 - lumps) + 0.12
    base = np.clip((p[..., 1] - FLOOR + 0.02 * (lumps - 0.5)) / 0.03, 0, 1)
    return np.clip(6 * value, 0, 1) * base


def make(folder, scale):
    """Writes the file. Returns the number of triangles, which is 0."""
    n = max(8, int(round(128 / scale)))
    centre, radius = puffs()
    grid = grids.sampled((n, n, n), lambda p: density(p, centre, radius))
    files.write_vol(folder / "cloud.vol", grid)
    return 0
