"""Shapes of revolution with normals and texture coordinates, and the plinth of the hebe scene."""

import numpy as np


def grid_faces(rows, columns, offset=0):
    """Returns two triangles for each cell of a (rows, columns) grid of vertices."""
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(columns - 1), indexing="ij")
    a = (i * columns + j).ravel() + offset
    quad = np.stack([a, a + 1, a + columns + 1, a, a + columns + 1, a + columns], axis=1)
    return quad.reshape(-1, 3)


def smooth_normals(positions, faces):
    """Returns area-weighted vertex normals. Vertices at the same position share one."""
    corners = positions[faces]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    _, place = np.unique(np.round(positions, 7), axis=0, return_inverse=True)
    place = place.ravel()
    total = np.zeros((place.max() + 1, 3))
    for k in range(3):
        np.add.at(total, place[faces[:, k]], flat)
    total /= np.maximum(np.linalg.norm(total, axis=1), 1e-30)[:, None]
    return total[place]


def without_slivers(mesh):
    """Removes the triangles of zero area at the poles of a grid."""
    c = mesh["positions"][mesh["faces"]]
    area = np.linalg.norm(np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]), axis=1)
    return {**mesh, "faces": mesh["faces"][area > 1e-14]}


def lathe(profile, segments, sharp=40.0):
    """Rotates (radius, height) points around y. Bends above `sharp` degrees keep an edge.

    The profile runs upwards on the outside, so that normals point outwards.
    """
    profile = np.asarray(profile, dtype=np.float64)
    distinct = np.linalg.norm(np.diff(profile, axis=0), axis=1) > 1e-6
    profile = profile[np.concatenate([[True], distinct])]
    along = np.diff(profile, axis=0)
    lengths = np.linalg.norm(along, axis=1)
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / lengths[:, None]
    v = np.concatenate([[0.0], np.cumsum(lengths)]) / lengths.sum()
    rows, normals, coords = [], [], []
    limit = np.cos(np.radians(sharp))
    for i, point in enumerate(profile):
        before, after = normal[max(i - 1, 0)], normal[min(i, len(normal) - 1)]
        if np.dot(before, after) < limit:
            pair = (before, after)
        else:
            mean = before + after
            pair = (mean / np.linalg.norm(mean),)
        for n in pair:
            rows.append(point)
            normals.append(n)
            coords.append(v[i])
    rows, normals, coords = np.array(rows), np.array(normals), np.array(coords)
    u = np.linspace(0.0, 1.0, segments + 1)
    sin, cos = np.sin(2 * np.pi * u), np.cos(2 * np.pi * u)
    sin[-1], cos[-1] = sin[0], cos[0]

    def turned(radial, height):
        r, h = np.meshgrid(radial, np.ones_like(u), indexing="ij")[0], height[:, None]
        return np.stack([r * sin, np.broadcast_to(h, r.shape), r * cos], axis=2).reshape(-1, 3)

    mesh = {"positions": turned(rows[:, 0], rows[:, 1]),
            "normals": turned(normals[:, 0], normals[:, 1]),
            "uv": np.stack(np.meshgrid(coords, u, indexing="ij")[::-1], axis=2).reshape(-1, 2),
            "faces": grid_faces(len(rows), segments + 1)}
    return without_slivers(mesh)


def arc(centre, radius, start, end, steps):
    """Returns points of a circular moulding. Angles are in degrees: 0 is right, 90 is up."""
    a = np.radians(np.linspace(start, end, steps))
    return [(centre[0] + radius * np.cos(t), centre[1] + radius * np.sin(t)) for t in a]


def plinth():
    """Returns a round pedestal with base and cornice mouldings, 0.6 m high."""
    profile = [(0.0, 0.0), (0.50, 0.0), (0.50, 0.10), (0.485, 0.115)]
    profile += arc((0.455, 0.150), 0.035, -90, 90, 13)  # torus of the base
    profile += [(0.445, 0.190)]
    profile += arc((0.445, 0.245), 0.050, 270, 180, 10)  # scotia
    profile += [(0.395, 0.255), (0.385, 0.262), (0.378, 0.400), (0.390, 0.408)]
    profile += arc((0.390, 0.422), 0.014, -90, 90, 9)  # astragal
    profile += [(0.392, 0.442)]
    profile += arc((0.445, 0.480), 0.045, 200, 110, 10)
    profile += [(0.455, 0.525), (0.455, 0.570), (0.448, 0.590)]
    profile += [(0.435, 0.600), (0.0, 0.600)]
    return lathe(profile, 160)
