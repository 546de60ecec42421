"""validation/media/: tables and a plot of the error by time in scenes with media."""
import csv
import io
import math
import statistics

import matplotlib

from bounces_page import number, ratio, reach

from .analysis import geometric_mean
from .plots import png_file
from .summary import markdown
from .tables import MEDIA_GOALS

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (the backend comes first)

OURS = ("volpath", "clustered")
STYLES = {"volpath": ("#e8590c", "o-"), "clustered": ("#b30000", "o-"), "peer": ("#0b4f8a", "s--")}
VOLPATH_GOAL = 1.5


def points(curve, error="relmse"):
    return [{"seconds": statistics.median(p["processor"]), "relmse": p[error]} for p in curve]


def speed_ups(entry, error="relmse"):
    """Returns (target, Mitsuba's seconds, {integrator: (seconds, kind, speed-up)}). The target is the error of
    Mitsuba's longest render."""
    last = points(entry["curves"]["peer"], error)[-1]
    found = {}
    for side in OURS:
        seconds, kind = reach(points(entry["curves"][side], error), last["relmse"], "ours")
        found[side] = (seconds, kind, last["seconds"] / seconds)
    return last["relmse"], last["seconds"], found


def speed_up_at_ours(entry, error="relmse"):
    """Returns (error of the longest render by `clustered`, its seconds, Mitsuba's seconds to that error, speed-up).
    Mitsuba's error falls as 1 / time beyond its longest render."""
    ours = points(entry["curves"]["clustered"], error)[-1]
    theirs, _ = reach(points(entry["curves"]["peer"], error), ours["relmse"], "peer")
    return ours["relmse"], ours["seconds"], theirs, theirs / ours["seconds"]


def nanoseconds(curve, size):
    """Returns the processor time per sample: the slope between the smallest and the largest count, or the
    mean if there is only one."""
    first, last = curve[0], curve[-1]
    if len(curve) == 1:
        return 1e9 * statistics.median(last["processor"]) / (size[0] * size[1] * last["samples"])
    spent = statistics.median(last["processor"]) - statistics.median(first["processor"])
    return 1e9 * spent / (size[0] * size[1] * (last["samples"] - first["samples"]))


def peer_name(entry):
    return entry["peer"].removeprefix("Mitsuba ").removesuffix(", depth -1").removesuffix(", llvm_ad_rgb")


def table(scenes):
    rows = []
    for name, entry in scenes.items():
        target, theirs, found = speed_ups(entry)
        _, _, trimmed = speed_ups(entry, "trimmed")
        cells = [name, peer_name(entry), f"{target:.2g}", number(theirs)]
        for side in OURS:
            seconds, kind, times = found[side]
            cells += [number(seconds, kind), ratio(kind, "measured", times),
                      ratio(trimmed[side][1], "measured", trimmed[side][2])]
        goal = MEDIA_GOALS[name]
        rows.append([*cells, "" if goal is None else str(goal)])
    head = ["scene", "Mitsuba's fastest", "relMSE", "Mitsuba [s]"]
    for side in OURS:
        head += [f"`{side}` [s]", "speed-up", "trimmed"]
    return [*head, "goal"], rows


def table_at_ours(scenes):
    rows = []
    for name, entry in scenes.items():
        target, ours, theirs, times = speed_up_at_ours(entry)
        trimmed = speed_up_at_ours(entry, "trimmed")[3]
        rows.append([name, f"{target:.2g}", *(number(value) for value in (ours, theirs, times, trimmed))])
    return ["scene", "relMSE", "`clustered` [s]", "Mitsuba [s]", "speed-up", "trimmed"], rows


def sample_table(scenes):
    rows = []
    for name, entry in scenes.items():
        ours, theirs = (nanoseconds(entry["curves"][side], entry["size"]) for side in ("volpath", "peer"))
        means = [f"{100 * difference:+.2f} ± {100 * error:.2f} %"
                 for difference, error in (entry["differences"][side] for side in OURS)]
        rows.append([name, f"{ours:.0f}", f"{theirs:.0f}", f"{theirs / ours:.2f}", *means])
    return ["scene", "`volpath` [ns]", "Mitsuba [ns]", "ratio", *(f"mean of `{s}`" for s in OURS)], rows


