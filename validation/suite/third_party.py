"""Measures the cost of a third-party plugin with only scalar functions: Minnaert's reflector of the SDK's
examples, which has a scalar and a wide version, on the sponge."""
import re
import subprocess

from .engine_scenes import with_filenames
from .problems import Problem
from .tables import ROOT

PROJECT = ROOT / "tests/sdk/project"
REFLECTORS = {"point by point": "minnaert", "wide": "wide_minnaert"}


def build(kinome_build, folder):
    """Builds the plugins against an installed Kinome, as users do. Returns the folder for --plugin-path."""
    prefix, work = (folder.resolve() / name for name in ("installed", "plugins-build"))
    compiler = [line.split("=", 1)[1] for line in
                (kinome_build / "CMakeCache.txt").read_text(encoding="utf-8").splitlines()
                if line.startswith("CMAKE_CXX_COMPILER:")]
    targets = [f"kinome_bsdf_{name}" for name in REFLECTORS.values()]
    for command in (["cmake", "--install", kinome_build, "--prefix", prefix],
                    ["cmake", "-S", PROJECT, "-B", work, f"-DCMAKE_PREFIX_PATH={prefix}",
                     *(f"-DCMAKE_CXX_COMPILER={path}" for path in compiler)],
                    ["cmake", "--build", work, "--target", *targets]):
        made = subprocess.run([str(word) for word in command], check=False, capture_output=True,
                              text=True)
        if made.returncode != 0:
            raise Problem(f"{' '.join(map(str, command))} failed:\n{made.stderr.strip()}")
    return work / "plugins"


def scene_with_reflector(path, folder):
    """Writes a copy of a scene whose diffuse surfaces have the BSDF of -D reflector."""
    text, count = re.subn(r'<bsdf type="diffuse"([^>]*)>(\s*)<rgb name="reflectance"',
                          r'<bsdf type="$reflector"\1>\2<rgb name="albedo"',
                          path.read_text(encoding="utf-8"))
    if count == 0:
        raise Problem(f"{path.name}: has no diffuse surface")
    copy = folder / f"{path.parent.name}-reflector.xml"
    copy.write_text(with_filenames(text, path.parent), encoding="utf-8")
    return copy
