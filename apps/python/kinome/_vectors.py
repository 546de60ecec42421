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
        raise check.fault(TypeError, name, " or ".join(takes.get(count, "finite numbers")
                                                       for count in counts), value)
    return array.ravel()


def normalized(vector, message):
    """Returns the unit vector, or that of each row. Raises ValueError with the message for a zero
    vector."""
    length = np.linalg.norm(vector, axis=-1, keepdims=True)
    if not (length > 0).all():
        raise ValueError(message)
    return vector / length


def _coordinate(axis):
    def set_coordinate(self, value):
        self[..., axis] = value
    return property(lambda self: self[..., axis][()], set_coordinate)


class _Triple(np.ndarray):
    """Three numbers as an array with the coordinates x, y and z; or n of them as an array of the shape
    (n, 3), from such an array or from three arrays of n numbers."""

    def __new__(cls, *values):
        if len(values) == 3 and any(np.ndim(one) > 0 for one in values):
            try:
                values = [np.stack(np.broadcast_arrays(*values), axis=-1)]
            except ValueError:
                raise check.fault(ValueError, cls.__name__, "three numbers or three arrays of n numbers",
                                  values) from None
        values = values[0] if len(values) == 1 else values
        what = cls.__name__
        if np.ndim(values) == 2 and np.shape(values)[1] == 3:
            return numbers(values, what, np.size(values)).reshape(-1, 3).view(cls)
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
    """An orthonormal basis: the tangents s and t, and the normal n; or an array of them. Frame3f(n)
    chooses tangents."""

    def __init__(self, *vectors):
        if len(vectors) not in (1, 3):
            raise TypeError(f"Frame3f takes a normal, or s, t and n, got {len(vectors)} vectors")
        if len(vectors) == 1:
            n = np.asarray(Normal3f(vectors[0]))
            n = normalized(n, "n is the zero vector")
            # Duff et al., Building an Orthonormal Basis, Revisited (2017)
            x, y, z = n[..., 0], n[..., 1], n[..., 2]
            sign = np.copysign(1., z)
            a = -1 / (sign + z)
            b = x * y * a
            vectors = (np.stack([1 + sign * x * x * a, sign * b, -sign * x], axis=-1),
                       np.stack([b, sign + y * y * a, -y], axis=-1), n)
        self.s, self.t = Vector3f(vectors[0]), Vector3f(vectors[1])
        self.n = Normal3f(vectors[2])

    @classmethod
    def of(cls, s, t, n):
        """Returns the frame of a Vector3f, a Vector3f and a Normal3f, without copies."""
        frame = cls.__new__(cls)
        frame.s, frame.t, frame.n = s, t, n
        return frame

    def _checked(self, v):
        """Returns directions as an array, if they are three numbers, or rows of them that fit those
        of the basis."""
        takes = "three numbers or an array of the shape (n, 3)"
        count = np.shape(self.n)[0] if np.ndim(self.n) == 2 else 1
        try:
            v = np.asarray(v)
        except ValueError:  # rows of different sizes
            raise check.fault(ValueError, "v", takes, v) from None
        if v.dtype.kind not in "fiu":
            raise check.fault(TypeError, "v", takes, v)
        if v.ndim not in (1, 2) or v.shape[-1] != 3:
            raise ValueError(f"v takes {takes}, got the shape {v.shape}")
        if v.ndim == 2 and len(v) != count and 1 not in (len(v), count):
            raise ValueError(f"v has {len(v)} rows, but the frame has {count}")
        return v

    def to_world(self, v):
        """Converts directions from the basis to the axes that it is given in."""
        v = self._checked(v)
        return (v[..., :1] * np.asarray(self.s) + v[..., 1:2] * np.asarray(self.t) +
                v[..., 2:] * np.asarray(self.n)).view(Vector3f)

    def to_local(self, v):
        """Converts directions to the basis."""
        v = self._checked(v)
        return np.stack([(v * np.asarray(axis)).sum(axis=-1) for axis in (self.s, self.t, self.n)],
                        axis=-1).view(Vector3f)

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
        """Returns the middle of the box; NaN if it is empty."""
        with np.errstate(invalid="ignore"):
            return ((self.min + self.max) / 2).view(Point3f)

    def extents(self):
        """Returns the box's size along each axis; -inf if it is empty, as in Mitsuba."""
        return (self.max - self.min).view(Vector3f)

    def volume(self):
        """Returns the box's volume; 0 if it is empty."""
        return float(np.prod(self.extents())) if self.valid() else 0.

    def surface_area(self):
        """Returns the area of the box's six sides; 0 if it is empty."""
        x, y, z = self.extents().tolist()
        return 2 * (x * y + y * z + z * x) if self.valid() else 0.

    def contains(self, point):
        point = numbers(point, "point", 3)
        return bool((self.min <= point).all() and (point <= self.max).all())

    def expand(self, other):
        """Expands the box so that it contains a point or a box."""
        if isinstance(other, BoundingBox3f):
            low, high = other.min, other.max
        else:
            low = high = numbers(other, "other", 3)
        self.min, self.max = Point3f(np.minimum(self.min, low)), Point3f(np.maximum(self.max, high))

    def __repr__(self):
        return f"BoundingBox3f[min={self.min.tolist()}, max={self.max.tolist()}]"
