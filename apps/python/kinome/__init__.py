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

from . import util  # noqa: E402
from ._bitmap import Bitmap, Struct  # noqa: E402
from ._color import linear_to_srgb, luminance, srgb_to_linear  # noqa: E402
from ._compare import compare  # noqa: E402
from ._denoise import denoise  # noqa: E402
from ._interaction import (BSDFContext, BSDFFlags, BSDFSample3f, DirectionSample3f,  # noqa: E402
                           Ray3f, SurfaceInteraction3f, TransportMode)
from ._mesh import Mesh, Properties  # noqa: E402
from ._object import Object  # noqa: E402
from ._parameters import Changes, Parameter, SceneParameters  # noqa: E402
from ._picture import Picture  # noqa: E402
from ._scene import (Scene, inspect, load_dict, load_file, load_string, render,  # noqa: E402
                     traverse)
from ._transform import Transform  # noqa: E402
from ._vectors import (BoundingBox3f, Color3f, Frame3f, Normal3f, Point3f,  # noqa: E402
                       Vector3f)

# Mitsuba's names.
ScalarTransform4f = Transform4f = Transform
ScalarAffineTransform4f = AffineTransform4f = Transform
ScalarProjectiveTransform4f = ProjectiveTransform4f = Transform
ScalarPoint3f, ScalarVector3f, ScalarNormal3f = Point3f, Vector3f, Normal3f
ScalarBoundingBox3f, ScalarColor3f, ScalarFrame3f = BoundingBox3f, Color3f, Frame3f

__all__ = ["AffineTransform4f", "BSDFContext", "BSDFFlags", "BSDFSample3f", "Bitmap",
           "BoundingBox3f", "Changes", "Color3f", "DirectionSample3f", "Error", "Frame3f", "Mesh",
           "Normal3f", "Object", "Parameter", "Picture", "Point3f", "ProjectiveTransform4f",
           "Properties", "Ray3f", "ScalarAffineTransform4f", "ScalarBoundingBox3f", "ScalarColor3f",
           "ScalarFrame3f", "ScalarNormal3f", "ScalarPoint3f", "ScalarProjectiveTransform4f",
           "ScalarTransform4f", "ScalarVector3f", "Scene", "SceneParameters", "Struct",
           "SurfaceInteraction3f", "Transform", "Transform4f", "TransportMode", "Vector3f",
           "compare", "cornell_box", "denoise", "inspect", "linear_to_srgb", "load_dict",
           "load_file", "load_string", "luminance", "plugins", "render", "set_log_level",
           "set_variant", "srgb_to_linear", "traverse", "util", "variant", "variants"]

cornell_box = util.cornell_box


def variants():
    """Returns the names of Mitsuba's variants that render in RGB, as Kinome does."""
    return ["scalar_rgb", "llvm_ad_rgb", "cuda_ad_rgb"]


def variant():
    """Returns the variant that set_variant() chose, or "scalar_rgb"."""
    return _variant


def set_variant(*names):
    """Accepts the first name of variants(), so that programs for Mitsuba run. It has no effect."""
    global _variant  # noqa: PLW0603
    known = [name for name in names if name in variants()]
    if not known:
        raise ValueError(f"set_variant takes one of {', '.join(variants())}, because Kinome renders "
                         f"in RGB; got {', '.join(map(repr, names))}")
    _variant = known[0]


_variant = "scalar_rgb"


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
