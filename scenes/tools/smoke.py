"""The assets of the smoke scene: a plume of 64 x 128 x 64 voxels, and a bowl."""

import numpy as np

from . import files, grids, noise, solids, stone


def density(p):
    """Returns the density at points in the unit cube, from 0 to 1. The plume rises from the middle of
    the base. It sways and widens, and its turbulence grows with the height."""
    y = p[..., 1]
    swirl = np.stack([noise.fractal_3d(3.5 * (p * [1, 2, 1] - [0, 0.37, 0]), 3, seed)
                      for seed in (3, 17, 29)], axis=-1) - 0.5
    q = p + swirl * (0.7 * y)[..., None] * [1, 0.5, 1]
    x = q[..., 0] - 0.5 - 0.10 * np.sin(6 * y) * y
    z = q[..., 2] - 0.5 - 0.08 * np.cos(5 * y + 1) * y
    body = np.clip(1 - (x * x + z * z) / (0.06 + 0.24 * y) ** 2, 0, 1)
    threads = noise.fractal_3d(np.array([9.0, 12.0, 9.0]) * q, 4, 7)
    fade = np.clip((1 - y) / 0.3, 0, 1) * (1 - 0.7 * y) * np.clip(y / 0.02, 0, 1)
    return body ** 1.5 * np.clip(5 * threads - 2, 0, 1) * fade


def bowl(steps):
    """Returns a bowl on a foot whose opening is at y = 0.3."""
    profile = [(0.0, 0.0), (0.2, 0.0), (0.2, 0.02)]
    profile += solids.curve([(0.1, 0.04), (0.06, 0.09), (0.16, 0.16), (0.26, 0.24), (0.27, 0.3)], steps)
    profile += solids.curve([(0.255, 0.3), (0.24, 0.25), (0.12, 0.2), (0.0, 0.19)], steps)
    return stone.lathe(profile, 6 * steps)


def make(folder, scale):
    """Writes the files. Returns the number of triangles."""
    n = max(8, int(round(64 / scale)))
    files.write_vol(folder / "smoke.vol", grids.sampled((n, 2 * n, n), density))
    return files.write_plys(folder, {"bowl": bowl(max(4, int(round(12 / scale))))})
