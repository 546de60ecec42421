"""Finds the surfaces that are visible in pixels, from renders with the integrator `aov` and one camera ray per
pixel. Computes the patches of each tile as clustered with product does (product/tiles/patches.cpp), the patches that
its pilot would find, and the viewing angle."""
import dataclasses
import math
import re
import xml.etree.ElementTree as tree

import numpy as np

from .problems import Problem

SIDE = 4  # pixels per side of a tile
MAX_PATCHES = 48  # per tile
# A patch contains points whose normal is within COSINE of that of its first point. A patch of the pilot has the
# cone of its points' normals instead, widened by CONE_FACTOR and CONE_MARGIN (radians). The maximum distance of a
# point from the plane of its patch is PLANE_WIDTHS times the width of the tile.
COSINE, CONE_FACTOR, CONE_MARGIN, PLANE_WIDTHS = 0.95, 1.3, 0.0175, 1
# Pairs (limit, camera rays per pixel of the pilot). The first pair whose limit exceeds the rays per pixel of the
# whole render is used. Below the first limit, a pilot probes some of the pixels at most, which counts as none.
PILOT = ((10, 0), (24, 1), (60, 2), (math.inf, 4))
# BSDFs without a lobe. All others have one, or are mirrors.
DULL = {"diffuse", "twosided", "normalmap", "bumpmap", "mask"}


@dataclasses.dataclass
class Points:
    """First hits, as arrays (renders, rows, columns, …). `shape`: 0 for none; `normal`: facing the camera;
    `cosine`: of the viewing angle; `width`: of a tile at that distance."""

    shape: np.ndarray
    normal: np.ndarray
    position: np.ndarray
    cosine: np.ndarray
    width: np.ndarray


@dataclasses.dataclass(frozen=True)
class Camera:
    origin: tuple
    pixel: float  # width of a pixel at a distance of 1


def camera_of(path, columns):
    """Returns the Camera of a scene whose sensor has a `lookat`. Raises Problem."""
    sensor = resolved(path).find("sensor")
    places = [] if sensor is None else sensor.findall(".//lookat")
    fov = None if sensor is None else sensor.find("float[@name='fov']")
    if len(places) != 1 or fov is None:
        raise Problem(f"{path.name}: its sensor has no lookat or no fov, which maps need")
    origin = tuple(float(x) for x in re.split(r"[,\s]+", places[0].get("origin").strip()))
    return Camera(origin, 2 * math.tan(math.radians(float(fov.get("value"))) / 2) / columns)


def resolved(path):
    """Returns the root of a scene file, with $names replaced by their defaults."""
    text = path.read_text(encoding="utf-8")
    defaults = dict(re.findall(r'<default name="(\w+)" value="([^"]*)"/>', text))
    for name in sorted(defaults, key=len, reverse=True):
        text = text.replace(f"${name}", defaults[name])
    return tree.fromstring(text)


def glossy_shapes(path):
    """Returns for each shape of a scene, in the order of the file, whether its BSDF has a lobe or is a
    mirror."""
    root = resolved(path)
    known = {bsdf.get("id"): bsdf for bsdf in root.iter("bsdf") if bsdf.get("id")}
    if root.find(".//shape[@type='instance']") is not None:
        raise Problem(f"{path.name}: shapes of instances have no materials of their own")

    def of(shape):
        bsdfs = shape.findall("bsdf") + [known[r.get("id")] for r in shape.findall("ref")
                                         if r.get("id") in known]
        return any(part.get("type") not in DULL for bsdf in bsdfs for part in bsdf.iter("bsdf"))

    return [of(shape) for shape in root.findall("shape")]


def points_of(pictures, camera):
    """Returns the Points in the channels of several renders with `aovs` =
    shape:shape_index,n:sh_normal,p:position."""
    def stack(name, letters):
        found = [np.stack([picture[f"{name}.{c}"] for picture in pictures]) for c in letters]
        return np.stack(found, axis=-1).astype(np.float32)

    normal, position = stack("n", "XYZ"), stack("p", "XYZ")
    shape = np.rint(stack("shape", "I")[..., 0]).astype(int)
    viewer = np.array(camera.origin, np.float32) - position
    distance = np.maximum(np.linalg.norm(viewer, axis=-1), 1e-20)
    cosine = (normal * viewer).sum(-1) / distance
    normal *= np.where(cosine < 0, -1, 1)[..., None]
    return Points(shape, normal, position, np.where(shape > 0, np.abs(cosine), 1),
                  SIDE * camera.pixel * distance)


