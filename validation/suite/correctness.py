"""Compares all unbiased integrators on all scenes with Mitsuba or groundtruth."""
import dataclasses
import re

from compare import BadInput, Errors, Estimate, compare, flip
from compare.verdict import sidak

from . import pictures
from .kinome import scene_hash, sized, with_parameters
from .problems import Problem
from .store import hash_of_files
from .tables import (CUT, MEDIA_INTEGRATORS, METHODS, POINTS, ROOT, SMALL_MEDIA, SMALL_SCENES,
                     chosen)
from .truth import load_reference

FAMILY_ALPHA = 0.01  # probability that any of all checks fails by chance
REFERENCES = ROOT / "validation/references"
HERE, COMPARE = ROOT / "validation/suite", ROOT / "validation/compare"
SEED = 1000  # first seed; clustered and groundtruth share their seeds, and so their light points
CLUSTERED_SAMPLES = 4  # samples of each render that is compared with groundtruth


@dataclasses.dataclass(frozen=True)
class Check:
    """One row of the table."""

    scene: str
    method: str
    truth: str
    path: object
    defines: tuple
    big: object = None  # the row of tables.SCENES
    factor: int = 1  # Method.check_factor


def default_integrator(path):
    """Returns the default integrator of a small scene."""
    found = re.search(r'<default name="integrator" value="(\w+)"/>', path.read_text("utf-8"))
    if not found:
        raise Problem(f"{path.name}: has no default for $integrator")
    return found[1]


def checks_of_small(path):
    if path in SMALL_MEDIA:
        for integrator in MEDIA_INTEGRATORS:
            yield Check(path.stem, integrator, "mitsuba", path, (("integrator", integrator),))
        return
    own = default_integrator(path)
    yield Check(path.stem, own, "mitsuba", path, (("integrator", own),))
    for method in METHODS:
        # References of integrators other than `direct` include more than direct light.
        if method.truth == "groundtruth" or (method.any_light and own == "direct"):
            yield Check(path.stem, method.name, method.truth, path, tuple(method.defines.items()))


def checks_of_big(scene):
    for method in METHODS:
        if method.serves(scene):
            yield Check(scene.name, method.name, method.truth, scene.path,
                        tuple(method.defines.items()), scene, method.check_factor)


def plan(effort, wanted):
    """Returns all checks, or those of the scenes `wanted`. Raises Problem."""
    found = []
    for path in SMALL_SCENES + SMALL_MEDIA if wanted else effort.small_scenes:
        if not wanted or path.stem in wanted:
            found += checks_of_small(path)
    for scene in chosen(wanted, effort):
        found += checks_of_big(scene)
    return found


def alpha_for(effort, checks):
    """Returns the false-alarm rate of one check, with the Šidák correction for all checks of a run without
    words. So a run of a part of the checks gives the same results."""
    return sidak(FAMILY_ALPHA, max(len(plan(effort, ())), len(checks)))


def finite(figures):
    """Limits values because JSON has no infinity. t is infinite if an image without noise differs."""
    return {k: min(max(v, -1e9), 1e9) if isinstance(v, float) else v for k, v in figures.items()}


def paired(made, truth):
    """Returns two estimates with the noise of the differences between renders with the same seed. Camera
    rays and light points, which these renders share, don't contribute to it."""
    if (made.masked | truth.masked).any():
        return made, truth
    stack = made.stack - truth.stack + truth.mean
    left = Estimate.from_renders(made.name, stack, max(made.rounding, truth.rounding))
    # All of the noise is on one side, but the tests skip values with noise on only one side. So the other
    # side gets a thousandth of the variance, which is harmless.
    return left, Estimate(truth.name, truth.mean, left.variance / 1000, truth.renders,
                          rounding=truth.rounding)


