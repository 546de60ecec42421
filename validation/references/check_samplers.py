"""Measures the bias of Mitsuba's ldsampler, because of which the references aren't made with it.

    v/bin/python validation/references/check_samplers.py [SCENE.xml]

First, the script computes the correlation of each pair of random numbers of a path, over the samples of a
pixel. It is 0 for every sampler with unbiased estimates. Then it renders the scene, and prints the 16x16
tile with the largest deviation from `independent` at 1024 samples, in standard deviations. Takes about a
minute. Needs mitsuba 3.9.1 and Debian's libllvm19.
"""
import pathlib
import sys

import environment

if not environment.use_llvm():
    sys.exit("check_samplers.py: libLLVM 19 not found: apt-get install libllvm19")
import mitsuba as mi  # noqa: E402
import numpy as np  # noqa: E402

mi.set_variant("llvm_ad_rgb")
SCENE = pathlib.Path(__file__).resolve().parents[1] / "scenes/plastic.xml"
SEEDS = 16
NAMES = ["film x", "film y"] + [
    f"bounce {bounce}, {use}" for bounce in (1, 2, 3)
    for use in ("emitter x", "emitter y", "lobe", "BSDF x", "BSDF y", "roulette")]
PAIRS = len(NAMES) * (len(NAMES) - 1) // 2


def path_numbers(kind, samples, seed, pixels):
    """Returns an array (number, pixels x samples) of random numbers, in the order in which Mitsuba's `path`
    uses them."""
    sampler = mi.load_dict({"type": kind, "sample_count": samples})
    sampler.set_samples_per_wavefront(samples)
    sampler.seed(seed, samples * pixels)
    film = sampler.next_2d()
    numbers = [film.x, film.y]
    for _ in range(3):
        emitter, lobe, bsdf = sampler.next_2d(), sampler.next_1d(), sampler.next_2d()
        numbers += [emitter.x, emitter.y, lobe, bsdf.x, bsdf.y, sampler.next_1d()]
    return np.array([np.array(x) for x in numbers])


def print_correlations(kind, samples):
    found = np.array([np.corrcoef(path_numbers(kind, samples, seed, 65536 // samples))
                      for seed in range(SEEDS)])
    mean = found.mean(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        z = np.triu(mean / found.std(axis=0, ddof=1) * np.sqrt(SEEDS), 1)
    i, j = np.unravel_index(np.abs(np.triu(mean, 1)).argmax(), mean.shape)
    print(f"{kind:<12} {samples:>5} samples: {(np.abs(z) > 6).sum()} of {PAIRS} "
          f"pairs correlated beyond 6 sigma; largest: {NAMES[i]} with {NAMES[j]}, {mean[i, j]:+.4f}",
          flush=True)


def tiles(scene, sampler, samples):
    """Returns the mean of each tile's green channel, and its variance between seeds."""
    loaded = mi.load_file(str(scene), sampler=sampler)
    renders = []
    for seed in range(SEEDS):
        green = np.array(mi.render(loaded, seed=seed, spp=samples), np.float64)[:, :, 1]
        rows = np.add.reduceat(green, np.arange(0, green.shape[0], 16), axis=0)
        renders.append(np.add.reduceat(rows, np.arange(0, green.shape[1], 16), axis=1) / 256)
    return np.mean(renders, axis=0), np.var(renders, axis=0, ddof=1) / SEEDS


def main():
    scene = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else SCENE
    mi.set_log_level(mi.LogLevel.Error)
    for kind in ("independent", "stratified", "multijitter", "ldsampler"):
        for samples in (64, 1024):
            print_correlations(kind, samples)
    truth, variance = tiles(scene, "independent", 1024)
    for sampler, samples in (("independent", 256), ("stratified", 256), ("multijitter", 256),
                             ("ldsampler", 16), ("ldsampler", 64), ("ldsampler", 256),
                             ("ldsampler", 1024)):
        mean, own = tiles(scene, sampler, samples)
        # Tiles without noise differ by rounding in single precision.
        z = (mean - truth) / np.sqrt(variance + own + (1e-5 * truth) ** 2)
        worst = np.unravel_index(np.abs(z).argmax(), z.shape)
        print(f"{sampler:<12} {samples:>5} samples: worst tile {worst[1]},{worst[0]} off by "
              f"{mean[worst] / truth[worst] - 1:+.3%}, z = {z[worst]:+.1f}", flush=True)


if __name__ == "__main__":
    main()
