"""Meshes: surface nets from a field, surfaces of revolution, and the checks on them.

A mesh is a dict: 'positions' (n, 3), 'normals' (n, 3), 'faces' (m, 3), and maybe 'uv' (n, 2).
"""

import numpy as np

from . import sdf


def graded_axis(low, high, spacing):
    """Returns grid planes from low to high, with distances of spacing(position)."""
    planes = [low]
    while planes[-1] < high:
        planes.append(planes[-1] + spacing(planes[-1]))
    return np.array(planes)


def sample_grid(field, axes, block=8, lipschitz=2.0):
    """Returns the field at every grid point. Blocks that the surface can't reach have a single value.

    A block is skipped if the field at its centre exceeds `lipschitz` times its half diagonal.
    """
    shape = tuple(len(a) for a in axes)
    starts = [np.arange(0, n, block) for n in shape]
    ends = [np.minimum(s + block, n) - 1 for s, n in zip(starts, shape)]
    centres = [0.5 * (a[s] + a[e]) for a, s, e in zip(axes, starts, ends)]
    halves = [0.5 * (a[e] - a[s]) for a, s, e in zip(axes, starts, ends)]
    cx, cy, cz = (c.ravel() for c in np.meshgrid(*centres, indexing="ij"))
    hx, hy, hz = (h.ravel() for h in np.meshgrid(*halves, indexing="ij"))
    middle = field(cx, cy, cz)
    near = np.abs(middle) < lipschitz * np.sqrt(hx * hx + hy * hy + hz * hz) + 1e-3
    values = middle.reshape([len(s) for s in starts])
    for axis, n in enumerate(shape):
        values = np.repeat(values, block, axis=axis).take(np.arange(n), axis=axis)
    wanted = near.reshape([len(s) for s in starts])
    for axis, n in enumerate(shape):
        wanted = np.repeat(wanted, block, axis=axis).take(np.arange(n), axis=axis)
    i, j, k = np.nonzero(wanted)
    for begin in range(0, len(i), 200_000):  # in chunks that fit into the cache
        s = slice(begin, begin + 200_000)
        values[i[s], j[s], k[s]] = field(axes[0][i[s]], axes[1][j[s]], axes[2][k[s]])
    return values


def remove_ambiguous_faces(values):
    """Fills grid points until no cell face has equal signs only on its diagonals.

    Such a face would make four quads meet at one edge of the dual mesh. Without them every edge
    of a surface net belongs to exactly two triangles.
    """
    for _ in range(50):
        inside = values < 0.0
        found = 0
        for axis in range(3):
            u, v = [a for a in range(3) if a != axis]

            def corner(du, dv, u=u, v=v):
                cut = [slice(None)] * 3
                cut[u] = slice(du, values.shape[u] - 1 + du)
                cut[v] = slice(dv, values.shape[v] - 1 + dv)
                return inside[tuple(cut)]

            a, b, c, d = corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)
            at = list(np.nonzero((a == d) & (b == c) & (a != b)))
            found += len(at[0])
            at[u] = at[u] + a[tuple(at)]  # the first corner that is outside: (0, 0) or (1, 0)
            values[tuple(at)] = -np.abs(values[tuple(at)]) - 1e-9
        if found == 0:
            return values
    raise RuntimeError("the grid stays ambiguous after 50 passes")


def surface_net(values, axes):
    """Returns vertices and triangles of the dual surface of `values` = 0 (Gibson, 1998)."""
    inside = values < 0.0
    cells = tuple(n - 1 for n in values.shape)
    total = np.zeros(cells + (3,))
    count = np.zeros(cells, dtype=np.int32)
    crossings = []
    for axis in range(3):
        low = tuple(slice(0, n - 1 if a == axis else n) for a, n in enumerate(values.shape))
        high = tuple(slice(1 if a == axis else 0, n) for a, n in enumerate(values.shape))
        at = np.nonzero(inside[low] != inside[high])
        f0, f1 = values[low][at], values[high][at]
        t = f0 / (f0 - f1)
        point = np.stack([axes[a][at[a]] for a in range(3)], axis=1)
        point[:, axis] += t * np.diff(axes[axis])[at[axis]]
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1)):
            cell = list(at)
            cell[u], cell[v] = at[u] - du, at[v] - dv
            np.add.at(total, tuple(cell), point)
            np.add.at(count, tuple(cell), 1)
        crossings.append((at, u, v, f0 < 0.0))
    used = np.nonzero(count)
    vertices = total[used] / count[used][:, None]
    index = np.full(cells, -1, dtype=np.int64)
    index[used] = np.arange(len(vertices))
    quads = []
    for at, u, v, leaves in crossings:
        ring = []
        for du, dv in ((1, 1), (0, 1), (0, 0), (1, 0)):
            cell = list(at)
            cell[u], cell[v] = at[u] - du, at[v] - dv
            ring.append(index[tuple(cell)])
        ring = np.stack(ring, axis=1)
        ring[~leaves] = ring[~leaves][:, ::-1]
        quads.append(ring)
    return vertices, np.concatenate(quads)


def split_quads(vertices, quads):
    """Divides each quad into two triangles along its shorter diagonal."""
    p = vertices[quads]
    first = np.sum((p[:, 0] - p[:, 2]) ** 2, axis=1) <= np.sum((p[:, 1] - p[:, 3]) ** 2, axis=1)
    a, b, c, d = quads.T
    one = np.where(first[:, None], np.stack([a, b, c], 1), np.stack([a, b, d], 1))
    two = np.where(first[:, None], np.stack([a, c, d], 1), np.stack([b, c, d], 1))
    return np.stack([one, two], axis=1).reshape(-1, 3)


def mesh_field(field, axes, newton_steps=3):
    """Returns the closed mesh of field = 0: a surface net, projected to the surface, with smooth normals."""
    values = remove_ambiguous_faces(sample_grid(field, axes))
    vertices, quads = surface_net(values, axes)
    for axis in range(3):
        planes = axes[axis]
        if vertices[:, axis].min() < planes[1] or vertices[:, axis].max() > planes[-2]:
            raise RuntimeError("the surface reaches the grid's border")
    cell = np.stack([np.diff(a)[np.clip(np.searchsorted(a, vertices[:, i]) - 1, 0, len(a) - 2)]
                     for i, a in enumerate(axes)], axis=1).min(axis=1)
    for _ in range(newton_steps):
        g = sdf.gradient(field, vertices, 5e-4)
        f = field(vertices[:, 0], vertices[:, 1], vertices[:, 2])
        step = -f / np.maximum(np.sum(g * g, axis=1), 1e-2)
        length = np.abs(step) * np.sqrt(np.sum(g * g, axis=1))
        step *= np.minimum(1.0, 0.4 * cell / np.maximum(length, 1e-12))
        vertices = vertices + step[:, None] * g
    g = sdf.gradient(field, vertices, 1e-3)
    normals = g / np.maximum(np.linalg.norm(g, axis=1), 1e-12)[:, None]
    return {"positions": vertices, "normals": normals, "faces": split_quads(vertices, quads)}


def is_watertight(faces):
    """Returns whether each edge belongs to exactly two triangles, once in each direction."""
    faces = np.asarray(faces, dtype=np.int64)
    a = faces.ravel()
    b = faces[:, [1, 2, 0]].ravel()
    n = int(faces.max()) + 1
    ahead, back = np.sort(a * n + b), np.sort(b * n + a)
    return bool(np.all(np.diff(ahead) > 0) and np.array_equal(ahead, back))
