#!/usr/bin/env python3
"""Writes sunsky_tables.cpp, the numbers of the Hošek-Wilkie sky and sun, on stdout:

    v/bin/pip install mitsuba==3.9.1
    python3 make_sunsky_tables.py v/lib/python3.*/site-packages/mitsuba/data/sunsky > sunsky_tables.cpp

Hošek and Wilkie publish their fits as C headers, which the package holds as arrays: the sky's (for
RGB) by turbidity, albedo, control point and channel; and the sun's irradiance, which Mitsuba's
authors have integrated from the second paper's radiance, by turbidity, elevation and wavelength.
That becomes RGB here: by the CIE's colour matching functions at these eleven wavelengths.
"""

import array
import math
import pathlib
import struct
import sys

SOLAR_HALF_ANGLE = math.radians(0.5358 / 2)
# CIE 1931 2-degree observer, x, y, z at 320, 360, ... 720 nm.
MATCHING = [(0, 0, 0), (0.000129900, 0.000003917, 0.000606100),
            (0.014310000, 0.000396000, 0.067850010), (0.348280000, 0.023000000, 1.747060000),
            (0.095640000, 0.139020000, 0.812950100), (0.063270000, 0.710000000, 0.078249990),
            (0.594500000, 0.995000000, 0.003900000), (1.062200000, 0.631000000, 0.000800000),
            (0.447900000, 0.175000000, 0.000020000), (0.046770000, 0.017000000, 0.000000000),
            (0.002899327, 0.001047000, 0.000000000)]
TO_RGB = [(3.240479, -1.537150, -0.498535), (-0.969256, 1.875991, 0.041556),
          (0.055648, -0.204043, 1.057311)]
# What makes the sky's unit the sun's: measured on Mitsuba's own emitter.
SUN_SCALE = 0.3986188
# 1 / 106.750..., the integral of y: as the sky's numbers are those of luminance without 683 lm/W.
LUMINANCE_SCALE = 1 / 106.7502593994140625


def read(path):
    """The arrays of a file of Mitsuba's: name, shape and numbers."""
    data = path.read_bytes()
    count, = struct.unpack_from("<I", data, 14)
    at, arrays = 18, {}
    for _ in range(count):
        length, = struct.unpack_from("<H", data, at)
        name = data[at + 2:at + 2 + length].decode()
        dimensions, kind, begin = struct.unpack_from("<HBQ", data, at + 2 + length)
        at += 13 + length
        shape = struct.unpack_from(f"<{dimensions}Q", data, at)
        at += 8 * dimensions
        numbers = array.array({10: "f", 11: "d"}[kind])
        size = math.prod(shape) * numbers.itemsize
        numbers.frombytes(data[begin:begin + size])
        arrays[name] = shape, numbers
    return arrays


def write(name, what, numbers):
    print(f"\n/// {what}\nconst float {name}[] = {{")
    for i in range(0, len(numbers), 7):
        print("    " + ", ".join(f"{x:.8g}" + ("f" if "." in f"{x:.8g}" or "e" in f"{x:.8g}" else
                                                ".f") for x in numbers[i:i + 7]) + ",")
    print("};")


def sun_colours(irradiance):
    """Radiance of the sun's disk, of its own size: R, G, B of each row of eleven wavelengths."""
    scale = SUN_SCALE / (2 * math.pi * (1 - math.cos(SOLAR_HALF_ANGLE)))
    for i in range(0, len(irradiance), len(MATCHING)):
        row = irradiance[i:i + len(MATCHING)]
        xyz = [sum(value * m[c] for value, m in zip(row, MATCHING)) for c in range(3)]
        yield from (scale * sum(a * b for a, b in zip(line, xyz)) for line in TO_RGB)


def main():
    folder = pathlib.Path(sys.argv[1])
    sky, sun = read(folder / "sunsky_datasets.bin"), read(folder / "sampling_data.bin")
    assert sky["sky_params_rgb"][0] == (10, 2, 6, 3, 9)
    assert sky["sky_rad_rgb"][0] == (10, 2, 6, 3)
    assert sun["sun_irradiance"][0] == (10, 30, 11)
    print("// Made by make_sunsky_tables.py; the numbers are under this licence:\n//")
    text = (folder / "LICENSE").read_text(encoding="utf-8")
    for line in text[text.index("Copyright (c)"):].strip().splitlines():
        print(f"// {line}".rstrip())
    print('\n#include "sunsky_tables.h"\n\nnamespace kinome::sunsky {')
    write("kSkyShape", "By turbidity 1 ... 10, albedo 0 and 1, control point, channel, parameter.",
          sky["sky_params_rgb"][1])
    write("kSkyRadiance", "By turbidity 1 ... 10, albedo 0 and 1, control point, channel.",
          [LUMINANCE_SCALE * x for x in sky["sky_rad_rgb"][1]])
    write("kSunRadiance", "By turbidity 1 ... 10, elevation 2, 5 ... 89 degrees, channel.",
          list(sun_colours(sun["sun_irradiance"][1])))
    print("\n}  // namespace kinome::sunsky")


if __name__ == "__main__":
    main()
