"""Measures the MPI traffic between processes, and predicts how many machines can render an image
efficiently. Writes validation/scaling/.

    sh scenes/render.sh                                  # builds, and makes the scenes' meshes
    /usr/bin/python3 validation/scaling.py [--build build] [--root] [SCENE...]

The program counts bytes and messages (--stats), with 1, 2, 4 and 8 processes of one thread, also if the
machine has fewer cores. A model is fitted to the traffic of the two smaller images with up to 4 processes,
and compared with all other measurements. The time without communication is that of one process with one
thread. From both, the page computes the maximum number of machines that render an image of 1920x1080 pixels
with 80 % efficiency on faster networks. The page lists the assumptions.
"""
import argparse
import csv
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

import matplotlib
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from program import ROOT, commit, machine  # noqa: E402
from suite.tables import SCENES  # noqa: E402

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (the backend comes first)

FOLDER = ROOT / "validation/scaling"
NAMES = ("hebe", "room", "attic")
SMALL, MIDDLE, LARGE = (192, 108), (384, 216), (768, 432)
SAMPLES = 64
PROCESSES = {SMALL: (2, 4, 8), MIDDLE: (1, 2, 4, 8), LARGE: (2,)}
FITTED = 4  # maximum number of processes in the measurements to which the model is fitted
# Stages that every process repeats, on all of its threads.
REPEATED = ("light left out", "light points", "tree", "cells", "points", "allocate")
# The image, the machines and the networks of the prediction.
PICTURE, PICTURE_SAMPLES, CORES = (1920, 1080), 256, 16
NETWORKS = {"10 Gbit/s": 1.25e9, "100 Gbit/s": 12.5e9}  # bytes per second
LATENCY = 2e-6  # seconds per message, typical of cluster networks
EFFICIENCY = 0.8
# Measurements that need root: network rates in Mbit/s, and the slowdown of the slow process.
RATES, REPEATS = (100, 20), 3
SLOWDOWN, SLOW_SAMPLES = 4, 256
MAX_MACHINES = 4096
MPI = os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}


def kinome(build, scene, size, folder, samples=SAMPLES):
    return [build / "bin/kinome", ROOT / scene.file, "-q", "--stats=json", "-t", "1", "-o",
            pathlib.Path(folder) / "picture.exr", f"-Dspp={samples}", f"-Dwidth={size[0]}",
            f"-Dheight={size[1]}", "-Dintegrator=clustered",
            *(f"-D{name}={value}" for name, value in scene.depth("clustered").items())]


def statistics_of(command):
    done = subprocess.run(list(map(str, command)), check=False, capture_output=True, text=True,
                          env=MPI, timeout=300)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, command))} failed:\n{done.stderr}")
    return json.loads(done.stdout)


def render(build, scene, size, processes, folder):
    launcher = ["mpirun", "--oversubscribe", "-n", str(processes)] if processes > 1 else []
    return statistics_of([*launcher, *kinome(build, scene, size, folder)])


def measure(build, names):
    runs = []
    with tempfile.TemporaryDirectory() as folder:
        for scene in SCENES:
            if scene.name not in names:
                continue
            for size, counts in PROCESSES.items():
                for processes in counts:
                    stats = render(build, scene, size, processes, folder)
                    runs.append({"scene": scene.name, "width": size[0], "height": size[1],
                                 "processes": processes, "seconds": stats["seconds"],
                                 "traffic": stats["traffic"]})
                    print(f"{scene.name} {size[0]}x{size[1]}, {processes} processes",
                          file=sys.stderr)
    return runs


def seconds_of(command):
    return statistics_of(command)["seconds"]["render"]


