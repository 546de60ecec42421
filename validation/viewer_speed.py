#!/usr/bin/env python3
"""Compares the rays per second of processor time of kinome-view with those of kinome.

Usage: validation/viewer_speed.py BUILD SCENE... [-D KEY=VALUE] [--size 800] [--seconds 20] [--pairs 3]
                                  [--csv FILE]

The window is on a virtual display (Xvfb), drawn by Mesa's llvmpipe, and nothing is moved. The viewer's
figure begins with its first full-size image, so that it lacks the start of the program, and ends with
the first one after the given processor time. kinome renders as many samples, and its figure has
everything. The two programs alternate. Processor time of the display's server isn't included. The
time to the first image is the elapsed time from the viewer's first frame to the first one with an image
of the scene. --csv appends a row for each pair to a file.
"""
import argparse
import csv
import os
import pathlib
import re
import statistics
import subprocess
import tempfile

from program import commit, run_kinome

COLUMNS = ("commit", "scene", "defines", "size", "samples", "viewer [rays/s]", "kinome [rays/s]", "first image [s]")
FIRST_IMAGE = re.compile(r"^([0-9.]+) (window|picture)")
PICTURE = re.compile(r" picture \d+ edition \d+ \S+ pass (\d+) samples .* rays (\d+)")


def processor_seconds(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def run_viewer(build, scene, seconds, display, defines):
    """Returns the rays per second of processor time, the samples per pixel, and the seconds to the first
    image."""
    arguments = [build / "bin/kinome-view", scene, "--trace"]
    for key, value in defines.items():
        arguments += ["-D", f"{key}={value}"]
    seen = []
    first_at = {}
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True,
                          env=os.environ | {"DISPLAY": display}) as viewer:
        for line in viewer.stdout:
            if found := FIRST_IMAGE.match(line):
                first_at.setdefault(found[2], float(found[1]))
            match = PICTURE.search(line)
            if match:
                seen.append((processor_seconds(viewer.pid), int(match[1]), int(match[2])))
            if match and seen[-1][0] > seen[0][0] + seconds:
                break
        viewer.kill()
    (first, _, no_rays), (last, samples, rays) = seen[0], seen[-1]
    return (rays - no_rays) / (last - first), samples, first_at["picture"] - first_at["window"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("scene", type=pathlib.Path, nargs="+")
    parser.add_argument("-D", dest="defines", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--size", type=int, default=800)
    parser.add_argument("--seconds", type=float, default=20)
    parser.add_argument("--pairs", type=int, default=3)
    parser.add_argument("--csv", type=pathlib.Path)
    options = parser.parse_args()
    read, write = os.pipe()
    with subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "1280x900x24"],
                          pass_fds=[write], stderr=subprocess.DEVNULL) as server:
        display = ":" + os.read(read, 16).decode().strip()
        for scene in options.scene:
            measure(scene, options, display)
        server.terminate()


def measure(scene, options, display):
    defines = dict(define.split("=", 1) for define in options.defines)
    defines |= {"width": options.size, "height": options.size}
    shares = []
    for _ in range(options.pairs):
        viewer, samples, first = run_viewer(options.build, scene.resolve(), options.seconds, display, defines)
        with tempfile.TemporaryDirectory() as folder:
            stats = run_kinome(options.build, scene.resolve(), pathlib.Path(folder) / "image.exr",
                               defines | {"spp": samples})
        program = sum(stats["rays"].values()) / stats["processor_seconds"]
        shares.append(viewer / program)
        print(f"{scene}: viewer {1e-6 * viewer:.2f}, kinome {1e-6 * program:.2f} million rays per second "
              f"of processor time, {samples} samples: {100 * shares[-1]:.0f} %, first image after {first:.2f} s",
              flush=True)
        if options.csv:
            write_row(options.csv, [commit(), scene.stem, " ".join(options.defines), options.size, samples,
                                    f"{viewer:.0f}", f"{program:.0f}", f"{first:.3f}"])
    print(f"{scene}: median {100 * statistics.median(shares):.0f} %", flush=True)


def write_row(path, row):
    is_new = not path.exists()
    with path.open("a", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        if is_new:
            writer.writerow(COLUMNS)
        writer.writerow(row)


if __name__ == "__main__":
    main()
