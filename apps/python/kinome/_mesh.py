"""Meshes from arrays, and their PLY files."""
import atexit
import itertools
import os
import re
import shutil
import tempfile

import numpy as np

from . import _arguments as check
from . import _kinome
from ._errors import Error
from ._values import indices, numbers
from ._vectors import BoundingBox3f

ARRAYS = ("vertex_positions", "vertex_normals", "vertex_texcoords", "faces")
_NAMES = {"vertex_positions": "xyz", "vertex_normals": ("nx", "ny", "nz"), "vertex_texcoords": "uv"}
_numbers = itertools.count()
_folder = None


def _new_path():
    """Returns the path of a file that is deleted when Python ends."""
    global _folder  # noqa: PLW0603
    if _folder is None:
        _folder = tempfile.mkdtemp(prefix="kinome-")
        atexit.register(shutil.rmtree, _folder, ignore_errors=True)
    return os.path.join(_folder, f"mesh-{next(_numbers)}.ply")


def write_ply(arrays, path=None, attributes=()):
    """Writes a binary PLY file and returns its path, which is a temporary one by default.

    arrays: dict of the names in ARRAYS; empty normals and texture coordinates are left out.
    attributes: tuples ("vertex_color", numbers per vertex or face, values)."""
    faces = np.asarray(arrays["faces"], np.uint32).reshape(-1, 3)
    columns = {"vertex": [], "face": []}
    for name, properties in _NAMES.items():
        values = np.asarray(arrays.get(name, ()), np.float32).reshape(-1, len(properties))
        if values.size or name == "vertex_positions":
            columns["vertex"] += zip(properties, values.T)
    for name, size, values in attributes:
        element, _, rest = name.partition("_")
        values = np.asarray(values, np.float32).reshape(-1, size)
        columns[element] += ((f"{rest}_{i}", column) for i, column in enumerate(values.T))
    count = np.asarray(arrays["vertex_positions"]).size // 3
    vertices = np.zeros(count, [(name, "<f4") for name, _ in columns["vertex"]])
    triangles = np.zeros(len(faces), [("count", "u1"), ("indices", "<u4", 3)] +
                         [(name, "<f4") for name, _ in columns["face"]])
    triangles["count"], triangles["indices"] = 3, faces
    for table, element in ((vertices, "vertex"), (triangles, "face")):
        for name, column in columns[element]:
            table[name] = column
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {count}",
              *(f"property float {name}" for name, _ in columns["vertex"]),
              f"element face {len(faces)}", "property list uchar uint vertex_indices",
              *(f"property float {name}" for name, _ in columns["face"]), "end_header", ""]
    content = b"".join(("\n".join(header).encode(), vertices.tobytes(), triangles.tobytes()))
    if path is None:
        path = _new_path()
        with open(path, "wb") as file:
            file.write(content)
    else:
        _kinome.write_bytes(path, content)  # raises Error for a file that a loaded scene reads
    return path


def keep_files(scene):
    """Copies the temporary files that a saved scene file names beside it, and replaces the names."""
    if _folder is None:
        return
    with open(scene, encoding="utf-8") as file:
        text = file.read()
    names = set(re.findall(re.escape(_folder) + r"[/\\]mesh-\d+\.ply", text))
    stem = os.path.splitext(scene)[0]
    for name in names:
        with open(name, "rb") as file:
            copy = _copy_beside(stem + "-" + os.path.basename(name), file.read())
        text = text.replace(f'"{name}"', f'"{os.path.basename(copy)}"')
    if names:
        _kinome.write_bytes(scene, text.encode())


def _copy_beside(path, content):
    """Writes a file, with another number if a loaded scene reads this one. Returns its path."""
    stem = os.path.splitext(path)[0]
    for i in range(1, 1000):
        try:
            _kinome.write_bytes(path, content)
            break
        except Error:
            if not os.path.exists(path) or i == 999:
                raise
            path = f"{stem}_{i}.ply"
    return path


class Properties(dict):
    """Values and objects that Mesh() takes, by any names."""


