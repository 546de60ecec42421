"""Renders of validation/thesis.py: five scenes, three importance functions, two sweeps."""
import sys
import time

from pictures import error, read_pfm
from program import ROOT, run_kinome

MODES = ("joint", "brdf", "luminance")
# size: with the thesis's number of pixels. small: a size at which every pixel can use every light
# point. truth: integrator and samples of the converged image. materials: Phong or Ward, as in the
# thesis. thesis: its table 5.1, and the samples of its "Lum" images of equal time (figures 5.2 to 5.5).
SCENES = {
    "hebe": {"size": (324, 324), "small": (176, 176), "truth": ("direct", 256),
             "max_depth": 2,
             "materials": {"material": "phong", "gloss": 0.2},
             "thesis": {"faces": "130k", "pixels": "104.5k", "joint": 13.3, "luminance": 6.1,
                        "brdf": 13.8, "equal": 300}},
    "car": {"size": (510, 287), "small": (224, 126), "truth": ("direct", 256),
             "max_depth": 2,
            "materials": {"material": "phong"},
            "thesis": {"faces": "30k", "pixels": "146.2k", "joint": 23.4, "luminance": 11.3,
                       "brdf": 24.9, "equal": 280}},
    "grace": {"size": (374, 281), "small": (196, 147), "truth": ("direct", 256),
             "max_depth": 2,
              "materials": {"material": "ward", "gloss": 0.2}, "thesis": None},
    "box": {"size": (640, 480), "small": (196, 147), "truth": ("path", 1024),
             "max_depth": 3,
            "materials": {"material": "phong"},
            "thesis": {"faces": "20k", "pixels": "307.2k", "joint": 24.5, "luminance": 16.3,
                       "brdf": 26.4, "equal": 210}},
    "plate": {"size": (640, 480), "small": (196, 147), "truth": ("path", 1024),
             "max_depth": 3,
              "materials": {"material": "ward"},
              "thesis": {"faces": "204", "pixels": "307.2k", "joint": 25.5, "luminance": 10.3,
                         "brdf": 27.5, "equal": 320}},
}
SAMPLES = 128
SWEEPS = {"cut_size": (16, 32, 64, 128, 256, 512, 1024, 2048),
          "brdf_samples": (0, 4, 8, 16, 32, 64, 128, 256)}
QUICK = {"shrink": 6, "light_samples": 512, "truth_samples": 4,
         "sweeps": {"cut_size": (16, 512), "brdf_samples": (0, 32)}}


