#!/usr/bin/python3
"""Measures the error rates of kinome-compare; prints a table with a row for each reconstruction filter.

    /usr/bin/python3 validation/compare_rates.py             simulates the film: 5 minutes
    /usr/bin/python3 validation/compare_rates.py --program   renders compare_rates.xml: 10 minutes

The columns are:

  - the number of pairs of correct images that fail at a nominal rate of 1 %;
  - the 95 % interval of that rate (Clopper and Pearson);
  - the number of pairs that would fail if pixels were assumed to be independent;
  - the number of detected differences, for a quarter as many pairs whose light differs by 0.3 %.
"""
import argparse
import concurrent.futures
import dataclasses
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from compare import compare, load
from scipy import stats
from simulated_film import FILTERS, render

ROOT = pathlib.Path(__file__).resolve().parents[1]
KINOME = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build")) / "bin/kinome"
ALPHA, BIAS = 0.01, 1.003
# `evenness` of a sample's noise: heavy tails, the worst case, for the rate; little noise for the bias.
HEAVY_TAILS, LITTLE_NOISE = 1, 4000
PROGRAM_FILTERS = ("box", "tent", "gaussian")
SAMPLES, SAMPLES_FOR_BIAS = 64, 512


def simulated(name, pairs):
    """Yields pairs of images whose noise has heavy tails."""
    rng = np.random.default_rng(list(name.encode()))
    for _ in range(pairs):
        yield [render(rng, name, 2, evenness=HEAVY_TAILS) for _ in range(2)]


def simulated_bias(name, pairs):
    rng = np.random.default_rng([0, *name.encode()])
    for _ in range(pairs):
        yield [render(rng, name, 3, bias, evenness=LITTLE_NOISE) for bias in (1, BIAS)]


def rendered(name, pairs, first_seed, samples, radiances):
    with tempfile.TemporaryDirectory() as folder:
        def one(seed, radiance):
            output = pathlib.Path(folder) / f"{seed}.exr"
            subprocess.run([KINOME, "-q", "-t", "1", "--variance", "--seed", str(seed),
                            "-D", f"filter={name}", "-D", f"spp={samples}", "-D",
                            f"radiance={radiance}", "-o", output,
                            ROOT / "validation/compare_rates.xml"], check=True)
            found = load(output)
            output.unlink()
            return found

        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            for i in range(pairs):
                yield list(pool.map(one, (first_seed + 2 * i, first_seed + 2 * i + 1), radiances))


def by_the_program(name, pairs):
    return rendered(name, pairs, 0, SAMPLES, (1, 1))


def bias_by_the_program(name, pairs):
    return rendered(name, pairs, 10000, SAMPLES_FOR_BIAS, (1, BIAS))


def by_pixels_alone(estimate):
    return dataclasses.replace(estimate, tile_variance=None, whole_variance=None)


def interval(count, number):
    low = stats.beta.ppf(0.025, count, number - count + 1) if count else 0
    high = stats.beta.ppf(0.975, count + 1, number - count) if count < number else 1
    return f"{low:.1%} to {high:.1%}"


def main():
    parser = argparse.ArgumentParser(prog="compare_rates.py", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", action="store_true", help="render instead of simulating")
    parser.add_argument("--pairs", type=int, default=200)
    parser.add_argument("--filter", action="append", help="measure only this filter; can be repeated")
    options = parser.parse_args()
    alike, unlike = ((by_the_program, bias_by_the_program) if options.program
                     else (simulated, simulated_bias))
    few = max(1, options.pairs // 4)
    print("| filter | false alarms | 95 % interval | from pixel variances alone | 0.3 % detected |")
    print("|---|---|---|---|---|")
    for name in options.filter or (PROGRAM_FILTERS if options.program else FILTERS):
        alarms = alone = 0
        for a, b in alike(name, options.pairs):
            alarms += not compare(a, b, ALPHA).passed
            alone += not compare(by_pixels_alone(a), by_pixels_alone(b), ALPHA).passed
        found = sum(not compare(bright, b, ALPHA).passed for b, bright in unlike(name, few))
        print(f"| {name} | {alarms} of {options.pairs} | {interval(alarms, options.pairs)} "
              f"| {alone} of {options.pairs} | {found} of {few} |", flush=True)


if __name__ == "__main__":
    sys.exit(main())
