"""Tests of validation/run.sh threads: the simulation of threads, and the page."""

import json
import pathlib
import sys
import tempfile
import unittest
import unittest.mock

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path.insert(0, str(ROOT / "validation"))
from suite import arguments, tables, threads, threads_page  # noqa: E402


def event(part, begin, seconds, name="main", cat="loop", thread=0):
    return {"ph": "X", "name": name, "cat": cat, "tid": thread, "ts": 1e6 * begin, "dur": 1e6 * seconds,
            "args": {"stage": "main" if name == "commit" else name, "part": part, "item": 0}}


# A serial part, four items with commits, and a serial part that doesn't belong to the render.
TRACE = [{"ph": "M", "name": "thread_name", "tid": 0},
         event(0, 0, 2, "cells", "serial"),
         *(one for i in range(4) for one in (event(1, 2 + 3 * i, 2.5),
                                             event(1, 4.5 + 3 * i, 0.5, "commit"))),
         event(2, 14, 5, "write", "serial")]


class Simulation(unittest.TestCase):
    def test_parts_of_a_trace(self):
        parts = threads.parts_of(TRACE)
        self.assertEqual([(p.stage, p.is_loop, len(p.items)) for p in parts],
                         [("cells", False, 1), ("main", True, 4), ("write", False, 1)])
        for work, commit in parts[1].items:
            self.assertAlmostEqual(work, 2.5)
            self.assertAlmostEqual(commit, 0.5)
        self.assertAlmostEqual(parts[1].rest, 0)

    def test_one_thread_takes_the_recorded_time(self):
        seconds, idle, serial = threads.simulated(threads.parts_of(TRACE), 1)
        self.assertAlmostEqual(seconds, 14)
        self.assertAlmostEqual(serial, 2)
        self.assertAlmostEqual(idle, 4 * 0.5)  # commits aren't work on items

    def test_items_without_commits(self):
        self.assertEqual(threads.simulate([(1, 0)] * 8, 4), (2, 0))
        self.assertEqual(threads.simulate([(1, 0)] * 5, 4), (2, 1))
        self.assertEqual(threads.simulate([(1, 0)], 16), (1, 1))
        self.assertEqual(threads.simulate([], 4), (0, 0))

    def test_commits_exclude_each_other(self):
        whole, idle = threads.simulate([(0, 1)] * 4, 4)
        self.assertEqual((whole, idle), (4, 4))

    def test_more_threads_are_never_slower(self):
        parts = threads.parts_of(TRACE)
        times = [threads.simulated(parts, count)[0] for count in threads.COUNTS]
        self.assertEqual(times, sorted(times, reverse=True))


class Command(unittest.TestCase):
    def rows(self, folder, cores):
        def run(_build, _scene, image, _defines, _seed, options):
            image.touch()
            pathlib.Path(options[-1]).write_text(json.dumps({"traceEvents": TRACE}), "utf-8")
            return {"stage_threads": [{"stage": "main", "seconds": 8.0, "partly_idle": 1.0},
                                      {"stage": "write", "seconds": 5.0, "partly_idle": 5.0}]}

        work = threads.Threads(unittest.mock.Mock(), [(256, 256)], folder, unittest.mock.Mock(), cores)
        with unittest.mock.patch.object(threads, "run_kinome", run):
            return work.scene(tables.SCENES[0])

    def test_simulated_rows_are_marked(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            rows = self.rows(folder, cores=2)
            self.assertEqual(list(folder.iterdir()), [])
        self.assertEqual([row.threads for row in rows], list(threads.COUNTS))
        self.assertEqual([row.is_measured for row in rows], [True, True, False, False, False])
        self.assertEqual((rows[1].seconds, rows[1].partly_idle), (8, 1))
        text = threads_page.page(rows, {"processor": "a processor", "cores": 2}, "0123456789ab")
        self.assertIn("on a processor, 2 cores", text)
        self.assertEqual(text.count("| measured |"), 2)
        self.assertEqual(text.count("| simulated |"), 3)
        self.assertEqual(threads_page.measurements(rows).count("\n"), 6)
        self.assertEqual(threads_page.plot(rows)[:4], b"\x89PNG")

    def test_arguments(self):
        self.assertEqual(arguments.parse(["threads"]).output, ROOT / "validation/threads")
        self.assertEqual(arguments.parse(["threads", "hebe"]).words, ["hebe"])
        with self.assertRaises(SystemExit), unittest.mock.patch("sys.stderr"):
            arguments.parse(["threads", "nowhere"])

    def test_default_scenes_exist(self):
        self.assertLessEqual(set(threads.SCENES), {scene.name for scene in tables.SCENES})


if __name__ == "__main__":
    unittest.main()