class Correctness:
    def __init__(self, kinome, references, effort, store, folder, log):
        self.kinome, self.references, self.effort = kinome, references, effort
        self.store, self.folder, self.log = store, folder, log
        self.truths = {}

    def run(self, checks):
        """Returns rows for the table, one for each check that was possible."""
        alpha = alpha_for(self.effort, checks)
        rows = []
        for number, check in enumerate(checks, 1):
            self.log.say(f"check {number} of {len(checks)}: {check.scene}, {check.method}")
            try:
                rows.append(self.row(check, alpha))
            except (Problem, BadInput, OSError) as reason:
                self.log.problem(f"{check.scene}, {check.method}: {reason}"
                                 if check.scene not in str(reason) else reason)
        return rows

    def row(self, check, alpha):
        key = {"check": check.scene, "method": check.method, "truth": check.truth,
               "scene": scene_hash(check.path), "program": self.kinome.program, "alpha": alpha,
               "defines": dict(self.defines(check)), "reference": self.truth_hash(check),
               "tests": hash_of_files([HERE / "correctness.py", *COMPARE.glob("*.py")])}
        row = self.store.recall(key, lambda: self.measure(check, alpha))
        return {"scene": check.scene, "method": check.method, "truth": check.truth,
                "program": self.kinome.program, **row}

    def truth_hash(self, check):
        if check.truth == "groundtruth":
            return "groundtruth"
        if check.big:
            return self.reference(check)[1]["hash"]
        return hash_of_files([REFERENCES / f"{check.scene}.exr"])

    def reference(self, check):
        return self.references.load(check.big, self.effort.size(check.big))

    def measure(self, check, alpha):
        path, options = self.scene_file(check)
        truth = self.truth(check, path, options)
        made = self.kinome.estimate(check.method, path, self.defines(check), SEED, options)
        if check.truth == "groundtruth":
            made, truth = paired(made, truth)
        verdict = compare(made, truth, alpha)
        masked = made.masked | truth.masked
        row = {"passed": verdict.passed, "masked": verdict.masked, "notes": verdict.notes,
               "not_finite": made.nans + made.infinities,
               "tests": {t.name: finite(dataclasses.asdict(t)) for t in verdict.tests},
               "relmse": Errors.of(made.mean, truth, masked).relmse,
               "flip": flip(made.mean, truth.mean, masked),
               "picture": pictures.difference(made.mean, truth.mean, masked)}
        if not verdict.passed:
            from compare import picture  # imported late because matplotlib takes a second to load
            target = self.folder / f"{check.scene}-{check.method.replace(' ', '-')}.png"
            target.parent.mkdir(parents=True, exist_ok=True)
            picture.write(target, made, truth, verdict)
            self.log.say(f"failed: {check.scene}, {check.method}: see {target}")
        return row

    @staticmethod
    def needs_parameters(check):
        """Returns whether the integrator of a small scene must be replaced by one that accepts parameters."""
        return check.path not in SMALL_MEDIA and dict(check.defines)["integrator"] == "clustered"

    def scene_file(self, check):
        """Returns the file to render and its options."""
        if check.big or not self.needs_parameters(check):
            return check.path, ()
        copy = with_parameters(check.path, self.folder / "scenes")
        return copy, ("-a", str(check.path.parent))

    def defines(self, check):
        found = {"sampler": "ldsampler", **dict(check.defines)}
        clustered = check.truth == "groundtruth"
        found["spp"] = CLUSTERED_SAMPLES if clustered else (
            check.factor * self.effort.check_samples if check.big else 16)
        if check.big:
            size = self.effort.size(check.big)
            found |= sized(check.big, [n // 2 for n in size] if clustered else size)
            found |= check.big.depth(found["integrator"])
        elif self.needs_parameters(check):
            found["max_depth"] = 2  # a parameter of the copy of scene_file()
        return found | (POINTS | CUT if clustered else {})

    def truth(self, check, path, options):
        if check.truth == "mitsuba":
            return (self.reference(check)[0] if check.big
                    else load_reference(REFERENCES / f"{check.scene}.exr"))
        # All modes of clustered share one groundtruth with the same camera rays and light points.
        if check.scene not in self.truths:
            own = {k: v for k, v in self.defines(check).items()
                   if k not in CUT and k != "importance"}
            own |= {"integrator": "groundtruth"}
            self.truths = {check.scene: self.kinome.estimate("groundtruth", path, own, SEED,
                                                             options)}
        return self.truths[check.scene]
