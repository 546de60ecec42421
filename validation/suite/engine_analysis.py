"""Computes results from the engine's times, and defines its goals. Uses no files and no renderers.

A row is the measurement of one scene in one part by engine.py: {"part", "scene", "size", "max_depth",
"runs": [{"label", "seed", "samples", "seconds", "processor", ...}]}."""
import dataclasses
import statistics

from .analysis import geometric_mean
from .tables import ISAS

OURS, THEIRS = "ours", "Mitsuba"
MEANS_DIFFER = 0.05  # relative difference of means beyond which the images are reported as different
DIRECT, PLASTIC, PATH = 1.35, 1.6, 1.3  # goals for the speed-up per sample against Mitsuba
SLOWDOWN_GOALS = 1.4, 3  # goals for the slowdown with AVX2 and with the baseline
DIFFUSE = {"diffuse", "twosided"}
ROUGH_PLASTIC = {"roughplastic"}


def median(values):
    """Returns the median, or None if there are no values."""
    return statistics.median(values) if values else None


def by_seed(row, label):
    """Returns the runs of a label: {seed: [run, ...] in ascending order of samples}."""
    found = {}
    for run in row["runs"]:
        if run["label"] == label:
            found.setdefault(run["seed"], []).append(run)
    return {seed: sorted(runs, key=lambda run: run["samples"]) for seed, runs in found.items()}


def line(xs, ys):
    """Returns (slope, intercept) by least squares, or None for fewer than two different x."""
    mean_x, mean_y = statistics.fmean(xs), statistics.fmean(ys)
    spread = sum((x - mean_x) ** 2 for x in xs)
    if spread == 0:
        return None
    slope = sum((x - mean_x) * (y - mean_y) for x, y in zip(xs, ys)) / spread
    return slope, mean_y - slope * mean_x


def lines(row, label, clock):
    """Returns {seed: (slope, intercept)} of the time over samples per pixel. `clock`: "processor" or
    "seconds"."""
    found = {seed: line([run["samples"] for run in runs], [run[clock] for run in runs])
             for seed, runs in by_seed(row, label).items()}
    return {seed: fit for seed, fit in found.items() if fit}


def rates(row, label, clock="processor"):
    """Returns {seed: nanoseconds per sample}. They are slopes, which exclude the fixed time of a render. Slopes
    that are zero or negative because of noise are left out."""
    pixels = row["size"][0] * row["size"][1]
    return {seed: 1e9 * slope / pixels for seed, (slope, _) in lines(row, label, clock).items()
            if slope > 0}


def rate(row, label, clock="processor"):
    return median(list(rates(row, label, clock).values()))


def faster(row, ours=OURS, theirs=THEIRS, clock="processor"):
    """Returns the speed-up per sample of `ours` against `theirs`, or None."""
    a, b = (rate(row, label, clock) for label in (ours, theirs))
    return b / a if a and b else None


def spread(row):
    """Returns the (minimum, maximum) of that speed-up over the seeds, or None."""
    ours, theirs = rates(row, OURS), rates(row, THEIRS)
    found = [theirs[seed] / ours[seed] for seed in ours.keys() & theirs.keys()]
    return (min(found), max(found)) if found else None


def of_label(row, label, key, samples=None):
    """Returns all values of `key` with the given number of samples, or with the largest one."""
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
    """Returns whether rough plastic is the only BSDF. Beside others, it affects the time too little."""
    return bsdfs(row) == ROUGH_PLASTIC


def different_pictures(row):
    """Returns the relative difference of the means of both images if it exceeds MEANS_DIFFER, else None."""
    ours, theirs = (median(of_label(row, label, "mean")) for label in (OURS, THEIRS))
    if not ours or not theirs:
        return None
    apart = abs(ours - theirs) / max(ours, theirs)
    return apart if apart > MEANS_DIFFER else None


def fixed_cost(row, label="product"):
    """Returns the seconds of rendering without samples: the intercept of the line over samples."""
    return median([start for _, start in lines(row, label, "seconds").values()])


