"""Makes the images of plugins/integrators/clustered/PRODUCT.md, which show the state of product sampling
at some pixels.

    /usr/bin/python3 scenes/make_assets.py hebe
    /usr/bin/python3 validation/method_pictures.py --build build
"""
import argparse
import dataclasses
import pathlib
import subprocess
import tempfile

from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUTPUT = ROOT / "plugins/integrators/clustered/pictures"
WIDTH = 640  # of the images that are written


@dataclasses.dataclass(frozen=True)
class Picture:
    """An image of PRODUCT.md. film: size of the film; pixel: coordinates on it; rays: number of shadow
    rays in the image."""

    name: str
    scene: str
    film: tuple
    pixel: tuple
    rays: int


HEBE, MORE = "scenes/hebe/scene.xml", "validation/scenes/benchmark"
PICTURES = [
    Picture("cells", HEBE, (256, 256), (30, 215), 1),  # the floor in the open
    Picture("shade", HEBE, (256, 256), (186, 238), 96),  # the floor beside the plinth
    Picture("robe", HEBE, (256, 256), (128, 140), 96),
    Picture("corridor", f"{MORE}/corridor.xml", (256, 192), (60, 150), 96),
    Picture("attic", f"{MORE}/attic.xml", (256, 192), (128, 170), 96),
]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--output", type=pathlib.Path, default=OUTPUT)
    options = parser.parse_args()
    options.output.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for one in PICTURES:
            stem = pathlib.Path(folder) / one.name
            (x, y), (width, height) = one.pixel, one.film
            subprocess.run(
                [options.build / "bin/kinome", ROOT / one.scene, "-q", "--inspect", f"{x},{y}",
                 "-o", f"{stem}.exr", "-D", "integrator=clustered", "-D", "importance=product",
                 "-D", f"max_depth={2 if one.scene == HEBE else 3}",
                 "-D", f"spp={max(1, one.rays // 3)}", "-D", f"width={width}",
                 "-D", f"height={height}"],
                check=True)
            with Image.open(f"{stem}.png") as picture:
                # Crops the legend below the map.
                sky = picture.crop((0, 0, picture.width, picture.width // 2))
                size = WIDTH, WIDTH // 2
                small = sky.convert("RGB").resize(size, Image.Resampling.LANCZOS)
            small.quantize(256, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE).save(
                options.output / f"{one.name}.png", optimize=True)


if __name__ == "__main__":
    main()
