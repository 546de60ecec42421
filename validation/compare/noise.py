"""How uncertain pixels, tiles and the whole picture are: variances and their degrees of freedom.

Pixels may have noise in common. A reconstruction filter wider than its pixel spreads each sample
over several (with the Gaussian, the mean of a tile is 1.8 times as uncertain as its pixels alone
would have it); lights and light paths may be shared by all of them. Two things are known of a tile:

  own    the variance of its mean from render to render: right whatever the pixels share, but known
         by N renders only, with N - 1 degrees of freedom;
  P      the sum of its pixels' variances: 256 times the sample, but right by a factor only, which
         is 1 where pixels share nothing.

That factor, own / P, is much the same in all tiles where it comes from the filter, and another in
each where it comes from what the scene does. How much of its spread is more than N - 1 degrees of
freedom bring about is estimated from all tiles, and each tile's variance is the mean of its own and
of what all tiles have it to be, weighed by what either is worth:

    V = (d0 s P + d own) / (d0 + d),    d = N - 1

with the scale s and the degrees of freedom d0 of the factor's distribution by moments of log(own/P)
(the moderated t statistic: Smyth, Linear models and empirical Bayes methods, 2004). A tile whose
own variance is beyond what that distribution allows one in a hundred has its own alone.

The whole picture's variance is the one from render to render. A file that tells of its pixels alone
is taken for one of a box filter and independent pixels, as Mitsuba's references are.
"""
import dataclasses

import numpy as np
from scipy import special

TILE = 16
FEWEST_TILES = 3  # to tell how much their factors differ
UNUSUAL = 0.01  # of tiles as all others: how often one is taken for unlike them
NOTABLE = 1e-3  # false-alarm rate of saying that pixels share noise


def tile_sums(x):
    """Sums over tiles of the two axes before the last; the last tile of a row may be narrower."""
    rows = np.add.reduceat(x, np.arange(0, x.shape[-3], TILE), axis=-3)
    return np.add.reduceat(rows, np.arange(0, x.shape[-2], TILE), axis=-2)


def neighbourhood(x):
    """Sums over 3x3 pixels; beyond the edge there is nothing."""
    padded = np.pad(x, ((1, 1), (1, 1)) + ((0, 0),) * (x.ndim - 2))
    rows = padded[:-2] + padded[1:-1] + padded[2:]
    return rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:]


def quotient(a, b, otherwise):
    """a / b, and what to take where b is 0."""
    return np.divide(a, b, out=np.full(np.broadcast(a, b).shape, float(otherwise)), where=b > 0)


def hits(estimate):
    """How many of the renders each value's light comes from, by its mean and variance: n where all
    found the same, 1 where one found all of it, 0 where none found any.

    k of n renders that found alike make a relative variance of the mean of (n - k) / (k (n - 1)).
    """
    n = estimate.renders
    found = quotient(n * estimate.mean ** 2,
                     estimate.mean ** 2 + (n - 1) * estimate.variance, 0)
    return np.where((estimate.mean == 0) & (estimate.variance == 0), 0, found)


def freedom_of_pixels(estimate):
    """Degrees of freedom of each value's variance: n - 1, or fewer where few renders found light.

    The variance of a variance is V² (kurtosis excess / n + 2 / (n - 1)); where k of n found light,
    the excess is about n / k - 1.
    """
    n = estimate.renders
    found = np.clip(hits(estimate), 1, n)
    return 2 / (1 / found - 1 / n + 2 / (n - 1))


def satterthwaite(total, squares, otherwise):
    """Degrees of freedom of a sum of independent variances. squares: the sum of V² / freedom."""
    return quotient(total ** 2, squares, otherwise)


@dataclasses.dataclass
class Noise:
    """Of one estimate. Variances of sums over pixels that aren't masked, with their freedom."""

    pixels: np.ndarray  # (height, width, channels)
    pixels_freedom: np.ndarray
    tiles: np.ndarray  # (rows, columns, channels)
    tiles_freedom: np.ndarray
    whole: np.ndarray  # (channels,)
    whole_freedom: np.ndarray
    factor: float | None  # by which pixels that share noise raise a tile's variance, if notable


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
        # What varies by rounding alone says nothing of noise.
        noisy = total > (estimate.rounding * tile_sums(estimate.mean * keep)) ** 2
        tiles, tiles_freedom, factor = moderated(own, total, freedom, noisy, single)
        notable = factor if is_notable(own, total, noisy, single) else None
    pixels, pixels_freedom = pooled(variance, squares, masked, max(factor, 1.0))
    return Noise(pixels, pixels_freedom, tiles, tiles_freedom, whole, whole_freedom, notable)


