"""Reads an estimate of an image (mean and variance of the mean) from files.

An estimate is one file with both, or several renders with different seeds. The files are OpenEXR or PFM
with linear radiance.
"""
import dataclasses
import glob
import json
import os
import pathlib

import numpy as np

from .noise import TILE, tile_sums

MIN_RENDERS = 4  # minimum number of renders; fewer give a poor variance for noise with heavy tails
RECOMMENDED_RENDERS = 16


class BadInput(Exception):
    """Invalid input, with a message of one line for the user."""


@dataclasses.dataclass
class Estimate:
    """Values of an image with their uncertainty. Arrays are float64, top row first.

    mean, variance: (height, width, channels); the variance is that of the mean, not of one render.
    renders: number of independent renders from which the variance was computed.
    stack: (renders, height, width, channels), or None if the single renders are unknown.
    tile_variance, whole_variance: variances of the sums over tiles (rows, columns, channels) and over
    the image (channels), or None. They include noise that pixels share.
    masked: (height, width), pixels without a value; their mean and variance are 0.
    rounding: relative error of any value by the number format of the file.
    """

    name: str
    mean: np.ndarray
    variance: np.ndarray
    renders: int
    stack: np.ndarray | None = None
    tile_variance: np.ndarray | None = None
    whole_variance: np.ndarray | None = None
    masked: np.ndarray | None = None
    nans: int = 0
    infinities: int = 0
    rounding: float = 1e-5

    def __post_init__(self):
        if self.masked is None:
            self.masked = np.zeros(self.mean.shape[:2], bool)

    @classmethod
    def from_renders(cls, name, stack, rounding=1e-5):
        """Returns the estimate of several renders. Masks pixels that aren't finite in all of them."""
        stack = np.array(stack, np.float64)
        broken = ~np.isfinite(stack)
        masked = broken.any(axis=(0, 3))
        nans, infinities = int(np.isnan(stack).sum()), int(np.isinf(stack).sum())
        stack[:, masked] = 0
        return cls(name, stack.mean(axis=0), stack.var(axis=0, ddof=1) / len(stack), len(stack),
                   stack, masked=masked, nans=nans, infinities=infinities, rounding=rounding)


def files_of(patterns):
    """Returns the files of a list of names. Each is a file, a pattern, or several of them separated by
    commas."""
    names = []
    for part in (p for pattern in patterns
                 for p in ([pattern] if os.path.exists(pattern) else pattern.split(","))):
        found = [part] if os.path.exists(part) else sorted(glob.glob(part))
        if not found:
            raise BadInput(f"{part}: no such file")
        names += found
    return names


def refuse_repeated(names):
    """Raises BadInput if a file occurs twice, because it isn't an independent render. load_renders checks
    for different files with the same values."""
    seen = {}
    for name in names:
        try:
            found = os.stat(name)
        except OSError:
            continue  # read() reports the reason
        key = found.st_dev, found.st_ino
        other = seen.get(key)
        seen[key] = name
        if other is not None:
            both = f"{name}: given" if other == name else f"{other} and {name}: the same file,"
            raise BadInput(f"{both} more than once; each render counts once")


def has_variance(path):
    """Returns whether the file has variance channels. Doesn't read its pixels."""
    import OpenImageIO as oiio  # not needed for images in memory
    source = oiio.ImageInput.open(str(path))
    if source is None:
        return False  # read() reports the reason
    names = source.spec().channelnames
    source.close()
    return any(name.startswith("variance.") for name in names)


@dataclasses.dataclass
class Picture:
    """Contents of a file."""

    channels: dict  # {name: array of (height, width)}
    header: dict  # {name: text} of attributes that begin with "kinome:"
    rounding: float  # relative error of a value by the number format


# Names of layers that contain the whole image.
WHOLE = ("combined", "beauty", "rgba", "rgb", "composite", "color", "colour")
# Matrix from XYZ to linear Rec.709: the inverse of the matrix with which Kinome and Mitsuba write XYZ.
TO_RGB = np.linalg.inv([[0.412453, 0.357580, 0.180423], [0.212671, 0.715160, 0.072169],
                        [0.019334, 0.119193, 0.950227]])


