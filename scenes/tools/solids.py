"""Solids to build scenes from: cuboids, balls, rings, profiles of revolution, and transformed copies."""

import numpy as np

from . import box, stone


def cuboid(low, high):
    """Returns an axis-parallel cuboid with flat sides."""
    ends = np.array([low, high], dtype=np.float64)
    sides = []
    for axis in range(3):
        first, second = [k for k in range(3) if k != axis]
        for sign in (0, 1):
            ring = np.tile(ends[sign], (4, 1))
            ring[:, first] = ends[[0, 1, 1, 0], first]
            ring[:, second] = ends[[0, 0, 1, 1], second]
            sides.append(box.polygon(ring, np.eye(3)[axis] * (2 * sign - 1), inside=False))
    return box.together(sides)


def grid(positions, uv=None):
    """Returns the mesh of an (rows, columns, 3) grid of points that is closed along its rows."""
    rows, columns = positions.shape[:2]
    points = positions.reshape(-1, 3)
    if uv is None:
        uv = np.stack(np.meshgrid(np.linspace(0, 1, rows), np.linspace(0, 1, columns),
                                  indexing="ij")[::-1], axis=2)
    mesh = {"positions": points, "uv": uv.reshape(-1, 2), "faces": stone.grid_faces(rows, columns)}
    mesh = stone.without_slivers(mesh)
    return {**mesh, "normals": stone.smooth_normals(points, mesh["faces"])}


def faceted(mesh):
    """Returns the mesh with flat triangles that share no vertices."""
    positions = mesh["positions"][mesh["faces"]].reshape(-1, 3)
    flat = np.cross(positions[1::3] - positions[::3], positions[2::3] - positions[::3])
    flat /= np.linalg.norm(flat, axis=1)[:, None]
    return {"positions": positions, "normals": np.repeat(flat, 3, axis=0),
            "uv": mesh["uv"][mesh["faces"]].reshape(-1, 2),
            "faces": np.arange(len(positions)).reshape(-1, 3)}


def circle(steps):
    """Returns (sin, cos) of a whole turn. The last point has the same bits as the first."""
    angle = np.linspace(0.0, 2 * np.pi, steps + 1)
    sin, cos = np.sin(angle), np.cos(angle)
    sin[-1], cos[-1] = sin[0], cos[0]
    return sin, cos


def star(radius, rows):
    """Returns the surface at the distance radius(x, y, z) from the origin in each direction (x, y, z)."""
    sin, cos = circle(2 * rows)
    height = np.linspace(-np.pi / 2, np.pi / 2, rows + 1)[:, None]
    ring = np.cos(height)
    ring[[0, -1]] = 0.0
    d = np.stack([ring * sin, np.broadcast_to(np.sin(height), (rows + 1, 2 * rows + 1)),
                  ring * cos], axis=2)
    return grid(d * radius(d[..., 0], d[..., 1], d[..., 2])[..., None])


def torus(radius, thickness, steps):
    """Returns a ring around y."""
    sin, cos = circle(2 * steps)
    up, out = circle(steps)
    out = radius + thickness * out[:, None]
    return grid(np.stack([out * sin, np.broadcast_to(thickness * up[:, None], out.shape[:1] +
                                                     sin.shape), out * cos], axis=2))


def curve(points, steps):
    """Returns a smooth line through points (Catmull and Rom, 1974); `steps` segments each."""
    p = np.asarray(points, dtype=np.float64)
    p = np.concatenate([2 * p[:1] - p[1:2], p, 2 * p[-1:] - p[-2:-1]])
    t = np.arange(steps)[:, None] / steps
    pieces = [b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)))
              for a, b, c, d in zip(p, p[1:], p[2:], p[3:])]
    return [tuple(q) for q in np.concatenate(pieces)] + [tuple(p[-2])]


def turn(axis, degrees):
    """Returns the rotation about an axis (0, 1, 2)."""
    a = np.radians(degrees)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[first, first] = matrix[second, second] = np.cos(a)
    matrix[first, second], matrix[second, first] = -np.sin(a), np.sin(a)
    return matrix


def moved(mesh, offset, rotation=None, scale=1.0):
    """Returns a copy that is scaled, then rotated, then translated."""
    rotation = np.eye(3) if rotation is None else rotation
    return {**mesh, "positions": scale * mesh["positions"] @ rotation.T + np.asarray(offset),
            "normals": mesh["normals"] @ rotation.T}
