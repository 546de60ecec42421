"""Makes the contents of validation/engine/: README.md with its plot, and measurements.csv."""
import csv
import io

from matplotlib import pyplot

from . import engine_analysis as analysis
from . import plots
from .page import machine_text
from .engine_analysis import OURS, THEIRS, faster, rate, seconds
from .summary import markdown
from .tables import ISAS, SCENES
from .tables_of_results import percent, significant

CLOCKS = ("processor", "seconds")
COLUMNS = ("label", "seed", "samples", "seconds", "processor", "rays", "memory", "embree_share",
           "mean")


def goals(rows):
    head = ["quantity", "goal", "measured", ""]
    return head, [[goal.what, f"{goal.bound} {goal.limit:g} {goal.unit}",
                   analysis.range_text(list(goal.known.values())), goal.verdict]
                  for goal in analysis.goals(rows)]


def ordered(rows):
    """Returns rows in the order of tables.SCENES, followed by those of small scenes."""
    place = {scene.name: i for i, scene in enumerate(SCENES)}
    return sorted(rows, key=lambda row: (place.get(row["scene"], len(place)), row["scene"]))


def of_part(rows, part, max_depth=None):
    return ordered(row for row in rows if row["part"] == part and row["max_depth"] == max_depth)


def against(bound, limit, value):
    """Formats a goal, and whether one value reaches it."""
    goal = analysis.Goal("", bound, limit, "", {"": value})
    return f"{bound} {limit:g}: {goal.verdict}"


def speeds(rows, goal_of):
    """Returns the table of one part and depth. `goal_of(row)`: the goal for the speed-up."""
    head = ["scene", "ours [ns]", "Mitsuba [ns]", "speed-up", "range over seeds", "goal",
            "wall: ours [ns]", "Mitsuba [ns]", "speed-up", "in Embree"]
    table = []
    for row in rows:
        spread = analysis.spread(row)
        table.append([row["scene"], *(significant(rate(row, label)) for label in (OURS, THEIRS)),
                      significant(faster(row)), analysis.range_text(spread),
                      against("at least", goal_of(row), faster(row)),
                      *(significant(rate(row, label, "seconds")) for label in (OURS, THEIRS)),
                      significant(faster(row, clock="seconds")),
                      percent(analysis.embree_share(row))])
    means = [analysis.geometric_mean([value for row in rows if (value := faster(row, clock=clock))])
             for clock in CLOCKS]
    if means[0]:
        table.append(["geometric mean", "", "", significant(means[0]), "", "", "", "",
                      significant(means[1]), ""])
    return head, table


def instruction_sets(rows):
    head = ["scene", *(f"{isa} [ns]" for isa in ISAS)]
    head += [text for isa in ISAS[1:] for text in (f"{isa}: slowdown", "goal")]
    return head, [[row["scene"], *(significant(rate(row, isa)) for isa in ISAS),
                   *(text for isa, limit in zip(ISAS[1:], analysis.SLOWDOWN_GOALS)
                     for value in [faster(row, ISAS[0], isa)]
                     for text in (significant(value), against("at most", limit, value)))]
                  for row in rows]


def short(rows):
    head = ["scene", "ours [s]", "Mitsuba [s]", "speed-up", "goal"]
    return head, [[row["scene"], *(significant(seconds(row, label)) for label in (OURS, THEIRS)),
                   significant(value), against("at least", 1, value)] for row in rows
                  for value in [analysis.quotient(seconds(row, THEIRS), seconds(row, OURS))]]


def watertight(rows):
    labels = "watertight", "not watertight"
    head = ["scene", "robust, our default [ns]", "not robust [ns]", "slowdown"]
    return head, [[row["scene"], *(significant(rate(row, label)) for label in labels),
                   significant(faster(row, *reversed(labels)))] for row in rows]


def counts_text(rows):
    """Formats the sample counts between which slopes are measured."""
    counts = {}
    for row in rows:
        used = sorted({run["samples"] for run in row["runs"] if run["label"] == OURS})
        counts.setdefault(tuple(used), []).append(row["scene"])
    if len(counts) == 1:
        return " and ".join(map(str, *counts))
    return "; ".join(f"{' and '.join(map(str, used))}: {', '.join(dict.fromkeys(names))}"
                     for used, names in sorted(counts.items()))


