"""Points, directions and normals, which transforms treat differently."""
import numpy as np

from . import _arguments as check


def numbers(value, name, *counts):
    """Returns a new flat array of finite numbers. Its size must be one of `counts`."""
    try:
        array = np.array(value, np.float64)
    except (TypeError, ValueError):
        array = None
    if array is None or array.size not in counts or not np.isfinite(array).all():
        takes = {16: "a 4x4 matrix", 3: "three numbers", 1: "a number"}
        raise check.fault(TypeError, name, " or ".join(takes[count] for count in counts), value)
    return array.ravel()


def normalized(vector, message):
    """Returns the unit vector. Raises ValueError with the message for the zero vector."""
    length = np.linalg.norm(vector)
    if not length > 0:
        raise ValueError(message)
    return vector / length


def _coordinate(axis):
    def set_coordinate(self, value):
        self[axis] = value
    return property(lambda self: self[axis], set_coordinate)


class _Triple(np.ndarray):
    """Three numbers as an array with the coordinates x, y and z."""

    def __new__(cls, *values):
        values = values[0] if len(values) == 1 else values
        what = cls.__name__
        return np.array(np.broadcast_to(numbers(values, what, 1, 3), 3)).view(cls)

    x, y, z = (_coordinate(axis) for axis in range(3))


class Point3f(_Triple):
    """A point. Transforms rotate, scale and translate it."""


class Vector3f(_Triple):
    """A direction. Transforms rotate and scale it."""


class Normal3f(_Triple):
    """A normal of a surface. Transforms multiply it by the inverse transpose of their matrix."""


class Color3f(_Triple):
    """A linear colour in Rec.709."""

    r, g, b = (_coordinate(axis) for axis in range(3))


class Frame3f:
    """An orthonormal basis: the tangents s and t, and the normal n. Frame3f(n) chooses tangents."""

    def __init__(self, *vectors):
        if len(vectors) not in (1, 3):
            raise TypeError(f"Frame3f takes a normal, or s, t and n, got {len(vectors)} vectors")
        if len(vectors) == 1:
            n = normalized(numbers(vectors[0], "n", 3), "n is the zero vector")
            # Duff et al., Building an Orthonormal Basis, Revisited (2017)
            sign = np.copysign(1., n[2])
            a = -1 / (sign + n[2])
            b = n[0] * n[1] * a
            vectors = ([1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]],
                       [b, sign + n[1] * n[1] * a, -n[1]], n)
        self.s, self.t = Vector3f(vectors[0]), Vector3f(vectors[1])
        self.n = Normal3f(vectors[2])

    def __repr__(self):
        return f"Frame3f[s={self.s.tolist()}, t={self.t.tolist()}, n={self.n.tolist()}]"


class BoundingBox3f:
    """A box from the point `min` to the point `max`. An empty one has min > max."""

    def __init__(self, low=np.inf, high=-np.inf):
        self.min, self.max = (self._corner(name, one) for name, one in (("low", low), ("high", high)))

    @staticmethod
    def _corner(name, value):
        """Returns a corner, whose coordinates can be infinite."""
        try:
            return np.array(np.broadcast_to(np.asarray(value, np.float64), 3)).view(Point3f)
        except (TypeError, ValueError):
            raise check.fault(TypeError, name, "three numbers or a number", value) from None

    @classmethod
    def of(cls, bounds):
        """Returns the box of a pair of points, or an empty one of None."""
        return cls() if bounds is None else cls(*bounds)

    def valid(self):
        """Returns True unless the box is empty."""
        return bool((self.min <= self.max).all())

    def center(self):
        return Point3f((self.min + self.max) / 2)

    def extents(self):
        """Returns the box's size along each axis."""
        return Vector3f(self.max - self.min)

    def contains(self, point):
        point = numbers(point, "point", 3)
        return bool((self.min <= point).all() and (point <= self.max).all())

    def expand(self, other):
        """Expands the box so that it contains a point or a box."""
        low, high = (other.min, other.max) if isinstance(other, BoundingBox3f) else (other, other)
        self.min, self.max = Point3f(np.minimum(self.min, low)), Point3f(np.maximum(self.max, high))

    def __repr__(self):
        return f"BoundingBox3f[min={self.min.tolist()}, max={self.max.tolist()}]"
