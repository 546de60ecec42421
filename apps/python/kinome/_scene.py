"""Scenes, their parameters, and renders of them."""
import collections
import collections.abc

import numpy as np

from . import _arguments as check
from . import _kinome
from ._describe import describe, description_of
from ._errors import Error
from ._picture import Picture
from ._values import to_core, to_python

Parameter = collections.namedtuple("Parameter",
                                   "path type plugin doc choices value default is_set low high")
Parameter.__doc__ = """What can be set: its path, type, the plugin that it is of, and what it means;
the names of which it is one, if it is a name (an empty list: it isn't, or any string will do);
its value (None: none, or an array, which is got by its path) and its default (None: none); whether
the scene or an edit sets it; the range that its type allows (of a texture, of each channel)."""

Changes = collections.namedtuple("Changes", "made refitted has_new_structure")
Changes.__doc__ = """What an update made anew: plugins of the objects that were made, the number of
shapes that were kept and got other triangles or another material or light, and whether the ray
tracer's structure was built again."""


# Samples a pixel, as parameters of samplers have them; parts that a variance comes from, and
# threads, as the program's options.
MOST_SAMPLES, MOST_PARTS, MOST_THREADS = 2 ** 30, 1024, 4096


class Scene:
    """What load_file() and load_dict() give. Rendered by one thread of Python's at a time."""

    def __init__(self, editor):
        self._editor = editor


def load_file(path, lenient=False, search_paths=(), **defines):
    """A scene file, each $name in it being what is given for it: load_file("scene.xml", spp=64).

    lenient: leave out what of Mitsuba's isn't here. search_paths: more folders for its files.
    """
    texts = {key: str(value).lower() if isinstance(value, bool) else str(value)
             for key, value in defines.items()}
    return Scene(_kinome.Editor(check.path(path, "path"), texts,
                                check.paths(search_paths, "search_paths"), bool(lenient)))


def load_dict(scene, search_paths=()):
    """A scene as a dict in Mitsuba's form: {"type": "scene", "ball": {"type": "sphere"}, …}."""
    return Scene(_kinome.Editor(describe(scene), check.paths(search_paths, "search_paths")))


def _editor(scene):
    check.instance(scene, "scene", Scene, "what load_file() or load_dict() gives")
    return scene._editor


def _integrator(integrator):
    if integrator is None:
        return None
    check.instance(integrator, "integrator", (str, dict), "an integrator's name or a dict")
    said = {"type": integrator} if isinstance(integrator, str) else integrator
    return describe(said, "", "integrator", "integrator")


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
    """Renders a scene into a Picture, a float32 array (height, width, channels).

    integrator: another one than the scene's, its name or a dict. sensor: an index or an id. spp:
    samples a pixel, in place of the scene's. time: seconds that the render may take; error: the
    relMSE to reach, by its own estimate; both as the program has them, where the first to be
    reached ends the render. variance: from how many independent parts (4 or more) the picture's
    variance is to be estimated, which adds channels "variance". threads: 0 is one for each core.

    progress(fraction) is called some twenty times a second; on_pass(picture, samples) after each
    pass over the whole picture, with what there is by then: once for spp alone, for variance= after
    each part, for error= and time= after passes that grow. It changes nothing in the picture, and
    its time is part of time=. Both are called by the thread that called render(); what they throw
    ends the render. Ctrl-C ends it, too, and gives the picture as it is, with stats["complete"]
    False.
    """
    if spp is not None:
        spp = check.whole(spp, "spp", 1, MOST_SAMPLES)
    if variance is not None:
        variance = check.whole(variance, "variance", 4, MOST_PARTS)
    time, error = (None if value is None else check.positive(value, name)
                   for value, name in ((time, "time"), (error, "error")))
    check.function(progress, "progress")
    check.function(on_pass, "on_pass")

    def give(array, channels, stats):
        on_pass(Picture(array, channels, stats), stats["samples"])
    array, channels, stats = _editor(scene).render(
        _integrator(integrator), _sensor(sensor), spp or 0, _seed(seed), time or 0., error or 0.,
        variance or 0, check.whole(threads, "threads", 0, MOST_THREADS), progress,
        None if on_pass is None else give)
    return Picture(array, channels, stats)


