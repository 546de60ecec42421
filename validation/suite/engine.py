"""Measures the speed of the engine and of Mitsuba's llvm_ad_rgb, and the other goals of the engine.
engine_analysis.py computes the results and defines the goals."""
import dataclasses
import pathlib
import time
import typing

import numpy as np

from program import commit, machine

from . import third_party
from .contestants import WARM_UP, Ours, Theirs
from .engine_scenes import WATERTIGHT, like_for_like
from .kinome import scene_hash
from .others import BUSY, Others, cores_of_others
from .peers import Configuration, Unavailable, version_hash
from .problems import Problem
from .store import hash_of_files
from .tables import (AREA, BOUNCE, ENGINE_PARTS, HEBE, ISAS, ISA_SCENES, PLAIN, PLUGIN_SCENE,
                     SCENES, SHORT_SCENES, SMALL_SCENES, THREADS, TOGETHER, WATERTIGHT_SCENES,
                     WITHOUT_PEER, Method, Scene)

VARIANT = "llvm_ad_rgb"
FIRST_SEED = 1
LOW, HIGH = (16, 64), (64, 256)  # pairs of sample counts per pixel, between which slopes are measured
MIN_SECONDS = 0.075  # seconds; if Mitsuba needs less for 16 samples, both renderers use HIGH
SHORT, SHORT_SIZE = (4,), (192, 144)
PRODUCT_SAMPLES = (4, 16, 64)
SIZE, LARGE = (256, 256), (1024, 1024)
MEMORY_SAMPLES = 16
DEFAULT_SECONDS = 20  # assumed seconds of a unit, if no unit of its part was measured yet


@dataclasses.dataclass(frozen=True)
class Unit:
    """One scene in one part. A unit is measured, stored or left out as a whole."""

    part: str
    scene: Scene
    size: tuple
    repeats: int
    max_depth: int | None = None

    @property
    def name(self):
        return f"{self.scene.name}, {self.part}" + (
            f" to depth {self.max_depth}" if self.max_depth else "")


class Entrant(typing.NamedTuple):
    """A renderer that takes turns, with its label and its sample counts per pixel."""

    label: str
    renderer: Ours | Theirs
    samples: tuple


def units(words, parts, quick):
    """Returns the units, shorter parts first. `words`: names of scenes; empty for all, except that `path`
    then uses only default scenes and scenes with bounced or local light, because all scenes would take more
    than 10 minutes. `parts`: some of ENGINE_PARTS; empty for all."""
    few = 1 if quick else 3
    large, small = SCENES, [Scene(path.stem, str(path), PLAIN, (), "", ())
                            for path in SMALL_SCENES if path.stem not in WITHOUT_PEER]
    by_name = {scene.name: scene for scene in large}
    hebe = by_name[HEBE]
    bounced = [scene for scene in large if scene.name in words or not words and
               (not scene.asked or scene.group in (BOUNCE, AREA, TOGETHER))]
    found = [Unit("product", hebe, SIZE, few), Unit("threads", hebe, SIZE, few),
             Unit("memory", hebe, LARGE, 1),
             *(Unit("short", by_name[name], SHORT_SIZE, 3 * few) for name in SHORT_SCENES),
             *(Unit("isa", by_name[name], SIZE, few) for name in ISA_SCENES),
             Unit("plugin", by_name[PLUGIN_SCENE], SIZE, few),
             *(Unit("watertight", by_name[name], SIZE, few) for name in WATERTIGHT_SCENES),
             *(Unit("direct", scene, SIZE, few) for scene in (*large, *small)),
             *(Unit("path", scene, SIZE, few, depth) for depth in (2, 5) for scene in bounced)]
    return [unit for unit in found if unit.part in (parts or ENGINE_PARTS)
            and unit.scene.name in (words or (unit.scene.name,))]


