"""Measures the cost of samplers in whole renders. Writes validation/numbers/samplers.md.

    /usr/bin/python3 validation/samplers.py [--build build] [--before BUILD] [--runs N] [--isa NAME] [--add]

The scene is first.xml of docs/command-line.md. A sampler is compared with `independent` at the number of
samples to which it rounds up. The two take turns on one thread. The cost of the sampler is the median ratio
of their processor times, each minus that of a render of 12 x 8 pixels. The film becomes smaller as the
number of samples grows, so that all renders have about the same total number of samples.

--before: another build, which is measured in the same way for a second table.
--add: keeps the measurements of earlier runs.
"""
import argparse
import json
import pathlib
import statistics
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from program import ROOT, commit, machine, run_kinome  # noqa: E402

GOAL = 1.2  # maximum ratio to the render with `independent`
SAMPLERS = ("ldsampler", "stratified", "multijitter", "halton", "orthogonal")
COUNTS = (4, 16, 64, 256)
INTEGRATORS = {"path, 2": ("path", 2), "path, all": ("path", -1), "direct": ("direct", None),
               "clustered": ("clustered", None)}
PIXELS = 512 * 1024  # size of the film for 4 samples per pixel


def scene_text():
    """Returns first.xml with parameters for everything that varies."""
    page = (ROOT / "docs/command-line.md").read_text(encoding="utf-8")
    start = page.index("<!-- first.xml")
    text = page[start:page.index("```", start)]
    for before, after in (
            ('<integrator type="$integrator"/>',
             '<default name="sampler" value="independent"/>\n    DEPTH'),
            ('type="ldsampler"', 'type="$sampler"'), ('"480"', '"$width"'), ('"320"', '"$height"')):
        assert before in text, before
        text = text.replace(before, after)
    return text


def write_scene(folder, integrator, depth):
    inner = "" if depth is None else f'<integer name="max_depth" value="{depth}"/>'
    path = folder / f"{integrator}{depth}.xml"
    path.write_text(scene_text().replace(
        "DEPTH", f'<integrator type="{integrator}">{inner}</integrator>'), encoding="utf-8")
    return path


def rounded(sampler, count):
    """Returns the sample count to which the sampler rounds up."""
    side = 1
    while side * side < count or (sampler == "orthogonal" and not is_prime(side)):
        side += 1
    return side * side if sampler in ("orthogonal", "stratified") else count


def is_prime(n):
    return n > 1 and all(n % i for i in range(2, n))


def processor_seconds(build, scene, folder, sampler, count, width, isa):
    stats = run_kinome(build, scene, folder / "out.exr",
                       {"sampler": sampler, "spp": count, "width": width, "height": width * 2 // 3},
                       options=["-t", "1", *(["--isa", isa] if isa else [])])
    return stats["processor_seconds"]


def measure(build, scene, folder, sampler, wanted, runs, isa):
    count = rounded(sampler, wanted)
    width = round((PIXELS * 4 / count * 1.5) ** 0.5)
    start = min(processor_seconds(build, scene, folder, sampler, 1, 12, isa) for _ in range(3))
    pairs = [[processor_seconds(build, scene, folder, s, count, width, isa) - start
              for s in (sampler, "independent")] for _ in range(runs)]
    return {"samples": count, "seconds": pairs, "ratio": statistics.median(a / b for a, b in pairs)}


def page(data):
    builds = list(data["builds"])
    lines = [f"""# Cost of samplers

The table gives the processor time of a render of [first.xml](../../docs/command-line.md) on one thread, divided by
that with `independent` at the same number of samples. The values are medians of {data['runs']} pairs of alternating
renders, on {data['machine']['processor']}, at commit {data['commit'][:10]}. The goal is at most {GOAL}. The second
column is the sample count in the scene. `orthogonal` rounds it up to the square of a prime, as Mitsuba does, so it
takes more samples. Written by `/usr/bin/python3 validation/samplers.py`, which describes the measurement. Raw values:
[samplers.json](samplers.json).
"""]
    for build in builds:
        rows = [r for r in data["rows"] if r["build"] == build]
        if len(builds) > 1:
            lines.append(f"## {build.capitalize()}\n")
        lines += ["| integrator | samples | " + " | ".join(f"`{s}`" for s in SAMPLERS) + " |",
                  "|---|---|" + "---|" * len(SAMPLERS)]
        for name in INTEGRATORS:
            for count in COUNTS:
                cells = [next((f"{r['ratio']:.2f}" for r in rows if (r["integrator"], r["wanted"], r["sampler"])
                               == (name, count, s)), "") for s in SAMPLERS]
                if any(cells):
                    lines.append(f"| {name} | {count} | " + " | ".join(cells) + " |")
        most = max(r["ratio"] for r in rows)
        lines.append(f"\nThe largest ratio is {most:.2f}.\n")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--before", type=pathlib.Path)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--isa")
    parser.add_argument("--add", action="store_true")
    parser.add_argument("--counts", type=int, nargs="+", default=COUNTS)
    parser.add_argument("--integrators", nargs="+", default=list(INTEGRATORS))
    parser.add_argument("--output", type=pathlib.Path, default=ROOT / "validation/numbers")
    options = parser.parse_args()
    builds = ({"before": options.before} if options.before else {}) | {"now": options.build}
    data = {"machine": machine(), "commit": commit(), "runs": options.runs, "isa": options.isa,
            "builds": list(builds), "rows": []}
    if options.add:
        before = json.loads((options.output / "samplers.json").read_text(encoding="utf-8"))
        data["rows"] = before["rows"]
        data["builds"] = before["builds"]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for count in options.counts:
            for integrator in options.integrators:
                scene = write_scene(folder, *INTEGRATORS[integrator])
                for sampler in SAMPLERS:
                    for build, path in builds.items():
                        row = measure(path, scene, folder, sampler, count, options.runs, options.isa)
                        key = {"build": build, "integrator": integrator, "wanted": count,
                               "sampler": sampler}
                        data["rows"] = [r for r in data["rows"] if not key.items() <= r.items()]
                        data["rows"].append(key | row)
                        print(f"{integrator:10} {count:4} {sampler:12} {build:6} {row['ratio']:.2f}", flush=True)
                write(data, options.output)


def write(data, folder):
    """Writes all measurements so far."""
    (folder / "samplers.json").write_text(json.dumps(data) + "\n", encoding="utf-8")
    (folder / "samplers.md").write_text(page(data), encoding="utf-8")


if __name__ == "__main__":
    main()
