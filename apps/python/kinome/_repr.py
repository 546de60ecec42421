"""Readable text about scenes and their objects."""
import numpy as np

from ._values import to_python

MAX_LISTED = 20  # objects of a category in the text of a scene


def value_text(value):
    value = to_python(value)
    matrix = getattr(value, "matrix", None)
    if matrix is not None:
        return value_text(matrix)
    if isinstance(value, np.ndarray) and value.ndim > 0:
        if value.size > 16:
            return f"array of the shape {value.shape}"
        if value.dtype.kind == "f":  # rounding errors of rotations
            value = np.where(np.abs(value) < 1e-9 * np.abs(value).max(), 0, value)
        return f"[{', '.join(value_text(row) for row in value)}]"
    if isinstance(value, (float, np.floating)):
        return f"{value:.6g}"
    return repr(value)


def box_text(low, high):
    return f"BoundingBox3f[min={value_text(np.array(low))}, max={value_text(np.array(high))}]"


class Texts:
    """Texts about the objects of an editor."""

    def __init__(self, editor):
        self._plugins = {path: plugin for path, plugin, _ in editor.objects()}
        self._values = {path: [] for path in self._plugins}
        for path, _, plugin, _, _, value, _, is_set, *_ in editor.parameters():
            owner = path.removesuffix(".value").rpartition(".")[0]
            while owner and self._plugins.get(owner) != plugin:
                owner = owner.rpartition(".")[0]
            if owner and is_set and value is not None:
                name = path.removeprefix(owner + ".").removesuffix(".value")
                self._values[owner].append(f"{name}={value_text(value)}")

    def line(self, path):
        """Returns a line about an object."""
        plugin = self._plugins[path].partition("/")[2]
        return f"{plugin}[{', '.join(self._values[path])}]"

    def tree(self, path, indent=""):
        """Returns lines about an object and the objects in it."""
        plugin = self._plugins[path].partition("/")[2]
        rows = list(self._values[path])
        rows += [f"{part.removeprefix(path + '.')}={self.tree(part, indent + '  ')}"
                 for part in self._plugins
                 if part.startswith(path + ".") and "." not in part.removeprefix(path + ".")]
        if not rows:
            return f"{plugin}[]"
        return "".join([f"{plugin}[\n", *(f"{indent}  {row},\n" for row in rows), f"{indent}]"])

    def listed(self, name, paths):
        """Returns lines about several objects."""
        rows = [f"    {path}: {self.line(path)},\n" for path in paths[:MAX_LISTED]]
        if len(paths) > MAX_LISTED:
            rows.append(f"    and {len(paths) - MAX_LISTED} more\n")
        return "".join([f"  {name} = [\n", *rows, "  ],\n"]) if rows else f"  {name} = [],\n"
