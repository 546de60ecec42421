"""Measures the processor time in which `clustered` and Mitsuba's fastest configuration reach an error
with any number of bounces. Writes validation/bounces/.

    sh validation/run.sh benchmark blocks --quick      # builds, installs Mitsuba, makes the assets
    /usr/bin/python3 validation/bounces.py [--build build] [--mitsuba PYTHON] [--seeds N] [--budget S] [SCENE...]

max_depth is -1 in every scene. Time is the processor time (user and system) of all threads, so other
programs on the machine hardly lengthen it. Mitsuba's time is that of rendering alone: each image is
rendered once before it is timed, which excludes loading and compilation. Kinome's time is that of the
whole process, minus that of an image of 16x12 pixels with one sample by `path`. The difference excludes
start-up, loading and writing.

No reference is needed. The error is the variance between seeds, as in ablation.py, divided by the squared
mean of all images. It doesn't include bias: the page compares the means of the images, and the test
`references` compares images of these or similar scenes. Images and times are kept in the build folder, so
the same command continues an interrupted measurement. Given scenes replace their entries on the page.
"""
import argparse
import dataclasses
import math
import pathlib
import re
import statistics
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import bounces_page  # noqa: E402
from program import ROOT, commit, machine  # noqa: E402
from suite.kinome import Kinome, scene_hash, sized, with_parameters  # noqa: E402
from suite.peers import Configuration, Mitsuba, version_hash  # noqa: E402
from suite.problems import Log, Problem  # noqa: E402
from suite.store import Store, digest, read_json, write_json  # noqa: E402
from suite.tables import SAMPLERS, SCENES, Scene  # noqa: E402

SIZE = (192, 144)
NAMES = ("room", "corridor", "attic", "evening", "box", "plate", "cornell_diffuse", "cornell_metal",
         "cornell_glass", "sunroom", "kitchen")
# Light tracing doesn't find light that is seen through glass, and seldom hits a room's window from outside.
WITHOUT_PTRACER = ("room", "cornell_glass", "sunroom")
OURS, THEIRS = (4, 16, 64, 256), (16, 64, 256)
SEARCH_SAMPLES, SEARCH_SEEDS = 16, (101, 102)
WARM_UP = 987654
VARIANT = "llvm_ad_rgb"  # scalar_rgb is the same estimator, and took 2.6 to 3.7 times as long
MAX_WORK_RATIO = 3  # maximum work (processor time x error) of a configuration, relative to the least so far
FLOOR = 0.01  # share of the squared mean that is added to the denominator of relMSE
MAX_NOT_FINITE = 1e-3  # share of values that aren't finite, above which a configuration is left out
MIN_ERROR = 7e-4  # error below which larger sample counts are skipped
BSDF = {"cornell_diffuse": '<ref id="white"/>',
        "cornell_metal": '<bsdf type="roughconductor"> <string name="material" value="Al"/> '
                         '<float name="alpha" value="0.1"/> </bsdf>'}
BALLS = (r'<bsdf type="roughconductor">.*?</bsdf>', r'<bsdf type="dielectric"/>')


def scene_of(name, folder):
    """Returns a tables.Scene. Derives the Cornell boxes from the small scene, and makes its image size a
    parameter."""
    peers = ("path",) if name in WITHOUT_PTRACER else ("path", "ptracer")
    for scene in SCENES:
        if scene.name == name:
            return dataclasses.replace(scene, peers=peers)
    source = ROOT / "validation/scenes/cornell.xml"
    path = with_parameters(source, folder / name)
    text = path.read_text(encoding="utf-8")
    for pattern in BALLS:
        if name in BSDF:
            text = re.sub(pattern, BSDF[name], text)
    for side, value in (("width", 64), ("height", 48)):
        text = text.replace(f'name="{side}" value="{value}"', f'name="{side}" value="${side}"')
    text = text.replace('<default name="spp"', '<default name="width" value="64"/>'
                        '<default name="height" value="48"/><default name="file_format" '
                        'value="openexr"/><default name="spp"')
    text = text.replace('<rfilter type="box"/>', '<string name="file_format" value="$file_format"/>'
                        '<string name="pixel_format" value="rgb"/><rfilter type="box"/>')
    path.write_text(text, encoding="utf-8")
    return Scene(name, str(path), "", SIZE, "path", peers)


