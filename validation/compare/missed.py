"""Incomplete tiles, in which the reference hardly found the light.

If a renderer seldom finds some light, many values of a tile are exactly 0. The others come from one or
two of all renders, and a few of them are so much brighter than the rest that they make up the variance
of the tile. This variance describes only the light that was found. It doesn't include the missing
light, which may be brighter and most of the total. The light that was found must be in the other image,
too. So the tests can detect an image that is darker than the reference, but not one that is brighter.

A tile of one channel is incomplete if both of these are true:

  * More than a fifth of its values are 0, but not all. On average, at most MAX_HITS renders found the
    others. This excludes tiles that are partly black and partly lit, whose light all renders find, and
    noisy tiles without zeros.
  * At most MAX_CARRIERS of its values carry its variance, (Σv)² / Σv², on average over the tile and
    such tiles around it. Many similar hits give a good estimate of the variance, even if they are rare.
    (Without its neighbours, a tile that misses the brightest light would have many carriers.)

Where the reference is black, the other image must be black, too. The only exception is a tile beside
incomplete ones whose light in the other image is so low that the reference might have missed all of it.
The limit is the light of MAX_MISSED_HITS average hits in these tiles.
"""
import dataclasses

import numpy as np

from .noise import TILE, hits, neighbourhood, quotient, tile_sums

MIN_ZEROS = 0.2
MAX_HITS = 2.0  # for 16 renders or more; n / 8 for fewer
MAX_CARRIERS = 10
MAX_LISTED = 5  # positions in the sentence
# With 10 expected hits, one of exp(10) = 22000 tiles has none.
MAX_MISSED_HITS = 10


def hardly_found(a, b, masked):
    """Returns an array (rows, columns, channels): true for tiles that are incomplete in the reference b."""
    keep = ~masked[:, :, None]
    variance = b.variance * keep
    values = tile_sums(np.where(keep, np.ones_like(b.mean), 0))
    zeros = tile_sums(((b.mean == 0) & (b.variance == 0) & keep).astype(float))
    found = tile_sums(hits(b) * keep)
    is_rare = quotient(found, values - zeros, 0) <= min(MAX_HITS, b.renders / 8)
    dim = (zeros > MIN_ZEROS * values) & (zeros < values) & is_rare
    total, squares, number = (neighbourhood(dim * x) for x in (
        tile_sums(variance), tile_sums(variance ** 2), 1.0))
    dim &= quotient(total ** 2, squares * number, 0) <= MAX_CARRIERS
    # Average light of a hit, over the incomplete tiles around each tile.
    worth = quotient(neighbourhood(dim * tile_sums(b.mean * keep)), neighbourhood(dim * found), 0)
    is_black = (zeros == values) & (values > 0)
    return dim | (is_black & (tile_sums(a.mean * keep) < MAX_MISSED_HITS * worth))


def of_pixels(tiles, shape):
    """Expands values of tiles to their pixels."""
    rows = np.repeat(tiles, TILE, axis=0)[:shape[0]]
    return np.repeat(rows, TILE, axis=1)[:, :shape[1]]


@dataclasses.dataclass
class Missed:
    """Report on incomplete tiles, which are tested only where A is darker."""

    tiles: int
    of: int  # number of all tiles
    places: list  # [x, y] of the first pixel of each tile
    zeros: float  # share of zeros among the reference's values there
    light: float  # share of A's light in these tiles

    def sentence(self, b):
        places = ", ".join(f"{x},{y}" for x, y in self.places[:MAX_LISTED])
        more = f" and {len(self.places) - MAX_LISTED} more" if len(self.places) > MAX_LISTED else ""
        return (f"left out unless A is darker than B: {self.tiles} of {self.of} tiles, with "
                f"{self.light:.2g} of A's light, where {b.name} hardly found the light, so its "
                f"brightness is unknown ({self.zeros:.0%} of its values there are exactly 0, the "
                f"others come from one or two of its {b.renders} renders). They begin at pixel "
                f"{places}{more}")


def describe(a, b, dim):
    """Returns the Missed of an array (rows, columns, channels) of tiles, or None if there are none."""
    places = np.argwhere(dim.any(axis=2))
    if not len(places):
        return None
    inside = of_pixels(dim, a.mean.shape)
    total = np.abs(a.mean).sum()
    return Missed(len(places), int(np.prod(dim.shape[:2])),
                  [[int(x) * TILE, int(y) * TILE] for y, x in places],
                  float((b.mean[inside] == 0).mean()),
                  float(np.abs(a.mean[inside]).sum() / total) if total > 0 else 0.0)
