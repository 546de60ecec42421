"""The assets of the reeds scene: metal with ridges that are finer than a pixel."""

import numpy as np

from . import files, solids, stone

# Lengths here are in metres, those of the scene in centimetres: some renderers start shadow rays at
# a distance of 1e-4 (1 + |position|), which must be far smaller than a ridge.
SCALE = 100.0
FLANK = np.tan(np.radians(30.0))  # slope of both flat sides of a ridge


def along_z(outline, depth):
    """Returns a strip with the cross-section `outline`: (x, y) points from left to right."""
    ends = [np.insert(outline, 2, z, axis=1) for z in (depth / 2, -depth / 2)]
    return solids.faceted(solids.grid(np.stack(ends)))


def zigzag(points):
    """Returns 0, 1, 0, 1, ..., 0."""
    return np.arange(points) % 2


def sheet(ridges, width, depth):
    """Returns a sheet with ridges along z."""
    flank = width / ridges / 2
    x = np.arange(2 * ridges + 1) * flank - width / 2
    return along_z(np.stack([x, FLANK * flank * zigzag(len(x))], axis=1), depth)


def drum(ridges, rows):
    """Returns a bulging drum with vertical ridges."""
    sin, cos = solids.circle(2 * ridges)
    deep = FLANK * 2 * np.pi * 0.6 / (2 * ridges) * zigzag(len(sin))
    radius = 0.6 - deep[None, :] + 0.05 * np.sin(np.linspace(0, np.pi, rows))[:, None]
    height = np.broadcast_to(np.linspace(0.0, 1.3, rows)[:, None], radius.shape)
    return solids.faceted(solids.grid(np.stack([radius * sin, height, radius * cos], axis=2)))


def make(folder, scale):
    """Writes the files. Returns the number of triangles."""
    few = max(1.0, scale)
    lid = stone.lathe([(0.6, 1.3), (0.6, 1.32), (0.58, 1.34), (0.0, 1.34)], int(160 / few))
    meshes = {"sheet": sheet(int(1500 / few), 6.0, 6.0), "drum": drum(int(600 / few), 9),
              "lid": lid}
    return files.write_plys(folder, {name: solids.moved(mesh, (0, 0, 0), scale=SCALE)
                                     for name, mesh in meshes.items()})
