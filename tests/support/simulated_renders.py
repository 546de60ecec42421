"""Images and renders with known noise, for the tests of `kinome compare`."""

import pathlib
import sys

import numpy as np
import OpenImageIO as oiio

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "validation"))
from compare import Estimate  # noqa: E402

HEIGHT, WIDTH = 48, 64
Y, X = np.mgrid[0:HEIGHT, 0:WIDTH]
RENDERS = 16


def write_exr(path, channels, kind=oiio.FLOAT, header=()):
    """Writes an EXR file. channels: {name: (height, width)}; header: texts by name."""
    height, width = next(iter(channels.values())).shape
    spec = oiio.ImageSpec(width, height, len(channels), kind)
    spec.channelnames = list(channels)
    for name, text in dict(header).items():
        spec.attribute(name, text)
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), spec), oiio.geterror()
    out.write_image(np.stack(list(channels.values()), axis=2).astype(np.float32))
    out.close()


def write_parts(path, parts):
    """Writes an EXR file of several parts. Each part is (channels as in write_exr, name)."""
    specs = []
    for channels, name in parts:
        height, width = next(iter(channels.values())).shape
        spec = oiio.ImageSpec(width, height, len(channels), oiio.FLOAT)
        spec.channelnames = list(channels)
        spec.attribute("oiio:subimagename", name)
        specs.append(spec)
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), tuple(specs)), oiio.geterror()
    for i, (channels, _) in enumerate(parts):
        assert i == 0 or out.open(str(path), specs[i], "AppendSubimage"), oiio.geterror()
        out.write_image(np.stack(list(channels.values()), axis=2).astype(np.float32))
    out.close()


def write_rgb(path, image, kind=oiio.FLOAT):
    write_exr(path, {name: image[:, :, i] for i, name in enumerate("RGB")}, kind)


def picture():
    """Returns radiance that varies by a factor of 20 over the image, with a noise-free emitter in
    view."""
    image = 0.2 + 0.6 * np.sin(X / 9) ** 2 * np.cos(Y / 13) ** 2
    image = image + 3 * np.exp(-((X - 40) ** 2 + (Y - 20) ** 2) / 30)
    image[5:9, 5:12] = 6
    return image


def noisy(rng, image, samples, kind):
    """Returns a render with `samples` samples per pixel, whose distribution has a path tracer's
    tails."""
    shape = image.shape
    if kind == "gamma":  # a few strong contributions among many near 0; more noise on the left
        k = samples * (0.05 + 0.5 * X / WIDTH)
        factor = rng.gamma(k) / k
    elif kind == "lognormal":
        normal = rng.standard_normal((samples, *shape), np.float32)
        factor = np.exp(np.float32(1.2) * normal - np.float32(0.72)).mean(axis=0, dtype=float)
    else:  # fireflies: half of the light is in one of 125 to 1000 samples
        rare = 0.0045 + 0.0035 * np.sin(X / 3)
        factor = (rng.gamma(samples, size=shape) + rng.binomial(samples, rare) / rare) / samples / 2
    factor[5:9, 5:12] = 1
    return image * factor


def estimate(rng, image, samples, kind, stored=False, renders=RENDERS):
    """Returns an estimate of one channel; `stored`: as if read from a file of mean and variance."""
    made = Estimate.from_renders(
        "simulated", [noisy(rng, image, samples, kind)[:, :, None] for _ in range(renders)])
    if stored:
        made.stack = None
    return made


def rare(rng, image, hits=0.2, spread=2.0):
    """Returns a render with rare light. All RENDERS together find each value's light `hits` times.
    Its brightness is lognormal; `spread` is the standard deviation of the logarithm."""
    count = rng.poisson(hits / RENDERS, image.shape)
    found = np.zeros(image.shape)
    for i in range(count.max()):
        found += (count > i) * np.exp(spread * rng.standard_normal(image.shape) - spread ** 2 / 2)
    return image * found * RENDERS / hits
