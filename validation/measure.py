"""Runs the benchmarks and writes validation/numbers/numbers.md, with the raw figures beside it.

Everything is measured in one run: medians of several, on whatever machine this is. See measure.sh.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import tempfile

from program import ROOT, commit, machine, run_kinome

HEBE = ROOT / "scenes/hebe/scene.xml"

MITSUBA = """
import sys, time
import mitsuba as mi
mi.set_variant("scalar_rgb")
scene = mi.load_file(sys.argv[1], integrator="direct", sampler="independent", spp=sys.argv[2],
                     width=sys.argv[3], height=sys.argv[3])
mi.set_log_level(mi.LogLevel.Error)
start = time.perf_counter()
mi.render(scene, seed=int(sys.argv[4]))
print(time.perf_counter() - start)
"""


def median(values):
    return statistics.median(values)


def run_benchmarks(build, runs):
    """Median real time in nanoseconds, by name."""
    output = subprocess.run(
        [build / "bin/kinome_benchmark", f"--benchmark_repetitions={runs}",
         "--benchmark_report_aggregates_only=true", "--benchmark_format=json"],
        check=True, capture_output=True, text=True).stdout
    unit = {"ns": 1, "us": 1e3, "ms": 1e6}
    return {b["run_name"]: {"nanoseconds": b["real_time"] * unit[b["time_unit"]],
                            "label": b.get("label", "")}
            for b in json.loads(output)["benchmarks"] if b["aggregate_name"] == "median"}


def render(build, folder, seed, **defines):
    return run_kinome(build, HEBE, folder / "out.exr", defines, seed)


def embree_share(stats):
    return stats["embree_share"]


def direct_against_mitsuba(build, folder, python, runs, size=512, spp=16):
    """Camera samples a second of both, their runs alternating."""
    ours, theirs = [], []
    for seed in range(runs):
        stats = render(build, folder, seed, integrator="direct", sampler="independent", spp=spp,
                       width=size, height=size)
        ours.append(size * size * spp / stats["seconds"]["render"])
        if python:
            seconds = subprocess.run([python, "-c", MITSUBA, HEBE, str(spp), str(size), str(seed)],
                                     check=True, capture_output=True, text=True).stdout
            theirs.append(size * size * spp / float(seconds.split()[-1]))
    return ours, theirs


def measure(build, python, runs):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        render(build, folder, 0, integrator="direct", spp=1, width=64, height=64)  # warm the files
        first = [render(build, folder, s, spp=1, sampler="independent") for s in range(runs)]
        direct = [render(build, folder, s, integrator="direct", spp=16) for s in range(runs)]
        ours, theirs = direct_against_mitsuba(build, folder, python, runs)
    return {
        "machine": machine(),
        "commit": commit(),
        "benchmarks": run_benchmarks(build, runs),
        "clustered_hebe": first,
        "direct_hebe": direct,
        "direct_samples_per_second": ours,
        "mitsuba_scalar_samples_per_second": theirs,
    }


def rows(data):
    first, direct = data["clustered_hebe"], data["direct_hebe"]
    bench = data["benchmarks"]
    plain = bench["BM_Importance512/without_lobe_rays"]
    yield ("start to first tile, hebe", "at most 0.3 s",
           f"{median(s['seconds']['first_tile'] for s in first):.3f} s")
    yield ("of which plugins", "at most 10 ms",
           f"{1e3 * median(s['seconds']['plugins'] for s in first):.1f} ms")
    yield (f"importance over 512 clusters, distribution built ({plain['label']})",
           "at most 0.8 us on AVX2, 0.4 us on AVX-512", f"{plain['nanoseconds'] / 1e3:.2f} us")
    glossy = bench["BM_Importance512/with_32_lobe_rays"]
    yield ("the same with 32 lobe rays counted", "", f"{glossy['nanoseconds'] / 1e3:.2f} us")
    scalar = bench["BM_Importance512/without_lobe_rays_scalar"]
    yield ("the same without SIMD or lobe rays", "", f"{scalar['nanoseconds'] / 1e3:.2f} us")
    yield ("tree of 32,768 points", "", f"{bench['BM_BuildTree/32768']['nanoseconds'] / 1e6:.1f} ms")
    yield ("`direct` on hebe: share of the time inside Embree", "at least 60 %",
           f"{100 * median(embree_share(s) for s in direct):.0f} %")
    ours = median(data["direct_samples_per_second"])
    yield ("`direct` on hebe, camera samples a second", "", f"{ours / 1e6:.2f} million")
    theirs = data["mitsuba_scalar_samples_per_second"]
    if theirs:
        yield ("the same, Mitsuba scalar_rgb", "", f"{median(theirs) / 1e6:.2f} million")
        yield ("ratio", "at least 2", f"{ours / median(theirs):.2f}")
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
        "# Numbers to reach, as measured", "",
        f"Medians of {options.runs} runs on {data['machine']['processor']}, "
        f"{data['machine']['cores']} cores, at commit {data['commit'][:10]}; made by "
        "`sh validation/measure.sh`. Raw figures: [numbers.json](numbers.json).", "",
        "| what | goal | measured |", "|---|---|---|"]
    lines += [f"| {' | '.join(row)} |" for row in rows(data)]
    (folder / "numbers.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
