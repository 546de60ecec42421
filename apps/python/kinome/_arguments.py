"""Checks of arguments: what is wrong is one line that says which, what it takes and what it got."""
import collections.abc
import math
import operator
import os


def _shown(value):
    text = repr(value)
    return text if len(text) <= 60 else f"{type(value).__name__} {text[:40]}…"


def fault(kind, name, takes, value):
    """The error: to be raised."""
    return kind(f"{name} takes {takes}, got {_shown(value)}")


def whole(value, name, least, most, special=""):
    """A whole number from `least` to `most`, also one of numpy's."""
    takes = f"a whole number from {least} to {most}{special}"
    try:
        number = operator.index(value)
    except TypeError:
        raise fault(TypeError, name, takes, value) from None
    if isinstance(value, bool):
        raise fault(TypeError, name, takes, value)
    if not least <= number <= most:
        raise fault(ValueError, name, takes, value)
    return number


def _float(value, name, takes):
    if not isinstance(value, (bool, str, bytes)):
        try:
            return float(value)
        except OverflowError:
            raise fault(ValueError, name, takes, value) from None
        except (TypeError, ValueError):
            pass
    raise fault(TypeError, name, takes, value)


def real(value, name):
    takes = "a finite number"
    number = _float(value, name, takes)
    if not math.isfinite(number):
        raise fault(ValueError, name, takes, value)
    return number


def positive(value, name):
    takes = "a finite number greater than 0"
    number = _float(value, name, takes)
    if not (number > 0 and math.isfinite(number)):
        raise fault(ValueError, name, takes, value)
    return number


def instance(value, name, kinds, takes):
    if not isinstance(value, kinds):
        raise fault(TypeError, name, takes, value)
    return value


def function(value, name):
    """A function or None."""
    if value is not None and not callable(value):
        raise fault(TypeError, name, "a function or None", value)
    return value


def path(value, name):
    try:
        return os.fsdecode(value)
    except TypeError:
        raise fault(TypeError, name, "a path", value) from None


def paths(values, name):
    """Folders. One alone would be taken apart, letter by letter."""
    takes = "a list of folders"
    if isinstance(values, (str, bytes, os.PathLike)) or not isinstance(values,
                                                                      collections.abc.Iterable):
        raise fault(TypeError, name, takes, values)
    return [path(one, name) for one in values]
