"""The tests: do two estimates have the same expectation?

Three tests, each with a third of the false-alarm rate (Šidák), so that together they fail for two
correct pictures at the rate `alpha` or less:

  image   signed: the mean difference of each channel over the whole picture;
  tiles   signed: the mean difference of each channel over 16x16 pixels;
  pixels  each value by itself.

All are Welch's t with both variances, Welch-Satterthwaite's degrees of freedom, and Šidák over all
values of the test. Noise of renders has heavy tails: of 16 renders of a pixel, often none holds the
rare bright path, and mean and variance are both too small together. Student's t is wrong then, by
orders of magnitude where the limit is one in a million. Therefore

  * a pixel's variance is its own or the mean over itself and its neighbours (3x3), whichever is
    larger: those that missed the bright path take it from those that met it. A pixel that met it
    has a variance of its own in proportion, and is no outlier;
  * a variance that comes from few renders with light has few degrees of freedom, and one that is
    pooled has what Satterthwaite gives for the sum: few where one member makes up most of it;
  * a pixel without noise in either picture, but with some around it, is left to its tile: all 16
    renders may miss, or may meet equally often, an edge that cuts off a corner;
  * tiles sum the variances of their pixels, 256 times the sample, and learn from the renders how
    much more or less they vary, since pixels share noise: see noise.py;
  * where the reference hardly found the light, only what is darker can be wrong: see missed.py.

What this costs is power for a lone pixel among much noisier neighbours.
"""
import dataclasses

import numpy as np
from scipy import special

from .images import ENOUGH, BadInput, size
from .missed import Missed, describe, hardly_found, of_pixels
from .noise import TILE, neighbourhood, noise_of, tile_sums

DETECTED = 0.9  # how often a bias of the size that is printed must be found
NO_NOISE = 1e-6  # relative standard deviation that summation in single precision may leave


@dataclasses.dataclass
class Test:
    """One family of values. detectable: the relative bias found 9 times out of 10, of the value
    that is in the middle in that; None if all is black."""

    name: str
    passed: bool
    p: float  # of the worst value, corrected for their number
    t: float  # of the worst value
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
    missed: Missed | None  # tiles where the reference hardly found the light


def sidak(alpha, count):
    """The rate for each of `count` tests that together give alpha."""
    return -np.expm1(np.log1p(-alpha) / count)


def two_sided(t, dof):
    """P(|T| >= |t|) of Student's distribution."""
    return 2 * special.stdtr(dof, -np.abs(t))


def welch(difference, a, b, rounding):
    """t and degrees of freedom. a, b: (variance of the mean, its degrees of freedom); rounding:
    standard deviation that has to be allowed for besides."""
    (va, na), (vb, nb) = a, b
    variance = va + vb + rounding ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.where(variance > 0, difference / np.sqrt(variance),
                     np.where(difference == 0, 0, np.copysign(np.inf, difference)))
        dof = variance ** 2 / (va ** 2 / na + vb ** 2 / nb)
    # Without noise only rounding is left: normal, as near as makes no difference.
    return t, np.where(np.isfinite(dof), dof, 1e9)


def can_be_tested(a, b, masked):
    """Which values have noise in both pictures, or none in both around them; all else is chance."""
    least = (NO_NOISE * np.maximum(np.abs(a.mean), np.abs(b.mean))) ** 2
    around = neighbourhood(np.where(masked[:, :, None], 0, a.variance + b.variance))
    return (np.minimum(a.variance, b.variance) > least) | (around <= 9 * least)


def judge(name, alpha, difference, reference, t, dof, where):
    """The verdict over one family of values; where(index) names one. Flat arrays."""
    limit = sidak(alpha, len(t))
    p = two_sided(t, dof)
    worst = int(np.argmax(np.abs(t))) if not (p > 0).all() else int(np.argmin(p))
    # Corrected for their number; log1p keeps the small ones.
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
                                            special.stdtrit(dof[middle], DETECTED)))
    failed = int((p < limit).sum())
    return Test(name, failed == 0, corrected, float(t[worst]), text, len(t), failed, detectable)


