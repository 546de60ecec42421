"""Scenes and renders of them."""
from . import _arguments as check
from . import _kinome
from ._describe import describe
from ._errors import Error
from ._mesh import Mesh
from ._object import Object, copied, load_object, of_path
from ._parameters import SceneParameters
from ._picture import Picture
from ._queries import Queries
from ._repr import Texts, box_text
from ._vectors import BoundingBox3f

# Limits of samples per pixel, as in samplers, and of renders for a variance and threads, as in the
# program's options.
MAX_SAMPLES, MAX_PARTS, MAX_THREADS = 2 ** 30, 1024, 4096


class Scene(Queries):
    """A scene from load_file(), load_string() or load_dict(). Only one Python thread at a time can render it."""

    def __init__(self, editor):
        self._editor = editor

    def _objects(self, category):
        return [Object(self._editor, path, plugin) for path, plugin, _ in self._editor.objects()
                if plugin.startswith(category + "/")]

    def _at(self, paths):
        """Returns the objects with these paths; None for ""."""
        return [of_path(self._editor, path) if path else None for path in paths]

    def sensors(self):
        """Returns the sensors. render() takes them, or their indices in this list. A scene without
        sensors has a default one, which is not listed."""
        return self._at(path for path in self._editor.sensors() if path)

    def shapes(self):
        """Returns the shapes, without those of shape groups."""
        return self._at(self._editor.shapes())

    def emitters(self):
        """Returns the emitters, including those of shapes."""
        return self._objects("emitter")

    def environment(self):
        """Returns the environment emitter, or None."""
        path = self._editor.environment()
        return of_path(self._editor, path) if path else None

    def integrator(self):
        """Returns the integrator; None if it is the default."""
        return next(iter(self._objects("integrator")), None)

    def bbox(self):
        """Returns the bounding box of all shapes."""
        return BoundingBox3f.of(self._editor.bounds(""))

    def __repr__(self):
        texts, bounds = Texts(self._editor), self._editor.bounds("")
        integrator = self.integrator()
        return "".join([
            "Scene[\n",
            f"  bbox = {box_text(*bounds)},\n" if bounds else "",
            f"  integrator = {texts.line(integrator._path)},\n" if integrator else "",
            texts.listed("sensors", [path for path in self._editor.sensors() if path]),
            texts.listed("shapes", self._editor.shapes()),
            texts.listed("emitters", [one._path for one in self.emitters()]),
            "]"])


def load_file(path, lenient=False, search_paths=(), update_scene=False, parallel=True,
              optimize=True, **defines):
    """Loads a scene file. Keywords replace each $name in it: load_file("scene.xml", spp=64).

    lenient: leaves out unsupported features of Mitsuba. search_paths: more folders for its files.
    update_scene, parallel and optimize are Mitsuba's, and have no effect.
    """
    return Scene(_kinome.Editor(check.path(path, "path"), _texts(defines),
                                check.paths(search_paths, "search_paths"), bool(lenient)))


def load_string(string, lenient=False, search_paths=(), parallel=True, optimize=True, **defines):
    """Loads a scene from the text of a scene file. Its files are searched for in `search_paths` and
    in the working directory. The other arguments are those of load_file()."""
    check.instance(string, "string", str, "the text of a scene file")
    return Scene(_kinome.Editor(string, "<string>", _texts(defines),
                                check.paths(search_paths, "search_paths"), bool(lenient)))


def _texts(defines):
    return {key: str(value).lower() if isinstance(value, bool) else str(value)
            for key, value in defines.items()}


def load_dict(description, search_paths=(), parallel=True, optimize=True):
    """Loads a scene or another object from a dict in Mitsuba's form. {"type": "scene", "ball":
    {"type": "sphere"}} is a Scene. {"type": "sphere"} is an Object, which can be a value in other
    dicts. parallel and optimize are Mitsuba's, and have no effect."""
    search_paths = check.paths(search_paths, "search_paths")
    if isinstance(description, (Scene, Object, Mesh)):
        return description
    kind = description.get("type") if hasattr(description, "get") else None
    try:
        if kind == "scene" or not isinstance(kind, str):
            return Scene(_kinome.Editor(describe(description), search_paths))
        return load_object(description, search_paths)
    except RecursionError:
        raise ValueError("the dict is nested too deeply, or contains itself") from None


def _editor(scene):
    check.instance(scene, "scene", Scene, "what load_file() or load_dict() gives")
    return scene._editor


def _integrator(integrator, editor):
    """Returns the description of an integrator, or None for that of the scene."""
    if integrator is None:
        return None
    check.instance(integrator, "integrator", (str, dict, Object), "an integrator's name or a dict")
    if isinstance(integrator, Object):
        if integrator._editor is editor and integrator.category == "integrator":
            return None
        integrator = integrator.as_dict()
    description = {"type": integrator} if isinstance(integrator, str) else copied(integrator)
    return describe(description, "", "integrator", "integrator")


def _sensor(sensor, editor):
    """Returns the editor that has the sensor, None for `editor` itself, and its index or id."""
    if isinstance(sensor, str):
        return None, sensor
    if isinstance(sensor, dict):
        sensor = load_object(sensor, [])
    if isinstance(sensor, Object) and sensor._path in sensor._editor.sensors():
        other = None if sensor._editor is editor else sensor._editor
        return other, str(sensor._editor.sensors().index(sensor._path))
    if not hasattr(sensor, "__index__"):
        raise check.fault(TypeError, "sensor", "an index, an id or a sensor", sensor)
    return None, str(check.whole(sensor, "sensor", 0, 2 ** 31 - 1, ", an id or a sensor"))


def _seed(seed):
    return check.whole(seed, "seed", 0, 2 ** 64 - 1)


def render(scene, integrator=None, sensor=0, spp=None, seed=0, time=None, error=None, variance=None,
           threads=0, progress=None, on_pass=None):
    """Renders a scene. Returns a Picture, a float32 array (height, width, channels).

    integrator: replaces the scene's; a name, a dict or an object. sensor: an index, an id, or a
    sensor of this scene, of another scene, or loaded alone. spp: samples per pixel, instead of the
    scene's. time: maximum time in seconds. error: the estimated relMSE to
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
    editor = _editor(scene)
    array, channels, stats = editor.render(
        _integrator(integrator, editor), *_sensor(sensor, editor), spp or 0, _seed(seed),
        time or 0., error or 0., variance or 0,
        check.whole(threads, "threads", 0, MAX_THREADS), progress,
        None if on_pass is None else give)
    return Picture(array, channels, stats)


def inspect(scene, x, y, integrator=None, sensor=0, seed=0):
    """Returns the light samples of the pixel at x, y. Each set of light points has a dict with the
    surface point ("position", "normal"), "clusters" and "samples" (lists of dicts)."""
    editor = _editor(scene)
    camera, index = _sensor(sensor, editor)
    if camera is not None:
        raise ValueError("sensor takes a sensor of this scene, got one of another scene")
    return editor.inspect(_integrator(integrator, editor), index, check.real(x, "x"),
                          check.real(y, "y"), _seed(seed))


def traverse(scene):
    """Returns the parameters of a scene or an object, which can be read and set."""
    if isinstance(scene, (Object, Mesh)):
        return scene.parameters()
    return SceneParameters(_editor(scene))
