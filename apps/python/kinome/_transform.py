"""Transforms: 4x4 matrices that are chained as in Mitsuba."""
import math

import numpy as np

from . import _arguments as check


def _numbers(value, name, *counts):
    """Returns a new array of finite numbers. Its size must be one of `counts`."""
    try:
        array = np.array(value, np.float64)
    except (TypeError, ValueError):
        array = None
    if array is None or array.size not in counts or not np.isfinite(array).all():
        takes = {16: "a 4x4 matrix", 3: "three numbers", 1: "a number"}
        raise check.fault(TypeError, name, " or ".join(takes[count] for count in counts), value)
    return array.ravel()


def _direction(vector, why_not):
    length = np.linalg.norm(vector)
    if not length > 0:
        raise ValueError(why_not)
    return vector / length


class Transform:
    """An affine transform. Methods multiply from the right, so the last one is applied first:
    Transform().translate([0, 1, 0]).rotate([0, 1, 0], 90) rotates, then translates."""

    def __init__(self, matrix=None):
        matrix = getattr(matrix, "matrix", matrix)
        self.matrix = np.eye(4) if matrix is None else _numbers(matrix, "matrix", 16).reshape(4, 4)

    def __array__(self, dtype=None, copy=None):
        return self.matrix if dtype is None else self.matrix.astype(dtype)

    def __matmul__(self, other):
        return Transform(self.matrix @ Transform(other).matrix)

    def __repr__(self):
        return f"Transform({self.matrix.tolist()})"

    def translate(self, offset):
        """Moves by (x, y, z)."""
        step = np.eye(4)
        step[:3, 3] = _numbers(offset, "offset", 3)
        return self @ step

    def scale(self, factor):
        """Scales by one factor, or by a factor for each axis."""
        return self @ np.diag([*np.broadcast_to(_numbers(factor, "factor", 1, 3), 3), 1])

    def rotate(self, axis, angle):
        """Rotates around an axis through the origin, by an angle in degrees. Positive angles are
        counter-clockwise when the axis points at the viewer."""
        x, y, z = _direction(_numbers(axis, "axis", 3), "axis is the zero vector")
        angle = check.real(angle, "angle")
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        turned = np.eye(4)
        turned[:3, :3] += (math.sin(math.radians(angle)) * cross +
                           (1 - math.cos(math.radians(angle))) * cross @ cross)
        return self @ turned

    def look_at(self, origin, target, up):
        """Places a camera at `origin` and points it at `target`."""
        origin, target, up = (_numbers(vector, name, 3) for vector, name in
                              ((origin, "origin"), (target, "target"), (up, "up")))
        forward = _direction(target - origin, "origin and target are the same point")
        left = _direction(np.cross(up, forward), "up has the direction from origin to target")
        camera = np.eye(4)
        camera[:3, :] = np.stack([left, np.cross(forward, left), forward, origin], axis=1)
        return self @ camera

    def inverse(self):
        """Returns the inverse transform."""
        try:
            return Transform(np.linalg.inv(self.matrix))
        except np.linalg.LinAlgError:
            raise ValueError("this transform can't be inverted") from None