class Engine:
    """Measures the units that aren't in the store."""

    def __init__(self, kinome, mitsuba, sampler, form, store, folder, log):
        """`form`: "full" or "quick"; `folder`: for copies of scenes."""
        self.kinome, self.mitsuba, self.sampler, self.form = kinome, mitsuba, sampler, form
        self.store, self.folder, self.log = store, folder, log
        self.machine = machine()

    def run(self, wanted, seconds):
        """Returns a row for each unit. Begins no unit that would end after `seconds`, estimated by the longest
        unit of its part so far. Reports missing units, which a rerun measures."""
        rows, longest, start = [], {}, time.monotonic()
        for i, unit in enumerate(wanted):
            known = self.store.get(self.key(unit))
            before = time.monotonic()
            if known is None and before - start + longest.get(unit.part, DEFAULT_SECONDS) > seconds:
                missing = sum(self.store.get(self.key(u)) is None for u in wanted[i:])
                self.log.problem(f"time is up: {missing} of {len(wanted)} measurements are "
                                 "missing; run the same command without --fresh to continue")
                wanted = [u for u in wanted[i:] if self.store.get(self.key(u)) is not None]
                return rows + [self.row(u) for u in wanted]
            try:
                rows.append(self.row(unit))
            except Problem as reason:
                self.log.problem(f"{unit.name}: {reason}")
            if known is None:
                longest[unit.part] = max(longest.get(unit.part, 0), time.monotonic() - before)
        return rows

    def key(self, unit):
        return {"engine": unit.part, "name": unit.scene.name, "scene": scene_hash(unit.scene.path),
                "size": unit.size, "max_depth": unit.max_depth, "repeats": unit.repeats,
                "form": self.form, "sampler": self.sampler, "program": self.kinome.program,
                "version": version_hash(),
                "code": hash_of_files(map(pathlib.Path, (__file__, third_party.__file__))),
                "machine": self.machine["processor"], "cores": self.machine["cores"],
                "threads": THREADS}

    def row(self, unit):
        """Returns the values of one unit in the form of engine_analysis.py."""
        values = self.store.recall(self.key(unit), lambda: self.measure(unit))
        return {"part": unit.part, "scene": unit.scene.name, "size": list(unit.size),
                "max_depth": unit.max_depth, "sampler": self.sampler,
                "program": self.kinome.program, "machine": self.machine, **values}

    def measure(self, unit):
        self.log.say(unit.name)
        entrants = self.entrants(unit)
        others, runs = Others(), []
        for seed in range(FIRST_SEED, FIRST_SEED + unit.repeats):
            # All renderers take turns for each sample count, so that other load of the machine affects all.
            for step in range(max((len(e.samples) for e in entrants), default=0)):
                for entrant in list(entrants):
                    if step < len(entrant.samples):
                        runs += self.turn(unit, entrant, entrant.samples[step], seed, entrants)
        taken = cores_of_others([others.taken()])
        if not runs:
            raise Problem("nothing could be rendered")
        if taken > BUSY * self.machine["cores"]:
            self.log.say(f"{unit.name}: other processes used {taken:.1f} of "
                         f"{self.machine['cores']} cores meanwhile, so the times are too long")
        return {"commit": commit(), "cores_of_others": taken, "runs": runs}

    def turn(self, unit, entrant, samples, seed, entrants):
        """Renders once; returns a list of one run, or an empty list. Removes an entrant that fails."""
        try:
            made = entrant.renderer.run(samples, seed)
        except Problem as reason:
            entrants.remove(entrant)
            if not isinstance(reason, Unavailable):  # an Unavailable was already reported
                where = "" if unit.part == "isa" else f"{unit.name}: "
                self.log.problem(f"{where}{entrant.label} is left out: {reason}")
            return []
        stats = made.stats
        bsdfs = sorted(p.split("/")[1] for p in stats.get("plugins", ()) if p.startswith("bsdf/"))
        return [{"label": entrant.label, "seed": seed, "samples": made.samples,
                 "seconds": made.seconds, "processor": stats["processor_seconds"],
                 "mean": float(np.nan_to_num(made.image, posinf=0, neginf=0).mean()),
                 "embree_share": stats.get("embree_share"), "bsdfs": bsdfs,
                 "rays": sum(stats.get("rays", {}).values()),
                 "memory": stats.get("peak_memory_bytes")}]

    def entrants(self, unit):
        return getattr(self, f"entrants_of_{unit.part}")(unit)

    def ours(self, unit, integrator, options=(), size=None, **defines):
        method = Method(integrator, {"integrator": integrator, "sampler": self.sampler, **defines},
                        "mitsuba", (), ())
        return Ours(self.kinome, method, unit.scene, size or unit.size, options)

    def both(self, unit, integrator, samples=None):
        """Returns the entrants of Kinome and Mitsuba. A warm-up render by Mitsuba decides the sample
        counts."""
        unit = dataclasses.replace(unit, scene=self.like_for_like(unit.scene))
        depth = {"max_depth": str(unit.max_depth)} if unit.max_depth else {}
        found = [Entrant("ours", self.ours(unit, integrator, **depth), samples or LOW)]
        theirs = Theirs(self.mitsuba, Configuration(VARIANT, integrator, self.sampler, False,
                                                    unit.max_depth), unit.scene, unit.size)
        try:
            seconds = theirs.run((samples or LOW)[0], WARM_UP).seconds
        except Unavailable:
            return found
        except Problem as reason:
            self.log.problem(f"{unit.name}: Mitsuba is left out: {reason}")
            return found
        apt = samples or (HIGH if seconds < MIN_SECONDS else LOW)
        return [found[0]._replace(samples=apt), Entrant("Mitsuba", theirs, apt)]

    def entrants_of_direct(self, unit):
        return self.both(unit, "direct")

    def entrants_of_path(self, unit):
        return self.both(unit, "path")

    def entrants_of_short(self, unit):
        return self.both(unit, "direct", SHORT)

    def entrants_of_isa(self, unit):
        return [Entrant(isa, self.ours(unit, "direct", ("-t", str(THREADS), "--isa", isa)), LOW)
                for isa in ISAS]

    def entrants_of_watertight(self, unit):
        unit = dataclasses.replace(unit, scene=self.like_for_like(unit.scene))
        return [Entrant(label, self.ours(unit, "direct", **{WATERTIGHT: value}), LOW)
                for label, value in (("watertight", "true"), ("not watertight", "false"))]

    def entrants_of_plugin(self, unit):
        self.folder.mkdir(parents=True, exist_ok=True)
        plugins = third_party.build(self.kinome.build, self.folder.parent / "third-party")
        copy = third_party.scene_with_reflector(unit.scene.path, self.folder)
        unit = dataclasses.replace(unit, scene=dataclasses.replace(unit.scene, file=str(copy)))
        options = ("-t", str(THREADS), "--plugin-path", str(plugins))
        return [Entrant(label, self.ours(unit, "direct", options, reflector=name), LOW)
                for label, name in third_party.REFLECTORS.items()]

    def entrants_of_product(self, unit):
        # An image of a few pixels measures the time of loading, which isn't rendering.
        return [Entrant("start", self.product(unit, size=(16, 16)), (1,)),
                Entrant("product", self.product(unit), PRODUCT_SAMPLES)]

    def entrants_of_threads(self, unit):
        return [Entrant(f"{name}, {count}", make(("-t", str(count))), PRODUCT_SAMPLES[-1:])
                for name, make in self.methods(unit).items() for count in (1, 2)]

    def entrants_of_memory(self, unit):
        return [Entrant(name, make(), (MEMORY_SAMPLES,))
                for name, make in self.methods(unit).items()]

    def methods(self, unit):
        return {"direct": lambda options=(): self.ours(unit, "direct", options),
                "product": lambda options=(): self.product(unit, options)}

    def product(self, unit, options=(), size=None):
        return self.ours(unit, "clustered", options, size, importance="product")

    def like_for_like(self, scene):
        copy = like_for_like(scene.path, self.folder, scene.path in SMALL_SCENES)
        return dataclasses.replace(scene, file=str(copy))
