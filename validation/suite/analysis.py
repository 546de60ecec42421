"""What follows from times and errors. Only arithmetic: no files, no renderers."""
import math
import statistics

TARGETS = (1e-2, 1e-3, 1e-4)
# No larger counts are rendered of who is well below the least target: peers; ours, whose slope is
# wanted farther.
ENOUGH = {"peer": TARGETS[-1] / 3, "ours": 5e-6}
BEHIND = 1.5  # times the best peer's seconds, to every target: such a peer is not among the first
# A curve flatter than this has stopped to converge: what lies beyond its end is never reached.
FLAT = -0.25
REACH = 10  # how many times longer than the last point a curve may be drawn on
# A peer that doesn't learn goes on as it began. Beyond REACH it is given a slope of -1 or its own,
# whichever is steeper: what that tells of its time is, if anything, too short.
PEER_REACH = 100


def quartiles(values):
    """(first quartile, median, third)"""
    ordered = sorted(values)
    if len(ordered) == 1:
        return ordered[0], ordered[0], ordered[0]
    low, middle, high = statistics.quantiles(ordered, n=4, method="inclusive")
    return low, middle, high


def curve(points, measure="relmse"):
    """Of [{"samples", "runs": [{"seconds", measure}]}]: medians and quartiles, by samples.
    `measure` may also be "trimmed"; the result calls it "relmse" all the same."""
    found = []
    for point in points:
        seconds = quartiles([run["seconds"] for run in point["runs"]])
        errors = quartiles([run[measure] for run in point["runs"]])
        found.append({"samples": point["samples"], "seconds": seconds[1], "relmse": errors[1],
                      "seconds_quartiles": [seconds[0], seconds[2]],
                      "relmse_quartiles": [errors[0], errors[2]]})
    return sorted(found, key=lambda point: point["samples"])


def can_tell(error, own_error):
    """Can a reference of that noise tell a picture of this error from a perfect one?"""
    return error > least(own_error)


def least(own_error):
    return max(0.5 * own_error, 0)


def trusted(points, own_error):
    """Without those that the reference can't tell from a perfect picture."""
    return [p for p in points if can_tell(p["relmse"], own_error) and p["seconds"] > 0]


def bounded(points, own_error):
    """Those that are trusted, and the first after them with the most that its error can be: by then
    all targets that the reference can tell are met."""
    good = trusted(points, own_error)
    after = [p for p in points if good and p["seconds"] > good[-1]["seconds"]]
    return good + [p | {"relmse": least(own_error)} for p in after[:1] if own_error > 0]


def slope(points):
    """Of log relMSE against log seconds by least squares over all points; None of fewer than 2."""
    if len(points) < 2:
        return None
    x = [math.log(p["seconds"]) for p in points]
    y = [math.log(p["relmse"]) for p in points]
    mean_x, mean_y = statistics.fmean(x), statistics.fmean(y)
    spread = sum((a - mean_x) ** 2 for a in x)
    if spread == 0:
        return None
    return sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y)) / spread


def seconds_to(points, target, reach=REACH):
    """(seconds, kind): kind is "measured" between two points, "extrapolated" beyond the last (along
    the last three; farther than REACH with a slope of at least -1), "at most" before the first.
    Seconds are None where the curve has gone flat ("never"), would take more than `reach` times the
    last point's ("beyond"), or has too few points ("unknown")."""
    if not points:
        return None, "unknown"
    if points[0]["relmse"] <= target:
        return points[0]["seconds"], "at most"
    for a, b in zip(points, points[1:]):
        if b["relmse"] <= target:
            return along(a, b, target), "measured"
    tail = points[-3:]
    falls = slope(tail)
    if falls is None:
        return None, "unknown"
    if falls > FLAT:
        return None, "never"
    centre = {key: math.exp(statistics.fmean(math.log(p[key]) for p in tail))
              for key in ("seconds", "relmse")}
    seconds = centre["seconds"] * (target / centre["relmse"]) ** (1 / falls)
    near = REACH * points[-1]["seconds"]
    if seconds > near:
        sooner = centre["seconds"] * (target / centre["relmse"]) ** (1 / min(falls, -1))
        seconds = max(sooner, near)
        if reach <= REACH or seconds > reach * points[-1]["seconds"]:
            return None, "beyond"
    return seconds, "extrapolated"


def along(a, b, target):
    """Seconds at that error on the line through two points, in logarithms."""
    share = math.log(target / a["relmse"]) / math.log(b["relmse"] / a["relmse"])
    return math.exp(math.log(a["seconds"]) + share * math.log(b["seconds"] / a["seconds"]))


