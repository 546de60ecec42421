"""Renders with Mitsuba when asked: mitsuba_worker.py VARIANT THREADS. Runs in Mitsuba's Python."""
import pathlib
import sys
import time

START = time.perf_counter()
sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "references"))
import environment  # noqa: E402

VARIANT, THREADS = sys.argv[1], int(sys.argv[2])
if VARIANT.startswith("llvm") and not environment.use_llvm():
    sys.exit("no libLLVM 19: apt-get install libllvm19")
import mitsuba as mi  # noqa: E402
import drjit as dr  # noqa: E402
import numpy as np  # noqa: E402
from serve import serve  # noqa: E402


class Renderer:
    def __init__(self):
        dr.set_thread_count(THREADS)
        mi.set_variant(VARIANT)
        mi.set_log_level(mi.LogLevel.Error)
        self.scene = None
        self.seconds = time.perf_counter() - START

    def hello(self):
        return {"version": mi.__version__, "import_seconds": self.seconds}

    def load(self, file, defines):
        self.scene = None
        start = time.perf_counter()
        self.scene = mi.load_file(file, **defines)
        return {"seconds": time.perf_counter() - start}

    def render(self, samples, seed, output=None):
        """Wall time until the pixels are in memory."""
        start = time.perf_counter()
        pixels = np.array(mi.render(self.scene, spp=samples, seed=seed), np.float32)
        seconds = time.perf_counter() - start
        if output:
            np.save(output, pixels[:, :, :3])
        sampler = self.scene.sensors()[0].sampler()
        sampler.set_sample_count(samples)
        return {"seconds": seconds, "samples": sampler.sample_count()}


if __name__ == "__main__":
    renderer = Renderer()
    serve({"hello": renderer.hello, "load": renderer.load, "render": renderer.render})
