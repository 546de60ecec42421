"""What Mitsuba 3 and Kinome show of a scene after the same time, side by side: the README's picture.

    /usr/bin/python3 docs/equal_time.py [--scene chess] [--samples 16] [--output docs/equal-time.jpg]

Kinome renders `--samples` samples a pixel by its default integrator. Mitsuba, in the configuration that
`validation/run.sh benchmark` found to be its fastest on this scene, gets as many samples as take it at
least as long. Both use two threads and are timed by processor time, which what else runs on the machine
hardly changes: Kinome by that of the whole process, Mitsuba by that of rendering, without loading and
compilation. Errors are against a picture of many more samples by Kinome. Needs what
`sh validation/run.sh` has installed.
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
    """The fewest samples that take at least as long, found by its speed at a few."""
    peer.render(configuration, scene, SIZE, 16, 1)  # compiles
    speed = peer.render(configuration, scene, SIZE, 16, 2)
    samples = speed.samples
    while True:
        samples = max(samples + 1, math.ceil(samples * 1.02 * seconds / speed.processor))
        peer.render(configuration, scene, SIZE, samples, 3)  # compiles, where the count is new to it
        speed = peer.render(configuration, scene, SIZE, samples, 4)
        if speed.processor >= seconds:
            return Shown("Mitsuba 3", speed.image, speed.samples, speed.processor)
        samples = speed.samples


def typical(image, reference):
    """Corner of the part of CROP x CROP pixels whose error is closest to that of the whole picture, of
    those that are neither much darker nor much brighter than it."""
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
    """Each picture above its enlarged part, labelled."""
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
                        help="its Python; default: that of validation/run.sh in the build folder")
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
