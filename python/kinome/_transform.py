"""Places and directions: 4x4 matrices that are chained as in Mitsuba."""
import math

import numpy as np


class Transform:
    """An affine transform. Methods multiply from the right, so that the last one named is the first
    to be applied: Transform().translate([0, 1, 0]).rotate([0, 1, 0], 90)."""

    def __init__(self, matrix=None):
        matrix = getattr(matrix, "matrix", matrix)
        self.matrix = np.eye(4) if matrix is None else np.array(matrix, np.float64).reshape(4, 4)

    def __array__(self, dtype=None, copy=None):
        return self.matrix if dtype is None else self.matrix.astype(dtype)

    def __matmul__(self, other):
        return Transform(self.matrix @ Transform(other).matrix)

    def __repr__(self):
        return f"Transform({self.matrix.tolist()})"

    def translate(self, offset):
        """Moves by (x, y, z)."""
        step = np.eye(4)
        step[:3, 3] = offset
        return self @ step

    def scale(self, factor):
        """By one factor, or by one for each axis."""
        return self @ np.diag([*np.broadcast_to(np.asarray(factor, np.float64), 3), 1])

    def rotate(self, axis, angle):
        """Around an axis through the origin; in degrees, counter-clockwise as seen against it."""
        x, y, z = np.asarray(axis, np.float64) / np.linalg.norm(axis)
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        turned = np.eye(4)
        turned[:3, :3] += (math.sin(math.radians(angle)) * cross +
                           (1 - math.cos(math.radians(angle))) * cross @ cross)
        return self @ turned

    def look_at(self, origin, target, up):
        """Of a camera at `origin`, which looks at `target`."""
        origin, target, up = (np.asarray(v, np.float64) for v in (origin, target, up))
        forward = (target - origin) / np.linalg.norm(target - origin)
        left = np.cross(up, forward)
        left /= np.linalg.norm(left)
        camera = np.eye(4)
        camera[:3, :] = np.stack([left, np.cross(forward, left), forward, origin], axis=1)
        return self @ camera

    def inverse(self):
        """The transform that undoes this one."""
        return Transform(np.linalg.inv(self.matrix))
