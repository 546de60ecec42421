#!/usr/bin/python3
"""Writes docs/notebook/kinome.ipynb: runs its cells, and stores their output and figures in the notebook.

    PYTHONPATH=build/python /usr/bin/python3 docs/notebook/make.py [--quick] [--output FILE]
    ... make.py --reference           # renders reference.npz again, which takes some minutes
    ... make.py --mitsuba PYTHON      # measures Mitsuba again with this Python, and writes mitsuba.json

--quick: small images with few samples, which only test that all cells run. Requires numpy and matplotlib.
"""
import argparse
import ast
import base64
import contextlib
import io
import json
import os
import pathlib
import subprocess
import tempfile

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

import kinome  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
SIZE = (160, 120)
REFERENCE_SAMPLES = 512
MITSUBA_SAMPLES = (1, 4, 16, 64, 256)

CELLS = ["""\
# A night scene, two integrators, and an edit

This page loads a scene that Mitsuba 3 can load as well, and renders it with path tracing and with Kinome's own
integrator. It plots the errors of both over time, beside those of Mitsuba, and then edits the scene.
`docs/notebook/make.py` ran the cells. To run them yourself, install the module [kinome](../python.md) and start
Jupyter in `docs/notebook`.""", """\
import json
import time

import matplotlib.pyplot as plt
import numpy as np

import kinome

width, height = 160, 120
scene = kinome.load_file("night.xml", width=width, height=height)
for path in list(kinome.traverse(scene))[:12]:
    print(path)""", """\
## The same samples, by two integrators

64 small lamps light a table. At each bounce, `path` samples one of them at random. `clustered` learns which of
them light which part of the image. Both converge to the same image.""", """\
def encoded(picture):
    \"\"\"Converts to sRGB, for display.\"\"\"
    linear = np.clip(picture.rgb, 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


figure, axes = plt.subplots(1, 2, figsize=(10, 4))
for axis, name in zip(axes, ("path", "clustered")):
    picture = kinome.render(scene, integrator=name, spp=16)
    axis.imshow(encoded(picture), interpolation="nearest")
    axis.set_title(f"{name}, 16 samples a pixel")
    axis.axis("off")
figure.tight_layout()""", """\
## Error against time

The error is the relMSE, the mean of (picture - reference)² / (reference² + 0.01 mean²) over pixels and
channels. The reference was rendered by `clustered` with 512 samples per pixel. Time is processor time, summed over
threads, which other programs on the machine hardly affect. Mitsuba's values, from `mitsuba.json`, were measured
with `llvm_ad_rgb` on the same machine.""", """\
reference = np.load("reference.npz")["picture"].astype(np.float64)
if reference.shape[:2] != (height, width):  # the stored reference has another size
    reference = np.asarray(kinome.render(scene, integrator="clustered", spp=128).rgb, np.float64)


def relmse(picture):
    square = (np.asarray(picture.rgb, np.float64) - reference) ** 2
    return np.mean(square / (reference ** 2 + 0.01 * reference.mean() ** 2))


def curve(integrator, samples):
    seconds, errors = [], []
    for spp in samples:
        start = time.process_time()
        picture = kinome.render(scene, integrator=integrator, spp=spp, seed=1)
        seconds.append(time.process_time() - start)
        errors.append(relmse(picture))
    return seconds, errors


samples = [1, 4, 16, 64]
kinome.render(scene, spp=1)  # starts threads and loads plugins before the measurement
curves = {"Kinome, path": curve("path", samples + [256]),
          "Kinome, clustered": curve("clustered", samples)}
with open("mitsuba.json") as file:
    mitsuba = json.load(file)
if (width, height) == (160, 120):
    curves[f"Mitsuba {mitsuba['version']}, path"] = mitsuba["seconds"], mitsuba["relmse"]

figure, axis = plt.subplots(figsize=(7, 5))
for name, (seconds, errors) in curves.items():
    axis.loglog(seconds, errors, "o-", label=name)
axis.set_xlabel("processor time [s]")
axis.set_ylabel("relMSE")
axis.grid(True, which="both", alpha=0.25)
axis.legend()
figure.tight_layout()""", """\
## An edit

Parameters have the same paths as in Mitsuba's `traverse`. An update recreates only the objects that depend on the
edits. Here, it keeps the meshes and the acceleration structure.""", """\
parameters = kinome.traverse(scene)
parameters["clay.reflectance.value"] = [0.1, 0.3, 0.5]
parameters["gold.alpha.value"] = 0.15
parameters["camera.to_world"] = kinome.Transform().look_at([4, 2.2, 5], [0, 0.6, 0], [0, 1, 0])
print(parameters.update())

figure, axis = plt.subplots(figsize=(5, 4))
axis.imshow(encoded(kinome.render(scene, integrator="clustered", spp=64)), interpolation="nearest")
axis.axis("off")
figure.tight_layout()"""]


