"""Tests of renders in Python: callbacks, budgets, Ctrl-C and threads."""
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time
import unittest

import numpy as np

from small_scene import DICT, SCENE, SceneTest, kinome, with_parts


class RenderTest(SceneTest):
    def test_progress_and_passes(self):
        scene = self.load(spp=64)
        fractions = []
        picture = kinome.render(scene, progress=fractions.append)
        self.assertEqual(fractions, sorted(fractions))
        self.assertEqual(fractions[-1], 1)
        # A callback must not change any bit.
        for options in ({}, {"spp": 10}, {"variance": 8}, {"error": 3e-3},
                        {"integrator": "clustered", "error": 1e-2}):
            seen = []
            looked_at = kinome.render(scene, on_pass=lambda p, n: seen.append((n, p)), **options)
            np.testing.assert_array_equal(looked_at, kinome.render(scene, **options))
            numbers = [samples for samples, _ in seen]
            self.assertEqual(numbers, sorted(set(numbers)))
            self.assertEqual(numbers[-1], looked_at.stats["samples"])
            self.assertEqual(len(numbers) == 1, not options.keys() & {"variance", "error"})
            np.testing.assert_array_equal(seen[-1][1], looked_at)
            self.assertEqual(seen[-1][1].channels, looked_at.channels)
            self.assertEqual([p.stats["samples"] for _, p in seen], numbers)
            self.assertFalse(seen[-1][1].stats["complete"])
        np.testing.assert_allclose(np.mean(looked_at), np.mean(picture), rtol=0.05)

        def fail(fraction):
            raise ZeroDivisionError("enough")
        with self.assertRaisesRegex(ZeroDivisionError, "enough"):
            kinome.render(scene, spp=100000, progress=fail)
        with self.assertRaisesRegex(ZeroDivisionError, "enough"):
            kinome.render(scene, error=1e-9, on_pass=lambda picture, samples: fail(samples))

    def test_a_failed_render_reports_no_end(self):
        # The memory limit is too small for this film.
        self.path.write_text(SCENE.replace('"40"', '"16000"').replace('"30"', '"16000"'))
        self.said_by("import resource\n"
                     "scene = kinome.load_file(sys.argv[1]); seen = []\n"
                     "size = int(open('/proc/self/statm').read().split()[0])\n"
                     "limit = size * resource.getpagesize() + (512 << 20)\n"
                     "resource.setrlimit(resource.RLIMIT_AS, (limit, limit))\n"
                     "try:\n"
                     "    kinome.render(scene, threads=1, progress=seen.append)\n"
                     "    raise SystemExit('it was rendered')\n"
                     "except (MemoryError, kinome.Error):\n"
                     "    assert 1 not in seen, seen\n")

    def test_budgets_are_kept_with_a_callback(self):
        scene = self.load()
        seen = []

        def look(picture, samples):
            seen.append(samples)
            time.sleep(0.05)
        picture = kinome.render(scene, time=0.6, on_pass=look)
        # The number of calls depends on the machine; tests/libs/progressive_test.cpp uses a
        # simulated clock.
        self.assertTrue(seen)
        self.assertGreaterEqual(picture.stats["samples"], seen[-1])
        self.assertGreater(picture.stats["seconds"], 0.2)
        # Any time limit gives an image, and a warning if the time was too short.
        said = self.said_by("scene = kinome.load_file(sys.argv[1]); seen = []\n"
                            "picture = kinome.render(scene, time=1e-6, integrator='clustered',\n"
                            "    on_pass=lambda p, n: (seen.append(n), time.sleep(0.2)))\n"
                            "assert picture.mean() > 0.1 and seen, (picture.mean(), seen)\n"
                            "kinome.render(scene, error=1e-12, time=0.1)\n")
        self.assertRegex(said, r"time=1e-06: it took 0\.\d+ s to render .* samples per pixel")
        self.assertRegex(said, "error=1e-12 was not reached: .* when time was up")

    def test_samplers_that_round(self):
        self.path.write_text(SCENE.replace('sampler type="independent"', 'sampler type="multijitter"'))
        scene, seen = self.load(), []
        picture = kinome.render(scene, spp=10, on_pass=lambda p, n: seen.append(n))
        self.assertEqual((picture.stats["samples"], seen), (12, [12]))
        np.testing.assert_array_equal(picture, kinome.render(scene, spp=12))
        said = self.said_by("kinome.render(kinome.load_file(sys.argv[1]), spp=10)")
        self.assertIn("spp=10 is rounded up to 12", said)

    def test_a_callback_may_inspect_but_not_change_its_scene(self):
        scene = self.load(spp=4)
        refused = []

        def look(picture, samples):
            for use in (lambda: kinome.render(scene, spp=1), lambda: kinome.traverse(scene).update()):
                with self.assertRaisesRegex(kinome.Error, "is in use: it is being rendered, updated or queried"):
                    use()
                refused.append(samples)
            self.assertTrue(list(kinome.traverse(scene)))
        kinome.render(scene, on_pass=look)
        self.assertTrue(refused)
        kinome.render(scene, spp=1)  # it can be used again

    def test_ctrl_c_gives_the_image_so_far(self):
        scene = self.load()
        threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        start = time.monotonic()
        picture = kinome.render(scene, spp=1000000)
        self.assertLess(time.monotonic() - start, 60)
        self.assertFalse(picture.stats["complete"])
        self.assertGreater(np.mean(picture.rgb), 0)
        self.assertTrue(kinome.render(scene).stats["complete"])

    def test_other_threads_run_meanwhile(self):
        steps, done = [0], threading.Event()

        def count():
            while not done.is_set():
                steps[0] += 1
                time.sleep(0.001)
        counter = threading.Thread(target=count)
        counter.start()
        seconds = kinome.render(self.load(), time=0.5).stats["seconds"]
        done.set()
        counter.join()
        # If the render held the lock, there would be only a handful.
        self.assertGreater(steps[0], 50 * seconds)

    def test_budgets_variance_and_comparison(self):
        scene = self.load(spp=32)
        a = kinome.render(scene, variance=16)
        b = kinome.render(scene, variance=16, seed=1)
        self.assertEqual(a["variance"].shape, (30, 40, 3))
        self.assertTrue(kinome.compare(a, b, alpha=1e-6).passed)
        darker = kinome.load_dict(with_parts(DICT, sky={"type": "constant", "radiance": 0.4}))
        self.assertFalse(kinome.compare(kinome.render(darker, spp=32, variance=16), b,
                                        alpha=1e-6).passed)
        self.assertTrue(kinome.compare([kinome.render(scene, seed=i) for i in range(4)], b,
                                       alpha=1e-6).passed)
        by_error = kinome.render(scene, error=1e-3)
        self.assertLess(by_error.stats["relmse"], 1e-3)
        # `kinome-compare` reads the written files.
        for picture, name in ((a, "a.exr"), (b, "b.exr")):
            picture.write(self.folder / name)
            picture.write(self.folder / name.upper())
        compare = pathlib.Path(__file__).resolve().parents[3] / "validation/kinome-compare"
        subprocess.run([compare, "-q", "--alpha", "1e-6", self.folder / "a.exr",
                        self.folder / "b.exr"], check=True, stdout=subprocess.DEVNULL)

    def test_who_waits_for_plugins_lets_others_run(self):
        """One thread loads a scene, a second waits for plugins that the first uses, and a third
        must keep running."""
        balls = '<shape type="sphere"><ref id="red"/></shape>' * 10000
        self.path.write_text(SCENE.replace("</scene>", balls + "</scene>"))
        loads = threading.Thread(target=self.load)

        def look():
            while loads.is_alive():
                kinome.plugins()
        waits = threading.Thread(target=look)
        kinome.plugins()  # opens all plugins
        loads.start()
        waits.start()
        steps = 0
        while loads.is_alive():
            steps += 1
            time.sleep(0.001)
        waits.join()
        # If the waiting thread held the lock, there would be only a handful.
        self.assertGreater(steps, 20)


if __name__ == "__main__":
    unittest.main()
