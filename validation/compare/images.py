"""Reading: one estimate of a picture (mean and variance of the mean) from files.

An estimate is one file that holds both, or several renders of different seeds. Files are OpenEXR or
PFM with linear radiance.
"""
import dataclasses
import glob
import json
import os
import pathlib

import numpy as np

from .noise import TILE, tile_sums

FEWEST = 4  # renders; with fewer, a variance says next to nothing of noise with heavy tails
ENOUGH = 16


class BadInput(Exception):
    """What the user has to put right, in one line."""


@dataclasses.dataclass
class Estimate:
    """A picture's values with their uncertainty. Arrays are float64, rows from the top.

    mean, variance: (height, width, channels); variance is that of the mean, not of one render.
    renders: how many independent renders the variance comes from.
    stack: (renders, height, width, channels) where the renders themselves are known, or None.
    tile_variance, whole_variance: what a file tells of what pixels have in common, or None:
    variances of the sums over tiles (rows, columns, channels) and over the picture (channels).
    masked: (height, width), pixels that have no value; their mean and variance are 0.
    rounding: relative error that the file's number format may leave in any value.
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
        """Of several renders; a pixel that is not finite in any one of them is masked."""
        stack = np.array(stack, np.float64)
        broken = ~np.isfinite(stack)
        masked = broken.any(axis=(0, 3))
        nans, infinities = int(np.isnan(stack).sum()), int(np.isinf(stack).sum())
        stack[:, masked] = 0
        return cls(name, stack.mean(axis=0), stack.var(axis=0, ddof=1) / len(stack), len(stack),
                   stack, masked=masked, nans=nans, infinities=infinities, rounding=rounding)


def files_of(patterns):
    """Each is a file, or a pattern, or several of either with commas between."""
    names = []
    for part in (p for pattern in patterns
                 for p in ([pattern] if os.path.exists(pattern) else pattern.split(","))):
        found = [part] if os.path.exists(part) else sorted(glob.glob(part))
        if not found:
            raise BadInput(f"{part}: no such file")
        names += found
    return names


def refuse_repeated(names):
    """The same file again is no other render. Another file with the same values may be: see
    load_renders."""
    seen = {}
    for name in names:
        try:
            found = os.stat(name)
        except OSError:
            continue  # read() says why
        key = found.st_dev, found.st_ino
        other = seen.get(key)
        seen[key] = name
        if other is not None:
            both = f"{name}: given" if other == name else f"{other} and {name}: the same file,"
            raise BadInput(f"{both} more than once; each render counts once")


def has_variance(path):
    """Does the file say so, by its channels? Without reading its pixels."""
    import OpenImageIO as oiio  # pictures in memory need none
    source = oiio.ImageInput.open(str(path))
    if source is None:
        return False  # read() says why
    names = source.spec().channelnames
    source.close()
    return any(name.startswith("variance.") for name in names)


@dataclasses.dataclass
class Picture:
    """What a file holds."""

    channels: dict  # (height, width) by name
    header: dict  # texts by name, of attributes that begin with "kinome:"
    rounding: float  # relative error that the number format may leave in a value


# Names of layers that hold the whole picture.
WHOLE = ("combined", "beauty", "rgba", "rgb", "composite", "color", "colour")
# From XYZ to linear Rec.709, the inverse of what Kinome and Mitsuba write XYZ by.
TO_RGB = np.linalg.inv([[0.412453, 0.357580, 0.180423], [0.212671, 0.715160, 0.072169],
                        [0.019334, 0.119193, 0.950227]])


def colour_names(names):
    """Finds the channels that are a file's colour, as Kinome's reader does (exr_colors.h). Returns
    their rank, of which the lowest is the best, and their names; no names if there is no colour."""
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
    """Renames the channels of a colour to R, G and B, or Y; converts XYZ to RGB."""
    rank, names = colour_names(channels)
    found = [channels.pop(name) for name in names]
    if rank == 1:
        found = list(np.einsum("ij,jyx->iyx", TO_RGB, np.stack(found)))
    return dict(zip("RGB" if len(found) == 3 else "Y", found)) | channels


def seek_colour(source):
    """Goes to the part of a file with the best colour, the first part if none has any."""
    ranks = []
    while source.seek_subimage(len(ranks), 0):
        ranks.append(colour_names(source.spec().channelnames)[0])
    source.seek_subimage(ranks.index(min(ranks)), 0)


def read(path):
    """The Picture in an EXR or PFM file."""
    import OpenImageIO as oiio
    source = oiio.ImageInput.open(str(path))
    if source is None:
        reason = oiio.geterror().splitlines() or ["unknown format"]
        raise BadInput(f"{path}: can't be read: {reason[0]}")
    seek_colour(source)
    spec = source.spec()
    if spec.format.basetype not in (oiio.FLOAT, oiio.HALF):
        raise BadInput(f"{path}: holds {spec.format}, expected an OpenEXR or PFM file of floats")
    pixels = source.read_image(source.current_subimage(), 0, 0, spec.nchannels, oiio.FLOAT)
    if pixels is None:
        raise BadInput(f"{path}: can't be read: {(source.geterror().splitlines() or ['?'])[0]}")
    source.close()
    # Half floats have 11 bits; what many of them leave in a mean has no sign, but may in one value.
    rounding = 2.0 ** -12 if spec.format.basetype == oiio.HALF else 1e-5
    pixels = np.asarray(pixels, np.float64).reshape(spec.height, spec.width, spec.nchannels)
    header = {a.name: a.value for a in spec.extra_attribs
              if a.name.startswith("kinome:") and isinstance(a.value, str)}
    channels = {name: pixels[:, :, i] for i, name in enumerate(spec.channelnames)}
    return Picture(name_colour(channels), header, rounding)


def colour(path, channels, prefix=""):
    """The colour channels of a file as one array, or None if it has none of that prefix."""
    for names in (("R", "G", "B"), ("Y",)):
        if all(prefix + name in channels for name in names):
            return np.stack([channels[prefix + name] for name in names], axis=2)
    if prefix:
        return None
    raise BadInput(f"{path}: needs channels R, G, B or X, Y, Z or Y, has {', '.join(channels)}")


def renders_of(path, picture, wanted):
    """How many renders a file's variance comes from: `wanted`, where the user says so; else the
    header of a picture by `kinome --variance`, or "seeds" in the JSON beside a reference."""
    note = pathlib.Path(path).with_suffix(".json")
    found, source = wanted, "as --renders-a or --renders-b says"
    if found is None and "kinome:renders" in picture.header:
        text = picture.header["kinome:renders"]
        found, source = int(text) if text.isdecimal() else text, "by kinome:renders in its header"
        if picture.header.get("kinome:complete") == "false":
            source += ", as it was interrupted"
    if found is None and note.is_file():
        try:
            found = json.loads(note.read_text(encoding="utf-8")).get("seeds")
        except (ValueError, AttributeError) as reason:
            raise BadInput(f"{note}: not the JSON object that belongs to a reference: "
                           f"{reason}") from reason
        source = f'by "seeds" in {note.name}'
    if found is None:
        raise BadInput(f"{path}: has a variance, but nothing says how many independent renders it "
                       "comes from (neither kinome:renders in its header nor \"seeds\" in "
                       f"{note.name} beside it): give --renders-a N for A, --renders-b N for B")
    if not isinstance(found, int) or isinstance(found, bool) or found < FEWEST:
        raise BadInput(f"{path}: its variance comes from {found} independent renders, {source}; "
                       f"needs at least {FEWEST} ({ENOUGH} are better)")
    return found


def shared_noise(path, picture, variance):
    """(tile_variance, whole_variance) of an Estimate, or (None, None) where the file has none."""
    tiles = colour(path, picture.channels, "tile_variance.")
    if tiles is None:
        return None, None
    text = picture.header.get("kinome:variance_of_mean", "")
    try:
        whole = np.array([float(word) for word in text.split()])
    except ValueError:
        whole = np.array([])
    if tiles.shape != variance.shape or whole.shape != variance.shape[2:]:
        raise BadInput(f"{path}: has tile_variance, but not of the same channels as its colours, "
                       "or no kinome:variance_of_mean in its header: write it again by "
                       "kinome --variance")
    # Pixels without a variance were left out of both.
    known = np.isfinite(variance).all(axis=2)[:, :, None].astype(float)
    count = tile_sums(known)
    tiles = np.where(count > 0, tiles[::TILE, ::TILE], 0) * count ** 2
    whole = whole * known.sum() ** 2
    if not (tiles >= 0).all() or not (whole >= 0).all() or not np.isfinite([*tiles.flat,
                                                                            *whole]).all():
        raise BadInput(f"{path}: variances of its tiles or of the whole are negative or no numbers")
    return tiles, whole


def load_mean(path, renders):
    """An estimate that is stored as such: channels R, G, B, variance.R, …, perhaps tile_variance.R,
    …, and perhaps mask."""
    return mean_of(path, read(path), renders)


def mean_of(path, picture, renders):
    """The same of a picture that was read; `path` is what it is called."""
    channels = picture.channels
    mean, variance = colour(path, channels), colour(path, channels, "variance.")
    if variance is None:
        raise BadInput(f"{path}: one render, without a variance, can't be compared: give at least "
                       f"{FEWEST} renders of different seeds, or one by kinome --variance")
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
    """The estimate that several renders of different seeds make."""
    refuse_repeated(names)
    if len(names) < FEWEST:
        raise BadInput(f"{names[0]} and others: {len(names)} renders, needs at least {FEWEST} "
                       f"({ENOUGH} are better)")
    stack, roundings = [], []
    for name in names:
        picture = read(name)
        stack.append(colour(name, picture.channels))
        roundings.append(picture.rounding)
        if stack[-1].shape != stack[0].shape:
            raise BadInput(f"{name}: {size(stack[-1])}, but {names[0]} is {size(stack[0])}")
    # The same seed twice would pass for a certainty that isn't there. Without any noise at all,
    # every render is the same, and rightly so.
    first, twins = {}, []
    for image, name in zip(stack, names):
        values = image.tobytes()
        if values in first:
            twins.append((first[values], name))
        else:
            first[values] = name
    if twins and len(first) > 1:
        raise BadInput(f"{twins[0][0]} and {twins[0][1]} are the same picture: render with "
                       "different seeds")
    label = names[0] if len(names) == 1 else f"{names[0]} … {pathlib.Path(names[-1]).name}"
    return Estimate.from_renders(label, stack, max(roundings))


def load(patterns, renders=None):
    """The estimate in one file, or of the renders that are named: a pattern or a list of several,
    see files_of."""
    several = isinstance(patterns, (list, tuple))
    names = files_of([str(p) for p in (patterns if several else [patterns])])
    return load_mean(names[0], renders) if len(names) == 1 else load_renders(names)


def size(image):
    return f"{image.shape[1]}x{image.shape[0]} with {image.shape[2]} channels"
