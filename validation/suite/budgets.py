"""`validation/run.sh budgets`: is `clustered` worse than `path` or `ptracer` on any scene, with any budget?

All three use any number of bounces (max_depth -1). The error is the variance between seeds, as in bounces.py.
Time is processor time minus that of a tiny render, so other programs on the machine have little effect. The
error of `path` at the time of `clustered` is interpolated on its own curve. For budgets of seconds
and of errors, it is that of a render by `path` with the same budget, which spends time on the same checks.
"""
import dataclasses
import math
import statistics

import numpy as np

import bounces
from program import commit, machine

from .problems import Problem
from .store import digest
from .budget_scenes import derived

SIZE = (160, 120)
# Budgets of `clustered`: samples, seconds (--time) and errors (--error). Samples of the others.
SAMPLES, SECONDS, ERRORS = (2, 8, 32, 128), (1, 5, 30), (1e-2, 1e-3)
PATH_SAMPLES, PTRACER_SAMPLES = (4, 8, 32, 128), (32,)
# Short renders use more seeds than requested, as many as fit into this processor time, up to a maximum. Few
# seeds seldom contain rare bright samples. Renders with --time use the requested number.
SECONDS_OF_SEEDS, MAX_SEEDS = 5, 16
MAX_SECONDS = 6  # processor time of a render by `path`; beyond it, its errors are extrapolated
MAX_SECONDS_OF_ERROR = 15  # estimated processor time of a render by --error; longer ones are skipped
LIMIT = 0.9
# `ptracer` is used if the mean of its image differs from that of `path` by at most this share, or by at most
# four standard errors. It doesn't find light that is seen by mirrors or through glass.
MAX_MEAN_DIFFERENCE, MAX_STANDARD_ERRORS = 0.01, 4
STARTS = 3  # number of renders that measure start-up and loading


@dataclasses.dataclass(frozen=True)
class Budget:
    """Budget of a render: samples, seconds or an error."""

    samples: int | None = None
    seconds: float | None = None
    error: float | None = None

    @property
    def name(self):
        if self.samples:
            return f"{self.samples} samples"
        return f"{self.seconds:g} s" if self.seconds else f"relMSE {self.error:g}"

    def options(self):
        """Returns the options of the program."""
        if self.samples:
            return ()
        return ("--time", str(self.seconds)) if self.seconds else ("--error", str(self.error))


BUDGETS = (*(Budget(samples=n) for n in SAMPLES), *(Budget(seconds=s) for s in SECONDS),
           *(Budget(error=e) for e in ERRORS))


def scale_of(size):
    """Returns the number of pixels, relative to that of SIZE."""
    return size[0] * size[1] / (SIZE[0] * SIZE[1])


class Budgets:
    def __init__(self, kinome, store, folder, options, log):
        self.kinome, self.store, self.folder = kinome, store, folder
        self.options, self.log = options, log
        self.size = options.size or SIZE
        (folder / "pictures").mkdir(parents=True, exist_ok=True)

    def measure(self, scene, integrator, budget, seed):
        """Returns {"processor", "samples", "why", "image"} from the store, or renders if it is missing."""
        key = {"budgets": scene.name, "scene": scene.hash(), "size": self.size, "who": integrator,
               "program": self.kinome.program, "budget": budget.name, "seed": seed,
               "threads": self.options.threads, "machine": machine()["processor"]}
        path = self.folder / f"pictures/{digest(key)}.npy"
        found = self.store.get(key)
        if found is None or not path.is_file():
            found, image = self.render(scene, integrator, budget, seed, self.size)
            np.save(path, image.astype(np.float32))
            self.store.put(key, found)
        return found | {"image": np.load(path).astype(np.float64)}

    def render(self, scene, integrator, budget, seed, size):
        copy, folders = derived(scene, self.folder / "scenes", integrator, budget.samples or 4, size)
        made = self.kinome.render(
            copy, {}, seed, ("-t", str(self.options.threads), *folders, *budget.options()))
        why = [skipped["why"] for skipped in made.stats["skipped"] if skipped["what"] == "product"]
        return {"processor": made.stats["processor_seconds"], "samples": made.samples,
                "why": why[0] if why else ""}, made.image

    def start(self, scene):
        """Returns the processor time of a tiny render, from the store or measured now."""
        def measure():
            return {"processor": statistics.median(
                self.render(scene, "path", Budget(samples=1), seed, (16, 12))[0]["processor"]
                for seed in range(STARTS))}

        key = {"budgets": scene.name, "scene": scene.hash(), "who": "start",
               "program": self.kinome.program, "machine": machine()["processor"]}
        return self.store.recall(key, measure)["processor"]

    def runs(self, scene, integrator, budgets):
        """Returns {budget: renders of all seeds}. Skips larger sample counts that would take longer than
        MAX_SECONDS times the square root of the image's size relative to SIZE. For `clustered`, skips them
        only in images larger than SIZE."""
        limit = MAX_SECONDS * math.sqrt(scale_of(self.size))
        is_limited = integrator != "clustered" or scale_of(self.size) > 1
        found = {}
        for budget in budgets:
            first = self.measure(scene, integrator, budget, 1)
            found[budget] = [first, *(self.measure(scene, integrator, budget, seed)
                                      for seed in range(2, self.seeds(budget, first) + 1))]
            if is_limited and budget.samples and found[budget][0]["processor"] > limit / 4:
                break
        self.log.say(f"{scene.name}: {integrator}")
        return found

    def seeds(self, budget, first):
        """Returns the number of seeds, by the processor time of the first render."""
        if budget.seconds:
            return self.options.seeds
        fit = int(SECONDS_OF_SEEDS / max(first["processor"], 1e-3))
        return max(self.options.seeds, min(fit, MAX_SEEDS))

    def runs_to_errors(self, scene, integrator, found):
        """Returns the same with --error. Skips renders that would take longer than
        MAX_SECONDS_OF_ERROR, estimated from the errors by number of samples."""
        mean = weighted_mean([best(found)])
        points = [point(budget, renders, mean, 0) for budget, renders in found.items()]
        last = max(points, key=seconds_of)
        return self.runs(scene, integrator, [
            Budget(error=error) for error in ERRORS
            if seconds_of(last) * last["relmse"] / error < MAX_SECONDS_OF_ERROR])

    def scene(self, scene):
        """Measures a scene; returns its entry for the page."""
        start = self.start(scene)
        runs = {"path": self.runs(scene, "path", [Budget(samples=n) for n in PATH_SAMPLES])}
        times = [Budget(seconds=s) for s in self.options.seconds]
        timed = self.runs(scene, "path", times) | self.runs_to_errors(scene, "path", runs["path"])
        try:
            light = self.runs(scene, "ptracer", [Budget(samples=n) for n in PTRACER_SAMPLES])
            if is_same(means(runs["path"]), means(light)):
                runs["ptracer"] = light
        except Problem as reason:
            self.log.say(f"{scene.name}: without ptracer: {reason}")
        by_samples = self.runs(scene, "clustered", [Budget(samples=n) for n in SAMPLES])
        runs["clustered"] = (by_samples | self.runs(scene, "clustered", times) |
                             self.runs_to_errors(scene, "clustered", by_samples))
        mean = weighted_mean([best(found) for found in runs.values()])
        runs["path"] |= timed
        curves = {who: [point(budget, renders, mean, start) for budget, renders in found.items()]
                  for who, found in runs.items()}
        ours, theirs = means(runs["clustered"]), means(runs["path"])
        return {"start": start, "curves": curves, "commit": commit(), "seeds": self.options.seeds,
                "difference": ours[0] / theirs[0] - 1,
                "difference_error": math.hypot(ours[1], theirs[1]) / theirs[0]}


