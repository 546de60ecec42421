"""Shows the distribution over seeds of `clustered`. Runs the test `seeds`, and draws the means of its images
relative to those of long renders by `path`. Writes validation/seeds/.

    sh tests/run.sh --only seeds                       # builds the test
    /usr/bin/python3 validation/seeds.py [--build build] [--report FILE]

--report: uses the output of an earlier run of the test with --gtest_output=json.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import matplotlib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from program import ROOT, commit, machine  # noqa: E402
from suite.plots import png_file  # noqa: E402
from suite.store import write_whole  # noqa: E402

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (the backend comes first)

SUITES = {"Seeds": "as users render", "SeedsOfProduct": "product sampling alone"}


def measured(build):
    """Runs the test and returns its report. Ignores the exit status because the page shows failures."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "report.json")
        subprocess.run([build / "bin/test_seeds", f"--gtest_output=json:{path}"], check=False,
                       capture_output=True)
        return json.loads(path.read_text(encoding="utf-8"))


def rows_of(report):
    """Returns {suite: [(scene, passed, mean, limit, means)]}."""
    found = {suite: [] for suite in SUITES}
    for suite in report["testsuites"]:
        for test in suite["testsuite"]:
            if "means" in test:
                found[suite["name"].split("/")[1]].append(
                    (test["name"].split("/")[-1], not test.get("failures"), float(test["mean"]),
                     float(test["limit"]), [float(word) for word in test["means"].split()]))
    return found


def plot(found):
    panels = [(suite, rows) for suite, rows in found.items() if rows]
    figure, axes = pyplot.subplots(len(panels), 1, figsize=(11, 4.4 * len(panels)), squeeze=False)
    for axis, (suite, rows) in zip(axes[:, 0], panels):
        for place, (_, passed, mean, limit, means) in enumerate(rows):
            axis.fill_between([place - 0.4, place + 0.4], 1 - limit / mean, 1 + limit / mean,
                              color="#0b4f8a", alpha=0.15, linewidth=0)
            axis.scatter([place + 0.3 * (2 * i / (len(means) - 1) - 1) for i in range(len(means))],
                         [value / mean for value in means], s=7,
                         color="#0b4f8a" if passed else "#b30000")
        axis.axhline(1, color="grey", linewidth=0.7)
        axis.set_yscale("log")
        low, high = axis.get_ylim()
        ticks = (0.1, 0.2, 0.5, 1, 2, 5, 10) if high > 4 * low else \
            (0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1, 1.05, 1.1, 1.2, 1.5, 2)
        axis.set_yticks([t for t in ticks if low <= t <= high],
                        [f"{t:g}" for t in ticks if low <= t <= high])
        axis.minorticks_off()
        axis.set_xticks(range(len(rows)), [row[0] for row in rows], rotation=90, fontsize=7)
        axis.set_xlim(-0.7, len(rows) - 0.3)
        axis.grid(axis="y", alpha=0.3)
        axis.set_title(f"{SUITES[suite]}: mean of each seed's image / that of path", fontsize=9)
    figure.tight_layout()
    return png_file(figure)


def page(found):
    lines = [
        "# Distribution over seeds", "",
        f"Written by `/usr/bin/python3 validation/seeds.py` at {commit()[:10]}, on "
        f"{machine()['processor']}. The scenes are small subjects on ground planes and under lamps of up to "
        "1,000 times their size ([seed_scenes.h](../../tests/render/product/seed_scenes.h)). Each is rendered with 20 "
        "seeds in two ways:", "",
        "- as users render: images of 64x48 pixels with 100 samples, for which `clustered` tries `path`;",
        "- product sampling alone (`trial` = false): images of 32x24 pixels with 64 samples. The names of "
        "these scenes end with the depth.", "",
        "[seeds_test.cpp](../../tests/render/product/seeds_test.cpp) defines the limits. The shaded areas are the "
        "limits of the means. In red scenes the test fails, because of a mean or an error.", "",
        "![Means of the images of all seeds](plot.png)", "",
        "| scene | `path` | limit | minimum | median | maximum | |", "|---|---|---|---|---|---|---|"]
    for rows in found.values():
        for name, passed, mean, limit, means in rows:
            middle = (means[len(means) // 2] + means[(len(means) - 1) // 2]) / 2
            lines.append(f"| {name} | {mean:.4g} | {limit:.2g} | {means[0]:.4g} | {middle:.4g} | "
                         f"{means[-1]:.4g} | {'' if passed else 'fails'} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--report", type=pathlib.Path)
    options = parser.parse_args()
    report = json.loads(options.report.read_text(encoding="utf-8")) if options.report \
        else measured(options.build)
    found = rows_of(report)
    folder = ROOT / "validation/seeds"
    write_whole(folder / "README.md", page(found))
    (folder / "plot.png").write_bytes(plot(found))
    return 0


if __name__ == "__main__":
    sys.exit(main())
