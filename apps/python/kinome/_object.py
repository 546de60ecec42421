"""Objects: parts of a scene, or loaded alone."""
import numpy as np

from . import _arguments as check
from . import _kinome
from ._describe import Located, describe, fail, tag_of
from ._errors import Error
from ._evaluation import Evaluated
from ._aliases import REVERTED, UNSET
from ._mesh import ARRAYS, write_ply
from ._parameters import SceneParameters
from ._repr import Texts
from ._vectors import BoundingBox3f


class Object(Evaluated):
    """An object of a scene, or one that load_dict() loaded alone. Objects that were loaded alone can
    be values in the dicts of other objects, with their edits. Those dicts then contain copies."""

    def __init__(self, editor, path, plugin, source=None, search_paths=()):
        """`source` is the dict of an object that was loaded alone, with these search paths."""
        self._editor = editor
        self._path = path
        self._source = source
        self._original = copied(source)
        self._edits = {}  # values by paths, the latest last
        self._search_paths = search_paths
        self._lost_edit = None  # an edit that the dict can't express
        self.category, _, self.plugin = plugin.partition("/")

    def id(self):
        """Returns the id, or the path in the scene if the object has no id."""
        return self._source.get("id", "") if self._source is not None else self._path

    def __repr__(self):
        return Texts(self._editor).tree(self._path)

    def __eq__(self, other):
        return isinstance(other, Object) and (self._editor, self._path) == (
            other._editor, other._path)

    def __hash__(self):
        return hash((id(self._editor), self._path))

    def __deepcopy__(self, memo):
        return load_object(self.as_dict(), self._search_paths)

    def parameters(self):
        """Returns the object's parameters, as traverse() does."""
        on_update = None if self._source is None else self._record
        return SceneParameters(self._editor, self._path + ".", on_update)

    def _record(self, edits):
        for path, value in edits:
            self._edits.pop(path, None)
            if value is not REVERTED:
                self._edits[path] = value
        self._source, self._lost_edit = copied(self._original), None
        for path, value in self._edits.items():
            try:
                place(self._source, path.split("."), value)
            except ValueError:
                self._lost_edit = path

    def as_dict(self):
        """Returns the dict of an object that was loaded alone, with its edits."""
        if self._source is None:
            raise ValueError(f"{self._path} belongs to a scene; only objects that load_dict() loaded "
                             "alone can be parts of other dicts")
        if self._lost_edit:
            raise ValueError(f"the edit of {self._lost_edit} can't be part of a dict; set the "
                             "parameter of the scene")
        if not self._source.keys() & ARRAYS:
            return copied(self._source)
        # Plugins have no parameters for arrays, so the mesh becomes a file.
        parameters = self.parameters()
        parts = {key: value for key, value in self._source.items()
                 if key not in ARRAYS and key not in ("filename", "to_world")}
        file = write_ply({name: parameters[name] for name in ARRAYS})
        return copied({**parts, "type": "ply", "filename": file})

    def _part(self, role):
        path = self._editor.parts(self._path).get(role)
        return None if path is None else of_path(self._editor, path)

    def bsdf(self):
        """Returns the BSDF of a shape."""
        return self._part("bsdf")

    def emitter(self):
        """Returns the emitter of a shape, or None."""
        return self._part("emitter")

    def sensor(self):
        """Returns the sensor of a shape, or None."""
        return self._part("sensor")

    def film(self):
        """Returns the film of a sensor; None if it is the default."""
        return self._part("film")

    def sampler(self):
        """Returns the sampler of a sensor; None if it is the default."""
        return self._part("sampler")

    def rfilter(self):
        """Returns the reconstruction filter of a film; None if it is the default."""
        return self._part("rfilter")

    def interior_medium(self):
        """Returns the medium inside a shape, or None."""
        return self._part("interior")

    def exterior_medium(self):
        """Returns the medium around a shape, or None."""
        return self._part("exterior")

    def medium(self):
        """Returns the medium around a sensor, or None."""
        return self._part("medium")

    def is_emitter(self):
        """Returns True for a shape that emits light."""
        return self.emitter() is not None

    def bbox(self):
        """Returns the bounding box of a shape."""
        return BoundingBox3f.of(self._editor.bounds(self._path))

    def size(self):
        """Returns the width and height of a film."""
        return self.parameters()["size"]

    def crop_size(self):
        """Returns the width and height of a film's crop window."""
        return self.parameters()["crop_size"]

    def crop_offset(self):
        """Returns the upper left corner of a film's crop window."""
        return self.parameters()["crop_offset"]

    def vertex_count(self):
        """Returns the number of vertices of a mesh."""
        return self.parameters()["vertex_positions"].size // 3

    def face_count(self):
        """Returns the number of triangles of a mesh."""
        return self.parameters()["faces"].size // 3

    def write_ply(self, path):
        """Writes the triangles of a mesh to a PLY file, in world space."""
        parameters = self.parameters()
        write_ply({name: parameters[name] for name in ARRAYS}, check.path(path, "path"))


def of_path(editor, path):
    """Returns the object with this path."""
    return Object(editor, path, editor.plugin(path))


def copied(description):
    """Returns a deep copy of a dict, in which objects are replaced by their dicts."""
    if hasattr(description, "as_dict"):
        return description.as_dict()
    if isinstance(description, dict):
        return {key: copied(value) for key, value in description.items()}
    return description


