"""Variances and their degrees of freedom, of pixels, of tiles and of the whole image.

The noise of pixels may be correlated. A reconstruction filter wider than a pixel adds each sample to
several pixels: with the Gaussian, the standard deviation of a tile's mean is 1.8 times as large as the
variances of its pixels imply. Pixels may also share light points or light paths. There are two estimates
of a tile's variance:

  own    the variance of its mean between the renders. It is correct for correlated pixels, too, but with
         N renders it has only N - 1 degrees of freedom;
  P      the sum of its pixels' variances. It uses a sample that is 256 times larger, but it is wrong by
         an unknown factor, which is 1 if pixels are independent.

The factor own / P is nearly the same in all tiles if the filter causes it, and different in each tile if
the scene causes it. The spread of this factor is estimated from all tiles, without the spread due to
N - 1 degrees of freedom. The variance of a tile is then a weighted mean of both estimates:

    V = (d0 s P + d own) / (d0 + d),    d = N - 1

The scale s and the degrees of freedom d0 of the factor's distribution are computed from moments of
log(own/P). This is the moderated t statistic: Smyth, Linear models and empirical Bayes methods, 2004. A
tile whose `own` has a probability below 1 % in this distribution uses `own` alone.

The variance of the whole image is that between renders. A file with only variances of pixels is assumed
to have a box filter and independent pixels, as Mitsuba's references have.
"""
import dataclasses

import numpy as np
from scipy import special

TILE = 16
MIN_TILES = 3  # minimum number of tiles for estimating the spread of their factors
UNUSUAL_ALPHA = 0.01  # probability that a usual tile is treated as unusual
NOTABLE_ALPHA = 1e-3  # false-alarm rate of the note that pixels share noise


def tile_sums(x):
    """Returns sums over tiles of the two axes before the last. The last tiles may be smaller."""
    rows = np.add.reduceat(x, np.arange(0, x.shape[-3], TILE), axis=-3)
    return np.add.reduceat(rows, np.arange(0, x.shape[-2], TILE), axis=-2)


def neighbourhood(x):
    """Returns sums over 3x3 pixels. Values beyond the edge are 0."""
    padded = np.pad(x, ((1, 1), (1, 1)) + ((0, 0),) * (x.ndim - 2))
    rows = padded[:-2] + padded[1:-1] + padded[2:]
    return rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:]


def quotient(a, b, otherwise):
    """Returns a / b, or `otherwise` where b is 0."""
    return np.divide(a, b, out=np.full(np.broadcast(a, b).shape, float(otherwise)), where=b > 0)


def hits(estimate):
    """Estimates how many of the n renders found the light of each value, from its mean and variance: n if
    all found the same, 1 if one found all of it, 0 if none found any.

    If k of n renders found the same light, the relative variance of the mean is
    (n - k) / (k (n - 1)).
    """
    n = estimate.renders
    found = quotient(n * estimate.mean ** 2,
                     estimate.mean ** 2 + (n - 1) * estimate.variance, 0)
    return np.where((estimate.mean == 0) & (estimate.variance == 0), 0, found)


def freedom_of_pixels(estimate):
    """Returns the degrees of freedom of each value's variance: n - 1, or fewer if few renders found light.

    The variance of a variance is V² (excess kurtosis / n + 2 / (n - 1)). If k of n renders found
    light, the excess kurtosis is about n / k - 1.
    """
    n = estimate.renders
    found = np.clip(hits(estimate), 1, n)
    return 2 / (1 / found - 1 / n + 2 / (n - 1))


def satterthwaite(total, squares, otherwise):
    """Returns the degrees of freedom of a sum of independent variances. squares: the sum of
    V² / freedom."""
    return quotient(total ** 2, squares, otherwise)


@dataclasses.dataclass
class Noise:
    """Noise of an estimate: variances of sums over unmasked pixels, with their degrees of freedom."""

    pixels: np.ndarray  # (height, width, channels)
    pixels_freedom: np.ndarray
    tiles: np.ndarray  # (rows, columns, channels)
    tiles_freedom: np.ndarray
    whole: np.ndarray  # (channels,)
    whole_freedom: np.ndarray
    factor: float | None  # own / P of all tiles if pixels notably share noise, else None


