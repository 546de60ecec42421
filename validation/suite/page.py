"""validation/report/index.html: one file, which contains all its images."""
import html

from . import analysis, plots
from . import tables_of_results as tables
from .others import BUSY
from .tables import explanation

STYLE = """
:root { color-scheme: light; --line: #d8d8d8; --bad: #b30000; --good: #1a7a34 }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 1240px; margin: 2rem auto; padding: 0 1rem;
       color: #1b1b1b; background: #fff }
h1 { font-size: 1.7rem } h2 { margin-top: 2.4rem; border-bottom: 1px solid var(--line) }
.wide { overflow-x: auto } table { border-collapse: collapse; font-size: 13px; margin: .6rem 0 }
th, td { padding: .22rem .5rem; border-bottom: 1px solid var(--line); text-align: left;
         white-space: nowrap; font-variant-numeric: tabular-nums }
th { background: #f4f4f4; white-space: normal; vertical-align: bottom }
td.fail { color: var(--bad); font-weight: 700 }
td.pass, td.win { color: var(--good) } td.lose { color: var(--bad) }
img { max-width: 100%; image-rendering: auto } .crops { display: flex; flex-wrap: wrap; gap: 12px }
figure { margin: 0; width: 160px } figcaption { font-size: 11.5px; line-height: 1.3 }
figure img { image-rendering: pixelated }
.thumb { height: 40px; vertical-align: middle; image-rendering: pixelated }
.note { color: #555; margin: .15rem 0; font-size: 13px } .problem { color: var(--bad) }
details { margin: .5rem 0 }
"""

CLUSTERED = (
    "<b>clustered</b> with joint, luminance or brdf converges to the light of its light points, not to the "
    "exact light. It is therefore compared, for each seed, with <b>groundtruth</b>, which uses each of the "
    "same points exactly once. Its difference from Mitsuba is the error of representing the light by points, "
    "below which its curve doesn't fall. <b>clustered product</b> uses the exact light, and is compared with "
    "Mitsuba.")
LDSAMPLER = (
    "Mitsuba's ldsampler is biased for paths with several bounces (references/README.md). The error of its "
    "curves may not fall below this bias. All references are made with multijitter.")


def cell(text):
    kind = {"FAIL": "fail", "pass": "pass"}.get(text)
    kind = kind or ("win" if text.endswith("(faster)") else
                    "lose" if text.endswith("(slower)") else "")
    return f'<td class="{kind}">{html.escape(text)}</td>' if kind else \
        f"<td>{html.escape(text)}</td>"


def table(head, rows, pictures=None):
    """Formats a table. pictures: a data URL for each row, for an additional last column."""
    lines = ["<div class=\"wide\"><table><thead><tr>",
             *(f"<th>{html.escape(h)}</th>" for h in head),
             "<th>ours, reference, difference</th>" if pictures else "", "</tr></thead><tbody>"]
    for i, row in enumerate(rows):
        lines.append("<tr>" + "".join(cell(text) for text in row))
        if pictures:
            lines.append(f'<td><img class="thumb" loading="lazy" src="{pictures[i]}" '
                         f'alt="{html.escape(row[0])}, {html.escape(row[1])}"/></td>')
        lines.append("</tr>")
    return "".join(lines) + "</tbody></table></div>\n"


def paragraph(text, kind=""):
    return f'<p class="{kind}">{text}</p>\n' if kind else f"<p>{text}</p>\n"


def correctness_section(data):
    rows = data["rows"]
    red = [row for row in rows if not row["passed"]]
    parts = ["<h2>Correctness</h2>\n", paragraph(
        f"{len(rows)} comparisons, {len(red)} failed. Their total rate of false alarms is "
        f"{100 * data['family_alpha']:g} %. <i>t</i> is Welch's t of the mean of the image, for the worst "
        "channel. <i>p</i> is corrected for the number of values. A bias of the given size would be found with "
        "a probability of 90 %. Phong and Ward are compared with BSDFs written in Python for Mitsuba, by the "
        "formulas of Mitsuba 0.6."), paragraph(CLUSTERED)]
    for why in dict.fromkeys(filter(None, map(explanation, red))):
        of = [f"{row['scene']}, {row['method']}" for row in red if explanation(row) == why]
        parts.append(paragraph(html.escape(f"Failed for a known reason: {'; '.join(of)}: {why} (evidence: "
                                           "validation/references/README.md).")))
    twins = tables.repeated(rows)
    if twins:
        parts.append(paragraph(
            f"<b>=</b> marks a row with the same values as a row above with another method, {twins} in all. "
            "The two methods don't differ in that scene, so the row gives no further evidence."))
    parts.append(table(*tables.correctness(rows), [row["picture"] for row in rows]))
    notes = [f"{row['scene']}, {row['method']}: {note}" for row in rows for note in row["notes"]]
    if notes:
        parts.append(f"<details><summary>{len(notes)} notes</summary>")
        parts += [paragraph(html.escape(note), "note") for note in notes]
        parts.append("</details>\n")
    return "".join(parts)


def reference_text(reference):
    count = reference["masked_pixels"]
    masked = (f". {reference['not_finite']} of its values were NaN or Inf, and {count} pixels are "
              "masked") if count else ""
    return (f"Reference: Mitsuba's {reference['integrator']} ({reference['variant']}), "
            f"{reference['seeds']} × {reference['samples_used']} samples, "
            f"{reference['sampler']}{masked}. Its own noise is a relMSE of "
            f"{reference['own_error']:.2g}, which is subtracted.")


