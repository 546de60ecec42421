"""Mitsuba's references for the scenes of tables.SCENES. They are made when they are needed, and kept."""
import subprocess

import numpy as np

from compare import BadInput, load

from .kinome import scene_hash
from .problems import Problem
from .store import hash_of_files, read_json
from .tables import RENDERS, ROOT, Effort

MAKE = ROOT / "validation/references/make.py"
REQUIREMENTS = ROOT / "validation/requirements.txt"
SAMPLER = "multijitter"  # Mitsuba's ldsampler is biased: see references/README.md


class References:
    def __init__(self, python, folder, effort: Effort, log):
        self.python, self.folder, self.effort, self.log = python, folder, effort, log
        self.known = {}

    def path(self, scene, size, timed=False):
        """Returns the path of the EXR file. `timed`: whether the reference is for timed images."""
        samples, seeds = self.samples_and_seeds(scene, timed)
        name = (f"{scene.name}-{size[0]}x{size[1]}-{scene.truth}-"
                f"{'compensated-' if scene.truth_compensated else ''}{samples}x{seeds}-"
                f"{scene_hash(scene.path)}")
        return self.folder / name / f"{scene.name}.exr"

    def samples_and_seeds(self, scene, timed):
        """Returns the numbers of samples and seeds of a reference. For timed images, the number of all samples
        is tables.Scene.timed_share of that for comparisons."""
        seeds = self.effort.truth_seeds * scene.truth_factor * (scene.timed_share if timed else 1)
        fewer = min(seeds / RENDERS, 1)
        return round(self.effort.truth_samples * fewer), round(seeds / fewer)

    def is_there(self, scene, size, timed=False):
        # make.py writes the JSON file last. If it exists, the image is complete.
        note = read_json(self.path(scene, size, timed).with_suffix(".json"))
        pinned = REQUIREMENTS.read_text("utf-8").split()
        return note is not None and f"mitsuba=={note['version']}" in pinned

    def picture(self, scene, size, timed=False):
        """Returns the path of the EXR file. Makes the file if it doesn't exist. Raises Problem."""
        path = self.path(scene, size, timed)
        if not self.is_there(scene, size, timed):
            self._make(scene, path.parent, *size, *self.samples_and_seeds(scene, timed))
        return path

    def _make(self, scene, folder, width, height, samples, seeds):
        if not self.python.is_file():
            raise Problem(f"{scene.name}: no reference without Mitsuba")
        self.log.say(f"{scene.name}: reference by {scene.truth}, {seeds} x {samples} samples")
        command = [self.python, MAKE, scene.path, "--output", folder, "--seeds", str(seeds),
                   "--samples", str(samples), "-D", f"integrator={scene.truth}",
                   "-D", f"sampler={SAMPLER}", "-D", f"width={width}", "-D", f"height={height}"]
        if scene.truth_compensated:
            command += ["-D", "mis_compensation=true"]
        result = subprocess.run(command, check=False, capture_output=True, text=True)
        if result.returncode != 0:
            lines = result.stderr.strip().splitlines() or ["make.py failed"]
            raise Problem(f"{scene.name}: no reference: {lines[-1]}")

    def load(self, scene, size, timed=False):
        """Returns the Estimate and its description. Raises Problem."""
        key = scene.name, size, timed
        if key not in self.known:
            path = self.picture(scene, size, timed)
            self.known[key] = load_reference(path), describe(path)
        return self.known[key]


def load_reference(path):
    """Returns an Estimate. Raises Problem if it has NaN or Inf outside its mask."""
    try:
        found = load(path)
    except BadInput as reason:
        raise Problem(reason) from reason
    if found.nans or found.infinities:
        raise Problem(f"{path.name}: the reference contains {found.nans} NaN and "
                      f"{found.infinities} Inf: it isn't used")
    return found


def describe(path):
    note = read_json(path.with_suffix(".json"))
    kept = ("variant", "integrator", "sampler", "samples_used", "seeds", "not_finite",
            "masked_pixels", "width", "height", "seconds")
    return {key: note[key] for key in kept} | {"hash": hash_of_files([path])}


def own_error(reference):
    """Returns the relMSE of the reference's own noise, which is subtracted from all other errors."""
    r = reference.mean[~reference.masked]
    floor = 0.01 * r.mean() ** 2 or 1.0
    return float(np.mean(reference.variance[~reference.masked] / (r ** 2 + floor)))
