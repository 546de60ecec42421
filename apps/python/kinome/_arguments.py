"""Checks of arguments. An error message has one line: the argument, what it takes, and its value."""
import collections.abc
import math
import operator
import os


def _shown(value):
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else f"{type(value).__name__} {text[:40]}…"


def fault(kind, name, takes, value):
    """Returns an error for the caller to raise."""
    return kind(f"{name} takes {takes}, got {_shown(value)}")


def whole(value, name, low, high, special=""):
    """Checks for a whole number from `low` to `high`, which can be of a numpy type."""
    takes = f"a whole number from {low} to {high}{special}"
    try:
        number = operator.index(value)
    except TypeError:
        raise fault(TypeError, name, takes, value) from None
    if isinstance(value, bool):
        raise fault(TypeError, name, takes, value)
    if not low <= number <= high:
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


def scene(value, name):
    """Checks for a scene."""
    if not hasattr(value, "_emitters_of_points"):  # importing Scene here would be circular
        raise fault(TypeError, name, "what load_file() or load_dict() gives", value)
    return value


def function(value, name):
    """Checks for a function or None."""
    if value is not None and not callable(value):
        raise fault(TypeError, name, "a function or None", value)
    return value


def path(value, name):
    try:
        return os.fsdecode(value)
    except TypeError:
        raise fault(TypeError, name, "a path", value) from None


def paths(values, name):
    """Checks for a list of folders. Refuses a single string, which is iterable, too."""
    takes = "a list of folders"
    if isinstance(values, (str, bytes, os.PathLike)) or not isinstance(values,
                                                                      collections.abc.Iterable):
        raise fault(TypeError, name, takes, values)
    return [path(one, name) for one in values]
