"""Kinome, a plugin renderer that reads Mitsuba 3 scenes."""
import os
from collections.abc import Callable, Iterator, Mapping, MutableMapping, Sequence
from typing import Any, NamedTuple, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self

from . import util as util
from ._color import AlphaTransform as _AlphaTransform
from ._color import PixelFormat as _PixelFormat
from ._color import Struct as Struct
from ._evaluation import Evaluated as _Evaluated
from ._interaction import BSDFContext as BSDFContext
from ._interaction import BSDFFlags as BSDFFlags
from ._interaction import BSDFSample3f as BSDFSample3f
from ._interaction import DirectionSample3f as DirectionSample3f
from ._interaction import Ray3f as Ray3f
from ._interaction import SurfaceInteraction3f as SurfaceInteraction3f
from ._interaction import TransportMode as TransportMode
from ._queries import Queries as _Queries

_Loaded = TypeVar("_Loaded", Scene, Object, Mesh)

__version__: str

class Error(Exception):
    """An error in a scene, a file or an argument. str() is "FILE:LINE:COLUMN: message"."""
    message: str
    """Message without the location."""
    file: str
    """File; for a dict the path of its keys, such as "scene.floor.bsdf"."""
    line: int
    """Line, from 1; 0 for the file as a whole."""
    column: int
    all: list[Error]
    """All errors of a scene, this one first."""

class Transform:
    """A transform of points by a 4x4 matrix. Methods multiply from the right, so the last one is
    applied first: Transform().translate([0, 1, 0]).rotate([0, 1, 0], 90) rotates, then translates.
    All methods that return a transform can also be called on the class: Transform.scale(2)."""
    matrix: NDArray[np.float64]
    def __init__(self, matrix: ArrayLike | Transform | None = None) -> None: ...
    def __matmul__(self, other: Any) -> Any:
        """Transforms a Point3f, Vector3f or Normal3f, points of three numbers, or a transform."""
    def transform_affine(self, x: ArrayLike) -> Any:
        """Transforms as @, but ignores the last row of the matrix."""
    def translate(self, offset: ArrayLike) -> Transform:
        """Moves by (x, y, z)."""
    def scale(self, factor: ArrayLike) -> Transform:
        """Scales by one factor, or by a factor for each axis."""
    def rotate(self, axis: ArrayLike, angle: float) -> Transform:
        """Rotates around an axis through the origin, by an angle in degrees. Positive angles are
        counter-clockwise when the axis points at the viewer."""
    def look_at(self, origin: ArrayLike, target: ArrayLike, up: ArrayLike) -> Transform:
        """Places a camera at `origin` and points it at `target`."""
    def perspective(self, fov: float, near: float, far: float) -> Transform:
        """Projects a pyramid along z onto the box from (-1, -1, 0) to (1, 1, 1)."""
    def orthographic(self, near: float, far: float) -> Transform:
        """Maps the distances from `near` to `far` along z to the range from 0 to 1."""
    def to_frame(self, frame: Frame3f) -> Transform:
        """Converts from the coordinate axes to a frame: the x axis becomes its s."""
    def from_frame(self, frame: Frame3f) -> Transform:
        """Converts from a frame to the coordinate axes: its s becomes the x axis."""
    def inverse(self) -> Transform:
        """Returns the inverse transform."""
    @property
    def inverse_transpose(self) -> NDArray[np.float64]:
        """The transpose of the inverse matrix, which transforms normals."""
    def translation(self) -> Vector3f:
        """Returns the position of the origin after the transform."""
    def has_scale(self) -> bool:
        """Returns True if the transform changes lengths."""

ScalarTransform4f = Transform
Transform4f = Transform
ScalarAffineTransform4f = Transform
AffineTransform4f = Transform
ScalarProjectiveTransform4f = Transform
ProjectiveTransform4f = Transform

class _Triple(np.ndarray[Any, np.dtype[np.float64]]):
    """Three numbers as an array with the coordinates x, y and z; or n of them, as an array (n, 3)."""
    def __new__(cls, *values: ArrayLike) -> Self: ...
    x: Any
    y: Any
    z: Any

class Point3f(_Triple):
    """A point. Transforms rotate, scale and translate it."""
class Vector3f(_Triple):
    """A direction. Transforms rotate and scale it."""
class Normal3f(_Triple):
    """A normal of a surface. Transforms multiply it by the inverse transpose of their matrix."""

class Color3f(_Triple):
    """A linear colour in Rec.709."""
    r: Any
    g: Any
    b: Any

