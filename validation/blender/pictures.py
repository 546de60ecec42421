"""Renders the three example scenes with Cycles and with Kinome: prints their means, and writes
docs/blender.jpg. Runs in a Python with bpy.

    pictures.py [--size WIDTH] [--samples COUNT] [--denoise] [--keep FOLDER] [SCENE...]
"""
import argparse
import importlib
import pathlib
import tempfile

import bpy
import numpy as np

from common import ROOT, export, quiet, render_cycles, render_kinome, render_mitsuba

SCENES = ("interior", "product", "outdoor")
EXPOSURES = {"interior": 1.15, "product": 0.75, "outdoor": 1.8}  # factors before the sRGB curve


def save_jpeg(path, pixels, quality=88):
    """Writes linear pixels, rows from top to bottom, with the sRGB curve."""
    color = np.clip(pixels, 0, 1)
    color = np.where(color <= 0.0031308, 12.92 * color, 1.055 * color ** (1 / 2.4) - 0.055)
    height, width = color.shape[:2]
    image = bpy.data.images.new("picture", width, height)
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = color[::-1]
    image.pixels.foreach_set(rgba.ravel())
    image.file_format = "JPEG"
    image.save(filepath=str(path), quality=quality)
    bpy.data.images.remove(image)


def means(image):
    return " ".join(f"{x:.4f}" for x in image.mean(axis=(0, 1)))


def render(name, options, folder):
    """Returns Cycles' image and Kinome's."""
    samples = options.samples
    importlib.import_module(name).build(options.size, options.size * 5 // 8)
    xml = f"{folder}/{name}/{name}.xml"
    with quiet():
        report = export(xml, sky_width=256)
    for line in report.lines:
        print(f"{name}: {line}")
    images = {"Cycles": render_cycles(samples, denoise=options.denoise),
              "Kinome": render_kinome(xml, samples, options=["--denoise"] if options.denoise else [])}
    if options.mitsuba:
        images["Mitsuba"] = render_mitsuba(xml, samples)
    for program, image in images.items():
        ratio = image.mean(axis=(0, 1)) / images["Cycles"].mean(axis=(0, 1))
        print(f"| {name} | {program} | {means(image)} | {' '.join(f'{x:.3f}' for x in ratio)} |", flush=True)
        save_jpeg(f"{folder}/{name}-{program}.jpg", EXPOSURES[name] * image)
        np.save(f"{folder}/{name}-{program}.npy", image.astype(np.float32))
    return images["Cycles"], images["Kinome"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("scenes", nargs="*", default=SCENES)
    parser.add_argument("--size", type=int, default=480)
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--keep", help="folder for scenes and images")
    parser.add_argument("--denoise", action="store_true", help="denoise Cycles' and Kinome's images")
    parser.add_argument("--mitsuba", action="store_true", help="also render with KINOME_MITSUBA")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or temporary
        columns = []
        for name in options.scenes:
            pathlib.Path(folder, name).mkdir(parents=True, exist_ok=True)
            pair = render(name, options, folder)
            columns.append(np.concatenate([EXPOSURES[name] * image for image in pair], 0))
        if tuple(options.scenes) == SCENES:
            save_jpeg(ROOT / "docs/blender.jpg", np.concatenate(columns, 1))


if __name__ == "__main__":
    main()
