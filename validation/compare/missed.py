"""Tiles in which the reference hardly found the light.

Where light is rare to a renderer, many values of a tile are exactly 0, the others come from one or
two renders out of all, and a handful of these is so much brighter than the rest that the tile's
variance is theirs alone. Such a variance tells of the light that was found; of the brighter light
that wasn't, which may be most of it, it knows nothing. What was found is there, though: a picture
that is darker than it can be told wrong, one that is brighter can't.

A tile (of one channel) counts as such if

  * more than a fifth of its values are 0, others are not, and the latter were found by MOST_HITS of
    the renders or fewer, on average: no tile that is part black and part lit, which all renders
    find, nor one that is noisy without zeros;
  * no more than CARRIERS of its values carry its variance, (Σv)² / Σv², in the mean over it and the
    like around it: where hits are many and alike, they tell the variance well, however rare they
    are. (By itself, a tile without the brightest light would have many carriers, and stay.)

A tile that is black in the reference stays black, and light there is wrong; but for one beside such
tiles which holds, in the other picture, so little that the reference might have missed all of it:
no more than CHANCE of its hits in those tiles are worth.
"""
import dataclasses

import numpy as np

from .noise import TILE, hits, neighbourhood, quotient, tile_sums

ZEROS = 0.2
MOST_HITS = 2.0  # of 16 renders or more; of n renders, n / 8
CARRIERS = 10
NAMED = 5  # places, in a sentence
CHANCE = 10  # hits that are due: none is met once in exp(10) = 22000 tiles


def hardly_found(a, b, masked):
    """(rows, columns, channels) of tiles: is it such a one in the reference b?"""
    keep = ~masked[:, :, None]
    variance = b.variance * keep
    values = tile_sums(np.where(keep, np.ones_like(b.mean), 0))
    zeros = tile_sums(((b.mean == 0) & (b.variance == 0) & keep).astype(float))
    found = tile_sums(hits(b) * keep)
    is_rare = quotient(found, values - zeros, 0) <= min(MOST_HITS, b.renders / 8)
    dim = (zeros > ZEROS * values) & (zeros < values) & is_rare
    total, squares, number = (neighbourhood(dim * x) for x in (
        tile_sums(variance), tile_sums(variance ** 2), 1.0))
    dim &= quotient(total ** 2, squares * number, 0) <= CARRIERS
    # What a hit is worth in such tiles, over those around each tile.
    worth = quotient(neighbourhood(dim * tile_sums(b.mean * keep)), neighbourhood(dim * found), 0)
    is_black = (zeros == values) & (values > 0)
    return dim | (is_black & (tile_sums(a.mean * keep) < CHANCE * worth))


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

    def sentence(self, b):
        places = ", ".join(f"{x},{y}" for x, y in self.places[:NAMED])
        more = f" and {len(self.places) - NAMED} more" if len(self.places) > NAMED else ""
        return (f"left out unless A is darker than B: {self.tiles} of {self.of} tiles, with "
                f"{self.light:.2g} of A's light, where {b.name} hardly found the light and can't "
                f"say how bright it is ({self.zeros:.0%} of its values there are exactly 0, the "
                f"others come from one or two of its {b.renders} renders). They begin at pixel "
                f"{places}{more}")


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