ScalarPoint3f = Point3f
ScalarVector3f = Vector3f
ScalarNormal3f = Normal3f

class Frame3f:
    """An orthonormal basis: the tangents s and t, and the normal n. Frame3f(n) chooses tangents."""
    s: Vector3f
    t: Vector3f
    n: Normal3f
    def __init__(self, *vectors: ArrayLike) -> None: ...
    def to_world(self, v: ArrayLike) -> Vector3f:
        """Converts directions from the basis to the axes that it is given in."""
    def to_local(self, v: ArrayLike) -> Vector3f:
        """Converts directions to the basis."""

class BoundingBox3f:
    """A box from the point `min` to the point `max`. An empty one has min > max."""
    min: Point3f
    max: Point3f
    def __init__(self, low: ArrayLike = ..., high: ArrayLike = ...) -> None: ...
    def valid(self) -> bool: ...
    def center(self) -> Point3f: ...
    def extents(self) -> Vector3f: ...
    def volume(self) -> float: ...
    def surface_area(self) -> float: ...
    def contains(self, point: ArrayLike) -> bool: ...
    def expand(self, other: ArrayLike | BoundingBox3f) -> None: ...

ScalarBoundingBox3f = BoundingBox3f
ScalarColor3f = Color3f
ScalarFrame3f = Frame3f

class Bitmap:
    """An image: an array (height, width, channels), rows from the top, with a pixel format."""
    PixelFormat = _PixelFormat
    AlphaTransform = _AlphaTransform
    UInt8: Struct.Type
    Int8: Struct.Type
    UInt16: Struct.Type
    Int16: Struct.Type
    UInt32: Struct.Type
    Int32: Struct.Type
    UInt64: Struct.Type
    Int64: Struct.Type
    Float16: Struct.Type
    Float32: Struct.Type
    Float64: Struct.Type
    def __init__(self, source: str | os.PathLike[str] | ArrayLike | Bitmap,
                 pixel_format: PixelFormat | None = None, channel_names: Sequence[str] = ()) -> None: ...
    def width(self) -> int: ...
    def height(self) -> int: ...
    def size(self) -> NDArray[np.int_]: ...
    def channel_count(self) -> int: ...
    def channel_names(self) -> list[str]: ...
    def pixel_count(self) -> int: ...
    def pixel_format(self) -> PixelFormat: ...
    def component_format(self) -> Struct.Type: ...
    def has_alpha(self) -> bool: ...
    def bytes_per_pixel(self) -> int: ...
    def buffer_size(self) -> int: ...
    def srgb_gamma(self) -> bool: ...
    def set_srgb_gamma(self, value: bool) -> None: ...
    def premultiplied_alpha(self) -> bool: ...
    def set_premultiplied_alpha(self, value: bool) -> None: ...
    def metadata(self) -> dict[str, Any]: ...
    def clear(self) -> None: ...
    def vflip(self) -> None: ...
    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]: ...
    def convert(self, pixel_format: PixelFormat | None = None,
                component_format: Struct.Type | None = None, srgb_gamma: bool | None = None,
                alpha_transform: AlphaTransform = AlphaTransform.Empty) -> Bitmap: ...
    def resample(self, res: ArrayLike, rfilter: Any = None) -> Bitmap: ...
    def split(self) -> list[tuple[str, Bitmap]]: ...
    def write(self, path: str | os.PathLike[str], quality: int = -1) -> None: ...
    def write_async(self, path: str | os.PathLike[str], quality: int = -1) -> None: ...

def srgb_to_linear(value: ArrayLike) -> NDArray[Any]:
    """Decodes values of sRGB from 0 to 1, in an array of any shape."""

def linear_to_srgb(value: ArrayLike) -> NDArray[Any]:
    """Encodes linear values as sRGB, in an array of any shape."""

def luminance(color: ArrayLike) -> NDArray[Any]:
    """Returns the luminance of linear Rec.709 colours: arrays with three channels as the last axis."""