def run(source, names):
    """Runs a cell. Returns its printed text and its figures, in the format of notebooks."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(ast.parse(source), "cell", "exec"), names)  # noqa: S102
    outputs = []
    if printed.getvalue():
        outputs.append({"output_type": "stream", "name": "stdout",
                        "text": printed.getvalue().splitlines(keepends=True)})
    for number in plt.get_fignums():
        png = io.BytesIO()
        plt.figure(number).savefig(png, format="png", dpi=90)
        plt.close(number)
        outputs.append({"output_type": "display_data", "metadata": {},
                        "data": {"image/png": base64.b64encode(png.getvalue()).decode()}})
    return outputs


def notebook(cells):
    """Runs the cells, and returns the notebook."""
    names, made, count = {}, [], 0
    for i, source in enumerate(cells):
        # Code cells never begin with a comment.
        is_text = source.startswith("#")
        cell = {"cell_type": "markdown" if is_text else "code", "id": f"cell-{i}", "metadata": {},
                "source": source.splitlines(keepends=True)}
        if not is_text:
            count += 1
            cell |= {"execution_count": count, "outputs": run(source, names)}
        made.append(cell)
    return {"cells": made, "nbformat": 4, "nbformat_minor": 5,
            "metadata": {"kernelspec": {"display_name": "Python 3", "language": "python",
                                        "name": "python3"},
                         "language_info": {"name": "python"}}}


def quick(source):
    return (source.replace("160, 120", "40, 30", 1).replace("samples + [256]", "samples")
            .replace("[1, 4, 16, 64]", "[1, 4]").replace("spp=128", "spp=16")
            .replace("spp=64", "spp=16"))


def render_reference():
    scene = kinome.load_file("night.xml", width=SIZE[0], height=SIZE[1])
    picture = kinome.render(scene, integrator="clustered", spp=REFERENCE_SAMPLES, seed=99)
    np.savez_compressed("reference.npz", picture=np.asarray(picture.rgb, np.float16))


def measure_mitsuba(python):
    with tempfile.TemporaryDirectory() as folder:
        output = os.path.join(folder, "mitsuba.npz")
        subprocess.run([python, "measure_mitsuba.py", output, *map(str, SIZE),
                        *map(str, MITSUBA_SAMPLES)], check=True)
        measured = np.load(output)
        reference = np.load("reference.npz")["picture"].astype(np.float64)
        floor = 0.01 * reference.mean() ** 2
        errors = [float(np.mean((picture - reference) ** 2 / (reference ** 2 + floor)))
                  for picture in measured["pictures"].astype(np.float64)]
    numbers = {"version": str(measured["version"]), "variant": "llvm_ad_rgb",
               "samples": measured["samples"].tolist(),
               "seconds": [round(s, 4) for s in measured["seconds"].tolist()],
               "relmse": [float(f"{e:.4g}") for e in errors]}
    pathlib.Path("mitsuba.json").write_text(json.dumps(numbers, indent=2) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--output", type=pathlib.Path, default=HERE / "kinome.ipynb")
    parser.add_argument("--reference", action="store_true")
    parser.add_argument("--mitsuba", metavar="PYTHON")
    options = parser.parse_args()
    output = options.output.absolute()
    os.chdir(HERE)
    if options.reference:
        render_reference()
    if options.mitsuba:
        measure_mitsuba(options.mitsuba)
    if options.reference or options.mitsuba:
        return
    made = notebook([quick(cell) if options.quick else cell for cell in CELLS])
    output.write_text(json.dumps(made, indent=1) + "\n")


if __name__ == "__main__":
    main()