def introduction(rows):
    seeds = sorted({run["seed"] for row in rows for run in row["runs"]})
    samplers = ", ".join(sorted({row["sampler"] for row in rows}))
    timed = [row for row in rows if row["part"] in ("direct", "path")]
    text = ("Written by `sh validation/run.sh engine`. Kinome and Mitsuba's `llvm_ad_rgb` take turns for each "
            "render, on two threads each, with the same integrator and "
            f"sampler ({samplers}). The values are medians over the seeds {', '.join(map(str, seeds))}.")
    units = ("*ns* is processor time per sample. It is the slope between two sample counts at 256x256, so it "
             "excludes loading, setup and compilation. *Wall* is the same slope of the rendering time that each "
             "program reports. *Speed-up* is Mitsuba's time divided by ours; above 1, Kinome is faster.")
    robust = ("Where both render, Embree's robust mode is off, as is Mitsuba's default. It is on by default in "
              "Kinome (`embree_use_robust_intersections` in the scene); a table below gives its cost. "
              "Raw values: [measurements.csv](measurements.csv).")
    return [text, "", units, "", robust, ""] + (
        [f"Samples per pixel: {counts_text(timed)}.", ""] if timed else [])


def page(rows, problems, quick):
    """Returns the text of README.md."""
    lines = ["# Speed of the engine, compared with Mitsuba's llvm_ad_rgb", "", machine_text(rows), ""]
    if quick:
        lines += ["**This is the small form, which only checks that the command works.**", ""]
    lines += [*introduction(rows), *markdown(*goals(rows))]
    if of_part(rows, "direct") or any(of_part(rows, "path", depth) for depth in (2, 5)):
        lines += ["![Nanoseconds per sample by scene](plot.png)", ""]
    for title, part, make in (("`direct`", of_part(rows, "direct"), direct),
                              *((f"`path` to depth {depth}", of_part(rows, "path", depth), path)
                                for depth in (2, 5)),
                              ("`direct` by instruction set", of_part(rows, "isa"),
                               instruction_sets),
                              ("`direct` at 4 spp, 192x144, seconds of rendering",
                               of_part(rows, "short"), short),
                              ("`direct` with robust intersections",
                               of_part(rows, "watertight"), watertight)):
        if part:
            lines += [f"## {title}", "", *markdown(*make(part))]
    for row in rows:
        apart = analysis.different_pictures(row)
        if apart:
            lines.append(f"- The images may be different: {row['scene']}, {row['part']}: the means differ "
                         f"by {percent(apart)}")
    lines += [f"- missing: {line}" for line in problems]
    return "\n".join(lines).rstrip() + "\n"


def direct(rows):
    return speeds(rows, lambda row: analysis.PLASTIC if analysis.is_rough_plastic(row)
                  else analysis.DIRECT)


def path(rows):
    return speeds(rows, lambda row: analysis.PATH)


def plot(rows):
    """Plots nanoseconds per sample of both programs, with a panel for each part and depth. Returns the bytes of
    a PNG, or None if there are no rows."""
    panels = [(title, part) for title, part in
              (("direct", of_part(rows, "direct")),
               *((f"path to depth {depth}", of_part(rows, "path", depth)) for depth in (2, 5)))
              if part]
    if not panels:
        return None
    tallest = max(len(part) for _, part in panels)
    figure, axes = pyplot.subplots(1, len(panels), figsize=(4.6 * len(panels), 1.6 + 0.2 * tallest),
                                   squeeze=False, sharex=True)
    for axis, (title, part) in zip(axes[0], panels):
        for label, colour, mark in ((OURS, plots.OURS[0], "o"), (THEIRS, plots.PEERS[0], "s")):
            found = [(rate(row, label), place) for place, row in enumerate(part)
                     if rate(row, label) is not None]
            if found:
                axis.plot(*zip(*found), mark, color=colour, markersize=4.5, label=label)
        axis.set(xscale="log", xlabel="ns per sample", title=title,
                 ylim=(len(part) - 0.5, -0.5))
        axis.set_yticks(range(len(part)), [row["scene"] for row in part], fontsize=8)
        axis.grid(alpha=0.3, which="both")
        axis.legend(fontsize=8)
    figure.tight_layout()
    return plots.png_file(figure)


def measurements(rows):
    """Returns all renders as the text of a CSV file."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["part", "scene", "max_depth", "width", "height", "sampler", *COLUMNS, "bsdfs",
                     "processor_name", "cores", "commit"])
    for row in rows:
        for run in row["runs"]:
            values = [run.get(name) for name in COLUMNS]
            writer.writerow([row["part"], row["scene"], row["max_depth"] or "", *row["size"],
                             row["sampler"], *("" if v is None else v for v in values),
                             " ".join(run.get("bsdfs", ())), row["machine"]["processor"],
                             row["machine"]["cores"], row["commit"]])
    return file.getvalue()