class Renderer:
    """Renders into a folder, and reports progress."""

    def __init__(self, build, folder, quick):
        self.build, self.folder, self.quick = build, folder, quick
        self.started = time.monotonic()

    def say(self, text):
        print(f"{time.monotonic() - self.started:7.1f} s  {text}", file=sys.stderr, flush=True)

    def size(self, scene, which):
        width, height = SCENES[scene][which]
        shrink = QUICK["shrink"] if self.quick else 1
        return max(8, width // shrink), max(8, height // shrink)

    def __call__(self, scene, integrator, which="small", seed=0, **defines):
        """Returns the image and the program's statistics."""
        width, height = self.size(scene, which)
        # One camera ray per pixel and independent random numbers, as in the thesis.
        values = {"integrator": integrator, "sampler": "independent", "spp": 1, "width": width,
                  "height": height, "file_format": "pfm", **SCENES[scene]["materials"]}
        if integrator != "direct":
            values["max_depth"] = SCENES[scene]["max_depth"]
        if self.quick and integrator in ("clustered", "groundtruth"):
            values["light_samples"] = QUICK["light_samples"]
        values.update(defines)
        output = self.folder / "picture.pfm"
        stats = run_kinome(self.build, ROOT / f"scenes/{scene}/scene.xml", output, values, seed)
        return read_pfm(output), stats


def summary(stats):
    """Returns the values of a render for the page, with the wall-clock seconds of each stage."""
    threads = stats["threads"]
    stages = stats["seconds"]["stages"]
    alone = ("light points", "tree")  # single-threaded, or already wall-clock time
    seconds = {name: value / (1 if name in alone else threads) for name, value in stages.items()}
    return {"width": stats["width"], "height": stats["height"], "threads": threads,
            "render_seconds": stats["seconds"]["render"],
            "processor_seconds": stats["processor_seconds"], "stage_seconds": seconds,
            "rays": {kind: count for kind, count in stats["rays"].items() if count},
            "skipped": stats["skipped"]}


def find_truth(render, scene):
    """Returns the converged image, and an estimate of its own error."""
    integrator, samples = SCENES[scene]["truth"]
    if render.quick:
        samples = QUICK["truth_samples"]
    halves = [render(scene, integrator, seed=seed, spp=samples, sampler="ldsampler")[0]
              for seed in (1, 2)]
    mean = (halves[0] + halves[1]) / 2
    # The mean squared difference of the halves is 4 times the squared error of their mean.
    own = {key: value / 4 for key, value in error(halves[0], halves[1]).items()}
    return mean, {"integrator": integrator, "samples": 2 * samples, "own_error": own}


def timed(render, scene, importance, samples):
    """Returns statistics of the faster of two renders at the thesis's size. The minimum reduces the effect
    of other processes."""
    runs = [render(scene, "clustered", "size", importance=importance, emitter_samples=samples)[1]
            for _ in range(2)]
    return min(runs, key=lambda stats: stats["processor_seconds"])


def equal_time_samples(render, scene, goal):
    """Returns the number of samples by luminance that take `goal` seconds of processor time, which other
    processes affect least."""
    less, more = (timed(render, scene, "luminance", count)["processor_seconds"]
                  for count in (SAMPLES, 2 * SAMPLES))
    # A part of the time doesn't depend on the number of samples.
    each = max(1e-9, (more - less) / SAMPLES)
    return min(8 * SAMPLES, max(1, round(SAMPLES + (goal - less) / each)))


def compare(render, scene):
    """Returns the values of table 5.1 for one scene, and its images by name."""
    render.say(f"{scene}: groundtruth")
    pictures = {}
    pictures["groundtruth"], stats = render(scene, "groundtruth")
    render.say(f"{scene}: truth by {SCENES[scene]['truth'][0]}")
    pictures["truth"], truth = find_truth(render, scene)
    numbers = {"groundtruth": summary(stats), "truth": truth, "modes": {}}
    numbers["groundtruth"]["error_to_truth"] = error(pictures["groundtruth"], pictures["truth"])

    def add(name, importance, samples):
        full = timed(render, scene, importance, samples)
        picture, _ = render(scene, "clustered", importance=importance, emitter_samples=samples)
        pictures[name] = picture
        numbers["modes"][name] = {
            "importance": importance, "samples": samples, **summary(full),
            "error_to_groundtruth": error(picture, pictures["groundtruth"]),
            "error_to_truth": error(picture, pictures["truth"])}

    for mode in MODES:
        render.say(f"{scene}: {mode}")
        add(mode, mode, SAMPLES)
    render.say(f"{scene}: luminance, equal time")
    goal = numbers["modes"]["joint"]["processor_seconds"]
    add("luminance_equal_time", "luminance", equal_time_samples(render, scene, goal))
    return numbers, pictures


def sweep(render, scene, groundtruth):
    """Returns the error against groundtruth and the time, by size of the cut and number of lobe rays."""
    found = {}
    for name, values in (QUICK["sweeps"] if render.quick else SWEEPS).items():
        render.say(f"{scene}: {name} from {values[0]} to {values[-1]}")
        found[name] = []
        for value in values:
            picture, stats = render(scene, "clustered", importance="joint", **{name: value})
            found[name].append({"value": value, "seconds": stats["seconds"]["render"],
                                **error(picture, groundtruth)})
    return found
