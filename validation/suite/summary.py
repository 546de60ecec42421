"""validation/report/summary.md, which docs/results.md quotes, and the raw values as CSV."""
import csv
import io

from . import analysis
from . import tables_of_results as tables
from .page import machine_text
from .tables import explanation


def markdown(head, rows):
    return [f"| {' | '.join(head)} |", "|" + "---|" * len(head),
            *(f"| {' | '.join(row)} |" for row in rows), ""]


def summary(correctness, benchmark, problems, quick):
    """Returns the summary as Markdown."""
    entries = ([correctness] if correctness else []) + list((benchmark or {}).values())
    lines = ["# Kinome against Mitsuba 3", "", machine_text(entries), ""]
    if quick:
        lines += ["**This is the small form, which only checks that the command works.**", ""]
    if correctness:
        red = [row for row in correctness["rows"] if not row["passed"]]
        scenes = {row["scene"] for row in correctness["rows"]}
        lines += [f"Correctness: {len(correctness['rows'])} comparisons on {len(scenes)} scenes, "
                  f"{len(red)} failed.", ""]
        for row in red:
            why = explanation(row)
            lines.append(f"- failed: {row['scene']}, {row['method']}" + (f" ({why})" if why else ""))
        lines += [""] if red else []
    if benchmark:
        found = {name: analysis.summary(benchmark[name]) for name in tables.ordered(benchmark)}
        lines += ["These tables compare the seconds of rendering until an error is reached, for the best of "
                  "Kinome's integrators and the fastest configuration of the other renderers. Ratios above 1 "
                  "mean that Kinome is faster. `~` marks extrapolated times. `≤` means that the fewest samples "
                  "already reach the error. `peer only` means that Kinome doesn't reach it; such scenes aren't "
                  "included in the mean.", ""]
        for target in analysis.TARGETS:
            lines += markdown(*tables.overview(found, target))
        lines += [f"Ratio of the best peer's seconds to ours, at {tables.MIDDLE:g}:", ""]
        lines += markdown(*tables.by_renderer(found))
        lines += ["The same without the worst 0.1 % of the values of each image:", ""]
        lines += markdown(*tables.by_renderer(
            {name: analysis.summary(benchmark[name], "trimmed") for name in found}))
    lines += [f"- missing: {line}" for line in problems]
    return "\n".join(lines).rstrip() + "\n"


def measurements(benchmark):
    """Returns all timed renders as the text of a CSV file."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["scene", "group", "width", "height", "renderer", "kind", "samples", "seed",
                     "seconds", "relmse", "relmse_trimmed", "relmse_maximum", "not_finite",
                     "embree_share", "processor", "cores", "commit"])
    for name in tables.ordered(benchmark):
        entry = benchmark[name]
        for renderer, one in entry["curves"].items():
            for point in one["points"]:
                for run in point["runs"]:
                    writer.writerow([
                        name, entry["group"], *entry["size"], renderer, one["kind"],
                        point["samples"], run["seed"], run["seconds"], run["relmse"],
                        run["trimmed"], run["maximum"], run["not_finite"],
                        run.get("embree_share", ""), entry["machine"]["processor"],
                        entry["machine"]["cores"], entry["commit"]])
    return file.getvalue()


def configurations(benchmark):
    """Returns all tried configurations of Mitsuba as the text of a CSV file."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["scene", "variant", "integrator", "sampler", "mis_compensation", "samples",
                     "seconds", "relmse", "relmse_trimmed"])
    for name in tables.ordered(benchmark):
        for row in benchmark[name]["tried"]:
            writer.writerow([name, row["variant"], row["integrator"], row["sampler"],
                             row["compensation"], row["samples"], row["seconds"], row["relmse"],
                             row["trimmed"]])
    return file.getvalue()
