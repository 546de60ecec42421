"""What follows from the engine's times, and its goals. Only arithmetic: no files, no renderers.

A row is one scene in one part, as engine.py measures it: {"part", "scene", "size", "max_depth",
"runs": [{"label", "seed", "samples", "seconds", "processor", ...}]}."""
import dataclasses
import statistics

from .analysis import geometric_mean
from .tables import ISAS

OURS, THEIRS = "ours", "Mitsuba"
MEANS_DIFFER = 0.05  # of a mean: more, and the two do not show the same picture
DIRECT, PLASTIC, PATH = 1.35, 1.6, 1.3  # goals: times as fast a sample as Mitsuba
SLOWER = 1.4, 3  # times, with AVX2 and with neither
DIFFUSE = {"diffuse", "twosided"}
ROUGH_PLASTIC = {"roughplastic"}


def median(values):
    """None of nothing."""
    return statistics.median(values) if values else None


def by_seed(row, label):
    """The runs of a label: {seed: [run, ...] by samples}."""
    found = {}
    for run in row["runs"]:
        if run["label"] == label:
            found.setdefault(run["seed"], []).append(run)
    return {seed: sorted(runs, key=lambda run: run["samples"]) for seed, runs in found.items()}


def line(xs, ys):
    """(slope, intercept) by least squares; None of fewer than two different x."""
    mean_x, mean_y = statistics.fmean(xs), statistics.fmean(ys)
    spread = sum((x - mean_x) ** 2 for x in xs)
    if spread == 0:
        return None
    slope = sum((x - mean_x) * (y - mean_y) for x, y in zip(xs, ys)) / spread
    return slope, mean_y - slope * mean_x


def lines(row, label, clock):
    """(slope, intercept) of that clock, "processor" or "seconds", over samples a pixel, by seed."""
    found = {seed: line([run["samples"] for run in runs], [run[clock] for run in runs])
             for seed, runs in by_seed(row, label).items()}
    return {seed: fit for seed, fit in found.items() if fit}


def rates(row, label, clock="processor"):
    """Nanoseconds a sample, by seed: slopes, so that what a render takes whatever its samples is
    not in them. One that noise has turned to zero or less isn't there."""
    pixels = row["size"][0] * row["size"][1]
    return {seed: 1e9 * slope / pixels for seed, (slope, _) in lines(row, label, clock).items()
            if slope > 0}


def rate(row, label, clock="processor"):
    return median(list(rates(row, label, clock).values()))


def faster(row, ours=OURS, theirs=THEIRS, clock="processor"):
    """How many times faster a sample `ours` is, or None."""
    a, b = (rate(row, label, clock) for label in (ours, theirs))
    return b / a if a and b else None


def spread(row):
    """(least, most) of that ratio, seed by seed, or None."""
    ours, theirs = rates(row, OURS), rates(row, THEIRS)
    found = [theirs[seed] / ours[seed] for seed in ours.keys() & theirs.keys()]
    return (min(found), max(found)) if found else None


def of_label(row, label, key, samples=None):
    """All values of that key, of the most samples or of those given."""
    runs = [run for runs in by_seed(row, label).values() for run in runs]
    most = samples or max((run["samples"] for run in runs), default=0)
    return [run[key] for run in runs if run["samples"] == most and run.get(key) is not None]


def embree_share(row):
    return median(of_label(row, OURS, "embree_share"))


def bsdfs(row):
    return {name for run in row["runs"] for name in run.get("bsdfs", ())}


def is_diffuse(row):
    return bool(bsdfs(row)) and bsdfs(row) <= DIFFUSE


def is_rough_plastic(row):
    """Of nothing else: beside other materials it decides too little of the time."""
    return bsdfs(row) == ROUGH_PLASTIC


def different_pictures(row):
    """How far the means of both pictures are apart, if by more than MEANS_DIFFER, else None."""
    ours, theirs = (median(of_label(row, label, "mean")) for label in (OURS, THEIRS))
    if not ours or not theirs:
        return None
    apart = abs(ours - theirs) / max(ours, theirs)
    return apart if apart > MEANS_DIFFER else None


def fixed_cost(row, label="product"):
    """Seconds of rendering that no sample takes: where the line over samples begins."""
    return median([start for _, start in lines(row, label, "seconds").values()])


def ray_cost(row, label="product", start="start"):
    """Processor nanoseconds of rendering by all rays, at the most samples: loading, which a picture
    of a few pixels also does, is subtracted, seed by seed."""
    loads = by_seed(row, start)
    return median([1e9 * (runs[-1]["processor"] - loads[seed][0]["processor"]) / runs[-1]["rays"]
                   for seed, runs in by_seed(row, label).items()
                   if seed in loads and runs[-1]["rays"]])


