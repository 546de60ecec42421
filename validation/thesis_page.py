"""The page of validation/thesis.py: tables from the numbers, and remarks written by hand."""
import csv

from program import ROOT
from thesis_runs import SCENES

REMARKS = ROOT / "validation/thesis_remarks.md"
THESIS_MACHINE = "Intel Xeon Quad-Core 2.0 GHz, GeForce 8800 GTS, Windows XP SP1"
NAMES = {"joint": "joint", "brdf": "BRDF", "luminance": "luminance",
         "luminance_equal_time": "luminance, equal time"}
STAGES = ("primary", "importance", "choose", "shadow", "evaluate")


def table(head, rows):
    lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
    return lines + [f"| {' | '.join(row)} |" for row in rows] + [""]


def million(count):
    return f"{count / 1e6:.1f}"


def errors(found):
    return [f"{found['relmse']:.3g}", f"{found['trimmed']:.3g}"]


def seconds_table(data):
    rows = []
    for scene, numbers in data["scenes"].items():
        for name, mode in numbers["modes"].items():
            stages = mode["stage_seconds"]
            once = stages.get("light points", 0) + stages.get("tree", 0)
            rows.append([scene, f"{NAMES[name]} {mode['samples']}",
                         f"{mode['width']}x{mode['height']}",
                         million(mode["rays"].get("shadow", 0)),
                         million(mode["rays"].get("lobe", 0)),
                         f"{mode['processor_seconds']:.2f}", f"{mode['render_seconds']:.2f}",
                         f"{once:.3f}"] + [f"{stages.get(s, 0):.2f}" for s in STAGES])
    return table(["scene", "importance, samples", "pixels", "shadow rays [million]",
                  "lobe rays [million]", "processor time [s]", "render [s]", "points and tree", *STAGES], rows)


def thesis_table(data):
    rows = []
    for scene, numbers in data["scenes"].items():
        thesis = SCENES[scene]["thesis"]
        if not thesis:
            continue
        ours = numbers["modes"]
        row = [scene, thesis["pixels"],
               f"{ours['joint']['width'] * ours['joint']['height'] / 1e3:.1f}k"]
        for mode in ("joint", "luminance", "brdf"):
            seconds = ours[mode]["render_seconds"]
            row.append(f"{thesis[mode]:.1f} / {seconds:.2f} ({thesis[mode] / seconds:.0f}x)")
        row.append(f"{thesis['equal']} / {ours['luminance_equal_time']['samples']}")
        rows.append(row)
    return table(["scene", "pixels, thesis", "pixels, here", "joint [s], thesis / here",
                  "luminance [s]", "BRDF [s]", "samples by luminance in joint's time"], rows)


def error_table(data):
    rows = []
    for scene, numbers in data["scenes"].items():
        for name, mode in numbers["modes"].items():
            rows.append([scene, f"{NAMES[name]} {mode['samples']}"]
                        + errors(mode["error_to_groundtruth"]) + errors(mode["error_to_truth"]))
        rows.append([scene, "*groundtruth*", "0", "0"]
                    + errors(numbers["groundtruth"]["error_to_truth"]))
        rows.append([scene, f"*the truth itself* ({numbers['truth']['integrator']}, "
                     f"{numbers['truth']['samples']} samples)", "", ""]
                    + errors(numbers["truth"]["own_error"]))
    return table(["scene", "importance, samples", "relMSE to groundtruth", "trimmed",
                  "relMSE to the truth", "trimmed"], rows)


def inspection_table(found):
    rows = [[NAMES[m], str(f["clusters"]), str(f["possible"]), str(f["drawn"]),
             str(f["met_by_lobe_rays"]), f"{100 * f['share_of_the_likeliest_16']:.0f} %"]
            for m, f in found.items() if isinstance(f, dict)]
    return table(["importance", "clusters", "of probability above 0", "drawn from",
                  "met by lobe rays", "share of the likeliest 16"], rows)


