#!/usr/bin/env python3
"""Generates the meshes and maps of the scenes, and copies their environment photographs.

    python3 scenes/make_assets.py [--force] [--scale S] [--output DIR] [SCENE…]

Writes DIR/SCENE/assets (DIR: this folder) for the given scenes, or for all. Nothing is random: the
same version of numpy on the same machine writes the same bytes. Scenes whose stamp matches the sources
of this script are skipped. A `--scale` above 1 makes coarser meshes, for tests.
"""

import argparse
import hashlib
import importlib
import pathlib
import shutil
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
PHOTOGRAPHS = pathlib.Path("/usr/share/blender/datafiles/studiolights/world")
LICENCE = "photographs-license.txt"
# Environment photograph of each scene. The others have emitters or a generated sky.
PHOTOGRAPH = {"hebe": "sunset.exr", "car": "courtyard.exr", "grace": "sunrise.exr", "box": None,
              "plate": "sunset.exr", "colonnade": "city.exr", "heap": "forest.exr",
              "room": "sunset.exr", "vases": "studio.exr", "chess": "interior.exr",
              "cobbles": "night.exr", "reeds": "courtyard.exr", "sponge": "city.exr",
              "tree": "sunset.exr", "focus": "sunrise.exr", "hammered": "interior.exr",
              "mirror": "city.exr", "noon": None, "lamps": None,
              "sunroom": "courtyard.exr", "kitchen": None,
              "beam": None, "haze": None, "smoke": "studio.exr", "cloud": "sunset.exr",
              "wax": "sunset.exr", "milk": "courtyard.exr", "mist": "forest.exr", "lanterns": None}
SCENES = tuple(PHOTOGRAPH)


def fingerprint(scale):
    """Returns a hash of everything that the assets depend on."""
    digest = hashlib.sha256(f"scale {scale:g}\n".encode())
    for source in [pathlib.Path(__file__), *sorted((HERE / "tools").glob("*.py"))]:
        digest.update(source.name.encode() + b"\0" + source.read_bytes())
    return digest.hexdigest()


def is_current(folder, stamp):
    """Returns whether the stamp of the folder matches, and all files that it lists exist."""
    try:
        lines = (folder / "stamp").read_text(encoding="ascii").split("\n")
    except OSError:
        return False
    return lines[0] == stamp and all((folder / name).is_file() for name in lines[1:] if name)


def copy_photograph(name, folder):
    source = PHOTOGRAPHS / name
    if not source.is_file():
        raise SystemExit(f"make_assets: {source} is missing, expected from the Debian package "
                         "blender-data (apt-get install blender-data)")
    shutil.copyfile(source, folder / name)
    shutil.copyfile(PHOTOGRAPHS / "license.txt", folder / LICENCE)


def make(scene, output, scale, force):
    """Generates the assets of a scene and prints a summary."""
    folder = output / scene / "assets"
    stamp = fingerprint(scale)
    if not force and is_current(folder, stamp):
        print(f"{scene}: up to date")
        return
    started = time.monotonic()
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "stamp").unlink(missing_ok=True)  # so an interrupted run leaves no valid stamp
    if PHOTOGRAPH[scene]:
        copy_photograph(PHOTOGRAPH[scene], folder)
    triangles = importlib.import_module(f"tools.{scene}").make(folder, scale)
    names = sorted(f.name for f in folder.iterdir() if f.name != "stamp")
    (folder / "stamp").write_text("\n".join([stamp, *names]) + "\n", encoding="ascii")
    print(f"{scene}: {triangles} triangles in {time.monotonic() - started:.1f} s")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scenes", nargs="*", metavar="SCENE",
                        help=", ".join(SCENES) + "; default: all")
    parser.add_argument("--force", action="store_true", help="make them even if they are current")
    parser.add_argument("--scale", type=float, default=1.0, help="grid spacing, 1 = as rendered")
    parser.add_argument("--output", type=pathlib.Path, default=HERE, help="folder of the scenes")
    arguments = parser.parse_args()
    for scene in arguments.scenes:
        if scene not in SCENES:
            parser.error(f"unknown scene {scene!r}, expected one of {', '.join(SCENES)}")
    if not 0.5 <= arguments.scale <= 3.0:
        parser.error(f"--scale must be between 0.5 and 3, got {arguments.scale:g}")
    try:
        import numpy  # noqa: F401  (checked here for a clear message)
    except ImportError:
        raise SystemExit("make_assets: Python's numpy is missing, expected from the Debian package "
                         "python3-numpy (apt-get install python3-numpy)") from None
    sys.path.insert(0, str(HERE))
    for scene in arguments.scenes or SCENES:
        make(scene, arguments.output, arguments.scale, arguments.force)


if __name__ == "__main__":
    main()
