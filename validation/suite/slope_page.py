"""validation/slope/: a table and a plot of the error by time from one sample on."""
import csv
import dataclasses
import io

import matplotlib

from . import slope
from .plots import png_file
from .summary import markdown

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (the backend comes first)

COLOURS = {"clustered": "#b30000", "path": "#0b4f8a"}


def curves_of(points):
    """Returns {scene: {integrator: points}}."""
    found = {}
    for point in points:
        found.setdefault(point.scene, {}).setdefault(point.integrator, []).append(point)
    return found


def plot(points):
    """Returns the bytes of a PNG: one diagram for each scene."""
    found = curves_of(points)
    columns = min(3, len(found))
    rows = -(-len(found) // columns)
    figure, axes = pyplot.subplots(rows, columns, figsize=(4 * columns, 3.3 * rows),
                                   layout="constrained", squeeze=False)
    for axis in axes.flat[len(found):]:
        axis.set_axis_off()
    for axis, (name, curves) in zip(axes.flat, found.items()):
        for integrator, curve in curves.items():
            axis.plot([p.seconds for p in curve], [max(p.relmse, 1e-12) for p in curve], marker="o",
                      markersize=4, color=COLOURS[integrator], label=integrator)
        for point in curves["clustered"]:
            axis.annotate(str(point.samples), (point.seconds, max(point.relmse, 1e-12)),
                          xytext=(4, 4), textcoords="offset points", fontsize=7)
        axis.set(xscale="log", yscale="log", title=title(name))
        axis.grid(alpha=0.3)
    figure.supxlabel("seconds of processor time", fontsize=10)
    figure.supylabel("relMSE", fontsize=10)
    axes[0][0].legend(frameon=False)
    return png_file(figure)


def title(name):
    depth = slope.DEPTHS.get(name, -1)
    return name + (", direct light" if depth == 2 else ", any number of bounces")


def table(points):
    lines = []
    for name, curves in curves_of(points).items():
        for p in curves["clustered"]:
            steep = p.slope is not None and p.slope < slope.STEEPEST
            value = "" if p.slope is None else f"{p.slope:.1f}"
            lines.append([name, str(p.samples), f"{1e3 * p.seconds:.0f}", f"{p.relmse:.3g}",
                          f"{p.least:.3g} to {p.most:.3g}", f"**{value}**" if steep else value,
                          f"{slope.error_at(curves['path'], p.seconds) / p.relmse:.2g}"])
    return ["scene", "samples", "time, ms", "relMSE", "by seed", "slope", "`path` / `clustered`"], lines


def page(points, where, commit):
    size = "x".join(map(str, slope.SIZE))
    return "\n".join([
        "# Error by time from one sample on", "",
        f"Written by `sh validation/run.sh slope` at {commit[:10]}, on {where['processor']}, "
        f"{where['cores']} cores. The images have {size} pixels. Renders use the sampler {slope.SAMPLER} and "
        "one thread. hebe, vases, tree and room have the direct light of an environment, the other scenes any "
        "number of bounces.", "",
        "Time is processor time without start-up and loading. It is the median of at least "
        f"{slope.TIMES} renders if they take less than {slope.SHORT} s, otherwise of one render for each seed. "
        f"The error is the mean over {slope.SEEDS} seeds. The reference is the mean of "
        f"{len(slope.REFERENCE_SEEDS)} renders by `clustered` with {slope.REFERENCE_SAMPLES} samples, whose own "
        "noise is subtracted. *Slope* is the slope between the logarithms of this row and of the row above; "
        f"values below {slope.STEEPEST} are bold. The last column is the relMSE of `path` at equal time, "
        "divided by that of `clustered`. Above 1, `clustered` is better.", "",
        *markdown(*table(points)),
        "![Error by time](plot.png)", ""])


def measurements(points):
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(field.name for field in dataclasses.fields(slope.Point))
    for point in points:
        writer.writerow("" if value is None else value for value in dataclasses.astuple(point))
    return text.getvalue()
