"""Runs the program for the measurements, and describes the machine and the commit."""
import json
import os
import pathlib
import platform
import resource
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent


class RenderFailed(SystemExit):
    """A failed render. Ends the script with its message, unless the caller continues without the image."""


def run_kinome(build, scene, output, defines, seed=0, options=()):
    """Renders `scene` into `output`. Returns the program's statistics and its "processor_seconds"."""
    arguments = [build / "bin/kinome", scene, "-q", "--stats=json", "--seed", str(seed),
                 "-o", output, *options]
    for key, value in defines.items():
        arguments += ["-D", f"{key}={value}"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    result = subprocess.run(arguments, check=False, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if result.returncode != 0:
        raise RenderFailed(f"{' '.join(map(str, arguments))} failed:\n{result.stderr}")
    stats = json.loads(result.stdout)
    # Removes absolute paths, because the statistics are committed.
    stats["scene"] = str(scene.relative_to(ROOT)) if scene.is_relative_to(ROOT) else scene.name
    del stats["output"]
    stats["processor_seconds"] = (after.ru_utime + after.ru_stime
                                  - before.ru_utime - before.ru_stime)
    return stats


def processor():
    for line in pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor()


def machine():
    return {"processor": processor(), "cores": os.cpu_count(), "system": platform.platform()}


def commit():
    return subprocess.run(["git", "-C", ROOT, "rev-parse", "HEAD"], capture_output=True, text=True,
                          check=False).stdout.strip()