def place(description, names, value):
    """Sets a value in a dict by its path, or removes it if it is UNSET."""
    name, child = names[0], description.get(names[0])
    is_object = isinstance(child, dict) and child.get("type") not in ("rgb", "spectrum")
    if len(names) == 1 or (names[1:] == ["value"] and not is_object):
        if value is UNSET:
            description.pop(name, None)
        else:
            description[name] = copied(value)
        return
    if not is_object:
        child = by_category(description, name)
    if child is None:
        raise ValueError(f"'{name}' is not a part of this dict")
    place(child, names[1:], value)


def by_category(description, name):
    """Returns the part of a dict that has the category as its name: "bsdf" or Mitsuba's "bsdf_0",
    "brdf_0" or "nested_bsdf", and "bsdf_1" for the second one. Returns None if there is none."""
    name = name.removeprefix("nested_").removesuffix("_0").replace("brdf", "bsdf")
    name = {"phase_function": "phase", "interior_medium": "medium"}.get(name, name)
    counts = {}
    for key, value in description.items():
        if not isinstance(value, dict) or value.get("type") in ("rgb", "spectrum", "ref"):
            continue
        tag = tag_of(value["type"], key, key)
        number = counts[tag] = counts.get(tag, -1) + 1
        if name == (f"{tag}_{number}" if number else tag):
            return value
    return None


def _attributes(description):
    """Returns the names of the attributes that textures in a dict read from their mesh."""
    if not isinstance(description, dict):
        return set()
    found = set().union(*map(_attributes, description.values()))
    return found | {description.get("name")} if description.get("type") == "mesh_attribute" else found


def _host_shape(part):
    """Returns a shape that has all attributes that the part reads."""
    attributes = sorted(filter(lambda name: isinstance(name, str), _attributes(part)))
    if not attributes:
        return {"type": "rectangle"}
    corners = {"vertex_positions": [0, 0, 0, 1, 0, 0, 0, 1, 0], "faces": [0, 1, 2]}
    values = {"vertex": [0.5] * 9, "face": [0.5] * 3}
    return {"type": "ply", "filename": write_ply(corners, attributes=[
        (name, 3, values[name.partition("_")[0]]) for name in attributes
        if name.partition("_")[0] in values])}


def _host(tag, part):
    """Returns a scene in which an object of this category is used."""
    in_sensor = {"type": "perspective", "film": {"type": "hdrfilm", "width": 1, "height": 1}}
    scene = {"type": "scene", "integrator": {"type": "path"}}
    if tag == "integrator":
        return {"type": "scene", "object": part}
    if tag in ("sensor", "shape", "emitter"):
        return {**scene, "object": part}
    if tag == "film":
        return {**scene, "host": {**in_sensor, "film": part}}
    if tag == "sampler":
        return {**scene, "host": {**in_sensor, "sampler": part}}
    if tag == "rfilter":
        in_sensor["film"]["rfilter"] = part
        return {**scene, "host": in_sensor}
    scene["integrator"] = {"type": "volpath"}
    if tag == "bsdf":
        return {**scene, "host": {**_host_shape(part), "bsdf": part}}
    if tag == "texture":
        return {**scene, "host": {**_host_shape(part),
                                  "emitter": {"type": "area", "radiance": part}}}
    medium = {"type": "homogeneous"}
    if tag == "medium":
        medium = part
    elif tag == "phase":
        medium["phase"] = part
    else:
        medium = {"type": "heterogeneous", "sigma_t": part}
    return {**scene, "host": {"type": "sphere", "bsdf": {"type": "null"}, "interior": medium}}


def _without_ids(description):
    return {key: _without_ids(value) if isinstance(value, dict) else value
            for key, value in description.items()
            if key != "id" or description.get("type") == "ref"}


def _is_nested_in_shape(plugin):
    """Returns True for sensors and emitters that must be part of a shape."""
    return plugin in ("area", "directionalarea", "irradiancemeter")


def add_defaults(camera):
    """Adds a film and a sampler to the dict of a camera that has none, so that they have parameters."""
    tags = {tag_of(part["type"], key, key) for key, part in camera.items()
            if isinstance(part, dict) and part.get("type") not in ("rgb", "spectrum", "ref")}
    for tag, plugin in (("film", "hdrfilm"), ("sampler", "independent")):
        if tag not in tags:
            camera.setdefault(tag, {"type": plugin})


def load_object(source, search_paths):
    """Loads an object alone: in a scene in which it is used, so that its values are checked."""
    source = copied(source)
    if not isinstance(source.get("type"), str):
        fail("object", "must be a dict with a 'type', a string")
    tag = tag_of(source["type"], "", "object")
    if source["type"] in ("perspective", "thinlens", "orthographic"):
        add_defaults(source)
    part = Located(_without_ids(source), tag)
    scene = _host(tag, part)
    if _is_nested_in_shape(source["type"]):
        scene["object"] = {"type": "rectangle", tag: part}
    editor = _kinome.Editor(describe(scene), search_paths)
    plugin = f"{tag}/{source['type']}"
    for path, found, _ in editor.objects():
        if found == plugin:
            return Object(editor, path, plugin, source, search_paths)
    raise Error(f"object: a {tag} '{source['type']}' can't be loaded alone",
                "can't be loaded alone", "object", 0, 0)
