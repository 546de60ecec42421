"""Kinome, a plugin renderer that reads Mitsuba 3 scenes."""
import os
from collections.abc import Callable, Iterator, Mapping, MutableMapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

class Error(Exception):
    """A mistake in a scene, a file or an argument. str() is "FILE:LINE:COLUMN: message"."""
    message: str
    """Without its place."""
    file: str
    """Of a dict: the path of its keys, as "scene.floor.bsdf"."""
    line: int
    """Counted from 1; 0: the file as a whole."""
    column: int
    all: list[Error]
    """Every mistake of a scene, this one first."""

class Transform:
    """An affine transform. Methods multiply from the right, so that the last one named is the
    first to be applied: Transform().translate([0, 1, 0]).rotate([0, 1, 0], 90)."""
    matrix: NDArray[np.float64]
    def __init__(self, matrix: ArrayLike | Transform | None = None) -> None: ...
    def __matmul__(self, other: ArrayLike | Transform) -> Transform: ...
    def translate(self, offset: ArrayLike) -> Transform:
        """Moves by (x, y, z)."""
    def scale(self, factor: ArrayLike) -> Transform:
        """By one factor, or by one for each axis."""
    def rotate(self, axis: ArrayLike, angle: float) -> Transform:
        """Around an axis through the origin; in degrees, counter-clockwise as seen against it."""
    def look_at(self, origin: ArrayLike, target: ArrayLike, up: ArrayLike) -> Transform:
        """Of a camera at `origin`, which looks at `target`."""
    def inverse(self) -> Transform:
        """The transform that undoes this one."""

class Picture(np.ndarray[Any, np.dtype[np.float32]]):
    """A float32 array (height, width, channels), linear Rec.709, rows from the top.
    picture["albedo"] is a layer by its name, without a copy. Crops, choices of channels, copies and
    what arithmetic makes of it number by number are Pictures, too; anything else has no names."""
    def __new__(cls, array: ArrayLike, channels: Sequence[str],
                stats: Mapping[str, Any] | None = None) -> Picture: ...
    channels: list[str]
    """Their names: "R", "G", "B", "albedo.R", …"""
    stats: dict[str, Any]
    """How it was made: "complete", "samples", "seconds", "relmse", …"""
    @property
    def rgb(self) -> NDArray[np.float32]:
        """The colour, without alpha and layers."""
    @property
    def layers(self) -> list[str]:
        """Names of what is beside the colour."""
    def write(self, path: str | os.PathLike[str]) -> None:
        """As .exr (with all channels, in single precision), .pfm or .png (8 bits, sRGB)."""

class Scene:
    """What load_file() and load_dict() give. Rendered by one thread of Python's at a time."""

class Parameter(NamedTuple):
    """What can be set: its path, type, the plugin that it is of, and what it means."""
    path: str
    type: str
    plugin: str
    doc: str
    choices: list[str]
    """All names that it may be; empty: it is no such name."""
    value: Any
    """What it is now; None: nothing, or an array, which is got by its path."""
    default: Any
    """What it is where nothing sets it; None: nothing."""
    is_set: bool
    """By the scene or by an edit."""
    low: float
    high: float
    """What its type allows (of a texture, of each channel); plugins may allow less."""

class Changes(NamedTuple):
    """What an update made anew."""
    made: list[str]
    """Plugins of the objects that were made, "category/name"."""
    refitted: int
    """Shapes that were kept, and got other triangles, or another material or light."""
    has_new_structure: bool
    """Whether the ray tracer's structure was built again."""

class SceneParameters(MutableMapping[str, Any]):
    """The parameters of a scene by their paths. Setting one is noted; update() makes it so."""
    def __getitem__(self, path: str) -> Any: ...
    def __setitem__(self, path: str, value: Any) -> None: ...
    def __delitem__(self, path: str) -> None: ...
    def objects(self) -> list[tuple[str, str]]:
        """All objects that have paths, and their plugins."""
    def textures(self) -> dict[str, str]:
        """The parameters that textures stand for, and the paths of those."""
    def unset(self, path: str) -> None:
        """Has nothing said of a parameter; takes off what was put around a BSDF."""
    def revert(self, path: str) -> None:
        """Has a parameter be again what the scene's file says."""
    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...
    def parameters(self) -> list[Parameter]:
        """All of them, with what is known of each."""
    def update(self, values: Mapping[str, Any] | None = None) -> Changes:  # type: ignore[override]
        """Sets `values`, if any, then makes anew what depends on all that was set. Where that
        can't be, an Error, and the scene is as it was."""
    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the scene, as the last update made it, as an XML file that gives the same picture,
        with edited meshes, pixels and includes beside it."""

def load_file(path: str | os.PathLike[str], lenient: bool = False,
              search_paths: Sequence[str | os.PathLike[str]] = (), **defines: object) -> Scene:
    """A scene file, each $name in it being what is given for it: load_file("scene.xml", spp=64).
    lenient: leave out what of Mitsuba's isn't here. search_paths: more folders for its files."""

def load_dict(scene: Mapping[str, Any],
              search_paths: Sequence[str | os.PathLike[str]] = ()) -> Scene:
    """A scene as a dict in Mitsuba's form: {"type": "scene", "ball": {"type": "sphere"}, …}."""

def render(scene: Scene, integrator: str | Mapping[str, Any] | None = None, sensor: int | str = 0,
           spp: int | None = None, seed: int = 0, time: float | None = None,
           error: float | None = None, variance: int | None = None, threads: int = 0,
           progress: Callable[[float], object] | None = None,
           on_pass: Callable[[Picture, float], object] | None = None) -> Picture:
    """Renders a scene. integrator: another one than the scene's. time: seconds; error: the relMSE
    to reach; variance: from how many independent parts to estimate it. progress(fraction) and
    on_pass(picture, samples) are called meanwhile. Ctrl-C gives the picture as it is."""

def inspect(scene: Scene, x: float, y: float, integrator: str | Mapping[str, Any] | None = None,
            sensor: int | str = 0, seed: int = 0) -> list[dict[str, Any]]:
    """Where the light samples of the pixel at x, y go."""

def traverse(scene: Scene) -> SceneParameters:
    """The scene's parameters, to look at and to set."""

def compare(a: Picture | Sequence[ArrayLike], b: Picture | Sequence[ArrayLike],
            alpha: float = 0.01) -> Any:
    """Whether two renderings have the same expectation: a verdict, which has `passed`."""

def plugins() -> list[dict[str, Any]]:
    """All plugins: "category", "name", "doc" and "parameters"."""

def set_log_level(level: str) -> None:
    """What is said on stderr: "quiet", "warn" (at first), "info" or "debug"."""
