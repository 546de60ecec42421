"""Renders a scene with Mitsuba 3 and with Kinome in equal time, side by side: the image of the README.

    /usr/bin/python3 docs/equal_time.py [--scene chess] [--samples 16] [--output docs/equal-time.jpg]

Kinome renders `--samples` samples per pixel with its default integrator. Mitsuba uses the configuration that
`validation/run.sh benchmark` found to be its fastest on this scene, with the number of samples that takes it
at least as long. Both use two threads. Time is processor time, which other programs on the machine hardly
affect: that of the whole process for Kinome, and that of rendering, without loading and compilation, for
Mitsuba. Errors are relative to an image by Kinome with many more samples. Requires the packages that
`sh validation/run.sh` installs.
"""
import argparse
import dataclasses
import math
import pathlib
import sys
import tempfile

import numpy as np
from PIL import Image, ImageDraw, ImageFont

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "validation"))
import pictures  # noqa: E402
from suite.kinome import Kinome, sized  # noqa: E402
from suite.peers import Configuration, Mitsuba  # noqa: E402
from suite.pictures import encoded, exposure  # noqa: E402
from suite.tables import SCENES  # noqa: E402

SIZE = (480, 360)
CROP = 120  # pixels of the enlarged part, which is shown three times as large
REFERENCE_SAMPLES = 1024
GAP, LABEL = 8, 34


class Log:
    @staticmethod
    def problem(reason):
        print(f"equal_time: {reason}", file=sys.stderr)


@dataclasses.dataclass
class Shown:
    name: str
    image: np.ndarray
    samples: int
    processor: float  # seconds
    relmse: float = 0


def by_kinome(program, scene, samples, seed):
    render = program.render(scene.path, {**sized(scene, SIZE), "spp": samples}, seed)
    return Shown("Kinome", render.image, render.samples, render.stats["processor_seconds"])


def by_mitsuba(peer, configuration, scene, seconds):
    """Renders with the smallest sample count that takes at least `seconds`. Estimates it from the speed of
    shorter renders."""
    peer.render(configuration, scene, SIZE, 16, 1)  # compiles
    speed = peer.render(configuration, scene, SIZE, 16, 2)
    samples = speed.samples
    while True:
        samples = max(samples + 1, math.ceil(samples * 1.02 * seconds / speed.processor))
        peer.render(configuration, scene, SIZE, samples, 3)  # compiles for a new sample count
        speed = peer.render(configuration, scene, SIZE, samples, 4)
        if speed.processor >= seconds:
            return Shown("Mitsuba 3", speed.image, speed.samples, speed.processor)
        samples = speed.samples


def typical(image, reference):
    """Returns the corner of the square of CROP x CROP pixels whose error is closest to that of the whole
    image. Squares that are much darker or much brighter than the image are excluded."""
    errors = pictures.squared_errors(image, reference)
    light = reference.mean(axis=2)
    best = None
    for y in range(0, SIZE[1] - CROP + 1, 10):
        for x in range(0, SIZE[0] - CROP + 1, 10):
            part = slice(y, y + CROP), slice(x, x + CROP)
            if not 0.5 < light[part].mean() / light.mean() < 2:
                continue
            ratio = abs(math.log(max(errors[part].mean(), 1e-30) / errors.mean()))
            if best is None or ratio < best[0]:
                best = ratio, y, x
    return best[1:]


def sheet(shown, corner, scale):
    """Returns an image of all renders, each with a label and its enlarged part below it."""
    width, height = SIZE
    font = ImageFont.truetype(str(pictures.FONT), 17)
    large = Image.new("RGB", (len(shown) * (width + GAP) - GAP, 2 * height + 2 * GAP + LABEL), "white")
    draw = ImageDraw.Draw(large)
    y, x = corner
    for i, one in enumerate(shown):
        left = i * (width + GAP)
        text = (f"{one.name}: {one.samples} samples a pixel, {one.processor:.1f} s, "
                f"error {one.relmse:.2g}")
        draw.text((left, 6), text, "black", font)
        picture = Image.fromarray(np.ascontiguousarray(encoded(one.image, scale)))
        part = picture.crop((x, y, x + CROP, y + CROP * height // width))
        ImageDraw.Draw(picture).rectangle((x, y, x + CROP, y + CROP * height // width), None, "white", 2)
        large.paste(picture, (left, LABEL))
        large.paste(part.resize(SIZE, Image.NEAREST), (left, LABEL + height + GAP))
    return large


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--scene", default="chess", choices=[s.name for s in SCENES if s.envmap])
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--mitsuba", type=pathlib.Path,
                        help="Mitsuba's Python; default: that of validation/run.sh in the build folder")
    parser.add_argument("--output", type=pathlib.Path, default=ROOT / "docs/equal-time.jpg")
    given = parser.parse_args()
    scene = next(s for s in SCENES if s.name == given.scene)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        program = Kinome(given.build.resolve(), folder)
        ours = by_kinome(program, scene, given.samples, 1)
        reference = by_kinome(program, scene, REFERENCE_SAMPLES, 2).image
        peer = Mitsuba(given.mitsuba or given.build / "validation/mitsuba/bin/python", folder, Log)
        try:
            theirs = by_mitsuba(peer, Configuration("llvm_ad_rgb", "direct", "multijitter", True), scene,
                                ours.processor)
        finally:
            peer.close()
    shown = [theirs, ours]
    for one in shown:
        one.relmse = pictures.error(one.image, reference)["relmse"]
        print(f"{one.name}: {one.samples} samples, {one.processor:.2f} s of processor time, "
              f"relMSE {one.relmse:.3g}")
    sheet(shown, typical(theirs.image, reference), exposure(reference)).save(given.output, quality=88)


if __name__ == "__main__":
    main()
