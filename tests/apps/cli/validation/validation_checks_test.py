"""Tests of validation/run.sh correctness: the pairs that are compared, and how."""

import pathlib
import sys
import tempfile
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path.insert(0, str(ROOT / "validation"))
from compare import Estimate, compare  # noqa: E402
from suite import tables  # noqa: E402
from suite.correctness import (Correctness, checks_of_big, checks_of_small,  # noqa: E402
                               default_integrator, paired, plan)


class Recorder:
    """Replaces the program, and records the requests."""

    program = "0123"

    def __init__(self):
        self.asked = []

    def estimate(self, name, scene, defines, first_seed, options=()):
        self.asked.append((dict(defines), first_seed))
        return Estimate.from_renders(name, np.ones((16, 4, 4, 3)))


class Samples(unittest.TestCase):
    def test_light_tracing_takes_more(self):
        work = Correctness(Recorder(), None, tables.QUICK, None, None, None)
        box = next(scene for scene in tables.SCENES if scene.name == "box")
        spp = {check.method: work.defines(check)["spp"] for check in checks_of_big(box)}
        self.assertEqual(spp["ptracer"], 4 * spp["path"])
        self.assertEqual(spp["path"], tables.QUICK.check_samples)


class GroundTruth(unittest.TestCase):
    def test_it_shares_seeds_sampler_and_points_with_clustered(self):
        recorder = Recorder()
        work = Correctness(recorder, None, tables.QUICK, None, None, None)
        checks = [c for c in checks_of_small(tables.SMALL_SCENES[0]) if c.truth == "groundtruth"]
        self.assertGreater(len(checks), 2)
        for check in checks:
            work.truth(check, check.path, ())
        self.assertEqual(len(recorder.asked), 1)
        (own, seed), clustered = recorder.asked[0], work.defines(checks[0])
        self.assertEqual(own["integrator"], "groundtruth")
        for key in ("sampler", "spp", *tables.POINTS):
            self.assertEqual(own[key], clustered[key])
        self.assertFalse(set(own) & {"importance", *tables.CUT})


class WhatIsCompared(unittest.TestCase):
    def test_product_meets_mitsuba_where_it_is_not_another_mode(self):
        checks = [c for c in plan(tables.FULL, ()) if c.method == "clustered product"]
        self.assertEqual([c.scene for c in checks],
                         [*(s.stem for s in tables.FULL.small_scenes
                            if default_integrator(s) == "direct"),
                          "hebe", "car", "grace", "box", "plate", "blocks"])
        work = Correctness(None, None, tables.FULL, None, pathlib.Path(self.folder), None)
        for check in checks:
            self.assertEqual(check.truth, "mitsuba")
            defines = work.defines(check)
            self.assertEqual((defines["sampler"], defines["importance"]), ("ldsampler", "product"))
            self.assertFalse(set(defines) & {*tables.POINTS, *tables.CUT})
            # The rendered scene file passes the importance on.
            path, options = work.scene_file(check)
            self.assertIn("$integrator.xml", path.read_text("utf-8"))
            self.assertEqual(bool(options), check.big is None)
        method = next(m for m in tables.METHODS if m.any_light)
        self.assertEqual(method.samples, (4, 16, 64, 256, 1024))

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = temporary.name


class PairedRenders(unittest.TestCase):
    """Noise that two renders with one seed share is not part of their difference."""

    def verdict(self, bias):
        rng = np.random.default_rng(5)
        shared = rng.gamma(4.0, 0.25, (16, 1, 1, 1)) * np.ones((16, 40, 40, 3))
        own = 0.01 * rng.standard_normal(shared.shape)
        made, points = (Estimate.from_renders(name, stack) for name, stack in (
            ("clustered", shared * (1 + bias) + own), ("groundtruth", shared)))
        return compare(*paired(made, points), 0.01).passed, compare(made, points, 0.01).passed

    def test_a_small_bias_is_found_in_pairs_alone(self):
        self.assertEqual(self.verdict(0), (True, True))
        self.assertEqual(self.verdict(0.01), (False, True))


if __name__ == "__main__":
    unittest.main()