def in_tiles(values):
    """Rearranges an array (renders, rows, columns, …) to (tiles, points, …), ordered by pixel. Pads incomplete
    tiles with 0."""
    renders, rows, columns, *rest = values.shape
    down, across = -rows % SIDE, -columns % SIDE
    values = np.pad(values, [(0, 0), (0, down), (0, across)] + [(0, 0)] * len(rest))
    high, wide = (rows + down) // SIDE, (columns + across) // SIDE
    values = values.reshape(renders, high, SIDE, wide, SIDE, *rest)
    order = (1, 3, 2, 4, 0, *range(5, 5 + len(rest)))
    return values.transpose(order).reshape(high * wide, SIDE * SIDE * renders, *rest)


def from_tiles(values, renders, rows, columns):
    """Inverts in_tiles()."""
    high, wide = -(-rows // SIDE), -(-columns // SIDE)
    values = values.reshape(high, wide, SIDE, SIDE, renders).transpose(4, 0, 2, 1, 3)
    return values.reshape(renders, high * SIDE, wide * SIDE)[:, :rows, :columns]


class Patches:
    """Patches of all tiles, as arrays (tiles, patches, …)."""

    def __init__(self, tiles):
        self.shape = np.zeros((tiles, MAX_PATCHES), int)  # 0: none
        self.normal, self.position = (np.zeros((tiles, MAX_PATCHES, 3), np.float32) for _ in range(2))
        self.cosine, self.tolerance = (np.zeros((tiles, MAX_PATCHES), np.float32) for _ in range(2))
        self.count = np.zeros(tiles, int)

    def assign(self, shape, normal, position, width):
        """Returns the index of each point's patch, or -1 for none. The arguments are arrays (tiles, points, …).
        A point gets the fitting patch with the closest normal. If none fits, it begins a new patch, as long
        as the tile has fewer than MAX_PATCHES."""
        found = np.full(shape.shape, -1)
        every = np.arange(len(shape))
        for k in range(shape.shape[1]):
            there = shape[:, k] > 0
            cosine = np.einsum("tpc,tc->tp", self.normal, normal[:, k])
            off = np.einsum("tpc,tpc->tp", position[:, k, None] - self.position, self.normal)
            fits = ((self.shape == shape[:, k, None]) & (cosine >= self.cosine)
                    & (np.abs(off) <= self.tolerance))
            best = np.where(fits, cosine, -2).argmax(axis=1)
            fitting = fits[every, best] & there
            begun = ~fitting & there & (self.count < MAX_PATCHES)
            at = every[begun], self.count[begun]
            self.shape[at], self.normal[at] = shape[begun, k], normal[begun, k]
            self.position[at], self.cosine[at] = position[begun, k], COSINE
            self.tolerance[at] = PLANE_WIDTHS * width[begun, k]
            found[:, k] = np.where(fitting, best, np.where(begun, self.count, -1))
            self.count += begun
        return found

    def settle(self, found, normal, position):
        """Replaces the first points of patches by means, and their cones by those of their points."""
        tiles, points = np.nonzero(found >= 0)
        at = tiles, found[tiles, points]
        count = np.zeros(self.shape.shape)
        sums = [np.zeros((*self.shape.shape, 3)) for _ in range(2)]
        np.add.at(count, at, 1)
        for total, values in zip(sums, (normal, position)):
            np.add.at(total, at, values[tiles, points])
        self.position = (sums[1] / np.maximum(count, 1)[..., None]).astype(np.float32)
        length = np.maximum(np.linalg.norm(sums[0], axis=-1), 1e-20)
        self.normal = (sums[0] / length[..., None]).astype(np.float32)
        least = np.ones(self.shape.shape)
        np.minimum.at(least, at, (self.normal[at] * normal[tiles, points]).sum(-1))
        angle = np.arccos(np.clip(least, -1, 1)) * CONE_FACTOR + CONE_MARGIN
        self.cosine = np.where(self.shape > 0, np.cos(np.minimum(angle, 1.5)), 0)


def patches_of(points, pilot):
    """Returns arrays (renders, rows, columns) of the patch of each point, and of whether the pilot missed it.
    The first `pilot` renders represent the pilot."""
    size = points.shape.shape
    columns = [in_tiles(x) for x in (points.shape, points.normal, points.position, points.width)]
    of_pilot = np.tile(np.arange(size[0]) < pilot, SIDE * SIDE)
    patches = Patches(len(columns[0]))
    found = np.full(columns[0].shape, -1)
    if pilot:
        known = [x[:, of_pilot] for x in columns]
        found[:, of_pilot] = patches.assign(*known)
        patches.settle(found[:, of_pilot], known[1], known[2])
    before = patches.count.copy()
    found[:, ~of_pilot] = patches.assign(*(x[:, ~of_pilot] for x in columns))
    new = found >= before[:, None]
    return from_tiles(found, *size), from_tiles(new, *size)


def pilot_rays(rays_per_pixel):
    return next(rays for most, rays in PILOT if rays_per_pixel < most)
