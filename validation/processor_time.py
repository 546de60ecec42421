#!/usr/bin/env python3
"""Compares the processor time of two builds of kinome in the scenes of the benchmark.

Usage: validation/processor_time.py BEFORE AFTER [SCENE...] [--rounds 3] [--spp 16] [--size 256] [--output FILE.csv]

BEFORE and AFTER are build folders. Both programs render the scene files of this tree with `clustered` and two
threads, in turns. Times are those of whole processes. Prints the medians for each scene, and the median of the
ratios of a scene's rounds with their range.
"""
import argparse
import csv
import math
import pathlib
import statistics
import tempfile

from program import commit, machine, run_kinome
from suite.tables import SCENES, THREADS


def size_of(scene, pixels):
    """Returns the width and height of `pixels` pixels in the proportions of the scene."""
    width, height = scene.size
    factor = math.sqrt(pixels / (width * height))
    return round(width * factor), round(height * factor)


def measure(scene, builds, options, folder):
    """Returns the processor seconds of each build, by round."""
    width, height = size_of(scene, options.size ** 2)
    defines = {"width": width, "height": height, "spp": options.spp, "integrator": "clustered"}
    times = {build: [] for build in builds}
    for turn in range(options.rounds):
        for build in builds if turn % 2 == 0 else builds[::-1]:
            stats = run_kinome(build, scene.path, folder / "image.exr", defines, seed=turn,
                               options=["-t", str(THREADS)])
            times[build].append(stats["processor_seconds"])
    return [times[build] for build in builds]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=pathlib.Path)
    parser.add_argument("after", type=pathlib.Path)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="all if none is given")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--size", type=int, default=256, help="the images have SIZE² pixels")
    parser.add_argument("--output", type=pathlib.Path)
    options = parser.parse_args()
    unknown = set(options.scenes).difference(scene.name for scene in SCENES)
    if unknown:
        parser.error(f"unknown scenes {sorted(unknown)}")
    builds = [options.before.resolve(), options.after.resolve()]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for scene in SCENES:
            if options.scenes and scene.name not in options.scenes:
                continue
            before, after = measure(scene, builds, options, pathlib.Path(folder))
            ratios = [new / old for old, new in zip(before, after)]
            rows.append([scene.name, statistics.median(before), statistics.median(after), statistics.median(ratios),
                         min(ratios), max(ratios)])
            print("{}: {:.2f} s, {:.2f} s, ratio {:.3f} ({:.3f} to {:.3f})".format(*rows[-1]), flush=True)
    mean = math.exp(statistics.fmean(math.log(row[3]) for row in rows))
    print(f"geometric mean of the ratios: {mean:.3f}, at {commit()[:10]} on {machine()['processor']}")
    if options.output:
        with options.output.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["scene", "before, s", "after, s", "ratio", "lowest ratio", "highest ratio"])
            writer.writerows([name, *(f"{value:.4g}" for value in values)] for name, *values in rows)


if __name__ == "__main__":
    main()
