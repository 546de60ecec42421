"""Figures 5.1 to 5.6 of the thesis with our images, and plots of the sweeps."""
import csv
import subprocess

import matplotlib
from PIL import Image

from pictures import difference, encoded, grid
from program import ROOT
from thesis_runs import SCENES

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (the backend comes first)

FIGURE = {"hebe": "5.2", "car": "5.3", "box": "5.4", "plate": "5.5"}
LABELS = {"joint": "joint", "brdf": "BRDF", "luminance": "luminance",
          "luminance_equal_time": "luminance"}
# Pixel of figure 5.6, as a share of the image size: the side of the teapot toward the sun.
INSPECTED = (0.60, 0.62)
SHOWN = 300  # height of a map on the page, in pixels


def overview(path, pictures):
    """Writes figure 5.1: joint importance in the top row, groundtruth in the bottom row."""
    rows = [[(f"{scene}, joint 128", encoded(p["joint"])) for scene, p in pictures.items()],
            [(f"{scene}, groundtruth", encoded(p["groundtruth"])) for scene, p in pictures.items()]]
    grid(path, rows)


def comparison(path, numbers, pictures):
    """Writes one of figures 5.2 to 5.5: an image for each importance function, and its errors."""
    above, below = [], []
    for name, label in LABELS.items():
        mode = numbers["modes"][name]
        found = mode["error_to_groundtruth"]
        above.append((f"{label} {mode['samples']}\n{mode['render_seconds']:.2f} s",
                      encoded(pictures[name])))
        below.append((f"relMSE {found['relmse']:.3g}\ntrimmed {found['trimmed']:.3g}",
                      difference(pictures[name], pictures["groundtruth"])))
    above.append(("groundtruth", encoded(pictures["groundtruth"])))
    below.append(("groundtruth minus truth",
                  difference(pictures["groundtruth"], pictures["truth"])))
    grid(path, [above, below])


def sweeps(path, data):
    """Plots the error, and error x seconds, over the size of the cut and the number of lobe rays."""
    figure, axes = pyplot.subplots(2, 2, figsize=(9, 6.4), sharex="col")
    columns = (("cut_size", "clusters in the cut", 512), ("brdf_samples", "lobe rays", 32))
    for column, (key, title, thesis) in enumerate(columns):
        for scene, numbers in data["scenes"].items():
            runs = numbers["sweeps"][key]
            x = range(len(runs))
            values = [r["value"] for r in runs]
            axes[0][column].plot(x, [r["trimmed"] for r in runs], "o-", label=scene, markersize=3)
            axes[1][column].plot(x, [r["trimmed"] * r["seconds"] for r in runs], "o-", label=scene,
                                 markersize=3)
        for row, name in ((0, "relMSE (trimmed)"), (1, "relMSE (trimmed) x seconds")):
            axis = axes[row][column]
            axis.axvline(values.index(thesis), color="grey", linestyle=":", linewidth=1)
            axis.set_xticks(range(len(values)), values)
            axis.set_yscale("log")
            axis.grid(alpha=0.3)
            axis.set_ylabel(name)
        axes[1][column].set_xlabel(f"{title} (the thesis: {thesis})")
    axes[0][0].legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    pyplot.close(figure)


def cluster_summary(path):
    """Returns statistics of the clusters in a table of --inspect."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    probabilities = sorted((float(r["probability"]) for r in rows), reverse=True)
    return {"clusters": len(rows),
            "possible": sum(p > 0 for p in probabilities),
            "drawn": sum(int(r["samples"]) > 0 for r in rows),
            "met_by_lobe_rays": sum(float(r["hits"]) > 0 for r in rows),
            "share_of_the_likeliest_16": sum(probabilities[:16])}


def inspection(render, folder, output):
    """Writes figure 5.6 for grace: maps of the three importance functions. Returns their statistics."""
    width, height = render.size("grace", "size")
    pixel = f"{round(INSPECTED[0] * width)},{round(INSPECTED[1] * height)}"
    found, maps = {"pixel": pixel, "width": width, "height": height}, []
    for mode in ("luminance", "brdf", "joint"):
        render.say(f"grace: samples of pixel {pixel}, {mode}")
        stem = folder / f"inspect-{mode}"
        values = {"importance": mode, "spp": 1, "sampler": "independent", "width": width,
                  "height": height, "max_depth": SCENES["grace"]["max_depth"],
                  **SCENES["grace"]["materials"]}
        if render.quick:
            values["light_samples"] = 512
        arguments = [render.build / "bin/kinome", ROOT / "scenes/grace/scene.xml", "-q",
                     "--inspect", pixel, "-o", f"{stem}.exr"]
        for key, value in values.items():
            arguments += ["-D", f"{key}={value}"]
        subprocess.run(arguments, check=True)
        found[mode] = cluster_summary(f"{stem}.csv")
        (output / f"figure-5.6-{mode}.csv").write_bytes((folder / f"{stem.name}.csv").read_bytes())
        with Image.open(f"{stem}.png") as picture:
            # Crops the legend below the map.
            sky = picture.crop((0, 0, picture.width, picture.width // 2))
            small = sky.convert("RGB").resize((2 * SHOWN, SHOWN), Image.Resampling.LANCZOS)
        maps.append([(f"{mode}: {found[mode]['drawn']} clusters with samples", small)])
    grid(output / "figure-5.6.jpg", maps)
    return found
