"""validation/budgets/: plot of all ratios, table, and raw values."""

import matplotlib

from .analysis import geometric_mean
from .budgets import BUDGETS, LIMIT, MAX_SEEDS, SIZE, ratios
from .plots import png_file

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (the backend comes first)

COLOURS = ("#0b4f8a", "#4361ee", "#2a9d8f", "#6a994e", "#e8590c", "#b30000", "#7b2cbf",
           "#495057", "#c2a000")


def by_worst(scenes):
    """Returns pairs of a name and its rows, worst scene first."""
    found = [(name, ratios(entry)) for name, entry in scenes.items()]
    return sorted(((name, rows) for name, rows in found if rows),
                  key=lambda pair: min(row["ratio"] for row in pair[1]))


def cell(row):
    if row is None:
        return "–"
    marks = ("*" if row["by_paths"] else "") + ("†" if row["peer"] == "ptracer" else "")
    text = f"{row['ratio']:.2g}"
    return (f"**{text}**" if row["ratio"] < LIMIT else text) + marks


def page(machine, scenes):
    found = by_worst(scenes)
    rows = []
    for name, of_scene in found:
        cells = {row["budget"]: row for row in of_scene}
        entry = scenes[name]
        rows.append(f"| {name} | " +
                    " | ".join(cell(cells.get(budget.name)) for budget in BUDGETS) +
                    f" | {100 * entry['difference']:+.2f} ± {100 * entry['difference_error']:.2f} % |")
    columns = {budget.name: [row["ratio"] for _, of_scene in found for row in of_scene
                             if row["budget"] == budget.name] for budget in BUDGETS}
    rows.append("| geometric mean | " + " | ".join(
        f"{geometric_mean(values):.2g}" if values else "–" for values in columns.values()) + " | |")
    rows.append("| least | " + " | ".join(
        f"{min(values):.2g}" if values else "–" for values in columns.values()) + " | |")
    every = [ratio for values in columns.values() for ratio in values]
    below = sum(ratio < LIMIT for ratio in every)
    commits = sorted({entry["commit"][:10] for entry in scenes.values()})
    seeds = sorted({entry["seeds"] for entry in scenes.values()})
    return "\n".join([
        "# Is `clustered` ever worse than `path`?", "",
        f"Written by `sh validation/run.sh budgets` at {', '.join(commits)}, on "
        f"{machine['processor']}, {machine['cores']} cores. The images have {SIZE[0]}x{SIZE[1]} pixels unless "
        f"the name gives another size, and max_depth is -1. There are {'/'.join(map(str, seeds))} seeds, and "
        f"up to {MAX_SEEDS} for short renders.", "",
        "Each value is the relMSE of the better of `path` and `ptracer` at equal time, divided by that of "
        "`clustered`. Above 1, `clustered` is better. Time is processor time (user and system, of all "
        "threads), without start-up and loading. The error is the variance between seeds. With so few seeds, "
        "ratios are uncertain by about 20 %, and light that no render found is not included. The last column "
        "compares the means of the images with those of `path`, with one standard error.", "",
        "Errors of `path` between its measured sample counts are interpolated. Beyond them, they are assumed "
        "to fall as 1 / time. With `--time` and `--error`, `path` has the same budget, and its error is scaled "
        "to the processor time that `clustered` took.", "",
        f"{len(every)} values, {below} below {LIMIT}." if every else "Nothing was measured.", "",
        "![relMSE ratio of all scenes and budgets](plot.png)", "",
        "\\*: `clustered` left the image to `path` with at least one seed. †: `ptracer` is the better "
        f"of the two. Values below {LIMIT} are bold. Raw values: [measurements.csv](measurements.csv), "
        "[budgets.json](budgets.json).", "",
        f"| scene | {' | '.join(budget.name for budget in BUDGETS)} | mean |",
        "|---|" + "---|" * (len(BUDGETS) + 1), *rows, ""])


def measurements(scenes):
    lines = ["scene,integrator,budget,samples,processor_seconds,relmse,relmse_trimmed,"
             "seeds_by_path,ratio"]
    for name, entry in scenes.items():
        found = {row["budget"]: row["ratio"] for row in ratios(entry)}
        for who, curve in entry["curves"].items():
            for one in curve:
                ratio = found.get(one["budget"]) if who == "clustered" else None
                for seconds in one["processor"]:
                    lines.append(f'{name},{who},{one["budget"]},{one["samples"]},{seconds:.4f},'
                                 f'{one["relmse"]:.5g},{one["trimmed"]:.5g},{one["by_paths"]},'
                                 f'{"" if ratio is None else f"{ratio:.4g}"}')
    return "\n".join(lines) + "\n"


def plot(scenes):
    """Draws a column for each scene and a mark for each budget; returns the bytes of a PNG."""
    found = by_worst(scenes)
    figure, axis = pyplot.subplots(figsize=(max(7, 0.34 * len(found) + 2), 6))
    for index, budget in enumerate(BUDGETS):
        shift = 0.1 * (index - (len(BUDGETS) - 1) / 2)
        marks = [(place + shift, row) for place, (_, rows) in enumerate(found) for row in rows
                 if row["budget"] == budget.name]
        for is_paths, face in ((False, COLOURS[index]), (True, "none")):
            some = [(x, row["ratio"]) for x, row in marks if bool(row["by_paths"]) == is_paths]
            axis.scatter([x for x, _ in some], [y for _, y in some], s=22, facecolors=face,
                         edgecolors=COLOURS[index], linewidths=1,
                         marker="s" if budget.seconds else "D" if budget.error else "o",
                         label=None if is_paths else budget.name)
    axis.scatter([], [], s=22, facecolors="none", edgecolors="grey", label="left to path")
    axis.axhline(1, color="grey", linewidth=0.7)
    axis.axhline(LIMIT, color="#b30000", linewidth=1.2)
    axis.text(len(found) - 0.4, LIMIT, f" {LIMIT}", color="#b30000", fontsize=8, va="center")
    axis.set_yscale("log")
    every = [row["ratio"] for _, rows in found for row in rows]
    if every:
        axis.set_ylim(min(0.5, 0.8 * min(every)), max(2, 1.3 * max(every)))
    axis.set_xlim(-0.7, len(found) - 0.3)
    axis.set_xticks(range(len(found)), [name for name, _ in found], rotation=90, fontsize=7)
    for place in range(len(found) - 1):
        axis.axvline(place + 0.5, color="grey", linewidth=0.3, alpha=0.4)
    ticks = [t for t in (.03, .1, .2, .5, 1, 2, 5, 10, 30, 100, 300, 1000)
             if axis.get_ylim()[0] <= t <= axis.get_ylim()[1]]
    axis.set_yticks(ticks, [f"{t:g}" for t in ticks])
    axis.minorticks_off()
    axis.grid(axis="y", alpha=0.3)
    axis.set_ylabel("relMSE of the better of path and ptracer / of clustered, equal time", fontsize=8)
    axis.legend(fontsize=7, ncol=7, loc="lower center", bbox_to_anchor=(0.5, 1), frameon=False)
    figure.tight_layout()
    return png_file(figure)
