"""Tests whether two estimates have the same expected value.

There are three tests, each with a third of the false-alarm rate (Šidák correction). Together they fail for
two correct images with a probability of at most `alpha`:

  image   the mean signed difference of each channel over the whole image;
  tiles   the mean signed difference of each channel over 16x16 pixels;
  pixels  each single value.

All tests use Welch's t with both variances, Welch-Satterthwaite's degrees of freedom, and the Šidák
correction for all values of the test. Noise of renders has heavy tails. Often none of 16 renders of a pixel
contains a rare bright path, so its mean and its variance are both too small. Student's t is then wrong, by
orders of magnitude at a limit of 1e-6. Therefore these rules apply:

  * The variance of a pixel is its own or the mean over itself and its neighbours (3x3), whichever is
    larger. Pixels that missed the bright path get its variance from pixels that found it. A pixel that
    found it has a proportionate variance, so it isn't an outlier.
  * A variance from few renders with light has few degrees of freedom. The degrees of freedom of a pooled
    variance are those of Satterthwaite for the sum, which are few if one member dominates it.
  * A pixel that has no noise in one of the images, but noisy neighbours, is tested only as a part of its
    tile. All 16 renders may miss an edge that cuts off a corner, or hit it equally often.
  * The variance of a tile is the sum of its pixels' variances, a sample that is 256 times larger, corrected
    by the variance between renders, because pixels share noise: see noise.py.
  * Where the reference hardly found the light, only values that are darker can fail: see missed.py.

The cost of these rules is a low power for a single pixel with much noisier neighbours.
"""
import dataclasses

import numpy as np
from scipy import special

from .images import RECOMMENDED_RENDERS, BadInput, size
from .missed import Missed, describe, hardly_found, of_pixels
from .noise import TILE, neighbourhood, noise_of, tile_sums

DETECTION_RATE = 0.9  # probability with which a bias of the printed size is found
NO_NOISE = 1e-6  # maximum relative standard deviation due to summation in single precision


@dataclasses.dataclass
class Test:
    """Result of one test. detectable: the relative bias that is found with probability DETECTION_RATE, as
    the median over all values; None if everything is black."""

    name: str
    passed: bool
    p: float  # p value of the worst value, corrected for the number of values
    t: float  # t value of the worst value
    worst: str
    values: int
    failed: int
    detectable: float | None


@dataclasses.dataclass
class Verdict:
    passed: bool
    alpha: float
    tests: list
    masked: int
    notes: list
    p_of_pixels: np.ndarray  # (height, width, channels), uncorrected; NaN where untested
    t_of_tiles: np.ndarray  # (rows, columns, channels); 0 where untested
    missed: Missed | None  # incomplete tiles of the reference


def sidak(alpha, count):
    """Returns the rate for each of `count` tests, such that their total rate is alpha."""
    return -np.expm1(np.log1p(-alpha) / count)


def two_sided(t, dof):
    """Returns P(|T| >= |t|) of Student's distribution."""
    return 2 * special.stdtr(dof, -np.abs(t))


def welch(difference, a, b, rounding):
    """Returns t and its degrees of freedom. a, b: (variance of the mean, its degrees of freedom);
    rounding: additional standard deviation due to rounding."""
    (va, na), (vb, nb) = a, b
    variance = va + vb + rounding ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.where(variance > 0, difference / np.sqrt(variance),
                     np.where(difference == 0, 0, np.copysign(np.inf, difference)))
        dof = variance ** 2 / (va ** 2 / na + vb ** 2 / nb)
    # Without noise, only rounding is left. Its degrees of freedom are practically infinite.
    return t, np.where(np.isfinite(dof), dof, 1e9)


def can_be_tested(a, b, masked):
    """Returns for each value whether it has noise in both images, or no noise around it in both."""
    least = (NO_NOISE * np.maximum(np.abs(a.mean), np.abs(b.mean))) ** 2
    around = neighbourhood(np.where(masked[:, :, None], 0, a.variance + b.variance))
    return (np.minimum(a.variance, b.variance) > least) | (around <= 9 * least)


