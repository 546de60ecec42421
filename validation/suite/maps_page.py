"""validation/maps/: a picture for each scene, and README.md with the shares of the error."""
import matplotlib
import numpy as np

from program import commit

from . import maps, pictures
from .plots import png_file
from .summary import markdown

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (the backend comes first)
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm  # noqa: E402

DECADES = 4  # of the key, below the 99.9th percentile
COLOURS = ("#f2f2f2", "#b30000", "#f0a202", "#7b2d8b", "#4a4a4a", "#1b6ca8", "#8ec1e0", "#3f8f4f",
           "#b5dca8")


def figure(name, one):
    """The bytes of a PNG: picture, error with its key, and what class each pixel is of."""
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
    head = ["class", "pixels", "rays", "error", "by halves of the seeds", "error a pixel, mean 1",
            f"of the worst {maps.WORST:.0%}"]
    rows = []
    for name, row in figures["classes"].items():
        if row["pixels"] == 0:
            continue
        rows.append([name, percent(row["pixels"]), percent(row["rays"]), percent(row["error"]),
                     " / ".join(percent(half) for half in row["halves"]),
                     f"{row['error'] / row['pixels']:.2g}", percent(row["worst"])])
    return head, rows


def ablations(figures):
    """A row for each part, a column for each class that has a share of the error to speak of."""
    names = ["all"] + [name for name, row in figures["classes"].items() if row["error"] >= 0.02]
    return ["", *names], [[part, *("" if one[name] is None else f"{one[name]:.2f}"
                                   for name in names)]
                          for part, one in figures["without"].items()]


def page(scenes):
    """Lines of Markdown, as one text. `scenes`: {name: figures}."""
    lines = [
        "# Where the error of product sampling lies", "",
        "Written by `sh validation/run.sh maps`, at commit "
        f"{', '.join(dict.fromkeys(one['commit'][:10] for one in scenes.values()))}. Error is the "
        f"variance between {maps.SEEDS} seeds, of each pixel, relative to its mean² + .01 M² (M: "
        "the picture's mean); the estimator is unbiased, so that needs no reference. The key of "
        f"the maps is logarithmic, over {DECADES} decades. Few seeds tell little of rare bright "
        "pixels: where the halves of the seeds disagree, neither is to be relied on.", "",
        "A pixel is of the first class that it fits:", "",
        *(f"- **{name}**: {meaning}." for name, meaning in maps.CLASSES), "",
        f"What a pixel sees is told by {maps.VIEWS} renders with `aov` of one camera ray a pixel; "
        "patches are made of them by product's own rules (nearly one normal and plane, within a "
        "tile of 4x4), the first of these renders standing for its pilot. What is believed to "
        "arrive is `visibility` of `diagnostics`; rays are its `cost`, without the pilot's. Cells "
        "that straddle a horizon are no class, as each pixel has some: what their control terms "
        "are worth, and to whom, is the row *nothing known at the horizon*. In the second table of "
        "each scene: how many times larger the error is without a part.", "",
        "| | relMSE | " + f"the worst {maps.WORST:.0%} of the pixels have | most of the error |",
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
