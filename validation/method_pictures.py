"""Pictures of plugins/integrators/PRODUCT.md: what product sampling knows at some pixels of hebe.

    /usr/bin/python3 scenes/make_assets.py hebe
    /usr/bin/python3 validation/method_pictures.py --build build
"""
import argparse
import pathlib
import subprocess
import tempfile

from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUTPUT = ROOT / "plugins/integrators/product"
SIZE = 256  # of the film, which tells what a pixel is
# Name, pixel, rays that are drawn: on the floor in the open, on the floor beside the plinth, and on
# the statue's robe.
PICTURES = [("cells", (30, 215), 1), ("shade", (186, 238), 96), ("robe", (128, 140), 96)]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--output", type=pathlib.Path, default=OUTPUT)
    options = parser.parse_args()
    options.output.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for name, (x, y), rays in PICTURES:
            stem = pathlib.Path(folder) / name
            subprocess.run(
                [options.build / "bin/kinome", ROOT / "scenes/hebe/scene.xml", "-q", "--inspect",
                 f"{x},{y}", "-o", f"{stem}.exr", "-D", "importance=product",
                 "-D", f"spp={max(1, rays // 3)}", "-D", f"width={SIZE}", "-D", f"height={SIZE}"],
                check=True)
            with Image.open(f"{stem}.png") as picture:
                small = picture.convert("RGB").resize((640, 320), Image.Resampling.LANCZOS)
            small.quantize(256, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE).save(
                options.output / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main()
