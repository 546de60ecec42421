"""Measures the effect of each part of learned product sampling, and its error and time against other
integrators. Writes validation/numbers/product.md, and product.json with the raw values.

    sh scenes/render.sh                                # builds, and makes the assets
    /usr/bin/python3 validation/ablation.py [--build build] [--seeds N] [SCENE...]

No reference is needed, because the estimators are unbiased (tests/render): their error is their
variance between seeds. If `path` hardly ever finds some light, a few seeds underestimate its variance.
relMSE is the mean over pixels and channels of variance / (mean² + 0.01 M²), where M is the mean of the
image. The scenes are those of validation/run.sh; the default is all of them. A new measurement of a
scene replaces its old entry in both files.
"""
import argparse
import json
import pathlib
import statistics
import sys
import tempfile

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from compare.images import colour, read  # noqa: E402
from program import ROOT, commit, machine, run_kinome  # noqa: E402
from suite.tables import AREA, BOUNCE, DEEP, SCENES, TOGETHER  # noqa: E402

PARTS = {"all": {}, "no control variate": {"control_variate": "false"},
         "rays not by sigma": {"learned_sigma": "false"}, "not adaptive": {"adaptive": "false"},
         "sigma not checked": {"checked_sigma": "false"},
         "plan not smoothed": {"smooth_plan": "false"},
         "nothing known at the horizon": {"horizon_terms": "false"},
         "no shared candidates": {"shared_candidates": "false"},
         "no fewer cells": {"fewer_cells": "false"},
         "light not guided": {"light_guide": "false"}}
LOCAL = (BOUNCE, AREA, TOGETHER)
OF_LOCAL_LIGHT = ("light not guided",)
SAMPLES_OF_PARTS = 16
SAMPLES = (16, 64)
OUTPUT = ROOT / "validation/numbers"


def measure(build, scene, integrator, samples, defines, seeds, folder):
    """Returns the error and the median seconds of one setting."""
    pictures, seconds = [], []
    width, height = scene.size
    for seed in range(1, seeds + 1):
        output = folder / "picture.exr"
        stats = run_kinome(build, scene.path, output,
                           {"integrator": integrator, "sampler": "independent", "spp": samples,
                            "width": width, "height": height, **defines}, seed)
        pictures.append(colour(output, read(output).channels))
        seconds.append(stats["seconds"]["render"])
    stack = np.stack(pictures)
    mean = stack.mean(0)
    error = stack.var(0, ddof=1) / (mean ** 2 + 0.01 * mean.mean() ** 2)
    return {"relmse": float(error.mean()), "seconds": statistics.median(seconds)}


def rivals(scene):
    """Returns the names of Kinome's integrators with which product sampling is compared."""
    if scene.group in (BOUNCE, TOGETHER):
        return ("path", "ptracer")
    if scene.group == DEEP:
        return ("path",)
    return ("direct",)


def product(scene, **defines):
    depth = {"max_depth": 3 if scene.truth == "path" else 2}
    return "clustered", {"importance": "product", **depth, **defines}


def of_scene(build, scene, seeds, folder):
    def run(integrator, defines, samples):
        print(f"{scene.name}: {integrator} {samples} {defines}", file=sys.stderr)
        return measure(build, scene, integrator, samples, defines, seeds, folder)

    found = {"group": scene.group, "size": list(scene.size), "parts": {}, "samples": {}}
    for name, defines in PARTS.items():
        if name not in OF_LOCAL_LIGHT or scene.group in LOCAL:
            found["parts"][name] = run(*product(scene, **defines), SAMPLES_OF_PARTS)
    for samples in SAMPLES:
        row = {"product": run(*product(scene), samples)}
        for rival in rivals(scene):
            depth = {} if rival == "direct" else {"max_depth": 3 if scene.truth == "path" else 2}
            row[rival] = run(rival, depth, samples)
        found["samples"][samples] = row
    return found


def times(value):
    return f"{value:.3g}x"


def parts_table(scenes):
    yield f"| {SAMPLES_OF_PARTS} samples | " + " | ".join(PARTS) + " |"
    yield "|---" * (len(PARTS) + 1) + "|"
    for name, found in scenes.items():
        whole = found["parts"]["all"]["relmse"]
        cells = [f"{whole:.2e}"]
        for part in list(PARTS)[1:]:
            one = found["parts"].get(part)
            cells.append(times(one["relmse"] / whole) if one else "")
        yield f"| {name} | " + " | ".join(cells) + " |"


def rivals_table(scenes):
    yield "| | rival | " + " | ".join(
        f"error, {n} samples | efficiency, {n} samples" for n in SAMPLES) + " |"
    yield "|---" * (2 + 2 * len(SAMPLES)) + "|"
    for name, found in scenes.items():
        for rival in next(iter(found["samples"].values())):
            if rival == "product":
                continue
            cells = []
            for row in found["samples"].values():
                theirs, ours = row[rival], row["product"]
                error = theirs["relmse"] / ours["relmse"]
                cells += [times(error), times(error * theirs["seconds"] / ours["seconds"])]
            yield f"| {name} | `{rival}` | " + " | ".join(cells) + " |"


def write(result, output):
    scenes = result["scenes"]
    lines = [
        "# Effect of the parts of product sampling", "",
        f"Written by validation/ablation.py at "
        f"{', '.join(sorted({s['commit'][:7] for s in scenes.values()}))}, on "
        f"{result['machine']['processor']}, {result['machine']['cores']} cores. The error is the variance "
        f"between {' or '.join(str(n) for n in sorted({s['seeds'] for s in scenes.values()}))} "
        "seeds. Raw values: product.json.", "",
        "The first column is the relMSE of `product`. The other columns are the factors by which it grows "
        "if one part is left out:", "",
        *parts_table(scenes), "",
        "This table compares `product` with other integrators at the same `sample_count`. *Error* is their "
        "relMSE divided by that of `product`. *Efficiency* is the same ratio for relMSE x seconds:", "",
        *rivals_table(scenes), ""]
    output.mkdir(parents=True, exist_ok=True)
    (output / "product.md").write_text("\n".join(lines), encoding="utf-8")
    (output / "product.json").write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--output", type=pathlib.Path, default=OUTPUT)
    parser.add_argument("scenes", nargs="*", metavar="SCENE")
    options = parser.parse_args()
    if options.seeds < 2:
        parser.error(f"--seeds must be at least 2, got {options.seeds}: the error is the variance between "
                     "seeds")
    unknown = set(options.scenes) - {scene.name for scene in SCENES}
    if unknown:
        parser.error(f"unknown scene {', '.join(sorted(unknown))}")
    before = options.output / "product.json"
    scenes = json.loads(before.read_text(encoding="utf-8"))["scenes"] if before.exists() else {}
    result = {"machine": machine(), "scenes": scenes}
    with tempfile.TemporaryDirectory() as folder:
        for scene in SCENES:
            if not options.scenes or scene.name in options.scenes:
                scenes[scene.name] = {"commit": commit(), "seeds": options.seeds, **of_scene(
                    options.build, scene, options.seeds, pathlib.Path(folder))}
                result["scenes"] = {s.name: scenes[s.name] for s in SCENES if s.name in scenes}
                write(result, options.output)


if __name__ == "__main__":
    main()
