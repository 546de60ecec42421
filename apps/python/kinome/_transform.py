"""Transforms: 4x4 matrices that are chained as in Mitsuba."""
import math
import types

import numpy as np

from . import _arguments as check
from ._vectors import Frame3f, Normal3f, Point3f, Vector3f, normalized, numbers


class _Chained:
    """A method that the class also has: Transform.translate(v) is Transform().translate(v)."""

    def __init__(self, function):
        self._function = function
        self.__doc__ = function.__doc__

    def __get__(self, transform, owner):
        return types.MethodType(self._function, owner() if transform is None else transform)


class Transform:
    """A transform of points by a 4x4 matrix. Methods multiply from the right, so the last one is
    applied first: Transform().translate([0, 1, 0]).rotate([0, 1, 0], 90) rotates, then translates.

    `transform @ x` transforms a Point3f, Vector3f or Normal3f. Three other numbers, and arrays of the
    shape (n, 3), are points. If x is a transform or a 4x4 matrix, the result is a transform.
    """

    def __init__(self, matrix=None):
        matrix = getattr(matrix, "matrix", matrix)
        self.matrix = np.eye(4) if matrix is None else numbers(matrix, "matrix", 16).reshape(4, 4)

    def __array__(self, dtype=None, copy=None):
        return self.matrix.astype(dtype or self.matrix.dtype, copy=bool(copy))

    def __matmul__(self, other):
        if isinstance(other, (Vector3f, Normal3f)):
            return self.transform_affine(other)
        points = None if hasattr(other, "matrix") else np.asarray(other)
        if points is None or points.ndim == 0 or points.shape[-1] != 3:
            return Transform(self.matrix @ Transform(other).matrix)
        moved = self.transform_affine(other)
        weight = points @ self.matrix[3, :3] + self.matrix[3, 3]
        return moved / np.asarray(weight)[..., None]

    def __eq__(self, other):
        return np.array_equal(self.matrix, other.matrix) if isinstance(other, Transform) else (
            NotImplemented)

    __hash__ = None

    def __repr__(self):
        return f"Transform({self.matrix.tolist()})"

    def transform_affine(self, x):
        """Transforms as `transform @ x`, but ignores the last row of the matrix, which is (0, 0, 0, 1)
        unless the transform is a perspective."""
        linear = self.matrix[:3, :3]
        if isinstance(x, Normal3f):
            return Normal3f(np.asarray(x) @ self.inverse().matrix[:3, :3])
        if isinstance(x, Vector3f):
            return Vector3f(np.asarray(x) @ linear.T)
        points = np.asarray(x, np.float64)
        if points.ndim == 0 or points.shape[-1] != 3:
            raise check.fault(TypeError, "x", "points of three numbers", x)
        moved = points @ linear.T + self.matrix[:3, 3]
        return Point3f(moved) if points.ndim == 1 else moved

    @_Chained
    def translate(self, offset):
        """Moves by (x, y, z)."""
        step = np.eye(4)
        step[:3, 3] = numbers(offset, "offset", 3)
        return self @ step

    @_Chained
    def scale(self, factor):
        """Scales by one factor, or by a factor for each axis."""
        return self @ np.diag([*np.broadcast_to(numbers(factor, "factor", 1, 3), 3), 1])

    @_Chained
    def rotate(self, axis, angle):
        """Rotates around an axis through the origin, by an angle in degrees. Positive angles are
        counter-clockwise when the axis points at the viewer."""
        x, y, z = normalized(numbers(axis, "axis", 3), "axis is the zero vector")
        angle = check.real(angle, "angle")
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        turned = np.eye(4)
        turned[:3, :3] += (math.sin(math.radians(angle)) * cross +
                           (1 - math.cos(math.radians(angle))) * cross @ cross)
        return self @ turned

    @_Chained
    def look_at(self, origin, target, up):
        """Places a camera at `origin` and points it at `target`."""
        origin, target, up = (numbers(vector, name, 3) for vector, name in
                              ((origin, "origin"), (target, "target"), (up, "up")))
        forward = normalized(target - origin, "origin and target are the same point")
        left = normalized(np.cross(up, forward), "up has the direction from origin to target")
        camera = np.eye(4)
        camera[:3, :] = np.stack([left, np.cross(forward, left), forward, origin], axis=1)
        return self @ camera

    @_Chained
    def perspective(self, fov, near, far):
        """Projects the pyramid with the opening angle `fov` in degrees, between the distances `near`
        and `far` along z, onto the box from (-1, -1, 0) to (1, 1, 1)."""
        fov = check.positive(fov, "fov")
        if fov >= 180:
            raise ValueError(f"fov takes an angle below 180 degrees, got {fov}")
        near, far = _distances(check.positive(near, "near"), far)
        projection = np.diag([1 / math.tan(math.radians(fov) / 2)] * 2 + [far / (far - near), 0])
        projection[2, 3], projection[3, 2] = -near * far / (far - near), 1
        return self @ projection

    @_Chained
    def orthographic(self, near, far):
        """Maps the distances from `near` to `far` along z to the range from 0 to 1."""
        near, far = _distances(check.real(near, "near"), far)
        return self.scale([1, 1, 1 / (far - near)]).translate([0, 0, -near])

    @_Chained
    def to_frame(self, frame):
        """Converts from the coordinate axes to a Frame3f: the x axis becomes its s."""
        return self @ _basis(frame)

    @_Chained
    def from_frame(self, frame):
        """Converts from a Frame3f to the coordinate axes: its s becomes the x axis."""
        return self @ _basis(frame).T

    def inverse(self):
        """Returns the inverse transform."""
        try:
            return Transform(np.linalg.inv(self.matrix))
        except np.linalg.LinAlgError:
            raise ValueError("this transform can't be inverted") from None

    @property
    def inverse_transpose(self):
        """The transpose of the inverse matrix, which transforms normals."""
        return self.inverse().matrix.T

    def translation(self):
        """Returns the position of the origin after the transform."""
        return Vector3f(self.matrix[:3, 3])

    def has_scale(self):
        """Returns True if the transform changes lengths."""
        linear = self.matrix[:3, :3]
        return not np.allclose(linear @ linear.T, np.eye(3), rtol=0, atol=1e-3)


def _distances(near, far):
    far = check.real(far, "far")
    if not far > near:
        raise ValueError(f"far takes a distance above near, which is {near}, got {far}")
    return near, far


def _basis(frame):
    check.instance(frame, "frame", Frame3f, "a Frame3f")
    basis = np.eye(4)
    basis[:3, :3] = np.stack([frame.s, frame.t, frame.n], axis=1)
    return basis
