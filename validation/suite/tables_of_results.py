"""Tables of the report as (heading row, rows of text), which page.py and summary.py format."""
from . import analysis
from .tables import SCENES

MARKS = {"measured": "", "extrapolated": "~", "at most": "≤ ", "at least": "≥ "}
WORDS = {"never": "never", "beyond": "far", "unknown": "–", "noise": "noise"}
MIDDLE = 1e-3  # target error of the ratios


def significant(value, digits=3):
    return "–" if value is None else f"{value:.{digits}g}"


def percent(value):
    return "–" if value is None else f"{100 * value:.2g} %"


def seconds(found):
    value, kind = found
    return WORDS[kind] if value is None else MARKS[kind] + significant(value)


def ordered(names):
    """Returns the names of small scenes in alphabetical order, then those of big scenes as in
    tables.SCENES."""
    place = {scene.name: i for i, scene in enumerate(SCENES)}
    return sorted(names, key=lambda name: (place.get(name, -1), name))


def figures(row):
    """Returns values of a row that two different images hardly ever share."""
    return (row["scene"], row["truth"], row["tests"]["image"]["t"], row["tests"]["pixels"]["p"])


def repeated(rows):
    """Returns the number of rows with the same values as a row before them."""
    return len(rows) - len({figures(row) for row in rows})


def correctness(rows):
    head = ["scene", "integrator", "against", "verdict", "t image", "p image", "p tiles",
            "p pixels", "finds a bias of", "HDR-FLIP"]
    masked = any(row["masked"] for row in rows)
    head += ["masked"] if masked else []
    table, known = [], set()
    for row in rows:
        tests = row["tests"]
        twin = figures(row) in known
        known.add(figures(row))
        table.append([
            row["scene"], row["method"] + (" =" if twin else ""),
            "Mitsuba" if row["truth"] == "mitsuba" else "groundtruth",
            "pass" if row["passed"] else "FAIL", f"{tests['image']['t']:+.2f}",
            *(significant(tests[name]["p"], 2) for name in ("image", "tiles", "pixels")),
            percent(tests["image"]["detectable"]), significant(row["flip"], 2),
            *([str(row["masked"] or "")] if masked else [])])
    return head, table


def renderers(found, trimmed):
    """Returns the table of one scene. `trimmed`: the same as `found` for trimmed errors."""
    head = ["renderer", "slope", "efficiency"]
    head += [f"s to {target:g}" for target in analysis.TARGETS]
    head += [f"ratio at {MIDDLE:g}", f"trimmed: s to {MIDDLE:g}", "in Embree"]
    ratios = analysis.ratios({"": found}, MIDDLE)
    rows = []
    for name, one in found.items():
        ratio = ratios.get(name, {}).get("", (None, "neither"))
        rows.append([name, significant(one["slope"]), significant(one["efficiency"]),
                     *(seconds(one["seconds_to"][t]) for t in analysis.TARGETS),
                     verdict(*ratio),
                     seconds(trimmed[name]["seconds_to"][MIDDLE]),
                     "–" if one["embree_share"] is None else percent(one["embree_share"])])
    return head, rows


def ratio_text(ratio, kind):
    if ratio is None:
        return "–" if kind == "neither" else kind
    return f"{MARKS[kind]}{ratio:.2f}"


def verdict(ratio, kind="measured"):
    """Formats a ratio and who is faster. Kinome is slower if it is below 1. If a bound doesn't decide this,
    returns only the ratio."""
    text = ratio_text(ratio, kind)
    if ratio is None:
        return {"ours only": f"{text} (faster)", "peer only": f"{text} (slower)"}.get(kind, text)
    if (kind == "at most" and ratio >= 1) or (kind == "at least" and ratio < 1):
        return text
    return f"{text} (slower)" if ratio < 1 else f"{text} (faster)"


def mean_of(ratios):
    """Returns the geometric mean of results of analysis.ratio() in the same form, or None if there are
    none."""
    measured = all(kind == "measured" for _, kind in ratios)
    return (analysis.geometric_mean([value for value, _ in ratios]),
            "measured" if measured else "extrapolated") if ratios else None


def overview(scenes, target=MIDDLE):
    """Returns the table of our best renderer and the best peer on each scene, with the geometric mean.
    `scenes`: {name: summary}."""
    head = ["scene", "best of ours", f"s to {target:g}", "best peer", f"s to {target:g}",
            "peer / ours"]
    rows, ratios = [], []
    for name, found in scenes.items():
        ours, peer = (analysis.best(found, kind, target) for kind in ("ours", "peer"))
        ratio = analysis.ratio(*(one[1:] if one else (None, "unknown") for one in (ours, peer)))
        if ratio[0] is not None:
            ratios.append(ratio)
        rows.append([name, *(text for one in (ours, peer) for text in
                             ((one[0], MARKS[one[2]] + significant(one[1])) if one
                              else ("–", "–"))),
                     verdict(*ratio)])
    mean = mean_of(ratios)
    if mean:
        count = f"{len(ratios)}" if len(ratios) == len(rows) else f"{len(ratios)} of {len(rows)}"
        rows.append([f"geometric mean of {count}", "", "", "", "", verdict(*mean)])
    return head, rows


def by_renderer(scenes, target=MIDDLE):
    """Returns the table of the ratios of our renderers to the best peer by scene, with the geometric mean."""
    table = analysis.ratios(scenes, target)
    head = ["", *scenes, "geometric mean"]
    rows = []
    for name, found in table.items():
        known = [found[s] for s in scenes if s in found and found[s][0] is not None]
        mean = mean_of(known)
        partial = f" (of {len(known)})" if 0 < len(known) < len(scenes) else ""
        rows.append([name, *(ratio_text(*found[s]) if s in found else "–" for s in scenes),
                     f"{ratio_text(*mean)}{partial}" if mean else "–"])
    return head, rows


def with_startup(entry, found, target=MIDDLE):
    """Returns the table of start-up and compilation times, and of the seconds to `target` with them."""
    head = ["renderer", "when", "start-up [s]", f"s to {target:g} with it"]
    rows = []
    for row in entry["startup"]:
        value, kind = found[row["renderer"]]["seconds_to"][target] \
            if row["renderer"] in found else (None, "unknown")
        whole = (None if value is None else value + row["seconds"], kind)
        rows.append([row["renderer"], row["when"], significant(row["seconds"]), seconds(whole)])
    return head, rows


def tried(entry):
    """Returns the table of all tried configurations of Mitsuba, fastest first."""
    head = ["configuration", "samples", "s", "relMSE", "trimmed", "trimmed efficiency"]
    rows = sorted(entry["tried"], key=analysis.work)
    return head, [[row["name"], str(row["samples"]), significant(row["seconds"]),
                   significant(row["relmse"]), significant(row["trimmed"]),
                   significant(1 / (row["trimmed"] * row["seconds"]) if row["trimmed"] > 0
                               else None)] for row in rows]
