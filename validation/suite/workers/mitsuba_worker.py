"""Renders with Mitsuba on request: mitsuba_worker.py VARIANT THREADS. Runs in Mitsuba's Python."""
import pathlib
import sys
import time

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "references"))
import environment  # noqa: E402

VARIANT, THREADS = sys.argv[1], int(sys.argv[2])
if VARIANT.startswith("llvm") and not environment.use_llvm():
    sys.exit("libLLVM 19 not found: apt-get install libllvm19")
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

    def hello(self):
        return {"version": mi.__version__}

    def load(self, file, defines):
        self.scene = None
        self.scene = mi.load_file(file, **defines)
        return {}

    def render(self, samples, seed, output):
        """Renders; returns the wall and processor time until the pixels are in memory."""
        start, before = time.perf_counter(), time.process_time()
        pixels = np.array(mi.render(self.scene, spp=samples, seed=seed), np.float32)
        seconds, processor = time.perf_counter() - start, time.process_time() - before
        np.save(output, pixels[:, :, :3])
        sampler = self.scene.sensors()[0].sampler()
        sampler.set_sample_count(samples)
        return {"seconds": seconds, "processor": processor, "samples": sampler.sample_count()}


if __name__ == "__main__":
    renderer = Renderer()
    serve({"hello": renderer.hello, "load": renderer.load, "render": renderer.render})
