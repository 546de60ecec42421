"""The program as the measurements run it, and what they say about where they ran."""
import json
import os
import pathlib
import platform
import resource
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent


class RenderFailed(SystemExit):
    """Ends a script with that message, unless it goes on without the picture."""


def run_kinome(build, scene, output, defines, seed=0, options=()):
    """Renders `scene` into `output`; the program's own statistics, and its "processor_seconds"."""
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
    # Where this clone lies is nobody's business.
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
