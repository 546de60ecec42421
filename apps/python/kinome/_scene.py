"""Scenes, their parameters, and renders of them."""
import collections
import collections.abc

import numpy as np

from . import _arguments as check
from . import _kinome
from ._describe import describe, description_of
from ._errors import Error
from ._picture import Picture
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


# Limits of samples per pixel, as in samplers, and of renders for a variance and threads, as in the
# program's options.
MAX_SAMPLES, MAX_PARTS, MAX_THREADS = 2 ** 30, 1024, 4096


class Scene:
    """A scene from load_file() or load_dict(). Only one Python thread at a time can render it."""

    def __init__(self, editor):
        self._editor = editor


def load_file(path, lenient=False, search_paths=(), **defines):
    """Loads a scene file. Keywords replace each $name in it: load_file("scene.xml", spp=64).

    lenient: leaves out unsupported features of Mitsuba. search_paths: more folders for its files.
    """
    texts = {key: str(value).lower() if isinstance(value, bool) else str(value)
             for key, value in defines.items()}
    return Scene(_kinome.Editor(check.path(path, "path"), texts,
                                check.paths(search_paths, "search_paths"), bool(lenient)))


def load_dict(scene, search_paths=()):
    """Loads a scene from a dict in Mitsuba's form: {"type": "scene", "ball": {"type": "sphere"}}."""
    return Scene(_kinome.Editor(describe(scene), check.paths(search_paths, "search_paths")))


def _editor(scene):
    check.instance(scene, "scene", Scene, "what load_file() or load_dict() gives")
    return scene._editor


def _integrator(integrator):
    if integrator is None:
        return None
    check.instance(integrator, "integrator", (str, dict), "an integrator's name or a dict")
    description = {"type": integrator} if isinstance(integrator, str) else integrator
    return describe(description, "", "integrator", "integrator")


def _sensor(sensor):
    if isinstance(sensor, str):
        return sensor
    if not hasattr(sensor, "__index__"):
        raise check.fault(TypeError, "sensor", "an index or an id", sensor)
    return str(check.whole(sensor, "sensor", 0, 2 ** 31 - 1, ", or an id"))


def _seed(seed):
    return check.whole(seed, "seed", 0, 2 ** 64 - 1)


def render(scene, integrator=None, sensor=0, spp=None, seed=0, time=None, error=None, variance=None,
           threads=0, progress=None, on_pass=None):
    """Renders a scene. Returns a Picture, a float32 array (height, width, channels).

    integrator: replaces the scene's; a name or a dict. sensor: an index or an id. spp: samples per
    pixel, instead of the scene's. time: maximum time in seconds. error: the estimated relMSE to
    reach. With both, the render ends at the first limit that it reaches, as in the program.
    variance: number of independent renders (4 or more) from which to estimate the variance, which
    adds the channels "variance". threads: 0 for one per core.

    progress(fraction) is called about twenty times per second. on_pass(picture, samples) is called
    after each pass with the image so far: once with only spp=, after each independent render with
    variance=, and after passes of increasing size with error= and time=. It doesn't change the
    image, and its time counts toward time=. Both are called in the thread that called render().
    An exception in them ends the render. Ctrl-C ends it, too, and returns the unfinished image with
    stats["complete"] False.
    """
    if spp is not None:
        spp = check.whole(spp, "spp", 1, MAX_SAMPLES)
    if variance is not None:
        variance = check.whole(variance, "variance", 4, MAX_PARTS)
    time, error = (None if value is None else check.positive(value, name)
                   for value, name in ((time, "time"), (error, "error")))
    check.function(progress, "progress")
    check.function(on_pass, "on_pass")

    def give(array, channels, stats):
        on_pass(Picture(array, channels, stats), stats["samples"])
    array, channels, stats = _editor(scene).render(
        _integrator(integrator), _sensor(sensor), spp or 0, _seed(seed), time or 0., error or 0.,
        variance or 0, check.whole(threads, "threads", 0, MAX_THREADS), progress,
        None if on_pass is None else give)
    return Picture(array, channels, stats)


def inspect(scene, x, y, integrator=None, sensor=0, seed=0):
    """Returns the light samples of the pixel at x, y. Each set of light points has a dict with the
    surface point ("position", "normal"), "clusters" and "samples" (lists of dicts)."""
    return _editor(scene).inspect(_integrator(integrator), _sensor(sensor), check.real(x, "x"),
                                  check.real(y, "y"), _seed(seed))


