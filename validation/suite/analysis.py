"""Computes results from times and errors. Uses no files and no renderers."""
import math
import statistics

TARGETS = (1e-2, 1e-3, 1e-4)
# Errors below which larger sample counts are skipped. Our curves are measured further, for their slopes.
ENOUGH = {"peer": TARGETS[-1] / 3, "ours": 5e-6}
BEHIND = 1.5  # a peer is behind if it needs this many times the best peer's seconds for every target
# A curve with a flatter slope has stopped converging. It never reaches targets beyond its end.
FLAT = -0.25
REACH = 10  # maximum extrapolated time, relative to that of the last point
# The same for peers, which don't learn and so keep converging. Beyond REACH they get their own slope or -1,
# whichever is steeper. This tends to underestimate their times.
PEER_REACH = 100


def quartiles(values):
    """Returns (first quartile, median, third quartile)."""
    ordered = sorted(values)
    if len(ordered) == 1:
        return ordered[0], ordered[0], ordered[0]
    low, middle, high = statistics.quantiles(ordered, n=4, method="inclusive")
    return low, middle, high


def curve(points, measure="relmse"):
    """Returns medians and quartiles by samples, from [{"samples", "runs": [{"seconds", measure}]}].
    `measure` may also be "trimmed", which is called "relmse" in the result."""
    found = []
    for point in points:
        seconds = quartiles([run["seconds"] for run in point["runs"]])
        errors = quartiles([run[measure] for run in point["runs"]])
        found.append({"samples": point["samples"], "seconds": seconds[1], "relmse": errors[1],
                      "seconds_quartiles": [seconds[0], seconds[2]],
                      "relmse_quartiles": [errors[0], errors[2]]})
    return sorted(found, key=lambda point: point["samples"])


def can_tell(error, own_error):
    """Returns whether an image with this error can be distinguished from a perfect image. `own_error`: error
    of the reference."""
    return error > least(own_error)


def least(own_error):
    return max(0.5 * own_error, 0)


def trusted(points, own_error):
    """Returns the points that can be distinguished from a perfect image."""
    return [p for p in points if can_tell(p["relmse"], own_error) and p["seconds"] > 0]


def bounded(points, own_error):
    """Returns the trusted points, and the first point after them with the upper bound of its error. At that
    point, all distinguishable targets are reached."""
    good = trusted(points, own_error)
    after = [p for p in points if good and p["seconds"] > good[-1]["seconds"]]
    return good + [p | {"relmse": least(own_error)} for p in after[:1] if own_error > 0]


def slope(points):
    """Returns the slope of log relMSE over log seconds by least squares, or None for fewer than 2
    points."""
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
    """Returns (seconds, kind) of the time to reach `target`. These are the kinds:

    measured: between two points.
    extrapolated: beyond the last point, along the last three. Beyond REACH, the slope is -1 or steeper.
    at most: the first point already reaches the target.
    never: the curve is flat; seconds are None.
    beyond: more than `reach` times the seconds of the last point; seconds are None.
    unknown: too few points; seconds are None.
    """
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
    """Returns the seconds at error `target` on the line through two points, in logarithms."""
    share = math.log(target / a["relmse"]) / math.log(b["relmse"] / a["relmse"])
    return math.exp(math.log(a["seconds"]) + share * math.log(b["seconds"] / a["seconds"]))


def work(row):
    """Returns relMSE x seconds. Uses the trimmed relMSE because single bright pixels would dominate the
    other. Errors of zero or less, which are below the reference's noise, count as 1e-9."""
    return max(row["trimmed"], 1e-9) * row["seconds"]


def efficiency(points):
    """Returns 1 / (relMSE x seconds) of the point with the longest time."""
    last = max(points, key=lambda p: p["seconds"], default=None)
    return None if last is None else 1 / (last["relmse"] * last["seconds"])


def geometric_mean(values):
    return math.exp(statistics.fmean(math.log(v) for v in values)) if values else None


def summary(entry, measure="relmse"):
    """Returns all results of a scene as {renderer: {...}}. For `measure` see curve()."""
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
    """Returns (renderer, seconds, kind of time) of the fastest renderer, or None."""
    reached = [(r["seconds_to"][target][0], name) for name, r in found.items()
               if r["kind"] == kind and r["seconds_to"][target][0] is not None]
    if not reached:
        return None
    seconds, name = min(reached)
    return name, seconds, found[name]["seconds_to"][target][1]


def enough(kind, own_error):
    """Returns the error below which larger sample counts are skipped, for renderers of that kind."""
    return max(ENOUGH[kind], least(own_error))


def behind(entry):
    """Returns the names of the peers that are behind in all trimmed measurements so far, see BEHIND.
    `entry`: as for summary()."""
    peers = {name: one["seconds_to"] for name, one in summary(entry, "trimmed").items()
             if one["kind"] == "peer"}
    first = set()
    for target in TARGETS:
        reached = {name: to[target][0] for name, to in peers.items() if to[target][0] is not None}
        first |= {name for name, seconds in reached.items()
                  if seconds < BEHIND * min(reached.values())}
    return set(peers) - first if first else set()


def ratio(ours, peer):
    """Returns (peer's seconds / our seconds, kind). Both arguments are results of seconds_to().

    kind is "measured", or "extrapolated", also for two bounds. It is "at most" or "at least" if one of the
    two reaches the target with its first point. If the ratio is None, kind says who reaches the
    target: "ours only", "peer only" or "neither".
    """
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
    """Compares each of our renderers with the best peer. Returns {renderer: {scene: result of ratio()}}.
    `scenes`: {name: summary}."""
    table = {}
    for scene, found in scenes.items():
        peer = best(found, "peer", target)
        for name, renderer in found.items():
            if renderer["kind"] == "ours":
                table.setdefault(name, {})[scene] = ratio(
                    renderer["seconds_to"][target], peer[1:] if peer else (None, "unknown"))
    return table


def finalists(tried, count, biased=()):
    """Returns the names of the configurations to measure in full, selected by work().

    They are the best `count` at the largest tried sample count, and the best at each other sample count,
    because a configuration with a slow start may win later. The best configuration without one of the
    `biased` samplers is included because the error of the others doesn't fall below their bias.
    """
    ranked = sorted(tried, key=work)
    names = []
    for samples in sorted({row["samples"] for row in tried}, reverse=True):
        here = [row for row in ranked if row["samples"] == samples]
        chosen = here[:1] if names else here[:count] + [
            row for row in here if row["sampler"] not in biased][:1]
        names += [row["name"] for row in chosen]
    return list(dict.fromkeys(names))
