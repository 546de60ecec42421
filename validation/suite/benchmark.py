"""Error over time: searches Mitsuba's fastest configurations, then measures them and ours in turns."""
import contextlib
import dataclasses
import math
import statistics
import tempfile
import time

import numpy as np

from compare import Errors
from program import commit, machine

from . import analysis
from .contestants import Ours, Theirs
from .cycles import Cycles
from .kinome import scene_hash
from .others import BUSY, Others, cores_of_others
from .peers import Unavailable, configurations
from .problems import Problem
from .schedule import Clock, Schedule
from .store import digest, hash_of_files
from .tables import BIASED_SAMPLERS, BOUNCE, DEEP, METHODS, ROOT, THREADS
from .truth import own_error

FINALISTS = 2  # minimum number of Mitsuba's configurations that are measured in full
FIRST_SEED = 1
MIN_COUNTS = 3  # number of sample counts for a slope; up to these the time limit of a render is higher
GRACE = 4  # factor of that limit
# A configuration is tried no further if its variant is MAX_TIME_RATIO times slower than the other. The variant
# isn't even tried with other samplers if it is MAX_TIME_RATIO_TO_TRY times slower.
MAX_TIME_RATIO, MAX_TIME_RATIO_TO_TRY = 2, 2.5
# A configuration is tried no further if its work (relMSE x seconds) is this many times the least work so
# far. On 26 scenes, with few samples, the final winner never had more than 2.3 times the least work.
MAX_WORK_RATIO = {"few": 3, "many": 2}


