"""A renderer for the tests of validation/suite. It answers as workers/mitsuba_worker.py does, and
misbehaves where its first argument says so.

Its pictures are 1 everywhere, with noise of the standard deviation 0.4 / sqrt(samples); with
`ldsampler` half of that.
"""
import os
import pathlib
import signal
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "validation/suite/workers"))
import numpy as np  # noqa: E402
from serve import serve  # noqa: E402

BEHAVIOUR = sys.argv[1]
loaded, warm = {}, set()  # what was asked for, and the counts of samples rendered since


def load(file, defines):
    if BEHAVIOUR == "refuses" and defines["integrator"] == "direct":
        raise ValueError(f"Error while loading {file} (line 3,\n col 7): no such plugin")
    loaded.update(defines)
    warm.clear()
    return {}


def render(samples, seed, output):
    """In 2 ms a sample, and twice that where this count is rendered for the first time."""
    if BEHAVIOUR == "crashes":
        os.kill(os.getpid(), signal.SIGILL)
    if BEHAVIOUR == "hangs":
        time.sleep(60)
    size = int(loaded["height"]), int(loaded["width"]), 3
    if BEHAVIOUR == "other size":
        size = (size[0] + 1, *size[1:])
    sigma = 0.4 / np.sqrt(samples) / (2 if loaded["sampler"] == "ldsampler" else 1)
    print("a line on stdout that is no answer")
    np.save(output, 1 + sigma * np.random.default_rng(seed).standard_normal(size, np.float32))
    first = samples not in warm
    warm.add(samples)
    seconds = 0.002 * samples * (2 if first else 1)
    return {"seconds": seconds, "processor": 2 * seconds, "samples": samples}


if BEHAVIOUR == "ends":
    sys.exit("no libLLVM 19: apt-get install libllvm19")
serve({"hello": lambda: {"version": "0"}, "load": load, "render": render})