def work(row):
    """relMSE x seconds, without the worst 0.1 % of the values, or else a bright pixel decides. An
    error below what can be told (zero or less) counts as a billionth."""
    return max(row["trimmed"], 1e-9) * row["seconds"]


def efficiency(points):
    """1 / (relMSE x seconds) of the point that took longest."""
    last = max(points, key=lambda p: p["seconds"], default=None)
    return None if last is None else 1 / (last["relmse"] * last["seconds"])


def geometric_mean(values):
    return math.exp(statistics.fmean(math.log(v) for v in values)) if values else None


def summary(entry, measure="relmse"):
    """All figures of one scene: {renderer: {...}} of its curves. For `measure` see curve."""
    own = entry["reference"]["own_error"]
    found = {}
    for name, renderer in entry["curves"].items():
        points = curve(renderer["points"], measure)
        good, reached = trusted(points, own), bounded(points, own)
        reach = REACH if renderer["kind"] == "ours" else PEER_REACH
        shares = [run["embree_share"] for p in renderer["points"] for run in p["runs"]
                  if run.get("embree_share") is not None]
        found[name] = {"kind": renderer["kind"], "points": points, "slope": slope(good),
                       "efficiency": efficiency(good),
                       "seconds_to": {t: seconds_to(reached, t, reach) if can_tell(t, own)
                                      else (None, "noise") for t in TARGETS},
                       "not_finite": sum(run["not_finite"] for p in renderer["points"]
                                         for run in p["runs"]),
                       "embree_share": statistics.median(shares) if shares else None}
    return found


def best(found, kind, target):
    """(renderer, seconds, kind of time) that gets there first, or None."""
    reached = [(r["seconds_to"][target][0], name) for name, r in found.items()
               if r["kind"] == kind and r["seconds_to"][target][0] is not None]
    if not reached:
        return None
    seconds, name = min(reached)
    return name, seconds, found[name]["seconds_to"][target][1]


def enough(kind, own_error):
    """The error below which who is of that kind needs no larger counts."""
    return max(ENOUGH[kind], least(own_error))


def behind(entry):
    """Names of the peers that BEHIND is true of, by what is measured so far, without the worst
    0.1 % of the values. `entry`: as summary takes it."""
    peers = {name: one["seconds_to"] for name, one in summary(entry, "trimmed").items()
             if one["kind"] == "peer"}
    first = set()
    for target in TARGETS:
        reached = {name: to[target][0] for name, to in peers.items() if to[target][0] is not None}
        first |= {name for name, seconds in reached.items()
                  if seconds < BEHIND * min(reached.values())}
    return set(peers) - first if first else set()


def ratio(ours, peer):
    """How many times sooner ours is there: (ratio, kind), each of the two given as seconds_to gives
    it. kind is "measured", "extrapolated" (or of two bounds), "at most" or "at least" where one of
    the two is there by its fewest samples already; with None, who gets there at all: "ours only",
    "peer only" or "neither"."""
    if ours[0] is None or peer[0] is None:
        return None, ("ours only" if ours[0] is not None else
                      "peer only" if peer[0] is not None else "neither")
    kinds = {ours[1], peer[1]}
    if kinds == {"measured"}:
        kind = "measured"
    elif kinds == {"measured", "at most"}:
        kind = "at least" if ours[1] == "at most" else "at most"
    else:
        kind = "extrapolated"
    return peer[0] / ours[0], kind


def ratios(scenes, target):
    """Each of ours against the best peer: {renderer: {scene: what ratio() says}}. `scenes`: {name:
    summary}."""
    table = {}
    for scene, found in scenes.items():
        peer = best(found, "peer", target)
        for name, renderer in found.items():
            if renderer["kind"] == "ours":
                table.setdefault(name, {})[scene] = ratio(
                    renderer["seconds_to"][target], peer[1:] if peer else (None, "unknown"))
    return table


def finalists(tried, count, biased=()):
    """Names of the configurations to measure in full: the best `count` at the most samples that
    were tried, the best at each other number of samples (what is slow to start may win only in the
    long run), and the best whose sampler isn't one of the `biased`, whose error ends in a floor.

    By their work."""
    ranked = sorted(tried, key=work)
    names = []
    for samples in sorted({row["samples"] for row in tried}, reverse=True):
        here = [row for row in ranked if row["samples"] == samples]
        chosen = here[:1] if names else here[:count] + [
            row for row in here if row["sampler"] not in biased][:1]
        names += [row["name"] for row in chosen]
    return list(dict.fromkeys(names))