def ray_cost(row, label="product", start="start"):
    """Returns the processor nanoseconds per ray with the largest number of samples. Subtracts the time of an
    image of a few pixels with the same seed, which is that of loading."""
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
    """A goal: each value must be `bound` ("at least" or "at most") `limit`. Values of None are ignored."""

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
    def missed(self):
        """Returns the names of values that miss the goal, worst first."""
        names = [name for name, value in self.known.items() if not self.reached(value)]
        return sorted(names, key=self.known.get, reverse=self.bound == "at most")

    @property
    def met(self):
        """Returns whether all values reach the goal, or None if nothing was measured."""
        return not self.missed if self.known else None

    @property
    def verdict(self):
        if self.met is None:
            return "not measured"
        if self.met:
            return "met"
        known, names = self.known, self.missed
        return "not met" if len(known) == 1 else (
            f"not met by {len(names)} of {len(known)}: " + ", ".join(names))


def speeds(rows, part, max_depth=None):
    return {row["scene"]: faster(row) for row in rows
            if row["part"] == part and row["max_depth"] == max_depth}


def of_part(rows, part):
    return {row["scene"]: row for row in rows if row["part"] == part}


def isa_ratios(rows, isa):
    """Returns {scene: slowdown against the best instruction set}."""
    return {name: faster(row, ISAS[0], isa) for name, row in of_part(rows, "isa").items()}


def goals(rows):
    """Yields all goals, in the order of the page."""
    direct = speeds(rows, "direct")
    found = {name: value for name, value in direct.items() if value is not None}
    parts = of_part(rows, "direct")
    plastic = {name: value for name, value in direct.items() if is_rough_plastic(parts[name])}
    shares = {name: 100 * share for name, row in parts.items() if is_diffuse(row)
              and (share := embree_share(row)) is not None}
    faster_than = "times as fast per sample as Mitsuba"
    yield Goal("`direct`", "at least", DIRECT, faster_than, direct)
    yield Goal("`direct`, rough plastic alone", "at least", PLASTIC, faster_than, plastic)
    yield Goal("`direct`, geometric mean", "at least", 1.6, faster_than,
               {f"mean of {len(found)}": geometric_mean(list(found.values()))})
    for depth in (2, 5):
        yield Goal(f"`path` to depth {depth}", "at least", PATH, faster_than,
                   speeds(rows, "path", depth))
    yield Goal("share inside Embree, `direct`, diffuse scenes", "at least", 40, "%", shares)
    yield Goal("AVX2 against AVX-512", "at most", SLOWDOWN_GOALS[0], "times slower",
               isa_ratios(rows, ISAS[1]))
    yield Goal("baseline against AVX-512", "at most", SLOWDOWN_GOALS[1], "times slower",
               isa_ratios(rows, ISAS[2]))
    yield Goal("`direct` at 4 spp, 192x144: seconds of rendering", "at most", 1, "of Mitsuba's",
               {name: quotient(seconds(row, OURS), seconds(row, THEIRS))
                for name, row in of_part(rows, "short").items()})
    product, threads = of_part(rows, "product"), of_part(rows, "threads")
    yield Goal("product, 256x256: fixed cost", "at most", 0.09, "s",
               {name: fixed_cost(row) for name, row in product.items()})
    yield Goal("product, 256x256, 64 spp: processor time per ray", "at most", 190, "ns",
               {name: ray_cost(row) for name, row in product.items()})
    yield Goal("2 threads against 1", "at least", 1.9, "times as fast",
               {f"{method} of {name}": quotient(seconds(row, f"{method}, 1"),
                                              seconds(row, f"{method}, 2"))
                for name, row in threads.items() for method in ("direct", "product")})
    yield Goal("peak memory at 1024x1024", "at most", 150, "MB",
               {f"{method} of {name}": size and size / 1e6
                for name, row in of_part(rows, "memory").items() for method in ("direct", "product")
                for size in [max(of_label(row, method, "memory"), default=None)]})
    yield Goal("a plugin with only scalar functions", "at most", 2,
               "times the time of the same plugin with wide functions",
               {name: faster(row, "wide", "point by point")
                for name, row in of_part(rows, "plugin").items()})


def range_text(values, digits=3):
    """Formats the minimum and the maximum of several values."""
    if not values:
        return "–"
    low, high = (f"{value:.{digits}g}" for value in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"
