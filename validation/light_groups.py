"""Measures the cost of light groups in whole renders. Writes validation/numbers/light_groups.md.

    python3 scenes/make_assets.py room lamps
    /usr/bin/python3 validation/light_groups.py [--build build] [--runs N] [--spp N] [--integrators NAME...]

There are three scenes: first.xml of docs/command-line.md with two lamps, scenes/room with three lamps,
and scenes/lamps with 1000 lamps. Each is rendered without groups, and with its emitters in four groups.
The two take turns on one thread. The cost is the median ratio of their processor times, each minus that
of a render of 12 x 8 pixels.

--integrators: measures only these, and keeps the measurements of the others.
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


def lamp(name, position, radius, radiance):
    x, y, z = position
    return f"""<shape type="sphere" id="{name}"> <point name="center" x="{x}" y="{y}" z="{z}"/>
        <float name="radius" value="{radius}"/>
        <emitter type="area"> <rgb name="radiance" value="{radiance}"/> </emitter> </shape>
    """


def replaced(text, *pairs):
    for before, after in pairs:
        assert before in text, before
        text = text.replace(before, after)
    return text


def first():
    added = lamp("left", (-2, 2.5, 2), 0.3, "12, 6, 3") + lamp("right", (2.2, 2, -1), 0.2, "4, 8, 16")
    text = replaced(scene_text(), ("DEPTH", "INTEGRATOR"), ("</film>", "FILTER </film>"),
                    ('<emitter type="constant">', added + '<emitter type="constant" id="sky">'),
                    ('<emitter type="directional">', '<emitter type="directional" id="sun">'))
    return text, "sky: sky; sun: sun; left: left; right: right"


def scene_file(name):
    """Returns the text of a scene of scenes/, for use in another folder."""
    text = (ROOT / f"scenes/{name}/scene.xml").read_text(encoding="utf-8")
    return replaced(text, ('"assets/', f'"{ROOT}/scenes/{name}/assets/'), ('<rfilter type="box"/>', "FILTER"),
                    ('<include filename="../integrators/$integrator.xml"/>', "INTEGRATOR"))


def room():
    added = "".join(lamp(f"lamp{i}", position, 0.08, "20, 14, 8")
                    for i, position in enumerate(((-1, 2.1, 0), (0, 2.1, -1), (1, 2.1, 0))))
    text = replaced(scene_file("room"), ('<emitter type="envmap">', added + '<emitter type="envmap" id="sky">'))
    return text, "sky: sky; left: lamp0; middle: lamp1; right: lamp2"


def lamps():
    """Every fourth lamp is in the same group."""
    emitters = (ROOT / "scenes/lamps/assets/area1000.xml").read_text(encoding="utf-8").splitlines()
    shapes = [line for line in emitters if line.startswith("<shape ")]
    shapes = [line.replace("<shape ", f'<shape id="lamp{i}" ', 1) for i, line in enumerate(shapes)]
    text = replaced(scene_file("lamps"), (f'<include filename="{ROOT}/scenes/lamps/assets/$lights.xml"/>',
                                          "\n".join(shapes)))
    groups = (" ".join(f"lamp{i}" for i in range(k, len(shapes), 4)) for k in range(4))
    return text, "; ".join(f"group{k}: {members}" for k, members in enumerate(groups))


# Name in the table, function, and width of the image.
SCENES = (("first.xml", first, 480), ("room", room, 240), ("lamps", lamps, 240))


def write_scene(folder, scene, integrator, film_filter, has_groups):
    text, groups = scene()
    nested = f'<integrator type="{integrator}"/>'
    if has_groups:
        nested = f'<integrator type="aov"> <string name="light_groups" value="{groups}"/> {nested} </integrator>'
    path = folder / f"{scene.__name__}-{integrator}-{film_filter}-{'groups' if has_groups else 'plain'}.xml"
    path.write_text(replaced(text, ("INTEGRATOR", nested), ("FILTER", f'<rfilter type="{film_filter}"/>')),
                    encoding="utf-8")
    return path


def measure(options, folder, name, scene, width, integrator, film_filter):
    files = [write_scene(folder, scene, integrator, film_filter, has_groups) for has_groups in (True, False)]

    def seconds(file, columns):
        return processor_seconds(options.build, file, folder, "independent", options.spp, columns, None)

    start = [min(seconds(file, 12) for _ in range(3)) for file in files]
    pairs = [[seconds(file, width) - fixed for file, fixed in zip(files, start)] for _ in range(options.runs)]
    ratios = [with_groups / without for with_groups, without in pairs]
    return {"scene": name, "commit": commit(), "integrator": integrator, "filter": film_filter, "width": width, "seconds": pairs,
            "ratio": statistics.median(ratios), "range": [min(ratios), max(ratios)]}


def page(data):
    lines = [f"""# Cost of light groups

The table gives the processor time of a render with four light groups, which writes 12 more channels, divided by that
without, on one thread. The scenes are [first.xml](../../docs/command-line.md) with two more lamps, `scenes/room` with
three lamps, and `scenes/lamps` with 1000 lamps, at {data['samples']} samples per pixel. The images of `first.xml` have {SCENES[0][2]}x{SCENES[0][2] * 2 // 3}
pixels, and the others {SCENES[1][2]}x{SCENES[1][2] * 2 // 3}. The values are medians of {data['runs']} pairs of alternating renders, on {data['machine']['processor']}, at commit
{" or ".join(sorted({row["commit"][:10] for row in data["rows"]}))}. The goal is at most {GOAL}. Written by `/usr/bin/python3 validation/light_groups.py`. Raw values:
[light_groups.json](light_groups.json).

| scene | integrator | filter of the film | ratio | range | seconds without groups |
|---|---|---|---|---|---|"""]
    lines += ["| `{}` | `{}` | `{}` | {:.3f} | {:.3f} to {:.3f} | {:.2f} |".format(
        row["scene"], row["integrator"], row["filter"], row["ratio"], *row["range"],
        statistics.median(without for _, without in row["seconds"])) for row in data["rows"]]
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--runs", type=int, default=7)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--integrators", nargs="+", choices=INTEGRATORS, default=INTEGRATORS)
    parser.add_argument("--output", type=pathlib.Path, default=ROOT / "validation/numbers")
    options = parser.parse_args()
    data = {"machine": machine(), "runs": options.runs, "samples": options.spp, "rows": []}
    file = options.output / "light_groups.json"
    if set(options.integrators) < set(INTEGRATORS):
        rows = json.loads(file.read_text(encoding="utf-8"))["rows"]
        data["rows"] = [row for row in rows if row["integrator"] not in options.integrators]
    with tempfile.TemporaryDirectory() as folder:
        for scene in SCENES:
            for integrator in options.integrators:
                for film_filter in FILTERS:
                    data["rows"].append(measure(options, pathlib.Path(folder), *scene, integrator, film_filter))
                    print("{scene:9} {integrator:10} {filter:9} {ratio:.3f}".format(**data["rows"][-1]), flush=True)
    names = [name for name, *_ in SCENES]
    data["rows"].sort(key=lambda row: (names.index(row["scene"]), INTEGRATORS.index(row["integrator"])))
    file.write_text(json.dumps(data) + "\n", encoding="utf-8")
    (options.output / "light_groups.md").write_text(page(data), encoding="utf-8")


if __name__ == "__main__":
    main()
