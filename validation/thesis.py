"""Repeats the experiments of chapter 5 of Åkerlund 2008, and writes a page. See thesis.sh."""
import argparse
import json
import pathlib
import tempfile

import thesis_figures as figures
from program import ROOT, commit, machine
from thesis_page import write_page, write_tables
from thesis_runs import SCENES, Renderer, compare, sweep


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=pathlib.Path, required=True)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--output", type=pathlib.Path)
    options = parser.parse_args()
    output = options.output or ROOT / ("out/thesis" if options.quick else "validation/thesis")
    output.mkdir(parents=True, exist_ok=True)
    data = {"machine": machine(), "commit": commit(), "quick": options.quick, "scenes": {}}
    pictures, compared = {}, {}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        render = Renderer(options.build, folder, options.quick)
        render("hebe", "clustered", width=32, height=32)  # fills the page cache
        for scene in SCENES:
            numbers, pictures[scene] = compare(render, scene)
            numbers["sweeps"] = sweep(render, scene, pictures[scene]["groundtruth"])
            data["scenes"][scene] = numbers
            figures.comparison(output / f"compare-{scene}.jpg", numbers, pictures[scene])
            compared[scene] = figures.FIGURE.get(scene)
        data["inspection"] = figures.inspection(render, folder, output)
    figures.overview(output / "figure-5.1.jpg", pictures)
    figures.sweeps(output / "sweeps.png", data)
    (output / "numbers.json").write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    write_tables(output, data)
    write_page(output, data, compared)
    render.say(f"wrote {output / 'README.md'}")


if __name__ == "__main__":
    main()
