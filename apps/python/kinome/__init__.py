"""Kinome, a plugin renderer that reads Mitsuba 3 scenes.

    import kinome
    scene = kinome.load_file("scene.xml", spp=64)
    picture = kinome.render(scene)          # a numpy array (height, width, channels)
    parameters = kinome.traverse(scene)
    parameters["floor.bsdf.reflectance.value"] = [0.5, 0.1, 0.1]
    parameters.update()
"""
import pathlib as _pathlib

from . import _kinome
from ._errors import Error

_here = _pathlib.Path(__file__).absolute().parent
# Of a wheel, or of a build folder.
_folders = [_here / "lib/kinome/plugins", _here.parent.parent / "plugins"]
_kinome.set_up(Error, [str(_folder) for _folder in _folders if (_folder / "bsdf").is_dir()])

__version__ = _kinome.version

from ._compare import compare  # noqa: E402
from ._picture import Picture  # noqa: E402
from ._scene import (Changes, Parameter, Scene, SceneParameters, inspect, load_dict,  # noqa: E402
                     load_file, render, traverse)
from ._transform import Transform  # noqa: E402

__all__ = ["Changes", "Error", "Parameter", "Picture", "Scene", "SceneParameters", "Transform",
           "compare", "inspect", "load_dict", "load_file", "plugins", "render", "set_log_level",
           "traverse"]


def plugins():
    """All plugins, as dicts: "category", "name", "doc" and "parameters", a list of dicts with
    "name", "type", "default" (as XML would have it, or None), "doc", "required", "ignored" (accepted
    without effect) and "choices" (the names that it may be; empty: it is no such name)."""
    return _kinome.plugins()


def set_log_level(level):
    """What is said on stderr: "quiet", "warn" (at first), "info" or "debug"."""
    levels = ("quiet", "warn", "info", "debug")
    if level not in levels:
        raise ValueError(f"level takes one of {', '.join(map(repr, levels))}, got {level!r}")
    _kinome.set_log_level(levels.index(level))