def best(found):
    """Returns the images of the most expensive budget."""
    dearest = max(found.values(), key=lambda renders: renders[0]["processor"])
    return [render["image"] for render in dearest]


def means(found):
    """Returns the mean of the images of the most expensive budget, and its standard error."""
    values = [float(image.mean()) for image in best(found)]
    return statistics.fmean(values), statistics.stdev(values) / math.sqrt(len(values))


def is_same(a, b):
    return abs(a[0] - b[0]) <= max(MAX_MEAN_DIFFERENCE * a[0], MAX_STANDARD_ERRORS * math.hypot(a[1], b[1]))


def weighted_mean(stacks):
    """Returns the mean of stacks of images, weighted by the inverse of their variances."""
    weights = [len(stack) / max(np.var(stack, axis=0, ddof=1).mean(), 1e-30) for stack in stacks]
    return np.average([np.mean(stack, axis=0) for stack in stacks], axis=0, weights=weights)


def point(budget, renders, mean, start):
    return {"budget": budget.name, "samples": renders[0]["samples"],
            "processor": [max(render["processor"] - start, 1e-3) for render in renders],
            "by_paths": sum(bool(render["why"]) for render in renders),
            "why": next((render["why"] for render in renders if render["why"]), ""),
            **bounces.errors([render["image"] for render in renders], mean)}


def seconds_of(one):
    return statistics.median(one["processor"])


def error_at(curve, seconds, budget=""):
    """Returns the relMSE after `seconds`. Interpolates between measured points in logarithms, and extrapolates
    as 1 / time. If `budget` is one of seconds or of an error and was measured, uses only its point."""
    def has_no_samples(name):
        return name.endswith(" s") or name.startswith("relMSE ")

    same = [one for one in curve if one["budget"] == budget and has_no_samples(budget)]
    others = [one for one in curve if not has_no_samples(one["budget"])]
    points = sorted((seconds_of(one), one["relmse"]) for one in same or others
                    if one["relmse"] > 0)
    if not points:
        return None
    first, last = points[0], points[-1]
    if seconds <= first[0] or seconds >= last[0]:
        near = first if seconds <= first[0] else last
        return near[1] * near[0] / seconds
    times, errors = zip(*points)
    return float(np.exp(np.interp(np.log(seconds), np.log(times), np.log(errors))))


def ratios(entry):
    """Returns [{budget, seconds, relmse, peer, peer_relmse, ratio, …}]. The ratio is the error of the better
    peer at the time of `clustered`, divided by that of `clustered`."""
    rows = []
    for one in entry["curves"]["clustered"]:
        seconds = seconds_of(one)
        others = {who: error_at(curve, seconds, one["budget"])
                  for who, curve in entry["curves"].items() if who != "clustered"}
        others = {who: error for who, error in others.items() if error}
        if not others or not one["relmse"] > 0:
            continue
        peer = min(others, key=others.get)
        rows.append({"budget": one["budget"], "seconds": seconds, "relmse": one["relmse"],
                     "peer": peer, "peer_relmse": others[peer],
                     "ratio": others[peer] / one["relmse"],
                     "path_ratio": others["path"] / one["relmse"],
                     "by_paths": one["by_paths"], "why": one["why"]})
    return rows