def goals(scenes):
    rows = []
    for name, entry in scenes.items():
        goal = MEDIA_GOALS[name]
        if goal is not None:
            times, at_ours = speed_ups(entry)[2]["clustered"][2], speed_up_at_ours(entry)[3]
            rows.append([f"`clustered`, {name}", str(goal), number(times), number(at_ours),
                         met(max(times, at_ours), goal)])
    mean = geometric_mean([speed_ups(entry)[2]["volpath"][2] for entry in scenes.values()])
    rows.append(["`volpath`, geometric mean", str(VOLPATH_GOAL), number(mean), "", met(mean, VOLPATH_GOAL)])
    return ["speed-up", "goal", "at Mitsuba's error", "at ours", ""], rows


def met(times, goal):
    return "met" if times >= goal else "not met"


def page(machine, scenes, seeds):
    sizes = sorted({"x".join(map(str, entry["size"])) for entry in scenes.values()})
    commits = sorted({entry["commit"][:10] for entry in scenes.values()})
    busy = [entry["cores_of_others"] for entry in scenes.values()]
    return "\n".join([
        "# Scenes with media", "",
        f"Written by `sh validation/run.sh media` at {', '.join(commits)}, on {machine['processor']}, "
        f"{machine['cores']} cores. The images have {', '.join(sizes)} pixels, and max_depth is -1. Kinome's "
        "sampler is `ldsampler`. Mitsuba 3.9.1 uses the fastest of its configurations of `volpath` and "
        "`volpathmis`, with `llvm_ad_rgb`, as found with 16 samples. The programs take turns; all times are "
        f"medians of {seeds} seeds.", "",
        f"Other processes used {min(busy):.1f} to {max(busy):.1f} of the {machine['cores']} cores "
        "meanwhile. Times are therefore processor times (user and system, of all threads). Mitsuba's exclude "
        "loading and compilation; ours exclude start-up and loading.", "",
        "The error is relMSE, computed from the variance between seeds. It doesn't include bias. *Speed-up* is "
        "Mitsuba's time for its longest render, whose error is in the third column, divided by our time to the "
        "same error. *Trimmed* is the same for the error without the largest 0.1 % of the values, which is less "
        "certain to include all light, but less noisy. \"~\" marks times that are extrapolated, as in "
        "[bounces](../bounces/README.md). \"<\" marks errors that our smallest sample count reaches.", "",
        *markdown(*table(scenes)),
        "This is the same for the error of the longest render by `clustered`. Mitsuba's times beyond its longest "
        "render are extrapolated as 1 / error, as the variance of independent paths falls.", "",
        *markdown(*table_at_ours(scenes)),
        *markdown(*goals(scenes)),
        "## Time per sample, and means", "",
        "Times are slopes between the smallest and the largest sample count, which excludes what doesn't depend "
        "on the number of samples. A sample isn't the same in both programs: Kinome's shadow rays have exact "
        "or tracked transmittances, and Mitsuba's end at random. The last columns are the relative differences of "
        "the means of our images to Mitsuba's, with standard errors from a few seeds.", "",
        *markdown(*sample_table(scenes)),
        "Raw values: [measurements.csv](measurements.csv), [media.json](media.json).", "",
        "![Error against processor time](plot.png)", ""])


def measurements(scenes):
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["scene", "renderer", "samples", "processor_seconds", "relmse", "relmse_trimmed"])
    for name, entry in scenes.items():
        for side, curve in entry["curves"].items():
            who = entry["peer"] if side == "peer" else f"Kinome {side}"
            for point in curve:
                for seconds in point["processor"]:
                    writer.writerow([name, who, point["samples"], f"{seconds:.4f}",
                                     f"{point['relmse']:.5g}", f"{point['trimmed']:.5g}"])
    return text.getvalue()


def plot(scenes):
    """Returns the bytes of a PNG: one diagram for each scene."""
    columns = min(4, len(scenes))
    rows = math.ceil(len(scenes) / columns)
    figure, axes = pyplot.subplots(rows, columns, figsize=(3.4 * columns, 3 * rows), squeeze=False,
                                   layout="constrained")
    for axis in axes.flat[len(scenes):]:
        axis.set_axis_off()
    for axis, (name, entry) in zip(axes.flat, scenes.items()):
        for side, (colour, style) in STYLES.items():
            found = points(entry["curves"][side])
            axis.loglog([p["seconds"] for p in found], [p["relmse"] for p in found], style, color=colour,
                        markersize=4, label="Mitsuba" if side == "peer" else side)
        axis.set_title(name, fontsize=9)
        axis.tick_params(labelsize=7, which="both")
        axis.grid(alpha=0.3)
    axes[0, 0].legend(fontsize=7)
    figure.supxlabel("processor time [s]", fontsize=9)
    figure.supylabel("relMSE", fontsize=9)
    return png_file(figure)