def _known(path):
    return check.instance(path, "a parameter's path", str, "a string")


def _are_same(a, b):
    """Compares two values in the form of the compiled module."""
    if isinstance(a, tuple) and isinstance(b, tuple):
        return a[0] == b[0] and np.array_equal(a[1], b[1])
    return type(a) is type(b) and a == b


class SceneParameters(collections.abc.MutableMapping):
    """The parameters of a scene by their paths. update() applies the values that were set.

    A value can be a dict of a texture: {"type": "bitmap", "filename": "wood.png"}, or {"type": "ref",
    "id": "wood"}. A dict of a BSDF, set at the path of a BSDF, wraps that BSDF, for instance
    {"type": "normalmap", "normalmap": {"type": "bitmap", …}}.
    """

    def __init__(self, scene):
        self._editor = _editor(scene)

    def objects(self):
        """Returns all objects as pairs of their path and plugin, such as "bsdf/diffuse"."""
        return [(path, plugin) for path, plugin, _ in self._editor.objects()]

    def textures(self):
        """Returns a dict of the parameters whose value is a texture, with the path of the texture."""
        return dict(self._editor.textures())

    def unset(self, path):
        """Removes a parameter, so that its default applies. For a BSDF, removes the map around it.
        update() applies this."""
        self._editor.unset(_known(path))

    def revert(self, path):
        """Restores the parameter's value from the scene file or dict. update() applies this."""
        self._editor.revert(_known(path))

    def __getitem__(self, path):
        value = to_python(self._editor.get(_known(path)))
        slices = None if value is None else self._slices(path)
        return value if slices is None else value.reshape(slices, -1, *value.shape[1:])

    def _slices(self, path):
        """Returns the number of slices of a grid of voxels, None for other parameters."""
        owner, _, name = path.rpartition(".")
        return self.get(f"{owner}.slices") if name == "data" else None

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
        values = self._core_values(path, value)
        if len(values) == 1:
            self._editor.set(*values[0])
        else:
            self._editor.set_all(values)

    def _core_values(self, path, value):
        """Returns pairs of paths and values for the compiled module: one, or two for a grid of voxels."""
        if isinstance(value, dict):
            return [(path, description_of(value, _known(path)))]
        if self._slices(_known(path)) is not None:
            rows, slices = grid(value, path)
            return [(path, rows), (path.rpartition(".")[0] + ".slices", slices)]
        return [(path, to_core(value, path.rpartition(".")[2], path))]

    def __delitem__(self, path):
        raise TypeError("a scene's parameters can be set and unset, not deleted")

    def __iter__(self):
        return (row.path for row in self._rows())

    def __len__(self):
        return len(self._editor.parameters())

    def __repr__(self):
        rows = [(p.path, p.type, p.plugin) for p in self.parameters()]
        width = max((len(row[0]) for row in rows), default=0)
        return "\n".join(f"{path:<{width}}  {kind}, of {plugin}" for path, kind, plugin in rows)

    def parameters(self):
        """Returns all parameters with their descriptions."""
        return [row._replace(value=to_python(row.value), default=to_python(row.default))
                for row in self._rows()]

    def _rows(self):
        """Returns all parameters, with values in the form of the compiled module."""
        return [Parameter(*row) for row in self._editor.parameters()]

    def save(self, path):
        """Writes the scene, as of the last update, as an XML file that renders the same image.
        Comments and everything that wasn't edited stay as in the original file. Edited meshes,
        pixels and includes are written beside it."""
        self._editor.save(check.path(path, "path"))

    def _to_set(self, values):
        """Returns pairs of paths and values, without values that equal a default in effect."""
        pairs, defaults, nothing = [], None, object()
        for path, value in values.items():
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

    def update(self, values=None):
        """Sets `values`, if any, then applies all edits and returns the Changes. If that fails,
        raises Error, leaves the scene unchanged and discards `values`. Skips defaults and None that equal
        the current value, so that a whole dict of values can be passed back."""
        takes = "a dict of values by their paths"
        check.instance(values, "values", (collections.abc.Mapping, type(None)), takes)
        if values:
            self._editor.set_all(self._to_set(values))
        return Changes(*self._editor.update())


def traverse(scene):
    """Returns the scene's parameters, which can be read and set."""
    return SceneParameters(scene)