def scene_section(name, entry, found, trimmed, load_picture):
    size = "×".join(str(n) for n in entry["size"])
    parts = [f'<h3 id="{html.escape(name)}">{html.escape(name)} ({html.escape(entry["group"])}, '
             f"{size})</h3>\n", paragraph(html.escape(reference_text(entry["reference"])))]
    picture = plots.error_over_time(found, trimmed, entry["reference"]["own_error"])
    parts.append(f'<img src="{picture}" alt="relMSE over seconds, {html.escape(name)}"/>\n')
    parts.append(table(*tables.renderers(found, trimmed)))
    parts += [paragraph(f"{html.escape(name)}: {one['not_finite']} pixels of all its renders were "
                        "NaN or Inf, and are left out of its error.", "problem")
              for name, one in found.items() if one["not_finite"]]
    goal, crops = plots.equal_time(entry, found, load_picture)
    if crops:
        parts.append(paragraph(f"Images after about {goal:.2g} s, or with the fewest samples if these take "
                               "longer, in the region of the largest differences:"))
        parts.append('<div class="crops">' + "".join(
            f'<figure><img src="{url}" alt="crop"/><figcaption>{html.escape(label)}</figcaption>'
            "</figure>" for label, url in crops) + "</div>\n")
    parts += ["<details><summary>With start-up and compilation</summary>",
              table(*tables.with_startup(entry, found)), "</details>\n"]
    parts += [f"<details><summary>All {len(entry['tried'])} measurements of Mitsuba's "
              "configurations</summary>", table(*tables.tried(entry)), "</details>\n"]
    return "".join(parts)


def benchmark_section(scenes, load_picture):
    found = {name: analysis.summary(scenes[name]) for name in tables.ordered(scenes)}
    parts = ["<h2>Time against error</h2>\n", paragraph(
        "Times are wall times of rendering by each program's own clock, without start-up, loading and "
        "compilation, which have a separate table. For Cycles, they include the whole render and writing the "
        "file, because it has no other clock. Renderers take turns, with the same number of threads. Values "
        "are medians over all seeds, and bars are quartiles. relMSE is "
        "mean[((I − R)² − var R) / (R² + 0.01 mean(R)²)]."), paragraph(
        "<b>~</b> marks times that are extrapolated beyond the last point. Peers are extrapolated by more "
        "than a factor of ten with a slope of -1 or steeper, which is in their favour. <b>≤</b> means that "
        "the fewest samples already reach the error. <b>never</b> means that the curve is flat. <b>far</b> "
        "means more than ten times the time of the last point, or a hundred times for peers. <b>noise</b> "
        "means that the error is below the noise of the reference."), paragraph(
        "Ratios are the best peer's seconds divided by ours: above 1, Kinome is faster. <b>peer only</b> "
        "means that Kinome doesn't reach the error. Such scenes aren't included in the mean."),
        paragraph(LDSAMPLER)]
    for target in analysis.TARGETS:
        parts += [f"<h3>To a relMSE of {target:g}</h3>\n", table(*tables.overview(found, target))]
    parts += [f"<h3>Kinome's integrators and the best peer, at {tables.MIDDLE:g}</h3>\n",
              table(*tables.by_renderer(found))]
    trimmed = {name: analysis.summary(scenes[name], "trimmed") for name in found}
    parts += ["<h3>The same without the worst 0.1 % of the values of each image</h3>\n",
              paragraph("If light is hard to find, single bright pixels dominate the relMSE."),
              table(*tables.overview(trimmed)), table(*tables.by_renderer(trimmed))]
    for name, one in found.items():
        parts.append(scene_section(name, scenes[name], one, trimmed[name], load_picture))
    return "".join(parts)


def machine_text(data):
    machines = {f"{e['machine']['processor']}, {e['machine']['cores']} cores, "
                f"{e['machine']['system']}" for e in data}
    commits = {e["commit"][:10] for e in data}
    text = f"On {'; '.join(sorted(machines))}; commit {', '.join(sorted(commits))}."
    # The rows may come from several runs, each of a few scenes.
    programs = {row.get("program") for e in data for row in e.get("rows", [e])}
    timed = [(e["cores_of_others"], e["machine"]["cores"]) for e in data if "cores_of_others" in e]
    busy = [(others, cores) for others, cores in timed if others > BUSY * cores]
    if busy:
        others, cores = max(busy, key=lambda pair: pair[0] / pair[1])
        text += (f" Other processes used the machine: in {len(busy)} of {len(timed)} scenes, they had up to "
                 f"{others:.1f} of {cores} cores, so the times are too long.")
    if len(programs) > 1:
        text += " The rows were measured with different versions of the program."
    return text


def page(correctness, benchmark, problems, load_picture, quick):
    """Returns the whole page. Either part may be None."""
    entries = ([correctness] if correctness else []) + list((benchmark or {}).values())
    parts = ["<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>"
             "<meta name=\"viewport\" content=\"width=device-width\"/>"
             f"<title>Kinome against Mitsuba 3</title><style>{STYLE}</style></head><body>\n"
             "<h1>Kinome against Mitsuba 3</h1>\n",
             paragraph(html.escape(machine_text(entries)))]
    if quick:
        parts.append(paragraph("<b>This is the small form, which only checks that the command works.</b>"))
    if problems:
        items = [f'<li class="problem">{html.escape(line)}</li>' for line in problems]
        parts += ["<h2>Missing results</h2>\n<ul>", *items, "</ul>\n"]
    if correctness:
        parts.append(correctness_section(correctness))
    if benchmark:
        parts.append(benchmark_section(benchmark, load_picture))
    return "".join(parts) + "</body></html>\n"
