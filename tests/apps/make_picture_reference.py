"""Prints tests/apps/picture_reference.inc: FLIP by NVIDIA's implementation, and relMSE by
validation/compare, for two small images. picture_comparison_test.cpp computes the same images.

    python3 -m venv v && v/bin/pip install flip-evaluator==1.7 numpy
    v/bin/python tests/apps/make_picture_reference.py > tests/apps/picture_reference.inc
"""
import pathlib
import sys
from importlib import metadata

import flip_evaluator
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "validation"))
from compare.errors import Errors  # noqa: E402
from compare.images import Estimate  # noqa: E402

WIDTH, HEIGHT = 64, 48
PLACES = [(0, 0), (63, 47), (20, 12), (31, 30), (40, 9), (10, 40), (22, 15), (50, 25)]


def pictures():
    """Returns (reference, other): linear, in [0,1]."""
    y, x, c = np.meshgrid(np.arange(HEIGHT), np.arange(WIDTH), np.arange(3), indexing="ij")
    reference = ((5 * x + 3 * y + 40 * c) % 256) / 255
    other = np.clip(reference + ((7919 * x + 104729 * y + 1299721 * c) % 61 - 30) / 300, 0, 1)
    square = np.array([0.9, 0.2, 0.1])[c]
    for picture, left in ((reference, 20), (other, 21)):
        inside = (x >= left) & (x < left + 16) & (y >= 12) & (y < 28)
        picture[inside] = square[inside]
    return reference.astype(np.float32), other.astype(np.float32)


def print_values(name, values):
    rows = ", ".join("{%d, %d, %.6ff}" % (x, y, values[y, x]) for x, y in PLACES)
    print("constexpr PixelValue %s[] = {%s};" % (name, rows))


def main():
    reference, other = pictures()
    print("// Made by make_picture_reference.py with flip-evaluator %s." %
          metadata.version("flip-evaluator"))
    print("// clang-format off")
    values, mean, _ = flip_evaluator.evaluate(reference, other, "LDR", inputsRGB=False,
                                              applyMagma=False)
    print("constexpr double kLdrFlip = %.8f;" % mean)
    print_values("kLdrFlipAt", values[:, :, 0])
    bright, bright_other = 20 * reference ** 2, 20 * other ** 2
    values, mean, used = flip_evaluator.evaluate(bright, bright_other, "HDR", applyMagma=False)
    print("constexpr double kHdrFlip = %.8f;" % mean)
    print("constexpr double kFirstExposure = %.8f, kLastExposure = %.8f;" %
          (used["startExposure"], used["stopExposure"]))
    print("constexpr int kExposures = %d;" % used["numExposures"])
    print_values("kHdrFlipAt", values[:, :, 0])

    masked = np.zeros((HEIGHT, WIDTH), bool)
    masked[5, 7] = masked[30, 11] = True  # the test has a NaN and an infinity here
    for name, variance in (("", 0 * bright), ("OfNoisy", 0.01 * bright)):
        truth = Estimate("reference", bright.astype(float), variance.astype(float), 16,
                         masked=masked)
        errors = Errors.of(bright_other.astype(float), truth, masked)
        print("constexpr double kRelMse%s = %.10g, kLargest%s = %.10g;" %
              (name, errors.relmse, name, errors.maximum))


if __name__ == "__main__":
    main()
