"""Small noise images for tests: sRGB bytes (PPM) and floats (PFM)."""
import numpy as np


def write_ppm(path, width, height, seed):
    pixels = np.random.default_rng(seed).bytes(3 * width * height)
    path.write_bytes(b"P6 %d %d 255\n" % (width, height) + pixels)


def write_pfm(path, width, height, seed, low=0, high=1):
    pixels = np.random.default_rng(seed).uniform(low, high, (height, width, 3)).astype("<f4")
    path.write_bytes(b"PF\n%d %d\n-1\n" % (width, height) + pixels.tobytes())
