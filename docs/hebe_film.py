"""Makes the video of docs/film.md: ten seconds along the thesis's ellipse around the marble statue.

    /usr/bin/python3 docs/hebe_film.py [--samples 16] [--frames 250] [--output docs/hebe-film.mp4]

Renders the missing frames (PNGs in build/hebe-film). Encodes all frames as a video of less than 2 MB, and
writes a contact sheet (.jpg) beside it. Requires the scene's meshes (scenes/make_assets.py hebe), ffmpeg and
Debian's python3-pil.
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys

from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build"))
WIDTH, HEIGHT = 480, 270
RATE = 25
# The scene is framed for a square image. A wider image with this field of view shows the same height of the
# statue. The target is at the middle of the statue; the camera stays above the floor.
KEYS = {"camera": "ellipse", "parameters": {"sensor.fov": [[0, 37]]}}
PATH = ["--target", "-0.06,1.28,0", "--angles", "55,6"]
COLUMNS, ROWS = 5, 5
MIN_CRF, MAX_CRF, MAX_BYTES = 20, 33, 2_000_000


def render(folder, frames, samples):
    folder.mkdir(parents=True, exist_ok=True)
    keys = folder / "keys.json"
    keys.write_text(json.dumps(KEYS))
    subprocess.run([BUILD / "bin/kinome", "film", ROOT / "scenes/hebe/scene.xml", "--path", keys, *PATH,
                    "--frames", str(frames), "-D", f"width={WIDTH}", "-D", f"height={HEIGHT}", "-D",
                    f"spp={samples}", "-D", "max_depth=2", "-o", folder / "%04d.png"], check=True)


def make_video(folder, output):
    """Encodes the video with the best quality, the lowest CRF, whose file is small enough. Returns the CRF."""
    for crf in range(MIN_CRF, MAX_CRF + 1):
        subprocess.run(["ffmpeg", "-nostdin", "-y", "-loglevel", "error", "-framerate", str(RATE), "-i",
                        folder / "%04d.png", "-vf", "scale=out_color_matrix=bt709:out_range=tv,"
                        "format=yuv420p", "-c:v", "libx264", "-preset", "veryslow", "-crf", str(crf),
                        "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc",
                        "iec61966-2-1", "-movflags", "+faststart", output], check=True)
        if output.stat().st_size <= MAX_BYTES:
            return crf
    sys.exit(f"hebe_film: no CRF makes {output} smaller than {MAX_BYTES} bytes")


def make_contact_sheet(folder, frames, output):
    width, height = WIDTH // 2, HEIGHT // 2
    sheet = Image.new("RGB", (COLUMNS * width, ROWS * height))
    for i in range(COLUMNS * ROWS):
        frame = Image.open(folder / f"{i * frames // (COLUMNS * ROWS):04d}.png").convert("RGB")
        sheet.paste(frame.resize((width, height), Image.LANCZOS),
                    (i % COLUMNS * width, i // COLUMNS * height))
    for quality in range(90, 30, -5):
        sheet.save(output, quality=quality, optimize=True)
        if output.stat().st_size <= 150_000:
            return


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--frames", type=int, default=250)
    parser.add_argument("--output", type=pathlib.Path, default=ROOT / "docs/hebe-film.mp4")
    options = parser.parse_args()
    folder = BUILD / "hebe-film"
    render(folder, options.frames, options.samples)
    quality = make_video(folder, options.output)
    make_contact_sheet(folder, options.frames, options.output.with_suffix(".jpg"))
    print(f"wrote {options.output} ({options.output.stat().st_size} bytes, CRF {quality})")


if __name__ == "__main__":
    main()