class Bounces:
    """Measures scenes. Subclasses may measure more renderers, which `sides` returns."""

    size = SIZE
    samplers = SAMPLERS  # of Mitsuba
    min_error = MIN_ERROR

    def __init__(self, kinome, mitsuba, store, folder, options, log):
        self.kinome, self.mitsuba, self.store, self.log = kinome, mitsuba, store, log
        self.folder, self.options = folder, options
        (folder / "pictures").mkdir(parents=True, exist_ok=True)

    def measure(self, scene, who, samples, seed, render):
        """Returns {"processor", "samples", "image", "not_finite"} from the store, or calls `render` if it is
        missing. Values of the image that aren't finite become 0; `not_finite` is their share."""
        key = {"bounces": scene.name, "scene": scene_hash(scene.path), "size": self.size, "who": who,
               "samples": samples, "seed": seed, "machine": machine()["processor"]}
        path = self.folder / f"pictures/{digest(key)}.npy"
        found = self.store.get(key)
        if found is None or not path.is_file():
            image, processor, used = render(samples, seed)
            np.save(path, image.astype(np.float32))
            found = {"processor": processor, "samples": used}
            self.store.put(key, found)
        image = np.load(path).astype(np.float64)
        return found | {"image": np.nan_to_num(image, nan=0, posinf=0, neginf=0),
                        "not_finite": 1 - np.isfinite(image).mean()}

    def ours(self, scene, integrator="clustered"):
        """Returns (who, render) for one of Kinome's integrators."""
        defines = {"integrator": integrator, "max_depth": -1, "sampler": "ldsampler",
                   **sized(scene, self.size)}
        small = defines | {"integrator": "path", "width": 16, "height": 12, "spp": 1}
        self.kinome.render(scene.path, small, 0)  # brings the scene's files into the page cache
        start = statistics.median(self.kinome.render(scene.path, small, seed).stats["processor_seconds"]
                                  for seed in range(3))

        def render(samples, seed):
            made = self.kinome.render(scene.path, {**defines, "spp": samples}, seed)
            return made.image, max(made.stats["processor_seconds"] - start, 1e-3), made.samples

        name = "kinome" if integrator == "clustered" else f"kinome {integrator}"
        return [name, self.kinome.program], render

    def theirs(self, scene, configuration):
        warmed = set()

        def render(samples, seed):
            if samples not in warmed:
                self.mitsuba.render(configuration, scene, self.size, samples, WARM_UP)
                warmed.add(samples)
            made = self.mitsuba.render(configuration, scene, self.size, samples, seed)
            return made.image, made.processor, made.samples

        return [configuration.name, version_hash()], render

    def search(self, scene):
        """Returns configurations in ascending order of their work at few samples, as rows of
        {"configuration", "name", "processor", "relmse", "trimmed"}. Skips the other samplers of an
        integrator whose work exceeds MAX_WORK_RATIO with the first one."""
        found, left_behind = [], set()
        for integrator in scene.peers:
            for sampler in self.samplers:
                for compensated in (False, True) if scene.envmap else (False,):
                    if integrator in left_behind:
                        continue
                    one = Configuration(VARIANT, integrator, sampler, compensated, -1)
                    who, render = self.theirs(scene, one)
                    try:
                        runs = [self.measure(scene, who, SEARCH_SAMPLES, seed, render)
                                for seed in SEARCH_SEEDS]
                    except Problem as reason:
                        self.log.problem(f"{scene.name}: {reason}")
                        left_behind.add(integrator)
                        continue
                    if max(run["not_finite"] for run in runs) > MAX_NOT_FINITE:
                        self.log.say(f"{scene.name}: {one.name} is left out: pixels are NaN")
                        continue
                    found.append((one, runs))
                    rows = ranked(found)
                    self.log.say(f"{scene.name}: {one.name}: {runs[0]['processor']:.2f} s")
                    if work(next(r for r in rows if r["name"] == one.name)) > MAX_WORK_RATIO * work(rows[0]):
                        left_behind.add(integrator)
        if not found:
            raise Problem(f"{scene.name}: no configuration of Mitsuba can render it")
        return ranked(found)

    def sides(self, scene, fastest):
        """Returns {side: (who, render, sample counts)}. `fastest`: Mitsuba's configuration. The key of each of
        Kinome's integrators is "ours" or its name."""
        return {"ours": (*self.ours(scene), OURS), "peer": (*self.theirs(scene, fastest), THEIRS)}

    def scene(self, scene):
        """Measures a scene; returns its entry for the page."""
        rows = self.search(scene)
        sides = self.sides(scene, rows[0]["configuration"])
        runs = {side: {} for side in sides}
        last = {side: max(counts) for side, (_, _, counts) in sides.items()}
        for seed in range(1, self.options.seeds + 1):
            for step in range(max(len(counts) for _, _, counts in sides.values())):
                for side, (who, render, counts) in sides.items():
                    if step >= len(counts) or counts[step] > last[side]:
                        continue
                    samples = counts[step]
                    run = self.measure(scene, who, samples, seed, render)
                    runs[side].setdefault(run["samples"], []).append(run)
                    # Only the first seed decides, so that every count has all seeds or none.
                    if seed == 1 and run["processor"] * 4 > self.options.budget:
                        last[side] = samples
            self.log.say(f"{scene.name}: seed {seed} of {self.options.seeds}")
            if seed == 2:
                for side in runs.keys() - {"peer"}:
                    self.stop_at_min_error(runs[side], last, side)
        return self.entry(rows, runs)

    def stop_at_min_error(self, runs, last, side):
        """Limits our sample counts to the first one with an error below `min_error`."""
        for samples, made in sorted(runs.items()):
            images = [run["image"] for run in made]
            if errors(images, np.mean(images, axis=0))["relmse"] < self.min_error:
                last[side] = samples
                break

    def entry(self, rows, runs):
        best = {side: found[max(found)] for side, found in runs.items()}
        weights, images = [], []
        for made in best.values():
            stack = [run["image"] for run in made]
            weights.append(len(stack) / np.var(stack, axis=0, ddof=1).mean())
            images.append(np.mean(stack, axis=0))
        mean = np.average(images, axis=0, weights=weights)
        means = {side: [float(run["image"].mean()) for run in made] for side, made in best.items()}
        curves = {side: [{"samples": samples, "processor": [run["processor"] for run in made],
                          **errors([run["image"] for run in made], mean)}
                         for samples, made in sorted(found.items()) if len(made) > 1]
                  for side, found in runs.items()}
        return {"peer": rows[0]["name"], "curves": curves, "commit": commit(),
                **self.differences(means),
                "tried": [{k: v for k, v in row.items() if k != "configuration"} for row in rows]}

    def differences(self, means):
        """Returns the relative difference of our mean to Mitsuba's, and its standard error. `means`: those of
        the images of each side."""
        difference, error = difference_of(means["ours"], means["peer"])
        return {"difference": difference, "difference_error": error}