def pooled(variance, squares, masked, factor):
    """Of each pixel: its own variance, or the mean over itself and its neighbours (see verdict.py).
    Where neighbours share noise, their variances tell as much as 1/factor as many."""
    count = neighbourhood((~masked).astype(float))[:, :, None]
    total = neighbourhood(variance)
    mean = total / np.maximum(count, 1)
    single = quotient(variance ** 2, squares, 1)
    together = satterthwaite(total, factor * neighbourhood(squares), 1)
    return np.maximum(variance, mean), np.where(variance >= mean, single, together)


def own_variance_of_tiles(estimate, keep):
    """Of each tile's sum, from render to render; None where only pixels are known."""
    if estimate.stack is not None:
        return tile_sums(estimate.stack * keep).var(axis=0, ddof=1) / estimate.renders
    if estimate.tile_variance is None:
        return None
    # What else is masked takes its share with it.
    kept = quotient(tile_sums(estimate.variance * keep), tile_sums(estimate.variance), 1)
    return estimate.tile_variance * kept


def own_variance_of_whole(estimate, keep, own):
    if estimate.stack is not None:
        sums = (estimate.stack * keep).sum(axis=(1, 2))
        return sums.var(axis=0, ddof=1) / estimate.renders
    kept = quotient(own.sum(axis=(0, 1)), estimate.tile_variance.sum(axis=(0, 1)), 1)
    return estimate.whole_variance * kept


def moderated(own, total, freedom, noisy, single):
    """(variances of tiles, their degrees of freedom, the factor s): see the top of this file."""
    count = noisy.any(axis=2).sum()
    if not count:
        return np.maximum(own, total), freedom, 1.0
    if count < FEWEST_TILES:
        return own, np.full_like(own, single), float((own[noisy] / total[noisy]).mean())
    ratio = quotient(own, total, 1)
    scale, prior = distribution_of_factors(ratio[noisy], single)
    share = single / (prior + single)  # of a tile's own; prior may be infinite
    variance = (1 - share) * scale * total + share * own
    known = min(prior + single, single * count)  # the channels of a tile count as one
    tiles_freedom = 1 / ((1 - share) ** 2 * max(scale, 1.0) / freedom + 1 / known)
    unlike = special.fdtrc(single, min(prior, 1e9), ratio / scale) < UNUSUAL
    use_own = unlike & noisy
    tiles = np.where(use_own, own, np.where(noisy, variance, np.maximum(own, total)))
    return tiles, np.where(use_own, single, tiles_freedom), scale


def distribution_of_factors(ratio, single):
    """(scale, degrees of freedom) of the distribution that factors have beside the noise of an
    estimate with `single` degrees of freedom: the latter infinite where all are the same."""
    half = single / 2
    logs = np.log(np.maximum(ratio, 1e-5 * np.median(ratio))) - special.digamma(half) + np.log(half)
    spread = logs.var(ddof=1) - special.polygamma(1, half)
    if spread <= 0:
        return float(ratio.mean()), np.inf
    prior = 2 * inverse_trigamma(spread)
    return float(np.exp(logs.mean() + special.digamma(prior / 2) - np.log(prior / 2))), prior


def inverse_trigamma(value):
    """By Newton's method on 1 / trigamma, which is nearly linear."""
    x = 0.5 + 1 / value
    for _ in range(50):
        trigamma = special.polygamma(1, x)
        step = trigamma * (1 - trigamma / value) / special.polygamma(2, x)
        x += step
        if abs(step) < 1e-8 * x:
            break
    return float(x)


def is_notable(own, total, noisy, single):
    """Is it more than chance that tiles vary more than their pixels?"""
    if not noisy.any():
        return False
    freedom = noisy.any(axis=2).sum() * single
    ratio = (own[noisy] / total[noisy]).mean()
    return special.chdtrc(freedom, ratio * freedom) < NOTABLE
