"""Simulation of the program's film with reconstruction filters and lanes. It makes the output of
`kinome --variance` from samples with known expectation. Its filters include wider ones than the
program's."""

import numpy as np
from compare import Estimate
from compare.noise import tile_sums

HEIGHT, WIDTH, LANES = 48, 64, 16


def cubic(b, c):
    """Mitchell and Netravali's family of filters, radius 2."""
    def at(x):
        x = np.abs(x)
        near = (12 - 9 * b - 6 * c) * x ** 3 + (12 * b + 6 * c - 18) * x ** 2 + 6 - 2 * b
        far = ((-b - 6 * c) * x ** 3 + (6 * b + 30 * c) * x ** 2 - (12 * b + 48 * c) * x +
               8 * b + 24 * c)
        return np.where(x < 1, near, np.where(x < 2, far, 0)) / 6
    return at


def lanczos(x):
    return np.where(np.abs(x) < 3, np.sinc(x) * np.sinc(x / 3), 0)


def gaussian(x):
    return np.where(np.abs(x) < 2, np.exp(-2 * x * x) - np.exp(-8), 0)


# name: (radius, weight along an axis)
FILTERS = {"box": (0.5, lambda x: np.where((x > -0.5) & (x <= 0.5), 1.0, 0.0)),
           "tent": (1, lambda x: np.maximum(1 - np.abs(x), 0)),
           "gaussian": (2, gaussian),
           "mitchell": (2, cubic(1 / 3, 1 / 3)),
           "catmullrom": (2, cubic(0, 1 / 2)),
           "lanczos": (3, lanczos)}


def radiance(x, y):
    """Returns the expected radiance at film positions. It varies by a factor of 20 and has an edge."""
    value = 0.2 + 0.6 * np.sin(x / 9) ** 2 * np.cos(y / 13) ** 2
    value = value + 3 * np.exp(-((x - 40) ** 2 + (y - 20) ** 2) / 30)
    return np.where(x + 0.3 * y > 50, 0.3 * value, value)


def render(rng, name, samples, bias=1.0, common=0.0, evenness=1.0, lanes=LANES, height=HEIGHT,
           width=WIDTH):
    """Returns an Estimate as from a file of `kinome --variance`.

    name: filter; samples: number per pixel in each lane; bias: factor of all light.
    evenness: factor of the shape of the gamma distribution of a sample, 0.05 at the left to 0.55 at
    the right. common: relative standard deviation of noise that a lane's pixels share.
    """
    radius, weight = FILTERS[name]
    border = int(np.ceil(radius - 0.5))
    shape = lanes, height + 2 * border, width + 2 * border
    y, x = np.mgrid[-border:height + border, -border:width + border]
    sums, weights = np.zeros((2, lanes, height, width))
    shift = 1 + common * rng.standard_normal((lanes, 1, 1))
    for _ in range(samples):
        u, v = rng.random(shape), rng.random(shape)
        k = evenness * (0.05 + 0.5 * np.clip(x / width, 0, 1))
        values = bias * shift * radiance(x + u, y + v) * rng.gamma(k, size=shape) / k
        for i in range(-border, border + 1):
            rows = slice(border + i, border + i + height)
            wy = weight(v[:, rows] + i - 0.5)
            for j in range(-border, border + 1):
                columns = slice(border + j, border + j + width)
                w = wy[:, :, columns] * weight(u[:, rows, columns] + j - 0.5)
                sums += w * values[:, rows, columns]
                weights += w
    return developed(sums, weights)


def developed(sums, weights):
    """Computes the Estimate as libs/session/film_noise.cpp does. Both arrays are (lanes, height,
    width)."""
    lanes, all_weights = len(sums), weights.sum(axis=0)
    mean = sums.sum(axis=0) / all_weights
    shares = (sums - weights * mean) / all_weights * np.sqrt(lanes / (lanes - 1))
    return Estimate("simulated", mean[:, :, None], (shares ** 2).sum(axis=0)[:, :, None], lanes,
                    tile_variance=(tile_sums(shares[:, :, :, None]) ** 2).sum(axis=0),
                    whole_variance=(shares.sum(axis=(1, 2)) ** 2).sum(axis=0, keepdims=True))
