"""Signed distance fields over numpy arrays: primitives and smooth combinations.

A field is a function of three equal arrays x, y, z (metres) that returns an array, negative
inside. Fields here are bounds more than exact distances: blends and displacements bend them, so
a user steps along the gradient with Newton's method instead of trusting one value.
The primitives are the usual ones; see Hart, "Sphere tracing" (1996), for the idea, and Quilez,
"Smooth minimum" (2013), for the polynomial blend.
"""

import numpy as np


def smoothstep(low, high, value):
    """Returns a cubic ramp from 0 at low to 1 at high (low may exceed high)."""
    t = np.clip((value - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def union(a, b, k):
    """Returns the union with a fillet of width k."""
    h = np.maximum(k - np.abs(a - b), 0.0)
    return np.minimum(a, b) - h * h * (0.25 / k)


def intersect(a, b, k):
    """Returns the intersection, with an edge rounded over a width of k."""
    return -union(-a, -b, k)


def subtract(a, b, k):
    """Returns the difference a - b."""
    return intersect(a, -b, k)


def sphere(x, y, z, c, r):
    return np.sqrt((x - c[0]) ** 2 + (y - c[1]) ** 2 + (z - c[2]) ** 2) - r


def ellipsoid(x, y, z, c, r):
    """Returns the first-order distance k0 (k0 - 1) / k1, which is accurate close to the surface."""
    u, v, w = (x - c[0]) / r[0], (y - c[1]) / r[1], (z - c[2]) / r[2]
    k0 = np.sqrt(u * u + v * v + w * w)
    k1 = np.sqrt((u / r[0]) ** 2 + (v / r[1]) ** 2 + (w / r[2]) ** 2)
    return k0 * (k0 - 1.0) / np.maximum(k1, 1e-9)


def cone(x, y, z, a, b, ra, rb):
    """Returns a bound on the distance to a round cone from a to b: a capsule with radius from ra to rb."""
    d = np.subtract(b, a)
    px, py, pz = x - a[0], y - a[1], z - a[2]
    t = np.clip((px * d[0] + py * d[1] + pz * d[2]) / float(np.dot(d, d)), 0.0, 1.0)
    px, py, pz = px - t * d[0], py - t * d[1], pz - t * d[2]
    return np.sqrt(px * px + py * py + pz * pz) - (ra + t * (rb - ra))


def chain(x, y, z, points, radii, k):
    """Returns round cones through points, blended over k."""
    d = cone(x, y, z, points[0], points[1], radii[0], radii[1])
    for i in range(1, len(points) - 1):
        d = union(d, cone(x, y, z, points[i], points[i + 1], radii[i], radii[i + 1]), k)
    return d


def torus(x, y, z, c, major, minor):
    """Returns the distance to a torus around the y axis."""
    ring = np.sqrt((x - c[0]) ** 2 + (z - c[2]) ** 2) - major
    return np.sqrt(ring * ring + (y - c[1]) ** 2) - minor


def disc(x, y, z, c, radius, half_height, rounding):
    """Returns the distance to an upright cylinder with rounded edges."""
    u = np.sqrt((x - c[0]) ** 2 + (z - c[2]) ** 2) - radius + rounding
    v = np.abs(y - c[1]) - half_height + rounding
    outside = np.sqrt(np.maximum(u, 0.0) ** 2 + np.maximum(v, 0.0) ** 2)
    return outside + np.minimum(np.maximum(u, v), 0.0) - rounding


def box(x, y, z, c, half, rounding):
    q = [np.abs(p - m) - h + rounding for p, m, h in zip((x, y, z), c, half)]
    outside = np.sqrt(sum(np.maximum(v, 0.0) ** 2 for v in q))
    return outside + np.minimum(np.maximum(np.maximum(q[0], q[1]), q[2]), 0.0) - rounding


def rotation(yaw=0.0, pitch=0.0, roll=0.0):
    """Returns the matrix of rotations in degrees about y, then x, then z, in the object's frame."""
    a, b, c = np.radians([yaw, pitch, roll])
    ry = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
    rx = np.array([[1, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
    rz = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    return ry @ rx @ rz


def local(x, y, z, origin, matrix):
    """Transforms world coordinates to a frame at origin, with the columns of the matrix as axes."""
    px, py, pz = x - origin[0], y - origin[1], z - origin[2]
    return tuple(matrix[0, i] * px + matrix[1, i] * py + matrix[2, i] * pz for i in range(3))


def fold(phase, sharpness=0.05):
    """Returns a cloth profile in [0, 1] with period pi: round ridges, narrow valleys."""
    return np.sqrt(np.sin(phase) ** 2 + sharpness) / np.sqrt(1.0 + sharpness)


def gradient(field, points, step):
    """Returns the gradient by central differences over a regular tetrahedron."""
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=np.float64)
    total = np.zeros_like(points)
    for c in corners:
        p = points + step * c
        total += field(p[:, 0], p[:, 1], p[:, 2])[:, None] * c
    return total / (4.0 * step)
