"""Tiles in which the reference hardly found the light.

Where light is rare to a renderer, most values of a tile are exactly 0, and the others come from one
or two renders out of all. Such a tile's variance tells of the light that was found; of the rest, which
may be most of it, it knows nothing. What was found is there, though: a picture that is darker than it
can be told wrong, one that is brighter can't.

A tile (of one channel) counts as such if more than half of its values are 0, others are not, and
these have been found by `MOST_HITS` of the renders or fewer, on average. So it is no such tile that
is black, or part black and part lit (what is lit, all renders find), or noisy without zeros.
"""
import dataclasses

import numpy as np

from .noise import TILE, hits, quotient, tile_sums

ZEROS = 0.5
MOST_HITS = 2.0  # of 16 renders or more; of n renders, n / 8


def hardly_found(estimate, masked):
    """(rows, columns, channels): is it such a tile?"""
    keep = ~masked[:, :, None]
    is_zero = (estimate.mean == 0) & (estimate.variance == 0)
    values = tile_sums(np.where(keep, np.ones_like(estimate.mean), 0))
    zeros = tile_sums((is_zero & keep).astype(float))
    found = quotient(tile_sums(hits(estimate) * keep), values - zeros, 0)
    most = min(MOST_HITS, estimate.renders / 8)
    return (zeros > ZEROS * values) & (zeros < values) & (found <= most)


def of_pixels(tiles, shape):
    """A value of each tile at each of its pixels."""
    rows = np.repeat(tiles, TILE, axis=0)[:shape[0]]
    return np.repeat(rows, TILE, axis=1)[:, :shape[1]]


@dataclasses.dataclass
class Missed:
    """What is said of such tiles: they are judged only where A is darker."""

    tiles: int
    of: int  # tiles in all
    places: list  # [x, y] of each one's first pixel
    zeros: float  # share of the reference's values there that are 0
    light: float  # share of A's light that they hold


def describe(a, b, dim):
    """The Missed of (rows, columns, channels) tiles, or None."""
    places = np.argwhere(dim.any(axis=2))
    if not len(places):
        return None
    inside = of_pixels(dim, a.mean.shape)
    total = np.abs(a.mean).sum()
    return Missed(len(places), int(np.prod(dim.shape[:2])),
                  [[int(x) * TILE, int(y) * TILE] for y, x in places],
                  float((b.mean[inside] == 0).mean()),
                  float(np.abs(a.mean[inside]).sum() / total) if total > 0 else 0.0)
