"""Renderers as the benchmark sees them: a name, sample counts, and run(samples, seed)."""
import dataclasses

import numpy as np

from .kinome import sized
from .peers import version_hash


@dataclasses.dataclass
class Run:
    image: np.ndarray
    seconds: float
    samples: int
    extra: dict


class Ours:
    kind = "ours"

    def __init__(self, kinome, method, scene, size):
        self.kinome, self.method, self.scene = kinome, method, scene
        self.name, self.samples = f"Kinome {method.name}", method.samples
        self.defines = {"sampler": "ldsampler", **method.defines, **sized(scene, size)}
        self.key = {"program": kinome.program, "defines": self.defines}
        self.converges_to_points = method.truth == "groundtruth"

    def run(self, samples, seed):
        made = self.kinome.render(self.scene.path, {**self.defines, "spp": samples}, seed)
        return Run(made.image, made.seconds, made.samples,
                   {"wall": made.wall, "embree_share": made.embree_share})


class Theirs:
    """A configuration of Mitsuba's. Each sample count is rendered once before it is timed: llvm
    compiles, and both touch their memory for the first time."""

    kind = "peer"
    converges_to_points = False

    def __init__(self, mitsuba, configuration, scene, size):
        self.mitsuba, self.configuration = mitsuba, configuration
        self.scene, self.size = scene, size
        self.name, self.samples = configuration.name, mitsuba.samples
        self.key = {"version": version_hash(), "defines": configuration.defines(scene, size),
                    "variant": configuration.variant}
        self.warmed = set()

    def run(self, samples, seed):
        if samples not in self.warmed:
            self._render(samples, 987654)
            self.warmed.add(samples)
        image, seconds, used = self._render(samples, seed)
        return Run(image, seconds, used, {})

    def _render(self, samples, seed):
        return self.mitsuba.render(self.configuration, self.scene, self.size, samples, seed)
