"""Measures the error of clustered with product in each pixel, by the variance between seeds, and the share of
classes of pixels in it. maps_page.py draws the results."""
import dataclasses
import os
import re

import numpy as np

from ablation import LOCAL, OF_LOCAL_LIGHT, PARTS, product
from compare.images import colour, read
from program import run_kinome

from . import surfaces
from .problems import Problem
from .tables import ROOT, THREADS

SEEDS = 8
VIEWS = 16  # number of `aov` renders with one camera ray per pixel, which find the visible points
RAYS_PER_SAMPLE = 3  # default of clustered
NEW = 0.5  # minimum share of a pixel's camera rays that fit none of the pilot's patches
GRAZING = 0.1  # cosine of the viewing angle
SHADE, OPEN = 0.02, 0.98  # limits of the estimated visible share of the light
WORST_SHARE = 0.01  # share of all pixels
SCENES = ("hebe", "tree", "room", "colonnade", "evening", "blocks")
INTEGRATORS = ROOT / "scenes/integrators"

# Pairs of (name, meaning). A pixel belongs to the first class that it fits.
CLASSES = (
    ("nothing", "the camera rays hit nothing that reflects"),
    ("new patch", f"at least {NEW:.0%} of the camera rays hit a patch that a pilot like "
                  "product's missed"),
    ("several patches", "the camera rays hit several patches, or a patch and the background"),
    ("grazing view", f"one patch, seen at a cosine below {GRAZING:g}"),
    ("deep shade", f"one patch, with an estimated visible share of its light above 0, but at most "
                   f"{SHADE:.0%}. Visibility causes the error"),
    ("glossy, partly lit", "one patch, whose BSDF has a lobe or is a mirror, with an estimated visible "
                           f"share of its light from {SHADE:.0%} to {OPEN:.0%}. Candidates and "
                           "visibility cause the error"),
    ("glossy", "the same, but the estimated visible share is 0 or nearly 1. Candidates cause the error"),
    ("dull, partly lit", "one patch without a lobe, whose estimated visible share is between these "
                         "limits. Visibility causes the error"),
    ("dull", "the same, but the estimated visible share is 0 or nearly 1"))
NAMES = [name for name, _ in CLASSES]


@dataclasses.dataclass
class Map:
    """Result for one scene. `error`: (rows, columns), relMSE of each pixel, averaged over channels;
    `classes`: indices of CLASSES."""

    picture: np.ndarray
    error: np.ndarray
    classes: np.ndarray
    figures: dict


def with_floats(path, folder):
    """Writes a copy of a scene that finds its files, and whose film has 32 bits per value."""
    text = path.read_text(encoding="utf-8")
    text, scenes = re.subn(r"(<scene [^>]*>)", rf'\1 <path value="{path.parent}"/>', text, count=1)
    text, films = re.subn(r'(<film type="hdrfilm">)',
                          r'\1 <string name="component_format" value="float32"/>', text, count=1)
    if scenes != 1 or films != 1:
        raise Problem(f"{path.name}: has no <scene> with an hdrfilm")
    copy = folder / f"{path.parent.name}-{path.name}"
    copy.write_text(text, encoding="utf-8")
    return copy


def write_integrators(folder):
    """Writes the integrators of the maps. Returns their values for $integrator:
    {"views": …, "diagnostics": …}."""
    clustered = (INTEGRATORS / "clustered.xml").read_text(encoding="utf-8")
    texts = {"views": '<scene version="3.0.0"> <integrator type="aov"> <string name="aovs" '
                      'value="shape:shape_index,n:sh_normal,p:position"/> </integrator> </scene>\n',
             "diagnostics": clustered.replace(
                 '<integrator type="clustered">',
                 '<integrator type="clustered"> <boolean name="diagnostics" value="true"/>')}
    for name, text in texts.items():
        (folder / f"{name}.xml").write_text(text, encoding="utf-8")
    # The value of $integrator is relative to the folder of the other integrators.
    return {name: os.path.relpath(folder / name, INTEGRATORS) for name in texts}