def write_csv(path, head, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(head)
        writer.writerows(rows)


def write_tables(output, data):
    """The numbers of table 5.1 and of the sweeps, for other programs."""
    rows, points = [], []
    for scene, numbers in data["scenes"].items():
        for name, m in numbers["modes"].items():
            rows.append([scene, name, m["samples"], m["width"], m["height"],
                         m["rays"].get("shadow", 0), m["rays"].get("lobe", 0), m["render_seconds"],
                         *(m["stage_seconds"].get(s, 0) for s in STAGES),
                         *m["error_to_groundtruth"].values(), *m["error_to_truth"].values()])
        for name, runs in numbers["sweeps"].items():
            points += [[scene, name, r["value"], r["seconds"], r["relmse"], r["trimmed"]]
                       for r in runs]
    write_csv(output / "table-5.1.csv",
              ["scene", "importance", "samples", "width", "height", "shadow_rays", "lobe_rays",
               "render_seconds", *(f"{s}_seconds" for s in STAGES), "relmse_groundtruth",
               "trimmed_groundtruth", "relmse_truth", "trimmed_truth"], rows)
    write_csv(output / "sweeps.csv",
              ["scene", "parameter", "value", "seconds", "relmse", "trimmed"], points)


def write_page(output, data, figures):
    """README.md; `figures`: the scenes that have a figure of comparison, with its number."""
    machine = data["machine"]
    remarks = REMARKS.read_text(encoding="utf-8").rstrip()
    first = next(iter(data["scenes"].values()))
    lines = [
        "# The thesis's results again", "",
        "What chapter 5 of Åkerlund 2008 shows, by this program with its own scenes; made by "
        f"`sh validation/thesis.sh` on {machine['processor']}, {machine['cores']} cores, at commit "
        f"{data['commit'][:10]}. Raw numbers: [numbers.json](numbers.json), "
        "[table-5.1.csv](table-5.1.csv), [sweeps.csv](sweeps.csv).", ""]
    if data["quick"]:
        lines += ["**A small form, which only proves that the command works.**", ""]
    lines += [
        "As in the thesis: one camera ray a pixel, 128 shadow rays, 32,768 light points, 512 "
        "clusters, 32 lobe rays, random numbers without structure, Phong's and Ward's materials, "
        "one bounce in box and plate. "
        "relMSE is mean[(I - R)² / (R² + 0.01 mean(R)²)]; *trimmed* is the same without the worst "
        "0.1 % of the pixels.", "",
        remarks, "",
        "## Table 5.1: time", "",
        f"The thesis's machine: {THESIS_MACHINE}. Ours has {first['modes']['joint']['threads']} "
        "threads.", ""]
    lines += thesis_table(data)
    lines += ["Where it goes, in seconds of wall-clock time. Processor time is that of the whole "
              "program, over all threads, and what *equal time* is about. Lobe rays meet the "
              "clusters' boxes, and not the scene.", ""]
    lines += seconds_table(data)
    lines += ["## Error", "",
              "At the smaller size of the pictures below. *groundtruth* uses each light point once, "
              "from the same camera rays: what differs from it is the choice of points alone. The "
              "truth is converged and antialiased: where groundtruth itself differs from it is what "
              "no choice can mend, one camera ray a pixel and points in place of light. The "
              "difference of two independent halves tells how far the truth is to be trusted.", ""]
    lines += error_table(data)
    lines += ["## Figure 5.1", "", "![Joint importance and groundtruth](figure-5.1.jpg)", "",
              "## Figures 5.2 to 5.5", "",
              "Below each picture, four times its difference from groundtruth: red is too bright, "
              "blue too dark.", ""]
    for scene, number in figures.items():
        lines += [f"{scene} ({'figure ' + number if number else 'not in the thesis'})", "",
                  f"![{scene}](compare-{scene}.jpg)", ""]
    found = data["inspection"]
    lines += ["## Figure 5.6: where a pixel's samples go", "",
              f"grace, pixel {found['pixel']} of {found['width']}x{found['height']}, on the "
              "teapot: `kinome --inspect`. Clusters are outlined; samples that see their light are "
              "red, those in shadow blue. Every cluster: "
              "[luminance](figure-5.6-luminance.csv), [BRDF](figure-5.6-brdf.csv), "
              "[joint](figure-5.6-joint.csv).", ""]
    lines += inspection_table(found)
    lines += ["![Samples by luminance, BRDF and both](figure-5.6.jpg)", "",
              "## Clusters and lobe rays", "",
              "Joint importance, 128 samples, error against groundtruth; the product with the time "
              "tells which setting is worth its cost.", "", "![Sweeps](sweeps.png)", ""]
    (output / "README.md").write_text("\n".join(lines), encoding="utf-8")
