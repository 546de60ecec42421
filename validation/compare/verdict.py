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
  * a pixel without noise in either picture, but with some around it, is left to its tile: all 16
    renders may miss, or may meet equally often, an edge that cuts off a corner;
  * a pooled variance has the degrees of freedom that Satterthwaite gives for the sum: few where one
    member makes up most of it;
  * tiles sum the variances of their pixels, 256 times the sample. Where the renders show that
    pixels are correlated (a reconstruction filter, lights shared by all pixels), the variance is
    that of the tile's mean from render to render;
  * the image's variance is always the one from render to render, where the renders are known.

What this costs is power for a lone pixel among much noisier neighbours.
"""
import dataclasses

import numpy as np
from scipy import special

from .images import BadInput, size

TILE = 16
DETECTED = 0.9  # how often a bias of the size that is printed must be found
NO_NOISE = 1e-6  # relative standard deviation that summation in single precision may leave
CORRELATED = 1e-3  # false-alarm rate of the test for correlated pixels


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
    t_of_tiles: np.ndarray  # (rows, columns, channels)


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


def neighbourhood(x):
    """Sums over 3x3 pixels; beyond the edge there is nothing."""
    padded = np.pad(x, ((1, 1), (1, 1)) + ((0, 0),) * (x.ndim - 2))
    rows = padded[:-2] + padded[1:-1] + padded[2:]
    return rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:]


def pixel_variance(estimate, masked):
    """(variance, degrees of freedom) of each value: see the top of this file."""
    own = np.where(masked[:, :, None], 0, estimate.variance)
    count = neighbourhood((~masked).astype(float))[:, :, None]
    total, squares = neighbourhood(own), neighbourhood(own ** 2)
    pooled = total / np.maximum(count, 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        members = np.where(squares > 0, total ** 2 / squares, 1)
    single = estimate.renders - 1
    return np.maximum(own, pooled), np.where(own >= pooled, single, members * single)


def can_be_tested(a, b, masked):
    """Which values have noise in both pictures, or none in both around them; all else is chance."""
    least = (NO_NOISE * np.maximum(np.abs(a.mean), np.abs(b.mean))) ** 2
    around = neighbourhood(np.where(masked[:, :, None], 0, a.variance + b.variance))
    return (np.minimum(a.variance, b.variance) > least) | (around <= 9 * least)


def tile_sums(x):
    """Sums over tiles of the two axes before the last; the last tile of a row may be narrower."""
    rows = np.add.reduceat(x, np.arange(0, x.shape[-3], TILE), axis=-3)
    return np.add.reduceat(rows, np.arange(0, x.shape[-2], TILE), axis=-2)


def render_to_render(estimate, sums):
    """Variance of the mean of `sums` (of each render) and its degrees of freedom."""
    return sums.var(axis=0, ddof=1) / estimate.renders, estimate.renders - 1.0


def tile_variance(estimate, masked):
    """(variance of the sum over each tile, degrees of freedom, are pixels correlated)."""
    own = np.where(masked[:, :, None], 0, estimate.variance)
    total, squares = tile_sums(own), tile_sums(own ** 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        dof = np.where(squares > 0, total ** 2 / squares, 1) * (estimate.renders - 1)
    if estimate.stack is None:
        return total, dof, False
    across, few = render_to_render(estimate, tile_sums(np.where(masked[:, :, None], 0,
                                                                estimate.stack)))
    # What varies by rounding alone says nothing of noise.
    noisy = total > (estimate.rounding * tile_sums(estimate.mean * ~masked[:, :, None])) ** 2
    if not noisy.any():
        return total, dof, False
    # The channels of a tile go up and down together: they count as one.
    freedom = noisy.any(axis=2).sum() * few
    ratio = (across[noisy] / total[noisy]).mean()
    if special.chdtrc(freedom, ratio * freedom) >= CORRELATED:
        return total, dof, False
    return across, np.full_like(dof, few), True


def judge(name, alpha, difference, reference, t, dof, where):
    """The verdict over one family of values; where(index) names one. Flat arrays."""
    limit = sidak(alpha, len(t))
    p = two_sided(t, dof)
    worst = int(np.argmax(np.abs(t))) if not (p > 0).all() else int(np.argmin(p))
    # Corrected for their number; log1p keeps the small ones.
    corrected = float(-np.expm1(len(t) * np.log1p(-min(p[worst], 1 - 1e-16))))
    share = f" ({difference[worst] / reference[worst]:+.3%})" if reference[worst] != 0 else ""
    text = f"{where(worst)}: {difference[worst]:+.4g} on {reference[worst]:.4g}{share}, " \
           f"t = {t[worst]:+.2f}"
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
    notes = []
    each = sidak(alpha, 3)
    relative = max(a.rounding, b.rounding)
    if relative > 1e-5:
        notes.append("half floats: biases under 0.03 % can't be seen; use component_format float32")
    keep = ~masked[:, :, None]
    mean_a, mean_b = a.mean * keep, b.mean * keep
    names = "RGB" if mean_a.shape[2] == 3 else "Y"

    sums = mean_a.sum(axis=(0, 1)), mean_b.sum(axis=(0, 1))
    count = (~masked).sum()
    spread = [render_to_render(e, (e.stack * keep).sum(axis=(1, 2))) if e.stack is not None
              else whole_variance(e.variance * keep, e.renders) for e in (a, b)]
    t, dof = welch(sums[0] - sums[1], *spread, relative * np.abs(sums[1]))
    tests = [judge("image", each, (sums[0] - sums[1]) / count, sums[1] / count, t, dof,
                   lambda i: f"channel {names[i]}")]

    counts = tile_sums((~masked).astype(float)[:, :, None])
    tiles_a, tiles_b = tile_sums(mean_a), tile_sums(mean_b)
    spread = []
    for estimate in (a, b):
        variance, dof, correlated = tile_variance(estimate, masked)
        spread.append((variance, dof))
        if correlated:
            notes.append(f"{estimate.name}: pixels are correlated; tiles use the variance from "
                         "render to render")
    t_of_tiles, dof = welch(tiles_a - tiles_b, *spread, relative * np.abs(tiles_b))
    shape = np.broadcast_to(counts, tiles_a.shape)
    used = shape > 0
    places = np.argwhere(used)
    tests.append(judge("tiles", each, (tiles_a - tiles_b)[used] / shape[used],
                       tiles_b[used] / shape[used], t_of_tiles[used], dof[used],
                       lambda i: tile_name(places[i], names)))

    t, dof = welch(mean_a - mean_b, pixel_variance(a, masked), pixel_variance(b, masked),
                   relative * np.abs(mean_b))
    testable = can_be_tested(a, b, masked)
    used = keep & testable
    if not used.any():
        raise BadInput(f"{a.name} and {b.name}: no pixel with noise, or without any around it")
    pixels = np.argwhere(used)
    tests.append(judge("pixels", each, (mean_a - mean_b)[used], mean_b[used], t[used], dof[used],
                       lambda i: f"pixel {pixels[i][1]},{pixels[i][0]} {names[pixels[i][2]]}"))
    p = np.where(used, two_sided(t, dof), np.nan)
    left_out = int((keep & ~testable).sum())
    if left_out:
        notes.append(f"{left_out} values without noise beside ones with noise are left to their "
                     "tiles")

    for e in (a, b):
        if e.renders < 16:
            notes.append(f"{e.name}: variance from {e.renders} renders only; heavy tails and "
                         "stratified samplers need 16")
    passed = all(test.passed for test in tests) and not (a.nans or a.infinities)
    return Verdict(passed, alpha, tests, int(masked.sum()), notes, p, t_of_tiles)


def whole_variance(variance, renders):
    """Of the sum of independent pixels: (variance, degrees of freedom) by channel."""
    total, squares = variance.sum(axis=(0, 1)), (variance ** 2).sum(axis=(0, 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        return total, np.where(squares > 0, total ** 2 / squares, 1) * (renders - 1)


def tile_name(place, names):
    row, column, channel = place
    return f"tile {column},{row} (from pixel {column * TILE},{row * TILE}) {names[channel]}"
