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
# Folders of a wheel and of a build folder.
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
    """Returns all plugins as dicts with "category", "name", "doc" and "parameters". The latter is a
    list of dicts with "name", "type", "default" (written as in XML, or None), "doc", "required",
    "ignored" (accepted without effect) and "choices" (the allowed names; empty if any value is)."""
    return _kinome.plugins()


def set_log_level(level):
    """Selects the messages on stderr: "quiet", "warn" (the default), "info" or "debug"."""
    levels = ("quiet", "warn", "info", "debug")
    if level not in levels:
        raise ValueError(f"level takes one of {', '.join(map(repr, levels))}, got {level!r}")
    _kinome.set_log_level(levels.index(level))
