"""Scenes of `validation/run.sh budgets`: any scene file, with integrator, samples and size set.

Scene files differ in the parameters that -D can set, if any. So this module writes a copy in which includes
are replaced by their contents, and the values are set. The copy is rendered with `-a` and the folders of the
originals.
"""
import dataclasses
import pathlib
import xml.etree.ElementTree as tree

from .problems import Problem
from .store import hash_of_files
from .tables import SCENES

MAX_INCLUDES = 8  # nesting depth
SAMPLE_COUNTS = ("sample_count", "sampleCount")
CROP = ("crop_width", "crop_height", "crop_offset_x", "crop_offset_y", "cropWidth", "cropHeight",
        "cropOffsetX", "cropOffsetY")


@dataclasses.dataclass(frozen=True)
class BudgetScene:
    name: str
    path: pathlib.Path

    def hash(self):
        """Returns a hash of the file and its neighbours, which it may include. Of files other than XML, only
        the names and sizes are hashed."""
        files = [path for path in self.path.parent.glob("[!.]*") if path.is_file()]
        sizes = " ".join(f"{path.name} {path.stat().st_size}" for path in sorted(files))
        return hash_of_files([path for path in files if path.suffix == ".xml"], sizes)


def scenes_of(words, cornell):
    """Returns the scenes for words: names of tables.SCENES, scene files, and folders, of which each file with
    a sensor is a scene. Without words, returns all of SCENES and the boxes of `cornell`
    (bounces.scene_of)."""
    known = {scene.name: BudgetScene(scene.name, scene.path) for scene in SCENES}
    found = []
    for word in words:
        path = pathlib.Path(word)
        if word in known:
            found.append(known[word])
        elif path.is_dir():
            found += [BudgetScene(name_of(file), file.resolve())
                      for file in sorted(path.rglob("*.xml")) if has_sensor(file)]
        elif path.is_file():
            found.append(BudgetScene(name_of(path), path.resolve()))
        else:
            raise Problem(f"no scene, file or folder {word}")
    return found or [*known.values(), *(BudgetScene(one.name, one.path) for one in cornell())]


def name_of(path):
    """Returns the names of the folder and the file, or only that of the folder if the file has the same name
    or is scene.xml."""
    folder = path.resolve().parent.name
    return folder if path.stem in (folder, "scene") else f"{folder}/{path.stem}"


def has_sensor(path):
    try:
        return tree.parse(path).getroot().find("sensor") is not None
    except tree.ParseError:
        return False


def derived(scene, folder, integrator, samples, size):
    """Writes the copy; returns its path, and the option of the program for the folders of the originals."""
    folders = []
    root = parsed(scene.path, folders)
    defaults = {one.get("name"): one.get("value") for one in root.iter("default")}
    inline(root, scene.path, defaults, folders, 0)
    for one in root.findall("integrator"):
        root.remove(one)
    added = tree.Element("integrator", type=integrator)
    tree.SubElement(added, "integer", name="max_depth", value="-1")
    root.append(added)
    sensor = root.find("sensor")
    if sensor is None:
        raise Problem(f"{scene.name}: has no sensor of its own")
    film, sampler = child(sensor, "film", "hdrfilm"), child(sensor, "sampler", "independent")
    if film.get("type") != "hdrfilm":
        raise Problem(f"{scene.name}: its film is a {film.get('type')}, not an hdrfilm")
    for name, value in zip(("width", "height"), size):
        put(film, (name,), value)
    for one in list(film):
        if one.get("name") in (*CROP, "file_format"):
            film.remove(one)
    put(sampler, SAMPLE_COUNTS, samples)
    folder.mkdir(parents=True, exist_ok=True)
    copy = folder / f"{scene.name.replace('/', '-')}-{integrator}.xml"
    tree.ElementTree(root).write(copy, encoding="utf-8")
    return copy, ("-a", ";".join(map(str, dict.fromkeys(folders))))


def parsed(path, folders):
    folders.append(path.parent)
    try:
        return tree.parse(path).getroot()
    except (OSError, tree.ParseError) as reason:
        raise Problem(f"{path.name}: {reason}") from reason


def inline(root, path, defaults, folders, depth):
    """Replaces includes by their contents. `derived` later removes their integrators."""
    if depth > MAX_INCLUDES:
        raise Problem(f"{path.name}: includes are nested too deeply")
    for place, one in reversed(list(enumerate(root))):
        if one.tag != "include":
            continue
        name = one.get("filename")
        for key in sorted(defaults, key=len, reverse=True):
            name = name.replace(f"${key}", defaults[key])
        included = (path.parent / name).resolve()
        content = parsed(included, folders)
        inline(content, included, defaults, folders, depth + 1)
        root[place:place + 1] = list(content)


def child(parent, tag, kind):
    found = parent.find(tag)
    return tree.SubElement(parent, tag, type=kind) if found is None else found


def put(parent, names, value):
    for one in list(parent):
        if one.get("name") in names:
            parent.remove(one)
    tree.SubElement(parent, "integer", name=names[0], value=str(value))
