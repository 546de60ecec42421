"""Runs Mitsuba: its configurations, and a persistent process for each variant."""
import dataclasses
import pathlib
import typing

import numpy as np

from .problems import Problem
from .store import hash_of_files
from .tables import PEER_SAMPLES, SAMPLERS, THREADS, VARIANTS
from .worker import Dead, Refused, Worker

HERE = pathlib.Path(__file__).resolve().parent


@dataclasses.dataclass(frozen=True)
class Configuration:
    variant: str
    integrator: str
    sampler: str
    compensation: bool
    max_depth: int | None = None  # None: that of tables.Scene

    @property
    def name(self):
        extra = ", compensated" if self.compensation else ""
        extra += f", depth {self.max_depth}" if self.max_depth else ""
        return f"Mitsuba {self.integrator}, {self.sampler}, {self.variant}{extra}"

    def defines(self, scene, size):
        found = {"integrator": self.integrator, "sampler": self.sampler, "width": size[0],
                 "height": size[1], **scene.depth(self.integrator)}
        if scene.envmap:
            found["mis_compensation"] = "true" if self.compensation else "false"
        if self.max_depth:
            found["max_depth"] = self.max_depth
        return {key: str(value) for key, value in found.items()}


def configurations(scene):
    """Returns all configurations to try on a scene."""
    return [Configuration(v, i, s, c) for v in VARIANTS for i in scene.peers for s in SAMPLERS
            for c in ((False, True) if scene.envmap else (False,))]


class Unavailable(Problem):
    """A problem that was already reported."""


@dataclasses.dataclass
class Loaded:
    """Scene that a process has loaded."""

    what: tuple
    warmed: set = dataclasses.field(default_factory=set)  # sample counts that it has rendered


class Rendered(typing.NamedTuple):
    image: np.ndarray
    seconds: float
    samples: int  # actual number per pixel
    processor: float  # seconds


class Mitsuba:
    """Mitsuba's processes. A variant that can't be started is reported once and then left out."""

    samples = PEER_SAMPLES

    def __init__(self, python, folder, log, cache=None, command=None):
        self.python, self.folder, self.log = python, folder, log
        self.environment = {"DRJIT_CACHE_DIR": str(cache or folder / "kernels")}
        self.command = command or [python, HERE / "workers/mitsuba_worker.py"]
        self.workers, self.loaded, self.broken = {}, {}, {}
        folder.mkdir(parents=True, exist_ok=True)

    def another(self, cache=None):
        """Returns a Mitsuba with its own processes, and with kernels in the folder `cache`."""
        return Mitsuba(self.python, self.folder, self.log, cache, self.command)

    def worker(self, variant):
        if variant in self.broken:
            raise self.broken[variant]
        if variant not in self.workers:
            if not pathlib.Path(self.python).is_file():
                self._give_up(variant, Problem(
                    "Mitsuba isn't installed (pip failed?), so its columns are left out"))
            try:
                worker = Worker(f"Mitsuba {variant}", [*self.command, variant, str(THREADS)],
                                self.environment)
                worker.ask(command="hello")
            except Problem as reason:
                self._give_up(variant, reason)
            self.workers[variant] = worker
        return self.workers[variant]

    def _give_up(self, variant, reason):
        self.log.problem(reason)
        self.broken[variant] = Unavailable(reason)
        raise self.broken[variant]

    def load(self, configuration, scene, size):
        """Returns the Loaded scene. A process has only one scene at a time, because llvm kernels would contain
        the plugins of all of them."""
        variant = configuration.variant
        wish = (configuration, scene, size)
        worker = self.worker(variant)
        if variant not in self.loaded or self.loaded[variant].what != wish:
            self.loaded.pop(variant, None)
            self._ask(variant, worker, command="load", file=str(scene.path),
                      defines=configuration.defines(scene, size))
            self.loaded[variant] = Loaded(wish)
        return self.loaded[variant]

    def render(self, configuration, scene, size, samples, seed):
        loaded = self.load(configuration, scene, size)
        output = self.folder / f"{configuration.variant}.npy"
        answer = self._ask(configuration.variant, self.workers[configuration.variant],
                           command="render", samples=samples, seed=seed, output=str(output))
        loaded.warmed.add(samples)
        image = np.load(output).astype(np.float64)
        output.unlink()
        return Rendered(image, answer["seconds"], answer["samples"], answer["processor"])

    def _ask(self, variant, worker, **request):
        try:
            return worker.ask(**request)
        except Refused:
            raise
        except Dead:
            # A new process will be started, because another scene may work.
            self.workers.pop(variant, None)
            self.loaded.pop(variant, None)
            raise

    def close(self):
        for worker in self.workers.values():
            worker.close()
        self.workers.clear()
        self.loaded.clear()


def version_hash():
    """Returns a hash of the pinned versions and of the worker, on which measurements depend."""
    return hash_of_files([HERE.parent / "requirements.txt", HERE / "workers/mitsuba_worker.py"])
