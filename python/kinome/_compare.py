"""Do two pictures show the same? By the tests of the program kinome-compare."""
import pathlib
import sys

import numpy as np

HERE = pathlib.Path(__file__).absolute().parent


def _package():
    """The program's own, which is installed beside this module."""
    for folder in (HERE / "lib/kinome/python", HERE.parent):
        if (folder / "compare/verdict.py").is_file() and str(folder) not in sys.path:
            sys.path.append(str(folder))
    from compare import images, verdict
    return images, verdict


def _estimate(images, said, name):
    if isinstance(said, (list, tuple)):
        if len(said) < images.FEWEST:
            raise ValueError(f"{name}: {len(said)} renders, needs at least {images.FEWEST}")
        return images.Estimate.from_renders(
            name, [np.asarray(getattr(picture, "rgb", picture)) for picture in said])
    header = {}
    if said.stats.get("renders"):
        header["kinome:renders"] = str(said.stats["renders"])
        header["kinome:variance_of_mean"] = " ".join(map(repr, said.stats["variance_of_mean"]))
    channels = {channel: np.asarray(said, np.float64)[:, :, i]
                for i, channel in enumerate(said.channels)}
    try:
        return images.mean_of(name, images.Picture(channels, header, 1e-5), None)
    except images.BadInput as reason:
        raise ValueError(str(reason)) from reason


def compare(a, b, alpha=0.01):
    """Whether two renderings have the same expectation; `b` is the reference. Each is a picture by
    render(variance=16), or a list of 4 or more pictures of different seeds. Gives a verdict, which
    has `passed`, and `tests` with what each of them says. Two pictures that do have the same
    expectation fail at the rate `alpha`. Needs scipy."""
    images, verdict = _package()
    estimates = _estimate(images, a, "a"), _estimate(images, b, "b")
    if estimates[0].mean.shape != estimates[1].mean.shape:
        raise ValueError(f"a is {images.size(estimates[0].mean)}, but b is "
                         f"{images.size(estimates[1].mean)}")
    return verdict.compare(*estimates, alpha)
