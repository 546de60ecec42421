"""Measures `kinome --denoise` on eight scenes, and writes the tables of docs/denoising.md.

    python3 validation/denoising.py [--build build] [--work FOLDER] [--seeds N] [--write]

For each scene and number of samples, the errors of three images are measured against a reference by the
same integrator: the noisy image, the result of Open Image Denoise alone (`--part all/1`, which has no
noise estimate), and that of `--denoise`, which combines the two. The error is the mean over the seeds.
relMSE excludes the reference's own noise; FLIP is the mean HDR-FLIP.

References are kept in FOLDER (default: out/denoising). --write: replaces the tables in the page.
Needs Open Image Denoise, and the Python packages numpy, OpenImageIO and flip-evaluator.
"""
import argparse
import pathlib
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from compare import Errors, flip, load  # noqa: E402
from program import ROOT, run_kinome  # noqa: E402

import numpy as np  # noqa: E402
import OpenImageIO as oiio  # noqa: E402

SCENES = ("hebe", "chess", "box", "kitchen", "sunroom", "vases", "focus", "lamps")
COUNTS = (1, 4, 16, 64)
REFERENCE_SAMPLES = 256
WIDTH = 128
PAGE = ROOT / "docs/denoising.md"
BEGIN, END = "<!-- validation/denoising.py -->\n", "<!-- end -->\n"
IMAGES = ("noisy", "OIDN", "`--denoise`")


def colour(path, layer=""):
    image = oiio.ImageInput.open(str(path))
    spec = image.spec()
    pixels = image.read_image(oiio.FLOAT).reshape(spec.height, spec.width, spec.nchannels)
    return pixels[:, :, [spec.channelnames.index(layer + c) for c in "RGB"]]


def render(scene, path, samples, seed, options, build):
    run_kinome(build, ROOT / f"scenes/{scene}/scene.xml", path, defines(scene, samples), seed=seed,
               options=options)


def defines(scene, samples):
    """Returns the variables of a scene with a width of WIDTH pixels. The scenes' sampler, `ldsampler`, has
    four samples at least."""
    text = (ROOT / f"scenes/{scene}/scene.xml").read_text(encoding="utf-8")
    size = {}
    for name in ("width", "height"):
        before = f'<default name="{name}" value="'
        start = text.index(before) + len(before)
        size[name] = int(text[start:text.index('"', start)])
    sampler = "independent" if samples < 4 else "ldsampler"
    return {"spp": samples, "sampler": sampler, "width": WIDTH, "height": round(WIDTH * size["height"] / size["width"])}


def reference_of(scene, build, work):
    path = work / f"{scene}-reference.exr"
    if not path.exists():
        render(scene, path, REFERENCE_SAMPLES, 99, ["--variance"], build)
    return load([path])


def measure(scene, samples, seeds, build, work):
    """Returns relMSE and FLIP of each of IMAGES."""
    reference = reference_of(scene, build, work)
    unmasked = np.zeros(reference.mean.shape[:2], bool)
    errors = {name: [] for name in IMAGES}
    for seed in range(seeds):
        paths = {}
        for name, options in (("alone", ["--denoise", "--part", "all/1"]), ("both", ["--denoise"])):
            paths[name] = work / f"{scene}-{samples}-{seed}-{name}.exr"
            render(scene, paths[name], samples, seed, options, build)
        for name, image in zip(IMAGES, (colour(paths["alone"], "noisy."), colour(paths["alone"]),
                                        colour(paths["both"]))):
            errors[name].append((Errors.of(image, reference, unmasked).relmse,
                                 flip(image, reference.mean, unmasked)))
    return {name: tuple(map(statistics.mean, zip(*values))) for name, values in errors.items()}


def table(results, which, digits):
    lines = ["| scene | " + " | ".join(f"{n} spp: {', '.join(IMAGES)}" for n in COUNTS) + " |",
             "|---|" + "---|" * len(COUNTS)]
    for scene in SCENES:
        cells = []
        for count in COUNTS:
            values = [results[scene, count][name][which] for name in IMAGES]
            best = min(values)
            cells.append(", ".join(f"**{v:.{digits}g}**" if v <= 1.02 * best else f"{v:.{digits}g}"
                                   for v in values))
        lines.append(f"| {scene} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "out/denoising")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    given.work.mkdir(parents=True, exist_ok=True)
    results = {}
    for scene in SCENES:
        for count in COUNTS:
            results[scene, count] = measure(scene, count, given.seeds, given.build.resolve(), given.work)
            print(scene, count, {name: f"{relmse:.3g} {of_flip:.3g}"
                                 for name, (relmse, of_flip) in results[scene, count].items()},
                  flush=True)
    text = (f"relMSE:\n\n{table(results, 0, 2)}\n\nFLIP:\n\n{table(results, 1, 2)}\n")
    if not given.write:
        print(text)
        return
    page = PAGE.read_text(encoding="utf-8")
    start, end = page.index(BEGIN) + len(BEGIN), page.index(END)
    PAGE.write_text(page[:start] + "\n" + text + "\n" + page[end:], encoding="utf-8")


if __name__ == "__main__":
    main()
