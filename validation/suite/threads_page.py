"""validation/threads/: a table and a plot of the time by the number of threads."""
import csv
import dataclasses
import io

import matplotlib

from . import threads
from .plots import png_file
from .summary import markdown

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (the backend comes first)


def images_of(rows):
    """Returns {"hebe 256x256": rows by the number of threads}."""
    found = {}
    for row in rows:
        found.setdefault(f"{row.scene} {row.size[0]}x{row.size[1]}", []).append(row)
    return found


def plot(rows):
    """Returns the bytes of a PNG: speed-ups, with hollow markers for simulated ones."""
    figure, axis = pyplot.subplots(figsize=(6, 4.4), layout="constrained")
    axis.plot(threads.COUNTS, threads.COUNTS, color="0.7", linestyle=":", label="linear")
    for name, own in images_of(rows).items():
        counts = [row.threads for row in own]
        gains = [own[0].seconds / row.seconds for row in own]
        line, = axis.plot(counts, gains, label=name)
        for row, gain in zip(own, gains):
            axis.plot(row.threads, gain, marker="o", color=line.get_color(),
                      fillstyle="full" if row.is_measured else "none")
    axis.set(xscale="log", yscale="log", xlabel="threads (hollow: simulated)", ylabel="speed-up")
    axis.set_xticks(threads.COUNTS, [str(count) for count in threads.COUNTS])
    axis.set_yticks(threads.COUNTS, [str(count) for count in threads.COUNTS])
    axis.minorticks_off()
    axis.legend(frameon=False)
    return png_file(figure)


def table(rows):
    lines = []
    for name, own in images_of(rows).items():
        for row in own:
            lines.append([name, str(row.threads), "measured" if row.is_measured else "simulated",
                          f"{row.seconds:.3f}", f"{own[0].seconds / row.seconds:.2f}",
                          f"{row.partly_idle:.3f}", f"{row.serial:.3f}"])
    return ["image", "threads", "", "render, s", "speed-up", "some threads idle, s",
            "outside loops, s"], lines


def page(rows, where, commit):
    return "\n".join([
        "# Time by the number of threads", "",
        f"Written by `sh validation/run.sh threads` at {commit[:10]}, on {where['processor']}, "
        f"{where['cores']} cores. `clustered` renders {threads.SAMPLES} samples per pixel. Loading and "
        f"writing are not included. Times are medians of {threads.REPEATS} renders.", "",
        *markdown(*table(rows)),
        "*Simulated* numbers of threads exceed the machine's cores. Their times follow from the items "
        "that one thread recorded (`--trace`): each free thread takes the next item, and one thread at a "
        "time adds a tile to the film. The simulation assumes that an item takes as long as on one "
        "thread, so shared caches and memory bandwidth don't count. It also keeps the "
        "division of setup loops for one thread, which is coarser than with more threads.", "",
        "![Speed-up by the number of threads](plot.png)", ""])


def measurements(rows):
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(field.name for field in dataclasses.fields(threads.Row))
    for row in rows:
        writer.writerow([row.scene, "x".join(map(str, row.size)), row.threads, row.is_measured,
                         row.seconds, row.partly_idle, row.serial])
    return text.getvalue()