def judge(name, alpha, difference, reference, t, dof, where):
    """Returns the Test of a family of values, given as flat arrays. where(index) returns the name of a
    value."""
    limit = sidak(alpha, len(t))
    p = two_sided(t, dof)
    worst = int(np.argmax(np.abs(t))) if not (p > 0).all() else int(np.argmin(p))
    # Corrects p for the number of values. log1p avoids cancellation for small p.
    corrected = float(-np.expm1(len(t) * np.log1p(-min(p[worst], 1 - 1e-16))))
    share = f" ({difference[worst] / reference[worst]:+.3%})" if reference[worst] != 0 else ""
    text = (f"{where(worst)}: A - B = {difference[worst]:+.4g}, B = {reference[worst]:.4g}{share}, "
            f"t = {t[worst]:+.2f}")
    with np.errstate(divide="ignore", invalid="ignore"):
        sizes = np.abs(difference / t / reference)  # one standard deviation
    known = np.flatnonzero(np.isfinite(sizes))
    detectable = None
    if len(known):
        middle = known[np.argsort(sizes[known])[len(known) // 2]]
        detectable = float(sizes[middle] * (special.stdtrit(dof[middle], 1 - limit / 2) +
                                            special.stdtrit(dof[middle], DETECTION_RATE)))
    failed = int((p < limit).sum())
    return Test(name, failed == 0, corrected, float(t[worst]), text, len(t), failed, detectable)


def compare(a, b, alpha=0.01):
    """Compares Estimate a with Estimate b, the reference. Raises BadInput."""
    if a.mean.shape != b.mean.shape:
        raise BadInput(f"{a.name} is {size(a.mean)}, but {b.name} is {size(b.mean)}")
    if b.nans or b.infinities:
        raise BadInput(f"{b.name}: the reference contains {b.nans} NaN and {b.infinities} Inf")
    masked = a.masked | b.masked
    if masked.all():
        raise BadInput(f"{a.name} and {b.name}: no pixel has a value in both")
    each = sidak(alpha, 3)
    pair = Pair(a, b, masked)
    dim = hardly_found(a, b, masked)
    tests = [test_of_image(pair, dim.any(axis=2), each)]
    of_tiles, t_of_tiles = test_of_tiles(pair, dim, each)
    of_pixel, p_of_pixels, left_out = test_of_pixels(pair, dim, each)
    tests += [of_tiles, of_pixel]
    missed = describe(a, b, dim)
    notes = ([missed.sentence(b)] if missed else []) + notes_on(pair, left_out)
    passed = all(test.passed for test in tests) and not (a.nans or a.infinities)
    return Verdict(passed, alpha, tests, int(masked.sum()), notes, p_of_pixels, t_of_tiles, missed)


class Pair:
    """Two estimates without their masked pixels, and the noise of both."""

    def __init__(self, a, b, masked):
        self.a, self.b, self.masked = a, b, masked
        self.keep = ~masked[:, :, None]
        self.mean_a, self.mean_b = a.mean * self.keep, b.mean * self.keep
        self.noise_a, self.noise_b = noise_of(a, masked), noise_of(b, masked)
        self.rounding = max(a.rounding, b.rounding)
        self.names = "RGB" if a.mean.shape[2] == 3 else "Y"


def test_of_image(pair, dim, alpha):
    """Returns the Test of the mean of the image without the incomplete tiles `dim`."""
    if dim.any():
        masked = pair.masked | of_pixels(dim, pair.masked.shape)
        if masked.all():
            raise BadInput(f"{pair.b.name}: hardly found any light: many of its values are exactly "
                           "0, the others come from one or two of its renders each. A reference needs "
                           "more samples, or an integrator that finds this light")
        pair = Pair(pair.a, pair.b, masked)
    sums = pair.mean_a.sum(axis=(0, 1)), pair.mean_b.sum(axis=(0, 1))
    t, dof = welch(sums[0] - sums[1], (pair.noise_a.whole, pair.noise_a.whole_freedom),
                   (pair.noise_b.whole, pair.noise_b.whole_freedom),
                   pair.rounding * np.abs(sums[1]))
    count = (~pair.masked).sum()
    return judge("image", alpha, (sums[0] - sums[1]) / count, sums[1] / count, t, dof,
                 lambda i: f"channel {pair.names[i]}")


def test_of_tiles(pair, dim, alpha):
    """Returns (Test, t of each tile)."""
    a, b = tile_sums(pair.mean_a), tile_sums(pair.mean_b)
    t, dof = welch(a - b, (pair.noise_a.tiles, pair.noise_a.tiles_freedom),
                   (pair.noise_b.tiles, pair.noise_b.tiles_freedom), pair.rounding * np.abs(b))
    counts = np.broadcast_to(tile_sums(pair.keep.astype(float)), a.shape)
    used = (counts > 0) & ~(dim & (a > b))
    places = np.argwhere(used)
    test = judge("tiles", alpha, (a - b)[used] / counts[used], b[used] / counts[used], t[used],
                 dof[used], lambda i: tile_name(places[i], pair.names))
    return test, np.where(used, t, 0)


def test_of_pixels(pair, dim, alpha):
    """Returns (Test, p, number of values that are tested only as a part of their tiles)."""
    t, dof = welch(pair.mean_a - pair.mean_b, (pair.noise_a.pixels, pair.noise_a.pixels_freedom),
                   (pair.noise_b.pixels, pair.noise_b.pixels_freedom),
                   pair.rounding * np.abs(pair.mean_b))
    wanted = pair.keep & ~(of_pixels(dim, t.shape) & (pair.mean_a > pair.mean_b))
    testable = can_be_tested(pair.a, pair.b, pair.masked)
    used = wanted & testable
    if not used.any():
        raise BadInput(f"{pair.a.name} and {pair.b.name}: no pixel can be compared: wherever one "
                       "image has noise, the other has none")
    pixels = np.argwhere(used)
    test = judge("pixels", alpha, (pair.mean_a - pair.mean_b)[used], pair.mean_b[used], t[used],
                 dof[used], lambda i: f"pixel {pixels[i][1]},{pixels[i][0]} "
                                      f"{pair.names[pixels[i][2]]}")
    return test, np.where(used, two_sided(t, dof), np.nan), int((wanted & ~testable).sum())


def notes_on(pair, left_out):
    """Returns further notes for the user, as sentences."""
    notes = []
    if not (pair.mean_a.any() or pair.mean_b.any()):
        notes.append("both images are black: there was nothing to compare")
    for e, noise in ((pair.a, pair.noise_a), (pair.b, pair.noise_b)):
        if e.rounding > 1e-5:
            notes.append(f"{e.name} is stored in half floats with 11 bits: differences below 0.03 % "
                         "can't be detected. Use component_format float32 in the film")
        if e.renders < RECOMMENDED_RENDERS:
            notes.append(f"{e.name}: there are only {e.renders} renders. With fewer than "
                         f"{RECOMMENDED_RENDERS}, rare bright samples may be mistaken for a difference")
        if noise.factor is not None:
            notes.append(f"{e.name}: pixels share noise (by a filter wider than a pixel, or by shared "
                         "light): the standard deviation of tiles is "
                         f"{np.sqrt(noise.factor):.2g} times as large as their pixels imply. The tests "
                         "use the larger one")
    if left_out:
        values = pair.keep.sum() * len(pair.names)
        notes.append(f"{left_out} of {values} values vary in one image but not in the other, for example "
                     "if few samples hit an edge: they are tested in their tiles, but not as pixels")
    return notes


def tile_name(place, names):
    row, column, channel = place
    return f"tile {column},{row} (from pixel {column * TILE},{row * TILE}) {names[channel]}"
