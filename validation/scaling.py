"""What several processes send each other over MPI, and how many machines a picture can use; writes
validation/scaling/.

    sh scenes/render.sh                                  # builds, and makes the scenes' meshes
    /usr/bin/python3 validation/scaling.py [--build build] [--root] [SCENE...]

Bytes and messages are counted by the program (--stats), with 1, 2, 4 and 8 processes of one thread on this
machine, whatever it has. A model is fitted to those of the two smaller pictures, up to 4 processes, and
compared with all the others. What a picture takes without communication is measured with one process of one thread, in
processor time; from both the page says up to how many machines a picture of 1920x1080 pixels is rendered at
80 % efficiency, on networks that are not here: see the page for what it takes for granted.
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
FITTED = 4
# Stages that every process goes through for itself, on all of its threads.
REPEATED = ("light left out", "light points", "tree", "cells", "points", "allocate")
# What is asked for: a picture, machines, networks.
PICTURE, PICTURE_SAMPLES, CORES = (1920, 1080), 256, 16
NETWORKS = {"10 Gbit/s": 1.25e9, "100 Gbit/s": 12.5e9}
LATENCY = 2e-6  # seconds of a message, of common networks of clusters
EFFICIENCY = 0.8
# Of the measurements that need root: rates in Mbit/s, and a process that is so many times slower.
RATES, REPEATS = (100, 20), 3
SLOWER, SLOW_SAMPLES = 4, 256
MOST = 4096
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
    """[(Mbit/s, seconds)] with two processes whose packets go through a device of that rate; 0: of none.
    A network of its own, as root has it, with Linux's token bucket filter."""
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
    """Seconds of one process of one thread, and of two, one of which has a quarter of a processor."""
    group = pathlib.Path("/sys/fs/cgroup/cpu/kinome-scaling")
    group.mkdir(exist_ok=True)
    (group / "cpu.cfs_period_us").write_text("20000", encoding="utf-8")
    (group / "cpu.cfs_quota_us").write_text(str(20000 // SLOWER), encoding="utf-8")
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
    """What bytes are proportional to, for each kind of traffic: of n processes each sends its share of the
    picture to the root, which has its own; what was learned goes from each to all others, and is more
    where edges are, of which there are more the larger a picture is, but not as many more."""
    n, pixels = run["processes"], pixels_of(run)
    edges = math.sqrt(pixels)
    return {"items": [pixels * (n - 1) / n],
            "ends of passes": [pixels * (n - 1), edges * (n - 1), n * (n - 1)]}


def sent(run, kind, what="bytes"):
    return run["traffic"].get(kind, {}).get(what, 0)


def fit(runs):
    """{kind: factors of shares()} by least squares of relative errors."""
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
    """Seconds of one thread: what all share, what each repeats, what the root does alone."""
    run = next(r for r in runs if r["processes"] == 1 and (r["width"], r["height"]) == MIDDLE)
    seconds = run["seconds"]
    repeated = sum(seconds["stages"].get(name, 0) for name in REPEATED)
    return {"shared": seconds["render"] - repeated, "repeated": repeated + seconds["build"],
            "load": seconds["load"], "write": seconds["write"]}


def times(runs, model, network, machines):
    """Of PICTURE on so many machines of CORES cores: (seconds, those of communication)."""
    pixels = PICTURE[0] * PICTURE[1]
    per_pixel = pixels / (MIDDLE[0] * MIDDLE[1])
    took = work(runs)
    shared = took["shared"] * per_pixel * PICTURE_SAMPLES / SAMPLES
    run = {"processes": machines, "width": PICTURE[0], "height": PICTURE[1]}
    passes = PICTURE_SAMPLES / SAMPLES  # as many more of them, each of which sends its items
    # At the root's own link, the busiest: all items, and what others have learned.
    to_root = predicted(model, run, "items") * passes
    learned, edges, _ = model["ends of passes"]
    to_root += (learned * pixels + edges * math.sqrt(pixels)) * (machines - 1) / machines
    messages = sent_messages(runs, pixels) * passes + 40 * np.log2(max(machines, 2))
    communication = 0 if machines == 1 else to_root / network + LATENCY * messages
    seconds = (took["load"] + took["write"] * per_pixel + took["repeated"] / CORES +
               shared / CORES / machines + communication)
    return seconds, communication


def sent_messages(runs, pixels):
    """Items that come to the root, and its answers to the counter, one after the other."""
    run = next(r for r in runs if r["processes"] == 2 and (r["width"], r["height"]) == MIDDLE)
    of_all = 2 * (sent(run, "items", "messages") + sent(run, "counter", "messages"))
    return of_all * pixels / pixels_of(run)


def efficiency(runs, model, network, machines):
    return times(runs, model, network, 1)[0] / (machines * times(runs, model, network, machines)[0])


def most_machines(runs, model, network):
    machines = 1
    while machines < MOST and efficiency(runs, model, network, machines + 1) >= EFFICIENCY:
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
    """Against the model: what all processes send goes through one device."""
    run = next(r for r in runs if r["processes"] == 2 and (r["width"], r["height"]) == MIDDLE)
    sent_bytes = sum(kind["bytes"] for kind in run["traffic"].values())
    free = found[0][1]
    lines = ["## On a slow network", "",
             f"`{name}`, {MIDDLE[0]}x{MIDDLE[1]}, two processes, whose packets go through a device of a limited "
             f"rate (Linux's token bucket filter in a network of its own); medians of {REPEATS}. The model: "
             f"the {sent_bytes / 1e6:.1f} MB that are sent, at that rate, on top of the time without a limit.",
             "", "| Mbit/s | render, s | model, s |", "|---|---|---|",
             f"| no limit | {free:.2f} | |"]
    for rate, seconds in found[1:]:
        lines.append(f"| {rate} | {seconds:.2f} | {free + 8e-6 * sent_bytes / rate:.2f} |")
    return [*lines, ""]


def imbalance_page(name, alone, together):
    ideal = alone / (1 + 1 / SLOWER)
    return ["## A slow process", "",
            f"`{name}`, {MIDDLE[0]}x{MIDDLE[1]}, {SLOW_SAMPLES} samples: one process of one thread renders for "
            f"{alone:.2f} s. With another one beside it that has 1/{SLOWER} of a processor, {together:.2f} s; "
            f"ideal would be {ideal:.2f} s: {together / ideal - 1:+.0%} (medians of {REPEATS}). The goal "
            "was at most +15 %.", ""]


def page(of_scene, more):
    where = machine()
    lines = ["# Communication of several processes", "",
             "Made by `validation/scaling.py`; the raw figures are in `measurements.csv`. "
             f"{where['processor']}, {where['cores']} cores, at {commit()[:9]}. `clustered`, "
             f"{SAMPLES} samples a pixel, one thread a process; there are more processes than cores, so that "
             "no time of theirs is quoted.", "",
             "## What is sent", "",
             "| scene | picture | processes | items MB | model | learned MB | model | messages |",
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
    lines += ["", "*Items*: tiles and blocks of the picture on their way to the root. *Learned*: what passes "
              "end with: reports, and what `clustered` has learned of each tile, which all processes get. "
              "Bytes count once for each process that gets them. The model (by pixels, and for what is "
              "learned by their root, too, as edges have more surfaces) is fitted to the two smaller pictures "
              f"of at most {FITTED} processes; all other rows are predictions.", "",
              "## How many machines", "",
              f"Of {PICTURE[0]}x{PICTURE[1]} pixels and {PICTURE_SAMPLES} samples, on machines of "
              f"{CORES} such cores, one process each: the most at which each of them does at least "
              f"{EFFICIENCY:.0%} of what it does alone.", "",
              "| scene | one machine, s | " + " | ".join(NETWORKS) + " | what limits it |",
              "|---|---|" + "---|" * len(NETWORKS) + "---|"]
    for name, (runs, model) in of_scene.items():
        counts = [most_machines(runs, model, network) for network in NETWORKS.values()]
        took = work(runs)
        slow = list(NETWORKS.values())[0]
        communication = times(runs, model, slow, max(2, counts[0]))[1]
        per_pixel = PICTURE[0] * PICTURE[1] / (MIDDLE[0] * MIDDLE[1])
        limits = {"loading": took["load"], "writing": took["write"] * per_pixel,
                  "what each process repeats": took["repeated"] / CORES,
                  "the root's link": communication}
        limit = max(limits, key=limits.get)
        lines.append(f"| {name} | {times(runs, model, slow, 1)[0]:.1f} | " +
                     " | ".join(map(str, counts)) + f" | {limit} ({limits[limit]:.2f} s) |")
    lines += ["", "![Efficiency by number of machines](plot.png)", "",
              "**Taken for granted, not measured:** sixteen cores do sixteen times the work of one; what is "
              f"sent isn't sent while rendering goes on; {LATENCY * 1e6:.0f} µs a message; the scene's file "
              "system serves all machines alike; what each process repeats takes as long for the large "
              "picture. The start of the launcher and of MPI (0.3 to 1 s) is left "
              "out.", ""]
    lines += more
    (FOLDER / "README.md").write_text("\n".join(lines), encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--root", action="store_true", help="also on a slow network and with a slow "
                        "process, which needs root, tc and control groups")
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