def difference_of(ours, theirs):
    """Returns the relative difference between two lists of means, and its standard error."""
    middle = statistics.fmean(theirs)
    error = math.sqrt(sum(statistics.variance(m) / len(m) for m in (ours, theirs)))
    return statistics.fmean(ours) / middle - 1, error / middle


def ranked(found):
    """Returns the rows of Bounces.search. `found`: pairs of a configuration and its runs."""
    mean = np.mean([run["image"] for _, runs in found for run in runs], axis=0)
    rows = ({"configuration": one, "name": one.name,
             "processor": min(run["processor"] for run in runs),
             **errors([run["image"] for run in runs], mean)} for one, runs in found)
    return sorted(rows, key=work)


def work(row):
    """Returns processor time x error. Uses the trimmed error because single bright pixels would dominate
    the other."""
    return row["processor"] * row["trimmed"]


def errors(images, mean):
    """Returns the variance between images, divided by mean² + FLOOR x (mean of the whole image)²: its mean
    over pixels and channels, and that mean without the largest 0.1 % of the values."""
    values = np.sort((np.var(images, axis=0, ddof=1)
                      / (mean ** 2 + FLOOR * mean.mean() ** 2)).ravel())
    return {"relmse": float(values.mean()),
            "trimmed": float(values[:-max(1, len(values) // 1000)].mean())}


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=", ".join(NAMES))
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--mitsuba", type=pathlib.Path, metavar="PYTHON",
                        help="a Python with Mitsuba 3.9.1; default: that of validation/run.sh")
    parser.add_argument("--seeds", type=int, default=4, help="number of seeds, at least 2; default: 4")
    parser.add_argument("--budget", type=float, default=20.0, metavar="SECONDS",
                        help="maximum processor time of a render; default: 20")
    options = parser.parse_args()
    unknown = [name for name in options.scenes if name not in NAMES]
    if unknown:
        parser.error(f"unknown scene {', '.join(unknown)}; must be one of {', '.join(NAMES)}")
    if options.seeds < 2:
        parser.error(f"--seeds must be at least 2, got {options.seeds}: the error is the variance between "
                     "seeds")
    log, work = Log(), options.build / "validation/bounces"
    mitsuba = Mitsuba(options.mitsuba or options.build / "validation/mitsuba/bin/python",
                      work / "mitsuba", log)
    output = ROOT / "validation/bounces"
    output.mkdir(exist_ok=True)
    try:
        measuring = Bounces(Kinome(options.build, work / "renders"), mitsuba,
                            Store(work / "measurements.jsonl"), work, options, log)
        for name in options.scenes or NAMES:
            try:
                one = measuring.scene(scene_of(name, work / "scenes"))
            except Problem as reason:
                log.problem(f"{name}: {reason}")
                continue
            found = (read_json(output / "bounces.json") or {"scenes": {}})["scenes"] | {name: one}
            found = {n: found[n] for n in NAMES if n in found}
            write_json(output / "bounces.json", {"machine": machine(), "scenes": found})
            bounces_page.write(output, machine(), found, options)
    except Problem as reason:
        log.problem(reason)
    finally:
        mitsuba.close()
    return 1 if log.problems else 0


if __name__ == "__main__":
    sys.exit(main())