class Picture(np.ndarray[Any, np.dtype[np.float32]]):
    """A float32 array (height, width, channels), linear Rec.709, rows from the top.
    picture["albedo"] is a layer by its name, without a copy. Crops, selections of channels, copies
    and results of element-wise arithmetic are Pictures, too. All other results have no names."""
    def __new__(cls, array: ArrayLike, channels: Sequence[str],
                stats: Mapping[str, Any] | None = None) -> Picture: ...
    channels: list[str]
    """Names of the channels: "R", "G", "B", "albedo.R", …"""
    stats: dict[str, Any]
    """Statistics of the render: "complete", "samples", "seconds", "relmse", …"""
    @property
    def rgb(self) -> NDArray[np.float32]:
        """The colour, without alpha and layers."""
    @property
    def layers(self) -> list[str]:
        """Names of the layers besides the colour."""
    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes a file in the format of its extension: .exr with all channels in single precision,
        or a format that Bitmap.write() supports."""

class Scene(_Queries):
    """A scene from load_file(), load_string() or load_dict(). Only one Python thread at a time can render it."""
    def sensors(self) -> list[Object]:
        """Returns the sensors. render() takes them, or their indices in this list."""
    def shapes(self) -> list[Object]:
        """Returns the shapes, without those of shape groups."""
    def emitters(self) -> list[Object]:
        """Returns the emitters, including those of shapes."""
    def environment(self) -> Object | None:
        """Returns the environment emitter."""
    def integrator(self) -> Object | None:
        """Returns the integrator; None if it is the default."""
    def bbox(self) -> BoundingBox3f:
        """Returns the bounding box of all shapes."""

class Object(_Evaluated):
    """An object of a scene, or one that load_dict() loaded alone."""
    category: str
    plugin: str
    def id(self) -> str: ...
    def parameters(self) -> SceneParameters: ...
    def as_dict(self) -> dict[str, Any]:
        """Returns the dict of an object that was loaded alone, with its edits."""
    def bsdf(self) -> Object | None: ...
    def emitter(self) -> Object | None: ...
    def sensor(self) -> Object | None: ...
    def film(self) -> Object | None: ...
    def sampler(self) -> Object | None: ...
    def rfilter(self) -> Object | None: ...
    def interior_medium(self) -> Object | None: ...
    def exterior_medium(self) -> Object | None: ...
    def medium(self) -> Object | None: ...
    def is_emitter(self) -> bool: ...
    def bbox(self) -> BoundingBox3f: ...
    def size(self) -> NDArray[np.int_]: ...
    def crop_size(self) -> NDArray[np.int_]: ...
    def crop_offset(self) -> NDArray[np.int_]: ...
    def vertex_count(self) -> int: ...
    def face_count(self) -> int: ...
    def write_ply(self, path: str | os.PathLike[str]) -> None: ...

class Properties(dict[str, Any]):
    """Values and objects that Mesh() takes, by any names."""

class Mesh:
    """A mesh from arrays. traverse(mesh) has its arrays, whose values are 0 at first."""
    def __init__(self, name: str, vertex_count: int, face_count: int,
                 has_vertex_normals: bool = False, has_vertex_texcoords: bool = False,
                 props: dict[str, Any] | None = None) -> None: ...
    def parameters(self) -> dict[str, Any]: ...
    def add_attribute(self, name: str, size: int, values: ArrayLike) -> None: ...
    def vertex_count(self) -> int: ...
    def face_count(self) -> int: ...
    def bbox(self) -> BoundingBox3f: ...
    def write_ply(self, path: str | os.PathLike[str]) -> None: ...
    def as_dict(self) -> dict[str, Any]: ...

class Parameter(NamedTuple):
    """A parameter of a scene, with the plugin that it belongs to."""
    path: str
    type: str
    plugin: str
    doc: str
    choices: list[str]
    """Allowed names; empty if the values are not from a list of names."""
    value: Any
    """Current value; None if there is none, and for arrays, which parameters[path] returns."""
    default: Any
    """Default value; None if there is none."""
    is_set: bool
    """True if the scene or an edit sets the parameter."""
    low: float
    high: float
    """Range that the type allows, for textures in each channel. Plugins may allow less."""

class Changes(NamedTuple):
    """Result of an update."""
    made: list[str]
    """Plugins of the objects that were created, as "category/name"."""
    refitted: int
    """Number of shapes that were kept with other triangles, or another material or emitter."""
    has_new_structure: bool
    """True if the ray tracing structure was rebuilt."""

class SceneParameters(MutableMapping[str, Any]):
    """The parameters of a scene by their paths. update() applies the values that were set."""
    def __getitem__(self, path: str) -> Any: ...
    def __setitem__(self, path: str, value: Any) -> None: ...
    def __delitem__(self, path: str) -> None: ...
    def objects(self) -> list[tuple[str, str]]:
        """Returns the paths of all objects, and their plugins."""
    def textures(self) -> dict[str, str]:
        """Returns the parameters whose value is a texture, with the path of the texture."""
    def unset(self, path: str) -> None:
        """Removes a parameter, so that its default applies; removes the map around a BSDF."""
    def revert(self, path: str) -> None:
        """Restores the value of the scene file."""
    def keep(self, keys: str | Sequence[str] | None) -> None:
        """Lists only the parameters of these paths, or that match one of these patterns."""
    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...
    def parameters(self) -> list[Parameter]:
        """Returns all parameters with their descriptions."""
    def update(self, values: Mapping[str, Any] | None = None) -> Changes:  # type: ignore[override]
        """Sets `values`, if any, then applies all edits. If that fails, raises Error and leaves the
        scene unchanged."""
    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the scene, as of the last update, as an XML file that renders the same image.
        Writes edited meshes, pixels and includes beside it."""

