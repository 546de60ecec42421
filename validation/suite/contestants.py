"""Renderers for the benchmark: each has a name, sample counts, and run(samples, seed)."""
import dataclasses

import numpy as np

from .kinome import sized
from .peers import version_hash

WARM_UP = 987654  # seed of renders that aren't timed


@dataclasses.dataclass
class Run:
    image: np.ndarray
    seconds: float
    samples: int
    extra: dict
    # The program's statistics for Kinome, and the available values for other renderers. "processor_seconds"
    # are those of the whole process for Kinome, and those of rendering for Mitsuba.
    stats: dict = dataclasses.field(default_factory=dict)


class Ours:
    kind = "ours"

    def __init__(self, kinome, method, scene, size, options=()):
        """`options`: further options of the program."""
        self.kinome, self.method, self.scene = kinome, method, scene
        self.options = {"options": options} if options else {}
        self.name, self.samples = f"Kinome {method.name}", method.samples
        self.defines = {"sampler": "ldsampler", **scene.depth(method.defines["integrator"]),
                        **method.defines, **sized(scene, size)}
        self.key = {"program": kinome.program, "defines": self.defines}
        self.converges_to_points = method.truth == "groundtruth"
        self.claimed = method.claimed

    def run(self, samples, seed):
        made = self.kinome.render(self.scene.path, {**self.defines, "spp": samples}, seed,
                                  **self.options)
        return Run(made.image, made.seconds, made.samples,
                   {"wall": made.wall, "embree_share": made.embree_share}, made.stats)


class Theirs:
    """A configuration of Mitsuba. Each sample count is rendered once before it is timed, because the llvm
    variants compile, and all variants access their memory for the first time."""

    kind = "peer"
    claimed = True
    converges_to_points = False

    def __init__(self, mitsuba, configuration, scene, size):
        self.mitsuba, self.configuration = mitsuba, configuration
        self.scene, self.size = scene, size
        self.name, self.samples = configuration.name, mitsuba.samples
        self.key = {"version": version_hash(), "defines": configuration.defines(scene, size),
                    "variant": configuration.variant}

    def run(self, samples, seed, warm=True):
        what = (self.configuration, self.scene, self.size)
        if warm and samples not in self.mitsuba.load(*what).warmed:
            self.mitsuba.render(*what, samples, WARM_UP)
        made = self.mitsuba.render(*what, samples, seed)
        return Run(made.image, made.seconds, made.samples, {},
                   {"processor_seconds": made.processor})
