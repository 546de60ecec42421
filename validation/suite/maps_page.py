"""validation/maps/: an image for each scene, and README.md with the shares of the error."""
import matplotlib
import numpy as np

from program import commit

from . import maps, pictures
from .plots import png_file
from .summary import markdown

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (the backend comes first)
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm  # noqa: E402

DECADES = 4  # range of the colour scale, below the 99.9th percentile
COLOURS = ("#f2f2f2", "#b30000", "#f0a202", "#7b2d8b", "#4a4a4a", "#1b6ca8", "#8ec1e0", "#3f8f4f",
           "#b5dca8")


def figure(name, one):
    """Returns the bytes of a PNG with the image, the error with its colour scale, and the class of each
    pixel."""
    high, wide = one.error.shape
    panel = 4.0
    drawn, (picture, error, scale, classes, key) = pyplot.subplots(
        1, 5, figsize=(3 * panel + 3, panel * high / wide + 0.6), layout="constrained",
        width_ratios=(1, 1, 0.05, 1, 0.05))
    picture.imshow(pictures.encoded(one.picture, pictures.exposure(one.picture)),
                   interpolation="nearest")
    picture.set_title(f"{name}, mean of {one.figures['seeds']} seeds", fontsize=10)
    top = max(float(np.percentile(one.error, 99.9)), 1e-30)
    norm = LogNorm(top / 10 ** DECADES, top)
    shown = error.imshow(np.maximum(one.error, norm.vmin), cmap="inferno", norm=norm,
                         interpolation="nearest")
    error.set_title(f"variance / (mean² + .01 M²), {one.figures['samples']} samples", fontsize=10)
    drawn.colorbar(shown, cax=scale)
    count = len(maps.CLASSES)
    shown = classes.imshow(one.classes, cmap=ListedColormap(COLOURS), interpolation="nearest",
                           norm=BoundaryNorm(np.arange(count + 1) - 0.5, count))
    classes.set_title("class", fontsize=10)
    drawn.colorbar(shown, cax=key, ticks=range(count))
    key.set_yticklabels(maps.NAMES, fontsize=9)
    key.tick_params(length=0)
    key.invert_yaxis()
    for axis in (picture, error, classes):
        axis.set_axis_off()
    return png_file(drawn)


def percent(value):
    return "" if value is None else f"{100 * value:.0f} %" if value >= 0.0095 or value == 0 \
        else f"{100 * value:.1g} %"


def shares(figures):
    head = ["class", "pixels", "rays", "error", "error by halves of the seeds",
            "error per pixel, relative to the mean", f"worst {maps.WORST_SHARE:.0%}"]
    rows = []
    for name, row in figures["classes"].items():
        if row["pixels"] == 0:
            continue
        rows.append([name, percent(row["pixels"]), percent(row["rays"]), percent(row["error"]),
                     " / ".join(percent(half) for half in row["halves"]),
                     f"{row['error'] / row['pixels']:.2g}", percent(row["worst"])])
    return head, rows


def ablations(figures):
    """Returns a table with a row for each part, and a column for each class with at least 2 % of the error."""
    names = ["all"] + [name for name, row in figures["classes"].items() if row["error"] >= 0.02]
    return ["", *names], [[part, *("" if one[name] is None else f"{one[name]:.2f}"
                                   for name in names)]
                          for part, one in figures["without"].items()]


def page(scenes):
    """Returns the page as Markdown. `scenes`: {name: figures}."""
    lines = [
        "# Error of product sampling by pixel", "",
        "Written by `sh validation/run.sh maps`, at commit "
        f"{', '.join(dict.fromkeys(one['commit'][:10] for one in scenes.values()))}.", "",
        f"The error of a pixel is its variance between {maps.SEEDS} seeds, divided by mean² + .01 M². M is "
        "the mean of the image. No reference is needed, because the estimator is unbiased. The colour scale "
        f"of the maps is logarithmic, over {DECADES} decades. A few seeds give a poor estimate for rare "
        "bright pixels: if the two halves of the seeds differ much, neither is reliable.", "",
        "A pixel belongs to the first class that it fits:", "",
        *(f"- **{name}**: {meaning}." for name, meaning in maps.CLASSES), "",
        f"The visible points of a pixel come from {maps.VIEWS} renders with `aov` and one camera ray per "
        "pixel. Patches are made from them by the rules of product sampling (nearly one normal and plane, "
        "within a tile of 4x4). The first of these renders represent the pilot. The estimated visible share "
        "of the light is `visibility` of `diagnostics`. Rays are its `cost`, without those of the pilot. "
        "Cells that straddle a horizon are no class, because each pixel has some. The row *nothing known at "
        "the horizon* shows the effect of their control terms. The second table of each scene gives the "
        "factors by which the error grows without a part.", "",
        "| | relMSE | " + f"share of the worst {maps.WORST_SHARE:.0%} of the pixels | largest shares |",
        "|---|---|---|---|"]
    for name, one in scenes.items():
        most = sorted(one["classes"], key=lambda c: -one["classes"][c]["error"])[:2]
        lines.append(f"| [{name}](#{name}) | {one['relmse']:.2e} | {percent(one['worst'])} | " +
                     ", ".join(f"{c} {percent(one['classes'][c]['error'])}" for c in most) + " |")
    lines.append("")
    for name, one in scenes.items():
        size = "x".join(map(str, one["size"]))
        lines += [f"## {name}", "", f"![{name}: picture, error and classes]({name}.png)", "",
                  f"{size}, {one['samples']} samples: relMSE {one['relmse']:.2e}.", "",
                  *markdown(*shares(one)), *markdown(*ablations(one))]
    return "\n".join(lines).rstrip() + "\n"


def with_commit(figures):
    return figures | {"commit": commit()}
