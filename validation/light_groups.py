"""Measures the cost of light groups in whole renders. Writes validation/numbers/light_groups.md.

    /usr/bin/python3 validation/light_groups.py [--build build] [--runs N] [--spp N]

The scene is first.xml of docs/command-line.md with two lamps, so that it has four emitters. It is rendered without
groups, and with a group for each emitter. The two take turns on one thread. The cost is the median
ratio of their processor times, each minus that of a render of 12 x 8 pixels.
"""
import argparse
import json
import pathlib
import statistics
import tempfile

from program import ROOT, commit, machine
from samplers import processor_seconds, scene_text

GOAL = 1.05  # maximum ratio to the render without groups
INTEGRATORS = ("path", "direct", "clustered")
FILTERS = ("box", "gaussian")
WIDTH = 480
GROUPS = "sky: sky; sun: sun; left: left; right: right"
LAMPS = """<shape type="sphere" id="left"> <point name="center" x="-2" y="2.5" z="2"/>
        <float name="radius" value="0.3"/>
        <emitter type="area"> <rgb name="radiance" value="12, 6, 3"/> </emitter> </shape>
    <shape type="sphere" id="right"> <point name="center" x="2.2" y="2" z="-1"/>
        <float name="radius" value="0.2"/>
        <emitter type="area"> <rgb name="radiance" value="4, 8, 16"/> </emitter> </shape>
"""


def write_scene(folder, integrator, film_filter, groups):
    nested = f'<integrator type="{integrator}"/>'
    if groups:
        nested = f'<integrator type="aov"> <string name="light_groups" value="{groups}"/> {nested} </integrator>'
    text = scene_text().replace("DEPTH", nested)
    for before, after in (('<emitter type="constant">', LAMPS + '    <emitter type="constant" id="sky">'),
                          ('<emitter type="directional">', '<emitter type="directional" id="sun">'),
                          ("</film>", f'<rfilter type="{film_filter}"/> </film>')):
        assert before in text, before
        text = text.replace(before, after)
    path = folder / f"{integrator}-{film_filter}-{'groups' if groups else 'plain'}.xml"
    path.write_text(text, encoding="utf-8")
    return path


def measure(options, folder, integrator, film_filter):
    scenes = [write_scene(folder, integrator, film_filter, groups) for groups in (GROUPS, "")]

    def seconds(scene, width):
        return processor_seconds(options.build, scene, folder, "independent", options.spp, width, None)

    start = [min(seconds(scene, 12) for _ in range(3)) for scene in scenes]
    pairs = [[seconds(scene, WIDTH) - fixed for scene, fixed in zip(scenes, start)] for _ in range(options.runs)]
    ratios = [with_groups / without for with_groups, without in pairs]
    return {"integrator": integrator, "filter": film_filter, "seconds": pairs,
            "ratio": statistics.median(ratios), "range": [min(ratios), max(ratios)]}


def page(data):
    lines = [f"""# Cost of light groups

The table gives the processor time of a render with four light groups, which writes 12 more channels, divided by that
without, on one thread. The scene is [first.xml](../../docs/command-line.md) with two more lamps. Its image has
{WIDTH}x{WIDTH * 2 // 3} pixels and {data['samples']} samples per pixel. The values are medians of {data['runs']} pairs of alternating renders, on
{data['machine']['processor']}, at commit {data['commit'][:10]}. The goal is at most {GOAL}. Written by
`/usr/bin/python3 validation/light_groups.py`. Raw values: [light_groups.json](light_groups.json).

| integrator | filter of the film | ratio | range |
|---|---|---|---|"""]
    lines += ["| `{}` | `{}` | {:.3f} | {:.3f} to {:.3f} |".format(row["integrator"], row["filter"], row["ratio"],
                                                                  *row["range"]) for row in data["rows"]]
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--runs", type=int, default=7)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--output", type=pathlib.Path, default=ROOT / "validation/numbers")
    options = parser.parse_args()
    data = {"machine": machine(), "commit": commit(), "runs": options.runs, "samples": options.spp, "rows": []}
    with tempfile.TemporaryDirectory() as folder:
        for integrator in INTEGRATORS:
            for film_filter in FILTERS:
                data["rows"].append(measure(options, pathlib.Path(folder), integrator, film_filter))
                print("{integrator:10} {filter:9} {ratio:.3f}".format(**data["rows"][-1]), flush=True)
    (options.output / "light_groups.json").write_text(json.dumps(data) + "\n", encoding="utf-8")
    (options.output / "light_groups.md").write_text(page(data), encoding="utf-8")


if __name__ == "__main__":
    main()
