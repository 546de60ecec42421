"""Makes reference images with Mitsuba: the mean of several renders, and its variance.

    python3 validation/references/make.py --mitsuba PYTHON validation/scenes/*.xml

For each scene NAME.xml, the script writes NAME.exr and NAME.json, which kinome-compare reads. The same is
true for a scene NAME/scene.xml of ../../scenes. NAME.exr has the channels R, G, B of the mean, and
variance.R, variance.G, variance.B of the variance of the mean. The channel `mask` is 1 for pixels without
a value. NAME.json records the settings. References that are up to date are skipped.

PYTHON must have the package mitsuba 3.9.1 (python3 -m venv v && v/bin/pip install mitsuba==3.9.1 numpy).
"""
import argparse
import hashlib
import json
import os
import pathlib
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import environment  # noqa: E402

VERSION = "3.9.1"


def parse():
    parser = argparse.ArgumentParser(
        prog="make.py", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", metavar="SCENE.xml")
    parser.add_argument("--mitsuba", metavar="PYTHON",
                        help="the Python with Mitsuba; default: the Python that runs this script")
    parser.add_argument("--variant", choices=["llvm_ad_rgb", "scalar_rgb"],
                        help="default: llvm_ad_rgb if a suitable LLVM is installed")
    parser.add_argument("--seeds", type=int, default=16, metavar="N",
                        help="number of independent renders, at least 16; default: 16")
    parser.add_argument("--samples", type=int, default=256, metavar="N",
                        help="samples per pixel of each render; default: 256")
    parser.add_argument("-D", "--define", action="append", default=[], metavar="KEY=VALUE",
                        help="sets $KEY of the scene file; can be repeated")
    parser.add_argument("--output", type=pathlib.Path, metavar="FOLDER",
                        default=pathlib.Path(__file__).resolve().parent)
    parser.add_argument("--force", action="store_true",
                        help="also make references that are up to date")
    options = parser.parse_args()
    if options.seeds < 16:
        parser.error(f"--seeds must be at least 16, got {options.seeds}: the variance of a "
                     "stratified sampler is computed only from the differences of renders")
    if options.samples < 1:
        parser.error(f"--samples must be positive, got {options.samples}")
    for define in options.define:
        if "=" not in define:
            parser.error(f"--define must be KEY=VALUE, got {define}")
    return options


def in_mitsubas_python(python):
    """Runs this script in that Python; returns its exit status."""
    arguments, skip = [], False
    for argument in sys.argv[1:]:
        if skip or argument == "--mitsuba":
            skip = not skip
        elif not argument.startswith("--mitsuba="):
            arguments.append(argument)
    try:
        return subprocess.run([python, __file__, *arguments], check=False).returncode
    except OSError as reason:
        print(f"make.py: {python}: {reason.strerror}", file=sys.stderr)
        return 1


def name_of(scene):
    """Returns the name of a scene's reference."""
    return scene.resolve().parent.name if scene.stem == "scene" else scene.stem


def wanted(scene, options, variant):
    """Returns the settings of a reference, which is up to date if its JSON contains the same."""
    return {"scene": scene.name, "scene_sha256": hashlib.sha256(scene.read_bytes()).hexdigest(),
            "defines": dict(sorted(d.split("=", 1) for d in options.define)), "version": VERSION,
            "variant": variant, "samples": options.samples, "seeds": options.seeds}


def is_current(picture, note, wish):
    try:
        made = json.loads(note.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return picture.is_file() and all(made.get(key) == value for key, value in wish.items())


def make(mi, np, scene_file, picture, wish):
    """Renders, and writes the EXR file; returns the other values of the JSON file."""
    scene = mi.load_file(str(scene_file), **wish["defines"])
    sensor = scene.sensors()[0]
    if sensor.film().rfilter().class_name() != "BoxFilter":
        raise ValueError("must have the box filter: other filters share samples between pixels, so the "
                         "variance of a sum is not the sum of the variances")
    start = time.perf_counter()
    renders = []
    for seed in range(wish["seeds"]):
        image = mi.render(scene, seed=seed, spp=wish["samples"])
        renders.append(np.array(image, np.float64)[:, :, :3])
    seconds = time.perf_counter() - start
    renders = np.array(renders)
    masked = ~np.isfinite(renders).all(axis=(0, 3))
    values = int((~np.isfinite(renders)).sum())
    renders[:, masked] = 0
    channels = [renders.mean(axis=0), renders.var(axis=0, ddof=1) / len(renders)]
    names = ["R", "G", "B", "variance.R", "variance.G", "variance.B"]
    if masked.any():
        print(f"{scene_file.name}: {values} values are NaN or Inf; {int(masked.sum())} of "
              f"{masked.size} pixels masked", file=sys.stderr)
        channels.append(masked[:, :, None])
        names.append("mask")
    pixels = np.concatenate(channels, axis=2).astype(np.float32)
    unfinished = picture.with_suffix(".part.exr")
    mi.Bitmap(pixels, mi.Bitmap.PixelFormat.MultiChannel, names).write(str(unfinished))
    unfinished.replace(picture)
    sampler = sensor.sampler()
    sampler.set_sample_count(wish["samples"])
    return {"integrator": scene.integrator().class_name(), "sampler": sampler.class_name(),
            "samples_used": sampler.sample_count(), "width": masked.shape[1],
            "height": masked.shape[0], "not_finite": values, "masked_pixels": int(masked.sum()),
            "seconds": round(seconds, 2)}


def main():
    options = parse()
    if options.mitsuba:
        return in_mitsubas_python(options.mitsuba)
    llvm = environment.use_llvm()
    variant = options.variant or ("llvm_ad_rgb" if llvm else "scalar_rgb")
    if variant == "llvm_ad_rgb" and not llvm:
        print("make.py: llvm_ad_rgb needs libLLVM 19: apt-get install libllvm19", file=sys.stderr)
        return 1
    try:
        import mitsuba as mi
        import numpy as np
    except ImportError as reason:
        print(f"make.py: {sys.executable} can't import {reason.name}: give a Python with "
              f"mitsuba=={VERSION} and numpy by --mitsuba", file=sys.stderr)
        return 1
    if mi.__version__ != VERSION:
        print(f"make.py: needs mitsuba {VERSION}, got {mi.__version__}", file=sys.stderr)
        return 1
    mi.set_variant(variant)
    mi.set_log_level(mi.LogLevel.Error)
    import legacy_bsdfs
    legacy_bsdfs.register()
    options.output.mkdir(parents=True, exist_ok=True)
    failed = 0
    for scene in map(pathlib.Path, options.scenes):
        picture, note = (options.output / (name_of(scene) + end) for end in (".exr", ".json"))
        try:
            wish = wanted(scene, options, variant)
            if not options.force and is_current(picture, note, wish):
                print(f"{scene.name}: up to date")
                continue
            made = make(mi, np, scene, picture, wish)
        except (OSError, RuntimeError, ValueError) as reason:
            # Continues with the other scenes.
            line = getattr(reason, "strerror", None) or " ".join(str(reason).split())
            print(f"make.py: {scene}: {line}", file=sys.stderr)
            failed += 1
            continue
        unfinished = note.with_suffix(".part.json")
        unfinished.write_text(json.dumps(wish | made, indent=2) + "\n", encoding="utf-8")
        os.replace(unfinished, note)
        print(f"{scene.name}: {made['seconds']} s, {variant}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