def compare(a, b, alpha=0.01):
    """Compares Estimate a with Estimate b, the reference. Raises BadInput."""
    if a.mean.shape != b.mean.shape:
        raise BadInput(f"{a.name} is {size(a.mean)}, but {b.name} is {size(b.mean)}")
    if b.nans or b.infinities:
        raise BadInput(f"{b.name}: the reference holds {b.nans} NaN and {b.infinities} Inf")
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
    """`dim`: tiles that are left out, bright or dark in A, or else the rest would be too dark."""
    if dim.any():
        masked = pair.masked | of_pixels(dim, pair.masked.shape)
        if masked.all():
            raise BadInput(f"{pair.b.name}: hardly found any light: many of its values are exactly "
                           "0, the others come from one or two of its renders each. It needs more "
                           "samples, or an integrator that finds this light, to be a reference")
        pair = Pair(pair.a, pair.b, masked)
    sums = pair.mean_a.sum(axis=(0, 1)), pair.mean_b.sum(axis=(0, 1))
    t, dof = welch(sums[0] - sums[1], (pair.noise_a.whole, pair.noise_a.whole_freedom),
                   (pair.noise_b.whole, pair.noise_b.whole_freedom),
                   pair.rounding * np.abs(sums[1]))
    count = (~pair.masked).sum()
    return judge("image", alpha, (sums[0] - sums[1]) / count, sums[1] / count, t, dof,
                 lambda i: f"channel {pair.names[i]}")


def test_of_tiles(pair, dim, alpha):
    """(Test, t of each tile)."""
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
    """(Test, p, number of values that were left to their tiles)."""
    t, dof = welch(pair.mean_a - pair.mean_b, (pair.noise_a.pixels, pair.noise_a.pixels_freedom),
                   (pair.noise_b.pixels, pair.noise_b.pixels_freedom),
                   pair.rounding * np.abs(pair.mean_b))
    wanted = pair.keep & ~(of_pixels(dim, t.shape) & (pair.mean_a > pair.mean_b))
    testable = can_be_tested(pair.a, pair.b, pair.masked)
    used = wanted & testable
    if not used.any():
        raise BadInput(f"{pair.a.name} and {pair.b.name}: no pixel can be compared: wherever one "
                       "picture has noise, the other has none")
    pixels = np.argwhere(used)
    test = judge("pixels", alpha, (pair.mean_a - pair.mean_b)[used], pair.mean_b[used], t[used],
                 dof[used], lambda i: f"pixel {pixels[i][1]},{pixels[i][0]} "
                                      f"{pair.names[pixels[i][2]]}")
    return test, np.where(used, two_sided(t, dof), np.nan), int((wanted & ~testable).sum())


def notes_on(pair, left_out):
    """What else there is to know, in sentences."""
    notes = []
    if not (pair.mean_a.any() or pair.mean_b.any()):
        notes.append("both pictures are black: there was nothing to compare")
    for e, noise in ((pair.a, pair.noise_a), (pair.b, pair.noise_b)):
        if e.rounding > 1e-5:
            notes.append(f"{e.name} is stored in half floats, of 11 bits: differences under 0.03 % "
                         "can't be seen. The film's component_format float32 keeps them")
        if e.renders < ENOUGH:
            notes.append(f"{e.name}: {e.renders} renders are few. With fewer than {ENOUGH}, rare "
                         "bright samples may pass for a difference")
        if noise.factor is not None:
            notes.append(f"{e.name}: pixels share noise (by a filter wider than a pixel, or by "
                         "light they have in common): tiles are "
                         f"{np.sqrt(noise.factor):.2g} times as uncertain as by their pixels "
                         "alone, which is allowed for")
    if left_out:
        values = pair.keep.sum() * len(pair.names)
        notes.append(f"{left_out} of {values} values vary in one picture but not in the other, as "
                     "where few samples meet an edge: the test of pixels leaves them out, that of "
                     "tiles has them")
    return notes


def tile_name(place, names):
    row, column, channel = place
    return f"tile {column},{row} (from pixel {column * TILE},{row * TILE}) {names[channel]}"
