"""Blender's Cycles as a renderer of the benchmark, for scenes whose materials it supports."""
import pathlib

import numpy as np

from compare import BadInput, Estimate, compare

from .contestants import WARM_UP, Run
from .problems import Problem
from .store import hash_of_files
from .tables import FAST, THREADS
from .worker import Worker

HERE = pathlib.Path(__file__).resolve().parent
AGREE_RENDERS, AGREE_SAMPLES, AGREE_ALPHA = 16, 64, 0.001


class Cycles:
    kind = "peer"
    claimed = True
    converges_to_points = False
    samples = FAST

    def __init__(self, python, scene, size, folder, command=None):
        if not pathlib.Path(python).is_file():
            raise Problem("the package bpy isn't installed (this Python has none, or pip failed)")
        self.folder, self.name = folder, "Cycles"
        self.key = {"version": hash_of_files([HERE.parent / "requirements-cycles.txt",
                                              HERE / "workers/cycles_worker.py"])}
        self.worker = Worker("Cycles", [*(command or [python, HERE / "workers/cycles_worker.py"]),
                                        str(THREADS)])
        try:
            self.worker.ask(command="hello")
            self.worker.ask(command="load", file=str(scene.path), width=size[0], height=size[1])
        except Problem:
            self.close()
            raise
        self.warmed = set()

    def must_agree(self, truth):
        """Raises Problem unless its images have the same expected value as the reference."""
        renders = [self._render(AGREE_SAMPLES, seed)[0] for seed in range(AGREE_RENDERS)]
        try:
            verdict = compare(Estimate.from_renders("Cycles", renders), truth, AGREE_ALPHA)
        except BadInput as reason:
            raise Problem(reason) from reason
        if not verdict.passed:
            worst = next(test for test in verdict.tests if not test.passed)
            raise Problem(f"its image differs from the reference: {worst.name}, {worst.worst}")

    def _render(self, samples, seed):
        output = self.folder / "cycles.npy"
        answer = self.worker.ask(command="render", samples=samples, seed=seed, output=str(output))
        image = np.load(output).astype(np.float64)
        output.unlink()
        return image, answer["seconds"]

    def run(self, samples, seed):
        if samples not in self.warmed:
            self._render(samples, WARM_UP)
            self.warmed.add(samples)
        image, seconds = self._render(samples, seed)
        return Run(image, seconds, samples, {})

    def close(self):
        self.worker.close()