def seconds(row, label):
    return median(of_label(row, label, "seconds"))


def quotient(a, b):
    return a / b if a and b else None


@dataclasses.dataclass(frozen=True)
class Goal:
    """`bound`: "at least" or "at most" `limit` `unit`; values of None are left out, and without
    any it isn't told."""

    what: str
    bound: str
    limit: float
    unit: str
    values: dict  # {scene: value}

    @property
    def known(self):
        return {name: value for name, value in self.values.items() if value is not None}

    def reached(self, value):
        return value >= self.limit if self.bound == "at least" else value <= self.limit

    @property
    def short_of_it(self):
        """Names of what doesn't reach it, the farthest first."""
        names = [name for name, value in self.known.items() if not self.reached(value)]
        return sorted(names, key=self.known.get, reverse=self.bound == "at most")

    @property
    def met(self):
        """None if nothing was measured."""
        return not self.short_of_it if self.known else None

    @property
    def verdict(self):
        if self.met is None:
            return "not measured"
        if self.met:
            return "met"
        known, names = self.known, self.short_of_it
        return "not met" if len(known) == 1 else (
            f"not met by {len(names)} of {len(known)}: " + ", ".join(names))


def speeds(rows, part, max_depth=None):
    return {row["scene"]: faster(row) for row in rows
            if row["part"] == part and row["max_depth"] == max_depth}


def of_part(rows, part):
    return {row["scene"]: row for row in rows if row["part"] == part}


def isa_ratios(rows, isa):
    """How many times slower than with the best instruction set."""
    return {name: faster(row, ISAS[0], isa) for name, row in of_part(rows, "isa").items()}


def goals(rows):
    """All of them, in the order of the page."""
    direct = speeds(rows, "direct")
    found = {name: value for name, value in direct.items() if value is not None}
    parts = of_part(rows, "direct")
    plastic = {name: value for name, value in direct.items() if is_rough_plastic(parts[name])}
    shares = {name: 100 * share for name, row in parts.items() if is_diffuse(row)
              and (share := embree_share(row)) is not None}
    faster_than = "times as fast a sample as Mitsuba"
    yield Goal("`direct`", "at least", DIRECT, faster_than, direct)
    yield Goal("`direct`, rough plastic alone", "at least", PLASTIC, faster_than, plastic)
    yield Goal("`direct`, geometric mean", "at least", 1.6, faster_than,
               {f"mean of {len(found)}": geometric_mean(list(found.values()))})
    for depth in (2, 5):
        yield Goal(f"`path` to depth {depth}", "at least", PATH, faster_than,
                   speeds(rows, "path", depth))
    yield Goal("share inside Embree, `direct`, diffuse scenes", "at least", 40, "%", shares)
    yield Goal("AVX2 against AVX-512", "at most", SLOWER[0], "times slower",
               isa_ratios(rows, ISAS[1]))
    yield Goal("baseline against AVX-512", "at most", SLOWER[1], "times slower",
               isa_ratios(rows, ISAS[2]))
    yield Goal("`direct` at 4 spp, 192x144: seconds of rendering", "at most", 1, "of Mitsuba's",
               {name: quotient(seconds(row, OURS), seconds(row, THEIRS))
                for name, row in of_part(rows, "short").items()})
    product, threads = of_part(rows, "product"), of_part(rows, "threads")
    yield Goal("product, 256x256: fixed cost", "at most", 0.09, "s",
               {name: fixed_cost(row) for name, row in product.items()})
    yield Goal("product, 256x256, 64 spp: processor time a ray", "at most", 190, "ns",
               {name: ray_cost(row) for name, row in product.items()})
    yield Goal("2 threads against 1", "at least", 1.9, "times as fast",
               {f"{method} of {name}": quotient(seconds(row, f"{method}, 1"),
                                              seconds(row, f"{method}, 2"))
                for name, row in threads.items() for method in ("direct", "product")})
    yield Goal("peak memory at 1024x1024", "at most", 150, "MB",
               {f"{method} of {name}": size and size / 1e6
                for name, row in of_part(rows, "memory").items() for method in ("direct", "product")
                for size in [max(of_label(row, method, "memory"), default=None)]})
    yield Goal("a plugin with functions for single points alone", "at most", 2,
               "times the time of the same one with wide functions",
               {name: faster(row, "wide", "point by point")
                for name, row in of_part(rows, "plugin").items()})


def range_text(values, digits=3):
    """The least and the most of several."""
    if not values:
        return "–"
    low, high = (f"{value:.{digits}g}" for value in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"
