"""Renders the images of scenes with media for docs/media.md.

    /usr/bin/python3 docs/media_gallery.py [--seconds 80] [--output docs/media-gallery.jpg] [SCENE…]

Each image is rendered for `--seconds` with two threads, and kept in out/gallery. Given scenes are rendered again;
the others only if their image is missing. First: python3 scenes/make_assets.py
"""
import argparse
import pathlib
import sys

import numpy as np
from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "validation"))
from pictures import read_pfm  # noqa: E402
from program import run_kinome  # noqa: E402
from suite.pictures import encoded  # noqa: E402

# Size and exposure of each image, in rows of three.
IMAGES = {"cloud": (400, 300, 0.75), "beam": (400, 300, 2.0), "haze": (400, 300, 0.8),
          "smoke": (400, 400, 1.6), "wax": (400, 400, 1.3), "milk": (400, 400, 0.6)}
GAP = 6


def rendered(name, given, folder):
    """Returns the pixels of a scene's image, which is rendered if necessary."""
    path = folder / f"{name}.pfm"
    width, height, scale = IMAGES[name]
    if name in given.scenes or not path.is_file():
        run_kinome(given.build.resolve(), ROOT / f"scenes/{name}/scene.xml", path,
                   {"integrator": given.integrator, "width": width, "height": height,
                    "file_format": "pfm"}, 1, ("-t", "2", "--time", str(given.seconds)))
    return Image.fromarray(np.ascontiguousarray(encoded(read_pfm(path), scale)))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=", ".join(IMAGES))
    parser.add_argument("--seconds", type=float, default=80)
    parser.add_argument("--integrator", default="clustered")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--output", type=pathlib.Path, default=ROOT / "docs/media-gallery.jpg")
    given = parser.parse_args()
    folder = ROOT / "out/gallery"
    folder.mkdir(parents=True, exist_ok=True)
    images = [rendered(name, given, folder) for name in IMAGES]
    rows = [images[i:i + 3] for i in range(0, len(images), 3)]
    width = max(sum(image.width + GAP for image in row) - GAP for row in rows)
    height = sum(row[0].height + GAP for row in rows) - GAP
    sheet = Image.new("RGB", (width, height), "white")
    y = 0
    for row in rows:
        x = 0
        for image in row:
            sheet.paste(image, (x, y))
            x += image.width + GAP
        y += row[0].height + GAP
    sheet.save(given.output, quality=86)


if __name__ == "__main__":
    main()
