"""Parameters of scenes and objects, which can be read and set."""
import collections
import collections.abc
import re

import numpy as np

from . import _aliases as aliases
from . import _arguments as check
from ._describe import description_of
from ._errors import Error
from ._mesh import keep_files
from ._values import grid, to_core, to_python

Parameter = collections.namedtuple("Parameter",
                                   "path type plugin doc choices value default is_set low high")
Parameter.__doc__ = """A parameter of a scene: its path, type, plugin and description; the allowed
names (empty if the values are not from a list of names); its value (None if there is none, and for
arrays, which parameters[path] returns) and its default (None if there is none); True if the scene or
an edit sets it; the range that its type allows (for textures in each channel)."""

Changes = collections.namedtuple("Changes", "made refitted has_new_structure")
Changes.__doc__ = """Result of an update: the plugins of the objects that were created; the number of
shapes that were kept with other triangles, or another material or emitter; True if the ray tracing
structure was rebuilt."""


def _are_same(a, b):
    """Compares two values in the form of the compiled module."""
    if isinstance(a, tuple) and isinstance(b, tuple):
        return a[0] == b[0] and np.array_equal(a[1], b[1])
    return type(a) is type(b) and a == b


class SceneParameters(collections.abc.MutableMapping):
    """The parameters of a scene, or of one of its objects, by their paths. update() applies the
    values that were set.

    A value can be a dict of a texture: {"type": "bitmap", "filename": "wood.png"}, or {"type": "ref",
    "id": "wood"}. A dict of a BSDF, set at the path of a BSDF, wraps that BSDF, for instance
    {"type": "normalmap", "normalmap": {"type": "bitmap", …}}.
    """

    def __init__(self, editor, prefix="", on_update=None):
        """The paths are those of the editor without `prefix`. on_update(edits) is called after
        each update; `edits` are pairs of paths and values."""
        self._editor = editor
        self._prefix = prefix
        self._on_update = on_update
        self._edits = []
        self._kept = None

    def _full(self, path):
        return self._prefix + check.instance(path, "a parameter's path", str, "a string")

    def objects(self):
        """Returns all objects as pairs of their path and plugin, such as "bsdf/diffuse"."""
        return [(path.removeprefix(self._prefix), plugin)
                for path, plugin, _ in self._editor.objects() if path.startswith(self._prefix)]

    def textures(self):
        """Returns a dict of the parameters whose value is a texture, with the path of the texture."""
        return {path.removeprefix(self._prefix): texture.removeprefix(self._prefix)
                for path, texture in self._editor.textures() if path.startswith(self._prefix)}

    def unset(self, path):
        """Removes a parameter, so that its default applies. For a BSDF, removes the map around it.
        update() applies this."""
        self._editor.unset(self._full(path))
        self._edits.append((path, aliases.UNSET))

    def revert(self, path):
        """Restores the parameter's value from the scene file or dict. update() applies this."""
        self._editor.revert(self._full(path))
        self._edits.append((path, aliases.REVERTED))

    def keep(self, keys):
        """Lists only the parameters of these paths, or that match one of these regular expressions.
        None lists all of them. The others can still be read and set."""
        keys = [keys] if isinstance(keys, str) else keys
        try:
            self._kept = None if keys is None else [re.compile(key) for key in keys]
        except re.error:
            raise check.fault(ValueError, "keys", "paths or regular expressions", keys) from None

    def __getitem__(self, path):
        full = self._full(path)
        if aliases.is_alias(self._editor, full):
            return aliases.get(self._editor, full)
        value = to_python(self._editor.get(full))
        slices = None if value is None else self._slices(path)
        return value if slices is None else value.reshape(slices, -1, *value.shape[1:])

    def _slices(self, path):
        """Returns the number of slices of a grid of voxels, None for other parameters."""
        owner, _, name = path.rpartition(".")
        return self.get(f"{owner}.slices" if owner else "slices") if name == "data" else None

    def get(self, path, default=None):
        """Returns the value, or `default` if there is no such parameter."""
        try:
            return self[path]
        except Error:
            return default

    def __contains__(self, path):
        nothing = object()
        return self.get(path, nothing) is not nothing

    def __setitem__(self, path, value):
        pairs = self._without_aliases({path: value})
        values = [core for part, one in pairs for core in self._core_values(part, one)]
        if len(values) == 1:
            self._editor.set(*values[0])
        else:
            self._editor.set_all(values)
        self._edits += pairs

    def _core_values(self, path, value):
        """Returns pairs of paths and values for the compiled module: one, or two for a grid of voxels."""
        full = self._full(path)
        if value is aliases.UNSET:
            return [(full, ("unset", None))]
        if hasattr(value, "as_dict"):
            value = value.as_dict()
        if isinstance(value, dict):
            return [(full, description_of(value, full))]
        if self._slices(path) is not None:
            rows, slices = grid(value, path)
            return [(full, rows), (full.rpartition(".")[0] + ".slices", slices)]
        return [(full, to_core(value, full.rpartition(".")[2], path))]

    def __delitem__(self, path):
        raise TypeError("a scene's parameters can be set and unset, not deleted")

    def __iter__(self):
        return (row.path for row in self._rows())

    def __len__(self):
        return len(self._rows())

    def __repr__(self):
        rows = [(p.path, p.type, p.plugin) for p in self.parameters()]
        width = max((len(row[0]) for row in rows), default=0)
        return "\n".join(f"{path:<{width}}  {kind}, of {plugin}" for path, kind, plugin in rows)

    def parameters(self):
        """Returns all parameters with their descriptions."""
        return [row._replace(value=to_python(row.value), default=to_python(row.default))
                for row in self._rows()]

    def _rows(self):
        """Returns all listed parameters, with values in the form of the compiled module."""
        rows = [Parameter(*row) for row in self._editor.parameters()]
        rows = [row._replace(path=row.path.removeprefix(self._prefix), value=self._in_effect(row))
                for row in rows if row.path.startswith(self._prefix)]
        return [row for row in rows if self._kept is None or
                any(key.pattern == row.path or key.fullmatch(row.path) for key in self._kept)]

    def _in_effect(self, row):
        """Returns a row's value, or that of a conductor's material in place of eta and k."""
        color = aliases.measured(self._editor, row.path) if row.plugin in aliases.CONDUCTORS else None
        return row.value if color is None else ("rgb", color.tolist())

    def save(self, path):
        """Writes the scene, as of the last update, as an XML file that renders the same image.
        Comments and everything that wasn't edited stay as in the original file. Edited meshes,
        pixels and includes are written beside it."""
        path = check.path(path, "path")
        self._editor.save(path)
        keep_files(path)

    def _to_set(self, values):
        """Returns pairs of paths and values for the compiled module, without values that equal a default in
        effect. `values` are pairs without aliases."""
        pairs, defaults, nothing = [], None, object()
        for path, value in values:
            now = self.get(path, nothing)  # `nothing` for a texture or an error
            if value is None and now is None:
                continue
            new = self._core_values(path, value)
            is_there = now is not None and now is not nothing
            if is_there and all(_are_same(a, b) for (_, a), (_, b) in
                                zip(new, self._core_values(path, now))):
                if defaults is None:
                    defaults = {row.path for row in self._rows()
                                if not row.is_set and row.type != "array"}
                if path in defaults:
                    continue
            pairs += new
        return pairs

    def _without_aliases(self, values):
        """Returns pairs of paths and values, in which aliases are replaced by their parts."""
        pairs, full_values = [], {self._full(path): value for path, value in values.items()}
        for path, value in values.items():
            full = self._full(path)
            if aliases.is_alias(self._editor, full):
                parts = aliases.values(self._editor, full, value, full_values)
            elif aliases.is_replaced(self._editor, full, value, full_values):
                continue
            else:
                parts = aliases.material_values(self._editor, full, value) or [(full, value)]
            pairs += [(part.removeprefix(self._prefix), one) for part, one in parts]
        return pairs

    def update(self, values=None):
        """Sets `values`, if any, then applies all edits and returns the Changes. If that fails,
        raises Error, leaves the scene unchanged and discards `values`. Skips defaults and None that
        equal the current value, so that a whole dict of values can be passed back."""
        takes = "a dict of values by their paths"
        check.instance(values, "values", (collections.abc.Mapping, type(None)), takes)
        if values:
            pairs = self._without_aliases(values)
            self._editor.set_all(self._to_set(pairs))
            self._edits += pairs
        edits, self._edits = self._edits, []
        changes = Changes(*self._editor.update())
        if self._on_update:
            self._on_update(edits)
        return changes