class Benchmark:
    def __init__(self, kinome, mitsuba, cycles_python, references, effort, store, folder, log):
        """`folder`: for images."""
        self.kinome, self.mitsuba, self.references = kinome, mitsuba, references
        self.cycles_python = cycles_python
        self.effort, self.store, self.folder, self.log = effort, store, folder, log
        self.machine = machine()
        self.schedule = Schedule(store, references, effort, kinome.program, self.machine)
        (folder / "pictures").mkdir(parents=True, exist_ok=True)

    def scene(self, scene):
        """Measures one scene; returns its entry. Raises Problem if there is no reference."""
        clock = Clock()
        size = self.effort.timed_size(scene)
        truth, description = self.references.load(scene, size, timed=True)
        if truth.mean.shape[:2] != (size[1], size[0]):
            raise Problem(f"{scene.name}: the reference is {truth.mean.shape[1]}x"
                          f"{truth.mean.shape[0]}, the images are {size[0]}x{size[1]}")
        self.common = {"scene": scene_hash(scene.path), "name": scene.name, "size": size,
                       "reference": description["hash"], "machine": self.machine["processor"],
                       "cores": self.machine["cores"], "threads": THREADS,
                       "errors": hash_of_files([ROOT / "validation/compare/errors.py"]),
                       "others": 1}  # version of the values on other processes
        clock.lap("reference")
        tried = self.search(scene, size, truth)
        clock.lap("search")
        finalists = analysis.finalists(tried, FINALISTS,
                                       BIASED_SAMPLERS if scene.group in (BOUNCE, DEEP) else ())
        with contextlib.ExitStack() as ending:
            renderers = self.renderers(scene, size, finalists, truth, ending)
            curves = self.compete(scene, renderers, truth)
            clock.lap("turns")
        others = cores_of_others([run for curve in curves.values() for point in curve["points"]
                                  for run in point["runs"]])
        if others > BUSY * self.machine["cores"]:
            self.log.say(f"{scene.name}: other processes used {others:.1f} of "
                         f"{self.machine['cores']} cores meanwhile, so the times are too long")
        startup = self.startup(scene, size, renderers, curves, finalists)
        clock.lap("startup")
        self.schedule.note(scene, clock.laps)
        return {"group": scene.group, "size": list(size), "program": self.kinome.program,
                "commit": commit(), "machine": self.machine, "cores_of_others": others,
                "reference": description | {"own_error": own_error(truth)},
                "tried": tried, "curves": curves, "startup": startup}

    def measure(self, renderer, samples, seed, truth, warm=None, **part):
        """Returns {"seconds", "relmse", …} of one render, from the store or measured now. `part`: name of the
        part of the measurement, because times can't be used for other parts. `warm`: for Mitsuba, whether
        to render once before the timed render."""
        key = {**self.common, "renderer": renderer.name, **renderer.key, "samples": samples,
               "seed": seed, **part}

        def now():
            others = Others()
            run = renderer.run(samples, seed, **({} if warm is None else {"warm": warm}))
            values = {"seconds": run.seconds, "samples": run.samples, **run.extra, **others.taken(),
                      **errors(run.image, truth, renderer.name)}
            if seed == FIRST_SEED and not part:
                np.save(self.folder / f"pictures/{digest(key)}.npy", run.image.astype(np.float32))
            return values

        return self.store.recall(key, now) | {"seed": seed, "picture": digest(key)}

    def search(self, scene, size, truth):
        """Returns a row for each configuration of Mitsuba and sample count that could be measured.
        Configurations that are behind are tried only with the fewest samples, or not at all: see
        MAX_TIME_RATIO, MAX_TIME_RATIO_TO_TRY and MAX_WORK_RATIO. A slower variant computes the same estimate,
        so it can't win with more samples. The first variant, which is always tried, has the higher fixed
        costs."""
        rows, given = [], [s for s in self.effort.search_samples if s <= self.effort.max_samples]
        fastest = {}  # least seconds, by configuration without its variant
        least = {}  # least work, by number of samples
        too_slow = set()  # (variant, integrator)
        for configuration in configurations(scene):
            same = dataclasses.replace(configuration, variant="")
            kind = configuration.variant, configuration.integrator
            if kind in too_slow:
                continue
            renderer = Theirs(self.mitsuba, configuration, scene, size)
            try:
                for samples in given:
                    row = self.trial(renderer, samples, truth, least.get(samples, math.inf),
                                     samples == given[0])
                    rows.append(row)
                    least[samples] = min(least.get(samples, math.inf), analysis.work(row))
                    if samples == given[0]:
                        few = row["seconds"]
                        slower = few / fastest.get(same, math.inf)
                        if slower >= MAX_TIME_RATIO_TO_TRY:
                            too_slow.add(kind)
                        if slower >= MAX_TIME_RATIO or row["left_behind"]:
                            break
                fastest[same] = min(fastest.get(same, math.inf), few)
            except Unavailable:
                continue
            except Problem as reason:
                self.log.problem(f"{scene.name}: {reason}")
                continue
            self.log.say(f"{scene.name}: {configuration.name}: {rows[-1]['seconds']:.3f} s, "
                         f"relMSE {rows[-1]['relmse']:.3g}")
        return rows

    def trial(self, renderer, samples, truth, least, few):
        """Returns means over the first seeds, or over one seed if the work exceeds MAX_WORK_RATIO times the
        least work. With many samples, the first seed is rendered without a warm-up, which would take as long.
        The seconds are then the minimum."""
        runs = []
        for i in range(self.effort.search_seeds):
            runs.append(self.measure(renderer, samples, FIRST_SEED + i, truth, part="search",
                                     warm=few or i > 0))
            row = {key: statistics.fmean(run[key] for run in runs)
                   for key in ("seconds", "relmse", "trimmed")}
            left_behind = analysis.work(row) >= MAX_WORK_RATIO["few" if few else "many"] * least
            if left_behind:
                break
        if not few:
            row["seconds"] = min(run["seconds"] for run in runs)
        return {"name": renderer.name, **dataclasses.asdict(renderer.configuration),
                "samples": runs[0]["samples"], "left_behind": left_behind, **row}

    def renderers(self, scene, size, finalists, truth, ending):
        """Returns the renderers that take turns. `ending` closes them."""
        found = [Ours(self.kinome, m, scene, size) for m in methods_timed(scene)]
        # Each configuration gets its own process. Otherwise, its scene would be loaded again before each turn,
        # and the first render after loading takes longer.
        self.mitsuba.close()
        for configuration in configurations(scene):
            if configuration.name in finalists:
                own = self.mitsuba.another()
                ending.callback(own.close)
                found.append(Theirs(own, configuration, scene, size))
        if scene.cycles:
            try:
                cycles = Cycles(self.cycles_python, scene, size, self.folder)
                ending.callback(cycles.close)
                cycles.must_agree(truth)
                found.append(cycles)
            except Problem as reason:
                self.log.problem(f"Cycles is left out: {reason}")
        return found

    def compete(self, scene, renderers, truth):
        """Measures and returns the curves by renderer. All renderers take turns for each seed and sample
        count, so that other load of the machine affects all of them."""
        runs = {r.name: {} for r in renderers}
        limit = {r.name: self.effort.max_samples for r in renderers}

        def curves():
            return {r.name: {"kind": r.kind, "converges_to_points": r.converges_to_points,
                             "points": [{"samples": s, "runs": found}
                                        for s, found in runs[r.name].items()]}
                    for r in renderers if runs[r.name]}

        for seed in range(FIRST_SEED, FIRST_SEED + self.effort.seeds):
            self.log.say(f"{scene.name}: seed {seed} of {self.effort.seeds}, "
                         f"{len(limit)} renderers")
            for step in range(max(len(r.samples) for r in renderers)):
                for renderer in renderers:
                    if step < len(renderer.samples) and renderer.name in limit:
                        self.turn(renderer, step, seed, truth, runs, limit)
            if seed == FIRST_SEED:
                self.leave_behind(scene, renderers, truth, curves(), runs, limit)
        return curves()

    def leave_behind(self, scene, renderers, truth, curves, runs, limit):
        """Removes Mitsuba's configurations that are behind for all targets. They aren't shown."""
        behind = analysis.behind({"reference": {"own_error": own_error(truth)}, "curves": curves})
        for renderer in renderers:
            if renderer.name in behind and isinstance(renderer, Theirs):
                self.log.say(f"{scene.name}: {renderer.name} is behind and measured no further")
                limit.pop(renderer.name, None)
                runs[renderer.name].clear()

    def turn(self, renderer, step, seed, truth, runs, limit):
        samples = renderer.samples[step]
        if samples > limit[renderer.name]:
            return
        try:
            found = self.measure(renderer, samples, seed, truth)
        except Problem as reason:
            self.log.problem(f"{reason} (at {samples} samples; more are not tried)")
            limit[renderer.name] = samples - 1
            return
        # Uses the actual sample count, because two counts may be rounded to the same one.
        point = runs[renderer.name].setdefault(found["samples"], [])
        if all(run["seed"] != seed for run in point):
            point.append(found)
        # Only the first seed decides, so that every count has all seeds or none.
        if seed == FIRST_SEED and step + 1 < len(renderer.samples):
            following = renderer.samples[step + 1]
            budget = self.effort.budget if renderer.claimed else self.effort.budget_of_others
            if step + 1 < MIN_COUNTS:
                budget *= GRACE
            if (found["seconds"] * following / samples > budget
                    or found["relmse"] < analysis.enough(renderer.kind, own_error(truth))):
                limit[renderer.name] = min(limit[renderer.name], samples)

    def startup(self, scene, size, renderers, curves, finalists):
        """Returns the seconds of start-up and compilation, as rows {"renderer", "when", "seconds"}, for our
        renderers and for the first of Mitsuba's finalists."""
        rows, first = [], next((name for name in finalists if name in curves), None)
        for renderer in renderers:
            if renderer.kind == "ours" and renderer.name in curves:
                extra = [run["wall"] - run["seconds"] for point in curves[renderer.name]["points"]
                         for run in point["runs"]]
                rows.append({"renderer": renderer.name, "when": "always",
                             "seconds": statistics.median(extra)})
            elif renderer.name == first:
                key = {**self.common, "startup": renderer.name, **renderer.key}
                try:
                    cold, warm = self.store.recall(
                        key, lambda r=renderer: self.measure_startup(r, scene, size))
                except Problem as reason:
                    self.log.problem(f"{scene.name}: {reason}")
                    continue
                rows += [{"renderer": renderer.name, "when": when, "seconds": seconds}
                         for when, seconds in (("first time", cold), ("kernels cached", warm))]
        return rows

    def measure_startup(self, renderer, scene, size):
        """Returns the start-up seconds of a new process with an empty kernel cache, and with a filled one."""
        with tempfile.TemporaryDirectory() as cache:
            return [self.one_startup(renderer.configuration, scene, size, cache) for _ in range(2)]

    def one_startup(self, configuration, scene, size, cache):
        fresh = self.mitsuba.another(cache)
        try:
            start = time.perf_counter()
            fresh.load(configuration, scene, size)
            fresh.render(configuration, scene, size, 16, 1)
            whole = time.perf_counter() - start
            return whole - fresh.render(configuration, scene, size, 16, 2).seconds
        finally:
            fresh.close()


def methods_timed(scene):
    """Returns our methods that are timed on a scene. Methods that converge to their light points, such as
    those of the thesis, are timed only on the default scenes and in thesis/. `path` is left out on the
    other scenes where `direct` renders the same in less time."""
    return [m for m in METHODS if m.serves(scene) and not (scene.asked and (
        m.truth == "groundtruth" or m.name == "path" and scene.truth == "direct"))]


def errors(image, truth, name):
    """Returns the errors against the reference, whose own noise is subtracted."""
    if image.shape != truth.mean.shape:
        raise Problem(f"{name}: the image is {image.shape[1]}x{image.shape[0]}, the reference "
                      f"{truth.mean.shape[1]}x{truth.mean.shape[0]}")
    broken = ~np.isfinite(image).all(axis=2)
    count = int((broken & ~truth.masked).sum())
    if (broken | truth.masked).all():
        raise Problem(f"{name}: the image has no finite pixel")
    found = Errors.of(np.where(broken[:, :, None], 0, image), truth, truth.masked | broken)
    return {"relmse": found.relmse, "trimmed": found.trimmed, "maximum": found.maximum,
            "not_finite": count}
