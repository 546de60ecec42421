"""Page of validation/thesis.py: tables of the measurements, and remarks written by hand."""
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
                  "luminance [s]", "BRDF [s]", "luminance samples in the time of joint"], rows)


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
    return table(["importance", "clusters", "with probability above 0", "with samples",
                  "hit by lobe rays", "probability of the most likely 16"], rows)


def write_csv(path, head, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(head)
        writer.writerows(rows)


def write_tables(output, data):
    """Writes the values of table 5.1 and of the sweeps as CSV files."""
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
    """Writes README.md. `figures`: {scene: number of its comparison figure in the thesis, or None}."""
    machine = data["machine"]
    remarks = REMARKS.read_text(encoding="utf-8").rstrip()
    first = next(iter(data["scenes"].values()))
    lines = [
        "# Results of the thesis, reproduced", "",
        "This page repeats the experiments of chapter 5 of Åkerlund 2008 with Kinome and its own scenes. "
        f"Written by `sh validation/thesis.sh` on {machine['processor']}, {machine['cores']} cores, at commit "
        f"{data['commit'][:10]}. Raw values: [numbers.json](numbers.json), "
        "[table-5.1.csv](table-5.1.csv), [sweeps.csv](sweeps.csv).", ""]
    if data["quick"]:
        lines += ["**This is the small form, which only checks that the command works.**", ""]
    lines += [
        "The settings are those of the thesis: one camera ray per pixel, 128 shadow rays, 32,768 light "
        "points, 512 clusters, 32 lobe rays, independent random numbers, the materials of Phong and Ward, "
        "and one bounce in box and plate. "
        "relMSE is mean[(I - R)² / (R² + 0.01 mean(R)²)]. *Trimmed* relMSE excludes the worst "
        "0.1 % of the pixels.", "",
        remarks, "",
        "## Table 5.1: time", "",
        f"The machine of the thesis was an {THESIS_MACHINE}. Ours has "
        f"{first['modes']['joint']['threads']} threads.", ""]
    lines += thesis_table(data)
    lines += ["The next table gives the time of each stage, in seconds of wall-clock time. Processor time "
              "is that of the whole program on all threads. *Equal time* means equal processor time. Lobe "
              "rays are intersected with the boxes of the clusters, not with the scene.", ""]
    lines += seconds_table(data)
    lines += ["## Error", "",
              "These errors are measured at the smaller size of the images below. *groundtruth* uses each "
              "light point once, with the same camera rays, so a difference from it is caused only by the "
              "selection of points. The truth is converged and antialiased. Groundtruth differs from it "
              "because of the one camera ray per pixel, and because points replace the light. No selection "
              "of points can reduce this difference. The error of the truth itself is estimated from the "
              "difference of two independent halves.", ""]
    lines += error_table(data)
    lines += ["## Figure 5.1", "", "![Joint importance and groundtruth](figure-5.1.jpg)", "",
              "## Figures 5.2 to 5.5", "",
              "Below each image is its difference from groundtruth, times four: red is too bright, "
              "blue is too dark.", ""]
    for scene, number in figures.items():
        lines += [f"{scene} ({'figure ' + number if number else 'not in the thesis'})", "",
                  f"![{scene}](compare-{scene}.jpg)", ""]
    found = data["inspection"]
    lines += ["## Figure 5.6: the samples of a pixel", "",
              f"The figure shows pixel {found['pixel']} of {found['width']}x{found['height']} in grace, on "
              "the teapot, by `kinome --inspect`. Clusters are outlined. Unoccluded samples are red, "
              "occluded ones blue. Tables of all clusters: "
              "[luminance](figure-5.6-luminance.csv), [BRDF](figure-5.6-brdf.csv), "
              "[joint](figure-5.6-joint.csv).", ""]
    lines += inspection_table(found)
    lines += ["![Samples by luminance, BRDF and both](figure-5.6.jpg)", "",
              "## Clusters and lobe rays", "",
              "The plots show the error of joint importance with 128 samples against groundtruth. The "
              "product of error and time shows which setting is most efficient.", "",
              "![Sweeps](sweeps.png)", ""]
    (output / "README.md").write_text("\n".join(lines), encoding="utf-8")
