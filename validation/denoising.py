"""Measures `kinome --denoise` on eight scenes, and writes the tables of docs/denoising.md.

    python3 validation/denoising.py [SCENE...] [--build build] [--work FOLDER] [--seeds N] [--width N] [--write]

For each scene and number of samples, the errors of three images are measured against a reference by the
same integrator: the noisy image, the result of Open Image Denoise alone, and that of `--denoise`, which
combines the two. All three have the same samples: one image with its albedo, normals and variance is
rendered for each seed by the Python module, and denoised twice. The error is the mean over the seeds.
relMSE excludes the reference's own noise; FLIP is the mean HDR-FLIP.

References are kept in FOLDER (default: out/denoising). --write: replaces the tables in the page; needs all
scenes. Needs Open Image Denoise, the Python module in the build folder, and flip-evaluator, which
validation/run.sh installs.
"""
import argparse
import importlib.util
import pathlib
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from compare import Errors, flip, load  # noqa: E402
from compare.packages import use_packages  # noqa: E402
from program import ROOT, run_kinome  # noqa: E402

import numpy as np  # noqa: E402

SCENES = ("hebe", "chess", "box", "kitchen", "sunroom", "vases", "focus", "lamps")
COUNTS = (1, 4, 16, 64)
REFERENCE_SAMPLES = 256
WIDTH = 128  # of the images, unless --width is given
COMBINED_FROM = 16  # samples from which --denoise divides them into NUM_RENDERS and combines
NUM_RENDERS = 4
PAGE = ROOT / "docs/denoising.md"
BEGIN, END = "<!-- validation/denoising.py -->\n", "<!-- end -->\n"
IMAGES = ("noisy", "OIDN", "`--denoise`")


def path_of(scene):
    return ROOT / f"scenes/{scene}/scene.xml"


def defines(path, samples, width):
    """Returns the variables of a scene file with a width in pixels. The scenes' sampler, `ldsampler`, has
    four samples at least."""
    text = path.read_text(encoding="utf-8")
    size = {}
    for name in ("width", "height"):
        before = f'<default name="{name}" value="'
        start = text.index(before) + len(before)
        size[name] = int(text[start:text.index('"', start)])
    sampler = "independent" if samples < 4 else "ldsampler"
    return {"spp": samples, "sampler": sampler, "width": width, "height": round(width * size["height"] / size["width"])}


def reference_of(scene, width, build, work):
    path = work / f"{scene}-{width}-reference.exr"
    if not path.exists():
        run_kinome(build, path_of(scene), path, defines(path_of(scene), REFERENCE_SAMPLES, width), seed=99,
                   options=["--variance"])
    return load([path])


def images_of(path, samples, seed, width, kinome):
    """Returns the colours of IMAGES for a scene file. They have the same samples. The scenes' films have a
    box filter, as denoising needs."""
    loaded = kinome.load_file(path, **defines(path, samples, width))
    # The integrator that the scenes include has the default parameters of `clustered`.
    guides = {"type": "aov", "aovs": "albedo:guide_albedo,normal:guide_normal", "image": {"type": "clustered"}}
    is_combined = samples >= COMBINED_FROM
    noisy = kinome.render(loaded, guides, seed=seed, variance=NUM_RENDERS if is_combined else None)
    others = [i for i, name in enumerate(noisy.channels) if "variance." not in name]
    alone = kinome.denoise(noisy[..., others])
    return noisy.rgb, alone.rgb, kinome.denoise(noisy).rgb if is_combined else alone.rgb


def measure(scene, samples, given, kinome):
    """Returns relMSE and FLIP of each of IMAGES."""
    reference = reference_of(scene, given.width, given.build.resolve(), given.work)
    unmasked = np.zeros(reference.mean.shape[:2], bool)
    errors = {name: [] for name in IMAGES}
    for seed in range(given.seeds):
        images = images_of(path_of(scene), samples, seed, given.width, kinome)
        for name, image in zip(IMAGES, map(np.asarray, images)):
            errors[name].append((Errors.of(image, reference, unmasked).relmse,
                                 flip(image, reference.mean, unmasked)))
    return {name: tuple(map(statistics.mean, zip(*values))) for name, values in errors.items()}


def table(scenes, results, which, digits):
    lines = ["| scene | " + " | ".join(f"{n} spp: {', '.join(IMAGES)}" for n in COUNTS) + " |",
             "|---|" + "---|" * len(COUNTS)]
    for scene in scenes:
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
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="all if none is given")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "out/denoising")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--width", type=int, default=WIDTH)
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    scenes = given.scenes or SCENES
    unknown = set(scenes).difference(SCENES)
    if unknown:
        parser.error(f"unknown scenes {sorted(unknown)}; possible: {', '.join(SCENES)}")
    if given.write and tuple(scenes) != SCENES:
        parser.error("--write needs all scenes")
    sys.path.insert(0, str(given.build.resolve() / "python"))
    import kinome
    use_packages(given.build.resolve())
    if importlib.util.find_spec("flip_evaluator") is None:
        parser.error("FLIP requires flip-evaluator. sh validation/run.sh installs it in the build folder")
    given.work.mkdir(parents=True, exist_ok=True)
    results = {}
    for scene in scenes:
        for count in COUNTS:
            results[scene, count] = measure(scene, count, given, kinome)
            print(scene, count, {name: f"{relmse:.3g} {of_flip:.3g}"
                                 for name, (relmse, of_flip) in results[scene, count].items()},
                  flush=True)
    text = "\n\n".join(f"{name}:\n\n{table(scenes, results, which, 2)}"
                       for which, name in enumerate(("relMSE", "FLIP"))) + "\n"
    if not given.write:
        print(text)
        return
    page = PAGE.read_text(encoding="utf-8")
    start, end = page.index(BEGIN) + len(BEGIN), page.index(END)
    PAGE.write_text(page[:start] + "\n" + text + "\n" + page[end:], encoding="utf-8")


if __name__ == "__main__":
    main()
