"""Measures the bias of Mitsuba's samplers: why the references here aren't made with ldsampler.

    v/bin/python validation/references/check_samplers.py [SCENE.xml]

Prints for each sampler the mean of each 16x16 tile's deviation from the mean of `independent`, as
the largest z of any tile, and exits with 0. About 2 minutes. Needs mitsuba 3.9.1 and libllvm19.
"""
import pathlib
import sys

import environment

VARIANT = "llvm_ad_rgb" if environment.use_llvm() else "scalar_rgb"
import mitsuba as mi  # noqa: E402
import numpy as np  # noqa: E402

SCENE = pathlib.Path(__file__).resolve().parents[1] / "scenes/plastic.xml"
SEEDS = 16


def tiles(scene, sampler, samples):
    """Mean of each tile's green, and its variance from the seeds."""
    loaded = mi.load_file(str(scene), sampler=sampler)
    renders = []
    for seed in range(SEEDS):
        green = np.array(mi.render(loaded, seed=seed, spp=samples), np.float64)[:, :, 1]
        rows = np.add.reduceat(green, np.arange(0, green.shape[0], 16), axis=0)
        renders.append(np.add.reduceat(rows, np.arange(0, green.shape[1], 16), axis=1) / 256)
    return np.mean(renders, axis=0), np.var(renders, axis=0, ddof=1) / SEEDS


def main():
    scene = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else SCENE
    mi.set_variant(VARIANT)
    mi.set_log_level(mi.LogLevel.Error)
    truth, variance = tiles(scene, "independent", 1024)
    for sampler, samples in (("independent", 256), ("stratified", 256), ("multijitter", 256),
                             ("orthogonal", 289), ("ldsampler", 16), ("ldsampler", 64),
                             ("ldsampler", 256), ("ldsampler", 1024)):
        mean, own = tiles(scene, sampler, samples)
        z = (mean - truth) / np.sqrt(variance + own)
        worst = np.unravel_index(np.abs(z).argmax(), z.shape)
        print(f"{sampler:<12} {samples:>5} samples: worst tile {worst[1]},{worst[0]} off by "
              f"{mean[worst] / truth[worst] - 1:+.3%}, z = {z[worst]:+.1f}", flush=True)


if __name__ == "__main__":
    main()
