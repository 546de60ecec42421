"""Plots and crops of the page, as data URLs."""
import base64
import io

import matplotlib
import numpy as np

from . import pictures

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (the backend comes first)

CROP = 48  # pixels
MAGNIFIED = 3
# Kinome has warm colours and solid lines; peers have cold colours and dashed lines.
OURS = ("#b30000", "#e8590c", "#f0a202", "#8c510a", "#d6336c", "#7f0000", "#c77dff")
PEERS = ("#0b4f8a", "#2a9d8f", "#5c677d", "#4361ee", "#6a994e")


def styles(found):
    """Returns {renderer: keyword arguments of matplotlib}."""
    count = {"ours": 0, "peer": 0}
    table = {}
    for name, renderer in found.items():
        colours = OURS if renderer["kind"] == "ours" else PEERS
        table[name] = {"color": colours[count[renderer["kind"]] % len(colours)],
                       "linestyle": "-" if renderer["kind"] == "ours" else "--"}
        count[renderer["kind"]] += 1
    return table


def error_over_time(found, trimmed, own_error):
    """Plots log relMSE over log seconds with quartiles of both, and beside it the same for the trimmed relMSE.
    `found`, `trimmed`: results of analysis.summary()."""
    figure, axes = pyplot.subplots(1, 2, figsize=(12, 5.4), sharex=True, sharey=True)
    for axis, label, part in zip(axes, ("relMSE", "relMSE without the worst 0.1 %"),
                                 (found, trimmed)):
        draw(axis, part)
        axis.set(xscale="log", yscale="log", xlabel="seconds of rendering", ylabel=label)
        axis.grid(alpha=0.3, which="major")
        axis.tick_params(labelleft=True)
    if own_error > 0:
        axes[0].axhline(own_error, color="grey", linestyle=":", linewidth=1)
        axes[0].annotate("noise of the reference, which is subtracted", (0.01, own_error),
                         xycoords=("axes fraction", "data"), fontsize=7, color="grey", va="bottom")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=3, fontsize=8, frameon=False)
    figure.tight_layout(rect=(0, 0.06 + 0.035 * ((len(labels) + 2) // 3), 1, 1))
    return png(figure)


def draw(axis, found):
    """Draws a curve for each renderer."""
    for name, style in styles(found).items():
        points = [p for p in found[name]["points"] if p["relmse"] > 0 and p["seconds"] > 0]
        if not points:
            continue
        x, y = ([p[k] for p in points] for k in ("seconds", "relmse"))
        reach_x, reach_y = ([[max(p[k] - p[k + "_quartiles"][0], 0) for p in points],
                             [max(p[k + "_quartiles"][1] - p[k], 0) for p in points]]
                            for k in ("seconds", "relmse"))
        # A quartile of zero or less has no logarithm, so the bar ends just above zero.
        reach_y[0] = [min(r, 0.999 * v) for r, v in zip(reach_y[0], y)]
        axis.errorbar(x, y, xerr=reach_x, yerr=reach_y, marker="o", markersize=3.5, linewidth=1.4,
                      elinewidth=0.8, capsize=2, label=name, **style)


def png_file(figure):
    """Returns the bytes of a PNG file."""
    file = io.BytesIO()
    figure.savefig(file, dpi=95, format="png", metadata={"Software": None})
    pyplot.close(figure)
    return file.getvalue()


def png(figure):
    return "data:image/png;base64," + base64.b64encode(png_file(figure)).decode()


def equal_time(entry, found, load_picture):
    """Returns (seconds, [(label, data URL)]): crops of each renderer's image after the same time.

    load_picture(digest): returns the pixels, or None. The time is the geometric mean of the first and the
    last point of the fastest peer. A renderer shows its largest sample count that takes no longer, or its
    fastest one if all take longer. The label gives the count.
    """
    peers = [r["points"] for r in found.values() if r["kind"] == "peer" and r["points"]]
    if not peers:
        return None, []
    times = min(peers, key=lambda points: points[-1]["relmse"] * points[-1]["seconds"])
    goal = float(np.sqrt(times[0]["seconds"] * times[-1]["seconds"]))
    shown = []
    for name, renderer in found.items():
        point = choose(renderer["points"], goal)
        runs = next(p["runs"] for p in entry["curves"][name]["points"]
                    if p["samples"] == point["samples"])
        image = load_picture(runs[0]["picture"])
        if image is not None:
            shown.append((f"{name}: {point['samples']} samples, {point['seconds']:.2g} s, "
                          f"relMSE {point['relmse']:.2g}",
                          np.nan_to_num(image, posinf=0.0, neginf=0.0)))  # shown black
    if not shown:
        return goal, []
    middle = np.median([image for _, image in shown], axis=0)
    row, column = busiest([image for _, image in shown], middle)
    scale = pictures.exposure(middle)
    crops = []
    for label, image in shown:
        crop = image[row:row + CROP, column:column + CROP]
        pixels = np.repeat(np.repeat(pictures.encoded(crop, scale), MAGNIFIED, 0), MAGNIFIED, 1)
        crops.append((label, pictures.url(pixels)))
    return goal, crops


def choose(points, goal):
    within = [p for p in points if p["seconds"] <= goal]
    return max(within, key=lambda p: p["samples"]) if within else min(
        points, key=lambda p: p["seconds"])


def busiest(images, middle):
    """Returns the corner of the crop with the largest differences between the renderers. Limits the effect of
    single bright pixels."""
    spread = np.mean([np.minimum(np.abs(i - middle).mean(axis=2) /
                                 (middle.mean(axis=2) + 0.1 * middle.mean() + 1e-30), 1)
                      for i in images], axis=0)
    total = np.pad(spread.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    height, width = (max(n - CROP, 0) for n in spread.shape)
    tall, wide = (min(CROP, n) for n in spread.shape)
    sums = (total[tall:, wide:] - total[:-tall, wide:] - total[tall:, :-wide]
            + total[:-tall, :-wide])[:height + 1, :width + 1]
    return np.unravel_index(int(sums.argmax()), sums.shape)
