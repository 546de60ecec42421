"""Makes the two small images in maps/, which scenes here use. Needs Debian's python3-openimageio."""
import pathlib

import numpy as np
import OpenImageIO as oiio

MAPS = pathlib.Path(__file__).resolve().parent / "maps"


def write(path, pixels, kind):
    height, width, channels = pixels.shape
    spec = oiio.ImageSpec(width, height, channels, kind)
    out = oiio.ImageOutput.create(str(path))
    if out is None or not out.open(str(path), spec) or not out.write_image(pixels):
        raise SystemExit(f"{path}: {oiio.geterror()}")
    out.close()


def main():
    rng = np.random.default_rng(7)
    sky = rng.uniform(0.1, 0.9, (12, 24, 3)).astype(np.float32)
    sky[3, 17] = 40, 35, 30  # a sun
    sky[9:, :] *= 0.3
    write(MAPS / "sky.exr", sky, oiio.FLOAT)
    tiles = rng.uniform(0.05, 0.95, (9, 13, 3)).astype(np.float32)
    write(MAPS / "tiles.png", tiles, oiio.UINT8)


if __name__ == "__main__":
    MAPS.mkdir(exist_ok=True)
    main()