def colour_names(names):
    """Finds the colour channels of a file, as Kinome's reader does (exr_colors.h). Returns their rank
    (the lowest is the best) and their names. There are no names if the file has no colour."""
    layers = {}
    for name in sorted(names):  # capital letters come first
        layer, _, letter = name.rpartition(".")
        layers.setdefault(layer, {}).setdefault(letter.upper(), name)
    unnamed = layers.pop("", {})
    if all(letter in unnamed for letter in "RGB"):
        return 0, tuple(unnamed[letter] for letter in "RGB")
    if {"X", "Y", "Z"} <= set(names):
        return 1, ("X", "Y", "Z")
    if "Y" in unnamed and "X" not in unnamed:
        return 2, (unnamed["Y"],)
    for rank, letters in ((3, "RGB"), (4, "Y")):
        found = [name for name, layer in layers.items()
                 if all(letter in layer for letter in letters) and (rank == 3 or "X" not in layer)]
        found.sort(key=lambda name: name.rpartition(".")[2].lower() not in WHOLE)
        if found:
            return rank, tuple(layers[found[0]][letter] for letter in letters)
    return 5, ()


def name_colour(channels):
    """Renames the colour channels to R, G and B, or to Y. Converts XYZ to RGB."""
    rank, names = colour_names(channels)
    found = [channels.pop(name) for name in names]
    if rank == 1:
        found = list(np.einsum("ij,jyx->iyx", TO_RGB, np.stack(found)))
    return dict(zip("RGB" if len(found) == 3 else "Y", found)) | channels


def seek_colour(source):
    """Seeks the part of a file with the best colour, or the first part if none has a colour."""
    ranks = []
    while source.seek_subimage(len(ranks), 0):
        ranks.append(colour_names(source.spec().channelnames)[0])
    source.seek_subimage(ranks.index(min(ranks)), 0)


def read(path):
    """Returns the Picture in an EXR or PFM file."""
    import OpenImageIO as oiio
    source = oiio.ImageInput.open(str(path))
    if source is None:
        reason = oiio.geterror().splitlines() or ["unknown format"]
        raise BadInput(f"{path}: can't be read: {reason[0]}")
    seek_colour(source)
    spec = source.spec()
    if spec.format.basetype not in (oiio.FLOAT, oiio.HALF):
        raise BadInput(f"{path}: has values of type {spec.format}, must be an OpenEXR or PFM file of floats")
    pixels = source.read_image(source.current_subimage(), 0, 0, spec.nchannels, oiio.FLOAT)
    if pixels is None:
        raise BadInput(f"{path}: can't be read: {(source.geterror().splitlines() or ['?'])[0]}")
    source.close()
    # Half floats have 11 bits. Their rounding errors cancel in means, but not in single values.
    rounding = 2.0 ** -12 if spec.format.basetype == oiio.HALF else 1e-5
    pixels = np.asarray(pixels, np.float64).reshape(spec.height, spec.width, spec.nchannels)
    header = {a.name: a.value for a in spec.extra_attribs
              if a.name.startswith("kinome:") and isinstance(a.value, str)}
    channels = {name: pixels[:, :, i] for i, name in enumerate(spec.channelnames)}
    return Picture(name_colour(channels), header, rounding)


def colour(path, channels, prefix=""):
    """Returns the colour channels of a file as one array, or None if it has none with that prefix."""
    for names in (("R", "G", "B"), ("Y",)):
        if all(prefix + name in channels for name in names):
            return np.stack([channels[prefix + name] for name in names], axis=2)
    if prefix:
        return None
    raise BadInput(f"{path}: needs channels R, G, B or X, Y, Z or Y, got {', '.join(channels)}")


def renders_of(path, picture, wanted):
    """Returns the number of renders from which a file's variance was computed: `wanted`, if the user gave
    it; else the number in the header by `kinome --variance`, or "seeds" in the JSON beside a reference."""
    note = pathlib.Path(path).with_suffix(".json")
    found, source = wanted, "by --renders-a or --renders-b"
    if found is None and "kinome:renders" in picture.header:
        text = picture.header["kinome:renders"]
        found, source = int(text) if text.isdecimal() else text, "by kinome:renders in its header"
        if picture.header.get("kinome:complete") == "false":
            source += ", because it was interrupted"
    if found is None and note.is_file():
        try:
            found = json.loads(note.read_text(encoding="utf-8")).get("seeds")
        except (ValueError, AttributeError) as reason:
            raise BadInput(f"{note}: not the JSON object of a reference: {reason}") from reason
        source = f'by "seeds" in {note.name}'
    if found is None:
        raise BadInput(f"{path}: has a variance, but the number of independent renders is unknown: there is "
                       f"no kinome:renders in its header, and no \"seeds\" in {note.name} beside it. Give "
                       "--renders-a N for A, or --renders-b N for B")
    if not isinstance(found, int) or isinstance(found, bool) or found < MIN_RENDERS:
        raise BadInput(f"{path}: its variance comes from {found} independent renders, {source}; "
                       f"needs at least {MIN_RENDERS} ({RECOMMENDED_RENDERS} are better)")
    return found


