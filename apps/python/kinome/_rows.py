"""Arguments and results with a row per ray or point. Single ones have no rows: their shapes are () and
(3,) in place of (n,) and (n, 3)."""
import numpy as np

from . import _arguments as check

MAX_FLOAT = np.finfo(np.float32).max
TAKES = {1: "a number or an array of the shape (n,)", 2: "two numbers or an array of the shape (n, 2)",
         3: "three numbers or an array of the shape (n, 3)"}


def rows_of(value, name, width):
    """Returns `value` as an array of float32 with the shape (width,) or (n, width), or () or (n,) if
    `width` is 1. Raises TypeError for anything but numbers, and ValueError for another shape."""
    if value is None:  # numpy makes NaN of it
        raise check.fault(TypeError, name, TAKES[width], value)
    try:
        array = np.asarray(value, np.float32)
    except TypeError:
        raise check.fault(TypeError, name, TAKES[width], value) from None
    except ValueError:  # a string, or rows of different sizes
        kind = TypeError if isinstance(value, (str, bytes)) else ValueError
        raise check.fault(kind, name, TAKES[width], value) from None
    if width == 1:
        array = array[..., None]
    if width == 3 and array.shape == ():
        array = np.broadcast_to(array, 3)
    if array.ndim not in (1, 2) or array.shape[-1] != width:
        shape = array.shape[:-1] if width == 1 else array.shape
        raise ValueError(f"{name} takes {TAKES[width]}, got the shape {shape}")
    return array[..., 0] if width == 1 else array


class Rows:
    """Arrays with a common number of rows. `count` is None if all of them are single ones."""

    def __init__(self, **arrays):
        """Takes pairs of a value and its width, by the name for messages."""
        self._arrays = {name: (rows_of(value, name, width), width)
                        for name, (value, width) in arrays.items()}
        counts = {name: array.shape[0] for name, (array, width) in self._arrays.items()
                  if array.ndim == (1 if width == 1 else 2)}
        self.count = max(counts.values(), default=None)
        if self.count is not None and 0 in counts.values():
            self.count = 0
        for name, count in counts.items():
            if count not in (1, self.count):
                raise ValueError(f"{name} has {count} rows, but others have {self.count}")

    def __getitem__(self, name):
        """Returns the rows of an argument, as a contiguous array."""
        array, width = self._arrays[name]
        shape = (self.size,) if width == 1 else (self.size, width)
        if array.shape != shape:
            array = array[None] if self.size == 1 else np.broadcast_to(array, shape)
        return np.ascontiguousarray(array)

    @property
    def size(self):
        return 1 if self.count is None else self.count

    def mask(self, active, endless=(), random=()):
        """Returns a mask with a row per point, or None if all are active. Raises ValueError for
        values in active rows that are not finite, or not from 0 to 1 in the arguments `random`.
        The arguments `endless` may be infinite."""
        mask = None if active is True else self._mask(active)
        for name in self._arrays:
            low, high, takes = ((0, 1, "random numbers from 0 to 1") if name in random else
                                (-np.inf, np.inf, "numbers, but not NaN") if name in endless else
                                (-MAX_FLOAT, MAX_FLOAT, "finite numbers"))
            self.check_range(name, low, high, takes, mask)
        return mask

    def check_range(self, name, low, high, takes, mask):
        """Raises ValueError if an active row of an argument has a value beyond low and high."""
        array, width = self._arrays[name]
        if array.size == 0 or (array.min() >= low and array.max() <= high):  # False for NaN
            return
        rows = array.reshape(-1, width)
        self.refuse(name, ~((low <= rows) & (rows <= high)).all(axis=1), takes, mask)

    def refuse(self, name, wrong, takes, mask):
        """Raises ValueError if an argument is wrong in an active row."""
        if mask is not None:
            wrong = wrong & mask
        if not wrong.any():
            return
        array, width = self._arrays[name]
        rows = array.reshape(-1, width)
        row = int(np.argmax(wrong))
        value = rows[row if len(rows) > 1 else 0]
        where = f" in row {row}" if self.count is not None else ""
        raise ValueError(f"{name} takes {takes}, got {(value[0] if width == 1 else value).tolist()}"
                         f"{where}")

    def _mask(self, active):
        takes = "a bool" if self.count is None else (
            f"a bool or an array of bools of the shape ({self.size},)")
        try:
            mask = np.asarray(active)
        except ValueError:  # rows of different sizes
            mask = None
        if mask is None or mask.dtype != bool or mask.ndim > 1:
            raise check.fault(TypeError, "active", takes, active)
        if mask.shape not in ((), (1,), (self.size,)):
            raise ValueError(f"active takes {takes}, got the shape {mask.shape}")
        return np.broadcast_to(mask, self.size)

    def result(self, values, kind=None, mask=None):
        """Returns flat values as an array with a row per point, or a single value. `kind` is the
        class of values with three numbers. Rows are 0 where `mask` is False."""
        values = values if kind is None else values.reshape(-1, 3)
        if mask is not None:
            values = np.where(mask if kind is None else mask[:, None], values, values.dtype.type(0))
        if self.count is None:
            values = values[0]
            return values.item() if kind is None else values.view(kind)
        return values if kind is None else values.view(kind)
