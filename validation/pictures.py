"""Images of the reports: reads and compares images, and assembles them into labelled figures."""
import pathlib

import matplotlib
import numpy as np
from PIL import Image, ImageDraw, ImageFont

GAP = 6
LABEL = 30
FONT = pathlib.Path(matplotlib.get_data_path()) / "fonts/ttf/DejaVuSans.ttf"


def read_pfm(path):
    """Returns the linear RGB values of a PFM file as float64, top row first."""
    with open(path, "rb") as file:
        kind, size, scale = (file.readline().split() for _ in range(3))
        if kind != [b"PF"]:
            raise ValueError(f"{path}: not a colour PFM")
        width, height = (int(n) for n in size)
        order = "<f4" if float(scale[0]) < 0 else ">f4"
        pixels = np.frombuffer(file.read(), order)
    return pixels.reshape(height, width, 3)[::-1].astype(np.float64)


def squared_errors(image, reference):
    """Returns (I - R)² / (R² + 0.01 mean(R)²) of each pixel, averaged over its channels."""
    floor = 0.01 * reference.mean() ** 2
    return ((image - reference) ** 2 / (reference ** 2 + floor)).mean(axis=2)


def error(image, reference):
    """Returns relMSE, and relMSE without the worst 0.1 % of the pixels."""
    errors = np.sort(squared_errors(image, reference).ravel())
    kept = len(errors) - max(1, round(len(errors) / 1000))
    return {"relmse": float(errors.mean()), "trimmed": float(errors[:kept].mean())}


def encoded(image):
    """Converts linear values to an 8-bit sRGB image."""
    x = np.clip(image, 0.0, 1.0)
    x = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    return Image.fromarray(np.floor(255 * x + 0.5).astype(np.uint8))


def difference(image, reference, gain=4.0):
    """Returns an image of `gain` times the difference: red is too bright, blue is too dark."""
    d = gain * (image - reference).mean(axis=2)
    return encoded(np.stack([np.maximum(d, 0), np.abs(d) / 8, np.maximum(-d, 0)], axis=2))


def grid(path, rows):
    """Writes a JPEG of rows of (label, image) pairs. An image of None leaves an empty cell."""
    columns = max(len(row) for row in rows)
    pictures = [picture for row in rows for _, picture in row if picture is not None]
    width = max(p.width for p in pictures)
    heights = [max((p.height for _, p in row if p is not None), default=0) + LABEL for row in rows]
    sheet = Image.new("RGB", (columns * (width + GAP) - GAP, sum(heights)), "white")
    draw = ImageDraw.Draw(sheet)
    font = ImageFont.truetype(str(FONT), 11)
    y = 0
    for row, height in zip(rows, heights):
        for column, (label, picture) in enumerate(row):
            x = column * (width + GAP)
            if picture is not None:
                sheet.paste(picture, (x, y))
            draw.multiline_text((x + 2, y + height - LABEL + 1), label, fill="black", font=font,
                                spacing=1)
        y += height
    sheet.save(path, quality=88)