def shared_noise(path, picture, variance):
    """Returns (tile_variance, whole_variance) of an Estimate, or (None, None) if the file has none."""
    tiles = colour(path, picture.channels, "tile_variance.")
    if tiles is None:
        return None, None
    text = picture.header.get("kinome:variance_of_mean", "")
    try:
        whole = np.array([float(word) for word in text.split()])
    except ValueError:
        whole = np.array([])
    if tiles.shape != variance.shape or whole.shape != variance.shape[2:]:
        raise BadInput(f"{path}: tile_variance has other channels than the colours, or there is no "
                       "kinome:variance_of_mean in the header: render it again with kinome --variance")
    # Both exclude pixels without a variance.
    known = np.isfinite(variance).all(axis=2)[:, :, None].astype(float)
    count = tile_sums(known)
    tiles = np.where(count > 0, tiles[::TILE, ::TILE], 0) * count ** 2
    whole = whole * known.sum() ** 2
    if not (tiles >= 0).all() or not (whole >= 0).all() or not np.isfinite([*tiles.flat,
                                                                            *whole]).all():
        raise BadInput(f"{path}: variances of tiles or of the whole image are negative or not finite")
    return tiles, whole


def load_mean(path, renders):
    """Returns the estimate in a file with the channels R, G, B, variance.R, …, optionally
    tile_variance.R, …, and optionally mask."""
    return mean_of(path, read(path), renders)


def mean_of(path, picture, renders):
    """Does the same for a Picture that was already read. `path` is its name in messages."""
    channels = picture.channels
    mean, variance = colour(path, channels), colour(path, channels, "variance.")
    if variance is None:
        raise BadInput(f"{path}: one render, without a variance, can't be compared: give at least "
                       f"{MIN_RENDERS} renders with different seeds, or one with kinome --variance")
    if mean.shape != variance.shape:
        raise BadInput(f"{path}: mean and variance have different channels")
    renders = renders_of(path, picture, renders)
    tiles, whole = shared_noise(path, picture, variance)
    masked = channels["mask"] > 0.5 if "mask" in channels else np.zeros(mean.shape[:2], bool)
    broken = ~(np.isfinite(mean) & np.isfinite(variance)) & ~masked[:, :, None]
    nans = int((np.isnan(mean) | np.isnan(variance))[~masked].sum())
    infinities = int(broken.sum()) - nans
    masked = masked | broken.any(axis=2)
    mean, variance = (np.where(masked[:, :, None], 0, x) for x in (mean, variance))
    if (variance < 0).any():
        raise BadInput(f"{path}: {int((variance < 0).sum())} variances are negative")
    return Estimate(str(path), mean, variance, renders, None, tiles, whole, masked, nans,
                    infinities, picture.rounding)


def load_renders(names):
    """Returns the estimate from several renders with different seeds."""
    refuse_repeated(names)
    if len(names) < MIN_RENDERS:
        raise BadInput(f"{names[0]} and others: {len(names)} renders, needs at least {MIN_RENDERS} "
                       f"({RECOMMENDED_RENDERS} are better)")
    stack, roundings = [], []
    for name in names:
        picture = read(name)
        stack.append(colour(name, picture.channels))
        roundings.append(picture.rounding)
        if stack[-1].shape != stack[0].shape:
            raise BadInput(f"{name}: {size(stack[-1])}, but {names[0]} is {size(stack[0])}")
    # Two renders with the same seed would make the variance too small. Only if there is no noise at
    # all, every render may be the same.
    first, twins = {}, []
    for image, name in zip(stack, names):
        values = image.tobytes()
        if values in first:
            twins.append((first[values], name))
        else:
            first[values] = name
    if twins and len(first) > 1:
        raise BadInput(f"{twins[0][0]} and {twins[0][1]} are the same image: render with "
                       "different seeds")
    label = names[0] if len(names) == 1 else f"{names[0]} … {pathlib.Path(names[-1]).name}"
    return Estimate.from_renders(label, stack, max(roundings))


def load(patterns, renders=None):
    """Returns the estimate in one file, or from several renders. `patterns`: a pattern or a list of
    patterns, see files_of."""
    several = isinstance(patterns, (list, tuple))
    names = files_of([str(p) for p in (patterns if several else [patterns])])
    return load_mean(names[0], renders) if len(names) == 1 else load_renders(names)


def size(image):
    return f"{image.shape[1]}x{image.shape[0]} with {image.shape[2]} channels"