class Maps:
    def __init__(self, kinome, size_of, samples, folder, log):
        """`size_of`: function of a scene, returns the size of its image; `samples`: number per pixel;
        `folder`: for copies of scenes."""
        self.kinome, self.size_of, self.samples, self.log = kinome, size_of, samples, log
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)
        self.integrators = write_integrators(folder)

    def scene(self, scene):
        """Measures one scene; returns its Map. Raises Problem."""
        size = self.size_of(scene)
        file = with_floats(scene.path, self.folder)
        self.log.say(f"{scene.name}: {SEEDS} seeds of {self.samples} samples")
        renders = self.renders(file, size, product(scene)[1],
                               self.integrators["diagnostics"])
        visibility, cost = (np.mean([r[name] for r in renders], axis=0)
                            for name in ("visibility", "cost"))
        if not any(r["samples"].any() for r in renders):
            raise Problem(f"{scene.name}: product sampling doesn't support this scene")
        stack = np.stack([colour(file, r) for r in renders])
        error, picture = relative_variance(stack), stack.mean(axis=0)
        classes = self.classes(scene, file, size, visibility)
        without = self.ablations(scene, file, size, error, classes)
        figures = {"size": list(size), "samples": self.samples, "seeds": SEEDS,
                   "relmse": float(error.mean()), "classes": shares(stack, error, cost, classes),
                   "worst": share_of_worst(error), "without": without}
        return Map(picture, error, classes, figures)

    def render(self, file, size, integrator, samples, seed, defines):
        output = self.folder / "picture.exr"
        run_kinome(self.kinome.build, file, output,
                   {"integrator": integrator, "spp": samples, "sampler": "independent",
                    "width": size[0], "height": size[1], **defines}, seed, ("-t", str(THREADS)))
        channels = read(output).channels
        output.unlink()
        return channels

    def renders(self, file, size, defines, integrator="clustered"):
        return [self.render(file, size, integrator, self.samples, seed, defines)
                for seed in range(1, SEEDS + 1)]

    def classes(self, scene, file, size, visibility):
        views = [self.render(file, size, self.integrators["views"], 1, seed, {})
                 for seed in range(1, VIEWS + 1)]
        points = surfaces.points_of(views, surfaces.camera_of(scene.path, size[0]))
        glossy = np.array([False, *surfaces.glossy_shapes(scene.path)])
        if points.shape.max() >= len(glossy):
            raise Problem(f"{scene.name}: has more shapes than its file, so their materials are unknown")
        return classify(points, surfaces.pilot_rays(RAYS_PER_SAMPLE * self.samples), glossy,
                        visibility)

    def ablations(self, scene, file, size, error, classes):
        """Returns the factors by which the error of each class, and of all pixels, grows without each part."""
        found = {}
        for part, defines in PARTS.items():
            if not defines or part in OF_LOCAL_LIGHT and scene.group not in LOCAL:
                continue
            self.log.say(f"{scene.name}: {part}")
            renders = self.renders(file, size, product(scene, **defines)[1])
            without = relative_variance(np.stack([colour(file, r) for r in renders]))
            found[part] = {name: ratio(without[inside], error[inside])
                           for name, inside in [("all", np.full(classes.shape, True)), *(
                               (name, classes == i) for i, name in enumerate(NAMES))]}
        return found


def classify(points, pilot, glossy, visibility):
    """Returns the index of the first of CLASSES that each pixel fits."""
    patch, new = surfaces.patches_of(points, pilot)
    hit = points.shape > 0
    seen = np.maximum(hit.sum(axis=0), 1)
    mean_cosine = (points.cosine * hit).sum(axis=0) / seen
    is_new = new[pilot:].mean(axis=0) >= NEW if pilot else np.zeros(hit.shape[1:], bool)
    is_glossy = glossy[points.shape].sum(axis=0) * 2 > seen
    is_between = (visibility > SHADE) & (visibility < OPEN)
    return np.select([~hit.any(axis=0), is_new, (patch != patch[0]).any(axis=0),
                      mean_cosine < GRAZING, (visibility > 0) & (visibility <= SHADE),
                      is_glossy & is_between, is_glossy, is_between],
                     range(len(CLASSES) - 1), len(CLASSES) - 1)


def relative_variance(stack):
    """Returns the relMSE of each pixel, from the variance between renders. Values that aren't finite count as
    0."""
    stack = np.nan_to_num(stack, posinf=0, neginf=0)
    mean = stack.mean(axis=0)
    floor = 0.01 * mean.mean() ** 2 or 1.0
    return (stack.var(axis=0, ddof=1) / (mean ** 2 + floor)).mean(axis=2)


def shares(stack, error, cost, classes):
    """Returns by class its share of the pixels, of the rays (`cost`), of the error, of the error in each half of
    the seeds, and of the worst pixels."""
    halves = [relative_variance(part) for part in (stack[::2], stack[1::2])]
    worst = error >= np.sort(error, axis=None)[-number_of_worst(error)]
    found = {}
    for i, name in enumerate(NAMES):
        inside = classes == i
        found[name] = {"pixels": float(inside.mean()), "rays": share(cost, inside),
                       "error": share(error, inside),
                       "halves": [share(half, inside) for half in halves],
                       "worst": share(worst, inside)}
    return found


def share(values, inside):
    return float(values[inside].sum() / (values.sum() or 1))


def ratio(without, error):
    return float(without.sum() / error.sum()) if error.sum() > 0 else None


def number_of_worst(error):
    return max(1, round(WORST_SHARE * error.size))


def share_of_worst(error):
    """Returns the share of the worst pixels (WORST_SHARE) in the error."""
    ordered = np.sort(error, axis=None)
    return float(ordered[-number_of_worst(error):].sum() / (ordered.sum() or 1))