def load_file(path: str | os.PathLike[str], lenient: bool = False,
              search_paths: Sequence[str | os.PathLike[str]] = (), update_scene: bool = False,
              parallel: bool = True, optimize: bool = True, **defines: object) -> Scene:
    """Loads a scene file. Keywords replace each $name in it: load_file("scene.xml", spp=64).
    lenient: leaves out unsupported features of Mitsuba. search_paths: more folders for its files.
    update_scene, parallel and optimize are Mitsuba's, and have no effect."""

def load_string(string: str, lenient: bool = False,
                search_paths: Sequence[str | os.PathLike[str]] = (), parallel: bool = True,
                optimize: bool = True, **defines: object) -> Scene:
    """Loads a scene from the text of a scene file. Its files are searched for in `search_paths` and
    in the working directory. The other arguments are those of load_file()."""

@overload
def load_dict(description: Mapping[str, Any],
              search_paths: Sequence[str | os.PathLike[str]] = (), parallel: bool = True,
              optimize: bool = True) -> Any:
    """Loads a Scene, or another Object, from a dict in Mitsuba's form. parallel and optimize are
    Mitsuba's, and have no effect."""
@overload
def load_dict(description: _Loaded,
              search_paths: Sequence[str | os.PathLike[str]] = (), parallel: bool = True,
              optimize: bool = True) -> _Loaded: ...

def render(scene: Scene, integrator: str | Mapping[str, Any] | Object | None = None,
           sensor: int | str | Mapping[str, Any] | Object = 0, spp: int | None = None, seed: int = 0, time: float | None = None,
           error: float | None = None, variance: int | None = None, threads: int = 0,
           progress: Callable[[float], object] | None = None,
           on_pass: Callable[[Picture, float], object] | None = None) -> Picture:
    """Renders a scene. integrator: replaces the scene's. time: seconds; error: the relMSE to reach;
    variance: number of independent renders from which to estimate the variance.
    progress(fraction) and on_pass(picture, samples) are called during the render. Ctrl-C ends it
    and returns the unfinished image."""

def inspect(scene: Scene, x: float, y: float, integrator: str | Mapping[str, Any] | None = None,
            sensor: int | str = 0, seed: int = 0) -> list[dict[str, Any]]:
    """Returns the light samples of the pixel at x, y."""

@overload
def traverse(scene: Scene | Object) -> SceneParameters:
    """Returns the parameters of a scene or an object, which can be read and set."""
@overload
def traverse(scene: Mesh) -> dict[str, Any]: ...

def cornell_box() -> dict[str, Any]:
    """Returns the dict of a Cornell box for load_dict(), with Mitsuba's keys and values."""

def variants() -> list[str]:
    """Returns the names of Mitsuba's variants that render in RGB, as Kinome does."""

def variant() -> str:
    """Returns the variant that set_variant() chose, or "scalar_rgb"."""

def set_variant(*names: str) -> None:
    """Accepts the first name of variants(), so that programs for Mitsuba run. It has no effect."""

def compare(a: Picture | Sequence[ArrayLike], b: Picture | Sequence[ArrayLike],
            alpha: float = 0.01) -> Any:
    """Tests if two renders have the same expectation. Returns a verdict, which has `passed`."""

def denoise(picture: Picture, albedo: ArrayLike | None = None, normal: ArrayLike | None = None,
            variance: ArrayLike | None = None, threads: int = 0) -> Picture:
    """Denoises the colour by Open Image Denoise. albedo, normal, variance: arrays (height, width,
    3); by default, the picture's layers of these names."""

def plugins() -> list[dict[str, Any]]:
    """Returns all plugins: "category", "name", "doc" and "parameters"."""

def set_log_level(level: str) -> None:
    """Selects the messages on stderr: "quiet", "warn" (the default), "info" or "debug"."""
