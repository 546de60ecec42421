"""Kinome, a plugin renderer that reads Mitsuba 3 scenes."""
import os
from collections.abc import Callable, Iterator, Mapping, MutableMapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

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
    """An affine transform. Methods multiply from the right, so the last one is applied first:
    Transform().translate([0, 1, 0]).rotate([0, 1, 0], 90) rotates, then translates."""
    matrix: NDArray[np.float64]
    def __init__(self, matrix: ArrayLike | Transform | None = None) -> None: ...
    def __matmul__(self, other: ArrayLike | Transform) -> Transform: ...
    def translate(self, offset: ArrayLike) -> Transform:
        """Moves by (x, y, z)."""
    def scale(self, factor: ArrayLike) -> Transform:
        """Scales by one factor, or by a factor for each axis."""
    def rotate(self, axis: ArrayLike, angle: float) -> Transform:
        """Rotates around an axis through the origin, by an angle in degrees. Positive angles are
        counter-clockwise when the axis points at the viewer."""
    def look_at(self, origin: ArrayLike, target: ArrayLike, up: ArrayLike) -> Transform:
        """Places a camera at `origin` and points it at `target`."""
    def inverse(self) -> Transform:
        """Returns the inverse transform."""

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
        """Writes .exr (all channels, single precision), .pfm or .png (8 bits, sRGB)."""

class Scene:
    """A scene from load_file() or load_dict(). Only one Python thread at a time can render it."""

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
              search_paths: Sequence[str | os.PathLike[str]] = (), **defines: object) -> Scene:
    """Loads a scene file. Keywords replace each $name in it: load_file("scene.xml", spp=64).
    lenient: leaves out unsupported features of Mitsuba. search_paths: more folders for its files."""

def load_dict(scene: Mapping[str, Any],
              search_paths: Sequence[str | os.PathLike[str]] = ()) -> Scene:
    """Loads a scene from a dict in Mitsuba's form: {"type": "scene", "ball": {"type": "sphere"}}."""

def render(scene: Scene, integrator: str | Mapping[str, Any] | None = None, sensor: int | str = 0,
           spp: int | None = None, seed: int = 0, time: float | None = None,
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

def traverse(scene: Scene) -> SceneParameters:
    """Returns the scene's parameters, which can be read and set."""

def compare(a: Picture | Sequence[ArrayLike], b: Picture | Sequence[ArrayLike],
            alpha: float = 0.01) -> Any:
    """Tests if two renders have the same expectation. Returns a verdict, which has `passed`."""

def plugins() -> list[dict[str, Any]]:
    """Returns all plugins: "category", "name", "doc" and "parameters"."""

def set_log_level(level: str) -> None:
    """Selects the messages on stderr: "quiet", "warn" (the default), "info" or "debug"."""