class MeshParameters(dict):
    """Arrays of a mesh. update() checks that they belong together."""

    def update(self, values=None):
        """Sets `values`, if any, and checks the sizes of all arrays."""
        for path, value in dict(values or {}).items():
            self[path] = value
        vertices = self["vertex_positions"].size // 3
        for name, value in self.items():
            each = 2 if name == "vertex_texcoords" else 3
            is_optional = name in ("vertex_normals", "vertex_texcoords")
            if name not in ARRAYS or (is_optional and value.size == 0):
                continue
            if value.size % each or (is_optional and value.size != each * vertices):
                raise ValueError(f"{name} has {value.size} numbers, which doesn't fit {vertices} "
                                 "vertices")
        faces = self["faces"]
        if faces.size and faces.max() >= vertices:
            raise ValueError(f"faces has the index {faces.max()}, but there are only {vertices} "
                             "vertices")

    def __reduce__(self):  # a copy begins with all arrays, because __setitem__() adds none
        return MeshParameters, (dict(self),)

    def __setitem__(self, path, value):
        if path not in self:
            raise KeyError(f"{path}: the mesh has {', '.join(self)}")
        if path == "faces":
            super().__setitem__(path, indices(value, path).copy())
            return
        array = numbers(value)
        if array is None:
            raise check.fault(TypeError, path, "an array of numbers", value)
        if path not in ARRAYS and array.size != self[path].size:
            raise check.fault(ValueError, path, f"{self[path].size} numbers", value)
        super().__setitem__(path, np.array(array.ravel(), np.float32))


class Mesh:
    """A mesh from arrays. traverse(mesh) has its arrays, whose values are 0 at first. A mesh can be a
    value in the dict of a scene, which then contains a copy.

    props: a dict of values and objects, such as {"bsdf": {"type": "diffuse"}, "face_normals": True}.
    """

    def __init__(self, name, vertex_count, face_count, has_vertex_normals=False,
                 has_vertex_texcoords=False, props=None):
        self._name = check.instance(name, "name", str, "a string")
        vertex_count = check.whole(vertex_count, "vertex_count", 0, 2 ** 32 - 1)
        face_count = check.whole(face_count, "face_count", 0, 2 ** 32 - 1)
        sizes = {"vertex_positions": 3 * vertex_count,
                 "vertex_normals": 3 * vertex_count if has_vertex_normals else 0,
                 "vertex_texcoords": 2 * vertex_count if has_vertex_texcoords else 0}
        self._parameters = MeshParameters(
            {name: np.zeros(size, np.float32) for name, size in sizes.items()},
            faces=np.zeros(3 * face_count, np.uint32))
        self._attributes = {}
        self._props = dict(check.instance(props or {}, "props", dict, "a dict"))

    def parameters(self):
        return self._parameters

    def add_attribute(self, name, size, values):
        """Adds an attribute for the texture mesh_attribute. name: "vertex_…" or "face_…"; size: 1 or 3
        numbers per vertex or face. It is then one of the arrays of traverse(mesh)."""
        check.instance(name, "name", str, "a string")
        if name in ARRAYS or not re.fullmatch(r"(vertex|face)_\w+", name, re.ASCII):
            raise ValueError("name takes vertex_ or face_ and letters, digits or _, except for the "
                             f"names of the mesh's own arrays, got {name!r}")
        if size not in (1, 3):
            raise ValueError(f"size takes 1 or 3, got {size!r}")
        count = self.vertex_count() if name.startswith("vertex_") else self.face_count()
        array = numbers(values)
        if array is None or array.size != size * count:
            raise check.fault(ValueError, "values", f"{size * count} numbers", values)
        self._attributes[name] = size
        dict.__setitem__(self._parameters, name, np.array(array.ravel(), np.float32))

    def vertex_count(self):
        """Returns the number of vertices."""
        return self._parameters["vertex_positions"].size // 3

    def face_count(self):
        """Returns the number of triangles."""
        return self._parameters["faces"].size // 3

    def bbox(self):
        """Returns the bounding box."""
        points = self._parameters["vertex_positions"].reshape(-1, 3)
        return BoundingBox3f(points.min(axis=0), points.max(axis=0)) if len(points) else (
            BoundingBox3f())

    def write_ply(self, path):
        """Writes a PLY file with all arrays and attributes."""
        self._write(check.path(path, "path"))

    def _write(self, path=None):
        return write_ply(self._parameters, path, [(name, size, self._parameters[name])
                                                  for name, size in self._attributes.items()])

    def as_dict(self):
        """Returns the dict of a shape with the arrays as of now."""
        props = {key: value.as_dict() if hasattr(value, "as_dict") else value
                 for key, value in self._props.items()}
        return {"face_normals": not self._parameters["vertex_normals"].size, **props,
                "type": "ply", "filename": self._write()}

    def __repr__(self):
        box = self.bbox()
        return (f"Mesh[\n  name={self._name!r},\n  bbox={box},\n  vertex_count="
                f"{self.vertex_count()},\n  face_count={self.face_count()},\n  attributes="
                f"{list(self._attributes)}\n]")
