"""The asset of the sponge scene: Menger's sponge, a lattice of holes of every size."""

import numpy as np

from . import box, files


def solid(level):
    """Returns which cells of a cube with 3^level cells per side are full."""
    cells = np.ones((1, 1, 1), dtype=bool)
    middle = np.arange(3) == 1
    count = middle[:, None, None].astype(int) + middle[None, :, None] + middle[None, None, :]
    for _ in range(level):
        cells = np.kron(cells, count < 2).astype(bool)
    return cells


def skin(cells):
    """Returns the faces between full and empty cells of a cube from -1 to 1."""
    n = len(cells)
    padded = np.pad(cells, 1)
    inner = (slice(1, -1),) * 3
    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    parts = []
    for axis in range(3):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        for sign in (-1, 1):
            at = np.argwhere(cells & ~np.roll(padded, -sign, axis=axis)[inner])
            ring = np.repeat(at[:, None, :], 4, axis=1)
            ring[:, :, axis] += sign > 0
            ring[:, :, first] += corners[:, 0]
            ring[:, :, second] += corners[:, 1]
            quads = np.arange(4 * len(at)).reshape(-1, 4)
            quads = quads if sign > 0 else quads[:, ::-1]
            parts.append({"positions": ring.reshape(-1, 3) * (2.0 / n) - 1.0,
                          "normals": np.tile(sign * np.eye(3)[axis], (4 * len(at), 1)),
                          "uv": np.tile(corners, (len(at), 1)).astype(float),
                          "faces": np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])})
    return box.together(parts)


def make(folder, scale):
    """Writes the file. Returns the number of triangles."""
    return files.write_plys(folder, {"sponge": skin(solid(3 if scale < 2 else 2))})
