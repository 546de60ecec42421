"""Makes the small images and grids in maps/, which scenes here use. Needs Debian's
python3-openimageio."""
import pathlib
import struct

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


def write_grid(path, values):
    """Writes a grid in Mitsuba's format for volumes. The axes of `values` are z, y, x, channel."""
    z, y, x, channels = values.shape
    header = b"VOL\3" + struct.pack("<5i6f", 1, x, y, z, channels, 0, 0, 0, 1, 1, 1)
    path.write_bytes(header + values.astype("<f4").tobytes())


def main():
    rng = np.random.default_rng(7)
    sky = rng.uniform(0.1, 0.9, (12, 24, 3)).astype(np.float32)
    sky[3, 17] = 40, 35, 30  # a sun
    sky[9:, :] *= 0.3
    write(MAPS / "sky.exr", sky, oiio.FLOAT)
    tiles = rng.uniform(0.05, 0.95, (9, 13, 3)).astype(np.float32)
    write(MAPS / "tiles.png", tiles, oiio.UINT8)
    rng = np.random.default_rng(11)
    axes = [(np.arange(n) + 0.5) / n - 0.5 for n in (8, 9, 12)]
    distance = np.sqrt(sum(a**2 for a in np.meshgrid(*axes, indexing="ij")))
    smoke = np.clip(1.2 - 2.2 * distance, 0, None) * rng.uniform(0, 1.6, distance.shape)
    write_grid(MAPS / "smoke.vol", smoke[..., None])
    write_grid(MAPS / "smoke_albedo.vol", rng.uniform(0.3, 0.99, (3, 4, 5, 3)))


if __name__ == "__main__":
    MAPS.mkdir(exist_ok=True)
    main()
