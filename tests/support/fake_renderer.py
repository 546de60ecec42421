"""Simulates a renderer for the tests of validation/suite.

Its replies are those of workers/mitsuba_worker.py. The first argument selects a misbehaviour.

All pixels are 1, plus noise of the standard deviation 0.4 / sqrt(samples); half of that with the
sampler `ldsampler`.
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
loaded, warm = {}, set()  # parameters of the last load, and sample counts rendered since then


def load(file, defines):
    if BEHAVIOUR == "refuses" and defines["integrator"] == "direct":
        raise ValueError(f"Error while loading {file} (line 3,\n col 7): no such plugin")
    loaded.update(defines)
    warm.clear()
    return {}


def render(samples, seed, output):
    """Takes 2 ms per sample, twice that for the first render with a sample count."""
    if BEHAVIOUR == "crashes":
        os.kill(os.getpid(), signal.SIGILL)
    if BEHAVIOUR == "hangs":
        time.sleep(60)
    size = int(loaded["height"]), int(loaded["width"]), 3
    if BEHAVIOUR == "other size":
        size = (size[0] + 1, *size[1:])
    sigma = 0.4 / np.sqrt(samples) / (2 if loaded["sampler"] == "ldsampler" else 1)
    print("a line on stdout that isn't a reply")
    np.save(output, 1 + sigma * np.random.default_rng(seed).standard_normal(size, np.float32))
    first = samples not in warm
    warm.add(samples)
    seconds = 0.002 * samples * (2 if first else 1)
    return {"seconds": seconds, "processor": 2 * seconds, "samples": samples}


if BEHAVIOUR == "ends":
    sys.exit("libLLVM 19 not found: apt-get install libllvm19")
serve({"hello": lambda: {"version": "0"}, "load": load, "render": render})
