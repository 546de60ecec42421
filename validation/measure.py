"""Runs the benchmarks, and writes validation/numbers/numbers.md and numbers.json with the raw values.

One run measures everything; the results are medians of several repetitions. See measure.sh.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import tempfile

from program import ROOT, commit, machine, run_kinome

HEBE = ROOT / "scenes/hebe/scene.xml"
BOX = ROOT / "scenes/box/scene.xml"
LAMPS = ROOT / "scenes/lamps/scene.xml"
LIGHTS = ("area10", "area1000", "area100000")

MITSUBA = """
import sys, time
import mitsuba as mi
mi.set_variant("scalar_rgb")
file, integrator, spp, size, seed = sys.argv[1:]
depth = {} if integrator == "direct" else {"max_depth": "3"}
scene = mi.load_file(file, integrator=integrator, sampler="independent", spp=spp, width=size,
                     height=size, **depth)
mi.set_log_level(mi.LogLevel.Error)
start = time.perf_counter()
mi.render(scene, seed=int(seed))
print(time.perf_counter() - start)
"""


def median(values):
    return statistics.median(values)


def run_benchmarks(build, runs):
    """Returns {name: median real time in nanoseconds, and label}."""
    output = subprocess.run(
        [build / "bin/kinome_benchmark", f"--benchmark_repetitions={runs}",
         "--benchmark_report_aggregates_only=true", "--benchmark_format=json"],
        check=True, capture_output=True, text=True).stdout
    unit = {"ns": 1, "us": 1e3, "ms": 1e6}
    return {b["run_name"]: {"nanoseconds": b["real_time"] * unit[b["time_unit"]],
                            "label": b.get("label", "")}
            for b in json.loads(output)["benchmarks"] if b["aggregate_name"] == "median"}


def against_mitsuba(build, folder, python, runs, scene, integrator, size=512, spp=16):
    """Returns the camera samples per second of Kinome and Mitsuba, whose renders alternate."""
    ours, theirs = [], []
    depth = {} if integrator == "direct" else {"max_depth": 3}
    for seed in range(runs):
        stats = run_kinome(build, scene, folder / "out.exr",
                           {"integrator": integrator, "sampler": "independent", "spp": spp,
                            "width": size, "height": size, **depth}, seed)
        ours.append(size * size * spp / stats["seconds"]["render"])
        if python:
            seconds = subprocess.run(
                [python, "-c", MITSUBA, scene, integrator, str(spp), str(size), str(seed)],
                check=True, capture_output=True, text=True).stdout
            theirs.append(size * size * spp / float(seconds.split()[-1]))
    return {"kinome": ours, "mitsuba_scalar_rgb": theirs}


def measure(build, python, runs):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)

        def render(scene, **defines):
            return [run_kinome(build, scene, folder / "out.exr", defines, s) for s in range(runs)]

        run_kinome(build, HEBE, folder / "out.exr",
                   {"integrator": "direct", "spp": 1, "width": 64, "height": 64})  # fills the page cache
        first = render(HEBE, max_depth=2, spp=1, sampler="independent", importance="joint")
        direct = render(HEBE, integrator="direct", spp=16)
        bounce = render(BOX, max_depth=3, spp=1, sampler="independent", importance="joint", width=64,
                        height=64)
        lamps = {lights: render(LAMPS, max_depth=2, lights=lights, importance="product", spp=4,
                                width=96, height=72) for lights in LIGHTS}
        rates = {"direct, hebe": against_mitsuba(build, folder, python, runs, HEBE, "direct"),
                 "path, box": against_mitsuba(build, folder, python, runs, BOX, "path")}
    return {
        "machine": machine(),
        "commit": commit(),
        "benchmarks": run_benchmarks(build, runs),
        "clustered_hebe": first,
        "direct_hebe": direct,
        "clustered_box": bounce,
        "product_lamps": lamps,
        "camera_samples_per_second": rates,
    }


def rate_rows(name, rates, goal):
    ours = median(rates["kinome"])
    yield f"`{name}`: camera samples per second", "", f"{ours / 1e6:.2f} million"
    if rates["mitsuba_scalar_rgb"]:
        theirs = median(rates["mitsuba_scalar_rgb"])
        yield "the same, Mitsuba scalar_rgb", "", f"{theirs / 1e6:.2f} million"
        yield "ratio", goal, f"{ours / theirs:.2f}"


def placing(stats):
    """Returns the seconds for placing light points, computing their light, and building the tree."""
    stages = stats["seconds"]["stages"]
    return stages["light points"] + stages["tree"]


def light_rows(runs):
    """Yields the rows on setup time and memory by number of area lights."""
    for lights, stats in runs.items():
        count = int(lights.removeprefix("area"))
        stages = [s["seconds"]["stages"] for s in stats]
        yield (f"{count:,} area lights, product: cells and points of pilot and pass", "n log n",
               f"{median(s['cells'] + s['points'] for s in stages):.3f} s")
        yield (f"{count:,} area lights: loading and building", "n log n",
               f"{median(s['seconds']['load'] + s['seconds']['build'] for s in stats):.3f} s")
        yield (f"{count:,} area lights: peak memory", "n log n",
               f"{max(s['peak_memory_bytes'] for s in stats) / 1e6:.0f} MB")


def rows(data):
    first, direct = data["clustered_hebe"], data["direct_hebe"]
    bench = data["benchmarks"]
    yield ("start to first tile, hebe", "at most 0.3 s",
           f"{median(s['seconds']['first_tile'] for s in first):.3f} s")
    yield ("loading of plugins, part of the above", "at most 10 ms",
           f"{1e3 * median(s['seconds']['plugins'] for s in first):.1f} ms")
    goals = {"": "at most 0.8 us on AVX2, 0.4 us on AVX-512",
             "local_": "at most 1.6 us on AVX2, 0.8 us on AVX-512"}
    for kind, goal in goals.items():
        plain, glossy = (bench[f"BM_Importance512/{kind}{name}"]
                         for name in ("without_lobe_rays", "with_32_lobe_rays"))
        where = "local" if kind else "distant"
        yield (f"importance of 512 {where} clusters and their distribution ({plain['label']})", goal,
               f"{plain['nanoseconds'] / 1e3:.2f} us")
        yield "the same with 32 lobe rays", "", f"{glossy['nanoseconds'] / 1e3:.2f} us"
    yield ("tree of 32,768 points", "", f"{bench['BM_BuildTree/32768']['nanoseconds'] / 1e6:.1f} ms")
    yield ("`direct` on hebe: share of the time inside Embree", "at least 60 %",
           f"{100 * median(s['embree_share'] for s in direct):.0f} %")
    yield from rate_rows("direct, hebe", data["camera_samples_per_second"]["direct, hebe"],
                         "at least 2")
    yield from rate_rows("path, box", data["camera_samples_per_second"]["path, box"],
                         "at least 0.67")
    yield ("2^15 light points of one bounce: placing, lighting and tree, box", "at most 0.15 s",
           f"{median(placing(s) for s in data['clustered_box']):.3f} s")
    yield from light_rows(data["product_lamps"])
    yield ("peak memory on hebe at 1024x1024", "at most 300 MB",
           f"{max(s['peak_memory_bytes'] for s in first + direct) / 1e6:.0f} MB")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=pathlib.Path, required=True)
    parser.add_argument("--mitsuba", metavar="PYTHON")
    parser.add_argument("--runs", type=int, default=5)
    options = parser.parse_args()
    data = measure(options.build, options.mitsuba, options.runs)
    folder = ROOT / "validation/numbers"
    folder.mkdir(exist_ok=True)
    (folder / "numbers.json").write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    lines = [
        "# Performance goals and measurements", "",
        f"Medians of {options.runs} runs on {data['machine']['processor']}, "
        f"{data['machine']['cores']} cores, at commit {data['commit'][:10]}. Written by "
        "`sh validation/measure.sh`. Raw values: [numbers.json](numbers.json).", "",
        "| quantity | goal | measured |", "|---|---|---|"]
    lines += [f"| {' | '.join(row)} |" for row in rows(data)]
    (folder / "numbers.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
