"""Page of bounces.py: a table, a plot for each scene, and the raw values as CSV."""
import math
import statistics

import matplotlib

from suite.analysis import geometric_mean, seconds_to, slope
from suite.plots import png_file
from suite.store import write_whole

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (the backend comes first)

TARGETS = (1e-2, 1e-3)
# Goals for the speed-up at the last target: geometric mean, and minimum of all scenes.
MEAN_GOAL, MIN_GOAL = 6, 1


def points(curve):
    return [{"seconds": statistics.median(p["processor"]), "relmse": p["relmse"]} for p in curve]


def reach(found, target, side):
    """Does the same as analysis.seconds_to, but extrapolates with a slope of at least -1. That is how the
    variance falls with the number of samples. While a method learns, its error may fall faster, but not
    later. Mitsuba's slope is -1. Ours is that of the last two points, if these are flatter."""
    seconds, kind = seconds_to(found, target, 1)
    if kind in ("measured", "at most"):
        return seconds, kind
    falls = -1.0
    if side == "ours" and len(found) > 1:
        falls = max(falls, min(slope(found[-2:]), -0.1))
    last = found[-1]
    return last["seconds"] * (target / last["relmse"]) ** (1 / falls), "extrapolated"


def figures(entry):
    """Returns {target: (our seconds, kind, their seconds, kind, speed-up)}."""
    found = {}
    for target in TARGETS:
        ours, theirs = (reach(points(entry["curves"][side]), target, side)
                        for side in ("ours", "peer"))
        found[target] = (*ours, *theirs, theirs[0] / ours[0])
    return found


def number(value, kind="measured"):
    """Formats a time or a ratio. "~" marks an extrapolated value; "<" marks a target that the first point
    already reaches."""
    if value is None:
        return "–"
    mark = {"extrapolated": "~", "at most": "<"}.get(kind, "")
    return f"{mark}{value:.3g}"


def ratio(ours, theirs, times):
    """Formats a speed-up with the mark of the less certain kind."""
    kinds = {ours, theirs}
    return number(times, "extrapolated" if "extrapolated" in kinds or "at most" in kinds
                  else "measured")


def page(machine, scenes, options):
    rows, all_times = [], {target: [] for target in TARGETS}
    for name, entry in scenes.items():
        cells = []
        for target, (ours, our_kind, theirs, their_kind, times) in figures(entry).items():
            cells += [number(ours, our_kind), number(theirs, their_kind),
                      ratio(our_kind, their_kind, times)]
            if times:
                all_times[target].append((times, name))
        cells += [f"{100 * entry['difference']:+.2f} ± {100 * entry['difference_error']:.2f} %"]
        rows.append(f"| {name} | {entry['peer'].removeprefix('Mitsuba ').removesuffix(', depth -1')} | "
                    f"{' | '.join(cells)} |")
    means = {target: geometric_mean([t for t, _ in times]) for target, times in all_times.items()}
    below = [name for times, name in all_times[TARGETS[-1]] if times < MIN_GOAL]
    met = means[TARGETS[-1]] is not None and means[TARGETS[-1]] >= MEAN_GOAL
    commits = sorted({entry["commit"][:10] for entry in scenes.values()})
    return "\n".join([
        "# Light after any number of bounces", "",
        f"Written by `/usr/bin/python3 validation/bounces.py` at {', '.join(commits)}, on "
        f"{machine['processor']}, {machine['cores']} cores. The images have 192x144 pixels, and max_depth is "
        "-1. `clustered` with `ldsampler` is compared with the fastest configuration of Mitsuba 3.9.1, which "
        "the table names. The two programs take turns; all times are medians of "
        f"{options.seeds} seeds.", "",
        "Time is processor time (user and system, of all threads), because other programs also used the "
        "machine. It is a few percent longer than on an idle machine. Mitsuba's time excludes loading and "
        "compilation; ours excludes start-up and loading. [bounces.py](../bounces.py) describes both "
        "measurements.", "",
        "The error is relMSE, computed from the variance between seeds. It doesn't include the bias of "
        "Mitsuba's samplers, or light that no render found. \"~\" marks times that are extrapolated beyond "
        "the longest render: Mitsuba's error falls as 1 / time, and ours falls in the same way or along its "
        "last two points, whichever is slower. \"<\" marks targets that the smallest sample count reaches.", "",
        "The last column is the relative difference between the mean of our image and that of Mitsuba's "
        "image, with its standard error. A few seeds give only a rough estimate of it: the pixels of our "
        "images share light points, so an image varies as a whole. "
        "Raw values: [measurements.csv](measurements.csv), [bounces.json](bounces.json).", "",
        "| scene | Mitsuba's fastest | 1e-2: ours [s] | Mitsuba [s] | speed-up | 1e-3: ours [s] | "
        "Mitsuba [s] | speed-up | mean |", "|---|---|---|---|---|---|---|---|---|", *rows, "",
        "| speed-up | goal | measured | |", "|---|---|---|---|",
        f"| geometric mean to 1e-3 | at least {MEAN_GOAL} | {number(means[TARGETS[-1]])} | "
        f"{'met' if met else 'not met'} |",
        f"| minimum to 1e-3 | at least {MIN_GOAL} | "
        f"{number(min((t for t, _ in all_times[TARGETS[-1]]), default=None))} | "
        f"{'not met by ' + ', '.join(below) if below else 'met'} |",
        f"| geometric mean to 1e-2 | | {number(means[TARGETS[0]])} | |", "",
        "![Error against processor time](plot.png)", ""])


def measurements(scenes):
    lines = ["scene,renderer,samples,processor_seconds,relmse,relmse_trimmed"]
    for name, entry in scenes.items():
        for side, curve in entry["curves"].items():
            who = "Kinome clustered" if side == "ours" else entry["peer"]
            for point in curve:
                for seconds in point["processor"]:
                    lines.append(f'{name},"{who}",{point["samples"]},{seconds:.4f},'
                                 f'{point["relmse"]:.5g},{point["trimmed"]:.5g}')
    return "\n".join(lines) + "\n"


def plot(scenes):
    columns = min(4, len(scenes))
    count = math.ceil(len(scenes) / columns)
    figure, axes = pyplot.subplots(count, columns, figsize=(3.4 * columns, 3 * count), squeeze=False)
    for axis in axes.ravel()[len(scenes):]:
        axis.set_axis_off()
    for axis, (name, entry) in zip(axes.ravel(), scenes.items()):
        for side, style, label in (("ours", "o-", "clustered"), ("peer", "s--", "Mitsuba")):
            found = points(entry["curves"][side])
            axis.loglog([p["seconds"] for p in found], [p["relmse"] for p in found], style,
                        color="#b30000" if side == "ours" else "#0b4f8a", markersize=4, label=label)
        for target in TARGETS:
            axis.axhline(target, color="grey", linewidth=0.7, linestyle=":")
        axis.set_title(name, fontsize=9)
        axis.tick_params(labelsize=7, which="both")
        axis.grid(alpha=0.3)
    axes[0, 0].legend(fontsize=7)
    figure.supxlabel("processor time [s]", fontsize=9)
    figure.supylabel("relMSE", fontsize=9)
    figure.tight_layout()
    return png_file(figure)


def write(folder, machine, scenes, options):
    write_whole(folder / "README.md", page(machine, scenes, options))
    write_whole(folder / "measurements.csv", measurements(scenes))
    (folder / "plot.png").write_bytes(plot(scenes))