def inspect(scene, x, y, integrator=None, sensor=0, seed=0):
    """Where the light samples of the pixel at x, y go: for each set of light points a dict of the
    place that is lit ("position", "normal"), its "clusters" and its "samples" (lists of dicts)."""
    return _editor(scene).inspect(_integrator(integrator), _sensor(sensor), check.real(x, "x"),
                                  check.real(y, "y"), _seed(seed))


def _known(path):
    return check.instance(path, "a parameter's path", str, "a string")


def _are_same(a, b):
    """Of values as the compiled module takes them."""
    if isinstance(a, tuple) and isinstance(b, tuple):
        return a[0] == b[0] and np.array_equal(a[1], b[1])
    return type(a) is type(b) and a == b


class SceneParameters(collections.abc.MutableMapping):
    """The parameters of a scene by their paths. Setting one is noted; update() makes it so.

    A dict of a texture takes the place of a value: {"type": "bitmap", "filename": "wood.png"}, or
    {"type": "ref", "id": "wood"}. A dict of a BSDF, set at the path of a BSDF, is put around that,
    as {"type": "normalmap", "normalmap": {"type": "bitmap", …}} is.
    """

    def __init__(self, scene):
        self._editor = _editor(scene)

    def objects(self):
        """All objects that have paths: pairs of the path and the plugin, as "bsdf/diffuse"."""
        return [(path, plugin) for path, plugin, _ in self._editor.objects()]

    def textures(self):
        """The parameters that textures stand for, with the paths of those: a dict."""
        return dict(self._editor.textures())

    def unset(self, path):
        """Has nothing said of a parameter: its default counts. Of a BSDF: what was put around it is
        taken off. Noted for update()."""
        self._editor.unset(_known(path))

    def revert(self, path):
        """Has a parameter be again what the scene's file, or dict, says. Noted for update()."""
        self._editor.revert(_known(path))

    def __getitem__(self, path):
        return to_python(self._editor.get(_known(path)))

    def get(self, path, default=None):
        """The value, or `default` where there is no such parameter."""
        try:
            return self[path]
        except Error:
            return default

    def __contains__(self, path):
        nothing = object()
        return self.get(path, nothing) is not nothing

    def __setitem__(self, path, value):
        self._editor.set(path, self._core_value(path, value))

    @staticmethod
    def _core_value(path, value):
        if isinstance(value, dict):
            return description_of(value, _known(path))
        return to_core(value, _known(path).rpartition(".")[2], path)

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
        """All of them, with what is known of each."""
        return [row._replace(value=to_python(row.value), default=to_python(row.default))
                for row in self._rows()]

    def _rows(self):
        """Values as the core has them."""
        return [Parameter(*row) for row in self._editor.parameters()]

    def save(self, path):
        """Writes the scene, as the last update made it, as an XML file that gives the same picture:
        its own file with comments and all that wasn't edited as they were. Edited meshes, pixels and
        includes are written beside it."""
        self._editor.save(check.path(path, "path"))

    def _to_set(self, values):
        """Pairs of paths and values, without those that are there though nothing says them."""
        pairs, unsaid, nothing = [], None, object()
        for path, value in values.items():
            now = self.get(path, nothing)  # nothing: a texture, or a mistake
            if value is None and now is None:
                continue
            new = self._core_value(path, value)
            is_there = now is not None and now is not nothing
            if is_there and _are_same(new, self._core_value(path, now)):
                if unsaid is None:
                    unsaid = {row.path for row in self._rows()
                              if not row.is_set and row.type != "array"}
                if path in unsaid:
                    continue
            pairs.append((path, new))
        return pairs

    def update(self, values=None):
        """Sets `values`, if any, then makes anew what depends on all that was set: a Changes. Where
        that can't be, an Error, and the scene is as it was, with none of `values` noted. Defaults and
        None stay unsaid where they are what is there: a whole dict of values can be given back."""
        takes = "a dict of values by their paths"
        check.instance(values, "values", (collections.abc.Mapping, type(None)), takes)
        if values:
            self._editor.set_all(self._to_set(values))
        return Changes(*self._editor.update())


def traverse(scene):
    """The scene's parameters, to look at and to set."""
    return SceneParameters(scene)