def noise_of(estimate, masked):
    keep = ~masked[:, :, None]
    variance = estimate.variance * keep
    squares = variance ** 2 / freedom_of_pixels(estimate)
    single = float(estimate.renders - 1)
    total = tile_sums(variance)
    freedom = satterthwaite(total, tile_sums(squares), single)
    own = own_variance_of_tiles(estimate, keep)
    factor, notable = 1.0, None
    if own is None:
        whole, whole_freedom = variance.sum(axis=(0, 1)), None
        whole_freedom = satterthwaite(whole, squares.sum(axis=(0, 1)), single)
        tiles, tiles_freedom = total, freedom
    else:
        whole = own_variance_of_whole(estimate, keep, own)
        whole_freedom = np.full_like(whole, single)
        # Excludes tiles whose values vary only by rounding.
        noisy = total > (estimate.rounding * tile_sums(estimate.mean * keep)) ** 2
        tiles, tiles_freedom, factor = moderated(own, total, freedom, noisy, single)
        notable = factor if is_notable(own, total, noisy, single) else None
    pixels, pixels_freedom = pooled(variance, squares, masked, max(factor, 1.0))
    return Noise(pixels, pixels_freedom, tiles, tiles_freedom, whole, whole_freedom, notable)


def pooled(variance, squares, masked, factor):
    """Returns the variance of each pixel and its degrees of freedom: its own variance, or the mean over
    itself and its neighbours (see verdict.py). If neighbours share noise, their number of independent
    variances is divided by `factor`."""
    count = neighbourhood((~masked).astype(float))[:, :, None]
    total = neighbourhood(variance)
    mean = total / np.maximum(count, 1)
    single = quotient(variance ** 2, squares, 1)
    together = satterthwaite(total, factor * neighbourhood(squares), 1)
    return np.maximum(variance, mean), np.where(variance >= mean, single, together)


def own_variance_of_tiles(estimate, keep):
    """Returns the variance of each tile's sum between renders, or None if only the variances of pixels are
    known."""
    if estimate.stack is not None:
        return tile_sums(estimate.stack * keep).var(axis=0, ddof=1) / estimate.renders
    if estimate.tile_variance is None:
        return None
    # Scales the variance by the share of the pixels that aren't masked.
    kept = quotient(tile_sums(estimate.variance * keep), tile_sums(estimate.variance), 1)
    return estimate.tile_variance * kept


def own_variance_of_whole(estimate, keep, own):
    if estimate.stack is not None:
        sums = (estimate.stack * keep).sum(axis=(1, 2))
        return sums.var(axis=0, ddof=1) / estimate.renders
    kept = quotient(own.sum(axis=(0, 1)), estimate.tile_variance.sum(axis=(0, 1)), 1)
    return estimate.whole_variance * kept


def moderated(own, total, freedom, noisy, single):
    """Returns (variances of tiles, their degrees of freedom, the factor s): see the top of this file."""
    count = noisy.any(axis=2).sum()
    if not count:
        return np.maximum(own, total), freedom, 1.0
    if count < MIN_TILES:
        return own, np.full_like(own, single), float((own[noisy] / total[noisy]).mean())
    ratio = quotient(own, total, 1)
    scale, prior = distribution_of_factors(ratio[noisy], single)
    share = single / (prior + single)  # weight of a tile's own variance; prior may be infinite
    variance = (1 - share) * scale * total + share * own
    known = min(prior + single, single * count)  # the channels of a tile count as one
    tiles_freedom = 1 / ((1 - share) ** 2 * max(scale, 1.0) / freedom + 1 / known)
    unlike = special.fdtrc(single, min(prior, 1e9), ratio / scale) < UNUSUAL_ALPHA
    use_own = unlike & noisy
    tiles = np.where(use_own, own, np.where(noisy, variance, np.maximum(own, total)))
    return tiles, np.where(use_own, single, tiles_freedom), scale


def distribution_of_factors(ratio, single):
    """Returns (scale, degrees of freedom) of the distribution of factors, without the noise of an estimate
    with `single` degrees of freedom. The degrees of freedom are infinite if all factors are the same."""
    half = single / 2
    logs = np.log(np.maximum(ratio, 1e-5 * np.median(ratio))) - special.digamma(half) + np.log(half)
    spread = logs.var(ddof=1) - special.polygamma(1, half)
    if spread <= 0:
        return float(ratio.mean()), np.inf
    prior = 2 * inverse_trigamma(spread)
    return float(np.exp(logs.mean() + special.digamma(prior / 2) - np.log(prior / 2))), prior


def inverse_trigamma(value):
    """Inverts the trigamma function by Newton's method on 1 / trigamma, which is nearly linear."""
    x = 0.5 + 1 / value
    for _ in range(50):
        trigamma = special.polygamma(1, x)
        step = trigamma * (1 - trigamma / value) / special.polygamma(2, x)
        x += step
        if abs(step) < 1e-8 * x:
            break
    return float(x)


def is_notable(own, total, noisy, single):
    """Returns whether tiles vary significantly more than their pixels imply."""
    if not noisy.any():
        return False
    freedom = noisy.any(axis=2).sum() * single
    ratio = (own[noisy] / total[noisy]).mean()
    return special.chdtrc(freedom, ratio * freedom) < NOTABLE_ALPHA
