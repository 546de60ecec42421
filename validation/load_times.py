"""Compares the loading time of a mesh with a million triangles with Mitsuba 3. Writes
validation/numbers/load.md.

    /usr/bin/python3 validation/load_times.py [--build build] [--mitsuba PYTHON] [--runs N]

The mesh, a rippled sheet with normals and uv, is written as `serialized` and as binary PLY. A scene with
only this mesh is loaded by Mitsuba's scalar_rgb and llvm_ad_rgb, and by the program:

  - Mitsuba's time is that of load_file in a new process, after setting the variant and loading a scene of
    two triangles.
  - Kinome's wall time is the loading and building time of --stats. Its processor time is that of the whole
    process. Both are minus those of a scene with two triangles.

All times include building the acceleration structure. The programs take turns, and the results are medians.
"""
import argparse
import json
import os
import pathlib
import statistics
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from program import ROOT, commit, machine, run_kinome  # noqa: E402

sys.path += [str(ROOT / "scenes"), str(ROOT / "validation/references")]
import environment  # noqa: E402
from tools.files import write_ply  # noqa: E402

SIDE = 708  # vertices per side: 2 * 707 * 707 = 999,698 triangles
GOAL = 0.6  # maximum share of Mitsuba's processor and wall time
KINDS = ("serialized", "ply")
VARIANTS = ("scalar_rgb", "llvm_ad_rgb")
SCENE = """<scene version="3.0.0">
    <default name="file" value="big"/>
    <integrator type="path"/>
    <sensor type="perspective">
        <transform name="to_world"> <lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/> </transform>
        <sampler type="independent"> <integer name="sample_count" value="1"/> </sampler>
        <film type="hdrfilm"> <integer name="width" value="16"/> <integer name="height" value="16"/>
            <rfilter type="box"/> </film>
    </sensor>
    <emitter type="constant"/>
    <shape type="KIND"> <string name="filename" value="$file.KIND"/> <bsdf type="diffuse"/> </shape>
</scene>
"""
MITSUBA = """
import sys, time, json
import mitsuba as mi
variant, file = sys.argv[1:]
mi.set_variant(variant)
mi.set_log_level(mi.LogLevel.Error)
mi.load_file(file, file="small")
wall, processor = time.perf_counter(), time.process_time()
scene = mi.load_file(file, file="big")
if variant.startswith("llvm"):
    import drjit
    drjit.sync_thread()
print(json.dumps([time.perf_counter() - wall, time.process_time() - processor]))
"""


def sheet(side):
    """Returns a rippled square of side x side vertices."""
    line = np.linspace(-1, 1, side)
    x, y = np.meshgrid(line, line)
    z = 0.1 * np.sin(9 * x) * np.cos(7 * y)
    slope_x, slope_y = 0.9 * np.cos(9 * x) * np.cos(7 * y), -0.7 * np.sin(9 * x) * np.sin(7 * y)
    normals = np.stack([-slope_x, -slope_y, np.ones_like(x)], axis=2)
    normals /= np.linalg.norm(normals, axis=2)[:, :, None]
    a = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)[None]).ravel()
    faces = np.concatenate([np.stack([a, a + 1, a + side + 1], axis=1),
                            np.stack([a, a + side + 1, a + side], axis=1)])
    return {"positions": np.stack([x, y, z], axis=2).reshape(-1, 3),
            "normals": normals.reshape(-1, 3),
            "uv": np.stack([x, y], axis=2).reshape(-1, 2) / 2 + 0.5, "faces": faces}


def write_serialized(path, mesh):
    """Writes one mesh in single precision, in version 4 of the format."""
    has_normals, has_uv, is_single = 0x1, 0x2, 0x1000
    body = struct.pack("<I", has_normals | has_uv | is_single) + b"sheet\0"
    body += struct.pack("<QQ", len(mesh["positions"]), len(mesh["faces"]))
    body += b"".join(np.asarray(mesh[name], "<f4").tobytes() for name in ("positions", "normals", "uv"))
    body += np.asarray(mesh["faces"], "<u4").tobytes()
    path.write_bytes(struct.pack("<HH", 0x041C, 4) + zlib.compress(body)
                     + struct.pack("<QI", 0, 1))


def make(folder):
    for name, side in (("big", SIDE), ("small", 2)):
        mesh = sheet(side)
        write_ply(folder / f"{name}.ply", mesh)
        write_serialized(folder / f"{name}.serialized", mesh)
    for kind in KINDS:
        (folder / f"{kind}.xml").write_text(SCENE.replace("KIND", kind), encoding="ascii")


def ours(build, folder, kind):
    """Returns [wall, processor] seconds of Kinome."""
    big, small = (run_kinome(build, folder / f"{kind}.xml", folder / "out.exr", {"file": file})
                  for file in ("big", "small"))
    return [sum(big["seconds"][k] - small["seconds"][k] for k in ("load", "build")),
            big["processor_seconds"] - small["processor_seconds"]]


def theirs(python, folder, kind, variant):
    result = subprocess.run([python, "-c", MITSUBA, variant, folder / f"{kind}.xml"], check=True,
                            capture_output=True, text=True, env=os.environ)
    return json.loads(result.stdout.splitlines()[-1])


def measure(options):
    found = {kind: {name: [] for name in ("kinome", *VARIANTS)} for kind in KINDS}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        make(folder)
        for run in range(options.runs + 1):
            for kind, times in found.items():
                for who in times:
                    seconds = (ours(options.build, folder, kind) if who == "kinome" else
                               theirs(options.mitsuba, folder, kind, who))
                    print(run, kind, who, *(f"{s:.3f}" for s in seconds), file=sys.stderr)
                    if run > 0:  # run 0 brings files and programs into the page cache
                        times[who].append(seconds)
    return found


def page(data):
    lines = ["# Loading a million triangles", "",
             f"Medians of {data['runs']} runs on {data['machine']['processor']}, "
             f"{data['machine']['cores']} cores, which other programs also used, at commit "
             f"{data['commit'][:10]}. Written by `/usr/bin/python3 validation/load_times.py`, which describes "
             "the measurement. Times are in seconds and include building the acceleration structure. Raw "
             "values: [load.json](load.json).",
             "", "| file | time | ours | Mitsuba `scalar_rgb` | `llvm_ad_rgb` | ours / faster of Mitsuba's | goal |",
             "|---|---|---|---|---|---|---|"]
    for kind, times in data["seconds"].items():
        for place, name in enumerate(("wall", "processor")):
            middle = [statistics.median(s[place] for s in times[who]) for who in ("kinome", *VARIANTS)]
            share = middle[0] / min(middle[1:])
            lines.append(f"| `{kind}` | {name} | " + " | ".join(f"{s:.3f}" for s in middle)
                         + f" | {share:.2f} | at most {GOAL:g}: {'met' if share <= GOAL else 'not met'} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--mitsuba", type=pathlib.Path, metavar="PYTHON",
                        help="a Python with Mitsuba 3.9.1; default: that of validation/run.sh")
    parser.add_argument("--runs", type=int, default=5)
    options = parser.parse_args()
    options.mitsuba = options.mitsuba or options.build / "validation/mitsuba/bin/python"
    environment.use_llvm()
    data = {"machine": machine(), "commit": commit(), "runs": options.runs,
            "seconds": measure(options)}
    folder = ROOT / "validation/numbers"
    (folder / "load.json").write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    (folder / "load.md").write_text(page(data), encoding="utf-8")
    print(page(data))


if __name__ == "__main__":
    main()