def measure_network(build, scene):
    """Returns [(Mbit/s, seconds)] of two processes whose packets pass a device with that rate limit. A rate
    of 0 is unlimited. Uses a new network namespace, which needs root, and Linux's token bucket filter."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        command = ["mpirun", "--mca", "btl", "self,tcp", "--mca", "btl_tcp_if_include", "lo",
                   "--mca", "pml", "ob1", "--oversubscribe", "-n", "2",
                   *kinome(build, scene, MIDDLE, folder)]
        for rate in (0, *RATES):
            limit = f"tc qdisc add dev lo root tbf rate {rate}mbit burst 32k latency 100ms" if rate \
                else "true"
            shell = ["unshare", "-n", "sh", "-c", f'ip link set lo up mtu 1500 && {limit} && exec "$@"', "sh"]
            found.append((rate, statistics.median(seconds_of([*shell, *command])
                                                  for _ in range(REPEATS))))
            print(f"network, {rate or 'no'} limit: {found[-1][1]:.2f} s", file=sys.stderr)
    return found


def measure_imbalance(build, scene):
    """Returns the seconds of one process with one thread, and of two such processes, one of which gets
    1/SLOWDOWN of a processor."""
    group = pathlib.Path("/sys/fs/cgroup/cpu/kinome-scaling")
    group.mkdir(exist_ok=True)
    (group / "cpu.cfs_period_us").write_text("20000", encoding="utf-8")
    (group / "cpu.cfs_quota_us").write_text(str(20000 // SLOWDOWN), encoding="utf-8")
    try:
        with tempfile.TemporaryDirectory() as folder:
            command = list(map(str, kinome(build, scene, MIDDLE, folder, SLOW_SAMPLES)))
            slow = ["sh", "-c", f'echo $$ > {group}/cgroup.procs; exec "$@"', "sh", *command]
            alone, together = [], []
            for _ in range(REPEATS):
                alone.append(seconds_of(command))
                together.append(seconds_of(["mpirun", "--oversubscribe", "--bind-to", "none", "-n",
                                            "1", *command, ":", "-n", "1", *slow]))
                print(f"imbalance: {alone[-1]:.2f} s, {together[-1]:.2f} s", file=sys.stderr)
            return statistics.median(alone), statistics.median(together)
    finally:
        group.rmdir()


def pixels_of(run):
    return run["width"] * run["height"]


def shares(run):
    """Returns the terms of the model for each kind of traffic; the bytes are a linear combination of them.
    Each of n processes sends its share of the image to the root, except the root itself. Each process sends
    its learned data to all others. These data are larger at edges, whose length grows with the square root
    of the number of pixels."""
    n, pixels = run["processes"], pixels_of(run)
    edges = math.sqrt(pixels)
    return {"items": [pixels * (n - 1) / n],
            "ends of passes": [pixels * (n - 1), edges * (n - 1), n * (n - 1)]}


def sent(run, kind, what="bytes"):
    return run["traffic"].get(kind, {}).get(what, 0)


def fit(runs):
    """Returns {kind: factors of shares()} by least squares of relative errors."""
    model = {}
    used = [r for r in runs if 1 < r["processes"] <= FITTED and
            (r["width"], r["height"]) in (SMALL, MIDDLE)]
    for kind in ("items", "ends of passes"):
        rows = np.array([shares(r)[kind] for r in used], float)
        bytes_ = np.array([sent(r, kind) for r in used], float)
        weights = 1 / np.maximum(bytes_, 1)
        factors, *_ = np.linalg.lstsq(rows * weights[:, None], bytes_ * weights, rcond=None)
        model[kind] = factors.tolist()
    return model


def predicted(model, run, kind):
    return float(np.dot(model[kind], shares(run)[kind]))


def work(runs):
    """Returns the seconds of one thread by kind of work: shared by all processes, repeated by each, and
    loading and writing."""
    run = next(r for r in runs if r["processes"] == 1 and (r["width"], r["height"]) == MIDDLE)
    seconds = run["seconds"]
    repeated = sum(seconds["stages"].get(name, 0) for name in REPEATED)
    return {"shared": seconds["render"] - repeated, "repeated": repeated + seconds["build"],
            "load": seconds["load"], "write": seconds["write"]}


def times(runs, model, network, machines):
    """Returns (seconds, seconds of communication) for PICTURE on `machines` machines with CORES cores."""
    pixels = PICTURE[0] * PICTURE[1]
    per_pixel = pixels / (MIDDLE[0] * MIDDLE[1])
    took = work(runs)
    shared = took["shared"] * per_pixel * PICTURE_SAMPLES / SAMPLES
    run = {"processes": machines, "width": PICTURE[0], "height": PICTURE[1]}
    passes = PICTURE_SAMPLES / SAMPLES  # factor of the number of passes, each of which sends its items
    # The root's link is the busiest. It receives all items and the learned data of all other processes.
    to_root = predicted(model, run, "items") * passes
    learned, edges, _ = model["ends of passes"]
    to_root += (learned * pixels + edges * math.sqrt(pixels)) * (machines - 1) / machines
    messages = sent_messages(runs, pixels) * passes + 40 * np.log2(max(machines, 2))
    communication = 0 if machines == 1 else to_root / network + LATENCY * messages
    seconds = (took["load"] + took["write"] * per_pixel + took["repeated"] / CORES +
               shared / CORES / machines + communication)
    return seconds, communication


def sent_messages(runs, pixels):
    """Returns the number of consecutive messages at the root: items, and requests to the work counter."""
    run = next(r for r in runs if r["processes"] == 2 and (r["width"], r["height"]) == MIDDLE)
    of_all = 2 * (sent(run, "items", "messages") + sent(run, "counter", "messages"))
    return of_all * pixels / pixels_of(run)


def efficiency(runs, model, network, machines):
    return times(runs, model, network, 1)[0] / (machines * times(runs, model, network, machines)[0])


def max_machines(runs, model, network):
    machines = 1
    while machines < MAX_MACHINES and efficiency(runs, model, network, machines + 1) >= EFFICIENCY:
        machines += 1
    return machines


def draw(of_scene, path):
    figure, axes = pyplot.subplots(1, len(of_scene), figsize=(4 * len(of_scene), 3.4), sharey=True)
    machines = np.unique(np.geomspace(1, 512, 60).astype(int))
    for axis, (name, (runs, model)) in zip(np.atleast_1d(axes), of_scene.items()):
        for label, network in NETWORKS.items():
            axis.plot(machines, [efficiency(runs, model, network, int(n)) for n in machines],
                      label=label)
        axis.axhline(EFFICIENCY, color="0.6", linewidth=0.8)
        axis.set(title=name, xscale="log", ylim=(0, 1.05), xlabel=f"machines of {CORES} cores")
    np.atleast_1d(axes)[0].set_ylabel("efficiency (model)")
    np.atleast_1d(axes)[0].legend()
    figure.tight_layout()
    figure.savefig(path, dpi=110)


def network_page(runs, name, found):
    """Returns the lines of the page on a slow network. The model adds the time of all bytes through one
    device."""
    run = next(r for r in runs if r["processes"] == 2 and (r["width"], r["height"]) == MIDDLE)
    sent_bytes = sum(kind["bytes"] for kind in run["traffic"].values())
    free = found[0][1]
    lines = ["## On a slow network", "",
             f"Two processes render `{name}` at {MIDDLE[0]}x{MIDDLE[1]}. Their packets pass a device with a "
             "limited rate (Linux's token bucket filter in a separate network namespace). The times are "
             f"medians of {REPEATS}. The model adds the time of {sent_bytes / 1e6:.1f} MB at that rate to the "
             "time without a limit.",
             "", "| Mbit/s | render, s | model, s |", "|---|---|---|",
             f"| no limit | {free:.2f} | |"]
    for rate, seconds in found[1:]:
        lines.append(f"| {rate} | {seconds:.2f} | {free + 8e-6 * sent_bytes / rate:.2f} |")
    return [*lines, ""]


def imbalance_page(name, alone, together):
    ideal = alone / (1 + 1 / SLOWDOWN)
    return ["## A slow process", "",
            f"One process with one thread renders `{name}` at {MIDDLE[0]}x{MIDDLE[1]} with {SLOW_SAMPLES} samples "
            f"in {alone:.2f} s. With a second process that gets 1/{SLOWDOWN} of a processor, the render takes "
            f"{together:.2f} s. The ideal time is {ideal:.2f} s, so the difference is "
            f"{together / ideal - 1:+.0%}. The goal is at most +15 %. The times are medians of {REPEATS}.", ""]


def page(of_scene, more):
    where = machine()
    lines = ["# Communication of several processes", "",
             f"Written by `validation/scaling.py` at {commit()[:9]}, on {where['processor']}, "
             f"{where['cores']} cores. The raw values are in `measurements.csv`. `clustered` renders with "
             f"{SAMPLES} samples per pixel and one thread per process. There are more processes than cores, so "
             "their times are not given.", "",
             "## Traffic", "",
             "| scene | image | processes | items MB | model | learned MB | model | messages |",
             "|---|---|---|---|---|---|---|---|"]
    for name, (runs, model) in of_scene.items():
        for run in runs:
            if run["processes"] == 1:
                continue
            cells = [name, f"{run['width']}x{run['height']}", str(run["processes"])]
            for kind in ("items", "ends of passes"):
                cells += [f"{sent(run, kind) / 1e6:.2f}",
                          f"{predicted(model, run, kind) / 1e6:.2f}"]
            cells.append(str(sum(kind["messages"] for kind in run["traffic"].values())))
            lines.append("| " + " | ".join(cells) + " |")
    lines += ["", "*Items* are tiles and blocks of the image that are sent to the root. *Learned* is the data "
              "that all processes exchange at the end of a pass: reports, and the learned data of each tile of "
              "`clustered`. Bytes are counted once for each receiver. The model is linear in the number of "
              "pixels. For learned data it also has a term in the square root of that number, because edges "
              "have more surfaces, and a term in the number of pairs of processes. It is fitted to the two "
              "smaller images with at most "
              f"{FITTED} processes. All other rows are predictions.", "",
              "## Number of machines", "",
              f"The table gives the maximum number of machines with an efficiency of at least {EFFICIENCY:.0%}, "
              f"for an image of {PICTURE[0]}x{PICTURE[1]} pixels with {PICTURE_SAMPLES} samples. Each machine "
              f"has {CORES} such cores and runs one process.", "",
              "| scene | one machine, s | " + " | ".join(NETWORKS) + " | limit |",
              "|---|---|" + "---|" * len(NETWORKS) + "---|"]
    for name, (runs, model) in of_scene.items():
        counts = [max_machines(runs, model, network) for network in NETWORKS.values()]
        took = work(runs)
        slow = list(NETWORKS.values())[0]
        communication = times(runs, model, slow, max(2, counts[0]))[1]
        per_pixel = PICTURE[0] * PICTURE[1] / (MIDDLE[0] * MIDDLE[1])
        limits = {"loading": took["load"], "writing": took["write"] * per_pixel,
                  "work that each process repeats": took["repeated"] / CORES,
                  "the root's link": communication}
        limit = max(limits, key=limits.get)
        lines.append(f"| {name} | {times(runs, model, slow, 1)[0]:.1f} | " +
                     " | ".join(map(str, counts)) + f" | {limit} ({limits[limit]:.2f} s) |")
    lines += ["", "![Efficiency by number of machines](plot.png)", "",
              "These assumptions are not measured:", "",
              f"- {CORES} cores do {CORES} times the work of one core.",
              "- Communication and rendering don't overlap.",
              f"- The latency of a message is {LATENCY * 1e6:.0f} µs.",
              "- The file system of the scene is equally fast for all machines.",
              "- The repeated work of each process takes the same time for the large image.", "",
              "The start-up time of the launcher and of MPI (0.3 to 1 s) is not included.", ""]
    lines += more
    (FOLDER / "README.md").write_text("\n".join(lines), encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--root", action="store_true", help="also measure a slow network and a slow "
                        "process; needs root, tc and control groups")
    parser.add_argument("scenes", nargs="*", default=NAMES)
    options = parser.parse_args()
    build = options.build.resolve()
    runs = measure(build, options.scenes)
    of_scene = {}
    for name in options.scenes:
        own = [r for r in runs if r["scene"] == name]
        of_scene[name] = (own, fit(own))
    FOLDER.mkdir(exist_ok=True)
    with (FOLDER / "measurements.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["scene", "width", "height", "processes", "kind", "messages", "bytes"])
        for run in runs:
            for kind, traffic in run["traffic"].items():
                writer.writerow([run["scene"], run["width"], run["height"], run["processes"], kind,
                                 traffic["messages"], traffic["bytes"]])
        for name, (own, _) in of_scene.items():
            for kind, seconds in work(own).items():
                writer.writerow([name, *MIDDLE, 1, f"seconds {kind}", "", f"{seconds:.3f}"])
    draw(of_scene, FOLDER / "plot.png")
    more = []
    if options.root:
        scene = next(scene for scene in SCENES if scene.name == options.scenes[0])
        own = of_scene[scene.name][0]
        more += network_page(own, scene.name, measure_network(build, scene))
        more += imbalance_page(scene.name, *measure_imbalance(build, scene))
    page(of_scene, more)


if __name__ == "__main__":
    main()
