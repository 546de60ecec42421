"""Comparison of two images, by the tests of the program kinome-compare."""
import importlib
import importlib.util
import pathlib
import sys

import numpy as np

from . import _arguments as check
from ._picture import Picture

HERE = pathlib.Path(__file__).absolute().parent
# The package of kinome-compare: in a wheel, and beside this package in a build folder. NAME is in
# this package, so that it can't clash with another module.
FOLDERS = [HERE / "lib/kinome/python/compare", HERE.parent / "compare"]
NAME = __package__ + "._comparison"


def _package():
    if NAME not in sys.modules:
        folder = next(folder for folder in FOLDERS if (folder / "verdict.py").is_file())
        found = importlib.util.spec_from_file_location(
            NAME, folder / "__init__.py", submodule_search_locations=[str(folder)])
        package = sys.modules[NAME] = importlib.util.module_from_spec(found)
        try:
            found.loader.exec_module(package)
        except BaseException as reason:
            del sys.modules[NAME]
            if isinstance(reason, ModuleNotFoundError) and str(reason.name).startswith("scipy"):
                raise ImportError("compare needs scipy: pip install scipy") from None
            raise
    return (importlib.import_module(NAME + ".images"), importlib.import_module(NAME + ".verdict"))


def _renders(pictures, images, name):
    """Returns the colours of several renders."""
    if len(pictures) < images.MIN_RENDERS:
        raise ValueError(f"{name}: {len(pictures)} renders, needs at least {images.MIN_RENDERS}")
    colours = [np.asarray(picture.rgb if isinstance(picture, Picture) else picture)
               for picture in pictures]
    # Renders with the same seed are not independent: the estimated variance would be too small.
    seeds = [picture.stats["seed"] for picture in pictures
             if isinstance(picture, Picture) and "seed" in picture.stats]
    if len(set(seeds)) < len(seeds):
        twin = next(seed for seed in seeds if seeds.count(seed) > 1)
        raise ValueError(f"{name} takes pictures of different seeds, got several of seed {twin}")
    for colour in colours:
        if colour.ndim != 3 or colour.dtype.kind not in "fiu" or colour.shape != colours[0].shape:
            shapes = sorted({str(one.shape) for one in colours})
            raise ValueError(f"{name} takes pictures of one shape (height, width, channels), got "
                             f"{', '.join(shapes)}")
    return colours


def _check(pictures, name):
    takes = "a picture by render(variance=16), or a list of 4 or more pictures of different seeds"
    check.instance(pictures, name, (Picture, list, tuple), takes)
    if isinstance(pictures, Picture) and not pictures.stats.get("renders"):
        raise ValueError(f"{name} takes {takes}, got a picture without a variance, or a part of one")


def _estimate(images, pictures, name):
    if isinstance(pictures, (list, tuple)):
        return images.Estimate.from_renders(name, _renders(pictures, images, name))
    header = {"kinome:renders": str(pictures.stats["renders"]),
              "kinome:variance_of_mean": " ".join(map(repr, pictures.stats["variance_of_mean"]))}
    channels = {channel: np.asarray(pictures, np.float64)[:, :, i]
                for i, channel in enumerate(pictures.channels)}
    try:
        return images.mean_of(name, images.Picture(channels, header, 1e-5), None)
    except images.BadInput as reason:
        raise ValueError(str(reason)) from reason


def compare(a, b, alpha=0.01):
    """Tests if two renders have the same expectation; `b` is the reference. Each is a picture by
    render(variance=16), or a list of 4 or more pictures of different seeds. Returns a verdict, which
    has `passed`, and `tests` with the results of the individual tests. Two renders with the same
    expectation fail at the rate `alpha`. Needs scipy."""
    if not 0 < check.positive(alpha, "alpha") < 1:
        raise check.fault(ValueError, "alpha", "a number between 0 and 1", alpha)
    _check(a, "a")
    _check(b, "b")
    images, verdict = _package()
    estimates = _estimate(images, a, "a"), _estimate(images, b, "b")
    if estimates[0].mean.shape != estimates[1].mean.shape:
        raise ValueError(f"a is {images.size(estimates[0].mean)}, but b is "
                         f"{images.size(estimates[1].mean)}")
    return verdict.compare(*estimates, alpha)
