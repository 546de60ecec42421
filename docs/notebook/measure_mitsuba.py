"""Renders night.xml with Mitsuba and measures the processor time, for make.py --mitsuba.

    PYTHON measure_mitsuba.py OUTPUT.npz WIDTH HEIGHT SAMPLES...

PYTHON must have the package mitsuba (llvm_ad_rgb). Loading and compilation are excluded from the time: each
image is rendered twice, and the second render is timed.
"""
import pathlib
import sys
import time

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")
output, width, height, *samples = sys.argv[1:]
scene = mi.load_file(str(pathlib.Path(__file__).with_name("night.xml")), width=width, height=height)
pictures, seconds = [], []
for count in map(int, samples):
    np.array(mi.render(scene, spp=count, seed=1))
    start = time.process_time()
    pictures.append(np.array(mi.render(scene, spp=count, seed=0))[:, :, :3])
    seconds.append(time.process_time() - start)
np.savez(output, pictures=pictures, seconds=seconds, samples=[int(s) for s in samples],
         version=mi.__version__)
