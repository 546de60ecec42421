"""Measures relMSE by processor time of `clustered` and `path`, from one sample per pixel on. A cliff, where the
error falls much faster than time grows, shows a number of rays below which nothing is learned. slope_page.py
writes the results."""
import dataclasses
import math
import statistics

import numpy as np

import bounces
from compare.output import whole

from .kinome import scene_hash, sized
from .problems import Problem
from .tables import SCENES

SIZE = (192, 144)
# Names and max_depth: four scenes with the direct light of an environment, two with any number of bounces.
DEPTHS = {"hebe": 2, "vases": 2, "tree": 2, "room": 2, "kitchen": -1, "cornell_diffuse": -1}
SAMPLER = "halton"  # supports any number of samples
COUNTS = {"clustered": (1, 2, 3, 4, 8, 16, 32), "path": (1, 4, 16, 64)}
MAX_SECONDS = 0.5  # processor time of a render by `path`; larger counts are skipped
SEEDS = 4
QUICK = {"clustered": (1, 2, 4, 16), "path": (1, 4, 16)}
QUICK_SIZE, QUICK_SEEDS = (96, 72), 2
# The reference is the mean of two renders by `clustered`, whose difference is its own noise.
REFERENCE_SAMPLES, REFERENCE_SEEDS = 256, (1001, 1002)
STARTS = 8  # number of tiny renders that measure start-up and loading
# Short renders are repeated until they have this many times, because other programs disturb their times most.
TIMES, SHORT = 4, 0.3
STEEPEST = -2.5  # goal for the slope between neighbouring points


@dataclasses.dataclass
class Point:
    scene: str
    integrator: str
    samples: int
    seconds: float  # processor time without start-up and loading
    relmse: float
    seeds: int
    least: float  # relMSE of the best and of the worst seed
    most: float
    slope: float | None = None  # from the previous point of the integrator, in logarithms


def relmse(image, mean, own):
    return float(np.mean((image - mean) ** 2 / floor(mean)) - own)


def floor(mean):
    return mean ** 2 + bounces.FLOOR * mean.mean() ** 2


def set_slopes(points):
    """Sets the slope of each point of one integrator, except of the first."""
    for before, point in zip(points, points[1:]):
        if min(before.relmse, point.relmse) > 0 and point.seconds != before.seconds:
            point.slope = (math.log(point.relmse / before.relmse)
                           / math.log(point.seconds / before.seconds))


def error_at(points, seconds):
    """Returns the relMSE of these points after `seconds`. Interpolates in logarithms, and extrapolates as
    1 / time."""
    found = sorted((p.seconds, p.relmse) for p in points if p.relmse > 0)
    near = found[0] if seconds < found[0][0] else found[-1]
    if not found[0][0] <= seconds <= found[-1][0]:
        return near[1] * near[0] / seconds
    times, errors = np.log(found).T
    return float(np.exp(np.interp(math.log(seconds), times, errors)))


class Slope:
    def __init__(self, kinome, folder, quick, log):
        self.kinome, self.log = kinome, log
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)
        self.size, self.seeds = (QUICK_SIZE, QUICK_SEEDS) if quick else (SIZE, SEEDS)
        self.counts = QUICK if quick else COUNTS

    def render(self, scene, integrator, samples, seed, size=None):
        defines = {"integrator": integrator, "max_depth": DEPTHS.get(scene.name, -1),
                   "sampler": SAMPLER, "spp": samples} | sized(scene, size or self.size)
        try:
            made = self.kinome.render(scene.path, defines, seed, ("-t", "1"))
        except Problem as reason:
            raise Problem(f"{scene.name}: {reason}") from None
        return made.image, made.stats["processor_seconds"]

    def scene(self, name):
        """Returns the points of a scene. Raises Problem."""
        scene = bounces.scene_of(name, self.folder)
        halves = self.reference(scene)
        mean = np.mean(halves, axis=0)
        own = float(np.mean((halves[0] - halves[1]) ** 2 / 4 / floor(mean)))
        start = statistics.median(self.render(scene, "path", 1, seed, (16, 12))[1]
                                  for seed in range(STARTS))
        points = []
        for integrator, counts in self.counts.items():
            self.log.say(f"{name}: {integrator}")
            curve = []
            for samples in counts:
                curve.append(self.point(scene, integrator, samples, mean, own, start))
                if integrator == "path" and curve[-1].seconds > MAX_SECONDS:
                    break
            set_slopes(curve)
            points += curve
        return points

    def reference(self, scene):
        """Returns two images of many samples, which are kept in the build folder."""
        width, height = self.size
        path = self.folder / f"{scene.name}-{width}x{height}-{scene_hash(scene.path)}.npy"
        if not path.is_file():
            self.log.say(f"{scene.name}: reference")
            found = [self.render(scene, "clustered", REFERENCE_SAMPLES, seed)[0]
                     for seed in REFERENCE_SEEDS]
            with whole(path) as file:
                np.save(file, np.array(found, dtype=np.float32))
        return np.load(path).astype(np.float64)

    def point(self, scene, integrator, samples, mean, own, start):
        errors, times = [], []
        for seed in range(1, self.seeds + 1):
            image, seconds = self.render(scene, integrator, samples, seed)
            errors.append(relmse(image, mean, own))
            times.append(seconds - start)
        while len(times) < TIMES and statistics.median(times) < SHORT:
            times.append(self.render(scene, integrator, samples, len(times))[1] - start)
        return Point(scene.name, integrator, samples, max(statistics.median(times), 1e-3),
                     statistics.fmean(errors), len(errors), min(errors), max(errors))


def names_of(words):
    """Returns the names of the scenes for words of the command line. Raises Problem."""
    known = {scene.name for scene in SCENES} | set(DEPTHS)
    for word in words:
        if word not in known:
            raise Problem(f"slope doesn't support {word}; scenes are {', '.join(sorted(known))}")
    return words or list(DEPTHS)
